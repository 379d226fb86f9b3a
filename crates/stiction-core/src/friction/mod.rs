//! Friction in joints that grows with the joint's own reaction.
//!
//! A friction is a *load map* (which of the joint's reaction components press the surfaces
//! together, [`NormalLoadMap`]) times a *law* (what coefficient at what speed, what viscous part,
//! [`Law`]), acting at a sliding contact ([`JointFriction`]) of known place and radius.

mod bristles;
mod interface;
mod law;
mod normal_load;
mod thread;

pub use bristles::Bristles;
pub use interface::JointFriction;
pub(crate) use law::Resistance;
pub use law::{Curve, Exponent, Law};
pub use normal_load::{Combine, NormalLoadMap, Supports};
pub(crate) use thread::OwnFriction;

// Used by the project's other crates; no part of the stable interface.
#[doc(hidden)]
pub use interface::{InterfaceShape, interfaces_of};
#[doc(hidden)]
pub use normal_load::Load;
#[doc(hidden)]
pub use thread::Thread;
