//! Restores joints that an export divided into several joints of the file, from extension elements that name these parts.
//!
//! The parts of such a joint may have motors, springs and dampers, which belong to its degrees of freedom. Chains without
//! an extension element are merged only if they are passive (see [`super::chains`]).

use super::super::context::Context;
use super::super::description::{Coordinate, Description, GROUND, Joint};
use super::super::extension::{self, Entry};
use super::super::rotation::z_and_x;
use super::chains::Chain;
use super::{SAME, are_parallel, are_perpendicular, remove, size_of};
use crate::diagnostic::quoted;
use stiction_core::joint::JointType::{
    self, Cylindrical, Free, Helical, Planar, Prismatic, Revolute, Spherical, Universal,
};
use stiction_core::spatial::{Mat3, Pose, Vec3};

/// Names the bodies and restores the joints that extension elements of the kinds `body` and `joint` describe.
pub(in crate::import) fn restore(context: &Context<'_>, robot: &mut Description) {
    let entries = std::mem::take(&mut robot.extensions);
    let (bodies, entries): (Vec<Entry>, Vec<Entry>) =
        entries.into_iter().partition(|entry| entry.kind == "body");
    let (joints, entries): (Vec<Entry>, Vec<Entry>) =
        entries.into_iter().partition(|entry| entry.kind == "joint");
    robot.extensions = entries;
    for entry in bodies {
        name_body(context, robot, &entry);
    }
    for entry in joints {
        let Some((kind, names)) = declaration(context, &entry) else { continue };
        if restore_joint(robot, &entry.name, kind, &names).is_none() {
            let parts: Vec<String> = names.iter().map(|name| quoted(name)).collect();
            let message = format!(
                "joint {} of type {} is not restored, because {} do not form such a joint: they stay separate",
                quoted(&entry.name),
                kind.symbol(),
                parts.join(", ")
            );
            context.warn(message, Some(entry.place));
        }
    }
}

/// Gives the body between two joints of one MJCF body the name that it had before the export.
fn name_body(context: &Context<'_>, robot: &mut Description, entry: &Entry) {
    let joint = robot.joints.iter().find(|joint| joint.name == entry.text.trim());
    match joint.map(|joint| joint.to).filter(|body| robot.bodies[*body].is_massless()) {
        Some(body) if body != GROUND => robot.bodies[body].name.clone_from(&entry.name),
        _ => {
            let message = format!(
                "joint {} carries no massless body that could be named {}",
                quoted(&entry.text),
                quoted(&entry.name)
            );
            context.note(message, Some(entry.place.clone()));
        }
    }
}

/// Reads the type of a joint, and the names of its parts in the order in which they act from frame J to frame K.
fn declaration(context: &Context<'_>, entry: &Entry) -> Option<(JointType, Vec<String>)> {
    let table = extension::table(context, entry)?;
    let symbol = table.get("type").and_then(toml::Value::as_str);
    let kind = [Helical, Cylindrical, Universal, Planar, Free]
        .into_iter()
        .find(|kind| Some(kind.symbol()) == symbol);
    let names = table.get("joints").and_then(toml::Value::as_array).map(|names| {
        names.iter().filter_map(toml::Value::as_str).map(str::to_owned).collect::<Vec<_>>()
    });
    let (Some(kind), Some(names)) = (kind, names) else {
        let message = format!("the parts of joint {} cannot be read", quoted(&entry.name));
        let help = "write the type of the joint, H, C, U, E or free, and the names of its parts: \
                    type = \"U\", joints = [\"J.first\", \"J.second\"]";
        context.error("extension", message, &entry.place, help);
        return None;
    };
    Some((kind, names))
}

/// Types of the parts of a joint, in the order in which they act from frame J to frame K.
fn kinds(kind: JointType) -> &'static [JointType] {
    match kind {
        Helical | Cylindrical => &[Revolute, Prismatic],
        Universal => &[Revolute, Revolute],
        Planar => &[Prismatic, Prismatic, Revolute],
        Free => &[Prismatic, Prismatic, Prismatic, Spherical],
        _ => &[],
    }
}

