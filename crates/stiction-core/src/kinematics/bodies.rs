//! Forward kinematics: motion of all bodies from coordinates, rates and accelerations of the
//! spanning tree.
//!
//! Equations (K1) and (K2) of the book's theory.

use super::Target;
use super::kernel_program::Results;
use super::measure::{Difference, deviation};
use crate::joint::{Carrier, Dof, MOST_DOFS, Motion};
use crate::parameters::{InterfaceParameters, JointSpringParameters, Parameters};
use crate::scalar::Scalar;
use crate::spatial::{Pose, Quaternion, Twist, Vec3, Wrench};
use crate::topology::{Actuator, Cut, Link, Node, Topology};

/// Coordinates of the spanning tree with their rates and accelerations. They determine the motion
/// of all bodies.
#[derive(Debug, PartialEq)]
pub struct State<T> {
    /// Coordinates of the spanning tree, rad and m; orientations are unit quaternions.
    pub coordinates: Vec<T>,
    /// Rate of each degree of freedom of the spanning tree, rad/s or m/s.
    pub rates: Vec<T>,
    /// Acceleration of each degree of freedom of the spanning tree, rad/s^2 or m/s^2.
    pub accelerations: Vec<T>,
}

impl<T: Clone> Clone for State<T> {
    fn clone(&self) -> Self {
        let Self { coordinates, rates, accelerations } = self;
        Self {
            coordinates: coordinates.clone(),
            rates: rates.clone(),
            accelerations: accelerations.clone(),
        }
    }

    /// Copies `other` into the existing buffers, so that tracking does not allocate.
    fn clone_from(&mut self, other: &Self) {
        self.coordinates.clone_from(&other.coordinates);
        self.rates.clone_from(&other.rates);
        self.accelerations.clone_from(&other.accelerations);
    }
}

impl State<f64> {
    /// Returns a bound on the round-off of the largest coordinate. The bound grows with the number
    /// of full turns of a joint and with lengths.
    pub(crate) fn round_off(&self) -> f64 {
        let largest = self.coordinates.iter().fold(0.0_f64, |max, q| max.max(q.abs()));
        8.0 * f64::EPSILON * largest
    }

    /// Converts all numbers to constants of another scalar type.
    pub fn lift<T: Scalar>(&self) -> State<T> {
        let lift = |numbers: &[f64]| numbers.iter().map(|&x| T::from_f64(x)).collect();
        State {
            coordinates: lift(&self.coordinates),
            rates: lift(&self.rates),
            accelerations: lift(&self.accelerations),
        }
    }
}

impl<T: Scalar> State<T> {
    /// Creates the state at rest in which frame K of each joint of the spanning tree coincides with
    /// frame J.
    pub fn new(topology: &Topology) -> Self {
        let mut coordinates = vec![T::zero(); topology.coordinates()];
        for node in &topology.nodes {
            let q = &mut coordinates[node.coordinates.clone()];
            match node.link {
                Link::Joint { joint, .. } => topology.joint_types[joint].write_zero(q),
                Link::Floating => q[3] = T::one(),
            }
        }
        let zeros = vec![T::zero(); topology.dofs()];
        Self { coordinates, rates: zeros.clone(), accelerations: zeros }
    }

    /// Advances the coordinates by a small `step`, which contains one displacement (rad or m) per
    /// degree of freedom of the spanning tree.
    pub fn advance(&mut self, topology: &Topology, step: &[T]) {
        for node in &topology.nodes {
            let q = &mut self.coordinates[node.coordinates.clone()];
            let step = &step[node.tree_dofs.clone()];
            match node.link {
                Link::Joint { joint, .. } => topology.joint_types[joint].advance(q, step),
                Link::Floating => advance_floating(q, step),
            }
        }
    }
}

/// Advances the coordinates of a floating body by a small step: translation (m), then rotation
/// (rad), about the reference point in world axes.
fn advance_floating<T: Scalar>(q: &mut [T], step: &[T]) {
    let linear = Vec3::new(step[0], step[1], step[2]);
    let angular = Vec3::new(step[3], step[4], step[5]);
    let turn = Quaternion::of_small(angular);
    let position = turn.rotation() * Vec3::new(q[0], q[1], q[2]) + linear;
    q[..3].copy_from_slice(&position.to_array());
    turn.compose(Quaternion::from_coordinates(&q[3..])).normalised().write(&mut q[3..]);
}

