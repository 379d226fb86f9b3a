//! Section 6 of the paper: the simulation of equation (29).

use super::{
    curves, digits, equation, fixed, greatest, open, panel, paragraph, range, right, rounding,
    section, table, wrong,
};
use crate::kinematics::{determinant, inverse_jacobian};
use crate::lagrangian::{Printed, driving_forces, generalised_force, generalised_load};
use crate::reactions::{Form, System};
use crate::report::{Cell, Section};
use crate::robot::{Load, NO_LOAD, PRINTED_LOAD, Robot};
use crate::simulation::{fold, least_squares, missing_moment, planar_least_squares, with_friction};
use core::f64::consts::FRAC_PI_2;
use nalgebra::{Matrix3, Vector3};

const SAMPLES: usize = 1000;

/// Minimum and maximum of the moment along (29) that the actuators cannot balance, N m.
pub(crate) fn missing(load: Load) -> (f64, f64) {
    let robot = Robot::printed();
    range(
        (0..=SAMPLES).map(|k| {
            missing_moment(&robot, &Robot::printed_motion(k as f64 / SAMPLES as f64), load)
        }),
    )
}

/// Smallest singular value of J^-1 along (29), with the third column in units of k, and the largest
/// deviation of row 2 + row 3 from twice row 1.
pub(crate) fn singular() -> (f64, f64) {
    let robot = Robot::printed();
    let mut worst = (0.0_f64, 0.0_f64);
    for k in 0..=SAMPLES {
        let rows = inverse_jacobian(&robot, Robot::printed_motion(k as f64 / SAMPLES as f64).pose);
        let unit = Vector3::new(1.0, 1.0, 1.0 / robot.k);
        let matrix = Matrix3::from_fn(|n, i| rows[n][i] * unit[i]);
        worst.0 = worst.0.max(matrix.singular_values().min());
        // The rows are unit leg directions; multiplied by the lengths they are linear in the pose.
        let lengths = crate::robot::leg_lengths(
            &robot,
            Robot::printed_motion(k as f64 / SAMPLES as f64).pose,
        );
        let of = |n: usize, i: usize| matrix[(n, i)] * lengths[n];
        worst.1 = worst.1.max(greatest((0..3).map(|i| of(1, i) + of(2, i) - 2.0 * of(0, i))));
    }
    worst
}

/// Largest actuator force of (21), N, at t = 0.25 s without load, if theta differs from 90 deg by
/// `degrees`.
pub(crate) fn near_singular(degrees: f64) -> Option<f64> {
    let mut motion = Robot::printed_motion(0.25);
    motion.pose[2] = FRAC_PI_2 + degrees.to_radians();
    let robot = Robot::printed();
    driving_forces(&robot, Printed::NONE, &motion, NO_LOAD).map(greatest)
}

/// Self-stresses of the friction examples on (29), N.
const STRESSES: [f64; 3] = [0.0, 50.0, -50.0];

fn folds(robot: &Robot) -> [[Cell; 4]; 3] {
    let home = Robot::printed_motion(0.0).pose;
    [1e-6, -1e-6, -1e-5].map(|change| {
        let found = [0.01, -0.01].map(|turn| fold(robot, 0.0, change, turn));
        let off = |i: usize, factor: f64| match found {
            [Some(a), Some(b)] => {
                let digits = if i == 0 { 1 } else { 2 };
                let (a, b) = ((a[i] - home[i]) * factor, (b[i] - home[i]) * factor);
                Cell::from(format!("{a:+.digits$} or {b:+.digits$}"))
            }
            _ => Cell::Empty,
        };
        let count = found.iter().flatten().count();
        let count = if count == 0 { "none".to_owned() } else { count.to_string() };
        [fixed(change * 1e6, 0), Cell::from(count), off(0, 1e3), off(2, 1f64.to_degrees())]
    })
}

