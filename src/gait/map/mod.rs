//! Maps of a gait: the next mid-stance speed over two parameters (thesis, figures 7.2 and 7.4).
mod figure;
mod file;
mod phased;
mod text;

use super::over::Over;
use super::{Assignment, GaitBench, Parametrised};
use crate::progress::Run;
use bipedc_analysis::gait::{Assumptions, Cell, Interpolation, MapRequest, Reason, Watch};
use bipedc_compiler::description::gait::GaitParameter;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;

/// Most cells of a map, all speeds counted.
pub const MOST_CELLS: usize = 8_000_000;
/// Maps of a gait of several phases that have so many cells of a speed are interpolated, if nothing else is asked for.
pub const INTERPOLATED_FROM: usize = 2_000;

/// What map is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct MapOptions {
    /// Speeds φ̇_m at the dead centre of the step before, per s; a map each.
    pub speeds: Vec<f64>,
    /// Two parameters: columns, then rows.
    pub over: Vec<Over>,
    /// Other parameters, where they are not the gait's own.
    pub set: Vec<Assignment>,
    /// Parameters of the step before, if it is to be another than the next; what is missing is as in the next step without ranges.
    pub from: Vec<Assignment>,
    /// What a step has to satisfy beside passing its dead centre.
    pub assume: Assumptions,
    /// Of a gait of several phases: from so many cells of a speed on most of them are interpolated; `None`: every cell is computed. Cells of
    /// gaits of one phase always are.
    pub interpolated_from: Option<usize>,
}

impl Default for MapOptions {
    fn default() -> Self {
        Self {
            speeds: Vec::new(),
            over: Vec::new(),
            set: Vec::new(),
            from: Vec::new(),
            assume: Assumptions::default(),
            interpolated_from: Some(INTERPOLATED_FROM),
        }
    }
}

/// A map. As text and as JSON it is what `bipedc gait map` prints.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GaitMap {
    /// Name of the gait.
    pub gait: String,
    /// Of the robot.
    pub robot: String,
    /// Unit of all speeds.
    pub speed_unit: String,
    /// Values of the parameters that are the same in all cells.
    pub parameters: BTreeMap<String, f64>,
    /// Values of all parameters of the step before; none: they are the cell's.
    pub from: Option<BTreeMap<String, f64>>,
    /// Columns, then rows.
    pub over: [MapAxis; 2],
    /// What was assumed, `step` first.
    pub assume: Vec<&'static str>,
    /// No cell is missing.
    pub complete: bool,
    /// Reasons that occur, to which numbers in `maps` refer.
    pub reasons: Vec<Reason>,
    /// One for each speed.
    pub maps: Vec<SpeedMap>,
    /// Ranges beyond bounds.
    #[serde(skip)]
    pub messages: Vec<Diagnostic>,
    #[serde(skip)]
    identity: String,
}

/// A parameter of a map.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MapAxis {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Bounds of the gait file.
    pub bounds: [f64; 2],
    /// Its values.
    pub values: Vec<f64>,
}

/// The map of one speed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SpeedMap {
    /// φ̇_m of the step before.
    pub speed: f64,
    /// Highest next speed within the bounds, over all cells where everything holds.
    pub fastest: Option<Extreme>,
    /// Lowest next speed within the bounds.
    pub slowest: Option<Extreme>,
    /// How many cells of each reason.
    pub counts: BTreeMap<&'static str, usize>,
    /// φ̇_m of the next step, row after row; null where it does not pass its dead centre.
    pub next_speed: Vec<Vec<Option<f64>>>,
    /// Index in `reasons`, row after row.
    pub reason: Vec<Vec<usize>>,
    /// What was interpolated; none: nothing.
    pub interpolation: Option<Interpolation>,
    /// 1 where a cell was computed, 0 where it was interpolated, row after row; none: all were computed.
    pub computed: Option<Vec<Vec<u8>>>,
}

/// A cell with an extreme speed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Extreme {
    /// φ̇_m of the next step.
    pub next_speed: f64,
    /// Values of both axes.
    pub at: [f64; 2],
}

impl GaitBench {
    /// The next mid-stance speed over two parameters.
    ///
    /// `file`: a map that was interrupted goes on from this file if it is there, and all of it is written there; [`GaitMap::complete`]
    /// says whether an early end was asked for.
    ///
    /// # Errors
    /// Parameters that the gait does not have, ranges and speeds that are none, assumptions that cannot be judged; a file that is
    /// there and is not of this map.
    pub fn map(
        &self,
        options: &MapOptions,
        file: Option<&Path>,
        run: &Run<'_>,
    ) -> Result<GaitMap, Diagnostics> {
        let request = self.map_request(options)?;
        self.check_assumptions(options.assume)?;
        let identity = self.identity(&request);
        let model = self.model()?;
        self.mapped((&request, identity), file, run, |known, watch| {
            (model.map(&request, known, watch), vec![None; request.speeds.len()])
        })
    }

