//! Springs on joints, gas springs and bushings.

use crate::common::random::*;
use crate::common::*;
use crate::counting::allocations;
use nalgebra::{Matrix3, Matrix6, Rotation3, UnitQuaternion, Vector3, Vector6};
use stiction_core::dynamics::{
    AppliedLoad, FrictionMode, InverseDynamics, InverseError, LoadAxes, Settings,
};
use stiction_core::forward::{self, ConstantEfforts, Forward};
use stiction_core::joint::JointType;
use stiction_core::kinematics::{AssemblyError, Coordinate, Target};
use stiction_core::mechanism::{
    BodySpec, Bushing, BushingSpec, Defect, GasSpring, JointId, JointRange, JointSpec, JointSpring,
    JointSpringSpec, Mechanism, MechanismBuilder, RangeOf, SixBySix, SpringSpec,
};
use stiction_core::spatial::{Mat3, Pose, Vec3};

/// Creates a symmetric positive definite matrix with coupling between forces and rotations.
fn random_matrix(random: &mut Random, force: f64, moment: f64) -> SixBySix {
    let factor = Matrix6::from_fn(|_, _| random.between(-1.0, 1.0));
    let scale =
        Matrix6::from_diagonal(&Vector6::from_fn(
            |k, _| {
                if k < 3 { force.sqrt() } else { moment.sqrt() }
            },
        ));
    let matrix = scale * (factor * factor.transpose()) * scale;
    std::array::from_fn(|i| std::array::from_fn(|j| 0.5 * (matrix[(i, j)] + matrix[(j, i)])))
}

/// Copies the mechanism to a builder. The order of bodies and joints does not change.
fn copied(mechanism: &Mechanism) -> MechanismBuilder {
    let mut builder = MechanismBuilder::new("sprung")
        .gravity(mechanism.gravity())
        .characteristic_length(mechanism.characteristic_length());
    let name = |id: stiction_core::mechanism::BodyId| mechanism.bodies()[id.0].name.clone();
    for body in &mechanism.bodies()[1..] {
        let spec = BodySpec::new(&body.name).mass(body.mass).com(body.com).inertia(body.inertia);
        builder = builder.body(spec);
    }
    for joint in mechanism.joints() {
        let (from, to) = (name(joint.predecessor), name(joint.successor));
        let mut spec = JointSpec::new(&joint.name, joint.joint_type, from, to)
            .frames(joint.frame_j, joint.frame_k)
            .pitch(joint.pitch)
            .actuated_dofs(joint.actuated_dofs().collect::<Vec<_>>());
        if let Some(start) = &joint.start {
            spec = spec.start(start.clone());
        }
        for interface in &joint.friction {
            spec = spec.friction(interface.clone());
        }
        builder = builder.joint(spec);
    }
    builder
}

/// Returns the mechanism with springs on some of its joints, a gas spring and bushings.
fn sprung(random: &mut Random, mechanism: &Mechanism) -> Mechanism {
    let mut builder = copied(mechanism);
    for joint in mechanism.joints() {
        if !joint.joint_type.has_scalar_coordinates() {
            continue;
        }
        for dof in 0..joint.joint_type.dofs().len() {
            let name = joint.dof_name(dof);
            let spec = JointSpringSpec::new(format!("{name} spring"), name)
                .stiffness(random.between(1.0, 9.0), random.between(-0.5, 0.5))
                .preload(random.between(-3.0, 3.0))
                .damping(random.between(0.0, 2.0));
            builder = builder.joint_spring(spec);
        }
    }
    let bodies = mechanism.bodies();
    let from = random.below(bodies.len());
    let to = (from + 1 + random.below(bodies.len() - 1)) % bodies.len();
    let gas = GasSpring {
        extension_force: random.between(20.0, 50.0),
        progression: random.between(1.0, 1.6),
        extended_length: random.between(0.3, 0.9),
        stroke: 0.2,
    };
    let spring = SpringSpec::new("gas", &bodies[from].name, &bodies[to].name)
        .points(random.vector() * 0.1, random.vector() * 0.1)
        .gas(gas)
        .damping(random.between(0.0, 20.0));
    let frame = |random: &mut Random| Pose {
        position: random.vector() * 0.1,
        rotation: Mat3::rotation(random.vector().direction().unwrap(), random.between(-1.0, 1.0)),
    };
    let (a, b) = (frame(random), frame(random));
    let bushing = BushingSpec::new("bushing", &bodies[from].name, &bodies[to].name)
        .frames(a, b)
        .stiffness(random_matrix(random, 100.0, 5.0))
        .damping(random_matrix(random, 10.0, 0.5));
    builder.spring(spring).bushing(bushing).build().unwrap()
}

