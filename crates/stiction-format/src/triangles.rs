//! Vertices and triangles of meshes, from STL, OBJ and MSH files.

use stiction_core::spatial::Vec3;

pub(crate) type Triangle = [Vec3<f64>; 3];

/// Vertices and faces of a mesh.
#[derive(Clone, Debug, Default)]
pub(crate) struct Surface {
    /// All vertices, also those that belong to no face.
    pub(crate) vertices: Vec<Vec3<f64>>,
    /// Faces as triangles; none if the mesh consists of vertices alone.
    pub(crate) triangles: Vec<Triangle>,
}

impl Surface {
    fn of(triangles: Vec<Triangle>) -> Self {
        Self { vertices: triangles.iter().flatten().copied().collect(), triangles }
    }
}

/// Reads the triangles of a mesh file, whose format follows from the extension of its name.
///
/// # Errors
/// Returns the reason, as the end of the sentence "the mesh cannot be read: ".
pub(crate) fn read(name: &str, bytes: &[u8]) -> Result<Vec<Triangle>, String> {
    let triangles = read_surface(name, bytes)?.triangles;
    if triangles.is_empty() { Err("it has no faces".to_owned()) } else { Ok(triangles) }
}

/// Reads a mesh file that may have vertices without faces. The format follows from the extension of its name.
///
/// # Errors
/// Returns the reason, as the end of the sentence "the mesh cannot be read: ".
pub(crate) fn read_surface(name: &str, bytes: &[u8]) -> Result<Surface, String> {
    let ending = name.rsplit_once('.').map_or("", |(_, ending)| ending).to_ascii_lowercase();
    let surface = match ending.as_str() {
        "stl" => Surface::of(stl(bytes)?),
        "obj" => obj(&String::from_utf8_lossy(bytes))?,
        "msh" => msh(bytes)?,
        _ => return Err("only STL, OBJ and MSH files are read".to_owned()),
    };
    if surface.vertices.is_empty() {
        return Err("it has no vertices".to_owned());
    }
    match surface.vertices.iter().all(|point| point.is_finite()) {
        true => Ok(surface),
        false => Err("a coordinate of a point is not a finite number".to_owned()),
    }
}

fn stl(bytes: &[u8]) -> Result<Vec<Triangle>, String> {
    let count =
        bytes.get(80..84).and_then(|bytes| Some(u32::from_le_bytes(bytes.try_into().ok()?)));
    let binary = count.filter(|count| 84 + 50 * u64::from(*count) == bytes.len() as u64);
    if binary.is_none() {
        return stl_text(&String::from_utf8_lossy(bytes));
    }
    let number =
        |bytes: &[u8]| f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]));
    let facet = |facet: &[u8]| {
        let point = |k: usize| {
            let at = 12 + 12 * k;
            Vec3::new(number(&facet[at..]), number(&facet[at + 4..]), number(&facet[at + 8..]))
        };
        [point(0), point(1), point(2)]
    };
    Ok(bytes[84..].chunks_exact(50).map(facet).collect())
}

fn stl_text(text: &str) -> Result<Vec<Triangle>, String> {
    let mut points = Vec::new();
    for line in text.lines() {
        if let Some(rest) = line.trim_start().strip_prefix("vertex") {
            points.push(point(rest)?);
        }
    }
    if points.is_empty() {
        return Err("it has no triangles".to_owned());
    }
    if !points.len().is_multiple_of(3) {
        return Err(format!("it has {} corners of triangles, not a multiple of 3", points.len()));
    }
    Ok(points.chunks_exact(3).map(|points| [points[0], points[1], points[2]]).collect())
}

fn point(text: &str) -> Result<Vec3<f64>, String> {
    let mut numbers = text.split_whitespace().map(str::parse::<f64>);
    match (numbers.next(), numbers.next(), numbers.next()) {
        (Some(Ok(x)), Some(Ok(y)), Some(Ok(z))) => Ok(Vec3::new(x, y, z)),
        _ => Err(format!("`{}` is not a point", text.trim().chars().take(60).collect::<String>())),
    }
}

fn obj(text: &str) -> Result<Surface, String> {
    let mut points = Vec::new();
    let mut triangles = Vec::new();
    for line in text.lines() {
        let (word, rest) = line.trim().split_once(char::is_whitespace).unwrap_or_default();
        if word == "v" {
            points.push(point(rest)?);
        } else if word == "f" {
            let corner = |word: &str| {
                let number: i64 = word.split('/').next()?.parse().ok()?;
                let index = if number < 0 { points.len() as i64 + number } else { number - 1 };
                points.get(usize::try_from(index).ok()?).copied()
            };
            let corners: Option<Vec<Vec3<f64>>> = rest.split_whitespace().map(corner).collect();
            let corners = corners.ok_or("a face has a corner that does not exist")?;
            // Polygons become fans of triangles.
            for k in 2..corners.len() {
                triangles.push([corners[0], corners[k - 1], corners[k]]);
            }
        }
    }
    Ok(Surface { vertices: points, triangles })
}

/// Reads MuJoCo's binary mesh format. It contains four counts (of vertices, normals, texture
/// coordinates, faces), then the vertices, normals, texture coordinates and indices of faces. All
/// numbers have 4 bytes.
fn msh(bytes: &[u8]) -> Result<Surface, String> {
    let word = |at: usize| <[u8; 4]>::try_from(bytes.get(4 * at..4 * at + 4)?).ok();
    let count =
        |at: usize| word(at).and_then(|word| usize::try_from(i32::from_le_bytes(word)).ok());
    let (Some(vertices), Some(normals), Some(textures), Some(faces)) =
        (count(0), count(1), count(2), count(3))
    else {
        return Err("it does not begin with a header of four counts".to_owned());
    };
    // Computed in 64 bits, because the counts of a damaged file can have any value. After this
    // check, all indices fit into `usize`.
    let words: u64 = [(1, 4), (vertices, 3), (normals, 3), (textures, 2), (faces, 3)]
        .map(|(count, words)| count as u64 * words)
        .iter()
        .sum();
    if bytes.len() as u64 != 4 * words {
        return Err("its size contradicts its header".to_owned());
    }
    let first_face = 4 + 3 * vertices + 3 * normals + 2 * textures;
    let number = |at: usize| word(at).map(|word| f64::from(f32::from_le_bytes(word)));
    let vertex = |index: usize| {
        let at = 4 + 3 * index;
        Some(Vec3::new(number(at)?, number(at + 1)?, number(at + 2)?))
    };
    let corner = |at: usize| vertex(count(at).filter(|index| *index < vertices)?);
    let face = |k: usize| {
        let at = first_face + 3 * k;
        Some([corner(at)?, corner(at + 1)?, corner(at + 2)?])
    };
    let triangles: Option<Vec<Triangle>> = (0..faces).map(face).collect();
    let triangles = triangles.ok_or("a face has a corner that does not exist")?;
    Ok(Surface { vertices: (0..vertices).filter_map(vertex).collect(), triangles })
}
