//! Reads model files: converts text to a mechanism with motions and loads, or reports diagnostics.
//!
//! A model is a TOML file that contains a mechanism, its named motions and its named loads. [`read`] converts it to a
//! [`ModelFile`], or returns [`Diagnostics`]: all errors at once, each with its place, what was expected, and a
//! remedy.
//!
//! ```
//! use stiction_format::{Source, read};
//!
//! let text = r#"
//! title = "A pendulum with a dry pivot"
//! gravity = [0, "-9.81 m/s^2", 0]
//!
//! [parameters]
//! length = "400 mm"
//!
//! [bodies.bob]
//! mass = "2 kg"
//! com = [0, "-length", 0]
//! inertia = ["1e-3 kg m^2", "1e-3 kg m^2", "1e-3 kg m^2"]
//!
//! [joints.pivot]
//! type = "R"
//! from = "ground"
//! to = "bob"
//! axis = "z"
//! actuated = true
//! friction = { mu = 0.1, radius = "8 mm" }
//!
//! [motions.swing]
//! duration = "2 s"
//! pivot = "30 deg*sin(2*pi*t)"
//!
//! [loads.wind]
//! bob = { force = ["3 N", 0, 0], at = [0, "-length", 0] }
//! "#;
//!
//! let model = read(&Source::new("pendulum.toml", text), &|_| Err("no files".into()))?;
//! assert_eq!(model.name, "pendulum");
//! assert_eq!(model.mechanism.joints()[0].friction.len(), 1);
//!
//! // Prescribed coordinates, with exact derivatives.
//! let swing = model.motion("swing").unwrap();
//! let target = swing.at(0.0).next().unwrap();
//! assert_eq!(target.value, 0.0);
//! assert!((target.rate - 30f64.to_radians() * std::f64::consts::TAU).abs() < 1e-15);
//!
//! // A spelling mistake.
//! let wrong = text.replace("mass =", "masss =");
//! let diagnostics = read(&Source::new("pendulum.toml", wrong), &|_| Err("no files".into()))
//!     .unwrap_err();
//! assert_eq!(diagnostics.to_string(), r#"error[unknown-key]: body `bob` has no key `masss`
//!  --> pendulum.toml:9:1
//!   |
//! 9 | masss = "2 kg"
//!   | ^^^^^ unknown key
//!   |
//!   = help: did you mean `mass`?
//! "#);
//! # Ok::<(), stiction_format::Diagnostics>(())
//! ```
//!
//! # Quantities
//!
//! A TOML number is in SI units. A string is an expression with units: `"128.48 mm"`,
//! `"2*l1 + 5 mm"`, `"l1*cos(30 deg)"`. Units directly after a number bind tighter than any operator,
//! so `5 mm / 2 s` is (5 mm)/(2 s), and `0.02 N s/m` is one unit. Dimensions are checked; angles are
//! plain numbers, but `30 deg` is not accepted as a length. A dimensionless result is taken in SI units. Expressions
//! can contain `+ - * / ^ ( )`, the functions `sin cos tan asin acos atan atan2 sinh cosh tanh exp log sqrt abs min
//! max smooth`, the constants `pi` and `e`, and the names of `[parameters]`.
//! `smooth(t, t0, t1)` goes from 0 at `t0` to 1 at `t1` with vanishing first and second derivatives at
//! both ends, and is constant outside.
//!
//! In motions and loads `t` is the time in seconds. It can be used as a plain number
//! (`sin(2*pi*t)`) or as a time (`10 mm/s*t`). Expressions are differentiated exactly.
//!
//! # Mechanism
//!
//! | table | contents |
//! | --- | --- |
//! | top level | `gravity` (world axes, required), `name`, `title`, `source`, `characteristic_length` |
//! | `[base]` | `position` and `rotation` of the ground's frame in the world |
//! | `[parameters]` | named quantities, which can refer to each other |
//! | `[bodies.NAME]` | `mass`, `com`, `inertia` about `com`, `home` (initial guess of the pose) |
//! | `[joints.NAME]` | `type`, `from`, `to`, position (`at`, `to_at`, `axis`, …), `actuated`, `start`, `friction` |
//! | `[legs]` or `[[legs]]` | equal legs around an axis, written as one chain |
//! | `[default]` | `motion`, `load`, `friction` (`"on"`, `"off"`, `"one-pass"`) |
//!
//! The frame J of a joint has z along `axis`, and x along `x_axis` (for a U joint: `second_axis`). By default, x is
//! rotated by the smallest rotation that takes z to the axis; for the axis -z this is the half turn about y. At zero
//! coordinates the frame of `to` is parallel to that of `from`, rotated by `turn`. Rotations are given as
//! `{ axis = "z", angle = "30 deg" }`, or as three intrinsic angles under the name of their order:
//! `{ xyz = [0, "30 deg", 0] }`.
//!
//! A chain lists joints and bodies alternately: `chain = "R cylinder P* rod S"`, where `*`
//! means actuated; or only the joints, `chain = "R P* S"`, with `between = ["cylinder", "rod"]` or with
//! bodies named `link1`, `link2`. There is a leg for each of `angles`, or for each entry of `place`,
//! which can also override any value of the leg. Leg 1 consists of the bodies `leg1.cylinder`, `leg1.rod` and the joints
//! `leg1.R`, `leg1.P`, `leg1.S`; joints of the same letter get numbers (`leg1.U1`, `leg1.U2`). Their tables are
//! `[legs.bodies.cylinder]`, `[legs.joints.R]` and so on. The first joint is at `foot` in the frame of
//! `from`, the last at `tip` in the frame of `to`, both rotated by the leg's angle about the
//! axis `about`; all other values refer to a leg at angle 0.
//!
//! # Motions and loads
//!
//! A motion prescribes coordinates by the name of a body or joint: `platform.x`, `y`, `z` (its origin in
//! the ground's frame), `rx`, `ry`, `rz` (intrinsic angles in the order `order`, by default `xyz`;
//! `r1`, `r2`, `r3` name them by number), `rvx`, `rvy`, `rvz` (rotation vector); a joint by its name
//! (`leg1.P`), or with its degree of freedom if it has several (`leg1.U1.first`). With `file = "motion.csv"` it
//! is interpolated from samples: columns like `time [s]`, `platform.x [mm]`, and optionally the derivatives
//! `d(platform.x) [mm/s]` and `dd(platform.x) [mm/s^2]`. See [`Motion::interpolation`].
//!
//! Actuator efforts are keyed by actuator: `leg1.P = 50 N`; a file of efforts has columns like
//! `leg1.P [N]` or, as in results, `leg1.P.drive [N]`. Efforts can depend on measured coordinates and rates:
//! `leg1.P = -2 kN/m*leg1.P - 80 N s/m*d(leg1.P)`; there, `sign` may be used as well. See [`ModelFile::parse_drives`], [`ModelFile::parse_control`].
//!
//! A load is keyed by body: `platform = { force = [...], moment = [...], at = [...], axes = "world" }`.
//!
//! [`json_schema`] describes all keys for editors; the models of the [`gallery`] are examples.

