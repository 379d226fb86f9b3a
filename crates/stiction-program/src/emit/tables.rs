//! Tables of the inputs and results of generated code, as lines of text for the comment at the
//! beginning of each file.

use super::names::{Labels, harmless};
use super::{Precision, SourceOptions};
use crate::feedforward::Feedforward;
use crate::tunable::Tunable;

/// Tunable parameters of one kind.
#[derive(Clone, Debug)]
pub(crate) struct Kind {
    /// Name of the field that contains these parameters in the generated code.
    pub(crate) field: &'static str,
    pub(crate) unit: &'static str,
    pub(crate) about: &'static str,
    /// Values in the model, each with the name of the friction interface or body and, for vectors,
    /// of the component.
    pub(crate) values: Vec<(String, f64)>,
}

/// Groups the tunable parameters of a program by kind, in the order of the program's inputs.
pub(crate) fn kinds(program: &Feedforward, labels: &Labels) -> Vec<Kind> {
    let mut kinds: Vec<Kind> = Vec::new();
    let name = |names: &[String], k: usize| names.get(k).map_or(String::new(), |n| harmless(n));
    for (tunable, values) in program.tunables() {
        let (field, unit, about, of) = match *tunable {
            Tunable::Mu(k) => {
                ("mu", "-", "coefficients of sliding friction", name(&labels.interfaces, k))
            }
            Tunable::Viscous(k) => {
                ("viscous", "N s/m", "viscous coefficients", name(&labels.interfaces, k))
            }
            Tunable::Mass(body) => ("mass", "kg", "masses", name(&labels.bodies, body.0)),
            Tunable::Payload(body) => (
                "payload",
                "kg, m, m, m",
                "point mass and its position in the frame of its body",
                name(&labels.bodies, body.0),
            ),
            Tunable::Wrench(body) => (
                "wrench",
                "N, N, N, N m, N m, N m",
                "force, and moment about the origin of the body, in world axes",
                name(&labels.bodies, body.0),
            ),
        };
        let axes = ["mass", "x", "y", "z"];
        let components = ["fx", "fy", "fz", "mx", "my", "mz"];
        let values = values.iter().enumerate().map(|(k, value)| match tunable {
            Tunable::Payload(_) => (format!("{of}, {}", axes[k]), *value),
            Tunable::Wrench(_) => (format!("{of}, {}", components[k]), *value),
            _ => (of.clone(), *value),
        });
        match kinds.iter_mut().find(|kind| kind.field == field) {
            Some(kind) => kind.values.extend(values),
            None => kinds.push(Kind { field, unit, about, values: values.collect() }),
        }
    }
    kinds
}

/// Returns lines of text that state the origin of the generated code, its inputs and results, and
/// the meaning of all indices.
pub(crate) fn lines(
    program: &Feedforward,
    labels: &Labels,
    options: &SourceOptions,
) -> Vec<String> {
    let mut lines = vec![
        format!("{}: inverse dynamics with joint friction for a control loop.", options.name),
        String::new(),
        format!(
            "Written by stiction {} from the model {}, fingerprint {:016x}.",
            harmless(&labels.version),
            harmless(&labels.model),
            program.fingerprint()
        ),
        "This code is yours: use, change and distribute it without any condition.".to_owned(),
        "It comes without any warranty.".to_owned(),
        String::new(),
    ];
    let precision = match options.precision {
        Precision::Double => "double",
        Precision::Float => "single",
    };
    lines.push(format!("Numbers are of {precision} precision, in SI units and radians."));
    let mut list = |title: &str, rows: Vec<String>| {
        lines.push(String::new());
        lines.push(title.to_owned());
        lines.extend(rows.into_iter().enumerate().map(|(k, row)| format!("  [{k}] {row}")));
    };
    let home = program.home();
    let coordinates = labels.coordinates.iter().zip(home);
    list(
        "Coordinates q with their units, and the home position, from which the first loop closure \
         starts:",
        coordinates
            .map(|((name, unit), at)| format!("{} [{unit}] {at:?}", harmless(name)))
            .collect(),
    );
    let efforts = labels.actuators.iter();
    list(
        "Actuator efforts tau with their units:",
        efforts.map(|(name, unit)| format!("{} [{unit}]", harmless(name))).collect(),
    );
    for Kind { field, unit, about, values } in kinds(program, labels) {
        list(
            &format!("Parameters {field} [{unit}]: {about}, with the values of the model:"),
            values.iter().map(|(name, value)| format!("{name} = {value:?}")).collect(),
        );
    }
    list("Joints:", labels.joints.iter().map(|name| harmless(name)).collect());
    if options.functions.kinematics {
        list("Bodies:", labels.bodies.iter().skip(1).map(|name| harmless(name)).collect());
    }
    lines
}
