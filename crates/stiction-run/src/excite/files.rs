//! Files of a designed motion: the reference motion in the format of recorded motions, and the
//! options for logs of this motion.

use super::result::Excitation;
use std::fmt::Write as _;
use stiction_draw::numbers::exact;

/// Cut-off frequency of the filter for the logs, as a multiple of the frequency of the highest
/// harmonic. Efforts of friction and of squared rates contain higher harmonics than the motion
/// itself.
const CUTOFF: f64 = 5.0;
/// Largest cut-off frequency of the filter, as a fraction of the sampling rate.
const SAMPLED: f64 = 0.1;

impl Excitation {
    /// Returns the reference motion as CSV: time, then position, rate and acceleration of each
    /// coordinate, in the format of `stiction inverse --motion`.
    pub fn reference_csv(&self) -> String {
        table(&self.coordinates, self.reference.iter().map(|(time, motion)| (*time, motion)))
    }

    /// Returns the reference motion in the coordinates of the actuators as CSV; `None` if the
    /// motion is designed in these coordinates.
    pub fn actuators_csv(&self) -> Option<String> {
        let actuators = self.actuators.as_ref()?;
        let times = self.reference.iter().map(|(time, _)| *time);
        Some(table(&actuators.names, times.zip(&actuators.rows)))
    }

    /// Returns a suitable cut-off frequency for the filter of the logs, Hz.
    pub fn cutoff(&self) -> f64 {
        let highest = self.frequency * self.coefficients.first().map_or(1, |c| c[0].len()) as f64;
        (CUTOFF * highest).min(SAMPLED / self.step)
    }

    /// Returns the options of `stiction identify` for logs of this motion, as TOML.
    pub fn log_toml(&self) -> String {
        let mut text = String::from(
            "# Options of `stiction identify` for logs of the motion in excite.csv. Log time, positions and efforts\n\
             # over the whole motion, one file for each table below.\n\n",
        );
        let _ = writeln!(text, "filter = \"{:.4} Hz\"", self.cutoff());
        if !self.held.is_empty() {
            let friction_only = self.holds_inertia;
            if friction_only {
                text += "estimate = \"friction\"\n";
            }
            // The key `estimate` already fixes the inertias at the values of the model.
            let held: Vec<&String> = self
                .held
                .iter()
                .filter(|name| !friction_only || !self.inertias.contains(name))
                .collect();
            if !held.is_empty() {
                text += "\n# These parameters keep the values of the model; the motion is designed for all others.\nhold = [\n";
                held.iter().for_each(|name| {
                    let _ = writeln!(text, "    {name:?},");
                });
                text += "]\n";
            }
        }
        for (file, load) in self.logs() {
            let _ = write!(text, "\n[[logs]]\nfile = {file:?}\n");
            if let Some(load) = load {
                let _ = writeln!(text, "load = {load:?}");
            }
        }
        text
    }

    /// Returns the names of the log files to record. Each name is paired with the load that the
    /// robot carries; `None` for the robot alone.
    pub fn logs(&self) -> Vec<(String, Option<&str>)> {
        match self.payloads.as_slice() {
            [] => vec![("log.csv".to_owned(), None)],
            all => {
                all.iter().map(|load| (format!("log-{load}.csv"), Some(load.as_str()))).collect()
            }
        }
    }
}

fn table<'a>(
    names: &[(String, &'static str)],
    rows: impl Iterator<Item = (f64, &'a [Vec<f64>; 3])>,
) -> String {
    let mut text = "time [s]".to_owned();
    for (name, unit) in names {
        let _ = write!(text, ",{name} [{unit}],d({name}) [{unit}/s],dd({name}) [{unit}/s^2]");
    }
    text.push('\n');
    for (time, motion) in rows {
        exact(&mut text, time);
        for k in 0..names.len() {
            for values in motion {
                text.push(',');
                exact(&mut text, values[k]);
            }
        }
        text.push('\n');
    }
    text
}
