//! Meshes that show bodies in HTML pages. The results of computations do not depend on meshes.

use crate::diagnostic::{Diagnostic, Diagnostics, quoted};
use crate::source::Place;
use crate::triangles;
use serde_json::Value;
use std::collections::HashMap;
use std::sync::Arc;
use stiction_core::mechanism::BodyId;
use stiction_core::spatial::Pose;

/// Size limit, in bytes, of one mesh file; [`LARGEST_SUM`] is that of all mesh files of a model
/// together. HTML pages embed these files.
const LARGEST: usize = 8 << 20;
const LARGEST_SUM: usize = 16 << 20;
/// Maximum number of triangles of an STL or OBJ mesh. [`MOST_ELEMENTS`] and [`MOST_NODES`] limit
/// the accessor elements and the nodes of a glTF file. A larger mesh would not be displayed
/// smoothly.
const MOST_TRIANGLES: usize = 1_000_000;
const MOST_ELEMENTS: u64 = 4_000_000;
const MOST_NODES: usize = 2000;
/// Prefixes of the glTF extensions that are accepted; they change only colours or the type of
/// numbers.
const EXTENSIONS: [&str; 3] = ["KHR_materials_", "KHR_texture_transform", "KHR_mesh_quantization"];

/// Mesh that shows a body.
#[derive(Clone, Debug)]
pub struct Visual {
    /// Body that the mesh shows.
    pub body: BodyId,
    /// File of the mesh, as written in the model file.
    pub file: String,
    /// Scale factors of the coordinates x, y and z of the mesh.
    pub scale: [f64; 3],
    /// Pose of the scaled mesh in the frame of the body.
    pub pose: Pose<f64>,
    /// Content of the file; `None` until it is loaded, or if it cannot be shown.
    pub mesh: Option<Arc<Mesh>>,
    pub(crate) place: Place,
}

/// Format of a mesh file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    /// STL, text or binary.
    Stl,
    /// Wavefront OBJ.
    Obj,
    /// glTF 2.0 with embedded data, or GLB.
    Gltf,
}

/// Checked content of a mesh file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mesh {
    /// Format of the file.
    pub format: MeshFormat,
    /// Content of the file.
    pub bytes: Vec<u8>,
}

impl Mesh {
    /// Checks the content of a mesh file, whose format follows from the extension of its name.
    ///
    /// # Errors
    /// Returns the reason why the mesh cannot be shown, as the end of the sentence "the mesh cannot
    /// be shown: ".
    pub fn new(name: &str, bytes: Vec<u8>) -> Result<Self, String> {
        if bytes.len() > LARGEST {
            let (size, most) = (bytes.len() as f64 / 1e6, LARGEST as f64 / 1e6);
            return Err(format!("it has {size:.1} MB; at most {most:.1} MB are shown"));
        }
        let ending = name.rsplit_once('.').map_or("", |(_, ending)| ending).to_ascii_lowercase();
        let format = match ending.as_str() {
            "stl" => MeshFormat::Stl,
            "obj" => MeshFormat::Obj,
            "gltf" | "glb" => MeshFormat::Gltf,
            _ => return Err("only STL, OBJ, glTF and GLB files are shown".to_owned()),
        };
        if format == MeshFormat::Gltf {
            check_gltf(&bytes)?;
        } else {
            let count = triangles::read(name, &bytes)?.len();
            if count > MOST_TRIANGLES {
                return Err(format!(
                    "it has {count} triangles; at most {MOST_TRIANGLES} are shown"
                ));
            }
        }
        Ok(Self { format, bytes })
    }
}

/// Loads the mesh files of all visuals, as
/// [`ModelFile::load_meshes`](crate::ModelFile::load_meshes) describes.
pub(crate) fn load(
    visuals: &mut [Visual],
    warnings: &mut Diagnostics,
    files: &dyn Fn(&str) -> Result<Vec<u8>, String>,
) {
    let mut known: HashMap<&str, Result<Arc<Mesh>, String>> = HashMap::new();
    let mut sum = 0;
    for visual in visuals {
        let Visual { file, mesh, place, .. } = visual;
        let file: &str = file;
        let is_new = !known.contains_key(file);
        let loaded = known.entry(file).or_insert_with(|| {
            let mesh = Mesh::new(file, files(file)?)?;
            sum += mesh.bytes.len();
            match sum > LARGEST_SUM {
                true => Err(format!(
                    "with this file, all meshes together are larger than {:.1} MB",
                    LARGEST_SUM as f64 / 1e6
                )),
                false => Ok(Arc::new(mesh)),
            }
        });
        match loaded {
            Ok(loaded) => *mesh = Some(Arc::clone(loaded)),
            // A file that several bodies use is reported only once.
            Err(why) if is_new => warnings.push(
                Diagnostic::warning(
                    "visual",
                    format!("the mesh {} cannot be shown: {why}", quoted(file)),
                )
                .at(place.clone(), "")
                .help("pages show the symbol of the body; results do not depend on meshes"),
            ),
            Err(_) => {}
        }
    }
}

