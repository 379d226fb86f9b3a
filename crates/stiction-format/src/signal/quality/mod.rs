//! Quality of recorded signals: noise, outliers, and contradictions between columns.
//!
//! Accelerations of a recording come from second differences of its positions, so small errors of
//! positions become large errors of efforts. The check estimates these errors from the samples and
//! compares them with the accelerations of the motion and with the rounding of the written numbers.
//!
//! - Noise: residuals of interpolation through neighbouring samples ([`stencil`]). A smooth signal
//!   leaves almost none. Steps of the acceleration increase only the residuals near them, so that a
//!   low quantile of the residuals is unaffected. Noise that the written digits explain is
//!   rounding.
//! - Outliers: accelerations by differences that lie outside all predictions from neighbours on
//!   both sides. A step of the acceleration lies between the predictions, a wrong sample does not.
//! - Wrong values in smooth stretches: residuals of a polynomial that have the shape of one wrong
//!   value, a jump, or two exchanged values ([`matched`]). This finds errors at few samples per
//!   period, where neighbouring accelerations differ too much for predictions.
//! - Rows in a wrong order: accelerations that become like the neighbouring ones if two values are
//!   exchanged.
//! - Held values: each value of a moving signal is repeated several times, because the sensor is
//!   slower than the log.
//! - Contradictions: displacements that differ from the integrals of the recorded rates.
//! - Gaps: time steps much longer than all others ([`gaps`]).
//!
//! Samples are analysed in blocks, so that the memory needed does not depend on the length of the
//! recording.

pub(crate) mod gaps;
mod histogram;
mod matched;
mod order;
mod outliers;
mod stencil;

use crate::signal::Given;
use histogram::Histogram;
use matched::{Kind, Matched};
use order::{exchanged, held};
use outliers::{AtEnd, at_zero, excess, excess_at_end};
use stencil::{Stencil, WIDE, residual, residuals};

/// Number of samples per analysed block.
const BLOCK: usize = 256;
/// Samples needed on either side of an analysed sample.
const MARGIN: usize = 12;
/// Number of blocks, from the beginning of the recording, that are all tested for noise. Of the
/// later blocks, one in [`SPARSE`] is tested.
const DENSE_BLOCKS: usize = 200;
const SPARSE: usize = 8;
/// Quantile of the residuals from which noise is estimated, and its value for a normal
/// distribution of unit variance. It is low, so that disturbed residuals do not count.
const NOISE_QUANTILE: (f64, f64) = (0.3, 0.385_320_466);
/// Minimum number of residuals of each stencil that a block needs for an estimate of its noise.
const FEWEST_RESIDUALS: usize = 28;
/// Noise is reported if its standard deviation in the acceleration exceeds this fraction of the peak acceleration. The
/// peak of the noise is then about 5 % of the peak acceleration.
const NOISE_LIMIT: f64 = 0.014;
/// Noise up to this multiple of the rounding of the written numbers is attributed to rounding.
const EXPLAINED: f64 = 6.0;
/// Minimum ratio of a residual to the standard deviation of rounding at which a value is compared
/// with a polynomial through more neighbours.
const MATCHED_SIGMAS: f64 = 3.0;
/// Minimum ratio of such a residual to the median residual of the block.
const UNUSUAL: f64 = 3.0;
/// Error of the acceleration, relative to its peak, above which an outlier is reported.
const OUTLIER_LIMIT: f64 = 0.025;
/// Minimum ratio of the acceleration error of an outlier to the typical error of predictions in the
/// recording.
const OUTLIER_FACTOR: f64 = 5.0;
/// Minimum ratio of the acceleration error of an outlier to the standard deviation of the
/// acceleration that rounding causes.
const OUTLIER_SIGMAS: f64 = 8.0;
/// Minimum ratio of the acceleration error of an outlier to the standard deviation of the
/// acceleration that noise causes.
const OUTLIER_NOISE: f64 = 4.0;
/// Difference between a recorded derivative and the slope of the column of the next lower order,
/// relative to the root mean square of the slope, above which a contradiction is reported. The
/// first limit applies to the difference of a rate at a single sample, the second to the median of
/// the differences in a block.
const CONTRADICTION_LIMIT: (f64, f64) = (0.02, 0.01);
/// Minimum ratio of a rate at an end of the recording to the slopes of the positions there at which a
/// contradiction is reported. The ratio is 4 where a motion begins with the fourth power of time.
const END_RATE_LIMIT: f64 = 6.0;
/// Limit of the ratio of an acceleration's error near an end of the recording to the peak
/// acceleration elsewhere. A reversal of the greatest acceleration has a ratio of 2, so the limit
/// lies above it.
const END_LIMIT: f64 = 2.2;
/// Acceleration error by rounded times, relative to the peak acceleration, above which the error is
/// reported.
const TIME_LIMIT: f64 = 0.05;
/// Minimum number of samples in motion that a block needs for contradictions in it to be judged, and
/// number below which almost all of these samples must contradict, since corners disturb some.
const FEWEST_MOVING: usize = 6;
const ENOUGH_MOVING: usize = 24;
/// Maximum number of stored outlier times.
const MAX_OUTLIERS: usize = 64;

