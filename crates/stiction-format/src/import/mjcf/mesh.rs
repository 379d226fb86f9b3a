//! Meshes of an MJCF file: their masses, and the simple shapes that MuJoCo fits to them.

use super::super::hull::{NoHull, convex_hull};
use super::super::inertia::Mass;
use super::super::mesh::{self, Content};
use super::super::xml::Element;
use super::Reader;
use crate::diagnostic::quoted;
use crate::triangles::{self, Triangle};
use nalgebra::{Matrix3, SymmetricEigen};
use std::collections::HashMap;
use stiction_core::spatial::{Mat3, Pose, Vec3};

/// Meshes by name: the elements of the file, and the meshes read so far. A mesh of unknown mass is
/// replaced by the reason.
#[derive(Default)]
pub(super) struct Meshes {
    pub(super) found: HashMap<String, Element>,
    read: HashMap<String, Result<Mesh, Lost>>,
}

/// Reason why the mass of a geom is unknown, as the beginning of a sentence, and the remedy for the
/// user.
#[derive(Clone, Debug)]
pub(super) struct Lost {
    pub(super) why: String,
    pub(super) cure: &'static str,
    /// True if the file of the mesh is absent, as in robots that are published without their
    /// meshes.
    pub(super) is_absent: bool,
}

/// Remedy for a mesh that has no triangles in the file, because MuJoCo generates it, or whose convex
/// hull is too large.
const SAVE: &str = "list the triangles in `face`, or give the body an <inertial>: MuJoCo can compute and write it \
                    (<compiler saveinertial=\"true\"/>, mj_saveLastXML)";
/// Remedy for a mesh that cannot be read.
const REPLACE: &str = "provide a valid mesh file (its path is relative to the robot file and to `meshdir`), or give \
                       the body an <inertial>";

/// A mesh with its mass properties for density 1.
#[derive(Clone, Debug)]
pub(super) struct Mesh {
    pub(super) mass: Mass,
    /// Frame of the principal axes at the centre of mass, in the frame of the mesh; the moments decrease from x to z.
    principal: Pose<f64>,
    /// Half the edges of the box with the same mass and inertia as the mesh.
    inertia_box: [f64; 3],
    /// Least and greatest coordinates of the vertices in the principal frame.
    bounds: [[f64; 3]; 2],
}

/// A simple shape that replaces a mesh.
pub(super) struct Fitted {
    pub(super) size: [f64; 3],
    /// Pose of the shape in the frame of the mesh.
    pub(super) pose: Pose<f64>,
}

impl Mesh {
    fn new(triangles: &[Triangle], mass: Mass) -> Self {
        let eigen = SymmetricEigen::new(Matrix3::from(mass.inertia));
        let mut order = [0, 1, 2];
        order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
        let axis = |k: usize| Vec3::from(eigen.eigenvectors.column(order[k]).into_owned());
        let rotation = Mat3::from_columns(axis(0), axis(1), axis(0).cross(axis(1)));
        let principal = Pose { position: mass.com, rotation };
        let moments = order.map(|k| eigen.eigenvalues[k]);
        let half = |k: usize| {
            let others = moments[(k + 1) % 3] + moments[(k + 2) % 3];
            (6.0 * (others - moments[k]).max(0.0) / mass.mass).sqrt() / 2.0
        };
        let mut bounds = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        let to_principal = principal.inverse();
        for point in triangles.iter().flatten() {
            for (k, x) in to_principal.apply(*point).to_array().into_iter().enumerate() {
                bounds[0][k] = bounds[0][k].min(x);
                bounds[1][k] = bounds[1][k].max(x);
            }
        }
        Self { mass, principal, inertia_box: [half(0), half(1), half(2)], bounds }
    }

