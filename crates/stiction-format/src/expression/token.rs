//! Tokens of an expression.

use super::Fault;
use super::unit;
use crate::diagnostic::quoted;
use crate::source::Span;

/// A token and its place.
#[derive(Clone, Debug)]
pub(crate) struct Token {
    pub(crate) kind: TokenKind,
    pub(crate) span: Span,
}

/// Kind of a token.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TokenKind {
    /// A number; its digits are in the text, at the place of the token.
    Number,
    /// A name, or `%`; its letters are in the text, at the place of the token.
    Name,
    /// One of `+ - * / ^ ( ) ,`.
    Symbol(char),
    End,
}

/// Splits `text` into tokens; the last token is [`TokenKind::End`].
pub(crate) fn tokens(text: &str) -> Result<Vec<Token>, Fault> {
    let mut tokens = Vec::new();
    let mut rest = text.char_indices().peekable();
    while let Some(&(start, c)) = rest.peek() {
        if c.is_whitespace() {
            rest.next();
        } else if c.is_ascii_digit() || c == '.' {
            let length = number_length(text.get(start..).unwrap_or_default());
            let span = start..start + length.max(1);
            if text.get(span.clone()).unwrap_or_default().parse::<f64>().is_err() {
                return Err(Fault::new(span, "this is not a number", "not a number"));
            }
            while rest.next_if(|(at, _)| *at < span.end).is_some() {}
            tokens.push(Token { kind: TokenKind::Number, span });
        } else if c.is_alphabetic() || c == '_' {
            let mut end = start;
            loop {
                while let Some((at, c)) = rest.next_if(|(_, c)| c.is_alphanumeric() || *c == '_') {
                    end = at + c.len_utf8();
                }
                // A dot between letters joins the parts of a name: `leg1.P`.
                let mut then = text.get(end..).unwrap_or_default().chars();
                let joins =
                    then.next() == Some('.') && then.next().is_some_and(|c| c.is_alphabetic());
                if !joins || rest.next().is_none() {
                    break;
                }
            }
            tokens.push(Token { kind: TokenKind::Name, span: start..end });
        } else {
            rest.next();
            let span = start..start + c.len_utf8();
            let kind = match c {
                '%' => TokenKind::Name,
                '+' | '-' | '*' | '/' | '^' | '(' | ')' | ',' => TokenKind::Symbol(c),
                _ => return Err(strange(c, span)),
            };
            if c == '*' && rest.peek().is_some_and(|(_, next)| *next == '*') {
                let fault = Fault::new(start..start + 2, "powers are written with `^`", "");
                return Err(fault.help("write `^`"));
            }
            tokens.push(Token { kind, span });
        }
    }
    tokens.push(Token { kind: TokenKind::End, span: text.len()..text.len() });
    Ok(tokens)
}

/// Length in bytes of the number at the start of `text`: digits, point, exponent.
fn number_length(text: &str) -> usize {
    let digits = |from: usize| text.bytes().skip(from).take_while(u8::is_ascii_digit).count();
    let mut length = digits(0);
    if text.as_bytes().get(length) == Some(&b'.') {
        length += 1 + digits(length + 1);
    }
    if matches!(text.as_bytes().get(length), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(text.as_bytes().get(length + 1), Some(b'+' | b'-')));
        let exponent = digits(length + 1 + sign);
        if exponent > 0 {
            length += 1 + sign + exponent;
        }
    }
    length
}

fn strange(c: char, span: Span) -> Fault {
    let meant = match c {
        '·' | '×' | '∙' | '⋅' => Some("*"),
        '−' | '–' => Some("-"),
        '÷' | ':' => Some("/"),
        '²' => Some("^2"),
        '³' => Some("^3"),
        '[' | '{' => Some("("),
        ']' | '}' => Some(")"),
        _ => None,
    };
    let help = meant.map(|meant| format!("write `{meant}`"));
    let message = format!("unexpected character {}", quoted(&c.to_string()));
    Fault::new(span, message, "not understood").maybe_help(help.or_else(|| match c {
        '"' | '\'' => Some("close the quote, or delete it".to_owned()),
        _ => unit::advice(&c.to_string()),
    }))
}