/// Returns a force and a moment at a world point on the second body of a pair, and the opposite
/// loads on the first.
fn pair(
    solver: &InverseDynamics,
    [from, to]: [usize; 2],
    point: Vec3<f64>,
    (force, moment): (Vec3<f64>, Vec3<f64>),
) -> [AppliedLoad<f64>; 2] {
    let bodies = solver.bodies();
    [(from, -1.0), (to, 1.0)].map(|(body, sign)| AppliedLoad {
        body: stiction_core::mechanism::BodyId(body),
        point: bodies.pose[body].inverse().apply(point),
        axes: LoadAxes::World,
        force: force * sign,
        moment: moment * sign,
    })
}

/// Returns the effort of a joint spring as loads, computed from the joint's frames and the
/// definition of its type.
fn joint_spring_as_loads(
    mechanism: &Mechanism,
    spring: &JointSpring,
    solver: &InverseDynamics,
) -> [AppliedLoad<f64>; 2] {
    use JointType::{Planar, Universal};
    let joint = &mechanism.joints()[spring.joint.0];
    let bodies = solver.bodies();
    let (j, k) = (bodies.frame_j[spring.joint.0], bodies.frame_k[spring.joint.0]);
    let [x, y, z] = j.rotation.columns;
    let [kx, _, kz] = k.rotation.columns;
    let ends = [joint.predecessor.0, joint.successor.0];
    let relative = bodies.twist[ends[1]] - bodies.twist[ends[0]];
    let slides = |axis: Vec3<f64>| (axis, relative.velocity_at(k.position).dot(axis), true);
    let turns = |axis: Vec3<f64>| (axis, relative.angular.dot(axis), false);
    let (axis, rate, is_force) = match (joint.joint_type, spring.dof) {
        (JointType::Prismatic, _) | (JointType::Cylindrical, 1) => slides(z),
        (Universal, 1) => turns(kx),
        (Planar, 0) => slides(x),
        (Planar, 1) => slides(y),
        (Planar, 2) => turns(kz),
        _ => turns(z),
    };
    let coordinate = solver.joint_coordinates(spring.joint)[spring.dof];
    let effort =
        spring.preload - spring.stiffness * (coordinate - spring.rest) - spring.damping * rate;
    let wrench =
        if is_force { (axis * effort, Vec3::zero()) } else { (Vec3::zero(), axis * effort) };
    pair(solver, ends, k.position, wrench)
}

