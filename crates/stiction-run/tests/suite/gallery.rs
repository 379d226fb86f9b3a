//! Power balance of every robot of the gallery, and equilibrium of its bodies.

use crate::common::*;
use stiction_core::dynamics::{FrictionMode, InverseDynamics, LoadAxes, Settings};
use stiction_core::mechanism::Body;
use stiction_core::spatial::{Mat3, Pose, Vec3};
use stiction_run::check::examine;
use stiction_run::{Error, Job};

#[test]
fn powers_balance_and_loops_close() {
    for name in regular() {
        let model = model(name);
        for (motion, load) in cases(&model) {
            for friction in MODES {
                let run = Run::of(&job(&model, motion, load, friction)).unwrap();
                let what = format!("{name} {motion} {load} {friction:?}");
                // Decoupled friction is computed from the frictionless reactions, although it
                // changes them. The actuators still supply exactly its power.
                assert!(run.power_residual <= 1e-12, "{what}: {:e}", run.power_residual);
                assert!(run.closure <= 1e-12, "{what}: {:e}", run.closure);
                assert!(run.verdict.passed_singularities.is_empty(), "{what}");
                for table in [&run.inverse, &run.reactions, &run.friction] {
                    for (column, values) in table.columns() {
                        assert_eq!(values.len(), run.verdict.samples);
                        assert!(values.iter().all(|x| x.is_finite()), "{what}: {column}");
                    }
                }
            }
        }
    }
}

/// Weights of the central difference of eighth order for the first derivative, for offsets 1 to 4.
const FIRST: [f64; 4] = [4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0];
/// Weights of the central difference of eighth order for the second derivative, for offsets 1 to 4.
const SECOND: [f64; 4] = [8.0 / 5.0, -1.0 / 5.0, 8.0 / 315.0, -1.0 / 560.0];
/// Weight of the same difference for offset 0.
const SECOND_AT_0: f64 = -205.0 / 72.0;

/// Returns the time step of the differences, s: 2 ms, and less for shorter motions.
fn step_of(job: &Job<'_>) -> f64 {
    2e-3 * job.motion.duration.min(1.0)
}

/// Returns the first and second derivative of a quantity from its values at nine instants, `step`
/// apart.
fn derivatives(values: &[f64; 9], step: f64) -> (f64, f64) {
    let pairs = (1..=4).map(|k| (values[4 + k], values[4 - k]));
    let first: f64 = pairs.clone().zip(FIRST).map(|((a, b), w)| w * (a - b)).sum();
    let second: f64 = pairs.zip(SECOND).map(|((a, b), w)| w * (a + b)).sum();
    (first / step, (second + SECOND_AT_0 * values[4]) / (step * step))
}

/// Computes the force and the moment about its centre of mass that a body's motion requires. The
/// computation uses only nine poses and is independent of the program.
fn needed(poses: &[Pose<f64>; 9], step: f64, body: &Body) -> [Vec3<f64>; 2] {
    let &Body { mass, com, inertia, .. } = body;
    let vector = |f: &dyn Fn(usize, &Pose<f64>) -> f64, which: usize| {
        let component = |k| {
            let (first, second) = derivatives(&poses.each_ref().map(|pose| f(k, pose)), step);
            if which == 1 { first } else { second }
        };
        Vec3::new(component(0), component(1), component(2))
    };
    let acceleration = vector(&|k, pose| pose.apply(com).component(k), 2);
    // L = R J R^T w, with w from R' R^T.
    let columns = |which| {
        let column = |j| vector(&|i, pose| pose.rotation.at(i, j), which);
        Mat3::from_columns(column(0), column(1), column(2))
    };
    let rotation = poses[4].rotation;
    let (rate, second) = (columns(1), columns(2));
    let omega = (rate * rotation.transpose()).skew_part();
    let alpha = (second * rotation.transpose()).skew_part();
    let tensor = rotation * inertia * rotation.transpose();
    [acceleration * mass, tensor * alpha + omega.cross(tensor * omega)]
}

/// Returns the poses of all bodies at nine instants around a time, s.
fn poses_around(job: &Job<'_>, t: f64) -> Vec<[Pose<f64>; 9]> {
    let coordinates: Vec<_> = job.motion.coordinates.iter().map(|(c, _)| *c).collect();
    let (mechanism, initial_poses) = (job.model.mechanism.clone(), &job.model.initial_poses);
    let start: Vec<_> = job.motion.at(job.motion.start).collect();
    let mut solver =
        InverseDynamics::new(mechanism, initial_poses, &coordinates, &start, Settings::default())
            .unwrap();
    let mut poses = vec![[Pose::identity(); 9]; job.model.mechanism.bodies().len()];
    let mut before = job.motion.start;
    for k in 0..9 {
        let time = t + (k as f64 - 4.0) * step_of(job);
        let targets = |t: f64, targets: &mut [_]| {
            targets.iter_mut().zip(job.motion.at(t)).for_each(|(target, at)| *target = at);
        };
        solver.follow(before, time, targets).unwrap();
        before = time;
        for (poses, pose) in poses.iter_mut().zip(&solver.bodies().pose) {
            poses[k] = Pose { position: pose.position + solver.parameters().origin, ..*pose };
        }
    }
    poses
}

