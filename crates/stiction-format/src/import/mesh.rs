//! Mass properties of triangle meshes.

use super::inertia::{Mass, steiner};
use crate::triangles::Triangle;
use stiction_core::spatial::{Mat3, Vec3};

/// Assumed distribution of the mass of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Content {
    /// The enclosed solid, with density 1 kg/m³.
    Solid,
    /// Pyramids from the centre of mass to all triangles, with density 1 kg/m³ (MuJoCo's `legacy`).
    /// Pyramids to triangles that face the centre are added, not subtracted, so that the result
    /// equals `Solid` only if the centre sees every triangle from inside.
    Pyramids,
    /// The surface alone, with 1 kg/m².
    Shell,
}

/// Mass properties of a mesh; zero if the mesh is degenerate. The triangles may all be oriented
/// outwards or all inwards.
pub(super) fn mass(triangles: &[Triangle], content: Content) -> Mass {
    let Some([corner, ..]) = triangles.first().copied() else { return Mass::none() };
    let mass = match content {
        // Relative to a point of the surface, so that the sums lose few digits by cancellation.
        Content::Solid => about_own_com(Moments::of_pyramids(triangles, corner, |volume| volume)),
        Content::Shell => about_own_com(Moments::of_surface(triangles, corner)),
        Content::Pyramids => pyramids(triangles, corner),
    };
    let size: f64 = (0..3).map(|k| mass.inertia.at(k, k).abs()).sum();
    let is_valid = mass.mass > 0.0 && mass.mass.is_finite() && size.is_finite();
    if is_valid { mass } else { Mass::none() }
}

/// Mass, and first and second moments of mass, about an apex.
struct Moments {
    apex: Vec3<f64>,
    mass: f64,
    first: Vec3<f64>,
    second: [[f64; 3]; 3],
}

impl Moments {
    fn none(apex: Vec3<f64>) -> Self {
        Self { apex, mass: 0.0, first: Vec3::zero(), second: [[0.0; 3]; 3] }
    }

    /// Adds a mass that is uniform over a simplex with `count` corners: a triangle or a pyramid.
    /// `a`, `b` and `c` are corners relative to the apex; the fourth corner of a pyramid is the
    /// apex.
    fn add(&mut self, mass: f64, [a, b, c]: Triangle, count: f64) {
        let sum = a + b + c;
        self.mass += mass;
        self.first += sum * (mass / count);
        for (i, row) in self.second.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                let product = |v: Vec3<f64>| v.component(i) * v.component(j);
                let squares = product(sum) + product(a) + product(b) + product(c);
                *entry += mass / (count * (count + 1.0)) * squares;
            }
        }
    }

    /// Sums the moments of the pyramids from the apex to all triangles, with density 1 kg/m³.
    /// `sign` maps the signed volume of a pyramid to its mass.
    fn of_pyramids(triangles: &[Triangle], apex: Vec3<f64>, sign: fn(f64) -> f64) -> Self {
        let mut moments = Self::none(apex);
        for triangle in triangles {
            let corners = triangle.map(|point| point + -apex);
            let [a, b, c] = corners;
            moments.add(sign(a.dot(b.cross(c)) / 6.0), corners, 4.0);
        }
        moments
    }

    /// Sums the moments of all triangles, with 1 kg/m².
    fn of_surface(triangles: &[Triangle], apex: Vec3<f64>) -> Self {
        let mut moments = Self::none(apex);
        for triangle in triangles {
            moments.add(area(triangle), triangle.map(|point| point + -apex), 3.0);
        }
        moments
    }

    fn com(&self) -> Vec3<f64> {
        self.apex + self.first * self.mass.recip()
    }

    /// Inertia tensor about the apex.
    fn inertia(&self) -> Mat3<f64> {
        let trace: f64 = (0..3).map(|k| self.second[k][k]).sum();
        let entry = |i: usize, j: usize| if i == j { trace } else { 0.0 } - self.second[i][j];
        let column = |j: usize| Vec3::new(entry(0, j), entry(1, j), entry(2, j));
        Mat3::from_columns(column(0), column(1), column(2))
    }
}

/// Converts moments about the apex to a mass with its inertia about the centre of mass. If the
/// triangles face inwards, the signed volume is negative and its sign is removed.
fn about_own_com(moments: Moments) -> Mass {
    let com = moments.com();
    let moved = steiner(moments.mass, com + -moments.apex);
    let inertia = (moments.inertia() + moved * -1.0) * moments.mass.signum();
    Mass { mass: moments.mass.abs(), com, inertia }
}

/// Mass properties by MuJoCo's rule `legacy`: the centre of mass is computed from pyramids about
/// the centroid of the surface, mass and inertia from pyramids about this centre of mass.
fn pyramids(triangles: &[Triangle], corner: Vec3<f64>) -> Mass {
    let centroid = Moments::of_surface(triangles, corner).com();
    let com = Moments::of_pyramids(triangles, centroid, f64::abs).com();
    let moments = Moments::of_pyramids(triangles, com, f64::abs);
    Mass { mass: moments.mass, com, inertia: moments.inertia() }
}

fn area([a, b, c]: &Triangle) -> f64 {
    (*b + -*a).cross(*c + -*a).norm() / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::triangles::read;

    fn solid(triangles: &[Triangle]) -> Mass {
        mass(triangles, Content::Solid)
    }

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
        // The fourth face has the wrong orientation in the text; it is corrected here because the
        // readers of meshes do not correct it.
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
    fn a_convex_solid_consists_of_pyramids_and_has_a_shell() {
        let triangles =
            read("a.obj", BOX.replace("f -6 -5 -1 -2", "f 2 3 7 6").as_bytes()).unwrap();
        check(mass(&triangles, Content::Pyramids));
        let shell = mass(&triangles, Content::Shell);
        assert!((shell.mass - 52.0).abs() < 1e-12);
        // About x: two plates 3 x 4 across the axis, and two pairs at half the edges from it.
        let across = 24.0 * (9.0 + 16.0) / 12.0;
        let along = 16.0 * (4.0 * 4.0 / 12.0 + 1.5 * 1.5);
        let below = 12.0 * (3.0 * 3.0 / 12.0 + 2.0 * 2.0);
        let expected = across + along + below;
        assert!((shell.inertia.at(0, 0) - expected).abs() < 1e-11 * expected);
    }

    /// Checks that `Pyramids` overestimates the mass of a cube with a pit: pyramids to triangles
    /// that face the centre are added instead of subtracted.
    #[test]
    fn pyramids_overcount_what_is_not_convex() {
        let with_pit = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n\
            v 0 0 -0.5\nf 4 3 2 1\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n\
            f 5 6 9\nf 6 7 9\nf 7 8 9\nf 8 5 9\n";
        let triangles = read("a.obj", with_pit.as_bytes()).unwrap();
        let exact = solid(&triangles);
        assert!((exact.mass - 6.0).abs() < 1e-12);
        assert!(mass(&triangles, Content::Pyramids).mass > 6.01);
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
            ("a.msh", b"\x03\0\0\0"),
            ("a.msh", &[255; 64]),
        ] {
            assert!(read(name, bytes).is_err(), "{name}");
        }
        assert_eq!(solid(&[]), Mass::none());
    }
}
