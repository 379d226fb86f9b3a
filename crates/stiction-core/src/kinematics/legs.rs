//! Closed-form solutions for the coordinates of legs.
//!
//! A leg is a chain of joints from its root (the ground or a floating body) to a cut joint (S, U,
//! R). The cut joint connects the last body of the leg to the ground or to another floating body.
//! The poses of the root body and of this other body determine the position of the cut joint's
//! point in the root's frame. The coordinates of the leg then follow one after the other from
//! distances and heights that each depend on a single coordinate (subproblems in the sense of Paden
//! 1986 and Kahan). The rule and the solution branch for each coordinate are selected by trial,
//! such that they reproduce the coordinates of known configurations.
//!
//! Equation (K7) of the book's theory.

use super::Bodies;
use crate::joint::JointType;
use crate::mechanism::BodyId;
use crate::parameters::Parameters;
use crate::scalar::Scalar;
use crate::spatial::{Mat3, Pose, Vec3};
use crate::topology::{Link, Topology};
use core::ops::Range;

/// Largest accepted difference between a computed coordinate and its known value, rad or
/// characteristic lengths.
const SAME: f64 = 1e-7;

/// Closed-form solutions for the legs of a mechanism.
#[derive(Clone, Debug, Default)]
pub struct Legs {
    legs: Vec<Leg>,
}

/// One coordinate of a leg: a rotation about an axis of the element's frame, or a translation
/// along this axis.
#[derive(Clone, Copy, Debug)]
struct Element {
    axis: usize,
    slides: bool,
    /// Sign of the coordinate: -1 for a joint traversed against its direction, otherwise 1.
    sign: f64,
    /// Index of this coordinate among the coordinates of the spanning tree.
    coordinate: usize,
}

#[derive(Clone, Debug)]
struct Leg {
    /// Spanning-tree nodes of the leg's bodies, from the root outwards.
    nodes: Vec<usize>,
    elements: Vec<Element>,
    root: usize,
    end: usize,
    cut: usize,
    /// True if the cut joint's successor is the last body of the leg.
    ends_in_successor: bool,
    choices: Vec<Choice>,
}

/// Rule that determines either the first or the last of a leg's coordinates that are still
/// unknown.
#[derive(Clone, Copy, Debug)]
enum Rule {
    /// Determines the last unknown coordinate from the distance between the end of the leg and the
    /// common point of all earlier axes. Rotations about these axes preserve the distance.
    LastByDistance,
    /// Determines the first unknown coordinate from the distance between the end of the leg and
    /// the common point of all later axes. Rotations about these axes preserve the distance.
    FirstByDistance,
    /// Determines the last of two unknown coordinates from the height of the leg's end along the
    /// axis of the first one. A rotation about this axis preserves the height.
    LastByHeight,
    /// Determines the coordinate if it is the only unknown one.
    Alone,
}

#[derive(Clone, Copy, Debug)]
struct Choice {
    rule: Rule,
    /// Sign of the square root, 1 or -1: selects one of the two solutions of the rule.
    branch: f64,
}

impl Rule {
    const ALL: [Self; 4] =
        [Self::Alone, Self::LastByDistance, Self::FirstByDistance, Self::LastByHeight];

    /// Returns `true` if the rule determines the last unknown coordinate, and `false` if it
    /// determines the first or the only one.
    fn is_last(self) -> bool {
        matches!(self, Self::LastByDistance | Self::LastByHeight)
    }
}

impl Element {
    fn axis<T: Scalar>(&self) -> Vec3<T> {
        Vec3::unit(self.axis)
    }

    /// Computes the pose of the element's frame after its displacement by `coordinate` (rad or m),
    /// relative to the frame before the displacement.
    fn pose<T: Scalar>(&self, coordinate: T) -> Pose<T> {
        let q = coordinate * T::from_f64(self.sign);
        if self.slides {
            Pose { rotation: Mat3::identity(), position: self.axis() * q }
        } else {
            Pose { rotation: Mat3::about_axis(self.axis, q.sin_cos()), position: Vec3::zero() }
        }
    }

