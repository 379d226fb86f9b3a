//! Reduction of a counterexample.

use crate::identities::harness::{Identity, Verdict, verdict};
use crate::identities::specimen::Specimen;
use stiction_core::joint::JointType;
use stiction_core::kinematics::Target;
use stiction_core::spatial::{Mat3, Vec3};

/// Returns the smallest specimen found that violates the identity in the same way. The search
/// reduces the specimen repeatedly, and tries large reductions first.
pub(crate) fn shrink(identity: Identity, specimen: &Specimen) -> Specimen {
    let kind = |specimen: &Specimen| match verdict(identity, specimen) {
        // Message of the violation, without its numbers.
        Verdict::Broken(why) => {
            why.split(|c: char| c == ':' || c.is_ascii_digit()).next().map(str::to_owned)
        }
        _ => None,
    };
    let wanted = kind(specimen);
    let is_broken = |specimen: &Specimen| kind(specimen) == wanted;
    let mut best = specimen.clone();
    // Each reduction removes something that no other reduction restores, so the loop ends.
    while let Some(smaller) = smaller(&best).into_iter().find(|smaller| is_broken(smaller)) {
        best = smaller;
    }
    best
}

fn smaller(of: &Specimen) -> Vec<Specimen> {
    let joints = 0..of.draft.joints.len();
    let mut all: Vec<Specimen> = Vec::new();
    all.extend(without_branches(of));
    all.extend(joints.clone().map(|joint| of.without_joint(joint)));
    all.extend(joints.clone().filter_map(|joint| welded(of, joint)));
    all.extend(joints.clone().filter_map(|joint| merged(of, joint)));
    all.extend((0..of.loads.len()).map(|load| {
        let mut smaller = of.clone();
        smaller.loads.remove(load);
        smaller
    }));
    all.extend(joints.filter_map(|joint| without_friction(of, joint)));
    all.extend((0..of.prescribed.len()).flat_map(|place| calmer(of, place)));
    all.extend((0..of.draft.bodies.len()).flat_map(|body| plainer(of, body)));
    all.retain(|smaller| !smaller.draft.bodies.is_empty());
    all
}

/// Returns variants of a specimen without one branch. A branch is a connected component that
/// remains when one body (the hub) and the ground are removed, such as a leg.
fn without_branches(of: &Specimen) -> Vec<Specimen> {
    let draft = &of.draft;
    let mut all = Vec::new();
    for hub in 1..=draft.bodies.len() {
        let mut part: Vec<usize> = (0..=draft.bodies.len()).collect();
        let apart = |body: usize| body == 0 || body == hub;
        // Bodies that are connected without the hub and the ground have the same component number.
        for _ in 0..draft.bodies.len() {
            for joint in draft.joints.iter().filter(|j| !apart(j.ends.0) && !apart(j.ends.1)) {
                let least = part[joint.ends.0].min(part[joint.ends.1]);
                (part[joint.ends.0], part[joint.ends.1]) = (least, least);
            }
        }
        for branch in (1..=draft.bodies.len()).filter(|&b| !apart(b) && part[b] == b) {
            let is_of_branch = |body: usize| !apart(body) && part[body] == branch;
            let joints: Vec<usize> = (0..draft.joints.len())
                .filter(|&j| {
                    let (a, b) = draft.joints[j].ends;
                    !is_of_branch(a) && !is_of_branch(b)
                })
                .collect();
            all.push(of.part(&joints));
        }
    }
    all
}

/// Returns a variant in which a joint is fixed.
fn welded(of: &Specimen, joint: usize) -> Option<Specimen> {
    if of.draft.joints[joint].joint_type == JointType::Fixed {
        return None;
    }
    let mut smaller = of.clone();
    let welded = &mut smaller.draft.joints[joint];
    welded.joint_type = JointType::Fixed;
    welded.actuated.clear();
    welded.friction.clear();
    smaller.prescribed.retain(|&(other, ..)| other != joint);
    Some(smaller)
}

/// Returns a variant in which the two bodies of a fixed joint are merged; the body with the lower
/// number remains.
fn merged(of: &Specimen, joint: usize) -> Option<Specimen> {
    let fixed = &of.draft.joints[joint];
    let (kept, gone) = (fixed.ends.0.min(fixed.ends.1), fixed.ends.0.max(fixed.ends.1));
    if fixed.joint_type != JointType::Fixed || kept == gone {
        return None;
    }
    let mut smaller = of.clone();
    for joint in &mut smaller.draft.joints {
        for end in [&mut joint.ends.0, &mut joint.ends.1] {
            if *end == gone {
                *end = kept;
            }
        }
    }
    smaller.loads.retain(|load| load.body.0 != gone);
    // A joint between a body and itself has no effect.
    let joints: Vec<usize> = (0..smaller.draft.joints.len())
        .filter(|&j| smaller.draft.joints[j].ends.0 != smaller.draft.joints[j].ends.1)
        .collect();
    Some(smaller.part(&joints))
}

fn without_friction(of: &Specimen, joint: usize) -> Option<Specimen> {
    let mut smaller = of.clone();
    let friction = &mut smaller.draft.joints[joint].friction;
    friction.pop()?;
    Some(smaller)
}

/// Returns variants with zero rates or zero accelerations.
fn calmer(of: &Specimen, place: usize) -> Vec<Specimen> {
    let target = of.prescribed[place].2;
    let mut calmer = vec![Target { acceleration: 0.0, ..target }];
    if target.rate != 0.0 {
        calmer.extend([0.0, target.rate.signum()].map(|rate| Target { rate, ..target }));
    }
    calmer.retain(|calmer| *calmer != target);
    let with = |target| {
        let mut smaller = of.clone();
        smaller.prescribed[place].2 = target;
        smaller
    };
    calmer.into_iter().map(with).collect()
}

/// Returns variants in which a body has no mass, or rounded numbers.
fn plainer(of: &Specimen, body: usize) -> Vec<Specimen> {
    let old = &of.draft.bodies[body];
    let mut all = Vec::new();
    let mut with = |change: &dyn Fn(&mut crate::mechanisms::random::DraftBody)| {
        let mut smaller = of.clone();
        change(&mut smaller.draft.bodies[body]);
        all.push(smaller);
    };
    if old.mass > 0.0 {
        with(&|body| {
            (body.mass, body.com, body.inertia) = (0.0, Vec3::zero(), Mat3::zero());
        });
        if old.com != Vec3::zero() {
            with(&|body| body.com = Vec3::zero());
        }
        if old.mass != 1.0 {
            with(&|body| body.mass = 1.0);
        }
        if old.inertia != Mat3::identity() * 0.01 {
            with(&|body| body.inertia = Mat3::identity() * 0.01);
        }
    }
    all
}
