//! Recording of inverse dynamics: an evaluation of the kernel without friction, and a Newton step
//! for the coupling of friction with the reactions.
//!
//! The kernel includes friction in the force balance as a linear function of the reactions, so a
//! Newton step solves a system that is as sparse as without friction. The unknowns of a step are
//! the wrenches of the cut joints, which determine all other forces. Components of these wrenches
//! that influence no result are omitted.
//!
//! Equation (P3) of the book's theory.

use crate::derivative_stages::DerivativeInputs;
use crate::error::RecordError;
use crate::graph::{Graph, Node, Op, needed};
use crate::program_inputs::InputLayout;
use crate::quantity::Quantity;
use crate::recorded::{Recorded, extend_graph, record_groups, with_slopes};
use crate::recording::{Followed, RecordingSource};
use crate::samples::SAMPLES;
use crate::stages::holds;
use crate::value_numbering::{Merged, merge};
use crate::wrench::{components, reaction};
use core::ops::Range;
use stiction_core::dynamics::{FrictionMode, Settings};
use stiction_core::kinematics::Target;
use stiction_core::parameters::{InterfaceParameters, Parameters};
use stiction_core::random::Random;
use stiction_core::scalar::Scalar;
use stiction_core::spatial::{Vec3, Wrench};

/// Results of all stages, as nodes of one graph. The inputs of the graph are, in this order: the
/// inputs of the program; the inputs of a Newton step, which are the components of each cut joint's
/// wrench and the accelerations of local passive DOFs; and the inputs of derivatives, see
/// [`DerivativeInputs`].
pub(crate) struct InverseStages {
    pub(crate) graph: Graph,
    /// Actuator forces and reactions without friction.
    pub(crate) ideal: Vec<Node>,
    /// Indices of those inputs of a Newton step that influence results.
    pub(crate) from: Vec<u32>,
    /// Initial values of the inputs in `from`: their values under the friction that the
    /// frictionless normal loads cause.
    pub(crate) begin: Vec<Node>,
    /// Values of the inputs in `from` after a Newton step.
    pub(crate) next: Vec<Node>,
    /// Three numbers that control convergence: the sum of squares of the changes of the inputs in
    /// `from` during a step, with moments divided by the characteristic length; the sum of squares
    /// of the values of these inputs, scaled in the same way; and the determinant of the step's
    /// matrix, relative to that without friction.
    pub(crate) control: [Node; 3],
    /// Actuator forces, reactions, normal loads, sliding velocities and friction forces after a
    /// Newton step.
    pub(crate) rest: Vec<Node>,
    /// Overlaps of the supports of friction interfaces: lengths that must be positive.
    pub(crate) overlaps: Vec<Node>,
    /// Reciprocal pivots of the rate equations.
    pub(crate) rate_pivots: Vec<Node>,
    /// Reciprocal pivots of the force balance without friction.
    pub(crate) balance_pivots: Vec<Node>,
    /// Geometric data for the singularity index, see
    /// [`IndexLayout::places`](crate::feedforward::IndexLayout::places).
    pub(crate) places: Vec<Node>,
    /// Derivatives of all actuator forces along a direction; empty if not requested.
    pub(crate) slopes: Vec<Node>,
    /// Indices of the inputs that contain the components of the direction.
    pub(crate) slope_inputs: Range<usize>,
    /// Indices of the joints with friction interfaces, each with the index of the first of six
    /// inputs for the reaction of the joint. The derivatives need these reactions.
    pub(crate) reactions: Vec<(usize, usize)>,
    /// Guards of the results without friction, of the results with friction, and of the
    /// derivatives. A guard is positive while the assumptions made at recording hold.
    pub(crate) guards: [Node; 3],
}

