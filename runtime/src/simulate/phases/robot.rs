//! A robot with the phases of its description.
use super::integrate::{Phased, Violation};
use super::support::{Load, Row, before_line, inside};
use crate::compare::BaseKind;
use crate::diagnose::Foot;
use crate::diagnostic::Diagnostic;
use crate::model::{Argument, Model, State};
use crate::simulate::mechanics::rotate;
use std::cell::RefCell;

/// When a phase is over.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Ending {
    /// One of these contact points (indices of the model's) reaches the ground.
    Touch(Vec<usize>),
    /// The ground no longer pushes on this foot.
    Release(usize),
    /// The centre of pressure of this foot reaches these of its points: it begins to tip about them.
    Tip(usize, Vec<usize>),
    /// Nothing ends it.
    Never,
}

/// One phase, its functions by name.
#[derive(Debug, Clone, PartialEq)]
pub struct PhaseSpec {
    /// As in the description.
    pub name: String,
    /// `constrained_dynamics_of_…`
    pub dynamics: String,
    /// Its rows after the accelerations.
    pub rows: Vec<Row>,
    /// Contact points that stand.
    pub standing: Vec<usize>,
    /// When it ends.
    pub ending: Ending,
    /// `impact_map_of_…` and its rows after the velocities; none: velocities do not jump.
    pub impact: Option<(String, Vec<Row>)>,
    /// Left and right exchange their roles.
    pub relabel: bool,
    /// Index of the phase that follows.
    pub next: usize,
}

/// Which assumptions are checked, and with which numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Assumptions {
    /// Coulomb's coefficient; infinite: feet never slip.
    pub friction: f64,
    /// Depth to which points in the air may pass through the ground, m; infinite: scuffing is allowed (walkers without
    /// knees do it).
    pub scuffing: f64,
    /// Feet may not pull.
    pub pushing: bool,
    /// A foot lands only where it is at least this far ahead (along x) of what stands, m; minus infinity: anywhere. With it
    /// a walker without knees passes its swing foot through the ground beside the other.
    pub shortest_step: f64,
}

impl Default for Assumptions {
    fn default() -> Self {
        Self { friction: f64::INFINITY, scuffing: 1e-6, pushing: true, shortest_step: f64::NEG_INFINITY }
    }
}

/// Generalised forces from phase, time, `q` and `v`, written in the order of `v`.
pub type Torque<'a> = &'a dyn Fn(usize, f64, &[f64], &[f64], &mut [f64]);

/// A robot that walks through its phases (4.23).
pub struct PhasedRobot<'a> {
    model: &'a dyn Model<f64>,
    base: BaseKind,
    feet: &'a [Foot],
    phases: Vec<(PhaseSpec, Functions)>,
    distances: usize,
    positions: usize,
    relabelled: Option<[usize; 2]>,
    assumptions: Assumptions,
    torque: Torque<'a>,
    work: RefCell<Work>,
}

/// Indices of a phase's functions.
#[derive(Debug, Clone, Copy)]
struct Functions {
    dynamics: usize,
    impact: Option<usize>,
}

#[derive(Debug, Default)]
struct Work {
    tau: Vec<f64>,
    out: Vec<f64>,
    points: Vec<f64>,
}

impl<'a> PhasedRobot<'a> {
    /// Looks the functions up.
    ///
    /// # Errors
    /// The model lacks one of them, or there is no phase.
    pub fn new(
        model: &'a dyn Model<f64>,
        base: BaseKind,
        feet: &'a [Foot],
        phases: Vec<PhaseSpec>,
        assumptions: Assumptions,
        torque: Torque<'a>,
    ) -> Result<Self, Diagnostic> {
        let find = |name: &str| {
            model.function(name).ok_or_else(|| {
                Diagnostic::error(format!("the model has no function `{name}`"))
                    .help("add it to what is generated from the description")
            })
        };
        if phases.is_empty() {
            return Err(
                Diagnostic::error("the robot has no phases").help("add [[phase]] tables to biped.toml")
            );
        }
        let relabelled = if phases.iter().any(|phase| phase.relabel) {
            Some([find("relabelled_configuration")?, find("relabelled_velocity")?])
        } else {
            None
        };
        let functions = |phase: PhaseSpec| {
            let impact = phase.impact.as_ref().map(|(name, _)| find(name)).transpose()?;
            let found = Functions { dynamics: find(&phase.dynamics)?, impact };
            Ok((phase, found))
        };
        Ok(Self {
            model,
            base,
            feet,
            distances: find("contact_distances")?,
            positions: find("contact_positions")?,
            relabelled,
            phases: phases.into_iter().map(functions).collect::<Result<_, Diagnostic>>()?,
            assumptions,
            torque,
            work: RefCell::new(Work::default()),
        })
    }

