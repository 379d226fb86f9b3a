//! Text with marks, read: any text is some text; a mark that is not closed is a sign like others.
//!
//! As in Markdown a mark opens before a word and closes after one, so that `a * b * c` has no marks.
//! Marks of a kind do not lie within each other. Within code only its end has a meaning.

use stiction_draw::xml::escape;

/// A piece of text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Span {
    Plain(String),
    Marked(Mark, Vec<Span>),
    Code(String),
    /// Words that lead to a place in the same report; its name comes without `#`.
    Link(Vec<Span>, String),
}

/// What is done to words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mark {
    Strong,
    Emphasis,
    Index,
    Power,
}

impl Mark {
    fn sign(self) -> &'static str {
        match self {
            Self::Strong => "**",
            Self::Emphasis => "*",
            Self::Index => "~",
            Self::Power => "^",
        }
    }

    /// Its element in HTML.
    pub(crate) fn element(self) -> &'static str {
        match self {
            Self::Strong => "strong",
            Self::Emphasis => "em",
            Self::Index => "sub",
            Self::Power => "sup",
        }
    }
}

/// What is not closed yet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Open {
    Mark(Mark),
    Bracket,
}

impl Open {
    fn sign(self) -> &'static str {
        match self {
            Self::Mark(mark) => mark.sign(),
            Self::Bracket => "[",
        }
    }
}

/// Reads a text.
pub(crate) fn parse(text: &str) -> Vec<Span> {
    let mut parser = Parser { text, at: 0, done: Vec::new(), open: Vec::new() };
    while let Some(sign) = parser.rest().chars().next() {
        parser.step(sign);
    }
    while !parser.open.is_empty() {
        parser.give_up(parser.open.len() - 1);
    }
    parser.done
}

struct Parser<'a> {
    text: &'a str,
    at: usize,
    /// What stands outside of all that is open.
    done: Vec<Span>,
    /// Opened from outside to inside, with what has been read since. No kind is there twice.
    open: Vec<(Open, Vec<Span>)>,
}

impl<'a> Parser<'a> {
    fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }

    fn step(&mut self, sign: char) {
        match sign {
            '\\' => self.backslash(),
            '`' => self.code(),
            '*' => self.stars(),
            '~' => self.mark(Mark::Index),
            '^' => self.mark(Mark::Power),
            '[' => self.bracket(),
            ']' => self.bracket_end(),
            sign => {
                self.plain(sign.encode_utf8(&mut [0; 4]));
                self.at += sign.len_utf8();
            }
        }
    }

    /// Where the next piece goes.
    fn inner(&mut self) -> &mut Vec<Span> {
        self.open.last_mut().map_or(&mut self.done, |(_, spans)| spans)
    }

    fn plain(&mut self, text: &str) {
        append(self.inner(), text);
    }

    fn backslash(&mut self) {
        let next = self.rest()[1..].chars().next();
        match next.filter(char::is_ascii_punctuation) {
            Some(sign) => {
                self.plain(sign.encode_utf8(&mut [0; 4]));
                self.at += 2;
            }
            None => {
                self.plain("\\");
                self.at += 1;
            }
        }
    }

    fn code(&mut self) {
        let inside = &self.rest()[1..];
        match inside.find('`') {
            Some(end @ 1..) => {
                self.inner().push(Span::Code(inside[..end].to_owned()));
                self.at += end + 2;
            }
            _ => {
                self.plain("`");
                self.at += 1;
            }
        }
    }

    fn stars(&mut self) {
        let run = self.rest().bytes().take_while(|&c| c == b'*').count();
        // Of three the inner mark ends first.
        let inmost = self.open.last().map(|(open, _)| *open);
        let single = run == 1 || (run == 3 && inmost == Some(Open::Mark(Mark::Emphasis)));
        self.mark(if single { Mark::Emphasis } else { Mark::Strong });
    }

    fn mark(&mut self, mark: Mark) {
        let sign = mark.sign();
        let (before, after) = (&self.text[..self.at], &self.rest()[sign.len()..]);
        let can_close = before.chars().next_back().is_some_and(|c| !c.is_whitespace());
        let can_open = after.chars().next().is_some_and(|c| !c.is_whitespace());
        self.at += sign.len();
        let opened = self.position(Open::Mark(mark));
        if let Some(k) = opened.filter(|_| can_close)
            && (k + 1 < self.open.len() || !self.open[k].1.is_empty())
        {
            let inside = self.close(k);
            self.inner().push(Span::Marked(mark, inside));
            return;
        }
        if !can_open {
            return self.plain(sign);
        }
        // What was meant to open before was none.
        if let Some(k) = opened {
            self.give_up(k);
        }
        self.open.push((Open::Mark(mark), Vec::new()));
    }

    fn bracket(&mut self) {
        if let Some(k) = self.position(Open::Bracket) {
            self.give_up(k);
        }
        self.open.push((Open::Bracket, Vec::new()));
        self.at += 1;
    }

    fn bracket_end(&mut self) {
        let Some(k) = self.position(Open::Bracket) else {
            self.at += 1;
            return self.plain("]");
        };
        match target(&self.rest()[1..]) {
            Some(name) if k + 1 < self.open.len() || !self.open[k].1.is_empty() => {
                let inside = self.close(k);
                self.inner().push(Span::Link(inside, name.to_owned()));
                // `](#` and `)`.
                self.at += name.len() + 4;
            }
            _ => {
                self.give_up(k);
                self.plain("]");
                self.at += 1;
            }
        }
    }

    fn position(&self, open: Open) -> Option<usize> {
        self.open.iter().position(|(own, _)| *own == open)
    }

    /// Ends the k-th of what is open; what was opened within it and not closed is no mark.
    fn close(&mut self, k: usize) -> Vec<Span> {
        while self.open.len() > k + 1 {
            self.give_up(self.open.len() - 1);
        }
        self.open.pop().map(|(_, spans)| spans).unwrap_or_default()
    }

    /// The k-th of what is open is no mark.
    fn give_up(&mut self, k: usize) {
        let (open, spans) = self.open.remove(k);
        let outer = if k == 0 { &mut self.done } else { &mut self.open[k - 1].1 };
        append(outer, open.sign());
        for span in spans {
            match span {
                Span::Plain(text) => append(outer, &text),
                other => outer.push(other),
            }
        }
    }
}

