//! Descriptions of the events of a simulation in words, for reports and tables.

use super::rows::Layout;
use crate::dofs::Dof;
use stiction_core::forward::{Event, EventKind, Method, RateJump};
use stiction_core::mechanism::JointId;
use stiction_draw::numbers::number;

/// Description of an event of a simulation in words.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct DescribedEvent {
    /// Time of the event, s.
    pub(crate) time: f64,
    /// Keyword for the kind of event, such as `sticks` or `jump`.
    pub(crate) what: &'static str,
    /// Name of the friction interface, joint or body at which the event occurs; empty if the event
    /// concerns the whole mechanism.
    pub(crate) at: String,
    /// Further details of the event; may be empty.
    pub(crate) detail: String,
}

/// Describes all events of a simulation in words. `at_rest` has one entry for each friction
/// interface, which is true if the interface sticks at the start of the simulation.
pub(crate) fn describe_all(
    layout: &Layout,
    mut at_rest: Vec<bool>,
    events: &[Event],
) -> Vec<DescribedEvent> {
    at_rest.resize(layout.names.interfaces.len(), false);
    events.iter().map(|event| describe(layout, &mut at_rest, event)).collect()
}

fn describe(layout: &Layout, at_rest: &mut [bool], event: &Event) -> DescribedEvent {
    let interface_name = |interface: usize| layout.names.interfaces[interface].0.clone();
    let joint_name = |joint: JointId| layout.names.joints[joint.0].clone();
    let (what, at, detail) = match &event.kind {
        EventKind::Sticks { interface, .. } => {
            at_rest[*interface] = true;
            ("sticks", interface_name(*interface), String::new())
        }
        EventKind::Slides { interface, direction, .. } => {
            let rested = std::mem::replace(&mut at_rest[*interface], false);
            let what = if rested { "slides" } else { "reverses" };
            (what, interface_name(*interface), way(*direction, layout.signed[*interface]))
        }
        EventKind::SharesNotUnique { redundant } => {
            ("shares-not-unique", String::new(), format!("{redundant} redundant"))
        }
        EventKind::NotUnique { joint, coupling, others } => {
            let count = others.len();
            let detail = format!("coupling {}, {count} found", number(*coupling));
            ("not-unique", joint_name(*joint), detail)
        }
        EventKind::Singular { lost } => {
            let detail = format!("{lost} of the loop constraints depend on the others");
            ("singular", String::new(), detail)
        }
        EventKind::Ends { switch } => {
            let condition = layout.stops.get(*switch).cloned();
            ("stop", String::new(), condition.unwrap_or_default())
        }
        EventKind::Payload { body, picked_up, lost } => {
            let what = if *picked_up { "picks-up" } else { "places" };
            let detail = picked_up.then(|| format!("{} J lost in the impact", number(*lost)));
            (what, layout.names.bodies[body.0].clone(), detail.unwrap_or_default())
        }
        EventKind::Method { method } => ("method", String::new(), method_name(*method).to_owned()),
        EventKind::Jump { joint, change: _, rates } => {
            let detail = format!("no acceleration: {}", rate_jumps(layout, rates));
            ("jump", joint_name(*joint), detail)
        }
    };
    DescribedEvent { time: event.time, what, at, detail }
}

/// Returns the total durations, s, of event-driven integration and of time stepping between the
/// first and the last sample.
pub(crate) fn methods(events: &[Event], (first, last): (f64, f64)) -> [f64; 2] {
    let (mut passed, mut since, mut now) = ([0.0; 2], first, 0);
    for event in events {
        if let EventKind::Method { method } = event.kind {
            let time = event.time.clamp(first, last);
            passed[now] += time - since;
            (since, now) = (time, usize::from(method == Method::TimeStepping));
        }
    }
    passed[now] += last - since;
    passed
}

/// Returns the rates before and after a jump with their units, such as "slider 1 -> 0 m/s, rod 0 ->
/// -1.342 rad/s".
fn rate_jumps(layout: &Layout, rates: &[RateJump]) -> String {
    const MOST: usize = 4;
    let mut words: Vec<String> = Vec::new();
    for jump in rates.iter().take(MOST) {
        let is_dof = |dof: &&Dof| (dof.joint, dof.index) == (jump.joint, jump.dof);
        let Some(dof) = layout.dofs.iter().find(is_dof) else { continue };
        let [_, unit, _] = dof.units();
        words.push(format!(
            "{} {} -> {} {unit}",
            dof.name,
            number(jump.before),
            number(jump.after)
        ));
    }
    if rates.len() > MOST {
        words.push(format!("{} more", rates.len() - MOST));
    }
    words.join(", ")
}

/// Returns the keyword of an integration scheme.
pub(crate) fn method_name(method: Method) -> &'static str {
    match method {
        Method::Automatic => "automatic",
        Method::EventDriven => "event-driven",
        Method::TimeStepping => "time-stepping",
    }
}

/// Returns the direction of sliding as text: `forward` or `backward` if the interface slides along
/// one direction, otherwise the components of the unit vector.
fn way(direction: [f64; 3], signed: bool) -> String {
    match (signed, direction[0] < 0.0) {
        (true, true) => "backward".to_owned(),
        (true, false) => "forward".to_owned(),
        // Components that are only rounding errors become zero.
        _ => direction.map(|x| number(if x.abs() < 1e-12 { 0.0 } else { x })).join(" "),
    }
}
