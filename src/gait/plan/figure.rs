//! Plans as a table, as a picture and as a page.
use super::Plans;
use bipedc_analysis::report::{CurveFigure, CurveKind, Fact, PlottedCurve, Table};
use std::fmt::Write;

impl Plans {
    /// One row per step of a single plan, else one per speed. Numbers have as many digits as it takes to read them back.
    pub fn csv(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        if let [plan] = &self.plans[..] {
            let names: Vec<&str> = self.from.keys().map(String::as_str).collect();
            let _ = writeln!(text, "step,speed,{}", names.join(","));
            let row =
                |k: usize, speed: f64, values: Vec<String>| format!("{k},{speed},{}\n", values.join(","));
            // Where steps are alike the present one has no parameters.
            let now = self.from.values().map(|x| if self.alike { String::new() } else { x.to_string() });
            text.push_str(&row(0, plan.from_speed, now.collect()));
            for (k, step) in plan.plan.iter().enumerate() {
                text.push_str(&row(
                    k + 1,
                    step.speed,
                    step.parameters.values().map(f64::to_string).collect(),
                ));
            }
            return text;
        }
        text.push_str("from_speed,to,steps,reason\n");
        for plan in &self.plans {
            let count = plan.steps.map_or_else(String::new, |count| count.to_string());
            let _ =
                writeln!(text, "{},{},{count},{}", plan.from_speed, self.to, plan.reason_code.unwrap_or(""));
        }
        text
    }

    /// What picture and page show.
    pub fn figure(&self) -> CurveFigure {
        let to = format!("{} {}", self.to, self.speed_unit);
        let title = format!("Gait {}: fewest steps to {to}", self.gait);
        let mut figure = match &self.plans[..] {
            [_] => self.staircase(),
            _ => self.counts(),
        };
        (figure.title, figure.robot, figure.facts) = (title, self.robot.clone(), self.facts());
        figure
    }

    /// Speed over steps, with what can be reached.
    fn staircase(&self) -> CurveFigure {
        let plan = &self.plans[0];
        let start = std::iter::once([0.0, plan.from_speed]);
        let way = plan.plan.iter().enumerate().map(|(k, step)| [(k + 1) as f64, step.speed]);
        let ends = |side: usize| {
            let reach = plan.reach.iter().enumerate().map(move |(k, ends)| [(k + 1) as f64, ends[side]]);
            start.clone().chain(reach).collect::<Vec<_>>()
        };
        let last = plan.reach.len().max(1) as f64;
        let curve =
            |kind, words: &str, points: Vec<[f64; 2]>| PlottedCurve { kind, words: words.to_owned(), points };
        let mut rows = vec![self.row("0", plan.from_speed, self.from.values())];
        if self.alike {
            rows[0].iter_mut().skip(2).for_each(|field| *field = "–".to_owned());
        }
        for (k, step) in plan.plan.iter().enumerate() {
            rows.push(self.row(&(k + 1).to_string(), step.speed, step.parameters.values()));
        }
        let head = ["step".to_owned(), format!("speed ({})", self.speed_unit)];
        CurveFigure {
            x: "step".to_owned(),
            y: format!("speed at mid-stance ({})", self.speed_unit),
            counted: [true, false],
            from_zero: true,
            curves: vec![
                curve(CurveKind::Limit, "fastest that can be reached", ends(1)),
                curve(CurveKind::Limit, "", ends(0)),
                curve(CurveKind::Wish, "wished", vec![[0.0, self.to], [last, self.to]]),
                curve(CurveKind::Main, "plan", start.clone().chain(way).collect()),
            ],
            table: Table {
                caption: plan.reason.clone().unwrap_or_else(|| "The plan".to_owned()),
                head: head.into_iter().chain(self.from.keys().cloned()).collect(),
                rows,
            },
            ..CurveFigure::default()
        }
    }

    fn row<'a>(&self, step: &str, speed: f64, values: impl Iterator<Item = &'a f64>) -> Vec<String> {
        let numbers =
            std::iter::once(speed).chain(values.copied()).map(|x| format!("{x:.4}")).collect::<Vec<_>>();
        std::iter::once(step.to_owned()).chain(numbers).collect()
    }

    /// Number of steps over the speed.
    fn counts(&self) -> CurveFigure {
        let points = self.plans.iter().filter_map(|plan| Some([plan.from_speed, plan.steps? as f64]));
        let words = |plan: &super::SpeedPlan| {
            plan.steps.map_or_else(|| plan.reason.clone().unwrap_or_default(), |n| n.to_string())
        };
        let groups = self.plans.chunk_by(|a, b| words(a) == words(b));
        let row = |group: &[super::SpeedPlan]| {
            Some(vec![
                group.first()?.from_speed.to_string(),
                group.last()?.from_speed.to_string(),
                words(group.first()?),
            ])
        };
        CurveFigure {
            x: format!("speed at mid-stance ({})", self.speed_unit),
            y: "fewest steps".to_owned(),
            counted: [false, true],
            from_zero: true,
            curves: vec![PlottedCurve {
                kind: CurveKind::Dots,
                words: "fewest steps".to_owned(),
                points: points.collect(),
            }],
            table: Table {
                caption: format!("Speeds in {}", self.speed_unit),
                head: ["from", "to", "steps"].map(str::to_owned).to_vec(),
                rows: groups.filter_map(row).collect(),
            },
            ..CurveFigure::default()
        }
    }

    fn facts(&self) -> Vec<Fact> {
        let fact = |name: &str, value: String| Fact { name: name.to_owned(), value };
        let now: Vec<String> = self.from.iter().map(|(name, value)| format!("{name} = {value}")).collect();
        let now = match self.alike {
            true => fact("steps", "each is taken as one among its own kind".to_owned()),
            false => fact("present step", now.join(", ")),
        };
        let mut facts = vec![fact("gait", self.gait.clone()), now];
        for choice in &self.choices {
            let [low, high] = choice.bounds;
            facts.push(fact(&choice.name, format!("{low} to {high} {}, chosen for each step", choice.unit)));
        }
        facts
    }
}
