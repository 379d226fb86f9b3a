//! Resolves names in motions, such as `leg1.P` or `platform.x`.

use super::names::Names;
use crate::diagnostic::{nearest, or, quoted};
use crate::document::{Node, Table, Value};
use crate::expression::Measure;
use crate::fields::Field;
use crate::fields::tables::BODY_MOTION;
use crate::source::Span;
use std::collections::HashMap;
use stiction_core::joint::JointType;
use stiction_core::kinematics::{AngleOrder, Coordinate};
use stiction_core::mechanism::{BodyId, JointId};

/// Value in nested tables, with its path, the keys joined by dots.
pub(crate) struct Leaf<'a> {
    pub(crate) path: String,
    /// Place of the last key of the path.
    pub(crate) key: Span,
    /// Range of the second-last key of the path, or of the last key if the path has only one.
    pub(crate) owner: Span,
    /// Value of the key; `None` for an empty table.
    pub(crate) value: Option<&'a Value>,
}

/// Returns all values in a table and its nested tables, except those under the keys `own` of the
/// table itself.
pub(crate) fn leaves<'a>(table: &'a Table, own: &[Field]) -> Vec<Leaf<'a>> {
    struct Pending<'a> {
        path: String,
        key: Span,
        owner: Span,
        value: &'a Value,
    }
    let mut all = Vec::new();
    let names = table.entries.iter().filter(|(key, _)| !own.iter().any(|f| f.key == key.name));
    let mut pending: Vec<Pending<'a>> = names
        .rev()
        .map(|(key, value)| {
            let (path, key) = (key.name.clone(), key.span.clone());
            Pending { path, owner: key.clone(), key, value }
        })
        .collect();
    while let Some(Pending { path, key, owner, value }) = pending.pop() {
        match &value.node {
            Node::Table(table) if table.entries.is_empty() => {
                all.push(Leaf { path, key, owner, value: None });
            }
            // An orientation is one value.
            Node::Table(_) if path.ends_with(".rotation") => {
                all.push(Leaf { path, key, owner, value: Some(value) });
            }
            Node::Table(table) => {
                pending.extend(table.entries.iter().rev().map(|(inner, value)| Pending {
                    path: format!("{path}.{}", inner.name),
                    key: inner.span.clone(),
                    owner: key.clone(),
                    value,
                }));
            }
            _ => all.push(Leaf { path, key, owner, value: Some(value) }),
        }
    }
    all
}

/// Object that a path names.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Meaning<'a> {
    /// Coordinate of a body: the body, and the key of the coordinate such as `x`.
    Body(BodyId, &'a str),
    /// Degree of freedom of a joint: the joint, its type, and the index of the degree of freedom.
    Joint(JointId, JointType, usize),
}

/// Reason why a path cannot be resolved.
#[derive(Debug, PartialEq)]
pub(crate) enum Unresolved {
    /// The problem has been reported elsewhere.
    Reported,
    /// The name is unknown.
    Unknown,
    /// The name is known but does not have the requested coordinate. The fields are the message and
    /// the advice.
    Wrong(String, Option<String>),
}

impl Unresolved {
    fn new(message: String, help: impl Into<Option<String>>) -> Self {
        Self::Wrong(message, help.into())
    }

    /// Returns the message, the advice, and a flag: true if the name of the body or joint is wrong,
    /// false if the coordinate is wrong. The keys `own` are suggested, too. Returns `None` if the
    /// problem has been reported. The search is slow, because all names are compared.
    pub(crate) fn explain(
        self,
        names: &Names,
        own: &'static [Field],
        path: &str,
    ) -> Option<(String, Option<String>, bool)> {
        match self {
            Self::Reported => None,
            Self::Wrong(message, help) => Some((message, help, false)),
            Self::Unknown => Some(unknown(names, own, path)),
        }
    }
}

/// Finds the coordinate of a body or joint that a path such as `platform.x` names.
pub(crate) fn resolve<'a>(names: &Names, path: &'a str) -> Result<Meaning<'a>, Unresolved> {
    let split = path.rsplit_once('.');
    let body = split.and_then(|(body, key)| Some(Meaning::Body(names.body(body)?, key)));
    let joint = if let Some((id, joint_type)) = names.joint(path) {
        Some(whole_joint(path, id, joint_type))
    } else if let Some((name, dof)) = split
        && let Some((id, joint_type)) = names.joint(name)
    {
        Some(joint_dof(name, id, joint_type, dof))
    } else {
        None
    };
    match (body, joint) {
        (Some(Meaning::Body(BodyId::GROUND, _)), _) => {
            Err(Unresolved::new("the motion of the ground cannot be prescribed".to_owned(), None))
        }
        (Some(_), Some(Ok(_))) => {
            let message = format!("{} is ambiguous: it can name a body or a joint", quoted(path));
            Err(Unresolved::new(message, "rename one of them".to_owned()))
        }
        (Some(body), _) => Ok(body),
        (None, Some(joint)) => joint,
        (None, None) if names.may_be_lost(path) => Err(Unresolved::Reported),
        (None, None) => Err(Unresolved::Unknown),
    }
}

