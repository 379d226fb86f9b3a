//! Recorded program in place of the general solver, at states in which all interfaces slide.

use super::Forward;
use super::affine_friction::{InterfaceMode, dot, norm};
use super::data::Data;
use super::inputs::Inputs;
use super::instant::{Instant, InterfaceSample};
use crate::kinematics::{Coordinate, ProgramMemory, Results, measure_motion};
use crate::spatial::{Vec3, Wrench};
use crate::statics::{AppliedLoad, act_alike};
use core::fmt::Debug;
use core::ops::Range;
use std::sync::Arc;

/// Program recorded for one mechanism that computes accelerations and reactions with the friction
/// of sliding interfaces. Its inputs are, in this order: coordinates and rates of the spanning
/// tree; its accelerations, which the program ignores; value, rate and (ignored) acceleration of
/// the coordinates of the recording; the external loads (force, moment); the actuator efforts. At
/// the stages of a step, coordinates and rates close the loops only with the accuracy of the step.
pub trait AccelerationProgram: Debug + Send + Sync {
    /// Allocates memory for one state.
    fn memory(&self) -> ProgramMemory;

    /// Runs the program. Returns `false` if the normal loads have not settled, or if an assumption
    /// made at recording does not hold at this state; the results are then invalid.
    fn run(&self, memory: &mut ProgramMemory) -> bool;

    /// Returns the range of the results in [`ProgramMemory::slots`]: the accelerations of the
    /// spanning tree; the normal load of each interface, N; the magnitude of its friction, N; the
    /// complete wrench of each joint (force, then moment about the joint's origin, world axes).
    fn results(&self) -> Range<usize>;
}

/// Memory of a program, and a buffer for the verification of its results.
#[derive(Clone, Debug)]
pub(super) struct ProgramBuffers {
    memory: ProgramMemory,
    wrenches: Vec<Wrench<f64>>,
}

/// Program of a model, and the quantities that are its inputs.
#[derive(Clone, Debug)]
pub(super) struct Recorded {
    program: Arc<dyn AccelerationProgram>,
    coordinates: Vec<Coordinate>,
    /// External loads at recording: bodies, points and axes must be the same.
    loads: Vec<AppliedLoad<f64>>,
    /// Time, s, from which the program is used.
    pub(super) from: f64,
}

impl Forward {
    /// Uses a program recorded for this mechanism in place of the general solver, at states in
    /// which all interfaces slide, in steps that start at the time `from`, s, or later.
    /// `coordinates` and `loads` are those of the recording. Returns false, and does not use the
    /// program, if actuators are prescribed, if motors have shafts of their own, if the mechanism
    /// has rotors or gearings, or if the program has results for another mechanism.
    #[doc(hidden)]
    pub fn use_program(
        &mut self,
        program: Arc<dyn AccelerationProgram>,
        (coordinates, loads): (&[Coordinate], &[AppliedLoad<f64>]),
        from: f64,
    ) -> bool {
        let topology = &self.topology;
        let (interfaces, joints) = (self.parameters.interfaces.len(), topology.joint_types.len());
        let results = topology.dofs() + 2 * interfaces + 6 * joints;
        let is_suited = self.prescribed.is_empty()
            && self.with_shafts.is_none()
            && self.rotors.is_empty()
            && topology.gearings.is_empty()
            && program.results().len() == results;
        if is_suited {
            let (coordinates, loads) = (coordinates.to_vec(), loads.to_vec());
            self.recorded = Some(Recorded { program, coordinates, loads, from });
        }
        is_suited
    }

    /// Computes inputs and results of the program for the motion in `data`. Returns `None` if there
    /// is no program, or if it is not valid there.
    pub(super) fn solve_by_program<'m>(
        &self,
        data: &mut Data,
        modes: &[InterfaceMode],
        buffers: &'m mut ProgramBuffers,
        inputs: &mut dyn Inputs,
    ) -> Option<Results<'m>> {
        self.update_inputs(data, inputs);
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
        let mut results = recorded.results(&buffers.memory);
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
        results.fill(&mut state.accelerations);
        bodies.clone_from(&data.bodies);
        bodies.accelerate(topology, &state.accelerations);
        drives.clone_from(&data.efforts);
        gearings.clear();
        let (loads, frictions) = (results.take(modes.len()), results.take(modes.len()));
        interfaces.clear();
        for (index, (load, friction)) in loads.iter().zip(frictions).enumerate() {
            let (mode, velocity) = (modes[index], data.velocities[index]);
            let speed = norm(velocity);
            let friction = velocity.map(|v| v / speed * friction);
            let limit = parameters.interfaces[index].law_towards(friction[0]).at_rest() * load;
            let load = *load;
            interfaces.push(InterfaceSample { interface: mode, velocity, load, friction, limit });
        }
        wrenches.clear();
        wrenches.extend((0..topology.joint_types.len()).map(|joint| {
            let [a, b, c, d, e, f] = results.next();
            let (force, moment) = (Vec3::new(a, b, c), Vec3::new(d, e, f));
            // Moments of the program are about the joint's origin.
            let moment = moment + bodies.frame_j[joint].position.cross(force);
            Wrench { force, moment }
        }));
        account.update(self, (&data.masses, &data.loads), bodies, drives, interfaces);
        bristle_rates.clear();
        bristle_rates.resize(modes.len(), [0.0; 3]);
        input_rates.clone_from(&data.input_rates);
        (instant.time, instant.coupling) = (data.time, None);
        (instant.redundant, instant.open_drives, instant.gives_way) = (0, 0, None);
        instant.mobility = topology.dofs() - topology.closures();
        self.satisfies_all_equations((data, modes), instant, &mut buffers.wrenches)
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
    ) -> Option<Results<'m>> {
        if !act_alike(&data.loads, &self.loads) || !slide_on(&data.velocities, modes) {
            return None;
        }
        let (topology, parameters) = (&model.topology, &model.parameters);
        let (state, bodies) = (&data.state, &data.bodies);
        let mut slots = memory.slots.iter_mut();
        let mut put = |numbers: &[f64]| {
            numbers.iter().zip(&mut slots).for_each(|(number, slot)| *slot = *number);
        };
        put(&state.coordinates);
        put(&state.rates);
        put(&state.accelerations);
        for coordinate in &self.coordinates {
            let motion =
                measure_motion(*coordinate, topology, parameters, bodies, &state.coordinates);
            put(&[motion.value, motion.rate, 0.0]);
        }
        for load in &data.loads {
            put(&load.force.to_array());
            put(&load.moment.to_array());
        }
        put(&data.efforts);
        self.program.run(memory).then(|| self.results(memory))
    }

    /// Returns the results of the last run.
    fn results<'m>(&self, memory: &'m ProgramMemory) -> Results<'m> {
        Results::new(memory.slots.get(self.program.results()).unwrap_or(&[]))
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
