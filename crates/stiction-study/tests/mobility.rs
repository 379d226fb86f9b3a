//! Degrees of freedom of the gallery's robots, counted three ways.

mod common;

use common::*;
use stiction::dynamics::{InverseDynamics, Settings};
use stiction::mobility::Mobility;
use stiction_model::Model;

fn mobility(model: &Model) -> Mobility {
    let motion = model.motion(model.default_motion.as_ref().unwrap()).unwrap();
    let coordinates: Vec<_> = motion.coordinates.iter().map(|(c, _)| *c).collect();
    let targets: Vec<_> = motion.at(motion.start + 0.1 * motion.duration).collect();
    let (mechanism, homes) = (model.mechanism.clone(), &model.homes);
    let solver =
        InverseDynamics::new(mechanism, homes, &coordinates, &targets, Settings::default());
    Mobility::of(&solver.unwrap())
}

fn freedoms(name: &str, body: &str) -> (Vec<String>, Vec<String>) {
    let found = mobility(&model(name)).bodies.into_iter().find(|known| known.body == body);
    found.map(|body| (body.motions, body.first_order_only)).unwrap()
}

#[test]
fn what_bodies_can_do_in_words() {
    let (lasting, brief) = freedoms("zhang2018", "platform");
    assert_eq!(lasting, ["translation along x", "translation along z", "rotation about y"]);
    assert_eq!(brief.len(), 1);
    assert!(brief[0].starts_with("rotation about x through "), "{brief:?}");
    let (lasting, brief) = freedoms("3rrr", "platform");
    assert_eq!(lasting, ["translation along x", "translation along y", "rotation about z"]);
    assert!(brief.is_empty());
    let (lasting, _) = freedoms("slider-crank", "slider");
    assert_eq!(lasting, ["translation along x"]);
    let (lasting, _) = freedoms("slider-crank", "crank");
    assert_eq!(lasting, ["rotation about z through (0, 0, 0) m"]);
    let (lasting, _) = freedoms("gough", "platform");
    assert_eq!(lasting.len(), 6);
}

/// Gruebler's count, instantaneous, finite, redundant constraints.
#[test]
fn of_the_gallery() {
    let known = [
        // The robot as printed: its three constraint forces are parallel and in one plane, so the
        // platform rolls to first order, and to first order only.
        ("zhang2018", 3, 4, 3, 1),
        ("zhang2018-regular", 3, 3, 3, 0),
        ("3rps", 3, 3, 3, 0),
        ("gough", 6, 6, 6, 0),
        ("four-bar", -2, 1, 1, 3),
        ("slider-crank", -2, 1, 1, 3),
        ("five-bar", -1, 2, 2, 3),
        ("3rrr", -3, 3, 3, 6),
        ("bricard", 0, 1, 1, 1),
        ("6sps", 12, 12, 12, 0),
    ];
    for (name, gruebler, instantaneous, finite, redundant) in known {
        let found = mobility(&model(name));
        let counts =
            (found.gruebler, found.instantaneous, found.finite, found.redundant_constraints);
        assert_eq!(counts, (gruebler, instantaneous, finite, redundant), "{name} {found:?}");
        let (kept, dropped) = found.gap;
        assert!(kept.unwrap() > 1e-4 && dropped.is_none_or(|d| d < 1e-12), "{name} {found:?}");
    }
}
