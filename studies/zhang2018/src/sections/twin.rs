//! Results for the regular variant of the robot, whose equations have a unique solution.

use super::{curves, digits, fixed, note, panel, paragraph, right, rounding, section, table};
use crate::Error;
use crate::engine::{Interval, Run, interval};
use crate::kinematics::joint_rates;
use crate::report::{Block, Cell, Section};
use crate::robot::Robot;
use serde_json::Value;
use stiction_draw::figure::Figure;
use stiction_run::Job;

/// Reversal of a joint of the regular variant.
#[derive(Clone, Debug)]
pub(crate) struct Reversal {
    pub(crate) joint: String,
    pub(crate) time: f64,
    pub(crate) interval: Interval,
}

/// Instants of one cycle at which a joint of the regular variant reverses, s.
pub(crate) fn instants() -> Vec<(String, f64)> {
    let robot = Robot::regular();
    let rates = |n: usize, time: f64| joint_rates(&robot, &Robot::regular_motion(time))[n];
    let mut found = Vec::new();
    for n in 0..3 {
        for (j, joint) in ["P", "R", "S"].into_iter().enumerate() {
            const PIECES: usize = 500;
            for piece in 0..PIECES {
                let mut low = piece as f64 / PIECES as f64;
                let mut high = (piece + 1) as f64 / PIECES as f64;
                let side = rates(n, low)[j] > 0.0;
                if (rates(n, high)[j] > 0.0) == side {
                    continue;
                }
                // Bisect until no representable number lies between.
                loop {
                    let middle = 0.5 * (low + high);
                    if middle <= low || middle >= high {
                        break;
                    }
                    if (rates(n, middle)[j] > 0.0) == side { low = middle } else { high = middle }
                }
                let root =
                    if rates(n, low)[j].abs() < rates(n, high)[j].abs() { low } else { high };
                found.push((format!("leg{}.{joint}", n + 1), root));
            }
        }
    }
    found.sort_by(|a, b| a.1.total_cmp(&b.1));
    found
}

/// Actuator force intervals at every reversal.
pub(crate) fn reversals(job: &Job<'_>, rest_speed: f64) -> Result<Vec<Reversal>, Error> {
    let at = |(joint, time): (String, f64)| {
        Ok(Reversal { joint, time, interval: interval(job, time, rest_speed)? })
    };
    instants().into_iter().map(at).collect()
}

/// The four friction metrics of an actuator in a summary, and the peak of its frictionless effort.
fn metrics(summary: &Value, leg: usize) -> [f64; 4] {
    let effect = &summary["drives"][format!("leg{leg}.P")]["friction_effect"];
    ["max_over_max", "rms_over_rms", "mean_over_mean", "greatest_at_one_time"]
        .map(|name| effect[name].as_f64().unwrap_or(f64::NAN))
}

/// Table of the metrics of all legs under all loads.
pub(crate) fn metric_table(id: &str, caption: &str, runs: &[(&str, &Run)]) -> Block {
    let rows = runs.iter().flat_map(|(load, run)| {
        (1..=3).map(move |leg| {
            let [most, root, mean, once] = metrics(&run.summary, leg).map(|part| 100.0 * part);
            [
                Cell::from(*load),
                Cell::from(leg.to_string()),
                fixed(most, 1),
                fixed(root, 1),
                fixed(mean, 1),
                fixed(once, 1),
            ]
        })
    });
    table(
        id,
        caption,
        [
            ("load", ""),
            ("leg", ""),
            ("max / max", "%"),
            ("rms / rms", "%"),
            ("mean / mean", "%"),
            ("greatest at one time", "%"),
        ],
        rows,
    )
}

fn figure(run: &Run, name: &str, caption: &str) -> Option<Block> {
    let found = run.figures.iter().find(|(known, _)| *known == name)?;
    let figure: Figure = found.1.clone();
    Some(Block::Curves { id: format!("twin-{name}-curves"), figure, caption: caption.into() })
}

/// Friction contributions of the joints to each actuator, from the summary.
fn shares(summary: &Value) -> Vec<[Cell; 5]> {
    let mut rows = Vec::new();
    for leg in 1..=3 {
        let drive = &summary["drives"][format!("leg{leg}.P")];
        let unit_root = drive["frictionless"]["rms"].as_f64().unwrap_or(f64::NAN);
        for share in drive["friction_contributions"].as_array().into_iter().flatten().take(4) {
            let root = share["rms"].as_f64().unwrap_or(f64::NAN);
            rows.push([
                Cell::from(format!("τ<sub>{leg}</sub>")),
                Cell::from(format!("`{}`", share["contact"].as_str().unwrap_or(""))),
                fixed(root, 3),
                fixed(share["peak"].as_f64().unwrap_or(f64::NAN), 3),
                fixed(100.0 * root / unit_root, 2),
            ]);
        }
    }
    rows
}

/// Runs under the three loads of the model, with converged friction.
pub(crate) struct Runs<'a> {
    pub(crate) none: &'a Run,
    pub(crate) moderate: &'a Run,
    pub(crate) printed: &'a Run,
}

