//! Forces: the balance of every body, driving forces, joint reactions, friction, power.
//!
//! Signs: a joint's reaction is the complete wrench that its predecessor exerts on its successor,
//! constraint, drive and friction together.

mod balance;
mod branches;
mod checks;
mod continuation;
mod contributions;
mod control;
mod coupling;
mod data;
mod dense_coupling;
mod dense_fallback;
mod error;
mod forces;
mod interfaces;
mod inverse;
mod model;
mod plan;
mod power;
mod rest;
mod settings;
mod solver;
mod spring;
mod structure;

pub use crate::statics::{AppliedLoad, LoadAxes};
pub use branches::FrictionMargin;
pub use contributions::{Response, Shares, Sharing};
pub use control::Status;
pub(crate) use coupling::radius_bound;
pub use data::Data;
pub use error::InverseError;
pub(crate) use error::NO_PART;
pub use forces::{Bounds, Forces, InterfaceForce};
pub use interfaces::InterfaceState;
pub(crate) use interfaces::{load_by, most_change_of_load};
pub use inverse::Inverse;
pub use model::Model;
pub use plan::{BalancePlan, NotPlanned};
pub use power::Power;
pub use rest::{Breakaway, Holding, Rest, Verdict};
pub use settings::{FrictionMode, Settings};
pub use solver::{InverseDynamics, Mirror};
pub use spring::SpringForce;
pub use structure::{BalanceStructure, Weighting};
