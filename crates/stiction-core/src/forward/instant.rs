//! Results of a simulation at one instant: accelerations, reactions, friction, powers.

use super::Forward;
use super::affine_friction::{InterfaceMode, bristle_rate, dot, norm};
use super::balance::Response;
use super::constraint_jacobian::StickingDof;
use super::data::Data;
use super::mass_matrix::{self, MassMatrix};
use super::solve::Solved;
use super::transmitted::LoadSide;
use crate::friction::OwnFriction;
use crate::kinematics::{Bodies, State};
use crate::spatial::{Vec3, Wrench};
use crate::statics::AppliedLoad;
use crate::topology::Role;

/// State of a friction interface at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InterfaceSample {
    /// Mode of the interface: stick, slip, or a smooth law.
    pub interface: InterfaceMode,
    /// Sliding velocity at the surface along each DOF of the interface, m/s.
    pub velocity: [f64; 3],
    /// Normal load, N.
    pub load: f64,
    /// Friction force at the surface along each DOF of the interface, N, with the sign of the
    /// sliding velocity that it opposes.
    pub friction: [f64; 3],
    /// Static friction limit under the normal load `load`, N.
    pub limit: f64,
}

impl InterfaceSample {
    /// Returns the margin to slip, N: the static friction limit minus the magnitude of the
    /// friction.
    pub fn margin(&self) -> f64 {
        self.limit - norm(self.friction)
    }

    /// Returns the dissipated power, W. During slip the power is computed as sliding speed times
    /// friction magnitude, not as the scalar product of velocity and friction. The energy balance
    /// therefore reveals any friction that does not oppose the slip.
    pub(super) fn dissipated(&self) -> f64 {
        let along = dot(self.velocity, self.friction);
        match self.interface {
            InterfaceMode::Slides(_) => (norm(self.velocity) * norm(self.friction)).copysign(along),
            _ => along,
        }
    }
}

/// Powers, W, and energies, J, at an instant.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Account {
    /// Kinetic energy, J.
    pub kinetic: f64,
    /// Potential energy of gravity (zero at the reference point) and springs, J.
    pub potential: f64,
    /// Rate of change of the potential energy, W.
    pub exchange: f64,
    /// Power of each actuator, W.
    pub drives: Vec<f64>,
    /// Power of all loads, W.
    pub loads: f64,
    /// Power dissipated by the dampers of springs, W.
    pub dampers: f64,
    /// Power dissipated by each interface, W. For laws with bristles, this power includes the rate
    /// of the energy that the bristles store.
    pub interfaces: Vec<f64>,
}

impl Forward {
    /// Computes the mechanical energy (kinetic plus potential) at a state, J.
    pub(super) fn energy(&self, state: &State<f64>) -> f64 {
        let (topology, parameters) = (&*self.topology, &self.parameters);
        let mut bodies = Bodies::new(topology);
        bodies.place(topology, parameters, &state.coordinates);
        bodies.move_with(topology, &state.rates);
        let masses = MassMatrix::new(topology, (parameters, &self.rotors), &mut bodies, &[]);
        masses.kinetic(&bodies) + mass_matrix::potential(parameters, &bodies)
    }
}

