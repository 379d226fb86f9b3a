//! Machine instructions, for the instruction sets that code is made for. Every set is written on every machine;
//! only what this one has can be run here (`machine`).

mod neon;
mod x86;

use crate::code::Fused;

/// How many numbers a register holds.
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

/// The instructions that a processor has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Set {
    /// AVX of x86-64, with FMA where there is need of it.
    Avx,
    /// AVX-512 (F, DQ, VL) of x86-64: more registers, masks, short addresses for all widths.
    Avx512,
    /// Advanced SIMD of AArch64, which is always there.
    Neon,
}

impl Set {
    /// The widths of its registers, from narrow to wide.
    pub(crate) const fn widths(self) -> &'static [Width] {
        match self {
            Self::Avx => &[Width::One, Width::Four],
            Self::Avx512 => &[Width::One, Width::Four, Width::Eight],
            Self::Neon => &[Width::One, Width::Two],
        }
    }

    /// The widest of its registers.
    pub(crate) fn widest(self) -> Width {
        self.widths().last().copied().unwrap_or(Width::One)
    }
}

/// What code is made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Target {
    pub(crate) width: Width,
    pub(crate) set: Set,
}

impl Target {
    /// How many registers values may be in.
    pub(crate) const fn registers(self) -> usize {
        match self.set {
            Set::Avx => 16,
            Set::Avx512 => 32,
            Set::Neon => neon::FREE as usize,
        }
    }

    /// Whether a number stands in this memory once, not once for each lane.
    pub(crate) fn is_single(self, base: Base) -> bool {
        match base {
            Base::Common => true,
            Base::Constants => self.set == Set::Avx512 && self.width != Width::One,
            Base::Slots | Base::Spills => false,
        }
    }

    /// Whether other operations than loads take operands from this memory.
    pub(crate) fn reads(self, base: Base) -> bool {
        self.set != Set::Avx || self.width == Width::One || !self.is_single(base)
    }

    /// Whether a fused instruction may overwrite a factor; all may overwrite the addend.
    pub(crate) fn overwrites_factors(self) -> bool {
        self.set != Set::Neon
    }

    /// The slot at which the base stands: where addresses reach as far below it as above it, more of them are
    /// short.
    pub(crate) const fn base_slot(self) -> usize {
        match self.set {
            Set::Avx | Set::Avx512 => 128,
            Set::Neon => 0,
        }
    }
}

/// A general register that holds an address.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Base {
    Slots,
    Constants,
    Spills,
    /// Numbers that all lanes share.
    Common,
}

/// An operand: a vector register or memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    Register(u8),
    /// So many bytes from the base.
    Memory(Base, i32),
}

/// Arithmetic of two operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Operation {
    Add,
    Sub,
    Mul,
    Div,
}

/// Where the operands of a fused instruction `product + sum` stand: the target is read, too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Order {
    /// `to = to * last + second`, see [`Target::overwrites_factors`].
    TimesLast,
    /// `to = second * last + to`.
    Plus,
}

/// Writes operations on one number or on all of a register, each in one instruction or a few.
pub(crate) trait Emit {
    /// `to = a OP b`.
    fn arithmetic(&mut self, operation: Operation, to: u8, a: u8, b: Place);

    /// One rounding for product and sum; `to` is one of the operands.
    fn fused(&mut self, kind: Fused, order: Order, to: u8, second: u8, last: Place);

    /// `to = from`, registers.
    fn copy(&mut self, to: u8, from: u8);

    /// `to = -from`; where that needs the bit of the sign it stands in `sign`.
    fn negate(&mut self, to: u8, from: u8, sign: Place);

    /// `to = sqrt(of)`.
    fn sqrt(&mut self, to: u8, of: Place);

    /// `to = of > 0 ? yes : no`, false for what is no number; `to` is none of the others, zero may be read there.
    fn select(&mut self, to: u8, of: u8, zero: Place, yes: u8, no: u8);

    /// `to = [from]`, into all lanes if that is one number for all.
    fn load(&mut self, to: u8, from: Place);

    /// `[to] = from`.
    fn store(&mut self, to: Place, from: u8);

    /// The whole function, which returns to its caller.
    fn finish(self: Box<Self>) -> Vec<u8>;
}

/// Begins a function of four addresses, in the order of [`Base`].
pub(crate) fn begin(target: Target) -> Box<dyn Emit> {
    match target.set {
        Set::Avx | Set::Avx512 => Box::new(x86::Assembler::new(target)),
        Set::Neon => Box::new(neon::Assembler::new(target)),
    }
}
