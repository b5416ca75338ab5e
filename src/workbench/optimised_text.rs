//! Gaits that were found, for people.
use super::closed_loop::PhaseCourses;
use super::optimised::{Landing, OptimisedGait, OptimisedGaits, Violated};
use super::search::Beginning;
use crate::table::table;
use std::fmt;

/// A number with so many decimals; none is "-0.0000".
pub(super) fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let nothing = text.starts_with('-') && text.chars().all(|c| matches!(c, '-' | '0' | '.'));
    if nothing { text[1..].to_owned() } else { text }
}

/// As many violated constraints as are told.
const TOLD: usize = 12;

impl fmt::Display for Landing {
    /// Nothing where the landing is no question.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { phase, push, asked, toe_joints } = self;
        if push >= asked {
            return Ok(());
        }
        writeln!(
            f,
            "\nin the best posture found, the landing that ends {phase} pushes with no more than {push:.3e} N s on every foot that stands, {asked:.3e} N s are \
             asked for: a smaller --impulse, another foot"
        )?;
        if toe_joints.is_empty() {
            return Ok(());
        }
        writeln!(
            f,
            "{}: not above the sole, which is that of toes alone. A toe that lands in front of its joint pulls the toe behind off the ground: lock these joints ([joints] locked of \
             biped.toml) and describe feet whose heel is behind the ankle",
            toe_joints.join(", ")
        )
    }
}

/// Words with which constraints begin, and the option that asks for less there.
const OPTIONS: [(&str, &str); 5] = [
    ("impact holds", "a smaller --impulse"),
    ("clearance of", "a smaller --clearance"),
    ("friction of", "a larger --friction"),
    ("centre of pressure", "a smaller --zmp"),
    ("centre of the impulse", "a smaller --zmp"),
];

/// What to ask for instead, by the constraints that were missed.
fn what_may_help(violations: &[Violated]) -> String {
    let mut named: Vec<&str> = Vec::new();
    for violated in violations {
        let fits = OPTIONS.iter().find(|(begins, _)| violated.constraint.starts_with(begins));
        if let Some((_, option)) = fits.filter(|(_, option)| !named.contains(option)) {
            named.push(option);
        }
    }
    named.truncate(4);
    named.push("a --start from a gait that was found with less asked for, or at another speed");
    format!("what may help: {}", named.join("; "))
}

impl fmt::Display for OptimisedGaits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.wished)?;
        for gait in &self.gaits {
            if gait.impulse < self.wished.impulse {
                writeln!(
                    f,
                    "of the usual impulse of {:.4} N s, {:.4} N s are asked for at {} m/s: the landing of the toe pushes with little more in any posture that was found\n",
                    self.wished.impulse, gait.impulse, gait.speed
                )?;
            }
            writeln!(f, "{gait}")?;
        }
        if !self.complete {
            writeln!(f, "interrupted: speeds are missing")?;
        }
        Ok(())
    }
}

impl fmt::Display for OptimisedGait {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ended = match (self.feasible, self.minimum) {
            (true, true) => "a minimum",
            (true, false) => "feasible, the search ended before a minimum",
            (false, _) => "not found",
        };
        let rounds = if self.rounds == 1 { "round" } else { "rounds" };
        write!(
            f,
            "{} m/s: {ended}, {} iterations in {} {rounds}, ",
            self.speed, self.iterations, self.rounds
        )?;
        match self.taken_over {
            true => writeln!(f, "found by an earlier run and taken over")?,
            false => writeln!(f, "{:.2} s", self.seconds)?,
        }
        self.write_beginnings(f)?;
        if let Some(reach) = self.reach.as_ref().filter(|_| !self.feasible) {
            write!(f, "{reach}")?;
            return self.landing.iter().try_for_each(|landing| write!(f, "{landing}"));
        }
        if !self.feasible {
            let row = |violated: &Violated| {
                let node = violated.node.map_or_else(|| "end".to_owned(), |node| node.to_string());
                vec![
                    violated.constraint.clone(),
                    violated.phase.clone(),
                    node,
                    format!("{:+.3e}", violated.by),
                ]
            };
            if self.violations.is_empty() {
                return writeln!(
                    f,
                    "\nthe search ended with numbers that are none, or was stopped: no constraint can be named"
                );
            }
            let rows: Vec<Vec<String>> = self.violations.iter().take(TOLD).map(row).collect();
            let left = self.violations.len().saturating_sub(TOLD);
            write!(f, "\n{}", table(&["violated", "phase", "node", "by (SI)"], rows, 2))?;
            if left > 0 {
                writeln!(f, "and {left} more")?;
            }
            writeln!(f, "\n{}", what_may_help(&self.violations))?;
            return self.landing.iter().try_for_each(|landing| write!(f, "{landing}"));
        }
        write!(f, "\n{}", table(&["", "motion", "walked", "unit"], self.numbers(), 1))?;
        match &self.closed_loop {
            Some(tried) if !tried.walks => {
                let why = tried.reason.as_deref().unwrap_or("deviations grow");
                writeln!(
                    f,
                    "\nthe motion is possible, but under its controller the robot does not walk: {why}"
                )
            }
            _ if !self.lacking.is_empty() => {
                writeln!(f, "\nit walks; of what was wished this is missing: {}", self.lacking.join(", "))
            }
            _ => Ok(()),
        }
    }
}

