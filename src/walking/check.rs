//! Every sample against every limit: the first that does not hold, and how near each quantity comes.
use super::Method;
use super::legs::Legs;
use super::motion::Row;
use bipedc_analysis::walking::{Kind, LEGS, Schedule, Settings, distance, margin};
use nalgebra::Vector3;
use serde::Serialize;

/// What is held against a limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// Of a joint.
    Position,
    /// Of a joint.
    Velocity,
    /// Of a joint.
    Effort,
    /// From the edge of the support polygon.
    ZeroMomentPoint,
    /// Of static walks, from the same edge.
    CenterOfMass,
    /// Of the foot in the air, in the middle half of its way.
    Clearance,
    /// Of the soles as seen from above.
    FeetDistance,
    /// Of the lines through the joints of both legs.
    LegsDistance,
    /// Horizontal by vertical force of the ground.
    Friction,
    /// The ground cannot pull.
    VerticalForce,
}

impl Quantity {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Position => "joint position",
            Self::Velocity => "joint velocity",
            Self::Effort => "joint effort",
            Self::ZeroMomentPoint => "margin of the zero moment point",
            Self::CenterOfMass => "margin of the centre of mass",
            Self::Clearance => "clearance of the foot in the air",
            Self::FeetDistance => "distance of the soles",
            Self::LegsDistance => "distance of the legs",
            Self::Friction => "friction that is needed",
            Self::VerticalForce => "vertical force of the ground",
        }
    }
}

/// On which side of its limit a value has to be.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Limit {
    /// At least this.
    Least(f64),
    /// At most this.
    Most(f64),
}

impl Limit {
    /// The number.
    pub fn value(self) -> f64 {
        match self {
            Self::Least(x) | Self::Most(x) => x,
        }
    }
}

/// A value beside its limit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Measured {
    /// Which.
    pub quantity: Quantity,
    /// The joint or foot that it is of.
    pub of: Option<String>,
    /// In `unit`.
    pub value: f64,
    /// In `unit`.
    pub limit: Limit,
    /// Of both.
    pub unit: &'static str,
    /// s
    pub time: f64,
    /// From 1; none while the robot stands.
    pub step: Option<usize>,
    /// What happens then.
    pub phase: Kind,
    /// Row of the plan.
    #[serde(skip)]
    pub row: usize,
}

impl Measured {
    /// How far it is from its limit, in `unit`; negative: it does not hold.
    pub fn left(&self) -> f64 {
        match self.limit {
            Limit::Least(limit) => self.value - limit,
            Limit::Most(limit) => limit - self.value,
        }
    }

    /// What is left as a part of the limit, to compare joints with one another.
    fn part(&self) -> f64 {
        self.left() / self.limit.value().abs().max(1e-9)
    }
}

/// What the checks found.
pub struct Checked {
    /// The nearest of each quantity.
    pub nearest: Vec<Measured>,
    /// The first that does not hold.
    pub first: Option<Measured>,
    /// Samples with something that does not.
    pub count: usize,
}

/// What rounding may leave of a limit.
const ROUNDING: f64 = 1e-9;

/// A quantity, what it is of, its value, limit and unit.
type Found<'a> = (Quantity, Option<&'a str>, f64, Limit, &'static str);

impl Legs {
    /// Holds all samples against all limits.
    pub fn check(&self, rows: &[Row], schedule: &Schedule, how: (Method, &Settings)) -> Checked {
        let mut checked = Checked { nearest: Vec::new(), first: None, count: 0 };
        for (index, row) in rows.iter().enumerate() {
            let phase = &schedule.phases[row.instant.phase];
            let mut wrong: Option<Measured> = None;
            for (quantity, of, value, limit, unit) in self.measured(row, schedule, how) {
                let measured = Measured {
                    quantity,
                    of: of.map(str::to_owned),
                    value,
                    limit,
                    unit,
                    time: row.instant.time,
                    step: phase.step.map(|step| step + 1),
                    phase: phase.kind,
                    row: index,
                };
                // A number that is none holds no limit.
                let left = measured.left();
                if (left.is_nan() || left < -ROUNDING)
                    && wrong.as_ref().is_none_or(|w| measured.part() < w.part())
                {
                    wrong = Some(measured.clone());
                }
                match checked.nearest.iter_mut().find(|nearest| nearest.quantity == quantity) {
                    Some(nearest) if measured.part() < nearest.part() => *nearest = measured,
                    Some(_) => {}
                    None => checked.nearest.push(measured),
                }
            }
            checked.count += usize::from(wrong.is_some());
            if checked.first.is_none() {
                checked.first = wrong;
            }
        }
        checked
    }

