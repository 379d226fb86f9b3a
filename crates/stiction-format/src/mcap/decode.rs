//! Decodes messages with joint states in the encodings of ROS 2, ROS 1 and JSON.

use serde_json::Value;

/// Positions and efforts of the joints in one message.
#[derive(Debug, Default, PartialEq)]
pub(super) struct JointState {
    /// Time stamp in the message, ns; 0 if the message has no time stamp.
    pub(super) time: u64,
    pub(super) names: Vec<String>,
    pub(super) positions: Vec<f64>,
    /// Efforts of the joints, N or N m, in the order of `names`. The list is empty if the message
    /// has no efforts; in Foxglove's schema, single joints may lack an effort.
    pub(super) efforts: Vec<Option<f64>>,
}

impl JointState {
    /// Returns the effort of the joint with this index in `names`, N or N m; `None` if the message
    /// does not contain it.
    pub(super) fn effort(&self, joint: usize) -> Option<f64> {
        self.efforts.get(joint).copied().flatten()
    }
}

/// Binary or text encoding of the messages in a log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    /// Common Data Representation (CDR) of ROS 2.
    Cdr,
    /// The serialization of ROS 1.
    Ros1,
    Json,
}

impl Encoding {
    pub(super) fn of(name: &str) -> Result<Self, String> {
        match name {
            "cdr" => Ok(Self::Cdr),
            "ros1" => Ok(Self::Ros1),
            "json" => Ok(Self::Json),
            _ => Err(format!("the encoding `{name}` is not supported; cdr, ros1 and json are")),
        }
    }
}

/// Decodes a joint state; `None` if the bytes are not a joint state.
pub(super) fn decode(encoding: Encoding, data: &[u8]) -> Option<JointState> {
    match encoding {
        Encoding::Json => of_json(&serde_json::from_slice(data).ok()?),
        Encoding::Cdr => {
            // The first byte of the encapsulation header is 0 for plain CDR, version 1; the second
            // byte is the byte order, 1 for little-endian.
            let (head, body) = data.split_first_chunk::<4>()?;
            if head[0] != 0 || head[1] > 1 {
                return None;
            }
            let is_big = head[1] == 0;
            Reader { data: body, at: 0, is_big, is_cdr: true }.state()
        }
        Encoding::Ros1 => Reader { data, at: 0, is_big: false, is_cdr: false }.state(),
    }
}

/// Reader of a ROS joint state with its header: time, frame, names, positions, velocities, efforts.
struct Reader<'a> {
    data: &'a [u8],
    at: usize,
    is_big: bool,
    is_cdr: bool,
}

impl Reader<'_> {
    fn state(mut self) -> Option<JointState> {
        if !self.is_cdr {
            // In ROS 1, the header begins with the sequence number of the message.
            self.whole()?;
        }
        let (seconds, nanoseconds) = (self.whole()?, self.whole()?);
        self.text()?;
        let count = self.whole()?;
        // Each name takes four bytes at least, for its length.
        let mut names = Vec::with_capacity((count as usize).min(self.data.len() / 4));
        for _ in 0..count {
            names.push(self.text()?);
        }
        let positions = self.numbers()?;
        self.numbers()?;
        let efforts = self.numbers()?.into_iter().map(Some).collect();
        let time = u64::from(seconds) * 1_000_000_000 + u64::from(nanoseconds);
        Some(JointState { time, names, positions, efforts })
    }

    /// Reads the next `N` bytes, which are aligned to `N` in CDR, and returns them in little-endian
    /// order.
    fn bytes<const N: usize>(&mut self) -> Option<[u8; N]> {
        if self.is_cdr {
            self.at = self.at.next_multiple_of(N);
        }
        let bytes: &[u8; N] = self.data.get(self.at..)?.first_chunk()?;
        self.at += N;
        let mut bytes = *bytes;
        if self.is_big {
            bytes.reverse();
        }
        Some(bytes)
    }

    fn whole(&mut self) -> Option<u32> {
        self.bytes().map(u32::from_le_bytes)
    }

    fn text(&mut self) -> Option<String> {
        let length = self.whole()? as usize;
        let bytes = self.data.get(self.at..)?.get(..length)?;
        self.at += length;
        // In CDR the length includes a terminating zero byte.
        let bytes = if self.is_cdr { bytes.strip_suffix(b"\0").unwrap_or(bytes) } else { bytes };
        String::from_utf8(bytes.to_vec()).ok()
    }

    fn numbers(&mut self) -> Option<Vec<f64>> {
        let count = self.whole()? as usize;
        let mut numbers = Vec::with_capacity(count.min(self.data.len() / 8));
        for _ in 0..count {
            numbers.push(f64::from_le_bytes(self.bytes()?));
        }
        Some(numbers)
    }
}

