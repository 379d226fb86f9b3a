//! Report on the quality of a recording: peaks, doubtful data, contradictions.

use super::header::{Header, Role};
use crate::diagnostic::{Diagnostic, Diagnostics, number};
use crate::signal::quality::{Contradiction, Findings, Noise, Peak};
use crate::source::{Place, Source};
use std::sync::Arc;
use stiction_core::kinematics::Coordinate;

/// Number of significant digits from which numbers have the usual precision of logs: the effect of
/// their rounding on accelerations is a note, not a defect of the recording.
const USUAL_DIGITS: i32 = 7;

/// Notes, warnings and errors about the columns of a recording.
pub(super) struct Report<'a> {
    header: &'a Header,
    page: Arc<Source>,
    notes: Vec<String>,
    warnings: Diagnostics,
    errors: Diagnostics,
}

impl<'a> Report<'a> {
    /// An empty report; `page` contains the header.
    pub(super) fn new(header: &'a Header, page: Arc<Source>) -> Self {
        Self {
            header,
            page,
            notes: Vec::new(),
            warnings: Diagnostics::new(),
            errors: Diagnostics::new(),
        }
    }

    /// Notes, warnings, errors.
    pub(super) fn finish(self) -> (Vec<String>, Diagnostics, Diagnostics) {
        (self.notes, self.warnings, self.errors)
    }

    /// Reports the findings about a coordinate whose positions are in a column.
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
            if noise.is_rounding && positions.digits.significant >= USUAL_DIGITS {
                note += &format!(
                    "; {} digits leave the acceleration uncertain by {} {unit}/s^2 (rms)",
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
        self.notes.push(note);
    }

    /// Place of the column with a coordinate or one of its derivatives.
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
        let cause = if noise.is_rounding { "rounding" } else { "noise" };
        let message = format!(
            "{cause} of {} {unit}{per} (rms) in `{column}` makes the acceleration uncertain by {} \
             {unit}/s^2 (rms); its peak is {} {unit}/s^2",
            short(noise.deviation.size),
            short(noise.acceleration),
            short(peak.size)
        );
        let label = format!("largest from t = {} s", short(noise.deviation.time));
        let help = if noise.is_rounding {
            "record more digits, fewer samples per second, or also rates and accelerations"
        } else {
            "low-pass filter the recording, check its time column, or also record rates and \
             accelerations"
        };
        let place = self.place(coordinate, noise.order);
        let warning = Diagnostic::warning("recording", message);
        self.warnings.push(warning.at(place, label).help(help));
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

    fn contradiction(
        &mut self,
        coordinate: Coordinate,
        (name, unit): (&str, &str),
        found: &Contradiction,
    ) {
        let (column, below) = (derivative(name, found.order), derivative(name, found.order - 1));
        let per = if found.order == 1 { "/s" } else { "/s^2" };
        let message = format!(
            "`{column}` contradicts `{below}`: it differs from the slope by {} {unit}{per} at t = {} \
             s; the slope is {} {unit}{per} (rms)",
            short(found.difference.size),
            short(found.difference.time),
            short(found.scale)
        );
        let place = self.place(coordinate, found.order);
        let label = format!("not the derivative of `{below}`");
        let help = format!(
            "check unit, sign and timing of the column, or delete it to use `{below}` alone"
        );
        // A difference as large as the slope itself is certain.
        if found.difference.size > found.scale {
            self.errors.push(Diagnostic::error("recording", message).at(place, label).help(help));
        } else {
            let warning = Diagnostic::warning("recording", message);
            self.warnings.push(warning.at(place, label).help(help));
        }
    }
}

/// Name of the column with a derivative of a coordinate.
fn derivative(name: &str, order: usize) -> String {
    match order {
        0 => name.to_owned(),
        _ => format!("{}({name})", "d".repeat(order)),
    }
}

/// A number with four significant digits.
fn short(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return number(x);
    }
    let places = 3 - x.abs().log10().floor() as i32;
    let rounded = format!("{x:.3e}").parse().unwrap_or(x);
    if (0..8).contains(&places) { number(rounded) } else { format!("{rounded:e}") }
}
