//! TUlip in a posture, on its emitted code.
use bipedc_analysis::robot::BaseKind;
use bipedc_analysis::simulate::{Ground, JointLaw, Mechanics, MotionState, Stepped, Stepper, Tolerance};
use bipedc_runtime::Model;

/// A case: posture with bent knees, springs in the joints.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    /// Of the lowest corner, m.
    pub clearance: f64,
    /// Pitch of the torso, rad.
    pub tilt: f64,
    /// N m/rad
    pub stiffness: f64,
    /// N m s/rad
    pub damping: f64,
    pub friction: f64,
    /// Dry friction of the joints, N m.
    pub dry: f64,
}

/// TUlip on its way.
pub struct Humanoid {
    stepper: Stepper<'static>,
    pub motion: MotionState,
    goal: Vec<f64>,
    stiffness: f64,
}

impl Humanoid {
    /// On the emitted model.
    pub fn new(case: Case, relative: f64) -> Self {
        Self::with(&tulip::Tulip, case, relative)
    }

    /// On this model of TUlip.
    pub fn with(model: &'static dyn Model<f64>, case: Case, relative: f64) -> Self {
        let mechanics = Mechanics::new(model, BaseKind::Floating).unwrap();
        let law = JointLaw { damping: case.damping, dry: [case.dry; 2], ..JointLaw::default() };
        let ground = Ground { friction: case.friction, ..Ground::default() };
        let tolerance = Tolerance { relative, ..Tolerance::default() };
        let stepper = Stepper::new(mechanics, ground, vec![law; 12], tolerance).unwrap();
        let mut q = vec![0.0; 19];
        (q[4], q[6]) = (0.5 * case.tilt).sin_cos();
        for side in [0, 6] {
            for (joint, angle) in [(2, -0.2), (3, 0.4), (4, -0.2)] {
                q[7 + side + joint] = angle;
            }
        }
        let mut gaps = [0.0; 8];
        mechanics.distances(&q, &mut gaps);
        q[2] = case.clearance - gaps.into_iter().fold(f64::INFINITY, f64::min);
        let motion = MotionState { time: 0.0, q: q.clone(), v: vec![0.0; 18] };
        Self { stepper, motion, goal: q, stiffness: case.stiffness }
    }

    /// The same on another ground, with an account of all work.
    pub fn accounted_on(mut self, ground: Ground) -> Self {
        *self.stepper.ground_mut() = ground;
        self.stepper = self.stepper.accounted();
        self
    }

    pub fn step(&mut self, time: f64) -> Stepped {
        let mut force = [0.0; 18];
        for j in 0..12 {
            force[6 + j] = self.stiffness * (self.goal[7 + j] - self.motion.q[7 + j]);
        }
        self.stepper.step(&mut self.motion, &force, time).unwrap()
    }

    /// Centre of mass, m.
    pub fn center_of_mass(&self) -> [f64; 3] {
        let q: [f64; 19] = self.motion.q.clone().try_into().unwrap();
        tulip::center_of_mass(&q.into()).into()
    }

    pub fn stepper(&self) -> &Stepper<'static> {
        &self.stepper
    }
}

/// Standing on both feet.
pub const STANDING: Case =
    Case { clearance: 0.0, tilt: 0.0, stiffness: 500.0, damping: 5.0, friction: 0.6, dry: 0.0 };

#[test]
fn standing_and_falling_reach_a_relative_residual_of_1e_6_in_every_step() {
    let cases = [
        ("standing", STANDING),
        ("standing with dry joints", Case { dry: 0.5, ..STANDING }),
        ("dropped", Case { clearance: 0.1, tilt: 0.05, ..STANDING }),
        ("dropped askew", Case { clearance: 0.1, tilt: 0.6, ..STANDING }),
        ("collapsing", Case { tilt: 0.1, stiffness: 0.0, damping: 0.1, ..STANDING }),
    ];
    for (name, case) in cases {
        let mut robot = Humanoid::new(case, 1e-6);
        let (mut worst, mut rounds, mut contacts) = (0.0_f64, 0, 0);
        for _ in 0..1500 {
            let stepped = robot.step(1e-3);
            worst = worst.max(stepped.solved.residual);
            rounds += stepped.solved.sweeps + stepped.solved.newton;
            contacts = contacts.max(stepped.contacts);
            assert!(stepped.work < 1e-9, "{name}: no restitution, no energy made: {stepped:?}");
        }
        println!(
            "{name}: worst residual {worst:.1e}, {:.2} rounds per step, {contacts} corners",
            rounds as f64 / 1500.0
        );
        assert!(worst <= 1e-6, "{name}: {worst}");
        assert!(contacts >= 4, "{name}: {contacts}");
    }
}

#[test]
fn joints_that_stick_move_alike_with_and_without_rows() {
    let case = Case { dry: 0.5, ..STANDING };
    let mut without = Humanoid::new(case, 1e-9);
    // Where work is accounted for, all friction has rows.
    let ground = Ground { friction: case.friction, ..Ground::default() };
    let mut with = Humanoid::new(case, 1e-9).accounted_on(ground);
    let (mut apart, mut frictions) = (0.0_f64, 0.0_f64);
    for _ in 0..1500 {
        without.step(1e-3);
        with.step(1e-3);
        for (a, b) in without.motion.q.iter().zip(&with.motion.q) {
            apart = apart.max((a - b).abs());
        }
        for joint in 0..12 {
            let [a, b] = [&without, &with].map(|robot| robot.stepper().dry_impulse(joint));
            assert!(a.abs() <= 0.5e-3 * (1.0 + 1e-9), "joint {joint}: {a}");
            frictions = frictions.max((a - b).abs());
        }
    }
    println!("apart by {apart:.1e} rad or m, friction by {frictions:.1e} N m s");
    assert!(apart < 1e-7, "{apart}");
    // On two feet joints that stick and corners can carry the same load: rows leave it to springs that are very stiff in joints,
    // without rows joints do not give way at all. The motion does not feel it.
    assert!(frictions < 0.1 * 0.5e-3, "{frictions}");
}

#[test]
fn feet_carry_the_weight() {
    let mut robot = Humanoid::new(Case { damping: 20.0, ..STANDING }, 1e-9);
    for _ in 0..3000 {
        robot.step(1e-3);
    }
    let carried: f64 = (0..8).map(|i| robot.stepper().impulse(i)[2] / 1e-3).sum();
    println!("carried {carried} N");
    // It still sways a little on its springs.
    assert!((carried / (19.0 * 9.81) - 1.0).abs() < 0.02, "{carried}");
}
