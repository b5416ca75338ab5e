//! Torques of a phase: outputs' accelerations as equations, limits of ground and drives as inequalities, the least change of the feed-forward.
use super::ground_limits::{Forces, LettingGo, Limit, Writer, rows};
use super::least_change::{
    Active, Conditions, Room as Search, Search as Outcome, nearest, nearest_compromise,
};
use super::phased::{PhaseLayout, PhasedLayout};
use super::slices::{copy, get};
use super::{Feedback, Refusal};
use crate::real::Scalar;

/// How much more a missed output weighs than a change of torques, once not all can be met: squares of N m. Torques jump by about its reciprocal
/// where that begins, so that it is as large as rounding lets it be.
const fn missing<R: Scalar>() -> f64 {
    if R::EPSILON < 1e-12 { 1e7 } else { 1e4 }
}

/// Which conditions torques could not meet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum GaveWay {
    /// All were met.
    #[default]
    Nothing,
    /// The foot whose letting go ends the phase slips: nothing is left over to prevent it.
    LettingGo,
    /// Limits were kept; outputs have other accelerations than was asked for, as little as possible.
    Outputs,
    /// Limits of the ground contradict those of the drives: torques were clamped.
    Ground,
}

/// The memory, by what stands there.
pub(super) struct Room<'m, R> {
    /// Of the present phase; φ is any.
    pub arguments: &'m mut [R],
    /// Of the present call.
    pub present: &'m mut [R],
    /// Gait parameters of the next step.
    pub asked: &'m mut [R],
    pub controlled: &'m mut [R],
    pub wanted: &'m mut [R],
    pub lie: &'m mut [R],
    pub feedforward: &'m mut [R],
    pub torques: &'m mut [R],
    pub rows: &'m mut [R],
    pub bounds: &'m mut [R],
    pub search: &'m mut [R],
}

impl<'m, R> Room<'m, R> {
    pub fn of(memory: &'m mut [R], layout: &PhasedLayout) -> Option<Self> {
        let PhasedLayout { outputs, joints, .. } = *layout;
        let (arguments, rest) = memory.split_at_mut_checked(layout.arguments())?;
        let (present, rest) = rest.split_at_mut_checked(layout.arguments())?;
        let (asked, rest) = rest.split_at_mut_checked(layout.parameters)?;
        let (controlled, rest) = rest.split_at_mut_checked(2 * (1 + outputs))?;
        let (wanted, rest) = rest.split_at_mut_checked(2 * outputs)?;
        let (lie, rest) = rest.split_at_mut_checked(layout.lie())?;
        let (feedforward, rest) = rest.split_at_mut_checked(joints)?;
        let (torques, rest) = rest.split_at_mut_checked(joints)?;
        let (rows, rest) = rest.split_at_mut_checked(layout.rows() * joints)?;
        let (bounds, search) = rest.split_at_mut_checked(layout.rows())?;
        Some(Self {
            arguments,
            present,
            asked,
            controlled,
            wanted,
            lie,
            feedforward,
            torques,
            rows,
            bounds,
            search,
        })
    }

    /// The results of a phase's functions: as many numbers as it has outputs and forces.
    pub fn cut(self, layout: &PhasedLayout, phase: &PhaseLayout) -> Option<Self> {
        let Self { controlled, wanted, lie, .. } = self;
        let height = phase.outputs + phase.forces;
        Some(Self {
            controlled: controlled.get_mut(..2 * (1 + phase.outputs))?,
            wanted: wanted.get_mut(..2 * phase.outputs)?,
            lie: lie.get_mut(..height * (3 + layout.joints))?,
            ..self
        })
    }
}

/// What torques are asked for.
pub(super) struct Asked<'a, R> {
    pub layout: &'a PhasedLayout,
    pub phase: &'a PhaseLayout,
    pub feedback: Feedback<R>,
    /// Limits of the ground hold.
    pub grounded: bool,
    /// Limits of the drives hold.
    pub limited: bool,
}

/// What there is to say of torques.
pub(super) struct Chosen<R> {
    pub error: R,
    pub limit: Option<Limit>,
    pub limits: usize,
    pub gave_way: GaveWay,
}

