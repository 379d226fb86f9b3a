//! Recording of the poses and twists of all bodies for generated source code.

use super::Routine;
use crate::code::{Slots, compile};
use crate::error::RecordError;
use crate::graph::{Graph, Node};
use crate::recorded::{Recorded, record_groups};
use crate::recording::RecordingSource;
use crate::samples::Sample;
use crate::stages::holds;
use crate::value_numbering::{Merged, merge};
use stiction_core::dynamics::{FrictionMode, Settings};
use stiction_core::kinematics::Target;
use stiction_core::parameters::Parameters;
use stiction_core::scalar::Scalar;

/// Poses and twists of all bodies except the ground, as nodes of a graph.
pub(super) struct KinematicStages {
    graph: Graph,
    inputs: usize,
    /// For each body, the position of its origin and the rows of its rotation matrix; at the end a
    /// guard, which is positive while the assumptions made at recording hold.
    poses: Vec<Node>,
    /// For each body, the velocity of its origin and its angular velocity; at the end a guard,
    /// which is positive while the assumptions made at recording hold.
    twists: Vec<Node>,
}

impl RecordingSource<'_> {
    /// Records poses and twists at closed loops. The inputs are the coordinates of the tree, then
    /// the value and the rate of each prescribed coordinate.
    pub(super) fn record_kinematics(&self, samples: &[Sample]) -> KinematicStages {
        let (solver, counts) = (self.solver, self.counts(0));
        let inputs = counts.coordinates + 2 * counts.targets;
        let origin = solver.parameters().origin;
        let (graph, [poses, twists]) = record_groups(inputs, |inputs| {
            let (coordinates, values) = inputs.split_at(counts.coordinates);
            let target = |pair: &[Recorded]| Target {
                value: pair[0],
                rate: pair[1],
                acceleration: Recorded::zero(),
            };
            let targets: Vec<Target<Recorded>> = values.chunks_exact(2).map(target).collect();
            let parameters = Parameters::<Recorded>::new(solver.mechanism());
            let settings =
                Settings { friction: FrictionMode::Off, position_steps: 0, ..Settings::default() };
            let mut data = self.model.data(solver.state(), settings);
            data.state.coordinates.copy_from_slice(coordinates);
            self.model.evaluate(&parameters, &mut data, &targets, &[]);
            let bodies = &data.kinematics.bodies;
            let (mut poses, mut twists) = (Vec::new(), Vec::new());
            for (pose, twist) in bodies.pose.iter().zip(&bodies.twist).skip(1) {
                let at = pose.position + origin.lift();
                poses.extend([at.x, at.y, at.z]);
                let [x, y, z] = pose.rotation.columns;
                poses.extend([x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z]);
                let (v, w) = (twist.velocity_at(pose.position), twist.angular);
                twists.extend([v.x, v.y, v.z, w.x, w.y, w.z]);
            }
            [poses, twists]
        });
        let rows: Vec<Vec<f64>> = samples
            .iter()
            .map(|Sample { state, targets, .. }| {
                let mut row = state.coordinates.clone();
                row.extend(targets.iter().flat_map(|target| [target.value, target.rate]));
                row
            })
            .collect();
        let Merged { graph: mut merged, new_of, guards } = merge(&graph, &rows);
        let mut guarded = |nodes: Vec<Node>| -> Vec<Node> {
            let guard = holds(&graph, &nodes, &guards, &mut merged);
            nodes.iter().map(|node| new_of[*node as usize]).chain([guard]).collect()
        };
        let [poses, twists] = [poses, twists].map(&mut guarded);
        KinematicStages { graph: merged, inputs, poses, twists }
    }
}

impl KinematicStages {
    /// Compiles the routine of the poses and the routine of the twists, each with slots of its own.
    pub(super) fn compile(&self) -> Result<[Routine; 2], RecordError> {
        let ops = self.graph.ops();
        let one = |nodes: &[Node]| -> Result<Routine, RecordError> {
            let mut slots = Slots::of_inputs(ops, 0..self.inputs);
            let parts = compile(ops, nodes, &mut slots, false);
            Ok(Routine { parts, results: slots.places(nodes)? })
        };
        Ok([one(&self.poses)?, one(&self.twists)?])
    }
}
