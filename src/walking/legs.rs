//! A robot made ready to walk: its legs, soles and posture, and the numbers that follow from them.
use super::kinematics::Kinematics;
use super::soles::{Limited, SoleFrame, chain, feet, joints};
use crate::film::poses;
use bipedc_analysis::walking::{LEGS, Point, Settings, Stated, hull};
use bipedc_compiler::Robot;
use bipedc_compiler::description::model::{Base, ContactPoint, RobotDescription};
use bipedc_compiler::tree::Tree;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::spelling::suggest;
use nalgebra::{DMatrix, Matrix3, Rotation3, UnitQuaternion, Vector3};

/// Axes that are at least so parallel to the robot's left bend a leg.
const LATERAL: f64 = 0.9;

/// A robot ready to walk.
pub struct Legs {
    /// On a floating base.
    pub robot: Robot,
    /// Its tree.
    pub tree: Tree,
    /// Its functions.
    pub kinematics: Kinematics,
    /// Names of the feet: right, left.
    pub feet: [String; 2],
    /// Names of the links that carry them.
    pub links: [String; 2],
    /// In the frames of their links.
    pub soles: [SoleFrame; 2],
    /// Axes forward, left and up in the frame of the root link.
    pub heading: Matrix3<f64>,
    /// In the order of `v`.
    pub joints: Vec<Limited>,
    /// Bodies along each leg, from the root on.
    pub bodies: [Vec<usize>; 2],
    /// Columns of `v` that move: the base and the legs.
    pub active: Vec<usize>,
    /// Straight legs.
    straight: Vec<f64>,
    /// Near the posture of standing.
    pub posture: Vec<f64>,
    /// What follows from the robot, and what is stated.
    pub settings: Settings,
}

impl Legs {
    /// Looks at a robot; numbers are derived from it unless they are stated.
    ///
    /// # Errors
    /// A base that does not float, feet or legs that cannot walk, joints that do not exist.
    pub fn new(robot: &Robot, stated: &Stated) -> Result<Self, Diagnostic> {
        let Base::Floating { root } = &robot.description.base else {
            return Err(
                Diagnostic::error("only a robot on a floating base walks").help("add --base floating")
            );
        };
        let (tree, description) = (robot.tree()?, &robot.description);
        ground_and_root(description, root)?;
        let pair = feet(description)?;
        let joints = joints(description, &tree, root, pair);
        six_each(&joints)?;
        let kinematics = Kinematics::new(robot, pair.map(|foot| foot.link.as_str()))?;
        let straight = stated_posture(&kinematics, &joints, stated)?;
        let heading = heading(&kinematics, &straight);
        let soles = [0, 1].map(|k| sole(&kinematics, k, &straight, &heading, &pair[k].points));
        let bodies = pair.map(|foot| {
            let names = chain(description, &foot.link, root);
            let own = names.iter().filter(|name| joints.iter().any(|j| j.name == **name && j.leg.is_some()));
            own.filter_map(|name| tree.bodies.iter().position(|body| body.joint == *name)).collect::<Vec<_>>()
        });
        let mut active: Vec<usize> = (0..6).collect();
        active.extend(joints.iter().filter(|joint| joint.leg.is_some()).map(|joint| joint.column));
        let [feet, links] = [pair.map(|foot| foot.name.clone()), pair.map(|foot| foot.link.clone())];
        let mut legs = Self {
            robot: robot.clone(),
            tree,
            kinematics,
            feet,
            links,
            soles,
            heading,
            joints,
            bodies,
            active,
            posture: straight.clone(),
            straight,
            settings: DEFAULTS,
        };
        legs.bend(DEFAULTS.with(stated).knee_bend, stated);
        Ok(legs)
    }

    /// Stands with knees that are so bent (rad).
    pub fn bend(&mut self, knee_bend: f64, stated: &Stated) {
        let frames = (&self.soles, &self.heading);
        self.posture.clone_from(&self.straight);
        bend_knees(&self.kinematics, &self.joints, &mut self.posture, frames, knee_bend);
        stand(&self.kinematics, &mut self.posture, frames);
        self.settings = self.derived(knee_bend, stated);
    }

    /// Numbers that follow from the robot's size, and from what is stated.
    fn derived(&self, knee_bend: f64, stated: &Stated) -> Settings {
        let at = self.kinematics.posture(&self.posture, &self.soles, &self.heading);
        let leg = self.leg_length();
        let width = (at.places[1] - at.places[0]).y.abs();
        let half =
            self.soles.iter().flat_map(|sole| sole.corners.iter()).map(|c| c[1].abs()).fold(0.0, f64::max);
        // Times go with the square root of lengths; 0.6 m of leg is TUlip's.
        let scale = (leg / 0.6).sqrt();
        let sizes = Settings {
            knee_bend,
            com_height: at.center.z,
            stance_width: width,
            step_height: 0.05 * leg,
            margin: 0.15 * half,
            feet_distance: 0.1 * half,
            static_swing_time: 1.5 * scale,
            step_time: 0.6 * scale,
            stand_time: 1.0 * scale,
            ..DEFAULTS
        };
        let sizes = sizes.with(stated);
        // A shift from sole to sole accelerates by at most 2π d / T² (6.43), which moves the zero moment point by so much times z / g: no farther than
        // half of what the margin leaves of a sole.
        let room = 0.5 * (half - sizes.margin).max(0.1 * half);
        let way = std::f64::consts::TAU * sizes.stance_width * sizes.com_height;
        let shift = (way / (self.kinematics.gravity() * room)).sqrt();
        Settings {
            clearance: 0.4 * sizes.step_height,
            legs_distance: 0.3 * sizes.stance_width,
            static_shift_time: shift.max(scale),
            ..sizes
        }
        .with(stated)
    }

