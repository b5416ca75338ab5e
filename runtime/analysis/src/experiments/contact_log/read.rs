//! A log of contacts is read: block after block, through one filter.
use super::columns::{Columns, has_all_corners};
use super::foot::FootRecord;
use super::forces::{ContactRecording, SHORTEST};
use super::one_sided::{Removed, without_means};
use super::passing::{Passing, with_quaternion};
use super::products::Products;
use crate::log::{Block, Blocks, Log, Reader};
use crate::measure::acceleration_noise::AccelerationNoise;
use crate::measure::columns::JointColumns;
use crate::measure::filtered::{Filtered, unusable};
use crate::measure::noise::{of_encoders, white_noise};
use crate::measure::stops::Stops;
use crate::measure::{HELD, Options};
use crate::robot::Robot;
use crate::robot::Trajectory;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use std::path::Path;

/// Samples per period of the cut-off on which rows are computed and filtered: with fewer the filter is another one.
const PER_PERIOD: f64 = 12.0;
/// m/s²
const STANDARD_GRAVITY: f64 = 9.81;
/// Fewer samples are no log.
const FEWEST: usize = 8;

/// Noise of what is read, by column and by joint.
struct Heard {
    raw: Vec<f64>,
    accelerations: AccelerationNoise,
}

impl ContactRecording {
    /// Reads a log. Motion and forces pass the same zero-phase filter at `options.cutoff_hz` (10 Hz if not given);
    /// every `stride`-th sample is kept, none of them is lost to the filter. By default about twelve per period of the
    /// cut-off are kept, and every other one counts.
    ///
    /// # Errors
    /// Those of the reader; no base, joints or foot forces in the log; a log too short for the filter.
    pub fn read(
        robot: &Robot<'_>,
        log: &Log,
        options: &Options,
        stride: Option<usize>,
    ) -> Result<Self, Diagnostics> {
        Self::from_reader(robot, log.rows(), options, stride)
    }

