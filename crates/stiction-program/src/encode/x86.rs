//! Machine instructions of x86-64 for straight-line code.
//!
//! Source: Intel 64 and IA-32 Architectures Software Developer's Manual, volume 2, sections 2.3
//! (VEX) and 2.7 (EVEX).

use super::{Base, Emit, Operation, Order, Place, Set, Target, Width};
use crate::code::Fused;

/// Returns the opcode of an arithmetic instruction in opcode map 0F.
const fn opcode(operation: Operation) -> u8 {
    match operation {
        Operation::Add => 0x58,
        Operation::Mul => 0x59,
        Operation::Sub => 0x5C,
        Operation::Div => 0x5E,
    }
}
const SQRT: u8 = 0x51;
const XOR: u8 = 0x57;
const COPY: u8 = 0x28;
const LOAD: u8 = 0x10;
const BROADCAST: u8 = 0x19;
const STORE: u8 = 0x11;
const COMPARE: u8 = 0xC2;
const BLEND: u8 = 0x4B;
const BLEND_BY_MASK: u8 = 0x65;
/// Predicate of the comparison "greater than", which is false for NaN and raises no exception.
const GREATER: u8 = 0x1E;

/// Code of the mandatory prefix 66 in VEX and EVEX prefixes.
const P66: u8 = 1;
/// Code of the mandatory prefix F2 in VEX and EVEX prefixes.
const PF2: u8 = 3;
/// Code of the opcode map 0F in VEX and EVEX prefixes.
const MAP_0F: u8 = 1;
/// Code of the opcode map 0F38 in VEX and EVEX prefixes.
const MAP_0F38: u8 = 2;
/// Code of the opcode map 0F3A in VEX and EVEX prefixes.
const MAP_0F3A: u8 = 3;

/// Encoder of x86-64 instructions.
pub(crate) struct Assembler {
    bytes: Vec<u8>,
    target: Target,
    /// `true` for AVX-512 (F, DQ, VL), with 32 registers, mask registers, and compressed address
    /// offsets for all register widths.
    extended: bool,
}

/// Instruction without its operands.
#[derive(Clone, Copy)]
struct Instruction {
    prefix: u8,
    map: u8,
    opcode: u8,
    immediate: Option<u8>,
    /// `true` if the mask register k1 selects lanes.
    masked: bool,
    /// Value of bit W in the prefix, which some double-precision instructions need.
    wide: bool,
    /// `true` if the instruction works on a whole register even in code for one number.
    whole: bool,
}

/// Number of the register (rdi, rsi, rdx or rcx) that contains a base address. These registers
/// contain the first four arguments of a function in the System V calling convention.
const fn register(base: Base) -> u8 {
    match base {
        Base::Slots => 7,
        Base::Constants => 6,
        Base::Spills => 2,
        Base::Common => 1,
    }
}

impl Assembler {
    pub(super) fn new(target: Target) -> Self {
        Self { bytes: Vec::new(), target, extended: target.set == Set::Avx512 }
    }

    fn is_scalar(&self) -> bool {
        self.target.width == Width::One
    }

    /// Returns the instruction with the given opcode in opcode map 0F, for one number or for a
    /// whole register.
    fn of_map(&self, opcode: u8) -> Instruction {
        let prefix = if self.is_scalar() { PF2 } else { P66 };
        Instruction {
            prefix,
            map: MAP_0F,
            opcode,
            immediate: None,
            masked: false,
            wide: false,
            whole: false,
        }
    }

