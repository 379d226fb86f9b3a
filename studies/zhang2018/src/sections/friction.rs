//! Section 5 of the paper: friction, and equation (28).

use super::{
    curves, equation, fixed, greatest, note, panel, paragraph, power_of_ten, right, section, table,
    wrong,
};
use crate::engine::Sample;
use crate::friction::{
    Method, Result, displacements, driving_forces_with_friction, sign, virtual_work,
};
use crate::report::{Cell, Section};
use crate::robot::{Motion, NO_LOAD, Robot};

/// Samples per cycle in the comparison of friction methods.
pub(crate) const SAMPLES: usize = 2000;

/// Friction methods under comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Converged,
    OnePass,
    FromHome,
    FromStart,
    PrismaticOnly,
    WithoutRadius,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Self::Converged => "converged",
            Self::OnePass => "one pass, virtual work",
            Self::FromHome => "(28), Δq from zero input",
            Self::FromStart => "(28), Δq from t = 0",
            Self::PrismaticOnly => "P alone, converged",
            Self::WithoutRadius => "one pass, without r",
        }
    }
}

/// Results of one method along a cycle of the non-singular variant of the robot, without load.
pub(crate) struct Row {
    pub(crate) kind: Kind,
    /// RMS friction contribution relative to the RMS frictionless actuator force.
    pub(crate) effect: [f64; 3],
    /// RMS error of the contribution relative to the RMS converged contribution.
    pub(crate) error: [f64; 3],
    /// Work per cycle of the friction contributions to the actuators, J.
    pub(crate) work: f64,
    /// Largest number of passes.
    pub(crate) passes: usize,
}

/// Reference positions of the legs for displacements: at zero input and at t = 0.
fn origins(robot: &Robot) -> [[[f64; 3]; 3]; 2] {
    let pose = [0.060, 0.500, 65.0_f64.to_radians()];
    let home = Motion { pose, rate: [0.0; 3], acceleration: [0.0; 3] };
    [displacements(robot, &home), displacements(robot, &Robot::regular_motion(0.0))]
}

fn cycle(robot: &Robot, method: Method) -> Option<Vec<Result>> {
    let at = |k: usize| Robot::regular_motion(k as f64 / SAMPLES as f64);
    (0..SAMPLES).map(|k| driving_forces_with_friction(robot, &at(k), NO_LOAD, method)).collect()
}

/// Results of all methods; `None` if a method has no solution.
pub(crate) fn compare() -> Option<Vec<Row>> {
    let robot = Robot::regular();
    let [home, first] = origins(&robot);
    let right = cycle(&robot, Method::Converged)?;
    let methods = [
        (Kind::Converged, Method::Converged),
        (Kind::OnePass, Method::OnePass),
        (Kind::FromHome, Method::Literal(home)),
        (Kind::FromStart, Method::Literal(first)),
        (Kind::PrismaticOnly, Method::PrismaticOnly),
        (Kind::WithoutRadius, Method::WithoutRadius),
    ];
    let root_of = |squares: f64| squares.sqrt();
    let rows = methods.into_iter().map(|(kind, method)| {
        let results = cycle(&robot, method)?;
        let sum = |f: &dyn Fn(usize) -> f64| (0..SAMPLES).map(|k| f(k).powi(2)).sum::<f64>();
        let effect = core::array::from_fn(|n| {
            root_of(sum(&|k| results[k].change()[n]) / sum(&|k| results[k].ideal[n]))
        });
        let error = core::array::from_fn(|n| {
            let off = sum(&|k| results[k].change()[n] - right[k].change()[n]);
            root_of(off / sum(&|k| right[k].change()[n]))
        });
        let power: f64 = results.iter().map(Result::power_of_change).sum();
        let passes = results.iter().map(|r| r.passes).max().unwrap_or(0);
        Some(Row { kind, effect, error, work: power / SAMPLES as f64, passes })
    });
    rows.collect()
}

