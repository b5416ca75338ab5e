//! The nonlinear program of a gait: direct collocation by Hermite and Simpson with the equations of motion, forces and torques at every node.
use super::cost::Cost;
use super::demands::Demands;
use super::layout::Layout;
use super::rows::Rows;
use super::similarity::Similarity;
use super::variables::Variables;
use bipedc_analysis::nonlinear::{Program, side_by_side};
use bipedc_compiler::compile::Collocation;
use bipedc_compiler::program::LocalFunction;

/// The program; its variables are scaled, so that all are near 1.
pub(super) struct Transcription<'c> {
    pub layout: Layout,
    pub rows: Rows,
    /// All functions, in a fixed order.
    parts: Vec<Part<'c>>,
    variables: Variables,
    cost: Cost<'c>,
    jacobian: Vec<[usize; 2]>,
    hessian: Vec<[usize; 2]>,
}

/// A function of the program with its variables and rows.
struct Part<'c> {
    function: &'c LocalFunction,
    variables: Vec<usize>,
    rows: Vec<Option<usize>>,
    /// Elements of ∂r/∂x that belong to rows of the program.
    asked: usize,
}

impl<'c> Part<'c> {
    fn new(function: &'c LocalFunction, variables: Vec<usize>, rows: &[Option<usize>]) -> Self {
        let asked = function.jacobian_structure().iter().filter(|[row, _]| rows[*row].is_some()).count();
        Self { function, variables, rows: rows.to_vec(), asked }
    }

    fn local(&self, x: &[f64]) -> Vec<f64> {
        self.variables.iter().map(|&k| x[k]).collect()
    }

    fn jacobian(&self, x: &[f64], out: &mut [f64]) {
        let structure = self.function.jacobian_structure();
        let mut found = vec![0.0; structure.len()];
        self.function.jacobian(&self.local(x), &mut found);
        let asked = structure.iter().zip(found).filter(|([row, _], _)| self.rows[*row].is_some());
        out.iter_mut().zip(asked).for_each(|(out, (_, value))| *out = value);
    }

    fn hessian(&self, x: &[f64], multipliers: &[f64], out: &mut [f64]) {
        let own: Vec<f64> = self.rows.iter().map(|row| row.map_or(0.0, |row| multipliers[row])).collect();
        self.function.hessian(&self.local(x), &own, out);
    }
}

/// Every function's part of the values with what it has to do, side by side; what is left of the values.
fn in_parts<'v, 'c>(
    parts: &[Part<'c>],
    mut values: &'v mut [f64],
    size: impl Fn(&Part<'c>) -> usize,
    work: impl Fn(&Part<'c>, &mut [f64]) + Sync,
) -> &'v mut [f64] {
    let mut jobs = Vec::with_capacity(parts.len());
    for part in parts {
        let (own, rest) = values.split_at_mut(size(part));
        values = rest;
        jobs.push((part, own));
    }
    side_by_side(jobs, |(part, own)| work(part, own));
    values
}

impl<'c> Transcription<'c> {
    pub fn new(
        of: &'c Collocation,
        layout: Layout,
        (rows, similar): (Rows, Similarity),
        demands: &Demands,
        guess: &[f64],
    ) -> Self {
        let mut found = Self {
            parts: parts(of, &layout, &rows),
            variables: Variables::new(of, &layout, similar, demands, guess),
            cost: Cost::new(of, similar, demands),
            jacobian: Vec::new(),
            hessian: Vec::new(),
            layout,
            rows,
        };
        found.jacobian = found.structure_of_jacobian();
        found.hessian = found.structure_of_hessian();
        found
    }

    /// In their units.
    pub fn unscaled(&self, x: &[f64]) -> Vec<f64> {
        x.iter().zip(&self.variables.scale).map(|(x, scale)| x * scale).collect()
    }
    pub fn scaled(&self, x: &[f64]) -> Vec<f64> {
        x.iter().zip(&self.variables.scale).map(|(x, scale)| x / scale).collect()
    }

    /// Equations between nodes: for each the row, then variable and factor of the linear part, and variable with factor of duration × it.
    fn each_between(&self, mut tell: impl FnMut(usize, usize, [(usize, f64); 3], [(usize, f64); 3])) {
        let nv = self.layout.nv;
        for (p, phase) in self.layout.phases.iter().enumerate() {
            for interval in 0..phase.intervals {
                let part = phase.width(interval);
                let first = self.rows.between[p] + 4 * nv * interval;
                for order in 0..2 {
                    let at = [0, 1, 2].map(|k| self.layout.motion(p, 2 * interval + k, order));
                    let slope = at.map(|x| x + nv);
                    for k in 0..nv {
                        let [a, m, b] = at.map(|x| x + k);
                        let [fa, fm, fb] = slope.map(|x| x + k);
                        let row = first + 2 * order * nv + k;
                        let whole = [(fa, -part / 6.0), (fm, -4.0 * part / 6.0), (fb, -part / 6.0)];
                        tell(row, phase.duration, [(b, 1.0), (a, -1.0), (m, 0.0)], whole);
                        let half = [(fa, -part / 8.0), (fb, part / 8.0), (fm, 0.0)];
                        tell(row + nv, phase.duration, [(m, 1.0), (a, -0.5), (b, -0.5)], half);
                    }
                }
            }
        }
    }

    fn structure_of_jacobian(&self) -> Vec<[usize; 2]> {
        let mut found = Vec::new();
        for part in &self.parts {
            for &[row, variable] in part.function.jacobian_structure() {
                if let Some(row) = part.rows[row] {
                    found.push([row, part.variables[variable]]);
                }
            }
        }
        self.each_between(|row, duration, linear, slopes| {
            found.extend(linear.iter().chain(&slopes).map(|&(variable, _)| [row, variable]));
            found.push([row, duration]);
        });
        for (row, terms) in &self.rows.sums {
            found.extend(terms.iter().map(|&(variable, _)| [*row, variable]));
        }
        found
    }

    fn structure_of_hessian(&self) -> Vec<[usize; 2]> {
        let mut found = Vec::new();
        for part in &self.parts {
            let pairs = part.function.hessian_structure().iter();
            found.extend(pairs.map(|&[i, j]| [part.variables[i], part.variables[j]]));
        }
        self.each_between(|_, duration, _, slopes| {
            found.extend(slopes.map(|(variable, _)| [variable, duration]))
        });
        self.cost.each_second(&self.layout, &vec![1.0; self.layout.variables], |place, _| found.push(place));
        found
    }
}

/// The functions of nodes and changes.
fn parts<'c>(of: &'c Collocation, layout: &Layout, rows: &Rows) -> Vec<Part<'c>> {
    let mut found = Vec::new();
    for (p, nodes) in rows.nodes.iter().enumerate() {
        let node = |(node, rows): (usize, &Vec<Option<usize>>)| {
            Part::new(&of.phases[p].node, layout.node(p, node), rows)
        };
        found.extend(nodes.iter().enumerate().map(node));
        found.push(Part::new(&of.changes[p].function, layout.change(p), &rows.changes[p]));
    }
    found
}

