//! What is recorded for derivatives of driving forces.
//!
//! Forces are where a Newton step of the coupling ends at its own beginning. There the step does not depend
//! on where it begins, to first order: that is why Newton's method converges as it does. So drives change as
//! those after one step from fixed reactions do, and the coupling is not differentiated iteration by iteration.
//! The same holds for the position, which one Newton step closes.
//!
//! Equation (P6) of the book's theory.

use crate::graph::{Graph, Node, Op};
use crate::meaning::{Merged, merge};
use crate::motions::run;
use crate::quantity::Quantity;
use crate::recipe::{Counts, Recipe};
use crate::recorded::{Recorded, record_groups};
use crate::slopes::slopes;
use crate::stages::{holds, with_inputs_replaced};
use crate::wrench::components;
use stiction::dynamics::AppliedLoad;
use stiction::kinematics::Target;
use stiction::parameters::Parameters;
use stiction::random::Random;
use stiction::spatial::{Vec3, Wrench};

/// Newton steps that close the loops of changed dimensions.
const CLOSING_STEPS: usize = 12;
/// By what part quantities of the mechanism differ from sample to sample.
const SPREAD: f64 = 0.02;

/// The graph of a program of derivatives. Inputs are those of an inverse program, the reactions of joints with
/// contacts as six numbers each, and the slopes of all quantities.
pub(crate) struct RecordedSlopes {
    pub(crate) graph: Graph,
    /// Slopes of all drives.
    pub(crate) drives: Vec<Node>,
    /// Positive where what is taken for granted holds.
    pub(crate) guard: Node,
}

