//! Answers to the requests that the page of the playground sends to the engine.
//!
//! A request is a JSON object with `command`. All commands except `gallery` also need the `name`
//! and the `text` of a model, and accept `changes` of single values (`"mu = 0.2"`) and `meshes`,
//! files that the model names (`["tool.stl", CONTENT]`, the content in base 64). The answer is
//! `{"ok": …}`, or `{"error": …}` with the content of [`stiction::Error::to_json`].

use crate::values::numeric_values;
use base64::prelude::{BASE64_STANDARD, Engine as _};
use serde_json::{Value, json};
use stiction::{Error, FrictionMode, ModelParts, ModelText, Robot};

/// Progress callback, which receives the number of steps done and the total number of steps.
pub(crate) type Progress<'a> = &'a mut dyn FnMut(u32, u32);

/// Answers one request. The request and the answer are JSON texts.
///
/// ```
/// let text = stiction_playground::answer(r#"{"command": "gallery"}"#, &mut |_, _| {});
/// assert!(text.contains("five-bar"));
/// ```
pub fn answer(request: &str, progress: Progress<'_>) -> String {
    let found = serde_json::from_str::<Value>(request)
        .map_err(|why| Error::input(format!("the request is not JSON: {why}")))
        .and_then(|request| result(&request, progress));
    match found {
        Ok(found) => json!({ "ok": found }),
        Err(error) => json!({ "error": error.to_json() }),
    }
    .to_string()
}

fn result(request: &Value, progress: Progress<'_>) -> Result<Value, Error> {
    match text_of(request, "command").unwrap_or_default() {
        "gallery" => gallery(),
        "read" => describe(&model(request)?.read()?),
        "check" => check(&model(request)?.read()?, request, progress),
        "inverse" => inverse(&model(request)?.read()?, request, progress),
        "forward" => forward(&model(request)?.read()?, request, progress),
        other => Err(Error::input(format!("unknown command `{other}`"))
            .with_help("use one of gallery, read, check, inverse, forward")),
    }
}

/// Text value of a key of a request; `None` if the key is absent, or its value is empty or not a
/// text.
fn text_of<'a>(request: &'a Value, key: &str) -> Option<&'a str> {
    request[key].as_str().filter(|text| !text.is_empty())
}

fn model(request: &Value) -> Result<ModelText, Error> {
    let text = request["text"].as_str().ok_or_else(|| Error::input("the request has no `text`"))?;
    let changes = request["changes"].as_array().map_or(&[][..], Vec::as_slice);
    let model = ModelText::from_parts(ModelParts {
        name: format!("{}.toml", text_of(request, "name").unwrap_or("model")),
        text: text.to_owned(),
        folder: None,
        changes: Vec::new(),
        filter: None,
    });
    let model = changes.iter().filter_map(Value::as_str).fold(model, ModelText::with);
    Ok(model.with_meshes(mesh_files(request)?))
}

/// Reads the names and contents of the mesh files of a request.
fn mesh_files(request: &Value) -> Result<Vec<(String, Vec<u8>)>, Error> {
    let file = |file: &Value| {
        let (name, content) = (file[0].as_str()?, file[1].as_str()?);
        Some((name.to_owned(), BASE64_STANDARD.decode(content).ok()?))
    };
    let files = request["meshes"].as_array().into_iter().flatten().map(file);
    files
        .collect::<Option<_>>()
        .ok_or_else(|| Error::input("`meshes` must contain names with contents in base 64"))
}

fn gallery() -> Result<Value, Error> {
    let models = stiction::format::gallery::names().map(|name| {
        let text = ModelText::builtin(name)?;
        let title = text.clone().read()?.title().to_owned();
        Ok(json!({ "name": name, "title": title, "text": text.as_text() }))
    });
    models.collect()
}

fn describe(robot: &Robot) -> Result<Value, Error> {
    let (motion, load) = robot.defaults();
    let text = robot.text().map(ModelText::as_text).unwrap_or_default();
    Ok(json!({
        "name": robot.name(),
        "title": robot.title(),
        "motions": robot.motions().collect::<Vec<_>>(),
        "loads": robot.loads().collect::<Vec<_>>(),
        "default_motion": motion,
        "default_load": load,
        "values": numeric_values(text),
        "meshes": meshes(robot),
        "warnings": robot.warnings().to_json(),
    }))
}

/// Lists the mesh files of the model, each as a pair of its name and a flag that is true if the
/// mesh was read.
fn meshes(robot: &Robot) -> Vec<Value> {
    let mut names: Vec<(&str, bool)> = Vec::new();
    for visual in &robot.model().visuals {
        let entry = (visual.file.as_str(), visual.mesh.is_some());
        if !names.contains(&entry) {
            names.push(entry);
        }
    }
    names.into_iter().map(|(name, is_shown)| json!([name, is_shown])).collect()
}

fn check(robot: &Robot, request: &Value, progress: Progress<'_>) -> Result<Value, Error> {
    let mut check = robot.check_along();
    if let Some(motion) = text_of(request, "motion") {
        check = check.motion(motion)?;
    }
    let found = check.run_with(|_phase, done, of| goes_on(progress, done, of))?;
    // If the robot cannot be drawn along the motion, the answer contains the results of the check
    // without a page.
    let page = check
        .job()
        .and_then(|job| Ok(stiction::run::check::draw_page(&job, found.findings(), None)?.html));
    Ok(json!({ "text": found.as_text(), "summary": found.to_json(), "page": page.ok() }))
}

fn inverse(robot: &Robot, request: &Value, progress: Progress<'_>) -> Result<Value, Error> {
    let mut inverse = robot.inverse();
    if let Some(motion) = text_of(request, "motion") {
        inverse = inverse.motion(motion)?;
    }
    if let Some(load) = text_of(request, "load") {
        inverse = inverse.load(load)?;
    }
    if let Some(is_on) = request["friction"].as_bool() {
        inverse = inverse.friction(if is_on { FrictionMode::Converged } else { FrictionMode::Off });
    }
    let report = inverse.report(|phase, done, of| {
        let before = if phase == stiction::run::inverse::Phase::Motion { 0 } else { of };
        goes_on(progress, before + done, 2 * of)
    })?;
    Ok(json!({ "text": report.text, "summary": report.summary, "page": report.page }))
}

fn forward(robot: &Robot, request: &Value, progress: Progress<'_>) -> Result<Value, Error> {
    let mut forward = robot.forward();
    if let Some(motion) = text_of(request, "motion") {
        forward = forward.motion(motion)?;
    }
    if let Some(load) = text_of(request, "load") {
        forward = forward.load(load)?;
    }
    if let Some(is_on) = request["friction"].as_bool() {
        forward = forward.friction(is_on);
    }
    if let Some(start) = text_of(request, "from") {
        forward = forward.from(start)?;
    }
    if let Some(until) = request["until"].as_f64() {
        forward = forward.until(until);
    }
    let progress = std::cell::RefCell::new(progress);
    let report =
        forward.plan()?.report(|done, of| goes_on(&mut **progress.borrow_mut(), done, of))?;
    let ended = report.ended.err().map(|error| error.to_json());
    Ok(
        json!({ "text": report.text, "summary": report.summary, "page": report.page, "ended": ended }),
    )
}

/// Reports progress. Always returns `true`, so that the computation continues: the page stops a
/// computation by terminating the worker that runs this module.
fn goes_on(progress: Progress<'_>, done: usize, of: usize) -> bool {
    let part = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
    progress(part(done), part(of));
    true
}
