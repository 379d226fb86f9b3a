//! Recordings that are read in pieces equal recordings that are read as a whole.

use std::fmt::Write;
use std::sync::{Arc, Mutex};
use stiction_core::kinematics::Target;
use stiction_format::{Contents, Diagnostics, Drives, ModelFile, Motion, Source, Store, read};

const ROBOT: &str = r#"
gravity = [0, 0, 0]
[bodies.rod]
[bodies.bob]
[joints.A]
type = "R"
from = "ground"
to = "rod"
axis = "z"
actuated = true
[joints.B]
type = "P"
from = "rod"
to = "bob"
axis = "x"
actuated = true
"#;

/// File that returns a few bytes at a time and whose content can be changed by other threads.
#[derive(Debug)]
struct Bytes(Mutex<Vec<u8>>);

impl Store for Bytes {
    fn read_at(&self, offset: u64, buffer: &mut [u8]) -> Result<usize, String> {
        let bytes = self.0.lock().unwrap();
        let rest = bytes.get(offset as usize..).unwrap_or_default();
        let count = rest.len().min(buffer.len()).min(50_021);
        buffer[..count].copy_from_slice(&rest[..count]);
        Ok(count)
    }
}

fn store(text: &str) -> Arc<Bytes> {
    Arc::new(Bytes(Mutex::new(text.as_bytes().to_vec())))
}

fn robot() -> ModelFile {
    let files = |_: &str| Err("no files".to_owned());
    read(&Source::new("robot.toml", ROBOT), &files).unwrap()
}

fn motion(contents: Contents) -> Result<Motion, Diagnostics> {
    let files = |_: &str| Ok(contents.clone());
    robot().parse_motion(&Source::new("--motion", "motion.csv"), &files)
}

fn drives(contents: Contents) -> Result<Drives, Diagnostics> {
    let files = |_: &str| Ok(contents.clone());
    robot().parse_drives(&Source::new("--drives", "drives.csv"), &files)
}

/// Irregular values, so that a missing sample is detected.
fn rough(k: usize) -> f64 {
    ((k * k) as f64 * 0.618).sin()
}

/// Lengths of time steps; neighbouring steps differ by at most a factor of three.
fn uneven(k: usize) -> f64 {
    1e-3 * [1.0, 0.4, 1.2, 0.7][k % 4]
}

/// A recording of two coordinates, the second in millimetres, with the given numbers of
/// derivatives.
fn recording(count: usize, [first, second]: [usize; 2], step: fn(usize) -> f64) -> String {
    let name = |name: &str, unit: &str, derivatives: usize| {
        let all = [
            format!(", {name} [{unit}]"),
            format!(", d({name}) [{unit}/s]"),
            format!(", dd({name}) [{unit}/s^2]"),
        ];
        all[..=derivatives].concat()
    };
    let mut text =
        format!("time [s], \"note\"{}{}\n", name("A", "rad", first), name("B", "mm", second))
            .replace(", \"note\"", "");
    let mut time = 0.0;
    // Numbers of each coordinate and its derivatives: the highest one is rough, the others are its
    // integrals by the trapezoidal rule.
    let mut all = [vec![0.0; first + 1], vec![0.0; second + 1]];
    for k in 0..count {
        time += step(k);
        write!(text, "{time}").unwrap();
        for (index, numbers) in all.iter_mut().enumerate() {
            let mut change = None;
            for number in numbers.iter_mut().rev() {
                let last = *number;
                *number = change.map_or(rough(k + 7 * index), |change| last + change);
                change = Some(0.5 * step(k) * (last + *number));
            }
            numbers.iter().for_each(|number| write!(text, ", {number}").unwrap());
        }
        text.push('\n');
    }
    text
}

fn bits(target: Target<f64>) -> [u64; 3] {
    [target.value, target.rate, target.acceleration].map(f64::to_bits)
}

