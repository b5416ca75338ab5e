//! Motor currents in the place of joint efforts: what a stiff drive's current says of the torque at its joint.
//!
//! effort = gear_ratio · torque_constant · current. That is the motor's torque at the joint (4.26), (4.30), of which rotor
//! and friction take their part before the link gets the rest. So the drive's `rotor_inertia`, `viscous_friction` and
//! `coulomb_friction`, seen through the gear, become effects of the model at that joint, unless the description has effects
//! of these kinds there: those were estimated and say it better.
//!
//! Angles of such motors are of their shafts, beside currents and beside efforts: here they become angles of the joint.
use super::Log;
use bipedc_analysis::log::{Kind, MappedColumn, Mapping};
use bipedc_compiler::Robot;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics, Severity};
use bipedc_effects::drive::{Drive, Transmission};
use bipedc_effects::effect::{self, Effect, Location, kinds};

/// A robot and logs in which currents are read as efforts.
#[derive(Debug, Clone)]
pub struct Prepared {
    /// With what drives do to their joints as effects.
    pub robot: Robot,
    /// In the order given.
    pub logs: Vec<Log>,
    /// Names of their columns.
    mappings: Vec<Mapping>,
    /// Whether drives entered the model.
    pub has_motors: bool,
    /// What was taken for granted.
    pub assumptions: Vec<String>,
    /// Currents that say nothing, and what to do about it.
    pub warnings: Vec<Diagnostic>,
}

/// Looks for joints that have `<joint>/motor_current` and no `<joint>/effort` in all these logs.
///
/// # Errors
/// Logs that cannot be read any more; currents that say nothing in logs without any effort.
pub fn prepare(robot: &Robot, logs: &[&Log]) -> Result<Prepared, Diagnostics> {
    let mut prepared = Prepared::new(robot, logs);
    if logs.iter().any(|log| log.kind() != Kind::Time) {
        return Ok(prepared);
    }
    let has = |name: &str| logs.iter().all(|log| log.has(name));
    let joints: Vec<String> = robot.description.joints.iter().map(|joint| joint.name.clone()).collect();
    let mut efforts = joints.iter().any(|joint| has(&format!("{joint}/effort")));
    for joint in &joints {
        let column = |what: &str| format!("{joint}/{what}");
        let effort = logs.iter().any(|log| log.has(&column("effort")));
        let drive = robot.description.drive(joint);
        if effort || !has(&column("motor_current")) {
            prepared.take_shaft(joint, drive);
            continue;
        }
        let angles = [has(&column("position")), has(&column("motor_position"))];
        prepared.take_angles(joint, drive, angles);
        match torque_per_ampere(joint, drive) {
            Ok((drive, factor)) => {
                prepared.take_current(joint, drive, factor);
                efforts = true;
            }
            Err(problem) => prepared.warnings.push(problem.in_file(logs[0].path()).at(1, 0)),
        }
    }
    if !efforts && !prepared.warnings.is_empty() {
        let error = |mut warning: Diagnostic| {
            warning.severity = Severity::Error;
            warning
        };
        return Err(Diagnostics(prepared.warnings.into_iter().map(error).collect()));
    }
    prepared.rename()?;
    Ok(prepared)
}

/// gear_ratio · torque_constant of a stiff drive, N m/A at the joint; why there is none.
fn torque_per_ampere<'d>(joint: &str, drive: Option<&'d Drive>) -> Result<(&'d Drive, f64), Diagnostic> {
    let column = format!("`{joint}/motor_current` says nothing of the joint's effort");
    let problem = |why: &str, help: String| Err(Diagnostic::warning(format!("{column}: {why}")).help(help));
    let Some(drive) = drive else {
        let help = format!(
            "add [drives.{joint}] with gear_ratio and torque_constant (N m/A) to biped.toml (robots/README.md), or log \
             `{joint}/effort`"
        );
        return problem("the description has no drive there", help);
    };
    match drive.transmission {
        Transmission::Stiff => {}
        Transmission::SeriesElastic { .. } => {
            let help = format!(
                "`bipedc identify --method elastic` works with the currents of elastic drives; here log `{joint}/effort`"
            );
            return problem("a spring lies between motor and joint", help);
        }
        Transmission::Passive { .. } => {
            return problem(
                "its drive is passive and has no motor",
                format!("change `kind` of [drives.{joint}]"),
            );
        }
    }
    match drive.torque_per_ampere() {
        Some(factor) => Ok((drive, factor)),
        None => {
            let help = format!("add torque_constant (N m/A) to [drives.{joint}] of biped.toml");
            problem("its drive has no torque constant", help)
        }
    }
}

