//! What motors consist of, and how they are estimated.
use bipedc_effects::drive::Drive;
use nalgebra::DVector;
use serde::Serialize;

/// What a motor's torque consists of, beside the spring's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Laws {
    /// `F_v θ̇_M`
    pub viscous: bool,
    /// `F_c sign θ̇_M`
    pub coulomb: bool,
    /// Constant: of the current's sensor, or a shifted encoder.
    pub offset: bool,
}

impl Laws {
    /// Number of unknowns of a motor.
    pub fn count(&self) -> usize {
        1 + usize::from(self.viscous) + usize::from(self.coulomb) + usize::from(self.offset)
    }

    /// Place of the spring's stiffness among them.
    pub fn stiffness(&self) -> usize {
        usize::from(self.viscous) + usize::from(self.coulomb)
    }

    /// Names and units, in the order of the columns.
    pub fn names(&self) -> Vec<(&'static str, &'static str)> {
        let all = [
            (self.viscous, ("viscous_friction", "N m s/rad")),
            (self.coulomb, ("coulomb_friction", "N m")),
            (true, ("spring_stiffness", "N/m")),
            (self.offset, ("torque_offset", "N m")),
        ];
        all.into_iter().filter(|(wanted, _)| *wanted).map(|(_, name)| name).collect()
    }

    /// Described values in the same order.
    pub fn nominal(&self, drive: &Drive) -> DVector<f64> {
        let all = [
            (self.viscous, drive.viscous_friction),
            (self.coulomb, drive.coulomb_friction),
            (true, drive.cable_stiffness()),
            (self.offset, 0.0),
        ];
        DVector::from_vec(all.into_iter().filter(|(wanted, _)| *wanted).map(|(_, x)| x).collect())
    }
}

/// How the two regressions are put together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Steps {
    /// Motors first, then joints with the springs so found (5.13), (5.15).
    #[default]
    Two,
    /// One regression, every row by its own noise: joints tell about springs too.
    One,
}

/// How residuals count.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Estimator {
    /// All joints alike.
    Ordinary,
    /// Each joint by its own noise.
    #[default]
    Weighted,
    /// As weighted; instruments are the same signals from samples that the regressors do not use.
    Instrumental,
}
