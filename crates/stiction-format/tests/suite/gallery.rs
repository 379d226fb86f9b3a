//! Gallery models: valid, and consistent with reference data.

use stiction_format::{Source, gallery, read};

#[test]
fn all_models_are_read_without_warnings() {
    for name in gallery::names() {
        let text = gallery::get(name).unwrap();
        match read(&Source::new(format!("{name}.toml"), text), &|_| Err("no files".into())) {
            Ok(model) => {
                assert!(model.warnings.is_empty(), "{name}:\n{}", model.warnings);
                assert_eq!(model.name, name);
                assert!(!model.title.is_empty() && !model.source.is_empty());
                assert!(model.default_motion.is_some());
            }
            Err(diagnostics) => panic!("{diagnostics}"),
        }
    }
}

/// Mistakes that leave the text valid are reported as warnings: an inertia ten times too large,
/// masses in g, an inertia in kg mm^2.
#[test]
fn unlikely_inertias_and_masses_are_doubted() {
    for (name, change, says) in [
        ("gough", "platform.inertia=[26, 26, 41]", "the inertia of body `platform`"),
        ("gough", "tube.inertia=[3, 3, 0.12]", "the inertia of body `leg1.tube`"),
        ("gough", "tube_mass=9000", "body `leg1.tube` has 9000 kg, more than a cube of gold"),
        ("gough", "tube_mass=5000", "the inertia of body `leg1.tube`"),
        ("gough", "platform.inertia=[2.6e6, 2.6e6, 4.1e6]", "the inertia of body `platform`"),
        (
            "five-bar",
            r#"left_crank.inertia={ yy = "3.5 kg*crank^2/12", zz = "3.5 kg*crank^2/12" }"#,
            "the inertia of body `left_crank`",
        ),
        ("slider-crank", "slider.mass=2000", "body `slider` has 2000 kg, more than a cube of gold"),
    ] {
        let source = Source::new(format!("{name}.toml"), gallery::get(name).unwrap());
        let changed = source.with_changes([change]);
        let warnings = read(&changed, &|_| Err("no files".into())).unwrap().warnings.to_string();
        assert!(warnings.contains(says), "{name}, {change}: {warnings}");
    }
}

mod reference {
    use stiction_core::dynamics::{FrictionMode, InverseDynamics, Settings};
    use stiction_format::{ModelFile, Source, gallery, read};

    fn model(name: &str) -> ModelFile {
        let text = gallery::get(name).unwrap();
        read(&Source::new(format!("{name}.toml"), text), &|_| Err("no files".into())).unwrap()
    }

    /// Header and rows of a reference file.
    fn rows(file: &str) -> (Vec<String>, Vec<Vec<String>>) {
        let path = format!("{}/../../reference/{file}", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(path).unwrap();
        let mut lines = text
            .lines()
            .filter(|line| !line.starts_with('#'))
            .map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
        (lines.next().unwrap(), lines.collect())
    }

    /// Actuator efforts at an instant of the default motion under a load.
    fn drives(model: &ModelFile, load: &str, friction: FrictionMode, t: f64) -> Vec<f64> {
        let motion = model.motion(model.default_motion.as_ref().unwrap()).unwrap();
        let coordinates: Vec<_> = motion.coordinates.iter().map(|(c, _)| *c).collect();
        let targets: Vec<_> = motion.at(t).collect();
        let settings = Settings { friction, ..Settings::default() };
        let mechanism = model.mechanism.clone();
        let mut solver =
            InverseDynamics::new(mechanism, &model.initial_poses, &coordinates, &targets, settings)
                .unwrap();
        let loads: Vec<_> = model.load(load).unwrap().at(t).collect();
        solver.solve(&loads).unwrap().efforts.clone()
    }

    #[test]
    fn the_3rps_agrees_with_the_reference() {
        let model = model("3rps");
        assert_eq!(model.default_friction, Some(FrictionMode::Off));
        let (_, rows) = rows("3rps_symmetric_actuator.csv");
        for row in rows.iter().step_by(10) {
            let row: Vec<f64> = row.iter().map(|cell| cell.parse().unwrap()).collect();
            let found = drives(&model, "reference", FrictionMode::Off, row[0]);
            for (found, expected) in found.iter().zip(&row[1..]) {
                // Five programs agree on these numbers, of order 100 N, within 1e-12.
                assert!((found - expected).abs() < 1e-10, "{}: {found} {expected}", row[0]);
            }
        }
    }

    #[test]
    fn the_regular_twin_agrees_with_the_reference() {
        let model = model("zhang2018-regular");
        assert_eq!(model.default_friction, Some(FrictionMode::Converged));
        let (header, rows) = rows("3rps_parallel_axis_regular_L0.csv");
        let column = |name: &str| header.iter().position(|cell| cell == name).unwrap();
        for row in &rows {
            let friction = match row[column("case")].as_str() {
                "frictionless" => FrictionMode::Off,
                "onepass" => FrictionMode::OnePass,
                _ => FrictionMode::Converged,
            };
            let t = row[column("t")].parse().unwrap();
            let found = drives(&model, "L0", friction, t);
            for (found, name) in found.iter().zip(["tau1", "tau2", "tau3"]) {
                let expected: f64 = row[column(name)].parse().unwrap();
                // The reference has ten digits.
                assert!((found - expected).abs() < 1e-7, "{t} {name}: {found} {expected}");
            }
        }
    }

    /// Checks the power balance along all motions, under all loads, with and without friction.
    #[test]
    fn the_five_bar_balances_power() {
        let mut model = model("five-bar");
        for (motion, _) in model.motions.clone() {
            model.default_motion = Some(motion.clone());
            for (load, _) in &model.loads {
                let duration = model.motion(&motion).unwrap().duration;
                for k in 0..=20 {
                    let t = duration * f64::from(k) / 20.0;
                    for friction in [FrictionMode::Off, FrictionMode::Converged] {
                        let drives = drives(&model, load, friction, t);
                        assert_eq!(drives.len(), 2);
                        // Efforts are of the order of two kilograms at a fifth of a metre, times
                        // some multiples of gravity.
                        assert!(drives.iter().all(|drive| drive.abs() < 20.0), "{motion} {t}");
                    }
                }
            }
        }
    }
}

/// Andrews' mechanism, benchmark A03; reference numbers from the test set for initial value problem
/// solvers.
mod andrews {
    use stiction_core::dynamics::InverseDynamics;
    use stiction_core::kinematics::{Coordinate, Target};
    use stiction_format::{ModelFile, Source, gallery, read};

