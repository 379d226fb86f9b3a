//! Force and moment balance of all bodies as one linear system. The unknowns are all constraint
//! reactions, gearing efforts and actuator efforts; each body except the ground has six equations.
//!
//! This simple but slow system serves as the test oracle of the kernels, and as the dense fallback
//! for statically indeterminate forces and infeasible loads.
//!
//! Source: the 42 equations (22) to (27) of Zhang et al. 2018, corrected and generalised to any mechanism.
//!
//! Equations (B1), (B2) and (B3) of the book's theory.

use super::load::AppliedLoad;
use crate::joint::JointType;
use crate::kinematics::Bodies;
use crate::linalg::SparseMatrix;
use crate::mechanism::Mechanism;
use crate::parameters::{Blocks, BushingParameters, Parameters, SpringParameters};
use crate::spatial::{Twist, Vec3, Wrench};
use crate::topology::Topology;
use nalgebra::DVector;
use std::collections::BTreeMap;

/// Unknown of the linear system: a constraint multiplier, an actuator effort or a gearing
/// multiplier.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unknown {
    /// Multiplier of one constraint wrench of a joint.
    Constraint {
        /// Index of the joint with this constraint.
        joint: usize,
        /// Index of the constraint among those of the joint's type.
        index: usize,
    },
    /// Effort of one actuator.
    Drive {
        /// Index of the actuator in [`Mechanism::actuators`].
        actuator: usize,
        /// Index of the joint that the actuator drives.
        joint: usize,
        /// Index, in the joint, of the degree of freedom that the actuator drives.
        dof: usize,
    },
    /// Multiplier of a gearing, in the order of [`Mechanism::gearings`]. The equation of the
    /// gearing is divided by its greatest coefficient.
    Gearing {
        /// Index of the gearing.
        gearing: usize,
    },
}

/// Wrench that an unknown of unit size causes at one joint.
#[derive(Clone, Copy, Debug)]
pub struct UnitWrench {
    /// Index of the unknown, which is also its column in the matrix.
    pub unknown: usize,
    /// Index of the joint that transmits the wrench.
    pub joint: usize,
    /// Wrench exerted by the predecessor on the successor, about the reference point.
    pub wrench: Wrench<f64>,
}

/// Linear system `matrix * unknowns = demand` of all bodies at one configuration. `demand` contains
/// the wrenches that the joints must exert on the bodies.
///
/// Rows: for each body except the ground, force x y z, then moment x y z about the centre of mass,
/// in world axes, N and N m.
#[derive(Clone, Debug)]
pub struct NewtonEuler {
    /// The unknowns, one for each column.
    pub unknowns: Vec<Unknown>,
    /// Unit wrenches in the order of the unknowns: one for each constraint and actuator effort, and
    /// one for each degree of freedom of a gearing.
    pub wrenches: Vec<UnitWrench>,
    /// Coefficients of the unknowns: one row for each equation, one column for each unknown.
    pub matrix: SparseMatrix,
    /// Predecessor and successor of all joints.
    ends: Vec<(usize, usize)>,
    /// Centres of mass relative to the reference point, world axes, m.
    com: Vec<Vec3<f64>>,
    length: f64,
    /// One flag for each gearing: true if the multiplier of the gearing is a moment, false if it is
    /// a force.
    moments: Vec<bool>,
    /// Compiled joint graph, which only the rates of spinning rotors require; `None` without such
    /// rotors.
    spinning: Option<Topology>,
}

