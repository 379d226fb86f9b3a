//! Complementarity problem between frictions and the accelerations, or velocities, of the interfaces.

use super::Forward;
use super::balance::{Balance, Response};
use super::data::Data;
use super::transmitted::{is_behind, parallel_to_gear};
use crate::friction_problem::complementarity::{Complementarity, Member, MemberLaw};
use crate::friction_problem::influence::Influence;
use crate::kinematics::Bodies;
use crate::spatial::Wrench;

/// Interfaces that take part in a complementarity problem, each with the responses of the balance to its unknown
/// frictions.
pub(super) struct Members<'a> {
    model: &'a Forward,
    data: &'a Data,
    balance: &'a Balance,
    members: Vec<Member>,
    /// Response to each unknown.
    pub(super) units: Vec<Response>,
    /// Interface and joint wrench of each unknown, per unit of the unknown.
    wrenches: Vec<(usize, Wrench<f64>)>,
    /// Interfaces whose friction the base response includes, and the wrenches of these frictions.
    known: Vec<(usize, Wrench<f64>)>,
}

/// Influence of each unknown on the wrenches at the joints of the members.
struct MemberWrenches<'a> {
    model: &'a Forward,
    bodies: &'a Bodies<f64>,
    members: &'a [Member],
    units: &'a [Response],
    wrenches: &'a [(usize, Wrench<f64>)],
}

impl Influence for MemberWrenches<'_> {
    fn visit(&mut self, mut put: impl FnMut(usize, usize, Wrench<f64>)) {
        for (row, member) in self.members.iter().enumerate() {
            let joint = self.model.parameters.interfaces[member.interface].joint;
            for (column, (unit, own)) in self.units.iter().zip(self.wrenches).enumerate() {
                let behind =
                    friction_behind(self.model, member.interface, std::slice::from_ref(own));
                let geared =
                    parallel_to_gear(self.model, self.bodies, member.interface, &unit.multipliers);
                put(row, column, unit.wrenches[joint] - behind - geared);
            }
        }
    }
}

/// Sums the frictions among `all` that act between the gear of the interface `gear` and its load.
fn friction_behind(model: &Forward, gear: usize, all: &[(usize, Wrench<f64>)]) -> Wrench<f64> {
    let own = all.iter().filter(|(interface, _)| is_behind(&model.parameters, gear, *interface));
    own.fold(Wrench::zero(), |sum, (_, wrench)| sum + *wrench)
}

impl<'a> Members<'a> {
    pub(super) fn new(model: &'a Forward, data: &'a Data, balance: &'a Balance) -> Self {
        let (members, units) = (Vec::new(), Vec::new());
        Self { model, data, balance, members, units, wrenches: Vec::new(), known: Vec::new() }
    }

    /// Records the friction wrench of an interface that the base response includes.
    pub(super) fn include(&mut self, interface: usize, wrench: Wrench<f64>) {
        self.known.push((interface, wrench));
    }

    /// Adds an interface to the problem; `wrenches` are the wrenches at its joint per unit of each of its unknowns.
    pub(super) fn add(
        &mut self,
        interface: usize,
        law: MemberLaw,
        wrenches: impl IntoIterator<Item = Wrench<f64>>,
    ) {
        let (model, data) = (self.model, self.data);
        let joint = model.parameters.interfaces[interface].joint;
        let first = self.units.len();
        for wrench in wrenches {
            self.units.push(self.balance.respond(model, data, &[(joint, wrench)], false));
            self.wrenches.push((interface, wrench));
        }
        self.members.push(Member { interface, places: first..self.units.len(), law });
    }

    /// Builds the complementarity problem of the members. `base` is the response without friction of the members, and
    /// `free` returns the surface rates of a member in that response. `prescribed` contains the rates of the prescribed
    /// actuators, which friction does not change. A friction force changes every other rate by `step` times the
    /// acceleration that it causes.
    pub(super) fn problem(
        &self,
        base: &Response,
        step: f64,
        free: impl Fn(usize) -> [f64; 3],
        prescribed: &[f64],
    ) -> Complementarity<'a> {
        let (model, data) = (self.model, self.data);
        let count = self.units.len();
        let (mut rates, mut compliance) = (vec![0.0; count], vec![0.0; count * count]);
        for member in self.members.iter().filter(|m| !matches!(m.law, MemberLaw::Sliding(_))) {
            let own = free(member.interface);
            for (place, i) in member.places.clone().enumerate() {
                let rate = model.prescribed_rate(member.interface, place, |k| prescribed[k]);
                if let Some(rate) = rate {
                    // Computed rates of a locked actuator are round-off, whose sign would choose a
                    // direction of slip.
                    rates[i] = rate;
                    continue;
                }
                rates[i] = own[place];
                for (j, unit) in self.units.iter().enumerate() {
                    let accelerations = &unit.accelerations;
                    let rate =
                        model.surface_rate(&data.bodies, accelerations, member.interface, place);
                    compliance[i * count + j] = step * rate;
                }
            }
        }
        let of_base = |member: &Member| {
            let joint = model.parameters.interfaces[member.interface].joint;
            let geared = parallel_to_gear(model, &data.bodies, member.interface, &base.multipliers);
            base.wrenches[joint] - friction_behind(model, member.interface, &self.known) - geared
        };
        let base = self.members.iter().map(of_base).collect();
        let (units, wrenches) = (&self.units[..], &self.wrenches[..]);
        let (members, bodies) = (&self.members[..], &data.bodies);
        let mut influence = MemberWrenches { model, bodies, members, units, wrenches };
        let at = model.configuration(data);
        let members = self.members.clone();
        Complementarity::new(at, members, (rates, compliance), base, &mut influence)
    }
}
