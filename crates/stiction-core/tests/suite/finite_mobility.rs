//! Finite mobility of linkages with known mobility, and of random linkages compared with an
//! independent tracer. The tracer shares only the singular value decomposition with the library.

use crate::common::random::Random;
use crate::exact::classes::{Class, drawing};
use crate::exact::solver::assembled;
use crate::exact::tracer::Tracer;
use crate::exact::verdicts::Verdicts;
use crate::exact::{Drawing, Ints, Joint, cross};
use stiction_core::joint::JointType::{self, *};
use stiction_core::mobility::Mobility;

/// Adds a chain of joints, starting at the ground or another body; returns the last body of the
/// chain.
fn chain(drawing: &mut Drawing, joints: &[(JointType, Ints, Ints)], ends: (usize, usize)) {
    let mut before = ends.0;
    for (k, &(joint_type, at, axis)) in joints.iter().enumerate() {
        let next = if k + 1 == joints.len() { ends.1 } else { drawing.body(at) };
        let second = [[1, 0, 0], [0, 1, 0]].map(|x| cross(axis, x));
        let second = if second[0] == [0; 3] { second[1] } else { second[0] };
        let (pitch, actuated) = (1, vec![]);
        let ends = (before, next);
        drawing.joints.push(Joint { joint_type, ends, at, axis, second, pitch, actuated });
        before = next;
    }
}

/// Creates a closed chain of hinges that contains the ground.
fn ring(hinges: &[(Ints, Ints)]) -> Drawing {
    let mut drawing = Drawing::default();
    let joints: Vec<_> = hinges.iter().map(|&(at, axis)| (Revolute, at, axis)).collect();
    chain(&mut drawing, &joints, (0, 0));
    drawing
}

/// Creates a platform connected with the ground by the given legs.
fn platform(legs: &[Vec<(JointType, Ints, Ints)>]) -> Drawing {
    let mut drawing = Drawing::default();
    let platform = drawing.body([0, 0, 3]);
    legs.iter().for_each(|leg| chain(&mut drawing, leg, (0, platform)));
    drawing
}

const X: Ints = [1, 0, 0];
const Y: Ints = [0, 1, 0];
const Z: Ints = [0, 0, 1];

/// Computes the Grübler count, the instantaneous mobility and the finite mobility.
fn counts(drawing: &Drawing) -> (i64, usize, usize) {
    let found = Mobility::of(&assembled(drawing, &mut Random(5)));
    assert_eq!(found.instantaneous, Verdicts::of(drawing).mobility, "{drawing:?}");
    (found.gruebler, found.instantaneous, found.finite.decided().expect("decided"))
}

#[test]
fn polygons_in_a_plane_and_on_a_sphere() {
    // A convex polygon, so that the configuration is not singular.
    let corners = [[0, 0, 0], [3, -1, 0], [5, 1, 0], [6, 4, 0], [4, 7, 0], [1, 8, 0], [-1, 3, 0]];
    for n in 3..=7 {
        let planar: Vec<_> = corners[..n].iter().map(|&at| (at, Z)).collect();
        assert_eq!(counts(&ring(&planar)), (n as i64 - 6, n - 3, n - 3), "{n} in a plane");
        // Axes from one point towards the corners of the polygon: a convex cone.
        let cone: Vec<_> =
            corners[..n].iter().map(|&[x, y, _]| ([0, 0, 0], [x - 2, y - 3, 4])).collect();
        assert_eq!(counts(&ring(&cone)), (n as i64 - 6, n - 3, n - 3), "{n} on a sphere");
    }
}

#[test]
fn overconstrained_linkages() {
    // Sarrus 1853: two chains of three parallel hinges each, with different directions of the
    // hinges.
    let sarrus = ring(&[
        ([3, 0, 0], Y),
        ([5, 0, 2], Y),
        ([3, 0, 4], Y),
        ([0, 3, 4], X),
        ([0, 5, 2], X),
        ([0, 3, 0], X),
    ]);
    assert_eq!(counts(&sarrus), (0, 1, 1));
    // A. Bricard's cube (IFToMM's benchmark A04).
    let bricard = ring(&[
        ([0, 0, 0], Y),
        ([1, 0, 0], Z),
        ([1, -1, 0], X),
        ([1, -1, 1], Y),
        ([0, -1, 1], Z),
        ([0, 0, 1], X),
    ]);
    assert_eq!(counts(&bricard), (0, 1, 1));
    // Tripteron, with three translations: each leg has a slide and three hinges parallel to the
    // slide.
    let leg = |axis: Ints, turn: usize| {
        let t = |[x, y, z]: Ints| {
            let mut p = [x, y, z];
            p.rotate_right(turn);
            p
        };
        vec![
            (Prismatic, t([0, 5, 1]), axis),
            (Revolute, t([0, 5, 1]), axis),
            (Revolute, t([0, 4, 3]), axis),
            (Revolute, t([0, 1, 1]), axis),
        ]
    };
    let tripteron = platform(&[leg(X, 0), leg(Y, 1), leg(Z, 2)]);
    assert_eq!(counts(&tripteron), (0, 3, 3));
    // Without the slides, the hinges keep the platform from moving.
    let held =
        platform(&[(X, 0), (Y, 1), (Z, 2)].map(|(axis, turn)| leg(axis, turn)[1..].to_vec()));
    assert_eq!(counts(&held), (-3, 0, 0));
    // A carriage on two rails, and one on three rails; the rails are not parallel to the world
    // axes.
    let rail = |at| vec![(Prismatic, at, [0, 3, 4])];
    assert_eq!(counts(&platform(&[rail([1, 0, 0]), rail([-1, 2, 0])])), (-4, 1, 1));
    assert_eq!(
        counts(&platform(&[rail([1, 0, 0]), rail([-1, 2, 0]), rail([0, 0, 2])])),
        (-9, 1, 1)
    );
    // A door on three hinges.
    let hinge = |z| vec![(Revolute, [1, 2, z], Z)];
    assert_eq!(counts(&platform(&[hinge(0), hinge(1), hinge(3)])), (-9, 1, 1));
}