    /// Returns the shape of type `word` that MuJoCo fits to the mesh. The shape is fitted to the
    /// box with the same inertia as the mesh or, if `to_bounds` (MuJoCo's `fitaabb`), to the
    /// bounding box along the principal axes. `None` for an unknown type.
    pub(super) fn fitted(&self, word: &str, to_bounds: bool) -> Option<Fitted> {
        let [least, greatest] = self.bounds;
        let [x, y, z] = match to_bounds {
            true => [0, 1, 2].map(|k| (greatest[k] - least[k]) / 2.0),
            false => self.inertia_box,
        };
        let radius = if to_bounds { x.max(y) } else { (x + y) / 2.0 };
        let size = match word {
            "sphere" if to_bounds => [x.max(y).max(z), 0.0, 0.0],
            "sphere" => [(x + y + z) / 3.0, 0.0, 0.0],
            "capsule" if to_bounds => [radius, (z - radius).max(0.0), 0.0],
            "capsule" => [radius, (z - radius / 2.0).max(0.0), 0.0],
            "cylinder" => [radius, z, 0.0],
            "box" | "ellipsoid" => [x, y, z],
            _ => return None,
        };
        let centre = match to_bounds {
            true => Vec3::from([0, 1, 2].map(|k| (greatest[k] + least[k]) / 2.0)),
            false => Vec3::zero(),
        };
        Some(Fitted { size, pose: self.principal * Pose::at(centre) })
    }
}

impl Reader<'_, '_> {
    /// Stores the `mesh` elements of the MJCF file. The mesh files are read later, when a mass
    /// depends on them.
    pub(super) fn read_meshes(&mut self, root: &Element) {
        for element in root.all("asset").flat_map(|asset| asset.all("mesh")) {
            let mesh = self.defaults.applied(self.context, element, None);
            let file = mesh.get("file").map(|file| {
                let name = file.rsplit(['/', '\\']).next().unwrap_or(file);
                name.rsplit_once('.').map_or(name, |(stem, _)| stem).to_owned()
            });
            let Some(name) = mesh.get("name").map(str::to_owned).or(file) else { continue };
            self.meshes.found.insert(name, mesh);
        }
    }

    /// Returns the mesh of this name, which is read at its first use.
    pub(super) fn mesh(&mut self, name: &str) -> Result<Mesh, Lost> {
        if !self.meshes.read.contains_key(name) {
            let mesh = self.read_mesh(name);
            self.meshes.read.insert(name.to_owned(), mesh);
        }
        self.meshes.read[name].clone()
    }

    fn read_mesh(&self, name: &str) -> Result<Mesh, Lost> {
        let context = self.context;
        let mesh = self.meshes.found.get(name);
        let lost = |why: String, cure: &'static str| Lost { why, cure, is_absent: false };
        let mesh = mesh.ok_or_else(|| {
            lost(format!("there is no mesh {}", quoted(name)), "correct the name in `mesh`")
        })?;
        let scale = mesh.numbers::<3>(context, "scale").unwrap_or([1.0; 3]);
        let triangles = match (mesh.get("file"), mesh.list(context, "vertex")) {
            (Some(file), _) => {
                let path = self.settings.mesh_path(file);
                let failed = |why: String| {
                    lost(format!("the mesh {} cannot be read: {why}", quoted(&path)), REPLACE)
                };
                let bytes = (context.files)(&path)
                    .map_err(|why| Lost { is_absent: true, ..failed(why) })?;
                triangles::read(&path, &bytes).map_err(failed)?
            }
            (None, Some(vertices)) if mesh.get("face").is_none() => {
                let points =
                    vertices.chunks_exact(3).map(|at| single(Vec3::new(at[0], at[1], at[2])));
                self.hull(mesh, points.collect())
                    .map_err(|why| lost(format!("the mesh {} has {why}", quoted(name)), SAVE))?
            }
            (None, Some(vertices)) => {
                let faces = mesh.list(context, "face").unwrap_or_default();
                let count = vertices.len() / 3;
                let point = |index: &f64| {
                    let exists = index.fract() == 0.0 && *index >= 0.0 && *index < count as f64;
                    let at = exists.then(|| 3 * (*index as usize))?;
                    let point = vertices.get(at..at + 3)?;
                    Some(Vec3::new(point[0], point[1], point[2]))
                };
                let triangle =
                    |face: &[f64]| Some([point(&face[0])?, point(&face[1])?, point(&face[2])?]);
                let triangles: Option<Vec<_>> = faces.chunks_exact(3).map(triangle).collect();
                let triangles = triangles.filter(|triangles| !triangles.is_empty());
                let why =
                    || format!("the mesh {} has no faces, or faces without vertices", quoted(name));
                triangles.ok_or_else(|| lost(why(), SAVE))?
            }
            _ => {
                let why = format!("the mesh {} has neither file nor faces", quoted(name));
                return Err(lost(why, SAVE));
            }
        };
        let position = Vec3::from(mesh.numbers::<3>(context, "refpos").unwrap_or([0.0; 3]));
        let turn = mesh.numbers::<4>(context, "refquat");
        let turn = turn.and_then(super::super::rotation::quaternion).unwrap_or(Mat3::identity());
        let placed = |point: Vec3<f64>| {
            let turned = turn.transpose() * (single(point) + -position);
            Vec3::new(turned.x * scale[0], turned.y * scale[1], turned.z * scale[2])
        };
        let triangles: Vec<Triangle> =
            triangles.iter().map(|corners| corners.map(placed)).collect();
        let triangles = match mesh.get("inertia") {
            Some("convex") => {
                let corners = triangles.iter().flatten().copied().collect();
                self.hull(mesh, corners).unwrap_or_else(|why| {
                    let message = format!(
                        "the mesh {} has {why}: the inertia is that of the mesh itself, not of its \
                         convex hull",
                        quoted(name)
                    );
                    context.note(message, Some(mesh.place()));
                    triangles
                })
            }
            _ => triangles,
        };
        let content = match mesh.get("inertia") {
            Some("exact" | "convex") => Content::Solid,
            Some("legacy") => Content::Pyramids,
            Some("shell") => Content::Shell,
            _ if self.settings.exact_meshes => Content::Solid,
            _ => Content::Pyramids,
        };
        let mass = mesh::mass(&triangles, content);
        if content == Content::Pyramids {
            self.note_overcount(mesh, mass.mass / mesh::mass(&triangles, Content::Solid).mass);
        }
        if mass.mass == 0.0 {
            return Err(lost(format!("the mesh {} encloses no volume", quoted(name)), REPLACE));
        }
        Ok(Mesh::new(&triangles, mass))
    }

