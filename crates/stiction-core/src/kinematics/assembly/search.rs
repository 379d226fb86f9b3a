//! Search for a configuration with closed loops; reports the remaining gap if none exists.

use super::super::bodies::{Bodies, State};
use super::super::coordinate::{Coordinate, Target};
use super::super::dof;
use super::super::error::{AssemblyError, Gap};
use super::super::least_squares::{Descent, PositionEquations};
use super::super::motion_constraints::MotionConstraints;
use super::super::rotation_vector::RotationVector;
use super::super::system::{Kinematics, column_scales};
use super::Assembly;
use super::metric::Metric;
use super::reference::{Given, Reference};
use super::report::{FAR, NEARLY_AS_NEAR};
use super::ties::TIE;
use crate::linalg::SparseMatrix;
use crate::parameters::Parameters;
use crate::random::Random;
use crate::spatial::Mat3;
use crate::topology::Topology;
use std::sync::Arc;

/// Maximum number of steps of a search.
const SEARCH_STEPS: usize = 500;
/// Scaled error at which a search stops. It is small because passive spins can be detected only
/// with closed loops.
pub(super) const CLOSELY: f64 = 1e-12;
/// A search has found a closed configuration if the largest weighted error is below this value.
const FOUND: f64 = 1e-6;
/// Maximum number of perturbations of configurations in which the rates of a body's prescribed
/// angles are undefined.
const UNDEFINED_AT_MOST: usize = 8;
/// Minimum size of a random perturbation, in rad and characteristic lengths.
const NUDGE: f64 = 0.1;
/// Factor for the search that starts on the opposite side of the reference configuration. The start
/// of this search is displaced from the reference by the negative displacement of the first search,
/// multiplied by this factor.
const OVERSHOOT: f64 = 1.3;
/// Maximum number of searches from random configurations.
const RANDOM_STARTS: usize = 12;
/// Number of degrees of freedom of the spanning tree above which fewer searches are made.
pub(super) const LARGE: usize = 150;
/// Safety factor on the estimated distance of another assembly mode from the reference. The factor
/// decides whether to search for that mode.
const SAFETY: f64 = 1.5;
/// Configurations closer than this root-mean-square displacement, in characteristic lengths, belong
/// to the same assembly mode.
pub(super) const SAME_MODE: f64 = 1e-3;

/// Assembly mode: a closed configuration found by a search.
struct Mode {
    state: State<f64>,
    bodies: Bodies<f64>,
    /// Root-mean-square displacement of the bodies from the reference configuration, in
    /// characteristic lengths.
    distance: f64,
}

/// Moves each degree of freedom of the spanning tree by a random step. `size` returns the maximum
/// step of a degree of freedom, in rad or characteristic lengths.
pub(super) fn perturb(
    topology: &Topology,
    parameters: &Parameters<f64>,
    state: &mut State<f64>,
    size: impl Fn(usize) -> f64,
    random: &mut Random,
) {
    let columns = column_scales(topology, parameters.length).into_iter().enumerate();
    let step: Vec<f64> = columns.map(|(dof, scale)| size(dof) * scale * random.number()).collect();
    state.advance(topology, &step);
}

impl Assembly {
    /// Searches for a closed configuration from the current state; requires neither an elimination
    /// plan nor a good initial guess. Complete orientations prescribed by angles of orders like zxz
    /// are first searched as rotation vectors, because such angles are undefined between parallel
    /// frames.
    pub(super) fn search(
        &mut self,
        parameters: &Parameters<f64>,
    ) -> Result<Descent, AssemblyError> {
        self.search_within(parameters, SEARCH_STEPS)
    }

    /// Runs [`Self::search`] with at most `steps` steps.
    pub(super) fn search_within(
        &mut self,
        parameters: &Parameters<f64>,
        steps: usize,
    ) -> Result<Descent, AssemblyError> {
        if let Some((motion_constraints, targets)) = self.by_rotations() {
            let motion_constraints =
                core::mem::replace(&mut self.model.constraints, Arc::new(motion_constraints));
            let targets = core::mem::replace(&mut self.targets, targets);
            // Errors are reported by the following search, which uses the prescribed angles.
            let _ = self.search_directly(parameters, steps);
            (self.model.constraints, self.targets) = (motion_constraints, targets);
        }
        self.search_directly(parameters, steps)
    }

