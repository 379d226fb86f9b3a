//! Everything at one instant: accelerations, reactions, friction, powers.

use super::Forward;
use super::affine_friction::{InterfaceMode, bristle_rate, dot, load, norm};
use super::mass_matrix::{self, MassMatrix};
use super::situation::Situation;
use super::solve::Solved;
use crate::friction::OwnFriction;
use crate::kinematics::{Bodies, State};
use crate::spatial::{Vec3, Wrench};
use crate::statics::AppliedLoad;
use crate::topology::Role;

/// A contact at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InterfaceSample {
    /// What it does.
    pub interface: InterfaceMode,
    /// Sliding velocity at the surface along its freedoms, m/s.
    pub velocity: [f64; 3],
    /// N.
    pub load: f64,
    /// Friction at the surface, with the sense of the sliding that it resists, N.
    pub friction: [f64; 3],
    /// The greatest friction before it slides, N; of a sliding contact that at rest under this load.
    pub limit: f64,
}

impl InterfaceSample {
    /// By how much the limit is above the friction, N.
    pub fn margin(&self) -> f64 {
        self.limit - norm(self.friction)
    }

    /// What it dissipates, W. Where it slides it is speed times friction, as the law says, and not their product
    /// along the freedoms: these are the same where friction is against the sliding, and where it is not the
    /// account of energy shows it.
    pub(super) fn dissipated(&self) -> f64 {
        let along = dot(self.velocity, self.friction);
        match self.interface {
            InterfaceMode::Slides(_) => (norm(self.velocity) * norm(self.friction)).copysign(along),
            _ => along,
        }
    }
}

/// Powers of one instant, W, and energies, J.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Account {
    /// J.
    pub kinetic: f64,
    /// Gravity's (zero at the kernel origin) and springs', J.
    pub potential: f64,
    /// What potential energy grows by, W.
    pub exchange: f64,
    /// Power of each actuator, W.
    pub drives: Vec<f64>,
    /// Power of all loads, W.
    pub loads: f64,
    /// What dampers of springs dissipate, W.
    pub dampers: f64,
    /// What each contact dissipates, W; of bristles what they take up.
    pub interfaces: Vec<f64>,
}

impl Account {
    /// That of bodies which move like this under these efforts of actuators and loads, in the room that is there.
    pub(super) fn update(
        &mut self,
        model: &Forward,
        (masses, loads): (&MassMatrix, &[AppliedLoad<f64>]),
        bodies: &Bodies<f64>,
        efforts: &[f64],
        interfaces: &[InterfaceSample],
    ) {
        let (topology, parameters) = (&model.topology, &model.parameters);
        let Self {
            kinetic,
            potential,
            exchange,
            drives,
            loads: of_loads,
            dampers,
            interfaces: lost,
        } = self;
        *kinetic = masses.kinetic(bodies);
        *potential = mass_matrix::potential(parameters, bodies);
        *exchange = mass_matrix::exchange(parameters, bodies);
        drives.clear();
        let each = topology.actuators.iter().zip(efforts);
        drives.extend(each.map(|(a, effort)| effort * bodies.actuator_rate(topology, *a)));
        *of_loads = mass_matrix::power_of_loads(loads, bodies);
        *dampers = mass_matrix::damped(parameters, bodies);
        lost.clear();
        lost.extend(interfaces.iter().map(InterfaceSample::dissipated));
    }
}

/// Everything at one instant.
#[derive(Clone, Debug)]
pub struct Instant {
    /// s.
    pub time: f64,
    /// Coordinates, rates, accelerations of the tree.
    pub state: State<f64>,
    /// Motion of all bodies, about the kernel origin.
    pub bodies: Bodies<f64>,
    /// Efforts of all actuators, N or N m.
    pub drives: Vec<f64>,
    /// For each joint the complete wrench that the predecessor exerts on the successor, world axes
    /// about the kernel origin.
    pub wrenches: Vec<Wrench<f64>>,
    /// All contacts.
    pub interfaces: Vec<InterfaceSample>,
    /// Rates of the deflections of bristles, m/s.
    pub(super) bristle_rates: Vec<[f64; 3]>,
    /// Energies and powers.
    pub account: Account,
    /// How strongly friction and reactions are coupled: below one there is no other solution. Only
    /// where it was asked for.
    pub coupling: Option<f64>,
    /// How many constraints, held freedoms among them, are redundant.
    pub redundant: usize,
    /// How many efforts of what is prescribed or locked are open: more are than it takes. Their sum of squares is
    /// least, rotary ones over the characteristic length.
    pub open_drives: usize,
    /// Degrees of freedom left.
    pub mobility: usize,
    /// How far the conditions are from being dependent: loops at a singular position.
    pub(super) distance: f64,
    /// A contact that sticks where its joint only stands for this instant, and must move an instant later.
    pub(super) gives_way: Option<usize>,
}

