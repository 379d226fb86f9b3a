//! Machine instructions of AArch64 with Advanced SIMD for straight-line code.
//!
//! Source: Arm Architecture Reference Manual for A-profile, section C7.2.

use super::{Base, Emit, Operation, Order, Place, Target, Width};
use crate::code::Fused;

/// Number of registers available for values.
pub(super) const FREE: u8 = 30;
/// Number of the register into which operands from memory are loaded, because arithmetic
/// instructions cannot read memory.
const OPERAND: u8 = 30;
/// Number of the register that receives the negated addend if the register of the addend is still
/// needed as a factor.
const ASIDE: u8 = 31;
/// Number of the general-purpose register in which addresses are computed. Callers do not expect
/// this register to be preserved.
const ADDRESS: u32 = 16;
/// Number of the stack pointer as a base register.
const STACK: u32 = 31;
/// First registers of the pairs of callee-saved vector registers: d8 and d9, d10 and d11, and so
/// on. The lower halves of these registers must be preserved.
const KEPT: [u32; 4] = [8, 10, 12, 14];

/// Number of the register (x0 to x3) that contains a base address, an argument of the function.
const fn register(base: Base) -> u32 {
    match base {
        Base::Slots => 0,
        Base::Constants => 1,
        Base::Spills => 2,
        Base::Common => 3,
    }
}

/// Encoder of AArch64 instructions.
pub(crate) struct Assembler {
    bytes: Vec<u8>,
    is_scalar: bool,
}

/// Direction of a memory access.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Access {
    Load,
    Store,
}

impl Assembler {
    pub(super) fn new(target: Target) -> Self {
        let mut new = Self { bytes: Vec::new(), is_scalar: target.width == Width::One };
        // stp dN, dN+1, [sp, #-64]!, then [sp, #16], ...
        new.pair(0x6D80_0000, 0x78, 0);
        for k in 1..KEPT.len() {
            new.pair(0x6D00_0000, 2 * k as u32, k);
        }
        new
    }

    fn emit(&mut self, instruction: u32) {
        self.bytes.extend(instruction.to_le_bytes());
    }

    /// Encodes the instruction `form`, which saves or restores a pair of callee-saved registers.
    /// `kept` is the index of the pair in [`KEPT`], and `place` an address offset in units of eight
    /// bytes.
    fn pair(&mut self, form: u32, place: u32, kept: usize) {
        let first = KEPT[kept];
        self.emit(form | place << 15 | (first + 1) << 10 | STACK << 5 | first);
    }

    /// Encodes an instruction with registers in the instruction fields d, n and m. `one` is the
    /// opcode for a single number, `two` the opcode for two numbers.
    fn of(&mut self, [one, two]: [u32; 2], d: u8, n: u8, m: u8) {
        let form = if self.is_scalar { one } else { two };
        self.emit(form | u32::from(m) << 16 | u32::from(n) << 5 | u32::from(d));
    }

    /// Encodes a load or a store of one number if `one` is true, otherwise of a whole register.
    fn memory(&mut self, access: Access, one: bool, which: u8, base: Base, offset: i32) {
        let unit = if one { 8 } else { 16 };
        let (mut rest, mut base) = (offset.unsigned_abs(), register(base));
        // For addresses out of range of the offset: add xA, xB, #(pages << 12).
        while rest / unit > 0xFFF {
            let pages = (rest >> 12).min(0xFFF);
            self.emit(0x9140_0000 | pages << 10 | base << 5 | ADDRESS);
            (rest, base) = (rest - (pages << 12), ADDRESS);
        }
        let form = match (access, one) {
            (Access::Load, true) => 0xFD40_0000,
            (Access::Load, false) => 0x3DC0_0000,
            (Access::Store, true) => 0xFD00_0000,
            (Access::Store, false) => 0x3D80_0000,
        };
        self.emit(form | (rest / unit) << 10 | base << 5 | u32::from(which));
    }

    /// Returns the register that contains the operand; loads the operand if necessary.
    fn in_register(&mut self, place: Place) -> u8 {
        match place {
            Place::Register(register) => register,
            Place::Memory(..) => {
                self.load(OPERAND, place);
                OPERAND
            }
        }
    }
}

