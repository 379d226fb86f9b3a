//! Random drawings of several classes, see [`Drawing`].

use super::{Drawing, Ints, Joint, by, cross, plus};
use crate::common::random::Random;
use stiction_core::joint::JointType::{self, *};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// One loop of three to eight joints.
    Loop,
    /// A platform on two to six legs of any kind.
    Parallel,
    /// A platform on equal legs that is translated but not rotated; leg wrenches are parallel and
    /// equal.
    EqualLegs,
    /// Planar linkages in space, with one loop or several.
    Planar,
    /// All axes through one point.
    Spherical,
    /// Planar linkages with all hinges on one line, or spherical ones with all axes in one plane:
    /// folded, taut, or branching mechanisms.
    Flat,
    /// Ladders: loops attached to loops.
    Ladder,
    /// Any connected graph of any joints.
    Mixed,
}

pub const CLASSES: [Class; 8] = [
    Class::Loop,
    Class::Parallel,
    Class::EqualLegs,
    Class::Planar,
    Class::Spherical,
    Class::Flat,
    Class::Ladder,
    Class::Mixed,
];

const AXES: [Ints; 14] = [
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
    [1, 1, 0],
    [1, -1, 0],
    [0, 1, 1],
    [1, 0, -1],
    [1, 1, 1],
    [1, 2, 2],
    [2, -1, 2],
    [0, 3, 4],
];

fn point(random: &mut Random) -> Ints {
    std::array::from_fn(|_| random.below(5) as i64 - 2)
}

/// Creates a joint with random actuators. `second` is used by types that need it (U and E).
fn joint(
    random: &mut Random,
    joint_type: JointType,
    ends: (usize, usize),
    at: Ints,
    axis: Ints,
) -> Joint {
    let second = loop {
        let second = cross(axis, random.pick(&AXES));
        if second != [0; 3] {
            break second;
        }
    };
    let ends = if random.below(4) == 0 { (ends.1, ends.0) } else { ends };
    let mut actuated = Vec::new();
    if joint_type.has_scalar_coordinates() {
        actuated = (0..joint_type.dofs().len()).filter(|_| random.below(3) == 0).collect();
    }
    let pitch = random.pick(&[1, -1, 2]);
    Joint { joint_type, ends, at, axis, second, pitch, actuated }
}

/// Adds a chain of joints with types, positions and axes from one body to another.
fn chain(
    drawing: &mut Drawing,
    random: &mut Random,
    joints: &[(JointType, Ints, Ints)],
    ends: (usize, usize),
) {
    let mut before = ends.0;
    for (k, &(joint_type, at, axis)) in joints.iter().enumerate() {
        let next = if k + 1 == joints.len() {
            ends.1
        } else {
            let com = point(random);
            drawing.body(com)
        };
        drawing.joints.push(joint(random, joint_type, (before, next), at, axis));
        before = next;
    }
}

const ANY: [JointType; 8] =
    [Revolute, Revolute, Revolute, Prismatic, Cylindrical, Universal, Spherical, Helical];

/// Creates types, positions and axes of a random chain. Its axes are often restricted to few
/// directions or points.
fn random_chain(random: &mut Random, count: usize) -> Vec<(JointType, Ints, Ints)> {
    let (axes, places) = (1 + random.below(4), 1 + random.below(count + 1));
    let axes: Vec<Ints> = (0..axes).map(|_| random.pick(&AXES)).collect();
    let places: Vec<Ints> = (0..places).map(|_| point(random)).collect();
    (0..count).map(|_| (random.pick(&ANY), random.pick(&places), random.pick(&axes))).collect()
}

/// Creates the joints of a planar chain: hinges along the normal, slides perpendicular to it.
fn planar_chain(random: &mut Random, count: usize, turned: usize) -> Vec<(JointType, Ints, Ints)> {
    let turn = |x: Ints| [x[turned % 3], x[(turned + 1) % 3], x[(turned + 2) % 3]];
    (0..count)
        .map(|_| {
            let [x, y, _] = point(random);
            if random.below(5) == 0 {
                let axis = random.pick(&[[1, 0, 0], [0, 1, 0], [1, 1, 0], [3, 4, 0]]);
                (Prismatic, turn([x, y, 0]), turn(axis))
            } else {
                // Hinges need not lie in one plane.
                (Revolute, turn([x, y, random.below(2) as i64]), turn([0, 0, 1]))
            }
        })
        .collect()
}

