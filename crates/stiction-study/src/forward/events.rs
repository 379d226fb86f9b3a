//! What happened, in words.

use super::rows::Layout;
use crate::inverse::terminal::number;
use stiction::forward::{Event, EventKind};

/// An event in words.
pub(crate) struct Told {
    /// s.
    pub(crate) time: f64,
    /// A word for programs.
    pub(crate) what: &'static str,
    /// The contact or the joint; may be empty.
    pub(crate) at: String,
    /// More; may be empty.
    pub(crate) detail: String,
}

/// Says what an event is.
pub(crate) fn tell(layout: &Layout, event: &Event) -> Told {
    let contact_name = |contact: usize| layout.names.contacts[contact].0.clone();
    let joint_name = |joint: stiction::mechanism::JointId| layout.names.joints[joint.0].clone();
    let (what, at, detail) = match &event.kind {
        EventKind::Sticks { contact, .. } => ("sticks", contact_name(*contact), String::new()),
        EventKind::Slides { contact, direction, .. } => {
            let detail = if layout.signed[*contact] {
                if direction[0] < 0.0 { "backward" } else { "forward" }.to_owned()
            } else {
                direction.map(number).join(" ")
            };
            ("slides", contact_name(*contact), detail)
        }
        EventKind::SharesNotUnique { redundant } => {
            ("shares-not-unique", String::new(), format!("{redundant}"))
        }
        EventKind::NotUnique { joint, coupling, others } => {
            let detail =
                format!("coupling {}, other solutions {}", number(*coupling), others.len());
            ("not-unique", joint_name(*joint), detail)
        }
    };
    Told { time: event.time, what, at, detail }
}
