//! Import of robot files of other programs.

mod formats;
mod gearings;
mod hostile;
mod meaning;
mod tree;
mod truths;
