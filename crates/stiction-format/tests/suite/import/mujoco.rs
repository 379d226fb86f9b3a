//! Imports of MJCF compared with MuJoCo: the expected numbers are those of MuJoCo 4.0.0 for the
//! same text.

use super::tree::{convert, mobility, model, refused, with_files};
use stiction_core::dynamics::{FrictionMode, InverseDynamics, Settings};
use stiction_core::joint::JointType;
use stiction_core::kinematics::{Coordinate, Target};
use stiction_core::mechanism::JointId;
use stiction_format::{Imported, ModelFile};

fn notes(imported: &Imported) -> String {
    imported.notes.iter().map(|note| note.line() + "\n").collect()
}

/// Text of a body on a hinge about the y axis, with further elements before, inside and after the
/// body.
fn hinged(before: &str, inside: &str, after: &str) -> String {
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
fn properties(before: &str, geom: &str) -> [f64; 7] {
    let text = hinged(before, geom, "");
    let mechanism = model(&convert("r.xml", &text)).mechanism;
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

/// Vertices without faces, some of them inside or on faces and edges, and the hull of a mesh that is not convex.
#[test]
fn meshes_without_faces_are_their_convex_hull() {
    let points =
        "0 0 0 0.5 0 0 0 0.7 0 0 0 1.1 0.4 0.5 0.6 0.1 0.1 0.1 0.25 0 0 0.3 0.3 0.3 0.5 0.7 0";
    let place = "<geom type='mesh' mesh='q' pos='.1 .2 .3' euler='10 20 30'/>";
    let expected = [
        167.166_670_252_879_4,
        0.243_513_293_071_610_88,
        0.502_778_470_234_019_9,
        0.635_164_936_339_497_3,
        12.831_248_811_290_338,
        9.999_159_711_396_477,
        9.179_187_316_406_969,
    ];
    let l_shape = "0 0 0 .2 0 0 .2 .1 0 .1 .1 0 .1 .2 0 0 .2 0 0 0 .05 .2 0 .05 .2 .1 .05 .1 .1 .05 .1 .2 .05 0 .2 .05";
    let faces = "0 2 1 6 7 8 0 3 2 6 8 9 0 5 3 6 9 11 3 5 4 9 10 11 0 1 7 0 7 6 1 2 8 1 8 7 2 3 9 2 9 8 3 4 10 3 10 9 \
                 4 5 11 4 11 10 5 0 6 5 6 11";
    let of_l = [
        1.750_000_078_231_097_2,
        0.090_476_191_824_390_79,
        0.090_476_191_824_390_79,
        0.025_000_000_372_529_037,
        0.005_622_520_260_180_273,
        0.005_622_520_260_180_273,
        0.010_515_873_799_366_722,
    ];
    let free = "<geom type='mesh' mesh='q'/>";
    for (mesh, geom, expected) in [
        (format!("vertex='{points}'"), place, expected),
        (format!("vertex='{points}' inertia='convex'"), place, expected),
        (format!("vertex='{l_shape}' face='{faces}' inertia='convex'"), free, of_l),
    ] {
        let found = properties(&format!("<asset><mesh name='q' {mesh}/></asset>"), geom);
        for (found, expected) in found.into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-9 * expected.abs(), "{found} {expected}");
        }
    }
    let limited = format!("<asset><mesh name='q' vertex='{points}' maxhullvert='5'/></asset>");
    let said = notes(&convert("r.xml", &hinged(&limited, free, "")));
    assert!(said.contains("maxhullvert is left out"), "{said}");
    let asset = "<asset><mesh name='q' file='q.obj' inertia='convex'/></asset>";
    let held = "<geom size='.1'/></body><body name='b'><geom type='mesh' mesh='q'/>";
    let far = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1e300\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
    let said = notes(&with_files("r.xml", &hinged(asset, held, ""), &[("q.obj", far)], false));
    assert!(said.contains("the mesh `q` has vertices beyond single precision"), "{said}");
}

/// Meshes of unknown mass, on a moving body and on a body that is fixed to the world.
#[test]
fn bodies_do_not_lose_mass() {
    for (mesh, why) in [
        ("vertex='0 0 0 1 0 0 0 1 0 1 1 0'", "has no convex hull: all vertices are in a plane"),
        ("vertex='0 0 0 1 0 0 0 1 0 0 0 1' face='0 1 4'", "has no faces, or faces without"),
        ("builtin='sphere' params='2'", "has neither file nor faces"),
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
