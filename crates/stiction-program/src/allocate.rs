//! Register allocation and machine code generation.
//!
//! In straight-line code, all later uses of a value are known in advance. If no register is free,
//! the allocator evicts the value whose next use is farthest away (Belady 1966).

use crate::code::{Code, Fused, Source, Step};
use crate::encode::{Base, Emit, Operation, Order, Place, Target, begin};
use rustc_hash::FxHashMap;

/// Index of the constant zero. The allocator's own constants precede the constants of the code.
const ZERO: usize = 0;
/// Index of the allocator's constant -0.0, in which only the sign bit is set.
const SIGN: usize = 1;
/// Number of the allocator's own constants.
const OWN: usize = 2;

/// Placeholder for "no register" in lists of pinned registers, which must not be evicted.
const NONE: u8 = u8::MAX;

/// If an operand in memory is used again within this number of steps, the allocator loads the
/// operand into a register and keeps it there.
const SOON: u32 = 12;

/// Machine code, and the data that it needs at run time.
pub(crate) struct Assembled {
    pub(crate) bytes: Vec<u8>,
    /// Constants of the allocator, then those of the code. Each constant is stored in as many
    /// consecutive copies as one instruction reads.
    pub(crate) constants: Vec<f64>,
    /// Length of the scratch memory, in numbers. Values evicted from registers are stored there.
    pub(crate) scratch: usize,
}

/// Compiles straight-line code to machine code for the instruction set and register width of
/// `target`.
pub(crate) fn assemble(code: &Code, target: Target) -> Assembled {
    let numbers = [0.0, -0.0].into_iter().chain(code.constants.iter().copied());
    let copies = copies(target);
    let constants = numbers.flat_map(|x| std::iter::repeat_n(x, copies)).collect();
    let mut allocator = Allocator::new(code, target);
    for (k, step) in code.steps.iter().enumerate() {
        allocator.step(k, *step);
    }
    allocator.rest();
    let scratch = allocator.spilled * target.width.lanes();
    Assembled { bytes: allocator.assembler.finish(), constants, scratch }
}

/// Number of copies of each constant in memory: one if instructions can broadcast constants to all
/// lanes, otherwise one for each lane and at least two. A sign change reads two numbers even in
/// code for one lane.
fn copies(target: Target) -> usize {
    if target.is_single(Base::Constants) { 1 } else { target.width.lanes().max(2) }
}

struct Allocator<'a> {
    code: &'a Code,
    target: Target,
    assembler: Box<dyn Emit>,
    /// For each step, the indices of the later steps that read its result, in descending order.
    uses: Vec<Vec<u32>>,
    /// For each constant, the indices of the steps that read the constant, in descending order.
    /// `slot_uses` and `common_uses` contain such lists for slots and for numbers shared by all
    /// lanes.
    constant_uses: Vec<Vec<u32>>,
    slot_uses: FxHashMap<u32, Vec<u32>>,
    common_uses: FxHashMap<u32, Vec<u32>>,
    /// Value that each register contains; `None` for a free register.
    holds: Vec<Option<Source>>,
    register_of_step: Vec<Option<u8>>,
    spill_of_step: Vec<Option<usize>>,
    free_spills: Vec<usize>,
    retired_spills: Vec<usize>,
    spilled: usize,
    /// For each step, the slots to which its result must be stored.
    stores: Vec<Vec<u32>>,
    /// For each step, a slot to which its result has already been stored; `None` if there is no
    /// such slot. The copy in the slot remains valid, because no slot is written twice.
    slot_of_step: Vec<Option<u32>>,
}

