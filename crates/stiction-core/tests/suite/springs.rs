//! Springs between bodies.

use crate::common::random::*;
use crate::common::*;
use crate::counting::allocations;
use stiction_core::dynamics::{
    AppliedLoad, FrictionMode, InverseDynamics, InverseError, LoadAxes, Settings,
};
use stiction_core::joint::JointType;
use stiction_core::kinematics::{AssemblyError, Coordinate, Target};
use stiction_core::mechanism::{
    BodySpec, Defect, JointSpec, Mechanism, MechanismBuilder, Spring, SpringSpec,
};
use stiction_core::parameters::Parameters;
use stiction_core::scalar::{Dual, Scalar};
use stiction_core::spatial::Vec3;

/// Copies the mechanism and adds springs. The order of bodies and joints does not change.
fn with_springs(mechanism: &Mechanism, springs: &[SpringSpec]) -> Mechanism {
    let mut builder = MechanismBuilder::new("sprung").gravity(mechanism.gravity());
    let name = |id: stiction_core::mechanism::BodyId| mechanism.bodies()[id.0].name.clone();
    for body in &mechanism.bodies()[1..] {
        let spec = BodySpec::new(&body.name).mass(body.mass).com(body.com).inertia(body.inertia);
        builder = builder.body(spec);
    }
    for joint in mechanism.joints() {
        let ends = [name(joint.predecessor), name(joint.successor)];
        let [from, to] = ends;
        let mut spec = JointSpec::new(&joint.name, joint.joint_type, from, to)
            .frames(joint.frame_j, joint.frame_k)
            .pitch(joint.pitch)
            .actuated_dofs(joint.actuated_dofs().collect::<Vec<_>>());
        for interface in &joint.friction {
            spec = spec.friction(interface.clone());
        }
        builder = builder.joint(spec);
    }
    springs.iter().cloned().fold(builder, MechanismBuilder::spring).build().unwrap()
}

/// Creates a few springs between random bodies, some attached to the ground. Their forces exceed
/// the weights of the bodies.
fn random_springs(random: &mut Random, mechanism: &Mechanism) -> Vec<SpringSpec> {
    let bodies = mechanism.bodies();
    (0..3)
        .map(|k| {
            let from = random.below(bodies.len());
            let to = (from + 1 + random.below(bodies.len() - 1)) % bodies.len();
            SpringSpec::new(format!("s{k}"), &bodies[from].name, &bodies[to].name)
                .points(random.vector() * 0.1, random.vector() * 0.1)
                .stiffness(random.between(100.0, 900.0), random.between(0.0, 0.5))
                .damping(random.between(0.0, 40.0))
        })
        .collect()
}

fn solver(mechanism: &Mechanism, case: &Case, settings: Settings) -> Option<InverseDynamics> {
    let (coordinates, targets) = (&case.coordinates, &case.targets);
    let solver = InverseDynamics::new(mechanism.clone(), &[], coordinates, targets, settings);
    match solver {
        // Two legs with fixed balls permit a rotation of the platform about the line between the
        // balls.
        Err(AssemblyError::Open { .. }) => None,
        solver => Some(solver.unwrap()),
    }
}

/// Computes the forces of a spring on its ends by Hooke's law, as external loads.
fn as_loads(spring: &Spring, solver: &InverseDynamics) -> [AppliedLoad<f64>; 2] {
    let bodies = solver.bodies();
    let place = |k: usize| bodies.pose[spring.ends[k].0].apply(spring.points[k]);
    let velocity = |k: usize| bodies.twist[spring.ends[k].0].velocity_at(place(k));
    let length = (place(1) - place(0)).norm();
    let direction = (place(1) - place(0)).direction().unwrap();
    let rate = (velocity(1) - velocity(0)).dot(direction);
    let tension = spring.stiffness * (length - spring.free_length) + spring.damping * rate;
    [(0, 1.0), (1, -1.0)].map(|(k, sign)| AppliedLoad {
        body: spring.ends[k],
        point: spring.points[k],
        axes: LoadAxes::World,
        force: direction * (sign * tension),
        moment: Vec3::zero(),
    })
}

fn numbers(solver: &InverseDynamics) -> Vec<f64> {
    let forces = solver.forces();
    let reactions = forces.reactions.iter().flat_map(|(f, m)| [f.to_array(), m.to_array()]);
    forces.efforts.iter().copied().chain(reactions.flatten()).collect()
}

