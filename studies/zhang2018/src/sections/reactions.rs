//! Section 4 of the paper: 42 equations for all joint reactions.

use super::{
    count_range, digits, equation, fixed, greatest, note, paragraph, power_of_ten, right, rounding,
    section, table, wrong,
};
use crate::engine::Sample;
use crate::lagrangian::{Printed, driving_forces};
use crate::reactions::{Form, NAMES, OF_LEG, SIZE, System, unknown};
use crate::report::{Cell, Section};
use crate::robot::{Motion, NO_LOAD, Robot};
use crate::screws::NEGLIGIBLE;
use crate::simulation::out_of_range;
use nalgebra::DVector;
use stiction_core::linalg::Svd;

/// Ranks of the 42 equations and their two smallest singular values, SI units, over a set of
/// motions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ranks {
    pub(crate) rank: (usize, usize),
    /// Minimum and maximum of the second-smallest singular value.
    pub(crate) before_last: (f64, f64),
    /// Minimum and maximum of the smallest singular value.
    pub(crate) last: (f64, f64),
}

/// Computes the ranks over motions.
pub(crate) fn ranks(robot: &Robot, form: Form, motions: &mut dyn Iterator<Item = Motion>) -> Ranks {
    let mut found = Ranks {
        rank: (usize::MAX, 0),
        before_last: (f64::INFINITY, 0.0),
        last: (f64::INFINITY, 0.0),
    };
    for motion in motions {
        let svd = Svd::new(&System::new(robot, &motion, NO_LOAD, form).matrix);
        let rank = svd.rank(NEGLIGIBLE);
        found.rank = (found.rank.0.min(rank), found.rank.1.max(rank));
        let widen = |known: &mut (f64, f64), value: f64| {
            *known = (known.0.min(value), known.1.max(value));
        };
        widen(&mut found.before_last, svd.singular_values[SIZE - 2]);
        widen(&mut found.last, svd.singular_values[SIZE - 1]);
    }
    found
}

/// Poses at rest, spread evenly over a box around the workspace.
fn at_rest(count: usize) -> impl Iterator<Item = Motion> {
    let still = |pose| Motion { pose, rate: [0.0; 3], acceleration: [0.0; 3] };
    super::structure::poses(count).map(still)
}

fn along(motion: fn(f64) -> Motion, count: usize) -> impl Iterator<Item = Motion> {
    (0..count).map(move |k| motion(k as f64 / (count - 1) as f64))
}

/// Null vector of the printed robot's equations on (29), scaled so that leg 1 carries -2 along y,
/// and its largest component that is neither a force along y nor a consequence of one within the
/// leg.
pub(crate) fn null_vector(time: f64) -> Option<(DVector<f64>, f64)> {
    let motion = Robot::printed_motion(time);
    let svd = Svd::new(&System::new(&Robot::printed(), &motion, NO_LOAD, Form::Corrected).matrix);
    let [null] = svd.null_space(SIZE - 1).try_into().ok()?;
    let null: DVector<f64> = &null * (-2.0 / null[unknown::FS + 1]);
    // A force along y causes forces along y and moments about t and u.
    let allowed = [1, 3, 4, 6, 7, 9, 12];
    let rest = greatest((0..SIZE).filter(|i| !allowed.contains(&(i % OF_LEG))).map(|i| null[i]));
    Some((null, rest))
}

/// Error of the transverse force F_S,t by the printed equation (23): for each leg the largest
/// error, N, and the largest force, N.
pub(crate) fn transverse(
    robot: &Robot,
    motion: fn(f64) -> Motion,
    count: usize,
) -> ([f64; 3], [f64; 3]) {
    let mut worst = ([0.0_f64; 3], [0.0_f64; 3]);
    for motion in along(motion, count + 1).take(count) {
        let of = |form: Form| {
            let system = System::new(robot, &motion, NO_LOAD, form);
            [0, 1, 2].map(|n| system.across(n))
        };
        let (printed, corrected) = (of(Form::Printed), of(Form::Corrected));
        for n in 0..3 {
            worst.0[n] = worst.0[n].max((printed[n] - corrected[n]).abs());
            worst.1[n] = worst.1[n].max(corrected[n].abs());
        }
    }
    worst
}

