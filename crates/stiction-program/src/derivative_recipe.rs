//! What is recorded for derivatives of driving forces, beside inverse dynamics.
//!
//! Forces are where a Newton step of the coupling ends at its own beginning. There the step does not depend
//! on where it begins, to first order: that is why Newton's method converges as it does. So drives change as
//! those after one step from fixed reactions do, and the coupling is not differentiated iteration by iteration.
//! The same holds for the position, which one Newton step closes.
//!
//! Equations (P6) and (P7) of the book's theory.

use crate::error::RecordError;
use crate::graph::{Graph, Node, Op};
use crate::motions::run;
use crate::quantity::Quantity;
use crate::recorded::Recorded;
use crate::recording::{Followed, Recipe};
use crate::slopes::slopes;
use crate::stages::with_inputs_replaced;
use crate::wrench::from_components;
use core::ops::Range;
use stiction_core::kinematics::Target;
use stiction_core::parameters::Parameters;
use stiction_core::random::Random;
use stiction_core::scalar::Scalar;
use stiction_core::spatial::Wrench;

/// Derivatives that are asked for, and where their inputs stand behind those of inverse dynamics: the reactions of
/// joints with contacts as six numbers each, the slopes of all quantities; and, while it is recorded, numbers of
/// the mechanism.
pub(crate) struct Asked<'a> {
    quantities: &'a [Quantity],
    /// Quantities that are numbers of the mechanism, and these.
    numbers: Vec<(Quantity, f64)>,
    /// The joints with contacts: their reactions make friction.
    rubbing: Vec<usize>,
    first_target: usize,
    first: usize,
}

impl<'a> Asked<'a> {
    /// With the first of the prescribed values among the inputs, and the first input of its own; a quantity that does
    /// not exist is an error.
    pub(crate) fn new(
        recipe: &Recipe<'_>,
        quantities: &'a [Quantity],
        first_target: usize,
        first: usize,
    ) -> Result<Self, RecordError> {
        let mut numbers = Vec::new();
        let mut parameters = recipe.solver.parameters().clone();
        let none = Target { value: 0.0, rate: 0.0, acceleration: 0.0 };
        let mut targets = vec![none; recipe.counts(0).targets];
        for quantity in quantities {
            match quantity.of_mechanism(&mut parameters) {
                Some(number) => numbers.push((*quantity, *number)),
                None => {
                    let found = quantity.of_motion(&mut targets);
                    found.ok_or(RecordError::UnknownQuantity(*quantity))?;
                }
            }
        }
        let has_interfaces = |joint: &usize| !parameters.interfaces_at[*joint].is_empty();
        let joints = if quantities.is_empty() { 0 } else { parameters.interfaces_at.len() };
        let rubbing = (0..joints).filter(has_interfaces).collect();
        Ok(Self { quantities, numbers, rubbing, first_target, first })
    }

    /// The slopes among the inputs.
    pub(crate) fn slopes(&self) -> Range<usize> {
        let first = self.first + 6 * self.rubbing.len();
        first..first + self.quantities.len()
    }

    /// For each joint with contacts the first input of its reaction.
    pub(crate) fn reactions(&self) -> Vec<(usize, usize)> {
        self.rubbing.iter().copied().zip((self.first..).step_by(6)).collect()
    }

    /// All inputs while it is recorded.
    pub(crate) fn inputs(&self) -> usize {
        self.slopes().end + self.numbers.len()
    }

    /// Any reactions and slopes, `length` being that of lever arms.
    pub(crate) fn any(&self, length: f64, random: &mut Random) -> Vec<f64> {
        let mut numbers = Vec::new();
        for _ in &self.rubbing {
            numbers.extend((0..3).map(|_| 50.0 * random.number()));
            numbers.extend((0..3).map(|_| 50.0 * length * random.number()));
        }
        numbers.extend(self.quantities.iter().map(|_| random.number()));
        numbers
    }

