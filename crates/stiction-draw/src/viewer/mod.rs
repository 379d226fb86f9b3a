//! Animated robot of a page: a canvas, drawn by a script of this crate, in which the reader can
//! rotate the robot, play the motion and query values.

use crate::xml::prose;
use base64::prelude::{BASE64_STANDARD, Engine};
use flate2::Compression;
use flate2::write::GzEncoder;
use serde_json::{Value, json};
use std::io::Write as _;
use std::sync::Arc;

/// Script of the animated robot. A page with a robot but without meshes may run no other script.
pub const SCRIPT: &str = include_str!(concat!(env!("OUT_DIR"), "/viewer.js"));

/// Script of the shaded view, which draws meshes with three.js; empty in a program that was built
/// without it. Pages with meshes may also run this script. `cargo xtask viewer` bundles it, and
/// `STICTION_SHADED` names the bundle during a build.
pub const SHADED: &str = include_str!(concat!(env!("OUT_DIR"), "/shaded.js"));

/// Start of the markup of an animated robot with meshes. Texts of users are escaped, so they cannot
/// contain this markup.
const WITH_MESHES: &str = "<figure class=\"robot\" id=\"robot\" data-meshes=\"\">";

/// True for markup with a robot whose meshes the shaded view draws.
pub(crate) fn has_meshes(inner: &str) -> bool {
    inner.contains(WITH_MESHES)
}

/// Style sheet of the animated robot.
pub const STYLE: &str = include_str!("style.css");

/// Samples of a run for the animated robot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Film {
    /// Times of the samples in the film, s.
    pub times: Vec<f64>,
    /// Number of samples of the whole run, of which the film contains a part.
    pub of: usize,
    /// Position of the origin of `poses` in the world, m.
    pub origin: [f64; 3],
    /// Position (m, from the origin) and quaternion (w, x, y, z) of every body, the ground first, sample
    /// by sample.
    pub poses: Vec<f32>,
    /// Names of the columns of the run's tables.
    pub columns: Vec<String>,
    /// Values of the columns, sample after sample.
    pub values: Vec<f64>,
    /// Name of each friction interface, with the index of its joint.
    pub interfaces: Vec<(String, usize)>,
    /// Actuators of the mechanism.
    pub actuators: Vec<Actuator>,
    /// Least-constrained motion at one sample, if it is shown.
    pub ghost: Option<Ghost>,
    /// Meshes of bodies.
    pub meshes: Vec<Mesh>,
}

/// Mesh that shows the shape of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Index of the body, the ground first.
    pub body: usize,
    /// Scale factors of the mesh's coordinates x, y, z.
    pub scale: [f64; 3],
    /// Position of the scaled mesh in the frame of the body, m.
    pub position: [f64; 3],
    /// Orientation of the mesh in the frame of the body, as a quaternion (w, x, y, z).
    pub quaternion: [f64; 4],
    /// File of the mesh, shared by meshes with the same content.
    pub file: Arc<MeshFile>,
}

/// Content of a mesh file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshFile {
    /// Name of the file, for messages.
    pub name: String,
    /// Format of the file: `stl`, `obj` or `gltf`.
    pub format: &'static str,
    /// Content of the file.
    pub bytes: Vec<u8>,
}

impl MeshFile {
    fn data(&self) -> Value {
        let mut packed = GzEncoder::new(Vec::new(), Compression::best());
        // Writing to memory does not fail.
        let _ = packed.write_all(&self.bytes);
        let data = BASE64_STANDARD.encode(packed.finish().unwrap_or_default());
        json!({ "name": self.name, "format": self.format, "data": data })
    }
}

/// Describes the meshes of a robot; returns the descriptions and the files, each file once.
fn mesh_data(meshes: &[Mesh]) -> (Vec<Value>, Vec<Arc<MeshFile>>) {
    let mut files: Vec<Arc<MeshFile>> = Vec::new();
    let mut place = |file: &Arc<MeshFile>| {
        files.iter().position(|known| Arc::ptr_eq(known, file)).unwrap_or_else(|| {
            files.push(Arc::clone(file));
            files.len() - 1
        })
    };
    let meshes = meshes.iter().map(|mesh| {
        let Mesh { body, scale, position, quaternion, file } = mesh;
        json!({
            "body": body, "file": place(file), "scale": scale, "position": position, "quaternion": quaternion,
        })
    });
    (meshes.collect(), files)
}

