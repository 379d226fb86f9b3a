//! Properties of friction with every friction law and every normal-load map, on random mechanisms.

use crate::common::random::*;
use stiction_core::dynamics::{FrictionMode, InverseDynamics, Settings};
use stiction_core::friction::{
    Bristles, Combine, Curve, Exponent, InterfaceShape, JointFriction, Law, NormalLoadMap, Supports,
};
use stiction_core::joint::JointType;
use stiction_core::kinematics::Target;
use stiction_core::parameters::{InterfaceParameters, Parameters};

/// Creates a random law with coefficients up to `mu`.
fn law(random: &mut Random, mu: f64) -> Law {
    let sliding = mu * random.between(0.3, 0.7);
    let mu_static = mu * random.between(0.7, 1.0);
    let velocity = random.between(0.002, 0.05);
    let exponent = Exponent::new(random.pick(&[0.7, 1.0, 2.0, 3.0]));
    let curve = match random.below(4) {
        0 => Curve::Constant,
        1 => Curve::Static { mu_static },
        2 => Curve::Stribeck { mu_static, velocity, exponent },
        _ => Curve::Table(vec![[0.0, mu_static], [velocity, 0.5 * mu], [4.0 * velocity, mu]]),
    };
    let mut law = Law { curve, ..Law::coulomb_viscous(sliding, random.between(0.0, 5.0)) };
    match random.below(4) {
        0 => law.regularisation = Some(velocity),
        1 => law.bristles = Some(Bristles { stiffness: 1e5, damping: 100.0 }),
        _ => {}
    }
    law
}

fn load(random: &mut Random, shape: InterfaceShape, joint_type: JointType) -> NormalLoadMap<f64> {
    let (pin, guide) = (
        matches!(shape, InterfaceShape::Pin { .. }),
        matches!(shape, InterfaceShape::Guide { .. }),
    );
    let thread = shape == InterfaceShape::Thread;
    let ball = shape == InterfaceShape::Ball;
    let length = |random: &mut Random| Some(random.between(0.05, 0.2)).filter(|_| !ball);
    let mut map = NormalLoadMap {
        bending_span: length(random),
        axial_ratio: pin.then(|| random.between(0.5, 1.5)),
        torsion_arm: guide.then(|| random.between(0.05, 0.2)),
        preload: random.between(0.0, 3.0),
        flank_cosine: thread.then(|| random.between(0.8, 1.0)),
        ..NormalLoadMap::force_only()
    };
    map.combine = match (shape, random.below(3)) {
        (InterfaceShape::Ball, _) | (_, 0) => Combine::Sum,
        (InterfaceShape::Plate, _) => Combine::RootSumSquare,
        (InterfaceShape::Thread, _) | (_, 1) => Combine::Pads,
        _ => Combine::RootSumSquare,
    };
    if !thread && random.below(2) == 0 {
        map.smoothing = Some(0.1);
    }
    use JointType::{Cylindrical, Helical, Prismatic};
    if matches!(joint_type, Prismatic | Cylindrical | Helical) {
        match random.below(3) {
            0 => {}
            1 => map.supports = Supports::Successor,
            _ => {
                map.supports = Supports::OneOnEach { gland: 0.1, piston: -0.1 };
                map.bending_span = None;
            }
        }
    }
    map
}

/// Creates a mechanism of a class with all kinds of friction in all joints.
fn rich_case(class: Class, seed: u64, mu: f64) -> Case {
    let (mut draft, case) = case(class, seed, 0.0);
    let mut random = Random(seed + 77);
    for joint in &mut draft.joints {
        for (place, shape) in surfaces_of(joint.joint_type, (joint.ends.0 + joint.ends.1) % 2 == 1)
        {
            let backward = shape.has_one_dof() && random.below(2) == 0;
            joint.friction.push(JointFriction {
                place,
                radius: shape.turns().then(|| random.between(0.005, 0.03)),
                law: law(&mut random, mu),
                backward: backward.then(|| law(&mut random, mu)),
                load: load(&mut random, shape, joint.joint_type),
            });
        }
    }
    Case { mechanism: draft.build_in_order(), ..case }
}