/// Instants at all samples, between them and outside.
fn instants(motion: &Motion) -> Vec<f64> {
    let samples: Vec<f64> = motion.samples.as_ref().unwrap().iter().collect();
    let between = samples.windows(2).map(|two| two[0] + 0.3 * (two[1] - two[0]));
    let (first, last) = (samples[0], samples[samples.len() - 1]);
    let beyond = [first - 0.1, last + 1e-4, last + 1.0];
    samples.iter().copied().chain(between).chain(beyond).collect()
}

fn assert_same(text: &str) {
    let whole = motion(text.into()).unwrap();
    let stored = motion(Contents::Stored(store(text))).unwrap();
    assert_eq!(whole.samples, stored.samples);
    assert_eq!(whole.start.to_bits(), stored.start.to_bits());
    assert_eq!(whole.duration.to_bits(), stored.duration.to_bits());
    assert_eq!(whole.interpolation, stored.interpolation);
    for t in instants(&whole) {
        for (a, b) in whole.at(t).zip(stored.at(t)) {
            assert_eq!(bits(a), bits(b), "at {t}: {a:?} {b:?}");
        }
    }
    let after = |motion: &Motion, t: f64| motion.samples.as_ref().unwrap().after(t);
    for t in instants(&whole) {
        assert_eq!(after(&whole, t), after(&stored, t), "after {t}");
    }
    for (_, signal) in &stored.coordinates {
        assert!(signal.fault_at(whole.start).is_none());
    }
}

/// Checks sample counts around the minimum numbers for a spline, for windows and for further
/// windows.
#[test]
fn pieces_equal_the_whole_to_the_last_bit() {
    for count in [2, 3, 6, 7, 8191, 8192, 8193, 12_287, 12_288, 20_001] {
        assert_same(&recording(count, [0, 1], uneven));
    }
    assert_same(&recording(13_000, [1, 2], uneven));
    assert_same(&recording(13_000, [2, 0], |_| 1e-3));
}

#[test]
fn ends_of_lines_comments_and_marks_do_not_matter() {
    let text = recording(9000, [0, 0], uneven);
    assert_same(&format!("\u{feff}# noted\n\n{text}"));
    assert_same(&text.replace('\n', "\r\n"));
    assert_same(text.trim_end());
    assert_same(&text.replace("\n0.8", "\n# a pause\n\n0.8"));
    assert_same(&format!("{text}\n\n# the end"));
}

/// Steps decrease by a fifth from one to the next over the whole margin of the first window, so
/// that samples beyond the margin have an influence. The spline is solved as a whole, and the
/// description says so.
#[test]
fn very_unequal_steps_are_solved_globally() {
    let steps = |k: usize| 1e-3 * 1.25_f64.powi(-(k as i32 - 4096).clamp(0, 96));
    let text = recording(9000, [0, 1], steps);
    let stored = motion(Contents::Stored(store(&text))).unwrap();
    let words = stored.interpolation.unwrap();
    assert!(words.contains("computed for all samples at once"), "{words}");
    assert_same(&text);
}

#[test]
fn efforts_are_the_same() {
    let text = recording(13_000, [0, 0], uneven).replace("[rad]", "[N m]").replace("[mm]", "[kN]");
    let (whole, stored) =
        (drives(text.as_str().into()).unwrap(), drives(Contents::Stored(store(&text))).unwrap());
    assert_eq!(whole.samples, stored.samples);
    assert_eq!(whole.interpolation, stored.interpolation);
    let (_, end) = whole.samples.as_ref().unwrap().ends().unwrap();
    for k in -10..30_000 {
        let t = f64::from(k) * end / 29_990.0;
        for ((a, whole), (b, stored)) in whole.efforts.iter().zip(&stored.efforts) {
            assert_eq!((a, bits(whole.at(t))), (b, bits(stored.at(t))), "at {t}");
        }
    }
}

/// Asserts that the messages are equal, including places and excerpts; returns them.
fn assert_same_complaint(text: &str) -> String {
    let whole = motion(text.into()).unwrap_err();
    let stored = motion(Contents::Stored(store(text))).unwrap_err();
    assert_eq!(whole.to_string(), stored.to_string());
    assert_eq!(whole.to_json(), stored.to_json());
    stored.to_string()
}

