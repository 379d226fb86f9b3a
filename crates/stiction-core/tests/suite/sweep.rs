//! Results for friction beyond the limit of self-locking, on random mechanisms, compared with an
//! independent slow search. The search treats friction as loads on the bodies of a frictionless
//! mechanism and follows the solution in small steps; it shares no code with the solver's friction
//! coupling.

use crate::common::random::*;
use nalgebra::{DMatrix, DVector};
use stiction_core::dynamics::{
    AppliedLoad, FrictionMode, InverseDynamics, InverseError, LoadAxes, Settings,
};
use stiction_core::friction::InterfaceShape;
use stiction_core::joint::Carrier;
use stiction_core::mechanism::{BodyId, JointId};
use stiction_core::spatial::Vec3;

/// A friction interface in world coordinates.
struct Surface {
    joint: usize,
    shape: InterfaceShape,
    axis: Vec3<f64>,
    coefficient: f64,
    /// Friction at zero normal load, N.
    constant: f64,
    preload: f64,
    /// Loads on both bodies per newton of friction.
    unit: [AppliedLoad<f64>; 2],
}

/// Returns the component of a joint's force that loads a surface, without preload. The normal-load
/// maps in this test have no other terms.
fn pressing(surface: &Surface, force: Vec3<f64>) -> Vec3<f64> {
    match surface.shape {
        InterfaceShape::Ball => force,
        _ => force - surface.axis * force.dot(surface.axis),
    }
}

fn surfaces(solver: &InverseDynamics) -> Option<Vec<Surface>> {
    let (topology, parameters) = (solver.topology(), solver.parameters());
    let bodies = solver.bodies();
    let mut all = Vec::new();
    for interface in &parameters.interfaces {
        let joint = interface.joint;
        let (j, k) = (bodies.frame_j[joint], bodies.frame_k[joint]);
        let rates = bodies.joint_rates(topology, joint);
        let own = &rates[interface.shape.dofs()];
        let content = &solver.mechanism().joints()[joint];
        let (p, s) = (content.predecessor.0, content.successor.0);
        let at = |body: usize, force: Vec3<f64>, moment: Vec3<f64>| {
            let point = bodies.pose[body].inverse().apply(j.position);
            let axes = LoadAxes::World;
            AppliedLoad { body: BodyId(body), point, axes, force, moment }
        };
        let (axis, speed, force, moment) = match interface.shape {
            InterfaceShape::Pin { axis, carrier, .. } => {
                let frame = if carrier == Carrier::Predecessor { j } else { k };
                let axis = frame.rotation.columns[axis];
                let torque = axis * (-own[0].signum() * interface.radius);
                (axis, own[0] * interface.radius, Vec3::zero(), torque)
            }
            InterfaceShape::Guide { .. } => {
                let axis = j.rotation.columns[2];
                (axis, own[0], axis * -own[0].signum(), Vec3::zero())
            }
            InterfaceShape::Ball => {
                let relative = bodies.twist[s].angular - bodies.twist[p].angular;
                let torque = relative * (-interface.radius / relative.norm());
                (Vec3::unit(2), relative.norm() * interface.radius, Vec3::zero(), torque)
            }
            InterfaceShape::Sleeve => {
                let axis = j.rotation.columns[2];
                let surface = [own[0] * interface.radius, own[1]];
                let speed = surface[0].hypot(surface[1]);
                let along = surface.map(|v| -v / speed);
                (axis, speed, axis * along[1], axis * (along[0] * interface.radius))
            }
            // Threads and plates have their own tests.
            _ => return None,
        };
        all.push(Surface {
            joint,
            shape: interface.shape,
            axis,
            coefficient: interface.law.mu,
            constant: interface.law.viscous * speed.abs(),
            preload: interface.load.preload,
            unit: [at(s, force, moment), at(p, -force, -moment)],
        });
    }
    Some(all)
}

/// Computes reactions and actuator forces without friction under the given loads.
fn frictionless(
    solver: &mut InverseDynamics,
    loads: &[AppliedLoad<f64>],
) -> (Vec<Vec3<f64>>, Vec<f64>) {
    solver.settings_mut().friction = FrictionMode::Off;
    let forces = solver.solve(loads).unwrap();
    let found = (forces.reactions.iter().map(|r| r.0).collect(), forces.efforts.clone());
    solver.settings_mut().friction = FrictionMode::Converged;
    found
}

