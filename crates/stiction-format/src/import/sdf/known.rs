//! Elements and attributes of SDF that the import does not report as unread: those that it reads,
//! those that it reports itself, and those that do not matter for rigid bodies without contact.

use super::super::unread::{ANY, Known, known};

/// Known content of the file from its root to its models.
pub(super) const ROOT: &[Known] = &[
    known("sdf", "version", "world model light"),
    known(
        "world",
        "name",
        "gravity model include joint frame physics scene light gui plugin atmosphere magnetic_field \
         spherical_coordinates audio road wind",
    ),
    // Models, and joints and frames of the world, are checked separately with `MODEL`.
    known("model", ANY, ANY),
    known("joint", ANY, ANY),
    known("frame", ANY, ANY),
    known("include", "merge placement_frame", "uri name pose static placement_frame plugin"),
];

/// Known content of a model, and of the world with its own joints and frames.
pub(super) const MODEL: &[Known] = &[
    known("world", "name", "joint frame"),
    known(
        "model",
        "name canonical_link placement_frame",
        "link joint frame pose static model include placement_frame self_collide allow_auto_disable enable_wind",
    ),
    // A model within a model is checked separately.
    known("model/model", ANY, ANY),
    known("include", "merge placement_frame", "uri name pose static placement_frame plugin"),
    known("pose", "relative_to frame degrees rotation_format", ""),
    known("frame", "name attached_to", "pose"),
    known(
        "link",
        "name",
        "pose inertial visual collision gravity enable_wind self_collide must_be_base_link sensor light projector \
         audio_source audio_sink battery particle_emitter kinematic=false",
    ),
    known("inertial", "auto", "mass pose inertia density fluid_added_mass"),
    known("inertia", "", "ixx iyy izz ixy ixz iyz"),
    known(
        "joint",
        "name type",
        "pose parent child axis axis2 gearbox_ratio gearbox_reference_body thread_pitch screw_thread_pitch sensor",
    ),
    known("axis", "", AXIS),
    known("axis2", "", AXIS),
    known("xyz", "expressed_in", ""),
    known("limit", "", "lower upper effort velocity"),
    known("dynamics", "", "damping friction spring_stiffness spring_reference"),
    known("mimic", "joint axis", "multiplier offset reference"),
];

const AXIS: &str = "xyz limit dynamics mimic use_parent_model_frame initial_position";
