//! Mechanics of closed-chain mechanisms with load-dependent joint friction: kinematics, inverse and
//! forward dynamics, joint reactions, mobility and singularities. The crate performs no I/O, reads
//! no clock and starts no threads.
//!
//! A [`MechanismBuilder`] builds a [`Mechanism`]. [`InverseDynamics`] moves the mechanism along
//! prescribed coordinates and computes efforts (actuator forces and torques), reactions and
//! friction; its [`Model`] is compiled for control loops and for other scalar types. [`Forward`]
//! simulates the mechanism under given efforts. [`Mobility`] and
//! [`SingularityDistances`](statics::SingularityDistances) determine the possible motions and the
//! distance of a configuration from singularities. Quantities are in SI units and radians. A
//! reaction is the wrench that a joint's predecessor exerts on its successor.
//!
//! This example computes the inverse dynamics of a five-bar linkage with friction in its joints and
//! actuators at both bases:
//!
//! ```
//! use stiction_core::{
//!     BodySpec, Coordinate, InverseDynamics, JointFriction, JointSpec, JointType, Law, MechanismBuilder, Pose,
//!     Settings, Target, Vec3,
//! };
//!
//! // Bars extend along x of their frames; joints rotate about z.
//! let bar = |name: &str, length| BodySpec::new(name).mass(1.0).com(Vec3::new(length / 2.0, 0.0, 0.0));
//! let at = |x| Pose::at(Vec3::new(x, 0.0, 0.0));
//! // A pin of 10 mm radius with Coulomb friction, proportional to the radial force.
//! let dry = JointFriction::round(0.01, Law::coulomb_viscous(0.1, 0.0));
//! let pin = |name: &str, from: &str, to: &str| JointSpec::new(name, JointType::Revolute, from, to).friction(dry.clone());
//! let linkage = MechanismBuilder::new("five-bar")
//!     .gravity(Vec3::new(0.0, -9.81, 0.0))
//!     .body(bar("crank1", 0.2))
//!     .body(bar("crank2", 0.2))
//!     .body(bar("rod1", 0.3))
//!     .body(bar("rod2", 0.3))
//!     // The start angles choose the assembly mode.
//!     .joint(pin("base1", "ground", "crank1").actuated().start([2.0]))
//!     .joint(pin("base2", "ground", "crank2").frames(at(0.3), at(0.0)).actuated().start([1.0]))
//!     .joint(pin("elbow1", "crank1", "rod1").frames(at(0.2), at(0.0)).start([-1.2]))
//!     .joint(pin("elbow2", "crank2", "rod2").frames(at(0.2), at(0.0)).start([1.2]))
//!     .joint(pin("tip", "rod1", "rod2").frames(at(0.3), at(0.3)))
//!     .build()?;
//!
//! // The motion prescribes both cranks: angles, rates and accelerations.
//! let coordinates: Vec<_> =
//!     linkage.actuators().map(|(joint, dof)| Coordinate::Joint { joint, dof }).collect();
//! let motion = |t: f64, targets: &mut [Target<f64>]| {
//!     targets[0] = Target { value: 2.0 + 0.3 * t, rate: 0.3, acceleration: 0.0 };
//!     targets[1] = Target { value: 1.0 - 0.2 * t, rate: -0.2, acceleration: 0.0 };
//! };
//! let mut first = [Target { value: 0.0, rate: 0.0, acceleration: 0.0 }; 2];
//! motion(0.0, &mut first);
//! let mut solver = InverseDynamics::new(linkage, &[], &coordinates, &first, Settings::default())?;
//! solver.follow(0.0, 0.5, motion)?;
//!
//! let forces = solver.solve(&[])?;
//! // The power that friction adds to the actuators equals the power that it dissipates.
//! let added = |k: usize| forces.efforts[k] - forces.efforts_frictionless[k];
//! let (given, lost) = (0.3 * added(0) - 0.2 * added(1), forces.power.dissipated);
//! assert!(lost > 0.0 && (given - lost).abs() < 1e-12 * lost);
//! // Power of the first pin: coefficient times force times radius times rate.
//! let (force, _moment) = forces.reactions[0];
//! assert!((forces.interfaces[0].power - 0.1 * force.norm() * 0.01 * 0.3).abs() < 1e-15);
//!
//! // In a control loop, nothing is allocated. The solution starts from the previous configuration,
//! // and a failure is reported as a status with the reason.
//! let model = solver.model()?;
//! let mut data = model.data(solver.state(), Settings::default());
//! let status = model.inverse_dynamics(&mut data, &[2.15, 0.9], &[0.3, -0.2], &[0.0; 2], &[]);
//! assert!(status.is_converged());
//! assert!((data.efforts()[0] - solver.forces().efforts[0]).abs() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#[doc(hidden)]
pub mod disjoint_sets;
pub mod dynamics;
pub mod forward;
pub mod friction;
mod friction_problem;
pub mod joint;
pub mod kinematics;
#[doc(hidden)]
pub mod linalg;
pub mod mechanism;
pub mod mobility;
pub mod parameters;
#[doc(hidden)]
pub mod random;
pub mod scalar;
pub mod spatial;
pub mod statics;
#[doc(hidden)]
pub mod topology;
#[doc(hidden)]
pub mod words;

pub use dynamics::{Data, Forces, FrictionMode, InverseDynamics, Model, Settings, Status};
pub use forward::{Forward, Simulation};
pub use friction::{JointFriction, Law};
pub use joint::JointType;
pub use kinematics::{Coordinate, State, Target};
pub use mechanism::{BodySpec, JointSpec, Mechanism, MechanismBuilder};
pub use mobility::Mobility;
pub use parameters::Parameters;
pub use scalar::Scalar;
pub use spatial::{Mat3, Pose, Vec3};
pub use statics::AppliedLoad;