impl NewtonEuler {
    /// Assembles the system at the current configuration of `bodies`.
    pub fn new(mechanism: &Mechanism, parameters: &Parameters<f64>, bodies: &Bodies<f64>) -> Self {
        let joints = mechanism.joints();
        let ends: Vec<_> = joints.iter().map(|j| (j.predecessor.0, j.successor.0)).collect();
        let com: Vec<_> =
            bodies.pose.iter().zip(&parameters.com).map(|(pose, com)| pose.apply(*com)).collect();
        let mut unknowns = Vec::new();
        let mut wrenches: Vec<UnitWrench> = Vec::new();
        for (joint, content) in joints.iter().enumerate() {
            let (j, k) = (&bodies.frame_j[joint], &bodies.frame_k[joint]);
            for (index, constraint) in content.joint_type.constraints().iter().enumerate() {
                let wrench = constraint.wrench(j, k, parameters.pitch[joint]);
                wrenches.push(UnitWrench { unknown: unknowns.len(), joint, wrench });
                unknowns.push(Unknown::Constraint { joint, index });
            }
        }
        let effort = |joint: usize, dof: usize| {
            let (j, k) = (&bodies.frame_j[joint], &bodies.frame_k[joint]);
            joints[joint].joint_type.dofs()[dof].effort(j, k)
        };
        let gearings = mechanism.gearings().iter().zip(&parameters.gearings).enumerate();
        for (gearing, (content, numbers)) in gearings {
            for (geared, &coefficient) in content.dofs.iter().zip(&numbers.coefficients) {
                let joint = geared.joint.0;
                let wrench = effort(joint, geared.dof) * coefficient;
                wrenches.push(UnitWrench { unknown: unknowns.len(), joint, wrench });
            }
            unknowns.push(Unknown::Gearing { gearing });
        }
        // Actuator efforts are the last unknowns.
        for (actuator, (joint, dof)) in mechanism.actuators().enumerate() {
            let joint = joint.0;
            let wrench = effort(joint, dof);
            wrenches.push(UnitWrench { unknown: unknowns.len(), joint, wrench });
            unknowns.push(Unknown::Drive { actuator, joint, dof });
        }
        let mut system = Self {
            matrix: SparseMatrix::default(),
            unknowns,
            wrenches,
            ends,
            com,
            length: parameters.length,
            moments: mechanism.gearings().iter().map(|gearing| !gearing.is_length()).collect(),
            spinning: (!parameters.rotors.is_empty()).then(|| Topology::new(mechanism)),
        };
        let size = (6 * (system.com.len() - 1), system.unknowns.len());
        let entries = system.wrenches.iter().flat_map(|unit| {
            let (predecessor, successor) = system.ends[unit.joint];
            let ends = [(successor, unit.wrench), (predecessor, -unit.wrench)];
            let moving = ends.into_iter().filter(|(body, _)| *body > 0);
            let com = &system.com;
            moving.flat_map(move |(body, wrench)| {
                let six = components(wrench, com[body]).into_iter().enumerate();
                six.map(move |(k, value)| (6 * (body - 1) + k, unit.unknown, value))
            })
        });
        system.matrix = SparseMatrix::new(size, entries);
        system
    }

    /// Centre of mass of a body relative to the reference point, world axes, m.
    pub fn com(&self, body: usize) -> Vec3<f64> {
        self.com[body]
    }

    /// Number of joints attached to each body.
    pub fn joints_at_bodies(&self) -> Vec<usize> {
        let mut counts = vec![0; self.com.len()];
        for &(predecessor, successor) in &self.ends {
            counts[predecessor] += 1;
            counts[successor] += 1;
        }
        counts
    }

    /// Number of joints attached to each body, without those of open chains: zero for a body of an
    /// open chain.
    pub(super) fn joints_of_loops(&self) -> Vec<usize> {
        let mut counts = self.joints_at_bodies();
        let mut joints_of = vec![Vec::new(); counts.len()];
        for (joint, &(predecessor, successor)) in self.ends.iter().enumerate() {
            joints_of[predecessor].push(joint);
            joints_of[successor].push(joint);
        }
        // Removing the body at the end of a chain may make its neighbour the end.
        let is_end = |counts: &[usize], body: usize| body != 0 && counts[body] == 1;
        let mut ends: Vec<usize> = (0..counts.len()).filter(|&b| is_end(&counts, b)).collect();
        let mut is_removed = vec![false; self.ends.len()];
        while let Some(body) = ends.pop() {
            let joint = joints_of[body].iter().find(|joint| !is_removed[**joint]);
            let Some(&joint) = joint else { continue };
            is_removed[joint] = true;
            let (predecessor, successor) = self.ends[joint];
            for body in [predecessor, successor] {
                counts[body] -= 1;
            }
            let neighbour = if predecessor == body { successor } else { predecessor };
            if is_end(&counts, neighbour) {
                ends.push(neighbour);
            }
        }
        counts
    }