impl Program for Transcription<'_> {
    fn bounds(&self) -> Vec<[f64; 2]> {
        self.variables
            .bounds
            .iter()
            .zip(&self.variables.scale)
            .map(|(b, scale)| b.map(|x| x / scale))
            .collect()
    }

    fn limits(&self) -> Vec<[f64; 2]> {
        self.rows
            .limits
            .iter()
            .zip(&self.rows.scale)
            .map(|(limits, scale)| limits.map(|x| x / scale))
            .collect()
    }

    fn objective(&self, x: &[f64]) -> f64 {
        self.cost.value(&self.layout, &self.unscaled(x))
    }

    fn gradient(&self, x: &[f64], gradient: &mut [f64]) {
        self.cost.gradient(&self.layout, &self.unscaled(x), gradient);
        gradient.iter_mut().zip(&self.variables.scale).for_each(|(g, scale)| *g *= scale);
    }

    fn constraints(&self, x: &[f64], values: &mut [f64]) {
        let x = self.unscaled(x);
        for part in &self.parts {
            let mut found = vec![0.0; part.function.rows()];
            part.function.values(&part.local(&x), &mut found);
            for (row, value) in part.rows.iter().zip(found) {
                if let Some(row) = *row {
                    values[row] = value;
                }
            }
        }
        self.each_between(|row, duration, linear, slopes| {
            let sum = |terms: [(usize, f64); 3]| terms.iter().map(|&(k, factor)| x[k] * factor).sum::<f64>();
            values[row] = sum(linear) + x[duration] * sum(slopes);
        });
        for (row, terms) in &self.rows.sums {
            values[*row] = terms.iter().map(|&(k, factor)| x[k] * factor).sum();
        }
        values.iter_mut().zip(&self.rows.scale).for_each(|(value, scale)| *value /= scale);
    }

    fn jacobian_structure(&self) -> Vec<[usize; 2]> {
        self.jacobian.clone()
    }

    fn jacobian(&self, x: &[f64], values: &mut [f64]) {
        let x = self.unscaled(x);
        let rest = in_parts(&self.parts, values, |part| part.asked, |part, out| part.jacobian(&x, out));
        let mut rest = rest.iter_mut();
        let mut put = |value: f64| rest.next().into_iter().for_each(|place| *place = value);
        self.each_between(|_, duration, linear, slopes| {
            linear.iter().for_each(|&(_, factor)| put(factor));
            slopes.iter().for_each(|&(_, factor)| put(factor * x[duration]));
            put(slopes.iter().map(|&(k, factor)| x[k] * factor).sum());
        });
        self.rows.sums.iter().flat_map(|(_, terms)| terms).for_each(|&(_, factor)| put(factor));
        for (value, &[row, variable]) in values.iter_mut().zip(&self.jacobian) {
            *value *= self.variables.scale[variable] / self.rows.scale[row];
        }
    }

    fn hessian_structure(&self) -> Vec<[usize; 2]> {
        self.hessian.clone()
    }

    fn hessian(&self, x: &[f64], weight: f64, multipliers: &[f64], values: &mut [f64]) {
        let x = self.unscaled(x);
        let multipliers: Vec<f64> =
            multipliers.iter().zip(&self.rows.scale).map(|(y, scale)| y / scale).collect();
        let size = |part: &Part<'_>| part.function.hessian_structure().len();
        let rest = in_parts(&self.parts, values, size, |part, out| part.hessian(&x, &multipliers, out));
        let mut rest = rest.iter_mut();
        let mut put = |value: f64| rest.next().into_iter().for_each(|place| *place = value);
        self.each_between(|row, _, _, slopes| {
            slopes.iter().for_each(|&(_, factor)| put(factor * multipliers[row]));
        });
        self.cost.each_second(&self.layout, &x, |_, value| put(weight * value));
        for (value, &[i, j]) in values.iter_mut().zip(&self.hessian) {
            *value *= self.variables.scale[i] * self.variables.scale[j];
        }
    }
}