/// Calls `check` for all cases of all classes that are far enough from singular configurations for
/// a meaningful comparison of digits.
fn for_each_case(mu: f64, seeds: u64, mut check: impl FnMut(&Case, &mut InverseDynamics)) {
    for class in CLASSES {
        for seed in 0..seeds {
            let case = rich_case(class, seed, mu);
            let mechanism = case.mechanism.clone();
            let settings = Settings::default();
            let Ok(mut solver) =
                InverseDynamics::new(mechanism, &[], &case.coordinates, &case.targets, settings)
            else {
                continue;
            };
            let statics = solver.statics();
            let smallest = statics.singular_values()[statics.rank() - 1];
            let spins = solver.constraints().spins().len();
            if smallest > 1e-2 && statics.open_motions() <= spins {
                check(&case, &mut solver);
            }
        }
    }
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    let largest = a.iter().chain(b).fold(1e-9f64, |max, x| max.max(x.abs()));
    a.iter().zip(b).fold(0.0f64, |max, (x, y)| max.max((x - y).abs())) / largest
}

#[test]
fn friction_dissipates_and_both_methods_agree() {
    let (mut compared, mut dissipating) = (0, 0);
    for_each_case(0.15, 80, |case, solver| {
        let Ok(forces) = solver.solve(&case.loads) else { return };
        let forces = forces.clone();
        for interface in &forces.interfaces {
            assert!(interface.power >= 0.0 && interface.load >= 0.0 && interface.limit >= 0.0);
            dissipating += usize::from(interface.power > 0.0);
        }
        let power = forces.power;
        assert!(power.residual().abs() <= 1e-11 * power.turnover, "{:?} {power:?}", case.class);
        // Near locking, rounding grows with the normal loads. The test then only checks that the
        // solution is the same one, since other solutions differ by much more.
        let strong = solver.coupling().is_none_or(|coupling| coupling > 0.9);
        let careful = solver.solve_dense(&case.loads).unwrap();
        let apart = apart(&forces.efforts, &careful.efforts);
        let limit = if strong { 1e-4 } else { 1e-9 };
        assert!(
            apart < limit,
            "{:?}: {apart} {:?} {:?}",
            case.class,
            forces.efforts,
            careful.efforts
        );
        compared += 1;
    });
    assert!(compared > 40 && dissipating > 400, "{compared} {dissipating}");
}

/// Multiplies all coefficients of an interface by a factor.
fn scale(interface: &mut InterfaceParameters<f64>, factor: f64) {
    for law in [Some(&mut interface.law), interface.backward.as_mut()].into_iter().flatten() {
        law.mu *= factor;
        law.viscous *= factor;
        match &mut law.curve {
            Curve::Constant => {}
            Curve::Static { mu_static } | Curve::Stribeck { mu_static, .. } => {
                *mu_static *= factor;
            }
            Curve::Table(rows) => rows.iter_mut().for_each(|row| row[1] *= factor),
        }
    }
}

/// Computes actuator forces with the kernel for changed parameters and rates.
fn drives(
    case: &Case,
    solver: &InverseDynamics,
    friction: FrictionMode,
    rates: f64,
    change: impl Fn(&mut Parameters<f64>),
) -> Option<Vec<f64>> {
    let model = solver.model().ok()?;
    let mut parameters = solver.parameters().clone();
    change(&mut parameters);
    let targets: Vec<_> =
        case.targets.iter().map(|t| Target { rate: rates * t.rate, ..*t }).collect();
    let settings = Settings { friction, ..Settings::default() };
    let mut data = model.data(solver.state(), settings);
    model.evaluate(&parameters, &mut data, &targets, &case.loads);
    let settled = data.inverse.friction_settled(&settings);
    settled.then(|| data.inverse.efforts().to_vec())
}

