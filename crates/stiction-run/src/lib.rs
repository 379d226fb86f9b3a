//! Runs of a mechanism: inverse dynamics along a motion, simulations, and sweeps over many designs.
//! Each run returns results sample by sample, from which this crate creates tables, summaries and
//! plots.
//!
//! The crate opens no files and prints nothing; it passes all results to functions or objects that
//! the caller provides.
//!
//! ```
//! use stiction_format::{LoadCase, Source, read};
//! use stiction_run::Job;
//!
//! let text = r#"
//! gravity = [0, "-9.81 m/s^2", 0]
//!
//! [bodies.bob]
//! mass = "2 kg"
//! com = ["500 mm", 0, 0]
//! inertia = [0, "0.04 kg m^2", "0.04 kg m^2"]
//!
//! [joints.pivot]
//! type = "R"
//! from = "ground"
//! to = "bob"
//! axis = "z"
//! actuated = true
//!
//! [motions.lift]
//! duration = "1 s"
//! pivot = "60 deg/s*t"
//! "#;
//! let model = read(&Source::new("pendulum.toml", text), &|_| Err("no files".into()))?;
//! let (motion, load) = (model.motion("lift").ok_or("no such motion")?, LoadCase::default());
//! let job = Job { step: Some(0.5), ..Job::new(&model, ("lift", motion), ("none", &load)) };
//! let mut drives = Vec::new();
//! let receive = |sample: &stiction_run::inverse::Sample| {
//!     drives.push(sample.forces.efforts[0]);
//!     Ok(())
//! };
//! let verdict = job.run(receive, |_phase, _done, _of| true)?;
//! assert_eq!(verdict.samples, 3);
//! // 2 kg * 9.81 m/s^2 at half a metre, level and lifted by 60 degrees.
//! assert!((drives[0] - 9.81).abs() < 1e-12 && (drives[2] - 4.905).abs() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod bodies;
pub mod breakaway;
mod by_leg;
pub mod check;
pub mod comparison;
pub mod compensation;
mod dofs;
mod error;
pub mod exchange;
pub mod excite;
mod follower;
pub mod forward;
mod gearing_load;
pub mod identify;
mod in_space;
mod instants;
pub mod inverse;
mod job;
mod motor_load;
mod names;
mod ordered;
mod portrait;
mod power_off;
mod ranges;
mod report;
mod sink;
mod statistics;
pub mod sweep;
mod table;
mod undetermined;
mod view;

pub use error::{Error, Missing, SinkError};
pub use follower::Follower;
pub use in_space::{SpaceError, SpacePoint, Tracked, tracked};
pub use instants::{Instants, InstantsError};
pub use job::{Indices, Job};
pub use names::heading;
pub use portrait::Portrait;
pub use sink::Sink;
pub use stiction_draw::figure::Figure;
pub use stiction_draw::numbers::number;
pub use table::Table;
pub use view::{View, draw_view};