/// Finds the largest fraction of the friction coefficients with a solution, and the actuator forces
/// there.
fn search(
    solver: &mut InverseDynamics,
    loads: &[AppliedLoad<f64>],
    factor: f64,
) -> (f64, Vec<f64>) {
    const LONGEST: f64 = 2e-3;
    const SHORTEST: f64 = 1e-7;
    let surfaces = surfaces(solver).unwrap();
    let count = surfaces.len();
    let (base, base_drives) = frictionless(solver, loads);
    let mut responses = Vec::new();
    for surface in &surfaces {
        let with: Vec<_> = loads.iter().chain(&surface.unit).copied().collect();
        let (forces, drives) = frictionless(solver, &with);
        let forces: Vec<_> = forces.iter().zip(&base).map(|(a, b)| *a - *b).collect();
        let drives: Vec<f64> = drives.iter().zip(&base_drives).map(|(a, b)| a - b).collect();
        responses.push((forces, drives));
    }
    let friction = |loads: &DVector<f64>, part: f64, k: usize| {
        surfaces[k].constant + part * factor * surfaces[k].coefficient * loads[k]
    };
    let mut known = DVector::zeros(count);
    let mut reached = (0.0, base_drives.clone());
    let mut step = LONGEST;
    let mut next = 0.0;
    loop {
        let part: f64 = next;
        let mut loads = known.clone();
        let mut settled = false;
        for _ in 0..60 {
            let mut misfit = DVector::zeros(count);
            let mut matrix = DMatrix::identity(count, count);
            for (k, surface) in surfaces.iter().enumerate() {
                let force = (0..count).fold(base[surface.joint], |sum, l| {
                    sum + responses[l].0[surface.joint] * friction(&loads, part, l)
                });
                let pressing_now = pressing(surface, force);
                let size = pressing_now.norm();
                misfit[k] = loads[k] - surface.preload - size;
                for l in 0..count {
                    let change = pressing(surface, responses[l].0[surface.joint]);
                    let slope = if size > 0.0 { pressing_now.dot(change) / size } else { 0.0 };
                    matrix[(k, l)] -= slope * part * factor * surfaces[l].coefficient;
                }
            }
            let lu = matrix.lu();
            let Some(change) = lu.solve(&misfit) else { break };
            loads -= &change;
            if !loads.iter().all(|load| load.is_finite() && load.abs() < 1e12) {
                break;
            }
            if change.amax() <= 1e-11 * loads.amax() {
                settled = lu.determinant() > 0.0;
                break;
            }
        }
        if !settled {
            // Bisect towards the last fraction with a solution.
            step *= 0.5;
            if step < SHORTEST {
                break;
            }
            next = reached.0 + step;
            continue;
        }
        known = loads.clone();
        let drives = (0..base_drives.len()).map(|d| {
            (0..count)
                .fold(base_drives[d], |sum, l| sum + responses[l].1[d] * friction(&loads, part, l))
        });
        reached = (part, drives.collect());
        if part >= 1.0 {
            break;
        }
        next = f64::min(part + step, 1.0);
        step = f64::min(2.0 * step, LONGEST);
    }
    reached
}

#[test]
fn verdicts_on_friction_swept_past_the_limit() {
    let classes = [Class::Tree, Class::Loop, Class::Parallel, Class::Constrained, Class::Nested];
    let (mut mechanisms, mut solved, mut locked, mut differ) = (0, 0, 0, 0);
    for class in classes {
        for seed in 0..60 {
            let (_, case) = case(class, seed, 1.0);
            let settings = Settings { rest_speed: 1e-12, ..Settings::default() };
            let made = InverseDynamics::new(
                case.mechanism.clone(),
                &[],
                &case.coordinates,
                &case.targets,
                settings,
            );
            let Ok(mut solver) = made else { continue };
            let statics = solver.statics();
            let smallest = statics.singular_values()[statics.rank() - 1];
            if smallest < 1e-2
                || statics.open_motions() > 0
                || statics.redundancy() > 0
                || surfaces(&solver).is_none_or(|all| all.is_empty())
            {
                continue;
            }
            mechanisms += 1;
            for factor in [0.1, 0.5, 1.0, 3.0, 10.0] {
                // The same mechanism with all coefficients multiplied by a factor.
                let (_, scaled) = self::case(class, seed, factor);
                let mut scaled = InverseDynamics::new(
                    scaled.mechanism,
                    &[],
                    &case.coordinates,
                    &case.targets,
                    settings,
                )
                .unwrap();
                let outcome = scaled.solve(&case.loads).map(|forces| forces.efforts.clone());
                let (part, drives) = search(&mut solver, &case.loads, factor);
                let what = format!("{class:?} {seed} x{factor}");
                match outcome {
                    Ok(found) => {
                        solved += 1;
                        // The solution branch may end exactly at the given coefficients.
                        assert!(part > 0.99, "{what}: found, but lost at {part}");
                        let largest = drives.iter().fold(1e-9f64, |max, d| max.max(d.abs()));
                        let apart = found.iter().zip(&drives).map(|(a, b)| (a - b).abs());
                        let apart = apart.fold(0.0, f64::max) / largest;
                        differ += usize::from(part == 1.0 && apart > 1e-5);
                        assert!(part < 1.0 || apart < 1e-5, "{what}: {found:?} {drives:?}");
                    }
                    Err(InverseError::Locked { percent, joint }) => {
                        locked += 1;
                        assert!(case.mechanism.joint_id(&joint) >= Some(JointId(0)));
                        let error = percent / 100.0 - part;
                        assert!((-0.003..0.003).contains(&error), "{what}: {percent} % {part}");
                    }
                    Err(error) => panic!("{what}: {error}"),
                }
            }
        }
    }
    println!("{mechanisms} mechanisms: {solved} solved, {locked} locked, {differ} differ");
    assert!(mechanisms >= 80 && locked > 40 && solved > 200, "{mechanisms} {solved} {locked}");
}
