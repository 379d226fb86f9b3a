//! Text of a model file that describes a given mechanism. All legs are written in full, and
//! expressions are replaced by their values.

pub(super) mod actuator;
pub(super) mod friction;
pub(super) mod joint;
pub(super) mod spring;

use crate::job::friction_word;
use stiction_core::dynamics::{AppliedLoad, FrictionMode, LoadAxes};
use stiction_core::kinematics::{Coordinate, Target};
use stiction_core::mechanism::{Body, Gearing, Mechanism};
use stiction_core::spatial::{Mat3, Pose, Vec3};
use thiserror::Error;
use toml::{Table, Value};

/// Error: a model file cannot express a joint. The error cannot occur for mechanisms that were read
/// from a model file.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum Unwritable {
    /// The laws of the forward and the backward friction of the joint with this name differ in kind.
    #[error(
        "the backward friction of `{0}` differs in kind from its forward friction, which a model \
         file cannot express"
    )]
    BackwardFriction(String),
    /// The ranges of the spherical joint with this name are measured from an axis other than the z
    /// axis of its body.
    #[error(
        "the ranges of the spherical joint `{0}` are not about the z axis of its body, which a \
         model file cannot express"
    )]
    TiltedRange(String),
}

/// Motion, loads and friction mode that a model file contains in addition to the mechanism.
#[derive(Clone, Copy, Debug, Default)]
pub struct Instant<'a> {
    /// Prescribed coordinates. They define the motion `here` of the file: a polynomial of second order in time, with
    /// zero duration.
    pub motion: &'a [(Coordinate, Target<f64>)],
    /// External loads, which the file contains as the load case `here`.
    pub loads: &'a [AppliedLoad<f64>],
    /// Friction mode that the file sets as its default; `None` sets no default.
    pub friction: Option<FrictionMode>,
}

/// Writes the text of a model file. Numbers are in SI units and are unchanged when the file is read
/// again. The [`start`](stiction_core::mechanism::Joint::start) of each joint is its initial guess
/// for the assembly; [`Mechanism::starting_at`] sets it to an assembled position.
///
/// The file contains no axes for spherical, fixed and free joints: their frame J is parallel to the
/// frame of the body, so that the components of their reactions refer to other axes than in
/// `mechanism`. In a joint with several friction interfaces, each interface without friction is
/// written with a coefficient of zero.
///
/// # Errors
/// Returns [`Unwritable`] if a model file cannot express a joint of the mechanism.
pub fn model_file(
    mechanism: &Mechanism,
    title: &str,
    instant: Instant<'_>,
) -> Result<String, Unwritable> {
    let mut file = Table::new();
    let mut put = |key: &str, value: Value| file.insert(key.to_owned(), value);
    put("name", mechanism.name().into());
    if !title.is_empty() {
        put("title", title.into());
    }
    put("gravity", vector(mechanism.gravity()));
    put("characteristic_length", mechanism.characteristic_length().into());
    if mechanism.base() != Pose::identity() {
        put("base", pose(mechanism.base()));
    }
    let bodies = mechanism.bodies().iter().skip(1);
    put("bodies", named(bodies.map(|body| (body.name.clone(), body_table(body)))));
    let mut joints = Table::new();
    for written in mechanism.joints() {
        joints.insert(written.name.clone(), joint::table(mechanism, written)?.into());
    }
    put("joints", joints.into());
    if !(mechanism.springs().is_empty() && mechanism.joint_springs().is_empty()) {
        put("springs", named(spring::tables(mechanism)));
    }
    if !mechanism.bushings().is_empty() {
        put("bushings", named(spring::bushing_tables(mechanism)));
    }
    if !mechanism.drive_trains().is_empty() {
        let trains = mechanism.drive_trains().iter();
        put("actuators", named(trains.map(|train| actuator::table(mechanism, train))));
    }
    if !mechanism.gearings().is_empty() {
        put("gearings", named(mechanism.gearings().iter().map(|g| gearing_table(mechanism, g))));
    }
    let here = |table: Table| named([("here".to_owned(), table)]);
    let mut default = Table::new();
    if !instant.motion.is_empty() {
        put("motions", here(motion_table(mechanism, instant.motion)));
        default.insert("motion".into(), "here".into());
    }
    if !instant.loads.is_empty() {
        put("loads", here(load_table(mechanism, instant.loads)));
        default.insert("load".into(), "here".into());
    }
    if let Some(mode) = instant.friction {
        default.insert("friction".into(), friction_word(mode).into());
    }
    if !default.is_empty() {
        put("default", default.into());
    }
    Ok(file.to_string())
}

