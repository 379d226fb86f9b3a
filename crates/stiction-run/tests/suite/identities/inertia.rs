//! Dependence of actuator forces on accelerations and loads, without friction.

use crate::identities::harness::{Verdict, try_everywhere};
use crate::identities::solve::{TOLERANCE, agree, solve};
use crate::identities::specimen::Specimen;
use crate::mechanisms::random::{Case, Class};
use nalgebra::DMatrix;
use stiction_core::dynamics::AppliedLoad;
use stiction_core::kinematics::{Coordinate, Target};

/// Tests that the derivatives of actuator forces with respect to the accelerations of the actuated
/// coordinates form the mass matrix: symmetric and positive definite.
#[test]
fn inertia_is_symmetric_and_positive() {
    fn identity(specimen: &Specimen) -> Result<Verdict, Verdict> {
        let case = specimen.case();
        let driven: Vec<Coordinate> = case
            .mechanism
            .actuators()
            .map(|(joint, dof)| Coordinate::Joint { joint, dof })
            .collect();
        if driven.len() != case.coordinates.len()
            || !driven.iter().all(|coordinate| case.coordinates.contains(coordinate))
        {
            return Err(Verdict::Apart("prescribed is not what is driven"));
        }
        let place: Vec<usize> = driven
            .iter()
            .map(|driven| case.coordinates.iter().position(|c| c == driven).expect("it is there"))
            .collect();
        let mut largest = 0.0_f64;
        let mut drives = |column: Option<usize>| {
            let mut case = Case { targets: case.targets.clone(), ..specimen.case() };
            for (k, target) in case.targets.iter_mut().enumerate() {
                target.acceleration = if Some(k) == column { 1.0 } else { 0.0 };
            }
            let solved = solve(&case)?;
            largest = largest.max(solved.numbers().largest);
            Ok::<_, Verdict>(solved.forces.efforts_frictionless)
        };
        let rest = drives(None)?;
        let n = driven.len();
        let mut matrix = DMatrix::<f64>::zeros(n, n);
        for column in 0..n {
            let moved = drives(Some(place[column]))?;
            for row in 0..n {
                matrix[(row, column)] = moved[row] - rest[row];
            }
        }
        // Differences of actuator forces contain the rounding errors of the forces.
        let asymmetry = (&matrix - matrix.transpose()).amax();
        if asymmetry > 1e-11 * largest {
            return Ok(Verdict::Broken(format!(
                "asymmetric by {asymmetry:e} of {largest:e}: {matrix}"
            )));
        }
        let least = matrix.symmetric_eigenvalues().min();
        let holds = least > -1e-11 * largest;
        Ok(if holds {
            Verdict::Holds
        } else {
            Verdict::Broken(format!("eigenvalue {least:e}: {matrix}"))
        })
    }
    try_everywhere("inertia is symmetric and positive", 0.4, identity);
}

/// Tests superposition: without friction, actuator forces are the sum of the forces for the motion
/// without loads and, for each load, the change of the forces due to this load.
#[test]
fn loads_superpose() {
    fn identity(specimen: &Specimen) -> Result<Verdict, Verdict> {
        let case = specimen.case();
        let with = |loads: &[AppliedLoad<f64>]| {
            let case = Case { loads: loads.to_vec(), ..specimen.case() };
            solve(&case)
        };
        let (none, all) = (with(&[])?, with(&case.loads)?);
        let mut largest = none.numbers().largest.max(all.numbers().largest);
        let none = none.forces.efforts_frictionless;
        let mut sum = none.clone();
        for load in &case.loads {
            let alone = with(&[*load])?;
            largest = largest.max(alone.numbers().largest);
            let alone = alone.forces.efforts_frictionless;
            for ((sum, alone), none) in sum.iter_mut().zip(alone).zip(&none) {
                *sum += alone - none;
            }
        }
        Ok(agree("drive", &all.forces.efforts_frictionless, &sum, largest, TOLERANCE))
    }
    try_everywhere("loads superpose", 0.5, identity);
}

/// Tests that rates enter quadratically: reversing all rates does not change frictionless actuator
/// forces. At rest, without gravity and loads, the actuator forces vanish.
#[test]
fn rates_enter_by_their_squares() {
    fn identity(specimen: &Specimen) -> Result<Verdict, Verdict> {
        if specimen.class == Class::RedundantlyActuated {
            return Err(Verdict::Apart("drives that share a load"));
        }
        let mut largest = 0.0_f64;
        let mut with = |factor: f64| {
            let mut case = specimen.case();
            for target in &mut case.targets {
                *target = Target { rate: factor * target.rate, ..*target };
            }
            let solved = solve(&case)?;
            largest = largest.max(solved.numbers().largest);
            Ok::<_, Verdict>(solved.forces.efforts_frictionless)
        };
        let (rest, once, back, twice) = (with(0.0)?, with(1.0)?, with(-1.0)?, with(2.0)?);
        let quadrupled: Vec<f64> =
            rest.iter().zip(&once).map(|(rest, once)| rest + 4.0 * (once - rest)).collect();
        Ok(agree("drive backward", &once, &back, largest, TOLERANCE)
            .and(|| agree("drive at twice the rates", &twice, &quadrupled, largest, TOLERANCE)))
    }
    try_everywhere("rates enter by their squares", 0.4, identity);
}