impl Emit for Assembler {
    fn arithmetic(&mut self, operation: Operation, to: u8, a: u8, b: Place) {
        let forms = match operation {
            Operation::Add => [0x1E60_2800, 0x4E60_D400],
            Operation::Sub => [0x1E60_3800, 0x4EE0_D400],
            Operation::Mul => [0x1E60_0800, 0x6E60_DC00],
            Operation::Div => [0x1E60_1800, 0x6E60_FC00],
        };
        let b = self.in_register(b);
        self.of(forms, to, a, b);
    }

    fn fused(&mut self, kind: Fused, _: Order, to: u8, second: u8, last: Place) {
        let last = self.in_register(last);
        if self.is_scalar {
            // fmadd, fnmsub, fmsub: the addend is a separate operand.
            let form = match kind {
                Fused::Add => 0x1F40_0000,
                Fused::Sub => 0x1F60_8000,
                Fused::From => 0x1F40_8000,
            };
            self.of([form | u32::from(to) << 10, 0], to, second, last);
            return;
        }
        // The addend is negated first: negating the result would change the sign of a zero.
        if kind == Fused::Sub && [second, last].contains(&to) {
            self.negate(ASIDE, to, Place::Register(to));
            self.of([0, 0x4E60_CC00], ASIDE, second, last);
            self.copy(to, ASIDE);
            return;
        }
        if kind == Fused::Sub {
            self.negate(to, to, Place::Register(to));
        }
        let form = if kind == Fused::From { 0x4EE0_CC00 } else { 0x4E60_CC00 };
        self.of([0, form], to, second, last);
    }

    fn copy(&mut self, to: u8, from: u8) {
        // Vectors: from OR from.
        let twice = if self.is_scalar { 0 } else { from };
        self.of([0x1E60_4000, 0x4EA0_1C00], to, from, twice);
    }

    fn negate(&mut self, to: u8, from: u8, _: Place) {
        self.of([0x1E61_4000, 0x6EE0_F800], to, from, 0);
    }

    fn sqrt(&mut self, to: u8, of: Place) {
        let of = self.in_register(of);
        self.of([0x1E61_C000, 0x6EE1_F800], to, of, 0);
    }

    fn select(&mut self, to: u8, of: u8, _: Place, yes: u8, no: u8) {
        // fcmgt with zero, then a bitwise selection.
        self.of([0x5EE0_C800, 0x4EE0_C800], to, of, 0);
        self.of([0x2E60_1C00, 0x6E60_1C00], to, yes, no);
    }

    fn load(&mut self, to: u8, from: Place) {
        match from {
            Place::Memory(Base::Common, offset) if !self.is_scalar => {
                self.memory(Access::Load, true, to, Base::Common, offset);
                // dup v.2d, v.d[0]
                self.of([0, 0x4E08_0400], to, to, 0);
            }
            Place::Memory(base, offset) => {
                self.memory(Access::Load, self.is_scalar, to, base, offset);
            }
            Place::Register(from) => self.copy(to, from),
        }
    }

    fn store(&mut self, to: Place, from: u8) {
        match to {
            Place::Memory(base, offset) => {
                self.memory(Access::Store, self.is_scalar, from, base, offset);
            }
            Place::Register(to) => self.copy(to, from),
        }
    }

    fn finish(mut self: Box<Self>) -> Vec<u8> {
        // ldp dN, dN+1, [sp, #16], ..., and finally [sp], #64.
        for k in (1..KEPT.len()).rev() {
            self.pair(0x6D40_0000, 2 * k as u32, k);
        }
        self.pair(0x6CC0_0000, 8, 0);
        const RET: u32 = 0xD65F_03C0;
        self.emit(RET);
        self.bytes
    }
}

#[cfg(test)]
mod tests {
    use super::super::Set;
    use super::*;

    fn instructions(width: Width, f: &dyn Fn(&mut Assembler)) -> Vec<u32> {
        let mut assembler = Assembler::new(Target { width, set: Set::Neon });
        let before = assembler.bytes.len();
        f(&mut assembler);
        let (words, _) = assembler.bytes[before..].as_chunks();
        words.iter().map(|word| u32::from_le_bytes(*word)).collect()
    }