/// Returns the wrench of a bushing as loads: the gradient of the elastic energy by central
/// differences of the energy itself, with rotations as quaternions of nalgebra.
fn bushing_as_loads(bushing: &Bushing, solver: &InverseDynamics) -> [AppliedLoad<f64>; 2] {
    let bodies = solver.bodies();
    let ends = bushing.ends.map(|body| body.0);
    let a = bodies.pose[ends[0]] * bushing.frames[0];
    let b = bodies.pose[ends[1]] * bushing.frames[1];
    let quaternion = |frame: &Pose<f64>| {
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(Matrix3::from(
            frame.rotation,
        )))
    };
    let (qa, qb) = (quaternion(&a), quaternion(&b));
    let (at_a, at_b) = (Vector3::from(a.position), Vector3::from(b.position));
    let stiffness = Matrix6::from_fn(|i, j| bushing.stiffness[i][j]);
    let energy = |shift: Vector3<f64>, turn: Vector3<f64>| {
        let place = qa.inverse() * (at_b + shift - at_a);
        let vector = (qa.inverse() * UnitQuaternion::from_scaled_axis(turn) * qb).scaled_axis();
        let x = Vector6::from_iterator(place.iter().chain(&vector).copied());
        0.5 * x.dot(&(stiffness * x))
    };
    // Fourth-order differences with steps of 1e-3 have an error of about 1e-12 of the second
    // derivative.
    let slope = |of: &dyn Fn(f64) -> f64| {
        let h = 1e-3;
        (8.0 * (of(h) - of(-h)) - (of(2.0 * h) - of(-2.0 * h))) / (12.0 * h)
    };
    let zero = Vector3::zeros();
    let unit = |k: usize, by: f64| Vector3::from_fn(|i, _| if i == k { by } else { 0.0 });
    let force = Vector3::from_fn(|k, _| -slope(&|h| energy(unit(k, h), zero)));
    let moment = Vector3::from_fn(|k, _| -slope(&|h| energy(zero, unit(k, h))));
    let relative = bodies.twist[ends[1]] - bodies.twist[ends[0]];
    let velocity = qa.inverse() * Vector3::from(relative.velocity_at(b.position));
    let omega = qa.inverse() * Vector3::from(relative.angular);
    let damping = Matrix6::from_fn(|i, j| bushing.damping[i][j]);
    let damped = damping * Vector6::from_iterator(velocity.iter().chain(&omega).copied());
    let force = force - qa * Vector3::new(damped[0], damped[1], damped[2]);
    let moment = moment - qa * Vector3::new(damped[3], damped[4], damped[5]);
    pair(solver, ends, b.position, (Vec3::from(force), Vec3::from(moment)))
}

fn solver(mechanism: &Mechanism, case: &Case, settings: Settings) -> Option<InverseDynamics> {
    let (coordinates, targets) = (&case.coordinates, &case.targets);
    match InverseDynamics::new(mechanism.clone(), &[], coordinates, targets, settings) {
        // Two legs with fixed balls permit a rotation of the platform about the line between the
        // balls.
        Err(AssemblyError::Open { .. }) => None,
        solver => Some(solver.unwrap()),
    }
}

fn numbers(solver: &InverseDynamics) -> Vec<f64> {
    let forces = solver.forces();
    let reactions = forces.reactions.iter().flat_map(|(f, m)| [f.to_array(), m.to_array()]);
    forces.efforts.iter().copied().chain(reactions.flatten()).collect()
}

