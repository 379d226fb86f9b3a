//! The chain of a leg: `R cylinder P* rod S`.

use super::context::Context;
use super::names;
use crate::diagnostic::{Diagnostic, did_you_mean, quoted};
use crate::document::{Node, Value};
use crate::fields::tables::JOINT_TYPES;
use crate::source::Span;
use stiction::joint::JointType;

/// Joints and the bodies between them, in order.
pub(crate) struct Chain {
    pub(crate) joints: Vec<JointLink>,
    pub(crate) bodies: Vec<Link>,
}

/// A body or joint of the chain: its key in the tables of the group, and where it stands.
pub(crate) struct Link {
    pub(crate) key: String,
    pub(crate) span: Span,
}

/// A joint of the chain.
pub(crate) struct JointLink {
    pub(crate) key: String,
    pub(crate) span: Span,
    pub(crate) joint_type: JointType,
    pub(crate) actuated: bool,
}

impl JointLink {
    pub(crate) fn link(&self) -> Link {
        Link { key: self.key.clone(), span: self.span.clone() }
    }
}

const EXAMPLE: &str = "write the joints and the bodies between them in turn: \"R cylinder P* rod S\"; * means \
     actuated";

impl Chain {
    /// Reads the chain; `None` if it cannot be understood.
    pub(crate) fn read(context: &Context<'_>, value: &Value) -> Option<Self> {
        let Node::Text(text) = &value.node else {
            context.wrong(value, "a chain such as \"R cylinder P* rod S\"");
            return None;
        };
        let error = |span: &Span, message: String, label: &str| {
            let place = context.place(&text.place_of(&value.span, span));
            Diagnostic::error("chain", message).at(place, label).help(EXAMPLE)
        };
        let mut chain = Self { joints: Vec::new(), bodies: Vec::new() };
        let mut sound = true;
        for (i, (word, span)) in words(&text.content).into_iter().enumerate() {
            let place = text.place_of(&value.span, &span);
            let symbol = word.trim_end_matches('*');
            let joint_type = JointType::from_symbol(symbol);
            if i % 2 == 0 {
                let Some(joint_type) = joint_type else {
                    let message = format!("{} is not a type of joint", quoted(symbol));
                    let near = did_you_mean(symbol, "types of joints", JOINT_TYPES.iter().copied());
                    let diagnostic = error(&span, message, "expected a joint");
                    context.push(diagnostic.maybe_help(near));
                    return None;
                };
                let actuated = word.len() > symbol.len();
                let key = symbol.to_owned();
                chain.joints.push(JointLink { key, span: place, joint_type, actuated });
            } else if joint_type.is_some() {
                let message = format!("there is no body before the joint {}", quoted(word));
                context.push(error(&span, message, "expected the name of a body"));
                return None;
            } else {
                names::check(context, word, &place, "body");
                if chain.bodies.iter().any(|body| body.key == word) {
                    let message = format!("body {} occurs twice in the chain", quoted(word));
                    context.push(error(&span, message, "used already"));
                    sound = false;
                }
                chain.bodies.push(Link { key: word.to_owned(), span: place });
            }
        }
        if chain.joints.len() != chain.bodies.len() + 1 {
            let end = text.content.len();
            let label = "expected a joint at the end";
            context.push(error(
                &(0..end),
                "a chain begins and ends with a joint".to_owned(),
                label,
            ));
            return None;
        }
        chain.number();
        sound.then_some(chain)
    }

    /// Joints of the same letter are told apart by a number.
    fn number(&mut self) {
        let letters: Vec<_> = self.joints.iter().map(|joint| joint.key.clone()).collect();
        for (i, joint) in self.joints.iter_mut().enumerate() {
            let same = |other: &&String| **other == joint.key;
            if letters.iter().filter(same).count() > 1 {
                let number = letters.iter().take(i + 1).filter(same).count();
                joint.key = format!("{}{number}", joint.key);
            }
        }
    }
}

/// Words and where they stand.
fn words(text: &str) -> Vec<(&str, Span)> {
    let mut words: Vec<Span> = Vec::new();
    let mut inside = false;
    for (at, c) in text.char_indices() {
        match words.last_mut().filter(|_| inside) {
            Some(word) if !c.is_whitespace() => word.end = at + c.len_utf8(),
            None if !c.is_whitespace() => words.push(at..at + c.len_utf8()),
            _ => {}
        }
        inside = !c.is_whitespace();
    }
    words.into_iter().map(|span| (text.get(span.clone()).unwrap_or_default(), span)).collect()
}
