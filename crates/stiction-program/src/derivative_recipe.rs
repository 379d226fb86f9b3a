//! What is recorded for derivatives of driving forces.
//!
//! Drives `D(x, p)` and loads `L(x, p)` are found at given loads `p` of all contacts, which make the friction; at
//! the solution `p = L(x, p)`. So `(1 - L_p) dp = L_x dx` and `dD = D_x dx + D_p dp`: the coupling is not
//! differentiated step by step but solved once more. `D_x dx` and `L_x dx` are slopes of what is recorded, through
//! one Newton step of the position; `L_p` and `D_p` are what unit frictions do.
//!
//! Equation (P6) of the book's theory.

use crate::graph::{Graph, Node, Op};
use crate::loads::Loads;
use crate::meaning::{Merged, merge};
use crate::motions::run;
use crate::quantity::Quantity;
use crate::recipe::{Counts, Recipe};
use crate::recorded::{Recorded, go_on, record_groups};
use crate::slopes::slopes;
use crate::small::{Factors, diagonal};
use crate::stages::{holds, with_inputs_replaced};
use crate::wrench::local;
use stiction::dynamics::{AppliedLoad, Sharing};
use stiction::friction::Load;
use stiction::kinematics::Target;
use stiction::parameters::Parameters;
use stiction::random::Random;
use stiction::scalar::Scalar;
use stiction::spatial::{Vec3, Wrench};

/// Newton steps that close the loops of changed dimensions.
const CLOSING_STEPS: usize = 12;
/// By what part quantities of the mechanism differ from sample to sample.
const SPREAD: f64 = 0.02;