    /// Refuses assumptions that nothing is known about.
    pub(super) fn check_assumptions(&self, assume: Assumptions) -> Result<(), Diagnostic> {
        if assume.friction && self.gait.limits.friction.is_none() {
            return Err(Diagnostic::error(format!(
                "the gait `{}` has no coefficient of friction",
                self.gait.name
            ))
            .help("write `friction` into its [limits], or leave out --assume friction"));
        }
        let limited = self.compiled.description.joints.iter().any(|joint| joint.effort_limit.is_some());
        if assume.torque && !limited {
            return Err(Diagnostic::error("no joint of the robot has a limit of its torque")
                .help("write `effort` into the URDF's limits, or leave out --assume torque"));
        }
        let stops = self.compiled.description.joints.iter().any(|joint| joint.position_limits.is_some());
        if assume.joints && !stops {
            let help = "write `lower` and `upper` into the URDF's limits, or leave out --assume joints";
            return Err(Diagnostic::error("no joint of the robot has stops").help(help));
        }
        let fast = self.compiled.description.joints.iter().any(|joint| joint.velocity_limit.is_some());
        if assume.velocity && !fast {
            return Err(no_velocity_limits());
        }
        Ok(())
    }
}

/// What maps of all gaits have in common.
trait Mapping: Parametrised {
    /// All cells, by `cells` from those that a file has already, and what they say.
    fn mapped(
        &self,
        (request, identity): (&MapRequest, String),
        file: Option<&Path>,
        run: &Run<'_>,
        cells: impl FnOnce(Vec<Cell>, &Watch<'_>) -> (Vec<Cell>, Vec<Option<Interpolation>>),
    ) -> Result<GaitMap, Diagnostics> {
        let frame = file::Frame { axes: [0, 1].map(|k| self.axis(request, k)), speeds: &request.speeds };
        let known = match file {
            Some(path) => file::read(path, &identity, &frame)?,
            None => Vec::new(),
        };
        let (cells, interpolation) =
            run.progress.counted("mapping", |advance| cells(known, &Watch { advance, stop: run.stop }));
        if let Some(path) = file {
            file::write(path, &identity, &frame, &cells)?;
        }
        Ok(self.described(request, (&cells, interpolation), identity))
    }

    fn map_request(&self, options: &MapOptions) -> Result<MapRequest, Diagnostics> {
        self.check_speeds(&options.speeds)?;
        let values = self.with(&self.defaults(), &options.set)?;
        let from = if options.from.is_empty() { None } else { Some(self.with(&values, &options.from)?) };
        let fixed: Vec<&str> = options.set.iter().map(|(name, _)| name.as_str()).collect();
        let axes = self.axes(&options.over, &fixed)?;
        let axes: [(usize, Vec<f64>); 2] = axes.try_into().map_err(|axes: Vec<_>| {
            let message = format!("a map has two ranges, not {}", axes.len());
            Diagnostic::error(message).help("give --over NAME=A:B:N twice, once for each of two parameters")
        })?;
        let cells = axes[0].1.len() * axes[1].1.len() * options.speeds.len();
        if cells > MOST_CELLS {
            let help = format!("ask for fewer values or speeds: at most {MOST_CELLS} cells in all");
            return Err(Diagnostic::error(format!("{cells} cells are too many")).help(help).into());
        }
        Ok(MapRequest { values, from, axes, speeds: options.speeds.clone(), assume: options.assume })
    }

    fn axis(&self, request: &MapRequest, k: usize) -> MapAxis {
        let (index, values) = &request.axes[k];
        let GaitParameter { name, unit, bounds, .. } = self.parameter(*index);
        MapAxis { name: name.clone(), unit: unit.clone(), bounds: *bounds, values: values.clone() }
    }

    fn described(
        &self,
        request: &MapRequest,
        (cells, interpolation): (&[Cell], Vec<Option<Interpolation>>),
        identity: String,
    ) -> GaitMap {
        let over = [0, 1].map(|k| self.axis(request, k));
        let reasons: Vec<Reason> = Reason::ALL
            .into_iter()
            .filter(|reason| cells.iter().any(|cell| cell.reason == *reason))
            .collect();
        let one =
            |(k, interpolation)| SpeedMap { interpolation, ..speed_map(request, &over, &reasons, cells, k) };
        let moving = request.axes.each_ref().map(|(index, _)| *index);
        let named = |values: &[f64], left_out: &[usize]| {
            let kept = self.parameters().iter().zip(values).enumerate();
            let kept = kept.filter(|(index, _)| !left_out.contains(index));
            kept.map(|(_, (parameter, value))| (parameter.name.clone(), *value)).collect()
        };
        GaitMap {
            gait: self.gait_name().to_owned(),
            robot: self.robot_name().to_owned(),
            speed_unit: self.speed_unit(),
            parameters: named(&request.values, &moving),
            from: request.from.as_deref().map(|values| named(values, &[])),
            assume: assumed(request.assume),
            complete: !reasons.contains(&Reason::NotComputed),
            maps: interpolation.into_iter().enumerate().map(one).collect(),
            messages: self.beyond_ranges(request),
            reasons,
            over,
            identity,
        }
    }

    /// Warnings of what lies beyond its bounds.
    fn beyond_ranges(&self, request: &MapRequest) -> Vec<Diagnostic> {
        let mut inside = request.values.clone();
        for (index, _) in &request.axes {
            // Ranges may go beyond: the picture shows the bounds.
            inside[*index] = self.parameter(*index).bounds[0];
        }
        let mut found = self.outside(&inside, "");
        found.extend(request.from.iter().flat_map(|from| self.outside(from, " of the step before")));
        found
    }
}

impl<B: Parametrised> Mapping for B {}

/// Said where velocities are assumed of a robot whose joints may be as fast as they like.
pub(in crate::gait) fn no_velocity_limits() -> Diagnostic {
    let help = "write `velocity` into the URDF's limits, or leave out --assume velocity";
    Diagnostic::error("no joint of the robot has a limit of its velocity").help(help)
}

/// Names of assumptions, as `--assume` has them.
fn assumed(assume: Assumptions) -> Vec<&'static str> {
    let Assumptions { friction, pull, clearance, torque, joints, velocity } = assume;
    let all = [
        (true, "step"),
        (friction, "friction"),
        (pull, "pull"),
        (clearance, "clearance"),
        (torque, "torque"),
        (joints, "joints"),
        (velocity, "velocity"),
    ];
    all.into_iter().filter(|(asked, _)| *asked).map(|(_, name)| name).collect()
}

