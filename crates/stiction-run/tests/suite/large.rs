//! Verdicts on large mechanisms, which sparse factors decide, against small ones and closed forms.

use crate::common::*;
use std::fmt::Write as _;
use stiction_core::dynamics::{FrictionMode, InverseDynamics, Settings};
use stiction_core::linalg::{Decomposition, Limit, Svd};
use stiction_core::statics::Constraints;
use stiction_format::gallery;
use stiction_run::check::{Findings, examine};

/// Planar four-bars in a row on the ground; the rocker of each is the crank of the next.
fn four_bars(count: usize) -> String {
    let mut text = "gravity = [0, 0, -9.81]\n".to_owned();
    for k in 0..=count {
        let _ = write!(
            text,
            "[bodies.c{k}]\nmass = 1\ncom = [0, 0, 0.1]\ninertia = [1e-3, 1e-3, 1e-3]\n\
             [joints.g{k}]\ntype = 'R'\nfrom = 'ground'\nto = 'c{k}'\nat = [{k}, 0, 0]\naxis = 'y'\n\
             actuated = {}\n",
            k == 0
        );
    }
    for k in 0..count {
        let next = k + 1;
        let _ = write!(
            text,
            "[bodies.k{k}]\nmass = 1\ncom = [0.5, 0, 0]\ninertia = [1e-2, 1e-2, 1e-2]\n\
             [joints.p{k}]\ntype = 'R'\nfrom = 'c{k}'\nto = 'k{k}'\nat = [0, 0, 0.2]\naxis = 'y'\n\
             [joints.q{k}]\ntype = 'R'\nfrom = 'k{k}'\nto = 'c{next}'\nat = [1, 0, 0]\n\
             to_at = [0, 0, 0.2]\naxis = 'y'\n"
        );
    }
    text + "[motions.m]\ng0 = '0.3 * sin(2 * pi * t)'\n[default]\nmotion = 'm'\n"
}

/// A chain of driven pendulums.
fn pendulums(count: usize) -> String {
    let mut text = "gravity = [0, 0, -9.81]\n".to_owned();
    let mut motion = String::new();
    for k in 0..count {
        let (from, at) = match k.checked_sub(1) {
            None => ("ground".to_owned(), 0.0),
            Some(last) => (format!("b{last}"), 0.1),
        };
        let _ = write!(
            text,
            "[bodies.b{k}]\nmass = 1\ncom = [0.05, 0, 0]\ninertia = [1e-3, 1e-3, 1e-3]\n\
             [joints.j{k}]\ntype = 'R'\nfrom = '{from}'\nto = 'b{k}'\naxis = 'y'\nat = [{at}, 0, 0]\n\
             actuated = true\n"
        );
        let _ = writeln!(motion, "j{k} = '{} * sin(2 * pi * t)'", 0.3 / count as f64);
    }
    text + "[motions.m]\n" + &motion + "[default]\nmotion = 'm'\n"
}

fn checked(text: &str, samples: f64) -> Findings {
    let model = model_of("large", text);
    let mut job = default_job(&model, FrictionMode::Off);
    job.step = Some(job.motion.duration / samples);
    examine(&job, |_, _, _| true).unwrap()
}

/// Each four-bar adds one DOF less than constraints would allow: three redundant ones. Its
/// self-stresses load its own four joints. The verdicts of a row of thirty are those of a row of
/// five, which a dense decomposition decides.
#[test]
fn rows_of_four_bars() {
    let [few, many] = [5, 30].map(|count| {
        let found = checked(&four_bars(count), 4.0);
        assert_eq!(found.mobility.instantaneous, 1);
        assert_eq!(found.mobility.finite.decided(), Some(1));
        assert_eq!(found.mobility.redundant_constraints, 3 * count);
        assert_eq!(found.self_stresses.len(), 3 * count);
        assert!(found.drives_unique && found.passed.is_empty());
        found
    });
    assert!(many.self_stresses.iter().all(|stress| stress.len() <= 4));
    let open = |found: &Findings, joint: &str| {
        let own = found.undetermined.iter().find(|(name, _)| name == joint);
        own.map(|(_, components)| components.clone())
    };
    // In the plane, forces are determined; across it, all six components of p and q depend on the
    // self-stresses like those of the short row.
    for (short, long) in [("g0", "g0"), ("p0", "p0"), ("q2", "q17"), ("g3", "g21"), ("g5", "g30")] {
        assert_eq!(open(&few, short), open(&many, long), "{short} {long}");
        assert!(open(&few, short).is_some());
    }
    assert_eq!(many.undetermined.len(), 31 + 2 * 30);
}

/// All forces of an open chain are determined; its actuation index is the smallest singular value of
/// the dense balance, and its constraints allow one motion at each joint.
#[test]
fn chains_of_pendulums() {
    let text = pendulums(40);
    let found = checked(&text, 2.0);
    assert_eq!(found.mobility.finite.decided(), Some(40));
    assert!(found.self_stresses.is_empty() && found.undetermined.is_empty());
    assert!(found.drives_unique);
    let model = model_of("large", &text);
    let motion = &model.motion("m").unwrap();
    let coordinates: Vec<_> = motion.coordinates.iter().map(|(own, _)| *own).collect();
    let targets: Vec<_> = motion.at(found.actuation.time).collect();
    let settings = Settings::default();
    let solver =
        InverseDynamics::new(model.mechanism.clone(), &[], &coordinates, &targets, settings);
    let statics = solver.unwrap().statics();
    let smallest = Svd::new(&statics.scaled_matrix().to_dense()).singular_values.min();
    // Round-off over the smallest singular value.
    assert!((found.actuation.least / smallest - 1.0).abs() < 1e-12 / smallest);
    let constraints = Constraints::new(&statics);
    assert_eq!(constraints.mobility(), 40);
}

/// Sparse factors decide the balance of every gallery model as the dense decomposition does.
#[test]
fn gallery() {
    for name in gallery::names() {
        let model = model(name);
        let motion = model.motion(model.default_motion.as_ref().unwrap()).unwrap();
        let coordinates: Vec<_> = motion.coordinates.iter().map(|(own, _)| *own).collect();
        // Away from reversals and symmetric positions.
        let time = motion.start + 0.07 * motion.duration;
        let targets: Vec<_> = motion.at(time).collect();
        let (homes, settings) = (&model.initial_poses, Settings::default());
        let mechanism = model.mechanism.clone();
        let solver = InverseDynamics::new(mechanism, homes, &coordinates, &targets, settings);
        let statics = solver.unwrap().statics();
        let matrix = statics.scaled_matrix();
        let single: Vec<usize> = (0..matrix.ncols()).collect();
        let sparse = Decomposition::sparse(matrix.clone(), &single, Limit::OfLargest(1e-10));
        assert!(sparse.is_sparse(), "{name}");
        assert_eq!(sparse.rank(), statics.rank(), "{name}");
        let smallest = Svd::new(&matrix.to_dense()).singular_values[statics.rank() - 1];
        let found = sparse.value(statics.rank() - 1);
        assert!((found / smallest - 1.0).abs() < 1e-12 / smallest, "{name}");
        let mut free = vec![0.0; matrix.ncols()];
        for (k, x) in sparse.null_space(sparse.rank()).into_iter().flatten() {
            free[k] += x * x;
        }
        let drives = statics.determined_drives();
        let first = free.len() - drives.len();
        for (own, drive) in free[first..].iter().zip(drives) {
            assert_eq!(own.sqrt() < 1e-8, drive, "{name}");
        }
    }
}
