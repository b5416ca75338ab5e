//! What a film shows. All quantities in SI units, world axes x forward, y left, z up; the ground is z = 0.
use crate::report::data::Fact;
use crate::robot::Side;

/// A simulated motion: everything on its page; what is empty is left out of it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Film {
    /// Such as `tulip: simulation of drop.toml`.
    pub title: String,
    /// Name of the robot.
    pub robot: String,
    /// What happened in plain words; empty lines separate paragraphs.
    pub summary: String,
    /// What went wrong.
    pub warnings: Vec<String>,
    /// Scenario, steps, provenance.
    pub facts: Vec<Fact>,
    /// Weight of the robot, N: gives force arrows their length.
    pub weight: f64,
    /// In the order of the model.
    pub feet: Vec<FilmFoot>,
    /// Contact points, in the order of [`Frame::forces`].
    pub points: Vec<FilmPoint>,
    /// What is drawn.
    pub parts: Vec<FilmPart>,
    /// Poses over time, thinned.
    pub frames: Vec<Frame>,
    /// Times of `loads`, s.
    pub time: Vec<f64>,
    /// Vertical force on each foot, N; as long as `time`.
    pub loads: Vec<Vec<f64>>,
    /// Plots over `time`.
    pub plots: Vec<Plot>,
    /// Pictures beside the film.
    pub pictures: Vec<Picture>,
}

/// A picture that does not move.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Picture {
    /// Its heading.
    pub title: String,
    /// What it shows.
    pub caption: String,
    /// A whole `<svg>` element of our own making: it is shown as it is.
    pub svg: String,
}

/// A foot.
#[derive(Debug, Clone, PartialEq)]
pub struct FilmFoot {
    /// As in the description.
    pub name: String,
    /// Its leg; `None`: neither.
    pub side: Option<Side>,
}

/// A contact point.
#[derive(Debug, Clone, PartialEq)]
pub struct FilmPoint {
    /// Index of its foot.
    pub foot: usize,
    /// Index of the body that carries it; `None`: the world.
    pub body: Option<usize>,
    /// In the body's frame, m.
    pub place: [f64; 3],
}

/// Something that moves with a body.
#[derive(Debug, Clone, PartialEq)]
pub struct FilmPart {
    /// Index of the body; `None`: the world.
    pub body: Option<usize>,
    /// Its leg; `None`: neither.
    pub side: Option<Side>,
    /// What it looks like, in the body's frame.
    pub form: Form,
}

/// The shape of a part.
#[derive(Debug, Clone, PartialEq)]
pub enum Form {
    /// A convex solid; faces are indices of corners, counterclockwise as seen from outside.
    Solid {
        /// Corners, m.
        corners: Vec<[f64; 3]>,
        /// Each at least three.
        faces: Vec<Vec<usize>>,
    },
    /// A line of some width: a link whose shape the URDF does not state.
    Bone {
        /// Both ends, m.
        ends: [[f64; 3]; 2],
        /// m
        width: f64,
    },
}

impl Form {
    /// Its corners or ends, m.
    pub fn corners(&self) -> &[[f64; 3]] {
        match self {
            Self::Solid { corners, .. } => corners,
            Self::Bone { ends, .. } => ends,
        }
    }
}

/// The robot at one instant.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Frame {
    /// s
    pub time: f64,
    /// Of each body.
    pub poses: Vec<Pose>,
    /// Of the ground on each contact point, N.
    pub forces: Vec<[f64; 3]>,
    /// Of all links, m.
    pub center_of_mass: [f64; 3],
    /// Where the contact forces have no horizontal moment, m: the centre of pressure, which on flat ground is the zero
    /// moment point; `None` in the air.
    pub center_of_pressure: Option<[f64; 2]>,
    /// Of a walk that a controller balances.
    pub balance: Option<Balance>,
}

/// What the controller of a walk knows of its balance.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Balance {
    /// The divergent component of motion as it is and as it is wished, on the ground, m.
    pub divergent: [[f64; 2]; 2],
    /// The zero moment point that it asks for, m.
    pub zero_moment_point: [f64; 2],
    /// What it does, such as `stands on the left foot`.
    pub phase: String,
    /// What keeps it from what it would do undisturbed, in words.
    pub limits: Vec<String>,
}

/// A body's frame in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Origin, m.
    pub position: [f64; 3],
    /// Unit quaternion x y z w.
    pub orientation: [f64; 4],
}

impl Pose {
    /// A point of the body's frame in the world, m.
    pub fn at(&self, point: [f64; 3]) -> [f64; 3] {
        let [x, y, z, w] = self.orientation;
        let cross = |a: [f64; 3], b: [f64; 3]| {
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        };
        let once = cross([x, y, z], point).map(|c| 2.0 * c);
        let twice = cross([x, y, z], once);
        [0, 1, 2].map(|i| self.position[i] + point[i] + w * once[i] + twice[i])
    }
}

impl Frame {
    /// A point of a body, or of the world, in the world, m; NaN for a body that is not there.
    pub fn at(&self, body: Option<usize>, point: [f64; 3]) -> [f64; 3] {
        match body {
            None => point,
            Some(body) => self.poses.get(body).map_or([f64::NAN; 3], |pose| pose.at(point)),
        }
    }
}

/// Curves over time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Plot {
    /// Such as `Energy`.
    pub title: String,
    /// The joint that it is about: plots of joints are chosen, others always there.
    pub joint: Option<String>,
    /// Of all curves.
    pub unit: String,
    /// Told apart by colour and dashes, at most three or four.
    pub curves: Vec<Curve>,
}

/// One line of a plot.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Curve {
    /// Such as `potential`.
    pub name: String,
    /// As long as [`Film::time`]; NaN leaves a gap.
    pub values: Vec<f64>,
}
