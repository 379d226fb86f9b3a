//! Normal force on the flanks of a helical joint's thread.
//!
//! Equation (L1) of the book.

use super::{Load, NormalLoadMap};
use crate::scalar::Scalar;
use crate::spatial::{Twist, Vec3, Wrench};

/// Helix of a thread, given by its radius and pitch.
///
/// The flanks exert a normal force on each other and friction along the helix. The friction `R`
/// carries a part of the joint's axial force `F`. With the lead angle `l` (`tan l = pitch /
/// radius`), half the flank angle `b` in the section normal to the thread, and `d = 1` for forward
/// and `-1` for backward sliding, the normal force is
///
/// ```text
/// N cos b = | F / cos l + d R tan l |,    R = constant + coefficient (N + N_other)
/// ```
///
/// Here, `N_other` is the normal load of the bore. The equation is solved for `N`; it is linear on
/// either side of `N = 0`. The actuator does not appear in the equation, so a motor may turn the
/// spindle through this joint or through another joint. With the radius `r` and `tan r' =
/// coefficient / cos b`, the result agrees with the textbook torques `F r tan(l + r')` to raise a
/// load and `F r tan(r' - l)` to lower the load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thread<T> {
    /// Contact radius of the flanks, m.
    pub radius: T,
    /// Pitch: advance per radian, m/rad; negative for a left-hand thread.
    pub pitch: T,
}

/// Friction force of one interface, affine in the normal load. In a thread, the friction force
/// carries a part of the joint's axial force and thereby changes the normal force of the flanks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OwnFriction<T> {
    /// Friction force per newton of normal load.
    pub coefficient: T,
    /// Friction force at zero normal load, N.
    pub constant: T,
    /// Sliding direction: 1 for forward, -1 for backward. At rest, the value is the mobilised
    /// fraction of static friction.
    pub direction: T,
}

impl<T: Scalar> OwnFriction<T> {
    /// Creates zero friction.
    pub fn none() -> Self {
        Self { coefficient: T::zero(), constant: T::zero(), direction: T::zero() }
    }
}

impl OwnFriction<f64> {
    /// Creates a friction force, N, that does not depend on the normal load. Its sign is that of
    /// the sliding velocity that it opposes.
    pub(crate) fn of(force: f64) -> Self {
        Self { coefficient: 0.0, constant: force.abs(), direction: force.signum() }
    }
}

impl<T: Scalar> Thread<T> {
    /// Returns the path length along the helix per radian of rotation, m/rad.
    #[inline]
    pub fn way(&self) -> T {
        (self.radius * self.radius + self.pitch * self.pitch).sqrt()
    }