/// Largest difference between the 42 equations and the engine for the frictionless regular variant,
/// over all unknowns, and the largest unknown; N and N m together.
pub(crate) fn agreement(frictionless: &[Sample]) -> (f64, f64) {
    let robot = Robot::regular();
    let mut worst = (0.0_f64, 0.0_f64);
    for sample in frictionless {
        let motion = Robot::regular_motion(sample.time);
        let system = System::new(&robot, &motion, NO_LOAD, Form::Corrected);
        let Some(own) = system.matrix.clone().lu().solve(&system.right) else {
            return (f64::INFINITY, 0.0);
        };
        for n in 0..3 {
            let leg = System::of_leg(&own, n);
            let differences = leg.iter().zip(&sample.unknowns[n]).map(|(a, b)| a - b);
            worst.0 = worst.0.max(greatest(differences));
            worst.1 = worst.1.max(greatest(leg));
        }
    }
    worst
}

const POSES: usize = 500;

pub(crate) fn write(frictionless: &[Sample]) -> Section {
    let (printed, regular) = (Robot::printed(), Robot::regular());
    let twin = ranks(&regular, Form::Corrected, &mut along(Robot::regular_motion, 101));
    let on_printed_motion = |form| ranks(&printed, form, &mut along(Robot::printed_motion, 101));
    let cases = [
        ("as printed, along (29), literally", on_printed_motion(Form::Literal)),
        ("as printed, along (29), with F′<sub>R</sub> added", on_printed_motion(Form::Printed)),
        ("as printed, along (29), corrected", on_printed_motion(Form::Corrected)),
        ("as printed, 500 poses, corrected", ranks(&printed, Form::Corrected, &mut at_rest(POSES))),
        ("regular twin, along its motion, corrected", twin),
        (
            "regular twin, 500 poses, corrected",
            ranks(&regular, Form::Corrected, &mut at_rest(POSES)),
        ),
    ];
    let on_29 = transverse(&printed, Robot::printed_motion, 400);
    let on_twin = transverse(&regular, Robot::regular_motion, 400);
    let (difference, largest) = agreement(frictionless);
    let null = [0.0, 0.13, 0.25, 0.5].map(|time| (time, null_vector(time)));
    let rest = greatest(null.iter().filter_map(|(_, null)| null.as_ref().map(|n| n.1)));
    let stresses = null.iter().flat_map(|(time, null)| {
        null.iter().map(|(vector, _)| {
            let leg = |n: usize, i: usize| vector[OF_LEG * n + i];
            [
                fixed(*time, 2),
                fixed(leg(0, unknown::FS + 1), 6),
                fixed(leg(1, unknown::FS + 1), 6),
                fixed(leg(2, unknown::FS + 1), 6),
                fixed(leg(0, unknown::MR), 4),
                fixed(leg(0, unknown::MP), 4),
            ]
        })
    });
    let stresses: Vec<_> = stresses.collect();
    let spread = twin.last;
    let arms = [0, 1].map(|n| 1e3 * (printed.home[n] / 2.0 - printed.rod_com));
    let blocks = vec![
        paragraph(
            "Forces and moments on each leg as a whole, on its rod, and on the platform, by \
             D’Alembert's principle, with 14 unknowns per leg. With complete inertia forces, these \
             equations are:",
        ),
        equation(
            "22",
            "F<sub>S</sub> + F<sub>R</sub> = m<sub>i</sub> (a<sub>i</sub> − g) + m<sub>j</sub> (a<sub>j</sub> − g)",
        ),
        equation(
            "23",
            "ρ u × F<sub>S</sub> + M<sub>R</sub> = p u × m<sub>i</sub> (a<sub>i</sub> − g) + (ρ − m) u × m<sub>j</sub> (a<sub>j</sub> − g) + (J<sub>i</sub> + J<sub>j</sub>) α̈ e<sub>y</sub>",
        ),
        equation("24", "F<sub>S</sub> + F<sub>P</sub> + τ u = m<sub>j</sub> (a<sub>j</sub> − g)"),
        equation(
            "25",
            "(S − P) × F<sub>S</sub> + M<sub>P</sub> = (G<sub>j</sub> − P) × m<sub>j</sub> (a<sub>j</sub> − g) + J<sub>j</sub> α̈ e<sub>y</sub>",
        ),
        equation("26", "−Σ F<sub>S,n</sub> = m<sub>d</sub> (a − g) − F<sub>load</sub>"),
        equation(
            "27",
            "−Σ (S<sub>n</sub> − O<sub>2</sub>) × F<sub>S,n</sub> = J<sub>d</sub> β̈ e<sub>y</sub> − M<sub>load</sub>",
        ),
        wrong(format!(
            "(22) lacks F′<sub>R</sub>, which is defined below it, and the inertia force of the \
             base. Its F′<sub>fj</sub> is not defined and can only be F<sub>lj</sub>, which \
             contains only the axial part of the inertia force of the rod. The printed matrix \
             R<sub>α</sub> is the transpose of the correct one: it maps the axis of the leg to \
             (−cos φ, 0, sin φ). (23) and (25) lack the lever arms of the inertia forces, and the \
             sign of their moments according to D’Alembert's principle; the lever arm of the \
             weight of a base is L<sub>i</sub>/2 = (ρ − 2m)/2, {:.0} to {:.0} mm at zero input, \
             instead of p = 174.65 mm. In (27), the sign of M<sub>lk</sub> is also wrong, β̈ is \
             printed as β, and I<sub>k</sub> is missing from R<sub>β</sub> I<sub>k</sub> \
             R<sub>β</sub><sup>T</sup>. Cross products are printed without a sign throughout. (26) \
             is right.",
            arms[0], arms[1],
        )),
        table(
            "reactions-transverse",
            "Force perpendicular to the leg at the ball joint, F<sub>S,t</sub>, by (23) as \
             printed: largest error and largest force.",
            [
                ("", ""),
                ("leg 1, error", "N"),
                ("of", "N"),
                ("leg 2, error", "N"),
                ("of", "N"),
                ("leg 3, error", "N"),
                ("of", "N"),
            ],
            [("printed robot, (29)", on_29), ("regular twin", on_twin)].map(
                |(name, (error, of))| {
                    [
                        Cell::from(name),
                        fixed(error[0], 2),
                        fixed(of[0], 2),
                        fixed(error[1], 2),
                        fixed(of[1], 2),
                        fixed(error[2], 2),
                        fixed(of[2], 2),
                    ]
                },
            ),
        ),
        table(
            "reactions-printed",
            "The system as printed, with F′<sub>R</sub> added and the axes of the legs corrected, \
             compared with the fully corrected system, for the regular twin without load and \
             friction: largest error of each unknown in any leg, and its largest value.",
            [("unknown", ""), ("error", "N"), ("of", "N")],
            printed_errors(&regular)
                .map(|(name, error, of)| [name.into(), fixed(error, 1), fixed(of, 1)]),
        ),
        wrong(
            "“42 independent equations”: the number is right, 42 equations for 42 unknowns, but \
             the equations are not independent in any pose of the printed robot. No correction of \
             the right-hand sides changes this, because the rank depends on the geometry only.",
        ),
        table(
            "reactions-rank",
            "Rank of the 42 equations, and the two smallest singular values (SI units). In the \
             first row, (22) is used literally, without F′<sub>R</sub>: nine unknowns then occur \
             in no equation.",
            [
                ("", ""),
                ("rank", ""),
                ("σ<sub>41</sub>, least", ""),
                ("σ<sub>41</sub>, greatest", ""),
                ("σ<sub>42</sub>, least", ""),
                ("σ<sub>42</sub>, greatest", ""),
            ],
            cases.map(|(name, ranks)| {
                [
                    Cell::from(name),
                    count_range(ranks.rank).into(),
                    digits(ranks.before_last.0, 2),
                    digits(ranks.before_last.1, 2),
                    digits(ranks.last.0, 2),
                    digits(ranks.last.1, 2),
                ]
            }),
        ),
        paragraph(format!(
            "The missing equation leaves one internal force undetermined: f times the following \
             vector, which consists of forces along y in the three legs and of the moments by \
             which the joints transmit them (all other unknowns are at most {}). No external \
             measurement determines f, but the normal loads of the P and S joints, and therefore \
             their friction, depend on it.",
            rounding(rest),
        )),
        table(
            "reactions-null",
            "The null vector along (29), scaled to −2 in leg 1. Moments in N m for f in N.",
            [
                ("time", "s"),
                ("F<sub>Sy,1</sub>", ""),
                ("F<sub>Sy,2</sub>", ""),
                ("F<sub>Sy,3</sub>", ""),
                ("M<sub>Rt,1</sub>", "m"),
                ("M<sub>Pt,1</sub>", "m"),
            ],
            stresses,
        ),
        paragraph(
            "The left null vector shows which loads cannot be balanced: a load parallel to it has \
             no solution, a load perpendicular to it has one. If θ differs from 90°, this vector \
             is mainly a moment about y, with a component M<sub>x</sub>. It corresponds to the \
             roll, which neither constraints nor actuators prevent. (21) does not contain the roll \
             and therefore contradicts the 42 equations: if θ differs from 90°, (21) has a \
             solution, and the 42 equations have none.",
        ),
        table(
            "reactions-range",
            "The load for which the 42 equations of the printed robot have no solution, relative \
             to its largest component, at the pose of (29) at t = 0.13 s but with other angles θ; \
             the distance of weight and inertia forces from a solution, in the same scale; and the \
             result of (21).",
            [
                ("θ", "deg"),
                ("F<sub>x</sub>", ""),
                ("F<sub>y</sub>", ""),
                ("F<sub>z</sub>", ""),
                ("M<sub>x</sub>", ""),
                ("M<sub>y</sub>", ""),
                ("M<sub>z</sub>", ""),
                ("missed by", "N m"),
                ("largest τ of (21)", "N"),
            ],
            range_rows(&printed),
        ),
        right(format!(
            "For the regular twin, the corrected equations have a unique solution (σ<sub>42</sub> \
             from {:.3} to {:.3}), and the general engine agrees with it: over {} instants and all \
             42 unknowns, the two differ by at most {} of {largest:.0} (N and N m).",
            spread.0,
            spread.1,
            frictionless.len(),
            power_of_ten(difference, 2),
        )),
        note(
            "M<sub>P</sub> depends on the reference point P, which the paper does not define; here \
             P is fixed in the base, 349.3 mm from R. Forces and driving forces do not depend on \
             this choice.",
        ),
        table(
            "reactions-twin",
            "All unknowns of the regular twin at t = 0.3 s, without load and friction, by the 42 \
             equations, and their differences from the general engine.",
            [
                ("", ""),
                ("unit", ""),
                ("leg 1", ""),
                ("leg 2", ""),
                ("leg 3", ""),
                ("largest difference", ""),
            ],
            unknowns(frictionless),
        ),
    ];
    section("reactions", "Joint reactions: equations (22) to (27)", blocks)
}

