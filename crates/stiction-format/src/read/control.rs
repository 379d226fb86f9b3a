//! Reads controllers of the actuators.

use super::actuators::Actuators;
use super::context::{Context, Record};
use super::path::{Leaf, leaves};
use crate::diagnostic::{Diagnostic, Diagnostics, did_you_mean, number, quoted};
use crate::document::{Table, Value};
use crate::expression::Measure;
use crate::fields::tables::{CHANNEL, CONTROL};
use crate::model_file::{Channel, Control, ControlType, FrictionFeed};
use crate::source::{Place, Source};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Names of the controllers that need no further settings.
const DEFAULTS: [&str; 3] = ["pd", "computed-torque", "computed-torque+friction"];
/// Default sampling period, s.
const PERIOD: f64 = 1e-3;
/// Default damping ratio of the closed loop without friction.
const DAMPING: f64 = 1.0;

/// Returns the controller of this name with default settings; `None` for an unknown name.
pub(super) fn usual(name: &str, actuators: &Actuators) -> Option<Control> {
    let (control, friction) = match name {
        "pd" => (ControlType::Pd, FrictionFeed::Off),
        "pid" => (ControlType::Pid, FrictionFeed::Off),
        "computed-torque" => (ControlType::ComputedTorque, FrictionFeed::Off),
        "computed-torque+friction" => (ControlType::ComputedTorque, FrictionFeed::Reference),
        _ => return None,
    };
    Some(Control {
        title: String::new(),
        control,
        friction,
        period: PERIOD,
        bandwidth: None,
        damping: DAMPING,
        differences: false,
        channels: vec![Channel::NONE; actuators.len()],
        named: Vec::new(),
    })
}

/// Creates the diagnostic for an unknown name of a controller.
pub(super) fn unknown(source: &Arc<Source>, name: &str) -> Diagnostics {
    let place = Place::new(source, 0..source.text.len());
    Diagnostic::error("unknown-name", format!("there is no controller {}", quoted(name)))
        .at(place, "unknown controller")
        .maybe_help(did_you_mean(
            name,
            "give a TOML file, assignments, or one of these controllers",
            DEFAULTS,
        ))
        .into()
}

/// Reads a controller; `None` if it is invalid.
pub(crate) fn read(context: &Context<'_>, actuators: &Actuators, table: &Table) -> Option<Control> {
    let record = Record::open(context, table, CONTROL, "a controller");
    let word = |key: &str| record.value(key).and_then(|_| record.choice(key));
    if record.value("type").is_none() {
        record.missing("type", "");
    }
    let kind = word("type")?;
    let usual = usual(kind, actuators)?;
    let friction = match word("friction") {
        Some("reference") => FrictionFeed::Reference,
        Some("measured") => FrictionFeed::Measured,
        _ => FrictionFeed::Off,
    };
    let positive = |key: &str, otherwise: f64, zero: bool| match record.value(key) {
        None => Some(otherwise),
        Some(value) => record.quantity(key).filter(|x| in_range(context, key, value, *x, zero)),
    };
    let period = positive("period", usual.period, true)?;
    let bandwidth = match record.value("bandwidth") {
        None => None,
        Some(_) => Some(TAU * positive("bandwidth", 0.0, false)?),
    };
    let damping = positive("damping", usual.damping, true)?;
    let mut channels = usual.channels;
    let errors = || context.out.borrow().len();
    let at_first = errors();
    for key in CHANNEL {
        let Some(value) = record.value(key) else { continue };
        // An error in a value for all actuators is reported only once.
        let before = errors();
        for (actuator, channel) in channels.iter_mut().enumerate() {
            if errors() == before {
                set(context, actuators, (actuator, channel), key, value);
            }
        }
    }
    let mut named = Vec::new();
    for leaf in &leaves(table, CONTROL) {
        named.extend(own(context, actuators, leaf, &mut channels));
    }
    // Combinations of settings are judged only if all settings of the actuators are known.
    let are_known = errors() == at_first;
    let control = usual.control;
    let gains =
        |c: &Channel| c.proportional.is_some() || c.derivative.is_some() || c.integral.is_some();
    let complain = |message: &str, help: &str, key: &str| {
        context.push(
            Diagnostic::error("controller", message)
                .at(context.place(&record.span(key)), "for this type")
                .help(help),
        );
    };
    if control == ControlType::ComputedTorque && channels.iter().any(gains) {
        complain(
            "computed torque has no gains for individual actuators",
            "give its `bandwidth` and `damping`",
            "type",
        );
    }
    if are_known && control == ControlType::Pid && channels.iter().all(|c| c.integral.is_none()) {
        complain(
            "a PID controller needs an integral gain",
            "give `ki`, for example `ki = \"2 kN/(m s)\"`, or use `type = \"pd\"`",
            "type",
        );
    }
    if control == ControlType::Pd && channels.iter().any(|c| c.integral.is_some()) {
        complain("a PD controller has no integral gain", "use `type = \"pid\"`", "type");
    }
    let integrates = |c: &Channel| c.integral.is_some_and(|gain| gain > 0.0);
    if are_known
        && control == ControlType::Pid
        && channels.iter().any(|c| {
            integrates(c)
                && c.limit.is_finite()
                && c.proportional == Some(0.0)
                && c.tracking.is_none()
        })
    {
        complain(
            "with `kp = 0` the default of `tracking`, kp/ki, is zero",
            "give the time constant `tracking`, for example `tracking = \"0.1 s\"`",
            "kp",
        );
    }
    if are_known && channels.iter().any(|c| c.tracking.is_some() && !c.limit.is_finite()) {
        complain(
            "`tracking` has no effect without a `limit`",
            "give the largest effort as `limit`, or leave `tracking` out",
            "tracking",
        );
    }
    if period == 0.0 && control == ControlType::ComputedTorque {
        complain(
            "computed torque needs a sampling period",
            "give a short `period`, for example `period = \"0.1 ms\"`",
            "period",
        );
    }
    if control != ControlType::ComputedTorque && friction != FrictionFeed::Off {
        complain(
            "a PD or PID controller does not compensate friction",
            "use `type = \"computed-torque\"`, or add the efforts of inverse dynamics: --drives inverse",
            "type",
        );
    }
    let differences = match word("rate") {
        Some(word) => word == "difference",
        None => channels.iter().any(|channel| channel.resolution > 0.0),
    };
    if period == 0.0 && differences {
        complain(
            "rates from differences of positions, and a `resolution`, need a sampling period",
            "give a `period`, for example `period = \"1 ms\"`",
            "period",
        );
    }
    let title = record.line("title");
    Some(Control {
        title,
        control,
        friction,
        period,
        bandwidth,
        damping,
        differences,
        channels,
        named,
    })
}