    fn split<'x>(&self, x: &'x [f64]) -> (&'x [f64], &'x [f64]) {
        x.split_at(self.model.nq())
    }

    fn call(&self, function: usize, state: &State<'_, f64>, out: &mut Vec<f64>) {
        let size = self.model.signature(function).map_or(0, |s| s.rows * s.columns);
        out.clear();
        out.resize(size, 0.0);
        // Lengths come from the model itself; a refusal would be a fault of this crate, seen in the numbers.
        if self.model.evaluate(function, state, out).is_err() {
            out.fill(f64::NAN);
        }
    }

    /// Accelerations, then the forces of the rows.
    fn dynamics(&self, phase: usize, time: f64, x: &[f64], work: &mut Work) {
        let (q, v) = self.split(x);
        work.tau.clear();
        work.tau.resize(v.len(), 0.0);
        (self.torque)(phase, time, q, v, &mut work.tau);
        let state = State::new().with(Argument::Q, q).with(Argument::V, v).with(Argument::Tau, &work.tau);
        self.call(self.phases[phase].1.dynamics, &state, &mut work.out);
    }

    /// Heights of the contact points, m.
    pub fn heights(&self, q: &[f64]) -> Vec<f64> {
        let mut out = Vec::new();
        self.call(self.distances, &State::new().with(Argument::Q, q), &mut out);
        out
    }

    /// Forces of a phase's rows, N and N m.
    pub fn forces(&self, phase: usize, time: f64, x: &[f64]) -> Vec<f64> {
        let mut work = Work::default();
        self.dynamics(phase, time, x, &mut work);
        work.out.split_off(self.model.nv())
    }

    /// Horizontal places of the points of a foot, m.
    fn places(&self, q: &[f64], points: &[usize], work: &mut Work) -> Vec<[f64; 2]> {
        self.call(self.positions, &State::new().with(Argument::Q, q), &mut work.points);
        let planar = self.base == BaseKind::Planar;
        let place = |&i: &usize| {
            if planar { [work.points[i], 0.0] } else { [work.points[2 * i], work.points[2 * i + 1]] }
        };
        points.iter().map(place).collect()
    }

    /// How far landing points are behind the shortest step, m; negative: a landing counts.
    fn behind(&self, q: &[f64], landing: &[usize], standing: &[usize], work: &mut Work) -> f64 {
        if self.assumptions.shortest_step == f64::NEG_INFINITY {
            return f64::NEG_INFINITY;
        }
        let mut foremost = |points: &[usize]| {
            let places = self.places(q, points, work);
            places.iter().map(|place| place[0]).fold(f64::NEG_INFINITY, f64::max)
        };
        self.assumptions.shortest_step - (foremost(landing) - foremost(standing))
    }

    /// Points of a foot that stand.
    fn sole(&self, foot: usize, standing: &[usize]) -> Vec<usize> {
        let first: usize = self.feet[..foot].iter().map(|f| f.corners.len()).sum();
        let own = first..first + self.feet[foot].corners.len();
        standing.iter().copied().filter(|point| own.contains(point)).collect()
    }

    /// Centre of pressure of a flat foot, its points and their middle.
    fn pressure(
        &self,
        q: &[f64],
        load: &Load,
        sole: &[usize],
        work: &mut Work,
    ) -> ([f64; 2], Vec<[f64; 2]>, [f64; 2]) {
        let points = self.places(q, sole, work);
        let count = points.len().max(1) as f64;
        let middle = [0, 1].map(|i| points.iter().map(|p| p[i]).sum::<f64>() / count);
        let relative = load.pressure();
        ([middle[0] + relative[0], middle[1] + relative[1]], points, middle)
    }

    /// Forces or impulses of the rows against the laws of contact.
    fn contact_violation(
        &self,
        phase: &str,
        time: f64,
        rows: &[Row],
        forces: &[f64],
        impact: bool,
    ) -> Option<Violation> {
        let (unit, kind) = if impact { ("N s", "impulse") } else { ("N", "force") };
        for (index, foot) in self.feet.iter().enumerate() {
            if !rows.iter().any(|row| row.foot == index) {
                continue;
            }
            let load = Load::of(index, rows, forces);
            let violation = |quantity: &str, value, limit, meaning| {
                let quantity = format!("{quantity} {kind} on {}", foot.name);
                Some(Violation { phase: phase.to_owned(), time, quantity, value, limit, unit, meaning })
            };
            if self.assumptions.pushing && load.force[2] < 0.0 {
                return violation("normal", load.force[2], 0.0, "the ground would have to pull the foot");
            }
            let tangential = load.force[0].hypot(load.force[1]);
            let limit = self.assumptions.friction * load.force[2].max(0.0);
            if self.assumptions.friction.is_finite() && tangential > limit {
                return violation("tangential", tangential, limit, "the foot slips");
            }
        }
        None
    }
}

