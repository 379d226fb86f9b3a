//! Verdicts on large mechanisms, for which random motions and random self-stresses replace bases.

use crate::common::{along, v};
use stiction_core::dynamics::{InverseDynamics, InverseError, Settings, Weighting};
use stiction_core::joint::JointType;
use stiction_core::kinematics::{Coordinate, Target};
use stiction_core::mechanism::{BodyId, BodySpec, JointId, JointSpec, MechanismBuilder};
use stiction_core::mobility::Mobility;
use stiction_core::spatial::{Pose, Vec3};

/// Assembles a mechanism whose revolute joints along z have the angle zero at present, and whose
/// body frames coincide with that of the ground.
fn assembled(
    bodies: usize,
    joints: &[(usize, usize, Vec3<f64>)],
    actuated: &[usize],
) -> InverseDynamics {
    let mut builder = MechanismBuilder::new("plane");
    for body in 1..=bodies {
        builder = builder.body(BodySpec::new(format!("b{body}")).mass(1.0));
    }
    let name = |body: usize| if body == 0 { "ground".to_owned() } else { format!("b{body}") };
    for (index, &(a, b, at)) in joints.iter().enumerate() {
        let frame = along(at, v(0.0, 0.0, 1.0));
        let spec = JointSpec::new(format!("j{index}"), JointType::Revolute, name(a), name(b));
        let spec = spec.frames(frame, frame);
        builder = builder.joint(if actuated.contains(&index) { spec.actuated() } else { spec });
    }
    let of = |joint: usize| Coordinate::Joint { joint: JointId(joint), dof: 0 };
    // The first joint of each body holds the body; the joints after those close the loops.
    let coordinates: Vec<Coordinate> = match joints.len() == bodies {
        true => (0..bodies).map(of).collect(),
        false => vec![of(0)],
    };
    let targets = vec![Target { value: 0.0, rate: 0.0, acceleration: 0.0 }; coordinates.len()];
    let homes: Vec<_> = (1..=bodies).map(|body| (BodyId(body), Pose::identity())).collect();
    let (mechanism, settings) = (builder.build().unwrap(), Settings::default());
    InverseDynamics::new(mechanism, &homes, &coordinates, &targets, settings).unwrap()
}

/// In a chain, the motions of a body depend only on the joints before it, so the first bodies of a
/// long chain have the same motions as those of a short one.
#[test]
fn first_bodies_of_a_long_chain_move_like_those_of_a_short_one() {
    let motions = |bodies: usize| {
        // The joints are not on one line.
        let at = |k: usize| v(0.1 * k as f64, 0.03 * (k * k % 7) as f64, 0.0);
        let joints: Vec<_> = (0..bodies).map(|k| (k, k + 1, at(k))).collect();
        let found = Mobility::of(&assembled(bodies, &joints, &[]));
        assert_eq!(found.finite.decided(), Some(bodies));
        found.bodies.into_iter().map(|body| body.motions).collect::<Vec<_>>()
    };
    let (short, long) = (motions(6), motions(200));
    assert_eq!(short[..], long[..6]);
    let counts: Vec<usize> = long.iter().map(Vec::len).collect();
    assert_eq!((counts[0], counts[1]), (1, 2));
    assert!(counts[2..].iter().all(|count| *count == 3));
}

/// A row of parallelograms has three self-stresses for each loop. Without a second actuator, they
/// load no actuator; with a second one, the redundant actuators and the redundant constraints need
/// two weightings.
#[test]
fn long_rows_have_the_weighting_of_short_ones() {
    let weighting = |loops: usize, actuated: &[usize]| {
        let at = |k: usize, y: f64| v(k as f64, y, 0.0);
        // Cranks first, then couplers.
        let mut joints: Vec<_> = (0..=loops).map(|k| (0, k + 1, at(k, 0.0))).collect();
        for k in 0..loops {
            let coupler = loops + 2 + k;
            joints.push((k + 1, coupler, at(k, 1.0)));
            joints.push((coupler, k + 2, at(k + 1, 1.0)));
        }
        let solver = assembled(2 * loops + 1, &joints, actuated);
        solver.model().map(|_| solver.weighting().unwrap())
    };
    for loops in [2, 12] {
        assert_eq!(weighting(loops, &[0]), Ok(Weighting::LeastReactions), "{loops}");
        assert_eq!(weighting(loops, &[0, 1]), Err(InverseError::TwoWeightings), "{loops}");
    }
}
