//! A map as pictures and as a page.
use super::{Extreme, GaitMap, SpeedMap};
use bipedc_analysis::report::{Fact, MapAxisFigure, MapFigure, MapPanel, Table};

impl GaitMap {
    /// What pictures and page show.
    pub fn figure(&self) -> MapFigure {
        let axis = |k: usize| {
            let axis = &self.over[k];
            MapAxisFigure {
                name: axis.name.clone(),
                unit: axis.unit.clone(),
                bounds: axis.bounds,
                values: axis.values.clone(),
            }
        };
        MapFigure {
            title: format!("Gait {}: speed of the next step", self.gait),
            robot: self.robot.clone(),
            axes: [axis(0), axis(1)],
            unit: self.speed_unit.clone(),
            panels: self.maps.iter().map(|map| self.panel(map)).collect(),
            facts: self.facts(),
            table: self.table(),
        }
    }

    fn panel(&self, map: &SpeedMap) -> MapPanel {
        let place = |extreme: &Option<Extreme>| extreme.map(|extreme| extreme.at);
        MapPanel {
            speed: map.speed,
            values: map.next_speed.iter().flatten().map(|x| x.unwrap_or(f64::NAN)).collect(),
            reasons: map.reason.iter().flatten().map(|&k| self.reasons[k]).collect(),
            fastest: place(&map.fastest),
            slowest: place(&map.slowest),
        }
    }

    fn facts(&self) -> Vec<Fact> {
        let fact = |name: &str, value: String| Fact { name: name.to_owned(), value };
        let values = |of: &std::collections::BTreeMap<String, f64>| {
            of.iter().map(|(name, value)| format!("{name} = {value}")).collect::<Vec<_>>().join(", ")
        };
        let mut facts = vec![fact("gait", self.gait.clone()), fact("assumed", self.assume.join(", "))];
        if !self.parameters.is_empty() {
            facts.push(fact("other parameters", values(&self.parameters)));
        }
        facts.push(match &self.from {
            Some(from) => fact("step before", values(from)),
            None => fact("step before", "has the parameters of the cell".to_owned()),
        });
        if !self.complete {
            facts.push(fact("interrupted", "cells are missing".to_owned()));
        }
        facts
    }

    fn table(&self) -> Table {
        let [x, y] = &self.over;
        let head =
            ["speed", "cells that pass", "fastest next", &x.name, &y.name, "slowest next", &x.name, &y.name];
        let number = |x: f64| format!("{x:.4}");
        let three = |extreme: &Option<Extreme>| match extreme {
            Some(Extreme { next_speed, at: [x, y] }) => [*next_speed, *x, *y].map(number),
            None => ["–", "–", "–"].map(str::to_owned),
        };
        let row = |map: &SpeedMap| {
            let passes = map.counts.get("passes").copied().unwrap_or(0);
            let mut row = vec![map.speed.to_string(), passes.to_string()];
            row.extend(three(&map.fastest));
            row.extend(three(&map.slowest));
            row
        };
        Table {
            caption: format!("Extremes within the bounds, speeds in {}", self.speed_unit),
            head: head.map(str::to_owned).to_vec(),
            rows: self.maps.iter().map(row).collect(),
        }
    }
}
