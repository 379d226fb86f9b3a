//! Reads the links of an SDF file.

use super::super::description::{Body, VisualMesh};
use super::super::inertia::{Mass, negative_mass, symmetric};
use super::super::mesh::{self, Content};
use super::super::solid::{capsule, cuboid, cylinder, ellipsoid};
use super::super::xml::Element;
use super::Reader;
use super::frames::pose;
use super::models::Model;
use crate::diagnostic::quoted;
use crate::triangles;
use stiction_core::spatial::{Mat3, Vec3};

/// Remedy for a link whose mass cannot be computed from its shapes.
const WRITE_MASS: &str = "write the numbers in <inertial> instead of auto=\"true\"";

/// Default density of collision shapes, kg/m³.
const DENSITY: f64 = 1000.0;

impl Reader<'_, '_> {
    pub(super) fn read_link(&mut self, model: &Model, link: &Element) -> Option<()> {
        let context = self.context;
        let name = model.full(link.required(context, "name")?);
        let mut body = Body::massless(name.clone(), Some(link.place()));
        let mass = match link.child("inertial") {
            Some(inertial) if matches!(inertial.get("auto"), Some("true" | "1")) => {
                self.mass_of_shapes(link, inertial)
            }
            Some(inertial) => self.inertial(inertial),
            None => {
                let message = "links without <inertial> have 1 kg and 1 kg m^2 about each axis, \
                               as SDF defines";
                context.note(message, Some(link.place()));
                Mass { mass: 1.0, inertia: Mat3::identity(), ..Mass::none() }
            }
        };
        if mass.mass < 0.0 {
            let message = negative_mass("link", &name, mass.mass);
            let place = link.child("inertial").and_then(|inertial| inertial.child("mass"));
            let place = place.map_or_else(|| link.place(), Element::place);
            context.error("mass", message, &place, "masses are at least 0 kg");
        }
        (body.mass, body.com, body.inertia) = (mass.mass, mass.com, mass.inertia);
        body.visuals = link.all("visual").filter_map(|visual| self.mesh_of(visual)).collect();
        let shapes =
            link.all("collision").filter_map(|shape| shape.child("geometry")?.child("mesh"));
        for file in shapes.filter_map(|mesh| mesh.child("uri")) {
            context.is_mesh_file(&file.text, &file.place());
        }
        let index = self.robot.bodies.len();
        if self.bodies.insert(name.clone(), index).is_some() {
            let message = format!("there are two links named {}", quoted(&name));
            context.error("name", message, &link.place(), "");
            return None;
        }
        self.poses.push(self.frames.pose(&name));
        self.robot.bodies.push(body);
        Some(())
    }

    /// Mesh of a `visual` element; `None` if the element has no mesh, or if the mesh cannot be
    /// shown.
    fn mesh_of(&self, visual: &Element) -> Option<VisualMesh> {
        let mesh = visual.child("geometry")?.child("mesh")?;
        let uri = mesh.child("uri")?;
        let file = uri.text.trim().to_owned();
        let scale = mesh.child("scale").and_then(|scale| scale.text_numbers::<3>(self.context));
        let pose = pose(self.context, visual);
        let scale = scale.unwrap_or([1.0; 3]);
        self.context.has_mesh(&file, uri.place()).then_some(VisualMesh { file, scale, pose })
    }

    fn inertial(&self, inertial: &Element) -> Mass {
        let context = self.context;
        let mass = inertial.child_number(context, "mass").unwrap_or(1.0);
        let entry = |key: &str, default: f64| {
            let inertia = inertial.child("inertia");
            inertia.and_then(|inertia| inertia.child_number(context, key)).unwrap_or(default)
        };
        let diagonal = ["ixx", "iyy", "izz"].map(|key| entry(key, 1.0));
        let products = ["ixy", "ixz", "iyz"].map(|key| entry(key, 0.0));
        let [[xx, yy, zz], [xy, xz, yz]] = [diagonal, products];
        if let Some(fluid) = inertial.child("fluid_added_mass") {
            let message = "the added mass of a fluid has no counterpart in the model";
            context.warn(message, Some(fluid.place()));
        }
        let inertia = symmetric([xx, yy, zz, xy, xz, yz]);
        Mass { mass, com: Vec3::zero(), inertia }.placed(pose(context, inertial))
    }

