//! `[ground.heights]`: ground that is not level, in time stepping.
use super::file::{File, Uneven};
use super::reading::{NOT_NEGATIVE, POSITIVE, Reading};
use crate::robot::BaseKind;
use crate::simulate::{Heights, HeightsKind, Plant};

/// Heights (m) that are none.
const HIGHEST: f64 = 1.0;

impl Reading<'_> {
    /// The ground's heights, if they are given.
    pub(super) fn heights(&mut self, file: &File, plant: &Plant) -> Option<Heights> {
        let table = file.ground.as_ref()?.get_ref().heights.as_ref()?;
        let at = table.span().start;
        let Uneven { kind, height, size, level, list, seed } = table.get_ref();
        if plant.layout.base == BaseKind::Fixed {
            let message = "`heights` on a stand: the robot hangs in the air and touches no ground";
            return self.wrong(at, message, "leave it out, or choose --base floating or planar");
        }
        if height.is_none() && list.is_none() {
            return self.wrong(
                at,
                "`height` is missing",
                "write height = 0.01 (m): heights are within ± this",
            );
        }
        let listed = list.as_ref().map(|list| list.get_ref().clone()).unwrap_or_default();
        let possible = |height: &f64| height.abs() <= HIGHEST;
        if let Some(list) = list.as_ref().filter(|_| listed.is_empty() || !listed.iter().all(possible)) {
            let message = format!("`list` = {listed:?} is not possible");
            return self.wrong(
                list.span().start,
                message,
                "write heights of footholds in m, such as [0.01, -0.01]",
            );
        }
        let kind = match self.choice("kind", kind.as_ref(), ["footholds", "tiles", "waves"]) {
            0 => HeightsKind::Footholds(listed),
            other => {
                if let Some(list) = list {
                    let help = "leave it out, or write kind = \"footholds\"";
                    self.wrong::<()>(list.span().start, "`list` has a meaning for footholds alone", help);
                }
                if other == 1 { HeightsKind::Tiles } else { HeightsKind::Waves }
            }
        };
        Some(Heights {
            kind,
            height: self.number("height", height.as_ref(), 0.0, (0.0, HIGHEST), "m"),
            size: self.number("size", size.as_ref(), 0.5, POSITIVE, "m"),
            level: self.number("level", level.as_ref(), 0.5, NOT_NEGATIVE, "m"),
            seed: seed.unwrap_or(file.seed),
        })
    }
}
