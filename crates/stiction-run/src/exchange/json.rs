//! JSON description of a mechanism in SI units, from which other programs can build the mechanism.

use super::Home;
use serde_json::{Value, json};
use std::fmt::{self, Write};
use stiction_core::friction::{
    Combine, Curve, InterfaceShape, JointFriction, Law, NormalLoadMap, Supports, interfaces_of,
};
use stiction_core::joint::Motion;
use stiction_core::mechanism::{
    Body, BodyId, Compliance, DriveTrain, GearedDof, Joint, JointRange, Mechanism, Spring,
};
use stiction_core::spatial::{Mat3, Pose};

/// Version of the JSON format; it is increased when the meaning of a key changes.
const VERSION: u32 = 1;

/// Describes the assembled mechanism as a JSON object. The relative pose of two frames is the pose
/// of the second frame in the first. A rotation is a list of matrix rows; the columns of the matrix
/// are the axes of the second frame.
pub fn json(home: &Home<'_>) -> Value {
    let mechanism = &home.model.mechanism;
    let name_of = |body: BodyId| mechanism.bodies()[body.0].name.as_str();
    let bodies = mechanism.bodies().iter().zip(&home.poses);
    let joints = mechanism.joints().iter().zip(&home.coordinates).map(|(joint, coordinates)| {
        json!({
            "name": joint.name,
            "type": joint.joint_type.symbol(),
            "from": name_of(joint.predecessor),
            "to": name_of(joint.successor),
            "frame_from": pose_json(&joint.frame_j),
            "frame_to": pose_json(&joint.frame_k),
            "pitch": joint.pitch,
            "dofs": dofs_json(joint, coordinates),
            "friction": joint.friction.iter().map(|c| interface_json(joint, c)).collect::<Vec<_>>(),
            "compliance": joint.compliance.as_ref().map(compliance_json),
            "ranges": joint.ranges.iter().map(|range| range_json(joint, range)).collect::<Vec<_>>(),
        })
    });
    let spring = |spring: &Spring| {
        let mut value = json!({
            "name": spring.name,
            "from": name_of(spring.ends[0]),
            "to": name_of(spring.ends[1]),
            "point_from": spring.points[0].to_array(),
            "point_to": spring.points[1].to_array(),
            "stiffness": spring.stiffness,
            "free_length": spring.free_length,
            "damping": spring.damping,
        });
        // Only springs with a preload or a stroke have these entries.
        if spring.preload != 0.0 {
            value["preload"] = json!(spring.preload);
        }
        if let Some((least, greatest)) = spring.lengths {
            value["lengths"] = json!([least, greatest]);
        }
        value
    };
    let mut value = json!({
        "format": "stiction-mechanism",
        "version": VERSION,
        "program": { "name": "stiction", "version": env!("CARGO_PKG_VERSION") },
        "name": home.model.name,
        "title": home.model.title,
        "units": "SI: s, m, rad, kg, N, N m",
        "gravity": mechanism.gravity().to_array(),
        "base": pose_json(&mechanism.base()),
        "characteristic_length": mechanism.characteristic_length(),
        "bodies": bodies.map(|(body, home)| body_json(body, home)).collect::<Vec<_>>(),
        "joints": joints.collect::<Vec<_>>(),
        "springs": mechanism.springs().iter().map(spring).collect::<Vec<_>>(),
    });
    // Only mechanisms with springs on joints have these entries.
    if !mechanism.joint_springs().is_empty() {
        let each = mechanism.joint_springs().iter().map(|spring| {
            json!({
                "name": spring.name,
                "freedom": mechanism.joints()[spring.joint.0].dof_name(spring.dof),
                "stiffness": spring.stiffness,
                "rest": spring.rest,
                "preload": spring.preload,
                "damping": spring.damping,
            })
        });
        value["joint_springs"] = each.collect();
    }
    if !mechanism.bushings().is_empty() {
        let each = mechanism.bushings().iter().map(|bushing| {
            json!({
                "name": bushing.name,
                "from": name_of(bushing.ends[0]),
                "to": name_of(bushing.ends[1]),
                "frame_from": pose_json(&bushing.frames[0]),
                "frame_to": pose_json(&bushing.frames[1]),
                "stiffness": bushing.stiffness,
                "damping": bushing.damping,
            })
        });
        value["bushings"] = each.collect();
    }
    // Only mechanisms with drive trains have this entry.
    if !mechanism.drive_trains().is_empty() {
        let each = mechanism.drive_trains().iter().map(|train| drive_train_json(mechanism, train));
        value["actuators"] = each.collect();
    }
    // Only mechanisms with gearings have this entry.
    if !mechanism.gearings().is_empty() {
        let each = mechanism.gearings().iter().map(|gearing| {
            json!({
                "name": gearing.name,
                "joints": gearing.dofs.iter().map(|dof| dof_json(mechanism, dof)).collect::<Value>(),
                "offset": gearing.offset,
            })
        });
        value["gearings"] = each.collect();
    }
    value
}

