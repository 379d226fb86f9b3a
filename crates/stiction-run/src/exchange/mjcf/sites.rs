//! Marked frames: where springs end, and what closes loops. Frames that are marked in both bodies do
//! not depend on the position in which a program reads the file, nor on where its joints are.

use super::names::Names;
use super::tree::{Closing, Part, Tree};
use stiction_core::mechanism::Mechanism;
use stiction_core::spatial::Pose;

/// A marked frame of a body.
#[derive(Clone, Debug)]
pub(super) struct Site {
    pub(super) name: String,
    pub(super) pose: Pose<f64>,
    /// It is on the further part of the body that hangs by this joint.
    pub(super) part: Option<usize>,
}

/// All sites.
#[derive(Clone, Debug)]
pub(super) struct Sites {
    /// For each of our bodies its own.
    pub(super) of_body: Vec<Vec<Site>>,
    /// For each spring the names of those at its ends.
    pub(super) of_spring: Vec<[String; 2]>,
    /// For each joint that closes a loop the names of those that coincide.
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
                // Both at the same place of two parts of one body.
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
