//! What feet, torso and weight do when: phases one after the other, each with a cosine profile (6.44).
use super::footsteps::Footstep;
use super::polygon::Point;
use super::profile::{Moved, moved};
use serde::Serialize;

/// The middle of a sole on the ground.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Sole {
    /// x, y, m.
    pub place: Point,
    /// rad
    pub yaw: f64,
}

/// Both feet on the ground: right, left.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Stance {
    /// Right and left.
    pub soles: [Sole; 2],
}

impl Stance {
    /// Beside one another about a place.
    pub fn about(body: Sole, width: f64) -> Self {
        let (sine, cosine) = body.yaw.sin_cos();
        let [x, y] = body.place;
        let at = |side: f64| Sole { place: [x - side * sine, y + side * cosine], yaw: body.yaw };
        Self { soles: [at(-0.5 * width), at(0.5 * width)] }
    }

    /// Between both soles.
    pub fn middle(&self) -> Point {
        [0, 1].map(|i| 0.5 * (self.soles[0].place[i] + self.soles[1].place[i]))
    }
}

/// What happens in a phase.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Nothing moves but, at ends of dynamic walks, the weight.
    Stand,
    /// The weight goes from foot to foot, both stand.
    Shift,
    /// A foot goes up and half of its way.
    Lift,
    /// The same foot goes down at its place.
    Place,
    /// A foot goes all of its way.
    Swing,
}

impl Kind {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stand => "stand",
            Self::Shift => "shift",
            Self::Lift => "lift",
            Self::Place => "place",
            Self::Swing => "swing",
        }
    }
}

/// Durations of phases, s, and how high feet go, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Timing {
    /// At the beginning and at the end.
    pub stand: f64,
    /// Both feet on the ground.
    pub shift: f64,
    /// One foot in the air.
    pub swing: f64,
    /// m
    pub step_height: f64,
}

/// A foot on its way: x, y, z (m), yaw (rad).
#[derive(Debug, Clone, Copy, PartialEq)]
struct Way {
    foot: usize,
    from: [f64; 4],
    to: [f64; 4],
    /// Goes up to this height and down again on its way, m; 0: straight.
    rise: f64,
}

/// A phase.
#[derive(Debug, Clone, PartialEq)]
pub struct Phase {
    /// What happens.
    pub kind: Kind,
    /// From 0; `None` while the robot stands at the beginning or at the end.
    pub step: Option<usize>,
    /// s
    pub start: f64,
    /// s
    pub duration: f64,
    /// Where the feet stand when it begins.
    pub stance: Stance,
    way: Option<Way>,
    /// The weight goes from here to there: the centre of mass of a static walk, the zero moment point of a dynamic one.
    weight: [Point; 2],
}

impl Phase {
    /// The foot in the air: 0 right, 1 left.
    pub fn swing(&self) -> Option<usize> {
        self.way.map(|way| way.foot)
    }
}

/// All that is wished at an instant.
#[derive(Debug, Clone, PartialEq)]
pub struct Instant {
    /// s
    pub time: f64,
    /// Index of the phase.
    pub phase: usize,
    /// x, y, z (m) and yaw (rad) of each sole with their rates.
    pub soles: [[Moved; 4]; 2],
    /// Yaw of the torso: halfway between the feet's.
    pub yaw: Moved,
    /// x, y of the weight, m.
    pub weight: [Moved; 2],
    /// Which feet stand.
    pub contact: [bool; 2],
}

/// Phases one after the other.
#[derive(Debug, Clone, PartialEq)]
pub struct Schedule {
    /// At least one.
    pub phases: Vec<Phase>,
    /// Between samples, s; all durations are multiples of it.
    pub sample: f64,
}

/// A schedule that grows.
struct Growing {
    schedule: Schedule,
    stance: Stance,
    weight: Point,
    time: usize,
}

impl Schedule {
    /// A statically stable walk: the weight is shifted over a foot, the other one is lifted and placed.
    pub fn statically(from: Stance, steps: &[Footstep], timing: &Timing, sample: f64) -> Self {
        let mut growing = Growing::new(from, sample);
        growing.add(Kind::Stand, None, timing.stand, None, growing.weight);
        for (k, step) in steps.iter().enumerate() {
            let over = growing.stance.soles[1 - step.foot].place;
            growing.add(Kind::Shift, Some(k), timing.shift, None, over);
            let [from, to] = growing.ends(step);
            let mut middle: [f64; 4] = std::array::from_fn(|i| 0.5 * (from[i] + to[i]));
            middle[2] = timing.step_height;
            let half = 0.5 * step.duration.unwrap_or(timing.swing);
            let way = |from, to| Some(Way { foot: step.foot, from, to, rise: 0.0 });
            growing.add(Kind::Lift, Some(k), half, way(from, middle), over);
            growing.add(Kind::Place, Some(k), half, way(middle, to), over);
        }
        growing.finish(timing)
    }