/// A magnitude and the time at which it occurs, s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Peak {
    pub(crate) size: f64,
    pub(crate) time: f64,
}

impl Peak {
    pub(crate) fn raise(&mut self, size: f64, time: f64) {
        // Comparisons with NaN are false.
        if size > self.size {
            *self = Self { size, time };
        }
    }
}

/// Estimated noise of a column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Noise {
    /// Order of the derivative in the column; 0 for positions.
    pub(crate) order: usize,
    /// Standard deviation of the noise, in SI units of the column, in the block in which the noise
    /// has its largest effect on the acceleration, and start time, s, of this block.
    pub(crate) deviation: Peak,
    /// Standard deviation of the acceleration that the noise causes.
    pub(crate) acceleration: f64,
    /// True if the rounding of the written numbers explains the noise.
    pub(crate) is_rounding: bool,
    /// True if most of the rounding effect comes from rounded times.
    pub(crate) is_of_times: bool,
}

/// Values that repeat because the sensor is slower than the recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Held {
    /// Length, in samples, of the longest run of a repeated value.
    pub(crate) samples: usize,
    /// Start of the first block with held values, s.
    pub(crate) time: f64,
}

/// Contradiction between a column and its derivative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Contradiction {
    /// Order of the derivative (1 or 2) that contradicts the column of the next lower order.
    pub(crate) order: usize,
    /// Largest difference, SI units of the derivative.
    pub(crate) difference: Peak,
    /// Root mean square of the derivative, computed by differences of the column of the next lower
    /// order.
    pub(crate) scale: f64,
    /// True if the difference cannot be an effect of the sampling.
    pub(crate) is_certain: bool,
}

/// Findings about one coordinate.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Findings {
    pub(crate) speed: Peak,
    pub(crate) acceleration: Peak,
    pub(crate) noise: Option<Noise>,
    /// Errors of the acceleration at samples inconsistent with their neighbours, in order of time.
    pub(crate) outliers: Vec<Peak>,
    /// Errors of the acceleration caused by exchanged rows, in order of time.
    pub(crate) exchanged: Vec<Peak>,
    pub(crate) held: Option<Held>,
    pub(crate) contradictions: Vec<Contradiction>,
}

