//! Mass of solids bounded by triangles.

use super::inertia::Mass;
use crate::triangles::Triangle;
use stiction_core::spatial::{Mat3, Vec3};

/// Mass of the solid with density 1. The orientation of the triangles, outwards or inwards, does not matter.
pub(super) fn solid(triangles: &[Triangle]) -> Mass {
    let Some([origin, ..]) = triangles.first().copied() else { return Mass::none() };
    let (mut volume, mut first) = (0.0, Vec3::zero());
    let mut second = [[0.0; 3]; 3];
    for triangle in triangles {
        // Relative to a point of the surface, so that the sums lose few digits by cancellation.
        let [a, b, c] = triangle.map(|point| point + -origin);
        let six = a.dot(b.cross(c));
        let sum = a + b + c;
        volume += six / 6.0;
        first += sum * (six / 24.0);
        for (i, row) in second.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                let product = |v: Vec3<f64>| v.component(i) * v.component(j);
                *entry += six / 120.0 * (product(sum) + product(a) + product(b) + product(c));
            }
        }
    }
    let size: f64 = (0..3).map(|k| second[k][k].abs()).sum();
    if !(volume.abs() > 0.0 && volume.is_finite() && size.is_finite()) {
        return Mass::none();
    }
    let sign = volume.signum();
    let com = first * volume.recip();
    let moment =
        |i: usize, j: usize| sign * (second[i][j] - volume * com.component(i) * com.component(j));
    let trace = moment(0, 0) + moment(1, 1) + moment(2, 2);
    let entry = |i: usize, j: usize| if i == j { trace - moment(i, i) } else { -moment(i, j) };
    let column = |j: usize| Vec3::new(entry(0, j), entry(1, j), entry(2, j));
    let inertia = Mat3::from_columns(column(0), column(1), column(2));
    Mass { mass: volume.abs(), com: com + origin, inertia }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::triangles::read;

    /// A box of 2 x 3 x 4 with a corner at (1, 1, 1), as OBJ with quadrangles.
    const BOX: &str = "v 1 1 1\nv 3 1 1\nv 3 4 1\nv 1 4 1\nv 1 1 5\nv 3 1 5\nv 3 4 5\nv 1 4 5\n\
        f 4 3 2 1\nf 5 6 7 8\nf 1/1 2/2 6/3 5/4\nf -6 -5 -1 -2\nf 3 4 8 7\nf 4 1 5 8\n";

    fn check(mass: Mass) {
        assert!((mass.mass - 24.0).abs() < 1e-12);
        let (com, centre) = (mass.com.to_array(), [2.0, 2.5, 3.0]);
        assert!((0..3).all(|k| (com[k] - centre[k]).abs() < 1e-12), "{com:?}");
        // m (b² + c²)/12.
        let expected = [50.0, 40.0, 26.0];
        for i in 0..3 {
            for j in 0..3 {
                let value = if i == j { expected[i] } else { 0.0 };
                assert!((mass.inertia.at(i, j) - value).abs() < 1e-11, "{i}{j}");
            }
        }
    }

    #[test]
    fn a_box_has_the_inertia_of_a_box() {
        // The fourth face has the wrong orientation in the file: corrected here, as no reader corrects it.
        let text = BOX.replace("f -6 -5 -1 -2", "f 2 3 7 6");
        let triangles = read("a.obj", text.as_bytes()).unwrap();
        check(solid(&triangles));
        let inwards: Vec<Triangle> = triangles.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
        check(solid(&inwards));
        let mut binary = vec![0; 80];
        binary.extend((triangles.len() as u32).to_le_bytes());
        let mut ascii = String::from("solid box\n");
        for triangle in &triangles {
            binary.extend([0; 12]);
            ascii += "facet normal 0 0 0\nouter loop\n";
            for point in triangle {
                let [x, y, z] = point.to_array();
                ascii += &format!("vertex {x} {y} {z}\n");
                binary.extend([x, y, z].iter().flat_map(|x| (*x as f32).to_le_bytes()));
            }
            ascii += "endloop\nendfacet\n";
            binary.extend([0; 2]);
        }
        check(solid(&read("a.stl", &binary).unwrap()));
        check(solid(&read("a.STL", ascii.as_bytes()).unwrap()));
    }

    #[test]
    fn broken_meshes_are_refused() {
        for (name, bytes) in [
            ("a.stl", &b""[..]),
            ("a.stl", b"solid\nvertex 1 2\n"),
            ("a.stl", b"vertex nan 0 0\nvertex 1 0 0\nvertex 0 1 0"),
            ("a.obj", b"f 1 2 3"),
            ("a.obj", b"v 1 2 3\nf 0 1 1"),
            ("a.obj", b"v 1 2 3\nf -9223372036854775808 1 1"),
            ("a.ply", b"ply"),
        ] {
            assert!(read(name, bytes).is_err(), "{name}");
        }
        assert_eq!(solid(&[]), Mass::none());
    }
}