    /// Mass properties of a link, computed from its collision shapes. If the file gives the mass, the densities only
    /// determine how it is distributed.
    fn mass_of_shapes(&self, link: &Element, inertial: &Element) -> Mass {
        let context = self.context;
        let density = inertial.child_number(context, "density");
        let shapes = link.all("collision").fold(Mass::none(), |sum, collision| {
            let own = collision.child_number(context, "density").or(density).unwrap_or(DENSITY);
            let solid = self.shape(collision).unwrap_or(Mass::none());
            sum.with(solid.scaled(own).placed(pose(context, collision)))
        });
        for ignored in ["pose", "inertia"].iter().filter_map(|key| inertial.child(key)) {
            let message = format!(
                "<{}> of an <inertial auto=\"true\"> is ignored, as SDF defines",
                ignored.tag
            );
            context.note(message, Some(ignored.place()));
        }
        if link.child("collision").is_none() {
            let message =
                format!("{} has <inertial auto=\"true\"> but no <collision>", link.title());
            context.error("mass", message, &inertial.place(), WRITE_MASS);
        }
        let Some(given) = inertial.child_number(context, "mass") else { return shapes };
        if shapes.mass > 0.0 {
            return shapes.scaled(given / shapes.mass);
        }
        // The reason may be an error that has been reported.
        if !context.has_errors() {
            let message = format!(
                "the mass of {}, {given} kg, cannot be distributed over its collision shapes: their sizes and densities \
                 give {} kg",
                link.title(),
                shapes.mass
            );
            context.error("mass", message, &inertial.place(), WRITE_MASS);
        }
        shapes
    }

    fn shape(&self, collision: &Element) -> Option<Mass> {
        let context = self.context;
        let shape = collision.child("geometry")?.children.first()?;
        let number = |key: &str| shape.child_number(context, key).unwrap_or(0.0).abs();
        let vector = |key: &str| -> [f64; 3] {
            let child = shape.child(key);
            let numbers = child.and_then(|child| child.text_numbers::<3>(context));
            numbers.unwrap_or([0.0; 3]).map(f64::abs)
        };
        match shape.tag.as_str() {
            "box" => Some(cuboid(vector("size").map(|edge| 0.5 * edge))),
            "sphere" => Some(ellipsoid([number("radius"); 3])),
            "ellipsoid" => Some(ellipsoid(vector("radii"))),
            "cylinder" => Some(cylinder(number("radius"), 0.5 * number("length"))),
            "capsule" => Some(capsule(number("radius"), 0.5 * number("length"))),
            "plane" => None,
            "mesh" => self.mesh_mass(shape),
            other => {
                let message =
                    format!("the mass of shapes of type {} is not computed", quoted(other));
                context.error("mass", message, &shape.place(), WRITE_MASS);
                None
            }
        }
    }

    /// Mass properties of the solid that a mesh encloses, with density 1 kg/m³. Reports an error if
    /// they cannot be computed.
    fn mesh_mass(&self, shape: &Element) -> Option<Mass> {
        let context = self.context;
        let file = shape.child("uri")?.text.as_str();
        let scale = shape.child("scale").and_then(|scale| scale.text_numbers::<3>(context));
        let scale = scale.unwrap_or([1.0; 3]);
        let triangles = (context.files)(file).and_then(|bytes| triangles::read(file, &bytes));
        let mass = triangles.map(|triangles| {
            let scaled = |point: Vec3<f64>| {
                Vec3::new(point.x * scale[0], point.y * scale[1], point.z * scale[2])
            };
            let triangles: Vec<_> = triangles.iter().map(|corners| corners.map(scaled)).collect();
            mesh::mass(&triangles, Content::Solid)
        });
        let why = match mass {
            Ok(mass) if mass.mass > 0.0 => return Some(mass),
            Ok(_) => "it encloses no volume".to_owned(),
            Err(why) => why,
        };
        let message = format!("the mass of the mesh {} is unknown: {why}", quoted(file));
        context.error("mesh", message, &shape.place(), WRITE_MASS);
        None
    }
}
