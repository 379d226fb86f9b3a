//! Programs for control loops compared with the general solver, with the actuators' coordinates as
//! inputs.

use crate::common::{Loop, gallery_loop, machine};
use stiction_core::dynamics::{FrictionMode, InverseDynamics, Settings, Status};
use stiction_core::kinematics::Target;
use stiction_core::mechanism::{Body, BodyId};
use stiction_core::spatial::{Mat3, Vec3};
use stiction_program::emit::TestVector;
use stiction_program::{Feedforward, RecordError, Shortfall, Tunable};

/// Tolerance relative to the largest actuator force of a state: rounding errors of about 1e-15,
/// magnified by condition numbers below 1e3 and by differences of forces.
const ROUNDING: f64 = 1e-11;

fn record(robot: &Loop, tunables: &[Tunable]) -> Feedforward {
    let program = Feedforward::record(&robot.solver, &robot.signal, tunables);
    program.unwrap_or_else(|error| panic!("{error}"))
}

/// Difference of the program from these efforts, relative to the largest of them.
fn difference(program: &Feedforward, vector: &TestVector, tuned: Option<&[f64]>) -> f64 {
    let mut memory = program.memory();
    if let Some(values) = tuned {
        program.tune(&mut memory, values);
    }
    let home = program.home().to_vec();
    let TestVector { positions, rates, accelerations, efforts } = vector;
    // Moves from the home position in small steps, as the solver does.
    for k in 1..100 {
        let part = f64::from(k) / 100.0;
        let q: Vec<f64> = home.iter().zip(positions).map(|(h, q)| h + (q - h) * part).collect();
        let outcome = program.run(&mut memory, &q, rates, accelerations);
        assert_ne!(outcome.shortfall, Some(Shortfall::Open));
    }
    let outcome = program.run(&mut memory, positions, rates, accelerations);
    assert_eq!(outcome.shortfall, None);
    assert!(outcome.residual < 1e-12 && outcome.determinant > 0.0, "{outcome:?}");
    let largest = efforts.iter().fold(0.0_f64, |max, effort| max.max(effort.abs()));
    let apart = |(k, effort): (usize, &f64)| (program.drive(&memory, k) - effort).abs();
    efforts.iter().enumerate().map(apart).fold(0.0, f64::max) / largest
}

/// The program reproduces the solver's forces at random states; it also solves the loop closure.
#[test]
fn feedforward_programs_agree_with_the_solver() {
    for name in ["3rps", "five-bar", "delta", "slider-crank", "four-bar", "zhang2018-regular"] {
        let robot = gallery_loop(name).unwrap();
        let program = record(&robot, &Tunable::frictions(robot.solver.parameters()));
        let vectors = TestVector::random(&robot.solver, &robot.signal, 40, 3);
        assert!(vectors.len() > 20, "{name}: {}", vectors.len());
        for vector in &vectors {
            let apart = difference(&program, vector, None);
            assert!(apart < ROUNDING, "{name}: {apart:e} at {vector:?}");
        }
    }
}

/// Changed coefficients and masses act as in the general kernel with changed parameters; a payload
/// acts as an additional body of the mechanism.
#[test]
fn tunable_parameters_act_as_in_the_model() {
    let robot = gallery_loop("3rps").unwrap();
    let mut parameters = robot.solver.parameters().clone();
    let mut tunables = Tunable::frictions(&parameters);
    tunables.extend(Tunable::masses(&parameters));
    let program = record(&robot, &tunables);
    let mut values = Vec::new();
    for (k, tunable) in tunables.iter().enumerate() {
        let number = match *tunable {
            Tunable::Mu(k) => &mut parameters.interfaces[k].law.mu,
            Tunable::Viscous(k) => &mut parameters.interfaces[k].law.viscous,
            Tunable::Mass(body) => &mut parameters.mass[body.0],
            _ => panic!("{tunable:?}"),
        };
        *number = *number * 1.3 + 0.001 * k as f64;
        values.push(*number);
    }
    let mut solver = robot.solver.clone();
    solver.move_to(&robot.signal[0]).unwrap();
    let model = solver.model().unwrap();
    let mut data = model.data(solver.state(), Settings::default());
    let q: Vec<f64> = robot.signal[0].iter().map(|target| target.value).collect();
    let (rates, accelerations) = (vec![0.1, -0.2, 0.3], vec![1.0, 2.0, -3.0]);
    let status =
        model.inverse_dynamics_with(&parameters, &mut data, &q, &rates, &accelerations, &[]);
    assert_eq!(status, Status::Converged);
    let efforts = data.efforts().to_vec();
    let vector = TestVector { positions: q, rates, accelerations, efforts };
    assert!(difference(&program, &vector, Some(&values)) < ROUNDING);
    assert!(difference(&program, &vector, None) > 1e-3);

    // Without a payload, the expected values use the numbers of the model; with a payload, a
    // mechanism with an additional body.
    let platform = BodyId(robot.solver.mechanism().bodies().len() - 1);
    let mechanism = robot.solver.mechanism();
    let heavy = (1..=platform.0).map(BodyId).find(|body| mechanism.bodies()[body.0].mass > 0.0);
    let heavy = heavy.unwrap();
    let program = record(&robot, &[Tunable::Payload(heavy)]);
    let part = Body {
        mass: 1.5,
        com: Vec3::new(0.03, -0.02, 0.05),
        inertia: Mat3::zero(),
        ..mechanism.bodies()[heavy.0].clone()
    };
    let loaded = mechanism.with_payload(heavy, &part);
    for (mechanism, values) in [(mechanism.clone(), [0.0; 4]), (loaded, [1.5, 0.03, -0.02, 0.05])] {
        let coordinates = robot.solver.constraints().coordinates().to_vec();
        let mut solver = InverseDynamics::new(
            mechanism,
            &[],
            &coordinates,
            &robot.signal[0],
            Settings::default(),
        )
        .unwrap();
        solver.settings_mut().friction = FrictionMode::Converged;
        let vectors = TestVector::random(&solver, &robot.signal, 5, 4);
        assert!(!vectors.is_empty());
        for vector in &vectors {
            let apart = difference(&program, vector, Some(&values));
            assert!(apart < ROUNDING, "{values:?}: {apart:e}");
        }
    }
}