/// Fraction of all (leg, instant) pairs at which the absolute value in (28), with displacements
/// from zero input, gives friction the wrong sign.
pub(crate) fn wrong_signs() -> f64 {
    let robot = Robot::regular();
    let [home, _] = origins(&robot);
    let mut wrong = 0;
    for k in 0..SAMPLES {
        let motion = Robot::regular_motion(k as f64 / SAMPLES as f64);
        let method = Method::OnePass;
        let Some(result) = driving_forces_with_friction(&robot, &motion, NO_LOAD, method) else {
            return f64::NAN;
        };
        let now = displacements(&robot, &motion);
        for n in 0..3 {
            let work: f64 = (0..3).map(|j| result.friction[n][j] * (now[n][j] - home[n][j])).sum();
            wrong += usize::from(sign(work) < 0.0);
        }
    }
    wrong as f64 / (3 * SAMPLES) as f64
}

/// Largest difference, N, between this study's converged method and the engine with friction.
pub(crate) fn agreement(samples: &[Sample], method: Method) -> f64 {
    let robot = Robot::regular();
    greatest(samples.iter().flat_map(|sample| {
        let motion = Robot::regular_motion(sample.time);
        let own = driving_forces_with_friction(&robot, &motion, NO_LOAD, method)
            .map_or([f64::INFINITY; 3], |result| result.drives);
        (0..3).map(move |n| own[n] - sample.drives[n])
    }))
}

/// Viscous contribution that cancels in (28): the largest generalised force of the viscous parts
/// along the motion of the regular variant, by virtual work; N, N, N m.
fn viscous_part(robot: &Robot) -> [f64; 3] {
    let mut most = [0.0_f64; 3];
    for k in 0..200 {
        let motion = Robot::regular_motion(f64::from(k) / 200.0);
        let free = Robot { mu: 0.0, ..robot.clone() };
        let Some(result) = driving_forces_with_friction(&free, &motion, NO_LOAD, Method::OnePass)
        else {
            continue;
        };
        let force = virtual_work(&free, &motion, &result.friction);
        most = core::array::from_fn(|i| most[i].max(force[i].abs()));
    }
    most
}

