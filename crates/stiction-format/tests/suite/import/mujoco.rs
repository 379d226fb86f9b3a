//! Imports of MJCF compared with MuJoCo: the expected numbers are those of MuJoCo 4.0.0 for the
//! same text.

use super::tree::{convert, mobility, model, refused, with_files};
use stiction_core::dynamics::{FrictionMode, InverseDynamics, Settings};
use stiction_core::joint::JointType;
use stiction_core::kinematics::{Coordinate, Target};
use stiction_core::mechanism::JointId;
use stiction_format::{Imported, ModelFile};

pub(super) fn notes(imported: &Imported) -> String {
    imported.notes.iter().map(|note| note.line() + "\n").collect()
}

/// Text of a body on a hinge about the y axis, with further elements before, inside and after the
/// body.
pub(super) fn hinged(before: &str, inside: &str, after: &str) -> String {
    format!(
        "<mujoco>{before}<worldbody><site name='s0' pos='0 0 1'/><body name='a'><joint name='j' axis='0 1 0'/>\n{inside}\
         </body></worldbody>{after}<actuator><motor name='m' joint='j'/></actuator></mujoco>"
    )
}

/// Static effort of the first joint at a coordinate.
fn effort(model: &ModelFile, value: f64) -> f64 {
    let coordinate = Coordinate::Joint { joint: JointId(0), dof: 0 };
    let target = Target { value, rate: 0.0, acceleration: 0.0 };
    let settings = Settings { friction: FrictionMode::Off, ..Settings::default() };
    let mechanism = model.mechanism.clone();
    InverseDynamics::new(mechanism, &model.initial_poses, &[coordinate], &[target], settings)
        .unwrap()
        .solve(&[])
        .unwrap()
        .efforts[0]
}

#[test]
fn tendons_have_defaults() {
    let body = "<geom type='box' size='.1 .1 .1'/><site name='s1' pos='.3 0 0'/>";
    for (default, class) in [
        ("<tendon stiffness='50' damping='2'/>", ""),
        ("<default class='c'><tendon stiffness='50' damping='2'/></default>", "class='c'"),
    ] {
        let tendon = format!(
            "<tendon><spatial {class}><site site='s0'/><site site='s1'/></spatial></tendon>"
        );
        let text = hinged(&format!("<default>{default}</default>"), body, &tendon);
        // Value of `qfrc_inverse` at 0.5 rad.
        let found = effort(&model(&convert("r.xml", &text)), 0.5);
        assert!((found - 1.454_673_730_976_828).abs() < 1e-12, "{found}");
    }
}

/// A tetrahedron.
const MESH: &str =
    "<mesh name='q' vertex='0 0 0 .5 0 0 0 .7 0 0 0 1.1' face='0 2 1 0 1 3 0 3 2 1 2 3'/>";

/// Mass, centre of mass, and moments xx, yy, zz of a body with one geom.
pub(super) fn properties(before: &str, geom: &str) -> [f64; 7] {
    properties_with(before, geom, &[])
}

/// Mass properties of a body with one geom, as [`properties`], with further files.
pub(super) fn properties_with(before: &str, geom: &str, files: &[(&str, &str)]) -> [f64; 7] {
    let text = hinged(before, geom, "");
    let mechanism = model(&with_files("r.xml", &text, files, false)).mechanism;
    let body = mechanism.bodies().iter().find(|body| body.name == "a").unwrap();
    let [x, y, z] = body.com.to_array();
    let moment = |k: usize| body.inertia.at(k, k);
    [body.mass, x, y, z, moment(0), moment(1), moment(2)]
}

