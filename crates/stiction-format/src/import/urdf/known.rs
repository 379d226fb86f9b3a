//! Lists the elements and attributes of URDF that the importer reads or reports itself, or that do
//! not matter for mechanics.

use super::super::unread::{Known, known};

const PLACE: &str = "xyz rpy quat_xyzw";

pub(super) const KNOWN: &[Known] = &[
    known("robot", "name version", "link joint loop_joint material transmission ros2_control"),
    known("link", "name type", "inertial visual collision"),
    known("inertial", "", "origin mass inertia"),
    known("origin", PLACE, ""),
    known("mass", "value", ""),
    known("inertia", "ixx iyy izz ixy ixz iyz", ""),
    known("joint", "name type", "origin parent child axis limit dynamics joint_properties mimic"),
    known("parent", "link", ""),
    known("child", "link", ""),
    known("axis", "xyz", ""),
    known("limit", "lower upper effort velocity", ""),
    known("dynamics", "damping friction", ""),
    known("joint_properties", "damping friction", ""),
    known("mimic", "joint multiplier offset", ""),
    known("loop_joint", "name type", "link1 link2 axis"),
    known("link1", "link xyz rpy quat_xyzw", ""),
    known("link2", "link xyz rpy quat_xyzw", ""),
];