    /// Encodes an instruction. `reg` and `rm` are the operands in the ModRM fields of these names,
    /// and `second` is the operand in the prefix.
    fn emit(&mut self, what: Instruction, reg: u8, second: u8, rm: Place) {
        let high = |register: u8| register >= 16;
        let needs = match rm {
            Place::Register(last) => high(last),
            // Offsets in units of the operand size remain short over a greater range.
            Place::Memory(_, offset) => {
                let is_shorter = i8::try_from(offset).is_err() && self.in_units(what, rm).is_some();
                is_shorter || self.spreads(rm) && what.opcode != BROADCAST
            }
        };
        if self.extended
            && (needs || high(reg) || high(second) || self.target.width == Width::Eight)
        {
            self.emit_extended(what, reg, second, rm);
            return;
        }
        let (base, is_register) = match rm {
            Place::Register(r) => (r, true),
            Place::Memory(base, _) => (register(base), false),
        };
        let long = u8::from(self.target.width == Width::Four) << 2;
        let rest = (!second & 15) << 3 | long | what.prefix;
        let r = inverted(reg >> 3, 7);
        if what.map == MAP_0F && !what.wide && base < 8 {
            self.bytes.extend([0xC5, r | rest]);
        } else {
            let first = r | inverted(0, 6) | inverted(base >> 3, 5) | what.map;
            self.bytes.extend([0xC4, first, u8::from(what.wide) << 7 | rest]);
        }
        self.bytes.push(what.opcode);
        let field = (reg & 7) << 3 | base & 7;
        match rm {
            _ if is_register => self.bytes.push(0xC0 | field),
            Place::Memory(_, offset) => self.address(field, offset, i8::try_from(offset).ok()),
            Place::Register(_) => {}
        }
        self.bytes.extend(what.immediate);
    }

    /// Encodes an instruction with the longer prefix of AVX-512 (EVEX); operands as for
    /// [`Self::emit`].
    fn emit_extended(&mut self, what: Instruction, reg: u8, second: u8, rm: Place) {
        let (low, high) = match rm {
            Place::Register(r) => (r, r >> 4),
            Place::Memory(base, _) => (register(base), 0),
        };
        let first = inverted(reg >> 3, 7)
            | inverted(high, 6)
            | inverted(low >> 3, 5)
            | inverted(reg >> 4, 4)
            | what.map;
        let middle = 1 << 7 | (!second & 15) << 3 | 1 << 2 | what.prefix;
        let length = match self.target.width {
            Width::One | Width::Two => 0,
            Width::Four => 1,
            Width::Eight => 2,
        };
        let spreads = u8::from(self.spreads(rm) && what.opcode != BROADCAST);
        let last = length << 5 | spreads << 4 | inverted(second >> 4, 3) | u8::from(what.masked);
        self.bytes.extend([0x62, first, middle, last, what.opcode]);
        let field = (reg & 7) << 3 | low & 7;
        match rm {
            Place::Register(_) => self.bytes.push(0xC0 | field),
            Place::Memory(_, offset) => self.address(field, offset, self.in_units(what, rm)),
        }
        self.bytes.extend(what.immediate);
    }

    /// Returns `true` if the operand is a number in memory that is broadcast to all lanes. Without
    /// AVX-512, only loads can broadcast.
    fn spreads(&self, place: Place) -> bool {
        match place {
            Place::Memory(base, _) => !self.is_scalar() && self.target.is_single(base),
            Place::Register(_) => false,
        }
    }

    /// Offset of a memory operand in units of its size; `None` if the offset does not fit into one
    /// byte.
    fn in_units(&self, what: Instruction, place: Place) -> Option<i8> {
        let Place::Memory(_, offset) = place else { return None };
        let unit = match self.target.width {
            _ if self.spreads(place) => 8,
            Width::One if what.whole => 16,
            width => 8 * width.lanes() as i32,
        };
        (offset % unit == 0).then(|| i8::try_from(offset / unit).ok()).flatten()
    }

    fn address(&mut self, field: u8, offset: i32, short: Option<i8>) {
        match short {
            Some(short) => self.bytes.extend([0x40 | field, short.to_le_bytes()[0]]),
            None => {
                self.bytes.push(0x80 | field);
                self.bytes.extend(offset.to_le_bytes());
            }
        }
    }
}

impl Emit for Assembler {
    fn arithmetic(&mut self, operation: Operation, to: u8, a: u8, b: Place) {
        self.emit(self.of_map(opcode(operation)), to, a, b);
    }