impl Account {
    /// Computes all powers and energies. Poses and twists of `bodies` must be up to date.
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

/// Results of a simulation at one instant.
#[derive(Clone, Debug)]
pub struct Instant {
    /// Time, s.
    pub time: f64,
    /// Coordinates, rates and accelerations of the spanning tree.
    pub state: State<f64>,
    /// Poses, twists and accelerations of all bodies, about the reference point.
    pub bodies: Bodies<f64>,
    /// Efforts of all actuators, N or N m.
    pub drives: Vec<f64>,
    /// Effort of each gearing, N m; N if the gearing sums lengths, see
    /// [`Gearing`](crate::mechanism::Gearing).
    pub gearings: Vec<f64>,
    /// Complete wrench of each joint, exerted by the predecessor on the successor, about the
    /// reference point in world axes. The joints of motor shafts that the model adds come last.
    pub wrenches: Vec<Wrench<f64>>,
    /// State of each friction interface.
    pub interfaces: Vec<InterfaceSample>,
    /// Rates of the bristle deflections, m/s.
    pub(super) bristle_rates: Vec<[f64; 3]>,
    /// Rates of the internal states of the inputs, per second.
    pub(super) input_rates: Vec<f64>,
    /// Energies and powers.
    pub account: Account,
    /// Uniqueness bound, if computed here or shortly before. If the bound is below one, no other normal loads satisfy the
    /// friction laws in the present modes.
    pub coupling: Option<f64>,
    /// Number of redundant constraints, including the constraints of sticking DOFs.
    pub redundant: usize,
    /// Number of actuator efforts that are statically indeterminate because more DOFs are
    /// prescribed or locked than the mechanism has. The simulation selects the efforts with the
    /// least sum of squares, with torques divided by the characteristic length.
    pub open_drives: usize,
    /// Mobility: number of DOFs left by the constraints.
    pub mobility: usize,
    /// Singularity index of the constraints, between zero and one. The index tends to zero as the
    /// mechanism approaches a singular configuration of the loops.
    pub(super) distance: f64,
    /// Index of a sticking interface that must begin to slip, because its joint is at rest only at
    /// this instant. `None` if no interface must begin to slip.
    pub(super) gives_way: Option<usize>,
    /// Number of joints of the mechanism, excluding motor shafts that the model adds.
    pub(super) joints: usize,
}

impl Instant {
    /// Returns a description of a quantity that is not finite; `None` if all quantities are finite.
    pub(super) fn nonfinite(&self) -> Option<&'static str> {
        if !self.drives.iter().all(|effort| effort.is_finite()) {
            return Some("the effort of an actuator");
        }
        if !self.state.accelerations.iter().all(|a| a.is_finite()) {
            return Some("an acceleration");
        }
        // Results include magnitudes of vectors, so the squared magnitudes must be finite as well.
        let is_finite = |w: &Wrench<f64>| [w.force, w.moment].iter().all(|v| v.dot(*v).is_finite());
        (!self.wrenches.iter().all(is_finite)).then_some("a reaction")
    }

    /// Allocates the results of a model, with all values zero.
    pub(super) fn new(model: &Forward) -> Self {
        let topology = &model.topology;
        Self {
            time: 0.0,
            state: State::new(topology),
            bodies: Bodies::new(topology),
            drives: Vec::new(),
            gearings: Vec::new(),
            wrenches: Vec::new(),
            interfaces: Vec::new(),
            bristle_rates: Vec::new(),
            input_rates: Vec::new(),
            account: Account::default(),
            coupling: None,
            redundant: 0,
            mobility: 0,
            distance: 0.0,
            open_drives: 0,
            gives_way: None,
            joints: model.mechanism.joints().len(),
        }
    }

    /// Returns the force, N, and the moment about the origin of frame J, N m, of the complete
    /// wrench of each joint, in world axes.
    pub fn reactions(&self) -> Vec<(Vec3<f64>, Vec3<f64>)> {
        let each = self.wrenches.iter().zip(&self.bodies.frame_j).take(self.joints);
        each.map(|(w, j)| (w.force, w.moment_about(j.position))).collect()
    }
}

impl Forward {
    /// Writes the friction and normal load of each interface for a solution, reusing the buffer.
    pub(super) fn interfaces_into(
        &self,
        data: &Data,
        modes: &[InterfaceMode],
        solved: &Solved,
        interfaces: &mut Vec<InterfaceSample>,
    ) {
        let parameters = &self.parameters;
        interfaces.clear();
        for (index, interface) in parameters.interfaces.iter().enumerate() {
            let arms = interface.arms(parameters.pitch[interface.joint]);
            let mut load = solved.coupled.loads[index];
            let mut friction = [0.0; 3];
            if modes[index] == InterfaceMode::Sticks {
                // The list of sticking DOFs is sorted by interface.
                let first = solved.sticking.partition_point(|dof| dof.interface < index);
                let own = solved.sticking[first..].iter();
                for &StickingDof { place, row, .. } in own.take_while(|dof| dof.interface == index)
                {
                    let row = self.topology.closures() + row;
                    friction[place] = -solved.coupled.response.multipliers[row] / arms[place];
                }
                let wrench = solved.coupled.response.wrenches[interface.joint]
                    - self.friction_behind(index, data, solved);
                let own = OwnFriction::of(friction[0]);
                load = self.configuration(data).normal_load(index, wrench, own).value;
            } else {
                friction = solved.frictions[index].at_surface(arms, load);
            }
            let limit = interface.law_towards(friction[0]).at_rest() * load;
            let (mut velocity, mode) = (data.velocities[index], modes[index]);
            if mode == InterfaceMode::Sticks && !self.is_prescribed_interface(index) {
                // The remaining velocity, due to other sticking interfaces, is round-off.
                velocity = [0.0; 3];
            }
            interfaces.push(InterfaceSample { interface: mode, velocity, load, friction, limit });
        }
    }

