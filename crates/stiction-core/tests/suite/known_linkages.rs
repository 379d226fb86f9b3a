//! Mobility of overconstrained linkages from the literature, with real dimensions.

use crate::common::{along, v};
use stiction_core::dynamics::{InverseDynamics, Settings};
use stiction_core::joint::JointType::{self, *};
use stiction_core::kinematics::{Coordinate, Target};
use stiction_core::mechanism::{BodyId, BodySpec, JointSpec, MechanismBuilder};
use stiction_core::mobility::Mobility;
use stiction_core::spatial::{Pose, Vec3};

/// A joint between two bodies (0 is the ground): type, bodies, position and axis in the world.
type Hinge = (JointType, (usize, usize), Vec3<f64>, Vec3<f64>);

const Z: Vec3<f64> = Vec3 { x: 0.0, y: 0.0, z: 1.0 };

/// Computes the mobility of a mechanism whose body frames all coincide with that of the ground.
fn mobility(bodies: usize, joints: &[Hinge]) -> Mobility {
    let mut builder = MechanismBuilder::new("linkage");
    for body in 1..=bodies {
        builder = builder.body(BodySpec::new(format!("b{body}")).mass(1.0));
    }
    let name = |body: usize| if body == 0 { "ground".to_owned() } else { format!("b{body}") };
    for (index, &(joint_type, (a, b), at, axis)) in joints.iter().enumerate() {
        let frame = along(at, axis);
        let spec = JointSpec::new(format!("j{index}"), joint_type, name(a), name(b));
        builder = builder.joint(spec.frames(frame, frame));
    }
    let mut coordinates = Vec::new();
    for body in (1..=bodies).map(BodyId) {
        coordinates.extend((0..3).map(|axis| Coordinate::Position { body, axis }));
        coordinates.extend((0..3).map(|axis| Coordinate::RotationVector { body, axis }));
    }
    let targets = vec![Target { value: 0.0, rate: 0.0, acceleration: 0.0 }; coordinates.len()];
    let homes: Vec<_> = (1..=bodies).map(|body| (BodyId(body), Pose::identity())).collect();
    let (mechanism, settings) = (builder.build().unwrap(), Settings::default());
    Mobility::of(
        &InverseDynamics::new(mechanism, &homes, &coordinates, &targets, settings).unwrap(),
    )
}

/// Checks that the finite mobility is decided, with a motion over a finite distance as evidence.
fn moves(mobility: &Mobility, finite: usize) {
    assert_eq!(mobility.finite.decided(), Some(finite), "{mobility:?}");
    let motion = mobility.finite_motion.as_ref().expect("a motion");
    assert!(motion.turned > 0.1 || motion.moved > 0.1, "{motion:?}");
    assert!(motion.closure < 1e-11, "{motion:?}");
}

/// A. C. Dixon 1899, W. Wunderlich 1976 ("On deformable nine-bar linkages with six triple joints"):
/// bars between all points of two perpendicular lines. If the squared length of each bar is
/// `x_i^2 + y_k^2`, it is also `(x_i^2 + t) + (y_k^2 - t)`.
#[test]
fn deformable_complete_bipartite_linkages() {
    let linkage = |xs: &[f64], ys: &[f64]| {
        let points: Vec<_> =
            xs.iter().map(|x| v(*x, 0.0, 0.0)).chain(ys.iter().map(|y| v(0.0, *y, 0.0))).collect();
        // Index of the bar between two points, numbered as a body.
        let bar = |i: usize, k: usize| i * ys.len() + k;
        let mut joints = Vec::new();
        for (point, at) in points.iter().enumerate() {
            let bars: Vec<usize> = match point.checked_sub(xs.len()) {
                None => (0..ys.len()).map(|k| bar(point, k)).collect(),
                Some(k) => (0..xs.len()).map(|i| bar(i, k)).collect(),
            };
            joints.extend(bars[1..].iter().map(|other| (Revolute, (bars[0], *other), *at, Z)));
        }
        mobility(xs.len() * ys.len() - 1, &joints)
    };
    moves(&linkage(&[1.0, -0.7, 1.6], &[0.8, -1.1, 1.9]), 1);
    moves(&linkage(&[1.0, -0.7, 1.6, 2.1], &[0.8, -1.1, 1.9, -2.3]), 1);
}

