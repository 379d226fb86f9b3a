//! Machine instructions of x86-64: the few that straight-line code needs.
//!
//! Source: Intel 64 and IA-32 Architectures Software Developer's Manual, volume 2, sections 2.3 (VEX) and
//! 2.7 (EVEX).

use crate::code::Fused;

/// How wide registers are and how many there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Width {
    /// One number (AVX).
    One,
    /// Four (AVX).
    Four,
    /// Eight, with masks (AVX-512 F and DQ).
    Eight,
}

impl Width {
    pub(crate) const fn lanes(self) -> usize {
        match self {
            Self::One => 1,
            Self::Four => 4,
            Self::Eight => 8,
        }
    }

    pub(crate) const fn registers(self) -> usize {
        match self {
            Self::One | Self::Four => 16,
            Self::Eight => 32,
        }
    }
}

/// A general register that holds an address.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Base {
    Slots,
    Constants,
    Spills,
}

impl Base {
    /// rdi, rsi, rdx: the first three arguments of a function (System V).
    const fn number(self) -> u8 {
        match self {
            Self::Slots => 7,
            Self::Constants => 6,
            Self::Spills => 2,
        }
    }
}

/// An operand: a vector register or memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    Register(u8),
    Memory(Base, i32),
}

/// Instructions of three operands: opcodes of the map 0F.
pub(crate) const ADD: u8 = 0x58;
pub(crate) const MUL: u8 = 0x59;
pub(crate) const SUB: u8 = 0x5C;
pub(crate) const DIV: u8 = 0x5E;
const SQRT: u8 = 0x51;
const XOR: u8 = 0x57;
const COPY: u8 = 0x28;
const LOAD: u8 = 0x10;
const STORE: u8 = 0x11;
const COMPARE: u8 = 0xC2;
const BLEND: u8 = 0x4B;
const BLEND_BY_MASK: u8 = 0x65;
/// Greater than, false for what is no number, quiet.
const GREATER: u8 = 0x1E;

/// Prefixes and maps.
const P66: u8 = 1;
const PF2: u8 = 3;
const MAP_0F: u8 = 1;
const MAP_0F38: u8 = 2;
const MAP_0F3A: u8 = 3;

/// Writes instructions.
pub(crate) struct Assembler {
    pub(crate) bytes: Vec<u8>,
    width: Width,
}

/// What an instruction is, without its operands.
#[derive(Clone, Copy)]
struct Instruction {
    prefix: u8,
    map: u8,
    opcode: u8,
    immediate: Option<u8>,
    /// Whether the mask register k1 chooses.
    masked: bool,
    /// The bit W, which some instructions of doubles have.
    wide: bool,
}

/// Where the operands of a fused instruction `product + sum` stand: the target is read, too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Order {
    /// `to = to * last + second`.
    TimesLast,
    /// `to = second * last + to`.
    Plus,
}

impl Assembler {
    pub(crate) fn new(width: Width) -> Self {
        Self { bytes: Vec::new(), width }
    }

    /// Arithmetic on one number or on all.
    fn of_map(&self, opcode: u8) -> Instruction {
        let prefix = if self.width == Width::One { PF2 } else { P66 };
        Instruction { prefix, map: MAP_0F, opcode, immediate: None, masked: false, wide: false }
    }

    /// `to = a OP b`.
    pub(crate) fn arithmetic(&mut self, opcode: u8, to: u8, a: u8, b: Place) {
        self.emit(self.of_map(opcode), to, a, b);
    }

    /// One rounding for product and sum; `to` is one of the operands.
    pub(crate) fn fused(&mut self, kind: Fused, order: Order, to: u8, second: u8, last: Place) {
        let order = match order {
            Order::TimesLast => 0x90,
            Order::Plus => 0xB0,
        };
        let kind = match kind {
            Fused::Add => 0x8,
            Fused::Sub => 0xA,
            Fused::From => 0xC,
        };
        let scalar = u8::from(self.width == Width::One);
        let instruction = Instruction {
            prefix: P66,
            map: MAP_0F38,
            opcode: order | kind | scalar,
            immediate: None,
            masked: false,
            wide: true,
        };
        self.emit(instruction, to, second, last);
    }

    /// `to = from`, registers.
    pub(crate) fn copy(&mut self, to: u8, from: u8) {
        // All of it, whatever the width: that is what processors do by renaming.
        let whole = Instruction { prefix: P66, opcode: COPY, ..self.of_map(COPY) };
        self.emit(whole, to, 0, Place::Register(from));
    }

    pub(crate) fn sqrt(&mut self, to: u8, of: Place) {
        // Of one number the upper half comes from the second operand: that of the target will do.
        let upper = if self.width == Width::One { to } else { 0 };
        self.emit(self.of_map(SQRT), to, upper, of);
    }

    /// `to = a XOR b`, all bits.
    pub(crate) fn xor(&mut self, to: u8, a: u8, b: Place) {
        self.emit(Instruction { prefix: P66, ..self.of_map(XOR) }, to, a, b);
    }

    /// `to = [from]`.
    pub(crate) fn load(&mut self, to: u8, from: Place) {
        self.emit(self.of_map(LOAD), to, 0, from);
    }

    /// `[to] = from`.
    pub(crate) fn store(&mut self, to: Place, from: u8) {
        self.emit(self.of_map(STORE), from, 0, to);
    }

