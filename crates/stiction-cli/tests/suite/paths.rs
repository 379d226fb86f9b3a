//! Plots of paths and of tracking errors in space, as a person uses them in headless Chromium.
#![cfg(unix)]

use crate::chromium::Browser;
use crate::chromium::person::Person;
use crate::pages::column;
use crate::program::Folder;
use serde_json::{Value, json};

/// Panel of a plot in the window: its attributes, and a transformation to px of the window.
struct Panel {
    attributes: Value,
    /// Scale, and horizontal and vertical offset, px.
    window: [f64; 3],
}

impl Panel {
    /// Scrolls to the plot that `selector` finds and returns its panel `index`.
    fn find(person: &mut Person, selector: &str, index: usize) -> Self {
        person.centre(selector);
        let found = person.value(&format!(
            "(() => {{ const svg = document.querySelector({selector:?}), m = svg.getScreenCTM(); \
             const panel = svg.querySelectorAll('g.panel')[{index}]; \
             return [{{ ...svg.dataset, ...panel.dataset }}, [m.a, m.e, m.f]]; }})()"
        ));
        let window = serde_json::from_value(found[1].clone()).unwrap();
        Self { attributes: found[0].clone(), window }
    }

    fn number(&self, name: &str) -> f64 {
        self.text(name).parse().unwrap()
    }

    fn text(&self, name: &str) -> &str {
        self.attributes[name].as_str().unwrap_or_else(|| panic!("{name}: {}", self.attributes))
    }

    /// Place of values of both axes in the plot.
    fn place(&self, (x, y): (f64, f64)) -> (f64, f64) {
        let part = |value: f64, low: &str, high: &str| {
            (value - self.number(low)) / (self.number(high) - self.number(low))
        };
        let between = |a: f64, b: f64, part: f64| a + (b - a) * part;
        (
            between(self.number("left"), self.number("right"), part(x, "first", "end")),
            between(self.number("bottom"), self.number("top"), part(y, "low", "high")),
        )
    }

    /// A place of the plot in the window, px.
    fn in_window(&self, (x, y): (f64, f64)) -> (f64, f64) {
        let [scale, across, down] = self.window;
        (scale * x + across, scale * y + down)
    }
}

/// Columns of a run: the times, and both coordinates of the path in a panel.
struct Path {
    times: Vec<f64>,
    points: Vec<(f64, f64)>,
}

impl Path {
    /// `run` is the beginning of the names of the run's columns.
    fn of(table: &str, run: &str, panel: &Panel) -> Self {
        let axis = |name: &str| column(table, &format!("{run}{}", panel.text(name)));
        let points = axis("acrossName").into_iter().zip(axis("name"));
        Self { times: column(table, "time [s]"), points: points.collect() }
    }

    /// The row whose time is this one with four digits.
    fn row_at(&self, time: f64) -> usize {
        let row = |time: f64| self.times.iter().position(|own| (own - time).abs() <= 6e-4 * time);
        row(time).unwrap_or_else(|| panic!("no row at {time} s"))
    }
}

fn away(a: (f64, f64), b: (f64, f64)) -> f64 {
    (a.0 - b.0).hypot(a.1 - b.1)
}

/// Centre of the ring in a panel; of the second run if `is_other`.
fn ring(person: &mut Person, index: usize, is_other: bool) -> (f64, f64) {
    let of = if is_other { ".cursor.other" } else { ".cursor:not(.other)" };
    let drawn =
        person.value(&format!("document.querySelector('svg[data-plan] {of}').getAttribute('d')"));
    let drawn = drawn.as_str().unwrap();
    let begin = drawn.split('M').nth(index + 1).unwrap_or_else(|| panic!("no ring: {drawn}"));
    let (place, _) = begin.split_once('a').unwrap();
    let (x, y) = place.split_once(' ').unwrap();
    // A ring is drawn from its left end, and its radius is 5.
    (x.parse::<f64>().unwrap() + 5.0, y.parse().unwrap())
}

fn time(person: &mut Person) -> f64 {
    person.value("Number(document.getElementById('robot').dataset.time)").as_f64().unwrap()
}

/// The lines of the text beside the pointer.
fn hint(person: &mut Person) -> Vec<String> {
    let lines =
        person.value("[...document.querySelectorAll('.hint div')].map(line => line.textContent)");
    let lines: Vec<String> = serde_json::from_value(lines).unwrap();
    lines.into_iter().map(|line| line.replace('−', "-")).collect()
}

/// The number after a word in a line.
fn number_after(line: &str, word: &str) -> f64 {
    let (_, rest) = line.split_once(word).unwrap_or_else(|| panic!("no {word} in {line}"));
    rest.split_whitespace().next().unwrap().parse().unwrap_or_else(|_| panic!("{line}"))
}

