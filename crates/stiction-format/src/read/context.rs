//! Reads single values of a model file, such as quantities and vectors, and reports errors in them.

use crate::diagnostic::{Diagnostic, Diagnostics, did_you_mean, nearest, or, quoted};
use crate::document::{Node, Table, Text, Value};
use crate::expression::Measure;
use crate::expression::{self, Dimension, Fault, TimeFormula};
use crate::fields::tables::MODEL;
use crate::fields::{self, Field, Shape};
use crate::parameters::Parameters;
use crate::signal::Signal;
use crate::source::{Place, Source, Span};
use std::cell::RefCell;
use std::sync::Arc;
use stiction_core::spatial::Vec3;

/// Greatest accepted magnitude of a number in SI units; products of several such numbers remain
/// finite.
pub(crate) const LARGEST: f64 = 1e30;
/// Lengths below this, m, are set to zero as rounding errors.
const SHORTEST: f64 = 1e-30;
/// Magnitude below which all quantities except lengths are set to zero, because their squares would
/// underflow.
const SMALLEST: f64 = 1e-150;

/// Text of a model with its parameters, and the diagnostics collected while the text is read.
pub(crate) struct Context<'a> {
    pub(crate) source: Arc<Source>,
    pub(crate) parameters: &'a Parameters,
    /// Ranges of the text with syntax errors, sorted by start. No further messages are reported for
    /// these ranges.
    pub(crate) broken: &'a [Span],
    pub(crate) out: RefCell<Diagnostics>,
}

impl<'a> Context<'a> {
    pub(crate) fn new(
        source: &Arc<Source>,
        parameters: &'a Parameters,
        broken: &'a [Span],
    ) -> Self {
        let out = RefCell::new(Diagnostics::new());
        Self { source: Arc::clone(source), parameters, broken, out }
    }

    pub(crate) fn place(&self, span: &Span) -> Place {
        Place::new(&self.source, span.clone())
    }

    pub(crate) fn push(&self, diagnostic: Diagnostic) {
        let is_broken = |place: &Place| {
            let at = place.span.start;
            // A value without its closing quote or bracket can begin in a broken range and end far
            // below.
            let candidates = self.broken.partition_point(|part| part.start <= at);
            let mut before = self.broken.iter().take(candidates).rev().take(20);
            Arc::ptr_eq(&place.source, &self.source) && before.any(|part| at <= part.end)
        };
        if diagnostic.place.as_ref().is_some_and(is_broken) {
            return;
        }
        self.out.borrow_mut().push(diagnostic);
    }

    /// Reports a missing part, unless the text has syntax errors that may hide it.
    pub(crate) fn push_missing(&self, diagnostic: Diagnostic) {
        if self.broken.is_empty() {
            self.push(diagnostic);
        }
    }

    /// Tests if the list of messages is full; suggestions, which take time, are then omitted.
    pub(crate) fn is_full(&self) -> bool {
        self.out.borrow().is_full()
    }

    /// Reports a value of the wrong type; `expected` describes the expected value in the message.
    pub(crate) fn wrong(&self, value: &Value, expected: &str) {
        let found = value.describe();
        self.push(
            Diagnostic::error("wrong-type", format!("expected {expected}, found {found}"))
                .at(self.place(&value.span), format!("this is {found}")),
        );
    }