mod contents;
mod diagnostic;
mod document;
mod expression;
mod fields;
pub mod gallery;
mod import;
mod law;
#[cfg(feature = "mcap")]
mod mcap;
mod model_file;
// Browsers have no files, and unpacking archives would require functions of the web page.
#[cfg(not(target_arch = "wasm32"))]
mod npz;
mod parameters;
mod pattern;
mod quantity;
mod read;
mod separated;
mod signal;
mod source;
mod triangles;
mod variation;
mod visual;

pub use contents::{Contents, Store, not_text};
pub use diagnostic::{Diagnostic, Diagnostics, Severity, did_you_mean};
pub use fields::json_schema;
pub use import::{FileLoader, ImportOptions, Imported, NAMESPACE, Note, import, is_robot_file};
pub use law::{Condition, Law};
#[cfg(feature = "mcap")]
pub use mcap::csv_of_mcap;
pub use model_file::{
    AppliedWrench, Channel, Control, ControlType, Drives, FrictionFeed, Leg, LoadCase, LoadLaw,
    ModelFile, Motion, Payload, PayloadChange, Side,
};
#[cfg(not(target_arch = "wasm32"))]
pub use npz::csv_of_npz;
pub use pattern::fits;
pub use quantity::{Amount, hertz, length_or_angle, seconds, speed};
pub use read::{Draft, Log, LogColumn, LogFormat, LogRole, Renamed, Rows, read};
pub use signal::Signal;
pub use signal::filter::{LowPass, Smooth};
pub use signal::samples::SampleTimes;
pub use source::{Place, Source};
pub use variation::{Key, Setting, Values, Variation};
pub use visual::{Mesh, MeshFormat, Visual};