fn spherical_chain(
    random: &mut Random,
    count: usize,
    centre: Ints,
) -> Vec<(JointType, Ints, Ints)> {
    (0..count)
        .map(|_| {
            let axis = random.pick(&AXES);
            (Revolute, plus(centre, by(axis, random.below(3) as i64)), axis)
        })
        .collect()
}

fn flat_chain(random: &mut Random, count: usize, on_line: bool) -> Vec<(JointType, Ints, Ints)> {
    (0..count)
        .map(|_| match on_line {
            true => (Revolute, [random.below(4) as i64, 0, 0], [0, 0, 1]),
            false => {
                let axis = random.pick(&[[1, 0, 0], [0, 1, 0], [1, 1, 0], [1, -1, 0], [2, 1, 0]]);
                (Revolute, axis, axis)
            }
        })
        .collect()
}

pub fn drawing(class: Class, random: &mut Random) -> Drawing {
    let mut drawing = Drawing::default();
    match class {
        Class::Loop => {
            let count = 3 + random.below(6);
            let joints = random_chain(random, count);
            chain(&mut drawing, random, &joints, (0, 0));
        }
        Class::Parallel => {
            let platform = drawing.body(point(random));
            for _ in 0..2 + random.below(5) {
                let count = 1 + random.below(3);
                let joints = random_chain(random, count);
                chain(&mut drawing, random, &joints, (0, platform));
            }
        }
        Class::EqualLegs => {
            let platform = drawing.body(point(random));
            let count = 1 + random.below(3);
            let joints = random_chain(random, count);
            for _ in 0..2 + random.below(4) {
                let by = point(random);
                let turned = random.below(3);
                // The platform is translated, and the axes are sometimes permuted.
                let turn = |x: Ints| [x[turned], x[(turned + 1) % 3], x[(turned + 2) % 3]];
                let turned = random.below(3) == 0;
                let turn = |x: Ints| if turned { turn(x) } else { x };
                let moved: Vec<_> = joints
                    .iter()
                    .map(|&(t, at, axis)| (t, plus(turn(at), by), turn(axis)))
                    .collect();
                chain(&mut drawing, random, &moved, (0, platform));
            }
        }
        Class::Planar | Class::Spherical | Class::Flat => {
            let (turned, centre) = (random.below(3), point(random));
            let on_line = random.below(2) == 0;
            let some = |random: &mut Random, count: usize| match class {
                Class::Planar => planar_chain(random, count, turned),
                Class::Spherical => spherical_chain(random, count, centre),
                _ => flat_chain(random, count, on_line),
            };
            let count = 3 + random.below(4);
            let joints = some(random, count);
            chain(&mut drawing, random, &joints, (0, 0));
            for _ in 0..random.below(3) {
                let from = random.below(drawing.coms.len() + 1);
                let to = (from + 1 + random.below(drawing.coms.len())) % (drawing.coms.len() + 1);
                let count = 1 + random.below(3);
                let joints = some(random, count);
                chain(&mut drawing, random, &joints, (from, to));
            }
        }
        Class::Ladder => {
            let count = 3 + random.below(3);
            let joints = random_chain(random, count);
            chain(&mut drawing, random, &joints, (0, 0));
            for _ in 0..1 + random.below(2) {
                // Add rungs between two bodies of the last loop.
                let bodies = drawing.coms.len();
                let (from, to) = (bodies, bodies - 1);
                let count = 2 + random.below(3);
                let joints = random_chain(random, count);
                chain(&mut drawing, random, &joints, (from, to));
            }
        }
        Class::Mixed => {
            let bodies = 2 + random.below(5);
            for _ in 0..bodies {
                let com = point(random);
                drawing.body(com);
            }
            let types = [
                Revolute,
                Prismatic,
                Cylindrical,
                Universal,
                Spherical,
                Helical,
                Planar,
                Fixed,
                Free,
            ];
            let mut ends: Vec<(usize, usize)> =
                (1..=bodies).map(|body| (random.below(body), body)).collect();
            for _ in 0..random.below(4) {
                let from = random.below(bodies + 1);
                ends.push((from, (from + 1 + random.below(bodies)) % (bodies + 1)));
            }
            for ends in ends {
                let (joint_type, at, axis) =
                    (random.pick(&types), point(random), random.pick(&AXES));
                drawing.joints.push(joint(random, joint_type, ends, at, axis));
            }
        }
    }
    drawing
}