    /// Of the right leg between its first and last joint, m.
    pub fn leg_length(&self) -> f64 {
        let line = self.leg_line(&self.posture, 0);
        line[..line.len() - 1].windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
    }

    /// Corners of a sole at a place with a yaw, on the ground, m.
    pub fn corners(&self, foot: usize, [x, y]: Point, yaw: f64) -> Vec<Point> {
        let (sine, cosine) = yaw.sin_cos();
        let corners = self.soles[foot].corners.iter();
        corners.map(|[a, b, _]| [x + a * cosine - b * sine, y + a * sine + b * cosine]).collect()
    }

    /// The convex hull of those.
    pub fn footprint(&self, foot: usize, place: Point, yaw: f64) -> Vec<Point> {
        hull(&self.corners(foot, place, yaw))
    }

    /// Places of the joints of a leg, from the root to its sole, m.
    pub fn leg_line(&self, q: &[f64], leg: usize) -> Vec<Vector3<f64>> {
        let poses = poses(&self.tree, q);
        let mut line: Vec<Vector3<f64>> =
            self.bodies[leg].iter().map(|body| Vector3::from(poses[*body].position)).collect();
        let (origin, turn) = self.kinematics.link(leg, q);
        line.push(origin + turn * self.soles[leg].center);
        line
    }

    /// Half the length of the longer sole, m.
    pub fn sole_arm(&self) -> f64 {
        let corners = self.soles.iter().flat_map(|sole| sole.corners.iter());
        corners.map(|c| c[0].abs()).fold(0.01, f64::max)
    }
}

/// Gravity straight down, and a link that carries the base.
fn ground_and_root(description: &RobotDescription, root: &str) -> Result<(), Diagnostic> {
    let [gx, gy, gz] = description.gravity;
    if gx != 0.0 || gy != 0.0 || gz >= 0.0 {
        let message = "walks are planned on level ground: gravity has to point along -z";
        return Err(Diagnostic::error(message).help("turn `gravity` in biped.toml"));
    }
    if !description.links.iter().any(|link| link.name == *root) {
        let message = format!("the base is carried by `{root}`, which is no link");
        return Err(Diagnostic::error(message).help("let the torso or pelvis carry the base: --root LINK"));
    }
    Ok(())
}

/// Legs that can put a foot anywhere.
fn six_each(joints: &[Limited]) -> Result<(), Diagnostic> {
    for (leg, name) in LEGS.iter().enumerate() {
        let count = joints.iter().filter(|joint| joint.leg == Some(leg)).count();
        if count < 6 {
            let message = format!("the {name} leg has {count} joints, walks are planned for six or more");
            let help = "a foot that stays level and goes where it is wished takes six joints between it and the root";
            return Err(Diagnostic::error(message).help(help));
        }
    }
    Ok(())
}

/// What does not follow from sizes.
const DEFAULTS: Settings = Settings {
    knee_bend: 0.7,
    com_height: 1.0,
    stance_width: 0.2,
    step_height: 0.03,
    margin: 0.01,
    clearance: 0.01,
    feet_distance: 0.005,
    legs_distance: 0.05,
    friction: 0.6,
    effort_part: 1.0,
    velocity_part: 1.0,
    static_shift_time: 1.5,
    static_swing_time: 1.5,
    static_stand_time: 1.0,
    step_time: 0.6,
    double_support: 0.25,
    stand_time: 1.0,
    sample: 0.005,
};

/// All joints at zero, within their limits, or where they are stated to be.
fn stated_posture(
    kinematics: &Kinematics,
    joints: &[Limited],
    stated: &Stated,
) -> Result<Vec<f64>, Diagnostic> {
    let mut q = vec![0.0; kinematics.nq()];
    q[6] = 1.0;
    for (name, angle) in &stated.posture {
        let Some(joint) = joints.iter().find(|joint| joint.name == *name) else {
            let names = joints.iter().map(|joint| joint.name.as_str());
            let message = format!("the posture of the walk names `{name}`, which is no joint");
            return Err(Diagnostic::error(message).help(suggest(name, names, || "take it out".to_owned())));
        };
        if joint.leg.is_some() {
            let message = format!("the posture of the walk names `{name}`, a joint of a leg");
            return Err(
                Diagnostic::error(message).help("legs move: state `knee_bend` or `com_height` instead")
            );
        }
        if !(joint.position[0]..=joint.position[1]).contains(angle) {
            let [low, high] = joint.position;
            let message =
                format!("the posture of the walk has `{name}` at {angle}, its limits are {low} and {high}");
            return Err(Diagnostic::error(message));
        }
        q[joint.column + 1] = *angle;
    }
    for joint in joints.iter().filter(|joint| joint.leg.is_none()) {
        q[joint.column + 1] = q[joint.column + 1].clamp(joint.position[0], joint.position[1]);
    }
    Ok(q)
}