    /// Converts a displacement (m) along the element's axis to the coordinate of the joint.
    fn slide<T: Scalar>(&self, displacement: T) -> T {
        displacement * T::from_f64(self.sign)
    }

    fn angle<T: Scalar>(&self, cosine: T, sine: T) -> T {
        (sine * T::from_f64(self.sign)).atan2(cosine)
    }

    /// Computes the coordinate at which the displaced `point` has the squared distance `square`
    /// from `centre`. `branch` (1 or -1) selects one of two solutions. All points are in the
    /// element's frame.
    fn by_distance<T: Scalar>(&self, point: Vec3<T>, centre: Vec3<T>, square: T, branch: T) -> T {
        let axis = self.axis();
        if self.slides {
            let apart = point - centre;
            let along = apart.dot(axis);
            let root = (along * along - apart.norm_squared() + square).sqrt();
            return self.slide(branch * root - along);
        }
        let height = point.dot(axis) * centre.dot(axis);
        let half = T::from_f64(0.5);
        let product = (point.norm_squared() + centre.norm_squared() - square) * half - height;
        self.by_product(point, centre, product, branch)
    }

    /// Computes the coordinate (rad) of the rotation after which the component of `point` normal to
    /// the axis has the scalar product `product` with that of `other`. `branch` (1 or -1) selects
    /// one of two solutions.
    fn by_product<T: Scalar>(&self, point: Vec3<T>, other: Vec3<T>, product: T, branch: T) -> T {
        let axis = self.axis();
        let cosine = point.dot(other) - point.dot(axis) * other.dot(axis);
        let sine = other.dot(axis.cross(point));
        let square = cosine * cosine + sine * sine;
        let root = (square - product * product).sqrt() * branch;
        let over = square.recip();
        let (c, s) = (cosine * product - sine * root, sine * product + cosine * root);
        self.angle(c * over, s * over)
    }
}

/// Computes the intersection of two axes or, if they are skew, the point of the first axis nearest
/// to the second. `axis` and `other` are unit vectors along the axes; the first axis passes
/// through the origin, the second through the point `through`.
fn meeting<T: Scalar>(axis: Vec3<T>, other: Vec3<T>, through: Vec3<T>) -> Vec3<T> {
    let cosine = axis.dot(other);
    let along = axis.dot(through) - cosine * other.dot(through);
    axis * (along / (T::one() - cosine * cosine))
}

/// Part of a leg whose coordinates are still unknown. The coordinates satisfy
/// `fixed[0] e[0] fixed[1] e[1] ... fixed[n] point = target`, where `e` are the displacements of
/// the elements.
struct Open<'a, T> {
    elements: &'a [Element],
    fixed: &'a [Pose<T>],
    point: Vec3<T>,
    target: Vec3<T>,
}

