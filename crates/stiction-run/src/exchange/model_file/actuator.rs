//! Tables of a model file that describe drive trains.

use stiction_core::mechanism::{DriveTrain, GearLoss, GearedDof, Mechanism, RotorAxis};
use toml::{Table, Value};

/// Returns the name and the table of a drive train.
pub(in crate::exchange) fn table(mechanism: &Mechanism, train: &DriveTrain) -> (String, Table) {
    let name = |driven: &GearedDof| mechanism.joints()[driven.joint.0].dof_name(driven.dof);
    let mut table = Table::new();
    let mut put = |key: &str, value: Value| table.insert(key.to_owned(), value);
    let numbers = |entries: &[(&str, Option<f64>)]| {
        let given = entries.iter().filter_map(|(key, value)| Some(((*key).to_owned(), (*value)?)));
        Value::Table(given.map(|(key, value)| (key, Value::from(value))).collect())
    };
    match &train.dofs[..] {
        [only] => put("joint", name(only).into()),
        several => {
            let each = several.iter().map(|driven| (name(driven), driven.coefficient.into()));
            put("joints", Value::Table(each.collect()))
        }
    };
    put("ratio", train.ratio.into());
    if let Some(lead) = train.lead {
        put("lead", lead.into());
    }
    if train.share != 1.0 {
        put("share", train.share.into());
    }
    put("rotor_inertia", train.rotor_inertia.into());
    if let Some(RotorAxis { body, axis }) = train.rotor_axis {
        let body = mechanism.bodies()[body.0].name.as_str();
        let axis = Value::Array(axis.to_array().map(Value::from).to_vec());
        let entries = [("body".to_owned(), body.into()), ("axis".to_owned(), axis)];
        put("rotor_axis", Value::Table(entries.into_iter().collect()));
    }
    match train.gear {
        GearLoss::Efficiency { forward, backward } => {
            put("efficiency", forward.into());
            put("backward_efficiency", backward.into());
        }
        GearLoss::Mesh(mesh) => {
            let entries = [
                ("mu", Some(mesh.mu)),
                ("lead_angle", Some(mesh.lead_angle)),
                ("flank_angle", Some(mesh.flank_angle)),
            ];
            put("mesh", numbers(&entries));
        }
    }
    let friction = train.motor_friction;
    let entries = [("constant", Some(friction.constant)), ("viscous", Some(friction.viscous))];
    put("motor_friction", numbers(&entries));
    if let Some(constant) = train.torque_constant {
        put("torque_constant", constant.into());
    }
    let limits = train.limits;
    let entries = [("peak", limits.peak), ("rated", limits.rated), ("speed", limits.speed)];
    if entries.iter().any(|(_, value)| value.is_some()) {
        put("limits", numbers(&entries));
    }
    (train.name.clone(), table)
}
