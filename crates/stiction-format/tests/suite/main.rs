//! Tests of the crate in one binary, which is linked once.

mod changes;
mod gallery;
mod import;
mod legs;
mod messages;
mod motions;
mod recordings;
mod robust;
mod schema;
mod stored;
mod variations;
mod visuals;
mod waypoints;
