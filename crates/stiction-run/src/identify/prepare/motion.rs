//! Motion of the coordinates in a log, computed from filtered positions or rates, or from a table
//! of steady motions.

use super::filter::{self, RowFilter};
use super::spikes::{self, Spikes};
use super::{MeasuredLog, gaps};
use crate::identify::IdentifyError as Error;
use crate::identify::chosen::{Chosen, refuse};
use std::f64::consts::{PI, TAU};
use stiction_core::kinematics::Target;
use stiction_draw::numbers::number;
use stiction_format::{LowPass, Signal};

/// Number of evaluations of the regressor per period of the cut-off frequency.
const PER_PERIOD: f64 = 16.0;
/// Number of rows of the regression per period of the cut-off frequency.
pub(super) const ROWS_PER_PERIOD: f64 = 4.0;
/// Largest number of samples that are examined in each part of a log to suggest a cut-off
/// frequency.
const EXAMINED: usize = 20_000;
/// Number of parts of a log that are examined to suggest a cut-off frequency.
const PARTS: usize = 4;
/// Sampling rate, 1/s, below which the motion of a robot cannot be resolved.
const SLOWEST: f64 = 2.0;
/// Standard deviation of the time steps, as a fraction of their mean, above which a caution reports
/// them.
const JITTER: f64 = 0.1;
/// Largest number of lines with spikes that a caution names.
const NAMED: usize = 10;

/// Motion of the coordinates in a log, at the instants at which the regressor is evaluated.
pub(super) struct Motion {
    /// Times of the instants, s.
    pub(super) times: Vec<f64>,
    /// Position, rate and acceleration of each coordinate at each instant.
    pub(super) targets: Vec<Vec<Target<f64>>>,
    /// Standard deviation of the noise that remains in the rate of each coordinate, rad/s or m/s.
    pub(super) rate_noise: Vec<f64>,
    pub(super) filter: RowFilter,
    /// Cut-off frequency of the filter, Hz; `None` for steady motions.
    pub(super) cutoff: Option<f64>,
    /// Times of the rows of the regression, s.
    pub(super) rows: Vec<f64>,
}

impl Motion {
    /// Chooses the pieces of the log that are filtered, each from start to end, s. Samples outside
    /// these pieces are left out. The rows of the regression are at least one period of the cut-off
    /// frequency away from the ends of each piece.
    fn set_pieces(&mut self, pieces: &[(f64, f64)]) {
        let Some(cutoff) = self.cutoff else { return };
        let (spacing, margin) = ((ROWS_PER_PERIOD * cutoff).recip(), cutoff.recip());
        let rows = pieces.iter().flat_map(|&(start, end)| {
            let places = (((end - start) - 2.0 * margin) / spacing).floor().max(0.0) as usize;
            (0..=places).map(move |k| start + margin + k as f64 * spacing)
        });
        self.rows = rows.collect();
        let filters = pieces.iter().map(|ends| (LowPass::new(cutoff, *ends), *ends));
        self.filter = RowFilter::LowPass(filters.collect());
    }

    /// Leaves out the neighbourhood of instants whose positions the model cannot reach. `reached`
    /// contains the times of all other instants, s, in increasing order.
    pub(super) fn keep(&mut self, reached: &[f64]) {
        let (Some(cutoff), RowFilter::LowPass(pieces)) = (self.cutoff, &self.filter) else {
            return;
        };
        let ends: Vec<(f64, f64)> = pieces.iter().map(|(_, ends)| *ends).collect();
        let mut kept = Vec::new();
        for ends in ends {
            let instants = &self.times[filter::within(&self.times, ends)];
            for run in instants.chunk_by(|a, b| {
                [a, b].map(|t| reached.binary_search_by(|x| x.total_cmp(t)).is_ok()) == [true; 2]
            }) {
                let (start, end) = (run[0], run[run.len() - 1]);
                if gaps::is_long((start, end), cutoff) {
                    kept.push((start, end));
                }
            }
        }
        self.set_pieces(&kept);
    }
}

