//! Friction in joints that grows with the joint's own reaction.
//!
//! A friction is a *load map* (which of the joint's reaction components press the surfaces
//! together, [`LoadMap`]) times a *law* (what coefficient, what viscous part, [`Law`]), acting at a
//! sliding contact ([`Contact`]) of known place and radius.

mod contact;
mod law;
mod load;

pub use contact::{Contact, ContactShape, contacts_of};
pub use law::{Law, Resistance};
pub use load::{Load, LoadMap};
