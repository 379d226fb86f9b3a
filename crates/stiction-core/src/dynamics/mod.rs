//! Forces: the balance of every body, driving forces, joint reactions, friction, power.
//!
//! Signs: a joint's reaction is the complete wrench that its predecessor exerts on its successor,
//! constraint, drive and friction together.

mod balance;
mod branches;
mod careful;
mod contacts;
mod coupling;
mod error;
mod forces;
mod inverse;
mod kernel;
mod plan;
mod power;
mod reduced;
mod rest;
mod settings;
mod setup;
mod shares;
mod solver;
mod spring;
mod structure;
mod wedge;

pub use crate::statics::{AppliedLoad, LoadAxes};
pub use branches::FrictionMargin;
pub use contacts::ContactState;
pub(crate) use contacts::{load_by, most_change_of_load};
pub(crate) use coupling::radius_bound;
pub use error::InverseError;
pub(crate) use error::NO_PART;
pub use forces::{Bounds, ContactForce, Forces};
pub use inverse::Inverse;
pub use kernel::{Kernel, Workspace};
pub use plan::{BalancePlan, NotPlanned};
pub use power::Power;
pub use rest::{Breakaway, Holding, Rest, Verdict};
pub use settings::{FrictionMode, Settings};
pub use setup::Setup;
pub use shares::{Response, Shares, Sharing};
pub use solver::{InverseDynamics, Mirror};
pub use spring::Pull;
pub use structure::{BalanceStructure, Weighting};
