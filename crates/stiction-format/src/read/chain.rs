//! Reads the chain of a leg, written as `R cylinder P* rod S` or as `R P* S`.

use super::context::Context;
use super::names;
use crate::diagnostic::{Diagnostic, did_you_mean, quoted};
use crate::document::{self, Node, Value};
use crate::fields::tables::JOINT_TYPES;
use crate::source::Span;
use std::collections::HashMap;
use stiction_core::joint::JointType;

/// Chain of a leg: its joints and the bodies between them, in order.
pub(crate) struct Chain {
    pub(crate) joints: Vec<JointLink>,
    pub(crate) bodies: Vec<Link>,
}

/// A body or joint of the chain: its key in the tables of the group of legs, and its span in the
/// text.
pub(crate) struct Link {
    pub(crate) key: String,
    pub(crate) span: Span,
}

/// A joint of the chain: its key in the tables of the group of legs, its span in the text, and its
/// type.
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

const EXAMPLE: &str = "write joints and bodies alternately, \"R cylinder P* rod S\", or only the \
     joints, \"R P* S\"; * means actuated";

/// Maximum number of joints and bodies in a chain; it limits the time for reading a chain.
const MAX_WORDS: usize = 1000;

/// A word and its place in the chain's text.
type Word<'a> = (&'a str, Span);

/// The chain's text, with the context for messages.
struct Text<'a> {
    context: &'a Context<'a>,
    value: &'a Value,
    text: &'a document::Text,
}

impl Text<'_> {
    fn place(&self, span: &Span) -> Span {
        self.text.place_of(&self.value.span, span)
    }

    fn complain(&self, span: &Span, message: String, label: &str) {
        self.complain_with(span, message, label, EXAMPLE.to_owned());
    }

    fn complain_with(&self, span: &Span, message: String, label: &str, help: String) {
        let place = self.context.place(&self.place(span));
        self.context.push(Diagnostic::error("chain", message).at(place, label).help(help));
    }

    fn joint(&self, (word, span): &Word<'_>) -> Option<JointLink> {
        let symbol = symbol(word);
        let Some(joint_type) = JointType::from_symbol(symbol) else {
            let message = format!("{} is not a type of joint", quoted(word));
            let types = JOINT_TYPES.iter().copied();
            let bare = symbol.trim_end_matches(|c: char| c.is_ascii_digit());
            let numbered = bare.len() < symbol.len() && JointType::from_symbol(bare).is_some();
            let near = apart(word)
                .map(|apart| format!("separate the joints with blanks: {apart:?}"))
                .or_else(|| {
                    numbered.then(|| {
                        format!("write {bare}: joints of the same type are numbered automatically")
                    })
                })
                .or_else(|| did_you_mean(symbol, "types of joints", types));
            self.complain_with(
                span,
                message,
                "expected a joint",
                near.unwrap_or_else(|| EXAMPLE.to_owned()),
            );
            return None;
        };
        let actuated = word.len() > symbol.len();
        Some(JointLink { key: symbol.to_owned(), span: self.place(span), joint_type, actuated })
    }
}

/// Returns the symbol of a joint, without the asterisk that marks the joint as actuated.
fn symbol(word: &str) -> &str {
    word.trim_end_matches('*')
}

/// Inserts blanks between joints that are written without blanks, such as `RP*S`, to suggest a
/// correction in a message. Returns `None` unless the word consists of several joint symbols.
fn apart(word: &str) -> Option<String> {
    let letters = word.chars().filter(|c| !matches!(c, '-' | '_' | ',' | '.'));
    let mut apart = String::new();
    for letter in letters {
        if letter != '*' && !apart.is_empty() {
            apart.push(' ');
        }
        apart.push(letter);
    }
    let joints = || apart.split(' ').map(symbol);
    let all = joints().all(|joint| JointType::from_symbol(joint).is_some());
    (all && joints().count() > 1).then_some(apart)
}

