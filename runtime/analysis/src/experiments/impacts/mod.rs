//! Single impacts of a foot: velocities just after them against an impact map (thesis 4.2).
//!
//! Rows: the generalised velocities after the impact as the table names them (base: world axes, its angular velocity
//! in base axes; joints). Nominal: plastic and without slip; the striking foot alone touches the ground, other feet
//! are free to leave it. A foot with one point strikes as a point; one with an extent strikes flat with its whole
//! sole (six rows; three in the plane), which is said in the assumptions.
//!
//! With λ the impulse, `J` the rows of the contact: `M (v⁺ − v⁻) = Jᵀ λ`. `impact_restitution`: the normal velocities
//! after are −coefficient times those before (of a flat foot those of all its corners), the tangential ones zero.
//! `foot_slip`: where a foot that sticks would need a tangential impulse beyond friction times the normal one, it
//! slides and the impulse points against the sliding. `spin_friction`: a flat foot in space goes on turning about the
//! vertical through the middle of its sole where stopping it would need an impulse beyond radius · friction times the
//! normal one. All hold together.
//!
//! Inertial effects change the mass matrix: its columns are inverse dynamics of unit accelerations, and what changed
//! parameters add to them is the model's regressor at the same accelerations, exact since it is linear. A rotor's
//! inertia is added to the diagonal. `no_impact`: velocities do not jump.
mod load;
mod map;

use crate::experiments::experiment::sought_at;
use crate::experiments::{Experiment, Inertial, Row};
use crate::robot::InertialParameters;
use crate::robot::LinkInertias;
use crate::robot::Robot;
use crate::robot::calls::{ModelCalls, joint};
use crate::robot::feet::FootCalls;
use crate::robot::inertial_parameters::body_of;
use crate::robot::world::World;
use bipedc_effects::effect::{Acts, Effect, Evidence, Kind, Law, Location, Place, Simulation};
use map::Contact;

/// Ratio of neighbouring values from which the search of a limit starts,
const SEED_RATIO: f64 = 1.1;
/// and their number.
const MOST_SEEDS: usize = 32;

/// Impacts against a model; built by [`ImpactExperiment::read`].
pub struct ImpactExperiment<'a> {
    robot: Robot<'a>,
    calls: ModelCalls<'a>,
    foot: usize,
    foot_calls: FootCalls,
    flat: bool,
    inverse_dynamics: usize,
    regressor: usize,
    number: Vec<f64>,
    /// Logged configurations, `impacts × nq`.
    q: Vec<f64>,
    /// Velocities before, `impacts × nv`, as the model has them.
    before: Vec<f64>,
    /// Velocities after, `impacts × nv`, as the table has them.
    after: Vec<f64>,
    /// Rows of `v` that are measured after.
    measured: Vec<usize>,
    parameters: InertialParameters,
    rows: Vec<Row>,
    residual: Vec<Vec<f64>>,
    inertial: Vec<Inertial>,
    /// What was taken for granted.
    pub assumptions: Vec<String>,
}

/// What effects do to an impact.
struct Changed {
    world: World,
    parameters: Option<InertialParameters>,
    rotors: Vec<f64>,
    contact: Contact,
}

