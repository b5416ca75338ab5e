//! A robot with two legs of six joints, as walking sees it: which functions of its model tell what, where its soles are; its state in the world.
use super::space::{
    Pose, Turn, Vector, add, along, cross, dot, of_quaternion, product, subtract, transpose, turned, zero,
};
use crate::control::Refusal;
use crate::control::slices::{get, set};
use crate::model::{Argument, Model, State};
use crate::real::Scalar;

/// Most velocities of a robot that walks: its base and 42 joints.
pub const MOST_VELOCITIES: usize = 48;
/// Joints between the base and a foot.
pub const LEG: usize = 6;
/// Velocities of a floating base.
pub const BASE: usize = 6;

/// A leg: indices are those of the model's functions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Leg<R> {
    /// Place of the foot's link in the world, m.
    pub position: usize,
    /// Its axes, column after column.
    pub rotation: usize,
    /// 6 × nv: linear, angular; world axes.
    pub jacobian: usize,
    /// Its rate times the velocity.
    pub jacobian_rate: usize,
    /// Columns of its joints in `v`, from the base on.
    pub joints: [usize; LEG],
    /// Middle of the sole, axes forward, left, up: in the frame of the link.
    pub sole: Pose<R>,
    /// Rear, front, right and left edge of the sole from its middle, m.
    pub extent: [R; 4],
    /// Place of the foot among those of the description.
    pub foot: usize,
    /// Column of the knee in `v`.
    pub knee: usize,
    /// 1 or −1: the way in which its angle grows when the leg bends.
    pub bends: R,
}

/// Everything that a controller has to know of the robot.
#[derive(Debug, Clone, PartialEq)]
pub struct WalkingRobot<R> {
    /// Right, left.
    pub legs: [Leg<R>; 2],
    /// nv × nv
    pub mass_matrix: usize,
    /// Generalised forces without acceleration.
    pub bias: usize,
    /// m
    pub center_of_mass: usize,
    /// m/s
    pub center_of_mass_velocity: usize,
    /// The torso's axes forward, left and up in those of the root link.
    pub heading: Turn<R>,
    /// Of `q`, `v`.
    pub lengths: [usize; 2],
    /// m/s²
    pub gravity: R,
    /// Largest torque of each joint, N m; infinite: none.
    pub torque: [R; MOST_VELOCITIES],
    /// Angles of joints that are in no leg, and those of the legs when it stands.
    pub posture: [R; MOST_VELOCITIES],
    /// Of the spring between each joint and its motor, N m/rad at the joint; infinite: there is none.
    pub stiffness: [R; MOST_VELOCITIES],
    /// Of each joint's motor as seen at the joint, kg m²; 0: nothing is known of it.
    pub motor_inertia: [R; MOST_VELOCITIES],
    /// What the right and the left foot's sensor report per newton of the normal force.
    pub load_gain: [R; 2],
    /// What they report beside it, N.
    pub load_bias: [R; 2],
}

/// A foot in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sole<R> {
    /// Of its middle.
    pub pose: Pose<R>,
    /// Linear and angular velocity, world axes, m/s, rad/s.
    pub velocity: [Vector<R>; 2],
    /// J̇ v of the same.
    pub drift: [Vector<R>; 2],
    /// Per joint of the leg: linear and angular velocity of the middle.
    pub columns: [[R; 6]; LEG],
}

/// A state, in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place<R> {
    /// The root link.
    pub base: Pose<R>,
    /// Of the root's origin, world axes, m/s.
    pub velocity: Vector<R>,
    /// World axes, rad/s.
    pub angular: Vector<R>,
    /// m, m/s
    pub center: [Vector<R>; 2],
    /// Right, left.
    pub soles: [Sole<R>; 2],
}

fn three<R: Scalar>(of: &[R], first: usize) -> Vector<R> {
    [get(of, first), get(of, first + 1), get(of, first + 2)]
}

/// Room for a Jacobian.
pub type Columns<R> = [R; 6 * MOST_VELOCITIES];

impl<R: Scalar> WalkingRobot<R> {
    /// Numbers of the right and the left foot in the order of the description's feet.
    pub fn legs_by_foot<T: Copy>(&self, of: [T; 2]) -> [T; 2] {
        let mut ordered = of;
        self.legs.iter().zip(of).for_each(|(leg, x)| set(&mut ordered, leg.foot, x));
        ordered
    }

