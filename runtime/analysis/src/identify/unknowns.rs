//! What is estimated: base parameters of the rigid bodies, and what joints add to them.
use crate::robot::JointLayout;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::{Identified, KINDS, Kind, UnitTorque, kinds};

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
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Law {
    /// A kind of effect that is offered to identifications ([`Kind::identified`]).
    Joint(&'static Kind),
    /// Times the other joint's acceleration, on both of a pair; kg m².
    CoupledInertia,
    /// Times the other joint's velocity, on both of a pair; N m s/rad.
    CoupledViscous,
    /// Times the sign of the sum of both velocities, on both of a pair; N m.
    CoupledCoulomb,
}

impl Law {
    /// Times the joint's velocity; N m s/rad.
    pub const VISCOUS: Self = Self::Joint(&kinds::VISCOUS_FRICTION);
    /// Times the sign of the joint's velocity; N m.
    pub const COULOMB: Self = Self::Joint(&kinds::COULOMB_FRICTION);
    /// Constant; N m.
    pub const OFFSET: Self = Self::Joint(&kinds::TORQUE_BIAS);
    /// Times the joint's acceleration: the rotor behind its gear; kg m².
    pub const ROTOR: Self = Self::Joint(&kinds::ROTOR_INERTIA);

    fn identified(self) -> Option<Identified> {
        match self {
            Self::Joint(kind) => kind.identified,
            Self::CoupledInertia | Self::CoupledViscous | Self::CoupledCoulomb => None,
        }
    }

    /// The parameter of the effect `coupling` that an unknown of this name is, at both joints of a pair.
    pub fn coupling_parameter(unknown: &str) -> Option<&'static str> {
        let terms = [
            (Self::CoupledInertia, "inertia"),
            (Self::CoupledViscous, "damping"),
            (Self::CoupledCoulomb, "coulomb"),
        ];
        terms.into_iter().find(|(law, _)| law.name() == unknown).map(|(_, parameter)| parameter)
    }

    /// Whether a negative value has no physical meaning.
    pub fn is_positive(self) -> bool {
        self.identified().is_some_and(|identified| identified.positive)
    }

    fn name(self) -> &'static str {
        match self {
            Self::Joint(kind) => kind.identified.map_or(kind.name, |identified| identified.unknown),
            Self::CoupledInertia => "coupled_inertia",
            Self::CoupledViscous => "coupled_viscous_friction",
            Self::CoupledCoulomb => "coupled_coulomb_friction",
        }
    }

    fn unit(self, prismatic: bool) -> &'static str {
        match (self, prismatic) {
            (Self::Joint(kind), sliding) => {
                kind.estimated().next().map_or("1", |parameter| kind.unit(parameter.name, sliding))
            }
            (Self::CoupledViscous, false) => "N m s/rad",
            (Self::CoupledViscous, true) => "N s/m",
            (Self::CoupledCoulomb, false) => "N m",
            (Self::CoupledCoulomb, true) => "N",
            (Self::CoupledInertia, false) => "kg m²",
            (Self::CoupledInertia, true) => "kg",
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
    pub fn name(&self, layout: &JointLayout) -> String {
        let of = |joint: usize| &layout.joints[joint].name;
        if self.joint == self.other {
            format!("{}.{}", of(self.joint), self.law.name())
        } else {
            format!("{}+{}.{}", of(self.joint), of(self.other), self.law.name())
        }
    }

    /// Unit of its parameter.
    pub fn unit(&self, layout: &JointLayout) -> &'static str {
        self.law.unit(layout.joints[self.joint].prismatic)
    }

    /// The joints whose direction alone decides its torque: the sign of the sum of their speeds, of one joint that joint
    /// twice.
    pub fn direction(&self) -> Option<(usize, usize)> {
        match self.law {
            Law::Joint(kind) => UnitTorque::of(kind)?.is_sign().then_some((self.joint, self.joint)),
            Law::CoupledCoulomb => Some((self.joint, self.other)),
            Law::CoupledInertia | Law::CoupledViscous => None,
        }
    }

    /// What tells its torque; to be made once for many samples.
    pub fn torque(self) -> ExtraTorque {
        let unit = match self.law {
            Law::Joint(kind) => UnitTorque::of(kind),
            Law::CoupledInertia | Law::CoupledViscous | Law::CoupledCoulomb => None,
        };
        ExtraTorque { extra: self, unit }
    }
}

