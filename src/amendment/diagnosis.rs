//! From a diagnosis to a proposal.
use super::history::{BeforeAfter, ChannelError};
use super::{Proposal, Proposed, Request, is_same};
use bipedc_analysis::diagnose::{Diagnosis, ErrorFall as Measured, FoundEffect, Step, StepErrors};
use bipedc_effects::diagnostic::Diagnostic;
use std::collections::BTreeMap;

/// Kinds of channels, the one that a diagnosis is about first.
const CHANNELS: [&str; 3] = ["post_impact_velocity", "cop", "effort"];

/// What to take of a diagnosis.
#[derive(Debug, Clone, Default)]
pub struct Selection {
    /// Numbers from 1, `KIND` or `KIND:PLACE`; empty: all effects.
    pub only: Vec<String>,
    /// Of a selection: also its corrections of masses and inertias, which belong to all effects together.
    pub corrections: bool,
    /// Add even where an effect of the kind stands.
    pub add: bool,
}

/// The effects that were asked for, in the order in which they entered, with their errors as far as the diagnosis
/// knows them: the error with some effects is known if they were the first to enter.
///
/// # Errors
/// A selection that the diagnosis does not have.
pub fn propose(diagnosis: &Diagnosis, selection: &Selection, origin: &str) -> Result<Proposal, Diagnostic> {
    let mut chosen = choose(diagnosis, &selection.only)?;
    let entered =
        |found: &FoundEffect| diagnosis.steps.iter().position(|s| is_same(&s.effect, &found.effect));
    chosen.sort_by_key(|found| entered(found).unwrap_or(usize::MAX));
    let request = if selection.add { Request::Add } else { Request::Put };
    let main = main_channel(diagnosis);
    let mut effects: Vec<Proposed> = Vec::new();
    for (index, found) in chosen.iter().enumerate() {
        // Beside corrections no effect has an error of its own.
        let alone = diagnosis.inertial_corrections.is_empty();
        let step = diagnosis.steps.get(index).filter(|step| alone && is_same(&step.effect, &found.effect));
        // After the first that is out of order the errors are those of another model.
        let known = effects.iter().all(|before| before.error.is_some());
        let of_step = |(step, (channel, rms)): (&Step, (&str, &Measured))| {
            let all = diagnosis.step_errors.get(index);
            all.and_then(|all| step_error(diagnosis, all, channel)).unwrap_or_else(|| ChannelError {
                channel: channel.to_owned(),
                unit: rms.unit.clone(),
                held_out: Some(BeforeAfter { before: step.before, after: step.after }),
                training: None,
                noise: rms.noise,
            })
        };
        let error = step.filter(|_| known).zip(main).map(of_step);
        effects.push(proposed(found, error, request));
    }
    // What was estimated together belongs together, unless somebody chooses.
    let corrections = selection.only.is_empty() || selection.corrections;
    let complete =
        chosen.len() == diagnosis.effects.len() && (corrections || diagnosis.inertial_corrections.is_empty());
    let (errors, note) = if complete { (all_channels(diagnosis), None) } else { errors(&effects) };
    if corrections {
        let corrections = diagnosis.inertial_corrections.iter();
        effects.extend(corrections.map(|found| proposed(found, None, Request::Increase)));
    }
    // Effects that stood already and were estimated again belong to the estimates of the others.
    effects.extend(diagnosis.standing.iter().map(|found| proposed(found, None, Request::Put)));
    let training = (!diagnosis.training.file.is_empty()).then(|| diagnosis.training.clone());
    let validation = diagnosis.validation.clone();
    let origin = origin.to_owned();
    let filter_hz = diagnosis.judged_at_hz.unwrap_or(diagnosis.cutoff_hz);
    let cutoff_hz = (filter_hz > 0.0 && !errors.is_empty()).then_some(filter_hz);
    Ok(Proposal { effects, origin, training, validation, errors, cutoff_hz, note, ..Proposal::default() })
}

/// How the error fell with a step, in the channel that tells most of it.
fn step_error(diagnosis: &Diagnosis, all: &StepErrors, main: &str) -> Option<ChannelError> {
    let channel = all.telling(main);
    let fall = |[before, after]: &[f64; 2]| BeforeAfter { before: *before, after: *after };
    let rms = diagnosis.rms.get(channel)?;
    Some(ChannelError {
        channel: channel.to_owned(),
        unit: rms.unit.clone(),
        held_out: Some(fall(all.held_out.get(channel)?)),
        training: all.training.get(channel).map(fall),
        noise: rms.noise,
    })
}

