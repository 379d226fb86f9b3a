//! Reads load maps, which determine the normal force of a friction interface from the joint's
//! reaction.

use super::layers::{Layers, Notes};
use super::{Place, applies};
use crate::diagnostic::Diagnostic;
use std::f64::consts::FRAC_PI_2;
use stiction_core::friction::{Combine, InterfaceShape, NormalLoadMap, Supports};

/// Reads the load map of a friction interface.
pub(super) fn read(
    layers: &Layers<'_>,
    shape: InterfaceShape,
    joint: &Place<'_>,
    radius: Option<f64>,
    notes: &mut Notes,
) -> NormalLoadMap<f64> {
    let applies = |key| applies(key, shape, joint.joint_type);
    let mut part = |key| applies(key).then(|| layers.number(key, notes)).flatten();
    let (bending_span, collar) = (part("bending_span"), part("collar_radius"));
    let (torsion_arm, smoothing) = (part("torsion_arm"), part("smoothing"));
    let preload = part("preload").unwrap_or(0.0);
    let axial_ratio = collar.zip(radius).map(|(collar, radius)| collar / radius);
    let combine = if applies("combine") { combine(layers, shape, notes) } else { Combine::Sum };
    let supports =
        if applies("supports") { supports(layers, notes) } else { Supports::Predecessor };
    let one_on_each = matches!(supports, Supports::OneOnEach { .. });
    let flank_cosine =
        (shape == InterfaceShape::Thread).then(|| flank_cosine(layers, joint, radius, notes));
    NormalLoadMap {
        bending_span: bending_span.filter(|_| !one_on_each),
        axial_ratio: axial_ratio.filter(|ratio| ratio.is_finite()),
        torsion_arm,
        preload,
        combine,
        supports,
        flank_cosine,
        smoothing,
        gear: None,
    }
}

fn combine(layers: &Layers<'_>, shape: InterfaceShape, notes: &mut Notes) -> Combine {
    let combine = match layers.word("combine") {
        Some("pads") => Combine::Pads,
        Some("root-sum-square") => Combine::RootSumSquare,
        _ => Combine::Sum,
    };
    let why = match (combine, shape) {
        (Combine::Pads, InterfaceShape::Plate) => {
            "`pads` needs two supports along an axis, which a plate does not have"
        }
        (Combine::RootSumSquare, InterfaceShape::Thread) => {
            "the normal force of a thread depends on the thread's friction, which `root-sum-square` does not support"
        }
        _ => return combine,
    };
    if let Some(given) = layers.given("combine") {
        layers.conflict(given, "combine", why, "delete it to use the sum", notes);
    }
    Combine::Sum
}

fn supports(layers: &Layers<'_>, notes: &mut Notes) -> Supports<f64> {
    let on_one = match layers.word("supports") {
        Some("to") => Supports::Successor,
        _ => Supports::Predecessor,
    };
    let (gland, piston) = (layers.given("gland"), layers.given("piston"));
    let Some(either) = gland.or(piston) else { return on_one };
    // `gland` and `piston` are ignored if one of these keys is in a more specific table.
    for key in ["bending_span", "supports"] {
        match layers.given(key) {
            Some(other) if other.layer < either.layer => return on_one,
            Some(other) if other.layer == either.layer => {
                let why = "`gland` and `piston` define the supports";
                let help = format!("delete `{key}`, or `gland` and `piston`");
                layers.conflict(other, key, why, &help, notes);
            }
            _ => {}
        }
    }
    let (Some(gland), Some(piston)) =
        (layers.number("gland", notes), layers.number("piston", notes))
    else {
        let key = if gland.is_none() { "gland" } else { "piston" };
        layers.missing(Some(either), key, ", the position of the other support", notes);
        return on_one;
    };
    Supports::OneOnEach { gland, piston }
}

/// Reads the flank angle of a thread, given in the axial section as in drawings, and returns the
/// cosine of the flank angle in the normal section: `tan normal = tan axial cos lead`.
fn flank_cosine(
    layers: &Layers<'_>,
    joint: &Place<'_>,
    radius: Option<f64>,
    notes: &mut Notes,
) -> f64 {
    let Some(angle) = layers.number("flank_angle", notes) else {
        layers.missing(None, "flank_angle", " for a thread", notes);
        return 1.0;
    };
    if !(0.0..FRAC_PI_2).contains(&angle) {
        if let Some(given) = layers.given("flank_angle") {
            let context = given.record.context;
            context.push(
                Diagnostic::error(
                    "range",
                    "half the flank angle must be at least 0 and below 90 deg",
                )
                .at(context.place(&given.value.span), "out of range")
                .help("it is 15 deg for trapezoidal threads and 30 deg for metric threads"),
            );
        }
        return 1.0;
    }
    let lead = radius.filter(|r| *r > 0.0).map_or(0.0, |r| (joint.pitch / r).atan());
    let normal = (angle.tan() * lead.cos()).atan();
    normal.cos()
}