/// Part of a log that the identification uses.
pub(super) struct Used<'a> {
    pub(super) log: &'a MeasuredLog,
    /// Indices of the used rows in the log.
    pub(super) rows: Vec<usize>,
    /// Times of the used rows, s.
    pub(super) times: Vec<f64>,
    /// Sampling rate outside gaps, 1/s.
    pub(super) rate: f64,
    /// Start and end, s, of each stretch without missing samples.
    pub(super) stretches: Vec<(f64, f64)>,
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
                format!("{} has fewer than two rows in the chosen interval of time", log.name),
                "check `from` and `until`",
            ));
        }
        let rate = gaps::rate(&times);
        let stretches = gaps::pieces(&times, gaps::SAMPLES / rate);
        Ok(Self { log, rows, times, rate, stretches })
    }

    pub(super) fn pick(&self, column: usize) -> Vec<f64> {
        self.rows.iter().map(|&k| self.log.log.columns[column].values[k]).collect()
    }

    /// Returns a caution on irregular time steps; `None` if the time steps are regular.
    fn jitter_caution(&self) -> Option<String> {
        let steps = self.samples().into_iter().flat_map(|own| {
            self.times[own].windows(2).map(|pair| pair[1] - pair[0]).collect::<Vec<_>>()
        });
        let steps: Vec<f64> = steps.collect();
        let count = steps.len().max(1) as f64;
        let mean = steps.iter().sum::<f64>() / count;
        let scatter = (steps.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / count).sqrt();
        (scatter > JITTER * mean).then(|| {
            format!(
                "{}: steps of the time scatter by {:.3} ms about {:.3} ms: if the time stamps \
                 jitter and not the samples, rates have errors; log the times of the sampling \
                 clock",
                self.log.name,
                1e3 * scatter,
                1e3 * mean
            )
        })
    }

    /// Returns the range of the sample indices of each stretch without missing samples.
    pub(super) fn samples(&self) -> Vec<std::ops::Range<usize>> {
        self.stretches.iter().map(|ends| filter::within(&self.times, *ends)).collect()
    }

    /// Returns a caution that names the spikes of a column with values in `unit`; `None` if there
    /// are no spikes.
    pub(super) fn spikes_caution(
        &self,
        (column, unit): (&str, &str),
        spikes: &Spikes,
    ) -> Option<String> {
        let first = *spikes.samples.first()?;
        let line = |k: &usize| self.log.log.lines[self.rows[*k]].to_string();
        let (size, time) = (number(spikes.largest), self.times[first]);
        let log = &self.log.name;
        if spikes.samples.len() == 1 {
            return Some(format!(
                "{log}: `{column}` has 1 sample that stands out from its neighbours, by {size} {unit}; it is \
                 replaced by interpolation, at {time:.4} s: line {}",
                line(&first)
            ));
        }
        let lines: Vec<String> = spikes.samples.iter().take(NAMED).map(line).collect();
        let more = if spikes.samples.len() > NAMED { " and others" } else { "" };
        Some(format!(
            "{log}: `{column}` has {} samples that stand out from their neighbours, by up to {size} {unit}; they are \
             replaced by interpolation, first at {time:.4} s: lines {}{more}",
            spikes.samples.len(),
            lines.join(", ")
        ))
    }
}

/// Converts a table of steady motions. Each row is a motion with constant rates at the logged
/// position, or at the position of the model if no position is logged.
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

