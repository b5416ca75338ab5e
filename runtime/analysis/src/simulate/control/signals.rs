//! What formulas can speak of: joints, the base, contact points; each with its derivatives along a motion.
use super::program::Jet;
use crate::robot::BaseKind;
use crate::simulate::mechanics::rotate;
use crate::simulate::plant::Plant;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::model::{Argument, Model, State};

/// One quantity that depends on the configuration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Signal {
    /// Position of a joint (by index), rad or m.
    Joint(usize),
    /// Position of the base along x, y or z, m.
    Position(usize),
    /// Roll, pitch or yaw of the base, `R_z R_y R_x`, rad.
    Angle(usize),
    /// Position of a contact point along x, y or z, m.
    Point(usize, usize),
}

/// All signals of a robot with their names: joints, `base_x`, `base_pitch`, …, `right_foot_toe_x`, …
pub fn signals(plant: &Plant) -> Vec<(String, Signal)> {
    let mut list: Vec<(String, Signal)> =
        plant.joint_names().enumerate().map(|(j, name)| (name.to_owned(), Signal::Joint(j))).collect();
    let (axes, angles) = plant.layout.base.axes();
    list.extend(axes.iter().map(|&axis| (format!("base_{}", ["x", "y", "z"][axis]), Signal::Position(axis))));
    let angle = |&k: &usize| (format!("base_{}", ["roll", "pitch", "yaw"][k]), Signal::Angle(k));
    list.extend(angles.iter().map(angle));
    let points: usize = plant.feet.iter().map(|foot| foot.corners.len()).sum();
    for point in 0..points {
        let name = plant.point_name(point).replace('/', "_");
        list.extend(
            axes.iter()
                .map(|&axis| (format!("{name}_{}", ["x", "y", "z"][axis]), Signal::Point(point, axis))),
        );
    }
    list
}

/// Functions of the model that contact points need.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct PointFunctions {
    heights: usize,
    places: usize,
    normal: usize,
    tangential: usize,
    normal_rate: usize,
    tangential_rate: usize,
}

/// Names of the functions that signals of contact points need.
pub const POINT_FUNCTIONS: [&str; 6] = [
    "contact_distances",
    "contact_positions",
    "contact_normal_directions",
    "contact_tangential_directions",
    "contact_normal_rate",
    "contact_tangential_rate",
];

/// Reads signals from a model's state.
#[derive(Debug, Clone)]
pub(super) struct Reader {
    base: BaseKind,
    list: Vec<Signal>,
    points: Option<PointFunctions>,
    /// Rates of the base's coordinates by rows of three, see [`Self::refresh`].
    rows: Vec<f64>,
    out: Vec<Vec<f64>>,
    /// By signal: value, rate, acceleration at zero generalised acceleration.
    jets: Vec<Jet>,
}

impl Reader {
    pub fn new(model: &dyn Model<f64>, base: BaseKind, list: Vec<Signal>) -> Result<Self, Diagnostic> {
        let find = |name: &str| {
            model.function(name).ok_or_else(|| {
                Diagnostic::error(format!("the model has no function `{name}`"))
                    .help("add it to what is generated from the description")
            })
        };
        let points = if list.iter().any(|signal| matches!(signal, Signal::Point(..))) {
            let [heights, places, normal, tangential, normal_rate, tangential_rate] = POINT_FUNCTIONS;
            Some(PointFunctions {
                heights: find(heights)?,
                places: find(places)?,
                normal: find(normal)?,
                tangential: find(tangential)?,
                normal_rate: find(normal_rate)?,
                tangential_rate: find(tangential_rate)?,
            })
        } else {
            None
        };
        let jets = vec![Jet::default(); list.len()];
        Ok(Self { base, list, points, rows: vec![0.0; 18], out: vec![Vec::new(); 6], jets })
    }

    /// At a state; `acceleration` belongs to `v`.
    pub fn read(&mut self, model: &dyn Model<f64>, q: &[f64], v: &[f64], acceleration: &[f64]) -> &[Jet] {
        self.refresh(model, q, v);
        for index in 0..self.list.len() {
            let mut jet = self.drift(self.list[index], q, v);
            jet.acceleration += self.along(self.list[index], acceleration);
            self.jets[index] = jet;
        }
        &self.jets
    }

    /// Adds `factor ×` the signal's derivative with respect to `v`'s coordinates to `row`, after [`Self::read`].
    pub fn add_row(&self, index: usize, factor: f64, row: &mut [f64]) {
        let joints = row.len() - self.base.nv();
        match self.list[index] {
            Signal::Joint(j) => row[row.len() - joints + j] += factor,
            Signal::Position(axis) if self.base == BaseKind::Planar => row[axis / 2] += factor,
            Signal::Angle(_) if self.base == BaseKind::Planar => row[2] += factor,
            Signal::Position(axis) => (0..3).for_each(|i| row[i] += factor * self.rows[3 * axis + i]),
            Signal::Angle(k) => (0..3).for_each(|i| row[3 + i] += factor * self.rows[9 + 3 * k + i]),
            Signal::Point(point, axis) => {
                let column = self.column(point, axis, row.len());
                row.iter_mut().zip(column).for_each(|(row, w)| *row += factor * w);
            }
        }
    }

    fn column(&self, point: usize, axis: usize, nv: usize) -> &[f64] {
        if axis == 2 {
            return &self.out[2][point * nv..(point + 1) * nv];
        }
        let tangents = if self.base == BaseKind::Planar { 1 } else { 2 };
        let at = point * tangents + axis;
        &self.out[3][at * nv..(at + 1) * nv]
    }