/// Rejects glTF files that need other files, or that an HTML page could not show in reasonable time
/// and memory.
fn check_gltf(bytes: &[u8]) -> Result<(), String> {
    let text = match bytes.starts_with(b"glTF") {
        true => {
            let length = bytes.get(12..16).and_then(|length| length.try_into().ok());
            let length = length.map_or(0, u32::from_le_bytes) as usize;
            let kind = bytes.get(16..20);
            let chunk = bytes.get(20..).and_then(|rest| rest.get(..length));
            let chunk = chunk.filter(|_| kind == Some(b"JSON"));
            let chunk = chunk.ok_or("its first chunk is not complete JSON")?;
            // A viewer would use the last of several JSON chunks, but only the first is checked.
            let mut rest = bytes.get(20 + length..).unwrap_or_default();
            while let Some((head, after)) = rest.split_first_chunk::<8>() {
                if head[4..] == *b"JSON" {
                    return Err("it has two JSON chunks".to_owned());
                }
                let length = u32::from_le_bytes([head[0], head[1], head[2], head[3]]) as usize;
                rest = after.get(length..).unwrap_or_default();
            }
            chunk
        }
        false => bytes,
    };
    let root: Value =
        serde_json::from_slice(text).map_err(|error| format!("it is not glTF: {error}"))?;
    if !root["asset"]["version"].as_str().is_some_and(|version| version.starts_with("2.")) {
        return Err("it is not glTF 2.0".to_owned());
    }
    let list = |value: &Value| value.as_array().cloned().unwrap_or_default();
    let names = list(&root["extensionsRequired"]);
    let is_known = |name: &&str| EXTENSIONS.iter().any(|known| name.starts_with(known));
    if let Some(name) = names.iter().filter_map(Value::as_str).find(|name| !is_known(name)) {
        return Err(format!("it needs the extension {}, which is not supported", quoted(name)));
    }
    let uris =
        list(&root["buffers"]).into_iter().filter_map(|one| Some(one["uri"].as_str()?.to_owned()));
    if let Some(uri) = uris.into_iter().find(|uri| !uri.starts_with("data:")) {
        let uri: String = uri.chars().take(60).collect();
        return Err(format!("its data are in the file {}; save it as GLB", quoted(&uri)));
    }
    let counts = list(&root["accessors"]);
    let elements: Option<Vec<u64>> = counts.iter().map(|one| one["count"].as_u64()).collect();
    let elements = elements.ok_or("a count of its elements is not a whole number")?;
    let elements = elements.into_iter().fold(0_u64, u64::saturating_add);
    if elements > MOST_ELEMENTS {
        return Err(format!("it has {elements} elements; at most {MOST_ELEMENTS} are shown"));
    }
    check_nodes(&list(&root["nodes"]), &list(&root["scenes"]))
}

/// Rejects glTF nodes that do not form trees, because a reader would follow a cycle of nodes
/// without end.
fn check_nodes(nodes: &[Value], scenes: &[Value]) -> Result<(), String> {
    if nodes.len() > MOST_NODES {
        return Err(format!("it has {} nodes; at most {MOST_NODES} are shown", nodes.len()));
    }
    let mut has_parent = vec![false; nodes.len()];
    let indices = |value: &Value| -> Vec<Option<usize>> {
        let all = value.as_array().into_iter().flatten();
        all.map(|index| usize::try_from(index.as_u64()?).ok()).collect()
    };
    for child in nodes.iter().flat_map(|node| indices(&node["children"])) {
        let place = child.and_then(|child| has_parent.get_mut(child));
        match place {
            Some(true) => return Err("a node has two parents".to_owned()),
            Some(known) => *known = true,
            None => return Err("a node has a child that does not exist".to_owned()),
        }
    }
    // Every node of a cycle has a parent, so a scene whose roots have no parents contains no cycle.
    for root in scenes.iter().flat_map(|scene| indices(&scene["nodes"])) {
        match root.and_then(|root| has_parent.get(root)) {
            Some(false) => {}
            Some(true) => return Err("a root of a scene has a parent".to_owned()),
            None => return Err("a scene has a root that does not exist".to_owned()),
        }
    }
    Ok(())
}
