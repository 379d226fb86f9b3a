//! Projection of configurations and velocities onto the loop constraints and constrained DOFs.

use super::Forward;
use super::balance::DEPENDENT;
use super::constraint_jacobian::{ConstrainedDof, ConstraintRows};
use super::error::ForwardError;
use super::inputs::joint_coordinate;
use super::sparse::rows::SparseRows;
use crate::kinematics::{Bodies, Coordinate, State, Target, deviation, difference};
use crate::linalg::RowSpace;
use crate::mechanism::JointId;
use crate::spatial::{Pose, Quaternion, Twist};
use crate::topology::{Link, Role};

/// Loops count as closed if every closure error is below this value, rad; length errors are divided
/// by the characteristic length.
const CLOSED: f64 = 1e-14;
/// Loops count as open if a closure error exceeds this value, rad; length errors are divided by the
/// characteristic length.
const OPEN: f64 = 1e-9;
/// If locked DOFs leave a closure error of at most this value, they may yield to the loops, rad or
/// characteristic lengths.
pub(super) const YIELDS: f64 = 1e-7;
/// Largest number of Newton steps to close the loops.
const STEPS: usize = 10;

/// Relative pose at which static friction locks a DOF of a joint.
#[derive(Clone, Copy, Debug)]
pub(super) struct Anchor {
    pub(super) joint: usize,
    pub(super) dof: usize,
    /// Pose of frame K in frame J at stick onset, `X_JK`.
    pub(super) pose: Pose<f64>,
}

/// If a correction is below this value, rad or characteristic lengths, and the singularity index
/// exceeds [`REGULAR`], the next correction reuses the present decomposition. The resulting error
/// is of second order.
const SMALL: f64 = 1e-9;
/// Singularity index above which a decomposition may be reused.
const REGULAR: f64 = 0.2;

/// Buffers for [`Forward::project_in`].
#[derive(Clone, Debug)]
pub(super) struct Projection {
    bodies: Bodies<f64>,
    constrained: Vec<ConstrainedDof>,
    rows: ConstraintRows,
    errors: Vec<f64>,
    scaled: Vec<f64>,
    space: RowSpace,
    /// Sparse decomposition of the constraint rows; `None` if the model uses only dense linear
    /// algebra.
    sparse: Option<SparseRows>,
    /// True if the sparse decomposition is valid at the present configuration.
    is_sparse: bool,
    values: Vec<f64>,
    step: Vec<f64>,
}

impl Projection {
    /// Allocates the buffers for a model.
    pub(super) fn new(model: &Forward) -> Self {
        Self {
            bodies: Bodies::new(&model.topology),
            constrained: Vec::new(),
            rows: ConstraintRows::default(),
            errors: Vec::new(),
            scaled: Vec::new(),
            space: RowSpace::default(),
            sparse: SparseRows::new(model),
            is_sparse: false,
            values: Vec::new(),
            step: Vec::new(),
        }
    }

    /// Decomposes the constraint rows, restricted to the DOFs that are not `frozen`.
    fn decompose(&mut self, model: &Forward, frozen: &[bool]) {
        let Self { bodies, rows, scaled, space, sparse, is_sparse, .. } = self;
        *is_sparse = sparse.as_mut().is_some_and(|s| s.decompose(model, bodies, rows, frozen));
        if *is_sparse {
            return;
        }
        rows.fill_matrix(&model.topology, &model.parameters, bodies);
        freeze(rows, frozen);
        rows.scale_into(&model.columns, scaled);
        space.decompose(scaled, rows.rows.len(), model.columns.len(), DEPENDENT);
    }

    /// Exchanges `bodies` with the bodies placed at the state of the last successful projection.
    pub(super) fn swap_bodies(&mut self, bodies: &mut Bodies<f64>) {
        core::mem::swap(&mut self.bodies, bodies);
    }

    /// Returns the singularity index of the constraint rows, between zero and one.
    fn distance(&self) -> f64 {
        let sparse = self.sparse.as_ref().filter(|_| self.is_sparse);
        sparse.map_or_else(|| self.space.least_part(), SparseRows::distance)
    }

    /// Returns the number of independent constraint rows.
    fn rank(&self) -> usize {
        let sparse = self.sparse.as_ref().filter(|_| self.is_sparse);
        sparse.map_or_else(|| self.space.rank(), SparseRows::rank)
    }