    /// Reports an unknown name of a part, which `kind` and the plural `kinds` describe, and
    /// suggests a similar name among `known`.
    pub(crate) fn unknown_name<'n>(
        &self,
        span: &Span,
        kind: &str,
        kinds: &str,
        name: &str,
        known: impl IntoIterator<Item = &'n str>,
    ) {
        if !self.broken.is_empty() {
            return;
        }
        if self.is_full() {
            return self.out.borrow_mut().add_omitted_errors(1);
        }
        self.push_missing(
            Diagnostic::error("unknown-name", format!("there is no {kind} {}", quoted(name)))
                .at(self.place(span), format!("unknown {kind}"))
                .help(
                    did_you_mean(name, kinds, known)
                        .unwrap_or_else(|| format!("the model has no {kinds}")),
                ),
        );
    }

    /// Reports an error in an expression.
    pub(crate) fn fault(&self, value: &Span, text: &Text, fault: Fault) {
        if fault.echo {
            return;
        }
        let span = text.place_of(value, &fault.span);
        self.push(
            Diagnostic::error(fault.code, fault.message)
                .at(self.place(&span), fault.label)
                .maybe_help(fault.help),
        );
    }

    /// Reads a number or an expression; returns its value in SI units.
    pub(crate) fn quantity(&self, value: &Value, measure: Measure) -> Option<f64> {
        self.quantity_of(value, &[measure]).map(|(number, _)| number)
    }

    /// Reads a number or an expression that may be one of several measures, such as a length or an
    /// angle. Bare numbers and error messages refer to the first measure. Returns the value in SI
    /// units and its measure.
    pub(crate) fn quantity_of(
        &self,
        value: &Value,
        measures: &[Measure],
    ) -> Option<(f64, Measure)> {
        let measure = *measures.first()?;
        match &value.node {
            Node::Number(number) => {
                let number = self.finite(value, *number, measure)?;
                self.doubt(value, measure, number, true);
                Some((number, measure))
            }
            Node::Text(_) if self.is_full() => None,
            Node::Text(text) => {
                let read = || {
                    let program = expression::parse(&text.content, self.parameters, false)?;
                    let quantity = expression::constant(&program, self.parameters)?;
                    let fits = |m: &&Measure| m.complaint(quantity.dimension).is_none();
                    let measure = *measures.iter().find(fits).unwrap_or(&measure);
                    match measure.complaint(quantity.dimension) {
                        None => {
                            let bare = quantity.dimension == Dimension::NONE;
                            self.doubt(value, measure, quantity.value, bare);
                            // Leads are stored per revolution; a lead per radian is converted.
                            let per_angle =
                                measure == Measure::Lead && quantity.dimension.has_angle();
                            let turn = if per_angle { std::f64::consts::TAU } else { 1.0 };
                            let number = self.finite(value, quantity.value * turn, measure);
                            Ok(number.map(|number| (number, measure)))
                        }
                        Some(fault) => Err(fault(0..text.content.len())),
                    }
                };
                let read = read().map_err(|fault| fault.with_unit_of(measure, &text.content));
                read.map_err(|fault| self.fault(&value.span, text, fault)).ok().flatten()
            }
            _ => {
                self.wrong(value, &measure.expected());
                None
            }
        }
    }

    /// Reads a number or an expression in which `t` is the time.
    pub(crate) fn signal(&self, value: &Value, measure: Measure) -> Option<Signal> {
        let Node::Text(text) = &value.node else {
            return self.quantity(value, measure).map(Signal::constant);
        };
        if self.is_full() {
            return None;
        }
        match expression::in_time(&text.content, self.parameters, measure) {
            Ok(TimeFormula::Constant(number)) => {
                self.finite(value, number, measure).map(Signal::constant)
            }
            Ok(TimeFormula::Changing(formula)) => {
                self.doubt_degrees(value, text);
                Some(Signal::formula(formula, &self.source, value.span.clone(), text.start))
            }
            Err(fault) => {
                self.fault(&value.span, text, fault);
                None
            }
        }
    }

    /// Warns about `sin` or `cos` of the time multiplied by a bare multiple of 90, which is
    /// probably meant in degrees.
    fn doubt_degrees(&self, value: &Value, text: &Text) {
        let content = text.content.replace(' ', "");
        for function in ["sin(", "cos("] {
            for (at, _) in content.match_indices(function) {
                let rest = content.get(at + function.len()..).unwrap_or_default();
                let digits = rest.split(|c: char| !c.is_ascii_digit()).next().unwrap_or_default();
                let number: u32 = digits.parse().unwrap_or(0);
                let then = rest.get(digits.len()..).unwrap_or_default();
                let is_time = ["*t)", "*t+", "*t-", "*t/(1s)", "*t/1s"]
                    .iter()
                    .any(|end| then.starts_with(end));
                if is_time && number > 0 && number.is_multiple_of(90) {
                    let turns = f64::from(number) / std::f64::consts::TAU;
                    self.push(
                        Diagnostic::warning("angle", format!("{function}{number}*t) means {number} \
                            rad/s, {turns:.1} turns per second"))
                            .at(self.place(&value.span), "angles without a unit are in rad")
                            .help(format!("write {function}{number} deg*t) for degrees per second, or {function}{number} rad*t)")),
                    );
                }
            }
        }
    }

    /// Warns about a bare number that is probably in degrees.
    fn doubt(&self, value: &Value, measure: Measure, number: f64, bare: bool) {
        if measure != Measure::Angle || !bare || number.abs() <= std::f64::consts::TAU {
            return;
        }
        let (shown, turns) = (crate::diagnostic::number(number), number / std::f64::consts::TAU);
        let message = format!("the angle {shown} rad is {turns:.1} turns");
        self.push(
            Diagnostic::warning("angle", message)
                .at(self.place(&value.span), "angles without a unit are in rad")
                .help(format!(
                    "write \"{shown} deg\" for degrees, or \"{shown} rad\" if radians are intended"
                )),
        );
    }

    /// Rejects numbers that are not finite or too large, and replaces numbers of negligible
    /// magnitude by zero.
    fn finite(&self, value: &Value, number: f64, measure: Measure) -> Option<f64> {
        if number.abs() <= LARGEST {
            let smallest = match measure {
                // A parameter may be an arbitrarily small factor.
                Measure::Any => 0.0,
                Measure::Length => SHORTEST,
                _ => SMALLEST,
            };
            return Some(if number.abs() < smallest { 0.0 } else { number });
        }
        if number.is_finite() {
            let message = format!("{} is too large", crate::diagnostic::number(number));
            self.push(
                Diagnostic::error("range", message)
                    .at(self.place(&value.span), "too large")
                    .help(format!("the maximum magnitude in SI units is {LARGEST:e}")),
            );
            return None;
        }
        let what = if number.is_nan() { "`nan`" } else { "infinity" };
        self.push(
            Diagnostic::error("not-finite", format!("{what} is not a finite number"))
                .at(self.place(&value.span), "expected a finite number"),
        );
        None
    }

    /// Reads a list of three items; `each` is the plural noun for the items in messages.
    pub(crate) fn three<'v>(&self, value: &'v Value, each: &str) -> Option<[&'v Value; 3]> {
        if let Some([x, y, z]) = value.as_list() {
            return Some([x, y, z]);
        }
        match value.as_list() {
            Some(list) => {
                let count = list.len();
                let message = format!("expected a list of 3 {each}, found {count}");
                let comma = (count > 3).then(|| "write decimals with a point: 0.5".to_owned());
                self.push(
                    Diagnostic::error("wrong-type", message)
                        .at(self.place(&value.span), "expected [x, y, z]")
                        .maybe_help(comma),
                );
            }
            None => self.wrong(value, &format!("a list [x, y, z] of 3 {each}")),
        }
        None
    }

    /// Reads a list of three quantities of the same measure, in SI units.
    pub(crate) fn vector(&self, value: &Value, measure: Measure) -> Option<Vec3<f64>> {
        let each = format!("{}s", plural_stem(measure));
        let components = self.three(value, &each)?.map(|item| self.quantity(item, measure));
        match components {
            [Some(x), Some(y), Some(z)] => Some(Vec3::new(x, y, z)),
            _ => None,
        }
    }

    /// Reads a string; `what` describes the expected string in messages.
    pub(crate) fn text<'v>(&self, value: &'v Value, what: &str) -> Option<&'v str> {
        let text = value.as_text();
        if text.is_none() {
            self.wrong(value, what);
        }
        text
    }

    /// Reads a string that must be one of several words.
    pub(crate) fn choice(
        &self,
        value: &Value,
        words: &'static [&'static str],
    ) -> Option<&'static str> {
        let all: Vec<_> = words.iter().map(|word| format!("{word:?}")).collect();
        let text = self.text(value, &or(&all))?;
        let found = words.iter().copied().find(|word| *word == text);
        if found.is_none() {
            self.push(
                Diagnostic::error("unknown-name", format!("{} is not understood", quoted(text)))
                    .at(self.place(&value.span), "not understood")
                    .maybe_help(did_you_mean(text, "expected one of", words.iter().copied())),
            );
        }
        found
    }
}

