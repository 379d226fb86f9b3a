//! Source code of [`Feedforward`] programs in other languages.
//!
//! Routines become functions of straight-line code; all languages use the same list of statements
//! (`walk`). A fixed text for each language surrounds these functions: it closes the loops,
//! iterates the friction forces, and covers the state of rest and failures.

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

/// Programming language.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Language {
    /// C99.
    C,
    /// Rust without its standard library.
    Rust,
}

/// Floating-point type of the source code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// Double precision, 64 bits.
    Double,
    /// Single precision, 32 bits.
    Float,
}

/// Functions in addition to inverse dynamics.
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
    /// Returns true if the code contains derivatives, which are requested or needed for forward
    /// dynamics.
    pub fn need_derivatives(self) -> bool {
        self.derivatives || self.accelerations
    }

    /// Returns true if the code computes the wrenches of all joints.
    fn need_wrenches(self) -> bool {
        self.reactions || self.need_derivatives()
    }
}

/// Options of the source code.
#[derive(Clone, Debug)]
pub struct SourceOptions {
    /// Name of the files and prefix of all names in the code; by default an identifier derived from the name of the
    /// model.
    pub name: String,
    /// Floating-point type.
    pub precision: Precision,
    /// True to include functions for sine and cosine in the code instead of calling the
    /// mathematical library.
    pub own_math: bool,
    /// Functions in addition to inverse dynamics.
    pub functions: Functions,
    /// Programs and files that run the C code in other environments.
    pub adapters: Adapters,
}

/// Test vector: a state of the prescribed coordinates, and the actuator forces that the general
/// solver computes there. The generated code must reproduce these forces.
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

/// File of source code: its name and its text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SourceFile {
    /// File name without a folder.
    pub name: String,
    /// Content of the file.
    pub text: String,
}

impl SourceOptions {
    /// Default options for a model with this name: double precision, functions of the mathematical
    /// library.
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
    /// Source files: code, self-test with test vectors, build files and instructions.
    ///
    /// # Errors
    /// A number of the program is too large for the precision; the options request derivatives, but
    /// the program has none, see [`Self::with_derivatives`]; or the options request accelerations,
    /// but the numbers of actuators and coordinates differ.
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

/// Statements of all routines.
struct Listings {
    position: Listing,
    forces: Listing,
    /// Routines of the poses and of the twists, or empty if they are not requested.
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

/// Number of results of a call: actuator efforts, followed by the wrenches of all joints if they
/// are needed.
fn answers(sizes: FeedforwardSizes, functions: Functions) -> usize {
    sizes.drives + if functions.need_wrenches() { 6 * sizes.joints } else { 0 }
}

/// Array items in C, with a final zero: the array is never empty, because C does not allow empty
/// arrays.
fn list_with_zero(numbers: &[usize]) -> String {
    numbers.iter().map(|number| format!("{number}, ")).collect::<String>() + "0"
}
