//! Complementarity problem: members (friction interfaces), and the effect of their friction on
//! surface rates and joint wrenches.

use super::laws::MemberLaw;
use super::local::LocalResponse;
use crate::friction::{Load, OwnFriction};
use crate::friction_problem::influence::Influence;
use crate::friction_problem::normal_load::Configuration;
use crate::spatial::Wrench;
use std::ops::Range;

/// Member of the complementarity problem: one friction interface with its friction law.
#[derive(Clone, Debug)]
pub(crate) struct Member {
    pub(crate) interface: usize,
    /// Indices of the member's unknowns among the unknowns of all members.
    pub(crate) places: Range<usize>,
    pub(crate) law: MemberLaw,
}

/// Complementarity problem: its members, and the matrices that describe how surface rates and joint
/// wrenches depend on the unknowns.
#[derive(Clone)]
pub(crate) struct Complementarity<'a> {
    at: Configuration<'a>,
    pub(crate) members: Vec<Member>,
    /// Surface rate in the direction of each unknown if no member has friction; unused for members
    /// with [`MemberLaw::Sliding`].
    pub(super) free: Vec<f64>,
    /// Change of each surface rate (rows) per unit of each unknown (columns), row by row.
    pub(super) compliance: Vec<f64>,
    /// Wrench at each member's joint if no member has friction.
    base: Vec<Wrench<f64>>,
    /// Change of the wrench at each member's joint (rows) per unit of each unknown (columns), row
    /// by row.
    pub(super) influence: Vec<Wrench<f64>>,
    /// Tolerance factor for sticking members. The relative residual of a sticking member is the
    /// smaller of two numbers: its force residual relative to the largest force, and this factor
    /// times its rate relative to the largest frictionless rate. If the factor is infinite, only
    /// the force residual counts.
    pub(crate) slack: f64,
    /// For each dry member with several components (ball or plate), its surface rate as a function
    /// of its own friction; `None` for all other members.
    pub(super) local: Vec<Option<LocalResponse>>,
    pub(super) scaling: Scaling,
    /// Largest friction force of any member under the normal loads of the frictionless problem, N.
    force: f64,
}

/// Rule for the factor `rho` in the [module's](super) equation, which makes surface rates
/// comparable with friction forces. It affects convergence, but not the solutions.
#[derive(Clone, Copy, Debug)]
pub(super) enum Scaling {
    /// The factor `rho` is this multiple of the member's effective mass.
    EffectiveMass(f64),
    /// The factor `rho` is the largest friction force divided by the largest frictionless rate, but
    /// at least the effective mass. This scale exists even for prescribed rates, which do not
    /// change with friction.
    ForcePerRate,
}

impl<'a> Complementarity<'a> {
    /// Creates the problem of `members` from the frictionless surface rates `free`, the change of
    /// these rates per unit of each unknown (`compliance`, row by row), the frictionless joint
    /// wrenches `base`, and the influence of the unknowns on these wrenches (`operator`).
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
        let mut problem = Self {
            at,
            members,
            free,
            compliance,
            base,
            influence,
            slack: f64::INFINITY,
            local,
            scaling: Scaling::EffectiveMass(1.0),
            force: 0.0,
        };
        problem.force = problem.largest_friction();
        problem
    }

    /// Number of unknowns.
    pub(super) fn count(&self) -> usize {
        self.free.len()
    }

    /// Computes the surface rates for given values of the unknowns.
    pub(super) fn rates(&self, amounts: &[f64]) -> Vec<f64> {
        let n = self.count();
        let each = self.free.iter().zip(self.compliance.chunks_exact(n.max(1)));
        each.map(|(free, row)| free + row.iter().zip(amounts).map(|(a, b)| a * b).sum::<f64>())
            .collect()
    }

    /// Computes the wrench at a member's joint for given values of the unknowns.
    pub(super) fn wrench(&self, member: usize, amounts: &[f64]) -> Wrench<f64> {
        let n = self.count();
        let row = &self.influence[member * n..(member + 1) * n];
        let mut sum = self.base[member];
        for (unit, amount) in row.iter().zip(amounts) {
            sum += *unit * *amount;
        }
        sum
    }

    /// Computes the normal load of a member from the wrench at its joint.
    pub(super) fn load(&self, member: usize, amounts: &[f64], wrench: Wrench<f64>) -> Load<f64> {
        let Member { interface, places, law } = &self.members[member];
        let own = match law {
            MemberLaw::Sliding(own) => *own,
            _ => OwnFriction::of(amounts[places.start]),
        };
        self.at.normal_load(*interface, wrench, own)
    }

    /// Computes the factor that scales surface rates of a member to the magnitude of forces.
    /// `places` are the indices of the member's unknowns.
    pub(super) fn rate_factor(&self, places: &Range<usize>) -> f64 {
        let n = self.count();
        let compliance: f64 = places.clone().map(|i| -self.compliance[i * n + i]).sum();
        if compliance <= 0.0 {
            // Friction does not change the rates of this member.
            return self.force_per_rate(&self.free[places.clone()]);
        }
        match self.scaling {
            Scaling::EffectiveMass(multiple) => multiple / compliance,
            // A smaller factor would hide residual rates of sticking members.
            Scaling::ForcePerRate => self.force_per_rate(&self.free).max(1.0 / compliance),
        }
    }

    /// Ratio of the largest friction force to the largest magnitude in `rates`; zero if all rates
    /// vanish.
    fn force_per_rate(&self, rates: &[f64]) -> f64 {
        let factor = self.force / rates.iter().fold(0.0_f64, |m, rate| m.max(rate.abs()));
        if factor.is_finite() { factor } else { 0.0 }
    }

    fn largest_friction(&self) -> f64 {
        let none = vec![0.0; self.count()];
        let each = self.members.iter().enumerate().map(|(index, member)| match &member.law {
            MemberLaw::Dry(law) => {
                let load = self.load(index, &none, self.base[index]).value;
                law.forward.max(law.backward) * load
            }
            _ => 0.0,
        });
        each.fold(0.0, f64::max)
    }
}
