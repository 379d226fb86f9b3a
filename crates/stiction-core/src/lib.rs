//! Closed-chain mechanisms with friction in their joints: kinematics, driving forces, every joint
//! reaction, and friction that grows with the reactions.
//!
//! A [`mechanism::MechanismBuilder`] makes a mechanism. [`dynamics::InverseDynamics`] carries it along a prescribed
//! motion and finds all forces, [`forward::Forward`] simulates it under given ones, and [`mobility`] says what can move
//! and what is unique. All is in SI units and radians. Signs: a reaction is what a joint's predecessor exerts on its
//! successor.
//!
//! A five-bar linkage with friction in its joints, driven at both bases:
//!
//! ```
//! use stiction_core::dynamics::{InverseDynamics, Settings};
//! use stiction_core::friction::{JointFriction, Law};
//! use stiction_core::joint::JointType::Revolute;
//! use stiction_core::kinematics::{Coordinate, Target};
//! use stiction_core::mechanism::{BodySpec, JointSpec, MechanismBuilder};
//! use stiction_core::spatial::{Pose, Vec3};
//!
//! // Bars lie along x of their frames; joints turn about z.
//! let bar = |name: &str, length| BodySpec::new(name).mass(1.0).com(Vec3::new(length / 2.0, 0.0, 0.0));
//! let at = |x| Pose::at(Vec3::new(x, 0.0, 0.0));
//! // A pin of 10 mm radius, its friction proportional to the force across it.
//! let dry = JointFriction::round(0.01, Law::coulomb_viscous(0.1, 0.0));
//! let pin = |name: &str, from: &str, to: &str| JointSpec::new(name, Revolute, from, to).friction(dry.clone());
//! let linkage = MechanismBuilder::new("five-bar")
//!     .gravity(Vec3::new(0.0, -9.81, 0.0))
//!     .body(bar("crank1", 0.2))
//!     .body(bar("crank2", 0.2))
//!     .body(bar("rod1", 0.3))
//!     .body(bar("rod2", 0.3))
//!     // Where assembly starts says on which side the elbows are.
//!     .joint(pin("base1", "ground", "crank1").actuated().start([2.0]))
//!     .joint(pin("base2", "ground", "crank2").frames(at(0.3), at(0.0)).actuated().start([1.0]))
//!     .joint(pin("elbow1", "crank1", "rod1").frames(at(0.2), at(0.0)).start([-1.2]))
//!     .joint(pin("elbow2", "crank2", "rod2").frames(at(0.2), at(0.0)).start([1.2]))
//!     .joint(pin("tip", "rod1", "rod2").frames(at(0.3), at(0.3)))
//!     .build()?;
//!
//! // Prescribed are both cranks: their angles, rates and accelerations.
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
//! // Forces are those of the position at which `solve` is called.
//! let forces = solver.solve(&[])?;
//! // Friction resists: what it adds to the efforts is what it dissipates.
//! let added = |k: usize| forces.efforts[k] - forces.efforts_frictionless[k];
//! let (given, lost) = (0.3 * added(0) - 0.2 * added(1), forces.power.dissipated);
//! assert!(lost > 0.0 && (given - lost).abs() < 1e-12 * lost);
//! // The pins at the bases turn with the cranks: friction there is coefficient times force times radius times rate.
//! let (force, _moment) = forces.reactions[0];
//! assert!((forces.interfaces[0].power - 0.1 * force.norm() * 0.01 * 0.3).abs() < 1e-15);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod dynamics;
pub mod forward;
pub mod friction;
pub mod joint;
pub mod kinematics;
pub mod linalg;
pub mod mechanism;
pub mod mobility;
pub mod parameters;
pub mod random;
pub mod scalar;
pub mod spatial;
pub mod statics;
pub mod topology;
pub mod words;
