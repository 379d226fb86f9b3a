//! Tables in the report: efforts, intervals at rest, motors, friction.

use crate::inverse::summary::Summary;
use crate::inverse::verdict::Verdict;
use crate::job::Job;
use crate::report::html::{Column, instant, long_table, note, paragraph, table_of, text};
use crate::report::{LISTED, by_joint};
use stiction_draw::numbers::{number, percent};

/// Returns the table of peaks and root mean squares of the efforts.
pub(super) fn efforts(job: &Job<'_>, summary: &Summary) -> String {
    if summary.drives.is_empty() {
        return paragraph("No joint is actuated: there are no efforts.");
    }
    let has_friction = summary.has_friction(job);
    let mut head = vec![
        ("actuator", Column::Text),
        ("unit", Column::Text),
        ("peak", Column::Number),
        ("at [s]", Column::Number),
        ("rms", Column::Number),
        ("peak power [W]", Column::Number),
    ];
    if has_friction {
        head.extend([
            ("peak, frictionless", Column::Number),
            ("rms, frictionless", Column::Number),
            ("friction adds, max/max", Column::Number),
            ("rms/rms", Column::Number),
        ]);
    }
    let named = summary.names.drives.iter().zip(&summary.drives).zip(summary.powers());
    let row = |(((name, unit), comparison), power): (
        (&(String, &'static str), &crate::statistics::Comparison),
        &crate::statistics::Size,
    )| {
        let (with, without) = (&comparison.with, &comparison.without);
        let mut row = vec![text(name), text(unit), text(&number(with.peak))];
        row.extend([instant(with.peak_time), text(&number(with.rms()))]);
        row.push(text(&number(power.peak)));
        if has_friction {
            let metrics = comparison.metrics();
            row.extend([without.peak, without.rms()].map(|x| text(&number(x))));
            row.extend([metrics.max_over_max, metrics.rms_over_rms].map(|x| text(&percent(x))));
        }
        row
    };
    let rows: Vec<Vec<String>> = named.map(row).collect();
    long_table(&head, &rows, 2 * LISTED)
}

/// Returns the table of the widest interval of possible efforts of each actuator while joints are
/// at rest; empty if joints are never at rest.
pub(super) fn rest(summary: &Summary) -> String {
    if summary.resting_samples == 0 {
        return String::new();
    }
    let mut rows = Vec::new();
    for (k, (name, unit)) in summary.names.drives.iter().enumerate() {
        let (size, (low, high)) = (&summary.widest[k], summary.widest_bounds[k]);
        if size.peak > 0.0 {
            let ends = match size.peak.is_infinite() {
                true => ["without limit".to_owned(), "friction locks".to_owned()],
                false => [low, high].map(number),
            };
            let [low, high] = ends.map(|end| text(&end));
            rows.push(vec![text(name), text(unit), low, high, instant(size.peak_time)]);
        }
    }
    let head = [
        ("at rest", Column::Text),
        ("unit", Column::Text),
        ("least", Column::Number),
        ("greatest", Column::Number),
        ("at [s]", Column::Number),
    ];
    let plural = if summary.resting_samples == 1 { "" } else { "s" };
    note(&format!(
        "Joints are at rest at {} sample{plural}. There static friction allows any effort of an interval; these are \
         the widest.",
        summary.resting_samples
    )) + &table_of(&head, &rows)
}

/// Returns the table of the loads on the motors: torque, speed, power and work.
pub(super) fn motors(summary: &Summary) -> String {
    let rows: Vec<Vec<String>> = summary
        .motors
        .loads()
        .map(|(train, load, losses)| {
            let ratio = losses / load.supplied.value;
            vec![
                text(&train.name),
                text(&number(load.torque.peak)),
                instant(load.torque.peak_time),
                text(&number(load.rms())),
                text(&number(load.speed.peak)),
                text(&number(load.power.peak)),
                text(&number(load.work.value)),
                text(&percent(Some(ratio).filter(|ratio| ratio.is_finite()))),
                text(&percent(Some(load.duty()))),
            ]
        })
        .collect();
    let head = [
        ("motor", Column::Text),
        ("peak [N m]", Column::Number),
        ("at [s]", Column::Number),
        ("rms [N m]", Column::Number),
        ("peak [rad/s]", Column::Number),
        ("peak [W]", Column::Number),
        ("work [J]", Column::Number),
        ("losses", Column::Number),
        ("turns", Column::Number),
    ];
    table_of(&head, &rows)
}

/// Returns the table of dissipation and normal load of the friction interfaces, in descending order
/// of dissipation.
pub(super) fn friction(job: &Job<'_>, summary: &Summary, verdict: &Verdict) -> String {
    if !summary.has_friction(job) {
        return String::new();
    }
    // A single instant has power but no work.
    let is_pose = verdict.samples == 1;
    let amount = |k: usize| match is_pose {
        true => summary.dissipated[k].last(),
        false => summary.dissipated[k].value,
    };
    let total: f64 = (0..summary.dissipated.len()).map(amount).sum();
    let mut order: Vec<usize> = (0..summary.dissipated.len()).collect();
    order.sort_by(|&a, &b| amount(b).total_cmp(&amount(a)));
    let row = |&k: &usize| {
        let load = &summary.interface_loads[k];
        vec![
            text(&summary.names.interfaces[k].0),
            text(&number(amount(k))),
            text(&percent((total > 0.0).then(|| amount(k) / total))),
            text(&number(load.peak)),
            instant(load.peak_time),
            text(if summary.determined_loads[k] { "" } else { "not unique" }),
        ]
    };
    let rows: Vec<Vec<String>> = order.iter().map(row).collect();
    let head = [
        ("friction interface", Column::Text),
        (if is_pose { "power [W]" } else { "dissipated [J]" }, Column::Number),
        ("part", Column::Number),
        ("peak normal load [N]", Column::Number),
        ("at [s]", Column::Number),
        ("", Column::Text),
    ];
    let unit = if is_pose { "W" } else { "J" };
    let interfaces = summary.names.interfaces.iter().enumerate();
    let amounts = interfaces.map(|(k, (_, joint))| (*joint, amount(k)));
    long_table(&head, &rows, LISTED) + &by_joint(&summary.names.joints, amounts, unit)
}
