//! Section 3 of the paper: dynamics without friction.

use super::{
    curves, digits, equation, fixed, greatest, panel, paragraph, power_of_ten, range, right,
    section, table, wrong,
};
use crate::engine::Sample;
use crate::kinematics::base_centre;
use crate::lagrangian::{Printed, driving_forces, generalised_force};
use crate::report::{Cell, Section};
use crate::robot::{Motion, NO_LOAD, Robot};

/// Interpretations of the moments of inertia, with the error of each.
pub(crate) const READINGS: [(&str, Printed); 4] = [
    (
        "(8): J′<sub>d</sub> = J<sub>d</sub> + m<sub>d</sub> (x² + z²)",
        Printed { platform: true, rods: false, bases: false },
    ),
    (
        "(16): J′<sub>n1</sub> = J<sub>n1</sub> + m<sub>n1</sub> l<sub>n1</sub>²",
        Printed { platform: false, rods: true, bases: false },
    ),
    (
        "(17): l<sub>n2</sub> to O<sub>1</sub>y<sub>1</sub>",
        Printed { platform: false, rods: false, bases: true },
    ),
    ("all three as printed", Printed::ALL),
];

/// Largest errors of an interpretation along a motion: generalised forces (N, N, N m) and actuator
/// forces (N). The errors of actuator forces are `None` at singular poses.
pub(crate) fn errors(
    robot: &Robot,
    motion: fn(f64) -> Motion,
    printed: Printed,
    count: usize,
) -> ([f64; 3], Option<[f64; 3]>) {
    let mut forces = [0.0_f64; 3];
    let mut drives = Some([0.0_f64; 3]);
    for k in 0..count {
        let motion = motion(k as f64 / count as f64);
        let [with, without] =
            [printed, Printed::NONE].map(|p| generalised_force(robot, p, &motion));
        let [wrong, right] =
            [printed, Printed::NONE].map(|p| driving_forces(robot, p, &motion, NO_LOAD));
        drives = drives.zip(wrong.zip(right)).map(|(most, (wrong, right))| {
            core::array::from_fn(|n| most[n].max((wrong[n] - right[n]).abs()))
        });
        forces = core::array::from_fn(|i| forces[i].max((with[i] - without[i]).abs()));
    }
    (forces, drives)
}

/// Largest difference from the engine's frictionless actuator forces, N, and the largest force, N.
pub(crate) fn agreement(samples: &[Sample]) -> (f64, f64) {
    let robot = Robot::regular();
    let mut worst = (0.0_f64, 0.0_f64);
    for sample in samples {
        let motion = Robot::regular_motion(sample.time);
        let drives = driving_forces(&robot, Printed::NONE, &motion, NO_LOAD);
        let own = drives.unwrap_or([f64::INFINITY; 3]);
        worst.0 = worst.0.max(greatest((0..3).map(|n| own[n] - sample.ideal[n])));
        worst.1 = worst.1.max(greatest(sample.ideal));
    }
    worst
}

