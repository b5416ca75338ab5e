//! `drives` and `[motor.JOINT]` of a scenario: what moves the joints.
use super::file::{File, Motor, Number};
use super::read::{ANY, NOT_NEGATIVE, POSITIVE, Reading};
use crate::log::closest;
use crate::simulate::{Actuator, Plant};
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
            let help = match closest(name, plant.joint_names()) {
                Some(meant) => format!("did you mean `{meant}`?"),
                None => format!("joints: {}", plant.joint_names().collect::<Vec<_>>().join(", ")),
            };
            self.wrong::<()>(motor.span().start, format!("the robot has no joint `{name}`"), help);
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
            let known = plant.drives.get(j).copied().flatten();
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
        let base = known.unwrap_or_default();
        if base.passive.is_some() {
            let help = "the description says that it is passive: take the table out";
            self.wrong::<()>(table.span().start, "[motor] of a joint without a motor", help);
        }
        let mut of = |name: &str, found: &Option<Number>, default: f64, range: (f64, f64), unit: &str| {
            self.number(name, found.as_ref(), default, range, unit)
        };
        let turns = of("gear_ratio", &motor.gear_ratio, base.turns, ANY, "1");
        let constant = of(
            "torque_constant",
            &motor.torque_constant,
            base.torque_constant.unwrap_or(0.0),
            POSITIVE,
            "N m/A",
        );
        let actuator = Actuator {
            turns,
            rotor_inertia: of(
                "rotor_inertia",
                &motor.rotor_inertia,
                base.rotor_inertia,
                NOT_NEGATIVE,
                "kg m²",
            ),
            viscous_friction: of(
                "viscous_friction",
                &motor.viscous_friction,
                base.viscous_friction,
                NOT_NEGATIVE,
                "N m s/rad",
            ),
            coulomb_friction: of(
                "coulomb_friction",
                &motor.coulomb_friction,
                base.coulomb_friction,
                NOT_NEGATIVE,
                "N m",
            ),
            torque_constant: (constant > 0.0).then_some(constant),
            resistance: of("resistance", &motor.resistance, base.resistance, NOT_NEGATIVE, "Ω"),
            voltage_limit: of("voltage_limit", &motor.voltage_limit, base.voltage_limit, POSITIVE, "V"),
            current_limit: of("current_limit", &motor.current_limit, base.current_limit, POSITIVE, "A"),
            stiffness: of("stiffness", &motor.stiffness, base.stiffness, POSITIVE, "N m/rad"),
            spring_damping: of(
                "spring_damping",
                &motor.spring_damping,
                base.spring_damping,
                NOT_NEGATIVE,
                "N m s/rad",
            ),
            gap: of("gap", &motor.gap, base.gap, NOT_NEGATIVE, "rad"),
            motor_counts: of("encoder_counts", &motor.encoder_counts, base.motor_counts, NOT_NEGATIVE, "1"),
            joint_counts: of(
                "joint_encoder_counts",
                &motor.joint_encoder_counts,
                base.joint_counts,
                NOT_NEGATIVE,
                "1",
            ),
            voltage_command: self.choice("command", motor.command.as_ref(), ["current", "voltage"]) == 1,
            ..base
        };
        self.check_motor(table, &actuator);
        actuator
    }

    fn check_motor(&mut self, table: &Spanned<Motor>, actuator: &Actuator) {
        let at = table.span().start;
        let motor = table.get_ref();
        if actuator.turns == 0.0 {
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
            electric.iter().find(|(_, given)| *given && actuator.torque_constant.is_none())
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
