//! Normal load maps: the normal load of a friction interface as a function of the joint's reaction.
//!
//! Equation (F3) of the book's theory.

use crate::scalar::Scalar;
use crate::spatial::{Twist, Vec3, Wrench};

/// Components of a joint's reaction that contribute to the normal load, with their arms.
///
/// The normal load has these parts:
///
/// | part | pin (R, C, U), sleeve (C) | guide (P, C) | thread (H) | ball (S) | plate (E) |
/// | --- | --- | --- | --- | --- | --- |
/// | always | radial force | lateral force | radial force, normal force of the flanks | resultant force | normal force |
/// | `bending_span` | 2 x bending moment / span | as pin | as pin | - | 2 x tilting moment / span |
/// | `axial_ratio` | axial force x ratio (collar radius / pin radius), not of a sleeve | - | - | - | - |
/// | `torsion_arm` | - | torsional moment / arm | - | - | - |
/// | `preload` | added | added | added | added | added |
///
/// [`Combine`] defines how the parts are combined. Moments are about the midpoint between the
/// supports, see [`Supports`]. By default, this midpoint is the origin of frame J; for a plate, it
/// is the origin of frame K. A part is omitted if its length or ratio is not given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalLoadMap<T> {
    /// Distance between the two supports of a pin or guide, or across a plate, m.
    pub bending_span: Option<T>,
    /// Ratio of collar radius to pin radius, dimensionless.
    pub axial_ratio: Option<T>,
    /// Lever arm of the forces by which a guide carries a torsional moment, m.
    pub torsion_arm: Option<T>,
    /// Constant part of the normal load, N.
    pub preload: T,
    /// Rule that combines the parts of the normal load.
    pub combine: Combine,
    /// Positions of the two supports along the axis of the pin or guide.
    pub supports: Supports<T>,
    /// Cosine of a thread's half flank angle in the section normal to the thread.
    pub flank_cosine: Option<T>,
    /// Smoothing force, N. Each norm `x` of a force in the normal load is replaced by `sqrt(x^2 +
    /// smoothing^2) - smoothing`, which has no kink at zero.
    pub smoothing: Option<T>,
    /// Losses of a motor's gear per unit of transmitted effort. The first value applies while the
    /// motor drives the load, the second while the load drives the motor. Only for the shaft of a
    /// motor; see [`Self::in_gear`].
    pub gear: Option<[T; 2]>,
}

/// Rule that combines the parts of a normal load.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Combine {
    /// Sum of the parts, for parts that act on separate surfaces.
    #[default]
    Sum,
    /// Radial (lateral) force `F` and bending moment `M` are combined into one force at each of two
    /// supports, which are one `span` apart. The load is the sum of the magnitudes of these forces,
    /// `|F/2 + M x e/span| + |F/2 - M x e/span|` with the axis `e`, plus the parts of axial force
    /// and torsion.
    Pads,
    /// Square root of the sum of the squares of all parts, plus the preload.
    RootSumSquare,
}

/// Positions of the two supports that carry the bending moment.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum Supports<T> {
    /// Both on the predecessor, half a span in front of and behind the origin of J.
    #[default]
    Predecessor,
    /// Both on the successor, half a span in front of and behind the origin of K.
    Successor,
    /// One support on each body, such as the gland of a cylinder and the piston of its rod. The span
    /// changes with the displacement and replaces [`NormalLoadMap::bending_span`].
    OneOnEach {
        /// Position of the predecessor's support along the axis, from the origin of J, m.
        gland: T,
        /// Position of the successor's support along the axis, from the origin of K, m.
        piston: T,
    },
}

/// A normal load and its gradient with respect to the reaction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Load<T> {
    /// Normal load, N, nonnegative.
    pub value: T,
    /// Gradient with respect to the wrench of the reaction, as a twist: a small change `d` of the
    /// wrench changes the load by `gradient.power(d)`. Parts of the load that are zero do not
    /// contribute to the gradient.
    pub gradient: Twist<T>,
}