/// Replaces the joints with these names by one joint of this type. `None` if they do not form such a joint.
fn restore_joint(
    robot: &mut Description,
    name: &str,
    kind: JointType,
    names: &[String],
) -> Option<()> {
    let find = |name: &String| robot.joints.iter().position(|joint| joint.name == *name);
    let parts: Vec<usize> = names.iter().map(find).collect::<Option<_>>()?;
    let is_kind = |(part, kind): (&usize, &JointType)| robot.joints[*part].kind == *kind;
    let matches = parts.len() == kinds(kind).len() && parts.iter().zip(kinds(kind)).all(is_kind);
    if !matches || kinds(kind).is_empty() || parts.iter().any(|part| robot.joints[*part].closes) {
        return None;
    }
    let is_reversed = is_chain(robot, &parts.iter().rev().copied().collect::<Vec<_>>());
    if !is_reversed && !is_chain(robot, &parts) {
        return None;
    }
    let thread = match kind {
        Helical => Some(thread(robot, &parts)?),
        _ => None,
    };
    // Degrees of freedom that the restored joint does not have must not be referred to.
    let kept = kept(kind);
    let others = || parts.iter().skip(kept);
    if others().any(|part| is_referred_to(robot, *part, thread.map(|own| own.0))) {
        return None;
    }
    let motors = motors_to_drop(robot, &parts[1..])?;
    let mut joint = restored(robot, kind, &parts, is_reversed)?;
    joint.name = name.to_owned();
    if let Some((gearing, pitch)) = thread {
        joint.pitch = pitch;
        robot.gearings.remove(gearing);
    }
    let mut index = 0;
    robot.joint_motors.retain(|_| {
        index += 1;
        !motors.contains(&(index - 1))
    });
    let own = parts[0];
    let dof_of = |joint: usize| parts.iter().position(|part| *part == joint);
    for motor in &mut robot.motors {
        if let Some(dof) = dof_of(motor.joint) {
            (motor.joint, motor.dof) = (own, dof);
        }
    }
    for term in robot.gearings.iter_mut().flat_map(|gearing| &mut gearing.terms) {
        if let Some(dof) = dof_of(term.0) {
            (term.0, term.1) = (own, dof);
        }
    }
    let ends = [joint.from, joint.to];
    let touched = parts.iter().flat_map(|part| [robot.joints[*part].from, robot.joints[*part].to]);
    let mut between: Vec<usize> = touched.filter(|body| !ends.contains(body)).collect();
    between.sort_unstable();
    between.dedup();
    robot.joints[own] = joint;
    remove(robot, &parts[1..], &between);
    Some(())
}

/// Number of parts whose coordinates are coordinates of the restored joint.
fn kept(kind: JointType) -> usize {
    match kind {
        Helical => 1,
        Free => 0,
        _ => kinds(kind).len(),
    }
}

/// Tests if joints are in series, with massless bodies between them to which no other part refers.
fn is_chain(robot: &Description, chain: &[usize]) -> bool {
    chain.windows(2).all(|pair| {
        let body = robot.joints[pair[0]].to;
        let touching = robot.joints.iter().filter(|joint| joint.from == body || joint.to == body);
        body == robot.joints[pair[1]].from
            && body != GROUND
            && robot.bodies[body].is_massless()
            && touching.count() == 2
            && !robot.springs.iter().any(|spring| spring.ends.contains(&body))
    })
}

/// Finds the gearing that couples the advance of a screw to its angle. Returns the index of the gearing, and the pitch,
/// m/rad.
fn thread(robot: &Description, parts: &[usize]) -> Option<(usize, f64)> {
    let &[angle, advance] = parts else { return None };
    let slack = SAME * size_of(robot);
    robot.gearings.iter().enumerate().find_map(|(index, gearing)| {
        let factor = |joint: usize| {
            let term = gearing.terms.iter().find(|(own, _, _)| *own == joint);
            term.map(|(_, _, factor)| *factor)
        };
        let (a, b) = (factor(angle)?, factor(advance)?);
        // A constant would move frame K along the axis.
        let is_thread = gearing.terms.len() == 2 && (gearing.constant / b).abs() <= slack;
        is_thread.then_some((index, -a / b))
    })
}

