//! Checkpoints of a simulation, and their conversion to and from JSON.

use super::job::{Feed, Job};
use super::sampled_loop::Tuning;
use serde_json::{Value, json};
use stiction_core::forward::{Competitor, Event, EventKind, Method, RateJump};
use stiction_core::mechanism::{BodyId, JointId, Mechanism};

/// State of a simulation after a sample, as numbers, from which the simulation can be resumed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RunCheckpoint {
    /// Number of completed samples.
    pub samples: usize,
    /// State of the mechanism; see [`stiction_core::forward::Checkpoint`].
    pub simulation: Vec<f64>,
    /// State of controllers and other inputs, including the assembled configurations of their
    /// models.
    pub inputs: Vec<f64>,
    /// Results accumulated over the completed samples.
    pub figures: Figures,
    /// Events of the simulation up to the sample of the checkpoint.
    pub events: Vec<Event>,
}

/// Results accumulated over the samples of a simulation; see [`super::Outcome`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Figures {
    /// Largest number of redundant constraints at any sample.
    pub redundant: usize,
    /// Largest number of statically indeterminate efforts of prescribed or locked actuators at any sample.
    pub open_drives: usize,
    /// True if the actuators determine the motion of the mechanism at the start of the simulation.
    pub invertible: bool,
    /// Number of payloads that were picked up and placed.
    pub payload_changes: usize,
    /// Stability of the controller with the payloads carried so far, the worst of all.
    pub tuning: Tuning,
}

impl RunCheckpoint {
    /// Returns the checkpoint as JSON, in which floating-point numbers become strings with all
    /// digits.
    pub fn json(&self) -> Value {
        json!({
            "samples": self.samples,
            "simulation": text(&self.simulation),
            "inputs": text(&self.inputs),
            "figures": {
                "redundant": self.figures.redundant,
                "open_drives": self.figures.open_drives,
                "invertible": self.figures.invertible,
                "payload_changes": self.figures.payload_changes,
                "lowered_bandwidth": self.figures.tuning.lowered.map(|x| text(&[x])),
                "growth_per_period": self.figures.tuning.growth.map(|x| text(&[x])),
            },
            "events": self.events.iter().map(event_json).collect::<Vec<_>>(),
        })
    }

    /// Reads a checkpoint from JSON; `None` if the JSON is not a checkpoint.
    pub fn from_json(value: &Value) -> Option<Self> {
        Some(Self {
            samples: usize::try_from(value["samples"].as_u64()?).ok()?,
            simulation: numbers(&value["simulation"])?,
            inputs: numbers(&value["inputs"])?,
            figures: Figures {
                redundant: usize::try_from(value["figures"]["redundant"].as_u64()?).ok()?,
                open_drives: usize::try_from(value["figures"]["open_drives"].as_u64()?).ok()?,
                invertible: value["figures"]["invertible"].as_bool()?,
                payload_changes: usize::try_from(value["figures"]["payload_changes"].as_u64()?)
                    .ok()?,
                tuning: Tuning {
                    lowered: optional(&value["figures"]["lowered_bandwidth"])?,
                    growth: optional(&value["figures"]["growth_per_period"])?,
                },
            },
            events: value["events"].as_array()?.iter().map(event).collect::<Option<_>>()?,
        })
    }

    /// Returns true if all interfaces, joints and bodies in the events exist in a mechanism, and if
    /// all event times and all numbers of the inputs are finite.
    pub(super) fn fits(&self, mechanism: &Mechanism) -> bool {
        let joints = mechanism.joints();
        let interfaces: usize = joints.iter().map(|joint| joint.friction.len()).sum();
        let interfaces = interfaces + mechanism.shafts_with_friction().len();
        let has_joint = |joint: &JointId| joint.0 < joints.len();
        let events = self.events.iter().all(|event| {
            event.time.is_finite()
                && match &event.kind {
                    EventKind::Sticks { interface, joint }
                    | EventKind::Slides { interface, joint, .. } => {
                        *interface < interfaces && has_joint(joint)
                    }
                    EventKind::NotUnique { joint, .. } | EventKind::Jump { joint, .. } => {
                        has_joint(joint)
                    }
                    EventKind::Payload { body, .. } => body.0 < mechanism.bodies().len(),
                    EventKind::SharesNotUnique { .. }
                    | EventKind::Ends { .. }
                    | EventKind::Singular { .. }
                    | EventKind::Method { .. } => true,
                }
        });
        events && self.inputs.iter().all(|number| number.is_finite())
    }
}