impl<T: Scalar> NormalLoadMap<T> {
    /// Creates the map whose normal load is the force in the row "always" of the table in
    /// [`NormalLoadMap`], without any other part.
    pub fn force_only() -> Self {
        Self {
            bending_span: None,
            axial_ratio: None,
            torsion_arm: None,
            preload: T::zero(),
            combine: Combine::Sum,
            supports: Supports::Predecessor,
            flank_cosine: None,
            smoothing: None,
            gear: None,
        }
    }

    /// Returns the map without preload and smoothing, which is a seminorm of the reaction: applied
    /// to a change of the reaction, the seminorm is an upper bound of the change of the load.
    pub fn seminorm(&self) -> Self {
        Self { preload: T::zero(), smoothing: None, ..*self }
    }

    /// Computes the distance between the supports, m, if they are on different bodies. `slide` is
    /// the position of the origin of K along the axis of J, m. The distance is positive if the
    /// bodies overlap. Returns `None` if both supports are on the same body.
    #[inline]
    pub fn overlap(&self, slide: T) -> Option<T> {
        let Supports::OneOnEach { gland, piston } = self.supports else { return None };
        let apart = gland - piston;
        Some(apart.if_positive(apart - slide, slide - apart))
    }

    /// Computes the normal load of a pin, a guide or the bore of a thread under the reaction
    /// `wrench`. The surface lies around an axis with the unit vector `axis`; `j` and `k` are the
    /// origins of the frames J and K.
    #[inline(always)]
    pub fn between(&self, wrench: Wrench<T>, j: Vec3<T>, k: Vec3<T>, axis: Vec3<T>) -> Load<T> {
        let (middle, span) = match self.supports {
            Supports::Predecessor => (j, self.bending_span),
            Supports::Successor => (k, self.bending_span),
            Supports::OneOnEach { gland, piston } => {
                let slide = (k - j).dot(axis);
                let middle = j + axis * ((gland + slide + piston) * T::from_f64(0.5));
                (middle, self.overlap(slide))
            }
        };
        self.across(wrench, middle, axis, span)
    }

    /// Computes the normal load of a pin or guide under the reaction `wrench`. The surface lies
    /// around an axis through `point`, the midpoint between the supports, with the unit vector
    /// `axis`.
    pub fn around_axis(&self, wrench: Wrench<T>, point: Vec3<T>, axis: Vec3<T>) -> Load<T> {
        self.across(wrench, point, axis, self.bending_span)
    }

    /// Computes the normal load of a motor shaft: the preload plus the loss of the gear. The gear
    /// transmits `wrench` to a degree of freedom with the unit twist `unit`. The loss depends on
    /// the direction of motion `direction`, 1 or -1. If the direction is unknown, pass zero, which
    /// selects the mean of the two losses.
    pub fn in_gear(&self, wrench: Wrench<T>, unit: Twist<T>, direction: T) -> Load<T> {
        let Some([driving, driven]) = self.gear else {
            return Load { value: self.preload, gradient: Twist::zero() };
        };
        let effort = unit.power(wrench);
        let along = effort * direction;
        let unknown = (driving + driven) * T::from_f64(0.5);
        let part = along.if_positive(driving, (-along).if_positive(driven, unknown));
        let sign = effort.if_positive(T::one(), (-effort).if_positive(-T::one(), T::zero()));
        let slope = part * sign;
        Load { value: self.preload + effort * slope, gradient: unit * slope }
    }

    #[inline(always)]
    fn across(&self, wrench: Wrench<T>, point: Vec3<T>, axis: Vec3<T>, span: Option<T>) -> Load<T> {
        // Rare cases are not inlined, to keep kernels of dual numbers small.
        if self.combine == Combine::Sum && self.smoothing.is_none() {
            self.sum(wrench, point, axis, span)
        } else {
            self.combined(wrench, point, axis, span)
        }
    }

