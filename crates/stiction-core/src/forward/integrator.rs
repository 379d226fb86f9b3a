//! Numerical integrator: the Runge-Kutta method of Dormand and Prince of order 8, with error
//! control and interpolation. Steps that the inputs shorten use methods of lower order, which have
//! fewer stages: the classical method of order 4, and the method of Cash and Karp of order 5.
//!
//! Equation (D6) of the book's theory.

use super::cash_karp::{self, ERROR_4};
use super::classical;
use super::dop853::{ALL_STAGES, ERROR_5, INTERPOLATION, LOWER_3, NODES, STAGES, WEIGHTS};

/// Times of all stages after the first stage, including the stages for the interpolant, as
/// fractions of the step.
pub(super) const NODES_OF_OUTPUT: &[f64] = NODES.split_at(1).1;

/// Runge-Kutta method of a step, by its order.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Order {
    /// Classical method.
    Four,
    /// Method of Cash and Karp.
    Five,
    /// Method of Dormand and Prince.
    #[default]
    Eight,
}

/// Stages of the last attempted step, and the interpolant of this step.
#[derive(Clone, Debug, Default)]
pub(super) struct Steps {
    order: Order,
    stages: Vec<Vec<f64>>,
    start: Vec<f64>,
    /// State at the stage evaluated last.
    last: Vec<f64>,
    /// Copy of `last` while the interpolant is prepared.
    kept: Vec<f64>,
    pub(super) end: Vec<f64>,
    pub(super) step: f64,
    /// Coefficients of the interpolant, valid if `has_curve`.
    curve: Vec<Vec<f64>>,
    has_curve: bool,
}

/// Error tolerances of a step. The tolerated error of a component `y` of the state is
/// `absolute * scale + relative * |y|`, where `scale` is the entry of this component in `scales`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tolerance<'a> {
    pub(super) relative: f64,
    pub(super) absolute: f64,
    pub(super) scales: &'a [f64],
}

impl Steps {
    /// Copies the stages of another step, without the interpolant, reusing the buffers of this
    /// step.
    pub(super) fn copy_from(&mut self, other: &Self) {
        let Self { order, stages, start, last, kept: _, end, step, curve: _, has_curve } = self;
        *order = other.order;
        stages.clone_from(&other.stages);
        start.clone_from(&other.start);
        last.clone_from(&other.last);
        end.clone_from(&other.end);
        (*step, *has_curve) = (other.step, false);
    }

    /// Attempts a step from the state `start` with the time derivative `first`. `time` is the start
    /// and `step` the length of the step, s. `derivative` writes the time derivative at a given
    /// time and state. Returns the estimated error divided by the tolerated error; zero at order 4,
    /// whose error [`Self::error_of_order_3`] estimates at the end of the step.
    pub(super) fn attempt<E>(
        &mut self,
        order: Order,
        (start, first): (&[f64], &[f64]),
        (time, step): (f64, f64),
        tolerance: &Tolerance<'_>,
        mut derivative: impl FnMut(f64, &[f64], &mut Vec<f64>) -> Result<(), E>,
    ) -> Result<f64, E> {
        self.order = order;
        self.start.clear();
        self.start.extend_from_slice(start);
        self.step = step;
        self.has_curve = false;
        self.stages.resize_with(ALL_STAGES, Vec::new);
        self.stages[0].clear();
        self.stages[0].extend_from_slice(first);
        let (nodes, weights): (&[f64], &[_]) = match order {
            Order::Four => (&classical::NODES, &classical::WEIGHTS),
            Order::Five => (&cash_karp::NODES, &cash_karp::WEIGHTS),
            Order::Eight => (&NODES[..STAGES], &WEIGHTS),
        };
        for stage in 1..nodes.len() {
            self.evaluate(stage, (time, nodes[stage]), weights[stage], &mut derivative)?;
        }
        let mut end = std::mem::take(&mut self.end);
        self.point(weights[nodes.len()], &mut end);
        self.end = end;
        Ok(match order {
            Order::Four => 0.0,
            Order::Five => self.error_of_order_4(tolerance),
            Order::Eight => self.error_of_order_5(tolerance),
        })
    }

