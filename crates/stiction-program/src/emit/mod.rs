//! Generation of source code in C and Rust from [`Feedforward`] programs.
//!
//! Each routine of the program becomes a function of straight-line code, whose statements (`walk`)
//! are the same in all languages. A fixed template for each language surrounds these functions: it
//! closes the loops, iterates the friction forces, and contains the rules for rest and for
//! failures.

mod adapters;
mod c;
pub mod fmu;
mod index;
mod literal;
mod names;
mod own_math;
mod rust;
mod tables;
mod vectors;
mod walk;

pub use adapters::Adapters;
pub use names::Labels;

use crate::error::RecordError;
use crate::feedforward::{Derivatives, Feedforward, FeedforwardSizes, Routine};
use names::identifier;
use walk::Listing;

/// Programming language of the generated source code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Language {
    /// C99.
    C,
    /// Rust without its standard library.
    Rust,
}

/// Floating-point type of the generated source code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// Double precision, 64 bits.
    Double,
    /// Single precision, 32 bits.
    Float,
}

/// Functions that the generated source code contains in addition to inverse dynamics.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Functions {
    /// Poses and twists of all bodies, and their Jacobians.
    pub kinematics: bool,
    /// Wrenches of all joints.
    pub reactions: bool,
    /// Derivatives of the actuator forces with respect to positions, rates and accelerations.
    pub derivatives: bool,
    /// Forward dynamics: accelerations from actuator forces.
    pub accelerations: bool,
}

impl Functions {
    /// Returns true if the code contains derivatives, because they are requested or because forward
    /// dynamics needs them.
    pub fn need_derivatives(self) -> bool {
        self.derivatives || self.accelerations
    }

    /// Returns true if the code computes the wrenches of all joints.
    fn need_wrenches(self) -> bool {
        self.reactions || self.need_derivatives()
    }
}

/// Options of the generated source code.
#[derive(Clone, Debug)]
pub struct SourceOptions {
    /// Name of the files and prefix of all names in the code; by default an identifier derived from
    /// the name of the model.
    pub name: String,
    /// Floating-point type of all numbers in the generated code.
    pub precision: Precision,
    /// True to include functions for sine and cosine in the code instead of calling the
    /// mathematical library.
    pub own_math: bool,
    /// Functions that the generated source code contains in addition to inverse dynamics.
    pub functions: Functions,
    /// Programs and files that run the C code in other environments.
    pub adapters: Adapters,
}

/// Test vector: a state of the prescribed coordinates, and the actuator forces that the general
/// solver computes at this state. The generated code must reproduce these forces.
#[derive(Clone, Debug, PartialEq)]
pub struct TestVector {
    /// Positions of the prescribed coordinates, m or rad.
    pub positions: Vec<f64>,
    /// Rates of the prescribed coordinates, m/s or rad/s.
    pub rates: Vec<f64>,
    /// Accelerations of the prescribed coordinates, m/s^2 or rad/s^2.
    pub accelerations: Vec<f64>,
    /// Actuator forces with friction, N or N m.
    pub efforts: Vec<f64>,
}

/// Generated file: name and text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SourceFile {
    /// File name without a folder. For files of an FMU, path inside the FMU.
    pub name: String,
    /// Content of the file.
    pub text: String,
}

impl SourceOptions {
    /// Creates the default options for a model with the name `name`: double precision, sine and
    /// cosine of the mathematical library, no additional functions or adapters.
    pub fn new(name: &str) -> Self {
        Self {
            name: identifier(name),
            precision: Precision::Double,
            own_math: false,
            functions: Functions::default(),
            adapters: Adapters::default(),
        }
    }
}

impl Feedforward {
    /// Generates the source files: code, self-test with test vectors, build files and instructions.
    ///
    /// # Errors
    /// A number of the program is too large for the precision; the options request derivatives, but
    /// the program has none, see [`Self::with_derivatives`]; or the options request accelerations,
    /// but the number of actuators differs from that of the prescribed coordinates.
    pub fn files(
        &self,
        language: Language,
        labels: &Labels,
        options: &SourceOptions,
        vectors: &[TestVector],
    ) -> Result<Vec<SourceFile>, RecordError> {
        let fits = |number: f64| match options.precision {
            Precision::Double => number.is_finite(),
            Precision::Float => (number as f32).is_finite(),
        };
        let functions = options.functions;
        if functions.need_derivatives() && !self.has_derivatives() {
            return Err(RecordError::NoDerivatives);
        }
        let FeedforwardSizes { prescribed: coordinates, drives: actuators, .. } = self.sizes();
        if functions.accelerations && actuators != coordinates {
            return Err(RecordError::ActuatorCount { actuators, coordinates });
        }
        let listings = Listings::new(self, functions);
        let mut numbers = listings.all().flat_map(|listing| listing.clone().numbers());
        if let Some(number) = numbers.find(|number| !fits(*number)) {
            return Err(RecordError::TooLarge(number));
        }
        Ok(match language {
            Language::C => c::files(self, labels, options, vectors),
            Language::Rust => rust::files(self, labels, options, vectors),
        })
    }
}

/// Statements of all routines that the generated source code contains.
struct Listings {
    position: Listing,
    forces: Listing,
    /// Statements that compute the poses, and statements that compute the twists; empty if
    /// kinematics is not requested.
    kinematics: Vec<Listing>,
    derivatives: Option<Listing>,
}

impl Listings {
    fn new(program: &Feedforward, functions: Functions) -> Self {
        let sizes = program.sizes();
        let inputs = |count: usize| (0..count as u32).collect::<Vec<_>>();
        let first = inputs(sizes.coordinates + sizes.prescribed);
        let mut second = inputs(sizes.coordinates + sizes.tunables + 3 * sizes.prescribed);
        second.extend(&program.unknown_slots);
        let third = inputs(sizes.coordinates + 2 * sizes.prescribed);
        let forces =
            if functions.need_wrenches() { &program.wrenches } else { &program.source.forces };
        let kinematics: &[Routine] = if functions.kinematics { &program.kinematics } else { &[] };
        let each = kinematics.iter().map(|one| Listing::new(std::slice::from_ref(one), &third));
        let derivatives = program.derivatives.as_ref().filter(|_| functions.need_derivatives());
        Self {
            position: Listing::new(&program.source.position, &first),
            forces: Listing::new(forces, &second),
            kinematics: each.collect(),
            derivatives: derivatives
                .map(|Derivatives { routines, inputs, .. }| Listing::new(routines, inputs)),
        }
    }

    fn all(&self) -> impl Iterator<Item = &Listing> {
        [&self.position, &self.forces].into_iter().chain(&self.kinematics).chain(&self.derivatives)
    }
}

/// Number of results of one call of the generated inverse dynamics: actuator efforts, followed by
/// the wrenches of all joints if they are needed.
fn answers(sizes: FeedforwardSizes, functions: Functions) -> usize {
    sizes.drives + if functions.need_wrenches() { 6 * sizes.joints } else { 0 }
}

/// Formats the items of an array, with an additional zero at the end. The array is therefore never
/// empty, which C would not allow.
fn list_with_zero(numbers: &[usize]) -> String {
    numbers.iter().map(|number| format!("{number}, ")).collect::<String>() + "0"
}