/// The graph of a program of derivatives. Inputs are those of an inverse program, the loads of all contacts,
/// and the slopes of all quantities.
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
        let [first_load, first_slope] = [counts.inputs(), counts.inputs() + counts.contacts];
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
        let given = [first_load, first_number];
        let inputs = first_number + numbers.len();
        let (mut graph, [drives, loads, gradients, responses, coefficients]) =
            record_groups(inputs, |inputs| self.follow_slopes(&counts, &numbers, given, inputs));
        let slope_of_input = self.slopes_of_inputs(&counts, quantities, first_slope, &mut graph);
        let slope = slopes(&mut graph, &slope_of_input);
        let zero = graph.number(0.0);
        let slopes_of = |nodes: &[Node]| -> Vec<Node> {
            nodes.iter().map(|node| slope[*node as usize].unwrap_or(zero)).collect()
        };
        let (drives, loads) = (slopes_of(&drives), slopes_of(&loads));
        let samples = self.varied(&numbers, samples, [counts.contacts, quantities.len()])?;
        let Merged { graph: mut merged, new_of, guards } = merge(&graph, &samples);
        let all = [drives, loads, gradients, responses, coefficients];
        let guard = holds(&graph, &all.concat(), &guards, &mut merged);
        // What was varied to be told apart is constant.
        let constants: Vec<Node> =
            numbers.iter().map(|(_, number)| merged.number(*number)).collect();
        let (graph, newer_of) = with_inputs_replaced(&merged, first_number, &constants);
        let system: Vec<Node> =
            all.concat().iter().map(|node| newer_of[new_of[*node as usize] as usize]).collect();
        let guard = newer_of[guard as usize];
        let (graph, drives) = go_on(graph, &system, |system| total(&counts, system));
        Some(RecordedSlopes { graph, drives, guard })
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

    /// Samples with the numbers of the mechanism varied, loops closed, and with any loads and slopes.
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
            row.extend((0..extra[0]).map(|_| 50.0 + 40.0 * random.number()));
            row.extend((0..extra[1]).map(|_| random.number()));
            row.extend(values);
            Some(row)
        };
        samples.iter().map(each).collect()
    }

    /// Drives and loads of all contacts under the frictions that belong to given loads; for each two contacts how
    /// the friction of the second changes the load of the first; how the friction of each changes each drive; and
    /// coefficients of friction.
    fn follow_slopes(
        &self,
        counts: &Counts,
        numbers: &[(Quantity, f64)],
        [first_load, first_number]: [usize; 2],
        inputs: &[Recorded],
    ) -> [Vec<Recorded>; 5] {
        let mut parameters = Parameters::<Recorded>::new(self.solver.mechanism());
        for ((quantity, _), input) in numbers.iter().zip(&inputs[first_number..]) {
            if let Some(number) = quantity.of_mechanism(&mut parameters) {
                *number = *input;
            }
        }
        let (coordinates, rest) = inputs.split_at(counts.coordinates);
        // Rates and accelerations are given first, and stay; here they are found once more, with their slopes.
        let rest = &rest[2 * counts.freedoms..];
        let targets: Vec<Target<Recorded>> = rest
            .chunks(3)
            .take(counts.targets)
            .map(|t| Target { value: t[0], rate: t[1], acceleration: t[2] })
            .collect();
        let wrenches = rest[3 * counts.targets..].chunks(6);
        let loads: Vec<AppliedLoad<Recorded>> = self
            .loads
            .iter()
            .zip(wrenches)
            .map(|(load, w)| AppliedLoad {
                force: Vec3::new(w[0], w[1], w[2]),
                moment: Vec3::new(w[3], w[4], w[5]),
                ..load.lift()
            })
            .collect();
        let presses = &inputs[first_load..][..counts.contacts];
        let coupled: Vec<usize> = (0..counts.contacts).collect();
        let like = self.solver.assembly().state();
        let given = (&targets[..], &loads[..]);
        let mut ran = run(self.kernel, &parameters, like, coordinates, given, 1);
        let setup = self.kernel.setup();
        let bodies = &ran.kinematics.bodies;
        let responses = Sharing::new(&setup).responses(&setup, &parameters, bodies, &ran.inverse);
        let states = ran.inverse.contacts().to_vec();
        let joints = parameters.contacts.iter().map(|contact| contact.joint);
        let added = joints.clone().map(|joint| {
            let j = &bodies.frame_j[joint];
            responses.iter().map(|response| local(j, response.wrenches[joint])).collect()
        });
        let loads = Loads {
            parameters: &parameters,
            bodies,
            states: &states,
            coupled: &coupled,
            without: Vec::new(),
            added: added.collect(),
        };
        ran.inverse.solve_with(&setup, &parameters, bodies, &loads.forces(presses));
        let found: Vec<Load<Recorded>> = joints
            .enumerate()
            .map(|(contact, joint)| {
                let wrench = ran.inverse.joint_wrenches()[joint];
                loads.load(contact, local(&bodies.frame_j[joint], wrench))
            })
            .collect();
        let of_row = |(load, added): (&Load<Recorded>, &Vec<Wrench<Recorded>>)| {
            added.iter().map(|added| load.gradient.power(*added)).collect::<Vec<_>>()
        };
        let gradients = found.iter().zip(&loads.added).flat_map(of_row).collect();
        [
            ran.inverse.drives().to_vec(),
            found.iter().map(|load| load.value).collect(),
            gradients,
            responses.into_iter().flat_map(|response| response.drives).collect(),
            states.iter().map(|state| state.resistance().0).collect(),
        ]
    }
}

/// Slopes of the drives with loads that follow, from those at constant loads.
fn total(counts: &Counts, system: &[Recorded]) -> Vec<Recorded> {
    let count = counts.contacts;
    let (drives, rest) = system.split_at(counts.drives);
    let (loads, rest) = rest.split_at(count);
    let (gradients, rest) = rest.split_at(count * count);
    let (responses, coefficients) = rest.split_at(count * counts.drives);
    let entry = |row: usize, column: usize| {
        let own = Recorded::from_f64(if row == column { 1.0 } else { 0.0 });
        own - gradients[row * count + column] * coefficients[column]
    };
    let matrix: Vec<Vec<Recorded>> =
        (0..count).map(|row| (0..count).map(|column| entry(row, column)).collect()).collect();
    let change = Factors::new(&matrix, diagonal(count)).solve(loads);
    let mut total = drives.to_vec();
    for (contact, change) in change.iter().enumerate() {
        let friction = coefficients[contact] * *change;
        for (drive, total) in total.iter_mut().enumerate() {
            *total += responses[contact * counts.drives + drive] * friction;
        }
    }
    total
}
