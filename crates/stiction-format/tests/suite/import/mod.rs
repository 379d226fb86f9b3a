//! Import of robot files of other programs.

mod formats;
mod hostile;
mod meaning;
mod tree;
mod truths;