    /// A dynamically stable walk: the zero moment point goes from foot to foot while both stand, and rests below the one that stands alone.
    pub fn dynamically(from: Stance, steps: &[Footstep], timing: &Timing, sample: f64) -> Self {
        let mut growing = Growing::new(from, sample);
        growing.add(Kind::Stand, None, timing.stand, None, growing.weight);
        for (k, step) in steps.iter().enumerate() {
            let over = growing.stance.soles[1 - step.foot].place;
            growing.add(Kind::Shift, Some(k), timing.shift, None, over);
            let [from, to] = growing.ends(step);
            let way = Way { foot: step.foot, from, to, rise: timing.step_height };
            growing.add(Kind::Swing, Some(k), step.duration.unwrap_or(timing.swing), Some(way), over);
        }
        growing.finish(timing)
    }

    /// The number of samples, both ends included.
    pub fn samples(&self) -> usize {
        (self.duration() / self.sample).round() as usize + 1
    }

    /// s
    pub fn duration(&self) -> f64 {
        self.phases.last().map_or(0.0, |phase| phase.start + phase.duration)
    }

    /// What is wished at a sample. Where a phase begins the next one has it: a foot that is just lifted carries nothing.
    pub fn instant(&self, sample: usize) -> Instant {
        let time = sample as f64 * self.sample;
        let begun = |phase: &Phase| phase.start <= time + 0.5 * self.sample;
        let index = self.phases.iter().rposition(begun).unwrap_or(0);
        let phase = &self.phases[index];
        let (local, duration) = ((time - phase.start).max(0.0), phase.duration);
        let soles = [0, 1].map(|foot| match phase.way {
            Some(way) if way.foot == foot => travelled(&way, local, duration),
            _ => {
                let Sole { place: [x, y], yaw } = phase.stance.soles[foot];
                [x, y, 0.0, yaw].map(|x| [x, 0.0, 0.0])
            }
        });
        let yaw = [0, 1, 2].map(|k| 0.5 * (soles[0][3][k] + soles[1][3][k]));
        let weight = [0, 1].map(|i| moved([phase.weight[0][i], phase.weight[1][i]], local, duration));
        let contact = [0, 1].map(|foot| phase.swing() != Some(foot));
        Instant { time, phase: index, soles, yaw, weight, contact }
    }
}

fn travelled(way: &Way, time: f64, duration: f64) -> [Moved; 4] {
    let mut found: [Moved; 4] = std::array::from_fn(|i| moved([way.from[i], way.to[i]], time, duration));
    if way.rise > 0.0 {
        let half = 0.5 * duration;
        found[2] = if time < half {
            moved([0.0, way.rise], time, half)
        } else {
            moved([way.rise, 0.0], time - half, half)
        };
    }
    found
}

impl Growing {
    fn new(stance: Stance, sample: f64) -> Self {
        Self { schedule: Schedule { phases: Vec::new(), sample }, stance, weight: stance.middle(), time: 0 }
    }

    fn ends(&self, step: &Footstep) -> [[f64; 4]; 2] {
        [self.stance.soles[step.foot], step.sole].map(|Sole { place: [x, y], yaw }| [x, y, 0.0, yaw])
    }

    /// Durations become whole numbers of samples, even ones, so that their halves are, too.
    fn add(&mut self, kind: Kind, step: Option<usize>, duration: f64, way: Option<Way>, weight: Point) {
        let sample = self.schedule.sample;
        let samples = (2.0 * (0.5 * duration / sample).round()).max(2.0);
        self.schedule.phases.push(Phase {
            kind,
            step,
            start: self.time as f64 * sample,
            duration: samples * sample,
            stance: self.stance,
            way,
            weight: [self.weight, weight],
        });
        self.time += samples as usize;
        self.weight = weight;
        if let Some(way) = way {
            let [x, y, _, yaw] = way.to;
            self.stance.soles[way.foot] = Sole { place: [x, y], yaw };
        }
    }

    fn finish(mut self, timing: &Timing) -> Schedule {
        let middle = self.stance.middle();
        self.add(Kind::Shift, None, timing.shift, None, middle);
        self.add(Kind::Stand, None, timing.stand, None, middle);
        self.schedule
    }
}