impl Recipe<'_> {
    /// Records slopes along directions of these quantities; none if one of them does not exist, or if
    /// loops do not close with dimensions that are slightly different.
    pub(crate) fn record_slopes(
        &self,
        quantities: &[Quantity],
        samples: &[Vec<f64>],
    ) -> Option<RecordedSlopes> {
        let counts = self.counts(0);
        let rubbing = self.rubbing();
        let first_reaction = counts.inputs();
        let first_slope = first_reaction + 6 * rubbing.len();
        let first_number = first_slope + quantities.len();
        let mut numbers = Vec::new();
        let mut parameters = self.solver.parameters().clone();
        let none = Target { value: 0.0, rate: 0.0, acceleration: 0.0 };
        for quantity in quantities {
            match quantity.of_mechanism(&mut parameters) {
                Some(number) => numbers.push((*quantity, *number)),
                None => {
                    quantity.of_motion(&mut vec![none; counts.targets])?;
                }
            }
        }
        let first_held = first_number + numbers.len();
        let inputs = first_held + 6 * rubbing.len();
        let (mut graph, [drives, carried]) = record_groups(inputs, |inputs| {
            let (inputs, held) = inputs.split_at(first_held);
            let (inputs, numbered) = inputs.split_at(first_number);
            let parameters = self.numbered(&numbers, numbered);
            let (tree, reactions) = inputs[..first_slope].split_at(first_reaction);
            self.follow_slopes(&counts, &parameters, tree, [reactions, held])
        });
        let slope_of_input = self.slopes_of_inputs(&counts, quantities, first_slope, &mut graph);
        let slope = slopes(&mut graph, &slope_of_input);
        let zero = graph.number(0.0);
        let slopes_of = |node: &Node| slope[*node as usize].unwrap_or(zero);
        let drives: Vec<Node> = drives.iter().map(slopes_of).collect();
        // What was held while slopes were found is what joints carry.
        let (graph, new_of) = with_inputs_replaced(&graph, first_held, &carried);
        let drives: Vec<Node> = drives.iter().map(|node| new_of[*node as usize]).collect();
        let samples = self.varied(&numbers, samples, [rubbing.len(), quantities.len()])?;
        let Merged { graph: mut merged, new_of, guards } = merge(&graph, &samples);
        let guard = holds(&graph, &drives, &guards, &mut merged);
        // What was varied to be told apart is constant.
        let constants: Vec<Node> =
            numbers.iter().map(|(_, number)| merged.number(*number)).collect();
        let (graph, newer_of) = with_inputs_replaced(&merged, first_number, &constants);
        let newer = |node: &Node| newer_of[new_of[*node as usize] as usize];
        let drives = drives.iter().map(newer).collect();
        Some(RecordedSlopes { graph, drives, guard: newer_of[guard as usize] })
    }

    /// The joints that have contacts: their reactions make friction.
    pub(crate) fn rubbing(&self) -> Vec<usize> {
        let contacts_at = &self.solver.parameters().contacts_at;
        (0..contacts_at.len()).filter(|joint| !contacts_at[*joint].is_empty()).collect()
    }

    /// The numbers of the mechanism, some of them inputs.
    fn numbered(&self, numbers: &[(Quantity, f64)], inputs: &[Recorded]) -> Parameters<Recorded> {
        let mut parameters = Parameters::new(self.solver.mechanism());
        for ((quantity, _), input) in numbers.iter().zip(inputs) {
            if let Some(number) = quantity.of_mechanism(&mut parameters) {
                *number = *input;
            }
        }
        parameters
    }

    /// The slope of each input: those of prescribed values and of the mechanism's numbers are inputs.
    fn slopes_of_inputs(
        &self,
        counts: &Counts,
        quantities: &[Quantity],
        first_slope: usize,
        graph: &mut Graph,
    ) -> Vec<Option<Node>> {
        let first_number = first_slope + quantities.len();
        let mut slopes = vec![None; first_number];
        let first_target = counts.coordinates + 2 * counts.freedoms;
        for (k, quantity) in quantities.iter().enumerate() {
            let slope = Some(graph.add(Op::Input((first_slope + k) as u32)));
            match *quantity {
                Quantity::Value(at) => slopes[first_target + 3 * at] = slope,
                Quantity::Rate(at) => slopes[first_target + 3 * at + 1] = slope,
                Quantity::Acceleration(at) => slopes[first_target + 3 * at + 2] = slope,
                // Numbers come in the same order.
                _ => slopes.push(slope),
            }
        }
        slopes
    }

    /// Samples with the numbers of the mechanism varied, loops closed, and with any reactions and slopes.
    fn varied(
        &self,
        numbers: &[(Quantity, f64)],
        samples: &[Vec<f64>],
        extra: [usize; 2],
    ) -> Option<Vec<Vec<f64>>> {
        let mut random = Random::new(8);
        let like = self.solver.assembly().state();
        let length = self.solver.mechanism().characteristic_length();
        let each = |sample: &Vec<f64>| {
            let mut parameters = self.solver.parameters().clone();
            let mut values = Vec::new();
            for (quantity, number) in numbers {
                // What is zero is varied as lengths are.
                let size = if *number == 0.0 { length } else { *number };
                let value = number + SPREAD * size * random.number();
                *quantity.of_mechanism(&mut parameters)? = value;
                values.push(value);
            }
            let (_, targets, loads) = self.unpacked(sample);
            let coordinates = &sample[..like.coordinates.len()];
            let steps = if numbers.is_empty() { 0 } else { CLOSING_STEPS };
            let given = (&targets[..], &loads[..]);
            let ran = run(self.kernel, &parameters, like, coordinates, given, steps);
            // Rounding of some steps; otherwise the loops are open.
            let error = ran.kinematics.largest_error();
            if error.is_nan() || error > 1e-12 * length.max(1.0) {
                return None;
            }
            let state = &ran.state;
            let mut row = state.coordinates.clone();
            row.extend(&state.rates);
            row.extend(&state.accelerations);
            row.extend(&sample[row.len()..]);
            for _ in 0..extra[0] {
                row.extend((0..3).map(|_| 50.0 * random.number()));
                row.extend((0..3).map(|_| 50.0 * length * random.number()));
            }
            row.extend((0..extra[1]).map(|_| random.number()));
            row.extend(values);
            Some(row)
        };
        samples.iter().map(each).collect()
    }

    /// Drives after a step from the wrenches at joints with contacts as they are held, about the kernel origin;
    /// and these wrenches, from reactions about the joints' origins.
    fn follow_slopes(
        &self,
        counts: &Counts,
        parameters: &Parameters<Recorded>,
        tree: &[Recorded],
        [reactions, held]: [&[Recorded]; 2],
    ) -> [Vec<Recorded>; 2] {
        let (coordinates, rest) = tree.split_at(counts.coordinates);
        // Rates and accelerations are given first, and stay; here they are found once more, with their slopes.
        let rest = &rest[2 * counts.freedoms..];
        let targets: Vec<Target<Recorded>> = rest
            .chunks(3)
            .take(counts.targets)
            .map(|t| Target { value: t[0], rate: t[1], acceleration: t[2] })
            .collect();
        let loads = rest[3 * counts.targets..].chunks(6).map(wrench);
        let loads: Vec<AppliedLoad<Recorded>> = self
            .loads
            .iter()
            .zip(loads)
            .map(|(load, w)| AppliedLoad { force: w.force, moment: w.moment, ..load.lift() })
            .collect();
        let like = self.solver.assembly().state();
        let given = (&targets[..], &loads[..]);
        let mut ran = run(self.kernel, parameters, like, coordinates, given, 1);
        let bodies = &ran.kinematics.bodies;
        let mut wrenches = vec![Wrench::zero(); counts.joints];
        let mut carried = Vec::new();
        let both = reactions.chunks(6).zip(held.chunks(6));
        for (joint, (reaction, held)) in self.rubbing().into_iter().zip(both) {
            let Wrench { force, moment } = wrench(reaction);
            let moment = moment + bodies.frame_j[joint].position.cross(force);
            carried.extend(components(Wrench { force, moment }));
            wrenches[joint] = wrench(held);
        }
        ran.inverse.step_at(&self.kernel.setup(), parameters, bodies, &wrenches);
        [ran.inverse.drives().to_vec(), carried]
    }
}

/// Force, then moment.
fn wrench(numbers: &[Recorded]) -> Wrench<Recorded> {
    let part = |first: usize| Vec3::new(numbers[first], numbers[first + 1], numbers[first + 2]);
    Wrench { force: part(0), moment: part(3) }
}
