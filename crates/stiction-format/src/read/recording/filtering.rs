//! Applies the low-pass filter to a recorded motion, and suggests cut-off frequencies.

use super::EXAMPLE;
use super::gather::{ReadHeader, Recording};
use super::input::Input;
use super::plan::Plan;
use super::report::short;
use super::scan::scan;
use crate::diagnostic::{Diagnostic, number};
use crate::signal::filter::{
    Filtered, MAX_KNOTS, MAX_RATIO, MIN_PERIODS, Samples, filter, knots_needed, rise_time, suggest,
};
use crate::source::Place;

/// Maximum number of samples used to suggest a cut-off frequency.
const EXAMINED: usize = 1 << 16;

/// Cut-off frequency of the filter, Hz, with its place if a text contains it.
pub(crate) struct Cutoff {
    pub(crate) hertz: f64,
    pub(crate) place: Option<Place>,
}

impl From<f64> for Cutoff {
    fn from(hertz: f64) -> Self {
        Self { hertz, place: None }
    }
}

impl Cutoff {
    /// Returns an error if the cut-off frequency does not suit a recording with `count` samples in
    /// `duration` seconds.
    fn refusal(&self, count: usize, duration: f64) -> Option<Diagnostic> {
        let Self { hertz, place } = self;
        let rate = (count - 1) as f64 / duration;
        let (low, high) = (MIN_PERIODS / duration, MAX_RATIO * rate);
        let knots = knots_needed(*hertz, duration);
        let (message, label, help) = if !hertz.is_finite() || *hertz <= 0.0 {
            let message = format!("the cut-off frequency of the filter is {} Hz", number(*hertz));
            (message, "not positive".to_owned(), "give a frequency such as 20 Hz".to_owned())
        } else if low > high {
            let message = format!("a recording of {count} samples is too short for a filter");
            (message, "too few samples".to_owned(), "delete the filter".to_owned())
        } else if *hertz > high {
            let message = format!(
                "the cut-off frequency of {} Hz is too high: the recording has {} samples per second",
                number(*hertz),
                short(rate)
            );
            let label = format!("at most {} Hz", short(high));
            (message, label, "give a lower frequency, or no filter".to_owned())
        } else if *hertz < low {
            let message = format!(
                "the cut-off frequency of {} Hz is too low: the recording lasts {} s",
                number(*hertz),
                short(duration)
            );
            let label = format!("at least {} Hz", short(low));
            (message, label, "give a higher frequency".to_owned())
        } else if knots > MAX_KNOTS {
            let message = format!(
                "a cut-off frequency of {} Hz for a recording of {} s needs too much memory: {} spline knots",
                number(*hertz),
                short(duration),
                number(knots)
            );
            let label = format!("at most {} knots", number(MAX_KNOTS));
            (message, label, "give a lower frequency, or split the recording".to_owned())
        } else {
            return None;
        };
        let refused = Diagnostic::error("filter", message);
        Some(match place {
            Some(place) => refused.at(place.clone(), label).help(help),
            None => refused.help(format!("{label}: {help}")),
        })
    }
}

/// Describes the filter with this cut-off frequency, Hz, in words.
pub(super) fn describe(cutoff: f64) -> String {
    format!(
        "positions only, low-pass filtered: zero phase, {} Hz at -3 dB, as a Butterworth filter of \
         order four run forward and backward; steps of the acceleration are spread over {} s",
        number(cutoff),
        short(rise_time(cutoff))
    )
}

/// Filters all coordinates of a recording, which is read a second time. The outer error is a
/// failure to read the recording; the inner error rejects the cut-off frequency.
pub(super) fn filtered(
    recording: &Recording,
    source: (&Input, ReadHeader<'_>),
    cutoff: &Cutoff,
) -> Result<Result<Vec<Filtered>, Diagnostic>, String> {
    let count = recording.samples.count();
    let Some((start, end)) = recording.samples.ends() else { return Ok(Ok(Vec::new())) };
    if let Some(refused) = cutoff.refusal(count, end - start) {
        return Ok(Err(refused));
    }
    let rate = (count - 1) as f64 / (end - start);
    let signals = recording.curves.len();
    let mut samples = Samples::new(cutoff.hertz, (start, end), signals).with_finer(rate, MAX_KNOTS);
    each_sample(source, |time, values| samples.push(time, values))?;
    Ok(Ok(filter(&samples.finish())))
}

/// Suggests a cut-off frequency, Hz, for the noisy coordinates of a recording, which is read a
/// second time. If the recording has more than [`EXAMINED`] samples, only those around the greatest
/// speed of the first noisy coordinate are used.
pub(super) fn suggestion(
    recording: &Recording,
    source: (&Input, ReadHeader<'_>),
) -> Result<Option<f64>, String> {
    let is_noisy: Vec<bool> = recording.curves.iter().map(|curve| curve.is_noisy()).collect();
    let fastest = recording.curves.iter().filter(|curve| curve.is_noisy()).find_map(|curve| {
        let findings = curve.findings.as_ref()?;
        Some(findings.speed.time)
    });
    let count = recording.samples.count();
    let Some((start, end)) = recording.samples.ends() else { return Ok(None) };
    let middle = (fastest.unwrap_or(start) - start) / (end - start) * count as f64;
    let last_begin = count.saturating_sub(EXAMINED);
    let begin = (middle as usize).saturating_sub(EXAMINED / 2).min(last_begin);
    let (mut times, mut row) = (Vec::new(), 0);
    let mut signals = vec![Vec::new(); is_noisy.iter().filter(|noisy| **noisy).count()];
    each_sample(source, |time, values| {
        if (begin..begin + EXAMINED).contains(&row) {
            times.push(time);
            let noisy = values.iter().zip(&is_noisy).filter(|(_, noisy)| **noisy);
            for (signal, (value, _)) in signals.iter_mut().zip(noisy) {
                signal.push(*value);
            }
        }
        row += 1;
    })?;
    Ok(suggest(&times, &signals))
}

/// Reads the rows of a recording; for each row, passes the time, s, and the positions of all
/// coordinates to `take`.
fn each_sample(
    (input, head): (&Input, ReadHeader<'_>),
    mut take: impl FnMut(f64, &[f64]),
) -> Result<(), String> {
    let mut plan: Option<(Plan, Vec<f64>, Vec<f64>)> = None;
    scan(input.pages(), EXAMPLE, head, |header, row, _, _| {
        let (plan, kept, values) = plan.get_or_insert_with(|| {
            let plan = Plan::of(header);
            let (width, curves) = (plan.layout.width(), plan.columns.len());
            (plan, vec![0.0; width], vec![0.0; curves])
        });
        plan.layout.pick(row, kept);
        for (value, (_, places)) in values.iter_mut().zip(plan.layout.curves()) {
            *value = kept.get(places.start).copied().unwrap_or(f64::NAN);
        }
        take(kept.first().copied().unwrap_or(f64::NAN), values);
    })?;
    Ok(())
}