/// Returns advice for a top-level key in the wrong place: in TOML, a key belongs to the nearest
/// `[table]` above it. Returns `None` for other keys.
pub(crate) fn of_the_top(key: &str) -> Option<String> {
    fields::find(MODEL, key)?;
    Some(format!("`{key}` belongs to the whole model: put it above the first [table]"))
}

/// Returns the noun for a measure without its article, to which a plural `s` can be appended:
/// `length` for `a length`.
fn plural_stem(measure: Measure) -> &'static str {
    match measure {
        Measure::Inertia => "moment",
        _ => measure.words().noun.trim_start_matches("an ").trim_start_matches("a "),
    }
}

/// A table of the model file with the list of keys that it may contain.
pub(crate) struct Record<'a> {
    pub(crate) context: &'a Context<'a>,
    pub(crate) table: &'a Table,
    fields: &'static [Field],
    /// Description of the table in messages, such as "body `bob`".
    what: String,
}

impl<'a> Record<'a> {
    /// Opens a table that permits only the keys of `fields`; reports unknown and missing keys.
    pub(crate) fn new(
        context: &'a Context<'a>,
        table: &'a Table,
        fields: &'static [Field],
        what: impl Into<String>,
    ) -> Self {
        let record = Self { context, table, fields, what: what.into() };
        let mut meant = Vec::new();
        for (key, _) in &table.entries {
            if fields::find(fields, &key.name).is_none() {
                record.unknown_key(&key.name, &key.span);
                meant.extend(nearest(&key.name, fields.iter().map(|field| field.key)));
            }
        }
        for field in fields.iter().filter(|field| field.required) {
            // A required key is not reported as missing if it was only misspelt.
            if table.get(field.key).is_none() && !meant.contains(&field.key) {
                record.missing(field.key, "");
            }
        }
        record
    }

