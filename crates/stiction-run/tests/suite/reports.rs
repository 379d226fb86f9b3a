//! Reports of runs, in a browser and as text.

#[cfg(unix)]
use crate::chromium::Browser;
use crate::chromium::look_at_with_script;
use crate::common::*;
use serde_json::{Value, json};
use stiction_core::dynamics::FrictionMode;
use stiction_draw::page::source_of;
use stiction_draw::viewer::{SCRIPT, SHADED};
use stiction_format::{LoadCase, ModelFile, Source};
use stiction_run::inverse::{Animation, Curves, Summary, Tables, draw_report};
use stiction_run::{Job, Sink};

struct Run {
    html: String,
    summary: Value,
    reactions: Csv,
}

fn report(job: &Job<'_>) -> Run {
    let count = job.instants().unwrap().count();
    let mut summary = Summary::new(job);
    let mut curves = Curves::new(job, count);
    let mut animation = Animation::new(job, count);
    let names = Tables::<Vec<u8>>::files(job);
    let mut tables = Tables::new(job, vec![Vec::new(); names.len()]).unwrap();
    let mut sinks = ((&mut summary, &mut curves), &mut animation, &mut tables);
    let verdict = job.run(|sample| sinks.add(sample), |_, _, _| true).unwrap();
    let files = tables.finish().unwrap();
    let place = names.iter().position(|name| *name == "reactions.csv").unwrap();
    let command = Some("stiction inverse 'a <b> & c'");
    Run {
        html: draw_report(job, (&summary, &verdict), &curves.figures(), &animation, command),
        summary: summary.json(job, &verdict),
        reactions: Csv::parse(&files[place]),
    }
}

fn report_of(name: &str) -> Run {
    let model = model(name);
    report(&default_job(&model, FrictionMode::Converged))
}

/// Tests that the path in the page equals that of `bodies.csv`, with the same scale on both axes.
#[test]
fn paths_are_those_of_the_table() {
    let model = model("five-bar");
    let job = default_job(&model, FrictionMode::Converged);
    let count = job.instants().unwrap().count();
    let (mut curves, names) = (Curves::new(&job, count), Tables::<Vec<u8>>::files(&job));
    let mut tables = Tables::new(&job, vec![Vec::new(); names.len()]).unwrap();
    let mut sinks = (&mut curves, &mut tables);
    job.run(|sample| sinks.add(sample), |_, _, _| true).unwrap();
    let place = names.iter().position(|name| *name == "bodies.csv").unwrap();
    let bodies = Csv::parse(&tables.finish().unwrap()[place]);
    let figures = curves.figures();
    let (_, figure) = figures.iter().find(|(name, _)| *name == "path").unwrap();
    let [panel] = &figure.panels[..] else { panic!("{} panels", figure.panels.len()) };
    let points = &panel.lines[0].points;
    let (x, y) = (bodies.column("tool.x [m]"), bodies.column("tool.y [m]"));
    assert_eq!(points.len(), x.len());
    assert!(points.iter().zip(x.iter().zip(y)).all(|(p, (x, y))| (p.0, p.1) == (*x, *y)));

    let page = figure.inline("path");
    let number = |name: &str| -> f64 {
        let (_, rest) = page.split_once(&format!(" data-{name}=\"")).unwrap();
        rest.split_once('"').unwrap().0.parse().unwrap()
    };
    let across = (number("right") - number("left")) / (number("end") - number("first"));
    let up = (number("bottom") - number("top")) / (number("high") - number("low"));
    // Coordinates in the page are rounded to a tenth of a pixel.
    assert!((across / up - 1.0).abs() < 2e-3, "{across} {up} px/m");
}

#[test]
fn reports_are_legible() {
    for name in ["gough", "five-bar"] {
        look_at_with_script(&format!("report-{name}"), &report_of(name).html, SCRIPT);
    }
}