#[test]
fn simple_shapes_are_fitted_to_meshes() {
    let place = "mesh='q' pos='.1 .2 .3' euler='10 20 30' fitscale='1.2'";
    let at_inertia = [0.213_557_148_703_313_63, 0.367_161_654_126_605_5, 0.584_669_558_617_012_6];
    let at_bounds = [0.241_607_357_810_610_4, 0.240_984_515_745_770_07, 0.782_690_107_178_622_5];
    let cases = [
        (
            "box",
            false,
            154.597_102_351_921,
            [12.230_743_701_925_135, 12.645_735_603_135_87, 7.681_671_047_366_443],
        ),
        (
            "box",
            true,
            770.351_398_480_454_2,
            [165.501_887_388_470_55, 174.586_867_260_314_85, 109.952_982_556_404_34],
        ),
        ("sphere", false, 110.750_749_026_497_52, [3.931_684_906_815_285_3; 3]),
        ("sphere", true, 1_729.613_288_919_155_6, [383.632_984_781_147_4; 3]),
        (
            "capsule",
            false,
            146.274_984_038_633_28,
            [12.724_220_555_749_891, 11.770_193_923_162_033, 6.785_819_585_515_975],
        ),
        (
            "capsule",
            true,
            928.465_980_214_944_8,
            [160.341_594_372_739_7, 154.798_545_740_883_33, 125.838_526_796_753_13],
        ),
        (
            "cylinder",
            false,
            135.655_552_380_415_26,
            [10.225_430_380_350_694, 9.517_431_096_762_843, 5.818_442_683_185_102],
        ),
        (
            "cylinder",
            true,
            1_200.764_583_742_164,
            [281.512_607_752_087_55, 268.711_100_715_749_8, 201.828_792_638_002_06],
        ),
        (
            "ellipsoid",
            false,
            80.946_853_502_510_72,
            [3.842_401_456_190_764, 3.972_775_007_005_054_3, 2.413_268_132_969_983],
        ),
    ];
    for (word, to_bounds, mass, moments) in cases {
        let before = format!("<compiler fitaabb='{to_bounds}'/><asset>{MESH}</asset>");
        let found = properties(&before, &format!("<geom type='{word}' {place}/>"));
        let [x, y, z] = if to_bounds { at_bounds } else { at_inertia };
        let [xx, yy, zz] = moments;
        for (found, expected) in found.into_iter().zip([mass, x, y, z, xx, yy, zz]) {
            // MuJoCo stores vertices in the principal frame in single precision.
            let error = (found - expected).abs() / expected;
            assert!(error < 1e-7, "{word} {to_bounds}: {found} {expected}");
        }
    }
    let asset = format!("<asset>{MESH}</asset>");
    // Without a type, MuJoCo fits a sphere; a geom of type `sdf` has the mass of the mesh.
    for (geom, mass) in [
        ("<geom mesh='q'/>", 64.091_868_649_593_5),
        ("<geom mesh='q' type='sdf'/>", 64.166_666_964_669_87),
        ("<geom mesh='q' type='box' mass='2'/>", 2.0),
    ] {
        let found = properties(&asset, geom)[0];
        assert!((found - mass).abs() < 1e-9 * mass, "{geom} {found}");
    }
}

#[test]
fn shells_have_the_mass_of_their_surface() {
    let geoms = "<geom type='box' size='.1 .2 .1' shellinertia='true'/>
        <geom type='cylinder' size='.1 .2' shellinertia='true' pos='.1 0 0'/>
        <geom type='capsule' size='.1 .2' shellinertia='true' pos='.1 0 0'/>
        <geom type='ellipsoid' size='.1 .2 .3' shellinertia='true'/>";
    let mass = properties("", geoms)[0];
    assert!((mass - 1_580.869_717_126_927_8).abs() < 1e-9, "{mass}");
}

/// Meshes of unknown mass, on a moving body and on a body that is fixed to the world.
#[test]
fn bodies_do_not_lose_mass() {
    for (mesh, why) in [
        ("vertex='0 0 0 1 0 0 0 1 0 1 1 0'", "has no convex hull: all vertices are in a plane"),
        ("builtin='sphere' params='2'", "has neither file nor vertices"),
    ] {
        let asset = format!("<asset><mesh name='q' {mesh}/></asset>");
        for geom in ["<geom type='mesh' mesh='q'/>", "<geom type='box' mesh='q'/>"] {
            let said = refused("r.xml", &hinged(&asset, geom, ""));
            assert!(said.contains(why) && said.contains("r.xml:2:"), "{said}");
            assert!(said.contains("the mass of body `a` is unknown"), "{said}");
            assert!(said.contains("<inertial>"), "{said}");
        }
        let held = "<geom size='.1'/></body><body name='b'><geom type='mesh' mesh='q'/>";
        let imported = convert("r.xml", &hinged(&asset, held, ""));
        assert!(
            notes(&imported).contains("the mass of body `b` does not include this mesh"),
            "{}",
            notes(&imported)
        );
        // Bodies whose mass does not come from the mesh.
        for body in [
            "<geom type='mesh' mesh='q'/><inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/>",
            "<geom type='mesh' mesh='q' density='0'/><geom size='.1'/>",
            "<geom type='mesh' mesh='q' mass='0'/><geom size='.1'/>",
        ] {
            convert("r.xml", &hinged(&asset, body, ""));
        }
    }
}

/// Missing meshes cause a warning, because robots are often published without their meshes.
#[test]
fn mass_of_absent_meshes_is_warned_of() {
    let asset = "<asset><mesh name='q' file='nope.stl'/></asset>";
    let text = hinged(asset, "<geom size='.1'/><geom type='mesh' mesh='q'/>", "");
    let said = notes(&convert("r.xml", &text));
    assert!(said.contains("r.xml:2: WARNING: body `a` lacks the mass of a mesh"), "{said}");
    assert!(said.contains("`nope.stl` cannot be read") && said.contains("<inertial>"), "{said}");
}