    /// `to = of > zero ? yes : no`; `mask` is a register that may be overwritten.
    pub(crate) fn select(&mut self, to: u8, of: u8, zero: Place, [yes, no]: [u8; 2], mask: u8) {
        let compare = Instruction { immediate: Some(GREATER), ..self.of_map(COMPARE) };
        let yes = Place::Register(yes);
        if self.width == Width::Eight {
            // Into the mask register k1, then by it.
            self.emit(compare, 1, of, zero);
            let blend = Instruction {
                prefix: P66,
                map: MAP_0F38,
                opcode: BLEND_BY_MASK,
                immediate: None,
                masked: true,
                wide: false,
            };
            self.emit(blend, to, no, yes);
        } else {
            self.emit(compare, mask, of, zero);
            let blend = Instruction {
                prefix: P66,
                map: MAP_0F3A,
                opcode: BLEND,
                immediate: Some(mask << 4),
                masked: false,
                wide: false,
            };
            self.emit(blend, to, no, yes);
        }
    }

    /// Returns to the caller, who may have code without VEX.
    pub(crate) fn finish(&mut self) {
        const VZEROUPPER_RET: [u8; 4] = [0xC5, 0xF8, 0x77, 0xC3];
        self.bytes.extend(VZEROUPPER_RET);
    }

    /// `reg` is the operand in the field of that name, `second` that in the prefix, `rm` the last.
    fn emit(&mut self, what: Instruction, reg: u8, second: u8, rm: Place) {
        // Bits of register numbers that do not fit into three are kept inverted.
        let (low, base, high) = match rm {
            Place::Register(r) => (r, r >> 3 & 1, r >> 4 & 1),
            Place::Memory(base, _) => (base.number(), 0, 0),
        };
        let inverted = |bit: u8, place: u8| (bit & 1 ^ 1) << place;
        let r = inverted(reg >> 3, 7);
        if self.width == Width::Eight {
            let first =
                r | inverted(high, 6) | inverted(base, 5) | inverted(reg >> 4, 4) | what.map;
            let middle = 1 << 7 | (!second & 15) << 3 | 1 << 2 | what.prefix;
            // 512 bits; the fifth bit of the second operand; the mask.
            let last = 2 << 5 | inverted(second >> 4, 3) | u8::from(what.masked);
            self.bytes.extend([0x62, first, middle, last]);
        } else {
            let first = r | inverted(0, 6) | inverted(base, 5) | what.map;
            let long = if self.width == Width::Four { 1 << 2 } else { 0 };
            let wide = u8::from(what.wide) << 7;
            let middle = wide | (!second & 15) << 3 | long | what.prefix;
            self.bytes.extend([0xC4, first, middle]);
        }
        self.bytes.push(what.opcode);
        let mode = if matches!(rm, Place::Register(_)) { 0xC0 } else { 0x80 };
        self.bytes.push(mode | (reg & 7) << 3 | low & 7);
        if let Place::Memory(_, offset) = rm {
            self.bytes.extend(offset.to_le_bytes());
        }
        self.bytes.extend(what.immediate);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As an assembler writes them (GNU as, `vaddsd (%rdi + 0x10), %xmm9, %xmm1` and so on).
    #[test]
    fn instructions_are_those_of_the_manual() {
        let bytes = |width, f: &dyn Fn(&mut Assembler)| {
            let mut assembler = Assembler::new(width);
            f(&mut assembler);
            assembler.bytes
        };
        let slot = Place::Memory(Base::Slots, 0x10);
        // vaddsd xmm1, xmm9, [rdi+0x10]
        assert_eq!(
            bytes(Width::One, &|a| a.arithmetic(ADD, 1, 9, slot)),
            [0xC4, 0xE1, 0x33, 0x58, 0x8F, 0x10, 0, 0, 0]
        );
        // vmulpd ymm12, ymm3, ymm11
        assert_eq!(
            bytes(Width::Four, &|a| a.arithmetic(MUL, 12, 3, Place::Register(11))),
            [0xC4, 0x41, 0x65, 0x59, 0xE3]
        );
        // vfmadd132sd xmm1, xmm9, [rdi+0x10]
        let fused = |a: &mut Assembler| a.fused(Fused::Add, Order::TimesLast, 1, 9, slot);
        assert_eq!(bytes(Width::One, &fused), [0xC4, 0xE2, 0xB1, 0x99, 0x8F, 0x10, 0, 0, 0]);
        // vfnmadd231pd ymm12, ymm3, ymm11
        assert_eq!(
            bytes(Width::Four, &|a| {
                a.fused(Fused::From, Order::Plus, 12, 3, Place::Register(11));
            }),
            [0xC4, 0x42, 0xE5, 0xBC, 0xE3]
        );
        // vfmsub132pd zmm20, zmm17, zmm31
        assert_eq!(
            bytes(Width::Eight, &|a| {
                a.fused(Fused::Sub, Order::TimesLast, 20, 17, Place::Register(31));
            }),
            [0x62, 0x82, 0xF5, 0x40, 0x9A, 0xE7]
        );
        // vmovapd xmm3, xmm12
        assert_eq!(bytes(Width::One, &|a| a.copy(3, 12)), [0xC4, 0xC1, 0x79, 0x28, 0xDC]);
        // vsubpd zmm20, zmm17, zmm31
        assert_eq!(
            bytes(Width::Eight, &|a| a.arithmetic(SUB, 20, 17, Place::Register(31))),
            [0x62, 0x81, 0xF5, 0x40, 0x5C, 0xE7]
        );
    }
}
