//! Reads joint states from MCAP logs, including bags of ROS 2, as tables.

mod decode;

use ::mcap::MessageStream;
use decode::{Encoding, JointState, decode};
use std::collections::BTreeMap;
use std::fmt::Write;

/// Maximum total size of the messages with joint states in a log, bytes.
const LARGEST: usize = 1 << 30;
/// Names of the message schemas for joint states in ROS 2, ROS 1 and Foxglove.
const SCHEMAS: [&str; 3] =
    ["sensor_msgs/msg/JointState", "sensor_msgs/JointState", "foxglove.JointStates"];
/// Topic that is read if a log has joint states in several topics.
const USUAL_TOPIC: &str = "/joint_states";
/// Maximum number of topics or joint names listed in an error message.
const LISTED: usize = 8;

/// Joint states of one topic, in the order of the log; each state is a row.
struct Recorded {
    names: Vec<String>,
    /// Log time and time stamp of each message, ns; the time stamp is 0 if the message has none.
    times: Vec<[u64; 2]>,
    /// Positions of all joints, row by row, m or rad.
    positions: Vec<f64>,
    /// For each joint: true if the first message contains its effort.
    with_effort: Vec<bool>,
    /// Efforts of the joints in `with_effort`, row by row, N or N m.
    efforts: Vec<f64>,
}

/// Converts the joint states of an MCAP log to a CSV table. The columns are the time since the
/// first state, s, and the position of each joint, m or rad, under the name of the joint. With
/// `efforts`, a column `NAME.effort`, N or N m, follows for each joint that has efforts.
///
/// Times are the time stamps of the messages, or the times of the log if no message has a time
/// stamp. If there are several topics with joint states, `/joint_states` is read.
///
/// # Errors
/// Returns the reason as the end of the sentence "cannot read FILE: ".
pub fn csv_of_mcap(bytes: &[u8], efforts: bool) -> Result<String, String> {
    let damaged = |error: ::mcap::McapError| {
        format!(
            "it is not a complete MCAP log ({error}); `mcap recover` repairs an interrupted \
            one"
        )
    };
    let mut topics: BTreeMap<String, Result<Recorded, String>> = BTreeMap::new();
    let mut others: Vec<String> = Vec::new();
    let mut size = 0;
    for message in MessageStream::new(bytes).map_err(damaged)? {
        let message = message.map_err(damaged)?;
        let channel = &message.channel;
        let schema = channel.schema.as_ref().map_or("", |schema| schema.name.as_str());
        if !SCHEMAS.contains(&schema) {
            let seen = format!("{} ({schema})", channel.topic);
            if others.len() < LISTED && !others.contains(&seen) {
                others.push(seen);
            }
            continue;
        }
        size += message.data.len();
        if size > LARGEST {
            return Err("its joint states are larger than 1 GB in total".to_owned());
        }
        let at =
            |why: String| format!("topic {}, message {}: {why}", channel.topic, message.sequence);
        let state = Encoding::of(&channel.message_encoding).and_then(|encoding| {
            decode(encoding, &message.data).ok_or_else(|| {
                format!("it is not a {schema} in the encoding {}", channel.message_encoding)
            })
        });
        // An error in a topic matters only if this topic is read.
        let log_time = message.log_time;
        match topics.get_mut(&channel.topic) {
            Some(Ok(recorded)) => {
                let added = state.and_then(|state| recorded.add([log_time, state.time], &state));
                if let Err(why) = added {
                    topics.insert(channel.topic.clone(), Err(at(why)));
                }
            }
            Some(Err(_)) => {}
            None => {
                let recorded = state.and_then(|state| Recorded::of([log_time, state.time], &state));
                topics.insert(channel.topic.clone(), recorded.map_err(at));
            }
        }
    }
    choose(topics, &others)?.csv(efforts)
}

/// Selects the only topic with joint states, or [`USUAL_TOPIC`] if there are several topics.
fn choose(
    mut topics: BTreeMap<String, Result<Recorded, String>>,
    others: &[String],
) -> Result<Recorded, String> {
    if let Some(usual) = topics.remove(USUAL_TOPIC) {
        return usual;
    }
    let names: Vec<String> = topics.keys().take(LISTED).cloned().collect();
    match (topics.len(), topics.pop_first()) {
        (1, Some((_, recorded))) => recorded,
        (0, _) if others.is_empty() => Err("it has no messages".to_owned()),
        (0, _) => Err(format!("it has no joint states; its topics are {}", others.join(", "))),
        _ => Err(format!(
            "it has joint states in several topics: {}; keep only one of them, or rename one to {USUAL_TOPIC}",
            names.join(", ")
        )),
    }
}

