//! Section 5 of the paper: friction in all joints, equation (28) and its replacement.

use super::kinematics::{angle_jacobian, inverse_jacobian, joint_rates, leg_motion};
use super::lagrangian::drives_of;
use super::reactions::{Form, System};
use super::robot::{Load, Motion, Robot};
use nalgebra::DVector;

/// One number for the P, R and S joint of each leg.
pub(super) type OfJoints = [[f64; 3]; 3];

/// Method of including friction in the actuator forces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Method {
    /// Friction and reactions computed together, iterated to convergence.
    Converged,
    /// Friction from the frictionless reactions in a single pass, by virtual work.
    OnePass,
    /// Equation (28) with displacements from these leg positions: lengths, rotations of R,
    /// rotations of S.
    Literal([[f64; 3]; 3]),
    /// Converged friction, but only in the prismatic joints.
    PrismaticOnly,
    /// Single pass with the torques of section 5.1 as printed: forces, without the radius.
    WithoutRadius,
}

/// Joint friction with the sign of its rate, by the unnumbered equations of section 5.1. For P the
/// force in N; for R and S the torque in N m, the force at the surface times its radius. The
/// paper's T_R and T_S lack this factor.
pub(super) fn joint_friction(
    robot: &Robot,
    rates: &OfJoints,
    loads: &OfJoints,
    with_radius: bool,
) -> OfJoints {
    let radius = [1.0, robot.radius[0], robot.radius[1]];
    core::array::from_fn(|n| {
        core::array::from_fn(|j| {
            let (rate, r) = (rates[n][j], radius[j]);
            let force = robot.viscous * r * rate + robot.mu * loads[n][j] * sign(rate);
            if with_radius { r * force } else { force }
        })
    })
}

/// Sign of a number; zero for zero.
pub(super) fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

/// Results of a method at one instant.
#[derive(Clone, Copy, Debug)]
pub(super) struct Result {
    /// Actuator forces, N.
    pub(super) drives: [f64; 3],
    /// Frictionless actuator forces, N.
    pub(super) ideal: [f64; 3],
    /// Friction of all joints, N for P, N m for R and S.
    pub(super) friction: OfJoints,
    /// Rates of the joints.
    pub(super) rates: OfJoints,
    /// Number of evaluations of the reactions.
    pub(super) passes: usize,
}

impl Result {
    /// Friction contributions to the actuator forces, N.
    pub(super) fn change(&self) -> [f64; 3] {
        core::array::from_fn(|n| self.drives[n] - self.ideal[n])
    }

    /// Mechanical power of the friction contributions, W.
    pub(super) fn power_of_change(&self) -> f64 {
        let change = self.change();
        (0..3).map(|n| change[n] * self.rates[n][0]).sum()
    }
}

/// Maximum number of passes. The iteration contracts by a factor of 0.2 or better at the paper's
/// friction coefficient.
const MOST_PASSES: usize = 200;

