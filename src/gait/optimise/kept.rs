//! Where a search ended, as text: the next search begins there, in another run too. Numbers are read back to the last bit, so that
//! both runs find the same.
use super::layout::Layout;
use super::{LandingPush, Optimum};
use bipedc_analysis::nonlinear::{Central, Ending};
use bipedc_compiler::compile::Collocation;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Of a number that there is not.
const NONE: &str = "-";

impl Optimum {
    /// A line for each kind of numbers, its name first.
    ///
    /// Of a motion that all demands hold of: violations are left out.
    pub fn to_text(&self) -> String {
        let mut text = String::new();
        let mut line = |name: &str, values: &mut dyn Iterator<Item = String>| {
            let values: Vec<String> = values.collect();
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{name} {}", values.join(" "));
        };
        let minimum = f64::from(u8::from(self.ending == Ending::Minimum));
        let numbers = [minimum, self.cost, self.iterations as f64, self.height];
        line("numbers", &mut words(&numbers));
        line("intervals", &mut self.layout.phases.iter().map(|phase| phase.intervals.to_string()));
        line("parts", &mut words(&self.parts));
        line("rates", &mut words(&self.rates));
        let of_leg = |leg: &Option<f64>| leg.map_or_else(|| NONE.to_owned(), |leg| leg.to_string());
        line("regular", &mut self.regular.iter().flatten().map(of_leg));
        let landing = self.landing.map(|landing| [landing.phase as f64, landing.push]);
        line("landing", &mut words(landing.as_ref().map_or(&[][..], |landing| landing)));
        line("x", &mut words(&self.x));
        if let Some(Central { barrier, x, multipliers }) = &self.central {
            line("barrier", &mut words(&[*barrier]));
            line("central", &mut words(x));
            line("multipliers", &mut words(multipliers));
        }
        text
    }

    /// From such a text; none: it is damaged, or of another robot or form.
    pub fn from_text(of: &Collocation, text: &str) -> Option<Self> {
        let lines: BTreeMap<&str, Vec<&str>> = text
            .lines()
            .filter_map(|line| {
                let mut words = line.split(' ').filter(|word| !word.is_empty());
                Some((words.next()?, words.collect()))
            })
            .collect();
        let numbers = |name: &str| read(lines.get(name)?);
        let [minimum, cost, iterations, height] = numbers("numbers")?[..] else { return None };
        let intervals: Vec<usize> = numbers("intervals")?.iter().map(|&count| count as usize).collect();
        let phases = of.phases.len();
        if intervals.len() != phases || intervals.iter().any(|count| !(1..=MOST).contains(count)) {
            return None;
        }
        let layout = Layout::new(of, &intervals);
        let (x, parts, rates) = (numbers("x")?, numbers("parts")?, numbers("rates")?);
        let regular: Vec<Option<f64>> = lines.get("regular")?.iter().map(|leg| leg.parse().ok()).collect();
        let feet = of.description.feet.len();
        let fits = x.len() == layout.variables && parts.len() == phases && rates.len() == phases;
        if !fits || regular.len() != phases * feet {
            return None;
        }
        let landing = match numbers("landing")?[..] {
            [phase, push] => Some(LandingPush { phase: phase as usize, push }),
            _ => None,
        };
        let central = match lines.contains_key("barrier") {
            true => Some(Central {
                barrier: *numbers("barrier")?.first()?,
                x: numbers("central").filter(|central| central.len() == x.len())?,
                multipliers: numbers("multipliers")?,
            }),
            false => None,
        };
        Some(Self {
            x,
            layout,
            parts,
            rates,
            regular: regular.chunks(feet.max(1)).map(<[_]>::to_vec).collect(),
            height,
            central,
            ending: if minimum == 1.0 { Ending::Minimum } else { Ending::Feasible },
            cost,
            iterations: iterations as usize,
            violations: Vec::new(),
            landing: landing.filter(|landing| landing.phase < phases),
        })
    }
}

/// Intervals of a phase at most; more are none that this program asks for.
const MOST: usize = 1000;

/// Numbers with as many digits as it takes to read them back.
fn words(values: &[f64]) -> impl Iterator<Item = String> + '_ {
    values.iter().map(ToString::to_string)
}

fn read(words: &[&str]) -> Option<Vec<f64>> {
    words.iter().map(|word| word.parse().ok()).collect()
}
