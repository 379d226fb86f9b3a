//! The kernels with scalar types other than `f64`.

use crate::common::*;
use stiction_core::dynamics::{AppliedLoad, InverseDynamics, Model, Settings};
use stiction_core::kinematics::{State, Target};
use stiction_core::parameters::Parameters;
use stiction_core::scalar::{Dual, Lanes, Scalar};

struct Subject {
    model: Model,
    parameters: Parameters<f64>,
    state: State<f64>,
    targets: Vec<Target<f64>>,
    load: AppliedLoad<f64>,
}

/// Creates the 3-RPS robot with friction in all joints, in the middle of its motion.
fn subject() -> Subject {
    let rub = [
        friction(0.12, 0.02, Some(0.0125)),
        friction(0.12, 0.02, None),
        friction(0.12, 0.02, Some(0.025)),
    ];
    let robot = symmetric_3rps(Some(rub));
    let targets = symmetric_motion(0.13);
    let load = symmetric_load(&robot);
    let solver = InverseDynamics::new(
        robot.mechanism,
        &robot.initial_poses,
        &robot.coordinates,
        &targets,
        Settings::default(),
    )
    .unwrap();
    Subject {
        model: solver.model().unwrap(),
        parameters: solver.parameters().clone(),
        state: solver.state().clone(),
        targets: targets.to_vec(),
        load,
    }
}

/// Settings with a fixed number of iterations in every kernel.
const SETTINGS: fn() -> Settings = || Settings {
    position_steps: 4,
    friction_steps: 6,
    friction_tolerance: 0.0,
    ..Settings::default()
};

fn run<T: Scalar>(
    subject: &Subject,
    parameters: &Parameters<T>,
    targets: &[Target<T>],
    load: AppliedLoad<T>,
) -> (Vec<T>, Vec<T>) {
    let mut data = subject.model.data(&subject.state, SETTINGS());
    subject.model.evaluate(parameters, &mut data, targets, &[load]);
    let wrenches = data.inverse.joint_wrenches();
    let numbers =
        wrenches.iter().flat_map(|w| w.force.to_array().into_iter().chain(w.moment.to_array()));
    (data.inverse.efforts().to_vec(), numbers.collect())
}

/// Number of varied inputs: values, rates and accelerations of the three targets, load components,
/// a mass, a friction coefficient, a radius, a length.
const DIRECTIONS: usize = 14;

fn vary<T: Scalar>(
    targets: &mut [Target<T>],
    load: &mut AppliedLoad<T>,
    parameters: &mut Parameters<T>,
    direction: usize,
    by: T,
) {
    match direction {
        0..3 => targets[direction].value += by,
        3..6 => targets[direction - 3].rate += by,
        6..9 => targets[direction - 6].acceleration += by,
        9 => load.force.x += by,
        10 => parameters.mass[2] += by,
        11 => parameters.interfaces[0].law.mu += by,
        12 => parameters.interfaces[2].radius += by,
        _ => parameters.frame_j[0].position.y += by,
    }
}

