//! All integration tests of this crate in one binary, which is linked only once.

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
