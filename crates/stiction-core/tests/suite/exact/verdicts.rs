//! Properties of a drawing, computed exactly.

use super::modular::{PRIMES, RowSpace};
use super::{Drawing, Ints, Six, cross};

/// Minimum number of joints of a hub, as in the definition of a leg.
const HUB: usize = 3;

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Verdicts {
    pub mobility: usize,
    /// Number of independent self-stresses of the constraints alone.
    pub redundant: usize,
    /// Rank of the balance with actuators.
    pub rank: usize,
    /// Number of unknowns of the balance minus its rank.
    pub free_unknowns: usize,
    /// For each joint, whether force x y z and moment x y z about its origin are statically
    /// determinate.
    pub determined: Vec<[bool; 6]>,
    pub drives: Vec<bool>,
    /// Number of independent motions of each moving body.
    pub motions: Vec<usize>,
    /// True if bodies between hubs can move while the hubs are fixed; `None` without hubs or such
    /// bodies.
    pub leg_singular: Option<bool>,
}

impl Verdicts {
    pub fn of(drawing: &Drawing) -> Self {
        let [first, second] = PRIMES.map(|prime| Self::modulo(drawing, prime));
        assert_eq!(first, second, "both primes");
        first
    }

    fn modulo(drawing: &Drawing, prime: u64) -> Self {
        let equations = 6 * drawing.coms.len();
        let held = RowSpace::of(prime, equations, &drawing.constraint_rows());
        let mobility = equations - held.rank();
        // The same mobility from the loop conditions on the joint rates.
        let (dofs, rows) = drawing.loop_rows();
        assert_eq!(mobility, dofs - RowSpace::of(prime, dofs, &rows).rank(), "{drawing:?}");

        // The balance: one row per equation, one column per unknown.
        let unknowns = unknowns(drawing);
        let columns: Vec<Vec<i64>> =
            unknowns.iter().map(|&(j, w)| drawing.on_bodies(&drawing.joints[j], w)).collect();
        let rows: Vec<Vec<i64>> =
            (0..equations).map(|i| columns.iter().map(|column| column[i]).collect()).collect();
        let balance = RowSpace::of(prime, unknowns.len(), &rows);
        // A linear function of the unknowns is determinate if it is a linear combination of the
        // equations.
        let determined = (0..drawing.joints.len())
            .map(|joint| {
                let at = drawing.joints[joint].at;
                std::array::from_fn(|k| {
                    let row: Vec<i64> = unknowns
                        .iter()
                        .map(|&(j, wrench)| if j == joint { component(wrench, at, k) } else { 0 })
                        .collect();
                    balance.contains(&row)
                })
            })
            .collect();
        let drives = (drawing.constraints()..unknowns.len())
            .map(|k| balance.contains(&unit(k, unknowns.len())))
            .collect();
        let motions = (0..drawing.coms.len())
            .map(|body| {
                let mut with = held.clone();
                (6 * body..6 * body + 6).filter(|&k| with.insert(&unit(k, equations))).count()
            })
            .collect();
        Self {
            mobility,
            redundant: drawing.constraints() - held.rank(),
            rank: balance.rank(),
            free_unknowns: unknowns.len() - balance.rank(),
            determined,
            drives,
            motions,
            leg_singular: leg_singular(drawing, prime),
        }
    }
}

fn leg_singular(drawing: &Drawing, prime: u64) -> Option<bool> {
    // Without the bodies of open chains, one after the other.
    let mut ends: Vec<(usize, usize)> = drawing.joints.iter().map(|joint| joint.ends).collect();
    let bodies = 1..=drawing.coms.len();
    let joints_at = |ends: &[(usize, usize)], body: usize| {
        ends.iter().filter(|(a, b)| *a == body || *b == body).count()
    };
    while let Some(body) = bodies.clone().find(|body| joints_at(&ends, *body) == 1) {
        ends.retain(|(a, b)| *a != body && *b != body);
    }
    let of_legs: Vec<usize> = bodies
        .clone()
        .filter(|&body| (1..HUB).contains(&joints_at(&ends, body)))
        .flat_map(|body| 6 * (body - 1)..6 * body)
        .collect();
    if of_legs.is_empty() || bodies.clone().all(|body| joints_at(&ends, body) < HUB) {
        return None;
    }
    let rows: Vec<Vec<i64>> = drawing
        .constraint_rows()
        .iter()
        .map(|row| of_legs.iter().map(|&k| row[k]).collect())
        .collect();
    Some(RowSpace::of(prime, of_legs.len(), &rows).rank() < of_legs.len())
}

/// Lists joint and wrench of each unknown: constraints first, then actuators.
fn unknowns(drawing: &Drawing) -> Vec<(usize, Six)> {
    let joints = || drawing.joints.iter().enumerate();
    let constraints =
        joints().flat_map(|(j, joint)| joint.wrenches().into_iter().map(move |w| (j, w)));
    let drives =
        joints().flat_map(|(j, joint)| joint.actuated.iter().map(move |&k| (j, joint.effort(k))));
    constraints.chain(drives).collect()
}

/// Computes a component of a wrench: of its force, or of its moment about a point.
fn component(wrench: Six, at: Ints, k: usize) -> i64 {
    let [fx, fy, fz, mx, my, mz] = wrench;
    let force = [fx, fy, fz];
    match k {
        0..3 => force[k],
        _ => {
            let turned = cross(at, force);
            [mx, my, mz][k - 3] - turned[k - 3]
        }
    }
}

fn unit(k: usize, length: usize) -> Vec<i64> {
    let mut row = vec![0; length];
    row[k] = 1;
    row
}