/// Computes the motion from filtered positions. `filter` is the cut-off frequency, Hz; `None`
/// selects one automatically. `is_angle` is true for each coordinate that is an angle. A coordinate
/// without a position column is integrated from its filtered rate, starting at its position in the
/// model. Gaps are not interpolated; each piece between gaps is filtered separately.
pub(super) fn filtered(
    used: &Used<'_>,
    chosen: &[Chosen],
    (filter, is_angle): (Option<f64>, &[bool]),
    cautions: &mut Vec<String>,
) -> Result<Motion, Error> {
    let Used { log, stretches, rate, .. } = used;
    let rate = *rate;
    if rate < SLOWEST {
        cautions.push(format!(
            "{}: samples are {:.4} s apart, and the log lasts {:.0} s: check the unit of the time \
             column (s if its header has none)",
            log.name,
            rate.recip(),
            used.times[used.times.len() - 1] - used.times[0]
        ));
    }
    cautions.extend(used.jitter_caution());
    let mut measured: Vec<Vec<f64>> = chosen.iter().map(|c| used.pick(c.column())).collect();
    for ((chosen, values), is_angle) in chosen.iter().zip(&mut measured).zip(is_angle) {
        let spikes = spikes::replace(&used.times, values, &used.samples(), 0.0);
        let name = &log.log.columns[chosen.column()].name;
        let unit = match (is_angle, chosen.position.is_some()) {
            (true, true) => "rad",
            (true, false) => "rad/s",
            (false, true) => "m",
            (false, false) => "m/s",
        };
        cautions.extend(used.spikes_caution((name, unit), &spikes));
    }
    let is_encoder = |k: usize| is_angle[k] && chosen[k].position.is_some();
    // Full turns are added to encoder angles only within each of the spans, because a joint may
    // move by more than half a turn across a gap.
    let continued = |measured: &mut [Vec<f64>], spans: &[(f64, f64)]| -> Vec<usize> {
        let each = measured.iter_mut().enumerate().map(|(k, values)| {
            let spans = spans.iter().filter(|_| is_encoder(k));
            spans.map(|ends| unwrap(&mut values[filter::within(&used.times, *ends)])).sum()
        });
        each.collect()
    };
    let mut turns = continued(&mut measured, stretches);
    let longest = gaps::longest(stretches);
    let (low, high) = (gaps::PERIODS / longest, 0.4 * rate);
    let cutoff = filter.unwrap_or_else(|| suggested_cutoff(used, &measured));
    if !(low..=high).contains(&cutoff) {
        return Err(refuse(
            format!(
                "{}: a filter of {cutoff} Hz is outside of the range for a stretch of {longest:.3} \
                 s at {rate:.4} samples per second",
                log.name,
            ),
            format!(
                "give a cut-off frequency from {low:.2} Hz to {high:.2} Hz with --filter, or a \
                 longer log without gaps"
            ),
        ));
    }
    let all = gaps::pieces(&used.times, (0.5 / cutoff).max(gaps::SAMPLES / rate));
    if let Some(caution) = gaps::caution(used, &all, cutoff) {
        cautions.push(caution);
    }
    // Full turns are also added across the short gaps between the stretches of one piece.
    let joined = continued(&mut measured, &all);
    turns.iter_mut().zip(joined).for_each(|(turns, more)| *turns += more);
    for (chosen, turns) in chosen.iter().zip(turns).filter(|(_, turns)| *turns > 0) {
        cautions.push(format!(
            "{}: `{}` jumps by a full turn {turns} times, like an encoder that counts within one \
             turn; the turns are added",
            log.name,
            log.log.columns[chosen.column()].name
        ));
    }
    let first = all[0];
    let pieces: Vec<(f64, f64)> =
        all.into_iter().filter(|piece| gaps::is_long(*piece, cutoff)).collect();
    // The position after a gap is unknown, so a rate is integrated over the first piece only. If
    // all later pieces are too short for the filter, this does no harm, because they are left out.
    let is_whole = pieces.len() == 1 && pieces[0] == first;
    let is_integrated = chosen.iter().position(|chosen| chosen.position.is_none());
    if let (Some(k), false) = (is_integrated, is_whole) {
        return Err(refuse(
            format!(
                "{}: samples are missing at {:.4} s, so positions cannot be integrated from `{}`",
                log.name,
                first.1,
                log.log.columns[chosen[k].column()].name
            ),
            "log positions, or use `from` and `until` to choose a part without gaps",
        ));
    }
    let mut motion = Motion {
        times: Vec::new(),
        targets: Vec::new(),
        rate_noise: vec![0.0; chosen.len()],
        filter: RowFilter::Unfiltered,
        cutoff: Some(cutoff),
        rows: Vec::new(),
    };
    let step = (PER_PERIOD * cutoff).min(rate).recip();
    let duration: f64 = pieces.iter().map(|(start, end)| end - start).sum();
    for &(start, end) in &pieces {
        let samples = filter::within(&used.times, (start, end));
        let own: Vec<Vec<f64>> = measured.iter().map(|all| all[samples.clone()].to_vec()).collect();
        let smooth = LowPass::new(cutoff, (start, end)).smooth(&used.times[samples], &own);
        let count = ((end - start) / step).floor().max(1.0) as usize;
        let times: Vec<f64> = (0..=count).map(|k| (start + k as f64 * step).min(end)).collect();
        let mut targets = vec![Vec::with_capacity(chosen.len()); times.len()];
        for ((chosen, smooth), noise) in chosen.iter().zip(&smooth).zip(&mut motion.rate_noise) {
            let all = match chosen.position {
                Some(_) => times.iter().map(|&time| smooth.signal.at(time)).collect(),
                None => integrated(&smooth.signal, &times, chosen.home),
            };
            targets.iter_mut().zip(all).for_each(|(row, target)| row.push(target));
            let own = smooth.noise[usize::from(chosen.position.is_some())];
            *noise += own * own * (end - start) / duration;
        }
        motion.times.extend(times);
        motion.targets.extend(targets);
    }
    motion.rate_noise.iter_mut().for_each(|noise| *noise = noise.sqrt());
    motion.set_pieces(&pieces);
    Ok(motion)
}