/// Decoupled (one-pass) friction is exact at first order in the coefficients: halving the
/// coefficients divides its error by four.
#[test]
fn the_one_pass_error_is_quadratic_in_the_coefficients() {
    use FrictionMode::{Converged, Off, OnePass};
    let mut compared = 0;
    for_each_case(0.15, 12, |case, solver| {
        let scaled = |friction, factor| {
            drives(case, solver, friction, 1.0, |parameters| {
                parameters.interfaces.iter_mut().for_each(|interface| scale(interface, factor));
            })
        };
        let Some(none) = scaled(Off, 1.0) else { return };
        let largest = none.iter().fold(1e-9f64, |max, x| max.max(x.abs()));
        for tiny in [0.0, 1e-11] {
            let Some(with) = scaled(Converged, tiny) else { return };
            // Tolerance relative to typical friction of some newtons, with reactions that loops may
            // magnify.
            assert!(apart(&none, &with) <= 1e4 * tiny, "{:?}", case.class);
        }
        let error = |factor| {
            let (once, converged) = (scaled(OnePass, factor)?, scaled(Converged, factor)?);
            let pairs = once.iter().zip(&converged);
            Some(pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max))
        };
        let (Some(one), Some(half)) = (error(2e-3), error(1e-3)) else { return };
        // Much smaller errors are due to rounding; the remaining difference is of third order.
        if half > 1e-9 * largest && one < 1e-4 * largest {
            assert!((one / half - 4.0).abs() < 0.1, "{:?} {one} {half}", case.class);
            compared += 1;
        }
    });
    assert!(compared > 30, "{compared}");
}

/// Time reversal reverses friction and changes nothing else, if the laws for the two directions are
/// exchanged.
#[test]
fn time_reversal_reverses_friction() {
    let mut compared = 0;
    for_each_case(0.05, 12, |case, solver| {
        let run = |rates, change: fn(&mut InterfaceParameters<f64>)| {
            drives(case, solver, FrictionMode::Converged, rates, |parameters| {
                parameters.interfaces.iter_mut().for_each(change);
            })
        };
        let swap = |interface: &mut InterfaceParameters<f64>| {
            if let Some(backward) = &mut interface.backward {
                std::mem::swap(backward, &mut interface.law);
            }
        };
        let Some(reversed) = run(-1.0, swap) else { return };
        let Some(negative) = run(1.0, |interface| scale(interface, -1.0)) else { return };
        let Some(forward) = run(1.0, |_| {}) else { return };
        assert!(apart(&reversed, &negative) < 1e-9, "{:?}", case.class);
        assert!(apart(&forward, &negative) > 1e-6, "{:?}", case.class);
        compared += 1;
    });
    assert!(compared > 40, "{compared}");
}

/// Pins, balls and threads with radius zero have no friction moment: only the friction of guides
/// remains. A plate keeps the friction of its translation.
#[test]
fn a_zero_radius_gives_no_friction_moment() {
    let mut compared = 0;
    for_each_case(0.15, 8, |case, solver| {
        let run = |change: fn(&mut InterfaceParameters<f64>)| {
            drives(case, solver, FrictionMode::Converged, 1.0, |parameters| {
                parameters.interfaces.iter_mut().for_each(change);
            })
        };
        let turns = |interface: &InterfaceParameters<f64>| {
            matches!(interface.shape, InterfaceShape::Pin { .. } | InterfaceShape::Ball)
        };
        if !solver.parameters().interfaces.iter().any(turns) {
            return;
        }
        let small = run(|interface| match interface.shape {
            InterfaceShape::Pin { .. } | InterfaceShape::Ball => interface.radius *= 1e-12,
            _ => {}
        });
        let off = run(|interface| match interface.shape {
            InterfaceShape::Pin { .. } | InterfaceShape::Ball => scale(interface, 0.0),
            _ => {}
        });
        let (Some(small), Some(off)) = (small, off) else { return };
        // With a radius of 1e-14 m instead, the remaining difference is rounding.
        assert!(apart(&small, &off) < 1e-9, "{:?}", case.class);
        compared += 1;
    });
    assert!(compared > 30, "{compared}");
}
