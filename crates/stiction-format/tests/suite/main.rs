//! All integration tests of this crate in one binary, which links only once.

mod gallery;
mod legs;
mod messages;
mod motions;
mod robust;
mod schema;
mod stored;