#[test]
fn dual_numbers_differentiate_drives_and_reactions() {
    type D = Dual<f64, DIRECTIONS>;
    let subject = subject();
    let numbers = |steps: [f64; DIRECTIONS]| {
        let (mut targets, mut load, mut parameters) =
            (subject.targets.clone(), subject.load, subject.parameters.clone());
        for (direction, &step) in steps.iter().enumerate() {
            vary(&mut targets, &mut load, &mut parameters, direction, step);
        }
        let (drives, wrenches) = run(&subject, &parameters, &targets, load);
        [drives, wrenches].concat()
    };

    let mut targets: Vec<Target<D>> = subject.targets.iter().map(|t| t.lift()).collect();
    let mut load = subject.load.lift();
    let mut parameters = lifted_parameters();
    for direction in 0..DIRECTIONS {
        vary(&mut targets, &mut load, &mut parameters, direction, D::variable(0.0, direction));
    }
    let (drives, wrenches) = run(&subject, &parameters, &targets, load);
    let exact = [drives, wrenches].concat();

    // Eighth-order central differences.
    let weights = [4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0];
    for direction in 0..DIRECTIONS {
        let h = if direction >= 12 { 2e-4 } else { 2e-3 };
        let at = |factor: f64| {
            let mut steps = [0.0; DIRECTIONS];
            steps[direction] = factor * h;
            numbers(steps)
        };
        let mut difference = vec![0.0; exact.len()];
        for (k, weight) in weights.into_iter().enumerate() {
            let (ahead, behind) = (at((k + 1) as f64), at(-((k + 1) as f64)));
            for ((d, a), b) in difference.iter_mut().zip(ahead).zip(behind) {
                *d += weight * (a - b) / h;
            }
        }
        let scale = difference.iter().fold(1e-3f64, |max, x| max.max(x.abs()));
        for (found, expected) in exact.iter().zip(&difference) {
            let error = (found.slope[direction] - expected).abs();
            // The differences have a round-off of about 1e-14 of the forces divided by the step.
            assert!(error < 1e-9 * scale, "direction {direction}: {error:e} of {scale}");
        }
    }
}

fn lifted_parameters<T: Scalar>() -> Parameters<T> {
    let rub = [
        friction(0.12, 0.02, Some(0.0125)),
        friction(0.12, 0.02, None),
        friction(0.12, 0.02, Some(0.025)),
    ];
    Parameters::new(&symmetric_3rps(Some(rub)).mechanism)
}

#[test]
fn lanes_agree_with_single_runs() {
    type L = Lanes<f64, 8>;
    let subject = subject();
    let instants: [f64; 8] = std::array::from_fn(|i| 0.10 + 0.01 * i as f64);
    let pick = |f: fn(&Target<f64>) -> f64, k: usize| {
        L::from_fn(|lane| f(&symmetric_motion(instants[lane])[k]))
    };
    let targets: Vec<Target<L>> = (0..3)
        .map(|k| Target {
            value: pick(|t| t.value, k),
            rate: pick(|t| t.rate, k),
            acceleration: pick(|t| t.acceleration, k),
        })
        .collect();
    let (drives, wrenches) =
        run(&subject, &lifted_parameters::<L>(), &targets, subject.load.lift());
    for (lane, &t) in instants.iter().enumerate() {
        let (d, w) = run(&subject, &subject.parameters, &symmetric_motion(t), subject.load);
        for (many, one) in drives.iter().zip(&d).chain(wrenches.iter().zip(&w)) {
            // The results must be identical: the same operations are computed in the same order.
            assert_eq!(many.0[lane], *one);
        }
    }
}

/// SIMD lanes of dual numbers yield derivatives of several states at once.
#[test]
fn lanes_of_dual_numbers() {
    type LD = Dual<Lanes<f64, 4>, 2>;
    let subject = subject();
    let mut targets: Vec<Target<LD>> = subject.targets.iter().map(|t| t.lift()).collect();
    for direction in 0..2 {
        let one = LD::variable(Lanes::from_f64(0.0), direction);
        targets[direction].acceleration += one;
    }
    let (many, _) = run(&subject, &lifted_parameters::<LD>(), &targets, subject.load.lift());
    type D = Dual<f64, 2>;
    let mut targets: Vec<Target<D>> = subject.targets.iter().map(|t| t.lift()).collect();
    for direction in 0..2 {
        targets[direction].acceleration += D::variable(0.0, direction);
    }
    let (one, _) = run(&subject, &lifted_parameters::<D>(), &targets, subject.load.lift());
    for (many, one) in many.iter().zip(&one) {
        for lane in 0..4 {
            assert_eq!(many.value.0[lane], one.value);
            for direction in 0..2 {
                assert_eq!(many.slope[direction].0[lane], one.slope[direction]);
            }
        }
    }
}
