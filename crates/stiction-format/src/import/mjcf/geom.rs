//! Masses of the geoms of an MJCF file, and meshes that show bodies.

use super::super::description::VisualMesh;
use super::super::inertia::Mass;
use super::super::xml::Element;
use super::super::{shell, solid};
use super::Reader;
use super::mesh::{Fitted, Lost};
use super::settings::pose_of_ends;
use crate::diagnostic::quoted;
use stiction_core::spatial::{Pose, Vec3};

/// Default density of geoms, kg/m³.
const DENSITY: f64 = 1000.0;

impl Reader<'_, '_> {
    /// Mass properties of a geom in the frame of the element that encloses it. A mass that cannot
    /// be computed is reported; if the body is fixed to the world (`is_fixed`), this is no error,
    /// because the mass does not matter.
    pub(super) fn geom_mass(&mut self, geom: &Element, body: &str, is_fixed: bool) -> Mass {
        let context = self.context;
        let group = geom.number(context, "group").unwrap_or(0.0);
        let [least, greatest] = self.settings.geom_groups;
        if group < least || group > greatest {
            return Mass::none();
        }
        let given = geom.number(context, "mass");
        let density = geom.number(context, "density").unwrap_or(DENSITY);
        if given.unwrap_or(density) == 0.0 {
            return Mass::none();
        }
        let word = geom.get("type").unwrap_or("sphere");
        let solid = match (word, geom.get("mesh")) {
            ("plane" | "hfield", _) => Ok(Mass::none()),
            // Collisions of type `sdf` use the distance to the mesh; the mass is the same.
            ("mesh" | "sdf", None) => Err(Lost {
                why: format!("a geom of type {word} has no mesh"),
                cure: "name the mesh in the attribute `mesh`",
                is_absent: false,
            }),
            ("mesh" | "sdf", Some(mesh)) => self.mesh(mesh).map(|mesh| mesh.mass),
            (_, Some(mesh)) => {
                let fitted = self.mesh(mesh).and_then(|mesh| {
                    let fit = mesh.fitted(word, self.settings.fit_aabb);
                    fit.ok_or_else(|| unknown(word))
                });
                fitted.map(|Fitted { size, pose }| {
                    let scale = geom.number(context, "fitscale").unwrap_or(1.0);
                    let solid = primitive(word, size.map(|x| x * scale), is_shell(geom));
                    solid.unwrap_or(Mass::none()).placed(pose)
                })
            }
            (_, None) => primitive(word, self.size_of(geom, word), is_shell(geom))
                .ok_or_else(|| unknown(word)),
        };
        let solid = match solid {
            Ok(solid) => solid,
            Err(Lost { why, .. }) if is_fixed => {
                let message =
                    format!("{why}: the mass of body {} does not include this mesh", quoted(body));
                context.note(message, Some(geom.place()));
                return Mass::none();
            }
            Err(Lost { why, cure, is_absent: true }) => {
                let message = format!(
                    "WARNING: body {} lacks the mass of a mesh, so results are wrong: {why}; {cure}",
                    quoted(body)
                );
                context.warn(message, Some(geom.place()));
                return Mass::none();
            }
            Err(Lost { why, cure, .. }) => {
                let message = format!("{why}, so the mass of body {} is unknown", quoted(body));
                context.error("mesh", message, &geom.place(), cure);
                return Mass::none();
            }
        };
        let factor = match given {
            Some(mass) if solid.mass > 0.0 => mass / solid.mass,
            Some(_) => 0.0,
            None => density,
        };
        solid.scaled(factor).placed(self.pose_of(geom))
    }

    /// Returns both end points of a geom whose axis is given by the attribute `fromto`; `None` for
    /// other geoms.
    fn ends_of(&self, geom: &Element) -> Option<[Vec3<f64>; 2]> {
        let [a, b, c, d, e, f] = geom.numbers::<6>(self.context, "fromto")?;
        Some([Vec3::new(a, b, c), Vec3::new(d, e, f)])
    }

    fn pose_of(&self, geom: &Element) -> Pose<f64> {
        match self.ends_of(geom) {
            Some(ends) => pose_of_ends(ends),
            None => self.settings.pose(self.context, geom),
        }
    }

    /// Sizes of a geom of simple shape, as in the attribute `size`: radius and half length, or half
    /// the edges or axes.
    fn size_of(&self, geom: &Element, word: &str) -> [f64; 3] {
        let mut size = [0.0; 3];
        let given = geom.list(self.context, "size").unwrap_or_default();
        for (known, value) in size.iter_mut().zip(given) {
            *known = value.abs();
        }
        match self.ends_of(geom).map(|[from, to]| (to + -from).norm() * 0.5) {
            Some(half) if matches!(word, "box" | "ellipsoid") => [size[0], size[0], half],
            Some(half) => [size[0], half, 0.0],
            None => size,
        }
    }

    /// Returns the mesh of a geom if MuJoCo's viewers show the geom by default and the file of the
    /// mesh can be read. Missing files are reported.
    pub(super) fn visual_of(
        &self,
        (element, frame): (&Element, Pose<f64>),
        class: Option<&str>,
    ) -> Option<VisualMesh> {
        // By default, viewers show geoms of the groups up to this one.
        const SHOWN: f64 = 2.0;
        if element.tag != "geom" {
            return None;
        }
        let context = self.context;
        let geom = self.defaults.applied(context, element, class);
        let mesh = self.meshes.found.get(geom.get("mesh")?)?;
        let file = self.settings.mesh_path(mesh.get("file")?);
        if !context.is_mesh_file(&file, &element.place()) {
            return None;
        }
        let is_moved = mesh.get("refpos").is_some() || mesh.get("refquat").is_some();
        if is_moved || geom.number(context, "group").unwrap_or(0.0) > SHOWN {
            return None;
        }
        let scale = mesh.numbers::<3>(context, "scale").unwrap_or([1.0; 3]);
        let pose = frame * self.settings.pose(context, &geom);
        context.has_mesh(&file, element.place()).then_some(VisualMesh { file, scale, pose })
    }
}

fn is_shell(geom: &Element) -> bool {
    geom.get("shellinertia") == Some("true")
}

fn unknown(word: &str) -> Lost {
    let why = format!("the mass of geoms of type {} cannot be computed", quoted(word));
    Lost { why, cure: "give the body an <inertial>", is_absent: false }
}

/// Mass properties of a simple shape: of the solid with density 1 kg/m³ or, if `is_shell`, of the
/// surface alone with 1 kg/m². `None` for an unknown type.
fn primitive(word: &str, size: [f64; 3], is_shell: bool) -> Option<Mass> {
    let [radius, half, _] = size;
    Some(match (word, is_shell) {
        ("sphere", false) => solid::ellipsoid([radius; 3]),
        ("sphere", true) => shell::sphere(radius),
        ("ellipsoid", false) => solid::ellipsoid(size),
        ("ellipsoid", true) => shell::ellipsoid(size),
        ("box", false) => solid::cuboid(size),
        ("box", true) => shell::cuboid(size),
        ("cylinder", false) => solid::cylinder(radius, half),
        ("cylinder", true) => shell::cylinder(radius, half),
        ("capsule", false) => solid::capsule(radius, half),
        ("capsule", true) => shell::capsule(radius, half),
        _ => return None,
    })
}