/// Poses and motions of all bodies, in world axes about the reference point.
#[derive(Debug)]
pub struct Bodies<T> {
    /// Pose `X_WB` of each body's frame.
    pub pose: Vec<Pose<T>>,
    /// Twist of each body.
    pub twist: Vec<Twist<T>>,
    /// Time derivative of each body's twist.
    pub acceleration: Vec<Twist<T>>,
    /// Bias acceleration of each body: the part due to the rates, which remains if the
    /// accelerations of the spanning tree are zero.
    pub(crate) bias: Vec<Twist<T>>,
    /// Pose of frame J of each joint, which is fixed to the predecessor.
    pub frame_j: Vec<Pose<T>>,
    /// Pose of frame K of each joint, which is fixed to the successor.
    pub frame_k: Vec<Pose<T>>,
    /// Unit twist of each degree of freedom of the spanning tree: motion of the child body relative
    /// to its parent.
    pub(crate) screws: Vec<Twist<T>>,
    /// Coordinate of each joint spring, rad or m.
    pub(crate) spring_coordinates: Vec<T>,
}

impl<T: Clone> Clone for Bodies<T> {
    fn clone(&self) -> Self {
        let Self { pose, twist, acceleration, bias, frame_j, frame_k, screws, .. } = self;
        Self {
            pose: pose.clone(),
            twist: twist.clone(),
            acceleration: acceleration.clone(),
            bias: bias.clone(),
            frame_j: frame_j.clone(),
            frame_k: frame_k.clone(),
            screws: screws.clone(),
            spring_coordinates: self.spring_coordinates.clone(),
        }
    }

    /// Copies `other` into the existing buffers, so that simulations do not allocate.
    fn clone_from(&mut self, other: &Self) {
        self.pose.clone_from(&other.pose);
        self.twist.clone_from(&other.twist);
        self.acceleration.clone_from(&other.acceleration);
        self.bias.clone_from(&other.bias);
        self.frame_j.clone_from(&other.frame_j);
        self.frame_k.clone_from(&other.frame_k);
        self.screws.clone_from(&other.screws);
        self.spring_coordinates.clone_from(&other.spring_coordinates);
    }
}

impl<T: Scalar> Bodies<T> {
    /// Allocates the buffers for a mechanism.
    pub fn new(topology: &Topology) -> Self {
        let bodies = topology.node_of_body.len();
        let joints = topology.joint_types.len();
        Self {
            pose: vec![Pose::identity(); bodies],
            twist: vec![Twist::zero(); bodies],
            acceleration: vec![Twist::zero(); bodies],
            bias: vec![Twist::zero(); bodies],
            frame_j: vec![Pose::identity(); joints],
            frame_k: vec![Pose::identity(); joints],
            screws: vec![Twist::zero(); topology.dofs()],
            spring_coordinates: Vec::new(),
        }
    }

