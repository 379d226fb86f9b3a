//! Masses of geoms.

use super::super::description::VisualMesh;
use super::super::inertia::Mass;
use super::super::mesh::{self, Content};
use super::super::solid::{capsule, cuboid, cylinder, ellipsoid};
use super::super::xml::Element;
use super::Reader;
use crate::diagnostic::quoted;
use crate::triangles::{self, Triangle};
use std::collections::HashMap;
use stiction_core::spatial::{Mat3, Pose, Vec3};

/// Default density, kg/m³.
const DENSITY: f64 = 1000.0;

/// Solids of the mesh files, with density 1, by mesh name; or the reason why a mesh bounds no
/// solid.
#[derive(Default)]
pub(super) struct Meshes {
    found: HashMap<String, Element>,
    read: HashMap<String, Result<Mass, String>>,
}

impl Reader<'_, '_> {
    /// Records the meshes of the file; their files are read when a mass depends on them.
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

    /// Mass of a geom in the frame of its body, without the poses of the enclosing frames.
    pub(super) fn geom_mass(&mut self, geom: &Element, body: &str) -> Mass {
        let context = self.context;
        let group = geom.number(context, "group").unwrap_or(0.0);
        let [least, greatest] = self.settings.geom_groups;
        if group < least || group > greatest {
            return Mass::none();
        }
        let word = match geom.get("type") {
            Some(word) => word,
            None if geom.attribute("mesh").is_some() => "mesh",
            None => "sphere",
        };
        let given = geom.number(context, "mass");
        if given == Some(0.0) {
            return Mass::none();
        }
        if geom.get("shellinertia") == Some("true") {
            let message = "inertias of shells are read as those of solids";
            context.note(message, Some(geom.place()));
        }
        let mut size = [0.0; 3];
        for (known, value) in size.iter_mut().zip(geom.list(context, "size").unwrap_or_default()) {
            *known = value.abs();
        }
        let mut pose = self.settings.pose(context, geom);
        if let Some([a, b, c, d, e, f]) = geom.numbers::<6>(context, "fromto") {
            let (from, to) = (Vec3::new(a, b, c), Vec3::new(d, e, f));
            let half = (to + -from) * 0.5;
            let along = half.direction().unwrap_or(Vec3::unit(2));
            pose =
                Pose { position: (from + to) * 0.5, rotation: Mat3::between(Vec3::unit(2), along) };
            size = match word {
                "box" | "ellipsoid" => [size[0], size[0], half.norm()],
                _ => [size[0], half.norm(), 0.0],
            };
        }
        let solid = match word {
            "sphere" => ellipsoid([size[0]; 3]),
            "ellipsoid" => ellipsoid(size),
            "box" => cuboid(size),
            "cylinder" => cylinder(size[0], size[1]),
            "capsule" => capsule(size[0], size[1]),
            "plane" | "hfield" => return Mass::none(),
            "mesh" => match self.mesh_of(geom, body) {
                Some(solid) => solid,
                None => return Mass::none(),
            },
            other => {
                let message = format!("geoms of type {} are imported without mass", quoted(other));
                context.note(message, Some(geom.place()));
                return Mass::none();
            }
        };
        let factor = match given {
            Some(mass) if solid.mass > 0.0 => mass / solid.mass,
            Some(_) => 0.0,
            None => geom.number(context, "density").unwrap_or(DENSITY),
        };
        solid.scaled(factor).placed(pose)
    }

    /// Mesh of a geom that viewers of MuJoCo show, and whose file exists.
    pub(super) fn visual_of(
        &self,
        (element, frame): (&Element, Pose<f64>),
        class: Option<&str>,
    ) -> Option<VisualMesh> {
        // By default they show these groups.
        const SHOWN: f64 = 2.0;
        if element.tag != "geom" {
            return None;
        }
        let context = self.context;
        let geom = self.defaults.applied(context, element, class);
        let mesh = self.meshes.found.get(geom.get("mesh")?)?;
        let is_moved = mesh.get("refpos").is_some() || mesh.get("refquat").is_some();
        if is_moved || geom.number(context, "group").unwrap_or(0.0) > SHOWN {
            return None;
        }
        let file = self.settings.mesh_path(mesh.get("file")?);
        let scale = mesh.numbers::<3>(context, "scale").unwrap_or([1.0; 3]);
        let pose = frame * self.settings.pose(context, &geom);
        context.has_mesh(&file).then_some(VisualMesh { file, scale, pose })
    }