pub(crate) fn write(by_engine: &stiction_run::Error) -> Section {
    let robot = Robot::printed();
    let (smallest, dependence) = singular();
    let determinants = greatest(
        (0..=SAMPLES)
            .map(|k| determinant(&robot, Robot::printed_motion(k as f64 / SAMPLES as f64).pose)),
    );
    let reversed = PRINTED_LOAD.map(|part| -part);
    let [none, printed, turned] = [NO_LOAD, PRINTED_LOAD, reversed].map(missing);
    let time = |k: usize| k as f64 / 200.0;
    let line = |load: Load| -> Vec<(f64, f64)> {
        let at =
            |k: usize| (time(k), missing_moment(&robot, &Robot::printed_motion(time(k)), load));
        (0..=200).map(at).collect()
    };
    let engine = match by_engine {
        stiction_run::Error::CannotCarry(missing) => {
            let (least, most) = missing.range;
            format!(
                "{least:.2} to {most:.2} {}, at {} of {} samples",
                missing.unit, missing.samples, missing.of
            )
        }
        other => other.to_string(),
    };
    let motion = Robot::printed_motion(0.25);
    let of_load = |load: Load, name: &'static str| {
        let system = System::new(&robot, &motion, load, Form::Corrected);
        let single = system.of_single_bodies(&robot);
        let row = |how: &'static str, drives: [f64; 3]| {
            [
                Cell::from(name),
                Cell::from(how),
                fixed(drives[0], 2),
                fixed(drives[1], 2),
                fixed(drives[2], 2),
            ]
        };
        [
            row("(22) to (27), lengths in m", least_squares(&system, 1.0, false).0),
            row("(22) to (27), lengths in mm", least_squares(&system, 1e3, false).0),
            row("the same, for single bodies, m", least_squares(&single, 1.0, false).0),
            row("the same, for single bodies, mm", least_squares(&single, 1e3, false).0),
            row(
                "(22) to (27) without the platform's M<sub>y</sub>",
                least_squares(&system, 1.0, true).0,
            ),
            row("(21), lengths in m", planar_least_squares(&robot, &motion, load, 1.0)),
            row("(21), lengths in mm", planar_least_squares(&robot, &motion, load, 1e3)),
        ]
    };
    let squares: Vec<_> =
        of_load(NO_LOAD, "none").into_iter().chain(of_load(PRINTED_LOAD, "printed")).collect();
    let force_panel = |i: usize, label: &str| {
        let without: Vec<(f64, f64)> = (0..=200)
            .map(|k| {
                let motion = Robot::printed_motion(time(k));
                (time(k), generalised_force(&robot, Printed::NONE, &motion)[i])
            })
            .collect();
        let [none, plus, minus] = STRESSES.map(|f| -> Vec<(f64, f64)> {
            let at = |k: usize| {
                let motion = Robot::printed_motion(time(k));
                Some((time(k), with_friction(&robot, &motion, NO_LOAD, f)?.0[i]))
            };
            (0..=200).filter_map(at).collect()
        });
        panel(
            label,
            [
                ("without friction", 0, false, without),
                ("with friction, f = 0", 1, true, none),
                ("f = 50 N", 2, true, plus),
                ("f = −50 N", 3, true, minus),
            ],
        )
    };
    let balances = [0.02, 0.1, 0.2, 0.3, 0.4].map(|time| {
        let motion = Robot::printed_motion(time);
        let missing = |f: f64| {
            with_friction(&robot, &motion, NO_LOAD, f)
                .map_or(Cell::Empty, |found| fixed(found.1, 3))
        };
        [
            fixed(time, 2),
            fixed(missing_moment(&robot, &motion, NO_LOAD), 3),
            missing(0.0),
            missing(50.0),
            missing(-50.0),
            missing(200.0),
        ]
    });
    let external = generalised_load(PRINTED_LOAD);
    let blocks = vec![
        equation("29", "x = 5 sin 2πt,  z = 10 cos 2πt,  θ = 90°  (mm)"),
        paragraph(
            "z must be meant relative to zero input, z = 505 + 10 cos 2πt; otherwise the platform \
             would pass through the plane of the base. Along this motion:",
        ),
        wrong(format!(
            "The determinant of J<sup>−1</sup> is zero at every instant (multiplied by the leg \
             lengths, at most {} m³; smallest singular value at most {}; ρ<sub>2</sub> row 2 + \
             ρ<sub>3</sub> row 3 = 2 ρ<sub>1</sub> row 1 to {}). Viewed along y, the lines of the \
             three legs intersect in one point, 1.5 (x, z), about which no driving force has a \
             moment. (21) does not exist along this motion.",
            rounding(determinants),
            rounding(smallest),
            rounding(dependence),
        )),
        table(
            "simulation-near",
            "Result of (21) at t = 0.25 s without load, as θ approaches 90°: it is inversely \
             proportional to the distance from 90°.",
            [("θ − 90°", "deg"), ("largest driving force", "N")],
            [1.0, 0.1, 0.01, 0.001].map(|degrees| {
                [digits(degrees, 1), digits(near_singular(degrees).unwrap_or(f64::INFINITY), 4)]
            }),
        ),
        equation(
            "",
            "a resultant (F<sub>x</sub>, F<sub>z</sub>, M<sub>y</sub>) at O<sub>2</sub> can be \
             balanced only if  M<sub>y</sub> + k z F<sub>x</sub>/(k − l) − k x F<sub>z</sub>/(k − \
             l) = 0",
        ),
        wrong(format!(
            "The printed load, 100 N and 80 N m along every axis, violates this condition at every \
             instant: without friction, {:.1} to {:.1} N m about y remain unbalanced for any \
             driving forces ({:.1} to {:.2} N m if the sign of the load is reversed). Even without \
             a load, the inertia of the robot leaves up to {:.2} N m unbalanced; only t = 0, 0.5 \
             and 1 s can be balanced.",
            printed.0.abs().min(printed.1.abs()),
            printed.0.abs().max(printed.1.abs()),
            turned.0.abs().min(turned.1.abs()),
            turned.0.abs().max(turned.1.abs()),
            greatest([none.0, none.1]),
        )),
        right(format!(
            "The general engine rejects this case with the same numbers: `stiction inverse \
             zhang2018` finds no finite driving forces and reports the unbalanced moment: {engine}.",
        )),
        curves(
            "simulation-missing",
            "Printed robot along (29): moment that no driving force can balance",
            vec![
                panel("printed load [N m]", [("missing", 1, false, line(PRINTED_LOAD))]),
                panel("no load [N m]", [("missing", 1, false, line(NO_LOAD))]),
            ],
            "The moment about y at O<sub>2</sub> that no driving force balances.",
        ),
        wrong(
            "Least squares do not solve the problem. Programs that solve singular systems by a \
             pseudo-inverse return numbers without a warning, but these numbers depend on the unit \
             of length and on the reference points of the moments. A result that depends on the \
             unit of length has no physical meaning.",
        ),
        table(
            "simulation-least-squares",
            "Driving forces by least squares with least norm at t = 0.25 s. The seven variants \
             give different results, and none of them moves the robot.",
            [
                ("load", ""),
                ("solved", ""),
                ("τ<sub>1</sub>", "N"),
                ("τ<sub>2</sub>", "N"),
                ("τ<sub>3</sub>", "N"),
            ],
            squares,
        ),
        paragraph(format!(
            "The generalised forces F of the motion exist along (29), because they require no \
             inverse. The printed load reduces them by (F<sub>x</sub>, F<sub>z</sub>, \
             M<sub>θ</sub>) = ({:.0} N, {:.0} N, −{:.0} N m). With friction, even F is not \
             determined, because the normal loads of the P and S joints contain the undetermined \
             force f of section 4. The dashed curves assume that an additional support carries the \
             unbalanced moment about y; the other 41 equations then have one solution for each f.",
            external[0], external[1], -external[2],
        )),
        curves(
            "simulation-forces",
            "Printed robot along (29): generalised forces without load",
            vec![force_panel(0, "Fx [N]"), force_panel(1, "Fz [N]"), force_panel(2, "Mθ [N m]")],
            "Generalised forces of the platform along (29) without friction, and with friction for \
             three self-stresses f, among which the printed model does not decide.",
        ),
        paragraph(
            "Friction does not solve the problem. Friction contributes to the balance about y \
             through the torques in the ball joints, and so does f: at some instants, some values \
             of f satisfy the balance; at others, no value does.",
        ),
        table(
            "simulation-balance",
            "Unbalanced moment about y along (29) without load: without friction, and with \
             friction for several values of f.",
            [
                ("time", "s"),
                ("without friction", "N m"),
                ("f = 0", "N m"),
                ("f = 50 N", "N m"),
                ("f = −50 N", "N m"),
                ("f = 200 N", "N m"),
            ],
            balances,
        ),
        paragraph(
            "Prescribed leg lengths do not determine the motion either. At an actuation \
             singularity, the forward kinematics has a fold: if leg 1 is slightly longer than \
             along (29), the loops do not close; if it is slightly shorter, the platform has two \
             possible positions.",
        ),
        table(
            "simulation-fold",
            "Positions of the platform for the leg lengths of (29) at t = 0, with small changes of \
             leg 1.",
            [("leg 1", "µm"), ("positions", ""), ("x off by", "mm"), ("θ off by", "deg")],
            folds(&robot),
        ),
        open(
            "How could a multibody program compute curves for this case? Not with the printed \
             model and actuated legs, because nothing balances the moment and the position has a \
             fold. It is possible if another element carries the moment: a motion generator that \
             remains on the platform (the paper says “motion excitation is applied at the \
             geometric centre”), bushings, or a model with another geometry.",
        ),
    ];
    section("simulation", "The simulation: equation (29)", blocks)
}
