//! The reference of the model file is generated from its schema.

use crate::{book, renewed};
use serde_json::{Map, Value};
use std::fmt::Write;
use std::fs;

/// Text before the tables.
const HEAD: &str = "\
# All keys of the model file

<!-- Generated from the schema: `cargo xtask book` writes this page. -->

This page is generated from the schema that `stiction schema` prints, and lists every key. The page
[The model file](model-file.md) explains how the keys belong together and gives examples. A *quantity* is a number in
the unit of the column, or a string with units and formulas, see [quantities](model-file.md#quantities). **Bold** keys
are required. An arrow → marks a key that is a table; the section of that name lists its keys.

";

/// Sections in order: the heading, and the location of the table in the schema.
const SECTIONS: &[(&str, &str)] = &[
    ("The file", ""),
    ("Pose", "/$defs/pose"),
    ("Body", "/properties/bodies/additionalProperties"),
    ("Visual", "/properties/bodies/additionalProperties/properties/visual/items"),
    ("Joint", "/properties/joints/additionalProperties"),
    ("Friction", "/properties/joints/additionalProperties/properties/friction"),
    (
        "Friction backward",
        "/properties/joints/additionalProperties/properties/friction/properties/backward",
    ),
    (
        "Friction interface",
        "/properties/joints/additionalProperties/properties/friction/properties/first",
    ),
    ("Compliance", "/properties/joints/additionalProperties/properties/compliance"),
    ("Spring", "/properties/springs/additionalProperties"),
    ("Bushing", "/properties/bushings/additionalProperties"),
    ("Actuator", "/properties/actuators/additionalProperties"),
    ("Rotor axis", "/properties/actuators/additionalProperties/properties/rotor_axis"),
    ("Mesh", "/properties/actuators/additionalProperties/properties/mesh"),
    ("Motor friction", "/properties/actuators/additionalProperties/properties/motor_friction"),
    ("Motor limits", "/properties/actuators/additionalProperties/properties/limits"),
    ("Gearing", "/properties/gearings/additionalProperties"),
    ("Legs", "/properties/legs/anyOf/0"),
    ("Place of a leg", "/properties/legs/anyOf/0/properties/place/items"),
    ("Joint of a leg", "/properties/legs/anyOf/0/properties/joints/additionalProperties"),
    ("Actuator of a leg", "/properties/legs/anyOf/0/properties/actuators/additionalProperties"),
    ("Motion", "/properties/motions/additionalProperties"),
    ("Waypoint", "/properties/motions/additionalProperties/properties/waypoints/items"),
    ("Limits", "/$defs/limits"),
    ("Load", "/properties/loads/additionalProperties"),
    ("Load on a body", "/$defs/load"),
    ("Payload", "/properties/loads/additionalProperties/properties/payload/items"),
    ("Default", "/properties/default"),
];

/// Keys of a table in the schema; they identify the table.
fn keys(table: &Value) -> Option<&Map<String, Value>> {
    table.get("properties").and_then(Value::as_object).filter(|keys| !keys.contains_key("xx"))
}

/// Finds the section of a table from the table's keys.
fn section(schema: &Value, table: &Value) -> Option<&'static str> {
    let own = keys(table)?;
    let same = |path: &str| schema.pointer(path).and_then(keys) == Some(own);
    SECTIONS.iter().find(|(_, path)| same(path)).map(|(heading, _)| *heading)
}

/// Link to the section of a table.
fn link(heading: &str) -> String {
    format!("→ [{heading}](#{})", heading.to_lowercase().replace(' ', "-"))
}

/// Description of the values of a key.
fn kind(schema: &Value, value: &Value) -> String {
    if let Some(heading) = section(schema, value) {
        return link(heading);
    }
    if let Some(name) = value["$ref"].as_str() {
        return match name.trim_start_matches("#/$defs/") {
            "pose" => link("Pose"),
            "load" => link("Load on a body"),
            "limits" => link("Limits"),
            other => other.to_owned(),
        };
    }
    if let Some(words) = value["enum"].as_array() {
        let words: Vec<_> =
            words.iter().filter_map(Value::as_str).map(|w| format!("`{w}`")).collect();
        return words.join(", ");
    }
    if let Some(forms) = value["anyOf"].as_array() {
        let forms: Vec<_> = forms.iter().map(|form| kind(schema, form)).collect();
        return forms.join(", or ");
    }
    match value["type"].as_str() {
        Some("string") => "text".into(),
        Some("boolean") => "`true`, `false`".into(),
        Some("array") => format!("list of: {}", kind(schema, &value["items"])),
        Some("object") => format!("by name: {}", kind(schema, &value["additionalProperties"])),
        other => panic!("{other:?} of {value}"),
    }
}