fn append(spans: &mut Vec<Span>, text: &str) {
    match spans.last_mut() {
        Some(Span::Plain(last)) => last.push_str(text),
        _ => spans.push(Span::Plain(text.to_owned())),
    }
}

/// The name in `(#name)`.
fn target(text: &str) -> Option<&str> {
    let (name, _) = text.strip_prefix("(#")?.split_once(')')?;
    is_name(name).then_some(name)
}

/// Whether a link can lead to it: lower-case letters, digits and hyphens.
pub(crate) fn is_name(name: &str) -> bool {
    let is_part = |c: u8| c.is_ascii_lowercase() || c.is_ascii_digit() || c == b'-';
    !name.is_empty() && name.bytes().all(is_part)
}

/// A text as HTML.
pub(crate) fn html(text: &str) -> String {
    spans_html(&parse(text))
}

fn spans_html(spans: &[Span]) -> String {
    let span = |span: &Span| match span {
        Span::Plain(text) => escape(text),
        Span::Marked(mark, inside) => {
            let element = mark.element();
            format!("<{element}>{}</{element}>", spans_html(inside))
        }
        Span::Code(text) => format!("<code>{}</code>", escape(text)),
        Span::Link(words, name) => format!("<a href=\"#{name}\">{}</a>", spans_html(words)),
    };
    spans.iter().map(span).collect()
}

/// A text without its marks.
pub(crate) fn plain(text: &str) -> String {
    spans_plain(&parse(text))
}

fn spans_plain(spans: &[Span]) -> String {
    let span = |span: &Span| match span {
        Span::Plain(text) | Span::Code(text) => text.clone(),
        Span::Marked(_, inside) | Span::Link(inside, _) => spans_plain(inside),
    };
    spans.iter().map(span).collect()
}

