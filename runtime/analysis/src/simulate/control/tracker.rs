//! Which phase a robot is in whose contacts nobody switches: time stepping.
use crate::simulate::phases::{Ending, Mirror, PhaseSpec};
use crate::simulate::stepper::CLOSED;

/// What carries nothing for so long has let go, s: contacts that begin a hair above the ground settle within some steps.
const UNLOADED: f64 = 0.001;
/// Height above which a foot has been in the air, m.
const LIFTED: f64 = 1e-4;

/// Follows the phases of a description along a motion.
pub(crate) struct Tracker<'a> {
    phases: &'a [PhaseSpec],
    mirror: Option<Mirror<'a>>,
    /// Contact points of each foot.
    feet: Vec<std::ops::Range<usize>>,
    shortest_step: f64,
    phase: usize,
    /// Left and right have exchanged their roles.
    swapped: bool,
    /// The present phase's ending can happen: the foot was in the air, or loaded.
    armed: bool,
    /// The phase has been looked at before.
    seen: bool,
    /// Since when nothing is carried any more, s.
    unloaded: Option<f64>,
}

impl<'a> Tracker<'a> {
    pub fn new(
        phases: &'a [PhaseSpec],
        mirror: Option<Mirror<'a>>,
        feet: Vec<std::ops::Range<usize>>,
        shortest_step: f64,
        phase: usize,
    ) -> Self {
        Self {
            phases,
            mirror,
            feet,
            shortest_step,
            phase,
            swapped: false,
            armed: false,
            seen: true,
            unloaded: None,
        }
    }

    /// The present phase.
    pub fn phase(&self) -> usize {
        self.phase
    }

    /// The mirror, while left and right have exchanged their roles.
    pub fn mirror(&self) -> Option<&Mirror<'a>> {
        self.mirror.as_ref().filter(|_| self.swapped)
    }

    /// The contact point of the robot as it is, for one of the robot as the phases name it.
    fn point(&self, point: usize) -> usize {
        self.mirror().map_or(point, |mirror| mirror.point(point))
    }

    /// Goes on to the next phase where the present one is over, and says so: time (s), heights and places along x of the contact
    /// points (m), and their last normal impulses (N s).
    pub fn update(&mut self, time: f64, heights: &[f64], places: &[f64], impulses: &[f64]) -> bool {
        let spec = &self.phases[self.phase];
        let begins = !std::mem::replace(&mut self.seen, true);
        let over = match &spec.ending {
            Ending::Never => false,
            Ending::Touch(points) => {
                let own: Vec<usize> = points.iter().map(|&point| self.point(point)).collect();
                let lowest = own.iter().map(|&point| heights[point]).fold(f64::INFINITY, f64::min);
                // What still comes down has part of the impact before it.
                let touches =
                    |&point: &usize| heights[point] <= if impulses[point] > 0.0 { CLOSED } else { 0.0 };
                let foremost =
                    |points: &[usize]| points.iter().map(|&p| places[p]).fold(f64::NEG_INFINITY, f64::max);
                let standing: Vec<usize> = spec.standing.iter().map(|&point| self.point(point)).collect();
                let ahead = foremost(&own) - foremost(&standing);
                self.armed |= lowest > LIFTED;
                // Heel and toe may land at once.
                self.armed |= begins && ahead > 0.0 && own.iter().any(|&point| impulses[point] > 0.0);
                self.armed && own.iter().any(touches) && ahead >= self.shortest_step
            }
            Ending::Release(foot) => {
                let own: Vec<usize> =
                    spec.standing.iter().copied().filter(|point| self.feet[*foot].contains(point)).collect();
                self.lets_go(&own, time, (heights, impulses))
            }
            Ending::Tip(foot, kept) => {
                let own = spec.standing.iter().copied();
                let own: Vec<usize> =
                    own.filter(|point| self.feet[*foot].contains(point) && !kept.contains(point)).collect();
                self.lets_go(&own, time, (heights, impulses))
            }
        };
        if over {
            self.swapped ^= spec.relabel;
            self.phase = spec.next;
            (self.armed, self.seen, self.unloaded) = (false, false, None);
        }
        over
    }

    /// Points that carried something in this phase and carry nothing now, or are in the air already as it begins.
    fn lets_go(&mut self, points: &[usize], time: f64, (heights, impulses): (&[f64], &[f64])) -> bool {
        let load: f64 = points.iter().map(|&point| impulses[self.point(point)]).sum();
        let lifted = points.iter().all(|&point| heights[self.point(point)] > LIFTED);
        self.armed |= load > 0.0 || lifted;
        if load > 0.0 {
            self.unloaded = None;
            return false;
        }
        self.armed && time - *self.unloaded.get_or_insert(time) >= UNLOADED
    }
}