/// Checks that joint springs, gas springs and bushings are equivalent to independently computed
/// loads: in the kernel, in the dense system, and in the power balance.
#[test]
fn springs_are_pairs_of_loads() {
    let (mut compared, mut densely) = (0, 0);
    for class in CLASSES {
        for seed in 0..6 {
            let (_, case) = case(class, seed, 0.1);
            let mechanism = sprung(&mut Random(seed + 177), &case.mechanism);
            let settings = Settings { friction: FrictionMode::Converged, ..Settings::default() };
            let Some(mut plain) = solver(&case.mechanism, &case, settings) else { continue };
            let statics = plain.statics();
            let smallest = *statics.singular_values()[..statics.rank()].last().unwrap();
            // Near singular configurations, round-off is magnified.
            if smallest < 1e-2 || statics.open_motions() > plain.constraints().spins().len() {
                continue;
            }
            let mut loads = case.loads.clone();
            for spring in mechanism.joint_springs() {
                loads.extend(joint_spring_as_loads(&mechanism, spring, &plain));
            }
            for bushing in mechanism.bushings() {
                loads.extend(bushing_as_loads(bushing, &plain));
            }
            let gas = &mechanism.springs()[0];
            let bodies = plain.bodies();
            let end = |k: usize| bodies.pose[gas.ends[k].0].apply(gas.points[k]);
            let velocity = |k: usize| bodies.twist[gas.ends[k].0].velocity_at(end(k));
            let direction = (end(1) - end(0)).direction().unwrap();
            let (shortest, extended) = gas.lengths.unwrap();
            let length = (end(1) - end(0)).norm();
            // The force is F1 at the extended length, and F2 = x F1 at the end of the stroke.
            let (first, second) =
                (gas.preload, gas.preload + gas.stiffness * (extended - shortest));
            let push = first + (second - first) * (extended - length) / (extended - shortest)
                - gas.damping * (velocity(1) - velocity(0)).dot(direction);
            let wrench = (direction * push, Vec3::zero());
            loads.extend(pair(&plain, gas.ends.map(|body| body.0), end(1), wrench));
            if plain.solve(&loads).is_err() {
                continue;
            }
            let what = format!("{class:?} {seed}");
            let mut own = solver(&mechanism, &case, settings).unwrap();
            let power = match own.solve(&case.loads) {
                // Some random bushings are twisted by nearly half a turn.
                Err(InverseError::Spring { .. }) => continue,
                forces => forces.unwrap().power,
            };
            assert!(power.residual().abs() <= 1e-11 * power.turnover, "{what}: {power:?}");
            // Differences of energies have errors of 1e-11 of their terms.
            let off = apart(&numbers(&own), &numbers(&plain));
            assert!(off < 1e-8, "{what}: {off:e}");
            let expected = plain.forces().power;
            assert!((power.loads - expected.loads).abs() < 1e-8 * expected.turnover, "{what}");
            compared += 1;
            if own.solve_dense(&case.loads).is_ok() {
                let off = apart(&numbers(&own), &numbers(&plain));
                assert!(off < 1e-8, "dense {what}: {off:e}");
                densely += 1;
            }
        }
    }
    assert!(compared > 20 && densely > 15, "{compared} {densely}");
}

/// Creates a wheel with a torsion spring about the vertical.
fn wheel(spring: JointSpringSpec) -> Mechanism {
    MechanismBuilder::new("wheel")
        .body(BodySpec::new("wheel").mass(2.0).inertia(diagonal(0.01, 0.01, 0.02)))
        .joint(JointSpec::new("pivot", JointType::Revolute, "ground", "wheel").actuated())
        .joint_spring(spring)
        .build()
        .unwrap()
}

fn torsion() -> JointSpringSpec {
    JointSpringSpec::new("coil", "pivot").stiffness(0.5, 0.3).preload(0.2).damping(0.01)
}

/// Checks the torque that moves the wheel, also after several turns: J q'' + k (q - q0) - preload +
/// c q'.
#[test]
fn a_torsion_spring_counts_full_turns() {
    for (value, rate, acceleration) in [(0.1, 0.7, -3.0), (31.0, -2.0, 5.0), (-17.0, 0.0, 0.0)] {
        let mechanism = wheel(torsion());
        let coordinates = [Coordinate::Joint { joint: JointId(0), dof: 0 }];
        let targets = [Target { value, rate, acceleration }];
        let mut solver =
            InverseDynamics::new(mechanism, &[], &coordinates, &targets, Settings::default())
                .unwrap();
        let forces = solver.solve(&[]).unwrap();
        let expected = 0.02 * acceleration + 0.5 * (value - 0.3) - 0.2 + 0.01 * rate;
        assert!((forces.efforts[0] - expected).abs() < 1e-12 * expected.abs(), "{forces:?}");
    }
}