/// Quality test of one coordinate, sample by sample.
pub(crate) struct Quality {
    orders: usize,
    times: Vec<f64>,
    /// Values and given derivatives; the standard deviations of their rounding are in `rounding`.
    columns: Vec<Vec<f64>>,
    rounding: Vec<Vec<f64>>,
    /// Standard deviation of the rounding error of the times, s, according to their digits; zero if
    /// all steps are equal.
    time_rounding: f64,
    /// Largest standard deviation of the rounding errors of the values.
    value_rounding: f64,
    blocks: usize,
    /// Index of the first sample in the buffer that has not been analysed.
    next: usize,
    speed: Peak,
    acceleration: Peak,
    /// Noise with the largest effect on the acceleration. The first entry is noise that rounding
    /// does not explain, the second is noise that rounding explains.
    noise: [Option<Noise>; 2],
    errors: Histogram,
    outliers: Vec<(Peak, f64)>,
    /// Deviations of the accelerations near the ends of the recording, each with its time and the
    /// standard deviation of its rounding error. `interior` is the largest acceleration elsewhere.
    ends: Vec<(AtEnd, f64, f64)>,
    interior: f64,
    exchanged: Vec<Peak>,
    /// Wrong values in smooth stretches, with the errors of the acceleration.
    wrong: Vec<(Peak, Kind)>,
    held: Option<Held>,
    contradictions: Vec<Difference>,
}

/// Differences between a derivative and the column of the next lower order.
#[derive(Clone, Debug, Default)]
struct Difference {
    /// Largest difference at a sample, beyond rounding and integration errors.
    single: Peak,
    /// Largest median of the differences in a block. `effect` is the largest effect of such a
    /// median on the acceleration.
    sustained: Peak,
    effect: f64,
    /// Largest rate at an end of the recording that is implausible for the slopes there.
    at_end: Peak,
    /// Sum of squares of the derivative computed by differences, and number of terms.
    squares: (f64, f64),
}

impl Quality {
    /// Begins the test of a coordinate. `given` are the derivatives that each sample contains.
    pub(crate) fn new(given: Given) -> Self {
        let orders = match given {
            Given::Values => 1,
            Given::Rates => 2,
            Given::Accelerations => 3,
        };
        Self {
            orders,
            times: Vec::new(),
            columns: vec![Vec::new(); orders],
            rounding: vec![Vec::new(); orders],
            time_rounding: 0.0,
            value_rounding: 0.0,
            blocks: 0,
            next: 0,
            speed: Peak::default(),
            acceleration: Peak::default(),
            noise: [None; 2],
            errors: Histogram::default(),
            outliers: Vec::new(),
            ends: Vec::new(),
            interior: 0.0,
            exchanged: Vec::new(),
            wrong: Vec::new(),
            held: None,
            contradictions: vec![Difference::default(); orders - 1],
        }
    }

    /// Adds a sample. `time` is the time, s, with the standard deviation of its rounding error;
    /// `numbers` are the values in SI units, and `rounding` the standard deviations of their
    /// rounding errors.
    pub(crate) fn push(&mut self, time: (f64, f64), numbers: &[f64], rounding: &[f64]) {
        let last = self.times.last().zip(self.columns.first().and_then(|c| c.last()));
        let speed = match (last, numbers.first(), numbers.get(1)) {
            (_, _, Some(rate)) => *rate,
            (Some((t, value)), Some(new), None) => (new - value) / (time.0 - t),
            _ => 0.0,
        };
        self.times.push(time.0);
        if let [.., a, b, c] = self.times.as_slice() {
            let change = (c - 2.0 * b + a).abs();
            // Steps count as equal if they differ only in the last digit of double precision.
            let equal = change <= 4.0 * f64::EPSILON * c.abs() || is_multiple(b - a, c - b);
            let change = if equal { 0.0 } else { change };
            self.time_rounding = self.time_rounding.max(change.min(time.1));
        }
        for (order, (column, sigmas)) in self.columns.iter_mut().zip(&mut self.rounding).enumerate()
        {
            column.push(numbers.get(order).copied().unwrap_or(0.0));
            let own = rounding.get(order).copied().unwrap_or(0.0);
            let by_time = if order == 0 { speed * self.time_rounding } else { 0.0 };
            if order == 0 {
                self.value_rounding = self.value_rounding.max(own);
            }
            sigmas.push(own.hypot(by_time));
        }
        if self.times.len() >= self.next + BLOCK + MARGIN {
            self.block(self.next..self.next + BLOCK);
            let drop = self.next.saturating_sub(MARGIN);
            self.times.drain(..drop);
            self.columns.iter_mut().chain(&mut self.rounding).for_each(|c| {
                c.drain(..drop);
            });
            self.next -= drop;
        }
    }