    /// Adds a joint's wrench to `rows`, the equations of all bodies: `wrench` acts on the joint's
    /// successor, `-wrench` on its predecessor.
    pub fn add_joint_wrench(&self, rows: &mut DVector<f64>, joint: usize, wrench: Wrench<f64>) {
        let (predecessor, successor) = self.ends[joint];
        self.add_wrench(rows, successor, wrench);
        self.add_wrench(rows, predecessor, -wrench);
    }

    fn add_wrench(&self, rows: &mut DVector<f64>, body: usize, wrench: Wrench<f64>) {
        if body == 0 {
            return;
        }
        for (k, value) in components(wrench, self.com[body]).into_iter().enumerate() {
            rows[6 * (body - 1) + k] += value;
        }
    }

    /// Computes the wrenches that the joints must exert on each body: the rate of change of
    /// momentum, less the weight, external loads and spring forces. The rows are those of
    /// [`Self::matrix`].
    pub fn demand(
        &self,
        parameters: &Parameters<f64>,
        bodies: &Bodies<f64>,
        loads: &[AppliedLoad<f64>],
    ) -> DVector<f64> {
        let mut rows = DVector::zeros(self.matrix.nrows());
        for body in 1..self.com.len() {
            let rotation = nalgebra::Matrix3::from(bodies.pose[body].rotation);
            let inertia =
                rotation * nalgebra::Matrix3::from(parameters.inertia[body]) * rotation.transpose();
            let omega = nalgebra::Vector3::from(bodies.twist[body].angular);
            let alpha = nalgebra::Vector3::from(bodies.acceleration[body].angular);
            let moment = inertia * alpha + omega.cross(&(inertia * omega));
            let force = (self.acceleration_of_com(bodies, body) - parameters.gravity)
                * parameters.mass[body];
            let about_com = Wrench { force, moment: Vec3::from(moment) };
            let at_origin =
                Wrench { force, moment: about_com.moment + self.com[body].cross(force) };
            self.add_wrench(&mut rows, body, at_origin);
        }
        for load in loads {
            self.add_wrench(&mut rows, load.body.0, -load.wrench(bodies));
        }
        for (rotor, topology) in parameters.rotors.iter().zip(std::iter::repeat(&self.spinning)) {
            // Rate of change of the angular momentum along the rotor axis, which rotates with the
            // body.
            let Some(topology) = topology else { continue };
            let motion =
                bodies.joint_motion(topology, parameters, (rotor.joint, rotor.dof), f64::NAN);
            let axis = bodies.pose[rotor.body].rotation * rotor.axis;
            let turning = bodies.twist[rotor.body].angular.cross(axis);
            let moment = (axis * motion.acceleration + turning * motion.rate) * rotor.momentum;
            self.add_wrench(&mut rows, rotor.body, Wrench { force: Vec3::zero(), moment });
        }
        for spring in &parameters.springs {
            let pull = spring_forces(spring, bodies);
            for ((&body, point), force) in spring.ends.iter().zip(pull.points).zip(pull.forces) {
                self.add_wrench(&mut rows, body, -Wrench { force, moment: point.cross(force) });
            }
        }
        self.add_springs(&mut rows, parameters, bodies);
        rows
    }

    /// Adds the wrenches of joint springs and bushings to `rows`, the equations of the bodies.
    fn add_springs(
        &self,
        rows: &mut DVector<f64>,
        parameters: &Parameters<f64>,
        bodies: &Bodies<f64>,
    ) {
        for (spring, &coordinate) in parameters.joint_springs.iter().zip(&bodies.spring_coordinates)
        {
            let [from, to] = spring.ends;
            let (j, k) = (&bodies.frame_j[spring.joint], &bodies.frame_k[spring.joint]);
            let unit = spring.dof.effort(j, k);
            let rate = (bodies.twist[to] - bodies.twist[from]).power(unit);
            let elastic = spring.stiffness * (coordinate - spring.rest);
            let wrench = unit * (spring.preload - elastic - spring.damping * rate);
            self.add_wrench(rows, to, -wrench);
            self.add_wrench(rows, from, wrench);
        }
        for bushing in &parameters.bushings {
            let wrench = bushing_wrench(bushing, bodies);
            let [from, to] = bushing.ends;
            self.add_wrench(rows, to, -wrench);
            self.add_wrench(rows, from, wrench);
        }
    }