fn assert_near(what: &str, found: &[f64], expected: &[f64], part: f64) {
    assert_eq!(found.len(), expected.len());
    let largest = expected.iter().fold(1e-9f64, |max, x| max.max(x.abs()));
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() <= part * largest, "{what}: {found} {expected}");
    }
}

/// Checks that a spring is equivalent to a pair of loads: in the kernel, in the dense system, and
/// in the power balance.
#[test]
fn a_spring_is_a_pair_of_loads() {
    let (mut compared, mut carefully) = (0, 0);
    for class in CLASSES {
        for seed in 0..10 {
            for friction in [FrictionMode::Off, FrictionMode::Converged] {
                let (_, case) = case(class, seed, 0.1);
                let springs = random_springs(&mut Random(seed + 77), &case.mechanism);
                let mechanism = with_springs(&case.mechanism, &springs);
                let settings = Settings { friction, ..Settings::default() };
                let Some(mut plain) = solver(&case.mechanism, &case, settings) else { continue };
                let statics = plain.statics();
                let smallest = *statics.singular_values()[..statics.rank()].last().unwrap();
                let spins = plain.constraints().spins().len();
                // Near singular configurations, round-off is magnified.
                if smallest < 1e-2 || statics.open_motions() > spins {
                    continue;
                }
                let mut loads = case.loads.clone();
                for spring in mechanism.springs() {
                    loads.extend(as_loads(spring, &plain));
                }
                if plain.solve(&loads).is_err() {
                    continue;
                }
                let what = format!("{class:?} {seed} {friction:?}");
                let mut sprung = solver(&mechanism, &case, settings).unwrap();
                let forces = sprung.solve(&case.loads).unwrap();
                let (power, with_loads) = (forces.power, plain.forces().power);
                assert!(power.residual().abs() <= 1e-11 * power.turnover, "{what}: {power:?}");
                // The loads agree to round-off of their terms.
                assert_near(&what, &numbers(&sprung), &numbers(&plain), 1e-10);
                let parts = [power.loads, power.actuators];
                let error = 1e-10 * with_loads.turnover;
                assert!((parts[0] - with_loads.loads).abs() <= error, "{what}: {power:?}");
                assert!((parts[1] - with_loads.actuators).abs() <= error, "{what}: {power:?}");
                compared += 1;
                if sprung.solve_dense(&case.loads).is_ok() {
                    // The fixed-point iteration of the dense fallback stops at 1e-13 of the largest
                    // normal load.
                    assert_near(&what, &numbers(&sprung), &numbers(&plain), 1e-9);
                    carefully += 1;
                }
            }
        }
    }
    assert!(compared > 60 && carefully > 50, "{compared} {carefully}");
}

/// Checks that exchanging the two ends of a spring does not change the results.
#[test]
fn springs_may_be_turned_round() {
    let (_, case) = case(Class::Parallel, 3, 0.1);
    let mut random = Random(5);
    let (a, b) = (random.vector() * 0.1, random.vector() * 0.1);
    let results = [false, true].map(|turned| {
        let spring = if turned {
            SpringSpec::new("s", "b2", "b1").points(b, a)
        } else {
            SpringSpec::new("s", "b1", "b2").points(a, b)
        };
        let mechanism =
            with_springs(&case.mechanism, &[spring.stiffness(700.0, 0.1).damping(20.0)]);
        let mut solver = solver(&mechanism, &case, Settings::default()).unwrap();
        solver.solve(&case.loads).unwrap();
        numbers(&solver)
    });
    assert_near("turned round", &results[0], &results[1], 1e-12);
}

/// Creates a pendulum of mass m on a rod of length l, prescribed at `angle` from upright.
fn pendulum(spring: SpringSpec, angle: f64) -> InverseDynamics {
    let mechanism = MechanismBuilder::new("pendulum")
        .gravity(v(0.0, 0.0, -9.81))
        .body(BodySpec::new("arm").mass(2.0).com(v(0.0, 0.0, 0.5)))
        .joint(
            JointSpec::new("pivot", JointType::Revolute, "ground", "arm")
                .frames(
                    along(Vec3::zero(), v(0.0, 1.0, 0.0)),
                    along(Vec3::zero(), v(0.0, 1.0, 0.0)),
                )
                .actuated(),
        )
        .spring(spring)
        .build()
        .unwrap();
    let joint = mechanism.joint_id("pivot").unwrap();
    let targets = [Target { value: angle, rate: 0.0, acceleration: 0.0 }];
    let coordinates = [Coordinate::Joint { joint, dof: 0 }];
    InverseDynamics::new(mechanism, &[], &coordinates, &targets, Settings::default()).unwrap()
}