impl RecordingSource<'_> {
    /// Records and merges all stages, and the derivatives with respect to `quantities`. Fails if a
    /// quantity does not exist.
    pub(crate) fn record_inverse(
        &self,
        layout: &InputLayout,
        samples: &[Vec<f64>],
        quantities: &[Quantity],
    ) -> Result<InverseStages, RecordError> {
        let model = self.model;
        let (cuts, spins) = (model.topology().cut_joints(), model.constraints().spins().len());
        let first = layout.count();
        let derivatives = DerivativeInputs::new(
            self,
            quantities,
            layout.first_prescribed(),
            first + 6 * cuts + spins,
        )?;
        let (graph, [ideal, begin, next, plain, tilted, rest, checks, places, drives]) =
            record_groups(derivatives.inputs(), |inputs| {
                let ([ideal, begin, next, plain, tilted, rest, checks, places], followed) =
                    self.follow(layout, inputs);
                let drives = with_slopes(|| derivatives.follow(self, &followed, inputs));
                [ideal, begin, next, plain, tilted, rest, checks, places, drives]
            });
        let (graph, of_recorded, slopes) = derivatives.differentiated(graph, &drives);
        let groups = [ideal, begin, next, plain, tilted, rest, checks, places];
        let groups = groups.map(|nodes| -> Vec<Node> {
            nodes.iter().map(|node| of_recorded[*node as usize]).collect()
        });
        // The inputs of a step are independent, so random values are suitable.
        let mut random = Random::new(2);
        let length = self.solver.mechanism().characteristic_length();
        let unit = |place: usize| if place < 6 * cuts && place % 6 >= 3 { length } else { 1.0 };
        let samples: Vec<Vec<f64>> = samples
            .iter()
            .enumerate()
            .map(|(index, sample)| {
                let mut sample = sample.clone();
                for place in 0..6 * cuts + spins {
                    let number = 50.0 * unit(place) * random.number();
                    // In some extreme samples, joints carry no forces in some directions.
                    let is_zero = index >= SAMPLES && (index % 4 == 0 || random.number() > 0.0);
                    sample.push(if is_zero { 0.0 } else { number });
                }
                sample.extend(derivatives.any(length, &mut random));
                sample
            })
            .collect();
        let Merged { graph: mut merged, new_of, guards } = merge(&graph, &samples);
        let guards = [&groups[0], &groups[1..6].concat(), &slopes]
            .map(|stage| holds(&graph, stage, &guards, &mut merged));
        let new = |nodes: &Vec<Node>| -> Vec<Node> {
            nodes.iter().map(|node| new_of[*node as usize]).collect()
        };
        let slopes = new(&slopes);
        let lengths = self.solver.parameters().interfaces.iter();
        let overlaps = lengths.filter(|interface| interface.load.overlap(0.0).is_some()).count();
        let [ideal, begin, next, plain, tilted, rest, checks, places] = groups.each_ref().map(new);
        let (overlaps, rate_pivots) = checks.split_at(overlaps);
        let (overlaps, rate_pivots) = (overlaps.to_vec(), rate_pivots.to_vec());
        let matter = influential_inputs(merged.ops(), first, &next, &rest);
        let of = |nodes: &[Node]| -> Vec<Node> { matter.iter().map(|k| nodes[*k]).collect() };
        let (begin, next) = (of(&begin), of(&next));
        let from: Vec<u32> = matter.iter().map(|k| (first + k) as u32).collect();
        let before: Vec<Node> = from.iter().map(|input| merged.add(Op::Input(*input))).collect();
        // Pivots that friction does not change cancel in the ratio of both determinants.
        let balance_pivots = plain.clone();
        let changed = plain.into_iter().zip(tilted).filter(|(plain, tilted)| plain != tilted);
        let pivot = |(plain, reciprocal): (Node, Node)| match merged.ops()[reciprocal as usize] {
            Op::Div(_, pivot) => (plain, pivot, true),
            _ => (plain, reciprocal, false),
        };
        let pivots: Vec<(Node, Node, bool)> = changed.map(pivot).collect();
        let plain: Vec<Node> = pivots.iter().map(|pivot| pivot.0).collect();
        let tilted: Vec<Node> = pivots.iter().map(|pivot| pivot.1).collect();
        let system = [&before[..], &next, &plain, &tilted].concat();
        let (graph, control) = extend_graph(merged, &system, |system| {
            let (before, rest) = system.split_at(matter.len());
            let (next, rest) = rest.split_at(matter.len());
            let (plain, tilted) = rest.split_at(pivots.len());
            let (mut change, mut size) = (Recorded::zero(), Recorded::zero());
            for ((place, before), next) in matter.iter().zip(before).zip(next) {
                let over = Recorded::from_f64(1.0 / unit(*place));
                let (moved, now) = ((*next - *before) * over, *next * over);
                change += moved * moved;
                size += now * now;
            }
            // The factors that are known before a Newton step form a separate product.
            let mut determinant = plain.iter().copied().fold(Recorded::one(), |a, b| a * b);
            for (tilted, (_, _, is_pivot)) in tilted.iter().zip(&pivots) {
                determinant *= if *is_pivot { *tilted } else { tilted.recip() };
            }
            vec![change, size, determinant]
        });
        let control = [control[0], control[1], control[2]];
        let (slope_inputs, reactions) = (derivatives.slopes(), derivatives.reactions());
        Ok(InverseStages {
            graph,
            ideal,
            from,
            begin,
            next,
            control,
            rest,
            overlaps,
            rate_pivots,
            balance_pivots,
            places,
            slopes,
            slope_inputs,
            reactions,
            guards,
        })
    }

    /// Evaluates the stages with recorded scalars. Returns eight groups: actuator forces and
    /// reactions without friction; initial values of the unknowns of a Newton step; values of these
    /// unknowns after a step from the inputs; reciprocal pivots of the force balance without
    /// friction; reciprocal pivots in the step; the remaining results; overlaps of supports,
    /// followed by reciprocal pivots of the rate equations; and geometric data for the singularity
    /// index. Also returns the recorded inputs.
    fn follow(&self, layout: &InputLayout, inputs: &[Recorded]) -> ([Vec<Recorded>; 8], Followed) {
        let mechanism = self.solver.mechanism();
        // The parameters of the mechanism are constants of the program, except tunable ones.
        let mut parameters = Parameters::<Recorded>::new(mechanism);
        let mut settings =
            Settings { friction: FrictionMode::Off, position_steps: 0, ..Settings::default() };
        layout.adapt(&mut settings);
        let mut data = self.model.data(self.solver.state(), settings);
        let mut inputs = inputs.iter().copied();
        let mut next = || inputs.next().unwrap_or_else(Recorded::zero);
        // The kernel recomputes rates and accelerations from the targets with more operations.
        // Value numbering merges both, and keeps the operations of `read`, which come first.
        layout.read(mechanism, &mut data.state, &mut next);
        layout.tune(&mut parameters, &mut next);
        let coordinates = data.state.coordinates.clone();
        let loads = self.read_loads(&mut next);
        let count = self.solver.constraints().coordinates().len();
        let targets: Vec<Target<Recorded>> = (0..count)
            .map(|_| Target { value: next(), rate: next(), acceleration: next() })
            .collect();
        self.model.evaluate(&parameters, &mut data, &targets, &loads);
        let (bodies, model) = (&data.kinematics.bodies, self.model);
        let all = 0..mechanism.joints().len();
        let overlap = |interface: &InterfaceParameters<Recorded>| {
            let (j, k) = (&bodies.frame_j[interface.joint], &bodies.frame_k[interface.joint]);
            interface.load.overlap((k.position - j.position).dot(j.rotation.columns[2]))
        };
        let mut checks: Vec<Recorded> = parameters.interfaces.iter().filter_map(overlap).collect();
        checks.extend(model.rate_pivots(&data));
        let places = self.index_layout().places(&parameters, bodies);
        let inverse = &mut data.inverse;
        let mut ideal: Vec<Recorded> = inverse.efforts().to_vec();
        ideal.extend(all.clone().flat_map(|joint| reaction(inverse, bodies, joint)));
        let plain = inverse.reciprocal_pivots(model);
        let numbers = |(cuts, spins): (Vec<Wrench<Recorded>>, Vec<Recorded>)| -> Vec<Recorded> {
            cuts.into_iter().flat_map(components).chain(spins).collect()
        };
        // The friction that the frictionless normal loads cause is closer to the solution than zero
        // friction.
        let mut rubbed = inverse.clone();
        let frictions: Vec<Recorded> =
            inverse.interfaces().iter().map(|state| state.friction()).collect();
        rubbed.solve_with(model, &parameters, bodies, &frictions);
        let (mut cuts, mut spins) = rubbed.carried(model);
        let begin = numbers((cuts.clone(), spins.clone()));
        for wrench in &mut cuts {
            let force = Vec3::new(next(), next(), next());
            *wrench = Wrench { force, moment: Vec3::new(next(), next(), next()) };
        }
        spins.fill_with(next);
        inverse.step_from(model, &parameters, bodies, (&cuts, &spins));
        let after = numbers(inverse.carried(model));
        let tilted = inverse.reciprocal_pivots(model);
        let mut rest: Vec<Recorded> = inverse.efforts().to_vec();
        rest.extend(all.flat_map(|joint| reaction(inverse, bodies, joint)));
        let states = inverse.interfaces();
        rest.extend(states.iter().map(|state| state.load()));
        rest.extend(states.iter().map(|state| state.velocity));
        rest.extend(states.iter().map(|state| state.friction()));
        (
            [ideal, begin, after, plain, tilted, rest, checks, places],
            Followed { coordinates, targets, loads, parameters },
        )
    }
}

/// Returns the indices, relative to `first`, of those inputs of a Newton step on which `rest`
/// depends, either directly or through the values `next` of the inputs in the next step.
fn influential_inputs(ops: &[Op], first: usize, next: &[Node], rest: &[Node]) -> Vec<usize> {
    let mut matters: Vec<usize> = Vec::new();
    loop {
        let by: Vec<Node> =
            rest.iter().copied().chain(matters.iter().map(|place| next[*place])).collect();
        let inputs = ops.iter().zip(needed(ops, &by)).filter_map(|(op, needed)| match op {
            Op::Input(place) if needed => (*place as usize).checked_sub(first),
            _ => None,
        });
        let mut found: Vec<usize> = inputs.collect();
        found.sort_unstable();
        if found == matters {
            return found;
        }
        matters = found;
    }
}