    /// Returns the convex hull of points, by which MuJoCo replaces a mesh without faces, or the end
    /// of the sentence "the mesh has".
    fn hull(&self, mesh: &Element, points: Vec<Vec3<f64>>) -> Result<Vec<Triangle>, &'static str> {
        if mesh.number(self.context, "maxhullvert").is_some_and(|most| most > 0.0) {
            let message = "maxhullvert is left out: the convex hull keeps all of its vertices";
            self.context.note(message, Some(mesh.place()));
        }
        if !points.iter().all(|point| point.is_finite()) {
            return Err("vertices beyond single precision");
        }
        convex_hull(&points).map_err(|error| match error {
            NoHull::Flat => "no convex hull: all vertices are in a plane",
            NoHull::TooLarge => "too large a convex hull: more than 20 000 faces",
        })
    }

    /// Adds a remark if the mass of a mesh by MuJoCo's default rule differs from the mass of the
    /// volume that the mesh encloses. `ratio` is the mass by the default rule divided by the mass
    /// of the volume.
    fn note_overcount(&self, mesh: &Element, ratio: f64) {
        // Smaller relative differences are below the accuracy of the mesh itself.
        const NOTABLE: f64 = 0.01;
        // Above this ratio, the enclosed volume says nothing about the body.
        const MEANINGLESS: f64 = 10.0;
        if !(ratio.is_finite() && ratio <= MEANINGLESS) {
            let message = "the faces of the mesh enclose hardly any volume (holes, or mixed orientations): its mass \
                           follows MuJoCo's default rule";
            self.context.note(message, Some(mesh.place()));
        } else if (ratio - 1.0).abs() > NOTABLE {
            let message = format!(
                "by MuJoCo's default rule, the mass of the mesh is {ratio:.3} times that of its enclosed volume; \
                 write inertia=\"exact\" to use the volume"
            );
            self.context.note(message, Some(mesh.place()));
        }
    }
}

/// Rounds a point to single precision, in which MuJoCo reads the vertices of all meshes.
fn single(point: Vec3<f64>) -> Vec3<f64> {
    Vec3::from(point.to_array().map(|x| f64::from(x as f32)))
}