/// Returns the cut-off frequency, Hz, that suits measured coordinates whose angles are continuous.
pub(super) fn suggested_cutoff(used: &Used<'_>, measured: &[Vec<f64>]) -> f64 {
    let Used { times, stretches, rate, .. } = used;
    let low = gaps::PERIODS / gaps::longest(stretches);
    // For noise-free positions of a model, the suggestion is the highest frequency that the samples
    // carry. Therefore a tenth of the sampling rate limits the suggestion.
    let most = 0.1 * rate;
    suggested(times, measured, stretches).unwrap_or(most).max(low).min(most)
}

/// Suggests a cut-off frequency, Hz. Several parts spread evenly over the log are examined, since a
/// motion may begin slowly, and the highest suggestion is returned. `None` if no part suggests a
/// frequency.
fn suggested(times: &[f64], measured: &[Vec<f64>], stretches: &[(f64, f64)]) -> Option<f64> {
    let count = times.len().min(EXAMINED);
    let parts = if times.len() > EXAMINED { PARTS } else { 1 };
    let part = |k: usize| {
        let first = (times.len() - count) * k / (parts - 1).max(1);
        // Only the longest gap-free stretch in this part of the log is examined.
        let own = stretches.iter().map(|ends| {
            let samples = filter::within(times, *ends);
            samples.start.max(first)..samples.end.min(first + count)
        });
        let own = own.max_by_key(|samples| samples.len())?;
        let some: Vec<Vec<f64>> = measured.iter().map(|p| p[own.clone()].to_vec()).collect();
        LowPass::suggested(&times[own], &some)
    };
    (0..parts).filter_map(part).max_by(f64::total_cmp)
}

