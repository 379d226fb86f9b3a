//! Friction of an interface at a given velocity and mode, as an affine function of its normal load.

use crate::friction::{Law, OwnFriction, Resistance};
pub(super) use crate::friction_problem::surface_vector::{dot, norm};
use crate::parameters::InterfaceParameters;

/// Mode of a friction interface at an instant: slip or stick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum InterfaceMode {
    /// Friction is a smooth function of velocity and internal state: a regularised law, viscous friction alone, or
    /// bristles.
    Smooth,
    /// Slip. For an interface with one DOF the first number is the direction of slip, 1 or -1, constant within a step.
    /// For several DOFs the numbers are the unit vector of slip at the surface, used where the velocity is too small to
    /// define one.
    Slides([f64; 3]),
    /// Stick: static friction prevents slip.
    Sticks,
    /// Static friction at its limit while other constraints prevent slip; the unit vector is the direction of slip
    /// onset, which the friction opposes.
    AtLimit([f64; 3]),
}

/// Friction of an interface as an affine function of its normal load: the effort on each DOF of the interface is
/// `-(constant + per_load * normal load)`, N or N m, with the lever arms of the surface included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct AffineFriction {
    pub(super) constant: [f64; 3],
    pub(super) per_load: [f64; 3],
    /// Friction of the interface itself as far as it changes the normal load, as on the flanks of a thread.
    pub(super) own: OwnFriction<f64>,
}

impl AffineFriction {
    /// Returns zero friction.
    pub(super) fn none() -> Self {
        Self { constant: [0.0; 3], per_load: [0.0; 3], own: OwnFriction::none() }
    }

    /// Returns the friction at the surface, N, under a normal load, N; `arms` are the lever arms of the DOFs, m, or 1
    /// for translations.
    pub(super) fn at_surface(&self, arms: [f64; 3], load: f64) -> [f64; 3] {
        let effort = |i: usize| self.constant[i] + self.per_load[i] * load;
        [0, 1, 2].map(|i| if effort(i) == 0.0 { 0.0 } else { effort(i) / arms[i] })
    }
}

/// Returns the mode of an interface at rest with an unregularised law, for given surface rates or accelerations: static
/// friction at its limit along them if their magnitude exceeds `rounding`, stick otherwise.
pub(super) fn mode_of(rates: &[f64], rounding: f64) -> InterfaceMode {
    let mut direction = [0.0; 3];
    direction[..rates.len()].copy_from_slice(rates);
    let rate = norm(direction);
    if rate > rounding {
        InterfaceMode::AtLimit(direction.map(|a| a / rate))
    } else {
        InterfaceMode::Sticks
    }
}

/// Returns whether friction is a smooth function of velocity and inner state, so that the interface never sticks.
pub(super) fn is_smooth(interface: &InterfaceParameters<f64>) -> bool {
    let smooth = |law: &Law<f64>| {
        law.bristles.is_some()
            || law.regularisation.is_some()
            || (law.at_rest() == 0.0 && law.coefficient(0.0) == 0.0 && law.is_constant())
    };
    interface.laws().into_iter().all(smooth)
}

/// Returns the friction of an interface at a surface velocity, m/s; `bristles` are the bristle deflections, m, if the
/// law has any.
pub(super) fn affine_friction(
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
        // Beyond a reversal, friction keeps its direction for the rest of the step, as for
        // interfaces with one DOF.
        InterfaceMode::Slides(before) if dot(velocity, before) < 0.0 => {
            velocity.map(|v| -v / speed)
        }
        _ if speed > 0.0 => velocity.map(|v| v / speed),
        _ => [0.0; 3],
    };
    // Speed along the direction; slightly negative where a step evaluates beyond a reversal.
    let along = dot(velocity, direction);
    let law = interface.law_towards(direction[0]);
    let resistance = match mode {
        // Slip onset within a step.
        InterfaceMode::AtLimit(_) if along > 0.0 && law.slides_as_at_its_limit() => {
            law.sliding(along)
        }
        InterfaceMode::AtLimit(_) => Resistance { coefficient: law.at_rest(), constant: 0.0 },
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
    let mut constant = direction.map(|d| d * resistance.constant);
    for i in 0..3 {
        constant[i] *= arms[i];
        per_load[i] *= arms[i];
    }
    AffineFriction { constant, per_load, own }
}

/// Returns the rates of the bristle deflections, m/s.
pub(super) fn bristle_rate(
    interface: &InterfaceParameters<f64>,
    velocity: [f64; 3],
    bristles: [f64; 3],
) -> [f64; 3] {
    let law = interface.law_towards(velocity[0]);
    let Some(own) = &law.bristles else { return [0.0; 3] };
    let speed = norm(velocity);
    let mu = law.coefficient(speed);
    // `Bristles::rate` with the speed of the whole interface.
    [0, 1, 2].map(|i| velocity[i] - own.stiffness * speed * bristles[i] / mu)
}
