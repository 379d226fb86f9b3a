//! Equality constraints of an MJCF file: loop closures, gearings, and the coupling of a screw's advance to its angle.

use super::tree::Closing;
use super::writer::Writer;
use crate::exchange::names::Names;
use crate::exchange::xml::numbers;
use stiction_core::joint::JointType;
use stiction_core::mechanism::{GearedDof, Gearing};

/// Stiffness of the equality constraints, which MuJoCo models as soft: time constant, s, and
/// damping ratio. These values are among the stiffest that MuJoCo's integrators can follow with the
/// time step of the file.
const SOLREF: &str = "0.002 1";
const SOLIMP: &str = "0.9999 0.9999 0.001 0.5 2";

impl Writer<'_> {
    /// Writes all equality constraints of the model.
    pub(super) fn write_equalities(&mut self) {
        let mut joint_names = Names::default();
        let threads: Vec<usize> = (0..self.tree.parts.len())
            .filter(|&k| self.joint(self.tree.parts[k].joint).joint_type == JointType::Helical)
            .collect();
        let closings = &self.tree.closings;
        let gearings: Vec<_> = self.home.model.mechanism.gearings().iter().collect();
        let geared = gearings.iter().filter_map(|gearing| self.geared(gearing)).collect::<Vec<_>>();
        let summed = self.summed_gearings();
        let is_closed = closings.iter().all(|(_, closing)| *closing == Closing::Nothing);
        if is_closed && threads.is_empty() && geared.is_empty() && summed.is_empty() {
            return;
        }
        self.xml.open("equality", &[]);
        self.xml
            .comment(&["MuJoCo's equality constraints are soft: solref and solimp define how \
                            soft."]);
        if closings.iter().any(|(_, closing)| *closing == Closing::Part) {
            self.xml.comment(&[
                "A body at a joint that closes a loop is split into two parts. One part, named BODY@JOINT,",
                "is attached by that joint. Welded together, the two parts have the mass and the inertia of the body.",
            ]);
        }
        for (&(joint, closing), sites) in closings.iter().zip(&self.sites.of_closing) {
            let tag = match closing {
                Closing::Nothing => continue,
                Closing::Connect => "connect",
                Closing::Weld | Closing::Part => "weld",
            };
            let [from, to] = sites.clone();
            // The MJCF joint of the split body already has the name of the mechanism's joint.
            let suffix = if closing == Closing::Part { ".weld" } else { "" };
            let name = joint_names.take(&format!("{}{suffix}", self.joint(joint).name));
            let mut attributes = vec![("name", name), ("site1", from), ("site2", to)];
            attributes.extend(stiffness());
            self.xml.empty(tag, &attributes);
        }
        for part in threads {
            let joint = self.joint(self.tree.parts[part].joint);
            let names = self.parts[part].steps.iter();
            let (advance, angle): (Vec<_>, Vec<_>) =
                names.partition(|named| named.step.dof.is_none());
            let (Some(advance), Some(angle)) = (advance.first(), angle.first()) else { continue };
            let mut attributes = vec![
                ("name", joint_names.take(&advance.name)),
                ("joint1", advance.name.clone()),
                ("joint2", angle.name.clone()),
                ("polycoef", numbers(&[0.0, joint.pitch, 0.0, 0.0, 0.0])),
            ];
            attributes.extend(stiffness());
            self.xml.empty("joint", &attributes);
        }
        for (name, joints, ratio) in geared {
            let [joint1, joint2] = joints;
            let mut attributes = vec![
                ("name", joint_names.take(&name)),
                ("joint1", joint1),
                ("joint2", joint2),
                ("polycoef", numbers(&[0.0, ratio, 0.0, 0.0, 0.0])),
            ];
            attributes.extend(stiffness());
            self.xml.empty("joint", &attributes);
        }
        for (name, _) in summed {
            let mut attributes =
                vec![("name", joint_names.take(&name)), ("tendon1", format!("{name}.sum"))];
            attributes.extend(stiffness());
            self.xml.empty("tendon", &attributes);
        }
        self.xml.close();
    }

    /// Returns the name of a gearing of two joints, the names of its MJCF joints, and its ratio.
    /// The ratio is the change of the first coordinate per unit change of the second. `None` for
    /// gearings of more than two joints, and for gearings with a degree of freedom that has no MJCF
    /// joint.
    pub(super) fn geared(&self, gearing: &Gearing) -> Option<(String, [String; 2], f64)> {
        let [first, second] = &gearing.dofs[..] else { return None };
        let joint = |dof: &GearedDof| Some(self.step_of(dof.joint, dof.dof)?.name.clone());
        let ratio = -second.coefficient / first.coefficient;
        Some((gearing.name.clone(), [joint(first)?, joint(second)?], ratio))
    }
}

fn stiffness() -> [(&'static str, String); 2] {
    [("solref", SOLREF.into()), ("solimp", SOLIMP.into())]
}