/// Writes a section: one row per key with kind, unit, requirement, and meaning.
fn table(page: &mut String, schema: &Value, heading: &str, path: &str) {
    let table = schema.pointer(path).unwrap_or_else(|| panic!("{path}"));
    let properties = keys(table).unwrap_or_else(|| panic!("{path} is no table"));
    let required: Vec<_> = table["required"].as_array().into_iter().flatten().collect();
    let _ = writeln!(page, "## {heading}\n");
    let _ = writeln!(
        page,
        "| key | value | unit | meaning | without it |\n| --- | --- | --- | --- | --- |"
    );
    for (key, value) in properties {
        let text = value["description"].as_str().unwrap_or_else(|| panic!("{path}/{key}"));
        let (text, unit) = text.split_once(" Bare numbers are in ").unwrap_or((text, ""));
        let (meaning, absent) = default(text);
        let mark = if required.iter().any(|name| *name == key) { "**" } else { "" };
        let absent = if mark.is_empty() { absent } else { "an error".into() };
        let kind = kind(schema, value);
        let _ = writeln!(
            page,
            "| {mark}`{key}`{mark} | {kind} | {} | {} | {absent} |",
            unit.trim_end_matches('.').replace("^2", "²"),
            meaning.replace('|', "\\|"),
        );
    }
    let others = &table["additionalProperties"];
    if others.is_object() {
        let _ = match others["$ref"].as_str() {
            Some("#/$defs/coordinates") => writeln!(
                page,
                "\nAny other key is a coordinate: that of a joint, or the name of a body followed by one of \
                 `{}`. Its value is a quantity that can contain the time `t`.",
                table["$comment"]
                    .as_str()
                    .unwrap()
                    .trim_start_matches("after the name of a body: ")
            ),
            Some("#/$defs/waypoint") => writeln!(
                page,
                "\nAny other key is a coordinate as in a motion, but constant, or the `rotation` of a body."
            ),
            _ if heading == "Load" => {
                writeln!(page, "\nAny other key is the name of a body: {}.", link("Load on a body"))
            }
            _ => writeln!(
                page,
                "\nA dot in a name separates nested tables: any other key is a part of a name."
            ),
        };
    }
    page.push('\n');
}

/// Splits a description into the meaning and the default of a missing key.
fn default(text: &str) -> (String, String) {
    let found = text.find("; by default ").map(|at| (at, at + 2));
    let Some((end, start)) = found.or_else(|| text.find(" By default ").map(|at| (at, at + 1)))
    else {
        return (text.into(), String::new());
    };
    let stop = text[start..].find([';', '.']).map_or(text.len(), |length| start + length);
    // A point within a number does not end the sentence.
    let said = text[start + "by default ".len()..stop].trim();
    let rest = text[stop..].trim_start_matches(['.', ';']).trim();
    let mut meaning = text[..end].trim_end_matches(['.', ';']).to_owned() + ".";
    if !rest.is_empty() {
        let mut signs = rest.chars();
        let first = signs.next().into_iter().flat_map(char::to_uppercase);
        meaning.push(' ');
        meaning.extend(first.chain(signs));
    }
    (meaning, said.into())
}

#[test]
fn the_reference_is_that_of_the_schema() {
    let schema = stiction_format::json_schema();
    let mut page = HEAD.to_owned();
    for (heading, path) in SECTIONS {
        table(&mut page, &schema, heading, path);
    }
    page.push_str(
        "## Other values\n\n| value | is |\n| --- | --- |\n\
         | quantity | a number in SI units, or an expression with units |\n\
         | vector | a list of three quantities |\n",
    );
    let names = |path: &str| {
        let words = schema.pointer(path).and_then(Value::as_array).unwrap();
        words.iter().filter_map(Value::as_str).map(|w| format!("`\"{w}\"`")).collect::<Vec<_>>()
    };
    let orders: Vec<String> = schema["$defs"]["rotation"]["anyOf"].as_array().unwrap()[1..]
        .iter()
        .flat_map(|form| keys(form).unwrap().keys().map(|order| format!("`{order}`")))
        .collect();
    let inertia = schema["$defs"]["inertia"]["anyOf"][1]["properties"].as_object().unwrap();
    let entries: Vec<String> = inertia.keys().map(|entry| format!("`{entry}`")).collect();
    let _ =
        writeln!(page, "| axis | {}, or a vector |", names("/$defs/axis/anyOf/0/enum").join(", "));
    let _ = writeln!(
        page,
        "| rotation | `{{ axis, angle }}`, or intrinsic angles as a list of three under one of the keys {} |",
        orders.join(" ")
    );
    let _ = writeln!(
        page,
        "| inertia | a list of three moments `[xx, yy, zz]`, or a table of {} in kg m² |",
        entries.join(" ")
    );
    let path = book().join("model-reference.md");
    if renewed() {
        fs::write(&path, &page).unwrap();
    }
    let known = fs::read_to_string(&path).unwrap_or_default();
    assert!(known == page, "model-reference.md is out of date: `cargo xtask book` renews it");
}

/// Checks that every table of the schema has a section.
#[test]
fn no_table_is_left_out() {
    fn walk(schema: &Value, value: &Value, path: &str, lost: &mut Vec<String>) {
        let is_rotation = path.contains("rotation") || path.contains("inertia");
        if keys(value).is_some() && section(schema, value).is_none() && !is_rotation {
            lost.push(path.to_owned());
        }
        match value {
            Value::Object(entries) => {
                for (key, inner) in entries {
                    walk(schema, inner, &format!("{path}/{key}"), lost);
                }
            }
            Value::Array(list) => {
                for (k, inner) in list.iter().enumerate() {
                    walk(schema, inner, &format!("{path}/{k}"), lost);
                }
            }
            _ => {}
        }
    }
    let schema = stiction_format::json_schema();
    let mut lost = Vec::new();
    walk(&schema, &schema, "", &mut lost);
    assert!(lost.is_empty(), "{lost:?}");
}
