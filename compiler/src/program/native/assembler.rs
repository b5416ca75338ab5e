//! Instructions of x86-64 with AVX on numbers of double precision: one at a time, or two or four side by side.
//!
//! Intel 64 and IA-32 Architectures Software Developer's Manual, volume 2: VEX prefixes and displacements as short as they can be.

/// A register for numbers, 0 to 15.
pub type Register = u8;

/// Registers that hold addresses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Base {
    /// rbx: inputs, angles, sines, cosines; from here on results that found no register.
    Memory = 3,
    /// rbp
    Constants = 5,
    /// r14
    Outputs = 14,
}

/// Where an operand is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum At {
    /// In a register.
    Register(Register),
    /// So many bytes behind an address.
    Memory(Base, i32),
}

/// Operations on two operands, with their codes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Binary {
    Sqrt = 0x51,
    Add = 0x58,
    Mul = 0x59,
    Sub = 0x5c,
    Div = 0x5e,
    /// The first if it is larger, else the second.
    Max = 0x5f,
}

/// Operations on bits of all lanes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bits {
    And = 0x54,
    Xor = 0x57,
}

/// ± a b ± c, with one rounding; codes of the packed forms that put the result in place of a factor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fused {
    /// a b + c
    Add = 0x98,
    /// a b − c
    Sub = 0x9a,
    /// −a b + c
    NegAdd = 0x9c,
    /// −a b − c
    NegSub = 0x9e,
}

/// What the target, the first and the second operand of a fused operation are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// Factor, addend, factor.
    FactorAddendFactor = 0x00,
    /// Factor, factor, addend.
    FactorFactorAddend = 0x10,
    /// Addend, factor, factor.
    AddendFactorFactor = 0x20,
}

/// Numbers side by side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Width {
    One,
    Two,
    Four,
}

/// Machine code that grows.
#[derive(Debug, Default)]
pub struct Assembler {
    pub code: Vec<u8>,
}

/// Maps of operation codes.
const MAP_0F: u8 = 1;
const MAP_0F38: u8 = 2;
/// Prefixes of operation codes.
const PACKED: u8 = 1;
const SCALAR: u8 = 3;

impl Assembler {
    fn bytes(&mut self, bytes: &[u8]) {
        self.code.extend_from_slice(bytes);
    }

    fn vex(
        &mut self,
        (map, prefix, w): (u8, u8, bool),
        (width, code): (Width, u8),
        (to, first): (Register, Register),
        second: At,
    ) {
        let low = match second {
            At::Register(register) => register,
            At::Memory(base, _) => base as u8,
        };
        // Bits of registers are inverted.
        let vector = (!first & 15) << 3 | u8::from(width == Width::Four) << 2 | prefix;
        if map == MAP_0F && !w && low < 8 {
            self.bytes(&[0xc5, u8::from(to < 8) << 7 | vector, code]);
        } else {
            let extended = u8::from(to < 8) << 7 | 1 << 6 | u8::from(low < 8) << 5;
            self.bytes(&[0xc4, extended | map, u8::from(w) << 7 | vector, code]);
        }
        let to = (to & 7) << 3;
        match second {
            At::Register(register) => self.bytes(&[0xc0 | to | register & 7]),
            At::Memory(base, offset) => match i8::try_from(offset) {
                Ok(offset) => self.bytes(&[0x40 | to | base as u8 & 7, offset as u8]),
                Err(_) => {
                    self.bytes(&[0x80 | to | base as u8 & 7]);
                    self.bytes(&offset.to_le_bytes());
                }
            },
        }
    }

    /// to = first ∘ second
    pub fn binary(&mut self, width: Width, operation: Binary, to: Register, first: Register, second: At) {
        self.vex(plain(width), (width, operation as u8), (to, first), second);
    }

    /// to = first ∘ second, bit by bit; of memory always as much as a whole register has.
    pub fn bits(&mut self, width: Width, operation: Bits, to: Register, first: Register, second: At) {
        self.vex((MAP_0F, PACKED, false), (width, operation as u8), (to, first), second);
    }

