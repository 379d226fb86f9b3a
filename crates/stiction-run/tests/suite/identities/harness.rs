//! Evaluation of an identity on many specimens.

use crate::identities::shrink::shrink;
use crate::identities::specimen::Specimen;
use crate::mechanisms::random::CLASSES;
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Outcome of an identity on a specimen.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Verdict {
    Holds,
    /// The identity does not apply. The variant contains the reason.
    Apart(&'static str),
    Broken(String),
}

impl Verdict {
    pub(crate) fn and(self, then: impl FnOnce() -> Self) -> Self {
        if self == Self::Holds { then() } else { self }
    }
}

/// Law of mechanics, as a function of a specimen. If the computation fails, the law does not apply
/// or is violated.
pub(crate) type Identity = fn(&Specimen) -> Result<Verdict, Verdict>;

/// Evaluates the identity on a specimen; a panic counts as a violation.
pub(crate) fn verdict(identity: Identity, specimen: &Specimen) -> Verdict {
    let tried = catch_unwind(AssertUnwindSafe(|| identity(specimen)));
    let said = |panic: Box<dyn std::any::Any + Send>| {
        let text = panic.downcast_ref::<String>().cloned();
        text.or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_owned()))
    };
    match tried {
        Ok(Ok(verdict) | Err(verdict)) => verdict,
        Err(panic) => Verdict::Broken(format!("panic: {}", said(panic).unwrap_or_default())),
    }
}

/// Returns the number of specimens of each class.
fn cases() -> u64 {
    match std::env::var("STICTION_CASES") {
        Ok(text) => text.parse().expect("STICTION_CASES is a number"),
        Err(_) => 20,
    }
}

/// Evaluates an identity on specimens of all classes, and panics with the smallest counterexample.
/// The identity must apply to at least the fraction `enough` of the specimens.
pub(crate) fn try_everywhere(name: &str, enough: f64, identity: Identity) {
    let (mut held, mut tried) = (0, 0);
    let mut apart = BTreeMap::<_, u64>::new();
    for class in CLASSES {
        for seed in 0..cases() {
            let specimen = Specimen::random(class, seed);
            tried += 1;
            match verdict(identity, &specimen) {
                Verdict::Holds => held += 1,
                Verdict::Apart(reason) => {
                    *apart.entry((format!("{class:?}"), reason)).or_default() += 1
                }
                Verdict::Broken(why) => {
                    println!("{name}: {class:?} {seed}: {why}");
                    report(name, identity, &specimen)
                }
            }
        }
    }
    println!("{name}: held on {held} of {tried}; apart: {apart:?}");
    assert!(f64::from(held) >= enough * f64::from(tried), "{name}: {held} of {tried}; {apart:?}");
}

/// Reduces the specimen that violates the identity, writes it to a file, and panics.
fn report(name: &str, identity: Identity, specimen: &Specimen) -> ! {
    let small = shrink(identity, specimen);
    let Verdict::Broken(why) = verdict(identity, &small) else {
        unreachable!("it was kept broken")
    };
    let file = small.file();
    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!(
        "{}-{:?}-{}.toml",
        name.replace(' ', "-"),
        specimen.class,
        specimen.seed
    ));
    std::fs::write(&path, &file).expect("the folder for tests can be written");
    panic!("{name} does not hold: {why}\n{}:\n{file}", path.display());
}
