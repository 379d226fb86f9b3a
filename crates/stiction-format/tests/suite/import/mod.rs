//! Import of robot files of other programs.

mod exporters;
mod formats;
mod gearings;
mod hostile;
mod legs;
mod meaning;
mod meshes;
mod mujoco;
mod remarks;
mod tilts;
mod tree;
mod truths;
