//! Reads joints.

use super::check_values::check_values;
use super::context::{Context, Record};
use super::friction::{self, FrictionSpans};
use super::geometry::frame;
use crate::diagnostic::{Diagnostic, did_you_mean, quoted};
use crate::document::{Key, Node, Table, Value};
use crate::expression::Measure;
use crate::fields::tables::{JOINT, JOINT_COMPLIANCE, LEG_JOINT};
use crate::source::Span;
use stiction_core::joint::{Dof, JointType, Motion};
use stiction_core::mechanism::{Compliance, JointRange, JointSpec, RangeOf};
use stiction_core::spatial::{Mat3, Pose, Quaternion, Vec3};

/// A joint as read from the model file, with the places of its entries in the text for messages.
pub(crate) struct JointDraft {
    pub(crate) name: String,
    /// Specification of the joint; `None` if its type or one of its bodies is missing or invalid.
    pub(crate) spec: Option<JointSpec>,
    pub(crate) joint_type: Option<JointType>,
    pub(crate) spans: JointSpans,
}

/// Places of a joint's name and values in the text.
pub(crate) struct JointSpans {
    pub(crate) name: Span,
    pub(crate) from: Span,
    pub(crate) to: Span,
    pub(crate) pitch: Span,
    pub(crate) start: Span,
    pub(crate) range: Span,
    pub(crate) actuated: Span,
    pub(crate) friction: FrictionSpans,
    /// Place of the table of compliances, and of the value of each of its keys.
    pub(crate) compliance: (Span, Vec<(&'static str, Span)>),
}

/// Attributes of a joint that are determined by its leg.
pub(crate) struct LegAttributes<'a> {
    pub(crate) joint_type: JointType,
    pub(crate) actuated: bool,
    pub(crate) from: (&'a str, Span),
    pub(crate) to: (&'a str, Span),
    /// For the first joint of a leg: its origin in the rotated frame of `from`, and the rotation.
    pub(crate) first: Option<(Vec3<f64>, Mat3<f64>)>,
    /// For the last joint of a leg: its origin in the rotated frame of `to`, and the rotation.
    pub(crate) last: Option<(Vec3<f64>, Mat3<f64>)>,
}

/// Reads a joint. `leg` contains the attributes that the leg determines, if the joint belongs to a
/// leg; `what` describes the joint in messages.
pub(crate) fn read(
    context: &Context<'_>,
    name: String,
    name_span: &Span,
    table: &Table,
    leg: Option<&LegAttributes<'_>>,
    what: &str,
) -> JointDraft {
    let fields = if leg.is_some() { LEG_JOINT } else { JOINT };
    let record = Record::new(context, table, fields, what);
    let joint_type = match leg {
        Some(leg) => Some(leg.joint_type),
        None => read_type(context, &record),
    };
    let end = |key: &str, of_leg: Option<&(&str, Span)>| match of_leg {
        Some((name, span)) => (Some((*name).to_owned()), span.clone()),
        None => (record.text(key).map(str::to_owned), record.span(key)),
    };
    let (from, from_span) = end("from", leg.map(|p| &p.from));
    let (to, to_span) = end("to", leg.map(|p| &p.to));
    let mut spans = JointSpans {
        name: name_span.clone(),
        from: from_span,
        to: to_span,
        pitch: record.span("pitch"),
        start: record.span("start"),
        range: record.span("range"),
        actuated: record.span("actuated"),
        friction: FrictionSpans::default(),
        compliance: (record.span("compliance"), Vec::new()),
    };
    let mut spec = None;
    if let (Some(joint_type), Some(from), Some(to)) = (joint_type, from, to) {
        let reader = Reader { context, record: &record, joint_type };
        let mut built = JointSpec::new(name.as_str(), joint_type, from, to);
        if let Some((frame_j, frame_k)) = reader.frames(leg) {
            built = built.frames(frame_j, frame_k);
        }
        let pitch = record.quantity("pitch");
        if let Some(pitch) = pitch {
            built = built.pitch(pitch);
        } else if record.value("pitch").is_some() {
            // The invalid pitch has been reported; this number avoids a second message about a
            // pitch of zero.
            built = built.pitch(f64::from(u8::from(joint_type == JointType::Helical)));
        }
        built = reader.actuated(built, leg);
        if let Some(start) = reader.start() {
            built = built.start(start);
        }
        built = reader.ranges().into_iter().fold(built, JointSpec::range);
        if let Some(table) = record.table("friction") {
            let joint = friction::Place { joint_type, pitch: pitch.unwrap_or(0.0), what };
            let (interfaces, friction_spans) = friction::read(context, table, &joint);
            spans.friction = friction_spans;
            built = interfaces.into_iter().fold(built, JointSpec::friction);
        }
        if let Some(table) = record.table("compliance") {
            let what = format!("the compliance of {what}");
            let record = Record::new(context, table, JOINT_COMPLIANCE, what);
            let mut part = |key: &'static str| {
                spans.compliance.1.push((key, record.span(key)));
                record.quantity(key).unwrap_or(0.0)
            };
            built = built.compliance(Compliance {
                radial: part("radial"),
                axial: part("axial"),
                bending: part("bending"),
                torsional: part("torsional"),
            });
        }
        spec = Some(built);
    } else {
        check_values(&record, fields);
    }
    JointDraft { name, spec, joint_type, spans }
}

/// Reads the type from its symbol; for a written-out type, the message suggests the symbol.
fn read_type(context: &Context<'_>, record: &Record<'_>) -> Option<JointType> {
    const WORDS: &[(&str, &str)] = &[
        ("revolute", "R"),
        ("hinge", "R"),
        ("prismatic", "P"),
        ("slider", "P"),
        ("helical", "H"),
        ("screw", "H"),
        ("cylindrical", "C"),
        ("universal", "U"),
        ("cardan", "U"),
        ("hooke", "U"),
        ("spherical", "S"),
        ("ball", "S"),
        ("planar", "E"),
    ];
    let value = record.value("type")?;
    let word = value.as_text().unwrap_or_default().to_lowercase();
    if let Some((_, symbol)) = WORDS.iter().find(|(known, _)| *known == word) {
        context.push(
            Diagnostic::error("unknown-name", "the type of a joint is written as a letter")
                .at(context.place(&value.span), "a word")
                .help(format!("write \"{symbol}\"")),
        );
        return None;
    }
    record.choice("type").and_then(JointType::from_symbol)
}

/// Returns the measure of a degree of freedom's coordinate, a length or an angle.
fn coordinate_measure(dof: &Dof) -> Measure {
    match dof.motion {
        Motion::Translation => Measure::Length,
        Motion::Rotation | Motion::Screw => Measure::Angle,
    }
}

struct Reader<'a> {
    context: &'a Context<'a>,
    record: &'a Record<'a>,
    joint_type: JointType,
}

impl Reader<'_> {
    /// Reads the poses of the joint's frame J in the predecessor (`X_PJ`) and of its frame K in the
    /// successor (`X_SK`).
    fn frames(&self, leg: Option<&LegAttributes<'_>>) -> Option<(Pose<f64>, Pose<f64>)> {
        let first = leg.and_then(|p| p.first);
        let last = leg.and_then(|p| p.last);
        let at = self.origin("at", first.map(|(origin, _)| origin), "foot");
        let to_at = self.origin("to_at", last.map(|(origin, _)| origin), "tip");
        let axes = self.axes();
        let turn = match self.record.value("turn") {
            Some(value) => self.context.rotation(value),
            None => Some(Mat3::identity()),
        };
        let (at, to_at, axes, turn) = (at?, to_at?, axes?, turn?);
        let turned = |by: Option<(Vec3<f64>, Mat3<f64>)>, pose: Pose<f64>| match by {
            Some((_, rotation)) => Pose { rotation, position: Vec3::zero() } * pose,
            None => pose,
        };
        let frame_j = Pose { rotation: axes, position: at };
        let frame_k = Pose { rotation: turn.transpose() * axes, position: to_at };
        Some((turned(first, frame_j), turned(last, frame_k)))
    }

