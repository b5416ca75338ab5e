//! The motion along a schedule: joints at every sample, the zero moment point fed back into the pendulum.
use super::legs::Legs;
use super::track::{State, Stuck, Wish, advance};
use super::{Method, rest};
use crate::progress::Run;
use bipedc_analysis::walking::{
    Footstep, Instant, LEGS, Moved, Point, Schedule, Settings, Wrench, distribute, hull, pendulum,
};
use bipedc_effects::diagnostic::Diagnostic;

/// Rounds in which the zero moment point is fed back.
const ROUNDS: usize = 12;
/// Largest distance of the zero moment point from its reference that is good enough, m.
const GOOD: f64 = 2e-5;

/// A sample of a walk.
#[derive(Debug, Clone)]
pub struct Row {
    /// What was wished.
    pub instant: Instant,
    /// What does it.
    pub state: State,
    /// Centre of mass as wished, m.
    pub center: [Moved; 3],
    /// Of the whole robot, m (4.42).
    pub zmp: Point,
    /// Divergent component of motion x + ẋ / ω, m.
    pub divergent: Point,
    /// Efforts of the joints in the order of the model.
    pub effort: Vec<f64>,
    /// Of the ground on each foot, about the world's origin.
    pub wrenches: [Wrench; 2],
    /// Counterclockwise, m.
    pub support: Vec<Point>,
}

/// A motion.
pub struct Motion {
    /// One per sample.
    pub rows: Vec<Row>,
    /// Rounds of the feedback.
    pub rounds: usize,
    /// Largest distance of the zero moment point from its reference, m.
    pub zmp_error: Option<f64>,
    /// Not interrupted.
    pub complete: bool,
}

/// No posture does what is wished.
pub struct Lost {
    /// s
    pub time: f64,
    /// Index of the phase.
    pub phase: usize,
    /// Why.
    pub why: Stuck,
}

impl Legs {
    /// Joint motions along a schedule.
    ///
    /// # Errors
    /// No posture does what is wished.
    pub fn follow(
        &self,
        method: Method,
        schedule: &Schedule,
        settings: &Settings,
        run: &Run<'_>,
    ) -> Result<Motion, Lost> {
        let instants: Vec<Instant> = (0..schedule.samples()).map(|k| schedule.instant(k)).collect();
        let mut states = Vec::new();
        let (mut rounds, mut zmp_error) = (0, None);
        let mut centers = match method {
            Method::Static => instants.iter().map(|instant| instant.weight).collect(),
            _ => self.above(&instants, &vec![[0.0; 2]; instants.len()], schedule, settings).0,
        };
        let mut correction = vec![[0.0; 2]; instants.len()];
        loop {
            let wishes = wishes(&instants, &centers, settings);
            let stage = if rounds == 0 { "inverse kinematics" } else { "zero moment point" };
            states = run
                .progress
                .counted(stage, |advance| self.along(&wishes, &states, schedule.sample, advance))?;
            if method != Method::Dynamic {
                break;
            }
            let reference = self.above(&instants, &correction, schedule, settings).1;
            let mut error: f64 = 0.0;
            for k in 0..instants.len() {
                let State { q, v, a } = &states[k];
                let zmp = self.kinematics.zero_moment_point([q, v, a]);
                for i in 0..2 {
                    // What the reference is without the feedback's own part, so that bumps of rest are allowed.
                    let missed = zmp[i] - (reference[k][i] + correction[k][i]);
                    error = error.max(missed.abs());
                    correction[k][i] += missed;
                }
            }
            (rounds, zmp_error) = (rounds + 1, Some(error));
            if error < GOOD || rounds == ROUNDS || (run.stop)() {
                break;
            }
            centers = self.above(&instants, &correction, schedule, settings).0;
        }
        let complete = !(run.stop)();
        let wishes = wishes(&instants, &centers, settings);
        let rows =
            wishes.into_iter().zip(states).map(|(wish, state)| self.row(wish, state, settings)).collect();
        Ok(Motion { rows, rounds, zmp_error, complete })
    }

    /// Centre of mass of the pendulum whose zero moment point is the reference less a correction, and that zero moment point.
    fn above(
        &self,
        instants: &[Instant],
        correction: &[Point],
        schedule: &Schedule,
        settings: &Settings,
    ) -> (Vec<[Moved; 2]>, Vec<Point>) {
        let omega = (self.kinematics.gravity() / settings.com_height).sqrt();
        let along = |i: usize| {
            let zmp: Vec<f64> = instants.iter().zip(correction).map(|(t, c)| t.weight[i][0] - c[i]).collect();
            pendulum(&zmp, schedule.sample, omega, rest(schedule))
        };
        let (x, y) = (along(0), along(1));
        let centers = x.0.into_iter().zip(y.0).map(|(x, y)| [x, y]).collect();
        (centers, x.1.into_iter().zip(y.1).map(|(x, y)| [x, y]).collect())
    }

