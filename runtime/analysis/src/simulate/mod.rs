//! Simulation of walking robots (thesis chapter 4).
//!
//! [`Stepper`] is the non-smooth time stepping of 4.3: rigid ground, Signorini's and Coulomb's laws, Newton's law of
//! impact, all contacts at once ([`Problem`], [`Solver`]), on any [`Model`](bipedc_runtime::Model) with a mass matrix, a bias and
//! contact points ([`Mechanics`]). A [`Scenario`] file says what a [`Simulation`] of a robot ([`Plant`]) does: initial
//! state, controllers, hidden effects, sensors; its rows are a measurement log.
//!
//! [`FreeStepper`] does the same for planar robots in absolute coordinates, every link by itself: a check of the first.
//!
//! [`phases`] is the event-driven simulation of 4.4: phases in a fixed order, each integrated to its end. [`control`] are
//! controllers that impose virtual constraints, for both.
mod absolute;
mod account;
mod actuation;
mod actuator;
mod beginning;
mod carried;
pub mod control;
mod csv;
mod dense;
mod driven_joint;
mod drives;
mod energy;
mod fall;
mod ground;
mod heights;
mod implicit;
mod imu;
mod instability;
mod mean_forces;
mod mechanics;
mod motors;
mod newton;
pub mod phases;
mod plant;
mod problem;
mod proximal;
mod reference;
mod resistance;
mod run;
mod scenario;
mod sensed;
mod sensing;
mod servo;
mod sharing;
mod soles;
mod stepper;
mod turned;
mod wrench;

pub use absolute::{FreeBodies, FreeLink, FreePoint, FreeStepper, Pin};
pub use account::Account;
pub use actuation::EffortSensor;
pub use actuator::Actuator;
pub use carried::{Carried, PutOn};
pub use csv::csv_line;
pub use drives::Coupled;
pub use energy::EnergyBalance;
pub use fall::{Fall, FallCause};
pub use ground::{Compliance, Ground, JointLaw};
pub use heights::{Heights, HeightsKind};
pub use imu::Imu;
pub use mechanics::{FUNCTIONS, Frame, Mechanics};
pub use motors::MotorLaw;
pub use plant::Plant;
pub use problem::{Block, Cone, Law, Problem};
pub use proximal::{Solved, Solver, Tolerance};
pub use reference::{Reference, Sine};
pub use run::{Run, Simulation, Summary};
pub use scenario::{
    Choosable, EventDriven, FootstepWalk, GaitControl, GaitValue, Initial, JointServo, Push, Scenario,
    Sensors, Shapes, Wishes, World,
};
pub use sensing::Sample;
pub use servo::DriveServo;
pub use stepper::{MotionState, Stepped, Stepper};
