//! Friction of an interface as an affine function of its normal load, at a given sliding velocity
//! and stick-slip mode.

use crate::friction::{Law, OwnFriction, Resistance};
pub(super) use crate::friction_problem::surface_vector::{dot, norm};
use crate::parameters::InterfaceParameters;

/// Mode of a friction interface at an instant: smooth law, slip, stick, or stick at the static
/// friction limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum InterfaceMode {
    /// The friction is a smooth function of velocity and internal state, so the interface never
    /// sticks: a regularised law, purely viscous friction, or a bristle law.
    Smooth,
    /// Slip in the given direction. For an interface with one DOF the first number is the sign of
    /// the slip, 1 or -1, constant within a step. For several DOFs the numbers are the unit vector
    /// of the sliding velocity, which is used only where the velocity is too small to define a
    /// direction.
    Slides([f64; 3]),
    /// Stick: static friction prevents slip.
    Sticks,
    /// The interface is at rest, and its static friction is at the limit. The interface begins to
    /// slip unless other constraints prevent the slip. The unit vector is the direction of this
    /// slip; the friction opposes this direction.
    AtLimit([f64; 3]),
}

/// Friction of an interface as an affine function of its normal load: `-(constant + per_load *
/// normal load)` is the effort on each DOF of the interface, N or N m, with the lever arms of the
/// surface included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct AffineFriction {
    pub(super) constant: [f64; 3],
    pub(super) per_load: [f64; 3],
    /// Part of the friction that itself changes the normal load, for example the friction on the
    /// flanks of a thread.
    pub(super) own: OwnFriction<f64>,
}

impl AffineFriction {
    /// Returns zero friction.
    pub(super) fn none() -> Self {
        Self { constant: [0.0; 3], per_load: [0.0; 3], own: OwnFriction::none() }
    }

    /// Returns the friction force along each DOF at the surface, N, under the normal load `load`,
    /// N. `arms` are the lever arms of the rotational DOFs, m; the entry of a translation is 1.
    pub(super) fn at_surface(&self, arms: [f64; 3], load: f64) -> [f64; 3] {
        let effort = |i: usize| self.constant[i] + self.per_load[i] * load;
        [0, 1, 2].map(|i| if effort(i) == 0.0 { 0.0 } else { effort(i) / arms[i] })
    }
}

/// Returns the mode of an interface at rest with an unregularised law. If the magnitude of the
/// given sliding velocities or accelerations exceeds `rounding`, the mode is
/// [`InterfaceMode::AtLimit`] in their direction, otherwise [`InterfaceMode::Sticks`].
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

/// Returns true if the friction is a smooth function of velocity and internal state, so that the
/// interface never sticks.
pub(super) fn is_smooth(interface: &InterfaceParameters<f64>) -> bool {
    let smooth = |law: &Law<f64>| {
        law.bristles.is_some()
            || law.regularisation.is_some()
            || (law.at_rest() == 0.0 && law.coefficient(0.0) == 0.0 && law.is_constant())
    };
    interface.laws().into_iter().all(smooth)
}

/// Returns the friction of an interface in a given mode at the sliding velocity `velocity`, m/s.
/// `pitch` is the pitch of the joint, m/rad. `bristles` contains the bristle deflections, m, which
/// laws without bristles ignore.
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
        // If the velocity reverses within a step, the friction keeps its direction until the end of
        // the step, as for interfaces with one DOF.
        InterfaceMode::Slides(before) if dot(velocity, before) < 0.0 => {
            velocity.map(|v| -v / speed)
        }
        _ if speed > 0.0 => velocity.map(|v| v / speed),
        _ => [0.0; 3],
    };
    // Speed along the direction of slip; slightly negative where a step is evaluated beyond a
    // reversal.
    let along = dot(velocity, direction);
    let law = interface.law_towards(direction[0]);
    let resistance = match mode {
        // The interface begins to slip within the step.
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

/// Returns the rate of each bristle deflection, m/s, at the sliding velocity `velocity`, m/s, and
/// the bristle deflections `bristles`, m. Returns zero for laws without bristles.
pub(super) fn bristle_rate(
    interface: &InterfaceParameters<f64>,
    velocity: [f64; 3],
    bristles: [f64; 3],
) -> [f64; 3] {
    let law = interface.law_towards(velocity[0]);
    let Some(own) = &law.bristles else { return [0.0; 3] };
    let speed = norm(velocity);
    let mu = law.coefficient(speed);
    // The formula of `Bristles::rate`, with the sliding speed of all DOFs together.
    [0, 1, 2].map(|i| velocity[i] - own.stiffness * speed * bristles[i] / mu)
}
