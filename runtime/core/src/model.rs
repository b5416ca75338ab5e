//! The one interface to a robot model, whether it was emitted as Rust or runs as a program in process.

/// A named vector that a function may take.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
pub enum Argument {
    /// Configuration: base pose (floating: position, quaternion x y z w), then joints; m, rad.
    Q = 0,
    /// Velocity: base twist (floating: linear, angular, in the root's axes), then joints.
    V = 1,
    /// Acceleration: time derivatives of the components of `V`.
    A = 2,
    /// Generalised forces in the order of `V`, N and N m.
    Tau = 3,
    /// External forces at the contact points, three per point, world axes, N.
    Forces = 4,
    /// Inertial or base parameters, or those of a gait, where the function takes them at run time.
    Parameters = 5,
    /// Motor angles of the driven joints (motor shaft), rad.
    MotorQ = 6,
    /// Motor velocities, rad/s.
    MotorV = 7,
    /// Motor accelerations, rad/s².
    MotorA = 8,
}

impl Argument {
    /// How many arguments there are.
    pub const COUNT: usize = 9;
    /// All of them, in the order in which functions take them.
    pub const ALL: [Self; Self::COUNT] = [
        Self::Q,
        Self::V,
        Self::A,
        Self::Tau,
        Self::Forces,
        Self::Parameters,
        Self::MotorQ,
        Self::MotorV,
        Self::MotorA,
    ];
    /// The name of the argument in generated code and messages.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Q => "q",
            Self::V => "v",
            Self::A => "a",
            Self::Tau => "tau",
            Self::Forces => "forces",
            Self::Parameters => "parameters",
            Self::MotorQ => "motor_q",
            Self::MotorV => "motor_v",
            Self::MotorA => "motor_a",
        }
    }
}

/// A set of arguments.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Arguments(u16);

impl Arguments {
    /// The set of the listed arguments.
    pub const fn of(list: &[Argument]) -> Self {
        let mut bits = 0;
        let mut i = 0;
        while i < list.len() {
            bits |= 1 << list[i] as u16;
            i += 1;
        }
        Self(bits)
    }
    /// Whether the set has it.
    pub const fn has(self, argument: Argument) -> bool {
        self.0 & (1 << argument as u16) != 0
    }
}

/// Name, arguments and shape of one function.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Signature<'a> {
    /// Such as `inverse_dynamics` or `position_of_left_foot`.
    pub name: &'a str,
    /// What it reads.
    pub arguments: Arguments,
    /// Rows of the result.
    pub rows: usize,
    /// Columns of the result (1 for vectors).
    pub columns: usize,
}

impl<'a> Signature<'a> {
    /// Of these arguments and shape.
    pub const fn new(name: &'a str, arguments: &[Argument], rows: usize, columns: usize) -> Self {
        Self { name, arguments: Arguments::of(arguments), rows, columns }
    }
}

/// The arguments of one call; those that the function does not read may be empty.
#[derive(Debug, Clone, Copy, Default)]
pub struct State<'a, R> {
    /// Indexed by [`Argument`].
    pub slices: [&'a [R]; Argument::COUNT],
}

impl<'a, R> State<'a, R> {
    /// No arguments yet.
    pub const fn new() -> Self {
        Self { slices: [&[]; Argument::COUNT] }
    }
    /// The same with one argument set.
    pub const fn with(mut self, argument: Argument, values: &'a [R]) -> Self {
        self.slices[argument as usize] = values;
        self
    }
    /// One argument.
    pub const fn get(&self, argument: Argument) -> &'a [R] {
        self.slices[argument as usize]
    }
}

/// Why a call was refused. Nothing was computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CallError {
    /// The model has no function of this index.
    UnknownFunction,
    /// The argument has another length than the model needs.
    WrongLength {
        /// Which one.
        argument: Argument,
        /// What the model needs.
        expected: usize,
    },
    /// The output has another length than rows × columns.
    WrongOutput {
        /// rows × columns
        expected: usize,
    },
}

/// A robot model: emitted code and the in-process evaluator alike.
pub trait Model<R> {
    /// Length of `q`.
    fn nq(&self) -> usize;
    /// Length of `v`, `a` and `tau`.
    fn nv(&self) -> usize;
    /// Names of the joints in the order of `v` after the base's coordinates.
    fn joint_name(&self, index: usize) -> Option<&str>;
    /// Number of joints (without the base).
    fn joints(&self) -> usize;
    /// The `index`-th function, `None` beyond the last.
    fn signature(&self, index: usize) -> Option<Signature<'_>>;
    /// Length of an argument.
    fn argument_length(&self, argument: Argument) -> usize;
    /// Computes the function into `output`, column after column.
    ///
    /// # Errors
    /// Slices of wrong length; nothing is written then.
    fn evaluate(&self, function: usize, state: &State<'_, R>, output: &mut [R]) -> Result<(), CallError>;

    /// The index of the function with this name.
    fn function(&self, name: &str) -> Option<usize> {
        let mut index = 0;
        while let Some(signature) = self.signature(index) {
            if signature.name == name {
                return Some(index);
            }
            index += 1;
        }
        None
    }
}

impl<R, M: Model<R> + ?Sized> Model<R> for &M {
    fn nq(&self) -> usize {
        (**self).nq()
    }
    fn nv(&self) -> usize {
        (**self).nv()
    }
    fn joint_name(&self, index: usize) -> Option<&str> {
        (**self).joint_name(index)
    }
    fn joints(&self) -> usize {
        (**self).joints()
    }
    fn signature(&self, index: usize) -> Option<Signature<'_>> {
        (**self).signature(index)
    }
    fn argument_length(&self, argument: Argument) -> usize {
        (**self).argument_length(argument)
    }
    fn evaluate(&self, function: usize, state: &State<'_, R>, output: &mut [R]) -> Result<(), CallError> {
        (**self).evaluate(function, state, output)
    }
}

/// One argument as an array; used by generated code.
///
/// # Errors
/// The slice has another length.
#[inline]
pub fn argument<'a, R, const N: usize>(
    state: &State<'a, R>,
    argument: Argument,
) -> Result<&'a [R; N], CallError> {
    state.get(argument).try_into().map_err(|_| CallError::WrongLength { argument, expected: N })
}

/// The output as columns; used by generated code.
///
/// # Errors
/// The slice has another length than rows × columns.
#[inline]
pub fn columns<R, const ROWS: usize, const COLUMNS: usize>(
    output: &mut [R],
) -> Result<&mut [[R; ROWS]; COLUMNS], CallError> {
    let wrong = CallError::WrongOutput { expected: ROWS * COLUMNS };
    let (columns, rest) = output.as_chunks_mut::<ROWS>();
    if !rest.is_empty() {
        return Err(wrong);
    }
    columns.try_into().map_err(|_| wrong)
}