    /// Returns the singularity index of the last projection. Returns `None` if it constrained more
    /// than the loops, or if constraints are redundant.
    pub(super) fn distance_of_loops(&self) -> Option<f64> {
        let count = self.rows.rows.len();
        let is_regular = self.constrained.is_empty() && self.rank() == count;
        is_regular.then(|| self.distance())
    }

    /// Computes the minimum-norm change of the tree coordinates (`step`) for which the products of
    /// the constraint rows with the change equal `values`.
    fn shortest(&mut self, columns: &[f64]) {
        let Self { rows, space, sparse, is_sparse, values, step, .. } = self;
        if let Some(sparse) = sparse.as_mut().filter(|_| *is_sparse) {
            sparse.shortest(columns, values, step);
            return;
        }
        values.iter_mut().zip(&rows.rows).for_each(|(v, r)| *v *= r.scale);
        space.shortest_into(values, step);
        step.iter_mut().zip(columns).for_each(|(s, c)| *s *= c);
    }
}

impl Forward {
    /// Projects a state onto the constraints: closes the loops, moves constrained DOFs to their
    /// prescribed or locked positions, and removes the component of the rates that violates the
    /// constraints. `frozen` DOFs of the spanning tree keep their coordinates, and their rates
    /// become zero.
    ///
    /// # Errors
    /// [`ForwardError::Open`] if the loops cannot be closed.
    pub(super) fn project(
        &self,
        time: f64,
        state: &mut State<f64>,
        targets: &[Target<f64>],
        anchors: &[Anchor],
        frozen: &[bool],
    ) -> Result<(), ForwardError> {
        self.project_in(time, state, targets, (anchors, frozen), &mut Projection::new(self))
    }

    /// Projects a state like [`Self::project`], reusing the buffers.
    ///
    /// # Errors
    /// See [`Self::project`].
    pub(super) fn project_in(
        &self,
        time: f64,
        state: &mut State<f64>,
        targets: &[Target<f64>],
        (anchors, frozen): (&[Anchor], &[bool]),
        workspace: &mut Projection,
    ) -> Result<(), ForwardError> {
        self.normalise(state);
        self.constrain_anchors(targets, anchors, &mut workspace.constrained);
        let mut best = f64::INFINITY;
        let mut decomposed = false;
        for step in 0..=STEPS {
            self.close(state, targets, anchors, workspace);
            let sizes = workspace.errors.iter().zip(&workspace.rows.rows);
            let sizes = sizes.map(|(e, row)| (e * row.scale).abs());
            let (mut worst, mut at) = (0.0, 0);
            for (row, size) in sizes.enumerate() {
                if size > worst || size.is_nan() {
                    (worst, at) = (size, row);
                }
            }
            let round_off = state.coordinates.iter().fold(0.0_f64, |m, q| m.max(q.abs()));
            let closed = worst <= CLOSED.max(4.0 * f64::EPSILON * round_off);
            let ends = closed
                || step == STEPS
                || (worst < 1e-12 && worst > 0.5 * best)
                || !worst.is_finite();
            if ends && (worst >= OPEN || worst.is_nan()) {
                let joint = self.joint_name(workspace.rows.rows[at].joint);
                return Err(ForwardError::Open { time, joint, gap: workspace.errors[at].abs() });
            }
            if !decomposed {
                workspace.decompose(self, frozen);
            }
            if ends {
                self.project_rates(state, targets, frozen, workspace);
                return Ok(());
            }
            best = worst;
            workspace.values.clone_from(&workspace.errors);
            workspace.shortest(&self.columns);
            workspace.step.iter_mut().for_each(|s| *s = -*s);
            let mut largest = 0.0_f64;
            for ((step, frozen), column) in workspace.step.iter_mut().zip(frozen).zip(&self.columns)
            {
                if *frozen {
                    *step = 0.0;
                }
                largest = largest.max((*step / column).abs());
            }
            decomposed = largest < SMALL && workspace.distance() > REGULAR;
            state.advance(&self.topology, &workspace.step);
        }
        Ok(())
    }