/// Replaces row `k`, counted from one.
fn with_row(text: &str, k: usize, row: &str) -> String {
    let mut lines: Vec<&str> = text.lines().collect();
    lines[k] = row;
    lines.join("\n")
}

#[test]
fn defects_have_the_same_places() {
    let count = 20_000;
    let good = recording(count, [0, 0], |_| 1e-3);
    for end in ["\n", "\r\n"] {
        for row in [1, 2, count / 2, count] {
            for defect in ["0.5, x, 1", "1e9, ,2", "0.5, 1", "-1, nan, 1e40", "\"0.1\", 7, ä", ",,"]
            {
                let text = with_row(&good, row, defect).replace('\n', end);
                let complaint = assert_same_complaint(&text);
                let place = format!("motion.csv:{}:", row + 1);
                assert!(complaint.contains(&place), "{complaint}");
            }
        }
    }
    // With an error in every row, some row begins a page, whatever the size of pages.
    assert_same_complaint(&good.replace(", 0", ", o"));
    // The wrong unit is reported on the first page, the time on the last.
    let late = with_row(&good, count, "0, 1, 2").replace("[mm]", "[kg]");
    assert!(assert_same_complaint(&late).contains("motion.csv:20001:1"));
    assert_same_complaint(&with_row(&good.replace("[rad]", "[deg]"), 9000, "9, 1000, 1"));
}

/// A cell that is not a number is reported only once, not also as a wrapped angle.
#[test]
fn an_invalid_number_is_reported_once() {
    let good = recording(10, [0, 0], |_| 1e-3);
    let whole = |text: String| motion(Contents::from(text));
    assert!(good.starts_with("time") && whole(good.clone()).is_ok(), "{good}");
    let header = good.lines().next().unwrap();
    let (angle, _) = header.split(',').enumerate().find(|(_, cell)| cell.contains("rad")).unwrap();
    for wrong in ["x", "nan", ""] {
        let row = good.lines().nth(5).unwrap();
        let mut cells: Vec<&str> = row.split(',').collect();
        cells[angle] = wrong;
        let Err(found) = whole(good.replace(row, &cells.join(","))) else { panic!("{wrong}") };
        assert_eq!(found.len(), 1, "{found:?}");
    }
}

#[test]
fn invalid_recordings_are_reported() {
    let rows = recording(9000, [0, 0], uneven);
    let (header, samples) = rows.split_once('\n').unwrap();
    for text in ["", "\n\n", "# nothing\n", header, &format!("{header}\n0, 1, 2\n"), samples] {
        assert_same_complaint(text);
    }
    assert_same_complaint(&format!("# {}\n", "x\n# ".repeat(200_000)));
    assert_same_complaint(&format!("{rows}\n1, x, 2\n\0"));
    assert_same(&rows.replace(',', ";"));
    assert_same(&rows.replace('\n', "\r"));
    // The spline through these samples is not finite.
    let steep = |k: usize| if k < 5000 { 1e-3 } else { f64::MIN_POSITIVE };
    assert_same_complaint(&recording(9000, [1, 1], steep));
}

#[test]
fn invalid_text_is_reported_with_its_place() {
    let why = |bytes: &[u8]| {
        let store = Arc::new(Bytes(Mutex::new(bytes.to_vec())));
        motion(Contents::Stored(store)).unwrap_err().to_string()
    };
    let mut bytes = recording(20_000, [0, 0], uneven).into_bytes();
    let at = bytes.len() - 1;
    bytes[at] = 0xe9;
    let place = format!("in line 20001 byte {} is 0xe9", at + 1);
    assert!(why(&bytes).contains(&place), "{}", why(&bytes));
    assert!(why(b"\xff\xfet\0").contains("UTF-16"));
    let endless = "7".repeat(2_000_000);
    assert!(why(endless.as_bytes()).contains("line 1 has more than 1048576 bytes"));
}

