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
pub use interface::{InterfaceShape, JointFriction, interfaces_of};
pub use law::{Curve, Exponent, Law, Resistance};
pub use normal_load::{Combine, Load, NormalLoadMap, Supports};
pub use thread::{OwnFriction, Thread};
