//! Search for other assembly modes that the given data do not distinguish from the assembled one.

use super::super::bodies::Bodies;
use super::super::least_squares::PositionEquations;
use super::super::system::Kinematics;
use super::Assembly;
use super::metric::Metric;
use super::reference::{Given, Reference};
use super::report::{NEARLY_AS_NEAR, OpenMode};
use super::search::{LARGE, SAME_MODE, perturb};
use crate::joint::{JointType, Motion};
use crate::parameters::Parameters;
use crate::random::Random;
use core::f64::consts::TAU;
use std::sync::Arc;

/// Number of searches for other assembly modes, each from a random perturbation of the assembled
/// configuration.
const STARTS: usize = 12;
/// Sizes of the random steps before the searches, in rad and characteristic lengths.
const SIZES: [f64; 3] = [1.0, 2.0, 3.0];
/// Maximum number of steps of a search. Searches that reach another mode take about ten steps; a
/// larger limit would delay every setup of a mechanism with undetermined poses by futile searches.
const STEPS: usize = 25;
/// Error at which a search that moves only the undetermined degrees of freedom ends. A search with
/// all degrees of freedom follows.
const ROUGHLY: f64 = 1e-3;
/// Distances from the reference configuration that differ by less than this value, in
/// characteristic lengths, count as equal.
pub(super) const TIE: f64 = 1e-6;

impl Assembly {
    /// Searches for other assembly modes that agree with the given poses about as closely as the
    /// assembled mode (see [`NEARLY_AS_NEAR`]), and reports the first mode found. Does nothing if
    /// the given data determine the poses of all bodies, or if the mechanism is large.
    ///
    /// Two modes count as the same if they differ only in rotations of bodies, such as the legs of
    /// a hexapod, about a line through the joints and the centre of mass of the body. Modes with a
    /// leg that points in the opposite direction do not count.
    pub(super) fn find_ties(
        &mut self,
        parameters: &Parameters<f64>,
        (given, reference, metric): (&Given<'_>, &Reference, &Metric<'_>),
    ) {
        let topology = given.topology;
        let mut is_open = vec![false; topology.dofs()];
        for node in &topology.nodes {
            is_open[node.tree_dofs.clone()].fill(!reference.is_certain(node.body));
        }
        if topology.dofs() > LARGE || !is_open.contains(&true) {
            return;
        }
        let here = self.placed(parameters);
        let limit = NEARLY_AS_NEAR * reference.certain_distance(&here, metric) + TIE;
        let mut trial = self.clone();
        let coordinates = self.model.constraints.coordinates().to_vec();
        trial.constrain(&coordinates, &[]);
        let mut random = Random::new(7);
        let mut found: Vec<Bodies<f64>> = Vec::new();
        for attempt in 0..STARTS {
            trial.state.clone_from(&self.state);
            let size = SIZES[attempt % SIZES.len()];
            let size = |dof: usize| if is_open[dof] { size } else { 0.0 };
            perturb(topology, parameters, &mut trial.state, size, &mut random);
            trial.close_open(parameters, &is_open);
            if trial.search_within(parameters, STEPS).is_err() {
                continue;
            }
            let bodies = trial.placed(parameters);
            if self.reverses_slides(parameters, [&here, &bodies]) {
                continue;
            }
            let is_new = |known: &Bodies<f64>| metric.is_shape_other(known, &bodies);
            if reference.certain_distance(&bodies, metric) <= limit
                && is_new(&here)
                && found.iter().all(is_new)
            {
                found.push(bodies);
            }
        }
        let Some(first) = found.first() else { return };
        self.report.open_mode = most_different(given, metric.length, [&here, first])
            .map(|mode| OpenMode { count: found.len(), ..mode });
        let distances = found.iter().filter_map(|bodies| reference.distance(bodies, metric));
        self.report.other_modes.extend(distances);
        self.report.other_modes.sort_by(f64::total_cmp);
        self.report.other_modes.dedup_by(|a, b| (*a - *b).abs() < SAME_MODE);
    }
}

impl Assembly {
    /// Searches from the current state, moving only the undetermined degrees of freedom, to close
    /// the loops as far as possible.
    fn close_open(&mut self, parameters: &Parameters<f64>, is_open: &[bool]) {
        let (topology, constraints) = (Arc::clone(&self.model.topology), &*self.model.constraints);
        self.kinematics = Kinematics::new(&topology, constraints, &self.model.rates);
        let equations = PositionEquations::new(&topology, parameters, constraints, &self.targets)
            .moving(|dof| is_open[dof]);
        equations.solve(&mut self.kinematics, &mut self.state, ROUGHLY, STEPS);
    }

    /// Returns `true` if a prismatic joint has opposite coordinates of equal magnitude in two
    /// placements of the bodies. In one of the placements, the leg with this joint has passed
    /// through its foot, so that placement is no assembly mode of the robot.
    fn reverses_slides(&self, parameters: &Parameters<f64>, both: [&Bodies<f64>; 2]) -> bool {
        let types = &self.model.topology.joint_types[..parameters.frame_j.len()];
        let mut slides =
            types.iter().enumerate().filter(|(_, kind)| **kind == JointType::Prismatic);
        slides.any(|(joint, kind)| {
            let [a, b] = both.map(|bodies| {
                let mut q = [0.0];
                let relative = bodies.frame_j[joint].inverse() * bodies.frame_k[joint];
                kind.write_coordinates(relative, parameters.pitch[joint], &mut q);
                q[0]
            });
            let limit = SAME_MODE * parameters.length;
            (a + b).abs() < limit && a.abs() > limit
        })
    }
}

/// Finds the joint coordinate that differs most between two placements of the bodies.
fn most_different(
    given: &Given<'_>,
    length: f64,
    placements: [&Bodies<f64>; 2],
) -> Option<OpenMode> {
    let mut most: Option<(f64, OpenMode)> = None;
    for (index, joint) in given.mechanism.joints().iter().enumerate() {
        let joint_type = joint.joint_type;
        if !joint_type.has_scalar_coordinates() {
            continue;
        }
        let [here, other] = placements.map(|bodies| {
            let mut q = vec![0.0; joint_type.coordinates()];
            let relative = bodies.frame_j[index].inverse() * bodies.frame_k[index];
            let pitch = given.parameters.pitch[index];
            joint_type.write_coordinates(relative, pitch, &mut q);
            q
        });
        for (dof, own) in joint_type.dofs().iter().enumerate() {
            let by = other[dof] - here[dof];
            let size = match own.motion {
                Motion::Rotation => (by - TAU * (by / TAU).round()).abs(),
                _ if own.translates() => by.abs() / length,
                _ => by.abs(),
            };
            if most.as_ref().is_none_or(|(largest, _)| size > *largest) {
                let coordinate = joint.dof_name(dof);
                let is_angle = !own.translates();
                let mode = OpenMode {
                    coordinate,
                    taken: here[dof],
                    other: other[dof],
                    is_angle,
                    count: 1,
                };
                most = Some((size, mode));
            }
        }
    }
    most.map(|(_, mode)| mode)
}
