//! Integrals with an error estimate, known at every place of the interval.

/// Nodes of the fifteen-point Kronrod rule on [0, 1] half of [-1, 1], from the outside in; the odd ones are Gauss's seven.
const NODES: [f64; 8] = [
    0.9914553711208126,
    0.9491079123427585,
    0.8648644233597691,
    0.7415311855993945,
    0.5860872354676911,
    0.4058451513773972,
    0.20778495500789848,
    0.0,
];
const KRONROD: [f64; 8] = [
    0.022935322010529224,
    0.06309209262997856,
    0.10479001032225019,
    0.14065325971552592,
    0.1690047266392679,
    0.19035057806478542,
    0.20443294007529889,
    0.20948214108472782,
];
/// Weights of Gauss's nodes: the odd ones of [`NODES`].
const GAUSS: [f64; 4] = [0.1294849661688697, 0.27970539148927664, 0.3818300505051189, 0.4179591836734694];

/// Panels that an integral begins with, so that nothing narrow is overlooked.
const FIRST: usize = 4;
/// Panels at most.
const MOST: usize = 4096;
/// Error of a panel, as a part of the integral of the magnitude.
const RELATIVE: f64 = 1e-14;

/// Places of a panel, from below, or the values there.
pub type Places = [f64; 15];

#[derive(Debug, Clone, Copy)]
struct Panel {
    low: f64,
    high: f64,
    integral: f64,
    magnitude: f64,
    error: f64,
}

/// F(x) = ∫ f from the lower end of an interval to x.
#[derive(Debug, Clone)]
pub struct Integral {
    panels: Vec<Panel>,
    /// Up to the lower end of each panel.
    before: Vec<f64>,
}

impl Integral {
    /// Integrates a function over an interval, which is asked for at fifteen places at once. Panels are halved while seven and
    /// fifteen points disagree.
    ///
    /// # Errors
    /// What the function reports.
    pub fn of<E>(range: [f64; 2], f: impl FnMut(&Places) -> Result<Places, E>) -> Result<Self, E> {
        Self::within(range, RELATIVE, f)
    }

    /// The same to another accuracy: the error of a panel, as a part of the integral of the magnitude.
    ///
    /// # Errors
    /// What the function reports.
    pub fn within<E>(
        [low, high]: [f64; 2],
        relative: f64,
        mut f: impl FnMut(&Places) -> Result<Places, E>,
    ) -> Result<Self, E> {
        let place = |k: usize| low + (high - low) * k as f64 / FIRST as f64;
        let mut open = Vec::new();
        for k in 0..FIRST {
            open.push(panel([place(k), place(k + 1)], &mut f)?);
        }
        // The lowest panel is the next one.
        open.reverse();
        let magnitude: f64 = open.iter().map(|panel| panel.magnitude).sum();
        let mut panels: Vec<Panel> = Vec::new();
        while let Some(top) = open.pop() {
            let middle = 0.5 * (top.low + top.high);
            let narrow = (top.high - top.low).abs() <= 1e-12 * (high - low).abs();
            if top.error <= relative * magnitude || narrow || panels.len() + open.len() >= MOST {
                panels.push(top);
                continue;
            }
            open.push(panel([middle, top.high], &mut f)?);
            open.push(panel([top.low, middle], &mut f)?);
        }
        let add = |sum: &mut f64, panel: &Panel| {
            let before = *sum;
            *sum += panel.integral;
            Some(before)
        };
        let before = panels.iter().scan(0.0, add).collect();
        Ok(Self { panels, before })
    }

    /// F at the upper end.
    pub fn whole(&self) -> f64 {
        self.panels
            .iter()
            .zip(&self.before)
            .next_back()
            .map_or(0.0, |(panel, before)| before + panel.integral)
    }