fn speed_map(
    request: &MapRequest,
    over: &[MapAxis; 2],
    reasons: &[Reason],
    cells: &[Cell],
    k: usize,
) -> SpeedMap {
    let ([columns, rows], speeds) = (request.size(), request.speeds.len());
    let cell = |column: usize, row: usize| cells[(row * columns + column) * speeds + k];
    let inside =
        |at: [f64; 2]| at.iter().zip(over).all(|(x, axis)| (axis.bounds[0]..=axis.bounds[1]).contains(x));
    let places = (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row)));
    let good: Vec<Extreme> = places
        .clone()
        .filter_map(|(column, row)| {
            let at = [over[0].values[column], over[1].values[row]];
            let next_speed = cell(column, row).good().filter(|_| inside(at))?;
            Some(Extreme { next_speed, at })
        })
        .collect();
    let mut counts = BTreeMap::new();
    for (column, row) in places {
        *counts.entry(cell(column, row).reason.code()).or_insert(0) += 1;
    }
    let number = |reason: Reason| reasons.iter().position(|known| *known == reason).unwrap_or(0);
    // Of equals the first one, whichever is sought.
    let fastest = good.iter().copied().reduce(|a, b| if b.next_speed > a.next_speed { b } else { a });
    let slowest = good.iter().copied().reduce(|a, b| if b.next_speed < a.next_speed { b } else { a });
    let each_row = |row: usize| (0..columns).map(move |column| cell(column, row));
    SpeedMap {
        speed: request.speeds[k],
        fastest,
        slowest,
        counts,
        next_speed: (0..rows).map(|row| each_row(row).map(|cell| cell.next_speed).collect()).collect(),
        reason: (0..rows).map(|row| each_row(row).map(|cell| number(cell.reason)).collect()).collect(),
        interpolation: None,
        computed: (0..rows).any(|row| each_row(row).any(|cell| cell.interpolated)).then(|| {
            (0..rows).map(|row| each_row(row).map(|cell| (!cell.interpolated).into()).collect()).collect()
        }),
    }
}