/// Static balancing: a spring with zero free length, from a point h above the pivot to a point r
/// along the arm, balances the arm at every angle if k h r = m g l.
#[test]
fn a_spring_without_free_length_balances_an_arm_in_every_position() {
    let (h, r) = (0.3, 0.2);
    let stiffness = 2.0 * 9.81 * 0.5 / (h * r);
    let spring = SpringSpec::new("balancer", "ground", "arm")
        .points(v(0.0, 0.0, h), v(0.0, 0.0, r))
        .stiffness(stiffness, 0.0);
    for k in -8..=8 {
        let angle = 0.37 * f64::from(k);
        let mut solver = pendulum(spring.clone(), angle);
        let torque = solver.solve(&[]).unwrap().efforts[0];
        // Relative to the 9.81 N m of the weight.
        assert!(torque.abs() < 1e-14 * 9.81 * 10.0, "{angle}: {torque:e}");
    }
}

/// A slide with a damper requires F = m a + c v.
#[test]
fn the_force_of_a_damper_is_proportional_to_the_rate() {
    let mechanism = MechanismBuilder::new("slide")
        .body(BodySpec::new("carriage").mass(3.0))
        .joint(JointSpec::new("guide", JointType::Prismatic, "ground", "carriage").actuated())
        .spring(
            SpringSpec::new("damper", "carriage", "ground")
                .points(Vec3::zero(), v(0.0, 0.0, -1.0))
                .damping(40.0),
        )
        .build()
        .unwrap();
    let coordinates = [Coordinate::Joint { joint: mechanism.joint_id("guide").unwrap(), dof: 0 }];
    let targets = [Target { value: 0.5, rate: -0.7, acceleration: 2.0 }];
    let mut solver =
        InverseDynamics::new(mechanism, &[], &coordinates, &targets, Settings::default()).unwrap();
    let forces = solver.solve(&[]).unwrap();
    assert!((forces.efforts[0] - (3.0 * 2.0 - 40.0 * 0.7)).abs() < 1e-13);
    assert!((forces.power.loads + 40.0 * 0.7 * 0.7).abs() < 1e-13, "{:?}", forces.power);
}

/// The end of the spring on the arm passes through the end on the ground.
#[test]
fn ends_that_coincide() {
    let spring = |free_length, damping| {
        SpringSpec::new("s", "ground", "arm")
            .points(v(0.0, 0.0, 0.2), v(0.0, 0.0, 0.2))
            .stiffness(500.0, free_length)
            .damping(damping)
    };
    // Without free length and damping the force vanishes there, so its direction is irrelevant.
    let torque = pendulum(spring(0.0, 0.0), 0.0).solve(&[]).unwrap().efforts[0];
    assert_eq!(torque, 0.0);
    for (free_length, damping) in [(0.05, 0.0), (0.0, 3.0)] {
        for angle in [0.0, 1e-16] {
            let mut solver = pendulum(spring(free_length, damping), angle);
            let expected = InverseError::SpringWithoutDirection { spring: "s".into() };
            assert_eq!(solver.solve(&[]).unwrap_err(), expected);
            assert_eq!(solver.solve_dense(&[]).unwrap_err(), expected);
            // The kernel itself returns finite forces and derivatives even there.
            let model = solver.model().unwrap();
            let parameters = Parameters::<Dual<f64, 5>>::new(solver.mechanism());
            let mut data = model.data(solver.state(), Settings::default());
            let zero = Dual::variable(0.0, 0);
            let target = Target { value: zero, rate: zero, acceleration: zero };
            model.evaluate(&parameters, &mut data, &[target], &[]);
            let drive = data.inverse.efforts()[0];
            assert!(drive.value.is_finite() && drive.slope[0].is_finite());
        }
        // Close to the coinciding position, all results are regular.
        let drive = pendulum(spring(free_length, damping), 1e-3).solve(&[]).unwrap().efforts[0];
        assert!(drive.is_finite());
    }
}

