//! Section 2 of the paper: positions and rates.

use super::{digits, equation, fixed, greatest, paragraph, right, rounding, section, table, wrong};
use crate::friction::OfJoints;
use crate::kinematics::{determinant, inverse_jacobian, joint_rates, leg_angle};
use crate::report::{Cell, Section};
use crate::robot::{Motion, Robot, leg_lengths};
use core::f64::consts::FRAC_PI_2;
use nalgebra::Matrix3;

/// Largest differences between closed form and engine along a motion: leg lengths, m, and rates of
/// the nine joints, m/s and rad/s.
pub(crate) fn agreement(
    robot: &Robot,
    motion: fn(f64) -> Motion,
    engine: &[(f64, [f64; 3], OfJoints)],
) -> (f64, f64) {
    let mut worst = (0.0_f64, 0.0_f64);
    for (time, lengths, rates) in engine {
        let motion = motion(*time);
        let (own, own_rates) = (leg_lengths(robot, motion.pose), joint_rates(robot, &motion));
        for n in 0..3 {
            worst.0 = worst.0.max((own[n] - lengths[n]).abs());
            worst.1 = worst.1.max(greatest((0..3).map(|j| own_rates[n][j] - rates[n][j])));
        }
    }
    worst
}

/// One datum of section 6 and its consequences for leg 2 at zero input.
pub(crate) struct Datum {
    pub(crate) stated: &'static str,
    /// l - k, m; z of the balls, m; length of leg 2, m; its angle, deg.
    pub(crate) implied: [f64; 4],
}

/// Consequences of each geometric datum in isolation from the others.
pub(crate) fn data() -> [Datum; 5] {
    let (height, length, angle) = (0.505_f64, 0.543_16_f64, 109.82_f64.to_radians());
    let of_offset = |offset: f64, height: f64| {
        [offset, height, offset.hypot(height), height.atan2(-offset).to_degrees()]
    };
    [
        Datum { stated: "sides 900 and 300 mm, height 505 mm", implied: of_offset(0.3, height) },
        Datum {
            stated: "leg of 543.16 mm, height 505 mm",
            implied: of_offset((length * length - height * height).sqrt(), height),
        },
        Datum {
            stated: "109.82 deg, height 505 mm",
            implied: of_offset(-height / angle.tan(), height),
        },
        Datum {
            stated: "leg of 543.16 mm at 109.82 deg",
            implied: of_offset(-length * angle.cos(), length * angle.sin()),
        },
        Datum {
            stated: "l − k = 200 mm (from 543.16 mm) and 109.82 deg",
            implied: of_offset(0.2, -0.2 * angle.tan()),
        },
    ]
}

/// Largest relative difference between det(J^-1) times all leg lengths and its closed form.
pub(crate) fn determinant_misfit(robot: &Robot, count: usize) -> f64 {
    let scale = 2.0 * robot.k * robot.l * robot.l;
    greatest(super::structure::poses(count).map(|pose| {
        let rows = inverse_jacobian(robot, pose);
        let numeric = Matrix3::from_fn(|n, i| rows[n][i]).determinant()
            * leg_lengths(robot, pose).iter().product::<f64>();
        (numeric - determinant(robot, pose)) / scale
    }))
}