    /// Projects a state like [`Self::project`]. If the locks leave a small closure error, they yield to
    /// the loops, and the result is true: after a jump, sticking joints may be locked at positions that
    /// contradict the loops a little. Static friction holds the joints wherever the loops close.
    ///
    /// # Errors
    /// See [`Self::project`].
    pub(super) fn project_yielding(
        &self,
        time: f64,
        state: &mut State<f64>,
        targets: &[Target<f64>],
        (anchors, frozen): (&[Anchor], &[bool]),
    ) -> Result<bool, ForwardError> {
        let mut workspace = Projection::new(self);
        let is_locked = !anchors.is_empty() || frozen.contains(&true);
        let largest = YIELDS * self.parameters.length.min(1.0);
        match self.project_in(time, state, targets, (anchors, frozen), &mut workspace) {
            Ok(()) => return Ok(false),
            Err(ForwardError::Open { gap, .. }) if is_locked && gap < largest => {}
            Err(error) => return Err(error),
        }
        let free = vec![false; frozen.len()];
        self.project_in(time, state, targets, (&[], &free), &mut workspace)?;
        self.constrain_anchors(targets, anchors, &mut workspace.constrained);
        self.close(state, targets, anchors, &mut workspace);
        workspace.decompose(self, frozen);
        self.project_rates(state, targets, frozen, &mut workspace);
        Ok(true)
    }

    /// Writes to `constrained` the DOFs that the projection constrains: first the DOFs of actuators
    /// with prescribed motion, then the anchored DOFs of cut joints.
    fn constrain_anchors(
        &self,
        targets: &[Target<f64>],
        anchors: &[Anchor],
        constrained: &mut Vec<ConstrainedDof>,
    ) {
        let prescribed = self.prescribed.iter().zip(targets).map(|(&actuator, _)| {
            let actuator = self.topology.actuators[actuator];
            (actuator.joint, actuator.dof)
        });
        let anchored = self.cut_anchors(anchors).map(|anchor| (anchor.joint, anchor.dof));
        constrained.clear();
        constrained.extend(prescribed.chain(anchored).map(|at| ConstrainedDof::actuated(at, 0.0)));
    }