    /// Replaces complete orientations prescribed by angles of orders like zxz by rotation vectors,
    /// in the prescribed coordinates and their targets. Returns `None` if there are no such
    /// orientations.
    fn by_rotations(&self) -> Option<(MotionConstraints, Vec<Target<f64>>)> {
        let mut coordinates = self.model.constraints.coordinates().to_vec();
        let mut targets = self.targets.clone();
        let mut some = false;
        for first in 0..coordinates.len() {
            let Coordinate::Angle { body, order, index: 0 } = coordinates[first] else { continue };
            let place = |index| {
                let angle = Coordinate::Angle { body, order, index };
                coordinates.iter().position(|c| *c == angle)
            };
            let (Some(second), Some(third)) = (place(1), place(2)) else { continue };
            if order.is_tait_bryan() {
                continue;
            }
            let places = [first, second, third];
            let turn = |k: usize| {
                Mat3::about_axis(order.axes()[k], self.targets[places[k]].value.sin_cos())
            };
            let vector = RotationVector::of(turn(0) * turn(1) * turn(2)).value;
            for (axis, place) in places.into_iter().enumerate() {
                coordinates[place] = Coordinate::RotationVector { body, axis };
                let value = vector.component(axis);
                targets[place] = Target { value, rate: 0.0, acceleration: 0.0 };
            }
            some = true;
        }
        let spins = self.model.constraints.spins();
        some.then(|| (MotionConstraints::new(&self.model.topology, &coordinates, spins), targets))
    }

    /// Runs damped least squares on all position equations from the current state. If it reaches a
    /// configuration at which the rates of prescribed angles are undefined (for example, for the
    /// order zxz between parallel frames), perturbs all coordinates and continues.
    fn search_directly(
        &mut self,
        parameters: &Parameters<f64>,
        steps: usize,
    ) -> Result<Descent, AssemblyError> {
        let topology = Arc::clone(&self.model.topology);
        let topology = &*topology;
        // With this weight, an infeasible motion is reported as a gap in the loops.
        const PRESCRIBED_WEIGHT: f64 = 100.0;
        if self.kinematics.errors().len() != self.model.constraints.row_count() {
            self.kinematics = Kinematics::new(topology, &self.model.constraints, &self.model.rates);
        }
        let mut random = Random::new(5);
        let mut descent;
        for _ in 0..=UNDEFINED_AT_MOST {
            let (constraints, targets) = (&self.model.constraints, &self.targets);
            let equations = PositionEquations::new(topology, parameters, constraints, targets)
                .weighted(|row| if row < topology.closures() { 1.0 } else { PRESCRIBED_WEIGHT });
            descent = equations.solve(&mut self.kinematics, &mut self.state, CLOSELY, steps);
            if !descent.is_undefined {
                return match descent.error < FOUND {
                    true => Ok(descent),
                    false => Err(AssemblyError::Gap(self.gap(parameters))),
                };
            }
            perturb(topology, parameters, &mut self.state, |_| NUDGE, &mut random);
        }
        Err(AssemblyError::Gap(self.gap(parameters)))
    }

    /// Assembles the mechanism in the mode nearest to the reference configuration.
    ///
    /// If the steps of the first search contract from the beginning, it ends at the nearest mode
    /// ([`Descent::contracts`]). Otherwise, or if the result is far from the reference, further
    /// searches begin at the given start coordinates, on the opposite side of the reference, and at
    /// random configurations around it; the nearest result is selected. If no pose is given, no
    /// mode is nearest, and the first result is selected.
    pub(super) fn assemble(
        &mut self,
        parameters: &Parameters<f64>,
        given: &Given<'_>,
    ) -> Result<(), AssemblyError> {
        let reference = given.reference(true);
        self.report.conflicts.clone_from(&reference.conflicts);
        self.state.clone_from(&reference.state);
        let first = self.search(parameters);
        let mut spin_axes = vec![None; self.body_names.len()];
        let mut twin = None;
        if first.is_ok() {
            reference.unwind(given.topology, &mut self.state);
            let outcome = self.complete(parameters);
            spin_axes = self.spin_axes(parameters);
            let (length, com) = (parameters.length, &parameters.com);
            let metric = Metric { length, com, spin_axes: spin_axes.clone() };
            if !matches!(outcome, Err(AssemblyError::Gap(_)))
                && first.as_ref().is_ok_and(Descent::contracts)
            {
                self.compare(parameters, (&reference, &metric), &[]);
                twin = self.near_twin(parameters, &reference, &metric);
                if twin.is_none() && self.report.distance.is_none_or(|distance| distance < FAR) {
                    if outcome.is_ok() {
                        self.find_ties(parameters, (given, &reference, &metric));
                    }
                    return outcome;
                }
            }
        }
        let metric = Metric { length: parameters.length, com: &parameters.com, spin_axes };
        let (mut modes, failure) =
            self.modes(parameters, (given, &reference, &metric), first, twin);
        let least = modes.iter().map(|mode| mode.distance).fold(f64::INFINITY, f64::min);
        // If several modes are equally near within rounding, the first one found counts as nearest.
        for mode in modes.iter_mut().filter(|mode| mode.distance <= least + TIE) {
            mode.distance = least;
        }
        modes.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        let mut outcome = Err(failure);
        for mode in &modes {
            self.state.clone_from(&mode.state);
            if metric.spin_axes.iter().any(Option::is_some) {
                let (topology, bodies) = (given.topology, &mode.bodies);
                reference.turn_spins(topology, parameters, &metric, bodies, &mut self.state);
                if self.search(parameters).is_err() {
                    self.state.clone_from(&mode.state);
                }
            }
            outcome = self.complete(parameters);
            if !matches!(outcome, Err(AssemblyError::Gap(_))) {
                self.compare(parameters, (&reference, &metric), &modes);
                if outcome.is_ok() {
                    self.find_ties(parameters, (given, &reference, &metric));
                }
                return outcome;
            }
        }
        outcome
    }

