//! Tests of complete expressions.

use super::*;
use crate::expression::Measure;
use proptest::prelude::*;
use std::f64::consts::PI;

struct Names(Vec<(&'static str, Quantity)>);

impl Scope for Names {
    fn find(&self, name: &str) -> Option<usize> {
        self.0.iter().position(|(known, _)| *known == name)
    }
    fn value(&self, index: usize) -> Option<Quantity> {
        self.0.get(index).map(|(_, quantity)| *quantity)
    }
    fn names(&self) -> Vec<&str> {
        self.0.iter().map(|(name, _)| *name).collect()
    }
}

fn scope() -> Names {
    Names(vec![
        ("l1", Quantity { value: 0.2, dimension: Dimension::LENGTH }),
        ("n", Quantity { value: 3.0, dimension: Dimension::NONE }),
    ])
}

fn value(text: &str) -> Result<Quantity, Fault> {
    constant(&parse(text, &scope(), false)?, &scope())
}

/// Checks the values and dimensions of expressions. The values must agree with directly computed
/// numbers to two rounding errors.
#[test]
fn values() {
    let length = Dimension::LENGTH;
    let none = Dimension::NONE;
    for (text, expected, dimension) in [
        ("128.48 mm", 0.12848, length),
        ("1.42e4 kg mm^2", 0.0142, Dimension::of(2, 1, 0)),
        ("0.02 N s/m", 0.02, Dimension::of(0, 1, -1)),
        ("20 deg", 20.0 * (PI / 180.0), none),
        ("5 mm/rev", 0.005 / (2.0 * PI), length),
        ("-9.81 m/s^2", -9.81, Dimension::of(1, 0, -2)),
        ("2*l1 + 5 mm", 0.405, length),
        ("l1*cos(60 deg)", 0.2 * (60.0 * (PI / 180.0)).cos(), length),
        ("5 mm / 2 s", 0.0025, Dimension::of(1, 0, -1)),
        ("5 mm/s", 0.005, Dimension::of(1, 0, -1)),
        ("1/2*l1", 0.1, length),
        ("10 N/(m s)", 10.0, Dimension::of(0, 1, -3)),
        ("100 N*m", 100.0, Dimension::of(2, 1, -2)),
        ("12 %", 0.12, none),
        ("2^3^2", 512.0, none),
        ("-2^2", -4.0, none),
        ("2^-1", 0.5, none),
        ("--3", 3.0, none),
        ("+3 - -3", 6.0, none),
        ("(5 mm)^2", 0.005 * 0.005, Dimension::of(2, 0, 0)),
        ("sqrt(4 m^2)", 2.0, length),
        ("l1^0.5*l1^0.5", 0.2, length),
        ("60/min(2, 3)", 30.0, none),
        ("3 min", 180.0, Dimension::TIME),
        ("max(l1, 5 mm, 1 m)", 1.0, length),
        ("atan2(1 m, 1 m)", PI / 4.0, none),
        ("60 rpm", 2.0 * PI, Dimension::of(0, 0, -1)),
        ("2*e + pi", 2.0 * std::f64::consts::E + PI, none),
        ("smooth(0.5, 0, 1)", 0.5, none),
        (".5", 0.5, none),
        ("n*1 in", 0.0762, length),
    ] {
        let found = value(text).unwrap_or_else(|fault| panic!("{text}: {fault:?}"));
        let error = (found.value - expected).abs();
        assert!(error <= 2.0 * f64::EPSILON * expected.abs(), "{text}: {}", found.value);
        assert!(found.dimension.same(dimension), "{text}: {:?}", found.dimension);
    }
    // No rounding beyond that of the decimal number itself.
    assert_eq!(value("128.48 mm").unwrap().value, 0.12848);
    assert_eq!(value("25 um").unwrap().value, 25e-6);
}

#[test]
fn faults_have_their_place() {
    for (text, part) in [
        ("l1 + 5", "+"),
        ("2*(l1 - 3 kg)", "-"),
        ("sin(5 mm)", "5 mm"),
        ("l1 + ll", "ll"),
        ("5 mm + log(-1)", "log(-1)"),
        ("3 Nm", "Nm"),
        ("2^(1 m)", "1 m"),
        ("l1^n^0.3", "n^0.3"),
        ("(1 + 2", "("),
        ("1 + 2)", ")"),
        ("1e999", "1e999"),
        ("1e308 km", "1e308 km"),
        ("10^400", "10^400"),
        ("1/(n - 3)", "/"),
        ("5 m^1000", "m^1000"),
        ("t", "t"),
    ] {
        let fault = value(text).unwrap_err();
        assert_eq!(&text[fault.span.clone()], part, "{text}: {}", fault.message);
    }
}

#[test]
fn depth_is_limited_but_not_length() {
    let deep = format!("{}1{}", "(".repeat(1000), ")".repeat(1000));
    assert!(value(&deep).unwrap_err().message.contains("nested"));
    let tower = vec!["1"; 1000].join("^");
    assert!(value(&tower).unwrap_err().message.contains("nested"));
    let long = vec!["1"; 100_000].join("+");
    assert_eq!(value(&long).unwrap().value, 100_000.0);
    let signs = format!("{}1", "-".repeat(100_001));
    assert_eq!(value(&signs).unwrap().value, -1.0);
}

/// Compiles a formula of time whose value is dimensionless.
pub(super) fn formula(text: &str) -> Formula {
    match in_time(text, &scope(), Measure::Number) {
        Ok(TimeFormula::Changing(formula)) => formula,
        other => panic!("{text}: {other:?}"),
    }
}

/// Checks that `t` may be used as a number or as a time, with equal values.
#[test]
fn time_is_a_number_or_a_quantity() {
    let formula = |text: &str, measure| match in_time(text, &scope(), measure) {
        Ok(TimeFormula::Changing(formula)) => formula,
        other => panic!("{text}: {other:?}"),
    };
    let plain = formula("5 mm*sin(2*pi*t)", Measure::Length);
    let timed = formula("5 mm*sin(2*pi*1 Hz*t)", Measure::Length);
    let speed = formula("10 mm/s*t", Measure::Length);
    for t in [0.0, 0.1, 0.7] {
        assert_eq!(plain.at(t), timed.at(t));
        assert_eq!(speed.at(t).first, 0.01);
    }
    assert!(in_time("5 mm*t + 3 mm/s*t", &scope(), Measure::Length).is_err());
    assert!(in_time("5 kg*t", &scope(), Measure::Length).is_err());
    assert!(matches!(in_time("2*l1", &scope(), Measure::Length), Ok(TimeFormula::Constant(0.4))));
    // A constant subexpression is evaluated once: its derivatives are zero even at an infinite
    // slope.
    let rooted = formula("sqrt(0)*t + t^2", Measure::Number);
    assert_eq!(rooted.at(0.0).second, 2.0);
}

#[test]
fn quantities_match_measures() {
    let fits =
        |text: &str, measure: Measure| measure.complaint(value(text).unwrap().dimension).is_none();
    assert!(fits("5 mm", Measure::Length) && fits("5", Measure::Length));
    assert!(!fits("5 kg", Measure::Length) && !fits("5 deg", Measure::Length));
    assert!(
        fits("5 deg", Measure::Angle) && fits("5", Measure::Angle) && !fits("5 s", Measure::Angle)
    );
    assert!(fits("0.1", Measure::Number) && !fits("5 deg", Measure::Number));
    assert!(fits("5 mm/rev", Measure::Pitch) && fits("5 mm", Measure::Pitch));
    assert!(fits("3 J", Measure::Moment) && fits("l1*10 deg", Measure::Length));
}

/// Strategy for random expressions of smooth functions.
fn expression() -> impl Strategy<Value = String> {
    let leaf = prop_oneof![
        Just("t".to_owned()),
        (0.1..3.0f64).prop_map(|x| format!("{x:.3}")),
        Just("n".to_owned()),
    ];
    leaf.prop_recursive(4, 24, 2, |inner| {
        prop_oneof![
            (inner.clone(), prop::sample::select(vec!["+", "-", "*"]), inner.clone())
                .prop_map(|(a, op, b)| format!("({a} {op} {b})")),
            (prop::sample::select(vec!["sin", "cos", "tanh", "atan"]), inner.clone())
                .prop_map(|(f, a)| format!("{f}({a})")),
            (inner.clone(), inner.clone()).prop_map(|(a, b)| format!("{a}/(2 + cos({b}))")),
            inner.prop_map(|a| format!("sqrt(2 + sin({a}))^3")),
        ]
    })
}

proptest! {
    /// Checks that derivatives agree with central differences of the values, improved by
    /// Richardson's extrapolation.
    #[test]
    fn derivatives_of_expressions(text in expression(), t in 0.0..1.0f64) {
        let formula = match in_time(&text, &scope(), Measure::Number) {
            Ok(TimeFormula::Changing(formula)) => formula,
            Ok(TimeFormula::Constant(_)) => return Ok(()),
            Err(fault) => return Err(TestCaseError::fail(format!("{text}: {fault:?}"))),
        };
        let f = |t: f64| formula.at(t).value;
        let jet = formula.at(t);
        let first = |h: f64| (f(t + h) - f(t - h)) / (2.0 * h);
        let second = |h: f64| (f(t + h) - 2.0 * f(t) + f(t - h)) / (h * h);
        let (h, scale) = (1e-3, 1.0 + jet.value.abs() + jet.first.abs() + jet.second.abs());
        let extrapolated = |d: &dyn Fn(f64) -> f64| (4.0 * d(h / 2.0) - d(h)) / 3.0;
        // Truncation h^4 = 1e-12 times high derivatives of steep expressions; rounding 1e-16/h^2.
        prop_assume!(scale < 1e3);
        prop_assert!((jet.first - extrapolated(&first)).abs() < 1e-5 * scale, "{text}");
        prop_assert!((jet.second - extrapolated(&second)).abs() < 1e-3 * scale, "{text}");
    }

    #[test]
    fn no_text_makes_it_panic(text in "\\PC{0,40}") {
        let _ = value(&text);
        let _ = in_time(&text, &scope(), Measure::Length);
        let _ = unit_of(&text);
    }

    #[test]
    fn no_sequence_of_words_makes_it_panic(
        words in prop::collection::vec(prop::sample::select(vec![
            "1", "2.5", "1e300", "mm", "s", "deg", "min", "l1", "n", "t", "+", "-", "*", "/", "^",
            "(", ")", ",", "sin(", "max(", "smooth(", "%", "pi", "e", " ", "²", "N",
        ]), 0..20),
    ) {
        let text = words.concat();
        if let Ok(quantity) = value(&text) {
            prop_assert!(quantity.value.is_finite(), "{text}");
        }
        if let Ok(TimeFormula::Constant(value)) = in_time(&text, &scope(), Measure::Length) {
            prop_assert!(value.is_finite(), "{text}");
        }
    }
}

/// Checks that angles and numbers in percent are accepted only where such a quantity is meant, and
/// plain numbers everywhere.
#[test]
fn angles_and_percentages_are_no_dimensioned_quantities() {
    let is_accepted = |text: &str, measure: Measure| {
        let scope = scope();
        let constant = parse(text, &scope, false).and_then(|program| constant(&program, &scope));
        let in_time = in_time(text, &scope, measure).is_ok();
        let is_accepted = measure.complaint(constant.unwrap().dimension).is_none();
        assert_eq!(in_time, is_accepted, "{text} {measure:?}");
        is_accepted
    };
    for measure in [Measure::Time, Measure::Mass, Measure::Length, Measure::Frequency] {
        for text in ["50 %", "5 % + 6 %", "-(50 %)", "max(5 %, 6 %)", "20 deg"] {
            assert!(!is_accepted(text, measure), "{text} {measure:?}");
        }
        // In arithmetic, percentages are plain numbers.
        for text in ["2*50 %", "0.3*(1 + 5 %)", "80 %*0.3"] {
            assert!(is_accepted(text, measure), "{text} {measure:?}");
        }
        assert!(is_accepted("0.5", measure) && is_accepted("50 %/(10 %)", measure));
    }
    assert!(
        is_accepted("50 %*2 kg", Measure::Mass) && is_accepted("2 kg + 5 %*1 kg", Measure::Mass)
    );
    assert!(is_accepted("12 %", Measure::Number) && is_accepted("1 - 5 %", Measure::Number));
    assert!(!is_accepted("2 deg", Measure::Number));
    assert!(is_accepted("2 deg", Measure::Angle) && !is_accepted("50 %", Measure::Angle));
    assert!(is_accepted("50 %*2 deg", Measure::Angle) && is_accepted("0.1", Measure::Angle));
}
