//! Options of the identification, which are read from a TOML file.

use super::IdentifyError as Error;
use stiction_format::{
    Contents, Control, Diagnostics, LoadCase, ModelFile, Payload, Renamed, Source, did_you_mean,
    hertz, seconds,
};
use toml::{Table, Value};

/// Example of an options file that contains every key. The option `--template` writes it.
pub const TEMPLATE: &str = r#"# Options of `stiction identify`. Every key may be left out.

# Cut-off frequency (-3 dB) of the zero-phase low-pass filter, for positions, efforts and the model alike.
# If it is left out, the program chooses it from the positions.
# filter = "10 Hz"

# What is estimated: "all", "friction" or "inertia". All other parameters keep the values of the model.
estimate = "all"

# Strength of the prior that pulls inertias to those of the model, in equivalent samples; "auto" chooses
# the most probable one for these logs.
prior = "auto"

# Relative error of the inertias of the model that is expected without logs; no standard deviation of an inertia that
# only the model determines is smaller.
prior_error = "30 %"

# "least-squares", or "instrumental-variables": the motion commanded in columns such as `axis1.reference [deg]`
# replaces the measured one where errors of measured rates and accelerations would bias the estimate; or
# "output-error": the motion is simulated in the closed loop of the model and its controller.
estimator = "least-squares"

# The robot's controller, for "output-error"; as for `stiction forward --controller`.
# controller = "type = pd; period = 1 ms; leg1.P.kp = 2e4 N/m; leg1.P.kd = 300 N s/m"

# Estimate a constant error of every measured effort.
offsets = false

# Delay of the measured efforts relative to the positions: "auto" estimates, reports and corrects that of each
# effort; a given time is corrected, but not estimated.
delay = "auto"                 # or "12 ms", or 0

# Parameters that keep the value of the model; * stands for any text.
hold = []                      # ["leg*.rod.i*"]

# Groups of parameters with one common value.
tie = []                       # [["leg*.P.mu"], ["leg*.P.viscous"]]

# Names of the columns of logs without a header, and the time from row to row of logs without a time.
# header = ["t", "q1", "i1"]
# step = "1 ms"

# Least and greatest values of parameters, in SI units. Those of a body must contain the values of the model.
[bounds]
# "leg*.P.mu" = [0.05, 0.3]
# "platform.mass" = [4.5, 7]
# "platform.com.z" = [-0.01, 0.05]

# Columns whose header does not say what they are: the header they should have, or a table with a
# factor and an offset in that unit; "" for columns that are not used, in whose names * stands for any text.
[columns]
# q1 = "leg1.P [mm]"
# i1 = { is = "A1.current [A]", factor = -1, offset = 0.02 }
# "debug*" = ""

# Efforts that the model lacks, as formulas of coordinates and rates. The program estimates a factor
# for each formula.
[terms]
# gas_spring = "axis2 = 900 N m*sin(axis2 - 20 deg)"

# One table for each log that needs options.
# [[logs]]
# file = "heavy.csv"
# use = "predict"              # or "fit"; logs named "predict" check the fit
# from = "0.5 s"
# until = "9.5 s"
# steady = true                # each row is a motion of constant rate, such as `d(axis1) [rad/s]`, without time
# load = "payload"             # a load of the model with payloads, or
# payload = { body = "platform", mass = "2 kg", com = [0, 0, "30 mm"], inertia = [0.01, 0.01, 0.01] }
"#;

/// Method of estimation.
#[derive(Clone, Debug, PartialEq)]
pub enum Estimator {
    /// Least squares along the measured motions.
    LeastSquares,
    /// Instrumental variables: columns along the commanded motions replace those along the measured ones where noise of
    /// the motion would bias the estimate.
    InstrumentalVariables,
    /// Output-error method: least squares along motions that are simulated in the closed loop of the model and this
    /// controller.
    OutputError(Control),
}

impl Estimator {
    /// Returns the name of the method, as in the options.
    pub fn name(&self) -> &'static str {
        match self {
            Self::LeastSquares => "least-squares",
            Self::InstrumentalVariables => "instrumental-variables",
            Self::OutputError(_) => "output-error",
        }
    }
}

