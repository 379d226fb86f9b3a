//! What is recorded for inverse dynamics: the kernel's own run without friction, and a Newton step of its
//! coupling.
//!
//! The kernel tilts the balance by friction that is linear in the reactions, so a step is another solution of a
//! system as sparse as the frictionless one. A step begins at what cut joints carry, from which all else follows;
//! many components change nothing, and are not asked for.
//!
//! Equation (P3) of the book's theory.

use crate::derivative_recipe::Asked;
use crate::error::RecordError;
use crate::graph::{Graph, Node, Op, needed};
use crate::program_inputs::Given;
use crate::quantity::Quantity;
use crate::recorded::{Recorded, go_on, record_groups, with_slopes};
use crate::recording::{Followed, Recipe};
use crate::stages::holds;
use crate::value_numbering::{Merged, merge};
use crate::wrench::{components, reaction};
use core::ops::Range;
use stiction_core::dynamics::{AppliedLoad, FrictionMode, Settings};
use stiction_core::kinematics::Target;
use stiction_core::parameters::Parameters;
use stiction_core::random::Random;
use stiction_core::scalar::Scalar;
use stiction_core::spatial::{Vec3, Wrench};

/// The stages as results of one graph. Inputs are what is given, then what a step begins with: the components of
/// each cut joint's wrench, and accelerations of idle spins; then what derivatives are given, see [`Asked`].
pub(crate) struct InverseStages {
    pub(crate) graph: Graph,
    /// Drives and reactions without friction.
    pub(crate) ideal: Vec<Node>,
    /// Inputs of a step that matter, by their places among all inputs.
    pub(crate) from: Vec<u32>,
    /// For each of them its value under the friction of the frictionless loads.
    pub(crate) begin: Vec<Node>,
    /// For each of them its value after a step.
    pub(crate) next: Vec<Node>,
    /// Squares of their changes in a step and of themselves, summed, moments over the characteristic length; the
    /// determinant of the step's matrix over that without friction.
    pub(crate) control: [Node; 3],
    /// After a step drives, reactions, loads, velocities, frictions.
    pub(crate) rest: Vec<Node>,
    /// Slopes of all drives, if they were asked for; and the inputs that make them.
    pub(crate) slopes: Vec<Node>,
    pub(crate) slope_inputs: Range<usize>,
    /// What they are given: for each joint with contacts the first input of its reaction.
    pub(crate) reactions: Vec<(usize, usize)>,
    /// Positive where what is taken for granted holds: without friction, with friction, of slopes.
    pub(crate) guards: [Node; 3],
}