impl Job<'_> {
    /// Returns a hash of the inputs of the simulation: model (without friction if friction is off),
    /// motion, load, efforts, controller, prescribed and locked actuators, stop conditions, start,
    /// sampling and settings. The hash contains neither [`Self::until`] nor [`Self::law`].
    pub fn fingerprint(&self) -> u64 {
        let drives = match self.drives {
            Feed::Given(drives) => Some(drives),
            Feed::Inverse => None,
        };
        let all = format!(
            "{:?} {:?} {:?} {drives:?} {:?} {:?} {:?} {:?} {:?} {:?} {:?} {:?} {:?}",
            self.model.mechanism,
            self.motion,
            self.load,
            self.control,
            self.stops,
            self.prescribed,
            self.locked,
            self.start,
            self.from,
            self.step,
            self.settings,
            self.model.initial_poses,
        );
        checksum(&all)
    }
}

/// Returns a checksum that detects accidental changes of a text (FNV-1a, 64 bits).
pub fn checksum(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

/// Formats numbers, separated by spaces, in the shortest form that reads back as the same number.
fn text(numbers: &[f64]) -> String {
    let each: Vec<String> = numbers.iter().map(|x| format!("{x:?}")).collect();
    each.join(" ")
}

fn numbers(value: &Value) -> Option<Vec<f64>> {
    value.as_str()?.split_ascii_whitespace().map(|x| x.parse().ok()).collect()
}

/// Reads a number that may be absent; `None` if the value is neither a number as text nor null.
fn optional(value: &Value) -> Option<Option<f64>> {
    match value {
        Value::Null => Some(None),
        _ => value.as_str()?.parse().ok().map(Some),
    }
}

fn event_json(event: &Event) -> Value {
    let time = text(&[event.time]);
    match &event.kind {
        EventKind::Sticks { interface, joint } => {
            json!({ "time": time, "sticks": interface, "joint": joint.0 })
        }
        EventKind::Slides { interface, joint, direction } => {
            json!({ "time": time, "slides": interface, "joint": joint.0, "way": text(direction) })
        }
        EventKind::SharesNotUnique { redundant } => json!({ "time": time, "redundant": redundant }),
        EventKind::NotUnique { joint, coupling, others } => {
            let loads: Vec<String> = others.iter().map(|other| text(&other.loads)).collect();
            json!({ "time": time, "others": loads, "joint": joint.0, "coupling": text(&[*coupling]) })
        }
        EventKind::Singular { lost } => json!({ "time": time, "lost": lost }),
        EventKind::Ends { switch } => json!({ "time": time, "ends": switch }),
        EventKind::Payload { body, picked_up, lost } => {
            json!({ "time": time, "body": body.0, "picked_up": picked_up, "lost": text(&[*lost]) })
        }
        EventKind::Method { method } => {
            json!({ "time": time, "steps": *method == Method::TimeStepping })
        }
        EventKind::Jump { joint, change, rates } => {
            let rates: Vec<Value> = rates
                .iter()
                .map(|r| json!([r.joint.0, r.dof, text(&[r.before, r.after])]))
                .collect();
            json!({ "time": time, "joint": joint.0, "change": text(&[*change]), "rates": rates })
        }
    }
}

fn rate_jump(value: &Value) -> Option<RateJump> {
    let index = |k: usize| usize::try_from(value[k].as_u64()?).ok();
    let [before, after] = numbers(&value[2])?.try_into().ok()?;
    Some(RateJump { joint: JointId(index(0)?), dof: index(1)?, before, after })
}

fn event(value: &Value) -> Option<Event> {
    let index = |key: &str| usize::try_from(value[key].as_u64()?).ok();
    let number = |key: &str| numbers(&value[key])?.first().copied();
    let joint = || index("joint").map(JointId);
    let kind = if let Some(interface) = index("sticks") {
        EventKind::Sticks { interface, joint: joint()? }
    } else if let Some(interface) = index("slides") {
        let direction = numbers(&value["way"])?.try_into().ok()?;
        EventKind::Slides { interface, joint: joint()?, direction }
    } else if let Some(switch) = index("ends") {
        EventKind::Ends { switch }
    } else if let Some(redundant) = index("redundant") {
        EventKind::SharesNotUnique { redundant }
    } else if let Some(lost) = index("lost") {
        EventKind::Singular { lost }
    } else if let Some(picked_up) = value["picked_up"].as_bool() {
        EventKind::Payload { body: BodyId(index("body")?), picked_up, lost: number("lost")? }
    } else if let Some(steps) = value["steps"].as_bool() {
        let method = if steps { Method::TimeStepping } else { Method::EventDriven };
        EventKind::Method { method }
    } else if let Some(change) = number("change") {
        let rates = value["rates"].as_array()?.iter().map(rate_jump).collect::<Option<_>>()?;
        EventKind::Jump { joint: joint()?, change, rates }
    } else {
        let loads = value["others"].as_array()?.iter().map(numbers);
        let others = loads.map(|loads| {
            // Of competing solutions, only the loads are needed after a restart from a checkpoint.
            Some(Competitor { loads: loads?, accelerations: Vec::new(), interfaces: Vec::new() })
        });
        let others = others.collect::<Option<_>>()?;
        EventKind::NotUnique { joint: joint()?, coupling: number("coupling")?, others }
    };
    Some(Event { time: number("time")?, kind })
}