/// Forward, left and up in the root's axes: left is from foot to foot.
fn heading(kinematics: &Kinematics, q: &[f64]) -> Matrix3<f64> {
    let [right, left] = [0, 1].map(|k| kinematics.link(k, q).0);
    let across = left - right;
    // Feet that are not quite mirrored do not turn the robot.
    if across.x.abs() < 0.02 * across.y {
        return Matrix3::identity();
    }
    let left = Vector3::new(across.x, across.y, 0.0).normalize();
    Matrix3::from_columns(&[left.cross(&Vector3::z()), left, Vector3::z()])
}

/// The plane of the contact points, forward as the robot.
fn sole(
    kinematics: &Kinematics,
    foot: usize,
    q: &[f64],
    heading: &Matrix3<f64>,
    points: &[ContactPoint],
) -> SoleFrame {
    let (_, turn) = kinematics.link(foot, q);
    let places: Vec<Vector3<f64>> = points.iter().map(|point| Vector3::from(point.position)).collect();
    let mean = places.iter().sum::<Vector3<f64>>() / places.len() as f64;
    let about = DMatrix::from_fn(3, places.len(), |i, k| places[k][i] - mean[i]);
    let square = Matrix3::from_fn(|i, j| about.row(i).dot(&about.row(j)));
    let eigen = square.symmetric_eigen();
    let mut up: Vector3<f64> = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into_owned();
    if (turn * up).z < 0.0 {
        up = -up;
    }
    // A plane that is meant to be one of the link's own is.
    let largest = up.iamax();
    if up[largest].abs() > 1.0 - 1e-9 {
        up = Vector3::ith(largest, up[largest].signum());
    }
    let ahead = turn.transpose() * heading.column(0);
    let forward = (ahead - up * up.dot(&ahead)).normalize();
    let axes = Matrix3::from_columns(&[forward, up.cross(&forward), up]);
    let inside: Vec<Vector3<f64>> = places.iter().map(|place| axes.transpose() * (place - mean)).collect();
    let middle = |i: usize| {
        let ends = inside.iter().fold([f64::MAX, f64::MIN], |e, p| [e[0].min(p[i]), e[1].max(p[i])]);
        0.5 * (ends[0] + ends[1])
    };
    let offset = Vector3::new(middle(0), middle(1), inside.iter().map(|p| p.z).fold(f64::MAX, f64::min));
    let corners = inside.iter().map(|place| (place - offset).into()).collect();
    SoleFrame { center: mean + axes * offset, axes, corners }
}

/// Bends both legs: hip, knee and ankle, which turn about the robot's left, so that the knee has this angle.
fn bend_knees(
    kinematics: &Kinematics,
    joints: &[Limited],
    q: &mut [f64],
    (soles, heading): (&[SoleFrame; 2], &Matrix3<f64>),
    bend: f64,
) {
    let at = kinematics.posture(q, soles, heading);
    let lateral = |joint: &Limited| {
        let leg = joint.leg.unwrap_or(0);
        let axis: Vector3<f64> = at.jacobian.fixed_view::<3, 1>(6 * leg + 3, joint.column).into_owned();
        axis.dot(&heading.column(1))
    };
    let clamped = |joint: &Limited, angle: f64| {
        (lateral(joint).signum() * angle).clamp(joint.position[0], joint.position[1])
    };
    let legs = [0, 1].map(|leg| {
        let own = joints.iter().filter(|joint| joint.leg == Some(leg) && !joint.prismatic);
        let mut pitch: Vec<&Limited> = own.filter(|joint| lateral(joint).abs() > LATERAL).collect();
        // From the root on.
        pitch.sort_by_key(|joint| joint.column);
        pitch
    });
    for pitch in &legs {
        let &[hip, .., knee, ankle] = &pitch[..] else { continue };
        // Knees bend forward unless their limits forbid it.
        let way = if clamped(knee, bend).abs() + 1e-9 >= clamped(knee, -bend).abs() { 1.0 } else { -1.0 };
        for (joint, angle) in [(hip, -0.5 * bend), (knee, bend), (ankle, -0.5 * bend)] {
            q[joint.column + 1] = clamped(joint, way * angle);
        }
    }
}

/// Puts the root so that both soles are on the ground about the origin, the robot looking along x.
fn stand(kinematics: &Kinematics, q: &mut [f64], (soles, heading): (&[SoleFrame; 2], &Matrix3<f64>)) {
    let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(heading.transpose()));
    q[3..7].copy_from_slice(turn.coords.as_slice());
    let at = kinematics.posture(q, soles, heading);
    let middle = (at.places[0] + at.places[1]) * 0.5;
    (0..3).for_each(|i| q[i] -= middle[i]);
}
