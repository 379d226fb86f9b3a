//! Gearings of two joints as mimic joints of URDF and SDF. The coordinate of a mimic joint follows
//! the coordinate of another joint, its leader.

use stiction_core::joint::JointType;
use stiction_core::mechanism::{GearedDof, JointRange, Mechanism, RangeOf};

/// Mimic joint: its coordinate is `multiplier` times the coordinate of the leader plus `offset`, m
/// or rad.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Mimic {
    /// Index of the gearing in the mechanism.
    pub(super) gearing: usize,
    /// Index of the mimic joint.
    pub(super) follower: usize,
    /// Index of the joint that leads the mimic joint.
    pub(super) leader: usize,
    pub(super) multiplier: f64,
    pub(super) offset: f64,
}

/// Finds the gearings that URDF and SDF can express as mimic joints: those of two revolute or
/// prismatic joints. A joint follows at most one leader, and never itself through a chain of
/// leaders.
pub(super) fn all(mechanism: &Mechanism) -> Vec<Mimic> {
    let is_simple = |dof: &GearedDof| {
        let kind = mechanism.joints()[dof.joint.0].joint_type;
        matches!(kind, JointType::Revolute | JointType::Prismatic)
    };
    let mut found: Vec<Mimic> = Vec::new();
    for (index, gearing) in mechanism.gearings().iter().enumerate() {
        let [first, second] = &gearing.dofs[..] else { continue };
        if !is_simple(first) || !is_simple(second) {
            continue;
        }
        let is_actuated = |dof: &GearedDof| mechanism.joints()[dof.joint.0].actuated[0];
        let pair = if is_actuated(first) { [second, first] } else { [first, second] };
        let [reverse, forward] = [[pair[1], pair[0]], pair];
        let fits = |[follower, leader]: &[&GearedDof; 2]| {
            let follows = |joint: usize| found.iter().find(|mimic| mimic.follower == joint);
            let mut last = leader.joint.0;
            while let Some(mimic) = follows(last) {
                last = mimic.leader;
            }
            follows(follower.joint.0).is_none() && last != follower.joint.0
        };
        if let Some([follower, leader]) = [forward, reverse].into_iter().find(fits) {
            found.push(Mimic {
                gearing: index,
                follower: follower.joint.0,
                leader: leader.joint.0,
                multiplier: -leader.coefficient / follower.coefficient,
                offset: gearing.offset / follower.coefficient,
            });
        }
    }
    found
}

/// Returns the range, the largest effort and the largest rate of a joint with one coordinate, in SI
/// units. A limit that the model does not define is `None`.
pub(super) fn limits(
    mechanism: &Mechanism,
    joint: usize,
) -> (Option<(f64, f64)>, Option<f64>, Option<f64>) {
    let content = &mechanism.joints()[joint];
    let is_own = |range: &&JointRange| range.of == RangeOf::Dof(0);
    let range = content.ranges.iter().find(is_own).map(|range| range.limits);
    let trains: Vec<_> = mechanism
        .drive_trains()
        .iter()
        .filter(|train| train.only_dof().is_some_and(|(own, dof)| (own.0, dof) == (joint, 0)))
        .collect();
    // The efforts of all motors of the joint add up. If one motor has no limit, the effort of the
    // joint has no limit.
    let effort = trains
        .iter()
        .try_fold(0.0, |sum, train| Some(sum + train.limits.peak? * train.transmission().abs()));
    let rates =
        trains.iter().filter_map(|train| Some(train.limits.speed? / train.transmission().abs()));
    let rate = rates.reduce(f64::min);
    (range, effort.filter(|effort| *effort > 0.0), rate)
}
