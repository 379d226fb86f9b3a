//! Recorded program in place of the general solver, at states in which all interfaces slide.

use super::Forward;
use super::affine_friction::{InterfaceMode, dot, norm};
use super::data::Data;
use super::instant::{Instant, InterfaceSample};
use super::mass_matrix::{damped, exchange, power_of_loads};
use crate::kinematics::{Bodies, ProgramMemory, Results};
use crate::parameters::{InterfaceParameters, Parameters};
use crate::scalar::Scalar;
use crate::spatial::{Vec3, Wrench};
use crate::statics::{AppliedLoad, act_alike};
use crate::topology::Topology;
use core::fmt::Debug;
use core::ops::Range;
use std::sync::Arc;

/// Program recorded for one mechanism that computes accelerations and reactions with the friction
/// of sliding interfaces, and all that a stage of a time step requires.
pub trait AccelerationProgram: Debug + Send + Sync {
    /// Allocates memory for one state.
    fn memory(&self) -> ProgramMemory;

    /// Runs the program. Returns `false` if the normal loads have not settled, or if an assumption
    /// made at recording does not hold at this state; the results are then invalid.
    fn run(&self, memory: &mut ProgramMemory, inputs: &ProgramInputs<'_>) -> bool;

    /// Returns the range of the results in [`ProgramMemory::slots`]: the accelerations of the
    /// spanning tree; the normal load of each interface, N; the magnitude of its friction, N; the
    /// [`moving_results`]; the complete wrench of each joint (force, then moment about the joint's
    /// origin, world axes).
    fn results(&self) -> Range<usize>;
}

/// Inputs of an [`AccelerationProgram`].
#[derive(Clone, Copy, Debug)]
pub struct ProgramInputs<'a> {
    /// Coordinates of the spanning tree. At the stages of a step, they and the rates close the
    /// loops only with the accuracy of the step.
    pub coordinates: &'a [f64],
    /// Rate of each degree of freedom of the spanning tree, rad/s or m/s.
    pub rates: &'a [f64],
    /// External loads; bodies, points and axes are those of the recording.
    pub loads: &'a [AppliedLoad<f64>],
    /// Effort of each actuator, N or N m.
    pub efforts: &'a [f64],
}

/// Returns those results of an [`AccelerationProgram`] that follow from the motion of the bodies,
/// which must be up to date: the sliding velocity of each interface along its three directions,
/// m/s; the rate of each actuator, rad/s or m/s; the powers of loads and dampers, and the rate of
/// the potential energy, W.
#[doc(hidden)]
pub fn moving_results<T: Scalar>(
    topology: &Topology,
    parameters: &Parameters<T>,
    bodies: &Bodies<T>,
    loads: &[AppliedLoad<T>],
) -> Vec<T> {
    let mut results: Vec<T> = surface_velocities(topology, parameters, bodies).flatten().collect();
    results.extend(topology.actuators.iter().map(|own| bodies.actuator_rate(topology, *own)));
    results.push(power_of_loads(loads, bodies));
    results.push(damped(parameters, bodies));
    results.push(exchange(parameters, bodies));
    results
}

/// Yields the sliding velocity of each interface along each of its DOFs, m/s.
pub(super) fn surface_velocities<'a, T: Scalar>(
    topology: &'a Topology,
    parameters: &'a Parameters<T>,
    bodies: &'a Bodies<T>,
) -> impl Iterator<Item = [T; 3]> + 'a {
    let velocity = |own: &InterfaceParameters<T>| {
        bodies.surface_velocity(topology, own, parameters.pitch[own.joint])
    };
    parameters.interfaces.iter().map(velocity)
}

/// Number of powers in [`moving_results`].
const POWERS: usize = 3;

/// Results of a program, see [`AccelerationProgram::results`].
#[derive(Clone, Copy, Debug)]
pub(super) struct ProgramResults<'m> {
    pub(super) accelerations: &'m [f64],
    pub(super) loads: &'m [f64],
    pub(super) frictions: &'m [f64],
    pub(super) velocities: &'m [[f64; 3]],
    pub(super) actuator_rates: &'m [f64],
    /// Powers of loads and dampers, and rate of the potential energy, W.
    pub(super) powers: [f64; POWERS],
    wrenches: &'m [[f64; 6]],
}

/// Memory of a program, and a buffer for the verification of its results.
#[derive(Clone, Debug)]
pub(super) struct ProgramBuffers {
    memory: ProgramMemory,
    wrenches: Vec<Wrench<f64>>,
}

/// Program of a model, and the conditions of its use.
#[derive(Clone, Debug)]
pub(super) struct Recorded {
    program: Arc<dyn AccelerationProgram>,
    /// External loads at recording: bodies, points and axes must be the same.
    loads: Vec<AppliedLoad<f64>>,
    /// Time, s, from which the program is used.
    pub(super) from: f64,
}

impl Forward {
    /// Uses a program recorded for this mechanism in place of the general solver, at states in
    /// which all interfaces slide, in steps that start at the time `from`, s, or later. `loads` are
    /// those of the recording. Returns false, and does not use the program, if actuators are
    /// prescribed, if motors have shafts of their own, if the mechanism has rotors or gearings, or
    /// if the program has results for another mechanism.
    #[doc(hidden)]
    pub fn use_program(
        &mut self,
        program: Arc<dyn AccelerationProgram>,
        loads: &[AppliedLoad<f64>],
        from: f64,
    ) -> bool {
        let topology = &self.topology;
        let (interfaces, joints) = (self.parameters.interfaces.len(), topology.joint_types.len());
        let moving = 3 * interfaces + topology.actuators.len() + POWERS;
        let results = topology.dofs() + 2 * interfaces + moving + 6 * joints;
        let is_suited = self.prescribed.is_empty()
            && self.with_shafts.is_none()
            && self.rotors.is_empty()
            && topology.gearings.is_empty()
            && program.results().len() == results;
        if is_suited {
            self.recorded = Some(Recorded { program, loads: loads.to_vec(), from });
        }
        is_suited
    }

