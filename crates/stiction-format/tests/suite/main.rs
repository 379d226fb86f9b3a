//! All tests of this crate in one program: it is linked once.

mod gallery;
mod legs;
mod messages;
mod motions;
mod robust;
mod schema;
mod stored;