pub(crate) fn write(
    of_printed: &[(f64, [f64; 3], OfJoints)],
    of_twin: &[(f64, [f64; 3], OfJoints)],
) -> Section {
    let (printed, regular) = (Robot::printed(), Robot::regular());
    let first = agreement(&printed, Robot::printed_motion, of_printed);
    let second = agreement(&regular, Robot::regular_motion, of_twin);
    let misfit = determinant_misfit(&printed, 2000);
    let home = [0.0, 0.505, FRAC_PI_2];
    let angle = leg_angle(&printed, 1, home).to_degrees();
    let blocks = vec![
        equation("4", "R<sub>2</sub>S<sub>2</sub> = (x + k sin θ − l, 0, z − k cos θ)"),
        equation("5", "R<sub>1</sub>S<sub>1</sub> = (x, 0, z)"),
        equation("6", "R<sub>3</sub>S<sub>3</sub> = (x − k sin θ + l, 0, z + k cos θ)"),
        equation("7", "q<sub>n</sub> = |R<sub>n</sub>S<sub>n</sub>| − L<sub>n</sub>"),
        equation(
            "9-12",
            "G<sub>n1</sub> = S<sub>n</sub> − m u<sub>n</sub>,  u<sub>n</sub> = R<sub>n</sub>S<sub>n</sub> / |R<sub>n</sub>S<sub>n</sub>|",
        ),
        equation("13-15", "φ<sub>n</sub> = arccos(u<sub>n</sub> · e<sub>x</sub>)"),
        equation(
            "",
            "q̇ = J<sup>−1</sup> Ẋ,  row n of J<sup>−1</sup>: u<sub>n</sub> · ∂S<sub>n</sub>/∂(x, z, θ)",
        ),
        table(
            "kinematics-agreement",
            "Closed form compared with the general engine, which closes the loops numerically: \
             largest difference at 101 instants, over all three legs and all nine joints.",
            [("robot and motion", ""), ("leg lengths", "m"), ("rates of P, R and S", "m/s, rad/s")],
            [
                ["as printed, motion (29)".into(), digits(first.0, 2), digits(first.1, 2)],
                ["regular twin".into(), digits(second.0, 2), digits(second.1, 2)],
            ],
        ),
        right(
            "(4) to (7), (9) to (15) and J<sup>−1</sup> are right up to rounding, with two \
             restrictions: the arccos in (13) to (15) loses the sign of the angle if a ball joint \
             is below the base; and J, the inverse of J<sup>−1</sup>, exists only outside of the \
             singular surface given by the next equation.",
        ),
        equation(
            "",
            "ρ<sub>1</sub> ρ<sub>2</sub> ρ<sub>3</sub> det J<sup>−1</sup> = 2 k l cos θ [k (x cos θ + z sin θ) − l z]",
        ),
        wrong(format!(
            "At θ = 90°, the determinant is zero for every x, z, k and l, and equation (29) keeps \
             θ at 90°: multiplied by the leg lengths, the second and third rows of J<sup>−1</sup> \
             then add up to twice the first. (The closed form agrees with the numerical \
             determinant at 2000 poses to {} of 2 k l<sup>2</sup>.)",
            rounding(misfit),
        )),
        paragraph(format!(
            "The data of section 6 do not belong to a single robot. Each row of the table uses \
             other data of that section. The study uses the sides of 900 and 300 mm, which also \
             agree with the base angles of 30° in section 1 (√3 k = l tan 30°), and the height of \
             505 mm; this is the position of zero input, in which φ<sub>2</sub> is {angle:.2}°.",
        )),
        table(
            "kinematics-data",
            "What each datum implies for leg 2 at zero input, platform level. No two rows agree.",
            [
                ("stated", ""),
                ("l − k", "mm"),
                ("height of S<sub>2</sub>", "mm"),
                ("leg 2", "mm"),
                ("φ<sub>2</sub>", "deg"),
            ],
            data().map(|datum| {
                let [offset, height, length, angle] = datum.implied;
                [
                    Cell::from(datum.stated),
                    fixed(offset * 1e3, 2),
                    fixed(height * 1e3, 2),
                    fixed(length * 1e3, 2),
                    fixed(angle, 2),
                ]
            }),
        ),
        paragraph(format!(
            "The lengths in (23) are inconsistent as well: (23) treats rod and base as uniform \
             bodies that together form the leg, L<sub>i</sub> + L<sub>j</sub>, with their weights \
             at half their lengths. But twice the printed distances of the centres of mass are \
             {:.2} mm in total, more than the length of any leg at zero input.",
            2e3 * (printed.rod_com + printed.base_com)
        )),
    ];
    section("kinematics", "Kinematics: equations (4) to (7) and (9) to (15)", blocks)
}
