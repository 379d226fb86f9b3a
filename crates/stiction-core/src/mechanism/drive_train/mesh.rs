//! Efficiency of a screw or worm gear from its geometry and coefficient of friction.
//!
//! Equation (G5) of the book's theory.

/// Friction at the inclined flank of a screw thread or of a worm.
///
/// Let `l` be the lead angle and `f = mu / cos(b)`, where `b` is half the flank angle in the
/// section normal to the flank. The screw raises its load with the efficiency
/// `tan l (1 - f tan l) / (tan l + f)`. The load drives the screw with the efficiency
/// `(tan l - f) / (tan l (1 + f tan l))`. The screw is self-locking if `f >= tan l`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mesh {
    /// Coefficient of friction, nonnegative.
    pub mu: f64,
    /// Lead angle, rad, `atan(lead / (2 pi radius))`; greater than 0 and less than a right angle.
    pub lead_angle: f64,
    /// Half the angle between the flanks in the axial section, rad; at least 0 and less than a
    /// right angle.
    pub flank_angle: f64,
}

impl Mesh {
    /// Computes two efficiencies: the first applies while the motor drives the screw, the second
    /// while the load drives the screw.
    pub fn efficiencies(&self) -> (f64, f64) {
        let lead = self.lead_angle.tan();
        // Half the flank angle `b` in the normal section: tan b = tan(flank angle) cos l.
        let tilt = self.flank_angle.tan() * self.lead_angle.cos();
        let friction = self.mu * tilt.hypot(1.0);
        let forward = lead * (1.0 - friction * lead) / (lead + friction);
        let backward = (lead - friction) / (lead * (1.0 + friction * lead));
        (forward, backward)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks the efficiencies of a square thread against the textbook formulas
    /// `tan l / tan(l + r)` and `tan(l - r) / tan l`, where `r` is the friction angle.
    #[test]
    fn square_thread() {
        for (mu, lead_angle) in [(0.1, 0.05_f64), (0.02, 0.3), (0.2, 0.1)] {
            let (forward, backward) = Mesh { mu, lead_angle, flank_angle: 0.0 }.efficiencies();
            let angle = mu.atan();
            assert!((forward - lead_angle.tan() / (lead_angle + angle).tan()).abs() < 1e-15);
            assert!((backward - (lead_angle - angle).tan() / lead_angle.tan()).abs() < 1e-15);
        }
    }

    /// Checks that a trapezoidal thread becomes self-locking where `pi mu d / cos b` exceeds the
    /// lead.
    #[test]
    fn self_locking_begins_where_friction_meets_the_slope() {
        let (lead_angle, flank_angle) = (0.08_f64, 15f64.to_radians());
        let threshold = lead_angle.tan() / (flank_angle.tan() * lead_angle.cos()).hypot(1.0);
        for (mu, holds) in [(threshold * (1.0 - 1e-12), false), (threshold * (1.0 + 1e-12), true)] {
            let (_, backward) = Mesh { mu, lead_angle, flank_angle }.efficiencies();
            assert_eq!(backward <= 0.0, holds, "{backward}");
        }
    }
}