/// Reads a joint state that ROS or Foxglove has written as JSON.
fn of_json(value: &Value) -> Option<JointState> {
    let time = |stamp: &Value| {
        let seconds = stamp["sec"].as_u64().or_else(|| stamp["secs"].as_u64())?;
        let parts = ["nanosec", "nsec", "nsecs"].iter().find_map(|key| stamp[*key].as_u64());
        seconds.checked_mul(1_000_000_000)?.checked_add(parts?)
    };
    let numbers =
        |list: &Value| -> Option<Vec<f64>> { list.as_array()?.iter().map(Value::as_f64).collect() };
    if let Some(joints) = value["joints"].as_array() {
        let text = |joint: &Value| joint["name"].as_str().map(str::to_owned);
        let each = |key: &str| -> Option<Vec<f64>> {
            joints.iter().map(|joint| joint[key].as_f64()).collect()
        };
        return Some(JointState {
            time: time(&value["timestamp"]).unwrap_or(0),
            names: joints.iter().map(text).collect::<Option<_>>()?,
            positions: each("position")?,
            efforts: joints.iter().map(|joint| joint["effort"].as_f64()).collect(),
        });
    }
    let names = value["name"].as_array()?.iter().map(|name| name.as_str().map(str::to_owned));
    Some(JointState {
        time: time(&value["header"]["stamp"]).unwrap_or(0),
        names: names.collect::<Option<_>>()?,
        positions: numbers(&value["position"])?,
        efforts: match &value["effort"] {
            Value::Null => Vec::new(),
            list => numbers(list)?.into_iter().map(Some).collect(),
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Byte strings that follow the rules of CDR: 4 bytes of encapsulation, then little-endian
    /// numbers with natural alignment.
    const CDR: [&[u8]; 12] = [
        &[0, 1, 0, 0],
        &[3, 0, 0, 0],                                              // seconds
        &[5, 0, 0, 0],                                              // nanoseconds
        &[2, 0, 0, 0, b'w', 0],                                     // frame `w`
        &[0, 0, 2, 0, 0, 0],                                        // padding, two names
        &[2, 0, 0, 0, b'A', 0],                                     // name `A`
        &[0, 0, 6, 0, 0, 0, b'B', b'1', b'2', b'3', b'4', 0],       // padding, name `B1234`
        &[0, 0, 2, 0, 0, 0],                                        // padding, two positions
        &[0; 4],                                                    // padding
        &[0, 0, 0, 0, 0, 0, 0xf8, 0x3f, 0, 0, 0, 0, 0, 0, 0, 0xc0], // 1.5, -2
        &[0, 0, 0, 0],                                              // no velocities
        &[0, 0, 0, 0],                                              // no efforts
    ];

    #[test]
    fn common_data_representation() {
        let data = CDR.concat();
        let state = decode(Encoding::Cdr, &data).unwrap();
        let names = vec!["A".to_owned(), "B1234".to_owned()];
        let expected = JointState {
            time: 3_000_000_005,
            names,
            positions: vec![1.5, -2.0],
            efforts: Vec::new(),
        };
        assert_eq!(state, expected);
        for end in 0..data.len() {
            assert_eq!(decode(Encoding::Cdr, &data[..end]), None, "{end}");
        }
        // Checks that lengths beyond the end of the data do not cause large allocations.
        let huge = [&data[..16], &[0xff; 16]].concat();
        assert_eq!(decode(Encoding::Cdr, &huge), None);
    }

    #[test]
    fn serialization_of_ros_1() {
        let mut data = vec![7, 0, 0, 0, 3, 0, 0, 0, 5, 0, 0, 0, 0, 0, 0, 0];
        data.extend([1, 0, 0, 0, 1, 0, 0, 0, b'A', 1, 0, 0, 0]);
        data.extend(0.25_f64.to_le_bytes());
        data.extend([0, 0, 0, 0, 1, 0, 0, 0]);
        data.extend((-8.0_f64).to_le_bytes());
        let state = decode(Encoding::Ros1, &data).unwrap();
        assert_eq!((state.time, state.names), (3_000_000_005, vec!["A".to_owned()]));
        assert_eq!((state.positions, state.efforts), (vec![0.25], vec![Some(-8.0)]));
    }

    #[test]
    fn json_of_foxglove() {
        let text = br#"{"timestamp": {"sec": 1, "nsec": 2}, "joints":
            [{"name": "A", "position": 1, "effort": 3}, {"name": "B", "position": 2, "effort": 4}]}"#;
        let state = decode(Encoding::Json, text).unwrap();
        assert_eq!((state.time, state.positions), (1_000_000_002, vec![1.0, 2.0]));
        assert_eq!(state.efforts, [Some(3.0), Some(4.0)]);
        assert_eq!(decode(Encoding::Json, b"[]"), None);
        assert_eq!(decode(Encoding::Json, br#"{"name": ["A"]}"#), None);
    }
}
