//! On two legs whose kinematics fit on a page.
use super::ground::{Conditions, Tolerance, perturbed};
use super::problem::{Direction, Point, Problem};
use super::start::feasible;
use super::*;
use crate::identify::excite::{Criterion, Scaling};
use bipedc_effects::random::Random;
use bipedc_runtime::model::{Argument, Arguments, CallError, Model, Signature, State};
use nalgebra::{DVector, Matrix3, Rotation3, Vector3};

/// Axes from the right foot to the left one, and from each joint to the next.
const AXES: [usize; 12] = [0, 1, 1, 1, 0, 2, 2, 0, 1, 1, 1, 0];
const STEPS: [[f64; 3]; 13] = [
    [0.0, 0.0, 0.055],
    [0.0, 0.0, 0.037],
    [0.0, 0.0, 0.273],
    [0.0, 0.0, 0.315],
    [0.0; 3],
    [0.0; 3],
    [0.0, 0.15, 0.0],
    [0.0; 3],
    [0.0; 3],
    [0.0, 0.0, -0.315],
    [0.0, 0.0, -0.273],
    [0.0, 0.0, -0.037],
    [0.0, 0.0, -0.055],
];
const MASSES: [f64; 13] = [0.5, 0.2, 1.0, 2.0, 0.4, 0.3, 10.0, 0.3, 0.4, 2.0, 1.0, 0.2, 0.5];

/// Thirteen bodies in a row; body 0 stands.
struct Legs;

impl Model<f64> for Legs {
    fn nq(&self) -> usize {
        19
    }
    fn nv(&self) -> usize {
        18
    }
    fn joint_name(&self, _index: usize) -> Option<&str> {
        None
    }
    fn joints(&self) -> usize {
        12
    }
    fn signature(&self, index: usize) -> Option<Signature<'_>> {
        let arguments = Arguments::of(&[Argument::Q]);
        (index == 0).then_some(Signature {
            name: "center_of_mass_regressor",
            arguments,
            rows: 3,
            columns: 130,
        })
    }
    fn argument_length(&self, _argument: Argument) -> usize {
        19
    }
    fn evaluate(&self, _function: usize, state: &State<'_, f64>, out: &mut [f64]) -> Result<(), CallError> {
        let q = state.get(Argument::Q);
        let (mut turn, mut at) = (Matrix3::identity(), Vector3::zeros());
        for body in 0..13 {
            if body > 0 {
                // The first step is that from the sole to the foot's frame.
                at += turn * if body == 1 { Vector3::zeros() } else { Vector3::from(STEPS[body - 1]) };
                let axis = Vector3::from_fn(|i, _| if i == AXES[body - 1] { 1.0 } else { 0.0 });
                turn *= Rotation3::new(axis * q[6 + body]).into_inner();
            }
            out[30 * body..][..3].copy_from_slice(at.as_slice());
            out[30 * body + 3..][..9].copy_from_slice(turn.as_slice());
        }
        Ok(())
    }
}

fn place(body: usize, z: f64) -> Place {
    Place { body, rotation: Matrix3::identity(), translation: Vector3::new(0.0, 0.0, z) }
}

fn standing() -> StanceModel<'static> {
    let corners = vec![[0.15, 0.06], [0.15, -0.06], [-0.09, 0.06], [-0.09, -0.06]];
    let sole = |body| SolePlace { place: place(body, -0.055), corners: corners.clone() };
    let joint = |j: usize| JointPlace {
        child: place(j + 1, 0.0),
        parent: j,
        axis: Vector3::from_fn(|i, _| if i == AXES[j] { 1.0 } else { 0.0 }),
        prismatic: false,
        limits: if STEPS[j + 1][2].abs() > 0.2 && AXES[j] == 1 { (-1.9, 1.9) } else { (-0.8, 0.8) },
    };
    let parameters = MASSES.iter().enumerate().flat_map(|(b, m)| {
        let z = if b == 6 { 0.25 } else { 0.5 * STEPS[(b + 1).min(12)][2] };
        [*m, 0.01 * m, 0.005 * m, z * m, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    });
    // Two first moments per joint: those across its axis.
    let across = |b: usize| {
        (1..4).filter(move |k| b == 0 && *k < 3 || b > 0 && *k != AXES[b - 1] + 1).map(move |k| 10 * b + k)
    };
    let mut columns: Vec<usize> = (0..13).flat_map(across).collect();
    columns.retain(|k| *k != 123);
    StanceModel::new(StandingParts {
        model: &Legs,
        parameters: parameters.collect(),
        joints: (0..12).map(joint).collect(),
        soles: [sole(0), sole(12)],
        torso: place(6, 0.0),
        columns,
        names: (0..12).map(|j| format!("joint_{j}")).collect(),
    })
    .unwrap()
}