/// Largest errors of the [`Form::Printed`] system, and largest values, N: actuator forces and the
/// forces at S, P and R.
pub(crate) fn printed_errors(robot: &Robot) -> [(&'static str, f64, f64); 4] {
    let mut found = [
        ("τ", 0.0_f64, 0.0_f64),
        ("F<sub>S</sub>", 0.0, 0.0),
        ("F<sub>P</sub>", 0.0, 0.0),
        ("F<sub>R</sub>", 0.0, 0.0),
    ];
    let places = [
        unknown::TAU..unknown::FS,
        unknown::FS..OF_LEG,
        unknown::FP..unknown::MP,
        unknown::FR..unknown::MR,
    ];
    for motion in along(Robot::regular_motion, 101) {
        let solve = |form: Form| {
            let system = System::new(robot, &motion, NO_LOAD, form);
            system.matrix.clone().lu().solve(&system.right)
        };
        let (Some(printed), Some(corrected)) = (solve(Form::Printed), solve(Form::Corrected))
        else {
            continue;
        };
        for n in 0..3 {
            let (wrong, right) = (System::of_leg(&printed, n), System::of_leg(&corrected, n));
            for ((_, error, of), places) in found.iter_mut().zip(&places) {
                *error = error.max(greatest(places.clone().map(|i| wrong[i] - right[i])));
                *of = of.max(greatest(places.clone().map(|i| right[i])));
            }
        }
    }
    found
}

fn range_rows(robot: &Robot) -> Vec<[Cell; 9]> {
    let row = |degrees: f64| {
        let mut motion = Robot::printed_motion(0.13);
        motion.pose[2] = degrees.to_radians();
        let (null, missed) = out_of_range(robot, &motion, NO_LOAD)?;
        let drives = driving_forces(robot, Printed::NONE, &motion, NO_LOAD);
        let [fx, fy, fz, mx, my, mz] = null.map(|x| fixed(x, 4));
        let drives = drives.map_or(Cell::from("none"), |drives| fixed(greatest(drives), 1));
        Some([fixed(degrees, 0), fx, fy, fz, mx, my, mz, fixed(missed, 3), drives])
    };
    [70.0, 80.0, 85.0, 89.0, 90.0].into_iter().filter_map(row).collect()
}

fn unknowns(frictionless: &[Sample]) -> Vec<[Cell; 6]> {
    let Some(sample) = frictionless.iter().find(|s| (s.time - 0.3).abs() < 1e-9) else {
        return Vec::new();
    };
    let motion = Robot::regular_motion(sample.time);
    let system = System::new(&Robot::regular(), &motion, NO_LOAD, Form::Corrected);
    let Some(own) = system.matrix.clone().lu().solve(&system.right) else { return Vec::new() };
    let legs: Vec<_> = (0..3).map(|n| System::of_leg(&own, n)).collect();
    let row = |(i, (name, unit)): (usize, &(&str, &str))| {
        let difference = greatest((0..3).map(|n| legs[n][i] - sample.unknowns[n][i]));
        [
            Cell::from(*name),
            Cell::from(*unit),
            fixed(legs[0][i], 4),
            fixed(legs[1][i], 4),
            fixed(legs[2][i], 4),
            digits(difference, 2),
        ]
    };
    NAMES.iter().enumerate().map(row).collect()
}
