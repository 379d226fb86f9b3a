//! Bodies, points and axes of external loads. They are constants of a recorded program, whereas the
//! forces and moments of the loads are inputs.

use stiction_core::dynamics::{AppliedLoad, LoadAxes};
use stiction_core::mechanism::BodyId;
use stiction_core::spatial::Vec3;

/// Body, point and axes of an external load.
pub(crate) type LoadPlace = (BodyId, Vec3<f64>, LoadAxes);

pub(crate) fn place_of(load: &AppliedLoad<f64>) -> LoadPlace {
    (load.body, load.point, load.axes)
}

/// Panics if the number of loads differs from that of the recording, or if a load differs from the
/// recorded one in its body, point or axes.
#[inline]
pub(crate) fn check_loads(loaded: &[LoadPlace], loads: &[AppliedLoad<f64>]) {
    check_count(loaded, loads);
    for (place, load) in loaded.iter().zip(loads) {
        assert!(
            place_of(load) == *place,
            "body, point or axes of a load differ from the recording: {:?} instead of {place:?}",
            place_of(load)
        );
    }
}

/// Panics if the number of loads differs from that of the recording.
#[inline]
pub(crate) fn check_count(loaded: &[LoadPlace], loads: &[AppliedLoad<f64>]) {
    let (found, expected) = (loads.len(), loaded.len());
    assert!(found == expected, "expected {expected} loads, as in the recording, found {found}");
}
