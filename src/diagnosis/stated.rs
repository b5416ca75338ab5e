//! What an answer states beside the search: the errors step by step in all channels, units, and the channel that tells most.
use bipedc_analysis::diagnose::{Diagnosis, StepErrors, left_by_kind, summary};
use bipedc_analysis::experiments::Experiment;
use bipedc_analysis::parallel::parallel;
use bipedc_effects::effect::{Effect, kinds};
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Notes how the errors fell with every step, in each kind of channel, and puts units right.
pub(super) fn state(answer: &mut Diagnosis, train: &dyn Experiment, judge: Option<&dyn Experiment>) {
    units(answer, train);
    answer.step_errors.clear();
    // Corrections of bodies belong to all effects together: then no effect has an error of its own.
    if answer.inertial_corrections.is_empty() {
        let effects: Vec<Effect> = answer.estimated().cloned().collect();
        let standing = answer.standing.len();
        let all = parallel(answer.steps.len() + 1, |count| {
            left_by_kind(train, judge, &effects[..standing + count])
        });
        let falls = |[was, is]: [&BTreeMap<String, f64>; 2]| {
            let both = was.iter().filter_map(|(name, was)| Some((name.clone(), [*was, *is.get(name)?])));
            both.collect()
        };
        let fall = |pair: &[[BTreeMap<String, f64>; 2]]| {
            let [held_out, training] = [0, 1].map(|which| falls([&pair[0][which], &pair[1][which]]));
            StepErrors { held_out, training }
        };
        answer.step_errors = all.windows(2).map(fall).collect();
    }
    answer.conclude();
    doubt_fast_ripples(answer, train);
    answer.summary = said(answer);
}

/// Part of a log's samples at which a ripple may be faster than the filter.
const FASTER: f64 = 0.5;

/// Ripples of which most periods pass faster than the filter lets through: the joint gives way to them, and what that takes back of them in the effort is not seen.
fn doubt_fast_ripples(answer: &mut Diagnosis, train: &dyn Experiment) {
    let (joints, motion) = (train.joints(), train.motion());
    let cutoff = answer.cutoff_hz;
    for found in answer.effects.iter_mut().filter(|found| found.effect.kind == &kinds::TORQUE_RIPPLE) {
        let here = |name: &&str| Some(*name) == found.effect.location.joint.as_deref();
        let Some(angles) = joints.iter().position(here).and_then(|j| motion.positions.get(j)) else {
            continue;
        };
        let turns = found.effect.value("periods_per_turn") / TAU;
        let rates =
            angles.windows(2).zip(motion.time.windows(2)).map(|(q, t)| (q[1] - q[0]).abs() / (t[1] - t[0]));
        let (fast, all) =
            rates.fold((0, 0), |(fast, all), speed| (fast + u32::from(turns * speed > cutoff), all + 1_u32));
        let doubt = format!(
            "most of its periods are faster than the filter of {cutoff} Hz: what the joint gives way to is not seen, and it may be larger"
        );
        if f64::from(fast) > FASTER * f64::from(all) && !found.doubts.contains(&doubt) {
            found.doubts.push(doubt);
        }
    }
}

/// Rows of one kind may have different units: sliding joints beside turning ones.
fn units(answer: &mut Diagnosis, experiment: &dyn Experiment) {
    for falls in [&mut answer.rms, &mut answer.rms_training] {
        for (kind, fall) in falls {
            let mut own =
                experiment.rows().iter().filter(|row| row.channel.name() == kind).map(|row| row.unit);
            let Some(first) = own.next() else { continue };
            // Velocities behind an impact are of both kinds always, which their unit says.
            if own.clone().all(|unit| unit == first) {
                first.clone_into(&mut fall.unit);
            } else if !fall.unit.contains(", ") {
                "mixed".clone_into(&mut fall.unit);
            }
        }
    }
}

/// The sentences, about the channel in which the error fell.
pub(super) fn said(answer: &Diagnosis) -> String {
    const HEAD: &str = "Held-out error ";
    let told = answer.telling_channel();
    let fall = told.and_then(|kind| Some((kind, answer.rms.get(kind)?)));
    let mut text = match fall {
        Some((kind, fall)) if fall.before != answer.rms_before => {
            let of_kind = Diagnosis { rms_before: fall.before, rms_after: fall.after, ..answer.clone() };
            let name = kind.replace('_', " ");
            summary(&of_kind).replacen(HEAD, &format!("Held-out error of the {name} "), 1)
        }
        _ => summary(answer),
    };
    if answer.rms.values().any(|fall| fall.unit == "mixed") {
        text = text.replace(" mixed", " (mixed units)");
    }
    text
}