/// Compares derivatives by dual numbers with respect to all five parameters of a spring with finite
/// differences. Without friction, actuator forces are affine in stiffness and damping, so
/// differences with respect to these are exact; the others are central differences.
#[test]
fn derivatives_by_the_numbers_of_a_spring() {
    let (_, case) = case(Class::Parallel, 4, 0.1);
    let springs = random_springs(&mut Random(11), &case.mechanism);
    let mechanism = with_springs(&case.mechanism, &springs);
    let settings = Settings { friction: FrictionMode::Off, ..Settings::default() };
    let solver = solver(&mechanism, &case, settings).unwrap();
    let model = solver.model().unwrap();
    fn vary<T: Scalar>(parameters: &mut Parameters<T>, direction: usize, by: T) {
        let spring = &mut parameters.springs[0];
        match direction {
            0 => spring.stiffness += by,
            1 => spring.free_length += by,
            2 => spring.damping += by,
            3 => spring.points[0].x += by,
            _ => spring.points[1].z += by,
        }
    }
    let at = |direction: usize, by: f64| {
        let mut parameters = solver.parameters().clone();
        vary(&mut parameters, direction, by);
        let mut data = model.data(solver.state(), settings);
        model.evaluate(&parameters, &mut data, &case.targets, &case.loads);
        data.inverse.efforts().to_vec()
    };
    let mut parameters = Parameters::<Dual<f64, 5>>::new(&mechanism);
    for direction in 0..5 {
        vary(&mut parameters, direction, Dual::variable(0.0, direction));
    }
    let constant = |x: f64| Dual::constant(x);
    let targets: Vec<_> = case
        .targets
        .iter()
        .map(|t| Target {
            value: constant(t.value),
            rate: constant(t.rate),
            acceleration: constant(t.acceleration),
        })
        .collect();
    let loads: Vec<_> = case.loads.iter().map(|load| load.lift()).collect();
    let mut data = model.data(solver.state(), settings);
    model.evaluate(&parameters, &mut data, &targets, &loads);
    let duals = data.inverse.efforts().to_vec();
    for direction in 0..5 {
        // Steps of 1 N/m and 1 N s/m, and of 10 um, whose square is 1e-9 of the squared lengths.
        let step = if matches!(direction, 0 | 2) { 1.0 } else { 1e-5 };
        let (ahead, back) = (at(direction, step), at(direction, -step));
        let expected: Vec<f64> =
            ahead.iter().zip(&back).map(|(a, b)| (a - b) / (2.0 * step)).collect();
        assert!(expected.iter().any(|slope| slope.abs() > 1e-6), "{direction}: {expected:?}");
        let found: Vec<f64> = duals.iter().map(|dual| dual.slope[direction]).collect();
        assert_near(&format!("{direction}"), &found, &expected, 1e-7);
    }
}

#[test]
fn springs_allocate_nothing() {
    let (_, case) = case(Class::Parallel, 3, 0.01);
    let springs = random_springs(&mut Random(3), &case.mechanism);
    let mechanism = with_springs(&case.mechanism, &springs);
    let mut solver = solver(&mechanism, &case, Settings::default()).unwrap();
    solver.solve(&case.loads).unwrap();
    let solve = || {
        solver.move_to(&case.targets).unwrap();
        solver.solve(&case.loads).unwrap();
    };
    assert_eq!(allocations(solve), 0);
}

#[test]
fn defects_of_springs() {
    let arm = || BodySpec::new("arm").mass(1.0);
    let pivot = || JointSpec::new("pivot", JointType::Revolute, "ground", "arm");
    let defects = MechanismBuilder::new("wrong")
        .body(arm())
        .joint(pivot())
        .spring(SpringSpec::new("a", "ground", "leg").stiffness(1.0, 0.0))
        .spring(SpringSpec::new("b", "arm", "arm").stiffness(1.0, 0.0))
        .spring(SpringSpec::new("c", "ground", "arm").stiffness(-1.0, f64::NAN).damping(-2.0))
        .spring(
            SpringSpec::new("c", "ground", "arm")
                .points(v(f64::INFINITY, 0.0, 0.0), v(0.0, 0.0, 0.0)),
        )
        .build()
        .unwrap_err();
    let kinds: Vec<&str> = defects
        .iter()
        .map(|defect| match defect {
            Defect::UnknownBodyOfSpring { .. } => "body",
            Defect::SpringWithinBody { .. } => "within",
            Defect::SpringParameter { parameter, .. } => parameter,
            Defect::DuplicateName { what, .. } => what,
            Defect::NotFinite { .. } => "place",
            other => panic!("{other}"),
        })
        .collect();
    assert_eq!(
        kinds,
        ["body", "within", "stiffness", "free length", "damping", "springs", "place"]
    );
}