impl Recorded {
    /// Creates the table of a topic from its first state; `time` contains the log time and the time
    /// stamp, ns.
    fn of(time: [u64; 2], state: &JointState) -> Result<Self, String> {
        if let Some(name) = state.names.iter().find(|name| !is_header(name)) {
            return Err(format!("the joint name {name:?} cannot be used as a column name"));
        }
        for (k, name) in state.names.iter().enumerate() {
            if state.names[..k].contains(name) {
                return Err(format!("it has two joints `{name}`"));
            }
        }
        let names = state.names.clone();
        let mut recorded = Self {
            with_effort: (0..names.len()).map(|k| state.effort(k).is_some()).collect(),
            names,
            times: Vec::new(),
            positions: Vec::new(),
            efforts: Vec::new(),
        };
        recorded.add(time, state)?;
        Ok(recorded)
    }

    /// Adds a state; the order of its joints may differ from that of the first state.
    fn add(&mut self, time: [u64; 2], state: &JointState) -> Result<(), String> {
        let count = self.names.len();
        let place = |name: &String| state.names.iter().position(|other| other == name);
        let places: Option<Vec<usize>> = match state.names == self.names {
            true => Some((0..count).collect()),
            false => self.names.iter().map(place).collect(),
        };
        let places = places.filter(|_| state.names.len() == count).ok_or_else(|| {
            format!(
                "a message has the joints {}, but the first message has {}: record the messages of \
                 one publisher only",
                state.names.join(", "),
                self.names.join(", ")
            )
        })?;
        if state.positions.len() != count {
            return Err(format!("it has {count} joints, but {} positions", state.positions.len()));
        }
        self.times.push(time);
        for (index, &k) in places.iter().enumerate() {
            self.positions.push(state.positions[k]);
            let effort = state.effort(k);
            if effort.is_some() != self.with_effort[index] {
                return Err(format!(
                    "some messages have the effort of `{}`, others have none",
                    self.names[index]
                ));
            }
            self.efforts.extend(effort);
        }
        Ok(())
    }

    fn csv(&self, efforts: bool) -> Result<String, String> {
        if efforts && self.efforts.is_empty() {
            return Err("its joint states have no efforts".to_owned());
        }
        // Only if all time stamps are 0, log times are used: the first message of a simulator may
        // have time 0.
        let clock = usize::from(self.times.iter().any(|[_, own]| *own != 0));
        let first = self.times.first().map_or(0, |times| times[clock]);
        let mut out = "time [s]".to_owned();
        for name in &self.names {
            out += &format!(",{name}");
        }
        if efforts {
            for (name, _) in self.names.iter().zip(&self.with_effort).filter(|(_, has)| **has) {
                out += &format!(",{name}.effort");
            }
        }
        out.push('\n');
        let count = self.names.len().max(1);
        let driven = self.with_effort.iter().filter(|has| **has).count().max(1);
        let mut more = self.efforts.chunks(driven);
        for (times, positions) in self.times.iter().zip(self.positions.chunks(count)) {
            // Computed in whole nanoseconds: the time since 1970 has more digits than a double.
            let since = i128::from(times[clock]) - i128::from(first);
            let _ = write!(out, "{}", since as f64 * 1e-9);
            let efforts = more.next().filter(|_| efforts).unwrap_or_default();
            for number in positions.iter().chain(efforts) {
                // Writing to a string cannot fail. The digits are the fewest that read back as the same number.
                let _ = write!(out, ",{number:e}");
            }
            out.push('\n');
        }
        Ok(out)
    }
}