fn dof_json(mechanism: &Mechanism, geared: &GearedDof) -> Value {
    let joint = &mechanism.joints()[geared.joint.0];
    json!({
        "joint": joint.name,
        "freedom": joint.joint_type.dofs()[geared.dof].name,
        "coefficient": geared.coefficient,
    })
}

fn drive_train_json(mechanism: &Mechanism, train: &DriveTrain) -> Value {
    let (efficiency, backward_efficiency) = train.gear.efficiencies();
    let (friction, limits) = (train.motor_friction, train.limits);
    let mut value = json!({
        "name": train.name,
        "transmission": train.transmission(),
        "share": train.share,
        "rotor_inertia": train.rotor_inertia,
        "rotor_axis": train.rotor_axis.map(|rotor| {
            json!({ "body": mechanism.bodies()[rotor.body.0].name, "axis": rotor.axis.to_array() })
        }),
        "efficiency": efficiency,
        "backward_efficiency": backward_efficiency,
        "motor_friction": { "constant": friction.constant, "viscous": friction.viscous },
        "torque_constant": train.torque_constant,
        "limits": { "peak": limits.peak, "rated": limits.rated, "speed": limits.speed },
    });
    if let [only] = &train.dofs[..] {
        let only = dof_json(mechanism, only);
        value["joint"] = only["joint"].clone();
        value["freedom"] = only["freedom"].clone();
    } else {
        value["joints"] = train.dofs.iter().map(|dof| dof_json(mechanism, dof)).collect();
        value["lead"] = json!(train.lead);
    }
    value
}

/// Returns the description of the mechanism as JSON text, with each vector and matrix on one line.
pub fn json_text(home: &Home<'_>) -> String {
    let mut text = String::new();
    // Writing to a string does not fail.
    let _ = write_value(&mut text, &json(home), 0);
    text + "\n"
}

fn write_value(out: &mut String, value: &Value, depth: usize) -> fmt::Result {
    let items: Vec<(Option<&str>, &Value)> = match value {
        Value::Array(items) if !items.iter().all(is_numeric) => {
            items.iter().map(|item| (None, item)).collect()
        }
        Value::Object(entries) => {
            entries.iter().map(|(key, entry)| (Some(key.as_str()), entry)).collect()
        }
        // Every comma in an array of numbers is a separator, so a space can be added after it.
        Value::Array(_) => return out.write_str(&value.to_string().replace(',', ", ")),
        _ => return write!(out, "{value}"),
    };
    let (open, close) = if value.is_array() { ('[', ']') } else { ('{', '}') };
    out.write_char(open)?;
    for (k, (key, item)) in items.into_iter().enumerate() {
        let comma = if k == 0 { "" } else { "," };
        write!(out, "{comma}\n{:1$}", "", 2 * depth + 2)?;
        if let Some(key) = key {
            write!(out, "{}: ", Value::from(key))?;
        }
        write_value(out, item, depth + 1)?;
    }
    write!(out, "\n{:1$}{close}", "", 2 * depth)
}

/// Returns true if a value is a number or a nested list of numbers.
fn is_numeric(value: &Value) -> bool {
    match value {
        Value::Number(_) => true,
        Value::Array(items) => items.iter().all(is_numeric),
        _ => false,
    }
}

