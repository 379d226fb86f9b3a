//! Load-dependent joint friction.
//!
//! Friction at an interface is described by a *normal load map* ([`NormalLoadMap`]: components of
//! the joint's reaction that contribute to the normal load) and a *law* ([`Law`]: friction
//! coefficient as a function of speed, and a viscous part). [`JointFriction`] combines both for one
//! interface of a joint, with the radius of the surface.

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

// Used by other crates of the project; not part of the stable interface.
#[doc(hidden)]
pub use interface::{InterfaceShape, interfaces_of};
#[doc(hidden)]
pub use normal_load::Load;
#[doc(hidden)]
pub use thread::Thread;
