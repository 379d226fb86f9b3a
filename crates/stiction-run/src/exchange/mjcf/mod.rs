//! Export to MuJoCo's XML format (MJCF): a tree of nested bodies, and equality constraints that
//! close the loops.

mod between;
mod contents;
mod equalities;
mod inertia;
mod notes;
mod parts;
mod sites;
mod steps;
mod tree;
mod writer;

use super::Home;
use stiction_core::joint::JointType;
use thiserror::Error;
use tree::{Part, Tree};
use writer::Writer;

/// MuJoCo model as text, with notes on properties that MJCF cannot express.
#[derive(Clone, Debug, PartialEq)]
pub struct Mjcf {
    /// Text of the MJCF file.
    pub text: String,
    /// Notes on properties that the file omits or changes, one per entry.
    pub notes: Vec<String>,
}

/// Reason why a mechanism cannot be converted to another format.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum Unfit {
    /// A moving body has no mass.
    #[error("MuJoCo rejects moving bodies without mass, such as `{body}`")]
    Massless {
        /// Name of the body without mass.
        body: String,
    },
    /// A joint closes a loop, and neither of the two bodies that it connects has mass. To close the
    /// loop, one of them would have to be split into two parts with mass.
    #[error(
        "joint `{joint}` closes a loop, for which one of its bodies must be split, and neither \
         of them has mass"
    )]
    CannotClose {
        /// Name of the joint that closes the loop.
        joint: String,
    },
    /// The target format has no joint of this type.
    #[error("joint `{joint}` is of type {kind}, which {format} does not have")]
    NoSuchJoint {
        /// Name of the joint that cannot be converted.
        joint: String,
        /// Type of the joint.
        kind: String,
        /// Name of the target format.
        format: &'static str,
    },
}

impl Unfit {
    /// Returns a remedy for the user.
    pub fn help(&self) -> &'static str {
        match self {
            Self::Massless { .. } => {
                "give the body a small mass, or leave it out and join its neighbours"
            }
            Self::CannotClose { .. } => "give one of the two bodies a small mass",
            Self::NoSuchJoint { .. } => {
                "use --to mjcf, or replace the joint in the model with \
                several joints"
            }
        }
    }
}

/// Converts an assembled mechanism to MJCF.
///
/// # Errors
/// Returns [`Unfit::Massless`] if a moving body has no mass, which MuJoCo rejects, and
/// [`Unfit::CannotClose`] if a joint that closes a loop connects two bodies without mass.
pub fn mjcf(home: &Home<'_>) -> Result<Mjcf, Unfit> {
    let tree = Tree::new(&home.model.mechanism)?;
    check_masses(home, &tree)?;
    let notes = notes::notes(&home.model.mechanism, &tree);
    let text = Writer::new(home, &tree).write(&notes);
    Ok(Mjcf { text, notes })
}

/// Checks that every moving body has mass, either its own or that of bodies fixed to it.
fn check_masses(home: &Home<'_>, tree: &Tree) -> Result<(), Unfit> {
    let mechanism = &home.model.mechanism;
    let is_fixed = |part: &Part| mechanism.joints()[part.joint].joint_type == JointType::Fixed;
    // Parents precede their children, so the reverse order passes the mass of fixed bodies on
    // towards the ground.
    let mut heavy: Vec<bool> = mechanism.bodies().iter().map(|body| body.mass > 0.0).collect();
    for part in tree.parts.iter().rev().filter(|part| is_fixed(part)) {
        heavy[part.parent] |= heavy[part.body];
    }
    let is_light = |part: &&Part| !is_fixed(part) && !part.is_between && !heavy[part.body];
    match tree.parts.iter().find(is_light) {
        None => Ok(()),
        Some(part) => Err(Unfit::Massless { body: mechanism.bodies()[part.body].name.clone() }),
    }
}