impl ImpactExperiment<'_> {
    fn changed(&self, effects: &[Effect]) -> Changed {
        let effects = &self.robot.with(effects);
        let mut changed = Changed {
            world: World::of(effects, self.robot.layout),
            parameters: Some(self.robot.link_inertias.change(effects))
                .filter(|c| c.iter().any(|x| *x != 0.0)),
            rotors: vec![0.0; self.calls.nv],
            contact: Contact::default(),
        };
        let first = self.calls.nv - self.robot.layout.joints.len();
        for effect in effects {
            match effect.kind.law {
                Law::Restitution => changed.contact.restitution = effect.value("coefficient"),
                Law::Slip => changed.contact.friction = effect.value("friction"),
                Law::SpinFriction => {
                    let slip = effects.iter().find(|other| other.kind.law == Law::Slip);
                    let friction = slip.unwrap_or(effect).value("friction");
                    changed.contact.spin = effect.value("radius") * friction;
                }
                Law::NoImpact => changed.contact.none = true,
                law => {
                    let index = joint(self.robot.layout, effect.location.joint.as_deref());
                    if let (Simulation::Inertia(of), Some(index)) = (effect.kind.simulation, index) {
                        changed.rotors[first + index] += effect.value(of);
                    }
                    // World and bodies have it already; finite torques and sensors of force do nothing in an instant.
                    debug_assert!(
                        law.acts() != Acts::Ground || matches!(law, Law::GroundSlope | Law::GroundCompliance)
                    );
                }
            }
        }
        changed
    }

    fn residual_under(&self, effects: &[Effect]) -> Vec<Vec<f64>> {
        let changed = self.changed(effects);
        let nv = self.calls.nv;
        let mut rows = vec![Vec::with_capacity(self.number.len()); self.rows.len()];
        for i in 0..self.number.len() {
            let predicted = self.logged(i, &self.velocity_after(i, &changed));
            for (row, k) in rows.iter_mut().zip(&self.measured) {
                row.push(self.after[i * nv + k] - predicted[*k]);
            }
        }
        rows
    }
}

impl Experiment for ImpactExperiment<'_> {
    fn rows(&self) -> &[Row] {
        &self.rows
    }
    fn time(&self) -> &[f64] {
        &self.number
    }
    fn residual(&self, row: usize) -> &[f64] {
        &self.residual[row]
    }
    fn response(&self, effects: &[Effect]) -> Vec<(usize, Vec<f64>)> {
        let changed = self.residual_under(effects);
        let rows = self.residual.iter().zip(changed).enumerate();
        rows.map(|(row, (nominal, changed))| {
            (row, nominal.iter().zip(changed).map(|(nominal, changed)| nominal - changed).collect::<Vec<_>>())
        })
        .filter(|(_, values)| values.iter().any(|v| *v != 0.0))
        .collect()
    }
    fn candidates(&self) -> Vec<(&'static Kind, Location)> {
        let links = self
            .robot
            .link_places(|body| self.inertial.iter().any(|i| i.columns.iter().any(|c| body_of(*c) == body)));
        sought_at(Evidence::Impacts, |kind| {
            let turns = self.flat && !self.robot.planar();
            match kind.place {
                Place::Link => links.clone(),
                Place::Joint => self.robot.joint_places().collect(),
                Place::Robot if kind.law == Law::SpinFriction && !turns => Vec::new(),
                Place::Robot => vec![Location::default()],
                Place::JointPair | Place::Sensor => Vec::new(),
            }
        })
    }
    /// A turning foot: what would hold it tells in which range its limit shows.
    fn seeds(&self, kind: &'static Kind, _location: &Location) -> Option<Vec<f64>> {
        if kind.law != Law::SpinFriction {
            return None;
        }
        let nominal = self.nominal();
        let held = (0..self.number.len()).filter_map(|i| self.turning(i, &nominal));
        let mut held: Vec<f64> = held.collect();
        held.sort_by(f64::total_cmp);
        let (least, most) = (held.get(held.len() / 20).copied()?, held.last().copied()?);
        let steps = (most / least).ln() / SEED_RATIO.ln();
        Some((0..=(steps as usize).min(MOST_SEEDS)).map(|k| most / SEED_RATIO.powi(k as i32 + 1)).collect())
    }
    fn inertial_count(&self) -> usize {
        self.parameters.len()
    }
    fn inertial_parameters(&self) -> &InertialParameters {
        &self.parameters
    }
    fn inertial(&self, row: usize) -> Option<&Inertial> {
        self.inertial.get(row)
    }
    fn link_inertias(&self) -> Option<&LinkInertias> {
        Some(self.robot.link_inertias)
    }
    fn signals(&self, _row: usize) -> Vec<(String, Vec<f64>)> {
        self.robot.joint_signals("position", &self.q, self.calls.nq)
    }
}