    fn acceleration_of_com(&self, bodies: &Bodies<f64>, body: usize) -> Vec3<f64> {
        // The second derivative of a body-fixed point c: a + alpha x c + omega x (v + omega x c).
        let Twist { angular: omega, linear: v } = bodies.twist[body];
        let Twist { angular: alpha, linear: a } = bodies.acceleration[body];
        let c = self.com[body];
        a + alpha.cross(c) + omega.cross(v + omega.cross(c))
    }

    /// Returns the dimensionless matrix. Rows of moments are divided by the characteristic length
    /// and columns of moments multiplied by it, so that singular values are comparable.
    pub fn scaled_matrix(&self, joint_types: &[JointType]) -> SparseMatrix {
        let rows: Vec<f64> = (0..self.matrix.nrows()).map(|row| self.row_scale(row)).collect();
        self.matrix.scaled(&rows, &self.column_scales(joint_types))
    }

    /// Returns, for each row, the index of the row's body among all bodies except the ground.
    pub(super) fn bodies_of_rows(&self) -> Vec<usize> {
        (0..self.matrix.nrows()).map(|row| row / 6).collect()
    }

    /// Returns, for each unknown, the index of its joint or gearing; indices of gearings follow
    /// those of the joints.
    pub(super) fn joints_of_unknowns(&self) -> Vec<usize> {
        let joint = |unknown: &Unknown| match *unknown {
            Unknown::Constraint { joint, .. } | Unknown::Drive { joint, .. } => joint,
            Unknown::Gearing { gearing } => self.ends.len() + gearing,
        };
        self.unknowns.iter().map(joint).collect()
    }

    /// Returns the factor by which [`Self::scaled_matrix`] multiplies a row.
    pub fn row_scale(&self, row: usize) -> f64 {
        if row % 6 < 3 { 1.0 } else { 1.0 / self.length }
    }

    /// Returns the factors by which [`Self::scaled_matrix`] multiplies the columns.
    pub fn column_scales(&self, joint_types: &[JointType]) -> Vec<f64> {
        let is_moment = |unknown: &Unknown| match *unknown {
            Unknown::Constraint { joint, index } => {
                joint_types[joint].constraints()[index].is_moment()
            }
            Unknown::Drive { joint, dof, .. } => !joint_types[joint].dofs()[dof].translates(),
            Unknown::Gearing { gearing } => self.moments[gearing],
        };
        self.unknowns.iter().map(|u| if is_moment(u) { self.length } else { 1.0 }).collect()
    }

    /// Computes the wrenches of the joints loaded by the given unknowns, as pairs of joint index
    /// and wrench in the order of the joints. `unknowns` are pairs of index and value, in ascending
    /// order of the indices.
    pub(super) fn sparse_wrenches(
        &self,
        unknowns: impl Iterator<Item = (usize, f64)>,
    ) -> Vec<(usize, Wrench<f64>)> {
        let mut sums = BTreeMap::new();
        for (unknown, value) in unknowns {
            let first = self.wrenches.partition_point(|unit| unit.unknown < unknown);
            for unit in self.wrenches[first..].iter().take_while(|unit| unit.unknown == unknown) {
                *sums.entry(unit.joint).or_insert(Wrench::zero()) += unit.wrench * value;
            }
        }
        sums.into_iter().collect()
    }

    /// Computes the total wrench of each joint from the values of all unknowns and the friction
    /// wrench of each joint.
    pub fn joint_wrenches(
        &self,
        unknowns: &DVector<f64>,
        friction: &[Wrench<f64>],
    ) -> Vec<Wrench<f64>> {
        let mut sums = friction.to_vec();
        for unit in &self.wrenches {
            sums[unit.joint] += unit.wrench * unknowns[unit.unknown];
        }
        sums
    }
}