/// Options that apply to one log.
#[derive(Clone, Debug, Default)]
pub struct LogSettings {
    /// Name or path of the log file.
    pub file: String,
    /// True if the log only checks the prediction of the fit; false if it is fitted.
    pub predict: bool,
    /// Start of the used time interval, s; minus infinity by default.
    pub from: f64,
    /// End of the used time interval, s; infinite by default.
    pub until: f64,
    /// True if each row of the log is a separate motion with constant rates.
    pub steady: bool,
    /// Payloads that the robot carries in this log.
    pub payloads: Vec<Payload>,
}

impl LogSettings {
    /// Returns whether these options belong to the log at `path`, that is, whether the last
    /// components of `path` equal the components of [`Self::file`].
    pub fn is_at(&self, path: &str) -> bool {
        let parts = |text: &str| -> Vec<String> {
            text.split(['/', '\\'])
                .filter(|part| !matches!(*part, "" | "."))
                .map(str::to_owned)
                .collect()
        };
        let (name, path) = (parts(&self.file), parts(path));
        !name.is_empty() && path.ends_with(&name)
    }
}

/// Options of identification.
#[derive(Clone, Debug)]
pub struct IdentifySettings {
    /// Cut-off frequency of the filter, Hz; chosen automatically if absent.
    pub filter: Option<f64>,
    /// Strength of the prior on the inertias, as a number of equivalent samples; chosen
    /// automatically if absent.
    pub strength: Option<f64>,
    /// Relative error of the inertias of the model that is expected without logs.
    pub prior_error: f64,
    /// Method of estimation.
    pub estimator: Estimator,
    /// True to estimate a constant error of each effort.
    pub offsets: bool,
    /// Delay of all efforts relative to the positions, s; estimated if absent.
    pub delay: Option<f64>,
    /// True to fix all inertial parameters at the values of the model.
    pub hold_inertia: bool,
    /// True to fix all friction parameters at the values of the model.
    pub hold_friction: bool,
    /// Name patterns of the parameters that are fixed at the values of the model.
    pub hold: Vec<String>,
    /// Groups of name patterns; the parameters of each group have a common value.
    pub tie: Vec<Vec<String>>,
    /// Name patterns of parameters, each with the least and the greatest value, SI units.
    pub bounds: Vec<(String, [f64; 2])>,
    /// Log columns whose header does not state their content, with the header that they should
    /// have, a factor and an offset.
    pub columns: Vec<Renamed>,
    /// Names of the columns of logs without a header.
    pub header: Vec<String>,
    /// Time between successive rows, s, for logs without a time column.
    pub step: Option<f64>,
    /// Effort terms that the model lacks: the name of each term and its formula for an effort.
    pub terms: Vec<(String, String)>,
    /// Options that apply to individual logs.
    pub logs: Vec<LogSettings>,
}

const KEYS: [&str; 16] = [
    "filter",
    "estimate",
    "prior",
    "prior_error",
    "estimator",
    "controller",
    "offsets",
    "delay",
    "hold",
    "tie",
    "bounds",
    "header",
    "step",
    "columns",
    "terms",
    "logs",
];
const LOG_KEYS: [&str; 7] = ["file", "use", "from", "until", "steady", "load", "payload"];

fn bad(key: &str, what: impl std::fmt::Display) -> Error {
    Error { message: format!("options: `{key}` {what}"), help: String::new() }
}

fn with_help(key: &str, what: impl std::fmt::Display, help: impl Into<String>) -> Error {
    Error { message: format!("options: `{key}` {what}"), help: help.into() }
}

/// Relative error of the inertias of a model that is expected unless the options state it. This is an assumption about
/// models from drawings, which lack cables, grease and fasteners or have another density; it is not measured.
const PRIOR_ERROR: f64 = 0.3;
/// Least and greatest relative error of the inertias that the options may state. The compared strengths of the prior
/// suffice for this range if up to a thousand rows count as one.
const PRIOR_ERRORS: [f64; 2] = [0.01, 1.0];

impl Default for IdentifySettings {
    fn default() -> Self {
        Self {
            filter: None,
            strength: None,
            prior_error: PRIOR_ERROR,
            estimator: Estimator::LeastSquares,
            offsets: false,
            delay: None,
            hold_inertia: false,
            hold_friction: false,
            hold: Vec::new(),
            tie: Vec::new(),
            bounds: Vec::new(),
            columns: Vec::new(),
            header: Vec::new(),
            step: None,
            terms: Vec::new(),
            logs: Vec::new(),
        }
    }
}

