//! Batches of states: inverse dynamics, poses, Jacobians, mass matrices.

use std::num::NonZeroUsize;
use stiction::{Batch, FrictionMode, Inverse, Outputs, Robot, States, Status, Workers};

/// Built-in robots with closed chains and one actuator for each degree of freedom.
const ROBOTS: [&str; 6] =
    ["3rps", "five-bar", "gough", "delta", "slider-crank", "zhang2018-regular"];

/// Reactions and frictions.
const BOTH: Outputs =
    Outputs { reactions: true, frictions: true, motors: false, derivatives: false };
const DERIVATIVES: Outputs =
    Outputs { reactions: false, frictions: false, motors: false, derivatives: true };

fn threads<'a>(count: usize) -> Workers<'a> {
    Workers { threads: NonZeroUsize::new(count).unwrap(), ..Workers::default() }
}

/// Coordinates, rates and accelerations of the actuators along the default motion, and the efforts there.
fn along(robot: &Robot, step: f64) -> ([Vec<f64>; 3], Vec<f64>) {
    let request: Inverse = robot.inverse().load("none").unwrap();
    let results = request.step(step).tabulate(|_, _, _| true).unwrap();
    let table =
        |file: &str| results.tables.iter().find(|table| table.file == file).unwrap().clone();
    let (joints, inverse) = (table("joints.csv"), table("inverse.csv"));
    let rows = inverse.rows();
    let column = |table: &stiction::run::Table, name: &str| -> Vec<f64> {
        let place = table.header.iter().position(|header| header.starts_with(name)).unwrap();
        table.clone().into_columns()[place * rows..][..rows].to_vec()
    };
    let names: Vec<String> = robot.actuators().map(str::to_owned).collect();
    let each = |quantity: &str, table: &stiction::run::Table| -> Vec<f64> {
        let columns: Vec<Vec<f64>> =
            names.iter().map(|name| column(table, &format!("{name}.{quantity} ["))).collect();
        (0..rows).flat_map(|row| columns.iter().map(move |c| c[row]).collect::<Vec<_>>()).collect()
    };
    let motion = ["position", "rate", "acceleration"].map(|quantity| each(quantity, &joints));
    (motion, each("drive", &inverse))
}

fn largest(numbers: &[f64]) -> f64 {
    numbers.iter().fold(0.0, |largest, x| x.abs().max(largest))
}

#[test]
fn efforts_of_a_batch_are_those_along_the_motion() {
    for name in ROBOTS {
        let robot = Robot::builtin(name).unwrap();
        let ([q, v, a], efforts) = along(&robot, 0.01);
        let states = robot.states().load("none").unwrap().compile().unwrap();
        let batch = Batch { q: &q, v: &v, a: &a };
        let rows = states.inverse_dynamics(batch, BOTH, &threads(1)).unwrap();
        let mut compared = 0;
        for (row, status) in rows.status.iter().enumerate() {
            assert!(status.is_converged(), "{name} row {row}: {status:?}");
            let count = states.coordinates().len();
            let at = row * count..(row + 1) * count;
            // At rest, `inverse` uses a speed limit of its own to choose the friction of joints.
            if v[at.clone()].iter().any(|rate| rate.abs() < 1e-9) {
                continue;
            }
            compared += 1;
            for (batch, run) in rows.efforts[at.clone()].iter().zip(&efforts[at]) {
                // The coordinates of the actuators follow from those of the motion by a numerical
                // inversion.
                assert!(
                    (batch - run).abs() < 1e-9 * largest(&efforts),
                    "{name} row {row}: {batch} {run}"
                );
            }
        }
        assert!(compared > 40, "{name}: {compared}");
        assert_eq!(rows.reactions.len(), rows.status.len() * 6 * robot.joints().count());
        assert!(rows.frictions.iter().all(|x| x.is_finite()));
    }
}

/// Motors of a five-bar: two that move both joints, one with a rotor that its body carries, and losses of all kinds.
const MOTORS: &str = r#"
[actuators.sum]
joints = { left_motor = 1, right_motor = 1 }
ratio = 5
rotor_inertia = "1e-3 kg m^2"
motor_friction = { constant = "0.01 N m", viscous = "1e-4 N m s/rad" }
efficiency = 0.9
[actuators.difference]
joints = { left_motor = 1, right_motor = -1 }
ratio = -7
rotor_inertia = "2e-4 kg m^2"
rotor_axis = { body = "left_crank", axis = "z" }
efficiency = 0.8
"#;

