//! Recording of forward dynamics: an evaluation of inverse dynamics, its changes due to unit
//! accelerations and unit friction forces, and the coupling of friction with the reactions.
//!
//! Let `a` be the accelerations of the prescribed coordinates, whose number is that of the
//! actuators, and `f` the friction forces. Actuator forces are `h + M a + C f`, and joint wrenches
//! are `w + W a + R f`. For given actuator forces `t`, wrenches are `w + W b + (R - V C) f` with
//! `M b = t - h` and `V = W / M`, and so depend only on the friction forces, in an affine way.
//!
//! Expressions in `b` and in the inverse of `M` are first recorded with `b` and the inverse as
//! inputs. The solutions of the linear systems then replace these inputs. The coupling is solved in
//! the merged graph. Therefore the bounds of rounding errors, with which value numbering
//! distinguishes nodes, do not grow through solutions of linear systems.
//!
//! Equations (P4) and (P5) of the book's theory.

use crate::graph::{Graph, Node};
use crate::loads::Loads;
use crate::motions::{Inertial, run};
use crate::recorded::{Recorded, extend_graph, record_groups};
use crate::recording::{Counts, RecordingSource};
use crate::small_lu::{Factors, diagonal, largest_pivots};
use crate::stages::{holds, with_inputs_replaced};
use crate::value_numbering::{Merged, merge};
use crate::wrench::{local, reaction};
use stiction_core::dynamics::{AppliedLoad, Data, Response, Sharing};
use stiction_core::friction::{InterfaceShape, Load};
use stiction_core::kinematics::Target;
use stiction_core::parameters::Parameters;
use stiction_core::random::Random;
use stiction_core::scalar::Scalar;
use stiction_core::spatial::{Mat3, Pose, Vec3, Wrench};

/// Results of all stages of a forward-dynamics program, as nodes of one graph. Inputs of the graph
/// include two sets of estimated normal loads of the coupled interfaces.
pub(crate) struct ForwardStages {
    pub(crate) graph: Graph,
    /// Accelerations and reactions without friction.
    pub(crate) ideal: Vec<Node>,
    /// Normal loads of the coupled interfaces under the friction that the frictionless normal loads
    /// cause.
    pub(crate) begin: Vec<Node>,
    /// Normal loads of the coupled interfaces after a Newton step from the first set of estimated
    /// normal loads, then the determinant of the matrix of this step.
    pub(crate) newton: Vec<Node>,
    /// Normal loads of the coupled interfaces after a chord step from the second set of estimated
    /// normal loads, with the matrix of the Newton step from the first set.
    pub(crate) chord: Vec<Node>,
    /// Accelerations, reactions, normal loads, sliding velocities and friction forces for the
    /// second set of estimated normal loads.
    pub(crate) rest: Vec<Node>,
    /// Guards of the results without friction, and of those with friction. A guard is positive
    /// while the assumptions made at recording hold.
    pub(crate) guards: [Node; 2],
    /// Derivative of each interface's normal load (row) with respect to the friction force of each
    /// coupled interface (column), row by row.
    pub(crate) influence: Vec<Node>,
}

/// Recorded evaluation of inverse dynamics, and its changes due to unit accelerations and unit
/// friction forces.
struct KernelResponses {
    parameters: Parameters<Recorded>,
    base: Data<Recorded>,
    units: Vec<Inertial<Recorded>>,
    responses: Vec<Response<Recorded>>,
    efforts: Vec<Recorded>,
    targets: Vec<Target<Recorded>>,
    loads: Vec<AppliedLoad<Recorded>>,
    coordinates: Vec<Recorded>,
}

