//! Names of a model in source code. Model names may contain any characters, so they enter the code
//! only as identifiers or as harmless text.

/// Names and units of the inputs and results of generated code, each list in the order of the
/// program.
#[derive(Clone, Debug, Default)]
pub struct Labels {
    /// Name of the model.
    pub model: String,
    /// Version of the program that writes the code.
    pub version: String,
    /// Name of each prescribed coordinate, and the unit of its value, `rad` or `m`.
    pub coordinates: Vec<(String, &'static str)>,
    /// Name of each actuator, and the unit of its effort, `N` or `N m`.
    pub actuators: Vec<(String, &'static str)>,
    /// Name of each joint.
    pub joints: Vec<String>,
    /// Name of each friction interface.
    pub interfaces: Vec<String>,
    /// Name of each body; the first body is the ground.
    pub bodies: Vec<String>,
}

/// Maximum length of an identifier, characters. It is short, because compilers may ignore
/// characters beyond the 31st of external names.
const LONGEST: usize = 20;

/// Names that the generated code must not have. Files with these names would hide a header of the C
/// library or replace another generated file, and modules with these names would hide a Rust
/// library.
const TAKEN: [&str; 33] = [
    "assert",
    "complex",
    "ctype",
    "errno",
    "fenv",
    "float",
    "inttypes",
    "iso646",
    "limits",
    "locale",
    "math",
    "setjmp",
    "signal",
    "stdarg",
    "stdbool",
    "stddef",
    "stdint",
    "stdio",
    "stdlib",
    "string",
    "tgmath",
    "time",
    "wchar",
    "wctype",
    "stdalign",
    "stdatomic",
    "stdnoreturn",
    "threads",
    "uchar",
    "selftest",
    "vectors",
    "core",
    "std",
];

/// Converts any text to an identifier of at most [`LONGEST`] characters: lower-case letters, digits
/// and underscores, beginning with a letter.
pub(crate) fn identifier(text: &str) -> String {
    let letter = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' };
    let plain: String = text.chars().map(letter).collect();
    let plain = plain.trim_matches('_');
    let is_taken = TAKEN.contains(&plain) || plain.is_empty();
    let begins_well = plain.starts_with(|c: char| c.is_ascii_lowercase());
    let mut name = match begins_well && !is_taken {
        true => plain.to_owned(),
        false => format!("robot_{plain}"),
    };
    name.truncate(LONGEST);
    name.trim_end_matches('_').to_owned()
}

/// Converts text so that it cannot end a comment or a string, or begin a new line, in any language.
/// Letters, digits and a few signs are kept; every other character is written as its code point in
/// braces.
pub(crate) fn harmless(text: &str) -> String {
    let mut plain = String::new();
    for c in text.chars() {
        match c {
            c if c.is_ascii_alphanumeric() => plain.push(c),
            '.' | '_' | '-' | '+' | ' ' | '(' | ')' | '[' | ']' => plain.push(c),
            c => plain.push_str(&format!("{{{:X}}}", u32::from(c))),
        }
    }
    plain
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn identifiers_are_identifiers() {
        assert_eq!(identifier("3rps"), "robot_3rps");
        assert_eq!(identifier("five-bar"), "five_bar");
        assert_eq!(identifier("Zhang 2018, regular"), "zhang_2018__regular");
        assert_eq!(identifier("math"), "robot_math");
        assert_eq!(identifier("*/ system(\"x\"); /*"), "system__x");
        assert_eq!(identifier("é"), "robot");
        assert_eq!(identifier("_"), "robot");
    }

    #[test]
    fn hostile_names_become_harmless() {
        assert_eq!(harmless("*/ \"\\\n??/%"), "{2A}{2F} {22}{5C}{A}{3F}{3F}{2F}{25}");
        assert_eq!(harmless("leg1.P (m)"), "leg1.P (m)");
        assert_eq!(harmless("ä\u{202e}"), "{E4}{202E}");
    }
}
