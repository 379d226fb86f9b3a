//! Kernels do not allocate after set-up, and their cost grows linearly with the number of legs.

use crate::common::random::*;
use crate::common::*;
use crate::counting::allocations;
use stiction_core::dynamics::{FrictionMode, InverseDynamics, Settings, Sharing};
use stiction_core::forward::{Forward, Inputs, InterfaceMode as Doing, Simulation, View};
use stiction_core::joint::JointType::*;
use stiction_core::kinematics::{Coordinate, Target};
use stiction_core::spatial::Pose;

#[test]
fn kernels_allocate_nothing() {
    assert_eq!(allocations(|| drop(std::hint::black_box(Box::new(1)))), 1, "the counter counts");
    for class in CLASSES {
        for mode in [FrictionMode::Off, FrictionMode::OnePass, FrictionMode::Converged] {
            let (_, case) = case(class, 3, 0.01);
            let settings = Settings { friction: mode, ..Settings::default() };
            let (coordinates, targets) = (&case.coordinates, &case.targets);
            let mut solver =
                InverseDynamics::new(case.mechanism.clone(), &[], coordinates, targets, settings)
                    .unwrap();
            let model = solver.model().unwrap();
            let parameters = solver.parameters().clone();
            let mut data = model.data(solver.state(), settings);
            let run = || model.evaluate(&parameters, &mut data, targets, &case.loads);
            assert_eq!(allocations(run), 0, "kernel, {class:?} {mode:?}");

            let mut sharing = Sharing::new(&model);
            let mut shares = solver.shares().clone();
            let (bodies, inverse) = (&data.kinematics.bodies, &data.inverse);
            let share = || sharing.run(&model, &parameters, bodies, inverse, &mut shares);
            assert_eq!(allocations(share), 0, "shares, {class:?} {mode:?}");

            // The checked solver does not allocate either, unless a special case occurs.
            solver.solve(&case.loads).unwrap();
            let solve = || {
                solver.move_to(targets).unwrap();
                solver.solve(&case.loads).unwrap();
            };
            assert_eq!(allocations(solve), 0, "solver, {class:?} {mode:?}");
        }
    }
}

/// Returns the operation counts of both factorisations for a platform on six actuated legs and
/// additional passive ones.
fn operations_with_legs(legs: usize) -> usize {
    let mut random = Random(1);
    let mut draft = Draft::new();
    let pose = Pose { position: v(0.0, 0.0, 0.6), ..random.pose(0.0) };
    let platform = draft.body(&mut random, pose);
    let mut coordinates = Vec::new();
    for leg in 0..legs {
        let angle = 2.4 * leg as f64;
        let foot = v(0.5 * angle.cos(), 0.5 * angle.sin(), 0.0);
        let tip = v(0.3 * (angle + 0.6).cos(), 0.3 * (angle - 0.4).sin(), 0.6);
        let types = [Universal, Prismatic, Spherical];
        let joints = draft.chain(&mut random, &types, 0, platform, (foot, tip));
        if leg < 6 {
            draft.joints[joints[1]].actuated.push(0);
            coordinates.push(joints[1]);
        }
    }
    let mechanism = draft.build_in_order();
    let coordinates: Vec<_> = coordinates
        .iter()
        .map(|j| Coordinate::Joint { joint: mechanism.joint_id(&format!("j{j}")).unwrap(), dof: 0 })
        .collect();
    let targets = vec![sine(0.0, 0.1, 1.0, 0.0, 0.0); 6];
    let solver =
        InverseDynamics::new(mechanism, &[], &coordinates, &targets, Settings::default()).unwrap();
    let (motion, balance) = solver.model().unwrap().operations();
    motion + balance
}

#[test]
fn cost_grows_linearly_with_the_legs() {
    let [few, more, many] = [8, 16, 32].map(operations_with_legs);
    let (per_leg, later) = ((more - few) as f64 / 8.0, (many - more) as f64 / 16.0);
    assert!((later / per_leg - 1.0).abs() < 0.1, "{few} {more} {many}");
}

/// Applies efforts that oscillate about those that balance the weight.
struct Swing {
    mean: Vec<f64>,
    amplitude: f64,
}

impl Inputs for Swing {
    fn efforts(&mut self, view: &View<'_>, efforts: &mut [f64]) {
        for (k, (effort, mean)) in efforts.iter_mut().zip(&self.mean).enumerate() {
            *effort = mean + self.amplitude * (9.0 * view.time + k as f64).sin();
        }
    }
}

#[test]
fn simulations_allocate_nothing_between_events() {
    let rub = [
        friction(0.12, 128.0, Some(0.0125)),
        friction(0.12, 30.0, None),
        friction(0.12, 32.0, Some(0.025)),
    ];
    let robot = symmetric_3rps(Some(rub));
    let model = Forward::new(robot.mechanism.clone(), &[]);
    let still = [0.55, 0.0, 0.0].map(|value| Target { value, rate: 0.0, acceleration: 0.0 });
    let settings = Settings { friction: FrictionMode::Off, ..Settings::default() };
    let mechanism = robot.mechanism.clone();
    let mut solver =
        InverseDynamics::new(mechanism, &robot.initial_poses, &robot.coordinates, &still, settings)
            .unwrap();
    let mean = solver.solve(&[]).unwrap().efforts.clone();
    // Either fast enough that nothing comes to rest soon, or held by friction with a margin,
    // because friction at a limit would have to be distributed anew.
    let moving = [(0.55, 0.5), (0.0, 0.3), (0.0, 0.2)];
    let moving = moving.map(|(value, rate)| Target { value, rate, acceleration: 0.0 });
    for (targets, amplitude, sticks) in [(moving, 5.0, false), (still, 0.1, true)] {
        let state = model.assemble(&robot.initial_poses, &robot.coordinates, &targets).unwrap();
        let mut swing = Swing { mean: mean.clone(), amplitude };
        let settings = stiction_core::forward::Settings::default();
        let mut simulation = model.start(0.0, state, settings, &mut swing).unwrap();
        let mut sample = 0;
        // A step at rest is long, so rows that are farther apart than in motion need several steps.
        let row = if sticks { 0.05 } else { 0.005 };
        let mut go_on = |simulation: &mut Simulation<'_>| {
            sample += 1;
            simulation.advance(row * f64::from(sample), &mut swing).unwrap();
        };
        (0..4).for_each(|_| go_on(&mut simulation));
        let doing = simulation.interfaces().to_vec();
        let is = |what: &Doing| matches!(what, Doing::Sticks) == sticks;
        assert!(doing.iter().all(is), "{doing:?}");
        let (events, evaluations) = (simulation.events().len(), simulation.evaluations());
        let count = allocations(|| (0..4).for_each(|_| go_on(&mut simulation)));
        assert!(simulation.evaluations() > evaluations + 3);
        assert_eq!(simulation.events().len(), events, "the stretch has no event");
        assert_eq!(count, 0, "sticks: {sticks}");
    }
}
