//! Random arguments for any model.
use bipedc_runtime::{Argument, Model, Real, State};

/// Xorshift: the same numbers on every machine.
pub struct Random(pub u64);

impl Random {
    /// Between -1 and 1.
    pub fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// All arguments of a model.
pub struct Arguments<R>(Vec<Vec<R>>);

impl<R: Real> Arguments<R> {
    /// Random ones; the base's quaternion of a floating robot has length one.
    pub fn random(model: &impl Model<R>, random: &mut Random) -> Self {
        let mut all: Vec<Vec<f64>> = Argument::ALL
            .iter()
            .map(|&a| (0..model.argument_length(a)).map(|_| 3.0 * random.next()).collect())
            .collect();
        if model.nq() == model.nv() + 1 {
            let quaternion = &mut all[Argument::Q as usize][3..7];
            let norm = quaternion.iter().map(|x| x * x).sum::<f64>().sqrt();
            quaternion.iter_mut().for_each(|x| *x /= norm);
        }
        Self(all.into_iter().map(|list| list.into_iter().map(R::constant).collect()).collect())
    }

    /// With other values of one argument.
    pub fn with(&self, argument: Argument, values: Vec<R>) -> Self {
        let mut all = self.0.clone();
        all[argument as usize] = values;
        Self(all)
    }

    /// As the model takes them.
    pub fn state(&self) -> State<'_, R> {
        Argument::ALL
            .iter()
            .zip(&self.0)
            .fold(State::new(), |state, (&argument, values)| state.with(argument, values))
    }
}

/// The names of all functions of a model, with the lengths of their results.
pub fn functions<R: Real>(model: &impl Model<R>) -> Vec<(String, usize)> {
    (0..).map_while(|k| model.signature(k).map(|s| (s.name.to_owned(), s.rows * s.columns))).collect()
}