    const NAMES: [&str; 7] = ["beta", "theta", "gamma", "phi", "delta", "Omega", "epsilon"];
    /// Angles at t = 0, rad.
    #[expect(clippy::excessive_precision, reason = "as they are published")]
    const START: [f64; 7] = [
        -0.0617138900142764496,
        0.0,
        0.455279819163070380,
        0.222668390165885885,
        0.487364979543842550,
        -0.222668390165885885,
        1.23054744454982119,
    ];
    /// Angles at t = 30 ms, after more than two turns.
    const END: [f64; 7] = [
        15.81077119629904,
        -15.75637105984298,
        0.04082224013073101,
        -0.5347301163226948,
        0.5244099658805304,
        0.5347301163226948,
        1.048080741042263,
    ];

    fn model() -> ModelFile {
        let source = Source::new("andrews.toml", gallery::get("andrews").unwrap());
        read(&source, &|_| Err("no files".into())).unwrap()
    }

    /// Inverse dynamics at the first instant of the default motion.
    fn at_the_start(model: &ModelFile) -> (InverseDynamics, Coordinate) {
        let motion = model.motion("squeeze").unwrap();
        let [(coordinate, _)] = motion.coordinates.as_slice() else { panic!() };
        let targets: Vec<_> = motion.at(0.0).collect();
        let (mechanism, initial_poses) = (model.mechanism.clone(), &model.initial_poses);
        let solver = InverseDynamics::new(
            mechanism,
            initial_poses,
            &[*coordinate],
            &targets,
            stiction_core::dynamics::Settings {
                friction: model.default_friction.unwrap(),
                ..Default::default()
            },
        );
        (solver.unwrap(), *coordinate)
    }

    fn angles(solver: &InverseDynamics) -> [f64; 7] {
        NAMES.map(|name| {
            let joint = solver.mechanism().joint_id(name).unwrap();
            solver.joint_coordinates(joint)[0]
        })
    }

    /// Compares angles modulo full turns.
    fn assert_angles(found: [f64; 7], expected: [f64; 7], error: f64) {
        for (name, (found, expected)) in NAMES.iter().zip(found.iter().zip(expected)) {
            let difference = (found - expected).rem_euclid(std::f64::consts::TAU);
            let difference = difference.min(std::f64::consts::TAU - difference);
            assert!(difference <= error, "{name}: {found} {expected}");
        }
    }

    #[test]
    fn initial_state_agrees_with_the_benchmark() {
        let model = model();
        let (mut solver, _) = at_the_start(&model);
        assert_angles(angles(&solver), START, 1e-15);
        // Joint accelerations, rad/s^2.
        let bodies = solver.bodies();
        let about_z = |joint: &str| {
            let joint = model.mechanism.joint_id(joint).unwrap();
            let joint = &model.mechanism.joints()[joint.0];
            let of = |body: usize| bodies.acceleration[body].angular.z;
            of(joint.successor.0) - of(joint.predecessor.0)
        };
        let expected = [14222.4439199541, -10666.8329399656, 0.0, 0.0, 0.0, 0.0, 0.0];
        for (name, expected) in NAMES.iter().zip(expected) {
            // The reference has fifteen digits: the tolerance is half a unit of the last digit.
            assert!((about_z(name) - expected).abs() <= 1e-10, "{name}: {}", about_z(name));
        }

        let forces = solver.solve(&[]).unwrap();
        // Residual torque due to the fifteen digits of the given acceleration.
        assert!((forces.efforts[0] - 0.033).abs() <= 1e-16 * 10.0, "{}", forces.efforts[0]);
        // The multipliers are the forces of K2 on the other bodies at the common pin.
        let expected = [
            ("pin3", [98.5668703962411, -6.12268834425567]),
            ("pin4", [0.0, 0.0]),
            ("pin6", [0.0, 0.0]),
        ];
        for (name, [x, y]) in expected {
            let joint = model.mechanism.joint_id(name).unwrap();
            let (force, _) = forces.reactions[joint.0];
            // The reference has fifteen digits, relative to the spring force of 99 N.
            assert!((force.x - x).abs() <= 1e-13, "{name}: {force:?}");
            assert!((force.y - y).abs() <= 1e-13, "{name}: {force:?}");
        }
    }

    /// The loops also have the benchmark's geometry far from the start.
    #[test]
    fn passes_through_its_last_position() {
        let model = model();
        let (mut solver, _) = at_the_start(&model);
        solver
            .follow(0.0, 1.0, |part, targets| {
                let rate = END[0] - START[0];
                targets[0] = Target { value: START[0] + part * rate, rate, acceleration: 0.0 };
            })
            .unwrap();
        // All digits of the reference, which is itself a solution to about 1e-13.
        assert_angles(angles(&solver), END, 1e-11);
    }
}
