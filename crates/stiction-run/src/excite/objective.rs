//! Objective of the search, with its derivatives: the information of a motion about the parameters,
//! plus a barrier at the limits.
//!
//! The theory is in equations (X2) and (X3) of the book.

use super::limits::Used;
use super::probe::{Probe, Reading};
use super::series::{Factors, Series};
use nalgebra::{DMatrix, DVector};
use stiction_core::kinematics::Target;
use stiction_core::mechanism::{JointId, Mechanism};
use stiction_core::spatial::Pose;

/// Used fraction of the limit on the singularity index above which the barrier acts for this limit.
const NEAR: f64 = 0.5;
/// Relative step of the finite differences.
const STEP: f64 = 1e-6;
/// Largest distance of a body from its initial position, in characteristic lengths, for which the
/// body counts as having returned at the end of a period.
const RETURNED: f64 = 1e-6;

/// Information about the parameters, used fractions of limits, efforts and barrier of a motion,
/// accumulated over the instants of one period.
#[derive(Clone, Debug)]
pub(super) struct Sweep {
    /// Information matrix of the parameters from the samples of one period, in units of the parameters' scales.
    pub(super) information: DMatrix<f64>,
    /// Largest used fraction of each limit over the period; for limits on rated torques, the root
    /// mean square of the used fraction.
    pub(super) greatest: Vec<f64>,
    /// Root mean square of the effort of each actuator over the period and all payloads.
    pub(super) rms: Vec<f64>,
    /// Mean value of the barrier function of all limits over the period.
    barrier: f64,
}

/// Time grid of one period: the factors of the Fourier series at each instant, and the positions to
/// which the series is added.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    factors: Vec<Factors>,
    pub(super) centre: Vec<f64>,
    /// Displacement of each coordinate, rad or m, for a Fourier coefficient of one.
    pub(super) reach: Vec<f64>,
    /// Number of instants from one evaluation of the singularity index to the next. The instants
    /// between two evaluations use the earlier value, because the evaluation is the slowest part if
    /// the statics is indeterminate.
    stride: usize,
}

impl Grid {
    /// Creates a grid of `count` instants over a period of `period` seconds.
    pub(super) fn new(
        series: &Series,
        period: f64,
        (count, stride): (usize, usize),
        centre: &[f64],
        reach: &[f64],
    ) -> Self {
        let factors = (0..count).map(|k| series.factors(period * k as f64 / count as f64));
        Self { factors: factors.collect(), centre: centre.to_vec(), reach: reach.to_vec(), stride }
    }

    pub(super) fn len(&self) -> usize {
        self.factors.len()
    }

    /// Returns the positions, rates and accelerations of all coordinates at instant `k` of the
    /// grid. `x` contains the free coefficients of the Fourier series, coordinate by coordinate.
    pub(super) fn motion(&self, k: usize, x: &DVector<f64>) -> [Vec<f64>; 3] {
        let size = x.len() / self.centre.len();
        [0, 1, 2].map(|order| {
            let each = (0..self.centre.len()).map(|i| {
                let own = x.rows(i * size, size);
                let base = if order == 0 { self.centre[i] } else { 0.0 };
                base + self.reach[i] * self.factors[k][order].dot(&own)
            });
            each.collect()
        })
    }
}

/// Objective of the search: the log-determinant of the information on the base parameters plus a
/// weighted barrier at the limits.
pub(super) struct Objective {
    probe: Probe,
    /// Evaluator of the robot at the first position. A copy of it replaces `probe` after a failed
    /// evaluation.
    home: Probe,
    poses: Vec<Pose<f64>>,
    pub(super) grid: Grid,
    /// Weight of the regressor rows of each actuator: the inverse of the standard deviation of its
    /// effort.
    pub(super) weights: Vec<f64>,
    /// Regressor columns of the chosen parameters, each with the scale of its parameter.
    pub(super) columns: Vec<(usize, f64)>,
    /// Indices in `columns` of the representative parameters, one for each base parameter.
    pub(super) leaders: Vec<usize>,
    rated: Vec<bool>,
}

