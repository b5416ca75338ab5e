//! What a map shows.
use crate::gait::Reason;
use crate::report::data::Fact;

/// Maps of several speeds over the same two parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct MapFigure {
    /// Of picture and page.
    pub title: String,
    /// Name of the robot.
    pub robot: String,
    /// Columns, then rows.
    pub axes: [MapAxisFigure; 2],
    /// Unit of all speeds.
    pub unit: String,
    /// One map for each speed.
    pub panels: Vec<MapPanel>,
    /// What the page says of them.
    pub facts: Vec<Fact>,
    /// Extremes of all maps.
    pub table: Table,
}

/// A parameter with evenly spaced values, at least two.
#[derive(Debug, Clone, PartialEq)]
pub struct MapAxisFigure {
    /// Of the parameter.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Drawn as a dashed rectangle.
    pub bounds: [f64; 2],
    /// From the smallest to the largest.
    pub values: Vec<f64>,
}

/// The map of one speed, row after row.
#[derive(Debug, Clone, PartialEq)]
pub struct MapPanel {
    /// φ̇_m of the step before, whose isocline is drawn.
    pub speed: f64,
    /// φ̇_m of the next step; NaN: there is none.
    pub values: Vec<f64>,
    /// What comes of the step.
    pub reasons: Vec<Reason>,
    /// Where the next step is fastest within the bounds.
    pub fastest: Option<[f64; 2]>,
    /// Where it is slowest.
    pub slowest: Option<[f64; 2]>,
}

/// A table of a page.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// What it tells.
    pub caption: String,
    /// Of the columns.
    pub head: Vec<String>,
    /// As many fields as columns.
    pub rows: Vec<Vec<String>>,
}

impl MapFigure {
    /// Smallest and largest speed that is shown in colour.
    pub(super) fn span(&self) -> [f64; 2] {
        let shown = self.panels.iter().flat_map(MapPanel::shown).filter(|x| x.is_finite());
        let [low, high] = shown.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], x| [l.min(x), h.max(x)]);
        match (low.is_finite(), high > low) {
            (false, _) => [0.0, 1.0],
            (true, false) => [low, low + 1.0],
            (true, true) => [low, high],
        }
    }

    /// Reasons other than passing that occur, in their order.
    pub(super) fn reasons(&self) -> Vec<Reason> {
        let occurs = |reason: &Reason| self.panels.iter().any(|panel| panel.reasons.contains(reason));
        Reason::ALL.into_iter().filter(|reason| *reason != Reason::Passes && occurs(reason)).collect()
    }
}

impl MapPanel {
    /// Speeds where everything holds, NaN elsewhere.
    pub(super) fn shown(&self) -> impl Iterator<Item = f64> + '_ {
        let shown =
            |(value, reason): (&f64, &Reason)| if *reason == Reason::Passes { *value } else { f64::NAN };
        self.values.iter().zip(&self.reasons).map(shown)
    }
}

impl MapAxisFigure {
    /// With its unit.
    pub(super) fn label(&self) -> String {
        if self.unit.is_empty() || self.unit == "1" {
            self.name.clone()
        } else {
            format!("{} ({})", self.name, self.unit)
        }
    }

    /// Both ends of what is drawn: half a cell beyond the values.
    pub(super) fn ends(&self) -> [f64; 2] {
        let (first, last) =
            (self.values.first().copied().unwrap_or(0.0), self.values.last().copied().unwrap_or(1.0));
        let half = 0.5 * (last - first) / (self.values.len().max(2) - 1) as f64;
        [first - half, last + half]
    }
}
