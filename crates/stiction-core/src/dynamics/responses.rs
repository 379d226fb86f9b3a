//! Changes of all forces per newton of each friction component, from one factorisation of the
//! frictionless balance.

use super::balance::{Balance, Four, LaneWorkspace, UnitFriction, UnitResponses, WIDTH};
use super::inverse::Inverse;
use super::model::Model;
use crate::kinematics::{Bodies, Results};
use crate::parameters::Parameters;
use crate::scalar::{Lanes, Scalar};
use crate::spatial::{Twist, Vec3, Wrench};
use core::ops::Range;

/// Changes of all forces per newton of each friction component, at one configuration. A sliding
/// interface has one component, the friction that opposes its sliding. An interface at rest has one
/// component for each of its DOFs, which is positive if it opposes a positive sliding velocity.
#[derive(Clone, Debug, Default)]
pub(super) struct Responses {
    balance: Option<Balance<f64>>,
    units: Vec<UnitFriction>,
    /// Range of the friction components of each interface.
    of: Vec<Range<usize>>,
    workspace: LaneWorkspace,
    /// Numbers of joints, actuators and local degrees of freedom.
    counts: [usize; 3],
    /// Changes of the joint wrenches per newton of each friction component, in blocks of four
    /// components. Empty unless [`Self::update`] stores them.
    wrenches: Vec<Wrench<Four>>,
    /// Changes of the efforts, and of the accelerations of local degrees of freedom, per newton of
    /// each friction component, in blocks of four components.
    efforts: Vec<Four>,
    spins: Vec<Four>,
}

impl Responses {
    /// Lists the friction components for the sliding directions in `inverse`. Factorises the
    /// frictionless balance at the configuration of `inverse`.
    fn begin(
        &mut self,
        inverse: &Inverse<f64>,
        model: &Model,
        parameters: &Parameters<f64>,
        bodies: &Bodies<f64>,
    ) {
        self.units.clear();
        self.of.clear();
        for (interface, content) in parameters.interfaces.iter().enumerate() {
            let first = self.units.len();
            let state = &inverse.interfaces()[interface];
            let unit = |against| UnitFriction { interface, against };
            if state.sliding > 0.0 {
                self.units.push(unit(state.against));
            } else {
                let arms = content.arms(parameters.pitch[content.joint]);
                self.units.extend((0..content.shape.dofs().len()).map(|dof| {
                    let mut against = [0.0; 3];
                    against[dof] = -arms[dof];
                    unit(against)
                }));
            }
            self.of.push(first..self.units.len());
        }
        let topology = model.topology();
        self.counts = [
            topology.joint_types.len(),
            topology.actuators.len(),
            model.constraints().spins().len(),
        ];
        self.wrenches.clear();
        self.efforts.clear();
        self.spins.clear();
        let balance = match &mut self.balance {
            Some(balance) if balance.fits(inverse.balance()) => balance,
            other => other.insert(inverse.balance().clone()),
        };
        balance.factor_frictionless(inverse.balance(), &model.balance, parameters, bodies);
    }

    /// Reads the responses from the results of a recorded program, in the order in which
    /// [`force_results`](super::program::force_results) writes them. All interfaces must slide.
    pub(super) fn read(
        &mut self,
        inverse: &Inverse<f64>,
        model: &Model,
        numbers: &mut Results<'_>,
    ) {
        let topology = model.topology();
        let (joints, actuators) = (topology.joint_types.len(), topology.actuators.len());
        self.counts = [joints, actuators, 0];
        self.units.clear();
        self.of.clear();
        for (interface, state) in inverse.interfaces().iter().enumerate() {
            self.units.push(UnitFriction { interface, against: state.against });
            self.of.push(interface..interface + 1);
        }
        let blocks = self.units.len().div_ceil(WIDTH);
        self.spins.clear();
        self.wrenches.resize(blocks * joints, Wrench::zero());
        self.efforts.resize(blocks * actuators, Four::zero());
        for wrench in &mut self.wrenches {
            let mut next = || Lanes(numbers.next());
            let mut vector = || Vec3::new(next(), next(), next());
            *wrench = Wrench { force: vector(), moment: vector() };
        }
        self.efforts.iter_mut().for_each(|effort| *effort = Lanes(numbers.next()));
    }

    /// Computes the changes of all forces per newton of each friction component. Calls `take` for
    /// each block of four components, with the index of the block, the components and the changes.
    /// If `store` is true, also stores the changes of the joint wrenches.
    pub(super) fn update(
        &mut self,
        inverse: &Inverse<f64>,
        model: &Model,
        parameters: &Parameters<f64>,
        bodies: &Bodies<f64>,
        store: bool,
        mut take: impl FnMut(usize, &[UnitFriction], &UnitResponses),
    ) {
        self.begin(inverse, model, parameters, bodies);
        let Self { balance, units, workspace, wrenches, efforts, spins, .. } = self;
        let Some(balance) = balance else { return };
        let plan = &*model.balance;
        let mut blocks = units.chunks(WIDTH).enumerate();
        balance.respond(plan, parameters, bodies, units, workspace, |responses| {
            if store {
                wrenches.extend_from_slice(&responses.wrenches);
            }
            efforts.extend_from_slice(&responses.efforts);
            spins.extend_from_slice(&responses.spins);
            if let Some((block, units)) = blocks.next() {
                take(block, units, responses);
            }
        });
    }

    /// Computes the changes of all joint wrenches if a body requires a wrench in addition, without
    /// friction, at the configuration of the last call of [`Self::update`].
    pub(super) fn under_demand(
        &mut self,
        model: &Model,
        parameters: &Parameters<f64>,
        bodies: &Bodies<f64>,
        demand: (usize, Wrench<f64>),
    ) -> &[Wrench<f64>] {
        let Some(balance) = &mut self.balance else { return &[] };
        let plan = &*model.balance;
        balance.apply_demand_alone(plan, parameters, bodies, demand, plan.passes());
        &balance.joint_wrenches
    }

