//! Section 5 of the paper: friction in all joints, equation (28), and what should stand in their place.

use super::kinematics::{angle_jacobian, inverse_jacobian, joint_rates, leg_motion};
use super::lagrangian::drives_of;
use super::reactions::{Form, System};
use super::robot::{Load, Motion, Robot};
use nalgebra::DVector;

/// For each leg a number for its P, R and S joint.
pub(super) type OfJoints = [[f64; 3]; 3];

/// How friction is brought into the driving forces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Method {
    /// Friction and reactions in balance with each other.
    Converged,
    /// Friction from the frictionless reactions, once, by virtual work.
    OnePass,
    /// Equation (28) with displacements from these legs' positions: lengths, turns of R, turns of S.
    Literal([[f64; 3]; 3]),
    /// As `Converged`, but only the prismatic joints rub.
    PrismaticOnly,
    /// As `OnePass`, but the torques of section 5.1 as printed: forces, in which the radius is missing.
    WithoutRadius,
}

/// The unnumbered equations of section 5.1: friction of a joint with its rate's sign. Of P in N; of R
/// and S the torque in N m, which is the force at the surface times its radius; the paper's T_R and
/// T_S lack that factor.
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

/// The sign of a number, zero of zero.
pub(super) fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

/// What a method gives at one instant.
#[derive(Clone, Copy, Debug)]
pub(super) struct Result {
    /// Driving forces, N.
    pub(super) drives: [f64; 3],
    /// The same without friction, N.
    pub(super) ideal: [f64; 3],
    /// Friction of all joints.
    pub(super) friction: OfJoints,
    /// Their rates.
    pub(super) rates: OfJoints,
    /// How many times the reactions were computed.
    pub(super) passes: usize,
}

impl Result {
    /// What friction adds to the driving forces, N.
    pub(super) fn change(&self) -> [f64; 3] {
        core::array::from_fn(|n| self.drives[n] - self.ideal[n])
    }

    /// The power of that addition, W: what it does to the energy of the world.
    pub(super) fn power_of_change(&self) -> f64 {
        let change = self.change();
        (0..3).map(|n| change[n] * self.rates[n][0]).sum()
    }
}

/// Passes after which the balance of friction and reactions is given up: it contracts by 0.2 and
/// better at the paper's coefficient.
const MOST_PASSES: usize = 200;

/// The driving forces by one of the methods. None where the system is singular or does not settle.
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
                // Rounding stops it falling.
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

/// Derivatives of the rates of P, R and S of leg n by those of (x, z, theta).
fn shares(robot: &Robot, motion: &Motion) -> [[[f64; 3]; 3]; 3] {
    let (lengths, angles) =
        (inverse_jacobian(robot, motion.pose), angle_jacobian(robot, motion.pose));
    core::array::from_fn(|n| {
        let turn = angles[n].map(|a| -a);
        [lengths[n], turn, [-turn[0], -turn[1], -1.0 - turn[2]]]
    })
}

/// The generalised force (x, z, theta) that overcomes frictions: their virtual work. It belongs in the
/// place of equation (28).
pub(super) fn virtual_work(robot: &Robot, motion: &Motion, friction: &OfJoints) -> [f64; 3] {
    let shares = shares(robot, motion);
    core::array::from_fn(|i| {
        (0..3).map(|n| (0..3).map(|j| friction[n][j] * shares[n][j][i]).sum::<f64>()).sum()
    })
}

/// Equation (28) to the letter: what the term -|f_P dq + T_R dphi_R + T_S dphi_S| of L' adds to
/// Lagrange's equations, loads taken as given and torques with their radii. With displacements d from
/// `from`, the viscous part f_v q' d gives d/dt (f_v d) - f_v q' = 0: it cancels. What is left is the
/// Coulomb part with the sign of the sum in the bars in place of that of the motion.
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

/// Length of each leg, its turn at R, the platform's turn at S; m and rad.
pub(super) fn displacements(robot: &Robot, motion: &Motion) -> OfJoints {
    let platform = core::f64::consts::FRAC_PI_2 - motion.pose[2];
    core::array::from_fn(|n| {
        let leg = leg_motion(robot, n, motion);
        [leg.length[0], leg.turn[0], platform - leg.turn[0]]
    })
}
