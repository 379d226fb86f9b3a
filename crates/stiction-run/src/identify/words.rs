//! Results of an identification as text, JSON and a model file.

use super::closed_loop::Simulated;
use super::identified::{Identified, Named};
use crate::exchange::{Instant, model_file};
use serde_json::{Map, Value, json};
use std::fmt::Write as _;
use stiction_core::kinematics::{Coordinate, Target};
use stiction_format::ModelFile;
use stiction_identify::{FitVerdict, Verdict};

/// Formats a number with four significant digits.
fn short(x: f64) -> String {
    let size = x.abs();
    if x == 0.0 {
        return "0".to_owned();
    }
    match size {
        s if (1e-3..1e5).contains(&s) => {
            let digits = (3.0 - s.log10().floor()).max(0.0) as usize;
            format!("{x:.digits$}")
        }
        _ => format!("{x:.3e}"),
    }
}

impl Identified {
    /// Returns whether the model fails to reproduce the data.
    pub fn has_failed(&self) -> bool {
        self.verdict == FitVerdict::Failed
    }

    /// Returns the content of `identify.json`.
    pub fn to_json(&self) -> Value {
        let named = |p: &Named| {
            json!({
                "name": p.name, "value": p.value, "sigma": p.sigma, "unit": p.unit,
                "verdict": p.verdict.to_string(), "prior": p.prior, "structure": p.structure,
                "filter_bias": p.filter_bias,
            })
        };
        let combined = self.combinations.iter().map(|c| {
            json!({
                "name": c.name, "value": c.value, "sigma": c.sigma, "unit": c.unit,
                "verdict": c.verdict.to_string(), "filter_bias": c.filter_bias,
            })
        });
        let predictions = self.predictions.iter().map(|p| {
            let errors: Map<String, Value> =
                p.error_percent.iter().map(|(name, e)| (name.clone(), json!(e))).collect();
            let prior: Map<String, Value> = p
                .error_percent
                .iter()
                .zip(&p.prior_percent)
                .map(|((name, _), e)| (name.clone(), json!(e)))
                .collect();
            json!({
                "log": p.log, "used_for_fit": p.used_for_fit, "error_percent": errors,
                "error_percent_of_model": prior,
            })
        });
        let finite = |x: f64| if x.is_finite() { json!(x) } else { Value::Null };
        json!({
            "verdict": self.verdict.to_string(),
            "parameters": self.parameters.iter().map(named).collect::<Vec<_>>(),
            "combinations": combined.collect::<Vec<_>>(),
            "predictions": predictions.collect::<Vec<_>>(),
            "asymmetries": self.asymmetries.iter().map(|a| json!({
                "actuator": a.actuator, "value": a.value, "sigma": a.sigma, "unit": a.unit,
                "frictionless": a.frictionless,
            })).collect::<Vec<_>>(),
            "delays": self.delays.iter().map(|d| json!({
                "actuator": d.actuator, "value": d.value, "sigma": d.sigma, "unit": "s", "corrected": d.is_corrected,
            })).collect::<Vec<_>>(),
            "missing": self.missing.iter().map(|m| json!({
                "actuator": m.actuator, "what": m.what, "value": m.value, "sigma": m.sigma, "unit": m.unit,
                "left_out_gain": m.gain, "cure": m.cure,
                "changes_in_sigma": m.changes.iter().map(|(name, x)| (name.clone(), json!(x))).collect::<Map<_, _>>(),
            })).collect::<Vec<_>>(),
            "confounded": self.confounded.iter().map(|(a, b, _)| json!([a, b])).collect::<Vec<_>>(),
            "cures": self.confounded.iter().map(|(a, b, cure)| json!({ "pair": [a, b], "cure": cure })).collect::<Vec<_>>(),
            "cautions": self.cautions,
            "rank": { "combinations": self.rank.0, "gap": finite(self.rank.1) },
            "estimator": self.estimator,
            "simulated": self.simulated.as_ref().map(|own| json!({
                "rounds": own.rounds,
                "deviations": own.deviations.iter().map(|d| json!({
                    "log": d.log, "actuator": d.actuator, "rms": d.value, "tracking_rms": d.tracking, "unit": d.unit,
                })).collect::<Vec<_>>(),
            })),
            "prior_strength": self.strength,
            "left_out_ratio": finite(self.left_out),
            "left_out_ratio_without_prior": finite(self.left_out_plain),
            "filter_hz": self.cutoffs,
            "residuals": self.residuals,
        })
    }

    /// Returns the summary for the terminal.
    pub fn to_text(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = self.write(&mut text);
        text
    }

