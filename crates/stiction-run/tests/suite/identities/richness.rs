//! Additional kinds of friction for random mechanisms.

use crate::mechanisms::random::{Draft, Random};
use stiction_core::friction::{
    Combine, Curve, Exponent, InterfaceShape, JointFriction, Supports, interfaces_of,
};
use stiction_core::joint::JointType;

/// Adds spans, collars, arms, both combination rules, and laws that depend on speed and direction
/// to some interfaces.
pub(crate) fn enrich(draft: &mut Draft, random: &mut Random) {
    for joint in &mut draft.joints {
        for interface in &mut joint.friction {
            let (_, shape) = interfaces_of(joint.joint_type)[interface.place];
            if random.below(2) == 0 {
                load(interface, joint.joint_type, shape, random);
            }
            if random.below(3) == 0 {
                law(interface, shape, random);
            }
        }
    }
}

fn load(
    interface: &mut JointFriction,
    joint_type: JointType,
    shape: InterfaceShape,
    random: &mut Random,
) {
    let map = &mut interface.load;
    let has_two_supports = !matches!(shape, InterfaceShape::Ball);
    if has_two_supports {
        map.bending_span = Some(random.between(0.05, 0.2));
    }
    match shape {
        InterfaceShape::Pin { .. } => map.axial_ratio = Some(random.between(0.5, 2.0)),
        InterfaceShape::Guide { .. } => map.torsion_arm = Some(random.between(0.02, 0.1)),
        _ => {}
    }
    map.combine = match (shape, random.below(3)) {
        (InterfaceShape::Plate | InterfaceShape::Ball, 1)
        | (InterfaceShape::Thread | InterfaceShape::Ball, 2) => Combine::Sum,
        (_, 1) => Combine::Pads,
        (_, 2) => Combine::RootSumSquare,
        _ => Combine::Sum,
    };
    let slides = matches!(shape, InterfaceShape::Guide { .. } | InterfaceShape::Thread)
        || joint_type == JointType::Cylindrical;
    if slides && random.below(3) == 0 {
        map.supports = Supports::Successor;
    }
}

fn law(interface: &mut JointFriction, shape: InterfaceShape, random: &mut Random) {
    let law = &mut interface.law;
    let static_coefficient = law.mu * random.between(1.0, 1.5);
    law.curve = match random.below(3) {
        0 => Curve::Stribeck {
            mu_static: static_coefficient,
            velocity: random.between(0.005, 0.1),
            exponent: Exponent::new(random.between(0.7, 2.5)),
        },
        1 => Curve::Static { mu_static: static_coefficient },
        _ => Curve::Table(vec![
            [0.0, static_coefficient],
            [random.between(0.001, 0.05), law.mu],
            [random.between(0.1, 0.5), law.mu * random.between(0.8, 1.2)],
        ]),
    };
    if matches!(law.curve, Curve::Table(_)) {
        law.mu = 0.0;
    } else if shape.has_one_dof() && random.below(2) == 0 {
        let mut backward = law.clone();
        backward.mu *= random.between(0.5, 1.0);
        backward.viscous *= random.between(0.5, 1.0);
        interface.backward = Some(backward);
    }
}