    /// Computes the results of the program for the state and inputs in `data`. Returns `None` if
    /// there is no program, or if it is not valid there.
    pub(super) fn solve_by_program<'m>(
        &self,
        data: &Data,
        modes: &[InterfaceMode],
        buffers: &'m mut ProgramBuffers,
    ) -> Option<ProgramResults<'m>> {
        self.recorded.as_ref()?.solve(self, data, modes, &mut buffers.memory)
    }

    /// Writes the results of the program at one instant, reusing the buffers; the singularity index
    /// must be known. Inertias and bias forces in `data` must be up to date. Returns false if the
    /// results do not satisfy all equations.
    pub(super) fn instant_by_program(
        &self,
        data: &Data,
        modes: &[InterfaceMode],
        buffers: &mut ProgramBuffers,
        instant: &mut Instant,
    ) -> bool {
        let (topology, parameters) = (&self.topology, &self.parameters);
        let Some(recorded) = &self.recorded else { return false };
        let results = recorded.results(self, &buffers.memory);
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
        state.clone_from(&data.state);
        state.accelerations.copy_from_slice(results.accelerations);
        bodies.clone_from(&data.bodies);
        bodies.accelerate(topology, &state.accelerations);
        drives.clone_from(&data.efforts);
        gearings.clear();
        interfaces.clear();
        for (index, (load, friction)) in results.loads.iter().zip(results.frictions).enumerate() {
            let (mode, velocity) = (modes[index], data.velocities[index]);
            let speed = norm(velocity);
            let friction = velocity.map(|v| v / speed * friction);
            let limit = parameters.interfaces[index].law_towards(friction[0]).at_rest() * load;
            let load = *load;
            interfaces.push(InterfaceSample { interface: mode, velocity, load, friction, limit });
        }
        wrenches.clear();
        wrenches.extend(results.wrenches.iter().zip(&bodies.frame_j).map(|(wrench, frame)| {
            let [a, b, c, d, e, f] = *wrench;
            let (force, moment) = (Vec3::new(a, b, c), Vec3::new(d, e, f));
            // Moments of the program are about the joint's origin.
            let moment = moment + frame.position.cross(force);
            Wrench { force, moment }
        }));
        account.update(self, (&data.masses, &data.loads), bodies, drives, interfaces);
        bristle_rates.clear();
        bristle_rates.resize(modes.len(), [0.0; 3]);
        input_rates.clone_from(&data.input_rates);
        (instant.time, instant.coupling) = (data.time, None);
        (instant.redundant, instant.open_drives, instant.gives_way) = (0, 0, None);
        instant.mobility = topology.dofs() - topology.closures();
        self.satisfies_all_equations((data, modes), instant, &results, &mut buffers.wrenches)
    }
}

impl Recorded {
    /// Allocates the buffers of the program.
    pub(super) fn buffers(&self) -> ProgramBuffers {
        ProgramBuffers { memory: self.program.memory(), wrenches: Vec::new() }
    }

    /// Runs the program at a state. Returns its results; `None` if the program is not valid there.
    pub(super) fn solve<'m>(
        &self,
        model: &Forward,
        data: &Data,
        modes: &[InterfaceMode],
        memory: &'m mut ProgramMemory,
    ) -> Option<ProgramResults<'m>> {
        if !act_alike(&data.loads, &self.loads) {
            return None;
        }
        let Data { state, loads, efforts, .. } = data;
        let (coordinates, rates) = (&state.coordinates[..], &state.rates[..]);
        let inputs = ProgramInputs { coordinates, rates, loads, efforts };
        if !self.program.run(memory, &inputs) {
            return None;
        }
        let results = self.results(model, memory);
        let is_valid = results.accelerations.iter().all(|a| a.is_finite());
        (is_valid && slide_on(results.velocities, modes)).then_some(results)
    }

    /// Returns the results of the last run.
    fn results<'m>(&self, model: &Forward, memory: &'m ProgramMemory) -> ProgramResults<'m> {
        let topology = &model.topology;
        let interfaces = model.parameters.interfaces.len();
        let mut all = Results::new(memory.slots.get(self.program.results()).unwrap_or(&[]));
        ProgramResults {
            accelerations: all.take(topology.dofs()),
            loads: all.take(interfaces),
            frictions: all.take(interfaces),
            velocities: all.take(3 * interfaces).as_chunks().0,
            actuator_rates: all.take(topology.actuators.len()),
            powers: all.next(),
            wrenches: all.take(6 * topology.joint_types.len()).as_chunks().0,
        }
    }
}

/// Returns true if all interfaces slide.
pub(super) fn all_slide(modes: &[InterfaceMode]) -> bool {
    modes.iter().all(|mode| matches!(mode, InterfaceMode::Slides(_)))
}

/// Returns true if all interfaces slide in the directions of their modes.
fn slide_on(velocities: &[[f64; 3]], modes: &[InterfaceMode]) -> bool {
    velocities.iter().zip(modes).all(|(velocity, mode)| match mode {
        InterfaceMode::Slides(direction) => dot(*velocity, *direction) > 0.0,
        _ => false,
    })
}
