//! Friction in joints that grows with the joint's own reaction.
//!
//! A friction is a *load map* (which of the joint's reaction components press the surfaces
//! together, [`LoadMap`]) times a *law* (what coefficient at what speed, what viscous part,
//! [`Law`]), acting at a sliding contact ([`Contact`]) of known place and radius.

mod bristles;
mod contact;
mod law;
mod load;
mod thread;

pub use bristles::Bristles;
pub use contact::{Contact, ContactShape, contacts_of};
pub use law::{Curve, Exponent, Law, Resistance};
pub use load::{Combine, Load, LoadMap, Supports};
pub use thread::{OwnFriction, Thread};