/// Simulates a user: plays, steps by keys, clicks a joint and compares its values with the table,
/// drags, follows a link, and prints.
#[cfg(unix)]
#[test]
fn a_person_uses_a_report() {
    let Some(browser) = Browser::find() else { return };
    let run = report_of("zhang2018-regular");
    let mut person = browser.open("report", &run.html, 1000);
    let time = "Number(document.getElementById('robot').dataset.time)";
    let picture = "document.querySelector('canvas').toDataURL()";
    assert_eq!(person.value(time), 0.0);

    let before = person.value(picture);
    let play = person.centre("button[aria-label=play]");
    person.click(play);
    person.wait_for(&format!("{time} > 0.05"));
    assert_ne!(person.value(picture), before, "playing moves the robot");
    let pause = person.centre("button[aria-label=pause]");
    person.click(pause);
    person.wait_for("document.querySelector('button[aria-label=play]') !== null");

    // The slider responds to keys: one sample at a time, and to both ends.
    person.value("document.querySelector('#robot input[type=range]').focus()");
    person.press("Home", 36);
    assert_eq!(person.value(time), 0.0);
    person.press("ArrowRight", 39);
    person.press("ArrowRight", 39);
    assert_eq!(person.value(time), 0.02);
    person.press("End", 35);
    assert_eq!(person.value(time), 1.0);
    person.press("ArrowLeft", 37);
    assert_eq!(person.value(time), 0.99);

    // Searches for a joint: the shape of the pointer changes there.
    let (x, y) = person.centre("canvas");
    let mut found = None;
    'search: for row in -12..12 {
        for column in -20..20 {
            let at = (x + 16.0 * f64::from(column), y + 16.0 * f64::from(row));
            person.point_at(at);
            if person.value("document.querySelector('canvas').style.cursor") == "pointer" {
                found = Some(at);
                break 'search;
            }
        }
    }
    person.click(found.expect("a joint"));
    let name = person.value("document.querySelector('.readout h3').textContent");
    let name = name.as_str().unwrap();
    let sample = run.reactions.column("time [s]").iter().position(|t| *t == 0.99).unwrap();
    for column in ["fx [N]", "fy [N]", "fz [N]", "mx [N m]", "my [N m]", "mz [N m]"] {
        let column = format!("{name}.{column}");
        let shown = person
            .value(&format!("document.querySelector('[data-column=\"{column}\"]').dataset.value"));
        let shown: f64 = shown.as_str().unwrap().parse().unwrap();
        assert_eq!(shown, run.reactions.column(&column)[sample], "{column}");
    }
    assert!(person.value("document.querySelectorAll('.joint-curve').length").as_u64() > Some(0));

    // The picture and the values can be saved as files.
    person.value(
        "window.kept = []; URL.createObjectURL = (make => blob => { blob.text().then(text => kept.push(text)); \
         return make.call(URL, blob); })(URL.createObjectURL)",
    );
    for label in ["save picture as SVG", "save values of the selected joint, or of all, as CSV"] {
        person.value(&format!("document.querySelector('[aria-label=\"{label}\"]').click()"));
    }
    person.wait_for("kept.length === 2");
    let files = person.value("kept");
    let (svg, csv) = (files[0].as_str().unwrap(), files[1].as_str().unwrap());
    assert!(svg.starts_with("<svg") && svg.matches("<path").count() > 20, "{svg}");
    assert_eq!(
        person.value(
            "new DOMParser().parseFromString(kept[0], 'image/svg+xml').querySelector('parsererror')"
        ),
        json!(null)
    );
    let mut lines = csv.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let column = header.iter().position(|own| *own == format!("{name}.fx [N]")).unwrap();
    let row: Vec<&str> = lines.nth(sample).unwrap().split(',').collect();
    let value: f64 = row[column].parse().unwrap();
    assert_eq!(value, run.reactions.column(&format!("{name}.fx [N]"))[sample]);

    // Selecting the least-constrained motion moves to the sample at which it occurs.
    person.value("document.querySelectorAll('.controls input[type=checkbox]').forEach(box => box.parentElement.textContent === 'least constrained motion' && box.click())");
    let least = &run.summary["verdicts"]["distance_actuation"];
    person.wait_for(&format!("{time} === {}", least["time"]));
    let words = person.value("document.querySelector('.key').textContent");
    assert!(words.as_str().unwrap().contains("resists least"), "{words}");
    person.value("document.querySelector('#robot input[type=range]').focus()");
    person.press("End", 35);
    person.press("ArrowLeft", 37);

    // The link contains view, joint and time. A page that is opened with this link begins with
    // them.
    person.drag((x - 300.0, y + 150.0), (x - 200.0, y + 120.0));
    let link = person.value("location.hash");
    let link = link.as_str().unwrap().to_owned();
    assert!(link.contains("t=0.99") && link.contains("joint=") && link.contains("view="), "{link}");
    let drawn = person.value(picture);
    let address = format!("{}{link}", person.address);
    person.go_to(&address);
    person.wait_for(&format!("{time} === 0.99"));
    assert_eq!(person.value("document.querySelector('.readout h3').textContent"), name);
    person.point_at((1.0, 1.0));
    assert_ne!(drawn, before);

    // A time in a table is a link to this time.
    let peak = run.summary["drives"]["leg1.P"]["with_friction"]["peak_time"].as_f64().unwrap();
    let peak_link = person.centre("td a[href^=\"#t=\"]");
    person.click(peak_link);
    person.wait_for(&format!("{time} === {peak:?}"));

    // The picture responds to keys.
    person.value("document.querySelector('canvas').focus()");
    let before = person.value(picture);
    person.press("ArrowLeft", 37);
    assert_ne!(person.value(picture), before);
    person.press("Escape", 27);
    assert_eq!(person.value("document.querySelector('.readout').textContent"), "");

    person.resize(360);
    assert!(person.value("document.documentElement.scrollWidth").as_u64() <= Some(360));
    person.call("Emulation.setEmulatedMedia", serde_json::json!({ "media": "print" }));
    let shown = |selector: &str| {
        format!("getComputedStyle(document.querySelector('{selector}')).display !== 'none'")
    };
    assert_eq!(person.value(&shown(".robot .still")), true);
    assert_eq!(person.value(&shown(".robot .stage")), false);
    assert_eq!(person.value(&shown(".robot .controls")), false);
    assert!(person.noise.is_empty(), "{:?}", person.noise);
}

