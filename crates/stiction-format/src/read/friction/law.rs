//! Reads the friction laws of friction interfaces.

use super::layers::{Given, Layers, Notes};
use crate::diagnostic::Diagnostic;
use crate::expression::Measure;
use stiction_core::friction::{Bristles, Curve, Exponent, Law};

/// Reads the friction law that the tables of an interface define. `arm` is the sliding distance of
/// the surface in metres per radian of joint rotation, or `None` for a guide. Keys that contradict
/// each other are reported and ignored.
pub(super) fn read(layers: &Layers<'_>, arm: Option<f64>, notes: &mut Notes) -> Law {
    let given = |key| layers.given(key);
    let word = layers.word("law").unwrap_or_default();
    let has_state = matches!(word, "dahl" | "lugre");
    let (mu, viscous) = (layers.number("mu", notes), viscous_of("viscous", layers, arm, notes));
    let table = table_in_force(layers, notes);
    if table.is_none() && mu.is_none() && (viscous.is_none() || has_state) {
        if has_state {
            layers.missing(given("law"), "mu", ", which this law needs", notes);
        } else if let Some(record) = layers.records.first() {
            record.missing_both(["mu", "viscous"]);
        }
    }
    let mut law = Law::coulomb_viscous(mu.unwrap_or(0.0), viscous.unwrap_or(0.0));
    law.curve = match table {
        Some(table) => {
            law.mu = 0.0;
            curve_of_table(layers, word, table, notes)
        }
        None => curve_of_numbers(layers, word, &law, notes),
    };
    law.bristles = bristles(layers, (word, arm), &mut law.viscous, notes);
    law.regularisation = regularisation(layers, &law, notes);
    if has_state && mu.is_none() && table.is_none() {
        // The missing value has been reported; this keeps the builder from reporting it again.
        law.mu = 1.0;
    }
    law
}

/// Reads a viscous coefficient at the surface, N s/m. A data sheet's moment per angular rate, N m
/// s/rad, is divided by the square of `arm`: equation (L3) of the book.
fn viscous_of(
    key: &'static str,
    layers: &Layers<'_>,
    arm: Option<f64>,
    notes: &mut Notes,
) -> Option<f64> {
    let Given { record, value, .. } = layers.given(key)?;
    let measures = [Measure::Viscous, Measure::AngularDamping];
    let known = if arm.is_some() { &measures[..] } else { &measures[..1] };
    // An invalid value has been reported; continue with an arbitrary valid number.
    let (number, measure) =
        record.context.quantity_of(value, known).unwrap_or((1.0, Measure::Viscous));
    let number = match arm {
        Some(arm) if measure == Measure::AngularDamping => number / (arm * arm),
        _ => number,
    };
    notes.spans.numbers.push((key, number, value.span.clone()));
    Some(number)
}

/// Finds the table of friction coefficients that applies. Returns `None` if there is no such table,
/// or if `mu` in a more specific layer overrides it.
fn table_in_force<'a>(layers: &Layers<'a>, notes: &mut Notes) -> Option<Given<'a>> {
    let table = layers.given("table")?;
    let Some(mu) = layers.given("mu") else { return Some(table) };
    if mu.layer == table.layer {
        let help = "delete `mu`, or the table";
        layers.conflict(mu, "mu", "the table defines all coefficients", help, notes);
    }
    (table.layer <= mu.layer).then_some(table)
}

fn curve_of_table(layers: &Layers<'_>, word: &str, table: Given<'_>, notes: &mut Notes) -> Curve {
    const WHY: &str =
        "the table defines the coefficient at all speeds; its first row is the coefficient at rest";
    let nearer = |key| layers.given(key).filter(|given| given.layer <= table.layer);
    for key in ["mu_static", "stribeck_velocity", "stribeck_exponent"] {
        if let Some(given) = nearer(key) {
            layers.conflict(given, key, WHY, &format!("delete `{key}`, or the table"), notes);
        }
    }
    if let ("coulomb" | "stribeck" | "exponential" | "dahl", Some(given)) = (word, nearer("law")) {
        layers.conflict(given, "law", WHY, "delete `law`, or the table", notes);
    }
    rows(table).map_or(Curve::Constant, Curve::Table)
}

/// Reads the rows of a table: sliding speed, m/s, and friction coefficient. The speeds must begin
/// at 0 and increase; the first invalid row is reported.
fn rows(table: Given<'_>) -> Option<Vec<[f64; 2]>> {
    let rows = table.record.pairs("table")?;
    let context = table.record.context;
    let wrong = |span, message: &str, label: &str| {
        context.push(
            Diagnostic::error("friction", message)
                .at(context.place(span), label)
                .help("for example `table = [[0, 0.2], [\"5 mm/s\", 0.15], [\"0.1 m/s\", 0.12]]`"),
        );
    };
    if rows.len() < 2 {
        wrong(&table.value.span, "a table of coefficients needs at least two rows", "too short");
        return None;
    }
    let mut before = None;
    for ([speed, coefficient], span) in &rows {
        let (message, label) = match before {
            None if *speed != 0.0 => ("a table of coefficients must begin at the speed 0", "not 0"),
            Some(before) if *speed <= before => (
                "the speeds in a table of coefficients must increase",
                "not greater than the speed in the row above",
            ),
            _ if *coefficient < 0.0 => ("a friction coefficient must be at least 0", "negative"),
            _ => {
                before = Some(*speed);
                continue;
            }
        };
        wrong(span, message, label);
        return None;
    }
    Some(rows.into_iter().map(|(row, _)| row).collect())
}

