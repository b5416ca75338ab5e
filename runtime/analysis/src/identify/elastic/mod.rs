//! Series elastic drives: friction and springs from the motors' side, bodies from the springs' torques (thesis 5.3.1).
//!
//! The motor of joint i obeys `K_t i = I_M θ̈_M + F_v θ̇_M + F_c sign θ̇_M + (r_M/N) k (r_M/N θ_M − r_L q) + o` (4.31), the joint
//! `k r_L (r_M/N θ_M − r_L q) = D q̈ + C q̇ + G` (4.32). Inertia of the rotor, pulley radii, gear and torque constant are known
//! ([`Driven`]); `F_v`, `F_c`, `k` and the offset `o` of each motor follow from its current (5.13), then base parameters
//! from the springs' torques (5.15). Stiff drives join the second step with their current, less what the rotor takes, and
//! their own friction; passive joints with the torque of their described spring and damper.
//!
//! The way of the data: [`look`] reads each log once (which motion, how fast, which signals), [`fold`] once more and keeps
//! triangles only: per stretch of motion, motor and joint. Stiffness stays an unknown of the joints' rows ([`Folded`]), so
//! that both steps, both at once, and every jackknife replicate of both work on the triangles.
mod bodies;
mod check;
mod driven;
mod fold;
mod laws;
mod linear;
mod look;
mod noise;
mod picture;
mod plan;
mod rows;
mod run;
mod signals;
mod solve;
mod summary;

pub use driven::Driven;
pub use fold::{Folded, fold};
pub use laws::{Estimator, Laws, Steps};
pub use look::{Look, look};
pub use plan::Columns;
pub use run::{Elastic, ElasticAnswer, ElasticParts, identify_elastic};
pub use summary::{DriveParameter, DriveSummary, JointDriveSummary, MotorErrors};