    fn origin(&self, key: &str, of_leg: Option<Vec3<f64>>, named: &str) -> Option<Vec3<f64>> {
        match (self.record.value(key), of_leg) {
            (None, origin) => Some(origin.unwrap_or(Vec3::zero())),
            (Some(_), None) => self.record.vector(key),
            (Some(value), Some(_)) => {
                let message = format!("the origin of this joint is the leg's `{named}`");
                self.context.push(
                    Diagnostic::error("unknown-key", message)
                        .at(self.context.place(&value.span), "given twice")
                        .help(format!("delete `{key}`, or change `{named}`")),
                );
                None
            }
        }
    }

    /// Reads the axes of frame J, expressed in the frame of the predecessor.
    fn axes(&self) -> Option<Mat3<f64>> {
        use JointType::{Fixed, Free, Spherical, Universal};
        let symbol = self.joint_type.symbol();
        if matches!(self.joint_type, Spherical | Fixed | Free) {
            for key in ["axis", "second_axis", "x_axis"] {
                if let Some(value) = self.record.value(key) {
                    let help = "to rotate the bodies relative to each other, use `turn`".to_owned();
                    self.not_for_type(value, key, &format!("a joint of type {symbol}"), Some(help));
                }
            }
            return Some(Mat3::identity());
        }
        let universal = self.joint_type == Universal;
        let (x_key, other) =
            if universal { ("second_axis", "x_axis") } else { ("x_axis", "second_axis") };
        if let Some(value) = self.record.value(other) {
            let help = universal
                .then(|| "the x axis of a U joint's frame is its `second_axis`".to_owned());
            self.not_for_type(value, other, &format!("a joint of type {symbol}"), help);
        }
        let axis = self.record.value("axis");
        if axis.is_none() {
            self.record.missing("axis", &format!(", which type {symbol} needs"));
        }
        let x = self.record.value(x_key);
        if universal && x.is_none() {
            self.record.missing("second_axis", ", which type U needs");
        }
        let axis_vector = axis.and_then(|value| self.context.axis(value));
        let x_vector = x.map(|value| self.context.axis(value));
        let axis_vector = axis_vector?;
        let x = match (x, x_vector) {
            (Some(value), Some(x)) => {
                Some(self.context.square_to(axis_vector, x?, value, x_key)?)
            }
            _ if universal => return None,
            _ => None,
        };
        Some(frame(axis_vector, x))
    }