/// A torsion pendulum follows q = q1 + A e^(-d t) (cos w t + d/w sin w t) with the period 2 pi/w;
/// the energy balance includes all its energies.
#[test]
fn a_torsion_pendulum_has_its_period_and_decay() {
    let (inertia, stiffness, damping): (f64, f64, f64) = (0.02, 0.5, 0.01);
    let model = Forward::new(wheel(torsion()), &[]);
    let coordinates = [Coordinate::Joint { joint: JointId(0), dof: 0 }];
    let amplitude = 0.8;
    let middle = 0.3 + 0.2 / stiffness;
    let start = Target { value: middle + amplitude, rate: 0.0, acceleration: 0.0 };
    let state = model.assemble(&[], &coordinates, &[start]).unwrap();
    let mut inputs = ConstantEfforts(vec![]);
    let settings =
        forward::Settings { relative: 1e-14, absolute: 1e-15, ..forward::Settings::default() };
    let mut simulation = model.start(0.0, state, settings, &mut inputs).unwrap();
    let decay = damping / (2.0 * inertia);
    let frequency = (stiffness / inertia - decay * decay).sqrt();
    let period = std::f64::consts::TAU / frequency;
    for turns in 1..=4 {
        let time = f64::from(turns) * period;
        simulation.advance(time, &mut inputs).unwrap();
        let now = simulation.instant();
        let expected = middle + amplitude * (-decay * time).exp();
        let found = now.state.coordinates[0];
        assert!((found - expected).abs() < 1e-12, "{turns}: {:e}", found - expected);
        assert!(now.state.rates[0].abs() < 1e-11, "{:e}", now.state.rates[0]);
        let error = simulation.energy_error();
        assert!(error.abs() < 1e-12 * simulation.energies().turnover, "{error:e}");
    }
}

/// A lid of weight W and length l at 25 deg, held by a gas spring; the torque about the hinge is
/// calculated by hand.
#[test]
fn a_gas_spring_holds_a_lid() {
    let (foot, top) = (v(0.25, 0.0, -0.1), 0.3);
    let gas =
        GasSpring { extension_force: 300.0, progression: 1.35, extended_length: 0.4, stroke: 0.25 };
    let spring = SpringSpec::new("strut", "ground", "lid").points(foot, v(top, 0.0, 0.0)).gas(gas);
    let pin = along(Vec3::zero(), v(0.0, -1.0, 0.0));
    let mechanism = MechanismBuilder::new("lid")
        .gravity(v(0.0, 0.0, -9.81))
        .body(BodySpec::new("lid").mass(15.0).com(v(0.4, 0.0, 0.0)))
        .joint(
            JointSpec::new("hinge", JointType::Revolute, "ground", "lid")
                .frames(pin, pin)
                .actuated(),
        )
        .spring(spring)
        .build()
        .unwrap();
    assert!((mechanism.springs()[0].lengths.unwrap().0 - 0.15).abs() < 1e-15);
    for degrees in [5.0f64, 25.0, 60.0] {
        let (s, c) = degrees.to_radians().sin_cos();
        let (x, z) = (top * c - foot.x, top * s - foot.z);
        let length = x.hypot(z);
        let force = 300.0 * (1.0 + 0.35 * (0.4 - length) / 0.25);
        // The moment of the force at the lid's end about the hinge.
        let moment = force / length * (top * c * z - top * s * x);
        let expected = 15.0 * 9.81 * 0.4 * c - moment;
        let coordinates = [Coordinate::Joint { joint: JointId(0), dof: 0 }];
        let targets = [Target { value: degrees.to_radians(), rate: 0.0, acceleration: 0.0 }];
        let settings = Settings::default();
        let mut solver =
            InverseDynamics::new(mechanism.clone(), &[], &coordinates, &targets, settings).unwrap();
        let torque = solver.solve(&[]).unwrap().efforts[0];
        assert!((torque - expected).abs() < 1e-12 * 60.0, "{degrees}: {torque} {expected}");
    }
}