/// Returns the components of a wrench: force x y z, then moment x y z about the centre of mass
/// `com`.
fn components(wrench: Wrench<f64>, com: Vec3<f64>) -> [f64; 6] {
    let (force, moment) = (wrench.force, wrench.moment_about(com));
    [force.x, force.y, force.z, moment.x, moment.y, moment.z]
}

/// Positions of the two ends of a spring relative to the reference point, in world axes, and the
/// forces on these ends.
struct SpringForces {
    points: [Vec3<f64>; 2],
    forces: [Vec3<f64>; 2],
}

/// Computes the forces of a linear spring with a damper. The code is independent of the kernels, so
/// that tests can compare both.
fn spring_forces(spring: &SpringParameters<f64>, bodies: &Bodies<f64>) -> SpringForces {
    let end = |k: usize| {
        let body = spring.ends[k];
        let Twist { angular, linear } = bodies.twist[body];
        let point = bodies.pose[body].apply(spring.points[k]);
        (nalgebra::Vector3::from(point), nalgebra::Vector3::from(linear + angular.cross(point)))
    };
    let ((a, velocity_a), (b, velocity_b)) = (end(0), end(1));
    let (from_a_to_b, length) = ((b - a), (b - a).norm());
    let mut force_on_a = from_a_to_b * spring.stiffness;
    if length > 0.0 {
        let direction = from_a_to_b / length;
        let rate = (velocity_b - velocity_a).dot(&direction);
        let offset = spring.stiffness * spring.free_length + spring.preload;
        force_on_a += direction * (spring.damping * rate - offset);
    }
    let force = Vec3::from(force_on_a);
    SpringForces { points: [a.into(), b.into()], forces: [force, -force] }
}

/// Computes the wrench of a bushing on its second body. The code is independent of the kernels, so
/// that tests can compare both: it uses nalgebra's logarithm of rotations, and a closed form of the
/// inverse Jacobian of the rotation vector.
fn bushing_wrench(bushing: &BushingParameters<f64>, bodies: &Bodies<f64>) -> Wrench<f64> {
    use nalgebra::{Matrix3, Rotation3, Vector3};
    let [from, to] = bushing.ends;
    let (a, b) = (bodies.pose[from] * bushing.frames[0], bodies.pose[to] * bushing.frames[1]);
    let (axes, other) = (Matrix3::from(a.rotation), Matrix3::from(b.rotation));
    let (at_a, at_b) = (Vector3::from(a.position), Vector3::from(b.position));
    let relative = bodies.twist[to] - bodies.twist[from];
    let omega = Vector3::from(relative.angular);
    let velocity = Vector3::from(relative.linear) + omega.cross(&at_b);
    let turn = Rotation3::from_matrix_unchecked(axes.transpose() * other).scaled_axis();
    let displacement = axes.transpose() * (at_b - at_a);
    let angle = turn.norm();
    let cross = turn.cross_matrix();
    // The rate of the rotation vector is J^-1 omega, with omega in the axes of the first frame.
    let factor = match angle > 1e-4 {
        true => 1.0 / (angle * angle) - (0.5 * angle).tan().recip() / (2.0 * angle),
        false => 1.0 / 12.0,
    };
    let inverse = Matrix3::identity() - cross * 0.5 + cross * cross * factor;
    let parts =
        |blocks: &Blocks<f64>| [blocks.force, blocks.coupling, blocks.moment].map(Matrix3::from);
    let [force, coupling, moment] = parts(&bushing.stiffness);
    let (elastic, gradient) = (
        force * displacement + coupling * turn,
        coupling.transpose() * displacement + moment * turn,
    );
    let (v, w) = (axes.transpose() * velocity, axes.transpose() * omega);
    let [force, coupling, moment] = parts(&bushing.damping);
    let pull = axes * (elastic + force * v + coupling * w);
    let twist = axes * (inverse.transpose() * gradient + coupling.transpose() * v + moment * w);
    let total = twist + at_b.cross(&pull);
    -Wrench { force: Vec3::from(pull), moment: Vec3::from(total) }
}
