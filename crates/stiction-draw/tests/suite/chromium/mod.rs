//! Checks of pages in headless Chromium.
#![allow(dead_code, reason = "each test suite uses its part")]

#[cfg(unix)]
pub(crate) mod person;

use serde_json::Value;
use std::env;
use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// Names of the browser's executable.
const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];
/// Time limit of a browser run; a page of a few hundred kilobytes takes one or two seconds.
const PATIENCE: Duration = Duration::from_secs(60);
/// Widths of a phone and of a desktop window, px.
const WIDTHS: [u32; 2] = [360, 1200];
/// Maximum height of a screenshot, px. Chromium fails beyond 16384 px; the PDF shows the whole
/// page.
const LONGEST: u64 = 12_000;
/// Maximum size of a page, bytes: less than e-mail permits.
const LARGEST: u64 = 3_000_000;

/// Fails if the browser finds a defect in a page; `name` is part of the names of its screenshots.
#[track_caller]
pub(crate) fn look_at(name: &str, html: &str) {
    judge_page(name, html, None);
}

/// Fails if the browser finds a defect in a page with an animated robot, which may run only the
/// given script.
#[track_caller]
pub(crate) fn look_at_with_script(name: &str, html: &str, script: &str) {
    judge_page(name, html, Some(script));
}

#[track_caller]
fn judge_page(name: &str, html: &str, script: Option<&str>) {
    let Some(browser) = Browser::find() else { return };
    let defects = browser.defects(name, html, script);
    assert!(defects.is_empty(), "{name}:\n{}", defects.join("\n"));
}

/// An installed browser. Without one the tests are skipped with a notice, except in continuous
/// integration, where they fail.
pub(crate) struct Browser {
    program: PathBuf,
}

impl Browser {
    pub(crate) fn find() -> Option<Self> {
        if let Some(chosen) = env::var_os("CHROME") {
            let program = PathBuf::from(chosen);
            assert!(program.is_file(), "CHROME is {program:?}, where there is no program");
            return Some(Self { program });
        }
        let folders: Vec<PathBuf> =
            env::var_os("PATH").map(|path| env::split_paths(&path).collect()).unwrap_or_default();
        let places = NAMES.iter().flat_map(|name| folders.iter().map(move |f| f.join(name)));
        if let Some(program) = places.into_iter().find(|place| place.is_file()) {
            return Some(Self { program });
        }
        let advice = "no browser found: install Chromium, or say in CHROME where it is";
        assert!(env::var("CI").as_deref() != Ok("true"), "{advice}");
        // Not by `eprintln`, which nobody sees of tests that pass.
        let _ = writeln!(io::stderr(), "pages are not looked at, {advice}");
        None
    }

    /// Runs the browser with a profile in `folder`; returns its output and the page's console
    /// messages.
    fn run(&self, folder: &Path, arguments: &[&str], page: &Path) -> (String, Vec<String>) {
        let mut command = Command::new(&self.program);
        let (out, err) = (folder.join("out.txt"), folder.join("err.txt"));
        let profile = folder.join("profile");
        let _ = fs::remove_dir_all(&profile);
        command
            .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic"])
            .args(["--no-first-run", "--disable-background-networking"])
            .args(["--disable-component-update", "--disable-sync", "--disable-dev-shm-usage"])
            .args(["--hide-scrollbars", "--enable-logging=stderr"])
            .arg(format!("--user-data-dir={}", profile.display()))
            .args(arguments)
            .arg(format!("file://{}", page.display()))
            .stdin(Stdio::null())
            .stdout(File::create(&out).unwrap())
            .stderr(File::create(&err).unwrap());
        let mut child = command.spawn().unwrap_or_else(|error| panic!("{command:?}: {error}"));
        let begun = Instant::now();
        let status = loop {
            match child.try_wait().unwrap() {
                Some(status) => break status,
                None if begun.elapsed() > PATIENCE => {
                    let _ = child.kill();
                    let _ = child.wait();
                    panic!("the browser did not end within {PATIENCE:?}: {command:?}");
                }
                None => thread::sleep(Duration::from_millis(20)),
            }
        };
        let text = |path: &Path| String::from_utf8_lossy(&fs::read(path).unwrap()).into_owned();
        let log = text(&err);
        assert!(status.success(), "the browser failed, {status}: {command:?}\n{log}");
        // All other lines of the log are about the browser and the machine.
        let console = log.lines().filter(|line| line.contains(":CONSOLE")).map(str::to_owned);
        (text(&out), console.collect())
    }

