//! `speeds` and `[control.choice]`: wished speeds of steps, and the gait parameters that may be chosen to meet them.
use super::file::{Choice, Control, File};
use super::reading::{POSITIVE, Reading};
use bipedc_effects::magnitude;
use bipedc_effects::random::Random;
use bipedc_effects::spelling::suggest;
use toml::{Spanned, Value};

/// Most steps with wished speeds.
const MOST_STEPS: i64 = 1_000_000;
/// Most values of a parameter on the grid of choices.
const MOST_VALUES: i64 = 500;
/// What a choice can keep.
const KEPT: [&str; 6] = ["friction", "pull", "clearance", "torque", "joints", "velocity"];

/// Wished speeds at mid-stance, and what may be chosen for them.
#[derive(Debug, Clone, PartialEq)]
pub struct Wishes {
    /// Of the second step, the third, …, per s.
    pub speeds: Vec<f64>,
    /// Line and column of `speeds`.
    pub position: (usize, usize),
    /// Parameters that may be chosen; none: all.
    pub parameters: Vec<Choosable>,
    /// Which assumptions a choice keeps, by name; `None`: as many as the gait has limits for.
    pub keep: Option<Vec<String>>,
    /// Coulomb's coefficient that choices keep to; `None`: that of the gait.
    pub friction: Option<f64>,
    /// Part of every limit that is left over, if it is said.
    pub reserve: Option<f64>,
    /// Values of each parameter on the grid that ways of several steps go over.
    pub values: Option<usize>,
}

/// A parameter that may be chosen.
#[derive(Debug, Clone, PartialEq)]
pub struct Choosable {
    /// As the gait calls it.
    pub name: String,
    /// Smallest and largest value; `None`: the gait's bounds.
    pub between: Option<[f64; 2]>,
    /// Line and column.
    pub position: (usize, usize),
}

impl Reading<'_> {
    /// What a scenario with a gait wishes of it.
    pub(super) fn wishes(&mut self, file: &File, control: &Control) -> Option<Wishes> {
        let Some(speeds) = &control.speeds else {
            if let Some(choice) = &control.choice {
                let help = "add speeds = [1.2, 1.4] to [control], or leave [control.choice] out";
                self.wrong::<()>(choice.span().start, "there are no speeds to choose parameters for", help);
            }
            return None;
        };
        let at = speeds.span().start;
        if file.method.as_ref().is_none_or(|method| method.get_ref() != "event_driven") {
            let help = "write method = \"event_driven\"";
            self.wrong::<()>(
                at,
                "parameters are chosen at an event, mid-stance; time stepping has none",
                help,
            );
        }
        let none = Choice::default();
        let choice = control.choice.as_ref().map_or(&none, |choice| choice.get_ref());
        Some(Wishes {
            speeds: self.speeds(speeds),
            position: self.place(at),
            parameters: self.choosable(choice),
            keep: choice.keep.as_ref().map(|keep| self.keep(keep)),
            friction: choice
                .friction
                .as_ref()
                .map(|friction| self.number("friction", Some(friction), 1.0, POSITIVE, "1")),
            reserve: choice
                .reserve
                .as_ref()
                .map(|reserve| self.number("reserve", Some(reserve), 0.0, (0.0, 0.9), "1")),
            values: choice.values.as_ref().and_then(|values| self.values(values)),
        })
    }

    /// A list of numbers, or random ones.
    fn speeds(&mut self, found: &Spanned<Value>) -> Vec<f64> {
        let list = match found.get_ref() {
            Value::Array(list) => {
                list.iter().map(number).collect::<Option<Vec<f64>>>().filter(|list| !list.is_empty())
            }
            Value::Table(table) => random(table),
            _ => None,
        };
        let possible = |speed: &f64| (0.0..=magnitude::LARGEST).contains(speed);
        let Some(list) = list.filter(|list| list.iter().all(possible)) else {
            let help = "write speeds at mid-stance, 0 or more, such as speeds = [1.2, 1.4], or speeds = { random = 7, between = [1.2, 1.6], \
                        steps = 100 }";
            self.wrong::<()>(found.span().start, "`speeds` is not possible", help);
            return Vec::new();
        };
        list
    }

    fn choosable(&mut self, choice: &Choice) -> Vec<Choosable> {
        let mut found = Vec::new();
        for (name, value) in &choice.parameters {
            let at = value.span().start;
            let between = match value.get_ref() {
                Value::Boolean(true) => None,
                Value::Array(list) => {
                    match list.iter().map(number).collect::<Option<Vec<f64>>>().as_deref() {
                        Some(&[low, high]) if low < high => Some([low, high]),
                        _ => self.no_range(at, name),
                    }
                }
                _ => self.no_range(at, name),
            };
            found.push(Choosable { name: name.clone(), between, position: self.place(at) });
        }
        found
    }

    fn no_range<T>(&mut self, at: usize, name: &str) -> Option<T> {
        let help = "write smallest and largest value, such as [0.2, 0.8], or true: within the bounds of the gait file";
        self.wrong(at, format!("`{name}` is no range"), help)
    }

    fn keep(&mut self, keep: &[Spanned<String>]) -> Vec<String> {
        for name in keep {
            if !KEPT.contains(&name.get_ref().as_str()) {
                let help = suggest(name.get_ref(), KEPT, || format!("what can be kept: {}", KEPT.join(", ")));
                let message = format!("`{}` is nothing that a choice can keep", name.get_ref());
                self.wrong::<()>(name.span().start, message, help);
            }
        }
        keep.iter().map(|name| name.get_ref().clone()).collect()
    }

    fn values(&mut self, found: &Spanned<i64>) -> Option<usize> {
        let count = *found.get_ref();
        if !(2..=MOST_VALUES).contains(&count) {
            let message = format!("`values` = {count} is not possible");
            return self.wrong(
                found.span().start,
                message,
                format!("write a whole number from 2 to {MOST_VALUES}"),
            );
        }
        Some(count as usize)
    }
}

fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Float(x) => Some(*x).filter(|x| x.is_finite()),
        Value::Integer(x) => Some(*x as f64),
        _ => None,
    }
}

/// `{ random = SEED, between = [LOW, HIGH], change = MOST, steps = N }`: each differs from the one before by `change` at most.
fn random(table: &toml::Table) -> Option<Vec<f64>> {
    if table.keys().any(|key| !["random", "between", "steps", "change"].contains(&key.as_str())) {
        return None;
    }
    let whole = |key: &str| table.get(key).and_then(Value::as_integer);
    let (seed, steps) = (whole("random")?, whole("steps")?);
    let between = table.get("between")?.as_array()?.iter().map(number).collect::<Option<Vec<f64>>>()?;
    let &[low, high] = &between[..] else { return None };
    if seed < 0 || !(1..=MOST_STEPS).contains(&steps) || low > high {
        return None;
    }
    let change = table.get("change").map_or(Some(high - low), number).filter(|change| *change >= 0.0)?;
    let mut random = Random::new(seed.unsigned_abs());
    let mut last = None;
    let mut next = || {
        // The first one may be any.
        let around = last.map_or([low, high], |x: f64| [(x - change).max(low), (x + change).min(high)]);
        let speed = around[0] + (around[1] - around[0]) * random.unit();
        last = Some(speed);
        speed
    };
    Some((0..steps).map(|_| next()).collect())
}