/// The torque of an [`Extra`] for a parameter of 1.
#[derive(Debug, Clone)]
pub struct ExtraTorque {
    extra: Extra,
    unit: Option<UnitTorque>,
}

impl ExtraTorque {
    /// Torque on `joint`; `None` if it has none there. `v`, `a`: of all joints.
    pub fn on(&self, joint: usize, v: &[f64], a: &[f64]) -> Option<f64> {
        let extra = &self.extra;
        if joint != extra.joint && joint != extra.other {
            return None;
        }
        let across = if joint == extra.joint { extra.other } else { extra.joint };
        let sign = |x: f64| f64::from(i8::from(x > 0.0) - i8::from(x < 0.0));
        match extra.law {
            Law::Joint(_) => Some(self.unit.as_ref()?.at(v[joint], a[joint])),
            Law::CoupledInertia => Some(a[across]),
            Law::CoupledViscous => Some(v[across]),
            Law::CoupledCoulomb => Some(sign(v[extra.joint] + v[extra.other])),
        }
    }
}

/// Which extras a model has.
#[derive(Debug, Clone, PartialEq)]
pub struct ExtraChoice {
    /// At every joint, in the order of the library.
    pub laws: Vec<&'static Kind>,
    /// Joints with a rotor whose inertia the effort has to move too.
    pub rotors: Vec<usize>,
    /// Pairs of joints whose drives turn together.
    pub coupled: Vec<(usize, usize)>,
    /// These and no others, whatever else is chosen, with their described values.
    pub exactly: Option<Vec<(Extra, f64)>>,
}

/// The kinds of effects that an identification offers at joints.
pub fn offered() -> impl Iterator<Item = (&'static Kind, Identified)> {
    KINDS.iter().filter_map(|kind| Some((*kind, kind.identified?)))
}

impl Default for ExtraChoice {
    fn default() -> Self {
        let usual = offered().filter(|(_, identified)| identified.by_default);
        Self { laws: usual.map(|(kind, _)| kind).collect(), ..Self::none() }
    }
}

impl ExtraChoice {
    /// No friction, no offset: rigid bodies alone.
    pub fn none() -> Self {
        Self { laws: Vec::new(), rotors: Vec::new(), coupled: Vec::new(), exactly: None }
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
            let rotor = self.rotors.contains(&joint).then_some(Law::ROTOR);
            let laws = self.laws.iter().map(|kind| Law::Joint(kind)).filter(|law| Some(*law) != rotor);
            list.extend(rotor.into_iter().chain(laws).map(|law| Extra { law, joint, other: joint }));
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
pub enum Summand {
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
    pub sum: Vec<(Summand, f64)>,
    /// Column of the base regressor, or else the extra.
    pub source: ColumnSource,
}

/// Where a column's numbers come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColumnSource {
    /// Column of the base regressor.
    Base(usize),
    /// Index among the extras.
    Extra(usize),
}

/// The unknowns of base parameters and extras, nothing grouped yet.
pub fn plain(base: &BaseSet, extras: &[Extra], layout: &JointLayout) -> Vec<Unknown> {
    let inertial =
        base.names.iter().zip(&base.units).zip(&base.sums).enumerate().map(|(k, ((name, unit), sum))| {
            let sum = sum.iter().map(|(p, factor)| (Summand::Inertial(*p), *factor)).collect();
            Unknown { name: name.clone(), unit, sum, source: ColumnSource::Base(k) }
        });
    let joints = extras.iter().enumerate().map(|(k, extra)| Unknown {
        name: extra.name(layout),
        unit: extra.unit(layout),
        sum: vec![(Summand::Extra(k), 1.0)],
        source: ColumnSource::Extra(k),
    });
    inertial.chain(joints).collect()
}

/// Joints by name.
///
/// # Errors
/// A name that no joint has.
pub fn joint(layout: &JointLayout, name: &str) -> Result<usize, Diagnostic> {
    layout.joints.iter().position(|joint| joint.name == name).ok_or_else(|| {
        let known: Vec<&str> = layout.joints.iter().map(|joint| joint.name.as_str()).collect();
        Diagnostic::error(format!("there is no joint `{name}`"))
            .help(format!("joints are: {}", known.join(", ")))
    })
}
