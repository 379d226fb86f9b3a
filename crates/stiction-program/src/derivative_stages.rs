//! Recording of derivatives of actuator forces, in addition to inverse dynamics.
//!
//! The coupled forces are a fixed point of a Newton step. At the solution, the result of the step
//! does not depend on its initial value to first order, which is why Newton's method converges
//! quadratically. The derivatives of the actuator forces are therefore those of a single step from
//! constant reactions; the iteration is not differentiated. The configuration is treated in the
//! same way, with one Newton step that closes the loops.
//!
//! Equations (P7) and (P8) of the book's theory.

use crate::error::RecordError;
use crate::graph::{Graph, Node, Op};
use crate::motions::run;
use crate::quantity::Quantity;
use crate::recorded::Recorded;
use crate::recording::{Followed, RecordingSource};
use crate::slopes::slopes;
use crate::stages::with_inputs_replaced;
use crate::wrench::from_components;
use core::ops::Range;
use stiction_core::kinematics::Target;
use stiction_core::random::Random;
use stiction_core::scalar::Scalar;
use stiction_core::spatial::Wrench;

/// Quantities with respect to which actuator forces are differentiated, and the inputs that the
/// derivatives need. These inputs follow those of inverse dynamics, in this order: the six
/// components of the reaction of each joint with friction interfaces; the slopes of all quantities;
/// and, only during the recording, the differentiated parameters of the mechanism.
pub(crate) struct DerivativeInputs<'a> {
    quantities: &'a [Quantity],
    /// Differentiated parameters of the mechanism, with their values.
    numbers: Vec<(Quantity, f64)>,
    /// Indices of the joints with friction interfaces. The reactions of these joints determine the
    /// friction forces.
    interface_joints: Vec<usize>,
    first_target: usize,
    first: usize,
}

impl<'a> DerivativeInputs<'a> {
    /// Assigns indices to the inputs of the derivatives. `first_target` is the index of the first
    /// prescribed value among all inputs, `first` the index of the first input of the derivatives.
    /// Fails if a quantity does not exist.
    pub(crate) fn new(
        source: &RecordingSource<'_>,
        quantities: &'a [Quantity],
        first_target: usize,
        first: usize,
    ) -> Result<Self, RecordError> {
        let mut numbers = Vec::new();
        let mut parameters = source.solver.parameters().clone();
        let none = Target { value: 0.0, rate: 0.0, acceleration: 0.0 };
        let mut targets = vec![none; source.counts(0).targets];
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
        let interface_joints = (0..joints).filter(has_interfaces).collect();
        Ok(Self { quantities, numbers, interface_joints, first_target, first })
    }

    /// Indices of the inputs that contain the slopes of all quantities.
    pub(crate) fn slopes(&self) -> Range<usize> {
        let first = self.first + 6 * self.interface_joints.len();
        first..first + self.quantities.len()
    }

    /// Indices of the joints with friction interfaces, each with the index of the first of six
    /// inputs for the reaction of the joint.
    pub(crate) fn reactions(&self) -> Vec<(usize, usize)> {
        self.interface_joints.iter().copied().zip((self.first..).step_by(6)).collect()
    }

    /// Number of all inputs during the recording, including those of inverse dynamics.
    pub(crate) fn inputs(&self) -> usize {
        self.slopes().end + self.numbers.len()
    }

    /// Returns random values for the inputs of the derivatives: reactions (force, N, and moment, N
    /// m) and slopes, without the differentiated parameters. Moments are scaled with `length`, m.
    pub(crate) fn any(&self, length: f64, random: &mut Random) -> Vec<f64> {
        let mut numbers = Vec::new();
        for _ in &self.interface_joints {
            numbers.extend((0..3).map(|_| 50.0 * random.number()));
            numbers.extend((0..3).map(|_| 50.0 * length * random.number()));
        }
        numbers.extend(self.quantities.iter().map(|_| random.number()));
        numbers
    }

    /// Records one Newton step, and returns the actuator forces after this step. The step starts
    /// from constant wrenches at the joints with friction interfaces. Configuration and motion
    /// start from those in `followed`, and are recomputed as functions of the prescribed values and
    /// of the differentiated parameters.
    pub(crate) fn follow(
        &self,
        source: &RecordingSource<'_>,
        followed: &Followed,
        inputs: &[Recorded],
    ) -> Vec<Recorded> {
        if self.quantities.is_empty() {
            return Vec::new();
        }
        let Followed { coordinates, targets, loads, parameters } = followed;
        let mut parameters = parameters.clone();
        for ((quantity, _), input) in self.numbers.iter().zip(&inputs[self.slopes().end..]) {
            if let Some(number) = quantity.of_mechanism(&mut parameters) {
                *number = *input;
            }
        }
        let like = source.solver.state();
        // An angle computed from poses is known modulo full turns, but a prescribed angle is
        // continuous. The position correction uses the difference of both angles, of which only the
        // slope must have an effect.
        let angles = source.solver.constraints().tree_angles(source.solver.topology());
        let targets = targets.iter().zip(angles).map(|(target, angle)| match angle {
            Some(place) => Target { value: nearest(target.value, coordinates[place]), ..*target },
            None => *target,
        });
        let targets: Vec<Target<Recorded>> = targets.collect();
        let given = (&targets[..], &loads[..]);
        let mut ran = run(source.model, &parameters, like, coordinates, given, 1);
        let bodies = &ran.kinematics.bodies;
        let mut wrenches = vec![Wrench::zero(); source.counts(0).joints];
        for (&joint, reaction) in self.interface_joints.iter().zip(inputs[self.first..].chunks(6)) {
            let Wrench { force, moment } = from_components(reaction);
            let moment = moment + bodies.frame_j[joint].position.cross(force);
            wrenches[joint] = Wrench { force, moment }.held();
        }
        ran.inverse.step_at(source.model, &parameters, bodies, &wrenches);
        ran.inverse.efforts().to_vec()
    }

    /// Adds the slopes of the actuator forces `drives` to the graph. After the differentiation,
    /// [`Op::Held`] nodes are replaced by their operands, and the inputs of the differentiated
    /// parameters by constants. Returns the new graph, the new node of each old node, and the
    /// slopes of `drives`.
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

    /// Returns the node of the slope of each input; `None` for an input that does not vary. The
    /// slopes of prescribed values and of differentiated parameters are themselves inputs of the
    /// graph.
    fn slopes_of_inputs(&self, graph: &mut Graph) -> Vec<Option<Node>> {
        let mut slopes = vec![None; self.slopes().end];
        for (place, quantity) in self.slopes().zip(self.quantities) {
            let slope = Some(graph.add(Op::Input(place as u32)));
            match *quantity {
                Quantity::Value(at) => slopes[self.first_target + 3 * at] = slope,
                Quantity::Rate(at) => slopes[self.first_target + 3 * at + 1] = slope,
                Quantity::Acceleration(at) => slopes[self.first_target + 3 * at + 2] = slope,
                // The inputs of the differentiated parameters have the order of their slopes.
                _ => slopes.push(slope),
            }
        }
        slopes
    }
}

/// Shifts `angle` by full turns to the value nearest to `other`, rad.
fn nearest(angle: Recorded, other: Recorded) -> Recorded {
    let (sine, cosine) = (angle - other).sin_cos();
    other + sine.atan2(cosine)
}
