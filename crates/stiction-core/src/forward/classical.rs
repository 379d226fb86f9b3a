//! Coefficients of the classical Runge-Kutta method of order 4. With the derivative at the end of
//! the step, the difference of the derivatives at the end estimates the error of order 3.

/// Number of stages of a step.
pub(super) const STAGES: usize = 4;

/// Time of each stage as a fraction of the step.
pub(super) const NODES: [f64; STAGES] = [0.0, 0.5, 0.5, 1.0];

/// Coefficients of the Runge-Kutta method: for each stage, the weights of the derivatives at
/// earlier stages, as pairs of stage index and weight. The last row contains the weights of the
/// solution of order 4.
pub(super) const WEIGHTS: [&[(usize, f64)]; STAGES + 1] = [
    &[],
    &[(0, 0.5)],
    &[(1, 0.5)],
    &[(2, 1.0)],
    &[(0, 1.0 / 6.0), (1, 1.0 / 3.0), (2, 1.0 / 3.0), (3, 1.0 / 6.0)],
];

/// Weight of the last stage in the solution of order 4. The solution of order 3 has the derivative
/// at the end of the step in its place.
pub(super) const LAST: f64 = 1.0 / 6.0;
