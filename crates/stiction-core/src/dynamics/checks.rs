//! Checks of loads and configuration before forces are computed.

use crate::kinematics::Bodies;
use crate::parameters::Parameters;
use crate::statics::AppliedLoad;

/// Returns the index of the first load with a component that is not finite.
///
/// # Panics
/// If a load acts on a body that does not exist. `bodies` is the number of bodies, including
/// ground.
pub(super) fn not_finite_load(loads: &[AppliedLoad<f64>], bodies: usize) -> Option<usize> {
    loads.iter().position(|AppliedLoad { body, point, force, moment, .. }| {
        assert!(
            body.0 < bodies,
            "a load refers to {body:?}, but the mechanism has {bodies} \
                                  bodies"
        );
        let mut numbers = [point, force, moment].into_iter().flat_map(|v| v.to_array());
        !numbers.all(f64::is_finite)
    })
}

/// Finds the first friction interface whose two supports no longer overlap. Returns the index of
/// the interface and the distance between the supports, m.
pub(super) fn parted_supports(
    parameters: &Parameters<f64>,
    bodies: &Bodies<f64>,
) -> Option<(usize, f64)> {
    parameters.interfaces.iter().enumerate().find_map(|(index, interface)| {
        let (j, k) = (&bodies.frame_j[interface.joint], &bodies.frame_k[interface.joint]);
        let slide = (k.position - j.position).dot(j.rotation.columns[2]);
        let overlap = interface.load.overlap(slide)?;
        (overlap <= 0.0).then_some((index, -overlap))
    })
}
