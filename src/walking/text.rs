//! A plan in words and as JSON.
use super::check::{Limit, Measured};
use super::{Method, Plan};
use crate::table::table;
use bipedc_analysis::walking::LEGS;
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use serde_json::{Value, json};
use std::fmt;

impl Measured {
    /// Where, what, by how much.
    pub fn sentence(&self) -> String {
        let of = self.of.as_ref().map_or_else(String::new, |of| format!(" of `{of}`"));
        let unit = if self.unit == "1" { String::new() } else { format!(" {}", self.unit) };
        let (side, limit) = match self.limit {
            Limit::Least(limit) => ("at least", limit),
            Limit::Most(limit) => ("at most", limit),
        };
        format!(
            "{}, at {:.3} s: {}{of} is {:.5}{unit}, allowed is {side} {limit:.5}{unit}",
            self.place(),
            self.time,
            self.quantity.words(),
            self.value
        )
    }

    fn place(&self) -> String {
        let phase = self.phase.name();
        self.step.map_or_else(|| phase.to_owned(), |step| format!("step {step}, {phase}"))
    }
}

impl Plan {
    /// s
    pub fn duration(&self) -> f64 {
        self.schedule.duration()
    }

    /// How far the middle between the feet goes, m: forward, to the left; and its turn, rad.
    pub fn moved(&self) -> [f64; 3] {
        let mut stance = self.start;
        self.footsteps.iter().for_each(|step| stance.soles[step.foot] = step.sole);
        let [x, y] = stance.middle();
        [x, y, 0.5 * (stance.soles[0].yaw + stance.soles[1].yaw)]
    }

    /// Largest speed of the centre of mass over a pair of steps, m/s; none of walks of fewer.
    pub fn speed(&self) -> Option<f64> {
        let starts: Vec<f64> = (0..self.footsteps.len())
            .filter_map(|k| {
                self.schedule.phases.iter().find(|phase| phase.step == Some(k)).map(|phase| phase.start)
            })
            .collect();
        let at = |time: f64| {
            let row = &self.rows[((time / self.schedule.sample).round() as usize).min(self.rows.len() - 1)];
            [row.center[0][0], row.center[1][0]]
        };
        let over = |pair: &[f64]| {
            let (a, b) = (at(pair[0]), at(pair[2]));
            (b[0] - a[0]).hypot(b[1] - a[1]) / (pair[2] - pair[0])
        };
        starts.windows(3).map(over).max_by(f64::total_cmp)
    }

    pub(super) fn method_name(&self) -> &'static str {
        match self.method {
            Method::Static => "static",
            Method::Dynamic => "dynamic",
            Method::Pendulum => "pendulum",
        }
    }

    /// What the plan is, in a few lines.
    pub fn summary(&self) -> String {
        let [x, y, yaw] = self.moved();
        let name = &self.legs.robot.description.name;
        let mut text = format!(
            "{name}: {} walk of {} steps in {:.2} s, {x:+.3} m forward, {y:+.3} m to the left, turned by {:+.1} deg",
            self.method_name(),
            self.footsteps.len(),
            self.duration(),
            yaw.to_degrees()
        );
        if let Some(speed) = self.speed() {
            text += &format!("; at most {speed:.3} m/s over a pair of steps");
        }
        if let Some(error) = self.zmp_error {
            text += &format!(
                ".\n\nThe zero moment point of the whole robot is within {:.3} mm of its reference after {} rounds of feedback",
                1e3 * error,
                self.rounds
            );
        }
        text + "."
    }

    /// What the checks say.
    pub fn verdict(&self) -> String {
        match &self.violation {
            None => format!("All limits hold at {} samples.", self.rows.len()),
            Some(first) => format!(
                "Limits do not hold at {} of {} samples. The first: {}.",
                self.violations,
                self.rows.len(),
                first.sentence()
            ),
        }
    }
}

impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}\n\n{}\n", self.summary(), self.verdict())?;
        let row = |nearest: &Measured| {
            let (side, limit) = match nearest.limit {
                Limit::Least(limit) => ("least", limit),
                Limit::Most(limit) => ("most", limit),
            };
            vec![
                nearest.quantity.words().to_owned(),
                nearest.of.clone().unwrap_or_default(),
                nearest.place(),
                format!("{:.3}", nearest.time),
                format!("{:.4}", nearest.value),
                format!("{side} {limit:.4}"),
                nearest.unit.to_owned(),
            ]
        };
        let head = ["nearest to its limit", "of", "where", "time (s)", "value", "limit", "unit"];
        f.write_str(&table(&head, self.nearest.iter().map(row).collect(), 3))
    }
}

impl Serialize for Plan {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let steps: Vec<Value> = self
            .footsteps
            .iter()
            .map(|step| {
                let [x, y] = step.sole.place;
                json!({"foot": LEGS[step.foot], "x": x, "y": y, "yaw": step.sole.yaw, "duration": step.duration})
            })
            .collect();
        let phases: Vec<Value> = self
            .schedule
            .phases
            .iter()
            .map(|phase| {
                let swing = phase.swing().map(|foot| LEGS[foot]);
                let step = phase.step.map(|step| step + 1);
                json!({"kind": phase.kind, "step": step, "start": phase.start, "duration": phase.duration, "swing": swing})
            })
            .collect();
        let soles: Vec<Value> = (0..2)
            .map(|k| {
                let sole = &self.legs.soles[k];
                let axes: Vec<[f64; 3]> = sole.axes.row_iter().map(|row| [row[0], row[1], row[2]]).collect();
                let center: [f64; 3] = sole.center.into();
                json!({"foot": self.legs.feet[k], "link": self.legs.links[k], "center": center, "axes": axes, "corners": sole.corners})
            })
            .collect();
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("robot", &self.legs.robot.description.name)?;
        map.serialize_entry("method", &self.method)?;
        map.serialize_entry("complete", &self.complete)?;
        map.serialize_entry("holds", &self.violation.is_none())?;
        map.serialize_entry("samples", &self.rows.len())?;
        map.serialize_entry("duration", &self.duration())?;
        map.serialize_entry("moved", &self.moved())?;
        map.serialize_entry("speed", &self.speed())?;
        map.serialize_entry("rounds", &self.rounds)?;
        map.serialize_entry("zmp_error", &self.zmp_error)?;
        map.serialize_entry("violation", &self.violation)?;
        map.serialize_entry("violations", &self.violations)?;
        map.serialize_entry("nearest", &self.nearest)?;
        map.serialize_entry("settings", &self.settings)?;
        map.serialize_entry("footsteps", &steps)?;
        map.serialize_entry("phases", &phases)?;
        map.serialize_entry("soles", &soles)?;
        map.end()
    }
}