    /// Computes the normal load as the sum of all parts, without smoothing.
    #[inline(always)]
    fn sum(&self, wrench: Wrench<T>, point: Vec3<T>, axis: Vec3<T>, span: Option<T>) -> Load<T> {
        let moment = wrench.moment_about(point);
        let mut sum = Sum { value: self.preload, by_force: Vec3::zero(), by_moment: Vec3::zero() };

        let lateral = norm(wrench.force.across(axis));
        sum.value += lateral.value;
        sum.by_force += lateral.direction;

        if let Some(span) = span {
            let factor = T::from_f64(2.0) / span;
            let bending = norm(moment.across(axis));
            sum.value += bending.value * factor;
            sum.by_moment += bending.direction * factor;
        }
        if let Some(ratio) = self.axial_ratio {
            let axial = norm(axis * wrench.force.dot(axis));
            sum.value += axial.value * ratio;
            sum.by_force += axial.direction * ratio;
        }
        if let Some(arm) = self.torsion_arm {
            let torsion = norm(axis * moment.dot(axis));
            sum.value += torsion.value / arm;
            sum.by_moment += torsion.direction * arm.recip();
        }
        sum.load(point)
    }

    /// Computes the normal load for any rule `combine`, with smoothing if `smoothing` is set.
    fn combined(
        &self,
        wrench: Wrench<T>,
        point: Vec3<T>,
        axis: Vec3<T>,
        span: Option<T>,
    ) -> Load<T> {
        let (none, two) = (T::zero(), T::from_f64(2.0));
        let moment = wrench.moment_about(point);
        let lateral = wrench.force.across(axis);
        let bending = span.map_or(none, |span| two / span);
        let torsion = self.torsion_arm.map_or(none, T::recip);
        let axial = self.axial_ratio.unwrap_or(none);
        let along = axis * (wrench.force.dot(axis) * axial);
        let bent = moment.across(axis) * bending;
        let twisted = axis * (moment.dot(axis) * torsion);
        if self.combine == Combine::RootSumSquare {
            let square = lateral.norm_squared()
                + along.norm_squared()
                + bent.norm_squared()
                + twisted.norm_squared();
            let Part { value, direction: over } = self.root(square);
            let by_force = (lateral + along * axial) * over;
            let by_moment = (bent * bending + twisted * torsion) * over;
            return Sum { value: self.preload + value, by_force, by_moment }.load(point);
        }
        let mut sum = Sum { value: self.preload, by_force: Vec3::zero(), by_moment: Vec3::zero() };
        if self.combine == Combine::Pads {
            let half = T::from_f64(0.5);
            let couple = bent.cross(axis) * half;
            let ahead = self.norm(lateral * half + couple);
            let behind = self.norm(lateral * half - couple);
            sum.value += ahead.value + behind.value;
            sum.by_force += (ahead.direction + behind.direction) * half;
            sum.by_moment += axis.cross(ahead.direction - behind.direction) * (bending * half);
        } else {
            let (lateral, bent) = (self.norm(lateral), self.norm(bent));
            sum.value += lateral.value + bent.value;
            sum.by_force += lateral.direction;
            sum.by_moment += bent.direction * bending;
        }
        let (along, twisted) = (self.norm(along), self.norm(twisted));
        sum.value += along.value + twisted.value;
        sum.by_force += along.direction * axial;
        sum.by_moment += twisted.direction * torsion;
        sum.load(point)
    }