#[test]
fn motors_of_a_batch_are_those_along_the_motion() {
    let robot = Robot::builtin("five-bar").unwrap();
    let text = format!("{}{MOTORS}", robot.text().unwrap().parts().text);
    let robot = Robot::parse(&text).unwrap();
    assert_eq!(robot.motors().collect::<Vec<_>>(), ["sum", "difference"]);
    let ([q, v, a], _) = along(&robot, 0.01);
    for friction in [FrictionMode::Converged, FrictionMode::Off] {
        let request = robot.inverse().load("none").unwrap().friction(friction);
        let expected: Vec<_> = request.step(0.01).collect().unwrap();
        let states = robot.states().load("none").unwrap().friction(friction).compile().unwrap();
        let wanted = Outputs { motors: true, ..Outputs::default() };
        let batch = Batch { q: &q, v: &v, a: &a };
        let rows = states.inverse_dynamics(batch, wanted, &threads(2)).unwrap();
        assert_eq!(rows.motor_torques.len(), 2 * expected.len());
        let mut compared = 0;
        for (row, sample) in expected.iter().enumerate() {
            // At a reversal `inverse` chooses the friction of joints by its own limit of speed.
            if v[2 * row..][..2].iter().any(|rate| rate.abs() < 1e-6) {
                continue;
            }
            compared += 1;
            for (index, name) in robot.motors().enumerate() {
                let motor = sample.motor(name).unwrap();
                let index = 2 * row + index;
                for (expected, found) in [
                    (motor.torque, rows.motor_torques[index]),
                    (motor.speed, rows.motor_speeds[index]),
                ] {
                    let error = (expected - found).abs();
                    assert!(error < 1e-9 * (1.0 + expected.abs()), "{row}: {expected} {found}");
                }
            }
        }
        assert!(compared > 50, "{compared}");
    }
    // At rest a torque has neither friction nor losses, whichever the coordinates are.
    let at_home = |states: States| {
        let wanted = Outputs { motors: true, ..Outputs::default() };
        let batch = Batch { q: states.home(), v: &[], a: &[] };
        let rows = states.inverse_dynamics(batch, wanted, &threads(1)).unwrap();
        assert_eq!(rows.motor_speeds, [0.0, 0.0]);
        rows.motor_torques
    };
    let rest = at_home(robot.states().compile().unwrap());
    let tool = robot.states().coordinates(&["tool.x", "tool.y"]).unwrap();
    for (a, b) in rest.iter().zip(at_home(tool.compile().unwrap())) {
        assert!((a - b).abs() < 1e-9, "{a} {b}");
    }
}

#[test]
fn results_do_not_depend_on_threads() {
    let robot = Robot::builtin("3rps").unwrap();
    let ([q, v, a], _) = along(&robot, 0.0005);
    let states = robot.states().compile().unwrap();
    let batch = Batch { q: &q, v: &v, a: &a };
    let rows = |count| states.inverse_dynamics(batch, BOTH, &threads(count)).unwrap();
    let one = rows(1);
    assert!(one.status.len() > 1000 && one.status.iter().all(|status| status.is_converged()));
    for count in [2, 3, 7] {
        let other = rows(count);
        assert_eq!((&one.efforts, &one.reactions), (&other.efforts, &other.reactions));
        assert_eq!(
            (&one.frictions, &one.power_residual),
            (&other.frictions, &other.power_residual)
        );
    }
}

/// States around the home position, from a simple generator of pseudo-random numbers.
fn about_home(states: &States, rows: usize, amplitude: f64) -> Vec<f64> {
    let mut seed = 1_u64;
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    (0..rows)
        .flat_map(|_| states.home().iter().map(|x| x + amplitude * random()).collect::<Vec<_>>())
        .collect()
}