    /// Completes the test and returns its findings.
    pub(crate) fn finish(mut self) -> Findings {
        if self.next < self.times.len() {
            self.block(self.next..self.times.len());
        }
        let peak = self.acceleration.size;
        let scale = self.typical(0);
        let significant = |noise: &Noise| noise.acceleration > NOISE_LIMIT * peak;
        let noise = self.noise.into_iter().flatten().find(significant).map(|noise| Noise {
            is_of_times: noise.is_of_times && noise.acceleration >= TIME_LIMIT * peak,
            ..noise
        });
        let noisy = noise.filter(|noise| !noise.is_rounding).map_or(0.0, |n| n.acceleration);
        let typical = self.errors.quantile(0.8);
        let is_large = |error: &Peak| {
            error.size >= OUTLIER_LIMIT * peak && error.size >= OUTLIER_NOISE * noisy
        };
        let mut outliers: Vec<Peak> = self
            .outliers
            .iter()
            .filter(|(error, sigma)| {
                is_large(error)
                    && error.size >= OUTLIER_FACTOR * typical
                    && error.size >= OUTLIER_SIGMAS * sigma
            })
            .map(|(error, _)| *error)
            .collect();
        // Where a coordinate moves only near an end, nothing shows which acceleration is usual.
        let at_ends = self.ends.iter().filter(|(at_end, _, sigma)| {
            (self.interior > 0.0 || at_end.alternates)
                && at_end.error >= END_LIMIT * self.interior.max(at_end.beside)
                && at_end.error >= OUTLIER_SIGMAS * sigma
        });
        outliers.extend(at_ends.map(|&(at_end, time, _)| Peak { size: at_end.error, time }));
        let mut exchanged = std::mem::take(&mut self.exchanged);
        exchanged.retain(is_large);
        // If the other tests have found errors, these may be the same ones.
        if outliers.is_empty() && exchanged.is_empty() {
            for (error, kind) in self.wrong.iter().filter(|(error, _)| is_large(error)) {
                let is_exchange = matches!(kind, Kind::Exchange(_));
                if is_exchange { &mut exchanged } else { &mut outliers }.push(*error);
            }
        }
        exchanged.sort_by(|a, b| a.time.total_cmp(&b.time));
        outliers.sort_by(|a, b| a.time.total_cmp(&b.time));
        let contradictions = self.contradictions.iter().enumerate();
        let contradictions = contradictions.filter_map(|(below, found)| {
            let order = below + 1;
            let scale = self.typical(below).max(if below == 0 { scale } else { 0.0 });
            let effect = found.effect >= NOISE_LIMIT * peak && found.sustained.size > 0.0;
            let (single, sustained) = CONTRADICTION_LIMIT;
            let (difference, is_certain) = match order {
                1 if found.single.size > single * scale => (found.single, true),
                _ if found.sustained.size > sustained * scale || effect => (found.sustained, true),
                1 if found.at_end.size > single * scale => (found.at_end, false),
                _ => return None,
            };
            let is_certain = is_certain && difference.size > scale;
            let contradiction = Contradiction { order, difference, scale, is_certain };
            (difference.size > 0.0).then_some(contradiction)
        });
        let contradictions = contradictions.collect();
        Findings {
            speed: self.speed,
            acceleration: self.acceleration,
            noise,
            outliers,
            exchanged,
            held: self.held,
            contradictions,
        }
    }