    /// Returns the effort of each gearing of the mechanism, N m or N, from the multipliers of a
    /// solution.
    pub(super) fn gearing_efforts<'a>(
        &'a self,
        response: &'a Response,
    ) -> impl Iterator<Item = f64> + 'a {
        let multipliers = &response.multipliers[self.topology.constraints..];
        let each = multipliers.iter().zip(&self.parameters.gearings).map(|(m, own)| m / own.size);
        each.take(self.mechanism.gearings().len())
    }

    /// Returns the sum of the wrenches of frictions and gearings that act between the gear of an
    /// interface and the load of this gear, for a solution.
    pub(super) fn friction_behind(&self, gear: usize, data: &Data, solved: &Solved) -> Wrench<f64> {
        let (rows, bodies) = (&solved.balance.rows.rows[..], &data.bodies);
        let side = LoadSide { model: self, bodies, sticking: &solved.sticking, rows };
        let mut sum = side.held(gear, &solved.coupled.response.multipliers);
        for other in side.behind(gear) {
            // The friction of a sticking interface is a multiplier and is part of the result of
            // `held`.
            let (friction, load) = (&solved.frictions[other], solved.coupled.loads[other]);
            let effort = [0, 1, 2].map(|i| -friction.constant[i] - friction.per_load[i] * load);
            if effort != [0.0; 3] {
                let content = &self.parameters.interfaces[other];
                sum += data.bodies.wrench_of(&self.topology, content, effort);
            }
        }
        sum
    }

    /// Returns the results at one instant from a solution of the equations of motion.
    pub(super) fn instant(&self, data: &Data, modes: &[InterfaceMode], solved: &Solved) -> Instant {
        let mut instant = Instant::new(self);
        self.instant_into(data, modes, solved, &mut instant);
        instant
    }

    /// Writes the results at one instant from a solution of the equations of motion, reusing the
    /// buffers.
    pub(super) fn instant_into(
        &self,
        data: &Data,
        modes: &[InterfaceMode],
        solved: &Solved,
        instant: &mut Instant,
    ) {
        let topology = &self.topology;
        let Data { efforts, loads, masses, .. } = data;
        let Instant {
            state,
            bodies,
            drives,
            gearings,
            wrenches,
            interfaces,
            bristle_rates,
            input_rates,
            account,
            ..
        } = instant;
        self.interfaces_into(data, modes, solved, interfaces);
        state.clone_from(&data.state);
        bodies.clone_from(&data.bodies);
        let response = &solved.coupled.response;
        state.accelerations.clone_from(&response.accelerations);
        for constrained in &solved.constrained {
            if let Role::Tree { node } = topology.role[constrained.joint] {
                // Assigned exactly, because constrained DOFs must not drift by round-off.
                let tree_dof = topology.nodes[node].tree_dofs.start + constrained.dof;
                state.accelerations[tree_dof] = constrained.acceleration;
            }
        }
        bodies.accelerate(topology, &state.accelerations);
        drives.clone_from(efforts);
        for (k, &actuator) in self.prescribed.iter().enumerate() {
            drives[actuator] = response.multipliers[topology.closures() + k];
        }
        gearings.clear();
        gearings.extend(self.gearing_efforts(response));
        account.update(self, (masses, loads), bodies, drives, interfaces);
        bristle_rates.clear();
        let each = self.parameters.interfaces.iter().zip(&*interfaces).zip(&data.bristles);
        bristle_rates
            .extend(each.map(|((interface, now), z)| bristle_rate(interface, now.velocity, *z)));
        input_rates.clone_from(&data.input_rates);
        wrenches.clone_from(&response.wrenches);
        instant.time = data.time;
        instant.coupling = solved.coupling_bound;
        instant.redundant = solved.balance.redundant();
        instant.open_drives = solved.balance.redundancy.open_efforts();
        instant.mobility = solved.balance.mobility(topology.dofs());
        instant.distance = solved.balance.distance();
        instant.gives_way = self.instantaneous_lock(data, solved).map(|(interface, _)| interface);
    }
}
