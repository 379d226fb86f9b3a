//! Section 4 of the paper: 42 equations for all joint reactions.

use super::{
    digits, equation, fixed, greatest, note, paragraph, power_of_ten, right, rounding, section,
    table, wrong,
};
use crate::report::{Cell, Section};
use crate::zhang2018::engine::Sample;
use crate::zhang2018::reactions::{Form, NAMES, OF_LEG, SIZE, System, unknown};
use crate::zhang2018::robot::{Motion, NO_LOAD, Robot};
use crate::zhang2018::screws::NEGLIGIBLE;
use nalgebra::DVector;
use stiction::linalg::Svd;

/// Ranks of the 42 equations and their two smallest singular values, SI units, over some motions.
#[derive(Clone, Copy, Debug)]
pub(in crate::zhang2018) struct Ranks {
    pub(in crate::zhang2018) rank: (usize, usize),
    /// The least and the greatest of the last but one.
    pub(in crate::zhang2018) before_last: (f64, f64),
    /// The least and the greatest of the last.
    pub(in crate::zhang2018) last: (f64, f64),
}

/// Ranks over motions.
pub(in crate::zhang2018) fn ranks(
    robot: &Robot,
    form: Form,
    motions: &mut dyn Iterator<Item = Motion>,
) -> Ranks {
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

/// Poses at rest, spread evenly over a box about the workspace.
fn at_rest(count: usize) -> impl Iterator<Item = Motion> {
    let still = |pose| Motion { pose, rate: [0.0; 3], acceleration: [0.0; 3] };
    super::structure::poses(count).map(still)
}

fn along(motion: fn(f64) -> Motion, count: usize) -> impl Iterator<Item = Motion> {
    (0..count).map(move |k| motion(k as f64 / (count - 1) as f64))
}

/// The null vector of the printed robot's equations on (29), scaled so that leg 1 carries -2 along y,
/// and the largest part of it that is neither a force along y nor what such a force makes in its leg.
pub(in crate::zhang2018) fn null_vector(time: f64) -> Option<(DVector<f64>, f64)> {
    let motion = Robot::printed_motion(time);
    let svd = Svd::new(&System::new(&Robot::printed(), &motion, NO_LOAD, Form::Corrected).matrix);
    let [null] = svd.null_space(SIZE - 1).try_into().ok()?;
    let null: DVector<f64> = &null * (-2.0 / null[unknown::FS + 1]);
    // A force along y loads forces along y and moments about t and u.
    let allowed = [1, 3, 4, 6, 7, 9, 12];
    let rest = greatest((0..SIZE).filter(|i| !allowed.contains(&(i % OF_LEG))).map(|i| null[i]));
    Some((null, rest))
}

/// The error of the transverse force F~S,t~ by the printed equation (23): for each leg the largest, N,
/// and the largest force.
pub(in crate::zhang2018) fn transverse(
    robot: &Robot,
    motion: fn(f64) -> Motion,
    count: usize,
) -> ([f64; 3], [f64; 3]) {
    let mut worst = ([0.0_f64; 3], [0.0_f64; 3]);
    for motion in along(motion, count + 1).take(count) {
        // The y component of (23) holds nothing else that is unknown.
        let of = |form: Form| {
            let system = System::new(robot, &motion, NO_LOAD, form);
            let at = |n: usize| {
                let (row, column) = (12 * n + 4, OF_LEG * n + unknown::FS);
                system.right[row] / system.matrix[(row, column)]
            };
            [at(0), at(1), at(2)]
        };
        let (printed, corrected) = (of(Form::Printed), of(Form::Corrected));
        for n in 0..3 {
            worst.0[n] = worst.0[n].max((printed[n] - corrected[n]).abs());
            worst.1[n] = worst.1[n].max(corrected[n].abs());
        }
    }
    worst
}

/// The largest difference between the 42 equations and the engine on the regular twin without friction,
/// over all unknowns, and the largest unknown; N and N m together.
pub(in crate::zhang2018) fn agreement(frictionless: &[Sample]) -> (f64, f64) {
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

fn told((least, greatest): (usize, usize)) -> String {
    if least == greatest { least.to_string() } else { format!("{least} to {greatest}") }
}

const POSES: usize = 500;

pub(in crate::zhang2018) fn write(frictionless: &[Sample]) -> Section {
    let (printed, regular) = (Robot::printed(), Robot::regular());
    let cases: [(&str, &Robot, Form, Ranks); 6] = [
        ("as printed, along (29), to the letter", &printed, Form::Literal),
        ("as printed, along (29), F′~R~ put back", &printed, Form::Printed),
        ("as printed, along (29), corrected", &printed, Form::Corrected),
        ("as printed, 500 poses, corrected", &printed, Form::Corrected),
        ("regular twin, along its motion, corrected", &regular, Form::Corrected),
        ("regular twin, 500 poses, corrected", &regular, Form::Corrected),
    ]
    .map(|(name, robot, form)| {
        let ranks = if name.contains("poses") {
            ranks(robot, form, &mut at_rest(POSES))
        } else if robot.home == printed.home {
            ranks(robot, form, &mut along(Robot::printed_motion, 101))
        } else {
            ranks(robot, form, &mut along(Robot::regular_motion, 101))
        };
        (name, robot, form, ranks)
    });
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
    let spread = cases[4].3.last;
    let arms = [0, 1].map(|n| 1e3 * (printed.home[n] / 2.0 - printed.rod_com));
    let blocks = vec![
        paragraph(
            "For each leg as a whole, for its rod and for the platform, forces and moments by D’Alembert, 14 unknowns a \
             leg. With the inertia forces complete and all products written out they are:",
        ),
        equation("22", "F~S~ + F~R~ = m~i~ (a~i~ − g) + m~j~ (a~j~ − g)"),
        equation(
            "23",
            "ρ u × F~S~ + M~R~ = p u × m~i~ (a~i~ − g) + (ρ − m) u × m~j~ (a~j~ − g) + (J~i~ + J~j~) α̈ e~y~",
        ),
        equation("24", "F~S~ + F~P~ + τ u = m~j~ (a~j~ − g)"),
        equation("25", "(S − P) × F~S~ + M~P~ = (G~j~ − P) × m~j~ (a~j~ − g) + J~j~ α̈ e~y~"),
        equation("26", "−Σ F~S,n~ = m~d~ (a − g) − F~load~"),
        equation("27", "−Σ (S~n~ − O~2~) × F~S,n~ = J~d~ β̈ e~y~ − M~load~"),
        wrong(format!(
            "(22) lacks F′~R~ and the base's inertia, though both are defined below it; F~lj~ has the axial part only of \
             the rod's inertia force. The printed matrix R~α~ is the transposed one: it takes the leg's axis to \
             (−cos φ, 0, sin φ). (23) and (25) lack the arms of the inertia forces and the sign that D’Alembert's \
             principle gives their moments; the arm of a base's weight is L~i~/2 = (ρ − 2m)/2, {:.0} to \
             {:.0} mm at zero input, and not p = 174.65 mm. In (27) β̈ is printed as β, and I~k~ is missing from \
             R~β~ I~k~ R~β~^T^.",
            arms[0], arms[1],
        )),
        table(
            "reactions-transverse",
            "What the printed (23) makes of the force across the leg at the ball, F~S,t~: largest error and largest force.",
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
        wrong(
            "“42 independent equations”: the count is right, 42 for 42 unknowns; independent they are not, in any \
             pose of the printed robot. No correction of the right-hand sides changes that: the rank is one of geometry.",
        ),
        table(
            "reactions-rank",
            "Rank of the 42 equations, and the last two singular values (SI units). Literal is (22) without F′~R~: \
             nine unknowns stand in no equation.",
            [
                ("", ""),
                ("rank", ""),
                ("σ~41~, least", ""),
                ("σ~41~, greatest", ""),
                ("σ~42~, least", ""),
                ("σ~42~, greatest", ""),
            ],
            cases.map(|(name, _, _, ranks)| {
                [
                    Cell::from(name),
                    told(ranks.rank).into(),
                    digits(ranks.before_last.0, 2),
                    digits(ranks.before_last.1, 2),
                    digits(ranks.last.0, 2),
                    digits(ranks.last.1, 2),
                ]
            }),
        ),
        paragraph(format!(
            "The missing equation leaves one internal force free: f times the vector below, forces along y in the three \
             legs and the moments with which the joints pass them on (all other unknowns at most {}). Nothing that \
             is measured outside tells f, and every load of a joint, hence every friction of section 5, contains it.",
            rounding(rest),
        )),
        table(
            "reactions-null",
            "The null vector along (29), scaled to −2 in leg 1. Moments in N m for f in N.",
            [
                ("time", "s"),
                ("F~Sy,1~", ""),
                ("F~Sy,2~", ""),
                ("F~Sy,3~", ""),
                ("M~Rt,1~", "m"),
                ("M~Pt,1~", "m"),
            ],
            stresses,
        ),
        right(format!(
            "For the regular twin the corrected equations have one solution (σ~42~ from {:.3} to {:.3}), and the general \
             engine finds it: over {} instants and all 42 unknowns the two differ by at most {} of {largest:.0} \
             (N and N m).",
            spread.0,
            spread.1,
            frictionless.len(),
            power_of_ten(difference, 2),
        )),
        note(
            "M~P~ depends on the point P at which it is stated, which the paper leaves to the reader; here P is fixed in the \
             base, 349.3 mm from R. Forces and driving forces do not depend on it.",
        ),
        table(
            "reactions-twin",
            "All unknowns of the regular twin at t = 0.3 s, no load, no friction: by the 42 equations, and their \
             difference from the general engine.",
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