/// Tests that every figure of a printed report fits on a page of letter paper, which has 25.9 cm between its margins, so that
/// none is divided. The friction forces of this robot have six panels.
#[cfg(unix)]
#[test]
fn printed_figures_fit_on_a_page() {
    let Some(browser) = Browser::find() else { return };
    let mut person = browser.open("print", &report_of("delta").html, 700);
    person.call("Emulation.setEmulatedMedia", json!({ "media": "print" }));
    let tallest =
        "Math.max(...[...document.querySelectorAll('.plot')].map(plot => plot.offsetHeight))";
    let pixels_per_cm = 96.0 / 2.54;
    let tallest = person.value(tallest).as_f64().unwrap() / pixels_per_cm;
    assert!((20.0..25.9).contains(&tallest), "{tallest} cm");
    assert!(person.noise.is_empty(), "{:?}", person.noise);
}

/// Simulates a user who points at a plot to read its curve, enlarges the plot by a key, and
/// restores it.
#[cfg(unix)]
#[test]
fn a_person_reads_a_plot() {
    let Some(browser) = Browser::find() else { return };
    let run = report_of("3rps");
    let mut person = browser.open("plot", &run.html, 1000);
    let plot = "document.querySelector('svg[data-left]')";
    person.centre("svg[data-left]");
    // The pointer is in the middle of the first panel, a quarter of its width from its left end.
    let place = person.value(&format!(
        "(() => {{ const p = {plot}, g = p.querySelector('g.panel'), n = (e, k) => Number(e.getAttribute('data-' + k)); \
         const at = new DOMPoint(0.75 * n(p, 'left') + 0.25 * n(p, 'right'), 0.5 * (n(g, 'top') + n(g, 'bottom'))); \
         const on = at.matrixTransform(p.getScreenCTM()); return [on.x, on.y]; }})()"
    ));
    let hint = "document.querySelector('.hint').textContent";
    assert_eq!(person.value(hint), "");
    person.point_at((place[0].as_f64().unwrap(), place[1].as_f64().unwrap()));
    let said = person.value(hint);
    let said = said.as_str().unwrap().replace('−', "-");
    // Page and tables contain the same samples, so the value is compared with that of the animated
    // robot at the same time.
    let words: Vec<&str> = said.split(' ').collect();
    assert_eq!(&words[..3], ["t", "≈", "0.25"], "{said}");
    let shown: Vec<f64> = words.iter().skip(3).filter_map(|word| word.parse().ok()).collect();
    let drive = "(() => { location.hash = '#t=0.25&joint=leg1.P'; return new Promise(done => setTimeout(() => \
                 done(document.querySelector('[data-column^=\"leg1.P.drive\"]').dataset.value), 200)); })()";
    person.value(&format!("{drive}.then(v => {{ window.drive = v; }}) && 0"));
    person.wait_for("window.drive !== undefined");
    let drive: f64 = person.value("window.drive").as_str().unwrap().parse().unwrap();
    let range = person.value(&format!(
        "(() => {{ const g = {plot}.querySelector('g.panel'); return g.getAttribute('data-high') - g.getAttribute('data-low'); }})()"
    ));
    // Tolerance: a tenth of a pixel of 160 vertically, and one pixel of 600 horizontally, on a
    // curve with slopes below ten ranges.
    let near = 0.02 * range.as_f64().unwrap();
    assert!(!shown.is_empty(), "{said}");
    assert!(shown.iter().any(|value| (value - drive).abs() < near), "{said}, but {drive}");

    let width = format!("{plot}.getBoundingClientRect().width");
    let before = person.value(&width).as_f64().unwrap();
    person.value(&format!("{plot}.parentElement.focus()"));
    person.press("+", 187);
    let after = person.value(&width).as_f64().unwrap();
    // The width without the scroll bar is the reference.
    assert!((after / before - 1.5).abs() < 0.05, "{before} {after}");
    assert!(person.value("document.documentElement.scrollWidth").as_u64() <= Some(1000));
    person.press("Escape", 27);
    assert!((person.value(&width).as_f64().unwrap() - before).abs() < 1.0);
    assert!(person.noise.is_empty(), "{:?}", person.noise);
}