impl Phased for PhasedRobot<'_> {
    fn derivative(&self, phase: usize, time: f64, x: &[f64], out: &mut [f64]) {
        let mut work = self.work.borrow_mut();
        self.dynamics(phase, time, x, &mut work);
        let (q, v) = self.split(x);
        let (rates, accelerations) = out.split_at_mut(q.len());
        accelerations.copy_from_slice(&work.out[..v.len()]);
        let joints = self.model.joints();
        rates[q.len() - joints..].copy_from_slice(&v[v.len() - joints..]);
        match self.base {
            BaseKind::Fixed => {}
            BaseKind::Planar => rates[..3].copy_from_slice(&v[..3]),
            BaseKind::Floating => {
                let turn = [q[3], q[4], q[5], q[6]];
                rates[..3].copy_from_slice(&rotate(turn, [v[0], v[1], v[2]]));
                let [x, y, z, w] = turn;
                let [a, b, c] = [0.5 * v[3], 0.5 * v[4], 0.5 * v[5]];
                rates[3] = w * a + y * c - z * b;
                rates[4] = w * b + z * a - x * c;
                rates[5] = w * c + x * b - y * a;
                rates[6] = -x * a - y * b - z * c;
            }
        }
    }

    fn guard(&self, phase: usize, time: f64, x: &[f64]) -> f64 {
        let spec = &self.phases[phase].0;
        let (q, v) = self.split(x);
        let mut work = self.work.borrow_mut();
        match &spec.ending {
            Ending::Never => f64::INFINITY,
            Ending::Touch(points) => {
                self.call(self.distances, &State::new().with(Argument::Q, q), &mut work.points);
                let height = points.iter().map(|&point| work.points[point]).fold(f64::INFINITY, f64::min);
                height.max(self.behind(q, points, &spec.standing, &mut work))
            }
            Ending::Release(foot) => {
                self.dynamics(phase, time, x, &mut work);
                Load::of(*foot, &spec.rows, &work.out[v.len()..]).force[2]
            }
            Ending::Tip(foot, edge) => {
                self.dynamics(phase, time, x, &mut work);
                let load = Load::of(*foot, &spec.rows, &work.out[v.len()..]);
                let sole = self.sole(*foot, &spec.standing);
                let (place, _, middle) = self.pressure(q, &load, &sole, &mut work);
                let edge = self.places(q, edge, &mut work);
                before_line(place, &edge, middle, self.base == BaseKind::Planar)
            }
        }
    }

    fn violation(&self, phase: usize, time: f64, x: &[f64]) -> Option<Violation> {
        let spec = &self.phases[phase].0;
        let (q, v) = self.split(x);
        let mut work = self.work.borrow_mut();
        self.dynamics(phase, time, x, &mut work);
        let forces = work.out[v.len()..].to_vec();
        if let Some(found) = self.contact_violation(&spec.name, time, &spec.rows, &forces, false) {
            return Some(found);
        }
        for (index, foot) in self.feet.iter().enumerate() {
            let load = Load::of(index, &spec.rows, &forces);
            if !load.flat {
                continue;
            }
            let sole = self.sole(index, &spec.standing);
            let (place, points, _) = self.pressure(q, &load, &sole, &mut work);
            let value = inside(place, &points, self.base == BaseKind::Planar);
            if value < -1e-9 {
                let quantity = format!("distance of the centre of pressure from the edge of {}", foot.name);
                let phase = spec.name.clone();
                let meaning = "the foot tips";
                return Some(Violation { phase, time, quantity, value, limit: 0.0, unit: "m", meaning });
            }
        }
        if self.assumptions.scuffing.is_finite() {
            self.call(self.distances, &State::new().with(Argument::Q, q), &mut work.points);
            let air = work.points.iter().enumerate().filter(|(point, _)| !spec.standing.contains(point));
            if let Some((_, &value)) = air.min_by(|a, b| a.1.total_cmp(b.1))
                && value < -self.assumptions.scuffing
            {
                let quantity = "height of the swing foot".to_owned();
                let (phase, limit) = (spec.name.clone(), -self.assumptions.scuffing);
                let meaning = "the swing foot scuffs";
                return Some(Violation { phase, time, quantity, value, limit, unit: "m", meaning });
            }
        }
        None
    }

    fn change(&self, phase: usize, time: f64, x: &mut [f64]) -> Result<usize, Violation> {
        let (spec, functions) = &self.phases[phase];
        let nq = self.model.nq();
        let mut out = Vec::new();
        if let (Some(impact), Some((_, rows))) = (functions.impact, &spec.impact) {
            let (q, v) = x.split_at_mut(nq);
            self.call(impact, &State::new().with(Argument::Q, q).with(Argument::V, v), &mut out);
            v.copy_from_slice(&out[..v.len()]);
            if let Some(found) = self.contact_violation(&spec.name, time, rows, &out[v.len()..], true) {
                return Err(found);
            }
        }
        if let (true, Some([configuration, velocity])) = (spec.relabel, self.relabelled) {
            let (q, v) = x.split_at_mut(nq);
            self.call(configuration, &State::new().with(Argument::Q, q), &mut out);
            q.copy_from_slice(&out);
            self.call(velocity, &State::new().with(Argument::V, v), &mut out);
            v.copy_from_slice(&out);
        }
        Ok(spec.next)
    }
}
