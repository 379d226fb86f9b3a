//! Massless bodies between two joints. MuJoCo rejects moving bodies without mass, but a body can have several joints.

use super::steps::{Kind, kinds};
use super::tree::{Closing, Part, has_mass};
use stiction_core::mechanism::{BodyId, Mechanism};

/// Greatest number of degrees of freedom between an MJCF body and its parent.
const MOST_DOFS: usize = 6;

/// Marks the massless bodies that carry one other body and nothing else, and gives their joints to the bodies that they
/// carry. `parts` is in the order of the file, parents before children.
pub(super) fn mark(mechanism: &Mechanism, closings: &[(usize, Closing)], parts: &mut [Part]) {
    let mut first = vec![None; mechanism.bodies().len()];
    let mut carried = vec![0_usize; mechanism.bodies().len()];
    for (index, part) in parts.iter().enumerate() {
        carried[part.parent] += 1;
        if !part.is_further {
            first[part.body] = Some(index);
        }
    }
    let has_sites = with_sites(mechanism, closings);
    let mut outer_bodies = vec![0; parts.len()];
    for index in 0..parts.len() {
        let Some(below) = first[parts[index].parent] else { continue };
        let Part { body, before, parent, .. } = parts[below].clone();
        outer_bodies[index] = outer_bodies[below];
        let is_movable = |part: &Part| {
            let kinds = kinds(mechanism, part.joint);
            !part.is_free && !kinds.is_empty() && !kinds.contains(&Kind::Ball)
        };
        let own = kinds(mechanism, parts[index].joint).len();
        let joints = before.iter().chain([&below]).map(|part| parts[*part].joint);
        let count: usize = joints.map(|joint| kinds(mechanism, joint).len()).sum();
        if !has_mass(mechanism, BodyId(body))
            && !has_sites[body]
            && carried[body] == 1
            && is_movable(&parts[below])
            && is_movable(&parts[index])
            && count + own <= MOST_DOFS
        {
            parts[below].is_between = true;
            parts[below].before.clear();
            outer_bodies[index] += 1;
            parts[index].parent = parent;
            parts[index].before = before.into_iter().chain([below]).collect();
        }
        parts[index].depth -= outer_bodies[index];
    }
}

/// Flag for each body, true if sites for springs or loop closures are fixed to it.
fn with_sites(mechanism: &Mechanism, closings: &[(usize, Closing)]) -> Vec<bool> {
    let mut has_sites = vec![false; mechanism.bodies().len()];
    let ends = mechanism.springs().iter().flat_map(|spring| spring.ends);
    let closed = closings
        .iter()
        .filter(|(_, closing)| matches!(closing, Closing::Connect | Closing::Weld))
        .map(|(joint, _)| &mechanism.joints()[*joint])
        .flat_map(|joint| [joint.predecessor, joint.successor]);
    for body in ends.chain(closed) {
        has_sites[body.0] = true;
    }
    has_sites
}