impl RecordingSource<'_> {
    /// Chooses the order of pivots for the matrix of actuator forces per unit acceleration. Returns
    /// `None` if the actuator forces do not determine the accelerations.
    pub(crate) fn mass_pivots(&self, samples: &[Vec<f64>]) -> Option<Vec<(usize, usize)>> {
        let counts = self.counts(0);
        let sample = samples.first()?;
        let like = self.solver.state();
        let (coordinates, rest) = sample.split_at(counts.coordinates);
        let targets: Vec<Target<f64>> = rest[2 * counts.dofs..]
            .chunks(3)
            .take(counts.targets)
            .map(|t| Target { value: t[0], rate: t[1], acceleration: t[2] })
            .collect();
        let parameters = self.solver.parameters();
        let units = Inertial::all(self.model, parameters, like, coordinates, &targets);
        largest_pivots(rows_by_units(&units, counts.drives))
    }

    /// Records and merges all stages; `coupled` lists the interfaces whose friction changes a
    /// normal load. Each sample contains [`Counts::inputs`] values.
    pub(crate) fn record_forward(
        &self,
        coupled: &[usize],
        pivots: &[(usize, usize)],
        samples: &[Vec<f64>],
    ) -> ForwardStages {
        let counts = self.counts(coupled.len());
        let given = counts.inputs() + counts.drives + 2 * coupled.len();
        let inputs = given + counts.targets * (1 + counts.targets);
        let (graph, groups) =
            record_groups(inputs, |inputs| self.follow_forward(&counts, coupled, pivots, inputs));
        // Efforts and normal loads are independent inputs, so random values are suitable.
        let mut random = Random::new(3);
        let samples: Vec<Vec<f64>> = samples
            .iter()
            .map(|sample| {
                let mut sample = sample.clone();
                sample.extend((0..counts.drives).map(|_| 100.0 * random.number()));
                sample.extend(coupled.iter().map(|_| 50.0 + 40.0 * random.number()));
                sample.extend(coupled.iter().map(|_| 50.0 + 40.0 * random.number()));
                sample.extend((given..inputs).map(|_| random.number()));
                sample
            })
            .collect();
        let Merged { graph: mut merged, new_of, guards } = merge(&graph, &samples);
        let [ideal, begin, matrix, residual, residual_later, estimates, rest, influence, solutions] =
            groups.each_ref().map(Vec::as_slice);
        let with_friction = [solutions, begin, matrix, residual, residual_later, rest].concat();
        let without = [solutions, ideal].concat();
        let guards =
            [&without, &with_friction].map(|s: &Vec<Node>| holds(&graph, s, &guards, &mut merged));
        let new = |nodes: &[Node]| -> Vec<Node> {
            nodes.iter().map(|node| new_of[*node as usize]).collect()
        };
        let (graph, newer_of) = with_inputs_replaced(&merged, given, &new(solutions));
        let now = |nodes: &[Node]| -> Vec<Node> {
            new(nodes).iter().map(|node| newer_of[*node as usize]).collect()
        };
        let count = coupled.len();
        let system = now(&[matrix, residual, residual_later, estimates].concat());
        let (graph, mut newton) = extend_graph(graph, &system, |system| {
            let (matrix, rest) = system.split_at(count * count);
            let rows: Vec<Vec<Recorded>> =
                (0..count).map(|row| matrix[row * count..][..count].to_vec()).collect();
            let factors = Factors::new(&rows, diagonal(count));
            let (residuals, estimates) = rest.split_at(2 * count);
            let step = |k: usize| {
                let change = factors.solve(&residuals[k * count..][..count]);
                let estimates = &estimates[k * count..][..count];
                estimates.iter().zip(change).map(|(estimate, change)| *estimate - change).collect()
            };
            let [mut steps, later]: [Vec<Recorded>; 2] = [step(0), step(1)];
            steps.push(factors.determinant);
            steps.extend(later);
            steps
        });
        let chord = newton.split_off(count + 1);
        ForwardStages {
            ideal: now(ideal),
            begin: now(begin),
            newton,
            chord,
            rest: now(rest),
            influence: now(influence),
            guards: guards.map(|guard| newer_of[guard as usize]),
            graph,
        }
    }

    fn kernel_responses(
        &self,
        counts: &Counts,
        inputs: &mut dyn Iterator<Item = Recorded>,
    ) -> KernelResponses {
        // The parameters of the mechanism are constants of the program.
        let parameters = Parameters::<Recorded>::new(self.solver.mechanism());
        let like = self.solver.state();
        let mut next = || inputs.next().unwrap_or_else(Recorded::zero);
        let coordinates: Vec<Recorded> = (0..counts.coordinates).map(|_| next()).collect();
        // The kernel computes the rates again. Value numbering merges them with these inputs, which
        // precede them in the graph. No result may depend on the accelerations.
        (0..2 * counts.dofs).for_each(|_| {
            next();
        });
        let targets: Vec<Target<Recorded>> = (0..counts.targets)
            .map(|_| {
                let [value, rate, _] = [next(), next(), next()];
                Target { value, rate, acceleration: Recorded::zero() }
            })
            .collect();
        let mut vector = || Vec3::new(next(), next(), next());
        let loads: Vec<AppliedLoad<Recorded>> = self
            .loads
            .iter()
            .map(|load| AppliedLoad { force: vector(), moment: vector(), ..load.lift() })
            .collect();
        let efforts = (0..counts.drives).map(|_| next()).collect();
        let base = run(self.model, &parameters, like, &coordinates, (&targets, &loads), 0);
        let model = self.model;
        let bodies = &base.kinematics.bodies;
        let responses = Sharing::new(model).responses(model, &parameters, bodies, &base.inverse);
        let units = Inertial::all(self.model, &parameters, like, &coordinates, &targets);
        KernelResponses { parameters, base, units, responses, efforts, targets, loads, coordinates }
    }

    /// Evaluates the results of all stages, and the influence matrix of the normal loads, with
    /// recorded scalars.
    fn follow_forward(
        &self,
        counts: &Counts,
        coupled: &[usize],
        pivots: &[(usize, usize)],
        inputs: &[Recorded],
    ) -> [Vec<Recorded>; 9] {
        let mut inputs = inputs.iter().copied();
        let kernel = self.kernel_responses(counts, &mut inputs);
        let mut take = |count: usize| -> Vec<Recorded> { inputs.by_ref().take(count).collect() };
        let [estimates, estimates_later] = [take(coupled.len()), take(coupled.len())];
        // Accelerations without friction.
        let free = take(counts.targets);
        // For each actuator, the accelerations per unit effort.
        let mobilities: Vec<Vec<Recorded>> =
            (0..counts.targets).map(|_| take(counts.targets)).collect();
        let KernelResponses { parameters, base, units, responses, efforts, .. } = &kernel;
        let (bodies, inverse) = (&base.kinematics.bodies, &base.inverse);

        let masses = Factors::new(&rows_by_units(units, counts.drives), pivots.to_vec());
        let left: Vec<Recorded> =
            efforts.iter().zip(inverse.efforts()).map(|(effort, h)| *effort - *h).collect();
        let mut solutions = masses.solve(&left);
        for effort in 0..counts.targets {
            let unit = |k: usize| Recorded::from_f64(if k == effort { 1.0 } else { 0.0 });
            solutions.extend(masses.solve(&(0..counts.targets).map(unit).collect::<Vec<_>>()));
        }
        let sum = |start: Wrench<Recorded>, of: &[Wrench<Recorded>], amounts: &[Recorded]| {
            let parts = of.iter().zip(amounts);
            parts.fold(start, |sum, (wrench, amount)| sum + *wrench * *amount)
        };
        // Wrenches without friction, and contributions of the friction of each interface.
        let mut without: Vec<Wrench<Recorded>> = Vec::new();
        let mut added: Vec<Vec<Wrench<Recorded>>> = Vec::new();
        for interface in &parameters.interfaces {
            let joint = interface.joint;
            let j = bodies.frame_j[joint];
            // The normal load of a ball does not depend on the axes.
            let frame = match interface.shape {
                InterfaceShape::Ball => Pose { rotation: Mat3::identity(), ..j },
                _ => j,
            };
            let of_units: Vec<Wrench<Recorded>> =
                units.iter().map(|unit| local(&frame, unit.wrenches[joint])).collect();
            let of_efforts: Vec<Wrench<Recorded>> = mobilities
                .iter()
                .map(|mobility| sum(Wrench::zero(), &of_units, mobility))
                .collect();
            let at_rest = local(&frame, inverse.joint_wrenches()[joint]);
            without.push(sum(at_rest, &of_units, &free));
            let of = |column: &usize| {
                let response = &responses[*column];
                let taken: Vec<Recorded> = response.efforts.iter().map(|drive| -*drive).collect();
                sum(local(&frame, response.wrenches[joint]), &of_efforts, &taken)
            };
            added.push(coupled.iter().map(of).collect());
        }
        let states = inverse.interfaces();
        let loads = Loads { parameters, bodies, states, coupled, without, added };

        // The friction that the frictionless normal loads cause is closer to the solution than zero
        // friction.
        let values = |loads: Vec<Load<Recorded>>| loads.iter().map(|load| load.value).collect();
        let begin = values(loads.all_under(&loads.forces(&loads.initial_loads())));
        // Normal loads that result from the friction under the input loads.
        let found = loads.all_under(&loads.forces(&estimates));
        let found_later = loads.all_under(&loads.forces(&estimates_later));
        let residual = Loads::residuals(&estimates, &found);
        let residual_later = Loads::residuals(&estimates_later, &found_later);
        let matrix = loads.matrix(&found).concat();
        let forces = loads.forces(&estimates_later);
        let influence = loads.influences(&forces);
        let all_loads = loads.of_all(&estimates_later, &forces);
        let all_forces = loads.forces_of_all(&all_loads);
        let mut taken = vec![Recorded::zero(); counts.drives];
        for (response, force) in responses.iter().zip(&all_forces) {
            for (taken, drive) in taken.iter_mut().zip(&response.efforts) {
                *taken += *drive * *force;
            }
        }
        let mut accelerations = free.clone();
        for (mobility, taken) in mobilities.iter().zip(&taken) {
            for (acceleration, unit) in accelerations.iter_mut().zip(mobility) {
                *acceleration -= *unit * *taken;
            }
        }
        let ideal = self.finish(&kernel, &free, None);
        let mut rest = self.finish(&kernel, &accelerations, Some(&all_forces));
        rest.extend(&all_loads);
        rest.extend(states.iter().map(|state| state.velocity));
        rest.extend(&all_forces);
        let estimates = [estimates, estimates_later].concat();
        [ideal, begin, matrix, residual, residual_later, estimates, rest, influence, solutions]
    }

    /// Evaluates the accelerations of the prescribed coordinates and of the tree, and all
    /// reactions, for the given accelerations and friction forces.
    fn finish(
        &self,
        kernel: &KernelResponses,
        accelerations: &[Recorded],
        frictions: Option<&[Recorded]>,
    ) -> Vec<Recorded> {
        let KernelResponses { parameters, targets, loads, coordinates, .. } = kernel;
        let moving: Vec<Target<Recorded>> = targets
            .iter()
            .zip(accelerations)
            .map(|(target, acceleration)| Target { acceleration: *acceleration, ..*target })
            .collect();
        let like = self.solver.state();
        let mut ran = run(self.model, parameters, like, coordinates, (&moving, loads), 0);
        let bodies = &ran.kinematics.bodies;
        if let Some(frictions) = frictions {
            ran.inverse.solve_with(self.model, parameters, bodies, frictions);
        }
        let mut results = accelerations.to_vec();
        results.extend(&ran.state.accelerations);
        for joint in 0..self.solver.mechanism().joints().len() {
            results.extend(reaction(&ran.inverse, bodies, joint));
        }
        results
    }
}

/// Matrix of actuator forces (rows) per unit acceleration of each coordinate (columns).
fn rows_by_units<T: Scalar>(units: &[Inertial<T>], drives: usize) -> Vec<Vec<T>> {
    (0..drives).map(|drive| units.iter().map(|unit| unit.drives[drive]).collect()).collect()
}
