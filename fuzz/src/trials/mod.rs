//! What must hold of any input, as functions that panic where it does not.
//!
//! The fuzz targets call them, and so does the test `findings` of `stiction-cli`, with every input that once
//! did harm. They take text and nothing else, so that a finding is a small file that can be read.

pub mod checkpoint;
pub mod finite;
pub mod runs;
pub mod texts;

/// What must hold of a text.
pub type Trial = fn(&str);

/// All of them by the name of the target.
pub const TRIALS: [(&str, Trial); 8] = [
    ("model", texts::model),
    ("unit", texts::unit),
    ("expression", texts::expression),
    ("recording", texts::recording),
    ("options", texts::options),
    ("drives", texts::drives),
    ("checkpoint", checkpoint::checkpoint),
    ("mechanism", runs::mechanism),
];