/// Adds full turns so that an angle never jumps by more than half a turn; returns the number of jumps removed.
pub(super) fn unwrap(values: &mut [f64]) -> usize {
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

/// Integrates a rate by the trapezoidal rule over the times `times`, s, starting at the position
/// `home`, rad or m.
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
    use crate::identify::options::LogSettings;
    use stiction_core::kinematics::Coordinate;
    use stiction_core::mechanism::JointId;
    use stiction_format::{Log, LogColumn, LogRole, Rows};

    /// Tests that rows are at least one period of the cut-off frequency away from positions that
    /// the model cannot reach.
    #[test]
    fn surroundings_of_unreachable_positions_are_left_out() {
        let times: Vec<f64> = (0..=1000).map(|k| 0.01 * f64::from(k)).collect();
        let mut motion = Motion {
            targets: vec![Vec::new(); times.len()],
            times,
            rate_noise: Vec::new(),
            filter: RowFilter::Unfiltered,
            cutoff: Some(2.0),
            rows: Vec::new(),
        };
        motion.set_pieces(&[(0.0, 10.0)]);
        // Positions from 4 s to 5 s and at 6.5 s cannot be reached; the piece between them is too
        // short.
        let is_reached = |t: &f64| !(4.0..=5.0).contains(t) && (t - 6.5).abs() > 1e-6;
        let reached: Vec<f64> = motion.times.iter().copied().filter(is_reached).collect();
        let all = motion.rows.len();
        motion.keep(&reached);
        assert!(motion.rows.len() < all);
        for row in &motion.rows {
            assert!((0.5..3.491).contains(row) || (7.009..9.501).contains(row), "{row}");
        }
        let RowFilter::LowPass(pieces) = &motion.filter else { panic!("no filter") };
        assert_eq!(pieces.len(), 2);
    }

    /// Creates a log of one encoder angle that contains only the sample times for which `keep`
    /// returns true.
    fn turning(keep: impl Fn(f64) -> bool) -> MeasuredLog {
        let times: Vec<f64> = (0..2000).map(|k| 2e-3 * f64::from(k)).filter(|t| keep(*t)).collect();
        // The angle swings over several turns; the encoder counts within one turn.
        let angle = |t: &f64| 9.0 * (1.7 * t).sin();
        let values = times.iter().map(|t| angle(t) - TAU * (angle(t) / TAU).round()).collect();
        let column = LogColumn { name: "axis".to_owned(), role: LogRole::Unused, values };
        let lines = (2..times.len() + 2).collect();
        let (columns, bad_rows) = (vec![column], Rows::default());
        let log = Log { times, lines, columns, bad_rows, is_steady: false };
        let (from, until) = (f64::NEG_INFINITY, f64::INFINITY);
        let settings = LogSettings { from, until, ..LogSettings::default() };
        MeasuredLog::new("log", log, settings)
    }

    /// Tests that the filtered angle does not jump if the measured angle passes half a turn inside
    /// a gap that is too short to divide the log into pieces.
    #[test]
    fn a_turn_within_a_short_gap_is_added() {
        // The angle reaches half a turn at asin(pi/9)/1.7 s = 0.2098 s. The gap is ten samples
        // long, a sixth of the period of the filter.
        let gap = 0.2..0.22;
        let log = turning(|t| !gap.contains(&t));
        let used = Used::of(&log).unwrap();
        assert_eq!(used.stretches.len(), 2);
        let chosen = [Chosen {
            coordinate: Coordinate::Joint { joint: JointId(0), dof: 0 },
            position: Some(0),
            rate: None,
            home: 0.0,
        }];
        let mut cautions = Vec::new();
        let motion = filtered(&used, &chosen, (Some(8.0), &[true]), &mut cautions).unwrap();
        assert!(cautions.iter().any(|c| c.contains("jumps by a full turn")), "{cautions:?}");
        for (time, targets) in motion.times.iter().zip(&motion.targets) {
            let truth = 9.0 * (1.7 * time).sin();
            // The tolerance allows for the change of a signal of 0.3 Hz by the filter.
            assert!((targets[0].value - truth).abs() < 1e-2, "{time}: {targets:?} {truth}");
        }
    }

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
