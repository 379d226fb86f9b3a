//! Converts the parsed document of a model file to the model.

mod actuator;
mod actuators;
mod assignments;
mod body;
mod bushing;
mod chain;
mod check_values;
mod context;
mod control;
mod defects;
mod draft;
mod drives;
mod friction;
mod gearing;
pub(crate) mod geometry;
mod given;
mod influence;
mod joint;
mod kinks;
mod leg_springs;
mod legs;
mod load;
mod log;
mod measured;
mod motion;
mod names;
pub(crate) mod parameters;
mod path;
mod recording;
mod spring;
mod time_column;
mod waypoints;

pub use draft::Draft;
pub use log::{Log, LogColumn, LogFormat, LogRole, Renamed, Rows};

use crate::parameters::Parameters;

use crate::contents::Contents;
use crate::diagnostic::{Diagnostic, Diagnostics, quoted};
use crate::document::{self, Document, Table, Value};
use crate::fields::Field;
use crate::fields::tables::{ACTUATOR, BODY, BUSHING, DEFAULT, GEARING, JOINT, MODEL, SPRING};
use crate::model_file::{Leg, LoadCase, ModelFile, Motion};
use crate::source::{Place, Source};
use crate::visual::Visual;
use actuator::ActuatorDraft;
use body::BodyDraft;
use context::{Context, Record};
use defects::Origin;
use gearing::GearingDraft;
use joint::JointDraft;
use legs::Expansion;
use motion::Files;
use names::Names;
use spring::{AnySpring, SpringDraft};
use std::sync::Arc;
use stiction_core::dynamics::FrictionMode;
use stiction_core::mechanism::{BodyId, GROUND_NAME, JointId, Mechanism, MechanismBuilder};

/// Reads a model from the text of a model file.
///
/// `files` returns the contents of a file named by a motion, or the reason for a failure. The name
/// is passed as written, relative to the model's file.
///
/// # Errors
/// All errors of the text, each with its place.
pub fn read(
    source: &Source,
    files: &dyn Fn(&str) -> Result<Contents, String>,
) -> Result<ModelFile, Diagnostics> {
    let source = Arc::new(source.clone());
    let mut out = Diagnostics::new();
    let model = document::parse(&source, &mut out)
        .and_then(|document| read_document(&source, &document, files, &mut out));
    completed(model, out)
}

fn completed(model: Option<ModelFile>, mut out: Diagnostics) -> Result<ModelFile, Diagnostics> {
    out.sort();
    match model {
        Some(model) if !out.has_errors() => Ok(ModelFile { warnings: out, ..model }),
        _ => Err(out),
    }
}

fn read_document(
    source: &Arc<Source>,
    document: &Document,
    files: Files<'_>,
    out: &mut Diagnostics,
) -> Option<ModelFile> {
    let Document { root, broken } = document;
    if root.entries.is_empty() && broken.is_empty() {
        out.push(
            Diagnostic::error("syntax", "the file is empty")
                .at(Place::new(source, 0..0), "")
                .help("a model needs `gravity`, [bodies.NAME] and [joints.NAME]"),
        );
        return None;
    }
    let parameters = match root.get("parameters").and_then(Value::as_table) {
        Some(table) => parameters::read_parameters(table, source, broken, out),
        None => Parameters::default(),
    };
    let context = Context::new(source, &parameters, broken);
    // Errors that are already known suppress warnings about their consequences.
    context.out.replace(std::mem::take(out));
    let model = read_model(&context, root, files);
    *out = context.out.into_inner();
    model.map(|model| ModelFile { parameters, ..model })
}

fn read_model(context: &Context<'_>, table: &Table, files: Files<'_>) -> Option<ModelFile> {
    let record = Record::new(context, table, MODEL, "the model");
    // Reports a value that is not a table; the content of the table is read elsewhere.
    record.table("parameters");
    let parts = Parts::read(&record);
    let names = parts.names();
    let mechanism = parts.build(&record, &names);

    let initial_poses = parts.initial_poses();
    let assembly = mechanism
        .as_ref()
        .map(|mechanism| motion::Assembly { mechanism, initial_poses: &initial_poses });
    let motions = read_motions(&record, (&names, assembly), files);
    let loads = read_loads(&record, &names, &motions);
    let default =
        record.table("default").map(|table| Record::new(context, table, DEFAULT, "`default`"));
    let default_name = |key: &str, known: Vec<&str>| {
        let default = default.as_ref()?;
        let name = default.text(key)?;
        if !known.contains(&name) {
            let kinds = format!("{key}s");
            context.unknown_name(&default.span(key), key, &kinds, name, known);
        }
        Some(name.to_owned())
    };
    // All names in the text, including those of defective parts.
    let keys = |key: &str| match table.get(key).and_then(Value::as_table) {
        Some(table) => table.entries.iter().map(|(key, _)| key.name.as_str()).collect(),
        None => Vec::new(),
    };
    let default_motion = default_name("motion", keys("motions"));
    let default_load = default_name("load", keys("loads"));
    let mode = default.as_ref().and_then(|default| default.choice("friction"));
    let default_friction = mode.map(|mode| match mode {
        "off" => FrictionMode::Off,
        "one-pass" => FrictionMode::OnePass,
        _ => FrictionMode::Converged,
    });
    let mechanism = mechanism?;
    // In a text with errors, a part that looks suspicious may merely be incomplete.
    if !context.out.borrow().has_errors() {
        parts.origin(&record, &names).warn(&mechanism.warnings());
    }
    Some(ModelFile {
        name: parts.name.clone(),
        title: title_with_changes(record.line("title"), &context.source),
        source: record.line("source"),
        mechanism,
        initial_poses,
        motions,
        loads,
        default_motion,
        default_load,
        default_friction,
        legs: parts.legs(&names),
        visuals: parts.visuals(),
        warnings: Diagnostics::new(),
        parameters: Parameters::default(),
    })
}

