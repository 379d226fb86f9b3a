//! Friction and reactions together, with accelerations unknown.
//!
//! Unknown are the loads `N` of the contacts. All wrenches are affine in them, with the accelerations
//! that they cause, so `N = load(wrench(N))` is a small system for Newton's method.
//!
//! Equation (D3) of the book's theory.

mod fours;
mod solution;
mod uniqueness;

pub(super) use solution::Lost;

use super::affine_friction::{AffineFriction, load};
use super::balance::{Balance, Four, Response, Scene, Scratch};
use crate::friction::Load;
use crate::scalar::Scalar;
use crate::spatial::{Vec3, Wrench};
use fours::blocks_of;
use solution::Room;

/// Accelerations and reactions with friction.
#[derive(Clone, Debug, Default)]
pub(super) struct Coupled {
    pub(super) response: Response,
    /// Of each contact, N.
    pub(super) loads: Vec<f64>,
}

/// The affine dependence on the loads.
#[derive(Clone, Debug, Default)]
pub(super) struct Coupling {
    /// Efforts that do not depend on loads.
    known: Vec<(usize, Wrench<f64>)>,
    /// The response to these.
    base: Response,
    /// Contacts whose load matters.
    active: Vec<usize>,
    /// What one newton of their loads exerts.
    units: Vec<(usize, Wrench<f64>)>,
    /// For each of them the six components of its joint's wrench, force first, by one newton of each load; four loads
    /// to a block, the last filled up with zeros.
    influence: Vec<Four>,
    one: Response,
    all: Vec<(usize, Wrench<f64>)>,
    room: Room,
}

/// What the coupling is about.
#[derive(Clone, Copy)]
pub(super) struct Site<'a> {
    pub(super) scene: Scene<'a>,
    pub(super) affine_frictions: &'a [AffineFriction],
}

impl Site<'_> {
    fn load(&self, interface: usize, wrench: Wrench<f64>) -> Load<f64> {
        let Scene { parameters, bodies, .. } = self.scene;
        load(
            parameters,
            bodies,
            &parameters.interfaces[interface],
            self.affine_frictions[interface].own,
            wrench,
        )
    }

    fn joint(&self, interface: usize) -> usize {
        self.scene.parameters.interfaces[interface].joint
    }

    fn against(&self, interface: usize, part: [f64; 3]) -> (usize, Wrench<f64>) {
        let Scene { topology, parameters, bodies, .. } = self.scene;
        let content = &parameters.interfaces[interface];
        (content.joint, bodies.wrench_of(topology, content, part.map(|x| -x)))
    }
}

impl Coupling {
    /// Makes it anew; `efforts` are those of drives.
    pub(super) fn update(
        &mut self,
        site: Site<'_>,
        balance: &Balance,
        efforts: &[(usize, Wrench<f64>)],
        scratch: &mut Scratch,
    ) {
        let Self { known, base, active, units, .. } = self;
        known.clear();
        known.extend_from_slice(efforts);
        active.clear();
        units.clear();
        for (interface, rub) in site.affine_frictions.iter().enumerate() {
            if rub.known != [0.0; 3] {
                known.push(site.against(interface, rub.known));
            }
            if rub.per_load != [0.0; 3] {
                units.push(site.against(interface, rub.per_load));
                active.push(interface);
            }
        }
        balance.respond_into(&site.scene, known, true, scratch, base);
        let width = blocks_of(self.active.len());
        self.influence.clear();
        self.influence.resize(6 * self.active.len() * width, Four::zero());
        if !balance.spread.stresses.is_empty() {
            for l in 0..self.active.len() {
                let unit = [self.units[l]];
                balance.respond_into(&site.scene, &unit, false, scratch, &mut self.one);
                let Self { one, influence, .. } = self;
                note(site, &self.active, l, influence, |joint| one.wrenches[joint]);
            }
            return;
        }
        for (k, four) in self.units.chunks(4).enumerate() {
            let wrenches = balance.respond_to_four(&site.scene, four, scratch);
            for lane in 0..four.len() {
                note(site, &self.active, 4 * k + lane, &mut self.influence, |joint| {
                    let Wrench { force, moment } = wrenches[joint];
                    let of = |v: Vec3<Four>| Vec3::new(v.x.0[lane], v.y.0[lane], v.z.0[lane]);
                    Wrench { force: of(force), moment: of(moment) }
                });
            }
        }
    }

    /// The components of the wrench of the `k`-th contact's joint by each load.
    fn of_joint(&self, k: usize) -> impl Iterator<Item = &[Four]> {
        let width = blocks_of(self.active.len());
        self.influence[6 * width * k..6 * width * (k + 1)].chunks_exact(width)
    }

    /// What the joint of the `k`-th of these contacts bears where their loads are a part of these.
    fn wrench(&self, site: Site<'_>, k: usize, loads: &[Four], part: f64) -> Wrench<f64> {
        let mut sums = [0.0; 6];
        for (sum, row) in sums.iter_mut().zip(self.of_joint(k)) {
            let mut lanes = Four::zero();
            row.iter().zip(loads).for_each(|(u, load)| lanes += *u * *load);
            let [a, b, c, d] = lanes.0;
            *sum = part * ((a + b) + (c + d));
        }
        let [force, moment] = [0, 3].map(|i| Vec3::new(sums[i], sums[i + 1], sums[i + 2]));
        self.base.wrenches[site.joint(self.active[k])] + Wrench { force, moment }
    }

    /// Loads where friction that grows with them is left out.
    fn frictionless_loads(&self, site: Site<'_>, loads: &mut Vec<f64>) {
        loads.clear();
        loads.extend(self.active.iter().map(|&interface| {
            site.load(interface, self.base.wrenches[site.joint(interface)]).value
        }));
    }

    /// Accelerations and reactions from loads of the active contacts.
    fn complete(
        &mut self,
        site: Site<'_>,
        balance: &Balance,
        loads: &[f64],
        scratch: &mut Scratch,
        coupled: &mut Coupled,
    ) {
        let Coupled { response, loads: found } = coupled;
        if self.active.is_empty() {
            response.clone_from(&self.base);
        } else {
            self.all.clone_from(&self.known);
            let units = self.units.iter().zip(loads);
            self.all.extend(units.map(|(&(joint, unit), load)| (joint, unit * *load)));
            balance.respond_into(&site.scene, &self.all, true, scratch, response);
        }
        found.clear();
        let mut active = self.active.iter().zip(loads).peekable();
        for interface in 0..site.affine_frictions.len() {
            found.push(match active.next_if(|(next, _)| **next == interface) {
                Some((_, load)) => *load,
                None => site.load(interface, response.wrenches[site.joint(interface)]).value,
            });
        }
    }
}

/// Writes down what one newton of the `l`-th load does to the joints of all.
fn note(
    site: Site<'_>,
    active: &[usize],
    l: usize,
    influence: &mut [Four],
    wrench: impl Fn(usize) -> Wrench<f64>,
) {
    let width = blocks_of(active.len());
    for (of_joint, &interface) in influence.chunks_exact_mut(6 * width).zip(active) {
        let Wrench { force, moment } = wrench(site.joint(interface));
        let components = [force.x, force.y, force.z, moment.x, moment.y, moment.z];
        for (row, component) in of_joint.chunks_exact_mut(width).zip(components) {
            row[l / 4].0[l % 4] = component;
        }
    }
}
