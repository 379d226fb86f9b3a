//! Properties that hold for any input, as functions that panic if one is violated.
//!
//! The fuzz targets call these functions, and so does the test `findings` of `stiction-cli`, for
//! every earlier finding. They accept only text, so that a finding is a small readable file.

pub mod checkpoint;
pub mod finite;
pub mod runs;
pub mod texts;

/// Checks a property for a text.
pub type Trial = fn(&str);

/// All trials by the name of their fuzz target.
pub const TRIALS: [(&str, Trial); 9] = [
    ("model", texts::model),
    ("unit", texts::unit),
    ("expression", texts::expression),
    ("recording", texts::recording),
    ("options", texts::options),
    ("drives", texts::drives),
    ("checkpoint", checkpoint::checkpoint),
    ("mechanism", runs::mechanism),
    ("robot_file", texts::robot_file),
];