pub(crate) fn write(samples: &[Sample]) -> Section {
    let (printed, regular) = (Robot::printed(), Robot::regular());
    let (difference, largest) = agreement(samples);
    let rows = READINGS.map(|(name, reading)| {
        let (forces, _) = errors(&printed, Robot::printed_motion, reading, 400);
        let (_, drives) = errors(&regular, Robot::regular_motion, reading, 400);
        let drives = drives.unwrap_or([f64::NAN; 3]);
        [
            Cell::from(name),
            fixed(forces[0], 3),
            fixed(forces[1], 3),
            fixed(forces[2], 4),
            fixed(drives[0], 1),
            fixed(drives[1], 1),
            fixed(drives[2], 1),
        ]
    });
    let size = |robot: &Robot, motion: fn(f64) -> Motion, i: usize| {
        let of = |k: usize| generalised_force(robot, Printed::NONE, &motion(k as f64 / 400.0))[i];
        greatest((0..400).map(of))
    };
    let sizes = [0, 1, 2].map(|i| size(&printed, Robot::printed_motion, i));
    let time = |k: usize| k as f64 / 200.0;
    let line = |n: usize, reading: Printed| -> Vec<(f64, f64)> {
        let at = |k: usize| {
            let motion = Robot::regular_motion(time(k));
            let drives = driving_forces(&regular, reading, &motion, NO_LOAD)?;
            Some((time(k), drives[n]))
        };
        (0..=200).filter_map(at).collect()
    };
    let panels = (0..3)
        .map(|n| {
            panel(
                &format!("leg {} [N]", n + 1),
                [
                    ("corrected", 0, false, line(n, Printed::NONE)),
                    ("as printed", 1, true, line(n, Printed::ALL)),
                ],
            )
        })
        .collect();
    let away = range((0..400).flat_map(|k| {
        let pose = Robot::printed_motion(f64::from(k) / 400.0).pose;
        let printed = &printed;
        (1..3).map(move |n| {
            let [x, z] = base_centre(printed, n, pose);
            x.hypot(z)
        })
    }));
    let blocks = vec![
        equation("8", "E<sub>d</sub> = ½ m<sub>d</sub> (ẋ² + ż²) + ½ J′<sub>d</sub> θ̇²"),
        equation(
            "16",
            "ΣE<sub>n1</sub> = ½ Σ m<sub>n1</sub> (Ẋ<sub>Gn1</sub>² + Ż<sub>Gn1</sub>²) + ½ Σ J′<sub>n1</sub> φ̇<sub>n</sub>²",
        ),
        equation("17", "ΣE<sub>n2</sub> = ½ Σ J′<sub>n2</sub> φ̇<sub>n</sub>²"),
        equation(
            "18-20",
            "U = g (m<sub>d</sub> z + Σ m<sub>n1</sub> Z<sub>Gn1</sub> + Σ m<sub>n2</sub> Z<sub>Gn2</sub>)",
        ),
        equation(
            "",
            "F = d/dt ∂L/∂Ẋ − ∂L/∂X,  L = E<sub>d</sub> + ΣE<sub>n1</sub> + ΣE<sub>n2</sub> − U,  X = (x, z, θ)",
        ),
        equation("21", "τ = J<sup>T</sup> F"),
        paragraph(
            "The study evaluates these energies as printed and differentiates them exactly, by \
             dual numbers. The potentials (18) to (20) are right. Three moments of inertia are \
             wrong:",
        ),
        wrong(format!(
            "(8): the kinetic energy of the platform's translation is counted twice, in \
             m<sub>d</sub> v² and again in J′<sub>d</sub> = J<sub>d</sub> + m<sub>d</sub> (x² + \
             z²), which belongs to a rotation about O<sub>1</sub>. The correct value is \
             J<sub>d</sub>. (16): the same error for the rods; the correct value is \
             J<sub>n1</sub>. (17): a base rotates about its joint R<sub>n</sub>, at p = 174.65 mm \
             from its centre of mass, and not about O<sub>1</sub>y<sub>1</sub>, which is {:.3} to \
             {:.3} m away for legs 2 and 3 along (29). For leg 1, the two axes coincide.",
            away.0, away.1,
        )),
        table(
            "ideal-errors",
            &format!(
                "Largest error that each printed equation causes along a cycle: in the generalised \
                 forces of the printed robot along (29), which are at most {:.2} N, {:.1} N and \
                 {:.4} N m; and in the driving forces of the regular twin, which are at most \
                 {largest:.0} N. Along (29), θ is constant, so (8) causes no error there.",
                sizes[0], sizes[1], sizes[2]
            ),
            [
                ("as printed", ""),
                ("(29): F<sub>x</sub>", "N"),
                ("F<sub>z</sub>", "N"),
                ("M<sub>θ</sub>", "N m"),
                ("twin: τ<sub>1</sub>", "N"),
                ("τ<sub>2</sub>", "N"),
                ("τ<sub>3</sub>", "N"),
            ],
            rows,
        ),
        curves(
            "ideal-drives",
            "Regular twin, driving forces without friction",
            panels,
            "Driving forces of the regular twin without friction and without load: inertias corrected, and as printed.",
        ),
        right(format!(
            "With these three corrections, Lagrange's equations and the general engine give the \
             same driving forces: they differ by at most {} N of {largest:.0} N at {} instants of \
             the motion of the twin, in which all rates, including θ̇, are nonzero. Equation (21) \
             is therefore right if J exists, if F denotes the derivatives with respect to x, z and \
             θ (the paper uses q<sub>n</sub> both for these and for the inputs of the joints), and \
             if the load is subtracted, which (21) omits. M<sub>yθ</sub> is the generalised force \
             of θ and equals −M<sub>y</sub>: a moment of the load enters with a minus sign.",
            power_of_ten(difference, 2),
            samples.len(),
        )),
        table(
            "ideal-agreement",
            "Lagrange's equations compared with the general engine for the regular twin without \
             load, at every tenth sample.",
            [
                ("time", "s"),
                ("τ<sub>1</sub>", "N"),
                ("τ<sub>2</sub>", "N"),
                ("τ<sub>3</sub>", "N"),
                ("largest difference", "N"),
            ],
            samples.iter().step_by(10).map(|sample| {
                let motion = Robot::regular_motion(sample.time);
                let own = driving_forces(&regular, Printed::NONE, &motion, NO_LOAD)
                    .unwrap_or([f64::NAN; 3]);
                let difference = greatest((0..3).map(|n| own[n] - sample.ideal[n]));
                [
                    fixed(sample.time, 1),
                    fixed(own[0], 4),
                    fixed(own[1], 4),
                    fixed(own[2], 4),
                    digits(difference, 2),
                ]
            }),
        ),
    ];
    section("ideal-dynamics", "Dynamics without friction: equations (8) and (16) to (21)", blocks)
}
