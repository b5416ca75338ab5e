//! Plans for people.
use super::{Plans, SpeedPlan};
use crate::table::table;
use std::fmt;

impl fmt::Display for Plans {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.ranges())?;
        match &self.plans[..] {
            [plan] => f.write_str(&self.one(plan))?,
            plans => f.write_str(&self.many(plans))?,
        }
        if !self.complete {
            writeln!(f, "\ninterrupted: plans are missing")?;
        }
        Ok(())
    }
}

impl Plans {
    fn ranges(&self) -> String {
        let head = ["each step chooses", "from", "to", "unit"];
        let rows = self.choices.iter().map(|choice| {
            let [low, high] = choice.bounds.map(|x| x.to_string());
            vec![choice.name.clone(), low, high, choice.unit.clone()]
        });
        let now: Vec<String> = self.from.iter().map(|(name, value)| format!("{name} = {value}")).collect();
        let now = match self.alike {
            true => "every step is taken as one among its own kind".to_owned(),
            false => format!("present step: {}", now.join(", ")),
        };
        format!("{}\n{now}\n", table(&head, rows.collect(), head.len()))
    }

    fn one(&self, plan: &SpeedPlan) -> String {
        let unit = &self.speed_unit;
        let names: Vec<&str> = self.from.keys().map(String::as_str).collect();
        let speed = format!("speed ({unit})");
        let head: Vec<&str> = ["step", speed.as_str()].into_iter().chain(names.iter().copied()).collect();
        let of_now = self.from.values().map(|x| if self.alike { "—".to_owned() } else { format!("{x:.6}") });
        let now = ["0".to_owned(), format!("{:.6}", plan.from_speed)].into_iter();
        let mut rows = vec![now.chain(of_now).collect::<Vec<_>>()];
        for (k, step) in plan.plan.iter().enumerate() {
            let numbers = std::iter::once(step.speed).chain(step.parameters.values().copied());
            rows.push(
                std::iter::once((k + 1).to_string()).chain(numbers.map(|x| format!("{x:.6}"))).collect(),
            );
        }
        let reach = plan
            .reach
            .iter()
            .enumerate()
            .map(|(k, [low, high])| vec![(k + 1).to_string(), format!("{low:.6}"), format!("{high:.6}")]);
        let reach = table(&["after", "slowest", "fastest"], reach.collect(), 0);
        let answer = match (&plan.reason, plan.steps) {
            (Some(reason), _) => format!("not reached: {reason}"),
            (None, Some(1)) => format!("1 step to {} {unit}", self.to),
            (None, count) => format!("{} steps to {} {unit}", count.unwrap_or(0), self.to),
        };
        if plan.plan.is_empty() {
            return format!("\n{reach}\n{answer}\n");
        }
        format!("\n{}\n{reach}\n{answer}\n", table(&head, rows, 0))
    }

    /// Speeds in a row that need equally many steps stand together.
    fn many(&self, plans: &[SpeedPlan]) -> String {
        let words = |plan: &SpeedPlan| match (plan.steps, plan.reason_code) {
            (Some(count), _) => count.to_string(),
            (None, code) => code.unwrap_or("—").to_owned(),
        };
        let groups = plans.chunk_by(|a, b| words(a) == words(b));
        let rows = groups.filter_map(|group| {
            let (first, last) = (group.first()?, group.last()?);
            Some(vec![format!("{:.6}", first.from_speed), format!("{:.6}", last.from_speed), words(first)])
        });
        let head = ["from speeds", "to", "steps"];
        format!("\nsteps to {} {}\n{}", self.to, self.speed_unit, table(&head, rows.collect(), 0))
    }
}
