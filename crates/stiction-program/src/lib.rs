//! Straight-line programs that compute the dynamics of one mechanism, recorded from generic
//! kernels.
//!
//! The kernels of `stiction-core` are generic over the scalar type, and never branch on values.
//! Evaluated with a scalar type that records operations (`recorded`), they produce an expression
//! graph (`graph`). Value numbering at random states finds equal nodes and merges them
//! (`value_numbering`): terms that vanish for this mechanism disappear, and common subexpressions
//! are computed once. The merged graph is compiled (`code`, `allocate`, `encode`) to machine code
//! for the widest registers of the processor (`machine`), or interpreted where machine code is
//! impossible.
//!
//! ```
//! use stiction_core::dynamics::{InverseDynamics, Settings};
//! use stiction_core::joint::JointType;
//! use stiction_core::kinematics::{Coordinate, Target};
//! use stiction_core::mechanism::{BodySpec, JointId, JointSpec, MechanismBuilder};
//! use stiction_core::spatial::Vec3;
//! use stiction_program::InverseProgram;
//!
//! let pendulum = MechanismBuilder::new("pendulum")
//!     .gravity(Vec3::new(0.0, -9.81, 0.0))
//!     .body(BodySpec::new("bob").mass(2.0).com(Vec3::new(0.5, 0.0, 0.0)))
//!     .joint(JointSpec::new("pivot", JointType::Revolute, "ground", "bob").actuated())
//!     .build()?;
//! let angle = Coordinate::Joint { joint: JointId(0), dof: 0 };
//! let at = |value| vec![Target { value, rate: 0.0, acceleration: 0.0 }];
//! let solver = InverseDynamics::new(pendulum, &[], &[angle], &at(0.0), Settings::default())?;
//! // Positions within the intended range of motion.
//! let signal: Vec<_> = (0..10).map(|k| at(0.1 * f64::from(k))).collect();
//! let program = InverseProgram::record(&solver, &signal, &[])?;
//!
//! let mut memory = program.memory(1);
//! program.set(&mut memory, 0, solver.state(), &signal[0], &[]);
//! let mut holds = [false];
//! program.run_frictionless(&mut memory, &mut holds);
//! assert!(holds[0] && (program.ideal_drive(&memory, 0, 0) - 9.81).abs() < 1e-14);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod aligned;
mod allocate;
mod batch;
mod certificate;
mod code;
mod compiled;
mod convergence;
mod derivative_stages;
mod derivatives;
pub mod emit;
mod encode;
mod error;
mod feedforward;
mod forward;
mod forward_kernel;
mod forward_stages;
mod graph;
mod inverse;
mod inverse_stages;
mod kernels;
mod loaded;
mod loads;
mod locality;
mod machine;
mod memory;
mod motions;
mod program_inputs;
mod quantity;
mod recorded;
mod recording;
mod run;
mod sampled_values;
mod samples;
mod schedule;
mod slopes;
mod small_lu;
mod stages;
mod tree;
mod tunable;
mod value_numbering;
mod wrench;

pub use batch::{ForcesAt, StateError, StateErrorCause};
pub use derivatives::{DerivativeMemory, DerivativeProgram};
pub use error::RecordError;
pub use feedforward::{Feedforward, FeedforwardMemory, FeedforwardSizes, Outcome, Shortfall};
pub use forward::ForwardProgram;
pub use inverse::InverseProgram;
pub use kernels::RecordedKernels;
pub use memory::Memory;
pub use program_inputs::{BodyMotion, StateOfMotion};
pub use quantity::Quantity;
pub use tunable::Tunable;