/// Returns the name and the table of a gearing.
pub(super) fn gearing_table(mechanism: &Mechanism, gearing: &Gearing) -> (String, Table) {
    let each = gearing.dofs.iter().map(|geared| {
        let name = mechanism.joints()[geared.joint.0].dof_name(geared.dof);
        (name, Value::from(geared.coefficient))
    });
    let joints = Value::Table(each.collect());
    let entries = [("joints".to_owned(), joints), ("offset".to_owned(), gearing.offset.into())];
    (gearing.name.clone(), entries.into_iter().collect())
}

fn named(tables: impl IntoIterator<Item = (String, Table)>) -> Value {
    Value::Table(tables.into_iter().map(|(name, table)| (name, Value::Table(table))).collect())
}

fn vector(v: Vec3<f64>) -> Value {
    Value::Array(v.to_array().map(Value::from).into())
}

/// Describes a rotation by its axis and its angle, rad.
fn rotation(rotation: Mat3<f64>) -> Value {
    let turn = rotation.rotation_vector();
    let angle = turn.norm();
    let axis = if angle > 0.0 { turn * angle.recip() } else { Vec3::unit(2) };
    let entries = [("axis".to_owned(), vector(axis)), ("angle".to_owned(), angle.into())];
    Value::Table(entries.into_iter().collect())
}

fn pose(pose: Pose<f64>) -> Value {
    let entries = [
        ("position".to_owned(), vector(pose.position)),
        ("rotation".to_owned(), rotation(pose.rotation)),
    ];
    Value::Table(entries.into_iter().collect())
}

fn body_table(body: &Body) -> Table {
    let mut table = Table::new();
    if body.mass == 0.0 && body.inertia == Mat3::zero() {
        return table;
    }
    table.insert("mass".into(), body.mass.into());
    table.insert("com".into(), vector(body.com));
    let entries =
        [("xx", 0, 0), ("yy", 1, 1), ("zz", 2, 2), ("xy", 0, 1), ("xz", 0, 2), ("yz", 1, 2)];
    let inertia: Table = entries
        .into_iter()
        .map(|(key, i, j)| (key.to_owned(), Value::from(body.inertia.at(i, j))))
        .collect();
    table.insert("inertia".into(), inertia.into());
    table
}

fn motion_table(mechanism: &Mechanism, motion: &[(Coordinate, Target<f64>)]) -> Table {
    let mut table = Table::new();
    table.insert("duration".into(), 0.0.into());
    let body_name = |body: stiction_core::mechanism::BodyId| &mechanism.bodies()[body.0].name;
    const AXES: [char; 3] = ['x', 'y', 'z'];
    for &(coordinate, target) in motion {
        let name = match coordinate {
            Coordinate::Position { body, axis } => format!("{}.{}", body_name(body), AXES[axis]),
            Coordinate::RotationVector { body, axis } => {
                format!("{}.rv{}", body_name(body), AXES[axis])
            }
            Coordinate::Angle { body, order, index } => {
                let order: String = order.axes().into_iter().map(|axis| AXES[axis]).collect();
                table.insert(format!("{}.order", body_name(body)), order.into());
                format!("{}.r{}", body_name(body), index + 1)
            }
            Coordinate::Joint { joint, dof } => mechanism.joints()[joint.0].dof_name(dof),
        };
        let is_angle = coordinate
            .is_angle(&mechanism.joints().iter().map(|joint| joint.joint_type).collect::<Vec<_>>());
        let unit = if is_angle { "rad" } else { "m" };
        let Target { value, rate, acceleration } = target;
        let text = format!(
            "{value:?} {unit} + {rate:?} {unit}/s*t + {:?} {unit}/s^2*t^2",
            0.5 * acceleration
        );
        // The model file cannot contain `a + -b`, because a minus after a plus sign would bind
        // tighter than the unit; `a - b` is written instead.
        table.insert(name, text.replace("+ -", "- ").into());
    }
    table
}

fn load_table(mechanism: &Mechanism, loads: &[AppliedLoad<f64>]) -> Table {
    let table = |load: &AppliedLoad<f64>| {
        let axes = match load.axes {
            LoadAxes::World => "world",
            LoadAxes::Body => "body",
        };
        let entries = [
            ("force", vector(load.force)),
            ("moment", vector(load.moment)),
            ("at", vector(load.point)),
            ("axes", axes.into()),
        ];
        entries.into_iter().map(|(key, value)| (key.to_owned(), value)).collect::<Table>()
    };
    let name = |load: &AppliedLoad<f64>| mechanism.bodies()[load.body.0].name.clone();
    loads.iter().map(|load| (name(load), Value::Table(table(load)))).collect()
}
