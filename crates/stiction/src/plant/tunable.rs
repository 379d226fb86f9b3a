//! Friction coefficients and masses of a plant that can be changed while it runs.

use crate::error::Error;
use stiction_core::friction::{Curve, JointFriction};
use stiction_core::mechanism::{JointId, Mechanism};

/// Kind of coefficient of a friction law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Coefficient {
    /// Coefficient of sliding friction.
    Mu,
    /// Coefficient of static friction.
    MuStatic,
    /// Viscous coefficient, N s/m.
    Viscous,
}

/// A tunable parameter of a mechanism.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Tunable {
    /// Friction coefficient of a joint: the joint, the index of the friction interface in the
    /// joint, and the kind of coefficient.
    Friction(JointId, usize, Coefficient),
    /// Mass, kg, of the body with this index. The centre of mass and the inertia about the centre
    /// of mass do not change with the mass.
    Mass(usize),
}

/// Tunable parameter, its name, and its value in the model.
pub(super) type Named = (Tunable, String, f64);

/// All tunable parameters of a mechanism. Friction coefficients that are given as a table, and
/// coefficients of interfaces with a separate law for each direction, are not tunable.
pub(super) fn tunables(mechanism: &Mechanism) -> Vec<Named> {
    let mut all = Vec::new();
    for (id, joint) in mechanism.joints().iter().enumerate() {
        for (place, (friction, name)) in
            joint.friction.iter().zip(joint.interface_names()).enumerate()
        {
            if friction.backward.is_some() {
                continue;
            }
            let mut add = |coefficient, ending: &str| {
                let value = value_of(friction, coefficient);
                let tunable = Tunable::Friction(JointId(id), place, coefficient);
                all.push((tunable, format!("{name}.{ending}"), value));
            };
            let curve = &friction.law.curve;
            if !matches!(curve, Curve::Table(_)) {
                add(Coefficient::Mu, "mu");
            }
            if matches!(curve, Curve::Static { .. } | Curve::Stribeck { .. }) {
                add(Coefficient::MuStatic, "mu_static");
            }
            add(Coefficient::Viscous, "viscous");
        }
    }
    for (body, content) in mechanism.bodies().iter().enumerate().skip(1) {
        if content.mass > 0.0 {
            all.push((Tunable::Mass(body), format!("{}.mass", content.name), content.mass));
        }
    }
    all
}

fn value_of(friction: &JointFriction, coefficient: Coefficient) -> f64 {
    match (coefficient, &friction.law.curve) {
        (Coefficient::Mu, _) => friction.law.mu,
        (Coefficient::Viscous, _) => friction.law.viscous,
        (_, Curve::Static { mu_static } | Curve::Stribeck { mu_static, .. }) => *mu_static,
        (Coefficient::MuStatic, _) => friction.law.mu,
    }
}

fn set(friction: &mut JointFriction, coefficient: Coefficient, value: f64) {
    match (coefficient, &mut friction.law.curve) {
        (Coefficient::Mu, _) => friction.law.mu = value,
        (Coefficient::Viscous, _) => friction.law.viscous = value,
        (_, Curve::Static { mu_static } | Curve::Stribeck { mu_static, .. }) => *mu_static = value,
        (Coefficient::MuStatic, _) => {}
    }
}

/// Returns the mechanism with `values` for its tunable parameters, in the order of `tunables`.
///
/// # Errors
/// A coefficient of static friction is less than that of sliding friction.
pub(super) fn tuned(
    mechanism: &Mechanism,
    tunables: &[Named],
    values: &[f64],
) -> Result<Mechanism, Error> {
    let changed = mechanism.with_changes(|parts| {
        for ((tunable, ..), value) in tunables.iter().zip(values) {
            match *tunable {
                Tunable::Friction(joint, place, coefficient) => {
                    set(&mut parts.joints[joint.0].friction[place], coefficient, *value);
                }
                Tunable::Mass(body) => parts.bodies[body].mass = *value,
            }
        }
    });
    for joint in changed.joints() {
        for (friction, name) in joint.friction.iter().zip(joint.interface_names()) {
            let (mu, at_rest) = (friction.law.mu, value_of(friction, Coefficient::MuStatic));
            if at_rest < mu && friction.backward.is_none() {
                let message = format!(
                    "the static coefficient of `{name}`, {at_rest}, is below that of sliding, {mu}"
                );
                return Err(Error::input(message).with_help("change both at the same instant"));
            }
        }
    }
    Ok(changed)
}