    /// Returns the state estimated by [`Self::twin`] if the assembly mode near it may be about as
    /// near to the reference as the present one.
    fn near_twin(
        &mut self,
        parameters: &Parameters<f64>,
        reference: &Reference,
        metric: &Metric<'_>,
    ) -> Option<State<f64>> {
        let distance = self.report.distance.filter(|_| self.state.rates.len() <= LARGE)?;
        let twin = self.twin(parameters)?;
        let mut bodies = self.kinematics.bodies.clone();
        bodies.place(&self.model.topology, parameters, &twin.coordinates);
        let other = reference.distance(&bodies, metric)?;
        (other < SAFETY * NEARLY_AS_NEAR * distance).then_some(twin)
    }

    /// Finds assembly modes by several searches and returns them in the order of the searches. Also
    /// returns the error to report if no mode can be completed.
    fn modes(
        &mut self,
        parameters: &Parameters<f64>,
        (given, reference, metric): (&Given<'_>, &Reference, &Metric<'_>),
        first: Result<Descent, AssemblyError>,
        twin: Option<State<f64>>,
    ) -> (Vec<Mode>, AssemblyError) {
        let topology = given.topology;
        let is_any_given = reference.distance(&self.kinematics.bodies, metric).is_some();
        let mut modes: Vec<Mode> = Vec::new();
        let (moved, failure) = match first {
            Ok(descent) => {
                self.add_mode(parameters, (reference, metric), &mut modes);
                (Some(descent.moved), AssemblyError::Undetermined { open: Vec::new() })
            }
            Err(error) => (None, error),
        };
        // Remove the locked spins, because they are valid only for the first result.
        let coordinates = self.model.constraints.coordinates().to_vec();
        self.constrain(&coordinates, &[]);
        if let Some(twin) = twin {
            self.state = twin;
            if self.search(parameters).is_ok() {
                self.add_mode(parameters, (reference, metric), &mut modes);
            }
        }
        // Search from the given start coordinates towards the prescribed values.
        self.state = given.reference(false).state;
        if self.search(parameters).is_ok() {
            if !is_any_given {
                modes.clear();
            }
            self.add_mode(parameters, (reference, metric), &mut modes);
        }
        if let Some(moved) = &moved {
            let opposite: Vec<f64> = moved.iter().map(|x| -OVERSHOOT * x).collect();
            self.state.clone_from(&reference.state);
            self.state.advance(topology, &opposite);
            if is_any_given && self.search(parameters).is_ok() {
                self.add_mode(parameters, (reference, metric), &mut modes);
            }
        }
        let mut random = Random::new(3);
        let (mut vain, enough) = (0, if topology.dofs() > LARGE { 2 } else { 4 });
        for attempt in 0..RANDOM_STARTS {
            if !modes.is_empty() && (!is_any_given || vain >= enough) {
                break;
            }
            self.state.clone_from(&reference.state);
            let nearest = modes.iter().map(|mode| mode.distance).fold(f64::INFINITY, f64::min);
            let size = if nearest < NUDGE { NUDGE } else { nearest.min(1.0) };
            let size = size * [1.0, 0.5, 2.0][attempt % 3];
            perturb(topology, parameters, &mut self.state, |_| size, &mut random);
            let count = modes.len();
            if self.search(parameters).is_ok() {
                self.add_mode(parameters, (reference, metric), &mut modes);
            }
            vain = if modes.len() > count { 0 } else { vain + 1 };
        }
        (modes, failure)
    }

