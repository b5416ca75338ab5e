//! The regression: which unknowns act in which rows, and the numbers of a batch of samples.
use super::triangle::Triangle;
use super::unknowns::{BaseSet, ColumnSource, Extra, ExtraTorque, Summand, Unknown, plain};
use crate::experiments::{Channel as Kind, Experiment, Row};
use crate::measure::{Direction, Directions};
use crate::robot::{Batch, JointLayout};
use bipedc_effects::random::Random;
use nalgebra::DVector;

/// The base regressor of many states.
///
/// A program in process implements it; so may anything else that evaluates a model.
pub trait BatchRegressor: Sync {
    /// Length of one configuration.
    fn nq(&self) -> usize;
    /// Length of one velocity: the number of rows.
    fn nv(&self) -> usize;
    /// Per row the columns that are not zero in every state.
    fn pattern(&self) -> &[Vec<usize>];
    /// Writes, for each row and each column of its pattern, the values of all samples one after the other.
    fn evaluate(&self, batch: &Batch<'_>, out: &mut [f64]);
}

/// A row of the equations of motion that is measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Joint, or `base/linear/x`, ….
    pub name: String,
    /// N m or N.
    pub unit: &'static str,
    /// Index in `v`.
    pub row: usize,
    /// Index of the joint; rows of the base have none.
    pub joint: Option<usize>,
    /// Unknowns that act here.
    pub places: Vec<usize>,
    /// Where their numbers come from.
    sources: Vec<ColumnSource>,
}

/// What is estimated from which rows.
pub struct Design<'a> {
    /// Joints and base.
    pub layout: &'a JointLayout,
    /// What joints add.
    pub extras: Vec<Extra>,
    /// Their torques, in the same order.
    torques: Vec<ExtraTorque>,
    /// The joints whose direction they depend on, in the same order.
    directed: Vec<Option<(usize, usize)>>,
    /// Columns.
    pub unknowns: Vec<Unknown>,
    /// Rows.
    pub channels: Vec<Channel>,
    /// None where rows come from an experiment in memory.
    regressor: Option<&'a dyn BatchRegressor>,
    /// Where the values of a row begin among those of a batch.
    starts: Vec<usize>,
}

/// Columns of this part of their length are sums of others.
const DEPENDENT: f64 = 1e-9;
/// Random states on which grouping is decided, per unknown.
const STATES: usize = 4;

impl<'a> Design<'a> {
    /// The regression of `rows` (indices into `v`) on base parameters and extras; extras that act exactly as base
    /// parameters do are grouped with them.
    pub fn new(
        layout: &'a JointLayout,
        base: &BaseSet,
        regressor: &'a dyn BatchRegressor,
        extras: Vec<Extra>,
        rows: &[usize],
    ) -> Self {
        let pattern = regressor.pattern();
        let starts = pattern
            .iter()
            .scan(0, |sum, row| {
                *sum += row.len();
                Some(*sum - row.len())
            })
            .collect();
        let unknowns = plain(base, &extras, layout);
        let regressor = Some(regressor);
        let torques = extras.iter().map(|extra| extra.torque()).collect();
        let directed = extras.iter().map(Extra::direction).collect();
        let mut design =
            Self { layout, extras, torques, directed, unknowns, channels: Vec::new(), regressor, starts };
        design.channels = rows.iter().map(|&row| design.channel(row)).collect();
        design.group(rows);
        design
    }

    /// The regression of the force and moment rows of an experiment in memory, such as a log of a free robot with forces
    /// at its feet; [`Channel::row`] is the row of the experiment then.
    pub fn of_table(layout: &'a JointLayout, base: &BaseSet, experiment: &dyn Experiment) -> Self {
        let unknowns = plain(base, &[], layout);
        let channel = |(row, of): (usize, &Row)| {
            if !matches!(of.channel, Kind::BaseForce | Kind::BaseMoment) {
                return None;
            }
            let inertial = experiment.inertial(row)?;
            let acts = |k: &usize| base.leading(*k).is_some_and(|column| inertial.columns.contains(&column));
            let places: Vec<usize> = (0..unknowns.len()).filter(acts).collect();
            let sources = places.iter().map(|&k| ColumnSource::Base(k)).collect();
            Some(Channel { name: of.name.clone(), unit: of.unit, row, joint: None, places, sources })
        };
        let channels = experiment.rows().iter().enumerate().filter_map(channel).collect();
        Self {
            layout,
            extras: Vec::new(),
            torques: Vec::new(),
            directed: Vec::new(),
            unknowns,
            channels,
            regressor: None,
            starts: Vec::new(),
        }
    }