/// Unreachable positions, interfaces at rest and impossible parameters have different return codes.
#[test]
fn a_feedforward_program_tells_why_there_is_no_answer() {
    let robot = gallery_loop("3rps").unwrap();
    let program = record(&robot, &[]);
    let mut memory = program.memory();
    let home = program.home().to_vec();
    let still = [0.0; 3];
    let outcome = program.run(&mut memory, &home, &still, &still);
    assert_eq!(outcome.shortfall, Some(Shortfall::Friction));
    let outcome = program.run(&mut memory, &[home[0] + 10.0, home[1], home[2]], &still, &still);
    assert_eq!(outcome.shortfall, Some(Shortfall::Open));
    // The last position remains.
    let outcome = program.run(&mut memory, &home, &[0.1, 0.2, 0.3], &still);
    assert_eq!((outcome.shortfall, outcome.passes[0]), (None, 0));
    let ground = Tunable::Payload(BodyId(0));
    let refused = Feedforward::record(&robot.solver, &robot.signal, &[ground]).unwrap_err();
    assert_eq!(refused, RecordError::NoTunable(ground));
}

/// Programs contain all branches and terms of the friction laws and of the normal loads, also those
/// that act only at speeds and accelerations far from usual ones: Stribeck terms and regularisation
/// at creeping speeds, all intervals of tables, axial forces of both signs, and bearings without
/// radial force.
#[test]
fn programs_hold_at_all_speeds_and_accelerations() {
    for (kind, friction) in [
        ("slide", "{ mu = 0.1, mu_static = 0.2, stribeck_velocity = \"0.3 mm/s\" }"),
        (
            "slide",
            "{ mu = 0.1, mu_static = 0.2, stribeck_velocity = \"1 mm/s\", stribeck_exponent = 0.7 }",
        ),
        ("slide", "{ mu = 0.1, regularised = \"tanh\", regularisation_velocity = \"1 mm/s\" }"),
        ("slide", "{ table = [[0, 0.2], [0.001, 0.1], [0.05, 0.15], [20, 0.1]] }"),
        ("wrist", "{ mu = 0.1, radius = \"10 mm\", collar_radius = \"20 mm\" }"),
        ("screw", "{ mu = 0.1, radius = \"10 mm\", flank_angle = \"15 deg\" }"),
        (
            "screw",
            "{ table = [[0, 0.2], [0.001, 0.1], [1, 0.05]], radius = \"10 mm\", flank_angle = \"15 deg\" }",
        ),
    ] {
        let robot = machine(kind, friction);
        let program = record(&robot, &[]);
        let mut memory = program.memory();
        let mut solver = robot.solver.clone();
        solver.settings_mut().friction = FrictionMode::Converged;
        for rate in [1e-5, 4e-5, 1.6e-4, 3e-3, 0.02, 0.3, 40.0] {
            for acceleration in [-2e3, -60.0, -9.0, -0.1, 0.0, 0.5, 70.0, 1e4] {
                for direction in [-1.0, 1.0] {
                    let mut targets = robot.signal[1].clone();
                    for (k, target) in targets.iter_mut().enumerate() {
                        let other = if k == 0 { 1.0 } else { -0.7 };
                        target.rate = direction * rate * other;
                        target.acceleration = acceleration;
                    }
                    solver.move_to(&targets).unwrap();
                    let forces = solver.solve(&[]);
                    let of = |f: fn(&Target<f64>) -> f64| targets.iter().map(f).collect::<Vec<_>>();
                    let (q, v, a) = (of(|t| t.value), of(|t| t.rate), of(|t| t.acceleration));
                    let outcome = program.run(&mut memory, &q, &v, &a);
                    let at = format!("{kind} {friction}: {v:?} {a:?}");
                    let Ok(forces) = forces else {
                        assert_eq!(outcome.shortfall, Some(Shortfall::Friction), "{at}");
                        continue;
                    };
                    let reactions = forces.reactions.iter().map(|(force, _)| force.norm());
                    let largest = reactions.fold(1e-9, f64::max);
                    for (k, effort) in forces.efforts.iter().enumerate() {
                        let found = program.drive(&memory, k);
                        let apart = (found - effort).abs() / largest;
                        assert!(outcome.shortfall.is_none(), "{at}: {outcome:?}");
                        assert!(apart < 1e-10, "{at}: {found} {effort}");
                    }
                }
            }
        }
    }
}