impl Objective {
    pub(super) fn new(probe: Probe, grid: Grid) -> Self {
        let poses = probe.bodies().pose.clone();
        let columns = probe.parameters().iter().enumerate().map(|(k, p)| (k, p.scale)).collect();
        let (_, actuators) = probe.shape();
        let rated = probe.limits.rated();
        Self {
            home: probe.clone(),
            poses,
            grid,
            weights: vec![1.0; actuators],
            columns,
            leaders: Vec::new(),
            rated,
            probe,
        }
    }

    /// Returns the same objective for the mechanism with each payload in `loaded`; `None` if the
    /// robot has no finite forces with one of them.
    pub(super) fn with_payloads(&self, loaded: &[Mechanism]) -> Option<Self> {
        let mut home = self.home.with_payloads(loaded);
        let rest = vec![0.0; self.grid.centre.len()];
        home.at([&self.grid.centre, &rest, &rest], None)?;
        Some(Self {
            probe: home.clone(),
            rated: home.limits.rated(),
            home,
            poses: self.poses.clone(),
            grid: self.grid.clone(),
            weights: self.weights.clone(),
            columns: self.columns.clone(),
            leaders: self.leaders.clone(),
        })
    }

    /// Returns the evaluator of the robot, with the state of the most recently evaluated instant.
    pub(super) fn probe(&self) -> &Probe {
        &self.probe
    }

    /// Evaluates the robot at all instants of a period in order, and calls `each` with the result
    /// at each instant. `None` if the robot cannot follow the motion.
    pub(super) fn read(
        &mut self,
        grid: &Grid,
        x: &DVector<f64>,
        mut each: impl FnMut(&mut Probe, usize, &Reading),
    ) -> Option<()> {
        let mut read = || {
            let mut last = None;
            for k in 0..grid.len() {
                let motion = grid.motion(k, x);
                let known = last.filter(|_| k % grid.stride > 0);
                let reading = self.probe.at(motion.each_ref().map(Vec::as_slice), known)?;
                last = Some(reading.index);
                each(&mut self.probe, k, &reading);
            }
            // The period must end at the first position, in the same assembly mode.
            let rest = vec![0.0; grid.centre.len()];
            self.probe.at([&grid.centre, &rest, &rest], Some(1.0))?;
            let length = self.probe.mechanism().characteristic_length();
            let now = &self.probe.bodies().pose;
            let away = now.iter().zip(&self.poses).map(|(a, b)| (a.position - b.position).norm());
            (away.fold(0.0, f64::max) < RETURNED * length).then_some(())
        };
        let outcome = read();
        if outcome.is_none() {
            self.probe = self.home.clone();
        }
        outcome
    }

    /// Computes positions, rates and accelerations of the degrees of freedom `dofs` at an instant
    /// of the motion near the most recently evaluated instant. `None` if the robot cannot follow
    /// the motion.
    pub(super) fn actuators_at(
        &mut self,
        motion: [&[f64]; 3],
        dofs: &[(JointId, usize)],
    ) -> Option<[Vec<f64>; 3]> {
        self.probe.at(motion, Some(1.0))?;
        let found: Vec<Target<f64>> =
            dofs.iter().map(|&(joint, dof)| self.probe.dof_at(joint, dof)).collect();
        Some([
            found.iter().map(|t| t.value).collect(),
            found.iter().map(|t| t.rate).collect(),
            found.iter().map(|t| t.acceleration).collect(),
        ])
    }

    /// Returns the regressor rows at an instant for the chosen columns, scaled and weighted. The
    /// row of an actuator is zero if friction at rest acts on the actuator.
    fn rows(weights: &[f64], columns: &[(usize, f64)], reading: &Reading) -> DMatrix<f64> {
        let actuators = weights.len();
        DMatrix::from_fn(reading.rows.nrows(), columns.len(), |row, column| {
            let (k, scale) = columns[column];
            match reading.resting[row] {
                true => 0.0,
                false => reading.rows[(row, k)] * scale * weights[row % actuators],
            }
        })
    }