    /// Computes the normal load of a plate with the origin `point` and the unit normal `normal`
    /// under the reaction `wrench`.
    pub fn on_plane(&self, wrench: Wrench<T>, point: Vec3<T>, normal: Vec3<T>) -> Load<T> {
        let factor = self.bending_span.map_or(T::zero(), |span| T::from_f64(2.0) / span);
        let pressing = normal * wrench.force.dot(normal);
        let tilting = wrench.moment_about(point).across(normal) * factor;
        let (value, by_force, by_moment) = if self.combine == Combine::RootSumSquare {
            let root = self.root(pressing.norm_squared() + tilting.norm_squared());
            (root.value, pressing * root.direction, tilting * (factor * root.direction))
        } else {
            let (pressing, tilting) = (self.norm(pressing), self.norm(tilting));
            (pressing.value + tilting.value, pressing.direction, tilting.direction * factor)
        };
        Sum { value: self.preload + value, by_force, by_moment }.load(point)
    }

    /// Computes the normal load of a ball under the reaction `wrench`; `point` is the centre of the
    /// ball.
    #[inline(always)]
    pub fn at_point(&self, wrench: Wrench<T>, point: Vec3<T>) -> Load<T> {
        let resultant = self.norm(wrench.force);
        Sum {
            value: self.preload + resultant.value,
            by_force: resultant.direction,
            by_moment: Vec3::zero(),
        }
        .load(point)
    }

    /// Computes the norm of a force and its gradient, with smoothing if `smoothing` is set.
    #[inline(always)]
    fn norm(&self, force: Vec3<T>) -> Part<T, Vec3<T>> {
        match self.smoothing {
            None => norm(force),
            Some(smoothing) => smooth(force, smoothing),
        }
    }

    /// Computes the square root of a sum of squares, smoothed if `smoothing` is set, and the factor
    /// that converts the gradient of half the sum to the gradient of the root.
    fn root(&self, square: T) -> Part<T, T> {
        match self.smoothing {
            None => {
                let value = square.norm_of_square();
                let safe = value.if_positive(value, T::one());
                Part { value, direction: value.if_positive(safe.recip(), T::zero()) }
            }
            Some(smoothing) => {
                let root = (square + smoothing * smoothing).sqrt();
                Part { value: square / (root + smoothing), direction: root.recip() }
            }
        }
    }
}

impl NormalLoadMap<f64> {
    /// Converts all parameters to constants of another scalar type.
    pub fn lift<T: Scalar>(&self) -> NormalLoadMap<T> {
        NormalLoadMap {
            bending_span: self.bending_span.map(T::from_f64),
            axial_ratio: self.axial_ratio.map(T::from_f64),
            torsion_arm: self.torsion_arm.map(T::from_f64),
            preload: T::from_f64(self.preload),
            combine: self.combine,
            supports: match self.supports {
                Supports::Predecessor => Supports::Predecessor,
                Supports::Successor => Supports::Successor,
                Supports::OneOnEach { gland, piston } => {
                    Supports::OneOnEach { gland: T::from_f64(gland), piston: T::from_f64(piston) }
                }
            },
            flank_cosine: self.flank_cosine.map(T::from_f64),
            smoothing: self.smoothing.map(T::from_f64),
            gear: self.gear.map(|losses| losses.map(T::from_f64)),
        }
    }
}

/// Magnitude of one part of the normal load, and its gradient.
struct Part<T, D> {
    value: T,
    direction: D,
}

/// Computes the length of a vector and the gradient of the length, which is the unit vector. For a
/// zero vector, length and gradient are zero.
#[inline(always)]
fn norm<T: Scalar>(v: Vec3<T>) -> Part<T, Vec3<T>> {
    let value = v.norm();
    let safe = value.if_positive(value, T::one());
    Part { value, direction: v * safe.recip() }
}

/// Computes `sqrt(|v|^2 + e^2) - e` and its gradient without cancellation.
fn smooth<T: Scalar>(v: Vec3<T>, e: T) -> Part<T, Vec3<T>> {
    let square = v.norm_squared();
    let root = (square + e * e).sqrt();
    Part { value: square / (root + e), direction: v * root.recip() }
}

struct Sum<T> {
    value: T,
    by_force: Vec3<T>,
    by_moment: Vec3<T>,
}

