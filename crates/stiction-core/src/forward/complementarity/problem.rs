//! The problem: members, and how rates and loads answer their frictions.

use super::alone::Alone;
use super::laws::Kind;
use crate::forward::affine_friction::load;
use crate::forward::balance::Response;
use crate::friction::{Load, OwnFriction};
use crate::kinematics::Bodies;
use crate::parameters::Parameters;
use crate::spatial::Wrench;
use std::ops::Range;

/// One contact.
#[derive(Clone, Debug)]
pub(in crate::forward) struct Member {
    pub(in crate::forward) interface: usize,
    /// Its unknowns.
    pub(in crate::forward) places: Range<usize>,
    pub(in crate::forward) kind: Kind,
}

/// The problem.
pub(in crate::forward) struct Cone<'a> {
    pub(super) parameters: &'a Parameters<f64>,
    pub(super) bodies: &'a Bodies<f64>,
    pub(in crate::forward) members: Vec<Member>,
    /// Of each unknown the rate where none of them acts; not read for those that slide.
    pub(super) free: Vec<f64>,
    /// Row by row: by how much each rate changes with each unknown.
    pub(super) change: Vec<f64>,
    /// The wrench of each member's joint where none of them acts.
    pub(super) base: Vec<Wrench<f64>>,
    /// Row by row: by how much the wrench of each member's joint changes with each unknown.
    pub(super) push: Vec<Wrench<f64>>,
    /// Rates of what holds may be missed by this inverse factor more than forces; none may where it is
    /// infinite.
    pub(in crate::forward) slack: f64,
    /// Of members with several components, how they alone change their own rates.
    pub(super) alone: Vec<Option<Alone>>,
    /// What rates are multiplied by, as a multiple of the usual.
    pub(super) stiffness: f64,
}

impl<'a> Cone<'a> {
    pub(in crate::forward) fn new(
        parameters: &'a Parameters<f64>,
        bodies: &'a Bodies<f64>,
        members: Vec<Member>,
        free: Vec<f64>,
        change: Vec<f64>,
        (base, units): (&Response, &[Response]),
    ) -> Self {
        let joint = |member: &Member| parameters.interfaces[member.interface].joint;
        let push = members
            .iter()
            .flat_map(|member| units.iter().map(move |unit| unit.wrenches[joint(member)]))
            .collect();
        let base = members.iter().map(|member| base.wrenches[joint(member)]).collect();
        let slack = f64::INFINITY;
        let n = free.len();
        let alone = |member: &Member| {
            let dry = matches!(member.kind, Kind::Dry(_));
            (dry && member.places.len() > 1).then(|| Alone::new(&change, &member.places, n))
        };
        let alone = members.iter().map(alone).collect();
        Self { parameters, bodies, members, free, change, base, push, slack, alone, stiffness: 1.0 }
    }

    /// Of unknowns.
    pub(super) fn count(&self) -> usize {
        self.free.len()
    }

    /// Rates of the surfaces.
    pub(super) fn rates(&self, amounts: &[f64]) -> Vec<f64> {
        let n = self.count();
        let each = self.free.iter().zip(self.change.chunks_exact(n.max(1)));
        each.map(|(free, row)| free + row.iter().zip(amounts).map(|(a, b)| a * b).sum::<f64>())
            .collect()
    }

    /// The wrench of a member's joint.
    pub(super) fn wrench(&self, member: usize, amounts: &[f64]) -> Wrench<f64> {
        let n = self.count();
        let push = &self.push[member * n..(member + 1) * n];
        let mut sum = self.base[member];
        for (unit, amount) in push.iter().zip(amounts) {
            sum += *unit * *amount;
        }
        sum
    }

    /// The load of a member under its joint's wrench.
    pub(super) fn load(&self, member: usize, amounts: &[f64], wrench: Wrench<f64>) -> Load<f64> {
        let Member { interface, places, kind } = &self.members[member];
        let own = match kind {
            Kind::Slides(own) => *own,
            _ => {
                let friction = amounts[places.start];
                OwnFriction {
                    coefficient: 0.0,
                    constant: friction.abs(),
                    direction: friction.signum(),
                }
            }
        };
        load(self.parameters, self.bodies, &self.parameters.interfaces[*interface], own, wrench)
    }

    /// What rates are multiplied by, for numbers of the size of forces.
    pub(super) fn softness(&self, places: &Range<usize>) -> f64 {
        let n = self.count();
        let stiffness: f64 = places.clone().map(|i| -self.change[i * n + i]).sum();
        if stiffness > 0.0 { self.stiffness / stiffness } else { 0.0 }
    }
}