/// Tests that, if the reader's settings ask for reduced motion, views change without a transition,
/// and the motion is played once.
#[cfg(unix)]
#[test]
fn reduced_motion_is_respected() {
    let Some(browser) = Browser::find() else { return };
    let mut person = browser.open("calm", &report_of("five-bar").html, 1000);
    let calm = json!({ "features": [{ "name": "prefers-reduced-motion", "value": "reduce" }] });
    person.call("Emulation.setEmulatedMedia", calm);
    let picture = "document.querySelector('canvas').toDataURL()";
    // The view changes at once: a later frame shows the same picture.
    let views = person.value(&format!(
        "(() => {{ document.querySelector('[aria-label=\"view: top\"]').click(); return {picture}; }})()"
    ));
    std::thread::sleep(std::time::Duration::from_millis(400));
    assert_eq!(person.value(picture), views);
    person.value(
        "(() => { const s = document.querySelector('select[aria-label=speed]'); s.value = '10'; \
         s.dispatchEvent(new Event('change')); document.querySelector('button[aria-label=play]').click(); })()",
    );
    let range = "document.querySelector('#robot input[type=range]')";
    person.wait_for(&format!(
        "document.querySelector('button[aria-label=play]') !== null && {range}.value === {range}.max"
    ));
}

/// Tests that the script draws a picture of a robot of 13 bodies and 18 joints in a few
/// milliseconds (median while playing).
#[cfg(unix)]
#[test]
fn pictures_are_drawn_fast() {
    let Some(browser) = Browser::find() else { return };
    let mut person = browser.open("fast", &report_of("gough").html, 1200);
    // Records the time that animation callbacks take in frames in which they draw a new sample.
    person.value(
        "(() => { window.took = []; const ask = window.requestAnimationFrame.bind(window); \
         const time = () => document.getElementById('robot').dataset.time; \
         window.requestAnimationFrame = act => ask(t => { const before = time(), begun = performance.now(); act(t); \
         if (time() !== before) took.push(performance.now() - begun); }); \
         document.querySelector('button[aria-label=play]').click(); })()",
    );
    person.wait_for("took.length >= 120");
    let median = person.value("took.sort((a, b) => a - b)[took.length >> 1]").as_f64().unwrap();
    assert!(median <= 4.0, "{median} ms");
}

