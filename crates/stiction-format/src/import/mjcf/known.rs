//! Elements and attributes of MJCF that the import does not report as unread: those that it reads,
//! those that it reports itself, and those that do not matter for rigid bodies without contact.

use super::super::unread::{Known, known};

const IN_BODIES: &str = "body frame joint freejoint inertial geom site camera light";

/// Known attributes of actuator elements.
const ACTUATOR: &str = "name class group user nsample interp delay joint jointinparent tendon slidersite cranksite \
    cranklength site refsite body gear ctrlrange ctrllimited forcerange forcelimited actrange actlimited lengthrange \
    actearly actdim input inheritrange armature dyntype dynprm gaintype gainprm biastype biasprm kp kv dampratio \
    timeconst damping=0";

pub(super) const KNOWN: &[Known] = &[
    known(
        "mujoco",
        "model",
        "compiler option default worldbody equality tendon actuator keyframe asset custom visual statistic size",
    ),
    known(
        "compiler",
        "angle eulerseq autolimits balanceinertia strippath exactmeshinertia inertiafromgeom inertiagrouprange \
         boundmass boundinertia settotalmass meshdir assetdir texturedir coordinate fitaabb discardvisual usethread \
         fusestatic saveinertial savecompiled savecanonical convexhull conflict alignfree=false",
        "lengthrange",
    ),
    known(
        "option",
        "gravity timestep apirate impratio tolerance ls_tolerance noslip_tolerance ccd_tolerance mpr_tolerance \
         sleep_tolerance magnetic o_margin o_solref o_solimp o_friction integrator cone collision jacobian solver \
         iterations ls_iterations noslip_iterations ccd_iterations mpr_iterations sdf_iterations sdf_initpoints \
         actuatorgroupdisable=0 density=0 viscosity=0 wind=0",
        "flag",
    ),
    known(
        "flag",
        "constraint equality frictionloss limit contact passive spring damper gravity clampctrl warmstart filterparent \
         refsafe sensor sensornoise midphase eulerdamp autoreset nativeccd island multiccd override energy fwdinv \
         invdiscrete sleep diagexact actuation=enable",
        "",
    ),
    known("worldbody", "name childclass", IN_BODIES),
    known(
        "body",
        "name childclass pos quat axisangle xyaxes zaxis euler mocap gravcomp user sleep simple fuse",
        IN_BODIES,
    ),
    known("frame", "name childclass pos quat axisangle xyaxes zaxis euler", IN_BODIES),
    known("inertial", "pos quat axisangle xyaxes zaxis euler mass diaginertia fullinertia", ""),
    known(
        "joint",
        "name class type group pos axis ref range limited damping stiffness armature frictionloss springref springdamper \
         actuatorfrcrange actuatorfrclimited solreflimit solimplimit solreffriction solimpfriction user margin=0 \
         actuatorgravcomp=false",
        "",
    ),
    known("freejoint", "name class group align=false", ""),
    known(
        "geom",
        "name class type contype conaffinity condim group priority size material friction mass density shellinertia \
         solmix solref solimp margin gap fromto pos quat axisangle xyaxes zaxis euler hfield mesh fitscale rgba user \
         fluidcoef fluidshape=none surfacevel=0 adhesion=0",
        "",
    ),
    known(
        "site",
        "name class type group size fromto pos quat axisangle xyaxes zaxis euler material rgba user",
        "",
    ),
    known("asset", "", "mesh texture material hfield skin"),
    known(
        "mesh",
        "name class content_type file vertex normal texcoord face refpos refquat scale smoothnormal maxhullvert \
         octree_maxdepth inertia builtin params material",
        "",
    ),
    known(
        "default",
        "class",
        "default joint geom site mesh equality tendon camera light material pair general motor position velocity \
         intvelocity damper cylinder muscle adhesion dcmotor plugin",
    ),
    known("default/equality", "active solref solimp", ""),
    known(
        "default/tendon",
        "group limited range springlength stiffness damping frictionloss armature solreflimit solimplimit \
         solreffriction solimpfriction width material margin=0 rgba user",
        "",
    ),
    known("equality", "", "connect weld joint tendon flex flexvert flexstrain distance"),
    known("connect", "name class active solref solimp body1 body2 anchor site1 site2", ""),
    known(
        "weld",
        "name class active solref solimp body1 body2 anchor relpose site1 site2 torquescale",
        "",
    ),
    known("equality/joint", "name class active solref solimp joint1 joint2 polycoef", ""),
    known("equality/tendon", "name class active solref solimp tendon1 tendon2 polycoef", ""),
    known("tendon", "", "fixed spatial"),
    known(
        "fixed",
        "name class group limited range springlength stiffness damping frictionloss armature solreflimit solimplimit \
         solreffriction solimpfriction margin=0 user",
        "joint",
    ),
    known("fixed/joint", "joint coef", ""),
    known(
        "spatial",
        "name class group limited=false springlength stiffness damping frictionloss armature=0 solreflimit solimplimit \
         solreffriction solimpfriction width material margin rgba user",
        "site geom pulley",
    ),
    known("spatial/site", "site", ""),
    known("spatial/geom", "geom sidesite", ""),
    known("pulley", "divisor", ""),
    known(
        "actuator",
        "",
        "general motor position velocity intvelocity damper cylinder muscle adhesion dcmotor plugin",
    ),
    known("general", ACTUATOR, ""),
    known("motor", ACTUATOR, ""),
    known("position", ACTUATOR, ""),
    known("velocity", ACTUATOR, ""),
    known("keyframe", "", "key"),
    known("key", "name time qpos ctrl act=0 qvel=0 mpos mquat", ""),
];