    fn not_for_type(&self, value: &Value, key: &str, what: &str, help: Option<String>) {
        self.context.push(
            Diagnostic::error("unknown-key", format!("{what} has no `{key}`"))
                .at(self.context.place(&value.span), "not allowed for this type")
                .maybe_help(help),
        );
    }

    fn actuated(&self, spec: JointSpec, leg: Option<&LegAttributes<'_>>) -> JointSpec {
        let Some(value) = self.record.value("actuated") else {
            return if leg.is_some_and(|p| p.actuated) { spec.actuated() } else { spec };
        };
        let dofs = self.joint_type.dofs();
        let nothing_to_drive = dofs.is_empty()
            && (matches!(value.node, Node::Flag(true))
                || value.as_list().is_some_and(|l| !l.is_empty()));
        if nothing_to_drive {
            self.context.push(
                Diagnostic::error("mechanism", "a fixed joint cannot be actuated")
                    .at(self.context.place(&value.span), "no degree of freedom"),
            );
            return spec;
        }
        match &value.node {
            Node::Flag(true) => spec.actuated(),
            Node::Flag(false) => spec,
            Node::List(names) => {
                let driven: Vec<_> = names.iter().filter_map(|name| self.dof(name, dofs)).collect();
                spec.actuated_dofs(driven)
            }
            _ => {
                self.context.wrong(
                    value,
                    "true, false or a list of degrees of freedom such as [\"slide\"]",
                );
                spec
            }
        }
    }

    fn dof(&self, value: &Value, dofs: &[Dof]) -> Option<usize> {
        let name = self.context.text(value, "a quoted name of a degree of freedom")?;
        let found = dofs.iter().position(|dof| dof.name == name);
        if found.is_none() {
            let symbol = self.joint_type.symbol();
            let message =
                format!("a joint of type {symbol} has no degree of freedom {}", quoted(name));
            self.context.push(
                Diagnostic::error("unknown-name", message)
                    .at(self.context.place(&value.span), "unknown degree of freedom")
                    .maybe_help(did_you_mean(
                        name,
                        "its degrees of freedom",
                        dofs.iter().map(|f| f.name),
                    )),
            );
        }
        found
    }