impl Recipe<'_> {
    /// Records all stages, and slopes by these quantities; and merges what means the same. It is an error if a quantity does
    /// not exist.
    pub(crate) fn record_inverse(
        &self,
        given: &Given,
        samples: &[Vec<f64>],
        quantities: &[Quantity],
    ) -> Result<InverseStages, RecordError> {
        let model = self.model;
        let (cuts, spins) = (model.topology().cut_joints(), model.constraints().spins().len());
        let first = given.count();
        let asked =
            Asked::new(self, quantities, given.first_prescribed(), first + 6 * cuts + spins)?;
        let (graph, [ideal, begin, next, plain, tilted, rest, drives]) =
            record_groups(asked.inputs(), |inputs| {
                let ([ideal, begin, next, plain, tilted, rest], followed) =
                    self.follow(given, inputs);
                let drives = with_slopes(|| asked.follow(self, &followed, inputs));
                [ideal, begin, next, plain, tilted, rest, drives]
            });
        let (graph, of_recorded, slopes) = asked.differentiated(graph, &drives);
        let groups = [ideal, begin, next, plain, tilted, rest].map(|nodes| -> Vec<Node> {
            nodes.iter().map(|node| of_recorded[*node as usize]).collect()
        });
        // What a step begins with are inputs of their own: any will do.
        let mut random = Random::new(2);
        let length = self.solver.mechanism().characteristic_length();
        let unit = |place: usize| if place < 6 * cuts && place % 6 >= 3 { length } else { 1.0 };
        let samples: Vec<Vec<f64>> = samples
            .iter()
            .map(|sample| {
                let mut sample = sample.clone();
                sample.extend((0..6 * cuts + spins).map(|k| 50.0 * unit(k) * random.number()));
                sample.extend(asked.any(length, &mut random));
                sample
            })
            .collect();
        let Merged { graph: mut merged, new_of, guards } = merge(&graph, &samples);
        let guards = [&groups[0], &groups[1..].concat(), &slopes]
            .map(|stage| holds(&graph, stage, &guards, &mut merged));
        let new = |nodes: &Vec<Node>| -> Vec<Node> {
            nodes.iter().map(|node| new_of[*node as usize]).collect()
        };
        let slopes = new(&slopes);
        let [ideal, begin, next, plain, tilted, rest] = groups.each_ref().map(new);
        let matter = matter(merged.ops(), first, &next, &rest);
        let of = |nodes: &[Node]| -> Vec<Node> { matter.iter().map(|k| nodes[*k]).collect() };
        let (begin, next) = (of(&begin), of(&next));
        let from: Vec<u32> = matter.iter().map(|k| (first + k) as u32).collect();
        let before: Vec<Node> = from.iter().map(|input| merged.add(Op::Input(*input))).collect();
        // Pivots that friction does not change are their own.
        let changed = plain.into_iter().zip(tilted).filter(|(plain, tilted)| plain != tilted);
        let pivot = |(plain, reciprocal): (Node, Node)| match merged.ops()[reciprocal as usize] {
            Op::Div(_, pivot) => (plain, pivot, true),
            _ => (plain, reciprocal, false),
        };
        let pivots: Vec<(Node, Node, bool)> = changed.map(pivot).collect();
        let plain: Vec<Node> = pivots.iter().map(|pivot| pivot.0).collect();
        let tilted: Vec<Node> = pivots.iter().map(|pivot| pivot.1).collect();
        let system = [&before[..], &next, &plain, &tilted].concat();
        let (graph, control) = go_on(merged, &system, |system| {
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
            // What is known before a step is a factor of its own.
            let mut determinant = plain.iter().copied().fold(Recorded::one(), |a, b| a * b);
            for (tilted, (_, _, is_pivot)) in tilted.iter().zip(&pivots) {
                determinant *= if *is_pivot { *tilted } else { tilted.recip() };
            }
            vec![change, size, determinant]
        });
        let control = [control[0], control[1], control[2]];
        let (slope_inputs, reactions) = (asked.slopes(), asked.reactions());
        Ok(InverseStages {
            graph,
            ideal,
            from,
            begin,
            next,
            control,
            rest,
            slopes,
            slope_inputs,
            reactions,
            guards,
        })
    }

    /// Drives and reactions without friction; what the first step begins with; what the next begins with after a
    /// step from the inputs; reciprocal pivots without friction and in the step; and the rest. Beside that from what.
    fn follow(&self, given: &Given, inputs: &[Recorded]) -> ([Vec<Recorded>; 6], Followed) {
        let mechanism = self.solver.mechanism();
        // Numbers of the mechanism are constants: they are folded into the program.
        let parameters = Parameters::<Recorded>::new(mechanism);
        let settings =
            Settings { friction: FrictionMode::Off, position_steps: 0, ..Settings::default() };
        let mut data = self.model.data(self.solver.state(), settings);
        let mut inputs = inputs.iter().copied();
        let mut next = || inputs.next().unwrap_or_else(Recorded::zero);
        // Rates and accelerations are found once more, from the targets, by more operations than it takes to
        // see that they are the same: what comes first stays.
        given.read(mechanism, &mut data.state, &mut next);
        let coordinates = data.state.coordinates.clone();
        let mut vector = || Vec3::new(next(), next(), next());
        let loads: Vec<AppliedLoad<Recorded>> = self
            .loads
            .iter()
            .map(|load| AppliedLoad { force: vector(), moment: vector(), ..load.lift() })
            .collect();
        let count = self.solver.constraints().coordinates().len();
        let targets: Vec<Target<Recorded>> = (0..count)
            .map(|_| Target { value: next(), rate: next(), acceleration: next() })
            .collect();
        self.model.evaluate(&parameters, &mut data, &targets, &loads);
        let (bodies, model) = (&data.kinematics.bodies, self.model);
        let all = 0..mechanism.joints().len();
        let inverse = &mut data.inverse;
        let mut ideal: Vec<Recorded> = inverse.efforts().to_vec();
        ideal.extend(all.clone().flat_map(|joint| reaction(inverse, bodies, joint)));
        let plain = inverse.reciprocal_pivots(model);
        let numbers = |(cuts, spins): (Vec<Wrench<Recorded>>, Vec<Recorded>)| -> Vec<Recorded> {
            cuts.into_iter().flat_map(components).chain(spins).collect()
        };
        // The friction of the loads without friction is nearer to the solution than none.
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
        ([ideal, begin, after, plain, tilted, rest], Followed { coordinates, targets, loads })
    }
}

/// The places, from the `first` of these inputs on, that `rest` depends on, and those on which their own next
/// values depend.
fn matter(ops: &[Op], first: usize, next: &[Node], rest: &[Node]) -> Vec<usize> {
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
