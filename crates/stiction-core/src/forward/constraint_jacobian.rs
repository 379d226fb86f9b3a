//! Constraints on the accelerations of the spanning tree: loop closures, gearings and constrained
//! DOFs.

use crate::kinematics::Bodies;
use crate::parameters::Parameters;
use crate::spatial::{Twist, Wrench};
use crate::topology::{Link, Role, Topology};

/// DOF of a joint whose acceleration is constrained, either by static friction or by an actuator
/// with prescribed motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ConstrainedDof {
    pub(super) joint: usize,
    pub(super) dof: usize,
    /// Acceleration that the DOF must have, rad/s^2 or m/s^2; zero under static friction.
    pub(super) acceleration: f64,
    /// True if an actuator constrains the DOF, false if static friction does.
    pub(super) actuated: bool,
    /// Estimated friction limit as an effort, divided by the largest friction limit of all
    /// interfaces; dimensionless, or m for a rotation. The value is 1 if an actuator constrains the
    /// DOF. Static frictions that are statically indeterminate are distributed relative to these
    /// limits.
    pub(super) scale: f64,
    /// Reference effort, N or N m. Statically indeterminate frictions deviate from their reference
    /// efforts as little as possible.
    pub(super) reference: f64,
}

impl ConstrainedDof {
    /// Creates the constraint of a DOF (joint, index in the joint) whose motion an actuator
    /// prescribes.
    pub(super) fn actuated((joint, dof): (usize, usize), acceleration: f64) -> Self {
        Self { joint, dof, acceleration, actuated: true, scale: 1.0, reference: 0.0 }
    }
}

/// DOF of a sticking interface, with its index among the constrained DOFs.
#[derive(Clone, Copy, Debug)]
pub(super) struct StickingDof {
    pub(super) interface: usize,
    /// Index of this DOF among the DOFs of the interface.
    pub(super) place: usize,
    /// Index in the list of [`ConstrainedDof`].
    pub(super) row: usize,
}

/// Row of the constraint equations: a unit wrench of a joint (a covector on the relative motion of
/// the two bodies), or a gearing.
#[derive(Clone, Debug)]
pub(super) struct ConstraintRow {
    /// Index of the joint. For a gearing, index of the first joint of the gearing.
    pub(super) joint: usize,
    /// Index of the DOF in the joint, if the row constrains a single DOF.
    pub(super) dof: Option<usize>,
    /// Index in [`Topology::gearings`] if the row is a gearing. The covector of a gearing is zero:
    /// a gearing acts on joints of the spanning tree, whose wrenches follow from the equilibrium of
    /// the bodies.
    pub(super) gearing: Option<usize>,
    /// Wrench that the predecessor exerts on the successor per unit of the multiplier of this row,
    /// world axes about the reference point.
    pub(super) covector: Wrench<f64>,
    /// Right-hand side: value that the product of this row with the accelerations of the spanning
    /// tree must have, m/s^2 or rad/s^2.
    pub(super) right: f64,
    /// True if the multiplier is the effort of a prescribed actuator.
    pub(super) actuated: bool,
    /// Relative friction limit, see [`ConstrainedDof::scale`], if the multiplier is a static
    /// friction; `None` for all other rows.
    pub(super) friction_scale: Option<f64>,
    /// Reference effort of a static friction, N or N m. Statically indeterminate frictions deviate
    /// from their reference efforts as little as possible.
    pub(super) reference: f64,
    /// Scale factor that makes residuals of angles and lengths comparable.
    pub(super) scale: f64,
}

impl ConstraintRow {
    /// Calls `of` for each entry of the row of the constraint Jacobian that can differ from zero,
    /// with the index of the DOF of the spanning tree.
    pub(super) fn each_entry(
        &self,
        (topology, parameters): (&Topology, &Parameters<f64>),
        bodies: &Bodies<f64>,
        mut of: impl FnMut(usize, f64),
    ) {
        match self.gearing {
            Some(gearing) => {
                topology.gearings[gearing].terms(parameters).for_each(|(d, entry)| of(d, entry));
            }
            None => each_dof(topology, self.joint, |tree_dof, sign| {
                of(tree_dof, sign * bodies.screws[tree_dof].power(self.covector));
            }),
        }
    }

    /// Returns the norm of the row of the constraint Jacobian, multiplied by its scale and each
    /// entry by the scale of its DOF, which `column` returns.
    pub(super) fn size(
        &self,
        at: (&Topology, &Parameters<f64>),
        bodies: &Bodies<f64>,
        column: impl Fn(usize) -> f64,
    ) -> f64 {
        let mut square = 0.0;
        self.each_entry(at, bodies, |tree_dof, entry| square += (entry * column(tree_dof)).powi(2));
        self.scale * square.sqrt()
    }
}

/// All constraint rows at one configuration and velocity.
#[derive(Clone, Debug, Default)]
pub(super) struct ConstraintRows {
    pub(super) rows: Vec<ConstraintRow>,
    /// Constraint Jacobian with respect to the DOFs of the spanning tree, row-major; see
    /// [`Self::fill_matrix`].
    pub(super) matrix: Vec<f64>,
}

impl ConstraintRows {
    /// Computes all rows and the constraint Jacobian, reusing the buffers. Beforehand
    /// [`Bodies::place`] must have set the poses of the bodies and, for the right-hand sides,
    /// [`Bodies::move_with`] their velocities.
    pub(super) fn update(
        &mut self,
        topology: &Topology,
        parameters: &Parameters<f64>,
        bodies: &Bodies<f64>,
        constrained: &[ConstrainedDof],
    ) {
        self.update_rows(topology, parameters, bodies, constrained);
        self.fill_matrix(topology, parameters, bodies);
    }

