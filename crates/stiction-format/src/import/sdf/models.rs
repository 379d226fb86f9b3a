//! Finds the models of an SDF file, including nested and included ones, as a flat list.

use super::super::context::Context;
use super::super::xml::{self, Element};
use crate::diagnostic::quoted;

/// Maximum number of models; it stops the search if files include each other.
const MOST: usize = 1000;

/// SDF model, or the world with its own joints and frames.
#[derive(Debug)]
pub(super) struct Model {
    pub(super) element: Element,
    /// Prefix of the names of the model's parts: `arm::` for parts of a nested model.
    pub(super) prefix: String,
    /// Prefix of the names of the parts of the enclosing model or world.
    pub(super) outer: String,
    /// Full name of the frame of the enclosing model; `None` for models that no model encloses.
    pub(super) around: Option<String>,
    /// Version of the format: major and minor number.
    pub(super) version: (u32, u32),
    pub(super) is_static: bool,
    /// True if the model is merged into the enclosing model, so that its parts belong to the
    /// enclosing model.
    pub(super) merged: bool,
    /// True for the world itself, which may have joints and frames of its own.
    pub(super) is_world: bool,
}

/// Name by which the parts of a model refer to the model's own frame.
const MODEL: &str = "__model__";

impl Model {
    /// Full name of the model's own frame. A model that is merged into another model keeps a
    /// separate frame.
    pub(super) fn own_frame(&self) -> String {
        if self.is_world {
            return "world".to_owned();
        }
        match self.merged {
            true => {
                let name = self.element.get("name").unwrap_or_default();
                format!("{}_merged__{name}{MODEL}", self.prefix)
            }
            false => self.full(MODEL),
        }
    }

    /// Full name of a frame, from its name within the enclosing model; `None` for the world.
    pub(super) fn outer_frame(&self, name: &str) -> Option<String> {
        match name {
            "world" | "__root__" => None,
            MODEL => self.around.clone(),
            _ => Some(format!("{}{name}", self.outer)),
        }
    }

    /// Full name of a frame, from its name within the model.
    pub(super) fn frame(&self, name: &str) -> String {
        match name {
            "world" | "__root__" => "world".to_owned(),
            MODEL => self.own_frame(),
            _ => self.full(name),
        }
    }

    /// Full name of a part: the prefix and its name in the model.
    pub(super) fn full(&self, name: &str) -> String {
        format!("{}{name}", self.prefix)
    }
}

/// Result of the search: the robot's name and its models.
pub(super) struct Found {
    pub(super) name: String,
    pub(super) models: Vec<Model>,
}

fn version_of(root: &Element) -> (u32, u32) {
    let text = root.get("version").unwrap_or("1.11");
    let mut numbers = text.split('.').map(|number| number.parse().ok());
    match (numbers.next().flatten(), numbers.next().flatten()) {
        (Some(major), Some(minor)) => (major, minor),
        _ => (1, 11),
    }
}

/// A model whose parts have not yet been listed.
struct Pending {
    element: Element,
    outer: String,
    around: Option<String>,
    version: (u32, u32),
    /// True for the only model of a file, whose name is omitted from the names of its parts.
    alone: bool,
    held: bool,
    merged: bool,
}

pub(super) fn read(context: &Context<'_>, root: &Element) -> Option<Found> {
    let version = version_of(root);
    let worlds: Vec<&Element> = root.all("world").collect();
    if let [_, second, ..] = worlds.as_slice() {
        context.note("only the first world of the file is read", Some(second.place()));
    }
    let around = worlds.first().copied().unwrap_or(root);
    let is_model = |child: &&Element| matches!(child.tag.as_str(), "model" | "include");
    let top = around.children.iter().filter(is_model);
    let top: Vec<&Element> = top.filter(|element| !is_scenery(context, element)).collect();
    if top.is_empty() {
        let message = "the file has no model".to_owned();
        context.error("missing", message, &root.place(), "an SDF file has <model> elements");
        return None;
    }
    let is_own = |child: &&Element| matches!(child.tag.as_str(), "joint" | "frame");
    let has_own = around.tag == "world" && around.children.iter().any(|child| is_own(&child));
    let name = top.first().and_then(|model| model.get("name")).unwrap_or("robot").to_owned();
    let name = match top.len() {
        1 => name,
        _ => around.get("name").unwrap_or("world").to_owned(),
    };
    // Joints of the world refer to parts by names that contain the name of the model.
    let alone = top.len() == 1 && !has_own;
    let mut open: Vec<Pending> = Vec::new();
    for element in top {
        let outer = (String::new(), None, version, alone, false);
        open.extend(pending(context, element, outer));
    }
    open.reverse();
    let mut models = Vec::new();
    if has_own {
        let mut element = around.clone();
        element.children.retain(|child| is_own(&child));
        models.push(Model {
            element,
            prefix: String::new(),
            outer: String::new(),
            around: None,
            version,
            is_static: false,
            merged: false,
            is_world: true,
        });
    }
    while let Some(pending) = open.pop() {
        if models.len() >= MOST {
            let message = format!("the file has or includes more than {MOST} models");
            context.error(
                "sdf",
                message,
                &pending.element.place(),
                "make sure that no model includes itself",
            );
            return None;
        }
        let model = model(context, pending)?;
        let inner = model.element.children.iter().filter(is_model);
        let around = Some(model.own_frame());
        let outer =
            || (model.prefix.clone(), around.clone(), model.version, false, model.is_static);
        let inner: Vec<Pending> =
            inner.filter_map(|element| self::pending(context, element, outer())).collect();
        open.extend(inner.into_iter().rev());
        models.push(model);
    }
    Some(Found { name, models })
}

