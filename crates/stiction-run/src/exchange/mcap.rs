//! Results of a run as MCAP logs: joint states and a moving skeleton of the robot, in Foxglove's
//! schemas, encoded as JSON.

use crate::bodies::BodyRow;
use ::mcap::WriteOptions;
use ::mcap::records::MessageHeader;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::io::{self, BufReader, BufWriter, Read, Seek, Write};
use stiction_core::mechanism::Mechanism;
use stiction_core::spatial::{Pose, Vec3};

/// Topic of the joint states. If an MCAP log has several topics with joint states,
/// [`stiction_format`] reads this one.
const JOINT_STATES: &str = "/joint_states";
/// Topic of the messages with the moving skeleton of the robot.
const SCENE: &str = "/scene";
/// Name of the frame to which all poses in the log refer.
const WORLD: &str = "world";
/// Endings of column names in `joints.csv` and `forward.csv`. Each ending is paired with the field
/// of `foxglove.JointStates` that contains the values of the column.
const FIELDS: [(&str, &str); 3] =
    [(".position", "position"), (".rate", "velocity"), (".acceleration", "acceleration")];
/// Thickness of lines and diameter of balls in the skeleton, in characteristic lengths.
const SIZES: [f64; 2] = [0.02, 0.06];
/// Value of the field `type` of a line marker in which each pair of points is a segment.
const LINE_LIST: u8 = 2;

/// Writes a run as an MCAP log.
///
/// Each row of the tables becomes two messages, whose time stamps equal the time in the row. The
/// message on `/joint_states` (`foxglove.JointStates`) contains position, velocity, acceleration
/// and, for actuators, effort, in m, rad, s, N and N m, with the names of the columns. The message
/// on `/scene` (`foxglove.SceneUpdate`) contains a line from the middle of each body to each of its
/// joints, in the frame `world`.
///
/// The table `joints` contains the coordinates of joints (`joints.csv` or `forward.csv`), `efforts`
/// the actuator efforts (`inverse.csv` or `forward.csv`), and `bodies` the motion of the bodies
/// (`bodies.csv`).
///
/// # Errors
/// Returns an error if a table cannot be read, the log cannot be written, or a time is negative.
pub fn mcap_of_csv(
    mechanism: &Mechanism,
    joints: impl Read,
    efforts: impl Read,
    bodies: impl Read,
    log: impl Write + Seek,
) -> io::Result<()> {
    let mut joints = csv::Reader::from_reader(BufReader::new(joints));
    let mut efforts = csv::Reader::from_reader(BufReader::new(efforts));
    let mut bodies = csv::Reader::from_reader(BufReader::new(bodies));
    let states = JointStates::new(joints.headers()?, efforts.headers()?);
    let scene = Scene::new(mechanism);

    // Without compression, the bytes do not depend on the version of a compressor.
    let options = WriteOptions::new().compression(None).library("stiction");
    let mut writer = options.create(BufWriter::new(log)).map_err(io::Error::other)?;
    let mut channel = |topic, name: &str, schema: Value| {
        let schema = writer.add_schema(name, "jsonschema", schema.to_string().as_bytes())?;
        writer.add_channel(schema, topic, "json", &BTreeMap::new())
    };
    let on_joints = channel(JOINT_STATES, "foxglove.JointStates", JointStates::schema());
    let on_joints = on_joints.map_err(io::Error::other)?;
    let on_scene = channel(SCENE, "foxglove.SceneUpdate", Scene::schema());
    let on_scene = on_scene.map_err(io::Error::other)?;

    let [mut joint, mut effort, mut body] = [(); 3].map(|()| csv::StringRecord::new());
    let mut sequence = 0;
    while joints.read_record(&mut joint)? {
        if !(efforts.read_record(&mut effort)? && bodies.read_record(&mut body)?) {
            return Err(invalid("the tables have different numbers of rows".to_owned()));
        }
        let time = nanoseconds(number(&joint, 0)?)?;
        let stamp = json!({ "sec": time / 1_000_000_000, "nsec": time % 1_000_000_000 });
        let state = states.message(&stamp, &joint, &effort)?;
        let update = scene.message(&stamp, &body)?;
        for (channel_id, message) in [(on_joints, state), (on_scene, update)] {
            let header = MessageHeader { channel_id, sequence, log_time: time, publish_time: time };
            writer
                .write_to_known_channel(&header, message.to_string().as_bytes())
                .map_err(io::Error::other)?;
        }
        sequence = sequence.wrapping_add(1);
    }
    writer.finish().map_err(io::Error::other)?;
    writer.into_inner().flush()
}