#[test]
fn the_mass_matrix_gives_the_kinetic_energy_of_all_bodies() {
    for name in ROBOTS {
        let robot = Robot::builtin(name).unwrap();
        // A payload of the load would be an additional body in the model.
        let states = robot.states().load("none").unwrap().compile().unwrap();
        let count = states.coordinates().len();
        let q = about_home(&states, 20, 0.002);
        let v: Vec<f64> = (0..q.len()).map(|k| 0.5 + ((k * k) as f64).sin()).collect();
        let masses = states.mass_matrix(&q, &threads(1)).unwrap();
        let batch = Batch { q: &q, v: &v, a: &[] };
        let motion = states.kinematics(batch, &threads(1)).unwrap();
        for row in 0..20 {
            assert!(masses.status[row].is_converged(), "{name}: {:?}", masses.status[row]);
            let matrix = &masses.values[row * count * count..][..count * count];
            let rates = &v[row * count..][..count];
            let mut twice = 0.0;
            for (i, j) in (0..count).flat_map(|i| (0..count).map(move |j| (i, j))) {
                let skew = matrix[i * count + j] - matrix[j * count + i];
                assert!(skew.abs() < 1e-10 * largest(matrix), "{name}: {skew}");
                twice += rates[i] * matrix[i * count + j] * rates[j];
            }
            let bodies = robot.mechanism().bodies();
            let mut energy = 0.0;
            for (index, body) in bodies.iter().enumerate().skip(1) {
                let place = (row * bodies.len() + index) * 6;
                let twist = &motion.twists[place..][..6];
                let [w, x, y, z] = motion.quaternions[(row * bodies.len() + index) * 4..][..4]
                else {
                    unreachable!()
                };
                let columns = [
                    [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)],
                    [2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)],
                    [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)],
                ];
                let com = body.com.to_array();
                let arm: Vec<f64> =
                    (0..3).map(|i| (0..3).map(|k| columns[k][i] * com[k]).sum()).collect();
                let omega = &twist[3..];
                let cross = |a: &[f64], b: &[f64], i: usize| {
                    let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                    a[j] * b[k] - a[k] * b[j]
                };
                let speed: f64 = (0..3).map(|i| (twist[i] + cross(omega, &arm, i)).powi(2)).sum();
                let spin: Vec<f64> =
                    (0..3).map(|k| (0..3).map(|i| columns[k][i] * omega[i]).sum()).collect();
                let turned: f64 = (0..3)
                    .flat_map(|i| (0..3).map(move |j| (i, j)))
                    .map(|(i, j)| spin[i] * body.inertia.at(i, j) * spin[j])
                    .sum();
                energy += body.mass * speed + turned;
            }
            // Twice the kinetic energy, computed in a different way.
            assert!((twice - energy).abs() < 1e-9 * energy, "{name}: {twice} {energy}");
        }
    }
}

#[test]
fn a_jacobian_times_rates_is_the_twist_and_the_slope_of_positions() {
    for name in ROBOTS {
        let robot = Robot::builtin(name).unwrap();
        let states = robot.states().compile().unwrap();
        let count = states.coordinates().len();
        let bodies = robot.bodies().count();
        let q = about_home(&states, 1, 0.01);
        let jacobian = states.jacobian(&q, &threads(1)).unwrap().values;
        let v: Vec<f64> = (0..count).map(|k| 1.0 + k as f64).collect();
        let motion =
            |q: &[f64], v: &[f64]| states.kinematics(Batch { q, v, a: &[] }, &threads(1)).unwrap();
        let twists = motion(&q, &v).twists;
        let shifted = |h: f64| -> Vec<f64> {
            let q: Vec<f64> = q.iter().zip(&v).map(|(q, v)| q + h * v).collect();
            motion(&q, &[]).positions
        };
        let (ahead, behind) = (shifted(1e-6), shifted(-1e-6));
        let size = largest(&twists);
        for row in 0..6 * bodies {
            let product: f64 = (0..count).map(|k| jacobian[row * count + k] * v[k]).sum();
            assert!((product - twists[row]).abs() < 1e-12 * size, "{name}");
            let (body, axis) = (row / 6, row % 6);
            if axis < 3 {
                let slope = (ahead[3 * body + axis] - behind[3 * body + axis]) / 2e-6;
                assert!(
                    (slope - twists[row]).abs() < 1e-7 * size,
                    "{name}: {slope} {}",
                    twists[row]
                );
            }
        }
    }
}