    /// Estimate of the error of all values, from what the two rules disagree by, and rounding.
    pub fn error(&self) -> f64 {
        let rounding = 4.0 * f64::EPSILON * self.panels.iter().map(|panel| panel.magnitude).sum::<f64>();
        self.panels.iter().map(|panel| panel.error).sum::<f64>() + rounding
    }

    /// F at a place of the interval; the function must be the one that was integrated.
    ///
    /// # Errors
    /// What the function reports.
    pub fn at<E>(&self, x: f64, mut f: impl FnMut(&Places) -> Result<Places, E>) -> Result<f64, E> {
        let found =
            self.panels.partition_point(|panel| panel.high <= x).min(self.panels.len().saturating_sub(1));
        let Some(inside) = self.panels.get(found) else { return Ok(0.0) };
        Ok(self.before[found] + panel([inside.low, x], &mut f)?.integral)
    }

    /// Where panels begin and end.
    pub fn edges(&self) -> impl Iterator<Item = f64> + '_ {
        self.panels.iter().map(|panel| panel.low).chain(self.panels.last().map(|panel| panel.high))
    }
}

fn panel<E>([low, high]: [f64; 2], f: &mut impl FnMut(&Places) -> Result<Places, E>) -> Result<Panel, E> {
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    let place = |k: usize| if k < 7 { middle - half * NODES[k] } else { middle + half * NODES[14 - k] };
    let values = f(&std::array::from_fn(place))?;
    let (mut kronrod, mut gauss, mut magnitude) = (0.0, 0.0, 0.0);
    for (k, value) in values.into_iter().enumerate() {
        let (of, weight) = (k.min(14 - k), KRONROD[k.min(14 - k)]);
        kronrod += weight * value;
        magnitude += weight * value.abs();
        if of % 2 == 1 {
            gauss += GAUSS[of / 2] * value;
        }
    }
    let mean = 0.5 * kronrod;
    let varies: f64 = values.iter().enumerate().map(|(k, x)| KRONROD[k.min(14 - k)] * (x - mean).abs()).sum();
    let (integral, magnitude) = (half * kronrod, (half * magnitude).abs());
    let error = estimate((half * (kronrod - gauss)).abs(), (half * varies).abs());
    Ok(Panel { low, high, integral, magnitude, error })
}

/// The error of fifteen points from how far seven points miss them: where both nearly agree, fifteen are far better than seven
/// (QUADPACK, Piessens et al. 1983).
fn estimate(apart: f64, varies: f64) -> f64 {
    if varies > 0.0 { varies * (200.0 * apart / varies).powf(1.5).min(1.0) } else { apart }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    fn sure<T>(x: Result<T, Infallible>) -> T {
        match x {
            Ok(x) => x,
            Err(never) => match never {},
        }
    }

    #[test]
    fn integrals_are_within_their_error() {
        let f = |at: &Places| Ok::<Places, Infallible>(at.map(|x| (3.0 * x).exp() * (20.0 * x).sin()));
        let primitive = |x: f64| (3.0 * x).exp() * (3.0 * (20.0 * x).sin() - 20.0 * (20.0 * x).cos()) / 409.0;
        let found = sure(Integral::of([-0.5, 1.2], f));
        for x in [-0.5, -0.31, 0.0, 0.7, 1.2] {
            let exact = primitive(x) - primitive(-0.5);
            assert!((sure(found.at(x, f)) - exact).abs() <= found.error(), "{x}");
        }
        assert!((found.whole() - (primitive(1.2) - primitive(-0.5))).abs() <= found.error());
        assert!(found.error() < 1e-11, "{}", found.error());
    }

    #[test]
    fn a_kink_costs_panels_but_no_accuracy() {
        let f = |at: &Places| Ok::<Places, Infallible>(at.map(|x| (x - 0.123).abs()));
        let found = sure(Integral::of([0.0, 1.0], f));
        let exact = 0.5 * (0.123f64.powi(2) + 0.877f64.powi(2));
        assert!((found.whole() - exact).abs() < 1e-14);
    }
}