impl<T: Scalar> Open<'_, T> {
    /// Computes the pose of the frame of element `last` in the frame of the earlier element
    /// `first`, with the coordinates of `first` and of all elements between the two at zero.
    fn between(&self, first: usize, last: usize) -> Pose<T> {
        self.fixed[first + 1..=last].iter().fold(Pose::identity(), |sum, fixed| sum * *fixed)
    }

    /// Returns the common point of the axes of one or two revolute elements, in the frame of the
    /// first of them; `None` for translations and for more than two elements.
    fn centre(&self, range: Range<usize>) -> Option<Vec3<T>> {
        if self.elements[range.clone()].iter().any(|element| element.slides) {
            return None;
        }
        match range.len() {
            1 => Some(Vec3::zero()),
            2 => {
                let next = self.between(range.start, range.start + 1);
                let (axis, other) = (&self.elements[range.start], &self.elements[range.start + 1]);
                Some(meeting(axis.axis(), next.rotation * other.axis(), next.position))
            }
            _ => None,
        }
    }

    /// Computes the coordinate that the given rule determines; `None` if the rule does not apply.
    fn find(&self, Choice { rule, branch }: Choice) -> Option<T> {
        let branch = T::from_f64(branch);
        let count = self.elements.len();
        let last = count.checked_sub(1)?;
        let target = self.fixed[0].inverse().apply(self.target);
        let point = self.fixed[count].apply(self.point);
        match rule {
            Rule::Alone if count == 1 => {
                let element = &self.elements[0];
                let axis = element.axis();
                if element.slides {
                    return Some(element.slide(axis.dot(target - point)));
                }
                let cosine = point.dot(target) - point.dot(axis) * target.dot(axis);
                Some(element.angle(cosine, axis.dot(point.cross(target))))
            }
            Rule::LastByDistance if count > 1 => {
                let centre = self.centre(0..last)?;
                let square = (target - centre).norm_squared();
                let centre = self.between(0, last).inverse().apply(centre);
                Some(self.elements[last].by_distance(point, centre, square, branch))
            }
            Rule::FirstByDistance if count > 1 => {
                let centre = self.centre(1..count)?;
                let end = self.between(1, last).apply(point);
                let square = (end - centre).norm_squared();
                let moved = self.between(0, 1).apply(centre);
                Some(self.elements[0].by_distance(moved, target, square, branch))
            }
            Rule::LastByHeight if count == 2 => {
                let (first, second) = (&self.elements[0], &self.elements[1]);
                let between = self.between(0, 1);
                let axis = first.axis();
                let up = between.rotation.transpose_mul(axis);
                let height = axis.dot(target - between.position);
                let own = second.axis();
                if first.slides {
                    return None;
                }
                if second.slides {
                    return Some(second.slide((height - up.dot(point)) / up.dot(own)));
                }
                let product = height - up.dot(own) * point.dot(own);
                Some(second.by_product(point, up, product, branch))
            }
            _ => None,
        }
    }
}

impl Leg {
    /// Computes the constant poses between successive elements: the first is relative to the frame
    /// of the root body, the last is that of the last body's frame.
    fn fixed<T: Scalar>(&self, topology: &Topology, parameters: &Parameters<T>) -> Vec<Pose<T>> {
        let mut fixed = Vec::with_capacity(self.elements.len() + 1);
        let mut pose = Pose::identity();
        for &node in &self.nodes {
            let Link::Joint { joint, reversed } = topology.nodes[node].link else { continue };
            let (j, k) = (parameters.frame_j[joint], parameters.frame_k[joint]);
            let (own, next) = if reversed { (k, j) } else { (j, k) };
            pose = pose * own;
            for _ in topology.nodes[node].coordinates.clone() {
                fixed.push(pose);
                pose = Pose::identity();
            }
            pose = pose * next.inverse();
        }
        fixed.push(pose);
        fixed
    }

    /// Computes the position (m) of the cut joint's point: once as a point of the leg's last body
    /// in the frame of that body, and once as a point of the body at the far side of the cut, in
    /// the frame of the root body.
    fn points<T: Scalar>(
        &self,
        parameters: &Parameters<T>,
        root: &Pose<T>,
        end: &Pose<T>,
    ) -> [Vec3<T>; 2] {
        let (j, k) = (parameters.frame_j[self.cut].position, parameters.frame_k[self.cut].position);
        let (own, other) = if self.ends_in_successor { (k, j) } else { (j, k) };
        [own, root.inverse().apply(end.apply(other))]
    }