impl<'a> Allocator<'a> {
    fn new(code: &'a Code, target: Target) -> Self {
        let count = code.steps.len();
        let mut uses = vec![Vec::new(); count];
        let mut constant_uses = vec![Vec::new(); code.constants.len()];
        let mut slot_uses: FxHashMap<u32, Vec<u32>> = FxHashMap::default();
        let mut common_uses: FxHashMap<u32, Vec<u32>> = FxHashMap::default();
        for (k, step) in code.steps.iter().enumerate().rev() {
            for operand in step.operands() {
                let list = match operand {
                    Source::Step(step) => &mut uses[step as usize],
                    Source::Constant(place) => &mut constant_uses[place as usize],
                    Source::Slot(slot) => slot_uses.entry(slot).or_default(),
                    Source::Common(place) => common_uses.entry(place).or_default(),
                };
                list.push(k as u32);
            }
        }
        let mut stores = vec![Vec::new(); count];
        for (source, slot) in &code.stores {
            if let Source::Step(step) = source {
                stores[*step as usize].push(*slot);
            }
        }
        Self {
            code,
            target,
            assembler: begin(target),
            uses,
            constant_uses,
            slot_uses,
            common_uses,
            holds: vec![None; target.registers()],
            register_of_step: vec![None; count],
            spill_of_step: vec![None; count],
            free_spills: Vec::new(),
            retired_spills: Vec::new(),
            spilled: 0,
            stores,
            slot_of_step: vec![None; count],
        }
    }

    fn uses_of(&mut self, source: Source) -> &mut Vec<u32> {
        match source {
            Source::Step(step) => &mut self.uses[step as usize],
            Source::Constant(place) => &mut self.constant_uses[place as usize],
            Source::Slot(slot) => self.slot_uses.entry(slot).or_default(),
            Source::Common(place) => self.common_uses.entry(place).or_default(),
        }
    }

    fn next_use(&mut self, source: Source) -> Option<u32> {
        self.uses_of(source).last().copied()
    }

    fn register_of(&self, source: Source) -> Option<u8> {
        match source {
            Source::Step(step) => self.register_of_step[step as usize],
            _ => self.holds.iter().position(|held| *held == Some(source)).map(|r| r as u8),
        }
    }

    fn address(&self, base: Base, place: usize, stride: usize) -> Place {
        let start = match base {
            Base::Slots | Base::Common => self.target.base_slot(),
            Base::Constants | Base::Spills => 0,
        };
        let place = place as i32 - start as i32;
        Place::Memory(base, place * (stride * size_of::<f64>()) as i32)
    }

    /// Returns the memory location of a value. For the result of a step, this is the slot that
    /// contains the result or, without such a slot, the scratch memory.
    fn memory_of(&self, source: Source) -> Place {
        let lanes = self.target.width.lanes();
        match source {
            Source::Common(place) => self.address(Base::Common, place as usize, 1),
            Source::Slot(slot) => self.address(Base::Slots, slot as usize, lanes),
            Source::Constant(place) => self.constant(OWN + place as usize),
            Source::Step(step) => match self.slot_of_step[step as usize] {
                Some(slot) => self.address(Base::Slots, slot as usize, lanes),
                None => {
                    let spill = self.spill_of_step[step as usize].unwrap_or(0);
                    self.address(Base::Spills, spill, lanes)
                }
            },
        }
    }

    fn constant(&self, place: usize) -> Place {
        self.address(Base::Constants, place, copies(self.target))
    }

    /// Returns a register that may be overwritten. If no register is free, evicts the value of a
    /// register that is not `pinned`.
    fn room(&mut self, pinned: &[u8]) -> u8 {
        match self.holds.iter().position(Option::is_none) {
            Some(free) => free as u8,
            None => self.evicted(pinned),
        }
    }

    /// Returns a register that may be overwritten and is not `pinned`. In contrast to
    /// [`Self::room`], `pinned` may also contain free registers.
    fn fresh(&mut self, pinned: &[u8]) -> u8 {
        let mut free = (0..self.holds.len() as u8).filter(|r| self.holds[*r as usize].is_none());
        match free.find(|register| !pinned.contains(register)) {
            Some(free) => free,
            None => self.evicted(pinned),
        }
    }

