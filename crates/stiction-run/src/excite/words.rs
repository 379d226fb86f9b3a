//! Results of the motion design as text and JSON.

use super::precision::Confounded;
use super::result::Excitation;
use crate::names::width;
use serde_json::{Value, json};
use std::fmt::Write as _;
use stiction_draw::numbers::number;

impl Excitation {
    /// Returns the factor by which the search reduced the standard deviations of the base
    /// parameters, compared with the random start. The factor is the geometric mean over all base
    /// parameters.
    pub fn gain(&self) -> f64 {
        let count = self.expected.len().max(1) as f64;
        (0.5 * (self.quality.log_det - self.start.log_det) / count).exp()
    }

    /// Returns the results as a JSON object, the content of `excite.json`.
    pub fn to_json(&self) -> Value {
        let coordinates = self.coordinates.iter().enumerate().map(|(k, (name, unit))| {
            let [sines, cosines] = &self.coefficients[k];
            json!({
                "name": name, "unit": unit, "centre": self.centre[k], "sine": sines, "cosine": cosines,
            })
        });
        let limits = self.limits.iter().map(|used| {
            json!({
                "name": used.name, "limit": used.bound, "unit": used.unit, "used": used.part,
            })
        });
        let expected = self.expected.iter().map(|e| {
            json!({
                "name": e.name, "alone": e.alone, "value": e.value, "sigma": e.sigma, "unit": e.unit,
            })
        });
        let noise = self
            .noise
            .iter()
            .map(|(name, sigma, unit)| json!({ "actuator": name, "sigma": sigma, "unit": unit }));
        let pairs = self.pairs.iter().map(|pair| {
            json!({
                "pair": [pair.mu, pair.coulomb],
                "correlation": pair.correlation,
                "needs_payload": pair.needs_payload(),
                "with_load": pair.with.as_ref().map(|(load, _)| load),
                "correlation_with_load": pair.with.as_ref().map(|(_, correlation)| correlation),
            })
        });
        let logs = self.logs();
        let logs = logs.iter().map(|(file, load)| json!({ "file": file, "load": load }));
        json!({
            "duration": self.duration,
            "periods": self.periods,
            "base_frequency_hz": self.frequency,
            "step": self.step,
            "seed": self.seed,
            "coordinates": coordinates.collect::<Vec<_>>(),
            "log_det": self.quality.log_det,
            "log_det_of_start": self.start.log_det,
            "condition": finite(self.quality.condition),
            "condition_of_start": finite(self.start.condition),
            "gain": self.gain(),
            "steps": self.steps,
            "limits": limits.collect::<Vec<_>>(),
            "noise": noise.collect::<Vec<_>>(),
            "noise_is_assumed": self.is_noise_assumed,
            "parameters": expected.collect::<Vec<_>>(),
            "without_effect": self.without_effect,
            "payloads": {
                "logs": logs.collect::<Vec<_>>(),
                "needs_another": self.pairs.iter().any(Confounded::needs_payload),
                "pairs": pairs.collect::<Vec<_>>(),
            },
            "cautions": self.cautions,
        })
    }

    /// Returns a summary of the results for the terminal.
    pub fn to_text(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = self.write(&mut text);
        text
    }

    fn write(&self, out: &mut String) -> std::fmt::Result {
        let harmonics = self.coefficients.first().map_or(0, |c| c[0].len());
        let periods =
            if self.periods == 1 { "1 period" } else { &format!("{} periods", self.periods) };
        let names: Vec<&str> = self.coordinates.iter().map(|(name, _)| name.as_str()).collect();
        writeln!(
            out,
            "{} s, {periods} of a Fourier series with {harmonics} harmonics of {} Hz in {}\n\
             every period begins and ends at rest; {} samples, one every {} s\n",
            number(self.duration),
            number(self.frequency),
            names.join(", "),
            self.reference.len(),
            number(self.step)
        )?;
        writeln!(
            out,
            "information about {} parameters: log-determinant {} (random start {}), condition number {} ({})\n\
             standard deviations are {} times smaller than those of the random start (geometric mean)\n",
            self.expected.len(),
            number(self.quality.log_det),
            number(self.start.log_det),
            number(self.quality.condition),
            number(self.start.condition),
            number(self.gain())
        )?;
        self.write_limits(out)?;
        self.write_expected(out)?;
        self.write_plan(out)?;
        for caution in &self.cautions {
            writeln!(out, "\nCAUTION {caution}")?;
        }
        Ok(())
    }