    fn fused(&mut self, kind: Fused, order: Order, to: u8, second: u8, last: Place) {
        let order = match order {
            Order::TimesLast => 0x90,
            Order::Plus => 0xB0,
        };
        let kind = match kind {
            Fused::Add => 0x8,
            Fused::Sub => 0xA,
            Fused::From => 0xC,
        };
        let scalar = u8::from(self.is_scalar());
        let instruction = Instruction {
            prefix: P66,
            map: MAP_0F38,
            opcode: order | kind | scalar,
            immediate: None,
            masked: false,
            wide: true,
            whole: false,
        };
        self.emit(instruction, to, second, last);
    }

    fn copy(&mut self, to: u8, from: u8) {
        // Copies of whole registers are eliminated by register renaming.
        let whole = Instruction { prefix: P66, whole: true, ..self.of_map(COPY) };
        self.emit(whole, to, 0, Place::Register(from));
    }

    fn sqrt(&mut self, to: u8, of: Place) {
        // For one number, the upper half of the result comes from the second operand; any content
        // is valid.
        let upper = if self.is_scalar() { to } else { 0 };
        self.emit(self.of_map(SQRT), to, upper, of);
    }

    fn negate(&mut self, to: u8, from: u8, sign: Place) {
        self.emit(Instruction { prefix: P66, whole: true, ..self.of_map(XOR) }, to, from, sign);
    }

    fn load(&mut self, to: u8, from: Place) {
        let load = self.of_map(LOAD);
        let broadcast = Instruction { map: MAP_0F38, opcode: BROADCAST, ..load };
        self.emit(if self.spreads(from) { broadcast } else { load }, to, 0, from);
    }

    fn store(&mut self, to: Place, from: u8) {
        self.emit(self.of_map(STORE), from, 0, to);
    }

    fn select(&mut self, to: u8, of: u8, zero: Place, yes: u8, no: u8) {
        let compare = Instruction { immediate: Some(GREATER), ..self.of_map(COMPARE) };
        let yes = Place::Register(yes);
        let whole = Instruction { prefix: P66, whole: true, wide: false, ..compare };
        if self.extended {
            // The comparison sets the mask register k1, which then selects.
            self.emit_extended(compare, 1, of, zero);
            let blend = Instruction {
                map: MAP_0F38,
                opcode: BLEND_BY_MASK,
                immediate: None,
                masked: true,
                ..whole
            };
            self.emit_extended(blend, to, no, yes);
        } else {
            // The target register holds the mask first.
            self.emit(compare, to, of, zero);
            let immediate = Some(to << 4);
            self.emit(
                Instruction { map: MAP_0F3A, opcode: BLEND, immediate, ..whole },
                to,
                no,
                yes,
            );
        }
    }

    fn finish(mut self: Box<Self>) -> Vec<u8> {
        // The caller may use instructions without VEX prefixes, which are slow unless the upper
        // halves of the registers are zero.
        const VZEROUPPER_RET: [u8; 4] = [0xC5, 0xF8, 0x77, 0xC3];
        self.bytes.extend(VZEROUPPER_RET);
        self.bytes
    }
}