fn curve_of_numbers(layers: &Layers<'_>, word: &str, law: &Law, notes: &mut Notes) -> Curve {
    let given = |key| layers.given(key);
    let refuse = |keys: &[&'static str], why: &str, help: &str, notes: &mut Notes| {
        for key in keys.iter().copied() {
            if let Some(given) = given(key) {
                layers.conflict(given, key, why, help, notes);
            }
        }
    };
    match word {
        "coulomb" => {
            let why = "Coulomb's coefficient does not change with the sliding speed";
            let help = "delete the key, or write `law = \"stribeck\"`";
            refuse(&["stribeck_velocity", "stribeck_exponent"], why, help, notes);
        }
        "dahl" => {
            let why = "Dahl's law has one coefficient";
            let help = "delete the key, or write `law = \"lugre\"`";
            let keys = ["mu_static", "stribeck_velocity", "stribeck_exponent"];
            refuse(&keys, why, help, notes);
            return Curve::Constant;
        }
        "exponential" => {
            let why = "the exponential law is Stribeck's law with the exponent 1";
            let help = "delete the key, or write `law = \"stribeck\"`";
            refuse(&["stribeck_exponent"], why, help, notes);
        }
        _ => {}
    }
    let mu_static = layers.number("mu_static", notes);
    let shaped = given("stribeck_velocity").or_else(|| given("stribeck_exponent"));
    let by_word = matches!(word, "stribeck" | "exponential");
    let changes = word != "coulomb"
        && (by_word || shaped.is_some() || (word == "lugre" && mu_static.is_some()));
    if mu_static.is_some() && given("mu").is_none() {
        layers.missing(given("mu_static"), "mu", ", though it has a `mu_static`", notes);
    }
    if !changes {
        return mu_static.map_or(Curve::Constant, |mu_static| Curve::Static { mu_static });
    }
    let velocity = layers.number("stribeck_velocity", notes);
    let beside = shaped.or_else(|| given("law"));
    if velocity.is_none() {
        layers.missing(beside, "stribeck_velocity", ", which a Stribeck curve needs", notes);
    }
    if mu_static.is_none() {
        layers.missing(beside, "mu_static", ", which a Stribeck curve needs", notes);
    }
    let exponent = match word {
        "exponential" => 1.0,
        _ => layers.number("stribeck_exponent", notes).unwrap_or(2.0),
    };
    Curve::Stribeck {
        mu_static: mu_static.unwrap_or(law.mu),
        velocity: velocity.unwrap_or(1.0),
        exponent: Exponent::new(exponent),
    }
}

/// Reads the bristle parameters of the Dahl and LuGre laws; returns `None` for a law without an
/// internal state. In the LuGre model, the viscous coefficient may also be called `sigma2`.
fn bristles(
    layers: &Layers<'_>,
    (word, arm): (&str, Option<f64>),
    viscous: &mut f64,
    notes: &mut Notes,
) -> Option<Bristles> {
    let given = |key| layers.given(key);
    let refused: &[&'static str] = match word {
        "lugre" => &[],
        "dahl" => &["sigma1", "sigma2"],
        _ => &["sigma0", "sigma1", "sigma2"],
    };
    for key in refused.iter().copied() {
        if let Some(given) = given(key) {
            let (why, help) = match word {
                "dahl" => ("Dahl's law has only `sigma0`", "write `law = \"lugre\"`, or `viscous`"),
                _ => (
                    "only the laws `dahl` and `lugre` have bristles",
                    "write `law = \"lugre\"`, or delete it",
                ),
            };
            layers.conflict(given, key, why, help, notes);
        }
    }
    if !matches!(word, "dahl" | "lugre") {
        return None;
    }
    if word == "lugre" {
        if let (Some(sigma2), Some(_)) = (given("sigma2"), given("viscous")) {
            let help = "keep one of them";
            layers.conflict(sigma2, "sigma2", "`viscous` gives the same coefficient", help, notes);
        } else if let Some(sigma2) = viscous_of("sigma2", layers, arm, notes) {
            *viscous = sigma2;
        }
    }
    let law = given("law");
    let mut needed = |key| {
        let number = layers.number(key, notes);
        if number.is_none() {
            layers.missing(law, key, ", which this law needs", notes);
        }
        number.unwrap_or(1.0)
    };
    let stiffness = needed("sigma0");
    let damping = if word == "lugre" { needed("sigma1") } else { 0.0 };
    Some(Bristles { stiffness, damping })
}

fn regularisation(layers: &Layers<'_>, law: &Law, notes: &mut Notes) -> Option<f64> {
    let (regularised, velocity) =
        (layers.given("regularised"), layers.given("regularisation_velocity"));
    match (regularised, velocity) {
        (None, None) => return None,
        (None, Some(velocity)) => {
            let (why, help) = ("the friction is not regularised", "add `regularised = \"tanh\"`");
            layers.conflict(velocity, "regularisation_velocity", why, help, notes);
            return None;
        }
        (Some(regularised), None) => {
            let why = ", which `regularised` needs";
            layers.missing(Some(regularised), "regularisation_velocity", why, notes);
            return None;
        }
        (Some(regularised), Some(_)) => {
            let (why, help) = match law.curve {
                _ if law.bristles.is_some() => (
                    "the laws `dahl` and `lugre` cannot be regularised",
                    "delete `regularised`, or choose another `law`",
                ),
                Curve::Static { .. } => (
                    "regularised friction has no static coefficient",
                    "delete `regularised` or `mu_static`",
                ),
                _ => {
                    layers.word("regularised");
                    return layers.number("regularisation_velocity", notes);
                }
            };
            layers.conflict(regularised, "regularised", why, help, notes);
        }
    }
    None
}