/// Tests the equilibrium of every body, computed only from `reactions.csv` and the positions of the
/// bodies, without velocities, accelerations and other forces.
#[test]
fn every_body_is_in_equilibrium_from_the_written_reactions() {
    for name in regular() {
        let model = model(name);
        let mechanism = &model.mechanism;
        for friction in [FrictionMode::Off, FrictionMode::Converged] {
            let job = default_job(&model, friction);
            let run = Run::of(&job).unwrap();
            let times = run.reactions.column("time [s]");
            let count = times.len();
            for row in [count / 7, count / 3, count / 2, 4 * count / 5] {
                let poses = poses_around(&job, times[row]);
                let written = |joint: &str, kind: char, unit: &str| {
                    let [x, y, z] = ['x', 'y', 'z'].map(|axis| {
                        run.reactions.column(&format!("{joint}.{kind}{axis} [{unit}]"))[row]
                    });
                    Vec3::new(x, y, z)
                };
                let loads: Vec<_> = job.load.at(times[row]).collect();
                for (index, body) in mechanism.bodies().iter().enumerate().skip(1) {
                    let com = poses[index][4].apply(body.com);
                    let (mut force, mut moment) = (mechanism.gravity() * body.mass, Vec3::zero());
                    let mut size = force.norm();
                    let mut reach = 0.0_f64;
                    let mut add = |f: Vec3<f64>, m: Vec3<f64>, point: Vec3<f64>| {
                        force += f;
                        moment += m + (point - com).cross(f);
                        size = size.max(f.norm());
                        reach = reach.max((point - com).norm());
                    };
                    for joint in mechanism.joints() {
                        let origin = poses[joint.predecessor.0][4].apply(joint.frame_j.position);
                        let f = written(&joint.name, 'f', "N");
                        let m = written(&joint.name, 'm', "N m");
                        if joint.successor.0 == index {
                            add(f, m, origin);
                        }
                        if joint.predecessor.0 == index {
                            add(-f, -m, origin);
                        }
                    }
                    for load in loads.iter().filter(|load| load.body.0 == index) {
                        let pose = poses[index][4];
                        let turn = |v| match load.axes {
                            LoadAxes::World => v,
                            LoadAxes::Body => pose.rotation * v,
                        };
                        add(turn(load.force), turn(load.moment), pose.apply(load.point));
                    }
                    for payload in job.load.payloads.iter().filter(|p| p.body.0 == index) {
                        let part = &payload.part;
                        let [force, moment] = needed(&poses[index], step_of(&job), part);
                        let weight = mechanism.gravity() * part.mass;
                        add(weight - force, -moment, poses[index][4].apply(part.com));
                    }
                    for spring in mechanism.springs() {
                        let at = |k: usize, poses: &[Pose<f64>; 9], instant: usize| {
                            poses[instant].apply(spring.points[k])
                        };
                        let ends = spring.ends.map(|body| &poses[body.0]);
                        let span = |instant| at(1, ends[1], instant) - at(0, ends[0], instant);
                        let lengths = core::array::from_fn(|instant| span(instant).norm());
                        let (rate, _) = derivatives(&lengths, step_of(&job));
                        let tension = spring.stiffness * (lengths[4] - spring.free_length)
                            + spring.damping * rate;
                        let pull = span(4) * (tension / lengths[4]);
                        for (k, sign) in [(0, 1.0), (1, -1.0)] {
                            if spring.ends[k].0 == index {
                                add(pull * sign, Vec3::zero(), at(k, ends[k], 4));
                            }
                        }
                    }
                    let [needed_force, needed_moment] = needed(&poses[index], step_of(&job), body);
                    let what = format!("{name} {friction:?} t = {} {}", times[row], body.name);
                    // Differences of eighth order over 2 ms have errors of about 1e-9 of the
                    // accelerations.
                    let error = (force - needed_force).norm();
                    assert!(error <= 1e-8 * size, "{what}: {error:e} N of {size:e}");
                    let mut error = moment - needed_moment;
                    let spins = ["rod", "screw", "tube"].iter().any(|s| body.name.ends_with(s));
                    if spins && ["6sps", "delta"].contains(&name) {
                        // A leg may spin about its own axis, z. Friction accelerates this spin, but
                        // the positions do not show it, because the rate of the spin is zero by
                        // convention.
                        error = error.across(poses[index][4].rotation.columns[2]);
                    }
                    let error = error.norm();
                    let size = size * reach.max(1e-2);
                    assert!(error <= 1e-8 * size, "{what}: {error:e} N m of {size:e}");
                }
            }
        }
    }
}

