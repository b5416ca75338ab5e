//! Single readings of efforts that no torque of the joint comes near: lost bits, a message that was mixed up.
use crate::log::Block;
use crate::measure::columns::Plan;
use crate::parallel::parallel;
use crate::robot::{Joint, JointLayout};
use bipedc_effects::diagnostic::Diagnostic;

/// A reading is wild that is so many times as far from the middle as 99 of 100 are,
const FAR: f64 = 10.0;
const USUAL: f64 = 0.99;
/// with no more than so many neighbours that are wild too: a shock lasts longer at the rates of logs.
const ALONE: usize = 2;
/// Fewer samples tell nothing, and more than this part of them is no accident.
const FEWEST: usize = 200;
const MOST: f64 = 2e-3;

/// Wild readings of one effort.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Wild {
    count: usize,
    /// The first one, and what 99 of 100 stay within, unit of the effort.
    first: usize,
    value: f64,
    usual: f64,
}

impl Wild {
    fn of(values: &[f64]) -> Option<Self> {
        if values.len() < FEWEST {
            return None;
        }
        let at = |values: &mut [f64], part: f64| {
            let index = ((values.len() - 1) as f64 * part) as usize;
            *values.select_nth_unstable_by(index, f64::total_cmp).1
        };
        let middle = at(&mut values.to_vec(), 0.5);
        let usual = at(&mut values.iter().map(|x| (x - middle).abs()).collect::<Vec<f64>>(), USUAL);
        let is_far = |x: &f64| (x - middle).abs() > FAR * usual;
        let far: Vec<usize> = (0..values.len()).filter(|&i| is_far(&values[i])).collect();
        let together = far.chunk_by(|a, b| b - a == 1).any(|run| run.len() > ALONE);
        let few = far.len() as f64 <= (MOST * values.len() as f64).max(1.0);
        let first = *far.first().filter(|_| usual > 0.0 && few && !together)?;
        Some(Self { count: far.len(), first, value: values[first], usual })
    }
}

/// Joints of a log of whose efforts wild readings were told.
#[derive(Default)]
pub(crate) struct WildEfforts {
    told: Vec<bool>,
}

impl WildEfforts {
    /// A warning for each joint of which a block has wild readings of its effort, once.
    pub fn look(&mut self, plan: &Plan, layout: &JointLayout, block: &Block<'_>) -> Vec<Diagnostic> {
        self.told.resize(plan.joints.len(), false);
        let times = &block.time[block.core.clone()];
        let found = parallel(plan.joints.len(), |joint| {
            let effort = plan.joints[joint].effort.filter(|_| !self.told[joint])?;
            Wild::of(&block.columns[effort][block.core.clone()])
        });
        self.told.iter_mut().zip(&found).for_each(|(told, wild)| *told |= wild.is_some());
        let joints = layout.joints.iter().zip(found);
        joints.filter_map(|(joint, wild)| Some(warning(joint, wild?, times))).collect()
    }
}

fn warning(joint: &Joint, Wild { count, first, value, usual }: Wild, times: &[f64]) -> Diagnostic {
    let more = if count > 1 { format!(", and so far off at least {count} times") } else { String::new() };
    let message = format!(
        "`{}/effort` is {value} {unit} at {} s, where 99 of 100 readings lie within {usual:.3} {unit} of the middle one{more}: wild readings, which pull at every error and estimate",
        joint.name,
        times[first],
        unit = joint.unit(),
    );
    Diagnostic::warning(message).help("leave these fields empty: their rows are then passed over")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn single_wild_readings_are_told_and_shocks_are_not() {
        let quiet: Vec<f64> = (0..2000).map(|i| 2.0 + (0.01 * f64::from(i)).sin()).collect();
        assert_eq!(Wild::of(&quiet), None);
        let mut wild = quiet.clone();
        (wild[700], wild[1200]) = (1e6, -40.0);
        let found = Wild::of(&wild).unwrap();
        assert_eq!((found.count, found.first, found.value), (2, 700, 1e6));
        // A foot that lands.
        let mut shock = quiet.clone();
        shock[500..506].fill(60.0);
        assert_eq!(Wild::of(&shock), None);
        // A joint that hardly does anything but now and then.
        let seldom: Vec<f64> = (0..2000).map(|i| if i % 100 == 0 { 30.0 } else { 0.01 }).collect();
        assert_eq!(Wild::of(&seldom), None);
        assert_eq!(Wild::of(&vec![0.0; 2000]), None);
    }
}
