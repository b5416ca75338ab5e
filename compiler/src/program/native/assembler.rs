//! Instructions of x86-64 with AVX on numbers of double precision: one at a time, or four side by side.
//!
//! Intel 64 and IA-32 Architectures Software Developer's Manual, volume 2: VEX prefixes of three bytes, memory operands with a displacement of four.

/// A register for numbers, 0 to 15.
pub type Register = u8;

/// Registers that hold addresses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Base {
    /// rbx: inputs, angles, sines, cosines, results that found no register.
    Memory = 3,
    /// r13
    Constants = 13,
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

/// ±(first · second) ± target, with one rounding; codes of the packed forms.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fused {
    /// a b + c
    Add = 0xb8,
    /// a b − c
    Sub = 0xba,
    /// −a b + c
    NegAdd = 0xbc,
    /// −a b − c
    NegSub = 0xbe,
}

/// Machine code that grows.
#[derive(Debug)]
pub struct Assembler {
    pub code: Vec<u8>,
    /// Four numbers side by side.
    pub wide: bool,
}

/// Maps of operation codes.
const MAP_0F: u8 = 1;
const MAP_0F38: u8 = 2;
/// Prefixes of operation codes.
const PACKED: u8 = 1;
const SCALAR: u8 = 3;

impl Assembler {
    pub fn new(wide: bool) -> Self {
        Self { code: Vec::new(), wide }
    }

    fn bytes(&mut self, bytes: &[u8]) {
        self.code.extend_from_slice(bytes);
    }

    fn vex(
        &mut self,
        (map, prefix, w): (u8, u8, bool),
        code: u8,
        (to, first): (Register, Register),
        second: At,
    ) {
        let low = match second {
            At::Register(register) => register,
            At::Memory(base, _) => base as u8,
        };
        // Bits of registers are inverted.
        let extended = u8::from(to < 8) << 7 | 1 << 6 | u8::from(low < 8) << 5;
        let vector = u8::from(w) << 7 | (!first & 15) << 3 | u8::from(self.wide) << 2;
        self.bytes(&[0xc4, extended | map, vector | prefix, code]);
        match second {
            At::Register(register) => self.bytes(&[0xc0 | (to & 7) << 3 | register & 7]),
            At::Memory(base, offset) => {
                self.bytes(&[0x80 | (to & 7) << 3 | base as u8 & 7]);
                self.bytes(&offset.to_le_bytes());
            }
        }
    }

    fn plain(&self) -> (u8, u8, bool) {
        (MAP_0F, if self.wide { PACKED } else { SCALAR }, false)
    }

    /// to = first ∘ second
    pub fn binary(&mut self, operation: Binary, to: Register, first: Register, second: At) {
        self.vex(self.plain(), operation as u8, (to, first), second);
    }

    /// to = first ∘ second, bit by bit; of memory always as much as a whole register has.
    pub fn bits(&mut self, operation: Bits, to: Register, first: Register, second: At) {
        self.vex((MAP_0F, PACKED, false), operation as u8, (to, first), second);
    }

    /// target = ±(first · second) ± target
    pub fn fused(&mut self, operation: Fused, target: Register, first: Register, second: At) {
        let code = operation as u8 + u8::from(!self.wide);
        self.vex((MAP_0F38, PACKED, true), code, (target, first), second);
    }

    pub fn load(&mut self, to: Register, from: At) {
        match from {
            At::Register(register) if register == to => {}
            // All bits of the register.
            At::Register(_) => self.vex((MAP_0F, PACKED, false), 0x28, (to, 0), from),
            At::Memory(..) => self.vex(self.plain(), 0x10, (to, 0), from),
        }
    }

    pub fn store(&mut self, base: Base, offset: i32, from: Register) {
        self.vex(self.plain(), 0x11, (from, 0), At::Memory(base, offset));
    }

    /// Keeps the registers of addresses, and takes the three arguments: memory, outputs, constants.
    pub fn begin(&mut self) {
        // push rbx, r13, r14: the stack is aligned to 16 bytes then.
        self.bytes(&[0x53, 0x41, 0x55, 0x41, 0x56]);
        // mov rbx, rdi; mov r14, rsi; mov r13, rdx
        self.bytes(&[0x48, 0x89, 0xfb, 0x49, 0x89, 0xf6, 0x49, 0x89, 0xd5]);
    }

    pub fn end(&mut self) {
        self.leave_wide();
        // pop r14, r13, rbx; ret
        self.bytes(&[0x41, 0x5e, 0x41, 0x5d, 0x5b, 0xc3]);
    }

    /// Upper halves of registers are given up before code that does not know them.
    fn leave_wide(&mut self) {
        if self.wide {
            // vzeroupper
            self.bytes(&[0xc5, 0xf8, 0x77]);
        }
    }

    /// Calls a function with the address of a place in memory and a number.
    pub fn call_with_place(&mut self, function: usize, offset: i32, count: i32) {
        self.leave_wide();
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