/// Names that a text's links lead to.
pub(crate) fn targets(text: &str) -> Vec<String> {
    fn collect(spans: &[Span], names: &mut Vec<String>) {
        for span in spans {
            match span {
                Span::Plain(_) | Span::Code(_) => {}
                Span::Marked(_, inside) => collect(inside, names),
                Span::Link(inside, name) => {
                    names.push(name.clone());
                    collect(inside, names);
                }
            }
        }
    }
    let mut names = Vec::new();
    collect(&parse(text), &mut names);
    names
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn marks_are_read() {
        let cases = [
            ("", ""),
            ("plain λ", "plain λ"),
            ("**a** and *b*", "<strong>a</strong> and <em>b</em>"),
            ("***a***", "<strong><em>a</em></strong>"),
            ("**a *b* c**", "<strong>a <em>b</em> c</strong>"),
            ("*a **b***", "<em>a <strong>b</strong></em>"),
            ("`*a* \\ <`", "<code>*a* \\ &lt;</code>"),
            ("*F*~*i*,x~^2^", "<em>F</em><sub><em>i</em>,x</sub><sup>2</sup>"),
            ("10^-3^ N m^-1^", "10<sup>-3</sup> N m<sup>-1</sup>"),
            ("see [eq. *3*](#force-2).", "see <a href=\"#force-2\">eq. <em>3</em></a>."),
            ("**[a](#b)**", "<strong><a href=\"#b\">a</a></strong>"),
            ("[[a](#b)](#c)", "[<a href=\"#b\">a</a>](#c)"),
            (r"\*a\* \[b](#c) \\ \n", r"*a* [b](#c) \ \n"),
            (r"x~a\~b~", "x<sub>a~b</sub>"),
        ];
        for (text, expected) in cases {
            assert_eq!(html(text), expected, "{text}");
        }
    }

    #[test]
    fn what_is_not_closed_is_a_sign() {
        let same = [
            "*",
            "**",
            "***",
            "****",
            "~",
            "~~",
            "^^",
            "`",
            "``",
            "[",
            "]",
            "[]",
            "[](#a)",
            "[a](b)",
            "[a](#B)",
            "[a](#",
            "[a](#)",
            "[a] (#b)",
            "a * b * c",
            "a*b",
            "2 ** 3",
            "~5 N, ~6 N",
            "end*",
            "`end",
            "x^2",
            "[1, 2] and [3, 4]",
            "\\",
            "a\\",
        ];
        for text in same {
            assert_eq!(parse(text), [Span::Plain(text.into())], "{text}");
        }
        let cases = [
            ("2*3 and *a*", "2*3 and <em>a</em>"),
            ("**a*", "**a*"),
            ("*a [b* c](#d)", "<em>a [b</em> c](#d)"),
            ("x~a^b~ c^", "x<sub>a^b</sub> c^"),
            ("[a `](#b)` c](#d)", "<a href=\"#d\">a <code>](#b)</code> c</a>"),
        ];
        for (text, expected) in cases {
            assert_eq!(html(text), expected, "{text}");
        }
    }

    #[test]
    fn a_text_loses_its_marks() {
        assert_eq!(plain("**a** `b`~*i*~ [c](#d) \\* *"), "a bi c * *");
        assert_eq!(targets("[a](#b) *[`c`](#d)*"), ["b", "d"]);
    }

    /// Deep nests would overflow the stack of whoever walks through them.
    #[test]
    fn nests_are_shallow() {
        fn depth(spans: &[Span]) -> usize {
            let inner = |span: &Span| match span {
                Span::Marked(_, inside) | Span::Link(inside, _) => 1 + depth(inside),
                _ => 1,
            };
            spans.iter().map(inner).max().unwrap_or(0)
        }
        for piece in ["*a ", "**a *b ~c ^d [e ", "[*a~b^"] {
            let mut text = piece.repeat(20_000);
            text += &"](#a)^ ~ * ** a* b** c~ d^".repeat(20_000);
            assert!(depth(&parse(&text)) <= 6, "{piece}");
        }
    }

    /// Text of many marks and few words.
    fn marked() -> impl Strategy<Value = String> {
        let piece = prop_oneof![
            "[*~^`\\[\\]\\\\()#]",
            "\\PC",
            Just("**".to_owned()),
            Just("](#a)".to_owned()),
            Just("<script>".to_owned()),
            Just("]]>".to_owned()),
            Just("&amp;".to_owned()),
            Just(" ".to_owned()),
            Just("\u{202e}".to_owned()),
            any::<char>().prop_map(String::from),
        ];
        proptest::collection::vec(piece, 0..40).prop_map(|pieces| pieces.concat())
    }

    proptest! {
        #[test]
        fn any_text_is_some_text(text in marked()) {
            let page = format!("<p>{}</p>", html(&text));
            let parsed = roxmltree::Document::parse(&page);
            prop_assert!(parsed.is_ok(), "{page}: {parsed:?}");
            let parsed = parsed.unwrap();
            let texts = parsed.descendants().filter(|n| n.is_text()).filter_map(|n| n.text());
            let shown: String = texts.collect();
            // XML knows one end of line, and not all signs.
            let lines = |text: &str| text.replace("\r\n", "\n").replace('\r', "\n");
            let kept = |c: &char| !matches!(c, '\u{fffe}' | '\u{ffff}');
            let expected = plain(&text);
            let expected = expected.chars().filter(kept);
            let expected: String = expected.filter(|c| !c.is_control() || "\t\n\r".contains(*c)).collect();
            prop_assert_eq!(lines(&shown), lines(&expected));
        }

        #[test]
        fn taken_marks_are_signs(text in marked()) {
            let taken: String = text.chars().flat_map(|c| {
                let slash = c.is_ascii_punctuation().then_some('\\');
                slash.into_iter().chain([c])
            }).collect();
            prop_assert_eq!(plain(&taken), text.clone());
            // Of what is left out of a text only its marks are.
            let signs = |c: &char| !"*~^`\\[]()#-".contains(*c) && !c.is_ascii_alphanumeric();
            let left = plain(&text);
            let own: Vec<char> = text.chars().filter(signs).collect();
            prop_assert_eq!(left.chars().filter(signs).collect::<Vec<_>>(), own);
        }
    }
}