/// Half of the last digit that a plot can be read to, for an axis of this length.
fn half_digit(range: f64) -> f64 {
    0.51 * 10f64.powf((range.log10() - 3.0).floor())
}

/// Moves the slider to a sample.
fn slide_to(person: &mut Person, row: usize) {
    person.value(&format!(
        "(() => {{ const s = document.querySelector('#robot input[type=range]'); s.value = '{row}'; \
         s.dispatchEvent(new Event('input')); }})()"
    ));
}

/// The ring follows the slider; pointing at the path tells the time and the position of the table, and a click goes to
/// that time. The first columns of a run begin with the first of `runs`, those of the run laid over it with the second.
fn read_path(person: &mut Person, table: &str, runs: &[&str]) {
    let panels = person.value("document.querySelectorAll('svg[data-plan] g.panel').length");
    for index in 0..panels.as_u64().unwrap() as usize {
        let panel = Panel::find(person, "svg[data-plan]", index);
        let paths: Vec<Path> = runs.iter().map(|run| Path::of(table, run, &panel)).collect();
        let path = &paths[0];
        for row in [0, path.times.len() / 3, path.times.len() - 1] {
            slide_to(person, row);
            assert_eq!(time(person), path.times[row]);
            for (k, own) in paths.iter().enumerate().take(2) {
                let found = ring(person, index, k == 1);
                // A place is rounded to a tenth.
                assert!(away(found, panel.place(own.points[row])) < 0.1, "row {row}: {found:?}");
            }
        }
        let row = path.times.len() / 4;
        let pointer = panel.place(path.points[row]);
        let at = panel.in_window(pointer);
        person.point_at(at);
        let lines = hint(person);
        let [first, x, y] = &lines[..] else { panic!("{lines:?}") };
        // Several samples and runs may be there: the nearest one is described.
        let told =
            paths.iter().zip(runs).find(|(_, run)| first.starts_with(run.trim_end_matches(": ")));
        let (told, _) = told.unwrap_or_else(|| panic!("{first}"));
        let row = told.row_at(number_after(first, "t = "));
        assert!(away(panel.place(told.points[row]), pointer) < 1.5, "{lines:?}");
        let near = half_digit(panel.number("end") - panel.number("first"));
        let point = told.points[row];
        for (name, line, value) in [("acrossName", x, point.0), ("name", y, point.1)] {
            let (name, _) = panel.text(name).split_once(" [").unwrap();
            let found = number_after(line, &format!("{name} ≈ "));
            assert!((found - value).abs() < near, "{line}, but {value}");
        }
        person.click(at);
        assert_eq!(time(person), told.times[row]);
        assert!(away(ring(person, index, false), panel.place(path.points[row])) < 0.1);
    }
}

/// Pointing at a plot of the distance from the reference tells the values of the table for each of the `runs` (beginning
/// of the columns, and label), and a click goes to that time.
fn read_errors(
    person: &mut Person,
    (table, body): (&str, &str),
    selector: &str,
    runs: &[(&str, &str)],
) {
    let panel = Panel::find(person, selector, 0);
    let name = panel.text("name");
    let unit = name.split(['[', ']']).nth(1).unwrap();
    assert!(name.starts_with(&format!("{body}: distance")), "{name}");
    let factor = match unit {
        "um" => 1e6,
        "mm" => 1e3,
        unit => panic!("{unit}"),
    };
    let times = column(table, "time [s]");
    let row = 2 * times.len() / 5;
    let middle = 0.5 * (panel.number("low") + panel.number("high"));
    let at = panel.in_window(panel.place((times[row], middle)));
    person.point_at(at);
    let lines = hint(person);
    assert_eq!(lines.len(), 1 + runs.len(), "{lines:?}");
    // One pixel of the window, s.
    let pixel = (panel.number("end") - panel.number("first"))
        / (panel.number("right") - panel.number("left"))
        / panel.window[0];
    let near_time = pixel + half_digit(panel.number("end") - panel.number("first"));
    assert!((number_after(&lines[0], "t ≈ ") - times[row]).abs() < near_time, "{lines:?}");
    for (run, label) in runs {
        let line = lines.iter().find(|line| line.starts_with(&format!("{label} ≈ ")));
        let line = line.unwrap_or_else(|| panic!("no {label} in {lines:?}"));
        assert!(line.ends_with(unit), "{line}");
        let found = number_after(line, "≈ ");
        // The curve may change within the pixel, and is drawn to a tenth.
        let errors = column(table, &format!("{run}{body}.error [m]"));
        let within = times
            .iter()
            .zip(&errors)
            .filter(|(t, _)| (*t - times[row]).abs() < 2.0 * pixel + 1.1 * (times[1] - times[0]));
        let within: Vec<f64> = within.map(|(_, error)| factor * error).collect();
        let range = panel.number("high") - panel.number("low");
        let near = half_digit(range) + 0.1 * range / (panel.number("bottom") - panel.number("top"));
        let (low, high) = (
            within.iter().copied().fold(f64::INFINITY, f64::min),
            within.iter().copied().fold(0.0, f64::max),
        );
        assert!(low - near <= found && found <= high + near, "{line}, but {low} to {high}");
    }
    person.click(at);
    assert!((time(person) - times[row]).abs() <= pixel + 0.5 * (times[1] - times[0]));
}