impl<T: Scalar> Sum<T> {
    /// Converts the derivatives with respect to the force and to the moment about `point` to the
    /// gradient with respect to the wrench about the reference point.
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
    use crate::scalar::{Dual, Lanes};
    use proptest::prelude::*;

    type D = Dual<f64, 6>;

    /// Creates maps that cover all combination rules, with and without smoothing, and all positions
    /// of the supports.
    fn maps() -> Vec<NormalLoadMap<f64>> {
        let whole = NormalLoadMap {
            bending_span: Some(0.1),
            axial_ratio: Some(1.5),
            torsion_arm: Some(0.03),
            preload: 2.0,
            ..NormalLoadMap::force_only()
        };
        let mut maps = vec![NormalLoadMap::force_only()];
        for combine in [Combine::Sum, Combine::Pads, Combine::RootSumSquare] {
            let map = NormalLoadMap { combine, ..whole };
            maps.extend([map, NormalLoadMap { smoothing: Some(0.5), ..map }]);
            let supports = Supports::OneOnEach { gland: 0.15, piston: -0.2 };
            maps.push(NormalLoadMap { supports, bending_span: None, ..map });
            maps.push(NormalLoadMap { supports: Supports::Successor, ..map });
        }
        maps
    }

    /// Computes the normal loads of a pin with two ways to give its supports, of a plate and of a
    /// ball under the same wrench.
    fn loads<T: Scalar>(map: &NormalLoadMap<T>, wrench: Wrench<T>) -> [Load<T>; 4] {
        let point = Vec3::new(0.2, -0.1, 0.3);
        let axis = Vec3::new(2.0, -1.0, 2.0).direction().unwrap();
        let (j, k) = (point.lift(), (point + axis * 0.07).lift());
        [
            map.between(wrench, j, k, axis.lift()),
            map.around_axis(wrench, j, axis.lift()),
            map.on_plane(wrench, k, axis.lift()),
            map.at_point(wrench, j),
        ]
    }

    fn as_wrench<T: Scalar>(c: [T; 6]) -> Wrench<T> {
        Wrench { force: Vec3::new(c[0], c[1], c[2]), moment: Vec3::new(c[3], c[4], c[5]) }
    }

    proptest! {
        /// Checks the gradient against exact derivatives of the load by dual numbers, and SIMD
        /// lanes against single numbers.
        #[test]
        fn gradient_is_the_derivative_of_the_value(
            wrench in prop::array::uniform6(-5.0..5.0_f64)
        ) {
            let variables = core::array::from_fn(|i| D::variable(wrench[i], i));
            for map in maps() {
                let numbers = loads(&map, as_wrench(wrench));
                let duals = loads(&map.lift::<D>(), as_wrench(variables));
                type L = Lanes<f64, 4>;
                let lanes = loads(&map.lift::<L>(), as_wrench(wrench.map(L::from_f64)));
                for ((number, dual), lane) in numbers.iter().zip(duals).zip(lanes) {
                    prop_assert_eq!(number.value, dual.value.value);
                    prop_assert_eq!(lane.value.0, [number.value; 4]);
                    prop_assert!(number.value >= map.preload);
                    let gradient = number.gradient;
                    let found = [gradient.linear.to_array(), gradient.angular.to_array()].concat();
                    for (i, component) in found.iter().enumerate() {
                        let error = component - dual.value.slope[i];
                        // The unit vectors are normalised differences, which lose digits.
                        prop_assert!(error.abs() < 1e-11, "{map:?} {i}: {error}");
                    }
                }
            }
        }

        /// Checks that the difference of two normal loads is at most the seminorm of the difference
        /// of the two reactions. The proof of uniqueness is based on this inequality.
        #[test]
        fn loads_are_seminorms(
            a in prop::array::uniform6(-5.0..5.0_f64),
            b in prop::array::uniform6(-5.0..5.0_f64),
        ) {
            for map in maps() {
                let change = as_wrench(a) - as_wrench(b);
                let of = |map: &NormalLoadMap<f64>, wrench| loads(map, wrench).map(|load| load.value);
                                let pairs = of(&map, as_wrench(a)).into_iter().zip(of(&map, as_wrench(b)));
                for ((a, b), most) in pairs.zip(of(&map.seminorm(), change)) {
                    prop_assert!((a - b).abs() <= most * (1.0 + 1e-12) + 1e-12);
                }
            }
        }
    }