fn conditions(standing: &StanceModel<'_>) -> Conditions {
    let tolerance = Tolerance { mass: 0.1, center: 0.01, draws: 2 };
    Conditions {
        limits: standing.parts.joints.iter().map(|j| j.limits).collect(),
        stability: 0.01,
        gap: 0.01,
        others: perturbed(&standing.parts.parameters, &tolerance, &mut Random::new(5)),
    }
}

fn begin(standing: &StanceModel<'_>, conditions: &Conditions) -> Point {
    let found = feasible(standing, conditions, (16, 4), &mut Random::new(2), &|| false).unwrap();
    let of = found.iter().enumerate().flat_map(|(k, (_, own))| vec![k; own.len()]).collect();
    let (placements, joints): (Vec<_>, Vec<_>) = found.into_iter().unzip();
    Point { placements, joints: joints.concat(), of }
}

#[test]
fn slopes_along_the_surface_are_those_of_the_cost() {
    let standing = standing();
    let conditions = conditions(&standing);
    let point = begin(&standing, &conditions);
    for criterion in [Criterion::Condition, Criterion::Information] {
        for scaling in [Scaling::Own, Scaling::Unit] {
            let problem = Problem { standing: &standing, conditions: &conditions, criterion, scaling };
            let tangents = problem.tangents(&point).unwrap();
            let (_, slope) = problem.slopes(&point, 1e-3).unwrap();
            let gradient = slope.pulled_back(&tangents, &point.of);
            let mut random = Random::new(7);
            for _ in 0..4 {
                let x = DVector::from_fn(gradient.len(), |_, _| random.symmetric());
                let direction = Direction::of_coordinates(&x, &tangents, &point.of, 4);
                let again = direction.coordinates(&tangents);
                assert!((again - &x).amax() < 1e-9, "coordinates of a direction are what it was made of");
                let at = |step: f64| {
                    let moved = problem.moved(&point, &direction, step).unwrap();
                    problem.slopes(&moved, 1e-3).unwrap().0
                };
                let numeric = (at(1e-6) - at(-1e-6)) / 2e-6;
                let exact = gradient.dot(&x);
                assert!(
                    (numeric - exact).abs() < 1e-4 * exact.abs().max(1.0),
                    "{criterion:?} {scaling:?}: {numeric} {exact}"
                );
            }
        }
    }
}

#[test]
#[ignore = "takes long"]
fn the_search_falls_and_keeps_everything() {
    let standing = standing();
    let request = PostureRequest {
        postures: 16,
        placements: 4,
        criterion: Criterion::Condition,
        scaling: Scaling::Own,
        margin: 0.05,
        stability: 0.01,
        gap: 0.01,
        tolerance: Tolerance { mass: 0.1, center: 0.01, draws: 2 },
        seed: 3,
        starts: 1,
        evaluations: 120,
        time_limit: None,
    };
    let found = design_postures(&standing, &request, &|_| (), &|| false).unwrap();
    let run = found.runs[0];
    println!("{} to {}", run.before.condition_number, run.after.condition_number);
    assert!(run.after.condition_number < 0.6 * run.before.condition_number);
    assert!(found.gap > 0.01 && found.postures.iter().all(|p| p.stability > 0.01));
    for (j, joint) in standing.parts.joints.iter().enumerate() {
        let unused = 0.025 * (joint.limits.1 - joint.limits.0);
        let inside = |q: f64| q > joint.limits.0 + unused && q < joint.limits.1 - unused;
        assert!(found.postures.iter().all(|p| inside(p.joints[j])), "joint {j}");
    }
    for posture in &found.postures {
        let missed = standing.missed(&standing.bodies(&posture.joints), &found.placements[posture.placement]);
        assert!(missed.amax() < 1e-10, "{missed}");
    }
    // Ended within the only start: it is said, though no other one is left out.
    let begun = std::cell::Cell::new(false);
    let cut = design_postures(&standing, &request, &|_| begun.set(true), &|| begun.get()).unwrap();
    assert!(cut.stopped && !found.stopped && cut.runs[0].evaluations < run.evaluations);
    // Ended at once, what it began with is the answer.
    let stopped = design_postures(&standing, &PostureRequest { starts: 3, ..request }, &|_| (), &|| true);
    assert!(stopped.is_err() || stopped.is_ok_and(|found| found.stopped || found.runs.len() == 1));
}