    fn pattern(&self) -> &[Vec<usize>] {
        self.regressor.map_or(&[], |regressor| regressor.pattern())
    }

    /// Lengths of a configuration and of a velocity.
    fn widths(&self) -> (usize, usize) {
        let (base, joints) = (self.layout.base, self.layout.joints.len());
        (base.nq() + joints, base.nv() + joints)
    }

    fn channel(&self, row: usize) -> Channel {
        let nb = self.layout.base.nv();
        let joint = row.checked_sub(nb);
        let pattern = &self.pattern()[row];
        let acts = |unknown: &Unknown| match unknown.source {
            ColumnSource::Base(column) => pattern.contains(&column),
            ColumnSource::Extra(k) => {
                joint.is_some_and(|j| self.extras[k].joint == j || self.extras[k].other == j)
            }
        };
        let places: Vec<usize> = (0..self.unknowns.len()).filter(|&k| acts(&self.unknowns[k])).collect();
        let (name, unit) = match joint {
            Some(j) => (self.layout.joints[j].name.clone(), self.layout.joints[j].unit()),
            None => base_row(self.layout, row),
        };
        Channel {
            name,
            unit,
            row,
            joint,
            sources: places.iter().map(|&k| self.unknowns[k].source).collect(),
            places,
        }
    }

    /// Groups extras that act as base parameters do.
    fn group(&mut self, rows: &[usize]) {
        let total = self.probe();
        let (factor, lengths) = (total.matrix(), total.lengths());
        let mut dropped = Vec::new();
        for k in 0..self.unknowns.len() {
            let ColumnSource::Extra(extra) = self.unknowns[k].source else { continue };
            let kept: Vec<usize> = (0..k).filter(|i| !dropped.contains(i)).collect();
            let columns = factor.select_columns(&kept);
            let target: DVector<f64> = factor.column(k).into_owned();
            let Some(sum) = columns.clone().svd(true, true).solve(&target, 1e-12).ok() else { continue };
            if (&columns * &sum - &target).norm() > DEPENDENT * lengths[k].max(f64::MIN_POSITIVE) {
                continue;
            }
            dropped.push(k);
            for (&i, &coefficient) in kept.iter().zip(sum.iter()) {
                // A sum of a few lengths and ones: what is this small is rounding.
                if coefficient.abs() > 1e-9 {
                    let rounded = (coefficient * 1e9).round() / 1e9;
                    let name = format!(" {} {}", signed(rounded), self.unknowns[k].name);
                    self.unknowns[i].sum.push((Summand::Extra(extra), rounded));
                    self.unknowns[i].name.push_str(&name);
                }
            }
        }
        let mut index = 0;
        self.unknowns.retain(|_| {
            index += 1;
            !dropped.contains(&(index - 1))
        });
        self.channels = rows.iter().map(|&row| self.channel(row)).collect();
    }

    /// The regression at random states, without measurements.
    fn probe(&self) -> Triangle {
        let count = STATES * self.unknowns.len().max(8);
        let (nq, nv) = self.widths();
        let mut random = Random::new(0x1dea);
        let mut q: Vec<f64> = (0..count * nq).map(|_| 1.5 * random.symmetric()).collect();
        if self.layout.base == crate::robot::BaseKind::Floating {
            for q in q.chunks_exact_mut(nq) {
                let length = q[3..7].iter().map(|x| x * x).sum::<f64>().sqrt();
                q[3..7].iter_mut().for_each(|x| *x /= length);
            }
        }
        let v: Vec<f64> = (0..count * nv).map(|_| 2.0 * random.symmetric()).collect();
        let a: Vec<f64> = (0..count * nv).map(|_| 5.0 * random.symmetric()).collect();
        let batch = Batch { count, q: &q, v: &v, a: &a };
        let mut work = Work::default();
        self.evaluate(&batch, &mut work);
        let mut total = Triangle::new(self.unknowns.len());
        for channel in 0..self.channels.len() {
            let mut part = Triangle::new(self.channels[channel].places.len());
            let mut rows = Vec::new();
            self.rows(channel, &batch, None, &work, &mut rows);
            rows.resize(rows.len() + count, 0.0);
            part.absorb(count, &mut rows);
            total.merge(&part, &self.channels[channel].places, 1.0);
        }
        total
    }

