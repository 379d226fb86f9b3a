//! Complementarity problem: its members, and the response of rates and joint wrenches to friction.

use super::laws::MemberLaw;
use super::local::LocalResponse;
use crate::friction::{Load, OwnFriction};
use crate::friction_problem::influence::Influence;
use crate::friction_problem::normal_load::Configuration;
use crate::spatial::Wrench;
use std::ops::Range;

/// One interface of the problem.
#[derive(Clone, Debug)]
pub(crate) struct Member {
    pub(crate) interface: usize,
    /// Indices of its unknowns.
    pub(crate) places: Range<usize>,
    pub(crate) law: MemberLaw,
}

/// Nonlinear complementarity problem of friction.
pub(crate) struct Complementarity<'a> {
    at: Configuration<'a>,
    pub(crate) members: Vec<Member>,
    /// Frictionless surface rate of each unknown; unused for members that slide for certain.
    pub(super) free: Vec<f64>,
    /// Change of each rate with each unknown, row by row.
    pub(super) compliance: Vec<f64>,
    /// Wrench of each member's joint without friction of the members.
    base: Vec<Wrench<f64>>,
    /// Change of the wrench of each member's joint with each unknown, row by row.
    pub(super) influence: Vec<Wrench<f64>>,
    /// Inverse weight of a sticking member's rate residual relative to force residuals; infinite
    /// for an exact constraint.
    pub(crate) slack: f64,
    /// Response of each member with several components to its own friction.
    pub(super) local: Vec<Option<LocalResponse>>,
    /// Factor of the rates relative to the default.
    pub(super) stiffness: f64,
}

impl<'a> Complementarity<'a> {
    /// Problem of `members` with free rates, their change with each unknown (row by row), the joint
    /// wrenches without friction of the members, and the influence of the unknowns on these
    /// wrenches.
    pub(crate) fn new(
        at: Configuration<'a>,
        members: Vec<Member>,
        (free, compliance): (Vec<f64>, Vec<f64>),
        base: Vec<Wrench<f64>>,
        operator: &mut impl Influence,
    ) -> Self {
        let n = free.len();
        let mut influence = vec![Wrench::zero(); members.len() * n];
        operator.visit(|row, column, wrench| influence[row * n + column] = wrench);
        let own = |member: &Member| {
            let dry = matches!(member.law, MemberLaw::Dry(_));
            (dry && member.places.len() > 1)
                .then(|| LocalResponse::new(&compliance, &member.places, n))
        };
        let local = members.iter().map(own).collect();
        let (slack, stiffness) = (f64::INFINITY, 1.0);
        Self { at, members, free, compliance, base, influence, slack, local, stiffness }
    }

    /// Number of unknowns.
    pub(super) fn count(&self) -> usize {
        self.free.len()
    }

    /// Surface rates.
    pub(super) fn rates(&self, amounts: &[f64]) -> Vec<f64> {
        let n = self.count();
        let each = self.free.iter().zip(self.compliance.chunks_exact(n.max(1)));
        each.map(|(free, row)| free + row.iter().zip(amounts).map(|(a, b)| a * b).sum::<f64>())
            .collect()
    }

    /// Wrench of a member's joint.
    pub(super) fn wrench(&self, member: usize, amounts: &[f64]) -> Wrench<f64> {
        let n = self.count();
        let row = &self.influence[member * n..(member + 1) * n];
        let mut sum = self.base[member];
        for (unit, amount) in row.iter().zip(amounts) {
            sum += *unit * *amount;
        }
        sum
    }

    /// Normal load of a member under its joint's wrench.
    pub(super) fn load(&self, member: usize, amounts: &[f64], wrench: Wrench<f64>) -> Load<f64> {
        let Member { interface, places, law } = &self.members[member];
        let own = match law {
            MemberLaw::Sliding(own) => *own,
            _ => OwnFriction::of(amounts[places.start]),
        };
        self.at.normal_load(*interface, wrench, own)
    }

    /// Factor that scales rates of a member to the magnitude of forces.
    pub(super) fn rate_factor(&self, places: &Range<usize>) -> f64 {
        let n = self.count();
        let compliance: f64 = places.clone().map(|i| -self.compliance[i * n + i]).sum();
        if compliance > 0.0 { self.stiffness / compliance } else { 0.0 }
    }
}
