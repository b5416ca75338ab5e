//! Which phase a robot is in whose contacts nobody switches: time stepping.
use crate::simulate::phases::{Ending, Mirror, PhaseSpec};
use crate::simulate::stepper::CLOSED;

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
}

impl<'a> Tracker<'a> {
    pub fn new(
        phases: &'a [PhaseSpec],
        mirror: Option<Mirror<'a>>,
        feet: Vec<std::ops::Range<usize>>,
        shortest_step: f64,
        phase: usize,
    ) -> Self {
        Self { phases, mirror, feet, shortest_step, phase, swapped: false, armed: false }
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

    /// Goes on to the next phase where the present one is over, and says so: heights and places along x of the contact points (m), and
    /// their last normal impulses (N s).
    pub fn update(&mut self, heights: &[f64], places: &[f64], impulses: &[f64]) -> bool {
        let spec = &self.phases[self.phase];
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
                self.armed && own.iter().any(touches) && ahead >= self.shortest_step
            }
            Ending::Release(foot) => {
                let own: Vec<usize> =
                    spec.standing.iter().copied().filter(|point| self.feet[*foot].contains(point)).collect();
                self.unloaded(&own, impulses)
            }
            Ending::Tip(foot, kept) => {
                let own = spec.standing.iter().copied();
                let own: Vec<usize> =
                    own.filter(|point| self.feet[*foot].contains(point) && !kept.contains(point)).collect();
                self.unloaded(&own, impulses)
            }
        };
        if over {
            self.swapped ^= spec.relabel;
            self.phase = spec.next;
            self.armed = false;
        }
        over
    }

    /// Points that carried something in this phase and carry nothing now.
    fn unloaded(&mut self, points: &[usize], impulses: &[f64]) -> bool {
        let load: f64 = points.iter().map(|&point| impulses[self.point(point)]).sum();
        self.armed |= load > 0.0;
        self.armed && load == 0.0
    }
}
