//! Columns of the regression compared with inverse dynamics for changed parameters.

use super::robots::*;
use nalgebra::DVector;
use stiction_core::Vec3;
use stiction_core::dynamics::Status;
use stiction_core::random::Random;
use stiction_identify::{Choice, Kind, Parameter, Regressor, Rest, applied, catalogue};

/// Efforts of inverse dynamics with changed inertia and friction equal the linear form, for every
/// gallery model whose motion is determined by its actuators.
#[test]
fn columns_agree_with_inverse_dynamics_of_changed_parameters() {
    let mut tried = 0;
    for (name, home, mut regressor) in gallery_regressors() {
        tried += 1;
        let mut random = Random::new(11);
        let parameters = regressor.parameters().to_vec();
        let changed: Vec<f64> = parameters
            .iter()
            .map(|p| match p.kind {
                Kind::Moment(..) => p.prior + 0.01 * p.scale * random.number(),
                Kind::Inertia(_, entry) if entry >= 3 => p.prior,
                Kind::Coulomb(_) => p.prior + 0.02,
                // Load-independent friction remains.
                Kind::Mu(0) => 0.0,
                _ => p.prior * (1.05 + 0.04 * random.number()),
            })
            .collect();
        let priors: Vec<f64> = parameters.iter().map(|p| p.prior).collect();
        let mut done = 0;
        for _ in 0..8 {
            let [q, v, a] = random_motion(&mut random, &home, 0.02);
            let Ok(columns) = regressor.at(&q, &v, &a) else { continue };
            let engine = regressor.engine_parameters(&changed);
            let mut data = regressor.engine_data();
            let Ok(solved) = regressor.loads(&engine, &mut data, [&q, &v, &a]) else { continue };
            let mut expected = columns.known.clone();
            for (k, p) in parameters.iter().enumerate() {
                let value = if p.body().is_some() { changed[k] - priors[k] } else { changed[k] };
                // The Coulomb column already contains the friction of the preload.
                let load = match p.kind {
                    Kind::Mu(i) => solved.loads[i],
                    _ => 1.0,
                };
                // Columns of actuated joints without friction interfaces have no counterpart in
                // inverse dynamics.
                if !matches!(p.kind, Kind::DriveCoulomb(_) | Kind::DriveViscous(_)) {
                    expected += columns.matrix.column(k) * (value * load);
                }
            }
            let found = DVector::from_column_slice(data.efforts());
            // Both methods solve the same equations; round-off errors of ill-conditioned
            // configurations remain.
            let error = (&found - &expected).norm();
            assert!(error < 1e-8 * (1.0 + found.norm()), "{name}: {found} {expected}");
            done += 1;
        }
        assert!(done > 0, "{name}");
    }
    assert!(tried >= 8, "{tried}");
}

#[test]
fn friction_at_rest_is_marked() {
    let mut model = gallery_model("five-bar");
    model.default_motion = Some("pick".into());
    let (solver, home) = gallery_solver(&model);
    let mut regressor = Regressor::new(solver, &Choice::ALL).unwrap();
    let still = regressor.at(&home, &[0.0; 2], &[0.0; 2]).unwrap();
    assert_eq!(still.rest, [Rest::Resting; 2]);
    let moving = regressor.at(&home, &[0.1, 0.05], &[0.0; 2]).unwrap();
    assert_eq!(moving.rest, [Rest::Sliding; 2]);
    // The sign of a rate below its noise is unknown.
    regressor.set_rate_noise(&[0.1, 0.1]);
    let noisy = regressor.at(&home, &[0.1, 0.05], &[0.0; 2]).unwrap();
    assert_eq!(noisy.rest, [Rest::Uncertain; 2]);
}

/// Friction of an actuator is assigned to the motor only if its efforts were measured at the motor.
#[test]
fn friction_measured_at_joints_is_not_that_of_motors() {
    let mechanism = serial_with_motors(&[(0.0, 0.4, 0.0)], Vec3::zero());
    for at_motors in [false, true] {
        let parameters = catalogue(&mechanism, &Choice { at_motors, ..Choice::ALL });
        let value = |p: &Parameter| match p.kind {
            Kind::DriveCoulomb(_) => 3.0,
            _ => p.prior,
        };
        let values: Vec<f64> = parameters.iter().map(value).collect();
        let found = applied(&mechanism, &parameters, &values, (at_motors, &[]));
        let motor = found.drive_trains()[0].motor_friction.constant;
        let joint: f64 = found.joints()[0].friction.iter().map(|f| f.law.mu * f.load.preload).sum();
        // The gear ratio is 50.
        let expected = if at_motors { (3.0 / 50.0, 0.0) } else { (0.0, 3.0) };
        assert!((motor - expected.0).abs() < 1e-12, "{motor}");
        assert!((joint - expected.1).abs() < 1e-12, "{joint}");
    }
}

#[test]
fn unreachable_positions_are_refused() {
    let (solver, _) = gallery_solver(&gallery_model("five-bar"));
    let mut regressor = Regressor::new(solver, &Choice::ALL).unwrap();
    let status = regressor.at(&[3.0, 3.0], &[0.0; 2], &[0.0; 2]).unwrap_err();
    assert!(!matches!(status, Status::Converged));
    let chain = serial(&[(0.0, 0.4, 0.0), (0.0, 0.3, 0.0)], Vec3::new(0.0, -9.81, 0.0));
    assert!(regressor.at(&[0.0; 2], &[f64::NAN; 2], &[0.0; 2]).is_err());
    assert_eq!(chain.actuators().count(), 2);
}

/// A configuration far from the last one is reached in the assembly mode of a stored state near it;
/// a direct jump does not reach this mode.
#[test]
fn a_stored_state_keeps_the_assembly_mode() {
    let model = gallery_model("five-bar");
    let (solver, home) = gallery_solver(&model);
    let mut regressor = Regressor::new(solver, &Choice::ALL).unwrap();
    let poses_at = |regressor: &mut Regressor, part: f64| {
        let goal = [-0.0955, 0.1207];
        let q: Vec<f64> = home.iter().zip(goal).map(|(h, g)| h + part * (g - h)).collect();
        let status = regressor.at(&q, &[0.0; 2], &[0.0; 2]).map(|_| ());
        status.map(|()| regressor.bodies().pose.clone())
    };
    let start = regressor.state().clone();
    // Moves in small steps along a line of the tool.
    let mut expected = Vec::new();
    for k in 0..=150 {
        expected = poses_at(&mut regressor, f64::from(k) / 150.0).unwrap();
    }
    let state = regressor.state().clone();
    let away = |regressor: &mut Regressor| {
        let poses = poses_at(regressor, 1.0).unwrap();
        let each = poses.iter().zip(&expected).map(|(a, b)| (a.position - b.position).norm());
        each.fold(0.0, f64::max)
    };
    regressor.start_from(&start);
    assert!(away(&mut regressor) > 0.1, "the jump finds the same mode");
    regressor.start_from(&state);
    // Loops are closed to 1e-12 of the robot's length.
    assert!(away(&mut regressor) < 1e-11);
}
