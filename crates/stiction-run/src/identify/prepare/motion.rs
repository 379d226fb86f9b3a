//! Motion of the coordinates of a log: filtered positions or rates, or steady motions.

use super::MeasuredLog;
use super::filter::RowFilter;
use crate::identify::IdentifyError as Error;
use crate::identify::chosen::{Chosen, refuse};
use std::f64::consts::{PI, TAU};
use stiction_core::kinematics::Target;
use stiction_format::{LowPass, Signal};

/// Samples of the regressor per period of the cut-off frequency.
const PER_PERIOD: f64 = 16.0;
/// Rows of the regression per period of the cut-off frequency.
pub(super) const ROWS_PER_PERIOD: f64 = 4.0;
/// Rows from which a cut-off frequency is suggested.
const EXAMINED: usize = 20_000;

/// Motion of the coordinates of a log at the instants of the regressor.
pub(super) struct Motion {
    /// Times of the instants, s.
    pub(super) times: Vec<f64>,
    /// Each coordinate at each instant.
    pub(super) targets: Vec<Vec<Target<f64>>>,
    /// Standard deviation that noise leaves in the rate of each coordinate.
    pub(super) rate_noise: Vec<f64>,
    pub(super) filter: RowFilter,
    /// Cut-off frequency, Hz; none for steady motions.
    pub(super) cutoff: Option<f64>,
    /// Times of the rows of the regression, s.
    pub(super) rows: Vec<f64>,
}

/// Rows of a log that are used.
pub(super) struct Used<'a> {
    pub(super) log: &'a MeasuredLog,
    /// Their numbers.
    pub(super) rows: Vec<usize>,
    /// Their times, s.
    pub(super) times: Vec<f64>,
}

impl<'a> Used<'a> {
    pub(super) fn of(log: &'a MeasuredLog) -> Result<Self, Error> {
        let (settings, times) = (&log.settings, &log.log.times);
        let is_bounded = settings.from.is_finite() || settings.until.is_finite();
        if log.log.is_steady && is_bounded {
            return Err(refuse(
                format!("{}: a table of steady motions has no time", log.name),
                "delete `from` and `until`",
            ));
        }
        let is_used = |k: &usize| (settings.from..=settings.until).contains(&times[*k]);
        let rows: Vec<usize> = (0..times.len()).filter(is_used).collect();
        let times: Vec<f64> = rows.iter().map(|&k| times[k]).collect();
        if times.len() < 2 {
            return Err(refuse(
                format!("{} has no two rows in the chosen time", log.name),
                "check `from` and `until`",
            ));
        }
        Ok(Self { log, rows, times })
    }

    pub(super) fn pick(&self, column: usize) -> Vec<f64> {
        self.rows.iter().map(|&k| self.log.log.columns[column].values[k]).collect()
    }

    pub(super) fn ends(&self) -> (f64, f64) {
        (self.times[0], self.times[self.times.len() - 1])
    }

    /// Samples per second.
    pub(super) fn rate(&self) -> f64 {
        let (start, end) = self.ends();
        (self.times.len() - 1) as f64 / (end - start)
    }
}

/// Each row is a motion of constant rate at the position of the log, or at that of the model.
pub(super) fn steady(used: &Used<'_>, chosen: &[Chosen]) -> Motion {
    let columns: Vec<[Option<Vec<f64>>; 2]> =
        chosen.iter().map(|c| [c.position, c.rate].map(|one| one.map(|k| used.pick(k)))).collect();
    let at = |k: usize| {
        let each = columns.iter().zip(chosen).map(|([positions, rates], chosen)| Target {
            value: positions.as_ref().map_or(chosen.home, |all| all[k]),
            rate: rates.as_ref().map_or(0.0, |all| all[k]),
            acceleration: 0.0,
        });
        each.collect()
    };
    Motion {
        times: used.times.clone(),
        targets: (0..used.times.len()).map(at).collect(),
        rate_noise: vec![0.0; chosen.len()],
        filter: RowFilter::Unfiltered,
        cutoff: None,
        rows: used.times.clone(),
    }
}