    /// States that do one wish after the other; `near` are those of the round before, if any.
    fn along(
        &self,
        wishes: &[Wish],
        near: &[State],
        sample: f64,
        progress: &dyn Fn(f64),
    ) -> Result<Vec<State>, Lost> {
        let mut states: Vec<State> = Vec::with_capacity(wishes.len());
        for (k, wish) in wishes.iter().enumerate() {
            let mut q = match (near.get(k), states.last()) {
                (Some(near), _) => near.q.clone(),
                (None, Some(State { q, v, a })) => {
                    // (6.49), with the drift that this leaves taken out by (6.52).
                    let mut q = q.clone();
                    let step: Vec<f64> =
                        v.iter().zip(a).map(|(v, a)| sample * (v + 0.5 * sample * a)).collect();
                    advance(&mut q, &step);
                    q
                }
                (None, None) => self.posture.clone(),
            };
            let lost = |why| Lost { time: wish.instant.time, phase: wish.instant.phase, why };
            let here = self.reach(&mut q, wish).map_err(lost)?;
            let [v, a] = self.rates(&q, &here, wish).map_err(lost)?;
            states.push(State { q, v, a });
            if k % 64 == 0 {
                progress(k as f64 / wishes.len() as f64);
            }
        }
        Ok(states)
    }

    fn row(&self, wish: Wish, state: State, settings: &Settings) -> Row {
        let Wish { instant, center } = wish;
        let State { q, v, a } = &state;
        let zmp = self.kinematics.zero_moment_point([q, v, a]);
        let omega = (self.kinematics.gravity() / settings.com_height).sqrt();
        let divergent = [0, 1].map(|i| center[i][0] + center[i][1] / omega);
        let places = instant.soles.map(|sole| [sole[0][0], sole[1][0], sole[2][0]]);
        let prints = [0, 1].map(|k| self.corners(k, [places[k][0], places[k][1]], instant.soles[k][3][0]));
        let standing = (0..2).filter(|k| instant.contact[*k]).flat_map(|k| prints[k].iter().copied());
        let support = hull(&standing.collect::<Vec<_>>());
        let forces = self.kinematics.inverse_dynamics([q, v, a]);
        let shares = shares(&instant, places, zmp);
        let wrenches = distribute(&self.ground_wrench(q, &forces), places, shares, self.sole_arm());
        let effort = self.efforts(q, &forces, &wrenches);
        Row { instant, center, zmp, divergent, effort, wrenches, support, state }
    }

    /// What the ground has to give for these forces on the base: about the world's origin.
    fn ground_wrench(&self, q: &[f64], forces: &[f64]) -> Wrench {
        use nalgebra::Vector3;
        let turn = super::kinematics::root_rotation(q);
        let force = turn * Vector3::from_column_slice(&forces[..3]);
        let moment =
            turn * Vector3::from_column_slice(&forces[3..6]) + Vector3::new(q[0], q[1], q[2]).cross(&force);
        [force.x, force.y, force.z, moment.x, moment.y, moment.z]
    }

    /// `D q̈ + H − Σ J_kᵀ w_k` on the joints.
    fn efforts(&self, q: &[f64], forces: &[f64], wrenches: &[Wrench; 2]) -> Vec<f64> {
        use nalgebra::Vector3;
        let here = self.kinematics.posture(q, &self.soles, &self.heading);
        let mut left = forces.to_vec();
        for (k, wrench) in wrenches.iter().enumerate() {
            let force = Vector3::from_column_slice(&wrench[..3]);
            let moment = Vector3::from_column_slice(&wrench[3..]) - here.places[k].cross(&force);
            for (column, x) in left.iter_mut().enumerate() {
                let linear = here.jacobian.fixed_view::<3, 1>(6 * k, column);
                let angular = here.jacobian.fixed_view::<3, 1>(6 * k + 3, column);
                *x -= linear.dot(&force) + angular.dot(&moment);
            }
        }
        self.joints.iter().map(|joint| left[joint.column]).collect()
    }

    /// Says where no posture was found.
    pub(super) fn lost(&self, lost: &Lost, schedule: &Schedule, steps: &[Footstep]) -> Diagnostic {
        let phase = &schedule.phases[lost.phase];
        let place = match phase.step {
            Some(step) => {
                format!("step {} ({} foot), {}", step + 1, LEGS[steps[step].foot], phase.kind.name())
            }
            None => phase.kind.name().to_owned(),
        };
        let why = match (&lost.why.limits[..], &lost.why.stretched) {
            ([(joint, limit), ..], _) => {
                let joint = &self.joints[*joint];
                format!("`{}` is at its limit {limit:.4} {}", joint.name, joint.units()[0])
            }
            ([], Some((joint, angle))) => {
                let joint = &self.joints[*joint];
                format!("`{}` is stretched at {angle:.4} {}", joint.name, joint.units()[0])
            }
            _ => "no joint can do more".to_owned(),
        };
        let message =
            format!("{place}, at {:.3} s: {why}, {:.4} m or rad are missing", lost.time, lost.why.error);
        Diagnostic::error(message)
            .help("shorter steps, a lower `com_height` or a smaller `step_height` take less")
    }
}

fn wishes(instants: &[Instant], centers: &[[Moved; 2]], settings: &Settings) -> Vec<Wish> {
    let height = [settings.com_height, 0.0, 0.0];
    let wish = |(instant, center): (&Instant, &[Moved; 2])| Wish {
        instant: instant.clone(),
        center: [center[0], center[1], height],
    };
    instants.iter().zip(centers).map(wish).collect()
}

/// Parts of the load on both feet: where the zero moment point is on the way between them.
fn shares(instant: &Instant, places: [[f64; 3]; 2], zmp: Point) -> [f64; 2] {
    let [right, left] = instant.contact;
    if !(right && left) {
        return [f64::from(right), f64::from(left)];
    }
    let way = [0, 1].map(|i| places[1][i] - places[0][i]);
    let along: f64 = (0..2).map(|i| way[i] * (zmp[i] - places[0][i])).sum();
    let part = (along / (way[0] * way[0] + way[1] * way[1])).clamp(0.0, 1.0);
    [1.0 - part, part]
}