/// Motion that the constraints resist least while the actuators are locked. Near a singular
/// configuration, the mechanism gains this motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Ghost {
    /// Time of the sample, s.
    pub time: f64,
    /// Singularity index of actuation (type 2) at this sample.
    pub index: f64,
    /// Velocity of the origin and angular velocity of every body, the ground first, in world axes; only their ratios
    /// matter.
    pub twists: Vec<[[f64; 3]; 2]>,
}

/// Actuator of the animated robot.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Actuator {
    /// Name in the columns of the tables.
    pub name: String,
    /// Unit of the actuator's effort.
    pub unit: &'static str,
    /// Index of the actuator's joint.
    pub joint: usize,
    /// Index of the actuator's axis in the joint's frame J: 0, 1, 2 for x, y, z.
    pub axis: usize,
    /// True for the second axis of a universal joint, which is fixed in the joint's frame K.
    pub second: bool,
    /// True if the effort is a torque, false if it is a force.
    pub turns: bool,
}

fn actuator(actuator: &Actuator) -> Value {
    let Actuator { name, unit, joint, axis, second, turns } = actuator;
    json!({ "name": name, "unit": unit, "joint": joint, "axis": axis, "second": second, "turns": turns })
}

/// Run that a page shows: a mechanism and the samples of its motion.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shot {
    /// Name that distinguishes this run from other runs on the page.
    pub label: String,
    /// Description of the mechanism by [`crate::drawing::Drawing::scene`].
    pub scene: Value,
    /// Samples of the run.
    pub film: Film,
}

impl Shot {
    fn data(&self) -> Value {
        let Self { label, scene, film } = self;
        let floats: Vec<u8> = film.poses.iter().flat_map(|x| x.to_le_bytes()).collect();
        let doubles = |list: &[f64]| {
            BASE64_STANDARD.encode(list.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>())
        };
        json!({
            "label": label,
            "scene": scene,
            "of": film.of,
            "origin": film.origin,
            "columns": film.columns,
            "interfaces": film.interfaces,
            "ghost": film.ghost.as_ref().map(|ghost| json!({
                "time": ghost.time, "index": ghost.index, "twists": ghost.twists,
            })),
            "actuators": film.actuators.iter().map(actuator).collect::<Vec<_>>(),
            "times": doubles(&film.times),
            "poses": BASE64_STANDARD.encode(&floats),
            "values": doubles(&film.values),
        })
    }
}

/// Returns the HTML markup of the animated robot of a run. The reader can overlay the robot of one
/// of the other runs, at the same instant of the motion. `still` is the picture that is shown
/// without scripts and in print.
pub fn robot(run: &Shot, others: &[Shot], still: &str, caption: &str) -> String {
    let mut data = run.data();
    let mut caption = caption.to_owned();
    let mut begin = "<figure class=\"robot\" id=\"robot\">";
    let (mut meshes, files) = mesh_data(&run.film.meshes);
    if SHADED.is_empty() && !meshes.is_empty() {
        caption += " Its meshes are not shown: this program was built without the shaded view.";
        meshes.clear();
    } else if !meshes.is_empty() {
        let files: Vec<Value> = files.iter().map(|file| file.data()).collect();
        let size =
            files.iter().filter_map(|file| file["data"].as_str()).map(str::len).sum::<usize>();
        let count = if files.len() == 1 {
            "one mesh file".to_owned()
        } else {
            format!("{} mesh files", files.len())
        };
        caption += &format!(" This page contains {count}, {} kB.", size.div_ceil(1000));
        data["files"] = files.into();
        begin = WITH_MESHES;
    }
    data["meshes"] = meshes.into();
    data["others"] = others.iter().map(Shot::data).collect();
    // A caption of several runs is about the moving robots.
    let class = if others.is_empty() { "" } else { " class=\"moving\"" };
    // Without the character `<`, no text in the data can end the element.
    let data = data.to_string().replace('<', "\\u003c");
    format!(
        "{begin}\n\
         <div class=\"stage\"><canvas tabindex=\"0\" role=\"application\" aria-label=\"The moving robot: drag \
         or arrow keys turn it, + and - zoom, space plays, a click selects a joint\"></canvas></div>\n\
         <div class=\"still picture\">{still}</div>\n\
         <div class=\"controls\"></div>\n\
         <figcaption><span{class}>{}</span><span class=\"kept\"></span></figcaption>\n\
         <div class=\"readout\" aria-live=\"polite\"></div>\n\
         <script type=\"application/json\" class=\"film\">{data}</script>\n</figure>\n",
        prose(&caption)
    )
}