impl IdentifySettings {
    /// Parses the text of an options file; `name` identifies the file in messages.
    ///
    /// # Errors
    /// Returns an error if the text is not TOML, or if a key or value is invalid.
    pub fn parse(name: &str, text: &str, model: &ModelFile) -> Result<Self, Error> {
        let table: Table = text.parse().map_err(|error: toml::de::Error| Error {
            message: format!("{name}: {}", error.to_string().trim_end()),
            help: "`stiction identify --template` writes a file with every key".to_owned(),
        })?;
        let mut settings = Self::default();
        for (key, value) in &table {
            match key.as_str() {
                "filter" => settings.filter = Some(quantity(key, value, hertz)?),
                "prior" => settings.strength = strength(key, value)?,
                "prior_error" => settings.prior_error = prior_error(key, value)?,
                "offsets" => {
                    settings.offsets =
                        value.as_bool().ok_or_else(|| bad(key, "should be true or false"))?;
                }
                "delay" if value.as_str() == Some("auto") => {}
                "delay" => settings.delay = Some(quantity(key, value, seconds)?),
                "estimate" => match value.as_str() {
                    Some("all") => {}
                    Some("friction") => settings.hold_inertia = true,
                    Some("inertia") => settings.hold_friction = true,
                    _ => return Err(bad(key, "should be \"all\", \"friction\" or \"inertia\"")),
                },
                "estimator" => match value.as_str() {
                    Some("least-squares") => settings.estimator = Estimator::LeastSquares,
                    Some("instrumental-variables") => {
                        settings.estimator = Estimator::InstrumentalVariables;
                    }
                    Some("output-error") => {
                        settings.estimator = Estimator::OutputError(controller(&table, model)?);
                    }
                    _ => {
                        return Err(bad(
                            key,
                            "should be \"least-squares\", \"instrumental-variables\" or \"output-error\"",
                        ));
                    }
                },
                "controller" if is_output_error(&table) => {}
                "controller" => {
                    return Err(with_help(
                        key,
                        "applies only to the output-error method",
                        "write `estimator = \"output-error\"`, or delete `controller`",
                    ));
                }
                "hold" => settings.hold = texts(key, value)?,
                "tie" => {
                    let groups =
                        value.as_array().ok_or_else(|| bad(key, "should be a list of lists"))?;
                    settings.tie =
                        groups.iter().map(|group| texts(key, group)).collect::<Result<_, _>>()?;
                }
                "bounds" => settings.bounds = bounds(key, value)?,
                "header" => settings.header = texts(key, value)?,
                "step" => {
                    let step = quantity(key, value, seconds)?;
                    if step.is_nan() || step <= 0.0 {
                        return Err(bad(key, "should be a positive time, such as \"1 ms\""));
                    }
                    settings.step = Some(step);
                }
                "columns" => settings.columns = columns(key, value)?,
                "terms" => {
                    let table = value.as_table().ok_or_else(|| bad(key, "should be a table"))?;
                    for (name, formula) in table {
                        let formula = formula.as_str().ok_or_else(|| {
                            with_help(
                                key,
                                format!("has a value of `{name}` that is not text"),
                                "write `NAME = \"JOINT = FORMULA\"`",
                            )
                        })?;
                        settings.terms.push((name.clone(), formula.to_owned()));
                    }
                }
                "logs" => {
                    let logs =
                        value.as_array().ok_or_else(|| bad(key, "should be [[logs]] tables"))?;
                    for log in logs {
                        settings.logs.push(log_settings(log, model)?);
                    }
                }
                _ => return Err(unknown(key, &KEYS)),
            }
        }
        Ok(settings)
    }

    /// Returns the options of the log at `path`; default options if none of [`Self::logs`] belong
    /// to this log.
    pub fn of_log(&self, path: &str) -> LogSettings {
        let own = self.logs.iter().find(|log| log.is_at(path));
        own.cloned().unwrap_or(LogSettings {
            file: path.to_owned(),
            from: f64::NEG_INFINITY,
            until: f64::INFINITY,
            ..LogSettings::default()
        })
    }
}

