//! Text in XML and HTML.

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped() {
        assert_eq!(escape("a<b> & \"c\" 'd'"), "a&lt;b&gt; &amp; &quot;c&quot; &#39;d&#39;");
        assert_eq!(escape("bell\u{7}, \u{ffff}"), "bell, ");
        assert_eq!(escape("Kurbel λ"), "Kurbel λ");
    }
}