    /// Returns the number of friction components.
    pub(super) fn len(&self) -> usize {
        self.units.len()
    }

    /// Returns the index range of the friction components of an interface.
    pub(super) fn components(&self, interface: usize) -> Range<usize> {
        self.of[interface].clone()
    }

    /// Returns the index of the interface to which a friction component belongs.
    pub(super) fn interface(&self, component: usize) -> usize {
        self.units[component].interface
    }

    /// Returns the change of the wrench of a joint per newton of each component in a block of four
    /// components. Requires stored wrenches.
    pub(super) fn block(&self, block: usize, joint: usize) -> &Wrench<Four> {
        &self.wrenches[block * self.counts[0] + joint]
    }

    /// Returns the change of the wrench of a joint per newton of a component. Requires stored
    /// wrenches.
    pub(super) fn wrench(&self, component: usize, joint: usize) -> Wrench<f64> {
        self.block(component / WIDTH, joint).lane(component % WIDTH)
    }

    /// Adds the changes of all joint wrenches due to the friction forces `amounts` (N, one per
    /// component, in blocks of four). Requires stored wrenches.
    pub(super) fn add_to(&self, wrenches: &mut [Wrench<f64>], amounts: &[Four]) {
        if is_zero(amounts) {
            return;
        }
        for (joint, wrench) in wrenches.iter_mut().enumerate() {
            *wrench += self.change(joint, amounts);
        }
    }

    /// Adds the change of the wrench of one joint due to the friction forces `amounts`, as
    /// [`Self::add_to`]. Requires stored wrenches.
    pub(super) fn add_at(&self, joint: usize, wrench: &mut Wrench<f64>, amounts: &[Four]) {
        if !is_zero(amounts) {
            *wrench += self.change(joint, amounts);
        }
    }

    /// Returns the change of the wrench of a joint due to the friction forces `amounts`.
    fn change(&self, joint: usize, amounts: &[Four]) -> Wrench<f64> {
        let mut change = Wrench::zero();
        let blocks = self.wrenches[joint..].iter().step_by(self.counts[0]);
        for (block, amounts) in blocks.zip(amounts) {
            change += *block * *amounts;
        }
        let [x, y, z] = change.force.to_array().map(sum);
        let [u, v, w] = change.moment.to_array().map(sum);
        Wrench { force: Vec3::new(x, y, z), moment: Vec3::new(u, v, w) }
    }

    /// Computes, for each friction component, the power of the change of the joint wrenches per
    /// newton of this component, summed over all joints. `twists` contains the twist of each joint.
    /// The results are in blocks of four components. Requires stored wrenches.
    pub(super) fn powers(&self, twists: &[Twist<f64>], powers: &mut Vec<Four>) {
        powers.clear();
        let blocks = self.wrenches.chunks_exact(twists.len().max(1));
        powers.extend(blocks.map(|wrenches| {
            let mut sum = Four::zero();
            for (twist, wrench) in twists.iter().zip(wrenches) {
                sum += twist.lift::<Four>().power(*wrench);
            }
            sum
        }));
    }

    /// Returns the change of an effort per newton of a component.
    pub(super) fn effort(&self, component: usize, actuator: usize) -> f64 {
        let block = component / WIDTH * self.counts[1];
        self.efforts[block + actuator].0[component % WIDTH]
    }

    /// Returns the change of the acceleration of a local degree of freedom per newton of a
    /// component.
    pub(super) fn spin(&self, component: usize, spin: usize) -> f64 {
        let block = component / WIDTH * self.counts[2];
        self.spins[block + spin].0[component % WIDTH]
    }
}

/// Blocks of friction components that change the wrench at each friction interface, and the blocks
/// of the components of this interface. All other responses are exactly zero. In mechanisms with
/// many bodies, most friction forces do not load most joints, so that computations that skip zero
/// responses take less time.
#[derive(Clone, Debug)]
pub(super) struct Influences {
    /// Index of the first entry of each interface in `blocks`, followed by the number of entries.
    starts: Vec<usize>,
    blocks: Vec<usize>,
}

impl Influences {
    /// Finds the nonzero blocks in `responses`, which must contain wrenches.
    pub(super) fn new(responses: &Responses, parameters: &Parameters<f64>) -> Self {
        let count = responses.len().div_ceil(WIDTH);
        let (mut starts, mut blocks) = (vec![0], Vec::new());
        for (interface, content) in parameters.interfaces.iter().enumerate() {
            let Range { start, end } = responses.components(interface);
            let acts = |&block: &usize| {
                (start / WIDTH..end.div_ceil(WIDTH)).contains(&block)
                    || !is_zero_wrench(responses.block(block, content.joint))
            };
            blocks.extend((0..count).filter(acts));
            starts.push(blocks.len());
        }
        Self { starts, blocks }
    }

    /// Returns the blocks that change the wrench at an interface, in ascending order.
    pub(super) fn at(&self, interface: usize) -> &[usize] {
        &self.blocks[self.starts[interface]..self.starts[interface + 1]]
    }
}

fn is_zero_wrench(Wrench { force, moment }: &Wrench<Four>) -> bool {
    is_zero(&[force.x, force.y, force.z, moment.x, moment.y, moment.z])
}

/// Returns true if all numbers are zero.
fn is_zero(amounts: &[Four]) -> bool {
    amounts.iter().all(|amounts| amounts.0 == [0.0; WIDTH])
}

/// Returns the sum of the four lanes.
fn sum(lanes: Four) -> f64 {
    let [a, b, c, d] = lanes.0;
    (a + b) + (c + d)
}
