//! Meshes of MJCF without faces, and defective ones. The expected numbers are those of MuJoCo 4.0.0 for the same files.

use super::mujoco::{hinged, notes, properties, properties_with};
use super::tree::{convert, refused, with_files};

/// Checks mass properties to nine digits.
fn check(found: [f64; 7], expected: [f64; 7], what: &str) {
    for (found, expected) in found.into_iter().zip(expected) {
        assert!((found - expected).abs() < 1e-9 * expected.abs(), "{what}: {found} {expected}");
    }
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

/// Vertices of a tetrahedron, one outside and one inside, separated by spaces and tabs.
const POINTS: &str = "v 0 0 0\nv .5 0 0\nv\t0 .7\t0\nv 0 0 1.1\nv .6 .5 .4\n  v .1 .1 .1 1\n";
const FACES: &str = "f 1 3 2\nf\t1 2 4\nf 1 4 3\nf 2 3 4\n";

/// Faces of one line and of none; vertices of a file that belong to no face count for the hull and for bounds.
#[test]
fn all_vertices_of_files_count() {
    let hull = [
        146.166_671_027_739_82,
        0.209_150_518_115_592_02,
        0.245_125_425_996_226_91,
        0.331_100_349_977_592,
        9.881_817_045_374_277,
        9.254_551_561_586_057,
        5.971_788_287_257_548,
    ];
    let tetrahedron = [
        64.166_666_964_689_87,
        0.125,
        0.174_999_997_019_767_73,
        0.275_000_005_960_464_4,
        4.090_625_121_954_649,
        3.513_125_127_371_236_3,
        1.780_624_966_368_418_2,
    ];
    let box_of_hull = [
        583.975_837_340_487_5,
        0.171_535_265_980_239_58,
        0.162_601_090_225_717_23,
        0.515_782_303_289_529,
        99.055_827_616_003_61,
        92.396_310_122_658_76,
        51.665_243_727_588_81,
    ];
    let bounding_box = [
        882.421_024_283_518_8,
        0.215_900_982_887_591_46,
        0.216_870_034_511_765_79,
        0.541_396_387_072_833_8,
        164.523_491_131_171_7,
        160.755_373_474_492_12,
        110.389_313_135_368,
    ];
    let edge = "f 1 2\n";
    for (inertia, faces, kind, expected) in [
        ("", "", "mesh", hull),
        ("", edge, "mesh", hull),
        ("inertia='exact'", "", "mesh", hull),
        ("inertia='convex'", FACES, "mesh", hull),
        ("", FACES, "mesh", tetrahedron),
        ("", "", "box", box_of_hull),
        ("inertia='convex'", FACES, "box", box_of_hull),
        ("", FACES, "box", bounding_box),
    ] {
        let before = format!(
            "<compiler fitaabb='true'/><asset><mesh name='q' file='q.obj' {inertia}/></asset>"
        );
        let geom = format!("<geom type='{kind}' mesh='q'/>");
        let text = format!("{POINTS}{faces}");
        let found = properties_with(&before, &geom, &[("q.obj", &text)]);
        // MuJoCo stores vertices in the principal frame in single precision.
        for (found, expected) in found.into_iter().zip(expected) {
            let error = (found - expected).abs() / expected;
            assert!(error < 1e-7, "{inertia} {faces:?} {kind}: {found} {expected}");
        }
    }
}

/// A file of MuJoCo's own format with five vertices and no faces; the bytes of its numbers are letters.
#[test]
fn binary_files_without_faces_are_their_hull() {
    let (zero, two, half) = ("\0\0\0\0", "\0\0\0@", "\0\0\0?");
    let header = "\u{5}\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0".to_owned();
    let vertices = [[zero, zero, zero], [two, zero, zero], [zero, half, zero], [zero, zero, two]];
    let text = header + &vertices.concat().concat() + &half.repeat(3);
    let asset = "<asset><mesh name='q' file='q.msh'/></asset>";
    let found = properties_with(asset, "<geom type='mesh' mesh='q'/>", &[("q.msh", &text)]);
    let expected = [
        500.0,
        0.541_666_666_666_666_6,
        0.166_666_666_666_666_66,
        0.541_666_666_666_666_7,
        81.076_388_888_889_37,
        148.263_888_888_889_7,
        81.076_388_888_889_38,
    ];
    check(found, expected, "q.msh");
}

/// Lists that MuJoCo refuses: the message names the attribute, its line, the number and a remedy, also for meshes that
/// no geom uses.
#[test]
fn defective_lists_are_refused() {
    const POINTS: &str = "0 0 0 1 0 0 0 1 0 0 0 1";
    for (list, why, cure) in [
        (
            format!("vertex='{POINTS} 2'"),
            "`vertex` of mesh `q` has 13 numbers, which is not a multiple of 3",
            "three coordinates for each vertex",
        ),
        (
            format!("vertex='{POINTS}'\nface='0 2 1 0 1'"),
            "`face` of mesh `q` has 5 numbers, which is not a multiple of 3",
            "three numbers of vertices for each triangle",
        ),
        (
            format!("vertex='{POINTS}'\nface='0 2 1 0 1 4'"),
            "4 in `face` of mesh `q` is not the number of a vertex, from 0 to 3",
            "the first vertex is 0",
        ),
        (format!("vertex='{POINTS}'\nface='0 2 -1'"), "-1 in `face` of mesh `q` is not", "is 0"),
        (format!("vertex='{POINTS}'\nface='0 2 1.5'"), "1.5 in `face` of mesh `q` is not", "is 0"),
        (format!("vertex='{POINTS}'\nface='0 2 1e30'"), "in `face` of mesh `q` is not", "is 0"),
        (format!("vertex='{POINTS} nan'"), "`nan` is not a finite number", "a number"),
        (format!("vertex='{POINTS}'\nface='0 2 inf'"), "`inf` is not a finite number", "a number"),
    ] {
        for geom in ["<geom type='mesh' mesh='q'/>", "<geom size='.1'/>"] {
            let said = refused(
                "r.xml",
                &hinged(&format!("<asset><mesh name='q' {list}/></asset>"), geom, ""),
            );
            let line = if list.contains("face") { 2 } else { 1 };
            assert!(said.contains(why) && said.contains(cure), "{list}:\n{said}");
            assert!(said.contains(&format!("r.xml:{line}:")), "{list}:\n{said}");
            assert_eq!(said.matches("error").count(), 1, "{list}:\n{said}");
        }
    }
}

/// Files in which a triangle lacks a corner or a face a vertex; SDF needs faces.
#[test]
fn defective_files_are_refused() {
    for (file, text, why) in [
        (
            "q.stl",
            "vertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nvertex 0 0 1",
            "4 corners of triangles",
        ),
        ("q.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9", "a corner that does not exist"),
        ("q.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 nan", "not a finite number"),
        ("q.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0", "all vertices are in a plane"),
        ("q.obj", "# empty", "it has no vertices"),
        (
            "q.obj",
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 1e39 0 0\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3",
            "vertices beyond single precision",
        ),
    ] {
        // A mesh of unknown mass on a fixed body is a note instead of an error.
        let held = "<geom size='.1'/></body><body name='b'><geom type='mesh' mesh='q'/>";
        let asset = format!("<asset><mesh name='q' file='{file}'/></asset>");
        let said = notes(&with_files("r.xml", &hinged(&asset, held, ""), &[(file, text)], false));
        assert!(said.contains(why) && said.contains("r.xml:2: "), "{file}: {said}");
    }
}
