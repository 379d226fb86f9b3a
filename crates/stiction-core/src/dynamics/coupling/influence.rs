//! Influence of normal loads on joint wrenches, from the responses to unit friction forces.

use super::Acting;
use crate::dynamics::inverse::Inverse;
use crate::dynamics::model::Model;
use crate::dynamics::responses::Responses;
use crate::friction_problem::influence::Influence;
use crate::friction_problem::normal_load::Configuration;
use crate::parameters::Parameters;
use crate::spatial::Wrench;

/// Change of the joint wrenches per newton of normal load at each coupled interface, due to
/// friction. It is computed from stored responses.
pub(super) struct StoredInfluence<'a> {
    pub(super) responses: &'a Responses,
    pub(super) acting: &'a [Acting],
    pub(super) unknowns: &'a [usize],
    pub(super) parameters: &'a Parameters<f64>,
}

impl Influence for StoredInfluence<'_> {
    fn visit(&mut self, mut put: impl FnMut(usize, usize, Wrench<f64>)) {
        let Self { responses, acting, unknowns, parameters } = self;
        for (column, &from) in unknowns.iter().enumerate() {
            let Acting { resistance, parts, .. } = acting[from];
            for (row, &to) in unknowns.iter().enumerate() {
                let joint = parameters.interfaces[to].joint;
                let mut sum = Wrench::zero();
                for (component, part) in responses.components(from).zip(parts) {
                    sum += responses.wrench(component, joint) * (part * resistance.coefficient);
                }
                put(row, column, sum);
            }
        }
    }
}

/// Change of the joint wrenches per newton of normal load at each sliding interface, due to
/// friction. It is evaluated while the responses are computed, so that the responses need not be
/// stored.
pub(super) struct ComputedInfluence<'a> {
    pub(super) responses: &'a mut Responses,
    pub(super) inverse: &'a Inverse<f64>,
    pub(super) model: &'a Model,
    pub(super) at: Configuration<'a>,
    pub(super) unknowns: &'a [usize],
}

impl Influence for ComputedInfluence<'_> {
    fn visit(&mut self, mut put: impl FnMut(usize, usize, Wrench<f64>)) {
        let Self { responses, inverse, model, at, unknowns } = self;
        let Configuration { parameters, bodies } = *at;
        // Components and unknowns are in the order of the interfaces.
        let mut column = 0;
        responses.update(inverse, model, parameters, bodies, false, |_, units, responses| {
            for (lane, unit) in units.iter().enumerate() {
                if unknowns.get(column) != Some(&unit.interface) {
                    continue;
                }
                let coefficient = inverse.interfaces()[unit.interface].resistance.coefficient;
                for (row, &to) in unknowns.iter().enumerate() {
                    let wrench = responses.wrenches[at.joint(to)].lane(lane);
                    put(row, column, wrench * coefficient);
                }
                column += 1;
            }
        });
    }
}