    /// Drives after a step from the wrenches at joints with contacts, which are held. Position and motion are those that were
    /// followed, found once more as they depend on what is prescribed and on numbers of the mechanism.
    pub(crate) fn follow(
        &self,
        recipe: &Recipe<'_>,
        followed: &Followed,
        inputs: &[Recorded],
    ) -> Vec<Recorded> {
        if self.quantities.is_empty() {
            return Vec::new();
        }
        let mut parameters = Parameters::new(recipe.solver.mechanism());
        for ((quantity, _), input) in self.numbers.iter().zip(&inputs[self.slopes().end..]) {
            if let Some(number) = quantity.of_mechanism(&mut parameters) {
                *number = *input;
            }
        }
        let Followed { coordinates, targets, loads } = followed;
        let like = recipe.solver.state();
        // A coordinate that was found from poses is one within a turn, what is prescribed goes on over whole turns. The
        // position is corrected by what is between them, which must be nothing but a slope.
        let angles = recipe.solver.constraints().tree_angles(recipe.solver.topology());
        let targets = targets.iter().zip(angles).map(|(target, angle)| match angle {
            Some(place) => Target { value: nearest(target.value, coordinates[place]), ..*target },
            None => *target,
        });
        let targets: Vec<Target<Recorded>> = targets.collect();
        let given = (&targets[..], &loads[..]);
        let mut ran = run(recipe.model, &parameters, like, coordinates, given, 1);
        let bodies = &ran.kinematics.bodies;
        let mut wrenches = vec![Wrench::zero(); recipe.counts(0).joints];
        for (&joint, reaction) in self.rubbing.iter().zip(inputs[self.first..].chunks(6)) {
            let Wrench { force, moment } = from_components(reaction);
            let moment = moment + bodies.frame_j[joint].position.cross(force);
            wrenches[joint] = Wrench { force, moment }.held();
        }
        ran.inverse.step_at(recipe.model, &parameters, bodies, &wrenches);
        ran.inverse.efforts().to_vec()
    }

    /// The graph with slopes of `drives`, in which nothing is held any more and the mechanism's numbers are constants;
    /// the new node for each of the old; and the slopes.
    pub(crate) fn differentiated(
        &self,
        mut graph: Graph,
        drives: &[Node],
    ) -> (Graph, Vec<Node>, Vec<Node>) {
        if self.quantities.is_empty() {
            let all = (0..graph.ops().len() as Node).collect();
            return (graph, all, Vec::new());
        }
        let of_inputs = self.slopes_of_inputs(&mut graph);
        let slope = slopes(&mut graph, &of_inputs);
        let zero = graph.number(0.0);
        let constants: Vec<Node> = self.numbers.iter().map(|(_, x)| graph.number(*x)).collect();
        let (graph, of_first) = with_inputs_replaced(&graph, self.slopes().end, &constants);
        let (graph, of_second) = graph.released();
        let new = |node: Node| of_second[of_first[node as usize] as usize];
        let slopes = drives.iter().map(|node| slope[*node as usize].unwrap_or(zero));
        let slopes = slopes.map(new).collect();
        let new_of = (0..of_first.len() as Node).map(new).collect();
        (graph, new_of, slopes)
    }

    /// The slope of each input: those of prescribed values and of the mechanism's numbers are inputs.
    fn slopes_of_inputs(&self, graph: &mut Graph) -> Vec<Option<Node>> {
        let mut slopes = vec![None; self.slopes().end];
        for (place, quantity) in self.slopes().zip(self.quantities) {
            let slope = Some(graph.add(Op::Input(place as u32)));
            match *quantity {
                Quantity::Value(at) => slopes[self.first_target + 3 * at] = slope,
                Quantity::Rate(at) => slopes[self.first_target + 3 * at + 1] = slope,
                Quantity::Acceleration(at) => slopes[self.first_target + 3 * at + 2] = slope,
                // Numbers come in the same order.
                _ => slopes.push(slope),
            }
        }
        slopes
    }
}

/// An angle less the whole turns by which it differs from another.
fn nearest(angle: Recorded, other: Recorded) -> Recorded {
    let (sine, cosine) = (angle - other).sin_cos();
    other + sine.atan2(cosine)
}