    /// target = ±(factor · factor) ± addend
    pub fn fused(
        &mut self,
        width: Width,
        (operation, form): (Fused, Form),
        target: Register,
        first: Register,
        second: At,
    ) {
        let code = operation as u8 + form as u8 + u8::from(width == Width::One);
        self.vex((MAP_0F38, PACKED, true), (width, code), (target, first), second);
    }

    pub fn load(&mut self, width: Width, to: Register, from: At) {
        match from {
            At::Register(register) if register == to => {}
            // All bits of the register.
            At::Register(_) => self.vex((MAP_0F, PACKED, false), (width, 0x28), (to, 0), from),
            At::Memory(..) => self.vex(plain(width), (width, 0x10), (to, 0), from),
        }
    }

    pub fn store(&mut self, width: Width, base: Base, offset: i32, from: Register) {
        self.vex(plain(width), (width, 0x11), (from, 0), At::Memory(base, offset));
    }

    /// Stores the second of two numbers.
    pub fn store_second(&mut self, base: Base, offset: i32, from: Register) {
        self.vex((MAP_0F, PACKED, false), (Width::Two, 0x17), (from, 0), At::Memory(base, offset));
    }

    /// A number twice; of a register its first.
    pub fn twice(&mut self, to: Register, from: At) {
        self.vex((MAP_0F, SCALAR, false), (Width::Two, 0x12), (to, 0), from);
    }

    /// A number of `first`, then one of `second`: the second ones where so said.
    pub fn shuffle(&mut self, to: Register, first: (Register, bool), second: (Register, bool)) {
        let at = At::Register(second.0);
        self.vex((MAP_0F, PACKED, false), (Width::Two, 0xc6), (to, first.0), at);
        self.bytes(&[u8::from(first.1) | u8::from(second.1) << 1]);
    }

    /// The first number of `first`, then one from memory.
    pub fn join(&mut self, to: Register, first: Register, memory: At) {
        self.vex((MAP_0F, PACKED, false), (Width::Two, 0x16), (to, first), memory);
    }

    /// Keeps the registers of addresses, and takes the three arguments: memory, of which so many bytes stand before what `Base::Memory` means, outputs, constants.
    pub fn begin(&mut self, before: i32) {
        // push rbx, rbp, r14: the stack is aligned to 16 bytes then.
        self.bytes(&[0x53, 0x55, 0x41, 0x56]);
        // lea rbx, [rdi + before]
        self.bytes(&[0x48, 0x8d, 0x9f]);
        self.bytes(&before.to_le_bytes());
        // mov r14, rsi; mov rbp, rdx
        self.bytes(&[0x49, 0x89, 0xf6, 0x48, 0x89, 0xd5]);
    }

    pub fn end(&mut self) {
        // pop r14, rbp, rbx; ret
        self.bytes(&[0x41, 0x5e, 0x5d, 0x5b, 0xc3]);
    }

    /// Upper halves of registers are given up before code that does not know them.
    pub fn leave_wide(&mut self) {
        // vzeroupper
        self.bytes(&[0xc5, 0xf8, 0x77]);
    }

    /// Calls a function with the address of a place in memory and a number.
    pub fn call_with_place(&mut self, function: usize, offset: i32, count: i32) {
        // lea rdi, [rbx + offset]; mov esi, count
        self.bytes(&[0x48, 0x8d, 0xbb]);
        self.bytes(&offset.to_le_bytes());
        self.bytes(&[0xbe]);
        self.bytes(&count.to_le_bytes());
        self.call(function);
    }

    /// Calls a function of a number that is in register 0, where its result is then.
    pub fn call(&mut self, function: usize) {
        // mov rax, function; call rax
        self.bytes(&[0x48, 0xb8]);
        self.bytes(&(function as u64).to_le_bytes());
        self.bytes(&[0xff, 0xd0]);
    }
}

fn plain(width: Width) -> (u8, u8, bool) {
    (MAP_0F, if width == Width::One { SCALAR } else { PACKED }, false)
}