    fn write(&self, out: &mut String) -> std::fmt::Result {
        let count =
            |verdict: Verdict| self.parameters.iter().filter(|p| p.verdict == verdict).count();
        writeln!(out, "verdict: {}", self.verdict)?;
        writeln!(
            out,
            "{} parameters: {} identified, {} fit only in combination, {} not excited, {} held\n",
            self.parameters.len(),
            count(Verdict::Identified),
            count(Verdict::FitsOnly),
            count(Verdict::NotExcited),
            count(Verdict::Held)
        )?;
        writeln!(
            out,
            "a prior pulls inertias towards those of the model with the weight of {} samples; \
             squared residuals of left-out blocks are\n{} times those of the fit, {} times \
             without the prior\n",
            short(self.strength),
            short(self.left_out),
            short(self.left_out_plain)
        )?;
        let cutoffs: Vec<String> =
            self.cutoffs.iter().flatten().map(|hz| format!("{} Hz", short(*hz))).collect();
        if !cutoffs.is_empty() {
            writeln!(
                out,
                "positions and efforts are filtered at {} (-3 dB, without phase shift)\n",
                cutoffs.join(", ")
            )?;
        }
        if self.estimator == "instrumental-variables" {
            writeln!(out, "estimated by instrumental variables from the commanded motion\n")?;
        }
        if let Some(simulated) = &self.simulated {
            self.write_simulated(simulated, out)?;
        }
        let width = self.parameters.iter().map(|p| p.name.len()).max().unwrap_or(0).max(9);
        writeln!(
            out,
            "{:width$} {:>12} {:>12} {:>12}  {:12} verdict",
            "parameter", "value", "sigma", "model", "unit"
        )?;
        let shown = self.parameters.iter().filter(|p| match p.verdict {
            Verdict::Held => false,
            // Many inertias keep the values of the model and are not listed.
            Verdict::NotExcited => !p.is_inertia,
            _ => true,
        });
        for p in shown {
            let prior = if p.prior.is_nan() { "none".to_owned() } else { short(p.prior) };
            let (value, sigma) = (short(p.value), short(p.sigma));
            writeln!(
                out,
                "{:width$} {value:>12} {sigma:>12} {prior:>12}  {:12} {}",
                p.name, p.unit, p.verdict
            )?;
        }
        if !self.combinations.is_empty() {
            writeln!(out, "\ncombinations that the efforts depend on")?;
            for c in &self.combinations {
                writeln!(
                    out,
                    "  {} +- {} {}  {}: {}",
                    short(c.value),
                    short(c.sigma),
                    c.unit,
                    c.verdict,
                    c.name
                )?;
            }
        }
        writeln!(out, "\nerror of the efforts, percent (in brackets that of the unchanged model)")?;
        for p in &self.predictions {
            let each: Vec<String> = p
                .error_percent
                .iter()
                .zip(&p.prior_percent)
                .map(|((name, e), prior)| match (e, prior) {
                    (Some(e), Some(prior)) => format!("{name} {e:.2} ({prior:.1})"),
                    _ => format!("{name} without rows"),
                })
                .collect();
            let what = if p.used_for_fit { "fitted" } else { "predicted" };
            writeln!(out, "  {} ({what}): {}", p.log, each.join(", "))?;
        }
        if !self.asymmetries.is_empty() {
            writeln!(
                out,
                "\neffort forward plus effort backward at the same speed (in brackets without friction)"
            )?;
            for a in &self.asymmetries {
                writeln!(
                    out,
                    "  {}: {} +- {} ({}) {}",
                    a.actuator,
                    short(a.value),
                    short(a.sigma),
                    short(a.frictionless),
                    a.unit
                )?;
            }
        }
        if !self.confounded.is_empty() {
            writeln!(out, "\nnot distinguished by these data")?;
            for (a, b, cure) in &self.confounded {
                writeln!(out, "  {a} and {b}: {cure}")?;
            }
        }
        for caution in &self.cautions {
            writeln!(out, "\nCAUTION {caution}")?;
        }
        Ok(())
    }

    fn write_simulated(&self, simulated: &Simulated, out: &mut String) -> std::fmt::Result {
        writeln!(
            out,
            "estimated by the output-error method from {} simulations of the closed loop; simulated minus measured \
             position (rms; in brackets measured minus commanded)",
            simulated.rounds
        )?;
        for own in &simulated.deviations {
            writeln!(
                out,
                "  {}: {} {} ({}) {}",
                own.log,
                own.actuator,
                short(own.value),
                short(own.tracking),
                own.unit
            )?;
        }
        writeln!(out)
    }

    /// Returns the text of the identified model; comments contain values and standard deviations.
    /// The only motion of the identified model is a rest at the initial position of the default
    /// motion. Code exported from this model starts at this position.
    ///
    /// # Errors
    /// Returns a message if a model file cannot express the friction.
    pub fn model_text(&self, model: &ModelFile) -> Result<String, String> {
        let motion = model.default_motion.as_deref().and_then(|name| model.motion(name));
        let start: Vec<(Coordinate, Target<f64>)> = motion.map_or(Vec::new(), |motion| {
            let coordinates = motion.coordinates.iter().map(|(coordinate, _)| *coordinate);
            let at_rest = |at: Target<f64>| Target { rate: 0.0, acceleration: 0.0, ..at };
            coordinates.zip(motion.at(motion.start).map(at_rest)).collect()
        });
        let instant =
            Instant { motion: &start, friction: model.default_friction, ..Instant::default() };
        let text = model_file(&self.mechanism, &model.title, instant)
            .map_err(|error| error.to_string())?;
        let mut out = format!(
            "# Identified by stiction {}; verdict: {}.\n",
            env!("CARGO_PKG_VERSION"),
            self.verdict
        );
        for p in self.parameters.iter().filter(|p| p.verdict != Verdict::Held) {
            let _ = writeln!(
                out,
                "# {} = {} +- {} {} ({})",
                p.name,
                short(p.value),
                short(p.sigma),
                p.unit,
                p.verdict
            );
        }
        let is_left_out = |p: &Named| p.is_of_log && p.verdict != Verdict::Held;
        if self.parameters.iter().any(is_left_out) {
            out += "# Offsets and factors of formulas belong to the logs: this model does not contain them.\n";
        }
        out.push('\n');
        Ok(out + &text)
    }
}