    /// Opens a table that permits names besides the keys of `fields`.
    pub(crate) fn open(
        context: &'a Context<'a>,
        table: &'a Table,
        fields: &'static [Field],
        what: impl Into<String>,
    ) -> Self {
        Self { context, table, fields, what: what.into() }
    }

    fn unknown_key(&self, name: &str, span: &Span) {
        if self.context.is_full() {
            return self.context.out.borrow_mut().add_omitted_errors(1);
        }
        let known = self.fields.iter().map(|field| field.key);
        let message = format!("{} has no key {}", self.what, quoted(name));
        let help = of_the_top(name).or_else(|| did_you_mean(name, "known keys", known));
        self.context.push(
            Diagnostic::error("unknown-key", message)
                .at(self.context.place(span), "unknown key")
                .maybe_help(help),
        );
    }

    /// Reports a missing key; `why` is the end of the message, with the condition that requires the
    /// key.
    pub(crate) fn missing(&self, key: &str, why: &str) {
        let doc = fields::find(self.fields, key).map_or("", |field| field.summary());
        let message = format!("{} has no `{key}`{why}", self.what);
        self.context.push_missing(
            Diagnostic::error("missing-key", message)
                .at(self.context.place(&self.table.span), format!("`{key}` is missing"))
                .help(format!("`{key}`: {doc}")),
        );
    }

    /// Reports that at least one of two keys is required.
    pub(crate) fn missing_both(&self, keys: [&str; 2]) {
        let [first, second] = keys;
        let message = format!("{} has neither `{first}` nor `{second}`", self.what);
        self.context.push_missing(
            Diagnostic::error("missing-key", message)
                .at(self.context.place(&self.table.span), "one of them is needed"),
        );
    }

