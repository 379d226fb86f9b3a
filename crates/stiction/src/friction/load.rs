//! Load maps: from a joint's reaction to the load on its sliding surface.

use crate::scalar::Scalar;
use crate::spatial::{Twist, Vec3, Wrench};

/// Which components of a joint's reaction press its sliding surfaces together, and at what arm.
///
/// The load is a sum of parts:
///
/// | part | pin (R, C, U) | guide (P, C) | ball (S) |
/// | --- | --- | --- | --- |
/// | always | radial force | lateral force | resultant force |
/// | `bending_span` | 2 x bending moment / span | 2 x bending moment / span (two pads) | - |
/// | `axial_ratio` | axial force x ratio (collar radius / pin radius) | - | - |
/// | `torsion_arm` | - | torsional moment / arm | - |
/// | `preload` | added | added | added |
///
/// Moments are about the joint's origin. A part without its length is absent: nothing is assumed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadMap<T> {
    /// Distance between the two supports of a pin or guide, m.
    pub bending_span: Option<T>,
    /// Collar radius over pin radius, dimensionless.
    pub axial_ratio: Option<T>,
    /// Arm at which a guide takes torsion, m.
    pub torsion_arm: Option<T>,
    /// Constant load, N.
    pub preload: T,
}

/// A load and how it changes with the reaction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Load<T> {
    /// The load, N, not negative.
    pub value: T,
    /// Its gradient: `d value = gradient.power(d wrench)`. Zero in every part that vanishes.
    pub gradient: Twist<T>,
}

impl<T: Scalar> LoadMap<T> {
    /// Nothing but the resultant force.
    pub fn force_only() -> Self {
        Self { bending_span: None, axial_ratio: None, torsion_arm: None, preload: T::zero() }
    }

    /// The load of a pin or guide: a surface around the line through `point` along the unit vector
    /// `axis`, under `wrench` (about the kernel's origin).
    #[inline(always)]
    pub fn around_axis(&self, wrench: Wrench<T>, point: Vec3<T>, axis: Vec3<T>) -> Load<T> {
        let moment = wrench.moment_about(point);
        let mut sum = Sum { value: self.preload, by_force: Vec3::zero(), by_moment: Vec3::zero() };

        let lateral = Part::norm(wrench.force.across(axis));
        sum.value += lateral.value;
        sum.by_force += lateral.direction;

        if let Some(span) = self.bending_span {
            let factor = T::from_f64(2.0) / span;
            let bending = Part::norm(moment.across(axis));
            sum.value += bending.value * factor;
            sum.by_moment += bending.direction * factor;
        }
        if let Some(ratio) = self.axial_ratio {
            let axial = Part::norm(axis * wrench.force.dot(axis));
            sum.value += axial.value * ratio;
            sum.by_force += axial.direction * ratio;
        }
        if let Some(arm) = self.torsion_arm {
            let torsion = Part::norm(axis * moment.dot(axis));
            sum.value += torsion.value / arm;
            sum.by_moment += torsion.direction * arm.recip();
        }
        sum.load(point)
    }

    /// The load of a ball at `point` under `wrench` (about the kernel's origin).
    #[inline(always)]
    pub fn at_point(&self, wrench: Wrench<T>, point: Vec3<T>) -> Load<T> {
        let resultant = Part::norm(wrench.force);
        Sum {
            value: self.preload + resultant.value,
            by_force: resultant.direction,
            by_moment: Vec3::zero(),
        }
        .load(point)
    }
}

impl LoadMap<f64> {
    /// The same map as constants of another scalar.
    pub fn lift<T: Scalar>(&self) -> LoadMap<T> {
        LoadMap {
            bending_span: self.bending_span.map(T::from_f64),
            axial_ratio: self.axial_ratio.map(T::from_f64),
            torsion_arm: self.torsion_arm.map(T::from_f64),
            preload: T::from_f64(self.preload),
        }
    }
}

/// The length of a vector and its gradient, the unit vector (zero where the length is).
struct Part<T> {
    value: T,
    direction: Vec3<T>,
}

impl<T: Scalar> Part<T> {
    #[inline(always)]
    fn norm(v: Vec3<T>) -> Self {
        let value = v.norm();
        let safe = value.if_positive(value, T::one());
        Self { value, direction: v * safe.recip() }
    }
}

struct Sum<T> {
    value: T,
    by_force: Vec3<T>,
    by_moment: Vec3<T>,
}

impl<T: Scalar> Sum<T> {
    /// Moves the gradient from `point` to the kernel's origin.
    #[inline(always)]
    fn load(self, point: Vec3<T>) -> Load<T> {
        Load {
            value: self.value,
            gradient: Twist {
                angular: self.by_moment,
                linear: self.by_force + point.cross(self.by_moment),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Dual;

    /// The gradient against exact derivatives of the value itself, all parts present.
    #[test]
    fn gradient_is_the_derivative_of_the_value() {
        let map = LoadMap {
            bending_span: Some(0.1),
            axial_ratio: Some(1.5),
            torsion_arm: Some(0.03),
            preload: 2.0,
        };
        let wrench: [f64; 6] = [3.0, -1.0, 2.0, 0.4, 0.5, -0.6];
        let point = Vec3::new(0.2, -0.1, 0.3);
        let axis = Vec3::new(2.0, -1.0, 2.0).direction().unwrap();

        let as_wrench = |c: [Dual<f64, 6>; 6]| Wrench {
            force: Vec3::new(c[0], c[1], c[2]),
            moment: Vec3::new(c[3], c[4], c[5]),
        };
        let variables = core::array::from_fn(|i| Dual::variable(wrench[i], i));
        for ball in [false, true] {
            let dual_map = map.lift::<Dual<f64, 6>>();
            let load = if ball {
                dual_map.at_point(as_wrench(variables), point.lift())
            } else {
                dual_map.around_axis(as_wrench(variables), point.lift(), axis.lift())
            };
            let gradient = load.gradient;
            let found = [gradient.linear.to_array(), gradient.angular.to_array()].concat();
            for (i, component) in found.iter().enumerate() {
                assert!((component.value - load.value.slope[i]).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn no_reaction_leaves_the_preload() {
        let map = LoadMap { preload: 5.0, ..LoadMap::force_only() };
        let load = map.around_axis(Wrench::zero(), Vec3::zero(), Vec3::unit(2));
        assert_eq!(load, Load { value: 5.0, gradient: Twist::zero() });
    }
}
