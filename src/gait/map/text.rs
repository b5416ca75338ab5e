//! A map for people: what it spans, and its extremes.
use super::{Extreme, GaitMap, SpeedMap};
use crate::table::table;
use bipedc_analysis::gait::Interpolation;
use std::fmt;

impl fmt::Display for GaitMap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.ranges())?;
        if !self.parameters.is_empty() {
            let fixed = self.parameters.iter().map(|(name, value)| format!("{name} = {value}"));
            writeln!(f, "\nfixed: {}", fixed.collect::<Vec<_>>().join(", "))?;
        }
        writeln!(f, "assumed: {}", self.assume.join(", "))?;
        writeln!(f, "\nspeeds at mid-stance in {}, extremes within the bounds", self.speed_unit)?;
        f.write_str(&self.extremes())?;
        f.write_str(&self.reasons_table())?;
        f.write_str(&self.interpolations())?;
        if !self.complete {
            writeln!(f, "\ninterrupted: cells are missing; with --csv the same command goes on from there")?;
        }
        Ok(())
    }
}

impl GaitMap {
    fn ranges(&self) -> String {
        let head = ["over", "from", "to", "values", "bounds", "unit"];
        let rows = self.over.iter().map(|axis| {
            let ends = [axis.values.first(), axis.values.last()].map(|x| x.copied().unwrap_or(f64::NAN));
            let [low, high] = axis.bounds;
            vec![
                axis.name.clone(),
                ends[0].to_string(),
                ends[1].to_string(),
                axis.values.len().to_string(),
                format!("{low} to {high}"),
                axis.unit.clone(),
            ]
        });
        table(&head, rows.collect(), head.len())
    }

    fn extremes(&self) -> String {
        let [x, y] = &self.over;
        let at = |axis: &super::MapAxis| format!("at {}", axis.name);
        let heads = [
            "speed".to_owned(),
            "passes".to_owned(),
            "fastest".to_owned(),
            at(x),
            at(y),
            "slowest".to_owned(),
            at(x),
            at(y),
        ];
        let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
        table(&heads, self.maps.iter().map(extremes).collect(), 0)
    }

    /// How much was computed, and how far off the rest is.
    fn interpolations(&self) -> String {
        let rows: Vec<Vec<String>> = self.maps.iter().filter_map(interpolation).collect();
        if rows.is_empty() {
            return String::new();
        }
        let heads = ["speed", "computed", "interpolated", "checked", "largest deviation", "allowed"];
        format!("\ncells computed, and those between them\n{}", table(&heads, rows, 0))
    }

    fn reasons_table(&self) -> String {
        let others = self.reasons.iter().filter(|reason| reason.code() != "passes");
        let rows: Vec<Vec<String>> = others
            .map(|reason| {
                let counts = self.maps.iter().map(|map| map.counts.get(reason.code()).copied().unwrap_or(0));
                std::iter::once(reason.words().to_owned())
                    .chain(counts.map(|count| count.to_string()))
                    .collect()
            })
            .collect();
        if rows.is_empty() {
            return String::new();
        }
        let speeds = self.maps.iter().map(|map| format!("at {}", map.speed));
        let heads: Vec<String> = std::iter::once("cells that do not pass".to_owned()).chain(speeds).collect();
        let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
        format!("\n{}", table(&heads, rows, 1))
    }
}

fn interpolation(map: &SpeedMap) -> Option<Vec<String>> {
    let Interpolation { computed, interpolated, checked, largest_deviation, tolerance } = map.interpolation?;
    let deviation = largest_deviation.map_or_else(|| "—".to_owned(), |deviation| format!("{deviation:.1e}"));
    let counts = [computed, interpolated, checked].map(|count| count.to_string());
    Some([vec![map.speed.to_string()], counts.to_vec(), vec![deviation, format!("{tolerance:.1e}")]].concat())
}

fn extremes(map: &SpeedMap) -> Vec<String> {
    let number = |x: f64| format!("{x:.6}");
    let three = |extreme: &Option<Extreme>| match extreme {
        Some(Extreme { next_speed, at: [x, y] }) => [*next_speed, *x, *y].map(number),
        None => ["—", "—", "—"].map(str::to_owned),
    };
    let passes = map.counts.get("passes").copied().unwrap_or(0);
    let mut row = vec![map.speed.to_string(), passes.to_string()];
    row.extend(three(&map.fastest));
    row.extend(three(&map.slowest));
    row
}