    /// Computes information, used fractions of limits, efforts and barrier over a period on the
    /// time grid `grid`. `None` if the robot cannot follow the motion.
    pub(super) fn sweep_on(&mut self, grid: &Grid, x: &DVector<f64>) -> Option<Sweep> {
        let (weights, columns) = (self.weights.clone(), self.columns.clone());
        let size = columns.len();
        let (cases, actuators) = self.probe.shape();
        let rated = self.rated.clone();
        let mut sweep = Sweep {
            information: DMatrix::zeros(size, size),
            greatest: vec![0.0; rated.len()],
            rms: vec![0.0; actuators],
            barrier: 0.0,
        };
        let over = 1.0 / grid.len() as f64;
        self.read(grid, x, |_, _, reading| {
            let rows = Self::rows(&weights, &columns, reading);
            sweep.information.gemm_tr(1.0, &rows, &rows, 1.0);
            for ((greatest, part), rated) in
                sweep.greatest.iter_mut().zip(&reading.parts).zip(&rated)
            {
                match rated {
                    true => *greatest += over * part * part,
                    false => *greatest = greatest.max(part.abs()),
                }
            }
            for efforts in &reading.efforts {
                for (sum, effort) in sweep.rms.iter_mut().zip(efforts) {
                    *sum += over * effort * effort / cases as f64;
                }
            }
            sweep.barrier += over * barrier(reading, &rated);
        })?;
        sweep.rms.iter_mut().for_each(|sum| *sum = sum.sqrt());
        for (greatest, rated) in sweep.greatest.iter_mut().zip(&rated) {
            if *rated {
                sweep.barrier += (1.0 - *greatest).max(0.0).ln();
                *greatest = greatest.sqrt();
            }
        }
        Some(sweep)
    }

    /// Computes the quantities of [`Self::sweep_on`], with the information about parameters that act
    /// on friction through the normal loads. The search does without, because it takes a multiple
    /// of the time.
    pub(super) fn sweep_through_loads(&mut self, grid: &Grid, x: &DVector<f64>) -> Option<Sweep> {
        self.probe.through_loads = true;
        let sweep = self.sweep_on(grid, x);
        self.probe.through_loads = false;
        sweep
    }

    pub(super) fn sweep(&mut self, x: &DVector<f64>) -> Option<Sweep> {
        let grid = self.grid.clone();
        self.sweep_on(&grid, x)
    }

    /// Returns the log-determinant of the information matrix of the base parameters.
    pub(super) fn log_det(&self, sweep: &Sweep) -> Option<f64> {
        let own = leading(&sweep.information, &self.leaders);
        Some(2.0 * own.cholesky()?.l_dirty().diagonal().iter().map(|d| d.ln()).sum::<f64>())
    }

    /// Returns the objective with the weight `mu` of the barrier, and the quantities accumulated
    /// over the period; `None` if a limit is exceeded.
    pub(super) fn value(&mut self, x: &DVector<f64>, mu: f64) -> Option<(f64, Sweep)> {
        let sweep = self.sweep(x)?;
        if sweep.greatest.iter().any(|part| *part >= 1.0) {
            return None;
        }
        let value = self.log_det(&sweep)? + mu * sweep.barrier;
        value.is_finite().then_some((value, sweep))
    }