    /// Returns the order of the last attempted step.
    pub(super) fn order(&self) -> Order {
        self.order
    }

    /// Returns the estimated error of a step of order 4 divided by the tolerated error. `after` is
    /// the derivative at the end of the step.
    pub(super) fn error_of_order_3(&self, after: &[f64], tolerance: &Tolerance<'_>) -> f64 {
        let last = &self.stages[classical::STAGES - 1];
        self.mean_error(tolerance, |i| classical::LAST * (last[i] - after[i]))
    }

    /// Returns the estimated error of a step of order 5 divided by the tolerated error.
    fn error_of_order_4(&self, tolerance: &Tolerance<'_>) -> f64 {
        self.mean_error(tolerance, |i| self.sum(ERROR_4, i))
    }

    /// Returns the root mean square of the errors of all components, each divided by its tolerated
    /// error. `of` returns the error of a component divided by the step.
    fn mean_error(&self, tolerance: &Tolerance<'_>, of: impl Fn(usize) -> f64) -> f64 {
        let (mut squares, mut count) = (0.0, 0);
        self.each_unit(tolerance, |i, unit| {
            let error = of(i) / unit;
            squares += error * error;
            count += 1;
        });
        self.step.abs() * (squares / f64::from(count.max(1))).sqrt()
    }

    /// Returns the estimated error of a step of order 8, from the error estimates of orders 5 and
    /// 3, divided by the tolerated error.
    fn error_of_order_5(&self, tolerance: &Tolerance<'_>) -> f64 {
        let (mut fifth, mut third, mut count) = (0.0, 0.0, 0);
        self.each_unit(tolerance, |i, unit| {
            let five = self.sum(ERROR_5, i) / unit;
            let three = (self.sum(WEIGHTS[STAGES], i) - self.sum(LOWER_3, i)) / unit;
            fifth += five * five;
            third += three * three;
            count += 1;
        });
        let below = fifth + 0.01 * third;
        if below == 0.0 {
            return 0.0;
        }
        self.step.abs() * fifth / (below * f64::from(count.max(1))).sqrt()
    }

    /// Calls `of` for each component of the state under error control, with its index and its
    /// tolerated error.
    fn each_unit(&self, tolerance: &Tolerance<'_>, mut of: impl FnMut(usize, f64)) {
        for (i, scale) in tolerance.scales.iter().enumerate().filter(|(_, s)| !s.is_infinite()) {
            let size = self.start[i].abs().max(self.end[i].abs());
            of(i, tolerance.absolute * scale + tolerance.relative * size);
        }
    }

    /// Returns the weighted sum of the stage derivatives of a component.
    fn sum(&self, weights: &[(usize, f64)], i: usize) -> f64 {
        weights.iter().map(|&(k, w)| w * self.stages[k][i]).sum()
    }

    /// Evaluates the derivative at a stage, and stores the state at this stage in `last`. `node` is
    /// the time of the stage as a fraction of the step.
    fn evaluate<E>(
        &mut self,
        stage: usize,
        (time, node): (f64, f64),
        weights: &[(usize, f64)],
        derivative: &mut impl FnMut(f64, &[f64], &mut Vec<f64>) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut y = std::mem::take(&mut self.last);
        self.point(weights, &mut y);
        let mut rates = std::mem::take(&mut self.stages[stage]);
        let done = derivative(time + node * self.step, &y, &mut rates);
        self.stages[stage] = rates;
        self.last = y;
        done
    }