fn hostile() -> ModelFile {
    let text = r#"
        title = "</script><script>window.hacked=1</script><img src=x onerror=window.hacked=1>"
        gravity = [0, 0, -9.81]
        [bodies."<b onclick=hacked()>"]
        mass = 2
        com = [0, 0, "-0.5 m"]
        inertia = [0.1, 0.1, 0.1]
        [joints."</script><svg onload=window.hacked=1>"]
        type = "R"
        from = "ground"
        to = "<b onclick=hacked()>"
        axis = "y"
        actuated = true
        friction = { mu = 0.1, radius = "10 mm" }
        [motions.m]
        duration = 1
        title = "\"><script>window.hacked=1</script>"
        "</script><svg onload=window.hacked=1>" = "0.3*sin(6*t)"
    "#;
    let source = stiction_format::Source::new("x.toml", text);
    match stiction_format::read(&source, &|_| Err("no files".into())) {
        Ok(model) => model,
        // If such names are rejected, only the titles contain markup.
        Err(_) => {
            let plain = text
                .replace("\"<b onclick=hacked()>\"", "\"bob\"")
                .replace("\"</script><svg onload=window.hacked=1>\"", "\"pivot\"")
                .replace("[bodies.\"bob\"]", "[bodies.bob]");
            model_of("x", &plain)
        }
    }
}

/// Tests that names and titles from the user's files are shown as text, not interpreted as markup.
#[test]
fn hostile_names_stay_text() {
    let model = hostile();
    let load = LoadCase::default();
    let job = Job::new(&model, ("m", model.motion("m").unwrap()), ("none", &load));
    let html = report(&job).html;
    // The page contains its own script and the data.
    assert_eq!(html.matches("<script").count(), 2);
    assert_eq!(html.matches("</script").count(), 2);
    for markup in ["<img", "<b onclick", "<svg onload"] {
        assert!(!html.contains(markup), "{markup}");
    }
    #[cfg(unix)]
    if let Some(browser) = Browser::find() {
        let mut person = browser.open("hostile", &html, 1000);
        assert_eq!(person.value("typeof window.hacked"), "undefined");
        assert_eq!(person.value("document.images.length"), 0);
        assert_eq!(person.value("document.documentElement.classList.contains('live')"), true);
        assert!(person.noise.is_empty(), "{:?}", person.noise);
        // The content security policy also blocks scripts that are injected later.
        person.value(
            "(() => { const s = document.createElement('script'); s.textContent = 'window.hacked = 1'; \
             document.body.append(s); })()",
        );
        assert_eq!(person.value("typeof window.hacked"), "undefined");
    }
}