impl Instant {
    /// What is no number in it, if anything is.
    pub(super) fn unfinite(&self) -> Option<&'static str> {
        if !self.state.accelerations.iter().all(|a| a.is_finite()) {
            return Some("an acceleration");
        }
        // Magnitudes are told, too: squares must not be infinite.
        let is_finite = |w: &Wrench<f64>| [w.force, w.moment].iter().all(|v| v.dot(*v).is_finite());
        (!self.wrenches.iter().all(is_finite)).then_some("a reaction")
    }

    /// Room for an instant.
    pub(super) fn new(model: &Forward) -> Self {
        let topology = &model.topology;
        Self {
            time: 0.0,
            state: State::new(topology),
            bodies: Bodies::new(topology),
            drives: Vec::new(),
            wrenches: Vec::new(),
            interfaces: Vec::new(),
            bristle_rates: Vec::new(),
            account: Account::default(),
            coupling: None,
            redundant: 0,
            mobility: 0,
            distance: 0.0,
            open_drives: 0,
            gives_way: None,
        }
    }

    /// Force and moment, about the joint's origin (that of J), of each joint's complete wrench.
    pub fn reactions(&self) -> Vec<(Vec3<f64>, Vec3<f64>)> {
        let each = self.wrenches.iter().zip(&self.bodies.frame_j);
        each.map(|(w, j)| (w.force, w.moment_about(j.position))).collect()
    }
}

impl Forward {
    /// The friction at the surface and the load of each contact of a solved choice.
    pub(super) fn interfaces(
        &self,
        situation: &Situation,
        modes: &[InterfaceMode],
        solved: &Solved,
    ) -> Vec<InterfaceSample> {
        let mut interfaces = Vec::with_capacity(modes.len());
        self.interfaces_into(situation, modes, solved, &mut interfaces);
        interfaces
    }

    /// The same in the room that is there.
    fn interfaces_into(
        &self,
        situation: &Situation,
        modes: &[InterfaceMode],
        solved: &Solved,
        interfaces: &mut Vec<InterfaceSample>,
    ) {
        let parameters = &self.parameters;
        interfaces.clear();
        for (index, interface) in parameters.interfaces.iter().enumerate() {
            let arms = interface.arms(parameters.pitch[interface.joint]);
            let mut load_now = solved.coupled.loads[index];
            let mut friction = [0.0; 3];
            if modes[index] == InterfaceMode::Sticks {
                for &(of, place, row) in &solved.holding {
                    if of == index {
                        let first = self.topology.constraints;
                        let effort = solved.coupled.response.multipliers[first + row];
                        friction[place] = -effort / arms[place];
                    }
                }
                let own = OwnFriction {
                    coefficient: 0.0,
                    constant: friction[0].abs(),
                    direction: friction[0].signum(),
                };
                let wrench = solved.coupled.response.wrenches[interface.joint];
                load_now = load(parameters, &situation.bodies, interface, own, wrench).value;
            } else {
                let rub = &solved.affine_frictions[index];
                for place in 0..interface.shape.dofs().len() {
                    let effort = rub.known[place] + rub.per_load[place] * load_now;
                    friction[place] = effort / arms[place];
                }
            }
            let limit = interface.law_towards(friction[0]).at_rest() * load_now;
            let (mut velocity, mode) = (situation.velocities[index], modes[index]);
            if mode == InterfaceMode::Sticks && self.leaders(index).is_none() {
                // What others that stick leave of it is rounding.
                velocity = [0.0; 3];
            }
            interfaces.push(InterfaceSample {
                interface: mode,
                velocity,
                load: load_now,
                friction,
                limit,
            });
        }
    }

    /// Everything of a solved choice.
    pub(super) fn instant(
        &self,
        situation: Situation,
        modes: &[InterfaceMode],
        solved: &Solved,
    ) -> Instant {
        let mut instant = Instant::new(self);
        self.instant_into(&situation, modes, solved, &mut instant);
        instant
    }

    /// The same in the room that is there.
    pub(super) fn instant_into(
        &self,
        situation: &Situation,
        modes: &[InterfaceMode],
        solved: &Solved,
        instant: &mut Instant,
    ) {
        let topology = &self.topology;
        let Situation { efforts, loads, masses, .. } = situation;
        let Instant { state, bodies, drives, wrenches, interfaces, bristle_rates, account, .. } =
            instant;
        self.interfaces_into(situation, modes, solved, interfaces);
        state.clone_from(&situation.state);
        bodies.clone_from(&situation.bodies);
        let response = &solved.coupled.response;
        state.accelerations.clone_from(&response.accelerations);
        for held in &solved.held {
            if let Role::Tree { node } = topology.role[held.joint] {
                // Not to rounding, but exactly: what is held does not drift.
                let tree_dof = topology.nodes[node].tree_dofs.start + held.dof;
                state.accelerations[tree_dof] = held.acceleration;
            }
        }
        bodies.accelerate(topology, &state.accelerations);
        drives.clone_from(efforts);
        for (k, &actuator) in self.prescribed.iter().enumerate() {
            drives[actuator] = response.multipliers[topology.constraints + k];
        }
        account.update(self, (masses, loads), bodies, drives, interfaces);
        bristle_rates.clear();
        let each = self.parameters.interfaces.iter().zip(&*interfaces).zip(&situation.bristles);
        bristle_rates
            .extend(each.map(|((interface, now), z)| bristle_rate(interface, now.velocity, *z)));
        wrenches.clone_from(&response.wrenches);
        instant.time = situation.time;
        instant.coupling = solved.strength;
        instant.redundant = solved.balance.spread.stresses.len();
        instant.open_drives = solved.balance.spread.open_drives();
        instant.mobility = solved.balance.mobility(topology.dofs());
        instant.distance = solved.balance.distance();
        instant.gives_way = self.gives_way(situation, solved).map(|(interface, _)| interface);
    }
}
