//! Parser of unit products such as `kg m^2/s^2`.

use super::super::dimension::Dimension;
use super::super::token::{TokenKind, tokens};
use super::super::unit::{self, Scale};
use super::super::{Fault, Quantity, Scope};
use super::Parser;

/// Parses a text that consists of a unit alone, such as the unit in a column header; returns the
/// scale and dimension of the unit.
pub(crate) fn unit_of(text: &str) -> Result<(Scale, Dimension), Fault> {
    if matches!(text.trim(), "-" | "1" | "") {
        return Ok((Scale::ONE, Dimension::NONE));
    }
    let tokens = tokens(text)?;
    let scope = &NoNames;
    let mut parser =
        Parser { text, tokens, at: 0, scope, time: false, steps: Vec::new(), depth: 0 };
    if parser.unit_here().is_none() {
        return Err(parser.unknown(true));
    }
    let unit = parser.units()?;
    match parser.kind() {
        TokenKind::End => Ok(unit),
        TokenKind::Name => Err(parser.unknown(true)),
        _ => Err(Fault::new(parser.span(), "this is not a unit", "not a unit")
            .help("write units like `mm/s` or `kg m^2`")),
    }
}

struct NoNames;

impl Scope for NoNames {
    fn find(&self, _name: &str) -> Option<usize> {
        None
    }
    fn value(&self, _index: usize) -> Option<Quantity> {
        None
    }
    fn names(&self) -> Vec<&str> {
        Vec::new()
    }
}

impl Parser<'_> {
    /// Unit named by the next word; `None` if the word is a function call (`min`) or a parameter
    /// that takes precedence over the unit.
    pub(super) fn unit_here(&self) -> Option<&'static unit::Unit> {
        let called = self.kind_at(1) == TokenKind::Symbol('(');
        let word = self.word_at(0);
        let shadowed = || unit::yields_to_parameters(word) && self.scope.find(word).is_some();
        let is_unit = self.kind() == TokenKind::Name && !called && !shadowed();
        is_unit.then(|| unit::find(word)).flatten()
    }

    /// Parses a product of units.
    pub(super) fn units(&mut self) -> Result<(Scale, Dimension), Fault> {
        let (mut scale, mut dimension) = (Scale::ONE, Dimension::NONE);
        let mut divided = false;
        loop {
            let below = self.kind() == TokenKind::Symbol('/') && {
                self.at += 1;
                let unit = self.unit_here().is_some();
                self.at -= 1;
                unit
            };
            let span = self.span();
            self.at += usize::from(below);
            let Some(unit) = self.unit_here() else { break };
            if divided {
                return Err(Fault::new(
                    self.span(),
                    "this quotient of units is ambiguous",
                    "only one unit can follow a `/`",
                )
                .help("use parentheses, as in `N/(m s)`, or put the numerator first: `N s/m`"));
            }
            divided |= below;
            self.at += 1;
            let exponent = self.exponent()? * if below { -1.0 } else { 1.0 };
            let power = unit.dimension.power(exponent).and_then(|power| dimension.times(power));
            let (Some(power), Some(product)) = (power, scale.times(unit.scale, exponent)) else {
                let span = span.start..self.before();
                let label = "expected a power such as 2 or -1";
                return Err(Fault::new(span, "this power of the unit is not supported", label));
            };
            (scale, dimension) = (product, power);
        }
        Ok((scale, dimension))
    }

    /// Exponent after a unit, such as `^2` or `^-1`; 1 if absent.
    fn exponent(&mut self) -> Result<f64, Fault> {
        if !self.accept('^') {
            return Ok(1.0);
        }
        let sign = if self.accept('-') { -1.0 } else { 1.0 };
        let power = self.word_at(0).parse::<f64>();
        let (TokenKind::Number, Ok(power)) = (self.kind(), power) else {
            return Err(Fault::new(
                self.span(),
                "the exponent of a unit must be a number",
                "expected a number such as 2",
            ));
        };
        self.at += 1;
        Ok(sign * power)
    }
}
