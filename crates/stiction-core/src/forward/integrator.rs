//! Numerical integrator: the Runge-Kutta method of Dormand and Prince of order 8, with error
//! control and interpolation.
//!
//! Equation (D6) of the book's theory.

use super::dop853::{ALL_STAGES, ERROR_5, INTERPOLATION, LOWER_3, NODES, STAGES, WEIGHTS};

/// Times of all stages after the first stage, including the stages for the interpolant, as
/// fractions of the step.
pub(super) const NODES_OF_OUTPUT: &[f64] = NODES.split_at(1).1;

/// Stages of the last attempted step, and the interpolant of this step.
#[derive(Clone, Debug, Default)]
pub(super) struct Steps {
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
        let Self { stages, start, last, kept: _, end, step, curve: _, has_curve } = self;
        stages.clone_from(&other.stages);
        start.clone_from(&other.start);
        last.clone_from(&other.last);
        end.clone_from(&other.end);
        (*step, *has_curve) = (other.step, false);
    }

    /// Attempts a step from the state `start` with the time derivative `first`. `time` is the start
    /// and `step` the length of the step, s. `derivative` writes the time derivative at a given
    /// time and state. Returns the estimated error divided by the tolerated error.
    pub(super) fn attempt<E>(
        &mut self,
        start: &[f64],
        first: &[f64],
        (time, step): (f64, f64),
        tolerance: &Tolerance<'_>,
        mut derivative: impl FnMut(f64, &[f64], &mut Vec<f64>) -> Result<(), E>,
    ) -> Result<f64, E> {
        self.start.clear();
        self.start.extend_from_slice(start);
        self.step = step;
        self.has_curve = false;
        self.stages.resize_with(ALL_STAGES, Vec::new);
        self.stages[0].clear();
        self.stages[0].extend_from_slice(first);
        for stage in 1..STAGES {
            self.evaluate(stage, time, &mut derivative)?;
        }
        let mut end = std::mem::take(&mut self.end);
        self.point(WEIGHTS[STAGES], &mut end);
        self.end = end;
        let (mut fifth, mut third, mut count) = (0.0, 0.0, 0);
        for i in 0..start.len() {
            if tolerance.scales[i].is_infinite() {
                continue;
            }
            let size = start[i].abs().max(self.end[i].abs());
            let unit = tolerance.absolute * tolerance.scales[i] + tolerance.relative * size;
            let sum = |weights: &[(usize, f64)]| -> f64 {
                weights.iter().map(|&(k, w)| w * self.stages[k][i]).sum()
            };
            let five = sum(ERROR_5) / unit;
            let three = (sum(WEIGHTS[STAGES]) - sum(LOWER_3)) / unit;
            fifth += five * five;
            third += three * three;
            count += 1;
        }
        let below = fifth + 0.01 * third;
        if below == 0.0 {
            return Ok(0.0);
        }
        Ok(step.abs() * fifth / (below * f64::from(count.max(1))).sqrt())
    }

    /// Evaluates the derivative at a stage, and stores the state at this stage in `last`.
    fn evaluate<E>(
        &mut self,
        stage: usize,
        time: f64,
        derivative: &mut impl FnMut(f64, &[f64], &mut Vec<f64>) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut y = std::mem::take(&mut self.last);
        self.point(WEIGHTS[stage], &mut y);
        let mut rates = std::mem::take(&mut self.stages[stage]);
        let done = derivative(time + NODES[stage] * self.step, &y, &mut rates);
        self.stages[stage] = rates;
        self.last = y;
        done
    }

    /// Estimates the product of the step size and the largest rate at which neighbouring solutions
    /// converge (E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, section IV.2).
    /// If the estimate exceeds about six, the step is limited by stability, not by accuracy.
    /// `after` is the derivative at the end of the step.
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
        for stage in STAGES + 1..ALL_STAGES {
            self.evaluate(stage, time, &mut derivative)?;
        }
        std::mem::swap(&mut self.kept, &mut self.last);
        let Self { stages, start, end, step: h, curve, .. } = self;
        let first = &stages[0];
        curve.resize_with(3 + INTERPOLATION.len(), Vec::new);
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
        Ok(())
    }

    /// Writes the interpolated state at the fraction `part` of the step, between 0 and 1, to `y`.
    pub(super) fn at(&self, part: f64, y: &mut Vec<f64>) {
        debug_assert!(self.has_curve, "the curve is that of this step");
        y.clear();
        y.resize(self.start.len(), 0.0);
        for (k, coefficients) in self.curve.iter().rev().enumerate() {
            let factor = if k % 2 == 0 { part } else { 1.0 - part };
            y.iter_mut().zip(coefficients).for_each(|(y, c)| *y = (*y + c) * factor);
        }
        y.iter_mut().zip(&self.start).for_each(|(y, s)| *y += s);
    }
}