/// Tests if a motor, a gearing other than `thread`, or a property refers to a joint's coordinate.
fn is_referred_to(robot: &Description, joint: usize, thread: Option<usize>) -> bool {
    let own = &robot.joints[joint];
    let is_plain = |dof: &Coordinate| {
        let sizes = [dof.damping, dof.friction, dof.armature];
        !dof.actuated && dof.range.is_none() && dof.spring.is_none() && sizes == [0.0; 3]
    };
    let others = robot.gearings.iter().enumerate().filter(|(index, _)| Some(*index) != thread);
    let mut terms = others.flat_map(|(_, gearing)| &gearing.terms);
    let mut of_motors = robot.joint_motors.iter().flat_map(|motor| &motor.terms);
    own.damping != 0.0
        || !own.dofs.iter().all(is_plain)
        || robot.motors.iter().any(|motor| motor.joint == joint)
        || terms.any(|term| term.0 == joint)
        || of_motors.any(|term| term.0 == joint)
}

/// Indices of the motors that drive several joints, one of them in `parts`. The description expresses such motors only at
/// the first degree of freedom of a joint, so that an extension element has to describe them. `None` if it does not.
fn motors_to_drop(robot: &Description, parts: &[usize]) -> Option<Vec<usize>> {
    let motors = robot.joint_motors.iter().enumerate();
    let of_parts =
        motors.filter(|(_, motor)| motor.terms.iter().any(|term| parts.contains(&term.0)));
    let is_described =
        |name: &str| robot.extensions.iter().any(|own| own.kind == "actuator" && own.name == name);
    of_parts.map(|(index, motor)| is_described(&motor.name).then_some(index)).collect()
}

/// Creates the joint whose parts are given in the order in which they act from frame J to frame K. In the file, they lead
/// from the successor to the predecessor if `is_reversed`, about opposite axes.
fn restored(
    robot: &Description,
    kind: JointType,
    parts: &[usize],
    is_reversed: bool,
) -> Option<Joint> {
    let mut order = parts.to_vec();
    if is_reversed {
        order.reverse();
    }
    let chain = Chain::new(robot, &order)?;
    let at = |part: usize| if is_reversed { order.len() - 1 - part } else { part };
    let sign = if is_reversed { -1.0 } else { 1.0 };
    let axis = |part: usize| chain.axis(at(part)) * sign;
    let frame = frame(kind, &chain, &at, &axis, size_of(robot))?;
    let mut joint = chain.joint(kind, frame, Vec::new());
    joint.comment = None;
    let relative =
        order.iter().fold(Pose::identity(), |pose, part| pose * robot.joints[*part].relative());
    let relative = if is_reversed { relative.inverse() } else { relative };
    if is_reversed {
        (joint.from, joint.to) = (joint.to, joint.from);
        (joint.frame_j, joint.frame_k) = (joint.frame_k, joint.frame_j);
    }
    if kind == Free {
        joint.start = Some(joint.frame_j.inverse() * relative * joint.frame_k);
    }
    let dofs = parts.iter().take(kept(kind)).map(|part| robot.joints[*part].dofs[0]);
    joint.dofs = dofs.collect();
    Some(joint)
}

/// Frame of the restored joint at zero coordinates, where its frames J and K coincide. `None` if the axes of the parts are
/// not those of a joint of this type.
fn frame(
    kind: JointType,
    chain: &Chain<'_>,
    at: &dyn Fn(usize) -> usize,
    axis: &dyn Fn(usize) -> Vec3<f64>,
    size: f64,
) -> Option<Pose<f64>> {
    let point = |part: usize| chain.frames[at(part)].position;
    match kind {
        Helical | Cylindrical => {
            let (z, along) = (axis(0), axis(1));
            let own = chain.frames[at(0)].rotation;
            // The x axis of such a joint is arbitrary.
            let rotation = match z.dot(own.columns[2]) > 0.0 {
                true => own,
                false => Mat3::from_columns(own.columns[0], -own.columns[1], -own.columns[2]),
            };
            let same = are_parallel(z, along) && z.dot(along) > 0.0;
            same.then_some(Pose { rotation, position: point(0) })
        }
        Universal => {
            let (z, x) = (axis(0), axis(1));
            let position = chain.crossing(at(0), at(1), size)?;
            let rotation = z_and_x(z, x)?;
            are_perpendicular(z, x).then_some(Pose { rotation, position })
        }
        _ => {
            let (x, y) = (axis(0), axis(1));
            let z = axis(2);
            let is_right = are_perpendicular(x, y) && (x.cross(y) + -z).norm() <= 2.0 * SAME;
            let position = point(if kind == Free { 3 } else { 2 });
            let rotation = z_and_x(z, x)?;
            is_right.then_some(Pose { rotation, position })
        }
    }
}
