//! Marked-up text: inline CommonMark, with `<sub>` and `<sup>` as its only HTML.

use pulldown_cmark::{Event, Parser, Tag, TagEnd};
use stiction_draw::xml::escape;

/// One piece of a text; start and end pieces are properly nested.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Piece {
    Text(String),
    Code(String),
    Begin(Element),
    End(Element),
}

/// An inline element.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Element {
    Strong,
    Emphasis,
    Subscript,
    Superscript,
    /// A link and its destination.
    Link(String),
}

impl Element {
    /// Link target within the report, if the element is an internal link.
    pub(crate) fn place(&self) -> Option<&str> {
        match self {
            Self::Link(destination) => destination.strip_prefix('#').filter(|name| is_name(name)),
            _ => None,
        }
    }

    /// HTML element name; none for links.
    fn name(&self) -> Option<&'static str> {
        match self {
            Self::Strong => Some("strong"),
            Self::Emphasis => Some("em"),
            Self::Subscript => Some("sub"),
            Self::Superscript => Some("sup"),
            Self::Link(_) => None,
        }
    }

    /// HTML start tag; none for a link to a place outside the report.
    pub(crate) fn begin(&self) -> Option<String> {
        let link = || self.place().map(|place| format!("<a href=\"#{place}\">"));
        self.name().map(|name| format!("<{name}>")).or_else(link)
    }

    /// HTML end tag, if there is a start tag.
    pub(crate) fn end(&self) -> Option<String> {
        let link = || self.place().map(|_| "</a>".to_owned());
        self.name().map(|name| format!("</{name}>")).or_else(link)
    }
}

/// Parses a marked-up text.
pub(crate) fn parse(text: &str) -> Vec<Piece> {
    // A text is inline, so no Markdown block may begin in it. The leading colon prevents that, and
    // marks after it open as at the start of a line.
    let line = format!(":{}", text.replace(['\r', '\n'], " "));
    let mut reader = Reader::default();
    for event in Parser::new(&line) {
        reader.add(event);
    }
    reader.finish()
}

#[derive(Default)]
struct Reader {
    pieces: Vec<Piece>,
    open: Vec<Element>,
}

impl Reader {
    fn add(&mut self, event: Event<'_>) {
        match event {
            Event::Text(text) => self.text(&text),
            Event::Code(text) => self.pieces.push(Piece::Code(text.into_string())),
            Event::InlineHtml(tag) => match tag.as_ref() {
                "<sub>" => self.begin(Element::Subscript),
                "<sup>" => self.begin(Element::Superscript),
                "</sub>" if self.open.last() == Some(&Element::Subscript) => self.end(),
                "</sup>" if self.open.last() == Some(&Element::Superscript) => self.end(),
                other => self.text(other),
            },
            Event::Start(Tag::Strong) => self.begin(Element::Strong),
            Event::Start(Tag::Emphasis) => self.begin(Element::Emphasis),
            Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
                self.begin(Element::Link(dest_url.into_string()));
            }
            Event::End(TagEnd::Strong | TagEnd::Emphasis | TagEnd::Link | TagEnd::Image) => {
                // An element closes the indices left open inside it.
                while let Some(Element::Subscript | Element::Superscript) = self.open.last() {
                    self.end();
                }
                self.end();
            }
            _ => {}
        }
    }

    fn text(&mut self, text: &str) {
        match self.pieces.last_mut() {
            Some(Piece::Text(last)) => last.push_str(text),
            _ => self.pieces.push(Piece::Text(text.to_owned())),
        }
    }

    fn begin(&mut self, element: Element) {
        self.open.push(element.clone());
        self.pieces.push(Piece::Begin(element));
    }

    fn end(&mut self) {
        self.pieces.extend(self.open.pop().map(Piece::End));
    }

    fn finish(mut self) -> Vec<Piece> {
        while !self.open.is_empty() {
            self.end();
        }
        if let Some(Piece::Text(first)) = self.pieces.first_mut() {
            // Remove the leading colon.
            first.remove(0);
        }
        self.pieces.retain(|piece| *piece != Piece::Text(String::new()));
        self.pieces
    }
}