    /// Evaluates the base regressor of a batch.
    pub fn evaluate(&self, batch: &Batch<'_>, work: &mut Work) {
        let entries: usize = self.pattern().iter().map(Vec::len).sum();
        work.entries.resize(entries * batch.count, 0.0);
        if let Some(regressor) = self.regressor {
            regressor.evaluate(batch, &mut work.entries);
        }
    }

    /// The directions that extras depend on, for a log in which joints reach these speeds.
    pub fn directions(&self, fastest: &[f64]) -> Directions {
        let pairs = self.directed.iter().flatten().copied().collect();
        Directions { pairs, fastest: fastest.to_vec() }
    }

    /// Which of [`Self::directions`] act on a channel.
    pub fn directions_of(&self, channel: usize) -> impl Iterator<Item = usize> {
        self.channels[channel].sources.iter().filter_map(|source| match source {
            ColumnSource::Extra(k) => self.direction_of(*k),
            ColumnSource::Base(_) => None,
        })
    }

    /// Index of an extra's direction among [`Self::directions`].
    fn direction_of(&self, extra: usize) -> Option<usize> {
        self.directed[extra].map(|_| self.directed[..extra].iter().flatten().count())
    }

    /// The columns of a channel for an evaluated batch, without the right-hand side. `directions`: as a recording has them, and
    /// the batch's first sample there; without them signs are sharp.
    pub fn rows(
        &self,
        channel: usize,
        batch: &Batch<'_>,
        directions: Option<(&[Direction], usize)>,
        work: &Work,
        out: &mut Vec<f64>,
    ) {
        let channel = &self.channels[channel];
        let (nb, nv, count) = (self.layout.base.nv(), self.widths().1, batch.count);
        out.clear();
        for source in &channel.sources {
            match *source {
                ColumnSource::Base(column) => {
                    let pattern = &self.pattern()[channel.row];
                    let place = pattern.iter().position(|c| *c == column).unwrap_or(0);
                    let start = (self.starts[channel.row] + place) * count;
                    out.extend_from_slice(&work.entries[start..start + count]);
                }
                ColumnSource::Extra(k) => {
                    if let (Some(at), Some((directions, first))) = (self.direction_of(k), directions)
                        && let Some(direction) = directions.get(at)
                    {
                        out.extend_from_slice(&direction.sign[first..first + count]);
                        continue;
                    }
                    let (torque, joint) = (&self.torques[k], channel.joint.unwrap_or(usize::MAX));
                    let joints = |values: &'_ [f64], i: usize| -> std::ops::Range<usize> {
                        debug_assert!(values.len() >= (i + 1) * nv);
                        i * nv + nb..(i + 1) * nv
                    };
                    out.extend((0..count).map(|i| {
                        let range = joints(batch.v, i);
                        torque.on(joint, &batch.v[range.clone()], &batch.a[range]).unwrap_or(0.0)
                    }));
                }
            }
        }
    }

    /// The matrix that makes unknowns of inertial parameters and extras: rows of (part, factor).
    pub fn sums(&self) -> impl Iterator<Item = &[(Summand, f64)]> {
        self.unknowns.iter().map(|unknown| unknown.sum.as_slice())
    }
}

fn signed(x: f64) -> String {
    let size = if x.abs() == 1.0 { String::new() } else { format!(" {}", x.abs()) };
    format!("{}{size}", if x < 0.0 { "-" } else { "+" })
}

fn base_row(layout: &JointLayout, row: usize) -> (String, &'static str) {
    const FLOATING: [&str; 6] = ["linear/x", "linear/y", "linear/z", "angular/x", "angular/y", "angular/z"];
    const PLANAR: [&str; 3] = ["x", "z", "pitch"];
    let planar = layout.base == crate::robot::BaseKind::Planar;
    let (name, linear) = if planar { (PLANAR[row], row < 2) } else { (FLOATING[row], row < 3) };
    (format!("base/{name}"), if linear { "N" } else { "N m" })
}

/// Memory that batches share.
#[derive(Debug, Default)]
pub struct Work {
    entries: Vec<f64>,
}
