//! Import of robot files of other programs.

mod exporters;
mod formats;
mod gearings;
mod hostile;
mod legs;
mod meaning;
mod mujoco;
mod tree;
mod truths;