fn proposed(found: &FoundEffect, error: Option<ChannelError>, request: Request) -> Proposed {
    Proposed { effect: found.effect.clone(), ci95: found.ci95.clone(), error, request }
}

fn choose<'d>(diagnosis: &'d Diagnosis, only: &[String]) -> Result<Vec<&'d FoundEffect>, Diagnostic> {
    let mut chosen = vec![only.is_empty(); diagnosis.effects.len()];
    for wanted in only {
        let matches = |index: usize, found: &FoundEffect| match wanted.parse::<usize>() {
            Ok(number) => number == index + 1,
            Err(_) => wanted == found.effect.kind.name || wanted == &name(found),
        };
        let hits: Vec<usize> =
            (0..chosen.len()).filter(|&index| matches(index, &diagnosis.effects[index])).collect();
        if hits.is_empty() {
            let list = diagnosis.effects.iter().zip(1..).map(|(found, n)| format!("{n} {}", name(found)));
            let list: Vec<String> = list.collect();
            let list = if list.is_empty() { "it has none".to_owned() } else { list.join(", ") };
            let corrections = if diagnosis.inertial_corrections.is_empty() {
                ""
            } else {
                "; its inertial corrections are taken with --with-corrections alone"
            };
            return Err(Diagnostic::error(format!("the diagnosis has no effect `{wanted}`"))
                .help(format!("its effects are: {list}{corrections}")));
        }
        hits.into_iter().for_each(|index| chosen[index] = true);
    }
    Ok(diagnosis.effects.iter().zip(chosen).filter_map(|(found, taken)| taken.then_some(found)).collect())
}

/// `KIND:PLACE`
fn name(found: &FoundEffect) -> String {
    format!("{}:{}", found.effect.kind, found.effect.location)
}

/// The channel that `rms_before` is about.
fn main_channel(diagnosis: &Diagnosis) -> Option<(&str, &Measured)> {
    let by_name = |name: &&str| diagnosis.rms.get_key_value(*name);
    let found = CHANNELS.iter().filter_map(by_name).find(|(_, rms)| rms.before == diagnosis.rms_before);
    let found = found.or_else(|| CHANNELS.iter().find_map(by_name)).or_else(|| diagnosis.rms.iter().next());
    found.map(|(name, rms)| (name.as_str(), rms))
}

/// Errors of a part of the effects, as far as they are known.
fn errors(chosen: &[Proposed]) -> (Vec<ChannelError>, Option<String>) {
    let falls: Option<Vec<&ChannelError>> = chosen.iter().map(|proposed| proposed.error.as_ref()).collect();
    // Falls of different channels do not add up.
    let one = |falls: &&Vec<&ChannelError>| falls.windows(2).all(|pair| pair[0].channel == pair[1].channel);
    let ends = falls.as_ref().filter(one).and_then(|falls| Some((*falls.first()?, *falls.last()?)));
    match ends {
        Some((first, last)) => {
            let both = |fall: fn(&ChannelError) -> Option<BeforeAfter>| {
                Some(BeforeAfter { before: fall(first)?.before, after: fall(last)?.after })
            };
            let (held_out, training) = (both(|error| error.held_out), both(|error| error.training));
            (vec![ChannelError { held_out, training, ..last.clone() }], None)
        }
        None => {
            let note = "the error with these effects alone is not known: bipedc compare measures it";
            (Vec::new(), Some(note.to_owned()))
        }
    }
}

fn all_channels(diagnosis: &Diagnosis) -> Vec<ChannelError> {
    let main = diagnosis.telling_channel().or(main_channel(diagnosis).map(|(name, _)| name));
    let fall = |rms: &Measured| BeforeAfter { before: rms.before, after: rms.after };
    let of = |map: &BTreeMap<String, Measured>, name: &str| map.get(name).map(fall);
    let mut list: Vec<ChannelError> = diagnosis
        .rms
        .iter()
        .map(|(name, rms)| ChannelError {
            channel: name.clone(),
            unit: rms.unit.clone(),
            held_out: Some(fall(rms)),
            training: of(&diagnosis.rms_training, name),
            noise: rms.noise,
        })
        .collect();
    list.sort_by_key(|error| Some(error.channel.as_str()) != main);
    list
}