/// Creates a parallelogram linkage with equal torsion springs at all four pins, so that one of them
/// is at the cut joint. The energy is 2 k q^2, the torque 4 k q.
fn parallelogram(ranges: Option<(f64, f64)>) -> Mechanism {
    let axis = |at: Vec3<f64>| along(at, v(0.0, 0.0, 1.0));
    let pin = |name: &str, from: &str, to: &str, j: f64, k: f64| {
        let spec = JointSpec::new(name, JointType::Revolute, from, to)
            .frames(axis(v(j, 0.0, 0.0)), axis(v(k, 0.0, 0.0)));
        match ranges {
            Some(limits) => spec.range(JointRange { of: RangeOf::Dof(0), limits }),
            None => spec,
        }
    };
    let body = |name: &str| BodySpec::new(name).mass(1.0).inertia(diagonal(0.0, 0.0, 0.01));
    let mut builder = MechanismBuilder::new("parallelogram")
        .body(body("crank"))
        .body(body("coupler"))
        .body(body("rocker"))
        // Cranks of 0.2 m start along +x; frame and coupler of 0.5 m stay parallel to x.
        .joint(pin("A", "ground", "crank", 0.0, 0.0).actuated())
        .joint(pin("B", "crank", "coupler", 0.2, 0.0))
        .joint(pin("C", "coupler", "rocker", 0.5, 0.2))
        .joint(pin("D", "ground", "rocker", 0.5, 0.0));
    for joint in ["A", "B", "C", "D"] {
        let spring = JointSpringSpec::new(format!("{joint} flexure"), joint).stiffness(3.0, 0.0);
        builder = builder.joint_spring(spring);
    }
    builder.build().unwrap()
}

#[test]
fn flexures_of_a_parallelogram() {
    let mechanism = parallelogram(None);
    let coordinates = [Coordinate::Joint { joint: JointId(0), dof: 0 }];
    let target = |value: f64| [Target { value, rate: 0.4, acceleration: 0.0 }];
    let settings = Settings::default();
    let mut solver =
        InverseDynamics::new(mechanism.clone(), &[], &coordinates, &target(0.3), settings).unwrap();
    for value in [0.3, 1.0, 1.5, 2.0, 2.4, 2.9] {
        solver.move_to(&target(value)).unwrap();
        let found = solver.joint_coordinates(JointId(1))[0];
        assert!((found + value).abs() < 1e-9, "another branch: {found}");
        let torque = solver.solve(&[]).unwrap().efforts[0];
        // The cranks' centres of mass are on their pins; the coupler translates with the
        // acceleration 0.2 w^2.
        let inertial = 0.0;
        assert!((torque - 12.0 * value - inertial).abs() < 1e-11 * torque, "{value}: {torque}");
    }
    // Beyond this configuration, the angle of the joint that closes the loop is no longer unique.
    solver.move_to(&target(3.05)).unwrap();
    let error = solver.solve(&[]).unwrap_err();
    let InverseError::Spring { problem, .. } = &error else { panic!("{error}") };
    assert!(problem.contains("closes a loop") && problem.contains("range"), "{error}");
    assert!(solver.solve_dense(&[]).is_err());
    // Ranges around the motion shift the middle of the interval into which the angle is wrapped.
    let ranged = parallelogram(Some((-3.3, 3.9)));
    let solver = InverseDynamics::new(ranged, &[], &coordinates, &target(2.9), settings);
    assert!(solver.unwrap().solve(&[]).is_ok());
}