    /// Computes the normal load of a thread under the reaction `wrench`: the normal force of the
    /// flanks plus `other`, the normal load of the bore, which is that of a pin. `axis` is the unit
    /// vector of the thread's axis, and `own` the friction of the thread. The load is infinite if
    /// friction jams the thread.
    pub fn load(
        &self,
        map: &NormalLoadMap<T>,
        other: Load<T>,
        wrench: Wrench<T>,
        axis: Vec3<T>,
        own: OwnFriction<T>,
    ) -> Load<T> {
        let lead = self.pitch / self.radius;
        let over_cosine = self.way() / self.radius;
        let back = own.direction * lead;
        let axial = wrench.force.dot(axis) * over_cosine
            + back * (own.constant + own.coefficient * other.value);
        let sign = axial.if_positive(T::one(), (-axial).if_positive(-T::one(), T::zero()));
        let left = map.flank_cosine.unwrap_or(T::one()) - sign * back * own.coefficient;
        // If `left` vanishes or is negative, the load is infinite: friction jams the thread.
        let left = left.if_positive(left, T::zero());
        let factor = sign / left;
        let gradient = Twist { angular: Vec3::zero(), linear: axis * over_cosine }
            + other.gradient * (back * own.coefficient);
        Load { value: other.value + axial * factor, gradient: other.gradient + gradient * factor }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::{Dual, Lanes};
    use proptest::prelude::*;

    const MAP: NormalLoadMap<f64> = NormalLoadMap {
        bending_span: Some(0.05),
        axial_ratio: None,
        torsion_arm: None,
        preload: 3.0,
        combine: crate::friction::Combine::Sum,
        supports: crate::friction::Supports::Predecessor,
        flank_cosine: Some(0.9),
        smoothing: None,
        gear: None,
    };

    proptest! {
        /// Checks that the normal force and the friction of a flank are in equilibrium with the
        /// axial force, and checks the gradient of the normal load against exact derivatives.
        #[test]
        fn flanks_are_in_balance(
            c in prop::array::uniform6(-50.0..50.0_f64),
            (pitch, coefficient) in (-0.008..0.008_f64, 0.0..0.4_f64),
            forward in any::<bool>(),
        ) {
            type D = Dual<Lanes<f64, 2>, 6>;
            let thread = Thread { radius: 0.01, pitch };
            let direction = if forward { 1.0 } else { -1.0 };
            let own = OwnFriction { coefficient, constant: 0.7, direction };
            let (at, axis) = (Vec3::new(0.1, 0.2, -0.1), Vec3::unit(2));
            let wrench = Wrench {
                force: Vec3::new(c[0], c[1], c[2]),
                moment: Vec3::new(c[3], c[4], c[5]),
            };
            let other = MAP.around_axis(wrench, at, axis);
            let load = thread.load(&MAP, other, wrench, axis, own);
            prop_assert!(load.value >= other.value);

            // Per newton, the axial component of the normal force is cos b cos l, and that of the
            // friction is sin l.
            let lead = (pitch / thread.radius).atan();
            let normal = load.value - other.value;
            let friction = own.constant + coefficient * load.value;
            let errors = [1.0, -1.0].map(|flank| {
                let along = flank * normal * 0.9 * lead.cos() - direction * friction * lead.sin();
                (along - c[2]).abs()
            });
            prop_assert!(errors[0].min(errors[1]) < 1e-12 * load.value, "{errors:?}");

            let lift = D::from_f64;
            let variable = |i: usize| D::variable(Lanes::from_f64(c[i]), i);
            let wrench = Wrench {
                force: Vec3::new(variable(0), variable(1), variable(2)),
                moment: Vec3::new(variable(3), variable(4), variable(5)),
            };
            let thread = Thread { radius: lift(thread.radius), pitch: lift(pitch) };
            let own = OwnFriction {
                coefficient: lift(coefficient),
                constant: lift(own.constant),
                direction: lift(direction),
            };
            let map = MAP.lift::<D>();
            let other = map.around_axis(wrench, at.lift(), axis.lift());
            let dual = thread.load(&map, other, wrench, axis.lift(), own);
            prop_assert_eq!(dual.value.value.0, [load.value; 2]);
            let gradient = [load.gradient.linear.to_array(), load.gradient.angular.to_array()];
            for (i, component) in gradient.concat().into_iter().enumerate() {
                prop_assert!((component - dual.value.slope[i].0[1]).abs() < 1e-11);
            }
        }
    }

    /// Checks that friction that jams the thread while raising the load yields an infinite normal
    /// load.
    #[test]
    fn a_jammed_thread_has_an_infinite_load() {
        let thread = Thread { radius: 0.01, pitch: 0.02 };
        let own = OwnFriction { coefficient: 0.5, constant: 0.0, direction: 1.0 };
        let force = Vec3::unit(2) * 10.0;
        let wrench = Wrench { force, moment: Vec3::zero() };
        let map = NormalLoadMap { preload: 0.0, ..MAP };
        let other = map.around_axis(wrench, Vec3::zero(), Vec3::unit(2));
        assert_eq!(thread.load(&map, other, wrench, Vec3::unit(2), own).value, f64::INFINITY);
        let down = OwnFriction { direction: -1.0, ..own };
        assert!(thread.load(&map, other, wrench, Vec3::unit(2), down).value.is_finite());
    }
}