    /// Checks that the instruction words are those of another assembler (GNU as).
    #[test]
    fn instructions_are_those_of_the_manual() {
        let r = Place::Register;
        let one = |f: &dyn Fn(&mut Assembler)| instructions(Width::One, f);
        let two = |f: &dyn Fn(&mut Assembler)| instructions(Width::Two, f);
        let arithmetic =
            |operation| move |a: &mut Assembler| a.arithmetic(operation, 3, 4, Place::Register(5));
        for (operation, scalar, vector) in [
            (Operation::Add, 0x1E65_2883, 0x4E65_D483),
            (Operation::Sub, 0x1E65_3883, 0x4EE5_D483),
            (Operation::Mul, 0x1E65_0883, 0x6E65_DC83),
            (Operation::Div, 0x1E65_1883, 0x6E65_FC83),
        ] {
            assert_eq!(one(&arithmetic(operation)), [scalar]);
            assert_eq!(two(&arithmetic(operation)), [vector]);
        }
        let fused =
            |kind| move |a: &mut Assembler| a.fused(kind, Order::Plus, 1, 9, Place::Register(28));
        // fmadd d1, d9, d28, d1; fnmsub; fmsub
        assert_eq!(one(&fused(Fused::Add)), [0x1F5C_0521]);
        assert_eq!(one(&fused(Fused::Sub)), [0x1F7C_8521]);
        assert_eq!(one(&fused(Fused::From)), [0x1F5C_8521]);
        // fmla v1.2d, v9.2d, v28.2d; fneg v1.2d, v1.2d and fmla; fmls
        assert_eq!(two(&fused(Fused::Add)), [0x4E7C_CD21]);
        assert_eq!(two(&fused(Fused::Sub)), [0x6EE0_F821, 0x4E7C_CD21]);
        assert_eq!(two(&fused(Fused::From)), [0x4EFC_CD21]);
        assert_eq!(one(&|a| a.copy(3, 12)), [0x1E60_4183]);
        assert_eq!(two(&|a| a.copy(3, 12)), [0x4EAC_1D83]);
        assert_eq!(one(&|a| a.negate(3, 12, r(0))), [0x1E61_4183]);
        assert_eq!(one(&|a| a.sqrt(3, r(12))), [0x1E61_C183]);
        assert_eq!(two(&|a| a.sqrt(3, r(12))), [0x6EE1_F983]);
        // fcmgt d3, d12, #0.0 and bsl v3.8b, v4.8b, v5.8b; of vectors
        assert_eq!(one(&|a| a.select(3, 12, r(0), 4, 5)), [0x5EE0_C983, 0x2E65_1C83]);
        assert_eq!(two(&|a| a.select(3, 12, r(0), 4, 5)), [0x4EE0_C983, 0x6E65_1C83]);
        let at = Place::Memory;
        assert_eq!(one(&|a| a.load(3, at(Base::Slots, 16))), [0xFD40_0803]);
        assert_eq!(two(&|a| a.load(3, at(Base::Constants, 65520))), [0x3DFF_FC23]);
        assert_eq!(one(&|a| a.store(at(Base::Spills, 8), 3)), [0xFD00_0443]);
        assert_eq!(two(&|a| a.store(at(Base::Spills, 32), 3)), [0x3D80_0843]);
        // ldr d3, [x3, #8] and dup v3.2d, v3.d[0]
        assert_eq!(two(&|a| a.load(3, at(Base::Common, 8))), [0xFD40_0463, 0x4E08_0463]);
        // add x16, x1, #0x10, lsl #12 and ldr q3, [x16]
        assert_eq!(two(&|a| a.load(3, at(Base::Constants, 65536))), [0x9140_4030, 0x3DC0_0203]);
        // ldr q30, [x0, #16] and fadd v3.2d, v4.2d, v30.2d
        assert_eq!(
            two(&|a| a.arithmetic(Operation::Add, 3, 4, at(Base::Slots, 16))),
            [0x3DC0_041E, 0x4E7E_D483]
        );
    }

    /// Checks that the code saves and restores the callee-saved registers: `stp d8, d9, [sp,
    /// #-64]!` and further `stp` at the start, `ldp` and `ret` at the end.
    #[test]
    fn callee_saved_registers_are_restored() {
        let target = Target { width: Width::One, set: Set::Neon };
        let bytes = Box::new(Assembler::new(target)).finish();
        let (words, _) = bytes.as_chunks();
        let words: Vec<u32> = words.iter().map(|word| u32::from_le_bytes(*word)).collect();
        assert_eq!(words[..2], [0x6DBC_27E8, 0x6D01_2FEA]);
        assert_eq!(words[3..5], [0x6D03_3FEE, 0x6D43_3FEE]);
        assert_eq!(words[7..], [0x6CC4_27E8, 0xD65F_03C0]);
    }
}