    /// Evicts a value and returns the register that contained it. Among the values in registers
    /// that are not `pinned`, chooses the value whose next use is farthest away.
    fn evicted(&mut self, pinned: &[u8]) -> u8 {
        let mut last = (0, 0);
        for register in 0..self.holds.len() as u8 {
            if pinned.contains(&register) {
                continue;
            }
            let Some(held) = self.holds[register as usize] else { continue };
            let next = self.next_use(held).unwrap_or(u32::MAX);
            if next >= last.0 {
                last = (next, register);
            }
        }
        let register = last.1;
        self.evict(register);
        register
    }

    fn evict(&mut self, register: u8) {
        let Some(Source::Step(step)) = self.holds[register as usize].take() else { return };
        let step = step as usize;
        self.register_of_step[step] = None;
        let is_in_memory = self.spill_of_step[step].is_some() || self.slot_of_step[step].is_some();
        if self.uses[step].is_empty() || is_in_memory {
            return;
        }
        let spill = self.free_spills.pop().unwrap_or_else(|| {
            self.spilled += 1;
            self.spilled - 1
        });
        self.spill_of_step[step] = Some(spill);
        let place = self.memory_of(Source::Step(step as u32));
        self.assembler.store(place, register);
    }

    fn take(&mut self, register: u8, source: Source) {
        self.holds[register as usize] = Some(source);
        if let Source::Step(step) = source {
            self.register_of_step[step as usize] = Some(register);
        }
    }

    /// Returns the register that contains an operand; loads the operand if necessary.
    fn in_register(&mut self, source: Source, pinned: &[u8]) -> u8 {
        if let Some(register) = self.register_of(source) {
            return register;
        }
        let register = self.room(pinned);
        let from = self.memory_of(source);
        self.assembler.load(register, from);
        self.take(register, source);
        register
    }

    /// Returns the location of an operand: a register if the operand is already in one, is used
    /// again soon, or lies in memory that only loads can read; otherwise the memory location of the
    /// operand.
    fn anywhere(&mut self, source: Source, now: u32, pinned: &[u8]) -> Place {
        let again = {
            let uses = self.uses_of(source);
            uses.iter().rev().find(|k| **k > now).copied()
        };
        let memory = self.memory_of(source);
        let must = matches!(memory, Place::Memory(base, _) if !self.target.reads(base));
        if must || self.register_of(source).is_some() || again.is_some_and(|k| k - now <= SOON) {
            return Place::Register(self.in_register(source, pinned));
        }
        memory
    }

    /// Marks the uses of a step's operands as done, and releases the registers of operands that
    /// have no further use.
    fn used(&mut self, now: u32, step: Step) {
        for operand in step.operands() {
            let uses = self.uses_of(operand);
            while uses.last().is_some_and(|k| *k <= now) {
                uses.pop();
            }
            if !uses.is_empty() {
                continue;
            }
            if let Some(register) = self.register_of(operand) {
                self.holds[register as usize] = None;
            }
            if let Source::Step(step) = operand {
                self.register_of_step[step as usize] = None;
                // The instruction may still read this scratch value, so the memory of the value is
                // reused only after the instruction.
                self.retired_spills.extend(self.spill_of_step[step as usize].take());
            }
        }
    }