    /// Returns the pose of frame K in frame J for each joint.
    pub fn joint_poses(&self) -> impl Iterator<Item = Pose<T>> + '_ {
        self.frame_j.iter().zip(&self.frame_k).map(|(j, k)| j.inverse() * *k)
    }

    /// Computes the poses of bodies and joint frames, and the unit twists of the spanning tree's
    /// degrees of freedom.
    pub fn place(&mut self, topology: &Topology, parameters: &Parameters<T>, coordinates: &[T]) {
        self.pose[0] = parameters.ground;
        for node in &topology.nodes {
            self.place_node(topology, parameters, coordinates, node);
        }
        for cut in &topology.cuts {
            self.place_cut(topology, parameters, cut);
        }
        if !parameters.joint_springs.is_empty() {
            self.place_springs(topology, parameters, coordinates);
        }
    }

    /// Computes the pose of the body of a node and the frames of its joint, from the pose of its
    /// parent.
    #[inline]
    pub(super) fn place_node(
        &mut self,
        topology: &Topology,
        parameters: &Parameters<T>,
        coordinates: &[T],
        node: &Node,
    ) {
        let q = &coordinates[node.coordinates.clone()];
        match node.link {
            Link::Floating => {
                self.pose[node.body] = Pose {
                    position: Vec3::new(q[0], q[1], q[2]),
                    rotation: Quaternion::from_coordinates(&q[3..]).rotation(),
                };
                for (k, screw) in self.screws[node.tree_dofs.clone()].iter_mut().enumerate() {
                    *screw = floating_screw(k);
                }
            }
            Link::Joint { joint, reversed } => {
                let joint_type = topology.joint_types[joint];
                let pitch = parameters.pitch[joint];
                let across = joint_type.pose(q, pitch);
                let (predecessor, successor) = topology.ends[joint];
                let (in_j, in_k) = (parameters.frame_j[joint], parameters.frame_k[joint]);
                let (j, k);
                if reversed {
                    k = self.pose[successor] * in_k;
                    j = k * across.inverse();
                    self.pose[node.body] = j * in_j.inverse();
                } else {
                    j = self.pose[predecessor] * in_j;
                    k = j * across;
                    self.pose[node.body] = k * in_k.inverse();
                }
                (self.frame_j[joint], self.frame_k[joint]) = (j, k);
                let screws = &mut self.screws[node.tree_dofs.clone()];
                for (screw, dof) in screws.iter_mut().zip(joint_type.dofs()) {
                    let twist = dof.twist(&j, &k, pitch);
                    *screw = if reversed { -twist } else { twist };
                }
            }
        }
    }

    /// Computes the frames of a cut joint from the poses of its bodies.
    #[inline]
    pub(super) fn place_cut(&mut self, topology: &Topology, parameters: &Parameters<T>, cut: &Cut) {
        let (predecessor, successor) = topology.ends[cut.joint];
        self.frame_j[cut.joint] = self.pose[predecessor] * parameters.frame_j[cut.joint];
        self.frame_k[cut.joint] = self.pose[successor] * parameters.frame_k[cut.joint];
    }

    /// Computes the coordinates of the joint springs. Angles of joints in the spanning tree include
    /// full turns; angles of joints that close a loop are wrapped to within half a turn of the
    /// middle of their range.
    #[inline(never)]
    fn place_springs(&mut self, topology: &Topology, parameters: &Parameters<T>, tree: &[T]) {
        let mut places = std::mem::take(&mut self.spring_coordinates);
        places.clear();
        places.extend(parameters.joint_springs.iter().map(|spring| {
            let JointSpringParameters { joint, index, middle, .. } = *spring;
            if let Some(node) = topology.node_of(joint) {
                return tree[node.coordinates.start + index];
            }
            let relative = self.frame_j[joint].inverse() * self.frame_k[joint];
            let found =
                topology.joint_types[joint].nearest(relative, parameters.pitch[joint]).1[index];
            match spring.dof.motion {
                Motion::Rotation => middle + deviation(Difference::Angle, found, middle),
                Motion::Translation | Motion::Screw => found,
            }
        }));
        self.spring_coordinates = places;
    }

    /// Computes the twists and bias accelerations of all bodies at the configuration of the last
    /// [`Self::place`].
    pub fn move_with(&mut self, topology: &Topology, rates: &[T]) {
        for node in &topology.nodes {
            let parent = parent_body(topology, node.parent);
            let (mut twist, mut bias) = match node.link {
                Link::Floating => (Twist::zero(), Twist::zero()),
                Link::Joint { .. } => (self.twist[parent], self.bias[parent]),
            };
            for tree_dof in node.tree_dofs.clone() {
                twist += self.screws[tree_dof] * rates[tree_dof];
            }
            self.twist[node.body] = twist;
            if let Link::Joint { joint, reversed } = node.link {
                let dofs = topology.joint_types[joint].dofs();
                for (tree_dof, dof) in node.tree_dofs.clone().zip(dofs) {
                    // The child body is the successor unless the joint is traversed against its
                    // direction.
                    let by_child = (dof.carrier == Carrier::Successor) != reversed;
                    let carrier = if by_child { twist } else { self.twist[parent] };
                    bias += carrier.carry(self.screws[tree_dof]) * rates[tree_dof];
                }
            }
            self.bias[node.body] = bias;
        }
    }

    /// Computes the accelerations of all bodies, with the bias accelerations of the last
    /// [`Self::move_with`].
    pub fn accelerate(&mut self, topology: &Topology, accelerations: &[T]) {
        for node in &topology.nodes {
            // Accelerations without the bias add up along the tree.
            let parent = parent_body(topology, node.parent);
            let mut sum = match node.link {
                Link::Floating => Twist::zero(),
                Link::Joint { .. } => self.acceleration[parent] - self.bias[parent],
            };
            for tree_dof in node.tree_dofs.clone() {
                sum += self.screws[tree_dof] * accelerations[tree_dof];
            }
            self.acceleration[node.body] = self.bias[node.body] + sum;
        }
    }

    /// Increases the acceleration of each body by `amount` times the contribution of the given
    /// `accelerations` of the spanning tree.
    pub(crate) fn accelerate_more(&mut self, topology: &Topology, accelerations: &[T], amount: T) {
        // The bias does not change; contributions of the degrees of freedom add up along the tree.
        for node in &topology.nodes {
            let mut sum = Twist::zero();
            let mut next = Some(node);
            while let Some(node) = next {
                for tree_dof in node.tree_dofs.clone() {
                    sum += self.screws[tree_dof] * accelerations[tree_dof];
                }
                next = node.parent.map(|parent| &topology.nodes[parent]);
            }
            self.acceleration[node.body] += sum * amount;
        }
    }

    /// Computes the rates of a joint's degrees of freedom, rad/s or m/s, from the twists of its
    /// bodies.
    pub fn joint_rates(&self, topology: &Topology, joint: usize) -> [T; MOST_DOFS] {
        let (predecessor, successor) = topology.ends[joint];
        let relative = self.twist[successor] - self.twist[predecessor];
        let mut rates = [T::zero(); MOST_DOFS];
        let (j, k) = (&self.frame_j[joint], &self.frame_k[joint]);
        for (rate, dof) in rates.iter_mut().zip(topology.joint_types[joint].dofs()) {
            *rate = dof.rate_of(relative, j, k);
        }
        rates
    }

    /// Rate of an actuated degree of freedom, rad/s or m/s.
    pub(crate) fn actuator_rate(&self, topology: &Topology, actuator: Actuator) -> T {
        self.joint_rates(topology, actuator.joint)[actuator.dof]
    }

    /// Computes the sliding velocity of a friction interface along each of its degrees of freedom,
    /// m/s; `pitch` is the joint's pitch, m/rad.
    #[inline]
    pub fn surface_velocity(
        &self,
        topology: &Topology,
        interface: &InterfaceParameters<T>,
        pitch: T,
    ) -> [T; 3] {
        let rates = self.joint_rates(topology, interface.joint);
        let rates = &rates[interface.shape.dofs()];
        let mut surface = [T::zero(); 3];
        for ((velocity, arm), &rate) in surface.iter_mut().zip(interface.arms(pitch)).zip(rates) {
            *velocity = rate * arm;
        }
        surface
    }

    /// Computes the joint wrench due to the given efforts (N m or N) on the degrees of freedom of a
    /// friction interface.
    pub(crate) fn wrench_of(
        &self,
        topology: &Topology,
        interface: &InterfaceParameters<T>,
        efforts: [T; 3],
    ) -> Wrench<T> {
        let dofs = topology.joint_types[interface.joint].dofs();
        let mut sum = Wrench::zero();
        for (&effort, dof) in efforts.iter().zip(&dofs[interface.shape.dofs()]) {
            sum += self.effort(dof, interface.joint) * effort;
        }
        sum
    }

    /// Returns the joint wrench of a unit effort (1 N m or 1 N) on a degree of freedom.
    pub(crate) fn effort(&self, dof: &Dof, joint: usize) -> Wrench<T> {
        dof.effort(&self.frame_j[joint], &self.frame_k[joint])
    }

    /// Computes the rate and acceleration of a joint's degree of freedom. Returns both together
    /// with the coordinate, which the caller passes as `value`. Rate and acceleration are zero if
    /// the joint has no degree of freedom `dof`.
    pub fn joint_motion(
        &self,
        topology: &Topology,
        parameters: &Parameters<T>,
        (joint, dof): (usize, usize),
        value: T,
    ) -> Target<T> {
        let Some(own) = topology.joint_types[joint].dofs().get(dof) else {
            return Target { value, rate: T::zero(), acceleration: T::zero() };
        };
        let (predecessor, successor) = topology.ends[joint];
        let rates = self.joint_rates(topology, joint);
        let bias = self.joint_bias_at(topology, parameters, joint, rates);
        let relative = self.acceleration[successor] - self.acceleration[predecessor] - bias;
        Target {
            value,
            rate: rates[dof],
            acceleration: own.rate_of(relative, &self.frame_j[joint], &self.frame_k[joint]),
        }
    }

    /// Acceleration of a joint's successor relative to its predecessor that is due to the rates of
    /// the joint alone.
    pub(crate) fn joint_bias(
        &self,
        topology: &Topology,
        parameters: &Parameters<T>,
        joint: usize,
    ) -> Twist<T> {
        self.joint_bias_at(topology, parameters, joint, self.joint_rates(topology, joint))
    }

    /// Computes [`Self::joint_bias`] from known rates of the joint's degrees of freedom.
    fn joint_bias_at(
        &self,
        topology: &Topology,
        parameters: &Parameters<T>,
        joint: usize,
        rates: [T; MOST_DOFS],
    ) -> Twist<T> {
        let (predecessor, successor) = topology.ends[joint];
        let mut bias = Twist::zero();
        for (&rate, dof) in rates.iter().zip(topology.joint_types[joint].dofs()) {
            let carrier = match dof.carrier {
                Carrier::Predecessor => self.twist[predecessor],
                Carrier::Successor => self.twist[successor],
            };
            let (j, k) = (&self.frame_j[joint], &self.frame_k[joint]);
            bias += carrier.carry(dof.twist(j, k, parameters.pitch[joint])) * rate;
        }
        bias
    }
}