/// Tests that a page with meshes contains the meshes and a script that draws them, and that a build
/// without the shaded view states that it is missing. Names and contents of mesh files are not
/// interpreted as markup.
#[test]
fn meshes_are_part_of_the_page() {
    let name = "</script><img src=x onerror=window.hacked=1>.obj";
    let visual = format!(
        "[bodies.left_crank]\nvisual = [{{ mesh = {name:?}, scale = [0.05, 0.05, 0.05] }}, {{ mesh = \"bad.stl\" }}]"
    );
    let text = stiction_format::gallery::get("five-bar").unwrap();
    let text = text.replacen("[bodies.left_crank]", &visual, 1);
    let source = Source::new("five-bar.toml", text);
    let mut model = stiction_format::read(&source, &|_| Err("no files".into())).unwrap();
    assert_eq!(model.visuals.len(), 2);
    let cube =
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n# </script>\n";
    // The STL file lacks its last line.
    let flat = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0 0 0\nvertex 0 0 0\nendloop\nendfacet\n";
    model.load_meshes(&|file| Ok(if file == name { cube } else { flat }.as_bytes().to_vec()));
    assert!(model.visuals.iter().all(|visual| visual.mesh.is_some()), "{:?}", model.warnings);
    let html = report(&default_job(&model, FrictionMode::Converged)).html;
    assert!(!html.contains("<img"));
    if SHADED.is_empty() {
        assert!(html.contains("this program was built without the shaded view"));
        assert_eq!(html.matches("<script").count(), 2);
        return;
    }
    assert!(html.contains("This page contains 2 mesh files, 1 kB."));
    assert_eq!(html.matches("<script").count(), 3);
    assert!(html.contains(&format!("{} {}", source_of(SCRIPT), source_of(SHADED))));
    #[cfg(unix)]
    if let Some(browser) = Browser::find() {
        let mut person = browser.open("meshes", &html, 1000);
        person.wait_for("document.querySelector('canvas.shaded') !== null");
        // Without its last line, the STL file contains no facet for the viewer; the other mesh is
        // drawn.
        let remark = person.value("document.querySelector('.kept').textContent");
        let remark = remark.as_str().unwrap();
        assert!(
            remark.ends_with(" The mesh bad.stl cannot be shown: it has no extent."),
            "{remark}"
        );
        let painted = "(() => { const c = document.createElement('canvas'), from = document.querySelector('canvas.shaded'); \
             c.width = from.width; c.height = from.height; const pen = c.getContext('2d'); \
             document.querySelector('.robot input[type=checkbox]').click(); \
             pen.drawImage(from, 0, 0); \
             return pen.getImageData(0, 0, c.width, c.height).data.filter((x, k) => k % 4 === 3 && x > 0).length; })()";
        let count = person.value(painted).as_u64().unwrap();
        assert!(count > 300, "{count} pixels");
        assert_eq!(person.value("typeof window.hacked"), "undefined");
        // The graphics driver warns that reading the picture back is slow.
        person.noise.retain(|noise| !noise.contains("GL Driver Message"));
        assert!(person.noise.is_empty(), "{:?}", person.noise);
    }
}

/// Tests that the report of a long run is small, and contains the samples of all peaks in its
/// tables.
#[test]
fn long_runs_are_thinned_and_keep_their_peaks() {
    let model = model("slider-crank");
    let job = default_job(&model, FrictionMode::Converged);
    let step = Some(job.motion.duration / 24_999.0);
    let run = report(&Job { step, ..job });
    assert_eq!(run.summary["options"]["samples"], 25_000);
    assert!(run.html.len() < 10_000_000, "{}", run.html.len());
    let film = film_of(&run.html);
    let times = doubles(&film["times"]);
    assert!(times.len() < 4000 && times.is_sorted() && film["of"] == 25_000);
    let columns = film["columns"].as_array().unwrap().len();
    assert_eq!(decoded(film["values"].as_str().unwrap()).len(), 8 * columns * times.len());
    let mut peaks = Vec::new();
    collect_peaks(&run.summary["joints"], &mut peaks);
    for drive in run.summary["drives"].as_object().unwrap().values() {
        peaks.push(drive["with_friction"]["peak_time"].as_f64().unwrap());
    }
    assert!(peaks.len() >= 8);
    for peak in peaks {
        assert!(times.contains(&peak), "{peak}");
    }
}