#[test]
fn far_rows_keep_the_assembly_mode_and_unreachable_ones_have_a_status() {
    let robot = Robot::builtin("five-bar").unwrap();
    let states = robot.states().compile().unwrap();
    let home = states.home().to_vec();
    let near = |q: &[f64]| states.kinematics(Batch { q, v: &[], a: &[] }, &threads(1)).unwrap();
    // The rows move away and back: both rows at the home position have equal poses.
    let far: Vec<f64> = home.iter().map(|x| x + 0.5).collect();
    let rows: Vec<f64> = [&home[..], &far, &home].concat();
    let motion = near(&rows);
    assert!(motion.status.iter().all(|status| status.is_converged()), "{:?}", motion.status);
    let width = motion.positions.len() / 3;
    for k in 0..width {
        assert!((motion.positions[k] - motion.positions[2 * width + k]).abs() < 1e-12);
    }
    let apart: Vec<f64> = [1.0, -1.0].iter().zip(&home).map(|(sign, x)| x + 2.0 * sign).collect();
    let rows: Vec<f64> =
        [&home[..], &apart, &home, &[f64::NAN, 0.0], &[1e300, 0.0], &home].concat();
    let motion = near(&rows);
    let works: Vec<bool> = motion.status.iter().map(|status| status.is_converged()).collect();
    assert_eq!(works[0..1], [true]);
    assert_eq!((works[2], works[5]), (true, true));
    assert!(matches!(motion.status[3], Status::InputNotFinite));
    assert!(matches!(motion.status[4], Status::LoopsOpen { .. }));
    assert!(motion.positions[3 * width..5 * width].iter().all(|x| x.is_nan()));
    assert_eq!(motion.positions[..width], motion.positions[5 * width..]);
}

#[test]
fn other_coordinates_are_those_of_the_motion() {
    let robot = Robot::builtin("gough").unwrap();
    let names =
        ["platform.x", "platform.y", "platform.z", "platform.rx", "platform.ry", "platform.rz"];
    let Ok(request) = robot.states().coordinates(&names) else {
        panic!("{}", robot.states().coordinates(&names).unwrap_err())
    };
    let states = request.friction(FrictionMode::Off).compile().unwrap();
    let rows = states
        .inverse_dynamics(
            Batch { q: states.home(), v: &[], a: &[] },
            Outputs::default(),
            &threads(1),
        )
        .unwrap();
    let by_legs = robot.states().friction(FrictionMode::Off).compile().unwrap();
    let batch = Batch { q: by_legs.home(), v: &[], a: &[] };
    let legs = by_legs.inverse_dynamics(batch, Outputs::default(), &threads(1)).unwrap();
    for (a, b) in rows.efforts.iter().zip(&legs.efforts) {
        assert!((a - b).abs() < 1e-10 * largest(&legs.efforts), "{a} {b}");
    }
    let error = states.mass_matrix(states.home(), &threads(1)).unwrap_err().to_string();
    assert!(error.contains("actuators") && error.contains("platform.x"), "{error}");
}

#[test]
fn wrong_shapes_are_refused_with_names() {
    let states = Robot::builtin("five-bar").unwrap().states().compile().unwrap();
    let call = |q: &[f64], v: &[f64]| {
        let error =
            states.inverse_dynamics(Batch { q, v, a: &[] }, Outputs::default(), &threads(1));
        error.map(|rows| rows.status.len()).map_err(|error| error.to_string())
    };
    assert!(call(&[0.0; 3], &[]).unwrap_err().contains("`q` has 3 numbers"));
    assert!(call(&[0.0; 4], &[0.0; 2]).unwrap_err().contains("`v` has 2 numbers"));
    assert_eq!(call(&[], &[]).unwrap(), 0);
}