impl Prepared {
    fn new(robot: &Robot, logs: &[&Log]) -> Self {
        Self {
            robot: robot.clone(),
            logs: logs.iter().map(|log| (*log).clone()).collect(),
            mappings: logs.iter().map(|log| log.mapping().clone()).collect(),
            has_motors: false,
            assumptions: Vec::new(),
            warnings: Vec::new(),
        }
    }

    /// Gives the logs the names by which currents are efforts.
    fn rename(&mut self) -> Result<(), Diagnostics> {
        for (log, mapping) in self.logs.iter_mut().zip(&self.mappings) {
            if mapping != log.mapping() {
                *log = log.mapped(mapping.clone())?;
            }
        }
        Ok(())
    }

    /// Reads the current as an effort, and puts the motor into the model.
    fn take_current(&mut self, joint: &str, drive: &Drive, factor: f64) {
        for mapping in &mut self.mappings {
            let source = scaled(mapping, &format!("{joint}/motor_current"), factor);
            mapping.columns.insert(format!("{joint}/effort"), source);
        }
        let motor = [
            (&kinds::ROTOR_INERTIA, "inertia", drive.rotor_inertia_at_joint()),
            (&kinds::VISCOUS_FRICTION, "damping", drive.viscous_friction_at_joint()),
            (&kinds::COULOMB_FRICTION, "torque", drive.coulomb_friction_at_joint()),
        ];
        let mut added = Vec::new();
        for (kind, parameter, value) in motor {
            let effects = &mut self.robot.description.effects;
            let described = effects.iter().any(|effect| {
                effect.location.joint.as_deref() == Some(joint) && same_role(effect.kind, kind)
            });
            if value != 0.0 && !described {
                let effect = Effect::new(kind, Location::joint(joint), &[(parameter, value)]);
                added.push(format!("{} {value:.4} {}", kind.name.replace('_', " "), effect.unit(parameter)));
                effects.push(effect);
                self.has_motors = true;
            }
        }
        let motor = match added.as_slice() {
            [] => "what rotor and friction take is as the effects of the description say".to_owned(),
            some => format!("the drive takes its part of it at the joint: {}", some.join(", ")),
        };
        self.assumptions.push(format!(
            "effort of `{joint}` = {factor:.5} N m/A (gear ratio times torque constant) times `{joint}/motor_current`; {motor}"
        ));
    }

    /// A motor's angle beside efforts is of the shaft too where the description has the drive: as an angle of the joint, springs and play
    /// between them left aside.
    fn take_shaft(&mut self, joint: &str, drive: Option<&Drive>) {
        let Some(drive) = drive.filter(|drive| drive.has_motor()) else { return };
        let motor = format!("{joint}/motor_position");
        for (_, mapping) in self.logs.iter().zip(&mut self.mappings).filter(|(log, _)| log.has(&motor)) {
            let source = scaled(mapping, &motor, 1.0 / drive.turns());
            mapping.columns.insert(motor.clone(), source);
        }
    }

    /// Motor angles are of the shaft: as angles of the joint. `angles`: whether position and motor position are logged.
    fn take_angles(&mut self, joint: &str, drive: Option<&Drive>, angles: [bool; 2]) {
        let (Some(drive), [position, true]) = (drive.filter(|drive| drive.has_motor()), angles) else {
            return;
        };
        let motor = format!("{joint}/motor_position");
        let turns = drive.turns();
        for mapping in &mut self.mappings {
            let source = scaled(mapping, &motor, 1.0 / turns);
            if position {
                mapping.columns.insert(motor.clone(), source);
            } else if drive.is_stiff() {
                mapping.columns.insert(format!("{joint}/position"), source);
                mapping.columns.remove(&motor);
                mapping.ignored.insert(motor.clone());
            }
        }
        if !position && drive.is_stiff() {
            self.assumptions.push(format!("angle of `{joint}` = `{motor}` / {turns} (stiff drive)"));
        }
    }
}

/// Where this column of ours comes from, times a factor.
fn scaled(mapping: &Mapping, name: &str, factor: f64) -> MappedColumn {
    match mapping.columns.get(name) {
        Some(source) => MappedColumn {
            column: Some(source.column.clone().unwrap_or_else(|| name.to_owned())),
            factor: factor * source.factor,
            offset: factor * source.offset,
            position: source.position,
        },
        None => MappedColumn { column: Some(name.to_owned()), factor, offset: 0.0, position: (0, 0) },
    }
}

/// Whether an effect of the description says what the drive's number says.
fn same_role(kind: &effect::Kind, of_drive: &effect::Kind) -> bool {
    kind == of_drive || kind.contains(of_drive)
}
