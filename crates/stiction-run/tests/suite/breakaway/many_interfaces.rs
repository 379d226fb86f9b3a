//! Mechanisms with so many interfaces that the equations of the normal loads are solved in block
//! triangular form.

use crate::breakaway::{at_rest, near};
use stiction_core::dynamics::Verdict;

const G: f64 = 9.81;
const MU: f64 = 0.4;
const RADIUS: f64 = 0.02;

/// Creates a four-bar linkage beside a chain of pendulums with an actuator in each joint.
fn linkage_and_chain(pendulums: usize) -> String {
    let friction = format!("friction = {{ mu = {MU:?}, radius = {RADIUS:?} }}");
    let body = |name: &str, com: &str| {
        format!("[bodies.{name}]\nmass = 1\ncom = {com}\ninertia = [0.01, 0.01, 0.01]\n")
    };
    let joint = |name: &str, (from, to): (&str, &str), more: &str| {
        format!(
            "[joints.{name}]\ntype = \"R\"\nfrom = \"{from}\"\nto = \"{to}\"\naxis = \"y\"\n{friction}\n{more}\n"
        )
    };
    let mut parts = vec![
        "gravity = [0, 0, -9.81]\n".to_owned(),
        body("crank", "[0, 0, 0.1]"),
        body("coupler", "[0.5, 0, 0]"),
        body("rocker", "[0, 0, 0.1]"),
        joint("a", ("ground", "crank"), "actuated = true"),
        joint("b", ("crank", "coupler"), "at = [0, 0, 0.2]"),
        joint("c", ("coupler", "rocker"), "at = [1, 0, 0]\nto_at = [0, 0, 0.3]"),
        joint("d", ("ground", "rocker"), "at = [0.9, 0, 0]"),
    ];
    let mut motion = "[motions.rest]\nduration = 0\na = 0.3\n".to_owned();
    for k in 0..pendulums {
        let from = if k > 0 { format!("p{}", k - 1) } else { "ground".to_owned() };
        let at = if k > 0 { 0.1 } else { 2.0 };
        parts.push(body(&format!("p{k}"), "[0.05, 0, 0]"));
        let more = format!("at = [{at:?}, 0, 0]\nactuated = true");
        parts.push(joint(&format!("j{k}"), (&from, &format!("p{k}")), &more));
        motion += &format!("j{k} = 0.0\n");
    }
    let load = "[loads.side]\ncrank = { force = [3, 0, -2], at = [0, 0, 0.2] }\n";
    format!("{}{motion}{load}[default]\nmotion = \"rest\"\nload = \"side\"\n", parts.concat())
}

/// Tests that the linkage has the same results alone and beside a chain of 70 pendulums, and that
/// the results of the chain are those of its closed form.
#[test]
fn results_are_those_of_few_interfaces() {
    let pendulums = 70;
    let [alone, found] = [0, pendulums].map(|count| at_rest(&linkage_and_chain(count)));
    assert!(alone.forces.interfaces.len() <= 64 && found.forces.interfaces.len() > 64);
    let ends = |(low, high): (f64, f64)| [low, high];
    let pairs = [
        (alone.forces.effort_bounds[0], found.forces.effort_bounds[0]),
        (alone.forces.effort_outer_bounds[0], found.forces.effort_outer_bounds[0]),
        (alone.rest.breakaway[0].unwrap().forward, found.rest.breakaway[0].unwrap().forward),
        (alone.rest.breakaway[0].unwrap().backward, found.rest.breakaway[0].unwrap().backward),
        (alone.rest.alone[0].needed, found.rest.alone[0].needed),
    ];
    for (alone, found) in pairs {
        ends(found).into_iter().zip(ends(alone)).for_each(|(found, alone)| near(found, alone));
    }
    assert_eq!(alone.rest.alone[0].verdict, found.rest.alone[0].verdict);
    // The whole mechanism needs the friction that the most demanding of its parts needs.
    let each = found.rest.alone.iter().map(|holding| holding.needed.1);
    near(found.rest.unpowered.needed.1, each.fold(0.0, f64::max));
    assert_eq!(found.rest.unpowered.verdict, Verdict::Slips);
    for k in 0..pendulums {
        let carried = (pendulums - k) as f64 * G;
        let effort = found.forces.efforts[k + 1];
        let limit = MU * RADIUS * carried;
        let (low, high) = found.forces.effort_bounds[k + 1];
        near(low, effort - limit);
        near(high, effort + limit);
        near(found.rest.alone[k + 1].needed.0, effort.abs() / limit);
        near(found.rest.alone[k + 1].needed.1, effort.abs() / limit);
    }
}