    /// The same from any source.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn from_reader(
        robot: &Robot<'_>,
        mut reader: Reader,
        options: &Options,
        stride: Option<usize>,
    ) -> Result<Self, Diagnostics> {
        let path = reader.file().to_path_buf();
        let mut columns = Columns::new(robot, &mut reader)?;
        columns.place_quaternion();
        // All samples are read, those at the ends too: the rows are filtered once more before the ends are left out.
        let whole = Options { trim_s: 0.0, from_s: None, to_s: None, ..options.clone() };
        let Filtered { step, cutoff_hz, filter, mut blocks } = Filtered::new(reader, &whole, (1, 1))?;
        let thin = stride.is_none();
        let stride = stride.unwrap_or(((1.0 / step) / (PER_PERIOD * cutoff_hz)) as usize).max(1);
        let mut recording =
            Self { step: step * stride as f64, cutoff_hz, ..Self::prepared(robot, &mut columns) };
        let reach = (0.3 / cutoff_hz / step) as usize;
        let weight = robot.link_inertias.parameters().mass() * STANDARD_GRAVITY;
        let cut = options.cut_at_impacts;
        let products =
            Products::new(robot, cutoff_hz, step, stride).map_err(|e| Diagnostics(vec![e.in_file(&path)]))?;
        let columns = &columns;
        let passing = Passing {
            robot,
            columns,
            filter: &filter,
            cutoff_hz,
            products,
            step,
            stride,
            reach,
            weight,
            cut,
        };
        let heard = recording.add_all(&passing, &mut blocks, &path)?;
        recording.warnings.extend(blocks.report().warnings.iter().cloned());
        recording.finish(&passing, &heard.raw, &heard.accelerations);
        // Half of them show all that the filter leaves.
        recording.keep(options, if thin { 2 } else { 1 });
        let falls = recording.keep_upright(robot);
        recording.keep_standing(robot).map_err(|e| Diagnostics(vec![e.in_file(&path)]))?;
        recording.is_long_enough(falls, &path)?;
        Ok(recording)
    }

    /// A recording without samples, of what the columns hold.
    fn prepared(robot: &Robot<'_>, columns: &mut Columns) -> Self {
        let both = |c: &JointColumns| c.motor_position.and(c.position).is_some();
        let joints = &columns.plan.joints;
        let mut recording = Self {
            filter_rows: true,
            trajectory: Trajectory::new(robot.layout),
            effort: joints.iter().map(|c| c.effort.map(|_| Vec::new())).collect(),
            transmission: joints.iter().map(|c| both(c).then(Vec::new)).collect(),
            motors: joints.iter().map(|c| both(c).then(Vec::new)).collect(),
            motor_side: joints.iter().map(|c| c.by_motor).collect(),
            stops: Stops::new(robot.layout, &columns.plan),
            standing: columns.standing,
            assumptions: std::mem::take(&mut columns.plan.assumptions),
            warnings: std::mem::take(&mut columns.plan.warnings),
            ..Self::default()
        };
        recording.prepare_feet(robot, columns);
        recording
    }

    /// Adds all blocks of a log, as many samples as are held.
    fn add_all(
        &mut self,
        passing: &Passing<'_, '_>,
        blocks: &mut Blocks,
        path: &Path,
    ) -> Result<Heard, Diagnostics> {
        let columns = passing.columns;
        let mut heard = Heard { raw: Vec::new(), accelerations: AccelerationNoise::new(&columns.plan) };
        let mut removed: Vec<Removed> = columns.feet.iter().map(|_| Removed::default()).collect();
        let mut longest = 0;
        while let Some(block) = blocks.next_block()? {
            if block.time.len() < SHORTEST {
                continue;
            }
            let own = with_quaternion(columns, &block);
            let block = Block { columns: own.as_deref().unwrap_or(block.columns), ..block };
            // What remembers is heard where it has the time: a gap may be near the beginning.
            if block.time.len() > longest {
                longest = block.time.len();
                heard.raw = block.columns.iter().map(|c| white_noise(c)).collect();
                for effort in columns.plan.joints.iter().filter_map(|joint| joint.effort) {
                    heard.raw[effort] = passing.noise(&block, &block.columns[effort]);
                }
                for position in columns.plan.joints.iter().filter_map(|joint| joint.position) {
                    heard.raw[position] = of_encoders(&block.columns[position], 1);
                }
            }
            heard.accelerations.hear(&columns.plan, &block);
            self.stops.look(&block, passing.step);
            let own = without_means(&columns.feet, &block, passing.weight, &mut removed);
            let block = Block { columns: own.as_deref().unwrap_or(block.columns), ..block };
            self.add(passing, block).map_err(|e| unusable(e, path))?;
            if self.time.len() > HELD {
                self.warnings.push(self.cut_off(path));
                break;
            }
        }
        let feet = passing.robot.feet.iter().zip(&removed);
        self.assumptions.extend(feet.filter_map(|(foot, removed)| removed.told(&foot.name)));
        Ok(heard)
    }

    /// Refuses a log of which hardly anything counts; `falls`: until when the robot stands, s, if it falls.
    fn is_long_enough(&self, falls: Option<f64>, path: &Path) -> Result<(), Diagnostics> {
        if self.kept.len() >= FEWEST {
            return Ok(());
        }
        let before = falls
            .map_or(String::new(), |end| format!(": the robot falls, and is looked at until {end:.2} s"));
        let message = format!("only {} samples of the log can be used{before}", self.kept.len());
        let help = "at least a few seconds of motion are needed";
        Err(Diagnostics(vec![Diagnostic::error(message).in_file(path).help(help)]))
    }

    /// Said of a log that is longer than what is held of it.
    fn cut_off(&self, path: &Path) -> Diagnostic {
        let last = self.time.last().copied().unwrap_or(0.0);
        let message = format!(
            "the log is too long: what comes after {last} s is not looked at ({HELD} samples of {:.4} s are)",
            self.step
        );
        Diagnostic::warning(message)
            .in_file(path)
            .help("cut the file into pieces; a quarter of an hour of motion tells what there is to tell")
    }

    fn prepare_feet(&mut self, robot: &Robot<'_>, columns: &Columns) {
        let planar = robot.planar();
        for (foot, columns) in robot.feet.iter().zip(&columns.feet) {
            let whole = columns.is_whole(planar);
            let corners = has_all_corners(columns);
            if whole && !columns.normal && !columns.has_torque(planar) {
                self.assumptions.push(format!(
                    "`{}` has no torque column: its force acts at its centre of pressure, and its moment about the vertical is not known",
                    foot.name
                ));
            }
            self.feet.push(FootRecord {
                columns: columns.clone(),
                from_corners: !whole && corners,
                is_logged: whole || corners,
                corners: if corners { vec![Vec::new(); foot.corners.len()] } else { Vec::new() },
                peaks: vec![Vec::new(); 1 + if corners { foot.corners.len() } else { 0 }],
                ..FootRecord::default()
            });
        }
    }
}