fn unknown(key: &str, known: &[&str]) -> Error {
    let help = did_you_mean(key, "keys", known.iter().copied());
    with_help(
        key,
        "is not a key",
        help.unwrap_or_else(|| format!("there are {}", known.join(", "))),
    )
}

fn quantity(key: &str, value: &Value, read: fn(&str) -> Result<f64, String>) -> Result<f64, Error> {
    match value {
        Value::String(text) => {
            read(text).map_err(|why| bad(key, format!("is not understood: {why}")))
        }
        Value::Float(number) if number.is_finite() => Ok(*number),
        Value::Integer(number) => Ok(*number as f64),
        _ => Err(bad(key, "should be a number with a unit, such as \"10 Hz\" or \"2 s\"")),
    }
}

fn strength(key: &str, value: &Value) -> Result<Option<f64>, Error> {
    let number = match value {
        Value::String(text) if text == "auto" => return Ok(None),
        Value::Float(number) => *number,
        Value::Integer(number) => *number as f64,
        _ => f64::NAN,
    };
    match number > 0.0 && number.is_finite() {
        true => Ok(Some(number)),
        false => Err(bad(key, "should be \"auto\" or a positive number of samples")),
    }
}

fn prior_error(key: &str, value: &Value) -> Result<f64, Error> {
    let read = |text: &str| -> Option<f64> {
        Some(text.trim().strip_suffix('%')?.trim().parse::<f64>().ok()? / 100.0)
    };
    let error = match value {
        Value::String(text) => read(text),
        other => number(other),
    };
    let [least, most] = PRIOR_ERRORS;
    error.filter(|own| (least..=most).contains(own)).ok_or_else(|| {
        with_help(
            key,
            format!(
                "should be a relative error from {:.0} to {:.0} %",
                100.0 * least,
                100.0 * most
            ),
            "for example \"10 %\" or 0.1",
        )
    })
}

fn is_output_error(table: &Table) -> bool {
    table.get("estimator").and_then(Value::as_str) == Some("output-error")
}

/// Reads the controller of the closed loop in which the output-error method simulates the logs.
fn controller(table: &Table, model: &ModelFile) -> Result<Control, Error> {
    let key = "controller";
    if table.contains_key("terms") {
        return Err(with_help(
            "terms",
            "cannot be simulated by the output-error method",
            "add the effort to the model, for example as a spring, or choose another `estimator`",
        ));
    }
    let help = "for example `controller = \"type = pd; period = 1 ms; leg1.P.kp = 2e4 N/m; leg1.P.kd = 300 N s/m\"`, \
                as for `stiction forward --controller`";
    let Some(text) = table.get(key).and_then(Value::as_str) else {
        let what = match table.contains_key(key) {
            true => "should be text",
            false => {
                "is missing: the output-error method simulates the closed loop with the robot's controller"
            }
        };
        return Err(with_help(key, what, help));
    };
    let files = |_: &str| Err("files cannot be read here: write assignments".to_owned());
    let read = model.parse_control(&Source::new(key, text), &files);
    read.map_err(|out| with_help(key, format!("is not understood:\n{out}"), help))
}

fn texts(key: &str, value: &Value) -> Result<Vec<String>, Error> {
    let list = value.as_array().and_then(|list| {
        list.iter().map(|entry| entry.as_str().map(str::to_owned)).collect::<Option<Vec<_>>>()
    });
    list.ok_or_else(|| bad(key, "should be a list of names"))
}

/// Reads a TOML number with or without a decimal point; `None` if the value is not a number.
fn number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|n| n as f64))
}

fn bounds(key: &str, value: &Value) -> Result<Vec<(String, [f64; 2])>, Error> {
    let table = value.as_table().ok_or_else(|| bad(key, "should be a table"))?;
    let each = table.iter().map(|(pattern, value)| {
        let pair = value.as_array().map(|list| list.iter().map(number).collect::<Vec<_>>());
        match pair.as_deref() {
            Some([Some(low), Some(high)])
                if low <= high && *low < f64::INFINITY && *high > f64::NEG_INFINITY =>
            {
                Ok((pattern.clone(), [*low, *high]))
            }
            _ => Err(with_help(
                key,
                format!("of `{pattern}` should be two numbers, the least and the greatest value"),
                "for example `\"leg*.P.mu\" = [0.05, 0.3]`, in SI units",
            )),
        }
    });
    each.collect()
}

