//! Complementarity problem of forward dynamics, with accelerations or velocities as rates.

use super::Forward;
use super::balance::{Balance, Response};
use super::data::Data;
use crate::friction_problem::complementarity::{Complementarity, Member, MemberLaw};
use crate::friction_problem::influence::Influence;
use crate::spatial::Wrench;

/// Members of a complementarity problem, each with the responses of the balance to its unknowns.
pub(super) struct Members<'a> {
    model: &'a Forward,
    data: &'a Data,
    balance: &'a Balance,
    members: Vec<Member>,
    /// Response to each unknown.
    pub(super) units: Vec<Response>,
}

/// Wrenches at the members' joints in response to each unknown.
struct MemberWrenches<'a> {
    joints: Vec<usize>,
    units: &'a [Response],
}

impl Influence for MemberWrenches<'_> {
    fn visit(&mut self, mut put: impl FnMut(usize, usize, Wrench<f64>)) {
        for (row, joint) in self.joints.iter().enumerate() {
            let each = self.units.iter().enumerate();
            each.for_each(|(column, unit)| put(row, column, unit.wrenches[*joint]));
        }
    }
}

impl<'a> Members<'a> {
    pub(super) fn new(model: &'a Forward, data: &'a Data, balance: &'a Balance) -> Self {
        Self { model, data, balance, members: Vec::new(), units: Vec::new() }
    }

    /// Adds an interface; `wrenches` are the wrenches at its joint per unit of each of its
    /// unknowns.
    pub(super) fn add(
        &mut self,
        interface: usize,
        law: MemberLaw,
        wrenches: impl IntoIterator<Item = Wrench<f64>>,
    ) {
        let (model, data) = (self.model, self.data);
        let joint = model.parameters.interfaces[interface].joint;
        let first = self.units.len();
        let responses = wrenches
            .into_iter()
            .map(|wrench| self.balance.respond(model, data, &[(joint, wrench)], false));
        self.units.extend(responses);
        self.members.push(Member { interface, places: first..self.units.len(), law });
    }

    /// Complementarity problem of the members. `base` is the response without friction of the
    /// members; `free` returns the surface rates of a member in it. A friction force changes the
    /// rates by `step` times the accelerations that it causes.
    pub(super) fn problem(
        &self,
        base: &Response,
        step: f64,
        free: impl Fn(usize) -> [f64; 3],
    ) -> Complementarity<'a> {
        let (model, data) = (self.model, self.data);
        let count = self.units.len();
        let (mut rates, mut compliance) = (vec![0.0; count], vec![0.0; count * count]);
        for member in self.members.iter().filter(|m| !matches!(m.law, MemberLaw::Sliding(_))) {
            let own = free(member.interface);
            for (place, i) in member.places.clone().enumerate() {
                rates[i] = own[place];
                for (j, unit) in self.units.iter().enumerate() {
                    let accelerations = &unit.accelerations;
                    let rate =
                        model.surface_rate(&data.bodies, accelerations, member.interface, place);
                    compliance[i * count + j] = step * rate;
                }
            }
        }
        let joint = |member: &Member| model.parameters.interfaces[member.interface].joint;
        let joints: Vec<usize> = self.members.iter().map(joint).collect();
        let wrenches = joints.iter().map(|joint| base.wrenches[*joint]).collect();
        let mut influence = MemberWrenches { joints, units: &self.units };
        let at = model.configuration(data);
        let members = self.members.clone();
        Complementarity::new(at, members, (rates, compliance), wrenches, &mut influence)
    }
}
