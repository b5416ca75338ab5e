//! A simulation on film.
use super::parts::{parts, side_of_bodies};
use super::poses::poses;
use crate::robot::feet;
use bipedc_analysis::report::{Balance, Curve, Film, FilmFoot, FilmPoint, Frame, Plot};
use bipedc_analysis::robot::Foot;
use bipedc_analysis::simulate::{Mechanics, Sample};
use bipedc_compiler::robot::Robot;
use bipedc_compiler::tree::{BaseKind, Tree};
use bipedc_effects::diagnostic::Diagnostic;

/// Most frames per second.
const FRAME_RATE: f64 = 60.0;
/// Most frames in memory; the page may show fewer.
const MOST_FRAMES: f64 = 6000.0;
/// Most samples of the plots in memory.
const MOST_SAMPLES: usize = 100_000;
/// Part of the weight below which nothing is carried, and a centre of pressure means nothing.
const NOTHING: f64 = 1e-6;

/// Takes the samples of a simulation ([`bipedc_analysis::simulate::Simulation::watched`]) and makes a film of them.
pub struct Recorder<'a> {
    mechanics: Mechanics<'a>,
    tree: Tree,
    film: Film,
    /// s
    frame_step: f64,
    next_frame: f64,
    /// Of the samples every so manieth goes into the plots.
    every: usize,
    taken: usize,
    /// Potential energy at the start, J.
    start: Option<f64>,
    /// A controller tells of its balance.
    balanced: bool,
}

impl<'a> Recorder<'a> {
    /// For a run of so many seconds and rows. `mechanics` is of a model with energies and centre of mass
    /// (`simulation::filmed_model`).
    ///
    /// # Errors
    /// A robot without a tree.
    pub fn new(
        robot: &Robot,
        mechanics: Mechanics<'a>,
        duration: f64,
        rows: usize,
    ) -> Result<Self, Diagnostic> {
        let tree = robot.tree()?;
        let described = feet(&robot.description);
        let sides = side_of_bodies(&tree, &described);
        let g = tree.gravity.iter().map(|x| x * x).sum::<f64>().sqrt();
        // On a stand nothing touches the ground.
        let touching = mechanics.points() > 0 && tree.base != BaseKind::Fixed;
        let feet = if touching { described } else { Vec::new() };
        let mut plots = plots_of_robot(&feet);
        plots.extend(tree.joints.iter().flat_map(|joint| plots_of_joint(&joint.name, joint.prismatic)));
        let film = Film {
            robot: robot.description.name.clone(),
            title: format!("{}: simulation", robot.description.name),
            weight: g * tree.total_mass(),
            feet: film_feet(&feet),
            points: if touching { film_points(&tree, &feet) } else { Vec::new() },
            parts: parts(robot, &tree, &sides),
            loads: vec![Vec::new(); feet.len()],
            plots,
            ..Film::default()
        };
        let frame_step = (1.0 / FRAME_RATE).max(duration / MOST_FRAMES);
        let every = rows.div_ceil(MOST_SAMPLES).max(1);
        Ok(Self {
            mechanics,
            tree,
            film,
            frame_step,
            next_frame: 0.0,
            every,
            taken: 0,
            start: None,
            balanced: false,
        })
    }

    /// The same of a walk that a controller balances: plots of it before those of the joints.
    pub fn with_balance(mut self) -> Self {
        let own = self.film.plots.iter().position(|plot| plot.joint.is_some());
        let place = own.unwrap_or(self.film.plots.len());
        self.film.plots.splice(place..place, plots_of_balance());
        self.balanced = true;
        self
    }

    /// Adds a sample.
    pub fn take(&mut self, sample: &Sample) {
        self.take_balanced(sample, None);
    }

    /// Adds a sample, with what a controller knows of its balance.
    pub fn take_balanced(&mut self, sample: &Sample, balance: Option<Balance>) {
        if self.taken.is_multiple_of(self.every) {
            self.plot(sample, balance.as_ref());
        }
        self.taken += 1;
        if sample.time >= self.next_frame - 1e-9 {
            let frame = Frame { balance, ..self.frame(sample) };
            self.film.frames.push(frame);
            while self.next_frame <= sample.time + 1e-9 {
                self.next_frame += self.frame_step;
            }
        }
    }

    /// The film so far.
    pub fn finish(self) -> Film {
        self.film
    }

    fn frame(&self, sample: &Sample) -> Frame {
        let mut frame = Frame {
            time: sample.time,
            poses: poses(&self.tree, &sample.q),
            forces: sample.forces.iter().copied().take(self.film.points.len()).collect(),
            center_of_mass: self.center_of_mass(&sample.q, &sample.v),
            ..Frame::default()
        };
        frame.center_of_pressure = self.center_of_pressure(&frame);
        frame
    }

