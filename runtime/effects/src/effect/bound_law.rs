//! A law with the values of its parameters filled in.
use super::formula::{Bound, Formula};
use super::instance::Effect;

/// The formula of an effect in some variables, ready to be evaluated at many states.
#[derive(Debug, Clone)]
pub struct BoundLaw {
    bound: Bound,
    /// Of the variables first, then of the parameters.
    values: Vec<f64>,
}

impl BoundLaw {
    /// The formula `text`: names are those of `variables`, or parameters of the effect.
    ///
    /// # Errors
    /// A formula that does not read, a name that is neither; as a clause about the effect.
    pub fn new(text: &str, variables: &[&str], effect: &Effect) -> Result<Self, String> {
        let formula = Formula::parse(text).map_err(|_| "its formula does not read".to_owned())?;
        let mut names = variables.to_vec();
        let mut values = vec![0.0; variables.len()];
        for name in formula.names().iter().filter(|name| !variables.contains(&name.as_str())) {
            let value =
                effect.known(name).ok_or_else(|| format!("its formula has the unknown name `{name}`"))?;
            names.push(name);
            values.push(value);
        }
        let bound =
            formula.bind(&names).map_err(|name| format!("its formula has the unknown name `{name}`"))?;
        Ok(Self { bound, values })
    }

    /// The value where the variables have these values, in their order; `work` is shared by many calls.
    pub fn at(&mut self, variables: &[f64], work: &mut Vec<f64>) -> f64 {
        self.values[..variables.len()].copy_from_slice(variables);
        self.bound.run(&self.values, work)
    }

    /// The value; `gradient[i]` becomes its derivative with respect to the `i`-th variable, then parameters follow: it must
    /// have [`BoundLaw::width`] elements.
    pub fn gradient(&mut self, variables: &[f64], gradient: &mut [f64]) -> f64 {
        self.values[..variables.len()].copy_from_slice(variables);
        self.bound.gradient(&self.values, gradient)
    }

    /// Number of variables and parameters.
    pub fn width(&self) -> usize {
        self.values.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::{Location, VARIABLES, kinds};

    #[test]
    fn parameters_settings_and_variables_have_their_values() {
        let mut effect = Effect::new(&kinds::FORMULA, Location::joint("a"), &[("k", 2.0)]);
        let mut value = |text: &str| {
            effect.torque = Some(text.to_owned());
            let law = BoundLaw::new(text, &VARIABLES, &effect);
            law.map(|mut law| law.at(&[0.2, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0], &mut Vec::new()))
        };
        assert_eq!(value("k * position * velocity"), Ok(2.0 * 0.2 * 3.0));
        // The smoothing of a user's sign is a setting of the kind.
        assert_eq!(value("sign(0.01 * velocity)"), Ok((0.01 * 3.0 / 0.02_f64).tanh()));
        assert_eq!(value("c * velocity"), Err("its formula has the unknown name `c`".to_owned()));
        assert_eq!(value("k *"), Err("its formula does not read".to_owned()));
    }
}
