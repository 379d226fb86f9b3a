//! The regular variant of the robot of Zhang et al. 2018: all 42 unknowns without friction, with
//! decoupled (one-pass) friction, and with converged friction.

use crate::common::*;
use stiction_core::dynamics::{FrictionMode, InverseDynamics, Settings};
use stiction_core::spatial::Vec3;

#[test]
fn all_unknowns_in_all_modes() {
    let robot = regular_twin(0.12, 0.02);
    let joint = |name: String| robot.mechanism.joint_id(&name).unwrap().0;
    let mut solver = InverseDynamics::new(
        robot.mechanism.clone(),
        &robot.initial_poses,
        &robot.coordinates,
        &twin_motion(0.0),
        Settings::default(),
    )
    .unwrap();
    let rows = table("3rps_parallel_axis_regular_L0.csv");
    assert_eq!(rows.len(), 33);
    let mut before = 0.0;
    for row in &rows {
        let t = number(row, "t");
        solver.follow(before, t, |t, targets| targets.copy_from_slice(&twin_motion(t))).unwrap();
        before = t;
        solver.settings_mut().friction = match row["case"].as_str() {
            "frictionless" => FrictionMode::Off,
            "onepass" => FrictionMode::OnePass,
            "converged" => FrictionMode::Converged,
            other => panic!("{other}"),
        };
        solver.solve(&[]).unwrap();
        let (bodies, forces) = (solver.bodies(), solver.forces());
        for n in 1..=3 {
            // The axes t, y, u of the leg are the axes x, y, z of its base.
            let axes =
                bodies.pose[robot.mechanism.body_id(&format!("leg{n}.base")).unwrap().0].rotation;
            let in_leg = |vector: Vec3<f64>| axes.transpose_mul(vector);
            let (fr, mr) = forces.reactions[joint(format!("leg{n}.R"))];
            let (fp, mp) = forces.reactions[joint(format!("leg{n}.P"))];
            let (fs, _) = forces.reactions[joint(format!("leg{n}.S"))];
            let (fr, mr, fp, mp, fs) = (in_leg(fr), in_leg(mr), in_leg(fp), in_leg(mp), in_leg(fs));
            let found = [
                ("FRt", fr.x),
                ("FRy", fr.y),
                ("FRu", fr.z),
                ("MRt", mr.x),
                ("MRu", mr.z),
                ("FPt", fp.x),
                ("FPy", fp.y),
                ("MPt", mp.x),
                ("MPy", mp.y),
                ("MPu", mp.z),
                ("tau", forces.efforts[n - 1]),
                // The reference lists the force that the platform exerts on the rod.
                ("FSt", -fs.x),
                ("FSy", -fs.y),
                ("FSu", -fs.z),
            ];
            for (name, found) in found {
                let expected = number(row, &format!("{name}{n}"));
                // The reference has ten digits.
                let last_digit = 10f64.powi(expected.abs().max(1e-9).log10().floor() as i32 - 9);
                assert!(
                    (found - expected).abs() < 0.51 * last_digit + 1e-10,
                    "t = {t} {}: {name}{n} {found} {expected}",
                    row["case"]
                );
            }
        }
        let power = forces.power;
        assert!(power.residual().abs() <= 1e-13 * power.turnover, "{power:?}");
    }
}