    /// Returns the root mean square of the derivative of the column of order `below`, computed by
    /// differences of the column.
    fn typical(&self, below: usize) -> f64 {
        self.contradictions.get(below).map_or(0.0, |found| {
            if found.squares.1 > 0.0 { (found.squares.0 / found.squares.1).sqrt() } else { 0.0 }
        })
    }

    fn block(&mut self, samples: std::ops::Range<usize>) {
        let is_dense = self.blocks < DENSE_BLOCKS || self.blocks.is_multiple_of(SPARSE);
        self.blocks += 1;
        if is_dense {
            self.noise(samples.clone());
        }
        for order in 0..self.orders {
            let accelerations = self.accelerations(order);
            if order + 1 == self.orders {
                self.peaks(samples.clone(), &accelerations);
            }
            self.outliers(samples.clone(), &accelerations);
            self.wrong_values(samples.clone(), order);
            if order == 0 {
                self.order_of_rows(samples.clone(), &accelerations);
            }
        }
        for below in 0..self.orders - 1 {
            self.contradiction(samples.clone(), below);
        }
        self.next = samples.end;
    }

    /// Computes the accelerations at all samples of the buffer by differences of the column of the
    /// given order. The result for a sample is the acceleration with the standard deviation of its
    /// rounding error, or `None` where a neighbour is missing.
    fn accelerations(&self, order: usize) -> Vec<Option<(f64, f64)>> {
        let t = &self.times;
        let (y, s) = (&self.columns[order], &self.rounding[order]);
        let at = |i: usize| {
            if order == 2 {
                return Some((y[i], s[i]));
            }
            let next = (i + 1 < t.len()).then_some(i + 1)?;
            let after = (t[next] - t[i], y[next] - y[i]);
            if order == 1 {
                return Some((after.1 / after.0, s[i].hypot(s[next]) / after.0));
            }
            let before = i.checked_sub(1).map(|last| (t[i] - t[last], y[i] - y[last]))?;
            let width = 0.5 * (before.0 + after.0);
            let value = (after.1 / after.0 - before.1 / before.0) / width;
            let sum = s[i] * (1.0 / after.0 + 1.0 / before.0);
            let sides = (s[i - 1] / before.0).hypot(s[next] / after.0);
            Some((value, sum.hypot(sides) / width))
        };
        (0..t.len()).map(at).collect()
    }

    fn peaks(&mut self, samples: std::ops::Range<usize>, accelerations: &[Option<(f64, f64)>]) {
        for i in samples {
            let time = self.times[i];
            if let Some(Some((acceleration, _))) = accelerations.get(i) {
                self.acceleration.raise(acceleration.abs(), time);
            }
            let rate = match self.columns.get(1) {
                Some(rates) => Some(rates[i]),
                None => self
                    .times
                    .get(i + 1)
                    .map(|next| (self.columns[0][i + 1] - self.columns[0][i]) / (next - time)),
            };
            if let Some(rate) = rate {
                self.speed.raise(rate.abs(), time);
            }
        }
    }