    /// Computes the leg's coordinates by `choices`, one after the other. Returns each value with
    /// the index of its element; `None` if a rule does not apply.
    fn follow<T: Scalar>(
        &self,
        topology: &Topology,
        parameters: &Parameters<T>,
        [root, end]: [&Pose<T>; 2],
        choices: &[Choice],
    ) -> Option<Vec<(usize, T)>> {
        let fixed = self.fixed(topology, parameters);
        let [mut point, mut target] = self.points(parameters, root, end);
        let mut open = 0..self.elements.len();
        let mut found = Vec::with_capacity(choices.len());
        for choice in choices {
            let elements = &self.elements[open.clone()];
            let fixed = &fixed[open.start..=open.end];
            let value = Open { elements, fixed, point, target }.find(*choice)?;
            if choice.rule.is_last() {
                open.end -= 1;
                let moved = self.elements[open.end].pose(value);
                point = moved.apply(fixed[fixed.len() - 1].apply(point));
                found.push((open.end, value));
            } else {
                let moved = fixed[0] * self.elements[open.start].pose(value);
                target = moved.inverse().apply(target);
                found.push((open.start, value));
                open.start += 1;
            }
        }
        Some(found)
    }

    /// Returns `true` if the coordinate computed by the last of the `choices` equals the known
    /// coordinate of the configuration `at`.
    fn agrees(&self, at: &Position<'_>, choices: &[Choice]) -> bool {
        let Position { topology, parameters, bodies, coordinates } = at;
        let poses = [&bodies.pose[self.root], &bodies.pose[self.end]];
        let Some(found) = self.follow(topology, parameters, poses, choices) else { return false };
        let Some(&(place, value)) = found.last() else { return true };
        let element = &self.elements[place];
        let difference = value - coordinates[element.coordinate];
        let difference = match element.slides {
            true => difference / parameters.length,
            false => difference.sin().hypot(1.0 - difference.cos()),
        };
        // A NaN difference counts as a mismatch.
        difference.abs() < SAME
    }
}

/// A configuration: known coordinates of the spanning tree and the resulting poses of the bodies.
struct Position<'a> {
    topology: &'a Topology,
    parameters: &'a Parameters<f64>,
    bodies: Bodies<f64>,
    coordinates: &'a [f64],
}

/// Returns `true` for the ground and for floating bodies. Their poses do not depend on the
/// coordinates of legs.
fn is_placed(topology: &Topology, body: usize) -> bool {
    topology.node_of_body[body].is_none_or(|node| topology.nodes[node].link == Link::Floating)
}

/// Returns the elementary motions of a joint in order from frame J to frame K, one for each
/// coordinate: an axis (0, 1, 2 for x, y, z) and a flag that is `true` for a translation. `None`
/// for joint types without closed forms.
fn elements_of(joint_type: JointType) -> Option<&'static [(usize, bool)]> {
    match joint_type {
        JointType::Fixed => Some(&[]),
        JointType::Revolute => Some(&[(2, false)]),
        JointType::Prismatic => Some(&[(2, true)]),
        JointType::Cylindrical => Some(&[(2, false), (2, true)]),
        JointType::Universal => Some(&[(2, false), (0, false)]),
        _ => None,
    }
}

impl Legs {
    /// Finds the closed forms that reproduce the coordinates of the legs at the given
    /// configurations. Each configuration consists of the coordinates of the spanning tree, and all
    /// its loops must be closed. Legs without a closed form are omitted.
    pub fn new(topology: &Topology, parameters: &Parameters<f64>, positions: &[Vec<f64>]) -> Self {
        let positions: Vec<Position<'_>> = positions
            .iter()
            .map(|coordinates| {
                let mut bodies = Bodies::new(topology);
                bodies.place(topology, parameters, coordinates);
                Position { topology, parameters, bodies, coordinates }
            })
            .collect();
        let legs = topology.cuts.iter().filter_map(|cut| leg_of(topology, cut.joint));
        let closed = legs.filter_map(|mut leg| {
            for _ in 0..leg.elements.len() {
                let candidates = Rule::ALL
                    .into_iter()
                    .flat_map(|rule| [1.0, -1.0].map(|branch| Choice { rule, branch }));
                let choice = candidates.into_iter().find(|choice| {
                    let choices = [&leg.choices[..], &[*choice]].concat();
                    positions.iter().all(|position| leg.agrees(position, &choices))
                })?;
                leg.choices.push(choice);
            }
            Some(leg)
        });
        Self { legs: closed.collect() }
    }