    /// Estimates the product of the step size and the largest rate at which neighbouring solutions
    /// converge (E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, section IV.2).
    /// If the estimate exceeds about six, the step is limited by stability, not by accuracy.
    /// `after` is the derivative at the end of the step, which must be of order 8.
    pub(super) fn stiffness(&self, after: &[f64], scales: &[f64]) -> f64 {
        let Some(before) = self.stages.get(STAGES - 1) else { return 0.0 };
        let (mut change, mut apart) = (0.0, 0.0);
        for (i, scale) in scales.iter().enumerate().filter(|(_, scale)| scale.is_finite()) {
            change += ((after[i] - before[i]) / scale).powi(2);
            apart += ((self.end[i] - self.last[i]) / scale).powi(2);
        }
        if apart > 0.0 { self.step * (change / apart).sqrt() } else { 0.0 }
    }

    /// Writes to `y` the state at the start of the step plus the step size times the weighted sum
    /// of the stage derivatives.
    fn point(&self, weights: &[(usize, f64)], y: &mut Vec<f64>) {
        y.clear();
        y.extend_from_slice(&self.start);
        for &(k, weight) in weights {
            let amount = weight * self.step;
            y.iter_mut().zip(&self.stages[k]).for_each(|(y, k)| *y += amount * k);
        }
    }

    /// Prepares the interpolant for [`Self::at`]. `last` is the derivative at the end of the step.
    /// After a step of lower order, evaluates the stages of order 8 first; the interpolant ends at
    /// the end of the step of lower order.
    pub(super) fn interpolate<E>(
        &mut self,
        time: f64,
        last: &[f64],
        mut derivative: impl FnMut(f64, &[f64], &mut Vec<f64>) -> Result<(), E>,
    ) -> Result<(), E> {
        self.stages[STAGES].clear();
        self.stages[STAGES].extend_from_slice(last);
        // [`Self::stiffness`] needs the state at the last stage of the step, not at the additional
        // stages of the interpolant.
        std::mem::swap(&mut self.kept, &mut self.last);
        let missing = match self.order {
            Order::Four | Order::Five => 1..STAGES,
            Order::Eight => 0..0,
        };
        for stage in missing.chain(STAGES + 1..ALL_STAGES) {
            self.evaluate(stage, (time, NODES[stage]), WEIGHTS[stage], &mut derivative)?;
        }
        std::mem::swap(&mut self.kept, &mut self.last);
        self.set_curve(3 + INTERPOLATION.len(), Some(last));
        Ok(())
    }

    /// Prepares a curve of lower order for [`Self::at`], without further stages: a cubic with the
    /// derivatives at both ends, or a parabola if the derivative `last` at the end is not known.
    pub(super) fn join_ends(&mut self, last: Option<&[f64]>) {
        self.set_curve(if last.is_some() { 3 } else { 2 }, last);
    }

    /// Computes the first `count` coefficients of the interpolant.
    fn set_curve(&mut self, count: usize, last: Option<&[f64]>) {
        let Self { stages, start, end, step: h, curve, .. } = self;
        let first = &stages[0];
        let last = last.unwrap_or(first);
        curve.resize_with(count, Vec::new);
        for (k, out) in curve.iter_mut().enumerate() {
            out.clear();
            out.extend((0..start.len()).map(|i| {
                let change = end[i] - start[i];
                match k {
                    0 => change,
                    1 => *h * first[i] - change,
                    2 => 2.0 * change - *h * (first[i] + last[i]),
                    _ => {
                        *h * INTERPOLATION[k - 3]
                            .iter()
                            .map(|&(k, w)| w * stages[k][i])
                            .sum::<f64>()
                    }
                }
            }));
        }
        self.has_curve = true;
    }

