//! Code that the processor runs itself.
//!
//! The only unsafe code of the project: memory is made executable and called. What is called was written
//! by `allocate`, touches nothing but the four pieces of memory that it is handed, as long as
//! they are as large as the code says, and returns.
#![allow(unsafe_code)]

use crate::aligned::Aligned;
use crate::allocate::assemble;
use crate::code::Code;
use crate::encode::{Set, Target, Width};
#[cfg(all(target_arch = "aarch64", target_os = "linux"))]
use core::arch::asm;
use memmap2::{Mmap, MmapMut};

/// As the instructions of each set find their four addresses.
#[cfg(target_arch = "x86_64")]
type Entry = unsafe extern "sysv64" fn(*mut f64, *const f64, *mut f64, *const f64);
#[cfg(not(target_arch = "x86_64"))]
type Entry = unsafe extern "C" fn(*mut f64, *const f64, *mut f64, *const f64);

/// A piece of code in machine instructions for one width.
#[derive(Debug)]
pub(crate) struct Machine {
    memory: Mmap,
    constants: Aligned,
    lanes: usize,
    /// The slot that it is handed the address of, and the place in what is common to all lanes.
    first: usize,
    /// Numbers of slots, of scratch and of what is common to all lanes that it touches.
    slots: usize,
    scratch: usize,
    common: usize,
}

/// The instructions that this processor has; none if code cannot be made for it.
#[cfg(target_arch = "x86_64")]
pub(crate) fn instructions() -> Option<Set> {
    let has_all = is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512dq")
        && is_x86_feature_detected!("avx512vl");
    match has_all {
        true => Some(Set::Avx512),
        false => is_x86_feature_detected!("avx").then_some(Set::Avx),
    }
}

/// The same: it is always there. Elsewhere than under Linux caches are told of new code in other ways.
#[cfg(all(target_arch = "aarch64", target_os = "linux"))]
pub(crate) fn instructions() -> Option<Set> {
    Some(Set::Neon)
}

/// The same: not here.
#[cfg(not(any(target_arch = "x86_64", all(target_arch = "aarch64", target_os = "linux"))))]
pub(crate) fn instructions() -> Option<Set> {
    None
}

/// Whether code for it can be run here.
fn runs(target: Target) -> bool {
    let here = match instructions() {
        Some(Set::Avx512) => &[Set::Avx, Set::Avx512][..],
        Some(Set::Avx) => &[Set::Avx],
        Some(Set::Neon) => &[Set::Neon],
        None => &[],
    };
    here.contains(&target.set) && target.set.widths().contains(&target.width)
}

/// Whether this processor adds to products in one instruction.
pub(crate) fn fuses() -> bool {
    match instructions() {
        #[cfg(target_arch = "x86_64")]
        Some(Set::Avx | Set::Avx512) => is_x86_feature_detected!("fma"),
        Some(set) => set == Set::Neon,
        None => false,
    }
}

/// Sees to it that the processor finds new instructions where it may have looked before: on AArch64 its caches for
/// instructions do not follow memory.
///
/// Source: Arm Architecture Reference Manual for A-profile, section B2.4.4.
fn publish(code: &[u8]) {
    #[cfg(all(target_arch = "aarch64", target_os = "linux"))]
    {
        let (start, end) = (code.as_ptr() as usize, code.as_ptr_range().end as usize);
        // SAFETY: reads a register that all may read and tells caches of memory that is there; changes nothing.
        unsafe {
            let kind: u64;
            asm!("mrs {}, ctr_el0", out(reg) kind, options(nomem, nostack, preserves_flags));
            // Lines, in bytes: both numbers count words, as powers of two.
            let (data, instructions) = (4 << (kind >> 16 & 15), 4 << (kind & 15));
            for line in (start..end).step_by(data) {
                asm!("dc cvau, {}", in(reg) line, options(nostack, preserves_flags));
            }
            asm!("dsb ish", options(nostack, preserves_flags));
            for line in (start..end).step_by(instructions) {
                asm!("ic ivau, {}", in(reg) line, options(nostack, preserves_flags));
            }
            asm!("dsb ish", "isb", options(nostack, preserves_flags));
        }
    }
    #[cfg(not(all(target_arch = "aarch64", target_os = "linux")))]
    let _ = code;
}

