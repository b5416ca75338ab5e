//! What is estimated: base parameters of the rigid bodies, and what joints add to them.
use crate::robot::JointLayout;
use bipedc_effects::diagnostic::Diagnostic;
use serde::Serialize;

/// The base parameters of the observed rows (thesis 5.2): which sums of inertial parameters these rows depend on.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BaseSet {
    /// Such as `torso.m*cx + 0.0764 left_hip.m`.
    pub names: Vec<String>,
    /// `kg`, `kg m` or `kg m²`.
    pub units: Vec<&'static str>,
    /// The sums: (index among ten inertial parameters per body, factor).
    pub sums: Vec<Vec<(usize, f64)>>,
}

impl BaseSet {
    /// The column of the full regressor that stands for a base parameter: its sum leads with factor 1.
    pub fn leading(&self, parameter: usize) -> Option<usize> {
        self.sums[parameter].first().map(|(column, _)| *column)
    }

    /// Values for given inertial parameters, ten per body.
    pub fn values(&self, parameters: &[f64]) -> Vec<f64> {
        let value = |sum: &Vec<(usize, f64)>| sum.iter().map(|(k, factor)| factor * parameters[*k]).sum();
        self.sums.iter().map(value).collect()
    }
}

/// A torque that a joint has beside that of rigid bodies, linear in one parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Law {
    /// Times the joint's velocity; N m s/rad.
    Viscous,
    /// Times the sign of the joint's velocity; N m.
    Coulomb,
    /// Constant; N m.
    Offset,
    /// Times the joint's acceleration: the rotor behind its gear; kg m².
    Rotor,
    /// Times the other joint's acceleration, on both of a pair; kg m².
    CoupledInertia,
    /// Times the other joint's velocity, on both of a pair; N m s/rad.
    CoupledViscous,
    /// Times the sign of the sum of both velocities, on both of a pair; N m.
    CoupledCoulomb,
}

impl Law {
    /// Whether a negative value has no physical meaning.
    pub fn is_positive(self) -> bool {
        matches!(self, Self::Viscous | Self::Coulomb | Self::Rotor)
    }

    fn name(self) -> &'static str {
        match self {
            Self::Viscous => "viscous_friction",
            Self::Coulomb => "coulomb_friction",
            Self::Offset => "torque_offset",
            Self::Rotor => "rotor_inertia",
            Self::CoupledInertia => "coupled_inertia",
            Self::CoupledViscous => "coupled_viscous_friction",
            Self::CoupledCoulomb => "coupled_coulomb_friction",
        }
    }

    fn unit(self, prismatic: bool) -> &'static str {
        match (self, prismatic) {
            (Self::Viscous | Self::CoupledViscous, false) => "N m s/rad",
            (Self::Viscous | Self::CoupledViscous, true) => "N s/m",
            (Self::Coulomb | Self::Offset | Self::CoupledCoulomb, false) => "N m",
            (Self::Coulomb | Self::Offset | Self::CoupledCoulomb, true) => "N",
            (Self::Rotor | Self::CoupledInertia, false) => "kg m²",
            (Self::Rotor | Self::CoupledInertia, true) => "kg",
        }
    }
}

/// A [`Law`] at a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Extra {
    /// Which torque.
    pub law: Law,
    /// Index of the joint.
    pub joint: usize,
    /// The other one of a pair; the joint itself for other laws.
    pub other: usize,
}

impl Extra {
    /// `left_knee.coulomb_friction`, `joint_5+joint_6.coupled_inertia`.
    pub fn name(&self, subject: &JointLayout) -> String {
        let of = |joint: usize| &subject.joints[joint].name;
        if self.joint == self.other {
            format!("{}.{}", of(self.joint), self.law.name())
        } else {
            format!("{}+{}.{}", of(self.joint), of(self.other), self.law.name())
        }
    }

    /// Unit of its parameter.
    pub fn unit(&self, subject: &JointLayout) -> &'static str {
        self.law.unit(subject.joints[self.joint].prismatic)
    }

    /// Torque on `joint` for a parameter of 1; `None` if it has none there. `v`, `a`: of all joints.
    pub fn torque(&self, joint: usize, v: &[f64], a: &[f64]) -> Option<f64> {
        if joint != self.joint && joint != self.other {
            return None;
        }
        let across = if joint == self.joint { self.other } else { self.joint };
        let sign = |x: f64| f64::from(i8::from(x > 0.0) - i8::from(x < 0.0));
        Some(match self.law {
            Law::Viscous => v[joint],
            Law::Coulomb => sign(v[joint]),
            Law::Offset => 1.0,
            Law::Rotor => a[joint],
            Law::CoupledInertia => a[across],
            Law::CoupledViscous => v[across],
            Law::CoupledCoulomb => sign(v[self.joint] + v[self.other]),
        })
    }
}

