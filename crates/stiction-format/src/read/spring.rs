//! Reader of springs and gas springs between points of two bodies, and of springs on degrees of
//! freedom of joints.

use super::check_values::check_values;
use super::context::{Context, Record};
use super::joint::JointDraft;
use crate::diagnostic::Diagnostic;
use crate::document::{Key, Table};
use crate::expression::Measure;
use crate::fields::tables::SPRING;
use crate::source::Span;
use stiction_core::joint::Dof;
use stiction_core::mechanism::{BushingSpec, GasSpring, JointSpringSpec, SpringSpec};
use stiction_core::spatial::Vec3;

/// Spring or bushing as read, with the places of its values in the text.
pub(crate) struct SpringDraft {
    pub(crate) name: String,
    /// Specification of the spring or bushing; `None` if its bodies, ends or values are invalid.
    pub(crate) spec: Option<AnySpring>,
    pub(crate) spans: SpringSpans,
}

/// Specification of a spring of any kind.
#[derive(Clone)]
pub(crate) enum AnySpring {
    Straight(SpringSpec),
    OnJoint(JointSpringSpec),
    Bushing(Box<BushingSpec>),
}

/// Places in the text of the name, the bodies and the values of a spring.
pub(crate) struct SpringSpans {
    pub(crate) name: Span,
    pub(crate) from: Span,
    pub(crate) to: Span,
    /// Key and place of each value of the spring.
    pub(crate) values: Vec<(String, Span)>,
}

impl SpringSpans {
    pub(crate) fn new(record: &Record<'_>, key: &Key) -> Self {
        let entries = &record.table.entries;
        Self {
            name: key.span.clone(),
            from: record.span("from"),
            to: record.span("to"),
            values: entries
                .iter()
                .map(|(key, value)| (key.name.clone(), value.span.clone()))
                .collect(),
        }
    }

    /// Returns the place of the value that messages of the mechanism builder call `parameter`; the
    /// place of the spring's name if the spring does not have this value.
    pub(crate) fn of(&self, parameter: &str) -> Span {
        let key = parameter.replace(' ', "_");
        let place = self.values.iter().find(|(known, _)| *known == key);
        place.map_or(&self.name, |(_, span)| span).clone()
    }

    /// Returns the place of the value whose key occurs first in a message of the mechanism builder;
    /// the place of the spring's name if no key occurs.
    pub(crate) fn mentioned_in(&self, message: &str) -> Span {
        let at = |key: &str| message.find(&key.replace('_', " "));
        let places = self.values.iter().filter_map(|(key, span)| Some((at(key)?, span)));
        places.min_by_key(|(at, _)| *at).map_or(&self.name, |(_, span)| span).clone()
    }
}

/// Keys that only gas springs have.
const GAS: &[&str] = &["extension_force", "progression", "extended_length", "stroke"];
/// Keys of springs between two points that gas springs do not have.
const STRAIGHT: &[&str] = &["stiffness", "free_length", "preload"];
/// Keys of the two bodies that a spring connects, and of the points on them.
const ENDS: &[&str] = &["from", "to", "at", "to_at"];

/// Reads a spring from its table; `joints` are the joints of the model, and `what` describes the
/// spring in messages.
pub(crate) fn read(
    context: &Context<'_>,
    key: &Key,
    table: &Table,
    joints: &[JointDraft],
    what: &str,
) -> SpringDraft {
    let record = Record::new(context, table, SPRING, what);
    let given = |key: &&&str| record.value(key).is_some();
    let spec = if record.value("joint").is_some() {
        refuse(&record, "a spring on a joint", &[ENDS, GAS, &["free_length"]]);
        on_joint(&record, key, joints).map(AnySpring::OnJoint)
    } else {
        if record.value("from").is_none() && record.value("to").is_none() {
            record.missing_both(["joint", "from"]);
        } else {
            ENDS.iter().take(2).filter(|key| !given(key)).for_each(|key| record.missing(key, ""));
        }
        refuse(&record, "a spring between points", &[&["rest"]]);
        if GAS.iter().any(|key| given(&key)) {
            refuse(&record, "a gas spring", &[STRAIGHT]);
            gas(&record, key).map(AnySpring::Straight)
        } else {
            straight(&record, key).map(AnySpring::Straight)
        }
    };
    if spec.is_none() {
        check_values(&record, SPRING);
    }
    SpringDraft { name: key.name.clone(), spec, spans: SpringSpans::new(&record, key) }
}

/// Reports each of `keys` that the table of a spring contains, although a spring of this kind does
/// not have it. `kind` describes the kind of spring in messages.
fn refuse(record: &Record<'_>, kind: &str, keys: &[&[&str]]) {
    for key in keys.iter().flat_map(|keys| keys.iter()) {
        let Some(value) = record.value(key) else { continue };
        let help = match *key {
            key if GAS.contains(&key) => {
                "gas springs act between points of two bodies: `from` and `to`"
            }
            "rest" => {
                "`rest` is the rest coordinate of a spring on a joint: give `joint`, or `free_length` between points"
            }
            "free_length" if kind.ends_with("joint") => {
                "the coordinate without spring force is `rest`"
            }
            key if STRAIGHT.contains(&key) => {
                "its force follows from `extension_force`, `progression`, `extended_length` and `stroke`"
            }
            _ => "a spring acts either on a `joint` or between points `from` and `to`",
        };
        record.context.push(
            Diagnostic::error("spring", format!("{kind} has no `{key}`"))
                .at(record.context.place(&value.span), "not for this kind of spring")
                .help(help),
        );
    }
}