    /// Returns the anchors of cut joints.
    fn cut_anchors<'a>(&self, anchors: &'a [Anchor]) -> impl Iterator<Item = &'a Anchor> {
        anchors.iter().filter(|a| matches!(self.topology.role[a.joint], Role::Cut { .. }))
    }

    /// Computes the constraint rows of loops and constrained DOFs at a state, and the position
    /// error of each row, m or rad.
    fn close(
        &self,
        state: &State<f64>,
        targets: &[Target<f64>],
        anchors: &[Anchor],
        workspace: &mut Projection,
    ) {
        let (topology, parameters) = (&self.topology, &self.parameters);
        let Projection { bodies, constrained, rows, errors, .. } = workspace;
        bodies.place(topology, parameters, &state.coordinates);
        bodies.move_with(topology, &state.rates);
        rows.update_rows(topology, parameters, bodies, constrained);
        errors.clear();
        for cut in &topology.cuts {
            let (j, k) = (bodies.frame_j[cut.joint], bodies.frame_k[cut.joint]);
            let joint_type = topology.joint_types[cut.joint];
            let (misfit, _) = joint_type.misfit(j.inverse() * k, parameters.pitch[cut.joint]);
            errors.extend(&misfit[..joint_type.constraints().len()]);
        }
        errors
            .extend(topology.gearings.iter().map(|own| own.error(parameters, &state.coordinates)));
        for (target, &ConstrainedDof { joint, dof, .. }) in targets.iter().zip(&*constrained) {
            let at = (joint, dof);
            let found = joint_coordinate((topology, &parameters.pitch), state, bodies, at);
            let coordinate = Coordinate::Joint { joint: JointId(joint), dof };
            errors.push(deviation(difference(topology, coordinate), found, target.value));
        }
        errors.extend(self.cut_anchors(anchors).map(|anchor| self.displacement(bodies, anchor)));
    }

    /// Sets the rates of frozen DOFs to zero and removes the component of the other rates that
    /// violates the constraints.
    fn project_rates(
        &self,
        state: &mut State<f64>,
        targets: &[Target<f64>],
        frozen: &[bool],
        workspace: &mut Projection,
    ) {
        for (rate, frozen) in state.rates.iter_mut().zip(frozen) {
            if *frozen {
                *rate = 0.0;
            }
        }
        let first = self.topology.closures();
        let Projection { bodies, rows, values, .. } = workspace;
        values.clear();
        let of = (&*self.topology, &self.parameters);
        let each = 0..rows.rows.len();
        values.extend(each.map(|row| -rows.product(of, bodies, row, &state.rates)));
        for (value, target) in values[first..].iter_mut().zip(targets) {
            *value += target.rate;
        }
        workspace.shortest(&self.columns);
        for ((rate, step), frozen) in state.rates.iter_mut().zip(&workspace.step).zip(frozen) {
            if !frozen {
                *rate += step;
            }
        }
    }

    /// Returns the displacement, rad or m, of an anchored DOF of a cut joint from its position at
    /// stick onset.
    fn displacement(&self, bodies: &Bodies<f64>, anchor: &Anchor) -> f64 {
        let (j, k) = (bodies.frame_j[anchor.joint], bodies.frame_k[anchor.joint]);
        let relative = j.inverse() * k;
        let turn = relative.rotation * anchor.pose.rotation.transpose();
        let angular = j.rotation * turn.rotation_vector();
        let at_j = j.rotation * (relative.position - turn * anchor.pose.position);
        let twist = Twist { angular, linear: at_j - angular.cross(j.position) };
        let dof = &self.topology.joint_types[anchor.joint].dofs()[anchor.dof];
        twist.power(bodies.effort(dof, anchor.joint))
    }

    /// Normalises all quaternions in a state.
    fn normalise(&self, state: &mut State<f64>) {
        for node in &self.topology.nodes {
            let q = &mut state.coordinates[node.coordinates.clone()];
            if let Some(at) = quaternion_at(&self.topology, &node.link) {
                let unit = Quaternion::from_coordinates(&q[at..]).normalised();
                unit.write(&mut q[at..]);
            }
        }
    }

    /// Writes the time derivatives of the coordinates of the spanning tree to `out`. Rotations of
    /// spherical (S) joints, free joints and floating bodies are described by quaternions, so these
    /// derivatives differ from the rates.
    pub(super) fn coordinate_rates(&self, coordinates: &[f64], rates: &[f64], out: &mut [f64]) {
        use crate::spatial::Vec3;
        for node in &self.topology.nodes {
            let q = &coordinates[node.coordinates.clone()];
            let v = &rates[node.tree_dofs.clone()];
            let out = &mut out[node.coordinates.clone()];
            let Some(at) = quaternion_at(&self.topology, &node.link) else {
                out.copy_from_slice(v);
                continue;
            };
            let omega = Vec3::new(v[at], v[at + 1], v[at + 2]);
            let pure = Quaternion { w: 0.0, v: omega * 0.5 };
            let now = Quaternion::from_coordinates(&q[at..]);
            // The angular velocity is in world axes for a floating body, and in the axes of the
            // successor for a joint.
            let change = match node.link {
                Link::Floating => pure.compose(now),
                Link::Joint { .. } => now.compose(pure),
            };
            change.write(&mut out[at..]);
            if at == 3 {
                let linear = Vec3::new(v[0], v[1], v[2]);
                let linear = match node.link {
                    Link::Floating => linear + omega.cross(Vec3::new(q[0], q[1], q[2])),
                    Link::Joint { .. } => linear,
                };
                out[..3].copy_from_slice(&linear.to_array());
            }
        }
    }
}

/// Sets the columns of frozen DOFs in the constraint Jacobian to zero.
fn freeze(rows: &mut ConstraintRows, frozen: &[bool]) {
    for entries in rows.matrix.chunks_exact_mut(frozen.len().max(1)) {
        for (entry, frozen) in entries.iter_mut().zip(frozen) {
            if *frozen {
                *entry = 0.0;
            }
        }
    }
}

/// Returns the index of the first quaternion component among the coordinates of a node; `None` if
/// the node has no quaternion.
fn quaternion_at(topology: &crate::topology::Topology, link: &Link) -> Option<usize> {
    use crate::joint::JointType;
    match *link {
        Link::Floating => Some(3),
        Link::Joint { joint, .. } => match topology.joint_types[joint] {
            JointType::Spherical => Some(0),
            JointType::Free => Some(3),
            _ => None,
        },
    }
}