impl Machine {
    /// Makes code executable; none where this system does not allow it.
    pub(crate) fn new(code: &Code, width: Width, slots: usize) -> Option<Self> {
        Self::for_target(code, Target { width, set: instructions()? }, slots)
    }

    fn for_target(code: &Code, target: Target, slots: usize) -> Option<Self> {
        if !runs(target) {
            return None;
        }
        let assembled = assemble(code, target);
        let mut memory = MmapMut::map_anon(assembled.bytes.len()).ok()?;
        memory.copy_from_slice(&assembled.bytes);
        let memory = memory.make_exec().ok()?;
        publish(&memory);
        let lanes = target.width.lanes();
        Some(Self {
            memory,
            constants: Aligned::from(&*assembled.constants),
            first: target.base_slot(),
            lanes,
            slots: slots * lanes,
            scratch: assembled.scratch,
            common: code.common(),
        })
    }

    /// Numbers of scratch that a run needs.
    pub(crate) fn scratch(&self) -> usize {
        self.scratch
    }

    /// Runs it. Slots are as many as it was made for, times the lanes; scratch is as it says.
    #[inline]
    pub(crate) fn run(&self, slots: &mut [f64], common: &[f64], scratch: &mut [f64]) {
        assert!(slots.len() >= self.slots && scratch.len() >= self.scratch);
        assert!(common.len() >= self.common);
        // SAFETY: the memory holds a whole function of this signature, written by `assemble` for a
        // processor that has its instructions (`new` asked). It reads and writes slots below
        // `self.slots`, reads `constants` and what is common below `self.common`, reads and writes scratch
        // below `self.scratch`, all of which are there, and changes no other register than its caller
        // expects.
        unsafe {
            let entry: Entry = std::mem::transmute(self.memory.as_ptr());
            let base = slots.as_mut_ptr().wrapping_add(self.first * self.lanes);
            let common = common.as_ptr().wrapping_add(self.first);
            entry(base, self.constants.as_ptr(), scratch.as_mut_ptr(), common);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::code::{Fused, Source, Step};
    use stiction_core::random::Random;

    /// Numbers that are common to all lanes: more than short addresses reach.
    const COMMON: usize = 300;

    /// Random code on ten slots, with a given number of steps.
    fn random_code(random: &mut Random, count: usize) -> Code {
        let mut code = Code { constants: vec![0.5, -1.25, 3.0], ..Code::default() };
        let mut pick = |bound: usize| ((random.number() + 1.0) * 0.5 * bound as f64) as usize;
        for k in 0..count {
            let mut source = || match pick(8) {
                0 => Source::Constant(pick(3) as u32),
                1 => Source::Slot(pick(10) as u32),
                2 => Source::Common(pick(COMMON) as u32),
                _ if k == 0 => Source::Slot(0),
                // Near ones and far ones.
                3..6 => Source::Step((k - 1 - pick(k.min(5))) as u32),
                _ => Source::Step(pick(k) as u32),
            };
            let (a, b, c) = (source(), source(), source());
            let step = match pick(if fuses() { 12 } else { 9 }) {
                0 | 1 => Step::Add(a, b),
                2 | 3 => Step::Sub(a, b),
                4 | 5 => Step::Mul(a, b),
                6 => Step::Div(a, b),
                7 => Step::Neg(a),
                9 => Step::Fused(Fused::Add, [a, b, c]),
                10 => Step::Fused(Fused::Sub, [a, b, c]),
                11 => Step::Fused(Fused::From, [a, b, c]),
                _ => Step::Select { of: a, yes: b, no: c },
            };
            code.steps.push(step);
            // Roots of squares.
            if pick(10) == 0 && k + 1 < count {
                code.steps.pop();
                code.steps.push(Step::Sqrt(Source::Slot(pick(10) as u32)));
            }
            if pick(4) == 0 || k + 1 == count {
                code.stores.push((Source::Step(k as u32), 10 + code.stores.len() as u32));
            }
        }
        code.stores.push((Source::Constant(1), 10 + code.stores.len() as u32));
        code.stores.push((Source::Common(COMMON as u32 - 1), 10 + code.stores.len() as u32));
        code
    }

    /// What can be run here.
    fn targets() -> impl Iterator<Item = Target> {
        [Set::Avx, Set::Avx512, Set::Neon]
            .into_iter()
            .flat_map(|set| set.widths().iter().map(move |width| Target { width: *width, set }))
            .filter(|target| runs(*target))
    }

    /// Slots and scratch lie between numbers that must stay, and then in pieces of memory of just their size:
    /// there Valgrind sees what is read or written beyond (`cargo xtask audit memory`). Results are not looked
    /// at: where Valgrind does the arithmetic, the sign of a zero may be another one.
    #[test]
    fn machine_code_touches_only_what_it_is_handed() {
        const ROOM: usize = 64;
        const MARK: f64 = 123.456;
        let mut random = Random::new(11);
        for case in 0..60 {
            let code = random_code(&mut random, 1 + 2 * case);
            let count = 10 + code.stores.len();
            for target in targets() {
                let machine = Machine::for_target(&code, target, count).unwrap();
                let (slots, scratch) = (count * target.width.lanes(), machine.scratch());
                let mut wide = [vec![MARK; slots + 2 * ROOM], vec![MARK; scratch + 2 * ROOM]];
                let [a, b] = &mut wide;
                a[ROOM..ROOM + slots].fill(1.5);
                let common = vec![0.5; COMMON].into_boxed_slice();
                machine.run(&mut a[ROOM..ROOM + slots], &common, &mut b[ROOM..ROOM + scratch]);
                for around in &wide {
                    let (before, rest) = around.split_at(ROOM);
                    let after = &rest[rest.len() - ROOM..];
                    let stays = before.iter().chain(after).all(|x| x.to_bits() == MARK.to_bits());
                    assert!(stays, "case {case}, {target:?}");
                }
                let mut slots = vec![1.5; slots].into_boxed_slice();
                let mut scratch = vec![0.0; scratch].into_boxed_slice();
                machine.run(&mut slots, &common, &mut scratch);
            }
        }
    }

    /// Machine code gives what the interpreter gives, bit by bit, for all widths, short and long.
    #[test]
    fn machine_code_is_what_is_interpreted() {
        let mut random = Random::new(7);
        for case in 0..300 {
            let code = random_code(&mut random, 1 + case % 120);
            let count = 10 + code.stores.len();
            for target in targets() {
                let lanes = target.width.lanes();
                let machine = Machine::for_target(&code, target, count).unwrap();
                let start: Vec<f64> =
                    (0..count * lanes).map(|_| (random.number() * 2.0).abs() + 0.1).collect();
                let (mut interpreted, mut run) = (start.clone(), start);
                let common: Vec<f64> = (0..COMMON).map(|_| random.number() + 1.5).collect();
                let mut values = vec![0.0; code.steps.len() * lanes];
                match lanes {
                    1 => code.interpret::<1>(&mut interpreted, &common, &mut values),
                    2 => code.interpret::<2>(&mut interpreted, &common, &mut values),
                    4 => code.interpret::<4>(&mut interpreted, &common, &mut values),
                    _ => code.interpret::<8>(&mut interpreted, &common, &mut values),
                }
                let mut scratch = vec![0.0; machine.scratch()];
                machine.run(&mut run, &common, &mut scratch);
                for (k, (a, b)) in interpreted.iter().zip(&run).enumerate() {
                    let same = a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan();
                    assert!(same, "case {case}, {target:?}, slot {}: {a} {b}", k / lanes);
                }
            }
        }
    }
}
