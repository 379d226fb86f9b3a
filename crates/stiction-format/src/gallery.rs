//! Gallery: the texts of the example models.

const MODELS: &[(&str, &str)] = &[
    ("3rps", include_str!("../gallery/3rps.toml")),
    ("3rrr", include_str!("../gallery/3rrr.toml")),
    ("3upu", include_str!("../gallery/3upu.toml")),
    ("3upu-singular", include_str!("../gallery/3upu-singular.toml")),
    ("4ups-upu", include_str!("../gallery/4ups-upu.toml")),
    ("6sps", include_str!("../gallery/6sps.toml")),
    ("andrews", include_str!("../gallery/andrews.toml")),
    ("bricard", include_str!("../gallery/bricard.toml")),
    ("delta", include_str!("../gallery/delta.toml")),
    ("five-bar", include_str!("../gallery/five-bar.toml")),
    ("four-bar", include_str!("../gallery/four-bar.toml")),
    ("gough", include_str!("../gallery/gough.toml")),
    ("griffis-duffy", include_str!("../gallery/griffis-duffy.toml")),
    ("slider-crank", include_str!("../gallery/slider-crank.toml")),
    ("spherical-3rrr", include_str!("../gallery/spherical-3rrr.toml")),
    ("zhang2018", include_str!("../gallery/zhang2018.toml")),
    ("zhang2018-regular", include_str!("../gallery/zhang2018-regular.toml")),
];

/// Names of all models in the gallery, sorted.
pub fn names() -> impl Iterator<Item = &'static str> {
    MODELS.iter().map(|(name, _)| *name)
}

/// Returns the text of the model file with this name; `None` for an unknown name.
///
/// ```
/// use stiction_format::{Source, gallery, read};
///
/// let text = gallery::get("3rps").unwrap();
/// let model = read(&Source::new("3rps.toml", text), &|_| Err("no files".into()))?;
/// assert_eq!(model.name, "3rps");
/// assert_eq!(model.legs.len(), 3);
/// # Ok::<(), stiction_format::Diagnostics>(())
/// ```
pub fn get(name: &str) -> Option<&'static str> {
    MODELS.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_sorted() {
        assert!(MODELS.is_sorted_by(|a, b| a.0 < b.0));
        assert_eq!(names().count(), MODELS.len());
    }
}