/// Reads one setting of an actuator, such as `leg1.P.kp`, into the actuator's channel; returns the
/// index of the actuator.
fn own(
    context: &Context<'_>,
    actuators: &Actuators,
    leaf: &Leaf<'_>,
    channels: &mut [Channel],
) -> Option<usize> {
    let (name, key) = leaf.path.rsplit_once('.').unwrap_or((leaf.path.as_str(), ""));
    let known = actuators.find(name);
    let known_key = CHANNEL.iter().find(|known| **known == key);
    match (known, known_key, leaf.value) {
        (Some(actuator), Some(key), Some(value)) => {
            if let Some(channel) = channels.get_mut(actuator) {
                set(context, actuators, (actuator, channel), key, value);
            }
        }
        (Some(_), None, _) => context.push(
            Diagnostic::error("unknown-key", format!("an actuator has no key {}", quoted(key)))
                .at(context.place(&leaf.key), "unknown key")
                .maybe_help(did_you_mean(key, "known keys", CHANNEL.iter().copied())),
        ),
        (None, ..) if actuators.find(&leaf.path).is_some() => context.push(
            Diagnostic::error(
                "wrong-type",
                format!("the setting of {} is missing", quoted(&leaf.path)),
            )
            .at(context.place(&leaf.key), "an actuator")
            .help(format!("for example `{}.limit = 300 N`", leaf.path)),
        ),
        (None, None, _) if !leaf.path.contains('.') => {
            let keys = CONTROL.iter().map(|field| field.key).chain(actuators.names());
            let message = format!("a controller has no key {}", quoted(&leaf.path));
            context.push(
                Diagnostic::error("unknown-key", message)
                    .at(context.place(&leaf.key), "unknown key")
                    .maybe_help(did_you_mean(&leaf.path, "known keys", keys)),
            );
        }
        (None, ..) => actuators.report(context, name, &leaf.owner),
        (Some(_), Some(_), None) => {}
    }
    known.filter(|_| known_key.is_some())
}

fn set(
    context: &Context<'_>,
    actuators: &Actuators,
    (actuator, channel): (usize, &mut Channel),
    key: &str,
    value: &Value,
) {
    let (linear, angular) = match key {
        "kp" => (Measure::Stiffness, Measure::AngularStiffness),
        "kd" => (Measure::Damping, Measure::AngularDamping),
        "ki" => (Measure::IntegralGain, Measure::AngularIntegralGain),
        "tracking" => (Measure::Time, Measure::Time),
        "resolution" => (Measure::Length, Measure::Angle),
        _ => (Measure::Force, Measure::Moment),
    };
    let given = context.quantity(value, actuators.measure(actuator, linear, angular));
    let Some(given) =
        given.filter(|x| in_range(context, key, value, *x, !matches!(key, "limit" | "tracking")))
    else {
        return;
    };
    match key {
        "kp" => channel.proportional = Some(given),
        "kd" => channel.derivative = Some(given),
        "ki" => channel.integral = Some(given),
        "tracking" => channel.tracking = Some(given),
        "resolution" => channel.resolution = given,
        _ => channel.limit = given,
    }
}

/// Checks that the number `x` under `key` is positive, or zero if `zero` is true; reports other
/// numbers.
fn in_range(context: &Context<'_>, key: &str, value: &Value, x: f64, zero: bool) -> bool {
    let fine = x > 0.0 || (zero && x == 0.0);
    if !fine {
        let expected = if zero { "not be negative" } else { "be greater than 0" };
        let message = format!("`{key}` is {}, but must {expected}", number(x));
        context.push(
            Diagnostic::error("range", message).at(context.place(&value.span), "out of range"),
        );
    }
    fine
}
