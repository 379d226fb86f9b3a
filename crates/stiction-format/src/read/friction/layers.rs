//! Tables that apply to a friction interface, in layers: a value in a more specific table overrides
//! the value in a more general table.

use super::FrictionSpans;
use crate::diagnostic::Diagnostic;
use crate::document::Value;
use crate::read::context::Record;

/// Places of the numbers read so far, and of the messages reported so far. Several friction
/// interfaces can share tables, but each message is reported only once.
pub(super) struct Notes {
    pub(super) spans: FrictionSpans,
    pub(super) reported: Vec<(usize, &'static str)>,
}

impl Notes {
    /// Records that a message about `key` was given at byte `at`; returns true for the first such
    /// message.
    fn is_new(&mut self, at: usize, key: &'static str) -> bool {
        let new = !self.reported.contains(&(at, key));
        if new {
            self.reported.push((at, key));
        }
        new
    }
}

/// The tables that apply to a friction interface, most specific first.
pub(super) struct Layers<'a> {
    pub(super) records: &'a [&'a Record<'a>],
    /// True if the key `radius` in the last, most general table is ignored because it belongs to
    /// another interface of the joint.
    pub(super) no_shared_radius: bool,
}

/// Value of a key, with the table that contains it and the index of this table among the layers, 0
/// for the most specific.
#[derive(Clone, Copy)]
pub(super) struct Given<'a> {
    pub(super) layer: usize,
    pub(super) record: &'a Record<'a>,
    pub(super) value: &'a Value,
}

impl<'a> Layers<'a> {
    /// Returns the value of a key from the most specific table that contains it.
    pub(super) fn given(&self, key: &str) -> Option<Given<'a>> {
        let last = self.records.len().saturating_sub(1);
        self.records.iter().enumerate().find_map(|(layer, &record)| {
            let hidden = key == "radius" && layer == last && self.no_shared_radius;
            let value = record.knows(key).then(|| record.table.get(key)).flatten();
            value.filter(|_| !hidden).map(|value| Given { layer, record, value })
        })
    }

    /// Reads the number under a key in the most specific table that contains the key; records the
    /// place of the number.
    pub(super) fn number(&self, key: &'static str, notes: &mut Notes) -> Option<f64> {
        let Given { record, value, .. } = self.given(key)?;
        // An invalid value has been reported; continue with an arbitrary valid number.
        let number = record.quantity(key).unwrap_or(1.0);
        notes.spans.numbers.push((key, number, value.span.clone()));
        Some(number)
    }

    /// Reads the word under a key in the most specific table that contains the key, such as the
    /// name of a friction law.
    pub(super) fn word(&self, key: &'static str) -> Option<&'static str> {
        self.given(key)?.record.choice(key)
    }

    /// Reports a key that is not allowed beside another key or for this friction law.
    pub(super) fn conflict(
        &self,
        given: Given<'_>,
        key: &'static str,
        why: &str,
        help: &str,
        notes: &mut Notes,
    ) {
        if !notes.is_new(given.value.span.start, key) {
            return;
        }
        let context = given.record.context;
        context.push(
            Diagnostic::error("friction", format!("`{key}` is not allowed here: {why}"))
                .at(context.place(&given.value.span), "in conflict")
                .help(help),
        );
    }

    /// Reports a missing key that another key requires.
    pub(super) fn missing(
        &self,
        beside: Option<Given<'_>>,
        key: &'static str,
        why: &str,
        notes: &mut Notes,
    ) {
        let nearest = self.records.first().copied();
        let Some(record) = beside.map(|given| given.record).or(nearest) else { return };
        if notes.is_new(record.table.span.start, key) {
            record.missing(key, why);
        }
    }
}