/// Tests for a valid link target: lower-case letters, digits and hyphens.
pub(crate) fn is_name(name: &str) -> bool {
    let is_part = |c: u8| c.is_ascii_lowercase() || c.is_ascii_digit() || c == b'-';
    !name.is_empty() && name.bytes().all(is_part)
}

/// Converts a text to HTML. Of a link to a place outside the report, only the words remain.
pub(crate) fn html(text: &str) -> String {
    let piece = |piece: &Piece| match piece {
        Piece::Text(text) => escape(text),
        Piece::Code(text) => format!("<code>{}</code>", escape(text)),
        Piece::Begin(element) => element.begin().unwrap_or_default(),
        Piece::End(element) => element.end().unwrap_or_default(),
    };
    parse(text).iter().map(piece).collect()
}

/// Removes the marks of a text.
pub(crate) fn plain(text: &str) -> String {
    let words = parse(text).into_iter().filter_map(|piece| match piece {
        Piece::Text(text) | Piece::Code(text) => Some(text),
        Piece::Begin(_) | Piece::End(_) => None,
    });
    words.collect()
}

/// Destinations of the links in a text.
pub(crate) fn destinations(text: &str) -> Vec<String> {
    let links = parse(text).into_iter().filter_map(|piece| match piece {
        Piece::Begin(Element::Link(destination)) => Some(destination),
        _ => None,
    });
    links.collect()
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
            ("***a***", "<em><strong>a</strong></em>"),
            ("**a *b* c**", "<strong>a <em>b</em> c</strong>"),
            ("`*a* \\ <`", "<code>*a* \\ &lt;</code>"),
            ("*F*<sub>*i*,x</sub><sup>2</sup>", "<em>F</em><sub><em>i</em>,x</sub><sup>2</sup>"),
            ("see [eq. *3*](#force-2).", "see <a href=\"#force-2\">eq. <em>3</em></a>."),
            ("**[a](#b)**", "<strong><a href=\"#b\">a</a></strong>"),
            ("[a](b) and [c](#D)", "a and c"),
            (r"\*a\* \[b](#c) \\ \n", r"*a* [b](#c) \ \n"),
        ];
        for (text, expected) in cases {
            assert_eq!(html(text), expected, "{text}");
        }
    }

    /// Markdown blocks and HTML in a text remain plain text.
    #[test]
    fn all_else_is_text() {
        let same =
            ["*", "~~", "[1, 2] and [3]", "a * b * c", "1. a", "- a", "# a", "> a", "    a", "x^2"];
        for text in same {
            assert_eq!(parse(text), [Piece::Text(text.into())], "{text}");
        }
        assert_eq!(html("<b>a</b> <!-- c -->"), "&lt;b&gt;a&lt;/b&gt; &lt;!-- c --&gt;");
        assert_eq!(html("*a<sub>b* c</sub>"), "<em>a<sub>b</sub></em> c&lt;/sub&gt;");
        assert_eq!(plain("a\n\n- b"), "a  - b");
    }

    #[test]
    fn a_text_loses_its_marks() {
        assert_eq!(plain("**a** `b`<sub>*i*</sub> [c](#d) \\* *"), "a bi c * *");
        assert_eq!(destinations("[a](#b) *[`c`](d)*"), ["#b", "d"]);
    }

    /// Strategy for texts with many marks and few words.
    fn marked() -> impl Strategy<Value = String> {
        let piece = prop_oneof![
            "[*_`\\[\\]\\\\()#<>!&;]",
            "\\PC",
            Just("**".to_owned()),
            Just("](#a)".to_owned()),
            Just("<sub>".to_owned()),
            Just("</sub>".to_owned()),
            Just("</sup>".to_owned()),
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
            let kept = |c: &char| {
                !matches!(c, '\u{fffe}' | '\u{ffff}') && (!c.is_control() || *c == '\t')
            };
            let expected: String = plain(&text).chars().filter(kept).collect();
            prop_assert_eq!(shown, expected);
        }

        #[test]
        fn escaped_marks_are_text(text in marked()) {
            let escaped: String = text.chars().flat_map(|c| {
                let slash = c.is_ascii_punctuation().then_some('\\');
                slash.into_iter().chain([c])
            }).collect();
            let line = text.replace(['\r', '\n'], " ");
            let found = plain(&escaped);
            prop_assert_eq!(found.trim_end(), line.trim_end());
        }
    }
}
