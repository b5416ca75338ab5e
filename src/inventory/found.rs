//! From what was seen to the inventory.
use super::pass::{Seen, Stamp};
use super::plan::Plan;
use super::statistics::Values;
use super::{ColumnFound, Entry, Inventory, Proposal, Robot, RobotChannels, Sampling, Source};
use bipedc_analysis::log::{Kind, names};
use bipedc_effects::diagnostic::Diagnostic;
use std::path::Path;

/// What is known of a file but for its rows.
pub(super) struct Found<'a> {
    pub path: &'a Path,
    pub plans: Vec<Plan>,
    pub kind: Kind,
    pub has_header: bool,
    pub proposal: Proposal,
    pub robot: Option<&'a Robot>,
}

impl Found<'_> {
    /// With what the rows have shown.
    pub fn finish(mut self, mut seen: Seen, stamp: Stamp) -> Inventory {
        let stamp = self.settle(&mut seen, stamp);
        let (factor, column) = match stamp {
            Stamp::One { field, factor, .. } => (factor, self.plans[field].name.clone()),
            _ => (1.0, "header/stamp".to_owned()),
        };
        let clock = std::mem::take(&mut seen.clock);
        let sampling = if stamp == Stamp::None { None } else { clock.sampling(&column, factor) };
        let warnings = self.warnings(&seen, sampling.as_ref(), stamp);
        let columns: Vec<ColumnFound> =
            self.plans.iter().zip(&seen.values).map(|(plan, values)| self.column(plan, values)).collect();
        let robot = self.robot.map(|robot| RobotChannels::of(robot, &columns));
        Inventory {
            file: self.path.display().to_string(),
            kind: self.kind.column(),
            rows: seen.rows,
            has_header: self.has_header,
            sampling,
            columns,
            robot,
            sources: self.sources(),
            proposal: self.proposal,
            warnings,
            stamp,
        }
    }

    /// The unit of the time stamps, now that their steps are known; a clock of another name or unit becomes an entry.
    fn settle(&mut self, seen: &mut Seen, stamp: Stamp) -> Stamp {
        let Stamp::One { field, factor, offset } = stamp else {
            return if let Stamp::Two { .. } = stamp { Stamp::Two { from: seen.began } } else { stamp };
        };
        // Who maps the clock says its unit.
        if self.plans[field].taken.as_ref().is_some_and(|taken| taken.mapped) {
            return stamp;
        }
        let (scale, unit) = match seen.clock.step() {
            Some(1e5..) => (1e-9, Some("ns")),
            Some(100.0..) => (1e-6, Some("µs")),
            Some(0.999..) => (1e-3, Some("ms")),
            _ => (factor, None),
        };
        let taken = &mut self.plans[field].taken;
        if unit.is_some() || taken.is_none() {
            *taken = None;
            let column = self.plans[field].name.clone();
            if let Some(unit) = unit {
                self.proposal
                    .assumptions
                    .push(format!("`{column}` is in {unit}: its steps are too long for seconds"));
            }
            let unit = unit.map(str::to_owned);
            let entry = Entry { name: "time".to_owned(), column, scale, unit, field };
            self.proposal.entries.insert(0, entry);
        }
        Stamp::One { field, factor: scale, offset }
    }

    /// What can be written under our names; the clock is written apart.
    fn sources(&self) -> Vec<Source> {
        let entry = |plan: &Plan| self.proposal.entries.iter().find(|entry| entry.field == plan.field);
        let source = |plan: &Plan| match (entry(plan), &plan.taken) {
            (Some(entry), _) => Some((entry.name.clone(), entry.scale, 0.0)),
            (None, Some(taken)) => Some((taken.name.clone(), taken.factor, taken.offset)),
            (None, None) => None,
        };
        let sources = self.plans.iter().filter_map(|plan| Some((plan.field, source(plan)?)));
        let sources = sources.map(|(field, (name, factor, offset))| Source { name, field, factor, offset });
        sources.filter(|source| source.name != "time").collect()
    }

    fn column(&self, plan: &Plan, values: &Values) -> ColumnFound {
        let entry = self.proposal.entries.iter().find(|entry| entry.field == plan.field);
        let (factor, offset) = match (entry, &plan.taken) {
            (Some(entry), _) => (entry.scale, 0.0),
            (None, Some(taken)) => (taken.factor, taken.offset),
            (None, None) => (1.0, 0.0),
        };
        let ours = entry.map(|entry| &entry.name).or(plan.taken.as_ref().map(|taken| &taken.name));
        let value = |x: f64| (values.numbers > 0).then_some(factor * x + offset);
        let (least, most) =
            if factor < 0.0 { (values.most, values.least) } else { (values.least, values.most) };
        ColumnFound {
            name: plan.name.clone(),
            number: plan.field + 1,
            taken_as: plan.taken.as_ref().map(|taken| taken.name.clone()),
            proposed: entry.map(|entry| entry.name.clone()),
            unit: ours.and_then(|name| self.unit(name)),
            least: value(least),
            most: value(most),
            constant: values.numbers > 1 && values.least == values.most,
            missing: values.missing,
            first_missing: values.first_missing,
            unusable: values.unusable.clone(),
        }
    }

    fn unit(&self, column: &str) -> Option<String> {
        let unit = names::unit(column)?;
        let slides = names::joint_of(column).is_some_and(|joint| self.robot.is_some_and(|r| r.slides(joint)));
        let unit = match unit {
            _ if !slides || column.ends_with("/motor_position") => unit,
            "rad" => "m",
            "rad/s" => "m/s",
            "rad/s²" => "m/s²",
            "N m" => "N",
            other => other,
        };
        Some(unit.to_owned())
    }

    fn warnings(&self, seen: &Seen, sampling: Option<&Sampling>, stamp: Stamp) -> Vec<Diagnostic> {
        let mut warnings = Vec::new();
        let mut warn = |line: usize, message: String, help: &str| {
            warnings.push(Diagnostic::warning(message).in_file(self.path).at(line, 0).help(help));
        };
        if stamp == Stamp::None && self.kind == Kind::Time {
            let help = "a log begins with the column `time` (s); if another column has it, say so in a mapping file: time = \"…\"";
            warn(1, "no column has the time of the rows".to_owned(), help);
        }
        if let (count @ 1.., line) = seen.ragged {
            let help =
                "was the file cut off here, or is a comma used in numbers? Other commands refuse such a row";
            warn(line, format!("{count} rows have another number of fields than the header"), help);
        }
        if let (count @ 1.., line) = seen.other_joints {
            let help = "do several programs publish this topic? Record that of one of them";
            warn(
                line,
                format!("{count} rows are of other joints than the first row, or in another order"),
                help,
            );
        }
        let Some(sampling) = sampling else { return warnings };
        let help = "other commands take such rows together; log time with more digits if they are not copies";
        if let Some(line) = sampling.first_doubled {
            warn(line, format!("{} rows have the time of the row before", sampling.doubled), help);
        }
        if let Some(line) = sampling.first_backward {
            let help = "other commands sort rows that are a little late, and refuse a clock that starts anew: split the file there";
            warn(line, format!("time runs back in {} rows", sampling.backward), help);
        }
        if sampling.without_time > 0 {
            warn(0, format!("{} rows have no time", sampling.without_time), "remove them");
        }
        warnings
    }
}