/// Bennett 1903: four hinges at the corners of a skew quadrilateral with equal opposite sides. Each
/// hinge is perpendicular to both of its sides. The lengths are then proportional to the sines of
/// the twist angles: both ratios are 3 V / (2 A B) with the volume V of the tetrahedron of the
/// corners and the two areas A and B of its faces.
#[test]
fn bennett() {
    let linkage = |[a, b, c]: Ints, [d, e, f]: Ints, amiss: Ints| {
        // A half turn about z exchanges opposite corners.
        let corners = [[a, b, c], [d, e, f], [-a, -b, c], [-d, -e, f]];
        let hinges: Vec<_> = (0..4)
            .map(|k| {
                let side = |other: usize| -> Ints {
                    std::array::from_fn(|i| corners[other % 4][i] - corners[k][i])
                };
                let normal = cross(side(k + 1), side(k + 3));
                let off = if k == 0 { amiss } else { [0; 3] };
                (corners[k], std::array::from_fn(|i| normal[i] + off[i]))
            })
            .collect();
        counts(&ring(&hinges))
    };
    for (a, b) in [([3, 0, 1], [1, 2, -1]), ([2, 1, 2], [-1, 3, 0]), ([4, 1, 0], [1, 1, 3])] {
        assert_eq!(linkage(a, b, [0; 3]), (-2, 1, 1), "{a:?} {b:?}");
        assert_eq!(linkage(a, b, [0, 1, 0]), (-2, 0, 0), "{a:?} {b:?} amiss");
    }
}

/// N-four-bar (IFToMM benchmark A02) lying flat: equal uprights on equally spaced pivots, connected
/// by rods with a length equal to the spacing, all on one line. With the angles t0 .. tN of the
/// uprights, each loop requires `sin((t' - t)/2) sin(t/2) cos(t'/2) = 0` for neighbours t, t'. In
/// the flat configuration all t are zero: either neighbours are equal, or the first of them stays
/// zero. On every branch one angle is free: the uprights up to some k are at rest, and the others
/// turn together. At first order, nothing constrains any of the N + 1 uprights: their tips move
/// perpendicular to the rods.
#[test]
fn n_four_bar_lying_flat() {
    let n_four_bar = |n: usize, corner: &dyn Fn(i64) -> Ints| {
        let mut drawing = Drawing::default();
        let uprights: Vec<usize> = (0..=n).map(|k| drawing.body([k as i64, 0, 0])).collect();
        for (k, &upright) in uprights.iter().enumerate() {
            chain(&mut drawing, &[(Revolute, [k as i64, 0, 0], Z)], (0, upright));
        }
        for k in 0..n {
            let rod = [corner(k as i64), corner(k as i64 + 1)].map(|at| (Revolute, at, Z));
            chain(&mut drawing, &rod, (uprights[k], uprights[k + 1]));
        }
        counts(&drawing)
    };
    for n in 1..=4 {
        let gruebler = 6 * (2 * n as i64 + 1) - 5 * (3 * n as i64 + 1);
        let flat = n_four_bar(n, &|k| [k + 1, 0, 0]);
        assert_eq!(flat, (gruebler, n + 1, 1), "{n} flat");
        let upright = n_four_bar(n, &|k| [k, 1, 0]);
        assert_eq!(upright, (gruebler, 1, 1), "{n} upright");
    }
}

