//! Inverse dynamics: efforts, joint reactions, friction and power for a given motion.
//!
//! Sign convention: the reaction of a joint is the complete wrench that the predecessor exerts on
//! the successor. The reaction includes constraint, actuator and friction forces.

mod balance;
mod branches;
mod checks;
mod continuation;
mod contributions;
mod control;
mod coupling;
mod data;
mod dense_fallback;
mod error;
mod forces;
mod interfaces;
mod inverse;
mod load_history;
mod load_sensitivity;
mod model;
mod plan;
mod power;
mod program;
mod responses;
mod rest;
mod rotor;
mod settings;
mod solver;
mod spring;
mod structure;

pub use crate::statics::{AppliedLoad, LoadAxes};
pub use control::Status;
pub use data::Data;
pub use error::InverseError;
pub(crate) use error::NO_PART;
pub use forces::{Bounds, Forces, InterfaceForce};
pub use model::Model;
pub use power::Power;
pub use rest::{Breakaway, Holding, Rest, Verdict};
pub use settings::{FrictionMode, Settings};
pub use solver::InverseDynamics;
pub(crate) use spring::{SpringFault, spring_powers, spring_wrenches};

// Used by other crates of the project; not part of the stable interface.
#[doc(hidden)]
pub use branches::FrictionMargin;
#[doc(hidden)]
pub use contributions::{Contributions, Response, Sharing};
#[doc(hidden)]
pub use interfaces::InterfaceState;
#[doc(hidden)]
pub use inverse::Inverse;
#[doc(hidden)]
pub use load_sensitivity::{LoadChanges, LoadSensitivity};
#[doc(hidden)]
pub use program::{force_results, motion_results};
#[doc(hidden)]
pub use rotor::RotorMotion;
#[doc(hidden)]
pub use solver::Mirror;
#[doc(hidden)]
pub use spring::SpringForce;
#[doc(hidden)]
pub use structure::Weighting;
