//! Meshes of an MJCF file: their masses, and the simple shapes that MuJoCo fits to them.

use super::super::context::Context;
use super::super::hull::{Flat, convex_hull};
use super::super::inertia::Mass;
use super::super::mesh::{self, Content};
use super::super::xml::Element;
use super::Reader;
use crate::diagnostic::quoted;
use crate::triangles::{self, Surface, Triangle};
use nalgebra::{Matrix3, SymmetricEigen};
use std::collections::HashMap;
use stiction_core::spatial::{Mat3, Pose, Vec3};

/// Meshes by name: the elements of the file with the lists of vertices and faces in them, and the
/// meshes read so far. A mesh of unknown mass is replaced by the reason.
#[derive(Default)]
pub(super) struct Meshes {
    pub(super) found: HashMap<String, Element>,
    lists: HashMap<String, Surface>,
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

/// Remedy for a mesh whose triangles are not in the file, because MuJoCo generates it.
const SAVE: &str = "list the triangles in `face`, or give the body an <inertial>: MuJoCo can compute and write it \
                    (<compiler saveinertial=\"true\"/>, mj_saveLastXML)";
/// Remedy for a mesh without faces and without a convex hull.
const ADD_FACES: &str = "list the triangles in `face`, or give the body an <inertial>";
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
    fn new(vertices: impl Iterator<Item = Vec3<f64>>, mass: Mass) -> Self {
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
        for point in vertices {
            for (k, x) in to_principal.apply(point).to_array().into_iter().enumerate() {
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
    /// Stores the `mesh` elements of the MJCF file, with their lists of vertices and faces. The mesh
    /// files are read later, when a mass depends on them.
    pub(super) fn read_meshes(&mut self, root: &Element) {
        for element in root.all("asset").flat_map(|asset| asset.all("mesh")) {
            let mesh = self.defaults.applied(self.context, element, None);
            let file = mesh.get("file").map(|file| {
                let name = file.rsplit(['/', '\\']).next().unwrap_or(file);
                name.rsplit_once('.').map_or(name, |(stem, _)| stem).to_owned()
            });
            if mesh.get("file").is_none()
                && let Some(surface) = lists(self.context, &mesh)
                && let Some(name) = mesh.get("name")
            {
                self.meshes.lists.insert(name.to_owned(), surface);
            }
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
        let surface = match mesh.get("file") {
            Some(file) => {
                let path = self.settings.mesh_path(file);
                let failed = |why: String| {
                    lost(format!("the mesh {} cannot be read: {why}", quoted(&path)), REPLACE)
                };
                let bytes = (context.files)(&path)
                    .map_err(|why| Lost { is_absent: true, ..failed(why) })?;
                triangles::read_surface(&path, &bytes).map_err(failed)?
            }
            None => self.meshes.lists.get(name).cloned().ok_or_else(|| {
                lost(format!("the mesh {} has neither file nor vertices", quoted(name)), SAVE)
            })?,
        };
        if !surface.vertices.iter().all(|point| single(*point).is_finite()) {
            let why = format!("the mesh {} has vertices beyond single precision", quoted(name));
            return Err(lost(why, REPLACE));
        }
        let triangles = match (surface.triangles.is_empty(), mesh.get("inertia")) {
            (false, Some("convex")) => self.hull(mesh, &surface.vertices).unwrap_or_else(|why| {
                let message = format!(
                    "the mesh {} has {why}: the inertia is that of the mesh itself, not of its \
                     convex hull",
                    quoted(name)
                );
                context.note(message, Some(mesh.place()));
                surface.triangles
            }),
            (false, _) => surface.triangles,
            (true, _) => self
                .hull(mesh, &surface.vertices)
                .map_err(|why| lost(format!("the mesh {} has {why}", quoted(name)), ADD_FACES))?,
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
        Ok(Mesh::new(surface.vertices.iter().copied().map(placed), mass))
    }

    /// Returns the convex hull of vertices, by which MuJoCo replaces a mesh without faces, or the end
    /// of the sentence "the mesh has".
    fn hull(&self, mesh: &Element, vertices: &[Vec3<f64>]) -> Result<Vec<Triangle>, &'static str> {
        if mesh.number(self.context, "maxhullvert").is_some_and(|most| most > 0.0) {
            let message = "maxhullvert is left out: the convex hull keeps all of its vertices";
            self.context.note(message, Some(mesh.place()));
        }
        let points: Vec<Vec3<f64>> = vertices.iter().copied().map(single).collect();
        convex_hull(&points).map_err(|Flat| "no convex hull: all vertices are in a plane")
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

/// Reads the vertices and faces that a `mesh` element lists itself; `None` if it lists no vertices,
/// or after an error.
fn lists(context: &Context<'_>, mesh: &Element) -> Option<Surface> {
    let vertices: Vec<_> = triples(context, mesh, "vertex")?.into_iter().map(Vec3::from).collect();
    let faces = triples(context, mesh, "face").unwrap_or_default();
    let vertex = |index: f64| {
        let is_whole = index.fract() == 0.0 && index >= 0.0;
        let vertex = is_whole.then(|| vertices.get(index as usize).copied()).flatten();
        if vertex.is_none()
            && let Some(attribute) = mesh.attribute("face")
        {
            let most = vertices.len().saturating_sub(1);
            let message = format!(
                "{index} in `face` of {} is not the number of a vertex, from 0 to {most}",
                mesh.title()
            );
            let help = "give three numbers of vertices for each triangle; the first vertex is 0";
            context.error("mesh", message, &attribute.place(), help);
        }
        vertex
    };
    let triangle = |[a, b, c]: [f64; 3]| Some([vertex(a)?, vertex(b)?, vertex(c)?]);
    // One error for each mesh is enough.
    let triangles: Option<Vec<Triangle>> = faces.into_iter().map(triangle).collect();
    let triangles = triangles?;
    Some(Surface { vertices, triangles })
}

/// Reads a list of points or triangles; reports a list that is not a multiple of three numbers.
fn triples(context: &Context<'_>, mesh: &Element, key: &str) -> Option<Vec<[f64; 3]>> {
    let attribute = mesh.attribute(key)?;
    let numbers = mesh.list(context, key)?;
    let (triples, []) = numbers.as_chunks::<3>() else {
        let message = format!(
            "`{key}` of {} has {} numbers, which is not a multiple of 3",
            mesh.title(),
            numbers.len()
        );
        let help = match key {
            "vertex" => "give three coordinates for each vertex",
            _ => "give three numbers of vertices for each triangle",
        };
        context.error("mesh", message, &attribute.place(), help);
        return None;
    };
    Some(triples.to_vec())
}

/// Rounds a point to single precision, in which MuJoCo reads the vertices of all meshes.
fn single(point: Vec3<f64>) -> Vec3<f64> {
    Vec3::from(point.to_array().map(|x| f64::from(x as f32)))
}