    /// Adds the current configuration to `modes` unless its assembly mode is already in the list.
    fn add_mode(
        &mut self,
        parameters: &Parameters<f64>,
        (reference, metric): (&Reference, &Metric<'_>),
        modes: &mut Vec<Mode>,
    ) {
        reference.unwind(&self.model.topology, &mut self.state);
        let bodies = self.placed(parameters);
        let distance = reference.distance(&bodies, metric).unwrap_or(0.0);
        if modes.iter().all(|mode| metric.between(&mode.bodies, &bodies) > SAME_MODE) {
            modes.push(Mode { state: self.state.clone(), bodies, distance });
        }
    }

    /// Computes the poses of the bodies at the present coordinates.
    pub(super) fn placed(&self, parameters: &Parameters<f64>) -> Bodies<f64> {
        let mut bodies = self.kinematics.bodies.clone();
        bodies.place(&self.model.topology, parameters, &self.state.coordinates);
        bodies
    }

    /// Compares the present configuration with the reference and stores the result in the report.
    fn compare(
        &mut self,
        parameters: &Parameters<f64>,
        (reference, metric): (&Reference, &Metric<'_>),
        modes: &[Mode],
    ) {
        let bodies = &self.placed(parameters);
        self.report.distance = reference.distance(bodies, metric);
        self.report.farthest = reference
            .farthest(bodies, metric)
            .map(|(body, moved, turned)| (self.body_names[body].clone(), moved, turned));
        let is_other = |mode: &&Mode| metric.between(&mode.bodies, bodies) > SAME_MODE;
        self.report.other_modes = modes.iter().filter(is_other).map(|mode| mode.distance).collect();
    }

    /// Returns the number of prescribed coordinates and the mobility of the mechanism if the number
    /// exceeds the mobility.
    pub(super) fn over_prescribed(
        &mut self,
        parameters: &Parameters<f64>,
    ) -> Option<(usize, usize)> {
        self.kinematics.linearise(&self.model.topology, parameters, &self.model.constraints);
        let rows = self.model.constraints.row_scales(parameters.length);
        let (closures, dofs) = (self.model.topology.closures(), self.model.topology.dofs());
        let columns = column_scales(&self.model.topology, parameters.length);
        let all = self.kinematics.scaled_matrix(&self.model.constraints, &rows, &columns);
        let of_loops = all.entries().filter(|(row, ..)| *row < closures);
        let scaled = SparseMatrix::new((closures, dofs), of_loops);
        let rank = dof::decompose(scaled).rank();
        let (prescribed, mobility) = (self.model.constraints.coordinates().len(), dofs - rank);
        (prescribed > mobility).then_some((prescribed, mobility))
    }

    /// Collects the largest error of a loop or gearing and the largest deviations from prescribed
    /// coordinates, for the poses of the bodies that were computed last.
    pub(super) fn gap(&mut self, parameters: &Parameters<f64>) -> Gap {
        let prescribed = self.over_prescribed(parameters);
        let errors = self.kinematics.errors();
        let scale = parameters.length;
        let mut worst = Gap { prescribed, scale, ..Gap::default() };
        let size = |length: f64, angle: f64| length / scale + angle;
        let mut row = 0;
        for cut in &self.model.topology.cuts {
            let (mut length, mut angle) = (0.0_f64, 0.0_f64);
            for constraint in self.model.topology.joint_types[cut.joint].constraints() {
                let error = errors[row];
                if constraint.is_moment() {
                    angle = angle.hypot(error);
                } else {
                    length = length.hypot(error);
                }
                row += 1;
            }
            if worst.joint.is_none() || size(length, angle) > size(worst.length, worst.angle) {
                let joint = Some(self.joint_names[cut.joint].clone());
                worst = Gap { joint, length, angle, ..worst };
            }
        }
        for gearing in &self.model.topology.gearings {
            let error = errors[row].abs();
            row += 1;
            let (length, angle) = if gearing.is_length { (error, 0.0) } else { (0.0, error) };
            if worst.joint.is_none() || size(length, angle) > size(worst.length, worst.angle) {
                let first = self.model.topology.joint_types.len();
                let joint = Some(self.joint_names[first + gearing.gearing].clone());
                worst = Gap { joint, of_gearing: true, length, angle, ..worst };
            }
        }
        for (error, is_angle) in errors.iter().zip(self.model.constraints.are_angles()).skip(row) {
            let missed = if is_angle { &mut worst.missed_angle } else { &mut worst.missed_length };
            *missed = missed.max(error.abs());
        }
        worst
    }
}