#[test]
fn a_coupling_of_one_joint_locks_it() {
    let body = "<geom type='box' size='.1 .1 .1'/></body><body name='b' pos='1 0 0'>\
                <joint name='k' axis='0 1 0' ref='10'/><geom type='box' size='.1 .1 .2'/>";
    for equality in [
        "<joint joint1='k' polycoef='.1 0 0 0 0'/>",
        "<joint joint1='k' joint2='j' polycoef='.1 0 0 0 0'/>",
        "<joint joint1='k' polycoef='.1 0 0 0 0'/><joint joint1='j' joint2='k' polycoef='0 2 0 0 0' active='false'/>",
    ] {
        let imported =
            convert("r.xml", &hinged("", body, &format!("<equality>{equality}</equality>")));
        let said = notes(&imported);
        assert!(said.contains("keeps joint `k`") && said.contains("fixed"), "{said}");
        let read = model(&imported);
        let joints = read.mechanism.joints();
        let lock = joints.iter().find(|joint| joint.name == "k").unwrap();
        assert_eq!((lock.joint_type, mobility(&read)), (JointType::Fixed, 1));
        // The joint is locked at its coordinate in the file's configuration plus 0.1 rad.
        let turned = (lock.frame_j * lock.frame_k.inverse()).rotation.rotation_vector();
        assert!((turned.y - 0.1).abs() < 1e-12, "{turned:?}");
    }
    let two = "<equality><joint joint1='k' polycoef='.1 0 0 0 0'/><joint joint1='k' polycoef='.2 0 0 0 0'/></equality>";
    let said = refused("r.xml", &hinged("", body, two));
    assert!(said.contains("different values"), "{said}");
}

/// A z axis that is turned by 180 degrees, and the direction of `fromto`, which matters for boxes and ellipsoids.
#[test]
fn orientations_are_those_of_mujoco() {
    let turned = "<geom type='box' size='.1 .2 .3' pos='.1 .2 .3' zaxis='0 0 -2'/>
        <frame zaxis='0 0 -1'><geom type='sphere' size='.2' pos='.3 .2 .1'/></frame>";
    let tilted = "<geom type='box' size='.1 .2' fromto='.1 .2 .3 .5 -.4 .7'/>
        <geom type='ellipsoid' size='.3 .1' fromto='-.1 .2 .3 .2 .1 .1'/>";
    // Centre of mass, moments xx, yy, zz, and products xy, xz, yz.
    let of_turned = [
        0.182_223_504_863_582_74,
        0.035_552_990_272_834_48,
        0.135_552_990_272_834_5,
        8.930_930_319_735_847,
        6.082_893_379_664_652,
        5.282_893_379_664_652,
        1.578_691_293_380_794_4,
        1.578_691_293_380_794_8,
        -3.157_382_586_761_59,
    ];
    let of_tilted = [
        0.129_663_205_413_151_96,
        0.070_336_794_586_848_05,
        0.295_595_846_495_782_4,
        7.254_420_542_664_638,
        6.293_688_705_446_041,
        6.359_305_373_295_365,
        1.859_278_453_186_525_2,
        -2.431_979_175_010_197,
        2.417_281_656_470_657_4,
    ];
    let cases = [(turned, of_turned), (tilted, of_tilted)];
    let mechanism = |geoms: &str| model(&convert("r.xml", &hinged("", geoms, ""))).mechanism;
    for (geoms, expected) in cases {
        let mechanism = mechanism(geoms);
        let body = mechanism.bodies().iter().find(|body| body.name == "a").unwrap();
        let com = body.com.to_array();
        let inertia = |i, j| body.inertia.at(i, j);
        let moments = [inertia(0, 0), inertia(1, 1), inertia(2, 2)];
        let products = [inertia(0, 1), inertia(0, 2), inertia(1, 2)];
        for (found, expected) in com.into_iter().chain(moments).chain(products).zip(expected) {
            let error = (found - expected).abs() / expected.abs();
            assert!(error < 1e-12, "{geoms}: {found} {expected}");
        }
    }
}

/// Without geoms of mass in the range of groups, a body keeps its `inertial`.
#[test]
fn inertias_from_geoms_need_geoms_with_mass() {
    let settings = "<compiler inertiafromgeom='true' inertiagrouprange='1 4'/>";
    let inertial = "<inertial pos='.1 0 0' mass='2' diaginertia='1 1 1'/>";
    for (geoms, mass) in [
        ("", 2.0),
        ("<geom size='.1'/>", 2.0),
        ("<geom size='.1' group='1' mass='0'/>", 2.0),
        ("<geom size='.1'/><geom size='.1' group='1' mass='.5'/>", 0.5),
    ] {
        let found = properties(settings, &format!("{inertial}{geoms}"))[0];
        assert_eq!(found, mass, "{geoms}");
    }
}

