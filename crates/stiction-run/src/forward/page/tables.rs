//! HTML tables in the report of a simulation: motion and efforts, motors, friction, events, energy.

use crate::forward::events::DescribedEvent;
use crate::forward::outcome::Outcome;
use crate::forward::summary::Summary;
use crate::report::html::{Column, instant, long_table, table, table_of, text};
use crate::report::{LISTED, by_joint};
use crate::statistics::Size;
use stiction_draw::numbers::{number, percent};

/// Largest number of events in the table of the page; `events.csv` contains all events.
const EVENTS: usize = 200;

/// Formats a position or a rate. Values that are rounding errors compared with 1 m or 1 rad become
/// zero.
fn settled(x: f64) -> String {
    if x.abs() < 1e-14 { "0".to_owned() } else { number(x) }
}

/// Returns the table of the actuator efforts.
pub(super) fn efforts(summary: &Summary) -> String {
    let names = &summary.layout.names.drives;
    let head = [
        ("actuator", Column::Text),
        ("peak", Column::Number),
        ("at [s]", Column::Number),
        ("rms", Column::Number),
        ("unit", Column::Text),
    ];
    let row = |((name, unit), size): (&(String, &str), &Size)| {
        let peak = [text(name), text(&number(size.peak)), instant(size.peak_time)];
        peak.into_iter().chain([text(&number(size.rms())), text(unit)]).collect()
    };
    let rows: Vec<Vec<String>> = names.iter().zip(&summary.drives).map(row).collect();
    long_table(&head, &rows, 2 * LISTED)
}

/// Returns the table of the final positions and rates of the actuators, and of their tracking
/// errors.
pub(super) fn motion(summary: &Summary) -> String {
    let layout = &summary.layout;
    if summary.last.forward.is_empty() || layout.names.drives.is_empty() {
        return String::new();
    }
    let follows = layout.reference.contains(&true);
    let mut head = vec![
        ("actuator", Column::Text),
        ("position at the end", Column::Number),
        ("rate at the end", Column::Number),
    ];
    if follows {
        head.extend([("error, peak", Column::Number), ("error, rms", Column::Number)]);
    }
    let row = |k: usize| {
        let dof = layout.dof_of_actuator[k];
        let motion = layout.motion_in(&summary.last.forward, dof);
        let [place, speed, _] = layout.dofs[dof].units();
        let mut row = vec![
            text(&layout.names.drives[k].0),
            text(&format!("{} {place}", settled(motion[0]))),
            text(&format!("{} {speed}", settled(motion[1]))),
        ];
        if follows {
            let small = if place == "m" { "mm" } else { "mrad" };
            let error = &summary.errors[k];
            row.extend([error.peak, error.rms()].map(|x| match layout.reference[k] {
                true => text(&format!("{} {small}", number(1e3 * x))),
                false => text("-"),
            }));
        }
        row
    };
    let rows: Vec<Vec<String>> = (0..layout.names.drives.len()).map(row).collect();
    long_table(&head, &rows, 2 * LISTED)
}

/// Returns the table of the loads on the motors: torque, speed, power and work.
pub(super) fn motors(summary: &Summary) -> String {
    let trains = summary.layout.motors.trains().zip(&summary.motors);
    let rows: Vec<Vec<String>> = trains
        .map(|(train, load)| {
            vec![
                text(&train.name),
                text(&number(load.torque.peak)),
                instant(load.torque.peak_time),
                text(&number(load.rms())),
                text(&number(load.speed.peak)),
                text(&number(load.power.peak)),
                text(&number(load.work.value)),
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
        ("turns", Column::Number),
    ];
    table_of(&head, &rows)
}

/// Returns the table of dissipation and sticking time of the friction interfaces, in descending
/// order of dissipation.
pub(super) fn friction(summary: &Summary, outcome: &Outcome) -> String {
    let names = &summary.layout.names.interfaces;
    let account = summary.account();
    let sticking = summary.sticking(&outcome.events);
    let rounding = summary.rounding();
    let settle = |x: f64| if x.abs() < rounding { 0.0 } else { x };
    let dissipated = |k: usize| settle(account.interfaces.get(k).copied().unwrap_or(0.0));
    let total = settle(account.interfaces.iter().sum());
    let mut order: Vec<usize> = (0..names.len()).collect();
    order.sort_by(|&a, &b| dissipated(b).total_cmp(&dissipated(a)));
    let row = |&k: &usize| {
        let sticking = sticking.get(k)?;
        let load = &summary.loads[k];
        Some(vec![
            text(&names[k].0),
            text(&number(dissipated(k))),
            text(&percent((total > 0.0).then(|| dissipated(k) / total))),
            text(&number(sticking.time)),
            text(&sticking.stops.to_string()),
            text(&number(load.peak)),
            instant(load.peak_time),
        ])
    };
    let rows: Vec<Vec<String>> = order.iter().filter_map(row).collect();
    let head = [
        ("friction interface", Column::Text),
        ("dissipated [J]", Column::Number),
        ("part", Column::Number),
        ("sticks [s]", Column::Number),
        ("stick onsets", Column::Number),
        ("peak normal load [N]", Column::Number),
        ("at [s]", Column::Number),
    ];
    let amounts = names.iter().enumerate().map(|(k, (_, joint))| (*joint, dissipated(k)));
    long_table(&head, &rows, LISTED) + &by_joint(&summary.layout.names.joints, amounts, "J")
}

/// Returns the table of the events in chronological order.
pub(super) fn events(summary: &Summary, outcome: &Outcome) -> String {
    let described = summary.described(&outcome.events);
    let row = |event: &DescribedEvent| {
        let DescribedEvent { time, what, at, detail } = event;
        vec![instant(*time), text(what), text(at), text(detail)]
    };
    let rows: Vec<Vec<String>> = described.iter().take(EVENTS).map(row).collect();
    let head = [
        ("time [s]", Column::Number),
        ("event", Column::Text),
        ("at", Column::Text),
        ("detail", Column::Text),
    ];
    let more = match described.len().saturating_sub(EVENTS) {
        0 => String::new(),
        more => crate::report::html::note(&format!("And {more} more, which events.csv lists.")),
    };
    long_table(&head, &rows, LISTED) + &more
}

/// Returns the table of the terms of the energy balance at the end of the simulation.
pub(super) fn energy(summary: &Summary) -> String {
    let account = summary.account();
    let rounding = summary.rounding();
    let amount = |x: f64| number(if x.abs() < rounding { 0.0 } else { x });
    let rows = [
        ("work of the actuators", account.drives.iter().sum()),
        ("work of the loads", account.loads),
        ("change of kinetic energy", account.kinetic.1 - account.kinetic.0),
        ("change of potential energy", account.potential.1 - account.potential.0),
        ("dissipated by friction", account.interfaces.iter().sum()),
        ("dissipated by dampers", account.dampers),
    ];
    let rows: Vec<Vec<String>> =
        rows.into_iter().map(|(name, value)| vec![name.to_owned(), amount(value)]).collect();
    table(&[("energy", Column::Text), ("[J]", Column::Number)], &rows)
}
