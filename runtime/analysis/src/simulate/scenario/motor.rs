//! `drives` and `[motor.JOINT]` of a scenario: what moves the joints.
use super::file::{File, Motor, Number};
use super::reading::{ANY, NOT_NEGATIVE, POSITIVE, Reading};
use crate::simulate::{Actuator, Plant};
use bipedc_effects::drive::{Drive, Transmission};
use toml::Spanned;

impl Reading<'_> {
    /// The index of what was chosen; the first is the default.
    pub(super) fn choice<const N: usize>(
        &mut self,
        name: &str,
        found: Option<&Spanned<String>>,
        choices: [&str; N],
    ) -> usize {
        let Some(found) = found else { return 0 };
        if let Some(index) = choices.iter().position(|choice| choice == found.get_ref()) {
            return index;
        }
        let message = format!("there is no {name} \"{}\"", found.get_ref());
        let help = choices.map(|choice| format!("\"{choice}\"")).join(" or ");
        self.wrong::<()>(found.span().start, message, format!("write {name} = {help}"));
        0
    }

    /// Motors by joint.
    pub(super) fn motors(&mut self, file: &File, plant: &Plant) -> Vec<Option<Actuator>> {
        for (name, motor) in file.motor.iter().filter(|(name, _)| plant.joint(name).is_none()) {
            self.no_joint(motor.span().start, name, plant);
        }
        let described = self.choice("drives", file.drives.as_ref(), ["ideal", "described"]) == 1;
        if let Some(drives) =
            file.drives.as_ref().filter(|_| described && plant.drives.iter().all(Option::is_none))
        {
            let help = "add [drives.JOINT] tables to biped.toml, or [motor.JOINT] tables here";
            self.wrong::<()>(drives.span().start, "the description has no drives", help);
        }
        let names: Vec<String> = plant.joint_names().map(str::to_owned).collect();
        let of = |(j, name): (usize, &String)| {
            let known = plant.drives.get(j).copied().flatten().map(Actuator::described);
            match file.motor.get(name) {
                Some(table) => Some(self.motor(table, known)),
                None => known.filter(|_| described),
            }
        };
        names.iter().enumerate().map(of).collect()
    }

    /// One table over what the description knows.
    fn motor(&mut self, table: &Spanned<Motor>, known: Option<Actuator>) -> Actuator {
        let motor = table.get_ref();
        let mut actuator = known.unwrap_or_default();
        if !actuator.drive.has_motor() {
            let help = "the description says that it is passive: take the table out";
            self.wrong::<()>(table.span().start, "[motor] of a joint without a motor", help);
        }
        let mut stiffness = actuator.series_stiffness();
        actuator.drive = self.shaft(motor, &actuator.drive);
        let mut over =
            |name: &str, found: &Option<Number>, value: &mut f64, range: (f64, f64), unit: &str| {
                *value = self.number(name, found.as_ref(), *value, range, unit);
            };
        over("resistance", &motor.resistance, &mut actuator.resistance, NOT_NEGATIVE, "Ω");
        over("voltage_limit", &motor.voltage_limit, &mut actuator.voltage_limit, POSITIVE, "V");
        over("current_limit", &motor.current_limit, &mut actuator.current_limit, POSITIVE, "A");
        over("stiffness", &motor.stiffness, &mut stiffness, POSITIVE, "N m/rad");
        actuator.stiffness = Some(stiffness);
        let damping = &mut actuator.spring_damping;
        over("spring_damping", &motor.spring_damping, damping, NOT_NEGATIVE, "N m s/rad");
        over("gap", &motor.gap, &mut actuator.gap, NOT_NEGATIVE, "rad");
        let mut counts = |name: &str, found: &Option<Number>, known: &mut Option<f64>| {
            if found.is_some() {
                *known = Some(self.counts(name, found.as_ref())).filter(|counts| *counts > 0.0);
            }
        };
        let drive = &mut actuator.drive;
        counts("encoder_counts", &motor.encoder_counts, &mut drive.motor_encoder_counts);
        counts("joint_encoder_counts", &motor.joint_encoder_counts, &mut drive.joint_encoder_counts);
        actuator.voltage_command =
            self.choice("command", motor.command.as_ref(), ["current", "voltage"]) == 1;
        self.check_motor(table, &actuator);
        actuator
    }

    /// Gear, rotor, friction and torque constant. Gear ratio and spring of a scenario are those that the joint sees, so that
    /// pulleys are in them: what is left of the transmission is stiff.
    fn shaft(&mut self, motor: &Motor, known: &Drive) -> Drive {
        let (gear_ratio, transmission) = (known.turns(), Transmission::Stiff);
        let mut drive = Drive { gear_ratio, transmission, ..*known };
        let mut constant = known.torque_constant.unwrap_or(0.0);
        let mut over =
            |name: &str, found: &Option<Number>, value: &mut f64, range: (f64, f64), unit: &str| {
                *value = self.number(name, found.as_ref(), *value, range, unit);
            };
        over("gear_ratio", &motor.gear_ratio, &mut drive.gear_ratio, ANY, "1");
        over("torque_constant", &motor.torque_constant, &mut constant, POSITIVE, "N m/A");
        over("rotor_inertia", &motor.rotor_inertia, &mut drive.rotor_inertia, NOT_NEGATIVE, "kg m²");
        let viscous = &mut drive.viscous_friction;
        over("viscous_friction", &motor.viscous_friction, viscous, NOT_NEGATIVE, "N m s/rad");
        over("coulomb_friction", &motor.coulomb_friction, &mut drive.coulomb_friction, NOT_NEGATIVE, "N m");
        drive.torque_constant = (constant > 0.0).then_some(constant);
        drive
    }

    fn check_motor(&mut self, table: &Spanned<Motor>, actuator: &Actuator) {
        let at = table.span().start;
        let motor = table.get_ref();
        if actuator.drive.gear_ratio == 0.0 {
            self.wrong::<()>(
                at,
                "a gear ratio of 0 moves nothing",
                "write motor turns per turn of the joint",
            );
        }
        let electric = [
            ("resistance", motor.resistance.is_some()),
            ("voltage_limit", motor.voltage_limit.is_some()),
            ("current_limit", motor.current_limit.is_some()),
            ("command", motor.command.is_some()),
        ];
        if let Some((key, _)) =
            electric.iter().find(|(_, given)| *given && actuator.drive.torque_constant.is_none())
        {
            self.wrong::<()>(at, format!("`{key}` of a motor without `torque_constant`"), "add it in N m/A");
        }
        let volts = actuator.voltage_command || actuator.voltage_limit.is_finite();
        if volts && actuator.resistance == 0.0 {
            let help = "add `resistance` in Ω: the current follows from it";
            self.wrong::<()>(at, "a voltage at a motor without `resistance`", help);
        }
    }
}
