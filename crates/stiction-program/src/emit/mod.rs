//! Source code of [`Feedforward`] programs in other languages.
//!
//! Routines become functions of straight-line code, written from one list of statements (`walk`).
//! A fixed text for each language around them closes the loops, couples the friction and decides
//! about rest and failures.

mod c;
pub mod fmu;
mod literal;
mod names;
mod own_math;
mod rust;
mod tables;
mod vectors;
mod walk;

pub use names::Labels;

use crate::error::RecordError;
use crate::feedforward::Feedforward;
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
    /// 64 bits.
    Double,
    /// 32 bits.
    Float,
}

/// Options of the source code.
#[derive(Clone, Debug)]
pub struct SourceOptions {
    /// Name of the files and beginning of all names in the code; made of the name of the model if
    /// it is no identifier.
    pub name: String,
    /// Floating-point type.
    pub precision: Precision,
    /// Sine and cosine by functions of their own instead of those of the mathematical library.
    pub own_math: bool,
}

/// Test vector: an independent state with the actuator forces that the code must reproduce.
#[derive(Clone, Debug, PartialEq)]
pub struct TestVector {
    /// Positions of the prescribed coordinates.
    pub positions: Vec<f64>,
    /// Their rates.
    pub rates: Vec<f64>,
    /// Their accelerations.
    pub accelerations: Vec<f64>,
    /// Actuator forces with friction.
    pub efforts: Vec<f64>,
}

/// File of source code: its name and its text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SourceFile {
    /// Name, without a folder.
    pub name: String,
    /// Text.
    pub text: String,
}

impl SourceOptions {
    /// Options for a model of this name: double precision, functions of the library.
    pub fn new(name: &str) -> Self {
        Self { name: identifier(name), precision: Precision::Double, own_math: false }
    }
}

impl Feedforward {
    /// Source files: code, self-test with test vectors, build files and a page of instructions.
    ///
    /// # Errors
    /// A number of the program is too large for the precision.
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
        let mut numbers = self.listings().into_iter().flat_map(|listing| listing.numbers());
        if let Some(number) = numbers.find(|number| !fits(*number)) {
            return Err(RecordError::TooLarge(number));
        }
        Ok(match language {
            Language::C => c::files(self, labels, options, vectors),
            Language::Rust => rust::files(self, labels, options, vectors),
        })
    }

    /// Statements of the position routines, and of the force routines.
    fn listings(&self) -> [Listing; 2] {
        let sizes = self.sizes();
        let first = (0..(sizes.coordinates + sizes.prescribed) as u32).collect::<Vec<_>>();
        let mut second: Vec<u32> =
            (0..(sizes.coordinates + sizes.tunables + 3 * sizes.prescribed) as u32).collect();
        second.extend(&self.unknown_slots);
        [Listing::new(&self.source.position, &first), Listing::new(&self.source.forces, &second)]
    }
}