pub(crate) fn write(runs: &Runs<'_>, job: &Job<'_>) -> Result<Section, Error> {
    let run = runs.none;
    let reversals = reversals(job, run.verdict.rest_speed)?;
    let widest = reversals
        .iter()
        .flat_map(|r| r.interval.attained.iter().map(move |(low, high)| (high - low, r)))
        .max_by(|a, b| a.0.total_cmp(&b.0));
    let beyond = reversals.iter().map(|r| r.interval.beyond()).fold(0.0, f64::max);
    let exact = reversals.iter().filter(|r| r.interval.beyond() < 1e-9).count();
    let coupling = [runs.none, runs.moderate, runs.printed]
        .map(|run| run.verdict.coupling.unwrap_or(f64::INFINITY))
        .into_iter()
        .fold(0.0, f64::max);
    let unique = 1.0 / coupling;
    let residual = run.samples.iter().fold(0.0_f64, |most, s| most.max(s.power.residual().abs()));
    let turnover = run.samples.iter().fold(0.0_f64, |most, s| most.max(s.power.turnover));
    let drive_panels = (0..3)
        .map(|n| {
            let of = |f: fn(&crate::engine::Sample) -> [f64; 3]| -> Vec<(f64, f64)> {
                run.samples.iter().map(|s| (s.time, f(s)[n])).collect()
            };
            panel(
                &format!("leg {} [N]", n + 1),
                [
                    ("without friction", 0, false, of(|s| s.ideal)),
                    ("with friction", 1, false, of(|s| s.drives)),
                ],
            )
        })
        .collect();
    let mut blocks = vec![
        paragraph(
            "The twin has the topology, masses, radii and friction coefficients of the paper, and \
             the motion x = 60 + 20 sin 2πt, z = 500 + 30 cos 2πt, θ = 65° + 5° sin(2πt + 0.7) \
             (mm), which avoids the symmetric pose. This figure corresponds to figure 7 of the \
             paper, for a robot whose driving forces exist.",
        ),
        curves(
            "twin-drives",
            "Regular twin: driving forces with and without friction",
            drive_panels,
            "Driving forces of the regular twin over one cycle without load. Jumps occur at \
             reversals of joints; at these instants, the force is not a single number but an \
             [interval](#table-twin-reversals).",
        ),
        metric_table(
            "twin-metrics",
            "Friction contribution to the driving forces by four metrics and under three loads: L0 \
             no load, L1 a moderate wrench, LP the load of the paper. The metrics are ratios of \
             the change to the frictionless force: of the largest magnitudes; of the root mean \
             squares; of the mean magnitudes; and the largest ratio at a single instant, which has \
             little meaning if the frictionless force passes through zero, as that of leg 3 does \
             under L1.",
            &[("L0", runs.none), ("L1", runs.moderate), ("LP", runs.printed)],
        ),
        note(format!(
            "Under all three loads, the solution is unique: the bound of the coupling of friction \
             and reactions is below one. It would remain below one if all coefficients were \
             {unique:.1} times as large (μ = {:.2}).",
            Robot::regular().mu * unique,
        )),
        paragraph(format!(
            "At {} instants of the cycle, a joint comes to rest and reverses. Its friction can \
             then have any value up to the limit, and each driving force has an interval. The \
             widest interval is {}. Both ends of each interval are attained by friction forces \
             that satisfy all friction laws. In {exact} cases, the interval is exact; in the \
             others, the guaranteed bounds lie at most {beyond:.2} N beyond it.",
            reversals.len(),
            widest.map_or(String::new(), |(width, r)| format!(
                "{width:.2} N as {} reverses at {:.4} s",
                r.joint, r.time
            )),
        )),
        table(
            "twin-reversals",
            "All reversals of joints in one cycle without load, and the driving forces that static \
             friction allows at these instants. The last column gives the largest distance of the \
             guaranteed bounds from these intervals.",
            [
                ("time", "s"),
                ("reverses", ""),
                ("τ<sub>1</sub> from", "N"),
                ("to", "N"),
                ("τ<sub>2</sub> from", "N"),
                ("to", "N"),
                ("τ<sub>3</sub> from", "N"),
                ("to", "N"),
                ("beyond", "N"),
            ],
            reversals.iter().map(|r| {
                let [a, b, c] = r.interval.attained;
                [
                    fixed(r.time, 4),
                    Cell::from(format!("`{}`", r.joint)),
                    fixed(a.0, 3),
                    fixed(a.1, 3),
                    fixed(b.0, 3),
                    fixed(b.1, 3),
                    fixed(c.0, 3),
                    fixed(c.1, 3),
                    digits(r.interval.beyond(), 2),
                ]
            }),
        ),
    ];
    blocks.extend(figure(
        run,
        "shares",
        "Friction contribution to each driving force, and the four joints with the largest \
         contributions. The contributions of all joints add up to the total.",
    ));
    blocks.push(table(
        "twin-shares",
        "The four joints with the largest friction contributions to each driving force, without \
         load.",
        [
            ("drive", ""),
            ("friction in", ""),
            ("rms", "N"),
            ("peak", "N"),
            ("rms / rms of frictionless drive", "%"),
        ],
        shares(&run.summary),
    ));
    blocks.extend(figure(
        run,
        "power",
        "Power of actuators and loads, rate of change of energy, dissipation, and the relative \
         residual of the power balance.",
    ));
    blocks.push(table(
        "twin-power",
        "Power balance with converged friction, without load.",
        [("time", "s"), ("drives", "W"), ("dE/dt", "W"), ("dissipated", "W"), ("residual", "W")],
        run.samples.iter().step_by(10).map(|s| {
            [
                fixed(s.time, 1),
                fixed(s.power.actuators, 6),
                fixed(s.power.energy, 6),
                fixed(s.power.dissipated, 6),
                digits(s.power.residual(), 1),
            ]
        }),
    ));
    blocks.push(right(format!(
        "The power balance closes at every sample to {} W, of an exchanged power of {turnover:.0} \
         W, with friction forces that are evaluated from the reactions that they cause. (28) \
         cannot satisfy this test.",
        rounding(residual),
    )));
    Ok(section("twin", "Results for the regular twin", blocks))
}