    /// Writes the interpolated state at the fraction `part` of the step, between 0 and 1, to `y`.
    pub(super) fn at(&self, part: f64, y: &mut Vec<f64>) {
        debug_assert!(self.has_curve, "the curve is that of this step");
        y.clear();
        y.resize(self.start.len(), 0.0);
        for (k, coefficients) in self.curve.iter().enumerate().rev() {
            let factor = if k % 2 == 0 { part } else { 1.0 - part };
            y.iter_mut().zip(coefficients).for_each(|(y, c)| *y = (*y + c) * factor);
        }
        y.iter_mut().zip(&self.start).for_each(|(y, s)| *y += s);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    const SCALES: Tolerance<'_> = Tolerance { relative: 0.0, absolute: 1.0, scales: &[1.0] };

    /// Derivative of `exp(sin t)`.
    fn rate(t: f64, y: &[f64], rates: &mut Vec<f64>) -> Result<(), Infallible> {
        rates.clear();
        rates.push(y[0] * t.cos());
        Ok(())
    }

    /// Integrates from 0 to 1 in `count` steps. Returns the error at the end, and the largest
    /// estimate of an error in a step.
    fn error(order: Order, count: u32) -> (f64, f64) {
        let mut steps = Steps::default();
        let (mut y, mut first, mut most) = (vec![1.0], Vec::new(), 0.0_f64);
        let step = 1.0 / f64::from(count);
        for k in 0..count {
            let time = f64::from(k) * step;
            let Ok(()) = rate(time, &y, &mut first);
            let state = (&y[..], &first[..]);
            let Ok(mut own) = steps.attempt(order, state, (time, step), &SCALES, rate);
            y.clone_from(&steps.end);
            if order == Order::Four {
                let Ok(()) = rate(time + step, &y, &mut first);
                own = steps.error_of_order_3(&first, &SCALES);
            }
            most = most.max(own);
        }
        ((y[0] - 1_f64.sin().exp()).abs(), most)
    }

    #[test]
    fn methods_have_their_orders_and_overestimate_their_errors() {
        for (order, power) in [(Order::Four, 4), (Order::Five, 5), (Order::Eight, 8)] {
            let ((coarse, _), (fine, most)) = (error(order, 4), error(order, 8));
            assert!(coarse > 0.7 * 2_f64.powi(power) * fine, "{order:?}: {coarse:e} {fine:e}");
            assert!(fine < 8.0 * most, "{order:?}: {fine:e} {most:e}");
        }
    }

    #[test]
    fn interpolation_of_steps_of_lower_order_is_accurate() {
        for order in [Order::Four, Order::Five, Order::Eight] {
            let (mut steps, mut y) = (Steps::default(), Vec::new());
            let (mut first, mut last) = (Vec::new(), Vec::new());
            let Ok(()) = rate(0.0, &[1.0], &mut first);
            let Ok(_) = steps.attempt(order, (&[1.0], &first), (0.0, 0.1), &SCALES, rate);
            let end = steps.end.clone();
            let Ok(()) = rate(0.1, &end, &mut last);
            let Ok(()) = steps.interpolate(0.0, &last, rate);
            for k in 0..=10 {
                let part = f64::from(k) / 10.0;
                steps.at(part, &mut y);
                let error = y[0] - (0.1 * part).sin().exp();
                assert!(error.abs() < 1e-6, "{order:?} at {part}: {error:e}");
            }
            assert!((y[0] - end[0]).abs() < 1e-15, "{order:?}");
        }
    }

    #[test]
    fn curves_through_both_ends_need_no_stages() {
        let (mut steps, mut first, mut last) = (Steps::default(), Vec::new(), Vec::new());
        let Ok(()) = rate(0.0, &[1.0], &mut first);
        let Ok(_) = steps.attempt(Order::Eight, (&[1.0], &first), (0.0, 0.1), &SCALES, rate);
        let Ok(()) = rate(0.1, &steps.end.clone(), &mut last);
        // Third and fourth power of the step, with the coefficients of the interpolation errors.
        for (last, within) in [(None, 5e-5), (Some(&last[..]), 1e-6)] {
            steps.join_ends(last);
            let mut y = Vec::new();
            for k in 0..=10 {
                let part = f64::from(k) / 10.0;
                steps.at(part, &mut y);
                let error = (y[0] - (0.1 * part).sin().exp()).abs();
                assert!(error < if k % 10 == 0 { 1e-14 } else { within }, "{part}: {error:e}");
            }
        }
    }
}