/// Inverts a bit of a register number, as the prefixes require, and shifts the bit to its place.
fn inverted(bit: u8, place: u8) -> u8 {
    (bit & 1 ^ 1) << place
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks that the bytes are those of another assembler (GNU as), or, for some short addresses,
    /// another valid encoding of the same instruction.
    #[test]
    fn instructions_are_those_of_the_manual() {
        let bytes = |width, extended, f: &dyn Fn(&mut Assembler)| {
            let set = if extended { Set::Avx512 } else { Set::Avx };
            let mut assembler = Assembler::new(Target { width, set });
            f(&mut assembler);
            assembler.bytes
        };
        let slot = |offset| Place::Memory(Base::Slots, offset);
        // vaddsd xmm1, xmm9, [rdi+0x10]
        assert_eq!(
            bytes(Width::One, false, &|a| a.arithmetic(Operation::Add, 1, 9, slot(0x10))),
            [0xC5, 0xB3, 0x58, 0x4F, 0x10]
        );
        // vaddsd xmm1, xmm9, [rdi+0x1000]
        assert_eq!(
            bytes(Width::One, false, &|a| a.arithmetic(Operation::Add, 1, 9, slot(0x1000))),
            [0xC5, 0xB3, 0x58, 0x8F, 0, 0x10, 0, 0]
        );
        // vaddsd xmm1, xmm9, [rdi+0x100] and vaddsd xmm1, xmm19, xmm2
        assert_eq!(
            bytes(Width::One, true, &|a| a.arithmetic(Operation::Add, 1, 9, slot(0x100))),
            [0x62, 0xF1, 0xB7, 0x08, 0x58, 0x4F, 0x20]
        );
        assert_eq!(
            bytes(Width::One, true, &|a| a.arithmetic(Operation::Add, 1, 19, Place::Register(2))),
            [0x62, 0xF1, 0xE7, 0x00, 0x58, 0xCA]
        );
        // vmulpd ymm12, ymm3, ymm11
        assert_eq!(
            bytes(Width::Four, false, &|a| a.arithmetic(
                Operation::Mul,
                12,
                3,
                Place::Register(11)
            )),
            [0xC4, 0x41, 0x65, 0x59, 0xE3]
        );
        // vfmadd132sd xmm1, xmm9, [rdi+0x10]
        let fused = |a: &mut Assembler| a.fused(Fused::Add, Order::TimesLast, 1, 9, slot(0x10));
        assert_eq!(bytes(Width::One, false, &fused), [0xC4, 0xE2, 0xB1, 0x99, 0x4F, 0x10]);
        // vfnmadd231pd ymm12, ymm3, ymm11
        assert_eq!(
            bytes(Width::Four, false, &|a| {
                a.fused(Fused::From, Order::Plus, 12, 3, Place::Register(11));
            }),
            [0xC4, 0x42, 0xE5, 0xBC, 0xE3]
        );
        // vfmsub132pd zmm20, zmm17, zmm31
        assert_eq!(
            bytes(Width::Eight, true, &|a| {
                a.fused(Fused::Sub, Order::TimesLast, 20, 17, Place::Register(31));
            }),
            [0x62, 0x82, 0xF5, 0x40, 0x9A, 0xE7]
        );
        // vmovapd xmm3, xmm12
        assert_eq!(bytes(Width::One, false, &|a| a.copy(3, 12)), [0xC4, 0xC1, 0x79, 0x28, 0xDC]);
        // vsubpd zmm20, zmm17, zmm31 and vsubpd zmm20, zmm17, [rdi-0x80]
        assert_eq!(
            bytes(Width::Eight, true, &|a| a.arithmetic(
                Operation::Sub,
                20,
                17,
                Place::Register(31)
            )),
            [0x62, 0x81, 0xF5, 0x40, 0x5C, 0xE7]
        );
        // vsubpd zmm20, zmm17, [rsi+0x40]{1to8}, vbroadcastsd zmm3, [rcx-8], vbroadcastsd ymm3, [rcx+0x100]
        assert_eq!(
            bytes(Width::Eight, true, &|a| {
                a.arithmetic(Operation::Sub, 20, 17, Place::Memory(Base::Constants, 0x40));
            }),
            [0x62, 0xE1, 0xF5, 0x50, 0x5C, 0x66, 0x08]
        );
        let load = |offset| move |a: &mut Assembler| a.load(3, Place::Memory(Base::Common, offset));
        assert_eq!(
            bytes(Width::Eight, true, &load(-8)),
            [0x62, 0xF2, 0xFD, 0x48, 0x19, 0x59, 0xFF]
        );
        assert_eq!(
            bytes(Width::Four, false, &load(0x100)),
            [0xC4, 0xE2, 0x7D, 0x19, 0x99, 0, 1, 0, 0]
        );
        assert_eq!(
            bytes(Width::Eight, true, &|a| a.arithmetic(Operation::Sub, 20, 17, slot(-0x80))),
            [0x62, 0xE1, 0xF5, 0x40, 0x5C, 0x67, 0xFE]
        );
    }
}