/// Tests if a text can be the name of a column in a CSV table.
fn is_header(name: &str) -> bool {
    !name.is_empty() && !name.contains(['"', '\n', '\r', ',', ';', '\t'])
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::mcap::{Writer, records::MessageHeader};
    use std::io::Cursor;

    /// Creates an MCAP log with one message for each topic and payload. The log times begin at 5 s
    /// and increase by 0.1 s.
    fn log(schema: &str, encoding: &str, topics: &[&str], payloads: &[Vec<u8>]) -> Vec<u8> {
        let mut file = Vec::new();
        {
            let mut writer = Writer::new(Cursor::new(&mut file)).unwrap();
            let schema = writer.add_schema(schema, "ros2msg", b"").unwrap();
            for topic in topics {
                let channel =
                    writer.add_channel(schema, topic, encoding, &BTreeMap::new()).unwrap();
                for (k, payload) in payloads.iter().enumerate() {
                    let log_time = 5_000_000_000 + 100_000_000 * k as u64;
                    let header = MessageHeader {
                        channel_id: channel,
                        sequence: k as u32,
                        log_time,
                        publish_time: log_time,
                    };
                    writer.write_to_known_channel(&header, payload).unwrap();
                }
            }
            writer.finish().unwrap();
        }
        file
    }

    /// Checks that a first time stamp of zero, as simulators write it, is valid.
    #[test]
    fn stamps_may_begin_at_zero() {
        let first = br#"{"name": ["A", "B"], "position": [1, 2]}"#.to_vec();
        let second = br#"{"header": {"stamp": {"sec": 0, "nanosec": 200000000}},
            "name": ["A", "B"], "position": [3, 4]}"#;
        let file = log(SCHEMAS[0], "json", &["/a"], &[first, second.to_vec()]);
        let text = csv_of_mcap(&file, false).unwrap();
        assert_eq!(text, "time [s],A,B\n0,1e0,2e0\n0.2,3e0,4e0\n");
        let damaged = br#"{"name": ["C"]}"#.to_vec();
        let file = log(SCHEMAS[0], "json", &["/gripper"], &[damaged]);
        assert!(csv_of_mcap(&file, true).unwrap_err().contains("/gripper, message 0"));
    }

    /// Formats the state of two joints, `A` and `B`, as JSON; `first` names the joint listed first.
    fn json(first: &str, positions: [f64; 2], efforts: &str) -> Vec<u8> {
        let second = if first == "A" { "B" } else { "A" };
        format!(
            "{{\"name\": [\"{first}\", \"{second}\"], \"position\": [{}, {}], \"effort\": [{efforts}]}}",
            positions[0], positions[1]
        )
        .into_bytes()
    }

    #[test]
    fn states_become_rows() {
        let states = [json("A", [0.1, 0.2], "1, 2"), json("B", [0.4, 0.3], "4, 3")];
        let file = log(SCHEMAS[0], "json", &["/joint_states"], &states);
        let text = csv_of_mcap(&file, true).unwrap();
        assert_eq!(
            text,
            "time [s],A,B,A.effort,B.effort\n0,1e-1,2e-1,1e0,2e0\n0.1,3e-1,4e-1,3e0,4e0\n"
        );
        let motion = csv_of_mcap(&file, false).unwrap();
        assert_eq!(motion, "time [s],A,B\n0,1e-1,2e-1\n0.1,3e-1,4e-1\n");
    }

    #[test]
    fn some_joints_have_efforts() {
        let state = |first: &str, second: &str| {
            format!(
                "{{\"joints\": [{{\"name\": \"A\", \"position\": 1{first}}}, \
                 {{\"name\": \"B\", \"position\": 2{second}}}]}}"
            )
            .into_bytes()
        };
        let driven = ", \"effort\": 3";
        let states = [state("", driven), state("", driven)];
        let text = csv_of_mcap(&log(SCHEMAS[2], "json", &["/a"], &states), true).unwrap();
        assert_eq!(text, "time [s],A,B,B.effort\n0,1e0,2e0,3e0\n0.1,1e0,2e0,3e0\n");
        let states = [state("", driven), state("", "")];
        let why = csv_of_mcap(&log(SCHEMAS[2], "json", &["/a"], &states), true).unwrap_err();
        assert!(why.contains("the effort of `B`"), "{why}");
    }

    #[test]
    fn unclear_logs_are_refused() {
        let why = |file: &[u8]| csv_of_mcap(file, true).unwrap_err();
        let states = [json("A", [0.1, 0.2], "1, 2")];
        let of =
            |schema: &str, encoding: &str, topics: &[&str]| log(schema, encoding, topics, &states);
        assert!(why(b"time,x\n").contains("not a complete MCAP log"));
        assert!(
            why(&of("std_msgs/msg/String", "json", &["/say"]))
                .contains("/say (std_msgs/msg/String)")
        );
        assert!(why(&of(SCHEMAS[0], "json", &["/a", "/b"])).contains("several topics: /a, /b"));
        assert!(csv_of_mcap(&of(SCHEMAS[0], "json", &["/a", "/joint_states"]), true).is_ok());
        assert!(why(&of(SCHEMAS[0], "protobuf", &["/a"])).contains("protobuf"));
        assert!(why(&of(SCHEMAS[0], "cdr", &["/a"])).contains("topic /a, message 0"));
        let no_efforts = log(SCHEMAS[0], "json", &["/a"], &[json("A", [0.1, 0.2], "")]);
        assert!(why(&no_efforts).contains("no efforts"));
        let other = br#"{"name": ["C"], "position": [1]}"#.to_vec();
        let changed = log(SCHEMAS[0], "json", &["/a"], &[states[0].clone(), other]);
        assert!(why(&changed).contains("a message has the joints C"));
        let file = of(SCHEMAS[0], "json", &["/a"]);
        for end in (0..file.len()).step_by(7) {
            // Checks that truncated files cause no panic.
            let _ = csv_of_mcap(&file[..end], true);
        }
    }
}