    /// Estimates the noise of the columns in a block.
    fn noise(&mut self, samples: std::ops::Range<usize>) {
        for order in 0..self.orders {
            // If accelerations are given, the spline takes exactly these values at the samples.
            // Noise of positions and rates then has no effect on them.
            if order + 1 < self.orders && self.orders == 3 {
                continue;
            }
            // All stencils are used or none: at few samples per period, the residuals of the narrowest
            // stencil are no noise.
            let mut found = Stencil::ALL.map(|stencil| {
                residuals(stencil, &self.times, &self.columns[order], samples.clone())
            });
            if found.iter().any(|residuals| residuals.len() < FEWEST_RESIDUALS) {
                continue;
            }
            let estimates = found.each_mut().map(|list| quantile(list, NOISE_QUANTILE.0));
            let least = estimates.into_iter().fold(f64::INFINITY, f64::min);
            let sigma = least / NOISE_QUANTILE.1;
            let count = samples.len() as f64;
            let own = samples.clone().map(|i| self.rounding[order][i].powi(2)).sum::<f64>() / count;
            let steps = self.times[samples.end - 1] - self.times[samples.start];
            let step = steps / (count - 1.0).max(1.0);
            // Root mean square of the acceleration that the spline computes from white noise of
            // unit variance.
            let gain = match (order, self.orders) {
                (0, 1) => 4.4 / step.powi(2),
                (0, _) => 8.0 / step.powi(2),
                (1, _) => 3.0 / step,
                _ => 1.0,
            };
            let is_rounding = sigma <= EXPLAINED * own.sqrt();
            // If many samples of a slow signal are rounded to the same number, the residuals vanish.
            let sigma = if is_rounding && self.moves(order, &samples) {
                sigma.max(own.sqrt())
            } else {
                sigma
            };
            let deviation = Peak { size: sigma, time: self.times[samples.start] };
            let is_of_times = is_rounding && order == 0 && own.sqrt() > 3.0 * self.value_rounding;
            let new =
                Noise { order, deviation, acceleration: gain * sigma, is_rounding, is_of_times };
            let known = &mut self.noise[usize::from(is_rounding)];
            if known.is_none_or(|known| known.acceleration < new.acceleration) {
                *known = Some(new);
            }
        }
    }

    /// Tests whether the values of the column of an order differ within a range of samples.
    fn moves(&self, order: usize, samples: &std::ops::Range<usize>) -> bool {
        let values = &self.columns[order][samples.clone()];
        values.windows(2).any(|pair| pair[0] != pair[1])
    }

    /// Collects accelerations inconsistent with their neighbours.
    fn outliers(&mut self, samples: std::ops::Range<usize>, found: &[Option<(f64, f64)>]) {
        for i in samples {
            let Some((own, sigma)) = found[i] else { continue };
            let Some(error) = excess(&self.times, found, i) else {
                if let Some(at_end) = excess_at_end(&self.times, found, i) {
                    self.ends.push((at_end, self.times[i], sigma));
                }
                continue;
            };
            self.interior = self.interior.max(own.abs());
            self.errors.add(error);
            if error <= OUTLIER_SIGMAS * sigma {
                continue;
            }
            self.outliers.push((Peak { size: error, time: self.times[i] }, sigma));
            keep_largest(&mut self.outliers);
        }
    }

    /// Collects wrong values in smooth stretches of the column of an order.
    fn wrong_values(&mut self, samples: std::ops::Range<usize>, order: usize) {
        let (t, y, sigmas) = (&self.times, &self.columns[order], &self.rounding[order]);
        let mut sizes = residuals(WIDE, t, y, samples.clone());
        let usual = quantile(&mut sizes, 0.5);
        for i in samples {
            let Some((residual, norm)) = residual(WIDE, t, y, i) else { continue };
            // Fits to samples that are as noisy as all others would only cost time.
            if residual.abs() < UNUSUAL * norm * usual {
                continue;
            }
            let h = t[i + 1] - t[i];
            // Acceleration that an error of one value causes.
            let gain = [2.0 / (h * h), 1.0 / h, 1.0][order];
            if residual.abs() < MATCHED_SIGMAS * sigmas[i]
                || residual.abs() * gain < 0.4 * OUTLIER_LIMIT * self.acceleration.size
            {
                continue;
            }
            let Some(matched) = Matched::new(t, y, i) else { continue };
            let sigma = sigmas[matched.range()].iter().fold(0.0_f64, |most, own| most.max(*own));
            for kind in Kind::of(order) {
                let Some(size) = matched.error(kind) else { continue };
                let gain = if kind == Kind::Jump { 0.5 * gain } else { gain };
                if size >= OUTLIER_SIGMAS * sigma {
                    self.wrong.push((Peak { size: gain * size, time: t[i] }, kind));
                }
            }
            keep_largest(&mut self.wrong);
        }
    }