#[test]
fn the_missing_moment_of_the_printed_robot_is_reported() {
    let model = model("zhang2018");
    for friction in MODES {
        match Run::of(&default_job(&model, friction)) {
            Err(Error::CannotCarry(missing)) => {
                assert_eq!((missing.samples, missing.of, missing.unit), (101, 101, "N m"));
                let (least, greatest) = missing.range;
                assert!(
                    (least - 53.9).abs() < 0.05 && (greatest - 55.6).abs() < 0.05,
                    "{missing:?}"
                );
                assert!(
                    missing.first.to_string().contains("rotation about y"),
                    "{}",
                    missing.first
                );
            }
            other => panic!("{other:?}"),
        }
    }
    // Without the load, the missing force is smaller and does not occur at every sample. Where no
    // force is missing, the problem with friction has no solution, which leads to another message.
    for friction in MODES {
        match Run::of(&job(&model, "printed", "none", friction)) {
            Err(Error::CannotCarry(missing)) => {
                assert_eq!(missing.samples, 98, "{friction:?}");
                assert!(missing.range.1 < 1.0, "{missing:?}");
            }
            other => panic!("{other:?}"),
        }
    }
}

/// Tests that six locked actuators do not hold the platform: under its weight it sinks, while all
/// legs keep their lengths.
#[test]
fn a_griffis_duffy_platform_falls_with_its_legs_locked() {
    let model = model("griffis-duffy");
    for friction in MODES {
        match Run::of(&default_job(&model, friction)) {
            // The three samples at the top of the curve have a solution.
            Err(Error::CannotCarry(missing)) => {
                assert_eq!((missing.samples, missing.of, missing.unit), (98, 101, "N m"));
                let first = missing.first.to_string();
                assert!(first.contains("`platform` can still move (screw about z"), "{first}");
            }
            other => panic!("{other:?}"),
        }
    }
    let found = examine(&default_job(&model, FrictionMode::Off), |_, _, _| true).unwrap();
    assert_eq!(found.actuation.singular_samples, found.samples);
    assert_eq!(found.constraint.singular_samples, 0);
    let legs: Vec<_> = found.sizes.joints.iter().filter(|r| r.name.ends_with(".P")).collect();
    assert_eq!(legs.len(), 6);
    for stiction_run::check::Range { name, least, greatest, .. } in legs {
        // sqrt(0.5^2 + (2/sqrt(3) - 1/sqrt(3))^2 0.3^2) m, up to rounding.
        let length = 0.28_f64.sqrt();
        assert!((least - length).abs() < 1e-14 && (greatest - length).abs() < 1e-14, "{name}");
    }
}

/// Tests that the platform has a singular architecture: in every pose, it has exactly one
/// instantaneous motion with locked actuators.
#[test]
fn a_griffis_duffy_platform_is_singular_everywhere() {
    let model = model("griffis-duffy");
    let job = job(&model, "sway", "none", FrictionMode::Off);
    let coordinates: Vec<_> = job.motion.coordinates.iter().map(|(c, _)| *c).collect();
    for k in 0..20 {
        let targets: Vec<_> = job.motion.at(0.1 * f64::from(k)).collect();
        let (mechanism, initial_poses) = (model.mechanism.clone(), &model.initial_poses);
        let solver = InverseDynamics::new(
            mechanism,
            initial_poses,
            &coordinates,
            &targets,
            Settings::default(),
        );
        assert_eq!(solver.unwrap().statics().open_motions(), 1, "{k}");
    }
}

/// Tests that, on the axis, the legs have equal forces and carry symmetric loads. A payload off the
/// axis tilts the platform about the intersection of the legs, 1.2 m above the base.
#[test]
fn the_snu_robot_carries_nothing_that_tilts_it() {
    let model = model("3upu-singular");
    for friction in MODES {
        let run = Run::of(&job(&model, "lift", "none", friction)).unwrap();
        assert!(run.power_residual <= 1e-12, "{friction:?} {:e}", run.power_residual);
        match Run::of(&job(&model, "lift", "payload", friction)) {
            Err(Error::CannotCarry(missing)) => {
                assert_eq!((missing.samples, missing.of, missing.unit), (101, 101, "N m"));
                let first = missing.first.to_string();
                assert!(first.contains("rotation about y through (0, 0, 1.2) m"), "{first}");
                // 5 kg at 60 mm from the axis, in a pose in which the moment of the payload acts
                // about this intersection. The motion begins and ends without acceleration.
                let at_rest = 5.0 * 9.81 * 0.06;
                assert!(first.contains("2.94300 N m"), "{first}");
                let (least, greatest) = missing.range;
                assert!(least < at_rest && at_rest < greatest, "{missing:?}");
            }
            other => panic!("{friction:?} {other:?}"),
        }
    }
    // Off the axis, three legs constrain the platform weakly: four sevenths of the given friction
    // already lock it.
    Run::of(&job(&model, "aside", "payload", FrictionMode::Off)).unwrap();
    let locked = Run::of(&job(&model, "aside", "payload", FrictionMode::Converged));
    assert!(locked.unwrap_err().to_string().contains("friction locks the mechanism"));
}