    /// Reads the ranges of the joint's coordinates.
    fn ranges(&self) -> Vec<JointRange> {
        let Some(value) = self.record.value("range") else { return Vec::new() };
        let dofs = match self.joint_type.has_scalar_coordinates() {
            true => self.joint_type.dofs(),
            false => &[],
        };
        let tilts = matches!(self.joint_type, JointType::Universal | JointType::Spherical);
        if let (Some(_), [dof]) = (value.as_list(), dofs) {
            return self
                .range(value, RangeOf::Dof(0), coordinate_measure(dof))
                .into_iter()
                .collect();
        }
        let names: Vec<&str> =
            dofs.iter().map(|dof| dof.name).chain(tilts.then_some("tilt")).collect();
        if names.is_empty() {
            let what = format!("a joint of type {}", self.joint_type.symbol());
            self.not_for_type(value, "range", &what, None);
            return Vec::new();
        }
        let Some(table) = value.as_table().filter(|_| dofs.len() != 1) else {
            let expected = match dofs {
                [_] => "a range [least, greatest]".to_owned(),
                _ => format!("a table such as {{ {} = [least, greatest] }}", names.join(" or ")),
            };
            self.context.wrong(value, &expected);
            return Vec::new();
        };
        let read = |(key, value): &(Key, Value)| match dofs.iter().position(|d| d.name == key.name)
        {
            Some(dof) => self.range(value, RangeOf::Dof(dof), coordinate_measure(&dofs[dof])),
            None if tilts && key.name == "tilt" => self.range(value, RangeOf::Tilt, Measure::Angle),
            None => {
                let symbol = self.joint_type.symbol();
                let message =
                    format!("a joint of type {symbol} has no range {}", quoted(&key.name));
                self.context.push(
                    Diagnostic::error("unknown-name", message)
                        .at(self.context.place(&key.span), "unknown quantity")
                        .maybe_help(did_you_mean(&key.name, "its ranges", names.iter().copied())),
                );
                None
            }
        };
        table.entries.iter().filter_map(read).collect()
    }

    fn range(&self, value: &Value, of: RangeOf, measure: Measure) -> Option<JointRange> {
        let Some([least, greatest]) = value.as_list() else {
            self.context.wrong(value, "a range [least, greatest]");
            return None;
        };
        let (least, greatest) =
            (self.context.quantity(least, measure), self.context.quantity(greatest, measure));
        Some(JointRange { of, limits: (least?, greatest?) })
    }

    /// Reads the initial guesses of the joint's coordinates.
    fn start(&self) -> Option<Vec<f64>> {
        let value = self.record.value("start")?;
        match self.joint_type {
            JointType::Fixed => {
                self.not_for_type(value, "start", "a fixed joint", None);
                None
            }
            JointType::Spherical => {
                let mut q = vec![0.0; 4];
                Quaternion::from_rotation(self.context.rotation(value)?).write(&mut q);
                Some(q)
            }
            JointType::Free => {
                let Some(table) = value.as_table() else {
                    self.context.wrong(value, "a pose { position = [x, y, z], rotation = … }");
                    return None;
                };
                let pose = self.context.pose(table, "`start`")?;
                let mut q = pose.position.to_array().to_vec();
                q.resize(7, 0.0);
                if let Some(quaternion) = q.get_mut(3..) {
                    Quaternion::from_rotation(pose.rotation).write(quaternion);
                }
                Some(q)
            }
            _ => {
                let dofs = self.joint_type.dofs();
                let single = std::slice::from_ref(value);
                let list = match value.as_list() {
                    Some(list) => list,
                    None if dofs.len() == 1 => single,
                    None => {
                        let names: Vec<_> = dofs.iter().map(|f| f.name).collect();
                        self.context.wrong(value, &format!("a list [{}]", names.join(", ")));
                        return None;
                    }
                };
                let measures =
                    dofs.iter().map(coordinate_measure).chain(std::iter::repeat(Measure::Any));
                list.iter().zip(measures).map(|(item, m)| self.context.quantity(item, m)).collect()
            }
        }
    }
}