/// L. Burmester 1893, W. Wunderlich 1968 ("On Burmester's focal mechanism and Hart's straight-line motion"): bars
/// from points P, Q, R, S on the sides of a four-bar ABCD to a common point F. Of the four quadrilaterals at F,
/// opposite ones are similar with their corners at F exchanged: FPAS to CRFQ and FPBQ to DRFS. With the sides
/// `a = FP, b = PA, c = AS, d = SF` and `FP, PB = k b, BQ = e, QF = f`, the angles p at P and s at S satisfy
/// `a^2 + b^2 - 2 a b cos p = c^2 + d^2 - 2 c d cos s` and, being the supplements in FPBQ,
/// `a^2 + k^2 b^2 + 2 a k b cos p = e^2 + f^2 + 2 e f cos s`: the same equation if `e f = k c d` and
/// `e^2 + f^2 = a^2 + k^2 b^2 + k (a^2 + b^2 - c^2 - d^2)`. With the ratio `m = f / c` of CRFQ all sides fit.
#[test]
fn burmesters_focal_mechanism() {
    let (a, b, c, d, k) = (1.0_f64, 1.2_f64, 1.1_f64, 0.9_f64, 0.8_f64);
    let (product, sum) = (k * c * d, a * a + k * k * b * b + k * (a * a + b * b - c * c - d * d));
    let f = (0.5 * (sum + (sum * sum - 4.0 * product * product).sqrt())).sqrt();
    let (e, m) = (product / f, f / c);
    let n = m / k;
    // Side AB lies along x, with P at the origin.
    let p = 1.2_f64;
    let diagonal = a * a + b * b - 2.0 * a * b * p.cos();
    let s = ((c * c + d * d - diagonal) / (2.0 * c * d)).acos();
    let origin = v(0.0, 0.0, 0.0);
    let (corner_a, corner_b) = (v(-b, 0.0, 0.0), v(k * b, 0.0, 0.0));
    let focus = v(-a * p.cos(), a * p.sin(), 0.0);
    // Third corner of the triangle to the left of the line between two points, from the lengths of
    // its sides.
    let third = |from: Vec3<f64>, to: Vec3<f64>, at_from: f64, at_to: f64| {
        let base = to - from;
        let length = base.norm();
        let x = (at_from * at_from - at_to * at_to + length * length) / (2.0 * length);
        let y = (at_from * at_from - x * x).sqrt();
        let along = base * (1.0 / length);
        from + along * x + v(-along.y, along.x, 0.0) * y
    };
    let corner_s = third(corner_a, focus, c, d);
    let corner_q = third(focus, corner_b, f, e);
    let beyond =
        |from: Vec3<f64>, to: Vec3<f64>, by: f64| to + (to - from).direction().unwrap() * by;
    let corner_c = beyond(corner_b, corner_q, m * d);
    let corner_d = beyond(corner_a, corner_s, n * f);
    let corner_r = third(focus, corner_c, m * b, m * a);
    // Check that the sides of the similar quadrilaterals fit.
    assert!(((corner_d - corner_r).norm() - n * a).abs() < 1e-12, "{s}");
    assert!(((corner_d - corner_c).norm() - (m + n) * a).abs() < 1e-12);
    // Bodies: AB is the ground, BC is 1, CD is 2, DA is 3; the bars of P, Q, R, S are 4 to 7.
    let joints = [
        (corner_a, (0, 3)),
        (corner_b, (0, 1)),
        (corner_c, (1, 2)),
        (corner_d, (2, 3)),
        (origin, (0, 4)),
        (corner_q, (1, 5)),
        (corner_r, (2, 6)),
        (corner_s, (3, 7)),
        (focus, (4, 5)),
        (focus, (4, 6)),
        (focus, (4, 7)),
    ];
    let hinges = joints.map(|(at, ends)| (Revolute, ends, at, Z));
    let found = mobility(7, &hinges);
    assert_eq!(found.gruebler, -13);
    moves(&found, 1);
    // With a different point Q, the mechanism is rigid.
    let mut amiss = hinges;
    amiss[5].2 += v(0.02, 0.01, 0.0);
    assert_eq!(mobility(7, &amiss).finite.decided(), Some(0));
}

/// Bennett's linkage with lengths in the ratio of the sines of the twist angles, rounded to a
/// number of digits. With few digits it is strictly rigid, and its mobility depends on the last
/// digit. An undecided mobility is a range.
#[test]
fn bennett_with_few_digits() {
    let linkage = |digits: i32| {
        let round = |x: f64| (x * 10_f64.powi(digits)).round() / 10_f64.powi(digits);
        // A half turn about z exchanges opposite corners.
        let corners = [
            v(0.31, 0.05, 0.07),
            v(0.04, 0.23, -0.05),
            v(-0.31, -0.05, 0.07),
            v(-0.04, -0.23, -0.05),
        ];
        let hinges: Vec<Hinge> = (0..4)
            .map(|k| {
                let (next, last) =
                    (corners[(k + 1) % 4] - corners[k], corners[(k + 3) % 4] - corners[k]);
                let axis = next.cross(last).direction().unwrap();
                let [x, y, z] = axis.to_array().map(round);
                (Revolute, (k, (k + 1) % 4), corners[k], v(x, y, z))
            })
            .collect();
        mobility(3, &hinges)
    };
    moves(&linkage(17), 1);
    for digits in [9, 10] {
        let found = linkage(digits);
        assert_eq!(found.finite.decided(), None, "{digits}: {found:?}");
        assert_eq!(found.finite.range(), [0, 1], "{digits}");
        let motion = found.finite_motion.expect("it moves within closure tolerance");
        assert!(motion.closure > 1e-13 && motion.closure < 1e-7, "{motion:?}");
        assert!(motion.turned > 0.1, "{motion:?}");
    }
    assert_eq!(linkage(3).finite.decided(), Some(0));
}

/// C. Wren's platforms: parallel legs of equal length permit the translation of a platform on a
/// sphere, for any number of legs.
#[test]
fn wren_platforms() {
    for legs in 4..=6_usize {
        let along_leg = v(0.3, 0.2, 0.93);
        let joints: Vec<Hinge> = (0..legs)
            .flat_map(|leg| {
                let angle = 1.3 * leg as f64 + 0.2 * (leg * leg) as f64;
                let foot = v(0.7 * angle.cos(), 0.6 * angle.sin(), 0.05 * leg as f64);
                let ends = [(0, leg + 2), (leg + 2, 1)];
                [(Spherical, ends[0], foot, Z), (Spherical, ends[1], foot + along_leg, Z)]
            })
            .collect();
        let found = mobility(legs + 1, &joints);
        // Each leg also has a spin.
        let expected = legs + 2;
        let [least, greatest] = found.finite.range();
        assert!(least <= expected && expected <= greatest, "{legs}: {found:?}");
        assert!(found.finite.decided().is_none_or(|finite| finite == expected));
        assert!(found.finite_motion.is_some_and(|motion| motion.moved > 0.1), "{legs}");
    }
}
