//! Report on the quality of a recording: peak values, noise, outliers, and columns that contradict
//! each other.

use super::header::{Header, Role};
use crate::diagnostic::{Diagnostic, Diagnostics, number};
use crate::signal::filter::{Filtered, Rest, rise_time};
use crate::signal::quality::gaps::Gap;
use crate::signal::quality::{Contradiction, Findings, Held, Noise, Peak};
use crate::source::{Place, Source};
use std::sync::Arc;
use stiction_core::kinematics::Coordinate;

/// Number of significant digits that is usual in logs. With at least this many digits, the effect
/// of rounding on accelerations is reported as a note, not as a defect of the recording.
const USUAL_DIGITS: i32 = 7;
/// Change of the acceleration by a filter, relative to the peak acceleration, above which a warning
/// is issued.
const SMEARING_LIMIT: f64 = 0.05;

/// Notes, warnings and errors about the columns of a recording.
pub(super) struct Report<'a> {
    header: &'a Header,
    page: Arc<Source>,
    notes: Vec<String>,
    warnings: Diagnostics,
    errors: Diagnostics,
    /// Cut-off frequency of a filter that the report suggests, Hz; `None` without a suggestion and
    /// after it has been reported.
    suggestion: Option<f64>,
}

impl<'a> Report<'a> {
    /// Creates an empty report. `page` is the page that contains the header; `suggestion` is the
    /// cut-off frequency, Hz, of a filter that suits the noise of the recording.
    pub(super) fn new(header: &'a Header, page: Arc<Source>, suggestion: Option<f64>) -> Self {
        Self {
            header,
            page,
            notes: Vec::new(),
            warnings: Diagnostics::new(),
            errors: Diagnostics::new(),
            suggestion,
        }
    }

    /// Returns the collected notes, warnings and errors.
    pub(super) fn finish(self) -> (Vec<String>, Diagnostics, Diagnostics) {
        (self.notes, self.warnings, self.errors)
    }

    /// Adds the longest gap between the samples to the report.
    pub(super) fn gap(&mut self, gap: Gap) {
        let message = format!(
            "samples are missing from t = {} to {} s: this time step is {} s, the others are {} s on \
             average; the motion between is only interpolated",
            short(gap.time),
            short(gap.time + gap.length),
            short(gap.length),
            short(gap.usual)
        );
        let label = match gap.count {
            1 => "one gap".to_owned(),
            n => format!("{n} gaps, this is the longest"),
        };
        let mut warning = Diagnostic::warning("recording", message)
            .help("split the file at the gap, or record the motion again without it");
        if let Some(time) = self.header.time.and_then(|index| self.header.columns.get(index)) {
            warning = warning.at(Place::new(&self.page, time.span.clone()), label);
        }
        self.warnings.push(warning);
    }

    /// Adds the findings about a coordinate to the report. `column` is the index in the header of
    /// the column with its positions.
    pub(super) fn add(&mut self, coordinate: Coordinate, column: usize, findings: &Findings) {
        let Some(positions) = self.header.columns.get(column) else { return };
        let unit = if positions.is_angle { "rad" } else { "m" };
        let name = positions.name.as_str();
        let (speed, peak) = (findings.speed, findings.acceleration);
        let mut note = format!(
            "{name}: peak speed {} {unit}/s at t = {} s, peak acceleration {} {unit}/s^2 at t = {} s",
            short(speed.size),
            short(speed.time),
            short(peak.size),
            short(peak.time),
        );
        for contradiction in &findings.contradictions {
            self.contradiction(coordinate, (name, unit), contradiction);
        }
        if let Some(noise) = &findings.noise {
            let has_usual_digits = positions.digits.significant >= USUAL_DIGITS;
            if noise.is_rounding && has_usual_digits && !noise.is_of_times {
                note += &format!(
                    "; with {} digits, the acceleration is uncertain by {} {unit}/s^2 (rms)",
                    positions.digits.significant,
                    short(noise.acceleration)
                );
            } else {
                self.noise(coordinate, (name, unit), noise, peak);
            }
        }
        if !findings.outliers.is_empty() {
            self.outliers(coordinate, (name, unit), &findings.outliers, peak);
        }
        if !findings.exchanged.is_empty() {
            self.exchanged(coordinate, (name, unit), &findings.exchanged, peak);
        }
        if let Some(held) = findings.held {
            self.held(coordinate, name, held);
        }
        self.notes.push(note);
    }