pub(crate) fn write(samples: &[Sample], one_pass: &[Sample]) -> Option<Section> {
    let robot = Robot::regular();
    let rows = compare()?;
    let wrong_part = 100.0 * wrong_signs();
    let viscous = viscous_part(&robot);
    let converged = agreement(samples, Method::Converged);
    let once = agreement(one_pass, Method::OnePass);
    let [home, _] = origins(&robot);
    let time = |k: usize| k as f64 / 400.0;
    let line = |n: usize, method: Method| -> Vec<(f64, f64)> {
        let at = |k: usize| {
            let motion = Robot::regular_motion(time(k));
            let result = driving_forces_with_friction(&robot, &motion, NO_LOAD, method)?;
            Some((time(k), result.change()[n]))
        };
        (0..=400).filter_map(at).collect()
    };
    let panels = (0..3)
        .map(|n| {
            panel(
                &format!("leg {} [N]", n + 1),
                [
                    ("converged", 0, false, line(n, Method::Converged)),
                    ("one pass", 2, true, line(n, Method::OnePass)),
                    ("(28), from zero input", 1, true, line(n, Method::Literal(home))),
                ],
            )
        })
        .collect();
    let pads = two_pads(samples, 0.1);
    let work =
        |kind: Kind| rows.iter().filter(|row| row.kind == kind).map(|row| row.work).sum::<f64>();
    let blocks = vec![
        paragraph(format!(
            "Section 5.1 computes the friction of each joint from its normal load N and its rate. \
             The paper does not define the normal loads; here N<sub>P</sub> = (F<sub>Pt</sub>² + \
             F<sub>Py</sub>²)<sup>1/2</sup>, N<sub>R</sub> = (F<sub>Rt</sub>² + \
             F<sub>Ru</sub>²)<sup>1/2</sup>, N<sub>S</sub> = |F<sub>S</sub>|, and f<sub>v</sub> is \
             in N s/m at the surface. The results depend on this choice: with two pads 100 mm \
             apart that also carry M<sub>P</sub>, N<sub>P</sub> would be {:.1} to {:.0} times as \
             large along the motion of the twin.",
            pads.0, pads.1,
        )),
        table(
            "friction-formulas",
            "The three formulas. A friction torque is the force at the surface times the radius of \
             the surface.",
            [("joint", ""), ("as printed", ""), ("corrected", ""), ("printed is too large by", "")],
            [
                ["P".into(), "f<sub>P</sub> = f<sub>v</sub> q̇ + μ N<sub>P</sub> sgn q̇".into(), "the same".into(), Cell::Empty],
                [
                    "R".into(),
                    "T<sub>R</sub> = f<sub>v</sub> r φ̇ + μ N<sub>R</sub> sgn(r φ̇)".into(),
                    "T<sub>R</sub> = r (f<sub>v</sub> r φ̇ + μ N<sub>R</sub> sgn φ̇)".into(),
                    fixed(1.0 / robot.radius[0], 0),
                ],
                [
                    "S".into(),
                    "T<sub>S</sub> = f<sub>v</sub> r<sub>s</sub> φ̇ + μ N<sub>S</sub> sgn(r<sub>s</sub> φ̇)".into(),
                    "T<sub>S</sub> = r<sub>s</sub> (f<sub>v</sub> r<sub>s</sub> φ̇ + μ N<sub>S</sub> sgn φ̇)".into(),
                    fixed(1.0 / robot.radius[1], 0),
                ],
            ],
        ),
        equation("", "ΣE<sub>f</sub> = Σ |f<sub>P</sub> Δq + T<sub>R</sub> Δφ<sub>R</sub> + T<sub>S</sub> Δφ<sub>S</sub>|,  L′ = L − ΣE<sub>f</sub>"),
        equation("28", "τ̃ = J<sup>T</sup> (d/dt ∂L′/∂q̇ − ∂L′/∂q)"),
        wrong(format!(
            "(28) contradicts mechanics: friction has no potential, and because N depends on \
             accelerations, ΣE<sub>f</sub> is not even part of a Lagrangian of first order. Here N \
             is treated as given, as the paper must have done, and the radii are added. The terms \
             can then be evaluated by hand. The viscous term f<sub>v</sub> q̇ Δq gives \
             d/dt(f<sub>v</sub> Δq) − f<sub>v</sub> q̇ = 0: viscous friction cancels, although by \
             virtual work it requires up to {} N, {} N and {} N m on the twin. The absolute values \
             replace the sign of the velocity by that of the displacement: at {wrong_part:.0} % of \
             all (leg, instant) pairs, friction pushes instead of resisting. If N were constant, \
             the work over a cycle would be zero, as for any potential. Because N changes, this \
             work is arbitrary: {:.3} J, whereas friction dissipates {:.3} J; and with \
             displacements measured from t = 0, a gain of {:.3} J.",
            power_of_ten(viscous[0], 2),
            power_of_ten(viscous[1], 2),
            power_of_ten(viscous[2], 2),
            work(Kind::FromHome),
            work(Kind::Converged),
            -work(Kind::FromStart),
        )),
        equation(
            "",
            "instead: τ = J<sub>a</sub><sup>−T</sup> (F − Q<sub>load</sub> + Q<sub>f</sub>),  Q<sub>f</sub> = Σ f<sub>P</sub> ∂q/∂X + T<sub>R</sub> ∂α/∂X + T<sub>S</sub> ∂(β − α)/∂X",
        ),
        table(
            "friction-methods",
            "Methods compared on the regular twin without load, 2000 samples per cycle, for legs \
             1, 2 and 3. Added: root mean square of the force that friction adds, relative to that \
             of the frictionless driving force. Error: root mean square of the error of this \
             addition, relative to that of the correct one. Work: work of the addition in a cycle. \
             (With 101 samples, as in [another table](#table-twin-metrics), reversals have more \
             weight, and the last digits differ.)",
            [
                ("method", ""),
                ("added: 1", "%"),
                ("2", "%"),
                ("3", "%"),
                ("error: 1", "%"),
                ("2", "%"),
                ("3", "%"),
                ("work", "J"),
                ("passes", ""),
            ],
            rows.iter().map(|row| {
                [
                    Cell::from(row.kind.name()),
                    fixed(100.0 * row.effect[0], 1),
                    fixed(100.0 * row.effect[1], 1),
                    fixed(100.0 * row.effect[2], 1),
                    fixed(100.0 * row.error[0], 0),
                    fixed(100.0 * row.error[1], 0),
                    fixed(100.0 * row.error[2], 0),
                    fixed(row.work, 3),
                    fixed(row.passes as f64, 0),
                ]
            }),
        ),
        note(
            "(28) is misleading: it gives percentages of the same size as the correct method, but \
             curves whose error exceeds the whole effect. A comparison of percentages does not \
             show this error; the work per cycle shows it immediately.",
        ),
        curves(
            "friction-methods-curves",
            "Regular twin: friction contribution to the driving forces",
            panels,
            "Friction contribution to the driving forces, by three methods. The one-pass curve \
             does not include the joint loads that friction causes; (28) has the wrong sign half \
             of the time.",
        ),
        right(format!(
            "With these corrections, the formulas of section 5.1 and the 42 equations agree with \
             the general engine at {2} instants: to {0} N converged, and to {1} N in one pass. In \
             this robot, the friction of P adds to the driving force of its own leg and changes no \
             reaction; only the friction of R and S is coupled with the reactions.",
            power_of_ten(converged, 2),
            power_of_ten(once, 2),
            samples.len(),
        )),
        table(
            "friction-work",
            "Work of all friction forces per cycle: the sum of the works of the driving forces, \
             and the energy that the joints dissipate according to the engine.",
            [("method", ""), ("study, 2000 samples", "J"), ("engine, 101 samples", "J")],
            [
                [
                    Cell::from("converged"),
                    fixed(work(Kind::Converged), 4),
                    fixed(dissipated(samples), 4),
                ],
                [
                    Cell::from("one pass"),
                    fixed(work(Kind::OnePass), 4),
                    fixed(dissipated(one_pass), 4),
                ],
            ],
        ),
    ];
    Some(section("friction", "Friction: section 5.1 and equation (28)", blocks))
}

/// Smallest and largest ratio of the normal load of a prismatic joint with two pads `span` m apart
/// about P to the load with one pad. The pads also carry the moment: |F/2 + d| + |F/2 - d| with d =
/// M x u / span.
fn two_pads(samples: &[Sample], span: f64) -> (f64, f64) {
    use crate::reactions::unknown::{FP, MP};
    super::range(samples.iter().flat_map(|sample| sample.unknowns).map(|leg| {
        let (force, couple) = ([leg[FP], leg[FP + 1]], [leg[MP + 1] / span, -leg[MP] / span]);
        let pad = |sign: f64| {
            let of = |i: usize| force[i] / 2.0 + sign * couple[i];
            of(0).hypot(of(1))
        };
        (pad(1.0) + pad(-1.0)) / force[0].hypot(force[1])
    }))
}

/// Energy dissipated by the joints over the samples, J, by the trapezoidal rule.
pub(crate) fn dissipated(samples: &[Sample]) -> f64 {
    let piece = |pair: &[Sample]| {
        0.5 * (pair[0].power.dissipated + pair[1].power.dissipated) * (pair[1].time - pair[0].time)
    };
    samples.windows(2).map(piece).sum()
}
