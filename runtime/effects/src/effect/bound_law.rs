//! A law with the values of its parameters filled in.
use super::formula::{Bound, Formula, Values};
use super::instance::Effect;
use std::borrow::Cow;

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

    /// The values at `count` places, where `variable(i)` gives the values of the `i`-th variable there; it is asked for those that the
    /// formula names alone.
    ///
    /// # Panics
    /// If a variable has fewer values.
    pub fn at_all<'v>(
        &self,
        count: usize,
        variables: usize,
        variable: &dyn Fn(usize) -> Cow<'v, [f64]>,
    ) -> Vec<f64> {
        let given = |(i, value): (usize, &f64)| match i < variables && self.bound.asks_for(i) {
            true => Values::Each(variable(i)),
            false => Values::Same(*value),
        };
        let values: Vec<Values<'_>> = self.values.iter().enumerate().map(given).collect();
        let mut out = vec![0.0; count];
        self.bound.run_at_all(&values, &mut out);
        out
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

    #[test]
    fn many_places_give_the_bits_of_one_after_the_other() {
        let mut effect = Effect::new(&kinds::FORMULA, Location::joint("a"), &[("k", 2.0)]);
        let text = "k * sign(velocity) * (1 + 0.3 * exp(-(velocity / 0.1)^2)) + max(-position, 0.5) * cos(load) / 3 - sqrt(abs(acceleration))";
        effect.torque = Some(text.to_owned());
        let mut law = BoundLaw::new(text, &VARIABLES, &effect).unwrap();
        let value = |variable: usize, i: usize| (0.37 * (i as f64 + 1.0) * (variable as f64 + 1.0)).sin();
        // No whole number of what is evaluated together.
        let count = 300;
        let all = law.at_all(count, VARIABLES.len(), &|variable| {
            (0..count).map(|i| value(variable, i)).collect::<Vec<f64>>().into()
        });
        let mut work = Vec::new();
        for (i, together) in all.iter().enumerate() {
            let state: Vec<f64> = (0..VARIABLES.len()).map(|variable| value(variable, i)).collect();
            assert_eq!(together.to_bits(), law.at(&state, &mut work).to_bits(), "{i}");
        }
    }
}