/// Defaults of all joints apply to ball and free joints, but not to the element `freejoint`.
#[test]
fn properties_of_ball_and_free_joints_are_noted() {
    let default =
        "<default><joint armature='.1' damping='.2' frictionloss='.3' stiffness='4'/></default>";
    let free = |joint: &str| {
        let body = "<geom size='.1'/></body><body name='b'>JOINT<geom size='.1'/><body name='c'>\n\
                    <joint type='ball'/><geom size='.1'/></body>";
        notes(&convert("r.xml", &hinged(default, &body.replace("JOINT", joint), "")))
    };
    let said = free("<joint type='free'/>");
    for (line, kind, keys) in [
        (2, "free", &["damping", "stiffness", "armature", "frictionloss"][..]),
        (3, "ball", &["armature", "frictionloss"]),
    ] {
        for key in keys {
            let note = format!("r.xml:{line}: `{key}` of a {kind} joint is left out");
            assert!(said.contains(&note), "{note}: {said}");
        }
    }
    assert!(!free("<freejoint/>").contains("free joint is left out"));
}

/// The relative pose of a weld is that of its anchor in the second body; without it, the anchor does not matter.
#[test]
fn welds_have_an_anchor() {
    let body =
        "<geom size='.1'/></body><body name='b' pos='1 0 0'><joint name='k'/><geom size='.1'/>";
    for (weld, expected) in [
        // The axes x, y and z of the second body are y, z and x of the first.
        (
            "relpose='.1 .2 .3 .5 .5 .5 .5' anchor='.05 .06 .07'",
            [0.1 - 0.07, 0.2 - 0.05, 0.3 - 0.06],
        ),
        ("relpose='.1 .2 .3 1 0 0 0'", [0.1, 0.2, 0.3]),
        ("anchor='.05 .06 .07'", [1.0, 0.0, 0.0]),
        ("relpose='.1 .2 .3 0 0 0 0' anchor='.05 .06 .07'", [1.0, 0.0, 0.0]),
    ] {
        let weld = format!("<equality><weld name='w' body1='a' body2='b' {weld}/></equality>");
        let imported = with_files("r.xml", &hinged("", body, &weld), &[], true);
        let mechanism = model(&imported).mechanism;
        let joint = mechanism.joints().iter().find(|joint| joint.name == "w").unwrap();
        let found = (joint.frame_j * joint.frame_k.inverse()).position.to_array();
        let error = (0..3).map(|k| (found[k] - expected[k]).abs()).fold(0.0, f64::max);
        assert!(error < 1e-15, "{weld}: {found:?}");
    }
}

#[test]
fn equalities_have_their_own_defaults() {
    let body = "<geom size='.1'/></body><body name='b'><joint name='k' axis='0 1 0'/><geom size='.1' pos='0 0 .1'/>";
    let equality = "<equality><joint joint1='j' joint2='k'/></equality>";
    let before = "<default><joint frictionloss='1'/><equality active='false'/></default>";
    let imported = convert("r.xml", &hinged(before, body, equality));
    assert!(notes(&imported).contains("not active"), "{}", notes(&imported));
    assert_eq!(mobility(&model(&imported)), 2);
}

/// Effort limits at the joint, from the force limits and the control limits of motors.
#[test]
fn the_smaller_limit_of_a_motor_holds() {
    let peak = |actuator: &str| {
        let text = hinged("", "<geom size='.1'/>", "");
        let text = text.replace("<motor name='m' joint='j'/>", actuator);
        let train = model(&convert("r.xml", &text)).mechanism.drive_trains().first().cloned()?;
        Some(train.limits.peak? * train.transmission())
    };
    for (actuator, expected) in [
        ("<motor joint='j' ctrlrange='-3 3' forcerange='-7 7'/>", Some(3.0)),
        ("<motor joint='j' ctrlrange='-9 9' forcerange='-7 7' gear='2'/>", Some(14.0)),
        ("<general joint='j' gainprm='5' ctrlrange='-2 2' gear='3'/>", Some(30.0)),
        ("<general joint='j' gainprm='5' ctrlrange='-2 2' forcerange='-4 4'/>", Some(4.0)),
        // The control signal of a servo is a position.
        ("<position joint='j' kp='5' ctrlrange='-2 2'/>", None),
        (
            "<general joint='j' gainprm='5' biastype='affine' biasprm='0 -5 0' ctrlrange='-2 2'/>",
            None,
        ),
    ] {
        let found = peak(actuator);
        let error = found.zip(expected).map_or(0.0, |(found, peak)| f64::abs(found - peak));
        assert!(found.is_some() == expected.is_some() && error < 1e-12, "{actuator}: {found:?}");
    }
}
