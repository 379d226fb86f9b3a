//! Execution of native machine code.
//!
//! This is the only unsafe code of this crate: it makes memory executable and calls the code in it.
//! The called code, which `allocate` generates, accesses only the four memory areas that are its
//! arguments, provided that these areas have the stated sizes, and returns.
#![allow(unsafe_code)]

use crate::aligned::Aligned;
use crate::allocate::assemble;
use crate::code::Code;
use crate::encode::{Set, Target, Width};
#[cfg(all(target_arch = "aarch64", target_os = "linux"))]
use core::arch::asm;
use memmap2::{Mmap, MmapMut};

/// Signature of the machine code. The arguments are the addresses of the slots, the constants, the
/// scratch memory, and the numbers that all lanes share.
#[cfg(target_arch = "x86_64")]
type Entry = unsafe extern "sysv64" fn(*mut f64, *const f64, *mut f64, *const f64);
#[cfg(not(target_arch = "x86_64"))]
type Entry = unsafe extern "C" fn(*mut f64, *const f64, *mut f64, *const f64);

/// Executable machine code of one block of straight-line code, for one register width.
#[derive(Debug)]
pub(crate) struct Machine {
    memory: Mmap,
    constants: Aligned,
    lanes: usize,
    /// Index of the slot to which the base pointer of the slots points, and of the number to which
    /// the base pointer of the shared numbers points.
    first: usize,
    /// Length of the memory of the slots that the code accesses, in numbers.
    slots: usize,
    scratch: usize,
    common: usize,
}

/// Returns the best instruction set that this processor supports; `None` if it supports none of them.
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

/// Returns Advanced SIMD, the instruction set that every AArch64 processor has. Systems other than
/// Linux synchronise instruction caches in other ways and are not supported.
#[cfg(all(target_arch = "aarch64", target_os = "linux"))]
pub(crate) fn instructions() -> Option<Set> {
    Some(Set::Neon)
}

/// Returns `None`, because machine code for this processor or system is not supported.
#[cfg(not(any(target_arch = "x86_64", all(target_arch = "aarch64", target_os = "linux"))))]
pub(crate) fn instructions() -> Option<Set> {
    None
}

/// Returns `true` if this processor executes code for the target.
fn runs(target: Target) -> bool {
    let here = match instructions() {
        Some(Set::Avx512) => &[Set::Avx, Set::Avx512][..],
        Some(Set::Avx) => &[Set::Avx],
        Some(Set::Neon) => &[Set::Neon],
        None => &[],
    };
    here.contains(&target.set) && target.set.widths().contains(&target.width)
}

/// Returns `true` if this processor has fused multiply-add instructions.
pub(crate) fn fuses() -> bool {
    match instructions() {
        #[cfg(target_arch = "x86_64")]
        Some(Set::Avx | Set::Avx512) => is_x86_feature_detected!("fma"),
        Some(set) => set == Set::Neon,
        None => false,
    }
}

/// Synchronises the instruction caches with new code. On AArch64 this is necessary, because the
/// instruction caches do not follow changes in memory.
///
/// Source: Arm Architecture Reference Manual for A-profile, section B2.4.4.
fn publish(code: &[u8]) {
    #[cfg(all(target_arch = "aarch64", target_os = "linux"))]
    {
        let (start, end) = (code.as_ptr() as usize, code.as_ptr_range().end as usize);
        // SAFETY: these instructions read a register that is always readable, and maintain caches
        // of valid memory. They change no data.
        unsafe {
            let kind: u64;
            asm!("mrs {}, ctr_el0", out(reg) kind, options(nomem, nostack, preserves_flags));
            // Cache lines in bytes: both fields are binary logarithms of the number of words.
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
    /// Compiles straight-line code to executable machine code with `slots` slots for each lane.
    /// Returns `None` if machine code with registers of this width is not supported, or if the
    /// system does not allow executable memory.
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

    /// Number of scratch values that a run needs.
    pub(crate) fn scratch(&self) -> usize {
        self.scratch
    }

    /// Executes the code. The length of `slots` must be at least the number of slots in
    /// [`Self::new`] times the number of lanes, that of `scratch` at least [`Self::scratch`], and
    /// that of `common` at least [`Code::common`].
    #[inline]
    pub(crate) fn run(&self, slots: &mut [f64], common: &[f64], scratch: &mut [f64]) {
        assert!(slots.len() >= self.slots && scratch.len() >= self.scratch);
        assert!(common.len() >= self.common);
        // SAFETY: the memory holds a complete function of this signature, written by `assemble` for
        // an instruction set that this processor has (`new` checks it). It accesses slots below
        // `self.slots`, `constants`, shared numbers below `self.common` and scratch below
        // `self.scratch`, all of which exist by the assertions, and preserves the registers that
        // its caller expects to be preserved.
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

    /// Number of values that all lanes share. Short address offsets do not reach all of them.
    const COMMON: usize = 300;

    /// Creates random code with ten input slots and `count` steps.
    fn random_code(random: &mut Random, count: usize) -> Code {
        let mut code = Code { constants: vec![0.5, -1.25, 3.0], ..Code::default() };
        let mut pick = |bound: usize| ((random.number() + 1.0) * 0.5 * bound as f64) as usize;
        for k in 0..count {
            let mut source = || match pick(8) {
                0 => Source::Constant(pick(3) as u32),
                1 => Source::Slot(pick(10) as u32),
                2 => Source::Common(pick(COMMON) as u32),
                _ if k == 0 => Source::Slot(0),
                // One of the last five steps, or any earlier step.
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
            // Only square roots of inputs occur, because all inputs are positive.
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

    /// Returns the targets whose code this processor executes.
    fn targets() -> impl Iterator<Item = Target> {
        [Set::Avx, Set::Avx512, Set::Neon]
            .into_iter()
            .flat_map(|set| set.widths().iter().map(move |width| Target { width: *width, set }))
            .filter(|target| runs(*target))
    }

    /// Checks that code accesses no other memory: slots and scratch memory lie first between marker
    /// numbers that must not change, then in allocations of their exact size, where Valgrind
    /// detects accesses out of bounds (`cargo xtask audit memory`). Results are not compared,
    /// because the arithmetic of Valgrind may change the sign of a zero.
    #[test]
    fn machine_code_accesses_only_its_arguments() {
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

    /// Checks that machine code and interpreter agree bit by bit, for all register widths and for
    /// short and long code.
    #[test]
    fn machine_code_agrees_with_the_interpreter() {
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