    fn measured<'a>(
        &'a self,
        row: &Row,
        schedule: &Schedule,
        (method, settings): (Method, &Settings),
    ) -> Vec<Found<'a>> {
        let mut found = self.of_joints(row, settings);
        let least = Limit::Least(settings.margin);
        let zmp = margin(&row.support, row.zmp);
        found.push((Quantity::ZeroMomentPoint, None, zmp, least, "m"));
        if method == Method::Static {
            let center = [row.center[0][0], row.center[1][0]];
            found.push((Quantity::CenterOfMass, None, margin(&row.support, center), least, "m"));
        }
        let [x, y, z] = [0, 1, 2].map(|i| row.wrenches[0][i] + row.wrenches[1][i]);
        found.push((Quantity::VerticalForce, None, z, Limit::Least(0.0), "N"));
        found.push((Quantity::Friction, None, x.hypot(y) / z.max(1e-9), Limit::Most(settings.friction), "1"));
        self.of_legs(row, schedule, settings, &mut found);
        found
    }

    fn of_joints(&self, row: &Row, settings: &Settings) -> Vec<Found<'_>> {
        let mut found: Vec<Found<'_>> = Vec::with_capacity(3 * self.joints.len() + 8);
        let state = &row.state;
        for (index, joint) in self.joints.iter().enumerate() {
            let (name, units) = (Some(joint.name.as_str()), joint.units());
            let q = state.q[joint.column + 1];
            let [low, high] = joint.position;
            // The nearer one; most joints have none at all.
            let limit = if q - low < high - q { Limit::Least(low) } else { Limit::Most(high) };
            if limit.value().abs() < 1e8 && joint.leg.is_some() {
                found.push((Quantity::Position, name, q, limit, units[0]));
            }
            let v = state.v[joint.column].abs();
            if joint.velocity.is_finite() && joint.leg.is_some() {
                found.push((
                    Quantity::Velocity,
                    name,
                    v,
                    Limit::Most(settings.velocity_part * joint.velocity),
                    units[1],
                ));
            }
            if joint.effort.is_finite() {
                let most = Limit::Most(settings.effort_part * joint.effort);
                found.push((Quantity::Effort, name, row.effort[index].abs(), most, units[2]));
            }
        }
        found
    }

    fn of_legs<'a>(
        &'a self,
        row: &Row,
        schedule: &Schedule,
        settings: &Settings,
        found: &mut Vec<Found<'a>>,
    ) {
        let instant = &row.instant;
        let phase = &schedule.phases[instant.phase];
        if let Some(foot) = phase.swing() {
            let part = (instant.time - phase.start) / phase.duration;
            let middle = match phase.kind {
                Kind::Lift => part > 0.5,
                Kind::Place => part < 0.5,
                _ => (0.25..0.75).contains(&part),
            };
            // The soles stay level: all corners are as high as the middle.
            let high = instant.soles[foot][2][0];
            if middle {
                found.push((
                    Quantity::Clearance,
                    Some(LEGS[foot]),
                    high,
                    Limit::Least(settings.clearance),
                    "m",
                ));
            }
        }
        let prints = [0, 1].map(|k| {
            let sole = &instant.soles[k];
            self.footprint(k, [sole[0][0], sole[1][0]], sole[3][0])
        });
        let apart = distance(&prints[0], &prints[1]);
        found.push((Quantity::FeetDistance, None, apart, Limit::Least(settings.feet_distance), "m"));
        let legs = between(&self.leg_line(&row.state.q, 0), &self.leg_line(&row.state.q, 1));
        found.push((Quantity::LegsDistance, None, legs, Limit::Least(settings.legs_distance), "m"));
    }
}

/// Least distance of two lines of straight pieces, m.
fn between(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    let pairs = a.windows(2).flat_map(|p| b.windows(2).map(move |q| (p, q)));
    pairs.map(|(p, q)| of_segments([p[0], p[1]], [q[0], q[1]])).fold(f64::INFINITY, f64::min)
}

/// Least distance of two segments (Ericson, Real-Time Collision Detection, 5.1.9).
fn of_segments([p1, q1]: [Vector3<f64>; 2], [p2, q2]: [Vector3<f64>; 2]) -> f64 {
    let (d1, d2, r) = (q1 - p1, q2 - p2, p1 - p2);
    let (a, e, f) = (d1.norm_squared(), d2.norm_squared(), d2.dot(&r));
    let (b, c) = (d1.dot(&d2), d1.dot(&r));
    let tiny = 1e-14;
    let part = |x: f64, y: f64| if y > tiny { (x / y).clamp(0.0, 1.0) } else { 0.0 };
    let denominator = a * e - b * b;
    let mut s =
        if a > tiny && denominator > tiny { ((b * f - c * e) / denominator).clamp(0.0, 1.0) } else { 0.0 };
    let mut t = part(b * s + f, e);
    if e > tiny {
        let along = (b * s + f) / e;
        if along < 0.0 {
            (t, s) = (0.0, part(-c, a));
        } else if along > 1.0 {
            (t, s) = (1.0, part(b - c, a));
        }
    } else {
        s = part(-c, a);
    }
    (p1 + d1 * s - p2 - d2 * t).norm()
}