    #[test]
    fn no_reaction_leaves_the_preload() {
        for map in maps() {
            for load in loads(&map, Wrench::zero()) {
                assert_eq!(load, Load { value: map.preload, gradient: Twist::zero() });
            }
        }
    }

    /// Checks the normal load of two pads against a calculation by hand: a lateral force of 30 N
    /// and a moment of 4 N m on pads 0.2 m apart. If the moment's forces are parallel to the
    /// lateral force, the pads carry 15 N + 20 N and 15 N - 20 N; if they are perpendicular to it,
    /// each pad carries the square root of 15^2 + 20^2.
    #[test]
    fn two_pads() {
        let map = NormalLoadMap {
            bending_span: Some(0.2),
            combine: Combine::Pads,
            ..NormalLoadMap::force_only()
        };
        let force = Vec3::new(30.0, 0.0, -7.0);
        for (moment, expected) in [
            (Vec3::new(0.0, 4.0, 9.0), 35.0 + 5.0),
            (Vec3::new(0.0, -4.0, 9.0), 35.0 + 5.0),
            (Vec3::new(4.0, 0.0, 9.0), 25.0 + 25.0),
        ] {
            let wrench = Wrench { force, moment };
            let load = map.around_axis(wrench, Vec3::zero(), Vec3::unit(2));
            assert!((load.value - expected).abs() < 1e-13, "{load:?}");
        }
        let sum = NormalLoadMap { combine: Combine::Sum, ..map };
        let root = NormalLoadMap { combine: Combine::RootSumSquare, ..map };
        let wrench = Wrench { force, moment: Vec3::new(0.0, 4.0, 9.0) };
        for (map, expected) in [(sum, 70.0), (root, 50.0)] {
            let load = map.around_axis(wrench, Vec3::zero(), Vec3::unit(2));
            assert!((load.value - expected).abs() < 1e-13, "{load:?}");
        }
    }

    /// Checks the normal load of a rod against the law of the lever. The rod slides in a gland and
    /// carries a lateral force at one end and a piston at the other end.
    #[test]
    fn gland_and_piston() {
        let map = NormalLoadMap {
            combine: Combine::Pads,
            supports: Supports::OneOnEach { gland: 0.5, piston: -0.6 },
            ..NormalLoadMap::force_only()
        };
        for slide in [0.65, 0.8, 0.95] {
            // Positions along the axis from J, m: gland 0.5, piston slide - 0.6, force slide.
            let overlap = 0.5 - (slide - 0.6);
            assert!((map.overlap(slide).unwrap() - overlap).abs() < 1e-15);
            let force = Vec3::new(0.0, 40.0, 0.0);
            let tip = Vec3::unit(2) * slide;
            let wrench = Wrench { force, moment: tip.cross(force) };
            let load = map.between(wrench, Vec3::zero(), tip, Vec3::unit(2));
            let (gland, piston) = (40.0 * 0.6 / overlap, 40.0 * (slide - 0.5) / overlap);
            assert!((load.value - (gland + piston)).abs() < 1e-12 * load.value);
        }
        assert!(map.overlap(1.2).unwrap() < 0.0);
        let turned = Supports::OneOnEach { gland: -0.5, piston: 0.6 };
        let turned = NormalLoadMap { supports: turned, ..map };
        assert!((turned.overlap(-0.8).unwrap() - 0.3).abs() < 1e-15);
    }
}