    /// Computes the gradient of [`Self::value`]. It consists of finite differences with respect to
    /// positions, rates and accelerations at each instant, followed by the linear map from the
    /// coefficients. The derivative of the log-determinant of `M` equals that of
    /// `sum phi^T M^-1 phi` with constant `M`.
    pub(super) fn gradient(
        &mut self,
        x: &DVector<f64>,
        mu: f64,
        sweep: &Sweep,
    ) -> Option<DVector<f64>> {
        let inverse = leading(&sweep.information, &self.leaders).cholesky()?.inverse();
        let (grid, weights) = (self.grid.clone(), self.weights.clone());
        let columns: Vec<(usize, f64)> = self.leaders.iter().map(|&k| self.columns[k]).collect();
        let rated = self.rated.clone();
        let over = 1.0 / grid.len() as f64;
        // For a mean square `m` the barrier `ln(1 - m)` has the derivative `-1/(1 - m)`; `left`
        // contains `1 - m`.
        let left: Vec<f64> = sweep.greatest.iter().map(|part| 1.0 - part * part).collect();
        let own = |reading: &Reading| -> f64 {
            let rows = Self::rows(&weights, &columns, reading);
            let product = &rows * &inverse;
            let mut sum = product.component_mul(&rows).sum();
            sum += mu * over * barrier(reading, &rated);
            let squares = reading.parts.iter().zip(&left).zip(&rated).filter(|(_, rated)| **rated);
            sum - mu * over * squares.map(|((part, left), _)| part * part / left).sum::<f64>()
        };
        let (count, size) = (grid.centre.len(), x.len() / grid.centre.len());
        let mut gradient = DVector::zeros(x.len());
        let mut failed = false;
        let omega = grid_frequency(&grid);
        self.read(&grid, x, |probe, k, reading| {
            let value = own(reading);
            let motion = grid.motion(k, x);
            for i in 0..count {
                for order in 0..3 {
                    let step = STEP * grid.reach[i] * omega.powi(order as i32);
                    let mut moved = motion.clone();
                    moved[order][i] += step;
                    // The singularity index depends on positions only, and contributes to the
                    // barrier only near its limit.
                    let is_near = reading.parts.last().is_some_and(|part| part.abs() > NEAR);
                    let is_kept = k % grid.stride > 0;
                    let known = (order > 0 || !is_near || is_kept).then_some(reading.index);
                    let Some(other) = probe.at(moved.each_ref().map(Vec::as_slice), known) else {
                        failed = true;
                        return;
                    };
                    // A change between sliding and rest is a jump of the friction, not a slope.
                    if other.resting != reading.resting {
                        continue;
                    }
                    let slope = (own(&other) - value) / step;
                    let factors = &grid.factors[k][order];
                    gradient.rows_mut(i * size, size).axpy(slope * grid.reach[i], factors, 1.0);
                }
            }
        })?;
        (!failed && gradient.iter().all(|g| g.is_finite())).then_some(gradient)
    }

    /// Returns the utilisation of each limit over the period of `sweep`.
    pub(super) fn used(&self, sweep: &Sweep) -> Vec<Used> {
        self.probe.limits.used(&sweep.greatest)
    }
}

/// Returns the ratio of rates to positions in the Fourier series, rad/s, which scales the steps of
/// the finite differences.
fn grid_frequency(grid: &Grid) -> f64 {
    let size = |order: usize| {
        let all = grid.factors.iter().flat_map(|factors| factors[order].iter());
        all.fold(0.0, |max: f64, x| max.max(x.abs()))
    };
    size(1) / size(0)
}

/// Extracts the rows and columns of an information matrix for the parameters in `leaders`.
pub(super) fn leading(information: &DMatrix<f64>, leaders: &[usize]) -> DMatrix<f64> {
    information.select_rows(leaders).select_columns(leaders)
}

/// Returns the sum of `ln(1 - part^2)` over the limits that must hold at every instant, where
/// `part` is the used fraction of a limit. The sum is minus infinity if a limit is exceeded. The
/// last fraction is that of the singularity index, which contributes to the sum only near its
/// limit.
fn barrier(reading: &Reading, rated: &[bool]) -> f64 {
    let last = reading.parts.len().saturating_sub(1);
    let each = reading.parts.iter().zip(rated).enumerate().filter(|(_, (_, rated))| !**rated);
    let each = each.map(|(k, (part, _))| {
        let part = if k == last { ((part.abs() - NEAR) / (1.0 - NEAR)).max(0.0) } else { *part };
        (1.0 - part * part).max(0.0).ln()
    });
    each.sum()
}