fn columns(key: &str, value: &Value) -> Result<Vec<Renamed>, Error> {
    let table = value.as_table().ok_or_else(|| bad(key, "should be a table"))?;
    let each = table.iter().map(|(column, value)| {
        let mut renamed =
            Renamed { column: column.clone(), meaning: String::new(), factor: 1.0, offset: 0.0 };
        match value {
            Value::String(text) => renamed.meaning.clone_from(text),
            Value::Table(table) => {
                for (key, value) in table {
                    match (key.as_str(), value.as_str(), number(value)) {
                        ("is", Some(text), _) => text.clone_into(&mut renamed.meaning),
                        ("factor", _, Some(x)) if x.is_finite() && x != 0.0 => renamed.factor = x,
                        ("offset", _, Some(x)) if x.is_finite() => renamed.offset = x,
                        ("is" | "factor" | "offset", ..) => {
                            return Err(bad(column, format!("has an invalid value of `{key}`")));
                        }
                        _ => return Err(unknown(key, &["is", "factor", "offset"])),
                    }
                }
            }
            _ => {
                return Err(with_help(
                    column,
                    "should be the header of the column",
                    "for example `q1 = \"leg1.P [mm]\"`",
                ));
            }
        }
        Ok(renamed)
    });
    each.collect()
}

fn log_settings(value: &Value, model: &ModelFile) -> Result<LogSettings, Error> {
    let table = value.as_table().ok_or_else(|| bad("logs", "should be [[logs]] tables"))?;
    let mut log =
        LogSettings { from: f64::NEG_INFINITY, until: f64::INFINITY, ..LogSettings::default() };
    for (key, value) in table {
        match key.as_str() {
            "file" => value
                .as_str()
                .ok_or_else(|| bad(key, "should be the name of a log"))?
                .clone_into(&mut log.file),
            "use" => match value.as_str() {
                Some("fit") => log.predict = false,
                Some("predict") => log.predict = true,
                _ => return Err(bad(key, "should be \"fit\" or \"predict\"")),
            },
            "from" => log.from = quantity(key, value, seconds)?,
            "until" => log.until = quantity(key, value, seconds)?,
            "steady" => {
                log.steady = value.as_bool().ok_or_else(|| bad(key, "should be true or false"))?;
            }
            "load" => {
                let name =
                    value.as_str().ok_or_else(|| bad(key, "should be the name of a load"))?;
                log.payloads = payloads(
                    key,
                    model.parse_load(&Source::new("load", name), &|_| {
                        Err("files cannot be read here".to_owned())
                    }),
                )?;
            }
            "payload" => {
                let mut load = Table::new();
                load.insert("payload".to_owned(), Value::Array(vec![value.clone()]));
                let text = toml::to_string(&load).map_err(|error| bad(key, error))?;
                let read = model.parse_load(&Source::new("payload", "payload.toml"), &|_| {
                    Ok(Contents::Whole(text.clone()))
                });
                log.payloads = payloads(key, read)?;
            }
            _ => return Err(unknown(key, &LOG_KEYS)),
        }
    }
    if log.file.is_empty() {
        return Err(bad("logs", "has a table without `file`, the name of the log"));
    }
    Ok(log)
}

fn payloads(key: &str, load: Result<LoadCase, Diagnostics>) -> Result<Vec<Payload>, Error> {
    let load = load.map_err(|out| bad(key, format!("is not understood:\n{out}")))?;
    if !load.wrenches.is_empty() {
        return Err(with_help(
            key,
            "has forces",
            "use a load that consists only of payloads, whose forces follow from the motion",
        ));
    }
    Ok(load.payloads)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests that the options of a log are found by the last components of its path, not by a part
    /// of a component.
    #[test]
    fn logs_are_named_by_the_end_of_their_path() {
        let named = |file: &str| LogSettings { file: file.to_owned(), ..LogSettings::default() };
        assert!(named("heavy/inverse.csv").is_at("./data/heavy/inverse.csv"));
        assert!(named("./inverse.csv").is_at("heavy/inverse.csv"));
        assert!(!named("heavy/inverse.csv").is_at("light/inverse.csv"));
        assert!(!named("verse.csv").is_at("inverse.csv"));
        assert!(!named("").is_at("inverse.csv"));
    }
}