    /// Detects exchanged rows and held values in a range of samples.
    fn order_of_rows(&mut self, samples: std::ops::Range<usize>, found: &[Option<(f64, f64)>]) {
        let (t, y) = (&self.times, &self.columns[0]);
        for i in samples.clone() {
            if self.exchanged.len() < MAX_OUTLIERS
                && let Some(size) = exchanged(t, y, found, i)
            {
                self.exchanged.push(Peak { size, time: t[i] });
            }
        }
        if self.held.is_none() {
            let time = t[samples.start];
            let length = held(y, &self.rounding[0], samples);
            self.held = length.map(|samples| Held { samples, time });
        }
    }

    /// Compares displacements of the column of order `below` with integrals of the column of the
    /// next higher order.
    fn contradiction(&mut self, samples: std::ops::Range<usize>, below: usize) {
        if below == 0 {
            self.rates_at_ends(samples.clone());
        }
        let (t, y, v) = (&self.times, &self.columns[below], &self.columns[below + 1]);
        let (sy, sv) = (&self.rounding[below], &self.rounding[below + 1]);
        let mut all = Vec::with_capacity(samples.len());
        let found = &mut self.contradictions[below];
        let mut step = 0.0;
        for i in samples.clone() {
            if i == 0 || i + 2 >= t.len() {
                continue;
            }
            let h = t[i + 1] - t[i];
            let slope = (y[i + 1] - y[i]) / h;
            found.squares.0 += slope * slope;
            found.squares.1 += 1.0;
            let two = slope - 0.5 * (v[i] + v[i + 1]);
            let four = slope - mean_of_cubic(&t[i - 1..i + 3], &v[i - 1..i + 3]);
            let rounding = 6.0 * ((sy[i].hypot(sy[i + 1])) / h).hypot(sv[i].hypot(sv[i + 1]));
            let rough = f64::EPSILON * (y[i].abs() + y[i + 1].abs()) / h;
            let integration = 3.0 * (two - four).abs();
            let allowed = rounding + 4.0 * rough;
            let mut excess = two.abs().min(four.abs()) - integration - allowed;
            found.single.raise(excess, t[i]);
            // At few samples per period, six points are much more accurate. At corners they are not,
            // but corners are too rare to change the median.
            if let Some((t, v)) = around(t, i).zip(around(v, i)) {
                let six = slope - mean_of_quintic(t, v);
                excess = excess.max(six.abs() - 3.0 * (four - six).abs() - allowed);
            }
            // Where both columns are at rest, they cannot be compared.
            if slope == 0.0 && v[i] == 0.0 && v[i + 1] == 0.0 {
                continue;
            }
            all.push(excess);
            step += h;
        }
        if all.len() >= FEWEST_MOVING {
            step /= all.len() as f64;
            let part = if all.len() >= ENOUGH_MOVING { 0.5 } else { 0.2 };
            let median = quantile(&mut all, part);
            if median > 0.0 {
                found.effect =
                    found.effect.max(if below == 0 { 3.0 * median / step } else { median });
            }
            found.sustained.raise(median, t[samples.start]);
        }
    }
}

impl Quality {
    /// Compares the rates of the first and the last two samples of the recording, which have too few
    /// neighbours for an integral of the rates, with the slopes of the positions beside them.
    fn rates_at_ends(&mut self, samples: std::ops::Range<usize>) {
        let (t, y, v) = (&self.times, &self.columns[0], &self.columns[1]);
        let (sy, sv) = (&self.rounding[0], &self.rounding[1]);
        let last = t.len() - 1;
        let slope = |i: usize| (y[i + 1] - y[i]) / (t[i + 1] - t[i]);
        let found = &mut self.contradictions[0];
        // Without interior intervals, the slopes of all intervals are the scale.
        if last < 3 {
            let squares = (0..last).map(|i| slope(i).powi(2)).sum();
            found.squares = (squares, last as f64);
        }
        let is_at_end = |k: &usize| *k < 2 || *k + 1 >= last;
        for k in samples.filter(is_at_end) {
            // Beside a reversal, the slope of one interval is small.
            let beside = k.saturating_sub(2)..(k + 2).min(last);
            let fastest = beside.clone().map(|i| slope(i).abs()).fold(0.0, f64::max);
            let rounding = beside.map(|i| {
                let rough = f64::EPSILON * (y[i].abs() + y[i + 1].abs());
                (sy[i].hypot(sy[i + 1]) + rough) / (t[i + 1] - t[i])
            });
            let rounding = 6.0 * (rounding.fold(0.0, f64::max) + sv[k]);
            if v[k].abs() > END_RATE_LIMIT * (fastest + rounding) {
                found.at_end.raise(v[k].abs() - fastest, t[k]);
            }
        }
    }
}