/// For a bushing between the ground and a plate, with one rotation or displacement, the wrench
/// follows from the stiffness matrix.
#[test]
fn a_bushing_has_its_matrix() {
    let mut random = Random(12);
    let matrix = random_matrix(&mut random, 2e3, 30.0);
    let damping = random_matrix(&mut random, 50.0, 1.0);
    for axis in 0..6 {
        let (amount, rate) = if axis < 3 { (0.02, 0.3) } else { (0.7, -0.4) };
        let mechanism = MechanismBuilder::new("plate")
            .body(BodySpec::new("plate"))
            .joint(JointSpec::new("held", JointType::Free, "ground", "plate"))
            .bushing(BushingSpec::new("pad", "ground", "plate").stiffness(matrix).damping(damping))
            .build()
            .unwrap();
        // A joint along one axis carries the five other components of the wrench.
        let (kind, direction) = (
            if axis < 3 { JointType::Prismatic } else { JointType::Revolute },
            Vec3::unit(axis % 3),
        );
        let frame = along(Vec3::zero(), direction);
        let held = MechanismBuilder::new("plate")
            .characteristic_length(1.0)
            .body(BodySpec::new("plate"))
            .joint(JointSpec::new("held", kind, "ground", "plate").frames(frame, frame).actuated())
            .bushing(BushingSpec::new("pad", "ground", "plate").stiffness(matrix).damping(damping))
            .build()
            .unwrap();
        assert_eq!(mechanism.bushings(), held.bushings());
        let coordinates = [Coordinate::Joint { joint: JointId(0), dof: 0 }];
        let targets = [Target { value: amount, rate, acceleration: 0.0 }];
        let mut solver =
            InverseDynamics::new(held, &[], &coordinates, &targets, Settings::default()).unwrap();
        let (force, moment) = solver.solve(&[]).unwrap().reactions[0];
        let found = [force.to_array(), moment.to_array()].concat();
        // The reaction refers to the joint's origin, which is the origin of the first frame.
        let place = if axis < 3 { direction * amount } else { Vec3::zero() };
        let pull = |k: usize| matrix[k][axis] * amount + damping[k][axis] * rate;
        let at = v(pull(0), pull(1), pull(2));
        let mut moments = v(pull(3), pull(4), pull(5));
        if axis >= 3 {
            // With a coupled matrix, the moment is the gradient of the energy with respect to a
            // small rotation.
            let gradient =
                nalgebra::Vector3::new(matrix[3][axis], matrix[4][axis], matrix[5][axis]) * amount;
            let cross = Vector3::from(direction * amount).cross_matrix();
            let factor = 1.0 / (amount * amount) - (0.5 * amount).tan().recip() / (2.0 * amount);
            let inverse = Matrix3::identity() - cross * 0.5 + cross * cross * factor;
            let turned = inverse.transpose() * gradient;
            let damped = v(damping[3][axis], damping[4][axis], damping[5][axis]) * rate;
            moments = Vec3::from(turned) + damped;
        }
        let moments = moments + place.cross(at);
        let expected = [at.to_array(), moments.to_array()].concat();
        let largest = expected.iter().fold(0.0f64, |max, x| max.max(x.abs()));
        for (found, expected) in found.iter().zip(&expected) {
            assert!((found - expected).abs() < 1e-12 * largest, "{axis}: {found} {expected}");
        }
        // About the rotation axis, the moment follows from the matrix without any correction.
        let own = found[axis];
        assert!((own - pull(axis)).abs() < 1e-12 * largest, "{axis}: {own}");
    }
}

/// A bushing that is twisted by half a turn has no moment.
#[test]
fn a_bushing_refuses_half_a_turn() {
    let stiffness: SixBySix =
        std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 10.0 } else { 0.0 }));
    let mechanism = MechanismBuilder::new("plate")
        .body(BodySpec::new("plate").mass(1.0).inertia(diagonal(1.0, 1.0, 1.0)))
        .joint(JointSpec::new("pivot", JointType::Revolute, "ground", "plate").actuated())
        .bushing(BushingSpec::new("pad", "ground", "plate").stiffness(stiffness))
        .build()
        .unwrap();
    let coordinates = [Coordinate::Joint { joint: JointId(0), dof: 0 }];
    let targets = |value| [Target { value, rate: 0.0, acceleration: 0.0 }];
    let solve = |value| {
        let mechanism = mechanism.clone();
        let settings = Settings::default();
        let solver = InverseDynamics::new(mechanism, &[], &coordinates, &targets(value), settings);
        solver.unwrap().solve(&[]).map(|forces| forces.efforts[0])
    };
    assert!((solve(3.0).unwrap() - 30.0).abs() < 1e-11);
    assert!(matches!(solve(3.13), Err(InverseError::Spring { .. })));
    // A simulation that would turn through half a turn stops there.
    let model = Forward::new(mechanism.clone(), &[]);
    let start = Target { value: 0.0, rate: 20.0, acceleration: 0.0 };
    let state = model.assemble(&[], &coordinates, &[start]).unwrap();
    let mut inputs = ConstantEfforts(vec![]);
    let settings = forward::Settings::default();
    let mut simulation = model.start(0.0, state, settings, &mut inputs).unwrap();
    let error = simulation.advance(1.0, &mut inputs).unwrap_err().to_string();
    assert!(error.contains("spring `pad`") && error.contains("half a turn"), "{error}");
}