    /// Returns the value of a key; `None` if the key is missing.
    pub(crate) fn value(&self, key: &str) -> Option<&'a Value> {
        debug_assert!(fields::find(self.fields, key).is_some(), "no field {key}");
        self.table.get(key)
    }

    /// Tests if the table may contain this key.
    pub(crate) fn knows(&self, key: &str) -> bool {
        fields::find(self.fields, key).is_some()
    }

    /// Returns the place of a key's value, or the place of the table if the key is missing.
    pub(crate) fn span(&self, key: &str) -> Span {
        self.table.get(key).map_or(&self.table.span, |value| &value.span).clone()
    }

    fn measure(&self, key: &str) -> Measure {
        match fields::find(self.fields, key).map(|field| field.shape) {
            Some(
                Shape::Quantity(measure) | Shape::Vector(measure) | Shape::Quantities(measure),
            ) => measure,
            _ => Measure::Any,
        }
    }

    /// Reads the quantity under a key.
    pub(crate) fn quantity(&self, key: &str) -> Option<f64> {
        self.context.quantity(self.value(key)?, self.measure(key))
    }

    /// Reads the list of three quantities under a key.
    pub(crate) fn vector(&self, key: &str) -> Option<Vec3<f64>> {
        self.context.vector(self.value(key)?, self.measure(key))
    }

    /// Reads the string under a key as one line of text, in which blanks replace control
    /// characters; returns an empty string if the key is missing.
    pub(crate) fn line(&self, key: &str) -> String {
        let text = self.text(key).unwrap_or_default().trim();
        let pieces: Vec<&str> = text.split(char::is_control).filter(|p| !p.is_empty()).collect();
        pieces.join(" ")
    }

    /// Reads the string under a key.
    pub(crate) fn text(&self, key: &str) -> Option<&'a str> {
        let what = match fields::find(self.fields, key).map(|field| field.shape) {
            Some(Shape::Name) => "a quoted name",
            _ => "a quoted string",
        };
        self.context.text(self.value(key)?, what)
    }

    /// Reads the list of pairs of quantities under a key; returns each pair with its place.
    pub(crate) fn pairs(&self, key: &str) -> Option<Vec<([f64; 2], Span)>> {
        let value = self.value(key)?;
        let Some(Shape::Pairs(first, second)) = fields::find(self.fields, key).map(|f| f.shape)
        else {
            return None;
        };
        let Some(list) = value.as_list() else {
            self.context.wrong(value, "a list of pairs");
            return None;
        };
        let pair = |item: &Value| {
            let Some([a, b]) = item.as_list() else {
                let (first, second) = (first.words().noun, second.words().noun);
                self.context.wrong(item, &format!("a pair of {first} and {second}"));
                return None;
            };
            let pair = (self.context.quantity(a, first), self.context.quantity(b, second));
            let (Some(a), Some(b)) = pair else { return None };
            Some(([a, b], item.span.clone()))
        };
        let pairs: Vec<_> = list.iter().map(pair).collect();
        pairs.into_iter().collect()
    }

    /// Reads the word under a key, which must be one of the words that the key permits.
    pub(crate) fn choice(&self, key: &str) -> Option<&'static str> {
        match fields::find(self.fields, key).map(|field| field.shape) {
            Some(Shape::Choice(words)) => self.context.choice(self.value(key)?, words),
            _ => None,
        }
    }

    /// Returns the tables nested in the table under a key, each with its name.
    pub(crate) fn tables(&self, key: &str) -> Vec<(&'a crate::document::Key, &'a Table)> {
        let Some(value) = self.value(key) else { return Vec::new() };
        let Some(table) = self.sub_table(value, key) else { return Vec::new() };
        let each = |(name, value): &'a (crate::document::Key, Value)| {
            Some((name, self.sub_table(value, &name.name)?))
        };
        table.entries.iter().filter_map(each).collect()
    }

    /// Returns the table under a key; reports an error if the value is not a table.
    pub(crate) fn table(&self, key: &str) -> Option<&'a Table> {
        self.sub_table(self.value(key)?, key)
    }

    fn sub_table(&self, value: &'a Value, key: &str) -> Option<&'a Table> {
        let table = value.as_table();
        if table.is_none() {
            self.context.wrong(value, &format!("a table for {}", quoted(key)));
        }
        table
    }
}