fn rows(matrix: &Mat3<f64>) -> [[f64; 3]; 3] {
    std::array::from_fn(|i| std::array::from_fn(|j| matrix.at(i, j)))
}

fn pose_json(pose: &Pose<f64>) -> Value {
    json!({ "position": pose.position.to_array(), "rotation": rows(&pose.rotation) })
}

fn body_json(body: &Body, home: &Pose<f64>) -> Value {
    json!({
        "name": body.name,
        "mass": body.mass,
        "com": body.com.to_array(),
        "inertia": rows(&body.inertia),
        "home": pose_json(home),
    })
}

fn dofs_json(joint: &Joint, coordinates: &[Option<f64>]) -> Value {
    let dofs = joint.joint_type.dofs().iter().zip(&joint.actuated).zip(coordinates);
    let dof = dofs.map(|((dof, actuated), coordinate)| {
        let kind = match dof.motion {
            Motion::Rotation => "rotation",
            Motion::Translation => "translation",
            Motion::Screw => "screw",
        };
        json!({
            "name": dof.name,
            "kind": kind,
            "actuated": actuated,
            "coordinate": coordinate,
        })
    });
    dof.collect()
}

fn interface_json(joint: &Joint, interface: &JointFriction) -> Value {
    let (place, shape) = interfaces_of(joint.joint_type)[interface.place];
    let word = match shape {
        InterfaceShape::Pin { .. } => "pin",
        InterfaceShape::Guide { .. } => "guide",
        InterfaceShape::Thread => "thread",
        InterfaceShape::Sleeve => "sleeve",
        InterfaceShape::Ball => "ball",
        InterfaceShape::Plate => "plate",
        InterfaceShape::Shaft { .. } => "shaft",
    };
    let dofs = joint.joint_type.dofs()[shape.dofs()].iter().map(|f| f.name);
    json!({
        "place": place,
        "shape": word,
        "dofs": dofs.collect::<Vec<_>>(),
        "radius": interface.radius,
        "law": law_json(&interface.law),
        "backward": interface.backward.as_ref().map(law_json),
        "load": load_json(&interface.load),
    })
}

fn law_json(law: &Law) -> Value {
    let curve = match &law.curve {
        Curve::Constant => json!({ "kind": "constant" }),
        Curve::Static { mu_static } => {
            json!({ "kind": "static", "mu_static": mu_static })
        }
        Curve::Stribeck { mu_static, velocity, exponent } => json!({
            "kind": "stribeck",
            "mu_static": mu_static,
            "velocity": velocity,
            "exponent": exponent.value(),
        }),
        Curve::Table(rows) => json!({ "kind": "table", "rows": rows }),
    };
    let bristles = law
        .bristles
        .map(|bristles| json!({ "stiffness": bristles.stiffness, "damping": bristles.damping }));
    json!({
        "mu": law.mu,
        "viscous": law.viscous,
        "curve": curve,
        "regularisation": law.regularisation,
        "bristles": bristles,
    })
}

fn load_json(load: &NormalLoadMap<f64>) -> Value {
    let combine = match load.combine {
        Combine::Sum => "sum",
        Combine::Pads => "pads",
        Combine::RootSumSquare => "root-sum-square",
    };
    let supports = match load.supports {
        Supports::Predecessor => json!({ "on": "from" }),
        Supports::Successor => json!({ "on": "to" }),
        Supports::OneOnEach { gland, piston } => {
            json!({ "on": "one-on-each", "gland": gland, "piston": piston })
        }
    };
    json!({
        "bending_span": load.bending_span,
        "axial_ratio": load.axial_ratio,
        "torsion_arm": load.torsion_arm,
        "preload": load.preload,
        "combine": combine,
        "supports": supports,
        "flank_cosine": load.flank_cosine,
        "smoothing": load.smoothing,
    })
}

fn range_json(joint: &Joint, range: &JointRange) -> Value {
    let (least, greatest) = range.limits;
    json!({ "name": joint.range_name(range.of), "limits": [least, greatest] })
}

fn compliance_json(compliance: &Compliance) -> Value {
    compliance.parts().into_iter().map(|(name, value)| (name.to_owned(), json!(value))).collect()
}