/// Appends the changes of the text to the title, because all results show the title.
fn title_with_changes(title: String, source: &Source) -> String {
    let Some(changes) = source.changes() else { return title };
    let changes: Vec<&str> = changes.text.lines().map(str::trim).collect();
    let comma = if title.is_empty() { "" } else { ", " };
    format!("{title}{comma}with {}", changes.join(", "))
}

fn read_motions(
    record: &Record<'_>,
    names: (&Names, Option<motion::Assembly<'_>>),
    files: Files<'_>,
) -> Vec<(String, Motion)> {
    let read = |(key, table): (&document::Key, &Table)| {
        let motion = motion::read(record.context, names, table, files)?;
        Some((key.name.clone(), motion))
    };
    record.tables("motions").into_iter().filter_map(read).collect()
}

fn read_loads(
    record: &Record<'_>,
    names: &Names,
    motions: &[(String, Motion)],
) -> Vec<(String, LoadCase)> {
    let loads: Vec<_> = record
        .tables("loads")
        .into_iter()
        .map(|(key, table)| (key.name.clone(), load::read(record.context, names, table)))
        .collect();
    // Loads are evaluated at the times of motions.
    for (_, load) in &loads {
        for (_, motion) in motions {
            motion::check_load(record.context, load, motion);
        }
    }
    loads
}

/// Returns the table of a part of type `kind`, such as `joints`. For names with unquoted dots, such
/// as `[joints.leg1.R]` instead of `[joints."leg1.R"]`, reports the error and returns the table of
/// each part.
fn dotted<'a>(
    context: &Context<'_>,
    kind: &str,
    key: &'a document::Key,
    table: &'a Table,
    fields: &[Field],
) -> Vec<(document::Key, &'a Table)> {
    let is_name = |(inner, value): &&(document::Key, Value)| {
        let is_key = fields.iter().any(|field| field.key == inner.name);
        value.as_table().is_some() && !is_key
    };
    let own = table.entries.iter().any(|entry| !is_name(&entry));
    if own || table.entries.is_empty() {
        return vec![(key.clone(), table)];
    }
    let meant = |(inner, value): &'a (document::Key, Value)| {
        let name = format!("{}.{}", key.name, inner.name);
        context.push(
            Diagnostic::error("name", "a name with a dot must be quoted")
                .at(context.place(&inner.span), "read as a nested table")
                .help(format!("write [{kind}.{name:?}]")),
        );
        Some((document::Key { name, span: inner.span.clone() }, value.as_table()?))
    };
    table.entries.iter().filter_map(meant).collect()
}

/// Bodies, joints, springs, drive trains and gearings of a model, including those of legs.
struct Parts {
    name: String,
    bodies: Vec<BodyDraft>,
    joints: Vec<JointDraft>,
    springs: Vec<SpringDraft>,
    actuators: Vec<ActuatorDraft>,
    gearings: Vec<GearingDraft>,
    legs: Vec<legs::LegDraft>,
    /// True if some legs are invalid.
    lost_legs: bool,
}