/// Which extras a model has.
#[derive(Debug, Clone, PartialEq)]
pub struct ExtraChoice {
    /// Friction proportional to velocity.
    pub viscous: bool,
    /// Dry friction.
    pub coulomb: bool,
    /// Constant torque: the sensor's zero, or asymmetric friction.
    pub offset: bool,
    /// Joints with a rotor whose inertia the effort has to move too.
    pub rotors: Vec<usize>,
    /// Pairs of joints whose drives turn together.
    pub coupled: Vec<(usize, usize)>,
    /// These and no others, whatever else is chosen, with their described values.
    pub exactly: Option<Vec<(Extra, f64)>>,
}

impl Default for ExtraChoice {
    fn default() -> Self {
        Self {
            viscous: true,
            coulomb: true,
            offset: true,
            rotors: Vec::new(),
            coupled: Vec::new(),
            exactly: None,
        }
    }
}

impl ExtraChoice {
    /// No friction, no offset: rigid bodies alone.
    pub fn none() -> Self {
        Self {
            viscous: false,
            coulomb: false,
            offset: false,
            rotors: Vec::new(),
            coupled: Vec::new(),
            exactly: None,
        }
    }

    /// Value of an extra in the description; zero where it says nothing.
    pub fn described(&self, extra: &Extra) -> f64 {
        let known = self.exactly.iter().flatten().find(|(known, _)| known == extra);
        known.map_or(0.0, |(_, value)| *value)
    }

    /// All extras of the joints that are observed.
    pub fn list(&self, observed: &[usize]) -> Vec<Extra> {
        if let Some(extras) = &self.exactly {
            return extras.iter().map(|(extra, _)| *extra).collect();
        }
        let mut list = Vec::new();
        for &joint in observed {
            let laws = [
                (self.rotors.contains(&joint), Law::Rotor),
                (self.viscous, Law::Viscous),
                (self.coulomb, Law::Coulomb),
                (self.offset, Law::Offset),
            ];
            let wanted = laws.into_iter().filter(|(wanted, _)| *wanted);
            list.extend(wanted.map(|(_, law)| Extra { law, joint, other: joint }));
        }
        for &(joint, other) in &self.coupled {
            let laws = [Law::CoupledInertia, Law::CoupledViscous, Law::CoupledCoulomb];
            list.extend(laws.map(|law| Extra { law, joint, other }));
        }
        list
    }
}

/// What one unknown is a sum of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Part {
    /// Index among ten inertial parameters per body.
    Inertial(usize),
    /// Index among the extras.
    Extra(usize),
}

/// One column of the regression.
#[derive(Debug, Clone, PartialEq)]
pub struct Unknown {
    /// Base parameter or extra, in words.
    pub name: String,
    /// Its unit.
    pub unit: &'static str,
    /// The sum it stands for; the leading term first, with factor 1.
    pub sum: Vec<(Part, f64)>,
    /// Column of the base regressor, or else the extra.
    pub source: Source,
}

/// Where a column's numbers come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// Column of the base regressor.
    Base(usize),
    /// Index among the extras.
    Extra(usize),
}

/// The unknowns of base parameters and extras, nothing grouped yet.
pub fn plain(base: &BaseSet, extras: &[Extra], subject: &JointLayout) -> Vec<Unknown> {
    let inertial =
        base.names.iter().zip(&base.units).zip(&base.sums).enumerate().map(|(k, ((name, unit), sum))| {
            let sum = sum.iter().map(|(p, factor)| (Part::Inertial(*p), *factor)).collect();
            Unknown { name: name.clone(), unit, sum, source: Source::Base(k) }
        });
    let joints = extras.iter().enumerate().map(|(k, extra)| Unknown {
        name: extra.name(subject),
        unit: extra.unit(subject),
        sum: vec![(Part::Extra(k), 1.0)],
        source: Source::Extra(k),
    });
    inertial.chain(joints).collect()
}

/// Joints by name.
///
/// # Errors
/// A name that no joint has.
pub fn joint(subject: &JointLayout, name: &str) -> Result<usize, Diagnostic> {
    subject.joints.iter().position(|joint| joint.name == name).ok_or_else(|| {
        let known: Vec<&str> = subject.joints.iter().map(|joint| joint.name.as_str()).collect();
        Diagnostic::error(format!("there is no joint `{name}`"))
            .help(format!("joints are: {}", known.join(", ")))
    })
}