fn open(folder: &Folder, name: &str) -> Option<Person> {
    let html = folder.read(&format!("{name}/report.html"));
    // Tests that run at the same time have folders of different names.
    let test = folder.0.file_name().unwrap().display();
    Some(Browser::find()?.open(&format!("{test}-{name}"), &html, 1000))
}

#[test]
fn paths_of_inverse_dynamics_are_read() {
    let folder = Folder::new("paths-inverse");
    for name in ["five-bar", "3rps"] {
        folder.stiction(&["inverse", name, "-o", name]).succeeds();
        let Some(mut person) = open(&folder, name) else { return };
        read_path(&mut person, &folder.read(&format!("{name}/bodies.csv")), &[""]);
        // Away from the path, no text appears, and a click changes nothing.
        let panel = Panel::find(&mut person, "svg[data-plan]", 0);
        let before = time(&mut person);
        let corner = (panel.number("left") - 3.0, panel.number("bottom") + 3.0);
        person.click(panel.in_window(corner));
        assert!(hint(&mut person).is_empty());
        assert_eq!(time(&mut person), before);
        assert!(person.noise.is_empty(), "{:?}", person.noise);
    }
}

#[test]
fn paths_and_errors_of_simulations_are_read() {
    let folder = Folder::new("paths-forward");
    folder.stiction(&["forward", "five-bar", "-o", "out"]).succeeds();
    let Some(mut person) = open(&folder, "out") else { return };
    let table = folder.read("out/bodies.csv");
    read_path(&mut person, &table, &[""]);
    let selector = "svg[data-left]:has(g[data-name*=\"distance from the reference\"])";
    read_errors(&mut person, (&table, "tool"), selector, &[("", "error")]);
    assert!(person.noise.is_empty(), "{:?}", person.noise);
}

#[test]
fn paths_and_errors_of_controllers_are_read() {
    let folder = Folder::new("paths-compensate");
    let laws = ["pd", "computed-torque", "computed-torque+friction"];
    let list = laws.join(",");
    folder.stiction(&["compensate", "five-bar", "--controller", &list, "-o", "out"]).succeeds();
    let Some(mut person) = open(&folder, "out") else { return };
    let table = folder.read("out/compensate-space.csv");
    let runs = laws.map(|law| format!("{law}: "));
    read_path(&mut person, &table, &runs.each_ref().map(String::as_str));
    let both: Vec<(&str, &str)> = runs.iter().map(String::as_str).zip(laws).collect();
    let selector = "svg[data-left]:has(g[data-name*=\"distance from the reference\"])";
    read_errors(&mut person, (&table, "tool"), selector, &both);
    // Small errors have a plot of their own.
    let titles =
        person.value("[...document.querySelectorAll('.plot-title')].map(one => one.textContent)");
    let titles: Vec<String> = serde_json::from_value(titles).unwrap();
    let of = |begin: &str| titles.iter().filter(|title| title.starts_with(begin)).count();
    assert_eq!(
        (of("Tracking error in space"), of("Reference minus position")),
        (2, 2),
        "{titles:?}"
    );
    person.value(
        "[...document.querySelectorAll('.plot-title')].findLast(one => one.textContent.startsWith('Tracking error in space')) \
         .closest('figure').querySelector('svg[data-left]').id = 'small'",
    );
    read_errors(&mut person, (&table, "tool"), "#small", &both[1..]);
    // The second robot and its ring are those of the controller that is chosen.
    let choice = "document.querySelector('select[aria-label=overlay]')";
    assert_eq!(person.value(&format!("{choice}.options.length")), json!(3));
    person.value(&format!(
        "(() => {{ const o = {choice}; o.value = '1'; o.dispatchEvent(new Event('change')); }})()"
    ));
    let panel = Panel::find(&mut person, "svg[data-plan]", 0);
    let path = Path::of(&table, &runs[2], &panel);
    let now = time(&mut person);
    let row = path.times.iter().position(|own| *own == now).unwrap();
    assert!(away(ring(&mut person, 0, true), panel.place(path.points[row])) < 0.1);
    assert!(person.noise.is_empty(), "{:?}", person.noise);
}