impl<R: Scalar> Room<'_, R> {
    /// Torques into `torques`, from `lie` and `feedforward`.
    pub fn choose(
        mut self,
        asked: &Asked<'_, R>,
        effort: impl Fn(usize) -> Option<f64>,
    ) -> Result<Chosen<R>, Refusal> {
        let effort = |joint: usize| effort(joint).filter(|_| asked.limited);
        let (mut letting_go, mut gave_way) = (None, GaveWay::Nothing);
        let (error, mut size) = self.conditions(asked, &effort, None);
        let (mut outcome, mut active) = self.search(asked, size).ok_or(Refusal::WrongLength)?;
        if asked.grounded && outcome == Outcome::Found {
            let forces = Forces { lie: self.lie, layout: asked.phase };
            letting_go = forces.letting_go(asked.layout.friction, self.torques);
        }
        if letting_go.is_some() {
            size = self.conditions(asked, &effort, letting_go).1;
            (outcome, active) = self.search(asked, size).ok_or(Refusal::WrongLength)?;
            if outcome != Outcome::Found {
                gave_way = GaveWay::LettingGo;
                letting_go = None;
                size = self.conditions(asked, &effort, None).1;
                (outcome, active) = self.search(asked, size).ok_or(Refusal::WrongLength)?;
            }
        }
        let mut equations = size.equations;
        match outcome {
            Outcome::Found => {}
            Outcome::Dependent => return Err(Refusal::SingularOutputs),
            Outcome::Impossible | Outcome::Unfinished => {
                size = self.all_as_rows(asked, &effort, letting_go);
                let (compromise, found) = self.compromise(asked, size).ok_or(Refusal::WrongLength)?;
                (gave_way, active, equations) = (GaveWay::Outputs, found, 0);
                if compromise != Outcome::Found {
                    gave_way = GaveWay::Ground;
                    self.clamp(asked, &effort)?;
                }
            }
        }
        if !self.torques.iter().all(|x| x.is_finite()) {
            return Err(Refusal::NotFinite);
        }
        let held = || active.all().filter_map(|row| row.checked_sub(equations));
        let limit = held().last().and_then(|row| named(asked, (row, letting_go)));
        Ok(Chosen { error, limit, limits: held().count(), gave_way })
    }

    /// Writes them: outputs and the push of a foot that is let go; ground; torques' limits behind the bounds. The largest output, and how many
    /// there are.
    fn conditions(
        &mut self,
        asked: &Asked<'_, R>,
        effort: &impl Fn(usize) -> Option<f64>,
        letting_go: Option<LettingGo<R>>,
    ) -> (R, Size) {
        let Asked { layout, phase, feedback, .. } = asked;
        let (joints, zero) = (layout.joints, R::constant(0.0));
        let mut writer = Writer { rows: self.rows, bounds: self.bounds, size: joints, count: 0 };
        let forces = Forces { lie: self.lie, layout: phase };
        let height = phase.outputs + phase.forces;
        let mut error = zero;
        for output in 0..phase.outputs {
            let of = |column: usize| get(self.lie, column * height + output);
            error = error.larger(of(0).abs());
            writer.push(feedback.at(of(0), of(1)) - of(2), |joint| of(3 + joint));
        }
        letting_go.iter().for_each(|of| forces.keep_push(of, &mut writer));
        let equations = writer.count;
        if asked.grounded {
            forces.write(layout, &mut writer);
        }
        letting_go.iter().for_each(|of| forces.keep_from_slipping(of, &mut writer));
        let count = writer.count;
        let limits = if asked.limited { joints } else { 0 };
        for (joint, place) in self.bounds.iter_mut().skip(count).take(limits).enumerate() {
            *place = R::constant(effort(joint).unwrap_or(f64::INFINITY));
        }
        let size = Size { equations, count, limits };
        self.these(asked, size).normalise();
        (error, size)
    }

    /// The same with rows for the torques' limits.
    fn all_as_rows(
        &mut self,
        asked: &Asked<'_, R>,
        effort: &impl Fn(usize) -> Option<f64>,
        letting_go: Option<LettingGo<R>>,
    ) -> Size {
        let (_, Size { equations, count, limits }) = self.conditions(asked, effort, letting_go);
        let mut writer = Writer { rows: self.rows, bounds: self.bounds, size: asked.layout.joints, count };
        for joint in 0..limits {
            let limit = R::constant(effort(joint).unwrap_or(f64::INFINITY));
            for sign in [1.0, -1.0] {
                writer.push(limit, |k| R::constant(if k == joint { sign } else { 0.0 }));
            }
        }
        Size { equations, count: writer.count, limits: 0 }
    }

    /// The conditions that were written.
    fn these(&mut self, asked: &Asked<'_, R>, size: Size) -> Conditions<'_, R> {
        size.conditions(asked.layout.joints, self.rows, self.bounds)
    }

    /// The least change of the feed-forward that meets all conditions.
    fn search(&mut self, asked: &Asked<'_, R>, size: Size) -> Option<(Outcome, Active)> {
        copy(self.feedforward, self.torques);
        let joints = asked.layout.joints;
        let conditions = size.conditions(joints, self.rows, self.bounds);
        let mut active = Active::new();
        let mut room = Search::of(self.search, joints)?;
        Some((nearest(&conditions, self.torques, &mut room, &mut active), active))
    }

    /// The same where only limits are to be met; they are changed by it.
    fn compromise(&mut self, asked: &Asked<'_, R>, rows: Size) -> Option<(Outcome, Active)> {
        let size = asked.layout.joints;
        copy(self.feedforward, self.torques);
        let (search, rest) = self.search.split_at_mut_checked(size * (2 * size + 4))?;
        let (factor, rest) = rest.split_at_mut_checked(size * size)?;
        let (centre, rest) = rest.split_at_mut_checked(size)?;
        let work = (factor, centre, rest.get_mut(..size)?);
        let conditions = rows.conditions(size, self.rows, self.bounds);
        let mut active = Active::new();
        let mut room = Search::of(search, size)?;
        let found =
            nearest_compromise(conditions, self.torques, missing::<R>(), work, &mut room, &mut active);
        Some((found, active))
    }

    /// What the outputs ask for, clamped to the drives' limits.
    fn clamp(&mut self, asked: &Asked<'_, R>, effort: &impl Fn(usize) -> Option<f64>) -> Result<(), Refusal> {
        let grounded = Asked { grounded: false, limited: false, feedback: asked.feedback, ..*asked };
        let (_, size) = self.conditions(&grounded, &|_| None, None);
        match self.search(&grounded, size) {
            Some((Outcome::Found, _)) => {}
            _ => return Err(Refusal::SingularOutputs),
        }
        for (joint, torque) in self.torques.iter_mut().enumerate() {
            let limit = effort(joint).map(R::constant);
            if let Some(limit) = limit.filter(|limit| torque.abs() > *limit) {
                *torque = torque.sign() * limit;
            }
        }
        Ok(())
    }
}

/// How many rows are equations, how many rows there are, and how many limits stand behind their bounds.
#[derive(Clone, Copy)]
struct Size {
    equations: usize,
    count: usize,
    limits: usize,
}

impl Size {
    fn conditions<'m, R>(self, size: usize, rows: &'m mut [R], bounds: &'m mut [R]) -> Conditions<'m, R> {
        let Self { equations, count, limits } = self;
        let (bounds, behind) = bounds.split_at_mut(count.min(bounds.len()));
        let limits = behind.get(..limits).unwrap_or(&[]);
        Conditions { rows, bounds, size, equations, count, limits }
    }
}

/// Which limit a condition behind the equations is.
fn named<R>(asked: &Asked<'_, R>, (row, letting_go): (usize, Option<LettingGo<R>>)) -> Option<Limit> {
    let of_ground = || rows(asked.phase, asked.layout.friction.is_some()).take_while(|_| asked.grounded);
    let Some(behind) = row.checked_sub(of_ground().count()) else { return of_ground().nth(row) };
    match letting_go {
        Some(of) if behind < 2 => Some(Limit::Friction(of.number as u8)),
        of => Some(Limit::Torque(((behind - 2 * usize::from(of.is_some())) / 2).min(255) as u8)),
    }
}