/// Order of the numbers in the results of a program, see [`Bodies::read`].
impl<T: Copy> Bodies<T> {
    /// Calls `put` with all numbers: first twists and accelerations, then places.
    pub(crate) fn write(&self, mut put: impl FnMut(&[T])) {
        for Twist { angular: a, linear: v } in
            self.twist.iter().chain(&self.acceleration).chain(&self.bias)
        {
            put(&[a.x, a.y, a.z, v.x, v.y, v.z]);
        }
        for pose in self.pose.iter().chain(&self.frame_j).chain(&self.frame_k) {
            let ([x, y, z], p) = (pose.rotation.columns, pose.position);
            put(&[x.x, x.y, x.z, y.x, y.y, y.z, z.x, z.y, z.z, p.x, p.y, p.z]);
        }
        for Twist { angular: a, linear: v } in &self.screws {
            put(&[a.x, a.y, a.z, v.x, v.y, v.z]);
        }
        put(&self.spring_coordinates);
    }
}

impl Bodies<f64> {
    /// Reads the numbers that [`Self::write`] puts: twists and accelerations; and, if `with_places`
    /// is true, poses of bodies and joint frames, unit twists, and coordinates of springs.
    pub(super) fn read(&mut self, numbers: &mut Results<'_>, with_places: bool) {
        let twist = |numbers: &mut Results<'_>| {
            let [a, b, c, u, v, w] = numbers.next();
            Twist { angular: Vec3::new(a, b, c), linear: Vec3::new(u, v, w) }
        };
        for own in self.twist.iter_mut().chain(&mut self.acceleration).chain(&mut self.bias) {
            *own = twist(numbers);
        }
        if !with_places {
            return;
        }
        let frames = self.frame_j.iter_mut().chain(&mut self.frame_k);
        for pose in self.pose.iter_mut().chain(frames) {
            let [a, b, c, d, e, f, g, h, i, x, y, z] = numbers.next();
            pose.rotation.columns = [Vec3::new(a, b, c), Vec3::new(d, e, f), Vec3::new(g, h, i)];
            pose.position = Vec3::new(x, y, z);
        }
        for own in &mut self.screws {
            *own = twist(numbers);
        }
        numbers.fill(&mut self.spring_coordinates);
    }
}

fn parent_body(topology: &Topology, parent: Option<usize>) -> usize {
    parent.map_or(0, |node| topology.nodes[node].body)
}

/// Unit twist of degree of freedom `k` of a floating body: translation along x, y, z for `k` from 0
/// to 2, rotation about x, y, z through the reference point for `k` from 3 to 5.
fn floating_screw<T: Scalar>(k: usize) -> Twist<T> {
    if k < 3 {
        Twist::translation(Vec3::unit(k))
    } else {
        Twist { angular: Vec3::unit(k - 3), linear: Vec3::zero() }
    }
}

/// Writes the coordinates `q` of a floating body with the given pose relative to the reference
/// point.
pub(crate) fn write_floating(pose: Pose<f64>, q: &mut [f64]) {
    q[..3].copy_from_slice(&pose.position.to_array());
    Quaternion::from_rotation(pose.rotation).write(&mut q[3..]);
}