type Outer = (String, Option<String>, (u32, u32), bool, bool);

/// Models of Gazebo's library that are in nearly every world and have no moving part.
const SCENERY: [&str; 2] = ["model://sun", "model://ground_plane"];

/// Tests if an element includes a model of the scenery. Reports that such a model is omitted
/// because it has no moving part.
fn is_scenery(context: &Context<'_>, element: &Element) -> bool {
    let uri = element.child("uri").map_or("", |uri| uri.text.trim_end_matches('/'));
    let is_scenery = element.tag == "include" && SCENERY.contains(&uri);
    if is_scenery {
        let message = format!("{} is left out: it has no moving part", quoted(uri));
        context.note(message, Some(element.place()));
    }
    is_scenery
}

/// Creates the pending entry for a model of the file, or for the model of an included file.
fn pending(context: &Context<'_>, element: &Element, outer: Outer) -> Option<Pending> {
    let (outer, around, version, alone, held) = outer;
    if element.tag == "model" {
        let element = element.clone();
        return Some(Pending { element, outer, around, version, alone, held, merged: false });
    }
    let uri = element.child("uri").map(|uri| uri.text.clone()).unwrap_or_default();
    let path = uri.strip_prefix("file://").unwrap_or(&uri).trim_end_matches('/').to_owned();
    let tried = match path.ends_with(".sdf") || path.ends_with(".xml") {
        true => vec![path.clone()],
        false => vec![format!("{path}/model.sdf"), format!("{path}/{}.sdf", last(&path))],
    };
    let Some(source) = tried.iter().find_map(|path| context.text(path).ok()) else {
        let message = format!("cannot read the included model {}", quoted(&uri));
        let help = "name the folder of the models with --package-path";
        context.error("include", message, &element.place(), help);
        return None;
    };
    let root = match xml::parse(&source) {
        Ok(root) => root,
        Err(error) => {
            context.append(error);
            return None;
        }
    };
    let Some(model) = root.child("model") else {
        let message = format!("the included file {} has no model", quoted(&uri));
        context.error("include", message, &element.place(), "");
        return None;
    };
    let mut model = model.clone();
    // Child elements of `include` take precedence over those of the included model.
    for tag in ["pose", "static", "placement_frame"] {
        if let Some(own) = element.child(tag) {
            model.children.retain(|child| child.tag != tag);
            model.children.push(own.clone());
        }
    }
    if let Some(name) = element.child("name")
        && let Some(attribute) = model.attributes.iter_mut().find(|known| known.name == "name")
    {
        attribute.value.clone_from(&name.text);
    }
    let merged = matches!(element.get("merge"), Some("true" | "1"));
    let version = version_of(&root);
    Some(Pending { element: model, outer, around, version, alone, held, merged })
}

fn last(path: &str) -> &str {
    path.rsplit('/').next().unwrap_or(path)
}

fn model(context: &Context<'_>, pending: Pending) -> Option<Model> {
    let Pending { element, outer, around, version, alone, held, merged } = pending;
    let name = element.required(context, "name")?.to_owned();
    let is_true = |child: &Element| matches!(child.text.as_str(), "true" | "1");
    let is_static = held || element.child("static").is_some_and(is_true);
    let prefix = match alone || merged {
        true => outer.clone(),
        false => format!("{outer}{name}::"),
    };
    Some(Model { element, prefix, outer, around, version, is_static, merged, is_world: false })
}