/// Tests if a chain lists only joints: its second word is a joint symbol, and every word is a joint
/// symbol, a single character, or a word with an asterisk.
fn is_bare(words: &[Word<'_>]) -> bool {
    let is_joint = |word: &str| JointType::from_symbol(symbol(word)).is_some();
    let is_letter = |word: &str| symbol(word).chars().count() == 1 || word.ends_with('*');
    words.get(1).is_some_and(|(second, _)| is_joint(second))
        && words.iter().all(|(word, _)| is_joint(word) || is_letter(word))
}

impl Chain {
    /// Reads the chain, with the names of the bodies from `between` if given; returns `None` if the
    /// chain is invalid.
    pub(crate) fn read(
        context: &Context<'_>,
        value: &Value,
        between: Option<&Value>,
    ) -> Option<Self> {
        let Node::Text(text) = &value.node else {
            context.wrong(value, "a chain such as \"R cylinder P* rod S\"");
            return None;
        };
        let words = words(&text.content);
        let text = Text { context, value, text };
        if let Some((_, beyond)) = words.get(MAX_WORDS) {
            let message = format!(
                "the chain has {} joints and bodies; the maximum is {MAX_WORDS}",
                words.len()
            );
            text.complain(beyond, message, "too many from here on");
            return None;
        }
        let mut chain = if is_bare(&words) {
            Self::of_joints(&text, &words, between)?
        } else {
            let chain = Self::of_joints_and_bodies(&text, &words)?;
            if let Some(between) = between.filter(|_| !chain.bodies.is_empty()) {
                context.push(
                    Diagnostic::error("chain", "the bodies of the chain are named twice")
                        .at(context.place(&between.span), "once here")
                        .also(context.place(&value.span), "once here")
                        .help("delete `between`, or leave the bodies out of `chain`"),
                );
            }
            chain
        };
        chain.number();
        Some(chain)
    }

    /// Reads a chain of joints, `R P* S`.
    fn of_joints(text: &Text<'_>, words: &[Word<'_>], between: Option<&Value>) -> Option<Self> {
        let joints = words.iter().map(|word| text.joint(word)).collect::<Option<Vec<_>>>()?;
        let count = joints.len().saturating_sub(1);
        let bodies = match between {
            Some(list) => names_of(text.context, list, count)?,
            // Bodies without a name have no place in the text; their errors are shown at the preceding joint.
            None => joints
                .iter()
                .take(count)
                .zip(1..)
                .map(|(joint, i)| Link { key: format!("link{i}"), span: joint.span.clone() })
                .collect(),
        };
        Some(Self { joints, bodies })
    }

    /// Reads a chain of joints and bodies, `R cylinder P* rod S`.
    fn of_joints_and_bodies(text: &Text<'_>, words: &[Word<'_>]) -> Option<Self> {
        let mut chain = Self { joints: Vec::new(), bodies: Vec::new() };
        for (i, word) in words.iter().enumerate() {
            let (name, span) = word;
            if i % 2 == 0 {
                chain.joints.push(text.joint(word)?);
            } else if JointType::from_symbol(symbol(name)).is_some() {
                let message = format!("a body is missing before the joint {}", quoted(name));
                text.complain(span, message, "expected the name of a body");
                return None;
            } else {
                let link = Link { key: (*name).to_owned(), span: text.place(span) };
                names::check(text.context, name, &link.span, "body");
                chain.bodies.push(link);
            }
        }
        let different = are_different(text.context, &chain.bodies);
        if chain.joints.len() != chain.bodies.len() + 1 {
            let end = text.text.content.len();
            let message = "a chain must begin and end with a joint".to_owned();
            text.complain(&(0..end), message, "expected a joint at the end");
            return None;
        }
        different.then_some(chain)
    }

    /// Appends numbers to the keys of joints with the same letter.
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

/// Reads a list of `count` body names; returns `None` after an error.
fn names_of(context: &Context<'_>, list: &Value, count: usize) -> Option<Vec<Link>> {
    let expected = "a list of names such as [\"cylinder\", \"rod\"]";
    let Some(items) = list.as_list() else {
        context.wrong(list, expected);
        return None;
    };
    if items.len() != count {
        let bodies = |n: usize| if n == 1 { "1 body".to_owned() } else { format!("{n} bodies") };
        let message = format!(
            "the chain has {} between its joints, but this list has {}",
            bodies(count),
            items.len()
        );
        context.push(
            Diagnostic::error("chain", message)
                .at(context.place(&list.span), format!("expected {count}, found {}", items.len())),
        );
        return None;
    }
    let link = |item: &Value| {
        let name = context.text(item, "a quoted body name")?;
        names::check(context, name, &item.span, "body");
        Some(Link { key: name.to_owned(), span: item.span.clone() })
    };
    let links = items.iter().map(link).collect::<Option<Vec<_>>>()?;
    are_different(context, &links).then_some(links)
}

/// Reports repeated body names; returns true if all names differ.
fn are_different(context: &Context<'_>, bodies: &[Link]) -> bool {
    let mut first: HashMap<&str, &Link> = HashMap::new();
    let mut different = true;
    for body in bodies {
        let Some(before) = first.insert(&body.key, body) else { continue };
        let message = format!("body {} occurs twice in the chain", quoted(&body.key));
        context.push(
            Diagnostic::error("chain", message)
                .at(context.place(&body.span), "again here")
                .also(context.place(&before.span), "first here")
                .help("rename it, for example after its position in the leg"),
        );
        different = false;
    }
    different
}

/// Splits a text at white space into words, each with its span in the text.
fn words(text: &str) -> Vec<Word<'_>> {
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