/// Converts the time of a row, s, to whole nanoseconds. Returns an error if the time is negative.
fn nanoseconds(time: f64) -> io::Result<u64> {
    // Times of tables are below 1e9 s, so the product is far below the largest integer.
    let nanoseconds = (time * 1e9).round();
    if nanoseconds < 0.0 {
        return Err(invalid(format!(
            "the time {time} s is negative, which an MCAP log cannot hold; let the motion begin at 0 s"
        )));
    }
    Ok(nanoseconds as u64)
}

fn invalid(why: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, why)
}

fn number(row: &csv::StringRecord, column: usize) -> io::Result<f64> {
    let cell = row.get(column).unwrap_or_default();
    cell.parse().map_err(|_| invalid(format!("`{cell}` in a table is not a number")))
}

/// Returns the header of a column without its unit.
fn without_unit(header: &str) -> &str {
    header.split_once(" [").map_or(header, |(name, _)| name)
}

/// Columns of the tables that contain the states of the joint coordinates.
struct JointStates {
    /// Name of each joint coordinate, and the indices of the columns with its position, velocity
    /// and acceleration, in the order of [`FIELDS`].
    coordinates: Vec<(String, [Option<usize>; 3])>,
    /// Index of the column with the effort of each joint coordinate; `None` without an actuator.
    efforts: Vec<Option<usize>>,
}

impl JointStates {
    fn new(joints: &csv::StringRecord, efforts: &csv::StringRecord) -> Self {
        let column = |headers: &csv::StringRecord, name: &str| {
            headers.iter().position(|header| without_unit(header) == name)
        };
        let names: Vec<String> = joints
            .iter()
            .filter_map(|header| without_unit(header).strip_suffix(FIELDS[0].0))
            .map(str::to_owned)
            .collect();
        let efforts = names.iter().map(|name| column(efforts, &format!("{name}.drive"))).collect();
        let of = |name: String| {
            let columns = FIELDS.map(|(suffix, _)| column(joints, &format!("{name}{suffix}")));
            (name, columns)
        };
        Self { coordinates: names.into_iter().map(of).collect(), efforts }
    }

    fn message(
        &self,
        stamp: &Value,
        joint: &csv::StringRecord,
        effort: &csv::StringRecord,
    ) -> io::Result<Value> {
        let mut joints = Vec::with_capacity(self.coordinates.len());
        for ((name, columns), drive) in self.coordinates.iter().zip(&self.efforts) {
            let mut state = json!({ "name": name });
            for ((_, field), column) in FIELDS.iter().zip(columns) {
                if let Some(column) = column {
                    state[field] = json!(number(joint, *column)?);
                }
            }
            if let Some(column) = drive {
                state["effort"] = json!(number(effort, *column)?);
            }
            joints.push(state);
        }
        Ok(json!({ "timestamp": stamp, "joints": joints }))
    }

    fn schema() -> Value {
        let joint = json!({
            "name": { "type": "string" },
            "position": { "type": "number" },
            "velocity": { "type": "number" },
            "acceleration": { "type": "number" },
            "effort": { "type": "number" },
        });
        let joints = list(object(joint));
        titled("foxglove.JointStates", json!({ "timestamp": time(), "joints": joints }))
    }
}

/// Skeleton of the robot: a ball at each joint, and a line from the middle of each body to each of
/// its joints. The middle of a body is the mean of its joint positions.
struct Scene {
    /// Name of each body, the ground first, and the origins of the joints of the body in its frame,
    /// m.
    bodies: Vec<(String, Vec<Vec3<f64>>)>,
    /// Pose of the ground in the world.
    base: Pose<f64>,
    /// Thickness of the lines and diameter of the balls, m.
    sizes: [f64; 2],
}

impl Scene {
    fn new(mechanism: &Mechanism) -> Self {
        let bodies = mechanism.bodies().iter().enumerate().map(|(body, description)| {
            let points = mechanism.joints().iter().flat_map(|joint| {
                let before = (joint.predecessor.0 == body).then_some(joint.frame_j.position);
                let after = (joint.successor.0 == body).then_some(joint.frame_k.position);
                before.into_iter().chain(after)
            });
            (description.name.clone(), points.collect())
        });
        Self {
            bodies: bodies.collect(),
            base: mechanism.base(),
            sizes: SIZES.map(|size| size * mechanism.characteristic_length()),
        }
    }

