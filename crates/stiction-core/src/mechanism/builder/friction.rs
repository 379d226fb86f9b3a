//! Checks of the friction parameters of a joint.

use super::JointSpec;
use crate::friction::{
    Combine, Curve, InterfaceShape, JointFriction, Law, Supports, interfaces_of,
};
use crate::joint::JointType;
use crate::mechanism::Defect;

const POSITIVE: &str = "greater than 0";
const NOT_NEGATIVE: &str = "at least 0";

impl JointSpec {
    pub(super) fn check_friction(&self, defects: &mut Vec<Defect>) {
        let joint = || self.name.clone();
        let places = interfaces_of(self.joint_type);
        for (i, interface) in self.friction.iter().enumerate() {
            let Some((_, shape)) = places.get(interface.place) else {
                let joint_type = self.joint_type.symbol();
                defects.push(Defect::NoContact { joint: joint(), joint_type });
                continue;
            };
            if self.friction[..i].iter().any(|other| other.place == interface.place) {
                defects.push(Defect::DuplicateContact { joint: joint() });
            }
            match interface.radius {
                None if shape.turns() => defects.push(Defect::Radius {
                    joint: joint(),
                    problem: "friction at a rotating interface needs the radius of the interface",
                }),
                Some(_) if !shape.turns() => defects.push(Defect::Radius {
                    joint: joint(),
                    problem: "a guide does not turn, so its friction has no radius",
                }),
                _ => {}
            }
            let mut check = Checks { joint: &self.name, defects };
            check.load(interface, *shape, self.joint_type);
            check.number("radius", interface.radius, POSITIVE);
            check.law(&interface.law);
            if let Some(law) = &interface.backward {
                check.law(law);
                if !shape.has_one_dof() {
                    check.problem(
                        "only an interface with one degree of freedom can have backward friction",
                    );
                }
            }
            if *shape == InterfaceShape::Sleeve {
                if self.friction.len() > 1 {
                    check.problem("a joint with a sleeve cannot also have the friction of a separate pin or guide");
                }
                if interface.load.axial_ratio.is_some() || interface.load.torsion_arm.is_some() {
                    check.problem(
                        "a sleeve carries neither an axial force nor a moment about its \
                        axis",
                    );
                }
            }
        }
    }
}

/// Checks the friction parameters of one joint and appends the defects found to `defects`.
struct Checks<'a> {
    joint: &'a str,
    defects: &'a mut Vec<Defect>,
}

impl Checks<'_> {
    fn problem(&mut self, problem: &'static str) {
        self.defects.push(Defect::Friction { joint: self.joint.to_owned(), problem });
    }

    fn number(&mut self, parameter: &'static str, value: Option<f64>, range: &'static str) {
        let Some(value) = value else { return };
        let inside = if range == POSITIVE { value > 0.0 } else { value >= 0.0 };
        self.require(parameter, value, inside, range);
    }

    fn require(&mut self, parameter: &'static str, value: f64, inside: bool, range: &'static str) {
        if !inside || !value.is_finite() {
            let joint = self.joint.to_owned();
            self.defects.push(Defect::FrictionParameter { joint, parameter, value, range });
        }
    }

    fn load(&mut self, interface: &JointFriction, shape: InterfaceShape, joint_type: JointType) {
        let map = &interface.load;
        self.number("preload", Some(map.preload), NOT_NEGATIVE);
        self.number("bending span", map.bending_span, POSITIVE);
        self.number("collar ratio", map.axial_ratio, NOT_NEGATIVE);
        self.number("torsion arm", map.torsion_arm, POSITIVE);
        self.number("smoothing", map.smoothing, POSITIVE);
        let is_thread = shape == InterfaceShape::Thread;
        match map.flank_cosine {
            None if is_thread => self.problem("the friction of a thread needs its flank angle"),
            Some(_) if !is_thread => self.problem("only a thread has a flank angle"),
            Some(cosine) => {
                let inside = cosine > 0.0 && cosine <= 1.0;
                self.require("flank cosine", cosine, inside, "greater than 0 and at most 1");
            }
            None => {}
        }
        match (map.combine, shape) {
            (Combine::Pads, InterfaceShape::Ball | InterfaceShape::Plate) => {
                self.problem(
                    "a ball or a plate has no pads, so its normal load cannot be combined as `pads`",
                );
            }
            (Combine::RootSumSquare, InterfaceShape::Thread) => {
                self.problem(
                    "the normal load of a thread can combine its parts only as `sum` or `pads`",
                );
            }
            _ => {}
        }
        if is_thread && map.smoothing.is_some() {
            self.problem("the normal load of a thread cannot be smoothed");
        }
        let slides = matches!(
            joint_type,
            JointType::Prismatic | JointType::Cylindrical | JointType::Helical
        );
        if !slides && map.supports != Supports::Predecessor {
            self.problem("supports on the successor require a joint that slides along its axis");
        }
        if let Supports::OneOnEach { gland, piston } = map.supports {
            let inside = gland.is_finite() && gland != piston;
            self.require(
                "position of the gland",
                gland,
                inside,
                "different from the position of the piston",
            );
            self.require("position of the piston", piston, true, "finite");
            if map.bending_span.is_some() {
                self.problem(
                    "supports on both bodies define the bending span, so it cannot be set",
                );
            }
        }
    }

    fn law(&mut self, law: &Law) {
        const NOT_BELOW: &str = "at least the sliding coefficient";
        self.number("coefficient", Some(law.mu), NOT_NEGATIVE);
        self.number("viscous coefficient", Some(law.viscous), NOT_NEGATIVE);
        let coefficient = "static coefficient";
        match &law.curve {
            Curve::Constant => {}
            Curve::Static { mu_static } => {
                self.require(coefficient, *mu_static, *mu_static >= law.mu, NOT_BELOW);
            }
            Curve::Stribeck { mu_static, velocity, exponent } => {
                self.require(coefficient, *mu_static, *mu_static >= law.mu, NOT_BELOW);
                self.number("Stribeck velocity", Some(*velocity), POSITIVE);
                self.number("Stribeck exponent", Some(exponent.value()), POSITIVE);
            }
            Curve::Table(rows) => self.table(rows),
        }
        self.number("regularisation velocity", law.regularisation, POSITIVE);
        if let Some(bristles) = law.bristles {
            self.number("bristle stiffness", Some(bristles.stiffness), POSITIVE);
            self.number("bristle damping", Some(bristles.damping), NOT_NEGATIVE);
            if law.regularisation.is_some() {
                self.problem("a law with an internal state (dahl, lugre) cannot be regularised");
            }
            let positive = match &law.curve {
                Curve::Table(rows) => rows.iter().all(|row| row[1] > 0.0),
                _ => law.mu > 0.0,
            };
            if !positive {
                self.problem(
                    "a law with an internal state (dahl, lugre) needs coefficients \
                    greater than 0",
                );
            }
        }
    }

    fn table(&mut self, rows: &[[f64; 2]]) {
        if rows.len() < 2 {
            self.problem("a table of coefficients needs at least two rows");
        }
        if rows.iter().flatten().any(|number| !number.is_finite()) {
            self.problem("a table of coefficients contains a number that is not finite");
        }
        if rows.first().is_some_and(|row| row[0] != 0.0) {
            self.problem("a table of coefficients must begin at speed 0");
        }
        if rows.iter().zip(rows.iter().skip(1)).any(|(a, b)| a[0] >= b[0]) {
            self.problem("the speeds in a table of coefficients must increase");
        }
        if rows.iter().any(|row| row[1] < 0.0) {
            self.problem("a table of coefficients contains a negative coefficient");
        }
    }
}