    /// Returns the place, in the header, of the column that contains a coordinate (`order` 0) or
    /// its first or second derivative.
    fn place(&self, coordinate: Coordinate, order: usize) -> Place {
        let role = Role::Coordinate { coordinate, order: u8::try_from(order).unwrap_or(0) };
        let column = self.header.columns.iter().find(|column| column.role == role);
        Place::new(&self.page, column.map_or(0..0, |column| column.span.clone()))
    }

    fn noise(
        &mut self,
        coordinate: Coordinate,
        (name, unit): (&str, &str),
        noise: &Noise,
        peak: Peak,
    ) {
        let column = derivative(name, noise.order);
        let per = ["", "/s", "/s^2"].get(noise.order).copied().unwrap_or_default();
        let cause = match (noise.is_rounding, noise.is_of_times) {
            (true, true) => "rounding of the time stamps, equivalent to an error",
            (true, false) => "rounding",
            _ => "noise",
        };
        let message = format!(
            "{cause} of {} {unit}{per} (rms) in `{column}` makes the acceleration uncertain by {} \
             {unit}/s^2 (rms); its peak is {} {unit}/s^2",
            short(noise.deviation.size),
            short(noise.acceleration),
            short(peak.size)
        );
        let label = format!("largest from t = {} s", short(noise.deviation.time));
        let mut help = String::new();
        // One filter applies to all columns, so it is suggested only once.
        if let Some(cutoff) = self.suggestion.take_if(|_| noise.order == 0) {
            let cutoff = number(cutoff);
            help = format!(
                "filter the recording with --filter \"{cutoff} Hz\" or `filter = \"{cutoff} Hz\"` in \
                 [motions.NAME] (this cut-off frequency suits the noise and the motion); or "
            );
        }
        help += if noise.is_of_times {
            "write the times with more digits, or replace them by equal steps if they are equal"
        } else if noise.is_rounding {
            "record more digits, fewer samples per second, or also rates and accelerations"
        } else {
            "check the time column, or also record rates and accelerations"
        };
        let place = self.place(coordinate, noise.order);
        let warning = Diagnostic::warning("recording", message);
        self.warnings.push(warning.at(place, label).help(help));
    }

    /// Adds the effect of a filter on a coordinate to the report. `column` is the index in the
    /// header of the column with its positions, `cutoff` the cut-off frequency, Hz; `findings` are
    /// those about the unfiltered samples.
    pub(super) fn filtered(
        &mut self,
        coordinate: Coordinate,
        column: usize,
        (cutoff, filtered): (f64, &Filtered),
        findings: Option<&Findings>,
    ) {
        let Some(positions) = self.header.columns.get(column) else { return };
        let unit = if positions.is_angle { "rad" } else { "m" };
        let name = positions.name.as_str();
        let peak = filtered.acceleration;
        let mut note = format!(
            "{name}: the filter removes {} {unit} (rms) and leaves an uncertainty of the acceleration \
             of {} {unit}/s^2 (rms); peak acceleration {} {unit}/s^2 at t = {} s",
            short(filtered.removed),
            short(filtered.acceleration_noise),
            short(peak.size),
            short(peak.time),
        );
        let rests: Vec<String> = filtered.rests.iter().map(describe_rest).collect();
        if !rests.is_empty() {
            note += &format!("; apart from noise, the coordinate is at rest {}", rests.join(", "));
        }
        self.notes.push(note);
        let Peak { size, time } = filtered.smearing;
        if size > SMEARING_LIMIT * peak.size {
            let message = format!(
                "the low-pass filter of {} Hz smears `{name}`: it changes the acceleration by {} \
                 {unit}/s^2 or more near t = {} s, and by about {} {unit}/s^2 if it has a step there; its \
                 peak is {} {unit}/s^2",
                number(cutoff),
                short(size),
                short(time),
                short(filtered.error_at_step),
                short(peak.size)
            );
            let place = self.place(coordinate, 0);
            let label =
                format!("steps of the acceleration are spread over {} s", short(rise_time(cutoff)));
            let warning = Diagnostic::warning("recording", message).at(place, label);
            self.warnings.push(warning.help("filter at a higher frequency"));
        }
        if let Some(findings) = findings.filter(|findings| !findings.outliers.is_empty()) {
            self.outliers(coordinate, (name, unit), &findings.outliers, findings.acceleration);
        }
    }

