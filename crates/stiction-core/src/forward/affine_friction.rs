//! Friction of a contact, affine in its own load.

use crate::dynamics::load_by;
use crate::friction::{Law, OwnFriction};
use crate::kinematics::Bodies;
use crate::parameters::{InterfaceParameters, Parameters};
use crate::spatial::Wrench;

/// What a contact does at the moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum InterfaceMode {
    /// Friction is a smooth function of velocity and inner state: regularised, viscous alone, or with
    /// bristles.
    Smooth,
    /// It slides. Of a contact with one freedom the first number is 1 or -1, and holds for a whole
    /// step; of others it is the direction at the surface where the velocity is too small to have one.
    Slides([f64; 3]),
    /// Friction holds it: it does not move.
    Sticks,
    /// Friction is at its limit, against the beginning of sliding in this direction, yet others hold it.
    AtLimit([f64; 3]),
}

/// The efforts of a contact's friction on its freedoms are `-(known + per_load * load)`, arms included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct AffineFriction {
    pub(super) known: [f64; 3],
    pub(super) per_load: [f64; 3],
    /// The friction as the load of a thread contains it.
    pub(super) own: OwnFriction<f64>,
}

impl AffineFriction {
    pub(super) fn none() -> Self {
        Self { known: [0.0; 3], per_load: [0.0; 3], own: OwnFriction::none() }
    }
}

pub(super) fn norm(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Whether friction is a smooth function of velocity and inner state, so that nothing ever sticks.
pub(super) fn is_smooth(interface: &InterfaceParameters<f64>) -> bool {
    let smooth = |law: &Law<f64>| {
        law.bristles.is_some()
            || law.regularisation.is_some()
            || (law.at_rest() == 0.0 && law.coefficient(0.0) == 0.0 && law.is_constant())
    };
    interface.laws().into_iter().all(smooth)
}

/// Friction at a surface velocity; `bristles` are deflections, if the law has any.
pub(super) fn rub(
    interface: &InterfaceParameters<f64>,
    pitch: f64,
    mode: InterfaceMode,
    velocity: [f64; 3],
    bristles: [f64; 3],
) -> AffineFriction {
    let single = interface.shape.has_one_dof();
    let speed = norm(velocity);
    let direction = match mode {
        InterfaceMode::Sticks => return AffineFriction::none(),
        InterfaceMode::Slides(direction) if single || speed == 0.0 => direction,
        InterfaceMode::AtLimit(direction) => direction,
        _ if single => [if velocity[0] < 0.0 { -1.0 } else { 1.0 }, 0.0, 0.0],
        // Beyond a reversal it keeps its sense for the rest of a step, as contacts with one freedom do.
        InterfaceMode::Slides(before) if dot(velocity, before) < 0.0 => {
            velocity.map(|v| -v / speed)
        }
        _ if speed > 0.0 => velocity.map(|v| v / speed),
        _ => [0.0; 3],
    };
    // Along the direction: a little negative where a step looks beyond a reversal.
    let along = dot(velocity, direction);
    let law = interface.law_towards(direction[0]);
    let resistance = match mode {
        // Where nothing holds it any more it begins to slide within a step.
        InterfaceMode::AtLimit(_) if along > 0.0 && law.slides_as_at_its_limit() => {
            law.sliding(along)
        }
        InterfaceMode::AtLimit(_) => {
            crate::friction::Resistance { coefficient: law.at_rest(), constant: 0.0 }
        }
        _ => law.sliding(along),
    };
    let mut per_load = direction.map(|d| d * resistance.coefficient);
    if let (Some(own), InterfaceMode::Smooth) = (&law.bristles, mode) {
        let rate = bristle_rate(interface, velocity, bristles);
        for i in 0..3 {
            per_load[i] = own.coefficient(bristles[i], rate[i]);
        }
    }
    let arms = interface.arms(pitch);
    let own = OwnFriction {
        coefficient: if single { per_load[0] * direction[0] } else { resistance.coefficient },
        constant: resistance.constant,
        direction: direction[0],
    };
    let mut known = direction.map(|d| d * resistance.constant);
    for i in 0..3 {
        known[i] *= arms[i];
        per_load[i] *= arms[i];
    }
    AffineFriction { known, per_load, own }
}

/// The rate of the deflections of bristles.
pub(super) fn bristle_rate(
    interface: &InterfaceParameters<f64>,
    velocity: [f64; 3],
    bristles: [f64; 3],
) -> [f64; 3] {
    let law = interface.law_towards(velocity[0]);
    let Some(own) = &law.bristles else { return [0.0; 3] };
    let speed = norm(velocity);
    let mu = law.coefficient(speed);
    let mut rate = [0.0; 3];
    for i in 0..3 {
        // `Bristles::rate` with the speed of the whole contact.
        rate[i] = velocity[i] - own.stiffness * speed * bristles[i] / mu;
    }
    rate
}

/// The load of a contact under its joint's complete wrench.
pub(super) fn load(
    parameters: &Parameters<f64>,
    bodies: &Bodies<f64>,
    interface: &InterfaceParameters<f64>,
    own: OwnFriction<f64>,
    wrench: Wrench<f64>,
) -> crate::friction::Load<f64> {
    load_by(&interface.load, interface, parameters.pitch[interface.joint], bodies, wrench, own)
}
