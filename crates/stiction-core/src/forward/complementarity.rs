//! Complementarity problem between the friction forces and the sliding accelerations (or sliding
//! velocities) of the interfaces.

use super::Forward;
use super::balance::{Balance, Response};
use super::data::Data;
use super::transmitted::{is_behind, parallel_to_gear};
use crate::friction_problem::complementarity::{Complementarity, Member, MemberLaw};
use crate::friction_problem::influence::Influence;
use crate::kinematics::Bodies;
use crate::spatial::Wrench;

/// Interfaces with unknown friction in a complementarity problem. Stores the [`Response`] of the
/// mechanism (accelerations, multipliers and joint wrenches) to one unit of each unknown friction.
pub(super) struct Members<'a> {
    model: &'a Forward,
    data: &'a Data,
    balance: &'a Balance,
    members: Vec<Member>,
    /// Response of the mechanism to one unit of each unknown friction, as soon as the problem is built.
    pub(super) units: Vec<Response>,
    /// Index of the interface of each unknown, and the wrench at its joint per unit of the unknown.
    wrenches: Vec<(usize, Wrench<f64>)>,
    /// Interfaces whose friction is already included in the base response, each with its friction
    /// wrench.
    known: Vec<(usize, Wrench<f64>)>,
}

/// Linear map from the unknown frictions to the wrenches at the joints of the interfaces in the
/// problem.
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

/// Sums those friction wrenches in `all` that act between the gear of the interface `gear` and the
/// load of the gear.
fn friction_behind(model: &Forward, gear: usize, all: &[(usize, Wrench<f64>)]) -> Wrench<f64> {
    let own = all.iter().filter(|(interface, _)| is_behind(&model.parameters, gear, *interface));
    own.fold(Wrench::zero(), |sum, (_, wrench)| sum + *wrench)
}

impl<'a> Members<'a> {
    pub(super) fn new(model: &'a Forward, data: &'a Data, balance: &'a Balance) -> Self {
        let (members, units) = (Vec::new(), Vec::new());
        Self { model, data, balance, members, units, wrenches: Vec::new(), known: Vec::new() }
    }

    /// Declares that the base response already includes the friction wrench of an interface.
    pub(super) fn include(&mut self, interface: usize, wrench: Wrench<f64>) {
        self.known.push((interface, wrench));
    }

    /// Adds an interface to the problem. `wrenches` contains the wrench at the joint of the
    /// interface per unit of each unknown friction of the interface.
    pub(super) fn add(
        &mut self,
        interface: usize,
        law: MemberLaw,
        wrenches: impl IntoIterator<Item = Wrench<f64>>,
    ) {
        let first = self.wrenches.len();
        self.wrenches.extend(wrenches.into_iter().map(|wrench| (interface, wrench)));
        self.members.push(Member { interface, places: first..self.wrenches.len(), law });
    }

    /// Builds the complementarity problem. `base` is the response without the unknown frictions,
    /// and `free` returns the sliding velocities (or accelerations) of an interface in the base
    /// response. `prescribed` contains the rates of the prescribed actuators, which friction does
    /// not change. A friction force changes every other rate by the acceleration that it causes
    /// times `step`.
    pub(super) fn problem(
        &mut self,
        base: &Response,
        step: f64,
        free: impl Fn(usize) -> [f64; 3],
        prescribed: &[f64],
    ) -> Complementarity<'a> {
        let (model, data) = (self.model, self.data);
        let joint = |interface: usize| model.parameters.interfaces[interface].joint;
        let efforts: Vec<_> =
            self.wrenches.iter().map(|(c, wrench)| (joint(*c), *wrench)).collect();
        self.units = self.balance.responses(model, data, &efforts);
        let count = self.units.len();
        let (mut rates, mut compliance) = (vec![0.0; count], vec![0.0; count * count]);
        for member in self.members.iter().filter(|m| !matches!(m.law, MemberLaw::Sliding(_))) {
            let own = free(member.interface);
            for (place, i) in member.places.clone().enumerate() {
                let rate = model.prescribed_rate(member.interface, place, |k| prescribed[k]);
                if let Some(rate) = rate {
                    // Computed rates of a locked actuator are round-off, and the sign of round-off
                    // must not select a direction of slip.
                    rates[i] = rate;
                    continue;
                }
                rates[i] = own[place];
                let rate = model.surface_rates(&data.bodies, member.interface, place);
                for (j, unit) in self.units.iter().enumerate() {
                    compliance[i * count + j] = step * rate(&unit.accelerations);
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