    fn along(&self, signal: Signal, acceleration: &[f64]) -> f64 {
        let joints = acceleration.len() - self.base.nv();
        let dot = |row: &[f64], a: &[f64]| row.iter().zip(a).map(|(x, y)| x * y).sum::<f64>();
        match signal {
            Signal::Joint(j) => acceleration[acceleration.len() - joints + j],
            Signal::Position(axis) if self.base == BaseKind::Planar => acceleration[axis / 2],
            Signal::Angle(_) if self.base == BaseKind::Planar => acceleration[2],
            Signal::Position(axis) => dot(&self.rows[3 * axis..3 * axis + 3], acceleration),
            Signal::Angle(k) => dot(&self.rows[9 + 3 * k..12 + 3 * k], &acceleration[3..6]),
            Signal::Point(point, axis) => dot(self.column(point, axis, acceleration.len()), acceleration),
        }
    }

    /// Value, rate, and acceleration at zero generalised acceleration.
    fn drift(&self, signal: Signal, q: &[f64], v: &[f64]) -> Jet {
        let joints = q.len() - self.base.nq();
        let planar = self.base == BaseKind::Planar;
        let still = |value: f64, rate: f64| Jet { value, rate, acceleration: 0.0 };
        match signal {
            Signal::Joint(j) => still(q[q.len() - joints + j], v[v.len() - joints + j]),
            Signal::Position(axis) if planar => still(q[axis / 2], v[axis / 2]),
            Signal::Angle(_) if planar => still(q[2], v[2]),
            Signal::Position(axis) => {
                // p̈ = R (v̇ + ω × v) in the root's own axes.
                let (linear, turn) = ([v[0], v[1], v[2]], [v[3], v[4], v[5]]);
                let cross = [
                    turn[1] * linear[2] - turn[2] * linear[1],
                    turn[2] * linear[0] - turn[0] * linear[2],
                    turn[0] * linear[1] - turn[1] * linear[0],
                ];
                let row = &self.rows[3 * axis..3 * axis + 3];
                let along = |x: [f64; 3]| row.iter().zip(x).map(|(a, b)| a * b).sum::<f64>();
                Jet { value: q[axis], rate: along(linear), acceleration: along(cross) }
            }
            Signal::Angle(k) => self.angle(k, q, v),
            Signal::Point(point, axis) => {
                let rate = self.column(point, axis, v.len()).iter().zip(v).map(|(w, v)| w * v).sum();
                let tangents = if planar { 1 } else { 2 };
                let (value, acceleration) = match axis {
                    2 => (self.out[0][point], self.out[4][point]),
                    _ => (self.out[1][point * tangents + axis], self.out[5][point * tangents + axis]),
                };
                Jet { value, rate, acceleration }
            }
        }
    }

    /// Roll, pitch and yaw of a floating base.
    fn angle(&self, k: usize, q: &[f64], v: &[f64]) -> Jet {
        let [roll, pitch, yaw] = euler([q[3], q[4], q[5], q[6]]);
        let turn = [v[3], v[4], v[5]];
        let rates: [f64; 3] =
            std::array::from_fn(|k| (0..3).map(|i| self.rows[9 + 3 * k + i] * turn[i]).sum());
        let (s, c) = roll.sin_cos();
        let (t, secant) = (pitch.tan(), pitch.cos().recip());
        // Derivatives of the rows below in `refresh`, times the angular velocity.
        let across = c * turn[1] - s * turn[2];
        let along = s * turn[1] + c * turn[2];
        let acceleration = match k {
            0 => rates[0] * across * t + along * secant * secant * rates[1],
            1 => -rates[0] * along,
            _ => (rates[0] * across + along * t * rates[1]) * secant,
        };
        Jet { value: [roll, pitch, yaw][k], rate: rates[k], acceleration }
    }

    /// Calls the functions of contact points and sets the rows of a floating base: three of `R`, then three that turn
    /// the angular velocity into rates of roll, pitch and yaw.
    fn refresh(&mut self, model: &dyn Model<f64>, q: &[f64], v: &[f64]) {
        if self.base == BaseKind::Floating {
            let turn = [q[3], q[4], q[5], q[6]];
            for axis in 0..3 {
                let mut unit = [0.0; 3];
                unit[axis] = 1.0;
                let column = rotate(turn, unit);
                (0..3).for_each(|row| self.rows[3 * row + axis] = column[row]);
            }
            let [roll, pitch, _] = euler(turn);
            let (s, c) = roll.sin_cos();
            let (t, secant) = (pitch.tan(), pitch.cos().recip());
            let rates = [1.0, s * t, c * t, 0.0, c, -s, 0.0, s * secant, c * secant];
            self.rows[9..].copy_from_slice(&rates);
        }
        let Some(points) = self.points else { return };
        let place = State::new().with(Argument::Q, q);
        let moving = place.with(Argument::V, v);
        let calls = [
            (points.heights, &place),
            (points.places, &place),
            (points.normal, &place),
            (points.tangential, &place),
            (points.normal_rate, &moving),
            (points.tangential_rate, &moving),
        ];
        for ((function, state), out) in calls.into_iter().zip(&mut self.out) {
            let size = model.signature(function).map_or(0, |s| s.rows * s.columns);
            out.resize(size, 0.0);
            // Lengths come from the model itself; a refusal would be a fault of this crate, seen in the numbers.
            if model.evaluate(function, state, out).is_err() {
                out.fill(f64::NAN);
            }
        }
    }
}

/// Roll, pitch and yaw of a quaternion x y z w.
fn euler([x, y, z, w]: [f64; 4]) -> [f64; 3] {
    let roll = f64::atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y));
    let pitch = (2.0 * (w * y - z * x)).clamp(-1.0, 1.0).asin();
    let yaw = f64::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z));
    [roll, pitch, yaw]
}