    /// Computes all rows without the constraint Jacobian, whose size is quadratic in the number of
    /// bodies.
    pub(super) fn update_rows(
        &mut self,
        topology: &Topology,
        parameters: &Parameters<f64>,
        bodies: &Bodies<f64>,
        constrained: &[ConstrainedDof],
    ) {
        let Self { rows, .. } = self;
        rows.clear();
        for cut in &topology.cuts {
            let joint = cut.joint;
            let (j, k) = (&bodies.frame_j[joint], &bodies.frame_k[joint]);
            let open = opening(topology, parameters, bodies, joint);
            for constraint in topology.joint_types[joint].constraints() {
                let covector = constraint.wrench(j, k, parameters.pitch[joint]);
                let scale = if constraint.is_moment() { 1.0 } else { 1.0 / parameters.length };
                let right = -open.power(covector);
                rows.push(ConstraintRow {
                    joint,
                    dof: None,
                    gearing: None,
                    covector,
                    right,
                    actuated: false,
                    friction_scale: None,
                    reference: 0.0,
                    scale,
                });
            }
        }
        for (index, gearing) in topology.gearings.iter().enumerate() {
            let first = topology.nodes[gearing.nodes[0]].link;
            rows.push(ConstraintRow {
                joint: if let Link::Joint { joint, .. } = first { joint } else { 0 },
                dof: None,
                gearing: Some(index),
                covector: Wrench::zero(),
                right: 0.0,
                actuated: false,
                friction_scale: None,
                reference: 0.0,
                scale: if gearing.is_length { 1.0 / parameters.length } else { 1.0 },
            });
        }
        for &ConstrainedDof { joint, dof, acceleration, actuated, scale, reference } in constrained
        {
            let place = dof;
            let dof = &topology.joint_types[joint].dofs()[place];
            let covector = bodies.effort(dof, joint);
            // The rate of a joint of the spanning tree is itself a rate of the tree.
            let right = match topology.role[joint] {
                Role::Tree { .. } => acceleration,
                Role::Cut { .. } => {
                    acceleration - opening(topology, parameters, bodies, joint).power(covector)
                }
            };
            rows.push(ConstraintRow {
                joint,
                dof: Some(place),
                gearing: None,
                covector,
                right,
                actuated,
                friction_scale: (!actuated).then_some(scale),
                reference,
                scale: if dof.translates() { 1.0 / parameters.length } else { 1.0 },
            });
        }
    }

    /// Computes the constraint Jacobian, one row for each constraint.
    pub(super) fn fill_matrix(
        &mut self,
        topology: &Topology,
        parameters: &Parameters<f64>,
        bodies: &Bodies<f64>,
    ) {
        let n = topology.dofs();
        let Self { rows, matrix } = self;
        matrix.clear();
        matrix.resize(rows.len() * n, 0.0);
        for (row, entries) in rows.iter().zip(matrix.chunks_exact_mut(n.max(1))) {
            row.each_entry((topology, parameters), bodies, |tree_dof, entry| {
                entries[tree_dof] = entry;
            });
        }
    }

    /// Returns the product of a constraint row with rates or accelerations of the spanning tree.
    /// Does not use the matrix of [`Self::fill_matrix`].
    pub(super) fn product(
        &self,
        (topology, parameters): (&Topology, &Parameters<f64>),
        bodies: &Bodies<f64>,
        index: usize,
        rates: &[f64],
    ) -> f64 {
        let mut sum = 0.0;
        self.rows[index].each_entry((topology, parameters), bodies, |tree_dof, entry| {
            sum += entry * rates[tree_dof];
        });
        sum
    }

    /// Writes the constraint Jacobian to `scaled`, with each row multiplied by its scale and each
    /// column by its entry in `columns`, reusing the buffer.
    pub(super) fn scale_into(&self, columns: &[f64], scaled: &mut Vec<f64>) {
        scaled.clone_from(&self.matrix);
        let each = self.rows.iter().zip(scaled.chunks_exact_mut(columns.len().max(1)));
        for (row, entries) in each {
            entries.iter_mut().zip(columns).for_each(|(entry, c)| *entry *= row.scale * c);
        }
    }
}

/// Calls `of` for each DOF of the spanning tree that changes the relative pose of the two bodies of
/// a joint, with the index of the DOF and the sign of the change, 1 or -1.
pub(super) fn each_dof(topology: &Topology, joint: usize, mut of: impl FnMut(usize, f64)) {
    match topology.role[joint] {
        Role::Cut { cut } => {
            for &(node, sign) in &topology.cuts[cut].path {
                topology.nodes[node].tree_dofs.clone().for_each(|tree_dof| of(tree_dof, sign));
            }
        }
        Role::Tree { node } => {
            let node = &topology.nodes[node];
            let reversed = matches!(node.link, Link::Joint { reversed: true, .. });
            let sign = if reversed { -1.0 } else { 1.0 };
            node.tree_dofs.clone().for_each(|tree_dof| of(tree_dof, sign));
        }
    }
}

/// Returns the relative acceleration of the two bodies of a joint at zero accelerations of the
/// spanning tree, minus the velocity-dependent acceleration that the joint allows. The constraint
/// rows must cancel this acceleration.
pub(super) fn opening(
    topology: &Topology,
    parameters: &Parameters<f64>,
    bodies: &Bodies<f64>,
    joint: usize,
) -> Twist<f64> {
    let (predecessor, successor) = topology.ends[joint];
    let own = bodies.joint_bias(topology, parameters, joint);
    bodies.bias[successor] - bodies.bias[predecessor] - own
}
