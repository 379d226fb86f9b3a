//! MJCF sites, which are frames fixed to bodies: at the ends of springs and at loop closures. A
//! constraint between two sites depends neither on the configuration in which another program reads
//! the file, nor on the locations of the joints.

use super::tree::{Closing, Part, Tree};
use crate::exchange::names::Names;
use stiction_core::mechanism::Mechanism;
use stiction_core::spatial::Pose;

/// MJCF site: a frame fixed to a body.
#[derive(Clone, Debug)]
pub(super) struct Site {
    pub(super) name: String,
    pub(super) pose: Pose<f64>,
    /// Index of the joint that carries the part of a split body to which the site is fixed; `None`
    /// for the first part of the body.
    pub(super) part: Option<usize>,
}

/// All MJCF sites of the exported model.
#[derive(Clone, Debug)]
pub(super) struct Sites {
    /// MJCF sites of each body of the mechanism.
    pub(super) of_body: Vec<Vec<Site>>,
    /// Names of the two sites at the ends of each spring.
    pub(super) of_spring: Vec<[String; 2]>,
    /// For each joint outside the spanning tree, the names of the two sites that its loop closure
    /// makes coincide.
    pub(super) of_closing: Vec<[String; 2]>,
}

impl Sites {
    pub(super) fn new(mechanism: &Mechanism, tree: &Tree) -> Self {
        let mut names = Names::default();
        let mut pair = |name: &str| ["from", "to"].map(|end| names.take(&format!("{name}.{end}")));
        let mut of_body = vec![Vec::new(); mechanism.bodies().len()];
        let (mut of_spring, mut of_closing) = (Vec::new(), Vec::new());
        for spring in mechanism.springs() {
            let own = pair(&spring.name);
            for (end, name) in own.iter().enumerate() {
                let (name, pose) = (name.clone(), Pose::at(spring.points[end]));
                of_body[spring.ends[end].0].push(Site { name, pose, part: None });
            }
            of_spring.push(own);
        }
        for &(index, closing) in &tree.closings {
            let joint = &mechanism.joints()[index];
            let own = pair(&joint.name);
            let mut place = |end: usize, body: usize, pose: Pose<f64>, part: Option<usize>| {
                of_body[body].push(Site { name: own[end].clone(), pose, part });
            };
            let (j, k) = (joint.predecessor.0, joint.successor.0);
            match closing {
                Closing::Nothing => {}
                Closing::Connect | Closing::Weld => {
                    place(0, j, joint.frame_j, None);
                    place(1, k, joint.frame_k, None);
                }
                // Both sites lie at the same point: one on each part of the split body.
                Closing::Part => {
                    let reversed = |part: &&Part| part.joint == index && part.reversed;
                    let (body, pose) = match tree.parts.iter().find(reversed) {
                        Some(_) => (j, joint.frame_j),
                        None => (k, joint.frame_k),
                    };
                    place(0, body, pose, None);
                    place(1, body, pose, Some(index));
                }
            }
            of_closing.push(own);
        }
        Self { of_body, of_spring, of_closing }
    }
}
