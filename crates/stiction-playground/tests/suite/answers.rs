//! Answers to requests, outside a browser.

use base64::prelude::{BASE64_STANDARD, Engine as _};
use serde_json::{Value, json};
use stiction::Robot;
use stiction_playground::{Engine, answer, page};

fn asked(request: &Value) -> Value {
    serde_json::from_str(&answer(&request.to_string(), &mut |_, _| {})).unwrap()
}

fn text(name: &str) -> String {
    Robot::builtin(name).unwrap().text().unwrap().as_text().to_owned()
}

#[test]
fn every_robot_of_the_gallery_is_read() {
    let gallery = asked(&json!({ "command": "gallery" }));
    let models = gallery["ok"].as_array().unwrap();
    assert!(models.len() > 10);
    for model in models {
        let read = asked(&json!({ "command": "read", "text": model["text"] }));
        assert!(read["error"].is_null(), "{}: {read}", model["name"]);
        assert!(!read["ok"]["values"].as_array().unwrap().is_empty(), "{}", model["name"]);
    }
}

/// A changed slider has the same effect as the same change in the library.
#[test]
fn changes_of_values_act() {
    let change = "legs.joints.P.friction.mu = 0.3";
    let request = json!({
        "command": "inverse", "name": "3rps", "text": text("3rps"), "changes": [change], "friction": true,
    });
    let found = answer(&request.to_string(), &mut |_, _| {});
    let robot = Robot::builtin("3rps").unwrap().with(change).unwrap();
    let expected = robot
        .inverse()
        .friction(stiction::FrictionMode::Converged)
        .tabulate(|_, _, _| true)
        .unwrap();
    // As texts, because reading numbers rounds their last digits.
    let drives = format!("\"drives\":{}", expected.summary["drives"]);
    assert!(drives.len() > 1000 && found.contains(&drives));
    let found: Value = serde_json::from_str(&found).unwrap();
    assert_eq!(found["ok"]["text"], json!(expected.text));
    assert!(found["ok"]["page"].as_str().unwrap().starts_with("<!DOCTYPE html>"));
}

#[test]
fn defects_have_places() {
    let text = text("five-bar").replace("mass", "masss");
    let found = asked(&json!({ "command": "read", "text": text }));
    let first = &found["error"]["diagnostics"][0];
    assert_eq!(first["file"], "model.toml");
    let line = first["line"].as_u64().unwrap();
    let at = text.lines().position(|line| line.contains("masss")).unwrap() as u64 + 1;
    assert_eq!(line, at);
}

/// Mesh files of a request are assigned to the meshes of the model by the last component of their
/// paths.
#[test]
fn mesh_files_of_a_request_are_used() {
    let visual = "[bodies.tool]\nvisual = [{ mesh = 'parts/tool.obj' }, { mesh = 'plate.stl' }]";
    let text = text("five-bar").replacen("[bodies.tool]", visual, 1);
    let pyramid = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n";
    let files = json!([["tool.obj", BASE64_STANDARD.encode(pyramid)]]);
    let found = asked(&json!({ "command": "read", "text": text, "meshes": files }));
    let found = &found["ok"];
    assert_eq!(found["meshes"], json!([["parts/tool.obj", true], ["plate.stl", false]]), "{found}");
    let warnings = found["warnings"].as_array().unwrap();
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0]["message"].as_str().unwrap().contains("plate.stl"), "{warnings:?}");
    let bad = asked(&json!({ "command": "read", "text": text, "meshes": [["tool.obj", "?"]] }));
    assert!(bad["error"]["message"].as_str().unwrap().contains("base 64"), "{bad}");
}

#[test]
fn nonsense_is_answered() {
    for request in ["", "[]", "{}", "{\"command\": 3}", "\u{0}", "{\"command\": \"fly\"}"] {
        let found: Value = serde_json::from_str(&answer(request, &mut |_, _| {})).unwrap();
        assert!(found["error"]["message"].is_string(), "{request}: {found}");
    }
    let request = json!({ "command": "inverse", "text": text("3rps"), "motion": "palyoad" });
    let found = asked(&request);
    assert!(found["error"].to_string().contains("palyoad"), "{found}");
}

#[test]
fn progress_reaches_its_end() {
    let mut last = (0, 1);
    let request = json!({ "command": "inverse", "text": text("five-bar") });
    answer(&request.to_string(), &mut |done, of| last = (done, of));
    assert_eq!(last.0, last.1);
}

/// Markup in a model never appears as markup in a page.
#[test]
fn names_and_titles_are_no_markup() {
    let hostile = "</script><script>alert(1)</script><img src=x onerror=alert(1)>";
    let text = text("five-bar");
    let at = text.find("title = ").unwrap();
    let end = at + text[at..].find('\n').unwrap();
    let text = format!("{}title = '{hostile}'{}", &text[..at], &text[end..]);
    for command in ["inverse", "check"] {
        let found = asked(&json!({ "command": command, "text": text }));
        let page = found["ok"]["page"].as_str().unwrap();
        assert!(!page.contains("<script>alert"), "{command}");
        assert!(!page.contains("<img"), "{command}");
    }
}

#[test]
fn the_page_allows_its_own_scripts_only() {
    for (engine, connections) in [(Engine::Beside, "'self'"), (Engine::Inside(b"module"), "'none'")]
    {
        let page = page(engine, "shaded view").unwrap();
        let policy =
            page.split("Content-Security-Policy").nth(1).unwrap().split("/>").next().unwrap();
        assert!(policy.contains(&format!("connect-src {connections}")), "{policy}");
        let scripts = policy.split("script-src").nth(1).unwrap().split(';').next().unwrap();
        assert!(!scripts.contains("unsafe-inline"), "{scripts}");
        // The page itself, the reports, and their shaded view.
        assert_eq!(scripts.matches("sha256-").count(), 3, "{scripts}");
    }
}
