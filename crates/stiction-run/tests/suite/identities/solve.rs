//! Solution of a case by inverse dynamics. A case is rejected if rounding errors dominate the
//! result.

use crate::identities::harness::Verdict;
use crate::identities::specimen::Solver;
use crate::mechanisms::random::Case;
use stiction_core::dynamics::{Forces, InverseDynamics, InverseError, Settings};
use stiction_core::kinematics::AssemblyError;
use stiction_core::topology::TreeRule;

/// Result of inverse dynamics for a case.
pub(crate) struct Solved {
    pub(crate) solver: Solver,
    pub(crate) forces: Forces,
}

/// Solves a case by inverse dynamics; returns a reason if rounding errors dominate the forces.
pub(crate) fn solve(case: &Case) -> Result<Solved, Verdict> {
    solve_with(case, TreeRule::Structure)
}

/// Solves a case with a given spanning tree.
pub(crate) fn solve_with(case: &Case, rule: TreeRule) -> Result<Solved, Verdict> {
    let (mechanism, settings) = (case.mechanism.clone(), Settings::default());
    let solver = InverseDynamics::with_tree(
        mechanism,
        rule,
        &[],
        &case.coordinates,
        &case.targets,
        settings,
    );
    let mut solver = match solver {
        Err(AssemblyError::Open { .. }) => return Err(Verdict::Apart("not all is prescribed")),
        // A reduced specimen may have no degree of freedom left.
        Err(AssemblyError::Contradiction { .. }) => {
            return Err(Verdict::Apart("it cannot move as prescribed"));
        }
        Err(error) => return Err(Verdict::Broken(format!("assembly: {error}"))),
        Ok(solver) => solver,
    };
    let statics = solver.statics();
    let Some(&smallest) = statics.singular_values()[..statics.rank()].last() else {
        return Err(Verdict::Apart("nothing moves"));
    };
    if smallest < 1e-2 || statics.open_motions() > solver.constraints().spins().len() {
        return Err(Verdict::Apart("nearly singular"));
    }
    // Prescribed coordinates may determine the platform's pose poorly, which also amplifies
    // rounding errors.
    if solver.bodies().twist.iter().any(|twist| twist.angular.norm() > 100.0) {
        return Err(Verdict::Apart("badly prescribed"));
    }
    let forces = match solver.solve(&case.loads) {
        Err(InverseError::Locked { .. }) => return Err(Verdict::Apart("locked")),
        Err(error) => return Err(Verdict::Broken(format!("inverse dynamics: {error}"))),
        Ok(forces) => forces.clone(),
    };
    let largest = |drives: &[f64]| {
        let lengths = (0..drives.len()).map(|actuator| per_length(case, actuator));
        drives.iter().zip(lengths).fold(0.0_f64, |max, (x, unit)| max.max((x / unit).abs()))
    };
    // Near self-locking, friction also amplifies rounding errors.
    if largest(&forces.efforts) > 20.0 * largest(&forces.efforts_frictionless) {
        return Err(Verdict::Apart("nearly locked"));
    }
    let solved = Solved { solver, forces };
    // Specimens whose forces are much larger than weights and loads are rejected; inertial forces
    // are not counted.
    let length = case.mechanism.characteristic_length();
    let weights = case.mechanism.bodies().iter().map(|b| b.mass * case.mechanism.gravity().norm());
    let loads = case.loads.iter().map(|load| load.force.norm() + load.moment.norm() / length);
    let reactions = solved.forces.reactions.iter();
    let largest = reactions.map(|(f, m)| f.norm().max(m.norm() / length)).fold(0.0, f64::max);
    if largest > 1e3 * weights.chain(loads).sum::<f64>() {
        return Err(Verdict::Apart("forces out of all proportion"));
    }
    Ok(solved)
}

/// Returns the characteristic length for an actuator torque, and 1 for an actuator force.
fn per_length(case: &Case, actuator: usize) -> f64 {
    if exerts_moment(case, actuator) { case.mechanism.characteristic_length() } else { 1.0 }
}

/// Returns true if the effort of an actuator is a torque.
pub(crate) fn exerts_moment(case: &Case, actuator: usize) -> bool {
    let (joint, dof) = case.mechanism.actuators().nth(actuator).expect("an actuator");
    let dofs = case.mechanism.joints()[joint.0].joint_type.dofs();
    !dofs[dof].translates()
}

/// Quantities compared between two descriptions of the same mechanism.
pub(crate) struct Numbers {
    pub(crate) drives: Vec<f64>,
    /// Normal load on each friction interface, N.
    pub(crate) loads: Vec<f64>,
    /// Largest force or moment anywhere in the mechanism. Rounding errors of other forces are
    /// relative to this value.
    pub(crate) largest: f64,
}

impl Solved {
    pub(crate) fn numbers(&self) -> Numbers {
        let loads: Vec<f64> =
            self.forces.interfaces.iter().map(|interface| interface.load).collect();
        let drives = self.forces.efforts.clone();
        let reactions = self.forces.reactions.iter().flat_map(|(f, m)| [f.norm(), m.norm()]);
        let all = reactions.chain(loads.iter().copied()).chain(drives.iter().copied());
        let largest = all.fold(1e-9_f64, |max, x| max.max(x.abs()));
        Numbers { drives, loads, largest }
    }
}

/// Checks that two lists agree within a fraction of `largest`.
pub(crate) fn agree(
    what: &str,
    expected: &[f64],
    found: &[f64],
    largest: f64,
    tolerance: f64,
) -> Verdict {
    if expected.len() != found.len() {
        return Verdict::Broken(format!("{what}: {} and {} numbers", expected.len(), found.len()));
    }
    for (place, (x, y)) in expected.iter().zip(found).enumerate() {
        let apart = (x - y).abs() / largest;
        // NaN differs from every value.
        if apart.is_nan() || apart > tolerance {
            return Verdict::Broken(format!(
                "{what} {place}: {x:e} and {y:e}, {apart:.1e} of {largest:e}"
            ));
        }
    }
    Verdict::Holds
}

/// Checks actuator forces and normal loads up to rounding errors, which the singularity index
/// amplifies.
pub(crate) fn same(expected: &Numbers, drives: &[f64], loads: &[f64]) -> Verdict {
    let largest = expected.largest;
    agree("drive", &expected.drives, drives, largest, TOLERANCE)
        .and(|| agree("load", &expected.loads, loads, largest, TOLERANCE))
}

/// Tolerance for rounding errors, amplified by a singularity index of 1e-2, by proximity to locking
/// and by about a hundred operations.
pub(crate) const TOLERANCE: f64 = 1e-11;