    /// Normal forces (N) of the right and the left foot, by what their sensors report.
    pub fn loads(&self, reported: [R; 2]) -> [R; 2] {
        [0, 1].map(|k| (get(&reported, k) - get(&self.load_bias, k)) / get(&self.load_gain, k))
    }

    /// Where everything is in a state.
    ///
    /// # Errors
    /// Lengths or functions that the model does not have; numbers that are not finite.
    pub fn place(
        &self,
        model: &impl Model<R>,
        [q, v]: [&[R]; 2],
        room: &mut Columns<R>,
    ) -> Result<Place<R>, Refusal> {
        let [nq, nv] = self.lengths;
        if q.len() != nq || v.len() != nv || nv > MOST_VELOCITIES {
            return Err(Refusal::WrongLength);
        }
        if !q.iter().chain(v).all(|x| x.is_finite()) {
            return Err(Refusal::NotFinite);
        }
        let state = State::new().with(Argument::Q, q).with(Argument::V, v);
        let vector = |function: usize| {
            let mut out = zero();
            model.evaluate(function, &state, &mut out).map(|()| out).map_err(|_| Refusal::WrongLength)
        };
        let center = [vector(self.center_of_mass)?, vector(self.center_of_mass_velocity)?];
        let turn = of_quaternion([get(q, 3), get(q, 4), get(q, 5), get(q, 6)]);
        let base = Pose { position: three(q, 0), turn };
        let (velocity, angular) = (turned(turn, three(v, 0)), turned(turn, three(v, 3)));
        let [right, left] = &self.legs;
        let soles = [right.sole(model, &state, room)?, left.sole(model, &state, room)?];
        Ok(Place { base, velocity, angular, center, soles })
    }
}

impl<R: Scalar> Leg<R> {
    /// How far the knee is bent, rad.
    pub fn bend(&self, q: &[R]) -> R {
        self.bends * get(q, self.knee + 1)
    }

    fn sole(
        &self,
        model: &impl Model<R>,
        state: &State<'_, R>,
        room: &mut Columns<R>,
    ) -> Result<Sole<R>, Refusal> {
        let v = state.get(Argument::V);
        let jacobian = room.get_mut(..6 * v.len()).ok_or(Refusal::WrongLength)?;
        let call = |function: usize, out: &mut [R]| {
            model.evaluate(function, state, out).map_err(|_| Refusal::WrongLength)
        };
        let (mut origin, mut axes, mut rate) = (zero(), [R::constant(0.0); 9], [R::constant(0.0); 6]);
        call(self.position, &mut origin)?;
        call(self.rotation, &mut axes)?;
        call(self.jacobian, jacobian)?;
        call(self.jacobian_rate, &mut rate)?;
        let pose = self.of_link(origin, axes);
        let arm = subtract(pose.position, origin);
        let moved = |linear: Vector<R>, angular: Vector<R>| add(linear, cross(angular, arm));
        let mut velocity = [zero(); 2];
        for (column, rate) in v.iter().enumerate() {
            let (linear, angular) = (three(jacobian, 6 * column), three(jacobian, 6 * column + 3));
            velocity = [along(velocity[0], *rate, linear), along(velocity[1], *rate, angular)];
        }
        let omega = velocity[1];
        let drift = [three(&rate, 0), three(&rate, 3)];
        let columns = self.joints.map(|column| {
            let (linear, angular) = (three(jacobian, 6 * column), three(jacobian, 6 * column + 3));
            let [x, y, z] = moved(linear, angular);
            let [a, b, c] = angular;
            [x, y, z, a, b, c]
        });
        Ok(Sole {
            pose,
            velocity: [moved(velocity[0], omega), omega],
            drift: [add(moved(drift[0], drift[1]), cross(omega, cross(omega, arm))), drift[1]],
            columns,
        })
    }

    /// The sole, where its link is: place (m) and axes, column after column.
    pub fn of_link(&self, origin: Vector<R>, axes: [R; 9]) -> Pose<R> {
        let link = transpose([three(&axes, 0), three(&axes, 3), three(&axes, 6)]);
        let position = add(origin, turned(link, self.sole.position));
        Pose { position, turn: product(link, self.sole.turn) }
    }

    /// How far a place on the ground is inside the sole, m: from rear, front, right, left.
    pub fn inside(&self, pose: &Pose<R>, place: Vector<R>) -> [R; 4] {
        let from = subtract(place, pose.position);
        let [forward, left, _] = transpose(pose.turn);
        let (x, y) = (dot(forward, from), dot(left, from));
        let [rear, front, right, other] = self.extent;
        [x - rear, front - x, y - right, other - y]
    }
}
