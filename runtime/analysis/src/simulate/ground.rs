//! Laws of the ground and of joints.
use super::implicit::Relaxed;
use super::problem::Cone;
use bipedc_effects::diagnostic::Diagnostic;

/// The ground z = 0 and how soles meet it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ground {
    /// Coulomb's friction coefficient μ (4.5).
    pub friction: f64,
    /// Normal speed after over normal speed before an impact, e_N of (4.3), 0 to 1.
    pub normal_restitution: f64,
    /// The same of tangential speed, e_T, −1 to 1. Unequal to e_N it can make energy.
    pub tangential_restitution: f64,
    /// Shape of the friction law.
    pub cone: Cone,
    /// Sole and ground give way: there is no restitution then.
    pub compliance: Option<Compliance>,
    /// Part of the penetration that hard ground pushes out per second, 1/s; 0: penetration stays, and no energy is
    /// made. It comes from impacts with restitution, where it is about the impact's speed times half a step, and from edges of the ground.
    pub recovery: f64,
}

/// Spring and damper below each contact point, along the normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Compliance {
    /// N/m
    pub stiffness: f64,
    /// N s/m
    pub damping: f64,
}

/// Heights that are rounding, m: a sole's corners would share its load by it.
const ROUNDED: f64 = 1e-12;

impl Default for Ground {
    /// Hard, no rebound, μ = 0.8.
    fn default() -> Self {
        Self {
            friction: 0.8,
            normal_restitution: 0.0,
            tangential_restitution: 0.0,
            cone: Cone::Round,
            compliance: None,
            recovery: 0.0,
        }
    }
}

impl Ground {
    /// Whether impacts give something back.
    pub fn restores(&self) -> bool {
        self.normal_restitution != 0.0 || self.tangential_restitution != 0.0
    }

    /// What makes a row soft whose point is `gap` above the ground at the middle of the step.
    pub(super) fn relaxed(&self, gap: f64, time: f64) -> Relaxed {
        match self.compliance {
            Some(soft) => {
                let stiff = 0.5 * time * soft.stiffness + soft.damping;
                Relaxed { softness: 1.0 / (time * stiff), offset: soft.stiffness * gap / stiff }
            }
            // The way down would last as long as a step: as at stops of joints. It is used up within two, without rebound.
            None => {
                let offset = if gap > ROUNDED { gap / time } else { self.recovery * gap.min(0.0) };
                Relaxed { softness: 0.0, offset }
            }
        }
    }

    /// Whether its numbers are possible.
    ///
    /// # Errors
    /// Names the first one that is not.
    pub fn check(&self) -> Result<(), Diagnostic> {
        within("friction", self.friction, 0.0, f64::MAX, "1")?;
        within("normal_restitution", self.normal_restitution, 0.0, 1.0, "1")?;
        within("tangential_restitution", self.tangential_restitution, -1.0, 1.0, "1")?;
        within("recovery", self.recovery, 0.0, f64::MAX, "1/s")?;
        if let Some(soft) = self.compliance {
            within("stiffness", soft.stiffness, f64::MIN_POSITIVE, f64::MAX, "N/m")?;
            within("damping", soft.damping, 0.0, f64::MAX, "N s/m")?;
        }
        Ok(())
    }
}

/// What acts in a joint besides the given torque.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct JointLaw {
    /// Added to the joint's own inertia, kg m².
    pub rotor_inertia: f64,
    /// N m s/rad
    pub damping: f64,
    /// By how much more the given torque resists per speed gained within the step, N m s/rad: of laws that are taken at
    /// its middle. Not negative.
    pub slope: f64,
    /// Dry friction against positive and against negative motion, N m: set-valued, a joint can stick.
    pub dry: [f64; 2],
    /// Positions where stops begin, rad; hit without rebound.
    pub limits: Option<[f64; 2]>,
}

impl JointLaw {
    /// What is left to a stop, rad; negative beyond it.
    pub(super) fn way(&self, upper: bool, q: f64) -> Option<f64> {
        self.limits.map(|[low, high]| if upper { high - q } else { q - low })
    }

    /// Whether its numbers are possible.
    ///
    /// # Errors
    /// Names the first one that is not.
    pub fn check(&self) -> Result<(), Diagnostic> {
        within("rotor inertia", self.rotor_inertia, 0.0, f64::MAX, "kg m²")?;
        within("slope", self.slope, 0.0, f64::MAX, "N m s/rad")?;
        within("damping", self.damping, 0.0, f64::MAX, "N m s/rad")?;
        within("dry friction", self.dry[0], 0.0, f64::MAX, "N m")?;
        within("dry friction", self.dry[1], 0.0, f64::MAX, "N m")?;
        match self.limits {
            Some([low, high]) if low >= high || low.is_nan() || high.is_nan() => {
                Err(Diagnostic::error(format!("joint limits of {low} to {high} rad leave no position"))
                    .help("the lower limit must be below the upper one"))
            }
            _ => Ok(()),
        }
    }
}

pub(super) fn within(name: &str, value: f64, low: f64, high: f64, unit: &str) -> Result<(), Diagnostic> {
    if value >= low && value <= high {
        return Ok(());
    }
    let range =
        if high == f64::MAX { "not negative and finite".to_owned() } else { format!("{low} to {high}") };
    Err(Diagnostic::error(format!("{name} = {value} {unit} is not possible"))
        .help(format!("it must be {range}")))
}
