//! The JSON schema accepts the files that the reader accepts, and contains all keys.

use serde_json::{Value, json};
use stiction_format::{gallery, json_schema};

fn validator() -> jsonschema::Validator {
    let schema = json_schema();
    assert!(jsonschema::meta::is_valid(&schema));
    jsonschema::draft202012::new(&schema).unwrap()
}

fn document(toml: &str) -> Value {
    toml::from_str(toml).unwrap()
}

#[test]
fn the_gallery_is_valid() {
    let validator = validator();
    for name in gallery::names() {
        let document = document(gallery::get(name).unwrap());
        let errors: Vec<_> = validator.iter_errors(&document).map(|e| e.to_string()).collect();
        assert!(errors.is_empty(), "{name}: {errors:?}");
    }
}

#[test]
fn unknown_keys_and_wrong_types_are_not() {
    let validator = validator();
    let base = document(gallery::get("3rps").unwrap());
    let mut wrong = Vec::new();
    for (place, key, value) in [
        ("", "gravty", json!([0, 0, 0])),
        ("/bodies/platform", "masss", json!(1)),
        ("/bodies/platform", "mass", json!(true)),
        ("/bodies/platform", "com", json!([0, 0])),
        ("/bodies/platform", "inertia", json!({ "xw": 1 })),
        ("/bodies/platform/home", "rotation", json!({ "axis": "z" })),
        ("", "bushings", json!({ "s": { "from": "ground" } })),
        ("", "springs", json!({ "s": { "from": "ground", "to": "platform", "lenght": 1 } })),
        ("/legs", "angels", json!([0])),
        ("/legs", "place", json!([{ "angel": 0 }])),
        ("/legs/joints/R", "type", json!("R")),
        ("/legs/joints/R", "axis", json!("w")),
        ("/legs/joints/R/friction", "my", json!(0.1)),
        ("/loads/reference/platform", "axes", json!("platform")),
        ("/default", "friction", json!("maybe")),
        ("/motions/reference", "step", json!({})),
    ] {
        let mut document = base.clone();
        document.pointer_mut(place).unwrap()[key] = value;
        if validator.is_valid(&document) {
            wrong.push(format!("{place}/{key}"));
        }
    }
    assert!(wrong.is_empty(), "accepted: {wrong:?}");
    let mut missing = base.clone();
    missing.as_object_mut().unwrap().remove("gravity");
    assert!(!validator.is_valid(&missing));
}

/// Every key has a description in the schema.
#[test]
fn every_key_is_described() {
    fn walk(schema: &Value, path: &str, silent: &mut Vec<String>) {
        if let Some(properties) = schema.get("properties").and_then(Value::as_object) {
            for (key, property) in properties {
                let is_short = ["xx", "axis", "angle", "xyz"].contains(&key.as_str());
                let described = property.get("description").and_then(Value::as_str);
                if described.is_none_or(|text| !text.contains('.'))
                    && !path.contains("$defs")
                    && !is_short
                {
                    silent.push(format!("{path}/{key}"));
                }
            }
        }
        match schema {
            Value::Object(object) => {
                for (key, value) in object {
                    walk(value, &format!("{path}/{key}"), silent);
                }
            }
            Value::Array(list) => list.iter().for_each(|value| walk(value, path, silent)),
            _ => {}
        }
    }
    let mut silent = Vec::new();
    walk(&json_schema(), "", &mut silent);
    assert!(silent.is_empty(), "{silent:?}");
}
