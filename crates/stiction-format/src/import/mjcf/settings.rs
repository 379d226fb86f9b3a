//! Settings of an MJCF file (elements `compiler` and `option`), and the angles, orientations and
//! paths that depend on these settings.

use super::super::context::Context;
use super::super::rotation;
use super::super::xml::Element;
use crate::diagnostic::quoted;
use stiction_core::spatial::{Mat3, Pose, Vec3};

/// Setting that determines for which bodies inertias are computed from geoms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FromGeoms {
    Always,
    Never,
    /// Only for bodies without an `inertial` element.
    Missing,
}

/// Settings of the elements `compiler` and `option`.
#[derive(Clone, Debug)]
pub(super) struct Settings {
    degrees: bool,
    pub(super) autolimits: bool,
    order: String,
    pub(super) from_geoms: FromGeoms,
    pub(super) geom_groups: [f64; 2],
    pub(super) balance_inertia: bool,
    pub(super) least_mass: f64,
    pub(super) least_inertia: f64,
    pub(super) total_mass: Option<f64>,
    pub(super) mesh_folder: String,
    /// True if a mesh has the mass of the solid that it encloses, unless the mesh specifies another
    /// rule.
    pub(super) exact_meshes: bool,
    /// True if simple shapes that replace meshes are fitted to the bounding boxes of these meshes.
    pub(super) fit_aabb: bool,
    pub(super) strip_path: bool,
    pub(super) gravity: Vec3<f64>,
    /// True if the file disables gravity.
    is_weightless: bool,
    /// Parts of the mechanics that the file disables, by the names of the attributes of `flag`.
    disabled: Vec<&'static str>,
}

/// Parts of the mechanics that a file may disable, each with the larger groups that include it.
const PARTS: [(&str, &[&str]); 5] = [
    ("equality", &["constraint"]),
    ("limit", &["constraint"]),
    ("frictionloss", &["constraint"]),
    ("spring", &["passive"]),
    ("damper", &["passive"]),
];

/// Attributes that specify an orientation.
pub(super) const ORIENTATIONS: [&str; 5] = ["quat", "axisangle", "euler", "xyaxes", "zaxis"];

fn is_true(element: &Element, key: &str) -> Option<bool> {
    element.get(key).map(|value| value == "true")
}

impl Settings {
    pub(super) fn read(context: &Context<'_>, root: &Element) -> Self {
        let mut all = Self {
            degrees: true,
            autolimits: true,
            order: "xyz".to_owned(),
            from_geoms: FromGeoms::Missing,
            geom_groups: [0.0, 5.0],
            balance_inertia: false,
            least_mass: 0.0,
            least_inertia: 0.0,
            total_mass: None,
            mesh_folder: String::new(),
            exact_meshes: false,
            fit_aabb: false,
            strip_path: false,
            gravity: Vec3::new(0.0, 0.0, -9.81),
            is_weightless: false,
            disabled: Vec::new(),
        };
        for compiler in root.all("compiler") {
            all.read_compiler(context, compiler);
        }
        for option in root.all("option") {
            if let Some(gravity) = option.numbers::<3>(context, "gravity") {
                all.gravity = Vec3::from(gravity);
            }
            for flag in option.all("flag") {
                all.read_flag(context, flag);
            }
        }
        if all.is_weightless {
            all.gravity = Vec3::zero();
        }
        all
    }

    fn read_compiler(&mut self, context: &Context<'_>, element: &Element) {
        match element.get("angle") {
            Some("radian") => self.degrees = false,
            Some("degree") => self.degrees = true,
            _ => {}
        }
        self.autolimits = is_true(element, "autolimits").unwrap_or(self.autolimits);
        self.balance_inertia = is_true(element, "balanceinertia").unwrap_or(self.balance_inertia);
        self.strip_path = is_true(element, "strippath").unwrap_or(self.strip_path);
        self.fit_aabb = is_true(element, "fitaabb").unwrap_or(self.fit_aabb);
        self.exact_meshes = is_true(element, "exactmeshinertia").unwrap_or(self.exact_meshes);
        match element.get("inertiafromgeom") {
            Some("true") => self.from_geoms = FromGeoms::Always,
            Some("false") => self.from_geoms = FromGeoms::Never,
            Some(_) => self.from_geoms = FromGeoms::Missing,
            None => {}
        }
        if let Some(attribute) = element.attribute("eulerseq") {
            let order = attribute.value.trim();
            if rotation::euler([0.0; 3], order).is_some() {
                self.order = order.to_owned();
            } else {
                let message = format!("{} is not a sequence of three axes", quoted(order));
                let help = "write three of x, y, z, X, Y, Z";
                context.error("euler", message, &attribute.place(), help);
            }
        }
        if let Some(groups) = element.numbers::<2>(context, "inertiagrouprange") {
            self.geom_groups = groups;
        }
        let number = |key: &str| element.number(context, key);
        self.least_mass = number("boundmass").unwrap_or(self.least_mass);
        self.least_inertia = number("boundinertia").unwrap_or(self.least_inertia);
        self.total_mass = number("settotalmass").filter(|mass| *mass > 0.0).or(self.total_mass);
        if let Some(folder) = element.get("meshdir").or_else(|| element.get("assetdir")) {
            self.mesh_folder = folder.trim_end_matches('/').to_owned();
        }
        if element.get("coordinate") == Some("global") {
            let message = "global coordinates are not read; newer versions of MuJoCo do not \
                support them either"
                .to_owned();
            let help = "save the model again with MuJoCo 2.3.3, which converts them";
            context.error("compiler", message, &element.place(), help);
        }
    }

