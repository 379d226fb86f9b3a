//! Text in XML and HTML.

use crate::numbers::with_minus;

/// Escapes text for element content and for attributes in double quotes; characters that XML does not permit are
/// omitted.
pub fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            c if is_of_xml(c) => escaped.push(c),
            _ => {}
        }
    }
    escaped
}

/// Returns `true` if XML permits a character.
pub(crate) fn is_of_xml(c: char) -> bool {
    match c {
        '\t' | '\n' | '\r' => true,
        '\u{fffe}' | '\u{ffff}' => false,
        c => !c.is_control(),
    }
}

/// Returns a text for people as HTML: escaped, with true minus signs, and with the parts between backticks as code.
///
/// The text may contain names from files of users. Since it is escaped before parts become code, and every part of code
/// is closed, no name can add or hide markup; a name with backticks only changes which words look like code.
pub fn prose(text: &str) -> String {
    sentence(&escape(text))
}

/// Marks the parts between backticks of an escaped text as code, and replaces the minus signs of numbers in the other parts
/// by true ones. Code keeps the hyphens, because readers copy it. A backtick without a partner, and two without a text
/// between them, remain as they are.
pub(crate) fn sentence(escaped: &str) -> String {
    let mut markup = String::with_capacity(escaped.len());
    let mut rest = escaped;
    while let Some((before, after)) = rest.split_once('`') {
        markup += &with_minus(before);
        rest = match after.split_once('`') {
            Some((code, after)) if !code.is_empty() => {
                markup += &format!("<code>{code}</code>");
                after
            }
            Some((_, after)) => {
                markup += "``";
                after
            }
            None => {
                markup.push('`');
                after
            }
        };
    }
    markup + &with_minus(rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped() {
        assert_eq!(escape("a<b> & \"c\" 'd'"), "a&lt;b&gt; &amp; &quot;c&quot; &#39;d&#39;");
        assert_eq!(escape("bell\u{7}, \u{ffff}"), "bell, ");
        assert_eq!(escape("Kurbel λ"), "Kurbel λ");
    }

    /// Checks that parts between backticks become code, with the hyphens that a reader copies.
    #[test]
    fn backticks_mark_code() {
        assert_eq!(prose("see `--set x=-1` at -1 s"), "see <code>--set x=-1</code> at −1 s");
        assert_eq!(prose("`a` and `b`"), "<code>a</code> and <code>b</code>");
    }

    /// Checks that names with backticks and tags neither add markup nor swallow text, whatever the number of backticks.
    #[test]
    fn hostile_names_are_no_markup() {
        let names = ["`<script>alert(1)</script>", "a`b", "``", "```", "</code>`", "`&`<b>`", "`"];
        for name in names {
            for text in [format!("joint `{name}` is singular"), format!("{name}: -1 `x`")] {
                let found = prose(&text);
                let plain = found.replace("<code>", "").replace("</code>", "");
                assert!(!plain.contains(['<', '>']), "{found}");
                let parts: Vec<&str> = found.split("<code>").collect();
                assert!(parts[1..].iter().all(|part| part.matches("</code>").count() == 1));
                let letters = |text: &str| text.replace('`', "").replace('−', "-");
                assert_eq!(letters(&plain), letters(&escape(&text)));
            }
        }
    }
}