/// Reads the two bodies that a spring connects and the points on them. A point that is not given is
/// the origin of its body's frame.
fn ends(record: &Record<'_>, key: &Key) -> Option<SpringSpec> {
    let (from, to) = (record.text("from")?, record.text("to")?);
    let end = |key: &str| match record.value(key) {
        Some(_) => record.vector(key),
        None => Some(Vec3::zero()),
    };
    let (at, to_at) = (end("at"), end("to_at"));
    Some(SpringSpec::new(key.name.as_str(), from, to).points(at?, to_at?))
}

fn straight(record: &Record<'_>, key: &Key) -> Option<SpringSpec> {
    needs_a_force(record);
    let number = |key: &str| record.context.quantity(record.value(key)?, linear(key));
    if record.value("stiffness").is_some() && record.value("free_length").is_none() {
        record.missing("free_length", ", though it has a stiffness");
    }
    let (stiffness, length) = (number("stiffness"), record.quantity("free_length"));
    let (preload, damping) = (number("preload"), number("damping"));
    let spec = ends(record, key)?;
    Some(
        spec.stiffness(stiffness.unwrap_or(0.0), length.unwrap_or(0.0))
            .preload(preload.unwrap_or(0.0))
            .damping(damping.unwrap_or(0.0)),
    )
}

/// Reports a spring that has neither stiffness nor damping nor preload.
fn needs_a_force(record: &Record<'_>) {
    let forces = ["stiffness", "damping", "preload"];
    if forces.iter().all(|key| record.value(key).is_none()) {
        record.missing_both(["stiffness", "damping"]);
    }
}

/// Returns the kind of quantity that a key of a translational spring has: a spring between two
/// points, or on a translational degree of freedom.
fn linear(key: &str) -> Measure {
    match key {
        "stiffness" => Measure::Stiffness,
        "damping" => Measure::Damping,
        "rest" => Measure::Length,
        _ => Measure::Force,
    }
}

fn angular(key: &str) -> Measure {
    match key {
        "stiffness" => Measure::AngularStiffness,
        "damping" => Measure::AngularDamping,
        "rest" => Measure::Angle,
        _ => Measure::Moment,
    }
}

fn gas(record: &Record<'_>, key: &Key) -> Option<SpringSpec> {
    let required = ["extension_force", "extended_length", "stroke"];
    for key in required.iter().filter(|key| record.value(key).is_none()) {
        record.missing(key, ", though it is a gas spring");
    }
    let [force, length, stroke] = required.map(|key| record.quantity(key));
    let progression = match record.value("progression") {
        Some(_) => record.quantity("progression"),
        None => Some(1.0),
    };
    let damping =
        record.value("damping").map(|value| record.context.quantity(value, Measure::Damping));
    let spec = ends(record, key)?;
    let gas = GasSpring {
        extension_force: force?,
        progression: progression?,
        extended_length: length?,
        stroke: stroke?,
    };
    Some(spec.gas(gas).damping(damping.unwrap_or(Some(0.0))?))
}

fn on_joint(record: &Record<'_>, key: &Key, joints: &[JointDraft]) -> Option<JointSpringSpec> {
    needs_a_force(record);
    let joint = record.text("joint")?;
    let measure: fn(&str) -> Measure = match dof(joints, joint) {
        Some(dof) if dof.translates() => linear,
        _ => angular,
    };
    let number = |key: &str| match record.value(key) {
        Some(value) => record.context.quantity(value, measure(key)),
        None => Some(0.0),
    };
    if record.value("stiffness").is_some() && record.value("rest").is_none() {
        record.missing("rest", ", though it has a stiffness");
    }
    let [stiffness, rest, preload, damping] =
        ["stiffness", "rest", "preload", "damping"].map(number);
    let spec = JointSpringSpec::new(key.name.as_str(), joint).stiffness(stiffness?, rest?);
    Some(spec.preload(preload?).damping(damping?))
}

/// Finds a degree of freedom by its name `JOINT.DOF`, or `JOINT` if the joint has a single degree
/// of freedom.
fn dof(joints: &[JointDraft], name: &str) -> Option<&'static Dof> {
    joints.iter().find_map(|joint| match joint.joint_type?.dofs() {
        [only] if joint.name == name => Some(only),
        dofs => {
            let own = name.strip_prefix(joint.name.as_str())?.strip_prefix('.')?;
            dofs.iter().find(|dof| dof.name == own)
        }
    })
}

/// Returns the names of all degrees of freedom on which springs can act: `JOINT` for a joint with a
/// single degree of freedom, otherwise `JOINT.DOF`.
pub(crate) fn coordinates(joints: &[JointDraft]) -> Vec<String> {
    let of_joint = |joint: &JointDraft| {
        let joint_type = joint.joint_type.filter(|known| known.has_scalar_coordinates());
        let dofs = joint_type.map_or(&[][..], |known| known.dofs());
        let name = |dof: &Dof| match dofs.len() {
            1 => joint.name.clone(),
            _ => format!("{}.{}", joint.name, dof.name),
        };
        dofs.iter().map(name).collect::<Vec<_>>()
    };
    joints.iter().flat_map(of_joint).collect()
}
