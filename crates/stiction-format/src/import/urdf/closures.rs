//! Reads loop closures from the `loop_joint` elements of a URDF file.

use super::super::context::Context;
use super::super::description::{Description, Joint};
use super::super::xml::Element;
use super::joint::{axis_frame, kind_of};
use super::{Tree, placed};
use crate::diagnostic::{did_you_mean, quoted};

pub(super) fn read(context: &Context<'_>, tree: &Tree, root: &Element, robot: &mut Description) {
    for element in root.all("loop_joint") {
        robot.joints.extend(closure(context, tree, element));
    }
}

fn closure(context: &Context<'_>, tree: &Tree, element: &Element) -> Option<Joint> {
    let name = element.required(context, "name")?;
    let kind = kind_of(context, element)?;
    // Documentation and exporters also use `link1` for the second link.
    let is_end = |child: &&Element| matches!(child.tag.as_str(), "link1" | "link2");
    let ends: Vec<&Element> = element.children.iter().filter(is_end).collect();
    let [first, second] = ends.as_slice() else {
        let message = format!("{} has {} ends instead of two", element.title(), ends.len());
        let help = "write <link1 link=\"…\" xyz=\"…\" rpy=\"…\"/> and <link2 …/>";
        context.error("loop", message, &element.place(), help);
        return None;
    };
    let body = |end: &Element| {
        let link = end.required(context, "link")?;
        let found = tree.links.get(link).copied();
        if found.is_none() {
            let mut known: Vec<&str> = tree.links.keys().map(String::as_str).collect();
            known.sort_unstable();
            let help = did_you_mean(link, "links", known).unwrap_or_default();
            context.error(
                "name",
                format!("there is no link {}", quoted(link)),
                &end.place(),
                &help,
            );
        }
        found
    };
    let mut joint = Joint::new(name, kind, (body(first)?, body(second)?));
    let frame = axis_frame(context, element, kind)?;
    joint.frame_j = placed(context, first) * frame;
    joint.frame_k = placed(context, second) * frame;
    joint.closes = true;
    joint.place = Some(element.place());
    Some(joint)
}