    fn write_limits(&self, out: &mut String) -> std::fmt::Result {
        let wide = width(self.limits.iter().map(|used| used.name.as_str()), 5);
        writeln!(out, "{:wide$} {:>12} {:8} {:>7}", "limit", "bound", "unit", "used")?;
        for used in &self.limits {
            let part = format!("{:.1} %", 100.0 * used.part);
            let bound = number(used.bound);
            writeln!(out, "{:wide$} {bound:>12} {:8} {part:>7}", used.name, used.unit)?;
        }
        Ok(())
    }

    fn write_expected(&self, out: &mut String) -> std::fmt::Result {
        let origin = if self.is_noise_assumed { " (assumed)" } else { "" };
        let noise: Vec<String> = self
            .noise
            .iter()
            .map(|(name, sigma, unit)| format!("{name} {} {unit}", number(*sigma)))
            .collect();
        writeln!(out, "\nexpected standard deviations, for efforts with white noise{origin} of")?;
        writeln!(out, "{}\n", noise.join(", "))?;
        let alone = || self.expected.iter().filter(|e| e.alone);
        let wide = width(alone().map(|e| e.name.as_str()), 9);
        writeln!(out, "{:wide$} {:>12} {:>12}  unit", "parameter", "model", "sigma")?;
        for e in alone() {
            let (value, sigma) = (number(e.value), number(e.sigma));
            writeln!(out, "{:wide$} {value:>12} {sigma:>12}  {}", e.name, e.unit)?;
        }
        if self.expected.iter().any(|e| !e.alone) {
            writeln!(out, "\nparameters that the logs determine only in these combinations")?;
            for e in self.expected.iter().filter(|e| !e.alone) {
                let (value, sigma) = (number(e.value), number(e.sigma));
                writeln!(out, "  {value} +- {sigma} {}: {}", e.unit, e.name)?;
            }
        }
        if !self.without_effect.is_empty() {
            writeln!(out, "\nwithout effect on the efforts: {}", self.without_effect.join(", "))?;
        }
        Ok(())
    }

    fn write_plan(&self, out: &mut String) -> std::fmt::Result {
        writeln!(out, "\nlogs to record:")?;
        for (file, load) in self.logs() {
            match load {
                Some(load) => writeln!(out, "  {file}: the motion with the load {load}")?,
                None => writeln!(out, "  {file}: the motion without payload")?,
            }
        }
        if self.pairs.is_empty() {
            return Ok(());
        }
        let open: Vec<&Confounded> = self.pairs.iter().filter(|p| p.needs_payload()).collect();
        if open.is_empty() {
            return writeln!(
                out,
                "these logs separate mu from the load-independent friction of every bearing"
            );
        }
        for pair in open {
            write!(out, "{} and {} are not separated", pair.mu, pair.coulomb)?;
            match (&pair.with, pair.is_cured()) {
                (Some((load, correlation)), true) => writeln!(
                    out,
                    ": a second payload is needed; the load {load} suffices (correlation {correlation:.2})"
                )?,
                (Some((load, correlation)), false) => writeln!(
                    out,
                    ": a second payload is needed, heavier than that of the load {load} (correlation {correlation:.2})"
                )?,
                (None, _) => writeln!(
                    out,
                    ": a second payload of at least half the mass that the joint carries is \
                     needed; declare one as a load of the model"
                )?,
            }
        }
        Ok(())
    }
}

fn finite(x: f64) -> Value {
    if x.is_finite() { json!(x) } else { Value::Null }
}
