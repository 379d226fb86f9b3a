//! Coefficients of the Runge-Kutta method of Cash and Karp of order 5, with an error estimate of
//! order 4.
//!
//! Source: J. R. Cash, A. H. Karp, A variable order Runge-Kutta method for initial value problems
//! with rapidly varying right-hand sides, ACM Transactions on Mathematical Software 16 (1990).

/// Number of stages of a step.
pub(super) const STAGES: usize = 6;

/// Time of each stage as a fraction of the step.
pub(super) const NODES: [f64; STAGES] = [0.0, 0.2, 0.3, 0.6, 1.0, 0.875];

/// Coefficients of the Runge-Kutta method: for each stage, the weights of the derivatives at
/// earlier stages, as pairs of stage index and weight. The last row contains the weights of the
/// solution of order 5.
pub(super) const WEIGHTS: [&[(usize, f64)]; STAGES + 1] = [
    &[],
    &[(0, 0.2)],
    &[(0, 3.0 / 40.0), (1, 9.0 / 40.0)],
    &[(0, 0.3), (1, -0.9), (2, 1.2)],
    &[(0, -11.0 / 54.0), (1, 2.5), (2, -70.0 / 27.0), (3, 35.0 / 27.0)],
    &[
        (0, 1631.0 / 55296.0),
        (1, 175.0 / 512.0),
        (2, 575.0 / 13824.0),
        (3, 44275.0 / 110592.0),
        (4, 253.0 / 4096.0),
    ],
    &[(0, 37.0 / 378.0), (2, 250.0 / 621.0), (3, 125.0 / 594.0), (5, 512.0 / 1771.0)],
];

/// Weights of the stage derivatives in the difference of the solutions of orders 5 and 4, as pairs
/// of stage index and weight.
pub(super) const ERROR_4: &[(usize, f64)] = &[
    (0, 37.0 / 378.0 - 2825.0 / 27648.0),
    (2, 250.0 / 621.0 - 18575.0 / 48384.0),
    (3, 125.0 / 594.0 - 13525.0 / 55296.0),
    (4, -277.0 / 14336.0),
    (5, 512.0 / 1771.0 - 0.25),
];