/// Filtered positions; a coordinate without one is integrated from its filtered rate, from its position in
/// the model.
pub(super) fn filtered(
    used: &Used<'_>,
    chosen: &[Chosen],
    (filter, is_angle): (Option<f64>, &[bool]),
    cautions: &mut Vec<String>,
) -> Result<Motion, Error> {
    let ((start, end), rate) = (used.ends(), used.rate());
    let mut measured: Vec<Vec<f64>> = chosen.iter().map(|c| used.pick(c.column())).collect();
    for ((values, chosen), is_angle) in measured.iter_mut().zip(chosen).zip(is_angle) {
        let turns = if *is_angle && chosen.position.is_some() { unwrap(values) } else { 0 };
        if turns > 0 {
            let log = used.log;
            cautions.push(format!(
                "{}: `{}` jumps by a turn {turns} times, as encoders do that count within one turn; the turns are \
                 added",
                log.name,
                log.log.columns[chosen.column()].name
            ));
        }
    }
    let (low, high) = (4.0 / (end - start), 0.4 * rate);
    let cutoff = match filter {
        Some(cutoff) => cutoff,
        None => {
            let count = used.times.len().min(EXAMINED);
            let some: Vec<Vec<f64>> = measured.iter().map(|p| p[..count].to_vec()).collect();
            // Exact positions of a model suggest the highest frequency that the samples carry.
            let suggested = LowPass::suggested(&used.times[..count], &some);
            suggested.unwrap_or(0.1 * rate).max(low).min(0.1 * rate)
        }
    };
    if !(low..=high).contains(&cutoff) {
        return Err(refuse(
            format!(
                "{}: a filter of {cutoff} Hz does not suit {:.3} s at {rate:.4} samples per second",
                used.log.name,
                end - start
            ),
            format!(
                "give a cut-off frequency from {low:.2} Hz to {high:.2} Hz by --filter, or a longer log"
            ),
        ));
    }
    let low_pass = LowPass::new(cutoff, (start, end));
    let smooth = low_pass.smooth(&used.times, &measured);
    let step = (PER_PERIOD * cutoff).min(rate).recip();
    let count = ((end - start) / step).floor().max(1.0) as usize;
    let times: Vec<f64> = (0..=count).map(|k| (start + k as f64 * step).min(end)).collect();
    let mut targets = vec![Vec::with_capacity(chosen.len()); times.len()];
    for (chosen, smooth) in chosen.iter().zip(&smooth) {
        let all = match chosen.position {
            Some(_) => times.iter().map(|&time| smooth.signal.at(time)).collect(),
            None => integrated(&smooth.signal, &times, chosen.home),
        };
        targets.iter_mut().zip(all).for_each(|(row, target)| row.push(target));
    }
    let noise = chosen.iter().zip(&smooth).map(|(c, s)| s.noise[usize::from(c.position.is_some())]);
    let (spacing, margin) = ((ROWS_PER_PERIOD * cutoff).recip(), cutoff.recip());
    let places = (((end - start) - 2.0 * margin) / spacing).floor().max(0.0) as usize;
    Ok(Motion {
        targets,
        rate_noise: noise.collect(),
        filter: RowFilter::LowPass(low_pass),
        cutoff: Some(cutoff),
        rows: (0..=places).map(|k| start + margin + k as f64 * spacing).collect(),
        times,
    })
}

/// Adds turns where an angle jumps by more than half of one; returns the number of jumps.
fn unwrap(values: &mut [f64]) -> usize {
    let (mut turns, mut count) = (0.0, 0);
    for k in 1..values.len() {
        let jump = values[k] + turns - values[k - 1];
        if jump.abs() > PI {
            turns -= TAU * (jump / TAU).round();
            count += 1;
        }
        values[k] += turns;
    }
    count
}

/// Positions from a rate, by the trapezoidal rule.
fn integrated(rate: &Signal, times: &[f64], home: f64) -> Vec<Target<f64>> {
    let mut value = home;
    let mut last: Option<(f64, f64)> = None;
    let each = times.iter().map(|&time| {
        let found = rate.at(time);
        if let Some((before, rate)) = last {
            value += 0.5 * (time - before) * (rate + found.value);
        }
        last = Some((time, found.value));
        Target { value, rate: found.value, acceleration: found.rate }
    });
    each.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_angle_within_one_turn_is_continued() {
        let mut values: Vec<f64> = (0..100).map(|k| 0.2 * f64::from(k)).collect();
        let expected = values.clone();
        values.iter_mut().for_each(|x| *x -= TAU * (*x / TAU).round());
        assert_eq!(unwrap(&mut values), 3);
        for (found, expected) in values.iter().zip(&expected) {
            assert!((found - expected).abs() < 1e-12);
        }
    }
}
