//! Formulas that contain the time and measured coordinates: control laws, load components and stop
//! conditions.

use crate::expression::Formula;
use stiction_core::kinematics::{Coordinate, Target};

/// A formula that contains the time and the measured coordinates and rates of a mechanism, such as
/// `-200 N m/rad*A - 5 N m s/rad*d(A)`.
#[derive(Clone, Debug)]
pub struct Law {
    formula: Formula,
    /// Measured variables of the formula: the coordinate, and true if its rate is measured instead
    /// of its value.
    measured: Vec<(Coordinate, bool)>,
}

impl Law {
    pub(crate) fn new(formula: Formula, measured: Vec<(Coordinate, bool)>) -> Self {
        Self { formula, measured }
    }

    /// Number of switching functions: arguments whose sign selects the branch of an `abs`, `min`,
    /// `max` or `sign` in the formula.
    pub fn switches(&self) -> usize {
        self.formula.switches()
    }

    /// Returns true if the formula contains the time.
    pub fn has_time(&self) -> bool {
        self.formula.has_time()
    }

    /// Returns a time, s, after `t` (s) such that a few samples between both times resolve every
    /// operation of the formula that depends on time alone.
    pub fn resolved_until(&self, t: f64) -> f64 {
        self.formula.resolved_until(t)
    }

    /// Returns the value of the formula, in SI units, at time `t`, s. `measure` returns the
    /// measured motion of a coordinate. `sides` selects the branch of each switching function
    /// ([`Self::switches`]): true if its value is at least 0. A function beyond the end of `sides`
    /// has the branch of its own value.
    pub fn at(
        &self,
        t: f64,
        measure: impl FnMut(Coordinate) -> Target<f64>,
        sides: &[bool],
    ) -> f64 {
        let mut sides = sides.iter();
        let measured = self.measured(measure);
        self.formula.at_state(t, &measured, |value| sides.next().copied().unwrap_or(value >= 0.0))
    }

    /// Appends the values of the switching functions at time `t`, s, to `values`. They are computed
    /// on the branches that `sides` selects, as in [`Self::at`].
    pub fn switches_at(
        &self,
        t: f64,
        measure: impl FnMut(Coordinate) -> Target<f64>,
        sides: &[bool],
        values: &mut Vec<f64>,
    ) {
        let mut sides = sides.iter();
        let measured = self.measured(measure);
        self.formula.at_state(t, &measured, |value| {
            values.push(value);
            sides.next().copied().unwrap_or(value >= 0.0)
        });
    }

    fn measured(&self, mut measure: impl FnMut(Coordinate) -> Target<f64>) -> Vec<f64> {
        let each = self.measured.iter().map(|(coordinate, rate)| {
            let motion = measure(*coordinate);
            if *rate { motion.rate } else { motion.value }
        });
        each.collect()
    }
}

/// A condition that ends a simulation, such as `platform.z < 100 mm`.
#[derive(Clone, Debug)]
pub struct Condition {
    /// Text of the condition as written.
    pub text: String,
    pub(crate) left: Law,
    pub(crate) right: Law,
    /// True if the condition uses `<` or `<=`, false if it uses `>` or `>=`.
    pub(crate) is_less: bool,
    /// True for `<=` and `>=`, which hold at equality.
    pub(crate) or_equal: bool,
}

impl Condition {
    /// Returns true if the condition contains the time.
    pub fn has_time(&self) -> bool {
        self.left.has_time() || self.right.has_time()
    }

    /// Returns a time, s, after `t` (s) such that a few samples between both times resolve every
    /// operation of either side that depends on time alone.
    pub fn resolved_until(&self, t: f64) -> f64 {
        self.left.resolved_until(t).min(self.right.resolved_until(t))
    }

    /// Signed difference of the two sides, in SI units; negative when the condition is true.
    pub fn distance(&self, t: f64, mut measure: impl FnMut(Coordinate) -> Target<f64>) -> f64 {
        let (left, right) = (self.left.at(t, &mut measure, &[]), self.right.at(t, measure, &[]));
        let distance = if self.is_less { left - right } else { right - left };
        if !self.or_equal {
            return distance;
        }
        // Sides that are equal up to rounding count as equal.
        let rounding = 8.0 * f64::EPSILON * (left.abs() + right.abs());
        if distance.abs() <= rounding { -f64::MIN_POSITIVE } else { distance }
    }
}
