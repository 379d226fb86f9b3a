//! Elimination of the spanning tree with articulated-body inertias.
//!
//! Degrees of freedom are eliminated one at a time, from the leaves of the tree to its roots. In
//! exact arithmetic this is a sparse decomposition of the mass matrix of the tree, `M = L D L^T`,
//! whose factors are never formed. The quantities of each node refer to a point of the node, in
//! world axes, so that in long chains no digits are lost to large distances from the origin.

use crate::forward::mass_matrix::MassMatrix;
use crate::kinematics::Bodies;
use crate::linalg::{BLOCK, Part, add_outer, dot};
use crate::parameters::Parameters;
use crate::spatial::{Twist, Vec3, Wrench};
use crate::topology::{Link, Topology};

/// The articulated-body inertia along a DOF counts as round-off if it is below this fraction of the
/// inertia that the subtree would have as a rigid body.
const NEGLIGIBLE: f64 = 1e-11;

/// Articulated-body inertia as a 6 x 6 matrix: force and moment per linear and angular
/// acceleration.
type Inertia = [Part; BLOCK];

/// Factorised equations of motion of the spanning tree at one configuration (articulated-body
/// algorithm).
#[derive(Clone, Debug, Default)]
pub(in crate::forward) struct Articulated {
    /// Reference point of each node, world axes, m.
    points: Vec<Vec3<f64>>,
    /// Articulated-body inertia of each node about its reference point.
    inertia: Vec<Inertia>,
    /// Unit twist of each DOF about the reference point of its node, linear part first.
    screws: Vec<Part>,
    /// Articulated-body inertia times the unit twist of each DOF.
    momenta: Vec<Part>,
    /// Articulated-body inertia along each DOF; infinite for a prescribed DOF.
    pub(in crate::forward) pivots: Vec<f64>,
}

impl Articulated {
    /// Eliminates all DOFs of the spanning tree. DOFs whose acceleration is `prescribed` are not
    /// eliminated and act as rigid connections. Returns false if the articulated-body inertia along
    /// a DOF is zero or below round-off.
    pub(in crate::forward) fn update(
        &mut self,
        (topology, parameters): (&Topology, &Parameters<f64>),
        (bodies, masses): (&Bodies<f64>, &MassMatrix),
        prescribed: &[bool],
    ) -> bool {
        let n = topology.dofs();
        let Self { points, inertia, screws, momenta, pivots } = self;
        points.clear();
        inertia.clear();
        screws.clear();
        for node in &topology.nodes {
            let point = match node.link {
                Link::Joint { joint, .. } => bodies.frame_j[joint].position,
                Link::Floating => bodies.pose[node.body].position,
            };
            points.push(point);
            inertia.push(inertia_about(parameters, bodies, node.body, point));
            screws.extend(bodies.screws[node.tree_dofs.clone()].iter().map(|s| of_twist(s, point)));
        }
        momenta.clear();
        momenta.resize(n, [0.0; BLOCK]);
        pivots.clear();
        pivots.resize(n, f64::INFINITY);
        for (index, node) in topology.nodes.iter().enumerate().rev() {
            let mut own = inertia[index];
            for d in node.tree_dofs.clone().rev() {
                let momentum = own.map(|row| dot(&row, &screws[d]));
                momenta[d] = momentum;
                if prescribed[d] {
                    continue;
                }
                let pivot = dot(&momentum, &screws[d]);
                let screw = bodies.screws[d];
                let rigid = screw.power(masses.composite[node.body].times(screw));
                if !(pivot > NEGLIGIBLE * rigid && pivot.is_finite()) {
                    return false;
                }
                pivots[d] = pivot;
                add_outer(&mut own, &momentum.map(|x| -x / pivot), &momentum);
            }
            inertia[index] = own;
            if let (Link::Joint { .. }, Some(parent)) = (node.link, node.parent) {
                let arm = points[index] - points[parent];
                add_shifted(&mut inertia[parent], own, arm);
            }
        }
        true
    }

    /// Applies the forward elimination to the generalised forces of a wrench on a body. Calls `put`
    /// once for each DOF between the body and the root of its tree, with the index of the DOF and
    /// its reduced force.
    pub(in crate::forward) fn reduce(
        &self,
        topology: &Topology,
        body: usize,
        wrench: Wrench<f64>,
        mut put: impl FnMut(usize, f64),
    ) {
        let Some(mut index) = topology.node_of_body[body] else { return };
        let mut force = of_wrench(&wrench, self.points[index]);
        loop {
            let node = &topology.nodes[index];
            for d in node.tree_dofs.clone().rev() {
                let along = dot(&self.screws[d], &force);
                put(d, along);
                let amount = along / self.pivots[d];
                (0..BLOCK).for_each(|i| force[i] -= self.momenta[d][i] * amount);
            }
            let (Link::Joint { .. }, Some(parent)) = (node.link, node.parent) else { return };
            carry_force(&mut force, self.points[index] - self.points[parent]);
            index = parent;
        }
    }

