//! The base's rows of the mass matrix: the momentum of the whole robot about the base's origin, per unit of each element of `v`.
//! Where the mass matrix takes few operations, so do momentum and centre of mass by way of it (Orin, Goswami and Lee 2013, (20)).
use super::frames::world_poses;
use super::model::RobotModel;
use super::momentum::{Wrench, center_of_mass, centroidal_momentum_matrix, times_rates};
use crate::expression::{Matrix3, Sym, Vector3};
use crate::tree::{JointMotion, Trunk};

/// Of a robot whose base moves freely, in space or in the plane.
pub struct BaseRows<'g> {
    /// From the base's axes to the world's, where these differ.
    rotation: Option<Matrix3<'g>>,
    /// The base's origin in the world, m.
    position: Vector3<'g>,
    /// Linear and angular momentum by element of `v`, about the base's origin in its axes; in the plane in the world's.
    columns: Vec<(Vector3<'g>, Vector3<'g>)>,
    /// From the base's origin to the centre of mass, in the same axes, m.
    arm: Vector3<'g>,
    per_mass: Sym<'g>,
    /// Rows of `v` along which the robot moves as one without turning.
    slides: Vec<usize>,
}

impl<'g> BaseRows<'g> {
    /// Of a mass matrix without rotors, whole or up to the base's rows; `None` for a base that is not free to move, or that moves in the plane and
    /// carries what leaves it.
    pub fn new(model: &RobotModel<'g, '_>, d: &[Vec<Sym<'g>>]) -> Option<Self> {
        let zero = model.constant(0.0);
        let per_mass = model.constant(1.0) / model.total_mass();
        let of_rows = |rows: [Option<usize>; 6]| {
            let vector = |rows: &[Option<usize>], j: usize| {
                Vector3([0, 1, 2].map(|k| rows[k].map_or(zero, |row| d[row][j])))
            };
            (0..model.tree.nv).map(|j| (vector(&rows[..3], j), vector(&rows[3..], j))).collect::<Vec<_>>()
        };
        let trunk = model.tree.trunk()?;
        let (Trunk::Floating(top) | Trunk::Planar(top)) = trunk;
        let pose = world_poses(model)[top];
        if let Trunk::Floating(_) = trunk {
            // The coupling of turning and moving is the first moment as a cross product.
            let arm = Vector3([d[5][1], d[3][2], d[4][0]]).scale(per_mass);
            let (rotation, columns) = (Some(pose.rotation), of_rows([0, 1, 2, 3, 4, 5].map(Some)));
            return Some(Self {
                rotation,
                position: pose.position,
                columns,
                arm,
                per_mass,
                slides: vec![0, 1, 2],
            });
        }
        if !stays_in_the_plane(model) {
            return None;
        }
        let row = |body: usize| model.tree.bodies[body].v_index;
        let along = |axis: usize| {
            (0..top).find(|&k| matches!(model.tree.bodies[k].motion, JointMotion::Prismatic { axis: a, .. } if a == axis))
        };
        let (x, z) = (along(0)?, along(2)?);
        let mut columns = of_rows([Some(row(x)), None, Some(row(z)), None, Some(row(top)), None]);
        for (linear, angular) in &mut columns {
            *linear = Vector3([model.signed(x, linear[0]), zero, model.signed(z, linear[2])]);
            *angular = Vector3([zero, model.signed(top, angular[1]), zero]);
        }
        // Turning by a rate of 1 moves the centre of mass by ŷ × arm.
        let moved = columns[row(top)].0.scale(per_mass);
        let arm = Vector3([-model.signed(top, moved[2]), zero, model.signed(top, moved[0])]);
        Some(Self {
            rotation: None,
            position: pose.position,
            columns,
            arm,
            per_mass,
            slides: vec![row(x), row(z)],
        })
    }

    fn in_world(&self, x: Vector3<'g>) -> Vector3<'g> {
        self.rotation.map_or(x, |rotation| rotation * x)
    }

    /// Angular momentum about the centre of mass, of a momentum about the base's origin.
    fn central(&self, (linear, angular): (Vector3<'g>, Vector3<'g>)) -> Wrench<'g> {
        Wrench { linear: self.in_world(linear), angular: self.in_world(angular - self.arm.cross(linear)) }
    }

    /// As [`super::momentum::centroidal_momentum_matrix`].
    pub fn centroidal_momentum_matrix(&self, model: &RobotModel<'g, '_>) -> Vec<Wrench<'g>> {
        let _work = model.work_on_all("centroidal momentum matrix");
        let column = |(k, &momentum): (usize, &(Vector3<'g>, Vector3<'g>))| {
            let found = self.central(momentum);
            // Nor does it turn about its centre of mass then.
            if self.slides.contains(&k) { Wrench { angular: model.zero3(), ..found } } else { found }
        };
        self.columns.iter().enumerate().map(column).collect()
    }

    /// Linear momentum, and angular momentum about the centre of mass, world axes.
    pub fn centroidal_momentum(&self, model: &RobotModel<'g, '_>) -> Wrench<'g> {
        let sum = times_rates(model, |k| {
            let (linear, angular) = self.columns[k];
            Wrench { linear, angular }
        });
        let _work = model.work_on_all("centroidal momentum");
        self.central((sum.linear, sum.angular))
    }

    /// Centre of mass in the world, m.
    pub fn center_of_mass(&self, model: &RobotModel<'g, '_>) -> Vector3<'g> {
        let _work = model.work_on_all("centre of mass");
        self.position + self.in_world(self.arm)
    }

    /// As [`super::momentum::center_of_mass_jacobian`].
    pub fn center_of_mass_jacobian(&self, model: &RobotModel<'g, '_>) -> Vec<Vector3<'g>> {
        let _work = model.work_on_all("Jacobian of the centre of mass");
        self.columns.iter().map(|(linear, _)| self.in_world(linear.scale(self.per_mass))).collect()
    }
}

/// Whether nothing moves or lies out of the x–z plane, by the structure of the expressions: the base's three rows tell all then.
fn stays_in_the_plane(model: &RobotModel<'_, '_>) -> bool {
    let in_plane = |w: &Wrench<'_>| w.linear[1].is_zero() && w.angular[0].is_zero() && w.angular[2].is_zero();
    center_of_mass(model)[1].is_zero() && centroidal_momentum_matrix(model).iter().all(in_plane)
}