    /// Solid of a mesh with density 1; a missing mesh is reported.
    fn mesh_of(&mut self, geom: &Element, body: &str) -> Option<Mass> {
        let name = geom.get("mesh")?;
        if !self.meshes.read.contains_key(name) {
            let solid = self.read_mesh(name);
            self.meshes.read.insert(name.to_owned(), solid);
        }
        match self.meshes.read.get(name)? {
            Ok(solid) => Some(*solid),
            Err(why) => {
                let message =
                    format!("{why}: the mass of body {} does not include this mesh", quoted(body));
                self.context.note(message, Some(geom.place()));
                None
            }
        }
    }

    fn read_mesh(&self, name: &str) -> Result<Mass, String> {
        let context = self.context;
        let mesh = self.meshes.found.get(name);
        let mesh = mesh.ok_or_else(|| format!("there is no mesh {}", quoted(name)))?;
        let scale = mesh.numbers::<3>(context, "scale").unwrap_or([1.0; 3]);
        let triangles = match (mesh.get("file"), mesh.list(context, "vertex")) {
            (Some(file), _) => {
                let path = self.settings.mesh_path(file);
                let failed =
                    |why: String| format!("the mesh {} cannot be read: {why}", quoted(&path));
                let bytes = (context.files)(&path).map_err(failed)?;
                let triangles = triangles::read(&path, &bytes).map_err(failed)?;
                triangles.iter().map(|corners| corners.map(single)).collect()
            }
            (None, Some(vertices)) => {
                let faces = mesh.list(context, "face").unwrap_or_default();
                let point = |index: &f64| {
                    let at = 3 * (*index as usize);
                    let point = vertices.get(at..at + 3)?;
                    Some(Vec3::new(point[0], point[1], point[2]))
                };
                let triangle =
                    |face: &[f64]| Some([point(&face[0])?, point(&face[1])?, point(&face[2])?]);
                let triangles: Option<Vec<_>> = faces.chunks_exact(3).map(triangle).collect();
                let triangles = triangles.filter(|triangles| !triangles.is_empty());
                triangles.ok_or_else(|| format!("the mesh {} has no faces", quoted(name)))?
            }
            _ => return Err(format!("the mesh {} has no file", quoted(name))),
        };
        let position = Vec3::from(mesh.numbers::<3>(context, "refpos").unwrap_or([0.0; 3]));
        let turn = mesh.numbers::<4>(context, "refquat");
        let turn = turn.and_then(super::super::rotation::quaternion).unwrap_or(Mat3::identity());
        let placed = |point: Vec3<f64>| {
            let turned = turn.transpose() * (point + -position);
            Vec3::new(turned.x * scale[0], turned.y * scale[1], turned.z * scale[2])
        };
        let triangles: Vec<Triangle> =
            triangles.iter().map(|corners| corners.map(placed)).collect();
        let content = match mesh.get("inertia") {
            Some("exact") => Content::Solid,
            Some("legacy") => Content::Pyramids,
            Some("shell") => Content::Shell,
            Some("convex") => {
                let message = "the inertia of the convex hull is read as that of the mesh";
                context.note(message, Some(mesh.place()));
                Content::Solid
            }
            _ if self.settings.exact_meshes => Content::Solid,
            _ => Content::Pyramids,
        };
        let mass = mesh::mass(&triangles, content);
        if content == Content::Pyramids {
            self.note_overcount(mesh, mass.mass / mesh::mass(&triangles, Content::Solid).mass);
        }
        Ok(mass)
    }

    /// Notes that a mesh has more, or less, mass than it encloses; `ratio` of both.
    fn note_overcount(&self, mesh: &Element, ratio: f64) {
        // Below it, the mesh itself is less exact.
        const NOTABLE: f64 = 0.01;
        // Beyond it, what the faces enclose is no measure of the body.
        const MEANINGLESS: f64 = 10.0;
        if !(ratio.is_finite() && ratio <= MEANINGLESS) {
            let message = "the faces of the mesh enclose hardly any volume (holes, or mixed orientations): its mass \
                           follows MuJoCo's default rule";
            self.context.note(message, Some(mesh.place()));
        } else if (ratio - 1.0).abs() > NOTABLE {
            let message = format!(
                "by MuJoCo's default rule, the mesh has {ratio:.3} times the mass of its volume; \
                 write inertia=\"exact\" for the mass of the volume"
            );
            self.context.note(message, Some(mesh.place()));
        }
    }
}

/// Rounds to single precision, in which MuJoCo reads the vertices of all mesh files.
fn single(point: Vec3<f64>) -> Vec3<f64> {
    Vec3::from(point.to_array().map(|x| f64::from(x as f32)))
}