impl Parts {
    fn read(record: &Record<'_>) -> Self {
        let context = record.context;
        let mut bodies = Vec::new();
        let tables = |kind: &str, fields| -> Vec<(document::Key, &Table)> {
            let tables = record.tables(kind).into_iter();
            tables.flat_map(|(key, table)| dotted(context, kind, key, table, fields)).collect()
        };
        for (key, table) in tables("bodies", BODY) {
            // The name of the ground is reserved; this is reported elsewhere.
            if key.name != GROUND_NAME {
                names::check(context, &key.name, &key.span, "body");
            }
            let what = format!("body {}", quoted(&key.name));
            bodies.push(body::read(context, key.name.clone(), &key, table, &what));
        }
        let mut joints = Vec::new();
        for (key, table) in tables("joints", JOINT) {
            names::check(context, &key.name, &key.span, "joint");
            let what = format!("joint {}", quoted(&key.name));
            let name = key.name.clone();
            joints.push(joint::read(context, name, &key.span, table, None, &what));
        }
        let mut actuators = Vec::new();
        for (key, table) in tables("actuators", ACTUATOR) {
            names::check(context, &key.name, &key.span, "actuator");
            let what = format!("actuator {}", quoted(&key.name));
            let name = (key.name.clone(), &key.span);
            actuators.push(actuator::read(context, name, table, None, &what));
        }
        let legs = record.value("legs").map(|value| legs::read(context, value));
        let expansion = legs.unwrap_or_default();
        let Expansion { legs, lost: lost_legs, .. } = expansion;
        bodies.extend(expansion.bodies);
        joints.extend(expansion.joints);
        actuators.extend(expansion.actuators);
        let mut springs = Vec::new();
        for (key, table) in tables("springs", SPRING) {
            names::check(context, &key.name, &key.span, "spring");
            let what = format!("spring {}", quoted(&key.name));
            springs.push(spring::read(context, &key, table, &joints, &what));
        }
        springs.extend(expansion.springs.iter().map(|spring| spring.read(context, &joints)));
        for (key, table) in tables("bushings", BUSHING) {
            names::check(context, &key.name, &key.span, "bushing");
            let what = format!("bushing {}", quoted(&key.name));
            springs.push(bushing::read(context, &key, table, &what));
        }
        let mut gearings = Vec::new();
        for (key, table) in tables("gearings", GEARING) {
            names::check(context, &key.name, &key.span, "gearing");
            let what = format!("gearing {}", quoted(&key.name));
            let type_of = |name: &str| {
                joints.iter().find(|joint| joint.name == name).and_then(|joint| joint.joint_type)
            };
            gearings.push(gearing::read(context, &key, table, &what, type_of));
        }
        let file = context.source.name.rsplit(['/', '\\']).next().unwrap_or_default();
        let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
        let name = record.text("name").unwrap_or(stem).to_owned();
        Self { name, bodies, joints, springs, actuators, gearings, legs, lost_legs }
    }

    fn names(&self) -> Names {
        Names::new(
            self.bodies.iter().map(|body| body.name.as_str()),
            self.joints.iter().map(|joint| (joint.name.as_str(), joint.joint_type)),
        )
        .with_lost_legs(self.lost_legs)
    }

    /// Builds the mechanism and reports its defects.
    fn build(&self, record: &Record<'_>, names: &Names) -> Option<Mechanism> {
        let context = record.context;
        let origin = self.origin(record, names);
        let mut builder = MechanismBuilder::new(self.name.as_str());
        if let Some(gravity) = record.vector("gravity") {
            builder = builder.gravity(gravity);
        }
        if let Some(length) = record.quantity("characteristic_length") {
            builder = builder.characteristic_length(length);
        }
        let base = record.table("base").and_then(|table| context.pose(table, "`base`"));
        if let Some(base) = base {
            builder = builder.base(base);
        }
        for body in &self.bodies {
            builder = builder.body(body.spec.clone());
        }
        for spec in self.joints.iter().filter_map(|joint| joint.spec.clone()) {
            builder = builder.joint(spec);
        }
        for spec in self.springs.iter().filter_map(|spring| spring.spec.clone()) {
            builder = match spec {
                AnySpring::Straight(spec) => builder.spring(spec),
                AnySpring::OnJoint(spec) => builder.joint_spring(spec),
                AnySpring::Bushing(spec) => builder.bushing(*spec),
            };
        }
        for spec in self.actuators.iter().filter_map(|actuator| actuator.spec.clone()) {
            builder = builder.drive_train(spec);
        }
        for spec in self.gearings.iter().filter_map(|gearing| gearing.spec.clone()) {
            builder = builder.gearing(spec);
        }
        match builder.build() {
            Ok(mechanism) => Some(mechanism),
            Err(defects) => {
                origin.report(&defects);
                None
            }
        }
    }

    fn origin<'a>(&'a self, record: &Record<'a>, names: &'a Names) -> Origin<'a> {
        Origin {
            context: record.context,
            bodies: &self.bodies,
            joints: &self.joints,
            springs: &self.springs,
            actuators: &self.actuators,
            gearings: &self.gearings,
            names,
            length: record.span("characteristic_length"),
        }
    }

    fn initial_poses(&self) -> Vec<(BodyId, stiction_core::spatial::Pose<f64>)> {
        let home = |(i, body): (usize, &BodyDraft)| Some((BodyId(i + 1), body.home?));
        self.bodies.iter().enumerate().filter_map(home).collect()
    }

    fn visuals(&self) -> Vec<Visual> {
        let of_body = |(i, body): (usize, &BodyDraft)| {
            let visual = |draft: &body::VisualDraft| Visual {
                body: BodyId(i + 1),
                file: draft.file.clone(),
                scale: draft.scale,
                pose: draft.pose,
                mesh: None,
                place: draft.place.clone(),
            };
            body.visuals.iter().map(visual).collect::<Vec<_>>()
        };
        self.bodies.iter().enumerate().flat_map(of_body).collect()
    }

    fn legs(&self, names: &Names) -> Vec<Leg> {
        let joint = |name: &String| names.joint(name).map(|(id, _)| id);
        let leg = |leg: &legs::LegDraft| Leg {
            name: leg.name.clone(),
            joints: leg.joints.iter().filter_map(joint).collect::<Vec<JointId>>(),
            bodies: leg.bodies.iter().filter_map(|name| names.body(name)).collect(),
        };
        self.legs.iter().map(leg).collect()
    }
}