    fn step(&mut self, k: usize, step: Step) {
        let now = k as u32;
        let to = match step {
            Step::Add(a, b) => self.binary(now, step, Operation::Add, a, b, true),
            Step::Mul(a, b) => self.binary(now, step, Operation::Mul, a, b, true),
            Step::Sub(a, b) => self.binary(now, step, Operation::Sub, a, b, false),
            Step::Div(a, b) => self.binary(now, step, Operation::Div, a, b, false),
            Step::Neg(a) => {
                let from = self.in_register(a, &[]);
                self.used(now, step);
                let to = self.room(&[from]);
                let sign = self.constant(SIGN);
                self.assembler.negate(to, from, sign);
                to
            }
            Step::Sqrt(a) => {
                let from = self.anywhere(a, now, &[]);
                self.used(now, step);
                let pinned = if let Place::Register(r) = from { [r] } else { [NONE] };
                let to = self.room(&pinned);
                self.assembler.sqrt(to, from);
                to
            }
            Step::Fused(kind, operands) => self.fused(now, step, kind, operands),
            Step::Select { of, yes, no } => {
                let of = self.in_register(of, &[]);
                let yes = self.in_register(yes, &[of]);
                let no = self.in_register(no, &[of, yes]);
                // The target must differ from all operands, because it is written before all
                // operands have been read.
                let to = self.room(&[of, yes, no]);
                let zero = self.constant(ZERO);
                self.used(now, step);
                self.assembler.select(to, of, zero, yes, no);
                to
            }
        };
        self.free_spills.append(&mut self.retired_spills);
        self.take(to, Source::Step(now));
        for slot in std::mem::take(&mut self.stores[k]) {
            let place = self.memory_of(Source::Slot(slot));
            self.assembler.store(place, to);
            self.slot_of_step[k] = Some(slot);
        }
        if self.uses[k].is_empty() {
            self.holds[to as usize] = None;
            self.register_of_step[k] = None;
        }
    }

    fn binary(
        &mut self,
        now: u32,
        step: Step,
        operation: Operation,
        a: Source,
        b: Source,
        commutes: bool,
    ) -> u8 {
        let swap = commutes && self.register_of(a).is_none() && self.register_of(b).is_some();
        let (a, b) = if swap { (b, a) } else { (a, b) };
        let first = self.in_register(a, &[]);
        let second = self.anywhere(b, now, &[first]);
        self.used(now, step);
        let mut pinned = [first, NONE];
        if let Place::Register(register) = second {
            pinned[1] = register;
        }
        let to = self.room(&pinned);
        self.assembler.arithmetic(operation, to, first, second);
        to
    }

    /// Emits a fused multiply-add and returns its target register. The instruction overwrites one
    /// of its operands, either an operand without further use or a copy of the addend.
    fn fused(&mut self, now: u32, step: Step, kind: Fused, [a, b, c]: [Source; 3]) -> u8 {
        let ends = |of: &mut Self, source: Source| {
            of.register_of(source).filter(|_| of.uses_of(source).first() == Some(&now))
        };
        let addend = self.register_of(c);
        let is_last = ends(self, c).is_some();
        let factors = if self.target.overwrites_factors() { &[(a, b), (b, a)][..] } else { &[] };
        let free = factors.iter().copied().find(|(a, _)| ends(self, *a).is_some());
        if let (Some(addend), Some((own, other)), false) = (addend, free, is_last || a == b) {
            let to = self.in_register(own, &[addend]);
            let other = self.anywhere(other, now, &[addend, to]);
            self.used(now, step);
            self.assembler.fused(kind, Order::TimesLast, to, addend, other);
            return to;
        }
        let kept = addend.unwrap_or(NONE);
        let first = self.in_register(a, &[kept]);
        let second = self.anywhere(b, now, &[kept, first]);
        let mut pinned = [kept, first, NONE];
        if let Place::Register(register) = second {
            pinned[2] = register;
        }
        let from = self.memory_of(c);
        self.used(now, step);
        let to = match addend {
            Some(addend) if is_last => addend,
            Some(addend) => {
                let to = self.fresh(&pinned);
                self.assembler.copy(to, addend);
                to
            }
            None => {
                let to = self.fresh(&pinned);
                self.assembler.load(to, from);
                to
            }
        };
        self.assembler.fused(kind, Order::Plus, to, first, second);
        to
    }

    /// Stores those results that no step computes: constants and numbers shared by all lanes.
    fn rest(&mut self) {
        for &(source, slot) in &self.code.stores {
            if matches!(source, Source::Step(_)) {
                continue;
            }
            let (from, to) = (self.memory_of(source), self.memory_of(Source::Slot(slot)));
            let register = 0;
            self.assembler.load(register, from);
            self.assembler.store(to, register);
        }
    }
}