    /// Returns `true` if the spanning-tree coordinate with this index has a closed form.
    pub fn finds(&self, coordinate: usize) -> bool {
        let elements = self.legs.iter().flat_map(|leg| &leg.elements);
        elements.into_iter().any(|element| element.coordinate == coordinate)
    }

    /// Computes the coordinates of all legs with closed forms and passes the index and value of
    /// each to `receive`. `floating` returns the pose of a floating body in world axes relative to
    /// the reference point. With dual numbers as the scalar type, the values include rates and
    /// accelerations.
    pub fn find<T: Scalar>(
        &self,
        topology: &Topology,
        parameters: &Parameters<T>,
        floating: impl Fn(BodyId) -> Pose<T>,
        mut receive: impl FnMut(usize, T),
    ) {
        let pose = |body: usize| match topology.node_of_body[body] {
            None => parameters.ground,
            Some(_) => floating(BodyId(body)),
        };
        for leg in &self.legs {
            let poses = [&pose(leg.root), &pose(leg.end)];
            let found = leg.follow(topology, parameters, poses, &leg.choices);
            for (place, value) in found.into_iter().flatten() {
                receive(leg.elements[place].coordinate, value);
            }
        }
    }

    /// Returns the index of the spanning tree's degree of freedom whose coordinate has the index
    /// `coordinate`. Applies to coordinates with a closed form.
    pub fn dof(&self, topology: &Topology, coordinate: usize) -> Option<usize> {
        let mut nodes = topology.nodes.iter();
        let node = nodes.find(|node| node.coordinates.contains(&coordinate))?;
        Some(node.tree_dofs.start + coordinate - node.coordinates.start)
    }
}

/// Returns the chain between a cut joint and the ground or a floating body if this chain qualifies
/// as a leg, and `None` otherwise.
fn leg_of(topology: &Topology, cut: usize) -> Option<Leg> {
    // Other joint types, which constrain a point to a plane or a line, do not determine its
    // position.
    let holds_a_point = matches!(
        topology.joint_types[cut],
        JointType::Spherical | JointType::Universal | JointType::Revolute
    );
    let (predecessor, successor) = topology.ends[cut];
    let ends_in_successor = is_placed(topology, predecessor);
    let (end, tip) =
        if ends_in_successor { (predecessor, successor) } else { (successor, predecessor) };
    if !holds_a_point || !is_placed(topology, end) || is_placed(topology, tip) {
        return None;
    }
    let mut nodes = topology.ancestors(tip);
    // Ascend to the floating body or the ground at the root of the chain.
    let count =
        nodes.iter().take_while(|node| topology.nodes[**node].link != Link::Floating).count();
    let root = nodes.get(count).map_or(0, |node| topology.nodes[*node].body);
    nodes.truncate(count);
    nodes.reverse();
    let mut elements = Vec::new();
    for &node in &nodes {
        let Link::Joint { joint, reversed } = topology.nodes[node].link else { return None };
        let motions = elements_of(topology.joint_types[joint])?;
        let coordinates = topology.nodes[node].coordinates.clone();
        let own = motions.iter().zip(coordinates).map(|(&(axis, slides), coordinate)| Element {
            axis,
            slides,
            sign: if reversed { -1.0 } else { 1.0 },
            coordinate,
        });
        let mut own: Vec<Element> = own.collect();
        if reversed {
            own.reverse();
        }
        elements.extend(own);
    }
    let choices = Vec::new();
    Some(Leg { nodes, elements, root, end, cut, ends_in_successor, choices })
}