    /// `Σ f_z p / Σ f_z` over the contact points, which lie on the ground where they carry.
    fn center_of_pressure(&self, frame: &Frame) -> Option<[f64; 2]> {
        let mut load = 0.0;
        let mut moment = [0.0; 2];
        for (point, force) in self.film.points.iter().zip(&frame.forces) {
            let place = frame.at(point.body, point.place);
            load += force[2];
            (0..2).for_each(|i| moment[i] += force[2] * place[i]);
        }
        (load > NOTHING * self.film.weight && load > 0.0).then(|| moment.map(|x| x / load))
    }

    fn center_of_mass(&self, q: &[f64], v: &[f64]) -> [f64; 3] {
        match self.mechanics.named("center_of_mass", q, v).as_deref() {
            Some(&[x, y, z]) => [x, y, z],
            Some(&[x, z]) => [x, 0.0, z],
            _ => [f64::NAN; 3],
        }
    }

    /// One value more for every curve, in the order of [`plots_of_robot`], [`plots_of_balance`] and [`plots_of_joint`].
    fn plot(&mut self, sample: &Sample, balance: Option<&Balance>) {
        let energy = |name: &str| {
            let found = self.mechanics.named(name, &sample.q, &sample.v);
            found.and_then(|values| values.first().copied()).unwrap_or(f64::NAN)
        };
        let (kinetic, potential) = (energy("kinetic_energy"), energy("potential_energy"));
        let risen = potential - *self.start.get_or_insert(potential);
        let mut loads = vec![0.0; self.film.loads.len()];
        for (point, force) in self.film.points.iter().zip(&sample.forces) {
            loads[point.foot] += force[2];
        }
        let mut values = loads.clone();
        values.extend([kinetic, risen, kinetic + risen]);
        values.extend(self.center_of_mass(&sample.q, &sample.v));
        if self.balanced {
            values.extend(balance.map_or([f64::NAN; 6], |balance| {
                let ([[x, y], [wished_x, wished_y]], [a, b]) = (balance.divergent, balance.zero_moment_point);
                [x, wished_x, a, y, wished_y, b]
            }));
        }
        let joints = self.tree.joints.len();
        let first = sample.q.len().saturating_sub(joints);
        for j in 0..joints {
            values.extend([sample.q[first + j], sample.reference[j], sample.effort[j]]);
        }
        self.film.time.push(sample.time);
        self.film.loads.iter_mut().zip(loads).for_each(|(track, load)| track.push(load));
        let curves = self.film.plots.iter_mut().flat_map(|plot| &mut plot.curves);
        curves.zip(values).for_each(|(curve, value)| curve.values.push(value));
    }
}

fn empty(title: impl Into<String>, unit: &str, names: &[&str]) -> Plot {
    let curve = |name: &&str| Curve { name: (*name).to_owned(), values: Vec::new() };
    Plot {
        title: title.into(),
        joint: None,
        unit: unit.to_owned(),
        curves: names.iter().map(curve).collect(),
    }
}

fn plots_of_robot(feet: &[Foot]) -> Vec<Plot> {
    let names: Vec<&str> = feet.iter().map(|foot| foot.name.as_str()).collect();
    let forces = (!feet.is_empty()).then(|| empty("Vertical force of the ground", "N", &names));
    let energy = empty("Energy of the links", "J", &["kinetic", "potential, from the start", "sum"]);
    let center = empty("Centre of mass", "m", &["x", "y", "z"]);
    forces.into_iter().chain([energy, center]).collect()
}

/// What a controller knows of its balance.
fn plots_of_balance() -> [Plot; 2] {
    let curves = ["divergent component", "as it is wished", "zero moment point that is asked for"];
    [("Balance forward", "x"), ("Balance to the left", "y")]
        .map(|(title, axis)| empty(format!("{title} ({axis})"), "m", &curves))
}

fn plots_of_joint(name: &str, prismatic: bool) -> [Plot; 2] {
    let (position, effort) = if prismatic { ("m", "N") } else { ("rad", "N m") };
    let joint = Some(name.to_owned());
    [
        Plot { joint: joint.clone(), ..empty("Position", position, &["position", "reference"]) },
        Plot { joint, ..empty("Effort", effort, &["effort"]) },
    ]
}

fn film_feet(feet: &[Foot]) -> Vec<FilmFoot> {
    feet.iter().map(|foot| FilmFoot { name: foot.name.clone(), side: foot.side }).collect()
}

fn film_points(tree: &Tree, feet: &[Foot]) -> Vec<FilmPoint> {
    let foot = |name: &str| feet.iter().position(|foot| Some(foot.name.as_str()) == name.split('/').next());
    let points = tree.points.iter();
    points
        .map(|point| FilmPoint {
            foot: foot(&point.name).unwrap_or(0),
            body: point.body,
            place: point.placement.translation,
        })
        .collect()
}