    fn read_flag(&mut self, context: &Context<'_>, flag: &Element) {
        let is_disabled = |name: &str| flag.get(name) == Some("disable");
        self.is_weightless |= is_disabled("gravity");
        for (part, wholes) in PARTS {
            if is_disabled(part) || wholes.iter().any(|whole| is_disabled(whole)) {
                self.disabled.push(part);
                let message = format!("the file disables `{part}`: it is left out everywhere");
                context.note(message, Some(flag.place()));
            }
        }
    }

    /// Tests if a part of the mechanics is enabled in the file: `equality`, `limit`,
    /// `frictionloss`, `spring` or `damper`.
    pub(super) fn has(&self, part: &str) -> bool {
        !self.disabled.contains(&part)
    }

    /// Converts an angle of the file to rad.
    pub(super) fn angle(&self, value: f64) -> f64 {
        if self.degrees { value.to_radians() } else { value }
    }

    /// Orientation of an element, given by any of the attributes in [`ORIENTATIONS`].
    pub(super) fn orientation(&self, context: &Context<'_>, element: &Element) -> Mat3<f64> {
        let identity = Mat3::identity();
        let zero = |key: &str| {
            let message = format!("`{key}` of {} is zero", element.title());
            context.error("rotation", message, &element.place(), "give a direction");
            identity
        };
        if let Some([x, y, z, angle]) = element.numbers::<4>(context, "axisangle") {
            let axis = Vec3::new(x, y, z);
            return match axis.direction() {
                Some(axis) => turn(axis, self.angle(angle)),
                None => zero("axisangle"),
            };
        }
        if let Some(angles) = element.numbers::<3>(context, "euler") {
            let angles = angles.map(|angle| self.angle(angle));
            return rotation::euler(angles, &self.order).unwrap_or(identity);
        }
        if let Some([a, b, c, d, e, f]) = element.numbers::<6>(context, "xyaxes") {
            let (x, y) = (Vec3::new(a, b, c), Vec3::new(d, e, f));
            let columns = x.direction().and_then(|x| Some((x, (y + x * -x.dot(y)).direction()?)));
            return match columns {
                Some((x, y)) => Mat3::from_columns(x, y, x.cross(y)),
                None => zero("xyaxes"),
            };
        }
        if let Some(axis) = element.numbers::<3>(context, "zaxis") {
            return match Vec3::from(axis).direction() {
                Some(axis) => z_to(axis),
                None => zero("zaxis"),
            };
        }
        match element.numbers::<4>(context, "quat") {
            Some(q) => rotation::quaternion(q).unwrap_or_else(|| zero("quat")),
            None => identity,
        }
    }

    /// Pose of an element, from its attribute `pos` and its orientation.
    pub(super) fn pose(&self, context: &Context<'_>, element: &Element) -> Pose<f64> {
        let position = element.numbers::<3>(context, "pos").unwrap_or([0.0; 3]);
        Pose { position: Vec3::from(position), rotation: self.orientation(context, element) }
    }

    /// Path of a mesh file, including the folder of meshes that the settings name.
    pub(super) fn mesh_path(&self, file: &str) -> String {
        let file = match self.strip_path {
            true => file.rsplit(['/', '\\']).next().unwrap_or(file),
            false => file,
        };
        match self.mesh_folder.is_empty() || file.starts_with('/') {
            true => file.to_owned(),
            false => format!("{}/{file}", self.mesh_folder),
        }
    }
}

/// Smallest rotation that maps the z axis to the unit vector `axis`; half a turn about the x axis if the two are opposite,
/// as MuJoCo chooses among such rotations.
fn z_to(axis: Vec3<f64>) -> Mat3<f64> {
    // MuJoCo's limit for directions that count as parallel.
    const PARALLEL: f64 = 1e-10;
    let [x, y, z] = [0, 1, 2].map(Vec3::unit);
    match axis.z < 0.0 && axis.cross(z).norm() < PARALLEL {
        true => Mat3::from_columns(x, -y, -z),
        false => Mat3::between(z, axis),
    }
}

/// Pose of a geom or site whose ends are given by `fromto`: its z axis points from the second end to the first.
pub(super) fn pose_of_ends([from, to]: [Vec3<f64>; 2]) -> Pose<f64> {
    let along = (from + -to).direction().unwrap_or(Vec3::unit(2));
    Pose { position: (from + to) * 0.5, rotation: z_to(along) }
}

/// Rotation by `angle`, rad, about the unit vector `axis`. Quarter turns about the coordinate axes
/// are exact.
fn turn(axis: Vec3<f64>, angle: f64) -> Mat3<f64> {
    for k in 0..3 {
        if axis == Vec3::unit(k) {
            return rotation::about(k, angle);
        }
        if axis == -Vec3::unit(k) {
            return rotation::about(k, -angle);
        }
    }
    Mat3::rotation(axis, angle)
}
