//! Mobility and static determinacy compared with exact arithmetic.

use crate::common::random::Random;
use crate::exact::Drawing;
use crate::exact::classes::{CLASSES, Class, drawing};
use crate::exact::modular::{PRIMES, RowSpace, is_prime};
use crate::exact::solver::assembled;
use crate::exact::verdicts::Verdicts;
use stiction_core::dynamics::InverseDynamics;
use stiction_core::mobility::Mobility;
use stiction_core::statics::Constraints;

/// Below this value, a singularity index counts as zero in reports.
const SINGULAR: f64 = 1e-9;
/// A smallest singular value below this value is reported as uncertain.
const HARDLY: f64 = 1e-6;

/// Compares all results with the exact ones. Returns `false` if the report calls the mobility
/// uncertain.
fn agrees(drawing: &Drawing, solver: &InverseDynamics, what: &str) -> bool {
    let exact = Verdicts::of(drawing);
    let found = Mobility::of(solver);
    if found.gap.0.is_some_and(|kept| kept < HARDLY) {
        return false;
    }
    let context = || format!("{what}\n{drawing:?}\n{exact:?}\n{found:?}");
    assert_eq!(found.gruebler, drawing.gruebler(), "{}", context());
    assert_eq!(found.instantaneous, exact.mobility, "mobility {}", context());
    assert_eq!(found.redundant_constraints, exact.redundant, "redundant {}", context());
    assert!(found.finite.greatest <= exact.mobility, "finite {}", context());
    if exact.redundant == 0 {
        assert_eq!(found.finite.decided(), Some(exact.mobility), "regular {}", context());
    }
    for (body, &motions) in found.bodies.iter().zip(&exact.motions) {
        let told = body.motions.len() + body.first_order_only.len();
        assert_eq!(told, motions, "{body:?} {}", context());
    }

    let statics = solver.statics();
    let equations = 6 * drawing.coms.len();
    assert_eq!(statics.rank(), exact.rank, "rank {}", context());
    assert_eq!(statics.redundancy(), exact.free_unknowns, "unknowns {}", context());
    assert_eq!(statics.determined_reactions(), exact.determined, "reactions {}", context());
    assert_eq!(statics.determined_drives(), exact.drives, "drives {}", context());
    let singular = statics.actuation_distance(0) < SINGULAR;
    assert_eq!(singular, exact.rank < equations, "actuation {}", context());

    let constraints = Constraints::new(&statics);
    assert_eq!(constraints.mobility(), exact.mobility, "constraints {}", context());
    assert_eq!(constraints.self_stresses().len(), exact.redundant, "stresses {}", context());
    assert!(constraints.distance(exact.mobility) > SINGULAR, "{}", context());
    if exact.mobility > 0 {
        assert!(constraints.distance(exact.mobility - 1) < SINGULAR, "{}", context());
    }
    let leg = constraints.leg_distance(0).map(|distance| distance < SINGULAR);
    assert_eq!(leg, exact.leg_singular, "leg {}", context());
    true
}

/// Tests the seeds of one class; counts the uncertain and the special mechanisms.
fn examine(class: Class, seeds: std::ops::Range<u64>) {
    let (mut hardly, mut redundant, mut mobile, mut undetermined) = (0, 0, 0, 0);
    let count = seeds.end - seeds.start;
    for seed in seeds {
        let mut random = Random(seed);
        let drawing = drawing(class, &mut random);
        let solver = assembled(&drawing, &mut random);
        hardly += usize::from(!agrees(&drawing, &solver, &format!("{class:?} {seed}")));
        let exact = Verdicts::of(&drawing);
        redundant += u64::from(exact.redundant > 0);
        mobile += u64::from(exact.mobility > 0);
        undetermined += u64::from(exact.drives.contains(&false));
    }
    println!("{class:?}: {count}, {redundant} redundant, {mobile} mobile, {undetermined} drives");
    assert_eq!(hardly, 0, "{class:?}");
    // Each class contains both regular and singular mechanisms.
    assert!(5 * redundant > count && 5 * mobile > count && 20 * undetermined > count, "{class:?}");
}

macro_rules! classes {
    ($($name:ident $class:ident $seeds:expr;)*) => {$(
        #[test]
        fn $name() {
            examine(Class::$class, 0..$seeds);
        }
    )*};
}

classes! {
    loops Loop 600;
    parallel_robots Parallel 300;
    equal_legs EqualLegs 400;
    planar_linkages Planar 400;
    spherical_linkages Spherical 400;
    flat_linkages Flat 400;
    ladders Ladder 400;
    mixed_graphs Mixed 500;
}

#[test]
fn the_oracle_itself() {
    assert_eq!(CLASSES.len(), 8);
    for prime in PRIMES {
        assert!(is_prime(prime));
        assert!(!is_prime(prime - 2));
        // Rank two: the third row is the sum of the first two, the last row is twice the first.
        let rows = [vec![1, -2, 3, 0], vec![0, 5, 0, -7], vec![1, 3, 3, -7], vec![2, -4, 6, 0]];
        let space = RowSpace::of(prime, 4, &rows);
        assert_eq!(space.rank(), 2);
        assert!(space.contains(&[3, -1, 9, -7]) && !space.contains(&[3, -1, 9, -6]));
    }
}
