//! Description of a mechanism for the animated picture of a page: shapes of its bodies and joints,
//! in the axes of the bodies.

use super::Drawing;
use super::sheet::thickness;
use super::symbols::word;
use super::trail::traced;
use super::view::{View, upwards};
use serde_json::{Value, json};
use stiction_core::spatial::Vec3;

impl Drawing<'_> {
    /// Describes the mechanism in JSON for [`crate::viewer`]; lengths in m.
    pub fn scene(&self) -> Value {
        let (placed, layout) = (&self.placed, &self.layout);
        let mechanism = placed.mechanism;
        let bodies = mechanism.bodies().iter().enumerate().map(|(body, content)| {
            json!({
                "name": content.name,
                "leg": layout.branch[body],
                "line": thickness(mechanism, &layout.joints[body], body),
                "mass": content.mass,
                "com": content.com.to_array(),
                "joints": layout.joints[body],
            })
        });
        let joints = mechanism.joints().iter().enumerate().map(|(index, joint)| {
            let anchorage = &layout.anchorages[index];
            let axes = joint.frame_j.rotation.columns.map(Vec3::to_array);
            json!({
                "name": joint.name,
                "type": joint.joint_type.symbol(),
                "word": word(joint.joint_type),
                "from": joint.predecessor.0,
                "to": joint.successor.0,
                "driven": joint.actuated.contains(&true),
                "leg": layout.branch_of_joint(mechanism, index),
                "at": [
                    anchorage.on_predecessor.to_array(),
                    anchorage.on_successor.to_array(),
                ],
                "weight": anchorage.weight,
                "axes": axes,
                "second": joint.frame_k.rotation.columns[0].to_array(),
            })
        });
        let springs = mechanism.springs().iter().map(|spring| {
            json!({
                "name": spring.name,
                "bodies": spring.ends.map(|body| body.0),
                "at": spring.points.map(Vec3::to_array),
            })
        });
        let traced = traced(placed, layout).into_iter();
        let traced = traced.map(|(body, point)| json!({ "body": body, "at": point.to_array() }));
        let views = [
            ("best", self.best_view()),
            ("front", View::front()),
            ("side", View::side()),
            ("top", View::top()),
        ];
        let views = views.map(|(name, view)| {
            json!({ "name": name, "up": view.up.to_array(), "toward": view.toward.to_array() })
        });
        json!({
            "name": mechanism.name(),
            "planar": self.is_planar(),
            "up": upwards(placed).to_array(),
            "bodies": bodies.collect::<Vec<_>>(),
            "joints": joints.collect::<Vec<_>>(),
            "springs": springs.collect::<Vec<_>>(),
            "legs": layout.branches,
            "traced": traced.collect::<Vec<_>>(),
            "views": views,
        })
    }
}
