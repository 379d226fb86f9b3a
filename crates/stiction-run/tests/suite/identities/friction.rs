//! Properties of friction on random mechanisms.

use crate::identities::harness::{Verdict, try_everywhere};
use crate::identities::solve::solve;
use crate::identities::specimen::Specimen;
use crate::mechanisms::random::Case;
use stiction_core::friction::{Curve, Law};
use stiction_core::kinematics::Target;

/// Tests that friction dissipates power at every interface, and equals the friction law at the
/// normal load of the interface.
#[test]
fn friction_dissipates() {
    fn identity(specimen: &Specimen) -> Result<Verdict, Verdict> {
        let solved = solve(&specimen.case())?;
        let largest = solved
            .forces
            .interfaces
            .iter()
            .fold(1e-9_f64, |max, interface| max.max(interface.load));
        let wrong = solved.forces.interfaces.iter().enumerate().find(|(_, interface)| {
            let gives = interface.power < 0.0;
            let exceeds = interface.friction.abs() > interface.limit * (1.0 + 1e-12);
            gives || exceeds || interface.load < -1e-12 * largest || interface.load.is_nan()
        });
        Ok(wrong.map_or(Verdict::Holds, |wrong| Verdict::Broken(format!("{wrong:?}"))))
    }
    try_everywhere("friction dissipates", 0.5, identity);
}

/// Tests the limit of small friction. As the coefficients tend to zero, actuator forces tend
/// linearly to the frictionless forces: half of small coefficients yields half of the difference.
#[test]
fn small_friction_acts_in_proportion() {
    fn identity(specimen: &Specimen) -> Result<Verdict, Verdict> {
        const SMALL: f64 = 1e-7;
        let with = |factor: f64| {
            let mut specimen = specimen.clone();
            let interfaces = specimen.draft.joints.iter_mut().flat_map(|joint| &mut joint.friction);
            for interface in interfaces {
                weaken(&mut interface.law, factor);
                if let Some(law) = &mut interface.backward {
                    weaken(law, factor);
                }
            }
            Ok::<_, Verdict>(solve(&specimen.case())?.forces)
        };
        let (half, whole, full) = (with(0.5 * SMALL)?, with(SMALL)?, with(1.0)?);
        let largest = full
            .efforts
            .iter()
            .chain(full.interfaces.iter().map(|interface| &interface.load))
            .fold(1e-9_f64, |max, x| max.max(x.abs()));
        for (k, none) in whole.efforts_frictionless.iter().enumerate() {
            let (once, twice) = (half.efforts[k] - none, whole.efforts[k] - none);
            // Second-order terms in the coefficients, and rounding.
            let tolerance = (1e3 * SMALL * SMALL + 1e-12) * largest;
            let apart = (2.0 * once - twice).abs();
            if apart.is_nan() || apart > tolerance {
                return Ok(Verdict::Broken(format!(
                    "drive {k}: {once:e}, {twice:e} of {largest:e}"
                )));
            }
        }
        Ok(Verdict::Holds)
    }
    try_everywhere("small friction acts in proportion", 0.5, identity);
}

fn weaken(law: &mut Law, factor: f64) {
    law.mu *= factor;
    law.viscous *= factor;
    match &mut law.curve {
        Curve::Constant => {}
        Curve::Static { mu_static } => *mu_static *= factor,
        Curve::Stribeck { mu_static, .. } => *mu_static *= factor,
        Curve::Table(rows) => rows.iter_mut().for_each(|[_, coefficient]| *coefficient *= factor),
    }
}

/// Tests that the actuator forces of a slow forward motion lie in the interval at rest, because
/// static friction can have any value between those of slow forward and slow backward sliding.
#[test]
fn slow_motions_are_within_the_interval_at_rest() {
    fn identity(specimen: &Specimen) -> Result<Verdict, Verdict> {
        let with = |factor: f64| {
            let mut specimen = specimen.clone();
            let interfaces = specimen.draft.joints.iter_mut().flat_map(|joint| &mut joint.friction);
            // Speed-dependent laws have larger coefficients at rest than while sliding.
            interfaces.for_each(|interface| interface.backward = None);
            let targets = specimen.prescribed.iter_mut().map(|(_, _, target)| target);
            for target in targets {
                *target = Target { rate: factor * target.rate, acceleration: 0.0, ..*target };
            }
            let case: Case = specimen.case();
            solve(&case)
        };
        let rest = with(0.0)?;
        if rest.forces.bounds == stiction_core::dynamics::Bounds::Unknown {
            return Err(Verdict::Apart("bounds are not known"));
        }
        for factor in [1e-9, -1e-9] {
            let slow = with(factor)?;
            let largest = slow.forces.efforts.iter().fold(1e-9_f64, |max, x| max.max(x.abs()));
            for (k, drive) in slow.forces.efforts.iter().enumerate() {
                let (attained, outer) =
                    (rest.forces.effort_bounds[k], rest.forces.effort_outer_bounds[k]);
                let (least, most) = (attained.0.min(outer.0), attained.1.max(outer.1));
                // Viscous forces at these speeds, and rounding.
                let slack = 1e-7 * largest;
                if !(least - slack..=most + slack).contains(drive) {
                    return Ok(Verdict::Broken(format!(
                        "drive {k}: {drive} outside {least} .. {most} (factor {factor:e})"
                    )));
                }
            }
        }
        Ok(Verdict::Holds)
    }
    try_everywhere("slow motions are within the interval at rest", 0.3, identity);
}