/// A file is refused if it has changed since it was first read.
#[test]
fn a_file_that_changes_is_refused() {
    let text = recording(20_000, [0, 0], uneven);
    let middle = text.match_indices('\n').nth(10_000).unwrap().0;
    /// Function that overwrites bytes around the middle of a file.
    type Change = fn(&mut Vec<u8>, usize);
    let changes: [(&str, Change); 4] = [
        // A digit of a time in the middle, which remains a number.
        ("it has changed", |bytes, middle| bytes[middle + 1] ^= 1),
        ("it has changed", |bytes, middle| bytes[middle + 1] = b'x'),
        ("it has changed", |bytes, middle| bytes[middle + 1] = 0xff),
        ("it has become shorter", |bytes, middle| bytes.truncate(middle)),
    ];
    for (why, change) in changes {
        let store = store(&text);
        let motion = motion(Contents::Stored(Arc::clone(&store) as Arc<dyn Store>)).unwrap();
        let (start, middle_time) = (motion.start, motion.start + 0.5 * motion.duration);
        let (_, signal) = &motion.coordinates[0];
        assert!(signal.at(start).value.is_finite());
        change(&mut store.0.lock().unwrap(), middle);
        // The piece in memory is that of the original file.
        assert!(signal.fault_at(start).is_none());
        let fault = signal.fault_at(middle_time).unwrap();
        assert!(fault.message.contains(why), "{}", fault.message);
        assert_eq!(fault.place.unwrap().source.name, "motion.csv");
        // After the error no value is returned, including those that could be read.
        assert!(signal.at(start).value.is_nan() && signal.at(middle_time).value.is_nan());
        let samples = motion.samples.as_ref().unwrap();
        assert!(samples.at(0).is_nan());
        assert!(motion.coordinates.iter().all(|(_, signal)| signal.fault_at(start).is_some()));
    }
}

/// Text appended after the end is ignored.
#[test]
fn appended_text_is_ignored() {
    let text = recording(9000, [0, 0], uneven);
    let store = store(&text);
    let stored = motion(Contents::Stored(Arc::clone(&store) as Arc<dyn Store>)).unwrap();
    store.0.lock().unwrap().extend_from_slice(b"1000, 1, 1\n");
    let whole = motion(text.as_str().into()).unwrap();
    for t in instants(&whole) {
        assert!(whole.at(t).map(bits).eq(stored.at(t).map(bits)), "at {t}");
    }
}

/// Threads use two recordings at different places; the number of threads exceeds the number of kept
/// pieces.
#[test]
fn threads_do_not_disturb_each_other() {
    let texts = [recording(60_000, [0, 0], uneven), recording(45_000, [1, 0], |_| 1e-3)];
    let whole = texts.each_ref().map(|text| motion(text.as_str().into()).unwrap());
    let stored = texts.each_ref().map(|text| motion(Contents::Stored(store(text))).unwrap());
    std::thread::scope(|scope| {
        for thread in 0..10 {
            let (whole, stored) = (&whole, &stored);
            scope.spawn(move || {
                for k in 0..4000 {
                    let part = f64::from((k + 1201 * thread) % 4000) / 4000.0;
                    let which = usize::from(k % 500 > 250);
                    let t = whole[which].start + part * whole[which].duration;
                    let same = whole[which].at(t).map(bits).eq(stored[which].at(t).map(bits));
                    assert!(same, "thread {thread} at {t}");
                }
            });
        }
    });
}

/// Only recordings can be longer than the limit for whole texts.
#[test]
fn only_recordings_can_be_long() {
    let files = |_: &str| Ok(Contents::Stored(store("A = 1")));
    let given = Source::new("--motion", "motion.toml");
    let refused = robot().parse_motion(&given, &files).unwrap_err().to_string();
    assert!(refused.contains("only recorded motions (CSV) can be this long"), "{refused}");
}
