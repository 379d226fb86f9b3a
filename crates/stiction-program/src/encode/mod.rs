//! Encoders of machine instructions. The encoders for all instruction sets work on every processor,
//! but a processor executes only code for its own instruction set (`machine`).

mod neon;
mod x86;

use crate::code::Fused;

/// Register width: number of values in a register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Width {
    One,
    Two,
    Four,
    Eight,
}

impl Width {
    pub(crate) const fn lanes(self) -> usize {
        match self {
            Self::One => 1,
            Self::Two => 2,
            Self::Four => 4,
            Self::Eight => 8,
        }
    }
}

/// Instruction set of a processor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Set {
    /// AVX of x86-64, with FMA for fused operations.
    Avx,
    /// AVX-512 (F, DQ, VL) of x86-64, with 32 registers, mask registers, and compressed address
    /// offsets for all register widths.
    Avx512,
    /// Advanced SIMD of AArch64, available on every processor.
    Neon,
}

impl Set {
    /// Available register widths, from narrow to wide.
    pub(crate) const fn widths(self) -> &'static [Width] {
        match self {
            Self::Avx => &[Width::One, Width::Four],
            Self::Avx512 => &[Width::One, Width::Four, Width::Eight],
            Self::Neon => &[Width::One, Width::Two],
        }
    }

    /// Greatest register width.
    pub(crate) fn widest(self) -> Width {
        self.widths().last().copied().unwrap_or(Width::One)
    }
}

/// Register width and instruction set of the generated code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Target {
    pub(crate) width: Width,
    pub(crate) set: Set,
}

impl Target {
    /// Number of registers available for values.
    pub(crate) const fn registers(self) -> usize {
        match self.set {
            Set::Avx => 16,
            Set::Avx512 => 32,
            Set::Neon => neon::FREE as usize,
        }
    }

    /// Returns `true` if the memory area contains only one copy of each number, instead of one copy
    /// for each lane.
    pub(crate) fn is_single(self, base: Base) -> bool {
        match base {
            Base::Common => true,
            Base::Constants => self.set == Set::Avx512 && self.width != Width::One,
            Base::Slots | Base::Spills => false,
        }
    }

    /// Returns `true` if operations other than loads accept operands from this memory area.
    pub(crate) fn reads(self, base: Base) -> bool {
        self.set != Set::Avx || self.width == Width::One || !self.is_single(base)
    }

    /// Returns `true` if a fused multiply-add can overwrite one of its factors. It can overwrite
    /// its addend on all instruction sets.
    pub(crate) fn overwrites_factors(self) -> bool {
        self.set != Set::Neon
    }

    /// Index of the slot to which the base address of the slots points. On x86-64 this is not the
    /// first slot, so that short offsets of both signs are used.
    pub(crate) const fn base_slot(self) -> usize {
        match self.set {
            Set::Avx | Set::Avx512 => 128,
            Set::Neon => 0,
        }
    }
}

/// Memory area of an operand. A general-purpose register contains the base address of each area.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Base {
    Slots,
    Constants,
    Spills,
    /// Read-only numbers that all lanes share.
    Common,
}

/// Location of an operand: a vector register or memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    Register(u8),
    /// Memory area, and offset from its base address in bytes.
    Memory(Base, i32),
}

/// Arithmetic operation with two operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Operation {
    Add,
    Sub,
    Mul,
    Div,
}

/// Order of the operands of a fused multiply-add. The target register `to` is also one of the
/// operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Order {
    /// Computes `to = to * last + second`, see [`Target::overwrites_factors`].
    TimesLast,
    /// Computes `to = second * last + to`.
    Plus,
}

/// Encoder of arithmetic operations and memory accesses. It encodes each operation, on one number
/// or on a whole register, as one or a few machine instructions.
pub(crate) trait Emit {
    /// Encodes `to = a OP b`.
    fn arithmetic(&mut self, operation: Operation, to: u8, a: u8, b: Place);

    /// Encodes a fused multiply-add, which is rounded once; `to` is also one of the operands.
    fn fused(&mut self, kind: Fused, order: Order, to: u8, second: u8, last: Place);

    /// Encodes `to = from`, both registers.
    fn copy(&mut self, to: u8, from: u8);

    /// Encodes `to = -from`; `sign` contains the sign bit for instruction sets that need it.
    fn negate(&mut self, to: u8, from: u8, sign: Place);

    /// Encodes `to = sqrt(of)`.
    fn sqrt(&mut self, to: u8, of: Place);

    /// Encodes `to = of > 0 ? yes : no`, where NaN selects `no`. `to` must differ from the other
    /// registers, and `zero` must contain zero.
    fn select(&mut self, to: u8, of: u8, zero: Place, yes: u8, no: u8);

    /// Encodes the load of a register, `to = [from]`. A number from a memory area with single
    /// copies is broadcast to all lanes, see [`Target::is_single`].
    fn load(&mut self, to: u8, from: Place);

    /// Encodes the store of a register, `[to] = from`.
    fn store(&mut self, to: Place, from: u8);

    /// Returns the bytes of the complete function, including the return instruction.
    fn finish(self: Box<Self>) -> Vec<u8>;
}

/// Creates the encoder of a function whose four arguments are the base addresses of the memory
/// areas, in the order of [`Base`].
pub(crate) fn begin(target: Target) -> Box<dyn Emit> {
    match target.set {
        Set::Avx | Set::Avx512 => Box::new(x86::Assembler::new(target)),
        Set::Neon => Box::new(neon::Assembler::new(target)),
    }
}