    /// Forward elimination in the solution of `M a = forces`: reduces the generalised `forces` in
    /// place. `accelerations` contains the accelerations of prescribed DOFs, whose forces are not
    /// reduced. `carried` is a buffer for the wrench on each node.
    pub(in crate::forward) fn reduce_all(
        &self,
        topology: &Topology,
        accelerations: &[f64],
        forces: &mut [f64],
        carried: &mut Vec<Part>,
    ) {
        let Self { points, screws, momenta, pivots, .. } = self;
        carried.clear();
        carried.resize(topology.nodes.len(), [0.0; BLOCK]);
        for (index, node) in topology.nodes.iter().enumerate().rev() {
            let mut force = carried[index];
            for d in node.tree_dofs.clone().rev() {
                let amount = if pivots[d].is_finite() {
                    forces[d] -= dot(&screws[d], &force);
                    forces[d] / pivots[d]
                } else {
                    accelerations[d]
                };
                (0..BLOCK).for_each(|i| force[i] += momenta[d][i] * amount);
            }
            if let (Link::Joint { .. }, Some(parent)) = (node.link, node.parent) {
                carry_force(&mut force, points[index] - points[parent]);
                (0..BLOCK).for_each(|i| carried[parent][i] += force[i]);
            }
        }
    }

    /// Back substitution: computes the accelerations from the reduced forces, except for prescribed
    /// DOFs. `carried` is a buffer for the acceleration of each node.
    pub(in crate::forward) fn accelerate(
        &self,
        topology: &Topology,
        reduced: &[f64],
        accelerations: &mut [f64],
        carried: &mut Vec<Part>,
    ) {
        let Self { points, screws, momenta, pivots, .. } = self;
        carried.resize(topology.nodes.len(), [0.0; BLOCK]);
        for (index, node) in topology.nodes.iter().enumerate() {
            let mut motion = [0.0; BLOCK];
            if let (Link::Joint { .. }, Some(parent)) = (node.link, node.parent) {
                motion = carried[parent];
                carry_motion(&mut motion, points[index] - points[parent]);
            }
            for d in node.tree_dofs.clone() {
                if pivots[d].is_finite() {
                    accelerations[d] = (reduced[d] - dot(&momenta[d], &motion)) / pivots[d];
                }
                (0..BLOCK).for_each(|i| motion[i] += screws[d][i] * accelerations[d]);
            }
            carried[index] = motion;
        }
    }
}

/// Returns the 6 x 6 inertia of a body about a point, in world axes.
fn inertia_about(
    parameters: &Parameters<f64>,
    bodies: &Bodies<f64>,
    body: usize,
    point: Vec3<f64>,
) -> Inertia {
    let pose = bodies.pose[body];
    let (mass, com) = (parameters.mass[body], pose.apply(parameters.com[body]) - point);
    let about_com = pose.rotation * parameters.inertia[body] * pose.rotation.transpose();
    let mut block = [[0.0; BLOCK]; BLOCK];
    for k in 0..3 {
        let e: Vec3<f64> = Vec3::unit(k);
        let force = (e.cross(com) * mass).to_array();
        let moment = about_com * e + com.cross(e.cross(com)) * mass;
        block[k][k] = mass;
        for i in 0..3 {
            block[i][3 + k] = force[i];
            block[3 + k][i] = force[i];
            block[3 + i][3 + k] = moment.component(i);
        }
    }
    block
}

/// Adds `inertia` to `to`. The reference point of `inertia` lies at `arm` from the reference point
/// of `to`.
fn add_shifted(to: &mut Inertia, mut inertia: Inertia, arm: Vec3<f64>) {
    // Multiplies by the shift matrix `X` from both sides: `X^T I X`.
    for row in &mut inertia {
        carry_force(row, arm);
    }
    for j in 0..BLOCK {
        let mut column = inertia.map(|row| row[j]);
        carry_force(&mut column, arm);
        (0..BLOCK).for_each(|i| to[i][j] += column[i]);
    }
}

/// Moves the reference point of a wrench by `-arm`.
fn carry_force(force: &mut Part, arm: Vec3<f64>) {
    let moment = arm.cross(Vec3::new(force[0], force[1], force[2]));
    (0..3).for_each(|i| force[3 + i] += moment.component(i));
}

/// Moves the reference point of a twist or acceleration by `arm`.
fn carry_motion(motion: &mut Part, arm: Vec3<f64>) {
    let linear = Vec3::new(motion[3], motion[4], motion[5]).cross(arm);
    (0..3).for_each(|i| motion[i] += linear.component(i));
}

fn of_twist(twist: &Twist<f64>, point: Vec3<f64>) -> Part {
    let (v, w) = (twist.velocity_at(point), twist.angular);
    [v.x, v.y, v.z, w.x, w.y, w.z]
}

fn of_wrench(wrench: &Wrench<f64>, point: Vec3<f64>) -> Part {
    let (f, m) = (wrench.force, wrench.moment_about(point));
    [f.x, f.y, f.z, m.x, m.y, m.z]
}
