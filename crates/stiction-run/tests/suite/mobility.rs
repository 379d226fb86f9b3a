//! Mobility of the robots of the gallery by three methods.

use crate::common::*;
use stiction_core::dynamics::{InverseDynamics, Settings};
use stiction_core::mobility::Mobility;
use stiction_format::ModelFile;

fn mobility(model: &ModelFile) -> Mobility {
    let motion = model.motion(model.default_motion.as_ref().unwrap()).unwrap();
    let coordinates: Vec<_> = motion.coordinates.iter().map(|(c, _)| *c).collect();
    let targets: Vec<_> = motion.at(motion.start + 0.1 * motion.duration).collect();
    let (mechanism, initial_poses) = (model.mechanism.clone(), &model.initial_poses);
    let solver =
        InverseDynamics::new(mechanism, initial_poses, &coordinates, &targets, Settings::default());
    Mobility::of(&solver.unwrap())
}

fn dofs(name: &str, body: &str) -> (Vec<String>, Vec<String>) {
    let found = mobility(&model(name)).bodies.into_iter().find(|known| known.body == body);
    found.map(|body| (body.motions, body.first_order_only)).unwrap()
}

#[test]
fn motions_of_bodies_in_words() {
    let (lasting, brief) = dofs("zhang2018", "platform");
    assert_eq!(lasting, ["translation along x", "translation along z", "rotation about y"]);
    assert_eq!(brief.len(), 1);
    assert_eq!(brief, ["rotation about the line leg2.S - leg3.S (along x)"]);
    let (lasting, brief) = dofs("3rrr", "platform");
    assert_eq!(lasting, ["translation along x", "translation along y", "rotation about z"]);
    assert!(brief.is_empty());
    let (lasting, _) = dofs("slider-crank", "slider");
    assert_eq!(lasting, ["translation along x"]);
    let (lasting, _) = dofs("slider-crank", "crank");
    assert_eq!(lasting, ["rotation about z through (0, 0, 0) m"]);
    let (lasting, _) = dofs("gough", "platform");
    assert_eq!(lasting.len(), 6);
    for name in ["delta", "3upu"] {
        let (lasting, _) = dofs(name, "platform");
        let moves = ["translation along x", "translation along y", "translation along z"];
        assert_eq!(lasting, moves, "{name}");
    }
    let (lasting, _) = dofs("spherical-3rrr", "camera");
    assert_eq!(lasting, ["x", "y", "z"].map(|k| format!("rotation about {k} through (0, 0, 0) m")));
}

/// Tests, for each robot, the Gruebler count, instantaneous mobility, finite mobility, and the
/// number of redundant constraints.
#[test]
fn of_the_gallery() {
    let known = [
        // For the robot as printed, the three constraint forces are parallel and coplanar, so the
        // platform rolls to first order only.
        ("zhang2018", 3, 4, 3, 1),
        ("zhang2018-regular", 3, 3, 3, 0),
        ("3rps", 3, 3, 3, 0),
        ("gough", 6, 6, 6, 0),
        ("four-bar", -2, 1, 1, 3),
        ("slider-crank", -2, 1, 1, 3),
        ("five-bar", -1, 2, 2, 3),
        ("3rrr", -3, 3, 3, 6),
        ("bricard", 0, 1, 1, 1),
        ("6sps", 12, 12, 12, 0),
        // 10 bodies, 3 R and 12 S: 60 - 15 - 36. Each pair of rods constrains one rotation of the
        // platform, so it has three translations; each of the six rods has a local DOF.
        ("delta", 9, 9, 9, 0),
        // 7 bodies, 10 R: 42 - 50. In the plane 21 - 20; three loops with three redundant
        // constraints each.
        ("andrews", -8, 1, 1, 9),
        // 13 bodies, 6 U, 6 P, 6 S: 78 - 24 - 30 - 18. An actuation singularity, not a constraint
        // singularity.
        ("griffis-duffy", 6, 6, 6, 0),
        // 7 bodies, 6 U, 3 P: 42 - 24 - 15. Three constraint couples, along the normals of the two
        // axis directions of each leg; these are independent.
        ("3upu", 3, 3, 3, 0),
        // The Gruebler count is the same, but the three couples are all vertical, so only one is
        // independent: 6 - 1. Two couples are redundant. Finite motions are the three translations,
        // or as many others.
        ("3upu-singular", 3, 5, 3, 2),
        // 7 bodies, 9 R: 42 - 45. On the sphere, each of the two loops has three redundant
        // constraints.
        ("spherical-3rrr", -3, 3, 3, 6),
        // 11 bodies, 6 U, 5 P, 4 S: 66 - 24 - 25 - 12. One leg with five DOFs, the others with six.
        ("4ups-upu", 5, 5, 5, 0),
    ];
    for (name, gruebler, instantaneous, finite, redundant) in known {
        let found = mobility(&model(name));
        let counts = (
            found.gruebler,
            found.instantaneous,
            found.finite.decided().expect("decided"),
            found.redundant_constraints,
        );
        assert_eq!(counts, (gruebler, instantaneous, finite, redundant), "{name} {found:?}");
        let (kept, dropped) = found.gap;
        assert!(kept.unwrap() > 1e-4 && dropped.is_none_or(|d| d < 1e-12), "{name} {found:?}");
    }
}
