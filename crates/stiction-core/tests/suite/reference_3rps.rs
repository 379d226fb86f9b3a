//! The symmetric 3-RPS robot compared with a 60-digit solution.

use crate::common::*;
use stiction_core::dynamics::{InverseDynamics, Settings};
use stiction_core::spatial::Vec3;

#[test]
fn motion_drives_and_reactions() {
    let robot = symmetric_3rps(None);
    let (motion, drives, reactions) = (
        table("3rps_symmetric_trajectory.csv"),
        table("3rps_symmetric_actuator.csv"),
        table("3rps_symmetric_reactions.csv"),
    );
    let load = symmetric_load(&robot);
    let platform = robot.mechanism.body_id("platform").unwrap().0;
    let joint = |name: String| robot.mechanism.joint_id(&name).unwrap().0;
    let mut solver = InverseDynamics::new(
        robot.mechanism.clone(),
        &robot.initial_poses,
        &robot.coordinates,
        &symmetric_motion(0.0),
        Settings::default(),
    )
    .unwrap();

    // For each column, computed and expected values.
    let mut columns: std::collections::BTreeMap<String, Vec<(f64, f64)>> = Default::default();
    let mut before = 0.0;
    for ((state, drive), reaction) in motion.iter().zip(&drives).zip(&reactions) {
        let t = number(state, "t");
        solver
            .follow(before, t, |t, targets| targets.copy_from_slice(&symmetric_motion(t)))
            .unwrap();
        before = t;
        solver.solve(&[load]).unwrap();
        let bodies = solver.bodies();
        let forces = solver.forces();
        let mut compare = |name: String, found: f64, expected: f64| {
            columns.entry(name).or_default().push((found, expected));
        };

        let pose = bodies.pose[platform];
        let origin = solver.parameters().origin;
        let position = pose.position + origin;
        let velocity = bodies.twist[platform].velocity_at(pose.position);
        compare("x".into(), position.x, number(state, "x"));
        compare("y".into(), position.y, number(state, "y"));
        compare("xd".into(), velocity.x, number(state, "xd"));
        compare("yd".into(), velocity.y, number(state, "yd"));
        let acceleration = bodies.acceleration[platform].velocity_at(pose.position)
            + bodies.twist[platform].angular.cross(velocity);
        compare("xdd".into(), acceleration.x, number(state, "xdd"));
        compare("ydd".into(), acceleration.y, number(state, "ydd"));
        let vectors = [
            ("om", bodies.twist[platform].angular),
            ("dom", bodies.acceleration[platform].angular),
        ];
        for (name, vector) in vectors {
            for (axis, found) in ["x", "y", "z"].iter().zip(vector.to_array()) {
                compare(format!("{name}_{axis}"), found, number(state, &format!("{name}_{axis}")));
            }
        }
        for n in 1..=3 {
            let axes =
                bodies.pose[robot.mechanism.body_id(&format!("leg{n}.base")).unwrap().0].rotation;
            compare(format!("tau{n}"), forces.efforts[n - 1], number(drive, &format!("tau{n}")));
            let (fs, _) = forces.reactions[joint(format!("leg{n}.S"))];
            let (fr, mr) = forces.reactions[joint(format!("leg{n}.R"))];
            // The origin of the P joint is at the R joint.
            let (fp, mp) = forces.reactions[joint(format!("leg{n}.P"))];
            let in_leg = |vector: Vec3<f64>| axes.transpose_mul(vector);
            let (fp, mpr) = (in_leg(fp), in_leg(mp));
            for (name, vector) in [("FS", fs), ("FR", fr), ("MR", mr)] {
                for (axis, found) in ["x", "y", "z"].iter().zip(vector.to_array()) {
                    let column = format!("{name}{n}_{axis}");
                    compare(column.clone(), found, number(reaction, &column));
                }
            }
            compare(format!("FP{n}_xL"), fp.x, number(reaction, &format!("FP{n}_xL")));
            compare(format!("FP{n}_yL"), fp.y, number(reaction, &format!("FP{n}_yL")));
            for (axis, found) in ["xL", "yL", "zL"].iter().zip(mpr.to_array()) {
                let column = format!("MPR{n}_{axis}");
                compare(column.clone(), found, number(reaction, &column));
            }
        }
    }
    for (name, pairs) in &columns {
        let largest = pairs.iter().map(|p| p.1.abs()).fold(0.0, f64::max);
        let error = pairs.iter().map(|p| (p.0 - p.1).abs()).fold(0.0, f64::max);
        // Columns that are zero by symmetry are compared relative to typical moments of 10 N m.
        let scale = if largest < 1e-9 { 10.0 } else { largest };
        assert!(error <= 1e-11 * scale, "{name}: {error:e} of {largest:e}");
    }
    assert_eq!(motion.len(), 101);
}