/// Shortens a list of errors to the largest ones if it is too long.
fn keep_largest<T>(errors: &mut Vec<(Peak, T)>) {
    if errors.len() > 2 * MAX_OUTLIERS {
        errors.sort_by(|a, b| b.0.size.total_cmp(&a.0.size));
        errors.truncate(MAX_OUTLIERS);
    }
}

/// Tests whether one of two time steps is a multiple of the other. Rows are then missing, and the
/// difference of the steps does not come from rounded times.
fn is_multiple(a: f64, b: f64) -> bool {
    let ratio = (a / b).max(b / a);
    ratio > 1.5 && (ratio - ratio.round()).abs() < 1e-6 * ratio
}

/// Returns the mean value of the cubic through four points over the interval between the second and
/// the third point.
fn mean_of_cubic(t: &[f64], v: &[f64]) -> f64 {
    let (&[t0, t1, t2, t3], &[v0, v1, v2, v3]) = (t, v) else { return f64::NAN };
    // Newton's form with nodes t1, t2, t0, t3; integrals of its products over [t1, t2].
    let h = t2 - t1;
    let d12 = (v2 - v1) / h;
    let d02 = ((v2 - v0) / (t2 - t0) - d12) / (t0 - t1);
    let d32 = ((v3 - v2) / (t3 - t2) - d12) / (t3 - t1);
    let cubic = (d32 - d02) / (t3 - t0);
    // Over [t1, t2], the mean of (t - t1)(t - t2) is -h^2/6. By symmetry, the mean of (t - t1)(t -
    // t2)(t - t0) is this value times t1 + h/2 - t0.
    let quadratic = -h * h / 6.0;
    v1 + 0.5 * d12 * h + d02 * quadratic + cubic * quadratic * (t1 + 0.5 * h - t0)
}

/// Returns the items from `i - 2` to `i + 3`; `None` near the ends of the list.
fn around(list: &[f64], i: usize) -> Option<&[f64; 6]> {
    list.get(i.checked_sub(2)?..)?.first_chunk()
}

/// Returns the mean value of the quintic through six points over the interval between the third and
/// the fourth point.
fn mean_of_quintic(t: &[f64; 6], v: &[f64; 6]) -> f64 {
    let (middle, half) = (0.5 * (t[2] + t[3]), 0.5 * (t[3] - t[2]));
    // Gauss quadrature with three nodes is exact for quintics.
    let node = half * 0.6_f64.sqrt();
    let at = |x: f64| {
        let mut points = [(0.0, 0.0); 6];
        for (point, (t, v)) in points.iter_mut().zip(t.iter().zip(v)) {
            *point = (t - middle - x, *v);
        }
        at_zero(&points)
    };
    (5.0 * (at(-node) + at(node)) + 8.0 * at(0.0)) / 18.0
}

/// Returns the quantile of a list for the fraction `part`, from 0 to 1; 0 for an empty list. The
/// list is reordered.
fn quantile(list: &mut [f64], part: f64) -> f64 {
    if list.is_empty() {
        return 0.0;
    }
    let at = ((list.len() - 1) as f64 * part).round() as usize;
    *list.select_nth_unstable_by(at, f64::total_cmp).1
}