fn collect_peaks(value: &Value, peaks: &mut Vec<f64>) {
    for (key, inner) in value.as_object().into_iter().flatten() {
        match key.as_str() {
            "peak_time" => peaks.extend(inner.as_f64()),
            _ => collect_peaks(inner, peaks),
        }
    }
}

fn decoded(text: &str) -> Vec<u8> {
    let digit = |letter: u8| match letter {
        b'A'..=b'Z' => letter - b'A',
        b'a'..=b'z' => letter - b'a' + 26,
        b'0'..=b'9' => letter - b'0' + 52,
        b'+' => 62,
        _ => 63,
    };
    let mut bytes = Vec::new();
    for group in text.as_bytes().chunks(4) {
        let kept = group.iter().filter(|letter| **letter != b'=').count();
        let bits = group.iter().take(kept).fold(0_u32, |bits, l| bits << 6 | u32::from(digit(*l)));
        let bits = bits << (6 * (4 - kept));
        bytes.extend_from_slice(&bits.to_be_bytes()[1..kept]);
    }
    bytes
}

/// Data of the moving robot in a page.
fn film_of(html: &str) -> Value {
    let begin = html.find("class=\"film\">").unwrap() + "class=\"film\">".len();
    let end = begin + html[begin..].find("</script>").unwrap();
    serde_json::from_str(&html[begin..end]).unwrap()
}

fn doubles(text: &Value) -> Vec<f64> {
    let bytes = decoded(text.as_str().unwrap());
    bytes.chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect()
}

fn pendulum() -> ModelFile {
    model_of(
        "pendulum",
        r#"
        gravity = [0, "-9.81 m/s^2", 0]
        [bodies.arm]
        mass = 2
        com = ["0.5 m", 0, 0]
        inertia = [0.1, 0.1, 0.1]
        [joints.J]
        type = "R"
        from = "ground"
        to = "arm"
        axis = "z"
        actuated = true
        [springs.s]
        from = "ground"
        at = [0, "1 m", 0]
        to = "arm"
        to_at = ["0.4 m", 0, 0]
        stiffness = "200 N/m"
        free_length = "100 mm"
        [loads.tip]
        arm = { force = [0, "20 N", 0], at = ["1 m", "0.1 m", 0] }
        [motions.m]
        J = "t"
        duration = 1
        "#,
    )
}

/// Tests the starts of arrows, which are fixed in the body.
#[test]
fn arrows_of_loads_start_at_their_points_of_application() {
    let model = pendulum();
    let film = film_of(&report(&job(&model, "m", "tip", FrictionMode::Off)).html);
    let names: Vec<&str> =
        film["columns"].as_array().unwrap().iter().map(|name| name.as_str().unwrap()).collect();
    let values = doubles(&film["values"]);
    let rows: Vec<&[f64]> = values.chunks_exact(names.len()).collect();
    assert!(rows.len() > 10);
    let column = |name: &str| names.iter().position(|own| *own == name).unwrap();
    for (name, expected) in [("fy [N]", 20.0), ("x [m]", 1.0), ("y [m]", 0.1), ("z [m]", 0.0)] {
        let place = column(&format!("load on arm.{name}"));
        assert!(rows.iter().all(|row| (row[place] - expected).abs() < 1e-12), "{name}");
    }
}

#[test]
fn springs_move_with_their_bodies() {
    let model = pendulum();
    let html = report(&job(&model, "m", "tip", FrictionMode::Off)).html;
    let expected =
        json!([{ "name": "s", "bodies": [0, 1], "at": [[0.0, 1.0, 0.0], [0.4, 0.0, 0.0]] }]);
    assert_eq!(film_of(&html)["scene"]["springs"], expected);
    assert!(html.contains("<title>s: spring, ground to arm</title>"));
}
