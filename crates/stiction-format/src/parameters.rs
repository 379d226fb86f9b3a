//! Parameters of a model: named quantities that expressions can use.

use crate::diagnostic::quoted;
use crate::expression::{self, Quantity, Scope};
use std::collections::HashMap;

/// All parameters of a model with their values.
#[derive(Clone, Debug, Default)]
pub(crate) struct Parameters {
    names: Vec<String>,
    /// Value of each parameter; `None` if its definition or its name is invalid. Errors in
    /// expressions that use such a parameter are suppressed.
    values: Vec<Option<Quantity>>,
    index: HashMap<String, usize>,
}

impl Scope for Parameters {
    fn find(&self, name: &str) -> Option<usize> {
        self.index.get(name).copied()
    }

    fn value(&self, index: usize) -> Option<Quantity> {
        self.values.get(index).copied().flatten()
    }

    fn names(&self) -> Vec<&str> {
        self.names.iter().map(String::as_str).filter(|name| complaint(name).is_none()).collect()
    }
}

impl Parameters {
    /// Creates parameters with these names whose values are not yet known.
    pub(crate) fn named(names: impl Iterator<Item = String>) -> Self {
        let names: Vec<String> = names.collect();
        let index = names.iter().enumerate().map(|(place, name)| (name.clone(), place)).collect();
        Self { values: vec![None; names.len()], names, index }
    }

    /// Names, values and SI units of all parameters that have a value.
    pub(crate) fn all(&self) -> impl Iterator<Item = (&str, f64, String)> {
        let each = self.names.iter().zip(&self.values);
        each.filter_map(|(name, quantity)| {
            let Quantity { value, dimension } = (*quantity)?;
            let unit = if dimension.is_angle() { "rad".to_owned() } else { dimension.units() };
            Some((name.as_str(), value, unit))
        })
    }

    /// Name of parameter `index`; empty if the index is out of range.
    pub(crate) fn name(&self, index: usize) -> &str {
        self.names.get(index).map_or("", String::as_str)
    }

    pub(crate) fn set(&mut self, index: usize, value: Option<Quantity>) {
        let known = !self.is_misnamed(index);
        if let Some(slot) = self.values.get_mut(index) {
            *slot = value.filter(|_| known);
        }
    }

    pub(crate) fn is_misnamed(&self, index: usize) -> bool {
        self.names.get(index).is_some_and(|name| complaint(name).is_some())
    }
}

/// Returns the reason why a parameter cannot have this name; `None` if the name is allowed.
pub(crate) fn complaint(name: &str) -> Option<String> {
    let mut letters = name.chars();
    let starts_well = letters.next().is_some_and(|c| c.is_alphabetic() || c == '_');
    if !starts_well || !letters.all(|c| c.is_alphanumeric() || c == '_') {
        return Some(
            "the name of a parameter consists of letters, digits and `_`, and does not begin with a digit"
                .to_owned(),
        );
    }
    let what = expression::reserved(name)?;
    Some(format!("{} cannot be the name of a parameter: it is {what}", quoted(name)))
}