    fn message(&self, stamp: &Value, row: &csv::StringRecord) -> io::Result<Value> {
        let mut columns = Vec::with_capacity(row.len());
        for column in 1..row.len() {
            columns.push(number(row, column)?);
        }
        let moving = columns.chunks_exact(BodyRow::WIDTH).map(BodyRow::pose);
        let poses = [self.base].into_iter().chain(moving);
        let bodies = self.bodies.iter().zip(poses).enumerate();
        let entities = bodies.map(|(index, ((name, points), pose))| {
            let points: Vec<Vec3<f64>> = points.iter().map(|point| pose.apply(*point)).collect();
            self.entity(stamp, name, &points, index == 0)
        });
        Ok(json!({ "entities": entities.collect::<Vec<_>>() }))
    }

    /// Returns the scene entity of a body whose joints are at `points` in the world. The ground has
    /// balls at its joints but no lines.
    fn entity(&self, stamp: &Value, name: &str, points: &[Vec3<f64>], is_ground: bool) -> Value {
        let [thickness, size] = self.sizes;
        let sum = points.iter().fold(Vec3::zero(), |sum, point| sum + *point);
        let middle = sum * (1.0 / points.len().max(1) as f64);
        let [r, g, b] = if is_ground { [0.4, 0.4, 0.4] } else { [0.0, 0.45, 0.7] };
        let color = json!({ "r": r, "g": g, "b": b, "a": 1.0 });
        let balls = points.iter().map(|point| {
            json!({
                "pose": { "position": xyz(*point), "orientation": upright() },
                "size": { "x": size, "y": size, "z": size },
                "color": color,
            })
        });
        let ends = points.iter().flat_map(|point| [xyz(middle), xyz(*point)]);
        let lines = json!({
            "type": LINE_LIST,
            "pose": { "position": xyz(Vec3::zero()), "orientation": upright() },
            "thickness": thickness,
            "scale_invariant": false,
            "points": ends.collect::<Vec<_>>(),
            "color": color,
            "colors": [],
            "indices": [],
        });
        json!({
            "timestamp": stamp,
            "frame_id": WORLD,
            "id": name,
            "lifetime": { "sec": 0, "nsec": 0 },
            "frame_locked": false,
            "metadata": [],
            "lines": if is_ground { Vec::new() } else { vec![lines] },
            "spheres": balls.collect::<Vec<_>>(),
        })
    }

    fn schema() -> Value {
        let vector = || object(numbers(&["x", "y", "z"]));
        let pose = object(json!({
            "position": vector(),
            "orientation": object(numbers(&["x", "y", "z", "w"])),
        }));
        let color = object(numbers(&["r", "g", "b", "a"]));
        let line = object(json!({
            "type": { "type": "integer" },
            "pose": pose,
            "thickness": { "type": "number" },
            "scale_invariant": { "type": "boolean" },
            "points": list(vector()),
            "color": color,
            "colors": list(color.clone()),
            "indices": list(json!({ "type": "integer" })),
        }));
        let entity = object(json!({
            "timestamp": time(),
            "frame_id": { "type": "string" },
            "id": { "type": "string" },
            "lifetime": time(),
            "frame_locked": { "type": "boolean" },
            "metadata": list(object(json!({}))),
            "lines": list(line),
            "spheres": list(object(json!({ "pose": pose, "size": vector(), "color": color }))),
        }));
        titled("foxglove.SceneUpdate", json!({ "entities": list(entity) }))
    }
}

/// Returns the identity quaternion: axes parallel to those of the world.
fn upright() -> Value {
    json!({ "x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0 })
}

fn xyz(vector: Vec3<f64>) -> Value {
    json!({ "x": vector.x, "y": vector.y, "z": vector.z })
}

// The functions below create parts of JSON schemas.

fn object(properties: Value) -> Value {
    json!({ "type": "object", "properties": properties })
}

fn titled(title: &str, properties: Value) -> Value {
    json!({ "title": title, "type": "object", "properties": properties })
}

fn list(items: Value) -> Value {
    json!({ "type": "array", "items": items })
}

fn numbers(names: &[&str]) -> Value {
    names.iter().map(|name| ((*name).to_owned(), json!({ "type": "number" }))).collect()
}

fn time() -> Value {
    object(json!({ "sec": { "type": "integer" }, "nsec": { "type": "integer" } }))
}
