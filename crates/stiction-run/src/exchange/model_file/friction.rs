//! Tables of a model file that describe joint friction.

use super::Unwritable;
use stiction_core::friction::{
    Combine, Curve, InterfaceShape, JointFriction, Law, NormalLoadMap, Supports, interfaces_of,
};
use stiction_core::mechanism::Joint;
use toml::{Table, Value};

/// Returns the table of all friction interfaces of a joint; `None` if the joint has no friction.
pub(in crate::exchange) fn table(joint: &Joint) -> Result<Option<Table>, Unwritable> {
    if joint.friction.is_empty() {
        return Ok(None);
    }
    let places = interfaces_of(joint.joint_type);
    let of_place = |place: usize| joint.friction.iter().find(|interface| interface.place == place);
    // If a joint type has only one interface, the interface has no name in the file.
    if let [interface] = &joint.friction[..]
        && places[interface.place].0.is_empty()
    {
        return interface_table(joint, interface).map(Some);
    }
    let mut all = Table::new();
    for (place, (name, shape)) in
        places.iter().enumerate().filter(|(_, (name, _))| !name.is_empty())
    {
        let interface = match of_place(place) {
            Some(interface) => interface_table(joint, interface)?,
            None => frictionless(*shape),
        };
        all.insert((*name).to_owned(), interface.into());
    }
    Ok(Some(all))
}

/// Returns the table of a frictionless interface. A joint whose other interfaces have friction
/// requires such a table.
fn frictionless(shape: InterfaceShape) -> Table {
    let mut table = Table::from_iter([("mu".to_owned(), Value::from(0.0))]);
    if shape.turns() {
        // Any radius is valid, because the coefficient is zero.
        table.insert("radius".into(), 1.0.into());
    }
    table
}

fn interface_table(joint: &Joint, interface: &JointFriction) -> Result<Table, Unwritable> {
    let mut table = law_table(&interface.law);
    if let Some(radius) = interface.radius {
        table.insert("radius".into(), radius.into());
    }
    load(&mut table, joint, interface);
    if let Some(backward) = &interface.backward {
        let backward = backward_table(&interface.law, backward)
            .ok_or_else(|| Unwritable::BackwardFriction(joint.name.clone()))?;
        table.insert("backward".into(), backward.into());
    }
    Ok(table)
}

fn law_table(law: &Law) -> Table {
    let mut table = Table::new();
    let mut put = |key: &str, value: Value| table.insert(key.to_owned(), value);
    if !matches!(law.curve, Curve::Table(_)) {
        put("mu", law.mu.into());
    }
    put("viscous", law.viscous.into());
    match &law.curve {
        Curve::Constant => {}
        Curve::Static { mu_static } => {
            put("mu_static", (*mu_static).into());
        }
        Curve::Stribeck { mu_static, velocity, exponent } => {
            put("mu_static", (*mu_static).into());
            put("stribeck_velocity", (*velocity).into());
            put("stribeck_exponent", exponent.value().into());
        }
        Curve::Table(rows) => {
            let rows = rows.iter().map(|row| Value::Array(row.map(Value::from).into()));
            put("table", rows.collect::<Vec<_>>().into());
        }
    }
    if let Some(bristles) = law.bristles {
        let has_one_parameter = bristles.damping == 0.0 && law.curve == Curve::Constant;
        put("law", if has_one_parameter { "dahl" } else { "lugre" }.into());
        put("sigma0", bristles.stiffness.into());
        if !has_one_parameter {
            put("sigma1", bristles.damping.into());
        }
    }
    if let Some(velocity) = law.regularisation {
        put("regularised", "tanh".into());
        put("regularisation_velocity", velocity.into());
    }
    table
}

/// Returns the table of the friction law for backward sliding. For a missing key, the value for
/// forward sliding applies. `None` if a model file cannot express the difference between both laws.
fn backward_table(forward: &Law, backward: &Law) -> Option<Table> {
    let shared = (forward.bristles, forward.regularisation);
    if shared != (backward.bristles, backward.regularisation) {
        return None;
    }
    let mut table = law_table(&Law { bristles: None, regularisation: None, ..backward.clone() });
    // For a constant backward law, the static coefficient inherited from the forward law must be
    // overridden.
    let mut flat = |key: &str| table.insert(key.to_owned(), backward.mu.into());
    match (&forward.curve, &backward.curve) {
        (Curve::Static { .. } | Curve::Stribeck { .. }, Curve::Constant) => {
            flat("mu_static");
        }
        (Curve::Stribeck { .. }, Curve::Static { .. }) => return None,
        _ => {}
    }
    Some(table)
}

fn load(table: &mut Table, joint: &Joint, interface: &JointFriction) {
    let NormalLoadMap {
        bending_span,
        axial_ratio,
        torsion_arm,
        preload,
        combine,
        supports,
        flank_cosine,
        smoothing,
        gear: _,
    } = interface.load;
    let mut put = |key: &str, value: Value| table.insert(key.to_owned(), value);
    let radius = interface.radius.unwrap_or(0.0);
    let numbers = [
        ("bending_span", bending_span),
        ("collar_radius", axial_ratio.map(|ratio| ratio * radius)),
        ("torsion_arm", torsion_arm),
        ("preload", (preload != 0.0).then_some(preload)),
        ("flank_angle", flank_cosine.map(|cosine| flank_angle(cosine, joint.pitch, radius))),
        ("smoothing", smoothing),
    ];
    for (key, number) in numbers {
        if let Some(number) = number {
            put(key, number.into());
        }
    }
    match combine {
        Combine::Sum => None,
        Combine::Pads => put("combine", "pads".into()),
        Combine::RootSumSquare => put("combine", "root-sum-square".into()),
    };
    match supports {
        Supports::Predecessor => None,
        Supports::Successor => put("supports", "to".into()),
        Supports::OneOnEach { gland, piston } => {
            put("gland", gland.into());
            put("piston", piston.into())
        }
    };
}

/// Computes the flank angle in the axial section of a thread, rad, as in drawings. `cosine` is the
/// cosine of the flank angle in the section normal to the thread: `tan normal = tan axial cos
/// lead`.
fn flank_angle(cosine: f64, pitch: f64, radius: f64) -> f64 {
    let lead = (pitch / radius).atan();
    (cosine.acos().tan() / lead.cos()).atan()
}