fn whole_joint<'a>(
    name: &str,
    id: JointId,
    joint_type: Option<JointType>,
) -> Result<Meaning<'a>, Unresolved> {
    let joint_type = joint_type.ok_or(Unresolved::Reported)?;
    let dofs = joint_type.dofs();
    if !joint_type.has_scalar_coordinates() || dofs.is_empty() {
        return Err(no_coordinates(name, joint_type));
    }
    if dofs.len() > 1 {
        let names: Vec<_> = dofs.iter().map(|f| format!("`{name}.{}`", f.name)).collect();
        let message = format!("joint {} has {} coordinates", quoted(name), dofs.len());
        return Err(Unresolved::new(message, format!("choose one of {}", or(&names))));
    }
    Ok(Meaning::Joint(id, joint_type, 0))
}

fn joint_dof<'a>(
    name: &str,
    id: JointId,
    joint_type: Option<JointType>,
    dof: &str,
) -> Result<Meaning<'a>, Unresolved> {
    let joint_type = joint_type.ok_or(Unresolved::Reported)?;
    if !joint_type.has_scalar_coordinates() {
        return Err(no_coordinates(name, joint_type));
    }
    let dofs = joint_type.dofs();
    match dofs.iter().position(|known| known.name == dof) {
        Some(index) => Ok(Meaning::Joint(id, joint_type, index)),
        None => {
            let names: Vec<_> = dofs.iter().map(|f| quoted(f.name)).collect();
            let message = format!("joint {} has no coordinate {}", quoted(name), quoted(dof));
            let help = (!names.is_empty()).then(|| format!("it has {}", or(&names)));
            Err(Unresolved::new(message, help))
        }
    }
}

fn no_coordinates(name: &str, joint_type: JointType) -> Unresolved {
    let message = format!(
        "joint {} of type {} has no coordinate to prescribe",
        quoted(name),
        joint_type.symbol()
    );
    Unresolved::new(message, "prescribe the pose of a body instead".to_owned())
}

fn unknown(names: &Names, own: &'static [Field], path: &str) -> (String, Option<String>, bool) {
    if names.body(path).is_some() {
        let message = format!("{} is a body; the name of a coordinate is missing", quoted(path));
        return (message, Some(format!("for example `{path}.x`")), false);
    }
    let (bodies, joints) = (names.body_names(), names.joint_names());
    let owner = path.rsplit_once('.').map_or(path, |(owner, _)| owner);
    // The misspelt part may be the name of a joint, or the name before the coordinate.
    let near = nearest(path, joints.iter().copied().chain(own.iter().map(|field| field.key)))
        .or_else(|| nearest(owner, bodies.iter().chain(&joints).copied()));
    // `leg1.Q` counts as a name if other names begin with `leg1.`.
    let prefix = format!("{owner}.");
    let within = bodies.iter().chain(&joints).any(|name| name.starts_with(&prefix));
    let missing = if within { path } else { owner };
    let message = format!("there is no body or joint {}", quoted(missing));
    let help = near.map(|near| format!("did you mean {}?", quoted(near))).or_else(|| {
        const MOST: usize = 10;
        let shown: Vec<_> = bodies.iter().chain(&joints).take(MOST).map(|n| quoted(n)).collect();
        let more = if bodies.len() + joints.len() > MOST { ", …" } else { "" };
        (!shown.is_empty()).then(|| format!("the model has {}{more}", shown.join(", ")))
    });
    (message, help, !within)
}

/// Order of the intrinsic angles of each body; bodies that are not listed have the order xyz.
pub(crate) type Orders = HashMap<BodyId, AngleOrder>;

/// Returns the coordinate that a resolved path names, and its measure: a length or an angle.
pub(crate) fn coordinate(
    meaning: Meaning<'_>,
    orders: &Orders,
) -> Result<(Coordinate, Measure), Unresolved> {
    let (body, key) = match meaning {
        Meaning::Joint(joint, joint_type, dof) => {
            let translation = joint_type.dofs().get(dof).is_some_and(|dof| dof.translates());
            let measure = if translation { Measure::Length } else { Measure::Angle };
            return Ok((Coordinate::Joint { joint, dof }, measure));
        }
        Meaning::Body(body, key) => (body, key),
    };
    let order = orders.get(&body).copied().unwrap_or(AngleOrder::XYZ);
    let axis_of = |name: &str| ["x", "y", "z"].iter().position(|axis| *axis == name);
    if let Some(axis) = axis_of(key) {
        return Ok((Coordinate::Position { body, axis }, Measure::Length));
    }
    if let Some(axis) = key.strip_prefix("rv").and_then(axis_of) {
        return Ok((Coordinate::RotationVector { body, axis }, Measure::Angle));
    }
    let letter = key.strip_prefix('r').and_then(axis_of);
    if letter.is_some() && !order.is_tait_bryan() {
        return Err(Unresolved::new(
            format!("{} is ambiguous: its axis occurs twice in the order", quoted(key)),
            "use the names `r1`, `r2`, `r3` for the angles".to_owned(),
        ));
    }
    let by_axis = letter.and_then(|axis| order.axes().iter().position(|&a| a == axis));
    let by_number = ["r1", "r2", "r3"].iter().position(|name| *name == key);
    match by_axis.or(by_number) {
        Some(index) => Ok((Coordinate::Angle { body, order, index }, Measure::Angle)),
        None => Err(Unresolved::new(
            format!("a body has no coordinate {}", quoted(key)),
            nearest(key, BODY_MOTION.iter().map(|field| field.key))
                .map(|near| format!("did you mean `{near}`?"))
                .unwrap_or_else(|| "x y z, rx ry rz (or r1 r2 r3), rvx rvy rvz".to_owned()),
        )),
    }
}