impl OptimisedGait {
    /// What each beginning of the first search came to, where there were several.
    fn write_beginnings(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.beginnings.is_empty() {
            return Ok(());
        }
        let row = |beginning: &Beginning| {
            let Beginning { step, feasible, cost, cost_of_transport, kept } = beginning;
            let number = |value: &f64| if *feasible { fixed(*value, 4) } else { "—".to_owned() };
            let end = match (kept, feasible) {
                (true, true) => "kept",
                (_, false) => "not found",
                _ => "",
            };
            vec![fixed(*step, 3), number(cost), number(cost_of_transport), end.to_owned()]
        };
        let head = ["first steps, m", "cost", "cost of transport", ""];
        write!(f, "\n{}", table(&head, self.beginnings.iter().map(row).collect(), 0))
    }

    /// As the motion has them at its nodes, and as the robot under its controller has them over whole steps.
    fn numbers(&self) -> Vec<Vec<String>> {
        let (margins, tried) = (&self.margins, self.closed_loop.as_ref());
        let walked = tried.and_then(|tried| tried.margins.as_ref());
        let of = |number: Option<Option<f64>>| number.flatten();
        let duration: f64 = self.durations.iter().sum();
        let speed_unit = tried.map_or("1/s", |tried| tried.speed_unit.as_str());
        let rows = [
            ("walking speed", Some(self.step_length / duration), of(tried.map(|t| t.walking_speed)), "m/s"),
            ("duration of a step", Some(duration), of(tried.map(|t| t.duration)), "s"),
            ("step length", Some(self.step_length), None, "m"),
            ("multiplier", None, of(tried.map(|t| t.multiplier)), "1"),
            ("speed at mid-stance", None, of(tried.map(|t| t.speed)), speed_unit),
            ("cost of transport", Some(self.cost_of_transport), of(tried.map(|t| t.cost_of_transport)), "1"),
            ("friction needed", Some(margins.friction), walked.map(|w| w.friction), "1"),
            (
                "friction needed by impacts",
                margins.impact_friction,
                of(walked.map(|w| w.impact_friction)),
                "1",
            ),
            ("smallest vertical impulse", margins.impulse, of(walked.map(|w| w.impulse)), "N s"),
            ("smallest vertical force", Some(margins.push), None, "N"),
            ("centre of pressure inside by", margins.zmp, of(walked.map(|w| w.zmp)), "m"),
            ("clearance", margins.clearance, of(walked.map(|w| w.clearance)), "m"),
            ("torque below its limit by", margins.torque, of(walked.map(|w| w.torque)), "N m"),
            ("largest torque", Some(margins.largest_torque), None, "N m"),
            ("joint inside its limits by", margins.joint, of(walked.map(|w| w.joint)), "rad or m"),
            ("velocity below its limit by", margins.velocity, of(walked.map(|w| w.velocity)), "rad/s or m/s"),
        ];
        let number = |value: Option<f64>| value.map_or_else(|| "—".to_owned(), |value| fixed(value, 6));
        let row = |(name, motion, walked, unit): (&str, Option<f64>, Option<f64>, &str)| {
            vec![name.to_owned(), number(motion), number(walked), unit.to_owned()]
        };
        let phases = tried.map_or(&[][..], |tried| &tried.phases);
        let of_phase = |phase: &PhaseCourses| {
            let name = format!("duration of {}", phase.name);
            row((&name, Some(phase.motion.duration), Some(phase.walked.duration), "s"))
        };
        rows.into_iter().map(row).chain(phases.iter().map(of_phase)).collect()
    }
}