/// Actuator forces by one of the methods; `None` if the system is singular or the iteration does
/// not converge.
pub(super) fn driving_forces_with_friction(
    robot: &Robot,
    motion: &Motion,
    load: Load,
    method: Method,
) -> Option<Result> {
    let system = System::new(robot, motion, load, Form::Corrected);
    let lu = system.matrix.clone().lu();
    let solve = |right: &DVector<f64>| lu.solve(right).filter(|y| y.iter().all(|v| v.is_finite()));
    let frictionless = solve(&system.right)?;
    let ideal = System::drives(&frictionless);
    let rates = joint_rates(robot, motion);
    let loads = System::loads(&frictionless);
    let result = |drives, friction, passes| Result { drives, ideal, friction, rates, passes };
    match method {
        Method::OnePass | Method::WithoutRadius => {
            let friction = joint_friction(robot, &rates, &loads, method == Method::OnePass);
            let change = drives_of(robot, motion.pose, virtual_work(robot, motion, &friction))?;
            Some(result(add(ideal, change), friction, 1))
        }
        Method::Literal(from) => {
            let friction = joint_friction(robot, &rates, &loads, true);
            let force = energy_of_friction(robot, motion, &rates, &loads, from);
            let change = drives_of(robot, motion.pose, force)?;
            Some(result(add(ideal, change), friction, 1))
        }
        Method::Converged | Method::PrismaticOnly => {
            let mut loads = loads;
            let mut last = f64::INFINITY;
            for pass in 1..=MOST_PASSES {
                let mut friction = joint_friction(robot, &rates, &loads, true);
                if method == Method::PrismaticOnly {
                    friction.iter_mut().for_each(|leg| leg[1..].fill(0.0));
                }
                let mut right = system.right.clone();
                system.add_friction(&friction, &mut right);
                let unknowns = solve(&right)?;
                let now = System::loads(&unknowns);
                let change = greatest_difference(&now, &loads);
                loads = now;
                // Rounding limits further convergence.
                if change == 0.0 || (change >= last && change < 1e-10) {
                    return Some(result(System::drives(&unknowns), friction, pass));
                }
                last = change;
            }
            None
        }
    }
}

fn add(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    core::array::from_fn(|n| a[n] + b[n])
}

fn greatest_difference(a: &OfJoints, b: &OfJoints) -> f64 {
    a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Derivatives of the P, R and S rates of leg n with respect to the rates of (x, z, theta).
fn shares(robot: &Robot, motion: &Motion) -> [[[f64; 3]; 3]; 3] {
    let (lengths, angles) =
        (inverse_jacobian(robot, motion.pose), angle_jacobian(robot, motion.pose));
    core::array::from_fn(|n| {
        let turn = angles[n].map(|a| -a);
        [lengths[n], turn, [-turn[0], -turn[1], -1.0 - turn[2]]]
    })
}

/// Generalised force (x, z, theta) that overcomes the friction, by virtual work. It replaces
/// equation (28).
pub(super) fn virtual_work(robot: &Robot, motion: &Motion, friction: &OfJoints) -> [f64; 3] {
    let shares = shares(robot, motion);
    core::array::from_fn(|i| {
        (0..3).map(|n| (0..3).map(|j| friction[n][j] * shares[n][j][i]).sum::<f64>()).sum()
    })
}

/// Equation (28) as printed: the contribution of the term -|f_P dq + T_R dphi_R + T_S dphi_S| of L'
/// to Lagrange's equations, with constant normal loads and with the radii in the torques. With
/// displacements d from `from`, the viscous part f_v q' cancels: d/dt (f_v d) - f_v q' = 0. The
/// Coulomb part remains, with the sign of the sum between the bars instead of that of the motion.
pub(super) fn energy_of_friction(
    robot: &Robot,
    motion: &Motion,
    rates: &OfJoints,
    loads: &OfJoints,
    from: [[f64; 3]; 3],
) -> [f64; 3] {
    let friction = joint_friction(robot, rates, loads, true);
    let coulomb = joint_friction(&Robot { viscous: 0.0, ..robot.clone() }, rates, loads, true);
    let now = displacements(robot, motion);
    let shares = shares(robot, motion);
    let mut force = [0.0; 3];
    for n in 0..3 {
        let work: f64 = (0..3).map(|j| friction[n][j] * (now[n][j] - from[n][j])).sum();
        for j in 0..3 {
            for i in 0..3 {
                force[i] += sign(work) * coulomb[n][j] * shares[n][j][i];
            }
        }
    }
    force
}

/// Length of each leg, its rotation at R, and the platform's rotation at S; m and rad.
pub(super) fn displacements(robot: &Robot, motion: &Motion) -> OfJoints {
    let platform = core::f64::consts::FRAC_PI_2 - motion.pose[2];
    core::array::from_fn(|n| {
        let leg = leg_motion(robot, n, motion);
        [leg.length[0], leg.turn[0], platform - leg.turn[0]]
    })
}
