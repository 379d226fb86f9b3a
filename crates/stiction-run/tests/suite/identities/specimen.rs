//! A random mechanism in motion, in a form that can be reduced.

use crate::identities::richness::enrich;
use crate::mechanisms::random::*;
use stiction_core::dynamics::{AppliedLoad, InverseDynamics};
use stiction_core::kinematics::{Coordinate, Target};
use stiction_core::mechanism::{BodyId, JointId};
use stiction_run::exchange::{Instant, model_file};

/// Largest friction coefficient of the specimens, chosen so that most of them do not lock.
pub(crate) const MU: f64 = 0.15;

/// Random mechanism with its prescribed motion and loads. Bodies and joints are identified by their
/// index; body 0 is the ground.
#[derive(Clone)]
pub(crate) struct Specimen {
    pub(crate) class: Class,
    pub(crate) seed: u64,
    pub(crate) draft: Draft,
    /// Prescribed motion: indices of a joint and of its DOF, and the target. Coordinates are zero
    /// in the generated position.
    pub(crate) prescribed: Vec<(usize, usize, Target<f64>)>,
    pub(crate) loads: Vec<AppliedLoad<f64>>,
}

impl Specimen {
    pub(crate) fn random(class: Class, seed: u64) -> Self {
        let (mut draft, case) = case(class, seed, MU);
        enrich(&mut draft, &mut Random(seed ^ 0x5EED));
        let prescribed = case.coordinates.iter().zip(&case.targets).map(|(coordinate, target)| {
            let Coordinate::Joint { joint, dof } = *coordinate else { unreachable!("joints only") };
            (joint.0, dof, *target)
        });
        Self { class, seed, prescribed: prescribed.collect(), loads: case.loads, draft }
    }

    /// Returns the random numbers for the changes that an identity makes; they are equal in every
    /// run.
    pub(crate) fn random_changes(&self) -> Random {
        Random(self.seed + 1000)
    }

    /// Builds the mechanism, with bodies and joints in the generated order.
    pub(crate) fn case(&self) -> Case {
        Case {
            mechanism: self.draft.build_in_order(),
            coordinates: self
                .prescribed
                .iter()
                .map(|&(joint, dof, _)| Coordinate::Joint { joint: JointId(joint), dof })
                .collect(),
            targets: self.prescribed.iter().map(|(_, _, target)| *target).collect(),
            loads: self.loads.clone(),
            class: self.class,
        }
    }

    /// Writes the specimen as a model file.
    pub(crate) fn file(&self) -> String {
        let case = self.case();
        let motion: Vec<_> = case.coordinates.into_iter().zip(case.targets).collect();
        let instant = Instant { motion: &motion, loads: &case.loads, friction: None };
        let title = format!("{:?} {}", self.class, self.seed);
        model_file(&case.mechanism, &title, instant).expect("drafts can be written")
    }

    /// Removes a joint, and everything that is then disconnected.
    pub(crate) fn without_joint(&self, joint: usize) -> Self {
        let joints = (0..self.draft.joints.len()).filter(|&j| j != joint).collect::<Vec<_>>();
        self.part(&joints)
    }

    /// Returns the specimen with only the given joints and the bodies that they connect.
    pub(crate) fn part(&self, joints: &[usize]) -> Self {
        let held = held(&self.draft, joints);
        let body = |old: usize| held[..old].iter().filter(|held| **held).count();
        let is_kept = |joint: &DraftJoint| held[joint.ends.0] && held[joint.ends.1];
        let kept: Vec<usize> =
            joints.iter().copied().filter(|&j| is_kept(&self.draft.joints[j])).collect();
        let mut draft = Draft::new();
        let bodies = self.draft.bodies.iter().zip(&held[1..]).filter(|(_, held)| **held);
        draft.bodies = bodies.map(|(body, _)| body.clone()).collect();
        let of_joint = |&joint: &usize| {
            let joint = self.draft.joints[joint].clone();
            DraftJoint { ends: (body(joint.ends.0), body(joint.ends.1)), ..joint }
        };
        draft.joints = kept.iter().map(of_joint).collect();
        let place = |joint: usize| kept.iter().position(|&k| k == joint);
        let prescribed = self
            .prescribed
            .iter()
            .filter_map(|&(joint, dof, target)| Some((place(joint)?, dof, target)));
        let loads = self
            .loads
            .iter()
            .filter(|load| held[load.body.0])
            .map(|load| AppliedLoad { body: BodyId(body(load.body.0)), ..*load });
        Self { prescribed: prescribed.collect(), loads: loads.collect(), draft, ..self.clone() }
    }
}

/// Returns, for each body including the ground, true if the given joints connect the body to the
/// ground.
fn held(draft: &Draft, joints: &[usize]) -> Vec<bool> {
    let mut held = vec![false; draft.bodies.len() + 1];
    held[0] = true;
    loop {
        let next = joints.iter().map(|&j| draft.joints[j].ends).find(|&(a, b)| held[a] != held[b]);
        let Some((a, b)) = next else { return held };
        (held[a], held[b]) = (true, true);
    }
}

/// Solver for the inverse dynamics of a case in its assembled position.
pub(crate) type Solver = InverseDynamics;