/// Derivatives agree with fourth-order central differences of the efforts of the general kernel,
/// with friction and without.
#[test]
fn derivatives_are_differences_of_the_efforts() {
    for name in ROBOTS {
        let robot = Robot::builtin(name).unwrap();
        for friction in [FrictionMode::Off, FrictionMode::Converged] {
            let states = robot.states().friction(friction).compile().unwrap();
            let ([q, v, a], _) = along(&robot, 0.13);
            let count = states.home().len();
            let rows = q.len() / count;
            let batch = Batch { q: &q, v: &v, a: &a };
            let found = states.inverse_dynamics(batch, DERIVATIVES, &threads(1)).unwrap();
            let again = states.inverse_dynamics(batch, DERIVATIVES, &threads(2)).unwrap();
            let derivatives = found.derivatives.unwrap();
            let same = again.derivatives.unwrap();
            assert_eq!(derivatives.is_defined, same.is_defined);
            let actuators = found.efforts.len() / rows;
            let efforts = |batch: Batch<'_>| {
                let results =
                    states.inverse_dynamics(batch, Outputs::default(), &threads(1)).unwrap();
                results.efforts
            };
            let mut compared = 0;
            for (kind, slopes) in
                [&derivatives.by_position, &derivatives.by_rate, &derivatives.by_acceleration]
                    .into_iter()
                    .enumerate()
            {
                for column in 0..count {
                    let step = [1e-5, 1e-6, 1e-3][kind];
                    let moved = |sign: f64| {
                        let mut arrays = [q.clone(), v.clone(), a.clone()];
                        for row in arrays[kind].chunks_exact_mut(count) {
                            row[column] += sign * step;
                        }
                        let [q, v, a] = arrays;
                        efforts(Batch { q: &q, v: &v, a: &a })
                    };
                    let [ahead, behind] = [moved(1.0), moved(-1.0)];
                    let [far_ahead, far_behind] = [moved(2.0), moved(-2.0)];
                    for row in (0..rows).filter(|row| derivatives.is_defined[*row]) {
                        // Near zero rate, friction reverses and jumps.
                        let slow = v[row * count..][..count].iter().any(|rate| rate.abs() < 1e-4);
                        if slow && friction == FrictionMode::Converged {
                            continue;
                        }
                        let scale = largest(&found.efforts).max(1.0) / [1e-2, 1e-2, 1.0][kind];
                        for actuator in 0..actuators {
                            let at = row * actuators + actuator;
                            let wanted = (8.0 * (ahead[at] - behind[at])
                                - (far_ahead[at] - far_behind[at]))
                                / (12.0 * step);
                            let slope = slopes[at * count + column];
                            let most = 1e-5 * scale.max(wanted.abs());
                            assert!(
                                (slope - wanted).abs() < most,
                                "{name} {friction:?} {kind} row {row}: {slope} {wanted}"
                            );
                            compared += 1;
                        }
                    }
                }
            }
            assert!(compared > 5 * count * actuators, "{name} {friction:?}: {compared}");
        }
    }
}

/// The derivatives with respect to accelerations are the mass matrix; at rest with friction there
/// are no derivatives.
#[test]
fn derivatives_at_rest() {
    let robot = Robot::builtin("five-bar").unwrap();
    let states = robot.states().friction(FrictionMode::Off).load("none").unwrap();
    let states = states.compile().unwrap();
    let batch = Batch { q: states.home(), v: &[], a: &[] };
    let found = states.inverse_dynamics(batch, DERIVATIVES, &threads(1)).unwrap();
    let mass = states.mass_matrix(states.home(), &threads(1)).unwrap();
    for (found, mass_entry) in found.derivatives.unwrap().by_acceleration.iter().zip(&mass.values) {
        let error = (found - mass_entry).abs();
        assert!(error < 1e-12 * largest(&mass.values), "{found} {mass_entry}");
    }
    let states = robot.states().friction(FrictionMode::Converged).compile().unwrap();
    let found = states.inverse_dynamics(batch, DERIVATIVES, &threads(1)).unwrap();
    let derivatives = found.derivatives.unwrap();
    assert_eq!(derivatives.is_defined, [false]);
    assert!(derivatives.by_rate.iter().all(|slope| slope.is_nan()));
    let one_pass = robot.states().friction(FrictionMode::OnePass).compile().unwrap();
    let error = one_pass.inverse_dynamics(batch, DERIVATIVES, &threads(1)).unwrap_err();
    assert!(error.to_string().contains("converged friction"), "{error}");
}
