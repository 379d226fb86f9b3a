//! A wrong law is detected, and its counterexample is small and readable.

use crate::identities::harness::{Verdict, verdict};
use crate::identities::shrink::shrink;
use crate::identities::solve::solve;
use crate::identities::specimen::Specimen;
use crate::mechanisms::random::Class;
use stiction_format::{Source, read};

/// States "Friction never decreases an actuator force", which is wrong for an actuator that holds a
/// weight while it sinks.
fn friction_costs(specimen: &Specimen) -> Result<Verdict, Verdict> {
    let forces = solve(&specimen.case())?.forces;
    let pairs = forces.efforts.iter().zip(&forces.efforts_frictionless);
    let smaller = pairs.clone().any(|(with, without)| with.abs() < without.abs() - 1e-3);
    Ok(if smaller { Verdict::Broken(format!("{pairs:?}")) } else { Verdict::Holds })
}

#[test]
fn a_wrong_law_is_reduced_to_a_joint() {
    let mut found = 0;
    for class in [Class::Tree, Class::Nested, Class::Parallel] {
        let mut specimens = (0..20).map(|seed| Specimen::random(class, seed));
        let broken = |s: &Specimen| matches!(verdict(friction_costs, s), Verdict::Broken(_));
        let Some(large) = specimens.find(broken) else { continue };
        let small = shrink(friction_costs, &large);
        assert!(broken(&small), "it is still a counterexample");
        let bodies = small.draft.bodies.len();
        assert!(bodies == 1 || bodies < large.draft.bodies.len(), "{class:?}: {bodies}");
        let frictions: usize = small.draft.joints.iter().map(|joint| joint.friction.len()).sum();
        assert_eq!(frictions, 1, "one friction is enough");

        // The reader accepts the written file.
        let file = small.file();
        let model = read(&Source::new("small.toml", file.as_str()), &|_| Err("no files".into()))
            .unwrap_or_else(|diagnostics| panic!("{diagnostics}\n{file}"));
        assert_eq!(model.mechanism.joints().len(), small.draft.joints.len());
        found += 1;
    }
    assert!(found >= 2, "{found}");
}