    /// Writes screenshots of a page to `target/browser` and returns the defects of the page.
    pub(crate) fn defects(&self, name: &str, html: &str, script: Option<&str>) -> Vec<String> {
        let tmp = Path::new(env!("CARGO_TARGET_TMPDIR"));
        let folder = tmp.join(format!("browser-{name}"));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        let pictures = tmp.parent().unwrap().join("browser");
        fs::create_dir_all(&pictures).unwrap();

        let mut defects = Vec::new();
        if html.len() as u64 > LARGEST {
            defects.push(format!("it has {} bytes", html.len()));
        }
        let frames = frames(&WIDTHS, 800, html);
        let measure = folder.join("measure.html");
        // The content security policy of the page also applies to the frame.
        let source = script.map_or(String::new(), stiction_draw::page::source_of);
        let text = include_str!("measure.html")
            .replace("'nonce-measure'", &format!("'nonce-measure' {source}"));
        fs::write(&measure, text.replace("<!--FRAMES-->", &frames)).unwrap();
        let mut heights = Vec::new();
        for is_dark in [false, true] {
            let window = "--window-size=1300,1700";
            let (out, console) =
                self.run(&folder, &[scheme(is_dark), window, "--dump-dom"], &measure);
            let measured = read(&out);
            for (width, values) in WIDTHS.iter().zip(&measured) {
                let what = format!("{width} px, {}", if is_dark { "dark" } else { "light" });
                assert_eq!(values["is_dark"], is_dark, "the browser does as it is told");
                assert_eq!(values["width"], *width);
                defects.extend(judge(values).into_iter().map(|defect| format!("{what}: {defect}")));
                heights.push(values["height"].as_u64().unwrap().min(LONGEST));
            }
            defects.extend(console);
        }

        let page = folder.join("page.html");
        fs::write(&page, html).unwrap();
        // Browser windows are never as narrow as a phone, so the page is shown in a frame.
        let phone = folder.join("phone.html");
        let head = "<!DOCTYPE html><meta charset=\"utf-8\"/><meta name=\"color-scheme\" \
                    content=\"light dark\"/><style>body{margin:0}iframe{display:block;border:0}</style>";
        fs::write(&phone, format!("{head}{}", self::frames(&WIDTHS[..1], heights[0], html)))
            .unwrap();
        let views = [
            ("desktop", &page, false, WIDTHS[1], heights[1]),
            ("dark", &page, true, WIDTHS[1], heights[3]),
            ("phone", &phone, false, 500, heights[0]),
        ];
        for (view, page, is_dark, width, height) in views {
            let file = pictures.join(format!("{name}-{view}.png"));
            let shot = format!("--screenshot={}", file.display());
            let window = format!("--window-size={width},{height}");
            let (_, console) = self.run(&folder, &[scheme(is_dark), &window, &shot], page);
            defects.extend(console);
            defects.extend(misfit(&file, b"\x89PNG"));
        }
        let file = pictures.join(format!("{name}-print.pdf"));
        let print = format!("--print-to-pdf={}", file.display());
        self.run(&folder, &[scheme(true), "--no-pdf-header-footer", &print], &page);
        defects.extend(misfit(&file, b"%PDF"));
        defects
    }
}

/// Option for the preferred colour scheme.
fn scheme(is_dark: bool) -> &'static str {
    if is_dark {
        "--blink-settings=preferredColorScheme=0"
    } else {
        "--blink-settings=preferredColorScheme=1"
    }
}

/// Page that shows the given page in frames of these widths.
fn frames(widths: &[u32], height: u64, html: &str) -> String {
    let inner = html.replace('&', "&amp;").replace('"', "&quot;");
    let frame = |width: &u32| {
        format!("<iframe width=\"{width}\" height=\"{height}\" srcdoc=\"{inner}\"></iframe>\n")
    };
    widths.iter().map(frame).collect()
}

/// Parses the measurements in the rendered page.
fn read(dom: &str) -> Vec<Value> {
    let inner =
        dom.split_once("<pre id=\"measured\">").and_then(|(_, rest)| rest.split_once("</pre>"));
    let (json, _) = inner.unwrap_or_else(|| panic!("nothing was measured:\n{dom}"));
    let json = json.replace("&lt;", "<").replace("&gt;", ">").replace("&nbsp;", "\u{a0}");
    serde_json::from_str(&json.replace("&amp;", "&"))
        .unwrap_or_else(|error| panic!("{error}\n{json}"))
}

/// Defects according to the measurements at one width.
fn judge(values: &Value) -> Vec<String> {
    let mut defects = Vec::new();
    let number = |value: &Value| value.as_f64().unwrap_or_else(|| panic!("{value} in {values}"));
    if values["scroll_width"].as_u64() > values["width"].as_u64() {
        defects.push(format!("the page is {} px wide", values["scroll_width"]));
    }
    if number(&values["texts"]) < 3.0 {
        defects.push("there is no text".into());
        return defects;
    }
    // WCAG 2.2, success criteria 1.4.3 and 1.4.11.
    if number(&values["contrast"]["contrast"]) < 4.5 {
        defects.push(format!("text that can hardly be read: {}", values["contrast"]));
    }
    // About 1.6 mm high on a phone, where plots may be enlarged with two fingers.
    if number(&values["size"]["size"]) < 7.0 {
        defects.push(format!("text that is too small: {}", values["size"]));
    }
    for (k, picture) in values["pictures"].as_array().unwrap().iter().enumerate() {
        let is_there = number(&picture["width"]) > 100.0 && number(&picture["height"]) > 40.0;
        if !is_there || number(&picture["drawn"]) < 1.0 {
            defects.push(format!("picture {k} is not there: {picture}"));
        }
        if number(&picture["line_contrast"]) < 3.0 {
            defects.push(format!("picture {k} has lines that can hardly be seen: {picture}"));
        }
    }
    for what in ["cut", "requests"] {
        if values[what].as_array().is_none_or(|list| !list.is_empty()) {
            defects.push(format!("{what}: {}", values[what]));
        }
    }
    defects
}

/// Message about a file of the wrong type or size; `None` for a valid file.
fn misfit(file: &Path, begin: &[u8]) -> Option<String> {
    let bytes = fs::read(file).unwrap_or_default();
    let size = bytes.len() as u64;
    let is_good = bytes.starts_with(begin) && size > 4000 && size < LARGEST;
    (!is_good).then(|| format!("{} has {size} bytes", file.display()))
}