    fn outliers(
        &mut self,
        coordinate: Coordinate,
        (name, unit): (&str, &str),
        outliers: &[Peak],
        peak: Peak,
    ) {
        let Some(first) = outliers.first() else { return };
        let worst = outliers.iter().copied().max_by(|a, b| a.size.total_cmp(&b.size));
        let worst = worst.unwrap_or(*first);
        let message = format!(
            "`{name}` jumps at t = {} s: the acceleration is wrong by {} {unit}/s^2 there; its peak \
             is {} {unit}/s^2",
            short(worst.time),
            short(worst.size),
            short(peak.size)
        );
        let label = match outliers.len() {
            1 => "one sample does not fit its neighbours".to_owned(),
            n => format!("{n} such samples, the first at t = {} s", short(first.time)),
        };
        let place = self.place(coordinate, 0);
        let help = "correct or remove these samples, or low-pass filter the recording";
        self.warnings.push(Diagnostic::warning("recording", message).at(place, label).help(help));
    }

    fn exchanged(
        &mut self,
        coordinate: Coordinate,
        (name, unit): (&str, &str),
        exchanged: &[Peak],
        peak: Peak,
    ) {
        let Some(first) = exchanged.first() else { return };
        let worst = exchanged.iter().fold(0.0_f64, |most, own| most.max(own.size));
        let message = format!(
            "rows of `{name}` near t = {} s are exchanged: the acceleration is wrong by {} {unit}/s^2 there; its \
             peak is {} {unit}/s^2",
            short(first.time),
            short(worst),
            short(peak.size)
        );
        let label = match exchanged.len() {
            1 => "with these two values exchanged, the motion is smooth".to_owned(),
            n => format!("{n} such pairs of values"),
        };
        let place = self.place(coordinate, 0);
        let help = "sort the rows by the times at which they were measured";
        self.warnings.push(Diagnostic::warning("recording", message).at(place, label).help(help));
    }

    fn held(&mut self, coordinate: Coordinate, name: &str, held: Held) {
        let Held { samples, time } = held;
        let message = format!(
            "`{name}` keeps each value for {samples} rows, from t = {} s on: the accelerations come from the steps \
             between the values",
            short(time)
        );
        let label = "the sensor is slower than the log";
        let place = self.place(coordinate, 0);
        let help = "keep only the first row of each value, or low-pass filter the recording";
        self.warnings.push(Diagnostic::warning("recording", message).at(place, label).help(help));
    }

    fn contradiction(
        &mut self,
        coordinate: Coordinate,
        (name, unit): (&str, &str),
        found: &Contradiction,
    ) {
        let (column, below) = (derivative(name, found.order), derivative(name, found.order - 1));
        let per = if found.order == 1 { "/s" } else { "/s^2" };
        let message = format!(
            "`{column}` contradicts `{below}`: it differs from the slope of `{below}` \
             by {} {unit}{per} at t = {} s; the slope \
             is {} {unit}{per} (rms)",
            short(found.difference.size),
            short(found.difference.time),
            short(found.scale)
        );
        let place = self.place(coordinate, found.order);
        let label = format!("not the derivative of `{below}`");
        let help = format!(
            "check unit, sign and timing of the column, or delete it to use `{below}` alone"
        );
        // A difference as large as the slope itself is certainly a contradiction.
        if found.is_certain {
            self.errors.push(Diagnostic::error("recording", message).at(place, label).help(help));
        } else {
            let warning = Diagnostic::warning("recording", message);
            self.warnings.push(warning.at(place, label).help(help));
        }
    }
}

/// Describes in words when a signal is at rest.
fn describe_rest(rest: &Rest) -> String {
    if rest.from == rest.until {
        return format!("at t = {} s", short(rest.from));
    }
    format!("from {} to {} s", short(rest.from), short(rest.until))
}

/// Returns the name of the column that contains a derivative of a coordinate, such as
/// `d(platform.x)`.
fn derivative(name: &str, order: usize) -> String {
    match order {
        0 => name.to_owned(),
        _ => format!("{}({name})", "d".repeat(order)),
    }
}

/// Formats a number with four significant digits.
pub(super) fn short(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return number(x);
    }
    let places = 3 - x.abs().log10().floor() as i32;
    let rounded = format!("{x:.3e}").parse().unwrap_or(x);
    if (0..8).contains(&places) { number(rounded) } else { format!("{rounded:e}") }
}