/// For random mechanisms with all springs, the energy balance closes, and the accelerations agree
/// with inverse dynamics.
#[test]
fn simulations_book_the_energy_of_springs() {
    let mut ended = 0;
    for class in CLASSES {
        for seed in 200..203 {
            let (_, case) = case(class, seed, 0.1);
            let mechanism = sprung(&mut Random(seed), &case.mechanism).without_friction();
            let model = Forward::new(mechanism, &[]);
            let Ok(state) = model.assemble(&[], &case.coordinates, &case.targets) else { continue };
            let mut inputs = ConstantEfforts(vec![]);
            let settings = forward::Settings {
                relative: 1e-9,
                absolute: 1e-11,
                ..forward::Settings::default()
            };
            let Ok(mut simulation) = model.start(0.0, state, settings, &mut inputs) else {
                continue;
            };
            if simulation.advance(0.05, &mut inputs).is_err() {
                continue;
            }
            let turnover = simulation.energies().turnover + simulation.instant().account.kinetic;
            let error = simulation.energy_error().abs() / turnover.max(1e-6);
            assert!(error < 1e-8, "{class:?} {seed}: {error:e}");
            assert!(simulation.instant().account.dampers >= 0.0);
            ended += 1;
        }
    }
    assert!(ended > 12, "{ended}");
}

#[test]
fn springs_on_joints_allocate_nothing() {
    let (_, case) = case(Class::Parallel, 3, 0.01);
    let mechanism = sprung(&mut Random(3), &case.mechanism);
    let mut solver = solver(&mechanism, &case, Settings::default()).unwrap();
    solver.solve(&case.loads).unwrap();
    let solve = || {
        solver.move_to(&case.targets).unwrap();
        solver.solve(&case.loads).unwrap();
    };
    assert_eq!(allocations(solve), 0);
}

#[test]
fn defects_of_springs_on_joints_and_bushings() {
    let gas =
        GasSpring { extension_force: -1.0, progression: 0.9, extended_length: 0.2, stroke: 0.3 };
    let mut crooked = [[0.0; 6]; 6];
    crooked[0][1] = 5.0;
    let mut indefinite = [[0.0; 6]; 6];
    (indefinite[0][0], indefinite[1][1]) = (1.0, 1.0);
    (indefinite[0][1], indefinite[1][0]) = (2.0, 2.0);
    let defects = MechanismBuilder::new("wrong")
        .body(BodySpec::new("arm").mass(1.0))
        .joint(JointSpec::new("pivot", JointType::Universal, "ground", "arm"))
        .joint(JointSpec::new("ball", JointType::Spherical, "ground", "arm"))
        .spring(SpringSpec::new("gas", "ground", "arm").gas(gas))
        .joint_spring(JointSpringSpec::new("a", "pivot").stiffness(1.0, 0.0))
        .joint_spring(JointSpringSpec::new("b", "ball").stiffness(1.0, 0.0))
        .joint_spring(JointSpringSpec::new("c", "nowhere").stiffness(-1.0, f64::NAN))
        .bushing(BushingSpec::new("c", "ground", "arm").stiffness(crooked))
        .bushing(BushingSpec::new("d", "ground", "arm").damping(indefinite))
        .build()
        .unwrap_err();
    let found: Vec<String> = defects.iter().map(Defect::to_string).collect();
    let parts = [
        "extension force is -1 N",
        "progression is 0.9",
        "stroke is 0.3 m",
        "name one of `pivot.first`, `pivot.second`",
        "no degree of freedom with a single coordinate",
        "stiffness is -1",
        "`rest` of spring `c`",
        "`nowhere`, which does not exist",
        "two springs named `c`",
        "not symmetric: 0 in row 2, column 1, but 5 in row 1, column 2",
        "negative eigenvalue",
    ];
    assert_eq!(found.len(), parts.len(), "{found:#?}");
    for (found, part) in found.iter().zip(parts) {
        assert!(found.contains(part), "{found}");
    }
}