/// The 3-RPS robot of Zhang et al. 2018: three constraint forces that are parallel and coplanar
/// permit a roll of the platform, but at first order only. If they are not coplanar, they block the
/// roll.
#[test]
fn a_roll_to_first_order_only() {
    let robot = |height: i64| {
        let leg = |foot: Ints, tip: Ints| {
            let along = std::array::from_fn(|k| tip[k] - foot[k]);
            vec![(Revolute, foot, Y), (Prismatic, foot, along), (Spherical, tip, Z)]
        };
        let tips = [[0, 3, 5 + height], [2, 0, 5], [-2, 0, 5]];
        platform(&[leg([0, 3, 0], tips[0]), leg([4, 0, 0], tips[1]), leg([-4, 0, 0], tips[2])])
    };
    assert_eq!(counts(&robot(0)), (3, 4, 3));
    assert_eq!(counts(&robot(1)), (3, 3, 3));
}

/// The configuration space of a taut chain is a single point, although the Grübler count is one
/// DOF. The reason is that a single real equation such as `x^2 + y^2 = 0` may fix two coordinates.
/// The Grübler count is therefore no lower bound.
#[test]
fn a_taut_chain_is_stuck() {
    // Three rods of length 1, 2, 1 between points at a distance of 4.
    let places = [[0, 0, 0], [1, 0, 0], [3, 0, 0], [4, 0, 0]];
    assert_eq!(counts(&ring(&places.map(|at| (at, Z)))), (-2, 2, 0));
    let mut spatial = Drawing::default();
    let types = [Universal, Revolute, Revolute, Spherical];
    let joints: Vec<_> = types.into_iter().zip(places).map(|(t, at)| (t, at, Z)).collect();
    chain(&mut spatial, &joints, (0, 0));
    assert_eq!(counts(&spatial), (1, 2, 0));
}

/// Compares the random linkages of a class with the tracer. The tracer must nearly always reach a
/// result. Returns the number of linkages compared and the number of those with motions at first
/// order only.
fn compare(class: Class, seeds: std::ops::Range<u64>) -> (usize, usize) {
    let (mut compared, mut doubtful, mut brief) = (0, 0, 0);
    for seed in seeds {
        let mut random = Random(seed);
        let drawing = drawing(class, &mut random);
        let exact = Verdicts::of(&drawing);
        // In all other cases the first-order analysis decides.
        if exact.mobility == 0 || exact.redundant == 0 || drawing.coms.len() > 6 {
            continue;
        }
        let found = Mobility::of(&assembled(&drawing, &mut random)).finite.traced;
        let traced = Tracer::new(&drawing, seed).trace(6);
        if traced.doubtful {
            println!("{class:?} {seed}: {found} of {}, {traced:?}", exact.mobility);
            doubtful += 1;
            continue;
        }
        compared += 1;
        brief += usize::from(found < exact.mobility);
        let most = traced.dimensions.last().copied().unwrap();
        let context = || format!("{class:?} {seed} of {} {drawing:?}", exact.mobility);
        assert_eq!(found, most, "{}", context());
    }
    println!("{class:?}: {compared} compared, {brief} of them brief, {doubtful} doubtful");
    assert!(8 * doubtful <= compared, "{class:?}: {doubtful} of {compared}");
    (compared, brief)
}

#[test]
fn random_loops() {
    let (compared, brief) = compare(Class::Loop, 0..100);
    assert!(compared > 40 && brief > 4, "{compared} {brief}");
}

#[test]
fn random_flat_linkages() {
    let (compared, brief) = compare(Class::Flat, 0..30);
    assert!(compared > 15 && brief > 10, "{compared} {brief}");
}

#[test]
fn random_robots_and_linkages() {
    let classes = [
        Class::Parallel,
        Class::EqualLegs,
        Class::Planar,
        Class::Spherical,
        Class::Ladder,
        Class::Mixed,
    ];
    for class in classes {
        let (compared, _) = compare(class, 0..50);
        assert!(compared > 7, "{class:?} {compared}");
    }
}

/// Finite motions combined with others that are blocked at second order. The cases detect two
/// errors: closing loops by the shortest corrections can miss finite motions (first and last case),
/// and the curvature of a cone can be mistaken for an independent direction (second case).
#[test]
fn motions_beside_blocked_ones() {
    let known = [
        // Two hinges on one line: three bodies rotate about it, so there is one finite motion.
        (Class::Loop, 1615, 2, 1),
        // Rods of length 1, 1, 1, 3, 2 on a line, with both ends of the chain at one pivot. The
        // rods turn about this pivot, and the pentagon that they form has two DOFs.
        (Class::Flat, 1487, 4, 3),
        // Two taut rods block the neighbour of the ground. One body between two hinges at one point
        // spins there, and two rods of equal length turn about that point.
        (Class::Flat, 1678, 3, 2),
    ];
    for (class, seed, instantaneous, finite) in known {
        let mut random = Random(seed);
        let drawing = drawing(class, &mut random);
        let found = Mobility::of(&assembled(&drawing, &mut random));
        let counts = (found.instantaneous, found.finite.traced);
        assert_eq!(counts, (instantaneous, finite), "{class:?} {seed} {drawing:?}");
    }
}
