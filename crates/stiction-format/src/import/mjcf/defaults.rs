//! Default classes of MJCF, and included files.

use super::super::context::Context;
use super::super::xml::{self, Attribute, Element};
use super::settings::ORIENTATIONS;
use crate::diagnostic::quoted;
use std::collections::HashMap;

/// Tags of actuator elements, which all share the same default attributes.
pub(super) const ACTUATORS: [&str; 11] = [
    "general",
    "motor",
    "position",
    "velocity",
    "intvelocity",
    "damper",
    "cylinder",
    "muscle",
    "adhesion",
    "dcmotor",
    "plugin",
];
/// Maximum number of included files.
const MOST_INCLUDES: usize = 1000;

/// Replaces each `include` element by the content of its file.
///
/// Returns `None` after a message if a file is missing, is defective, or includes itself.
pub(super) fn include(context: &Context<'_>, root: &mut Element) -> Option<()> {
    let mut included = 0;
    let mut names: Vec<String> = Vec::new();
    // Elements are identified by their path, so that the tree can be changed.
    let mut open: Vec<Vec<usize>> = vec![Vec::new()];
    while let Some(path) = open.pop() {
        let mut element = &mut *root;
        for &index in &path {
            element = element.children.get_mut(index)?;
        }
        let mut index = 0;
        while index < element.children.len() {
            if element.children[index].tag != "include" {
                index += 1;
                continue;
            }
            let child = element.children.remove(index);
            let name = child.required(context, "file")?.to_owned();
            included += 1;
            let again = names.contains(&name);
            if again || included > MOST_INCLUDES {
                let message = format!("the file {} is included again", quoted(&name));
                let help = "MuJoCo allows each file to be included once";
                context.error("include", message, &child.place(), help);
                return None;
            }
            names.push(name.clone());
            let source = match context.text(&name) {
                Ok(source) => source,
                Err(why) => {
                    let message = format!("cannot read the included file {}: {why}", quoted(&name));
                    let help = "its path is relative to the folder of the main file";
                    context.error("include", message, &child.place(), help);
                    return None;
                }
            };
            let content = match xml::parse(&source) {
                Ok(content) => content,
                Err(error) => {
                    context.append(error);
                    return None;
                }
            };
            for (k, new) in content.children.into_iter().enumerate() {
                element.children.insert(index + k, new);
            }
        }
        for index in 0..element.children.len() {
            if !element.children[index].children.is_empty() {
                open.push(path.iter().copied().chain([index]).collect());
            }
        }
    }
    Some(())
}

/// Default attributes of one class of elements.
#[derive(Debug, Default)]
struct Class {
    parent: Option<String>,
    /// Default attributes by the tag of elements.
    attributes: HashMap<String, Vec<Attribute>>,
}

/// All default classes of an MJCF file.
#[derive(Debug, Default)]
pub(super) struct Defaults {
    classes: HashMap<String, Class>,
    main: String,
}

/// Name under which the default attributes of an element are stored. All actuators share their
/// defaults, and so do all tendons.
fn family(tag: &str) -> &str {
    match tag {
        "fixed" | "spatial" => "tendon",
        _ if ACTUATORS.contains(&tag) => "general",
        _ => tag,
    }
}

impl Defaults {
    pub(super) fn read(context: &Context<'_>, root: &Element) -> Self {
        let mut all = Self { main: "main".to_owned(), ..Self::default() };
        for (number, element) in root.all("default").enumerate() {
            let name = element.get("class").unwrap_or("main").to_owned();
            if number == 0 {
                all.main.clone_from(&name);
            }
            let mut open: Vec<(&Element, String, Option<String>)> = vec![(element, name, None)];
            while let Some((element, name, parent)) = open.pop() {
                let class = all.classes.entry(name.clone()).or_default();
                class.parent = parent;
                for child in &element.children {
                    if child.tag == "default" {
                        let Some(own) = child.required(context, "class") else { continue };
                        open.push((child, own.to_owned(), Some(name.clone())));
                    } else {
                        let own =
                            class.attributes.entry(family(&child.tag).to_owned()).or_default();
                        // A later element overrides an earlier one.
                        own.retain(|known| child.attribute(&known.name).is_none());
                        own.extend(child.attributes.iter().cloned());
                    }
                }
            }
        }
        all
    }

    /// Returns the element completed by the defaults of its class or, if it names no class, by
    /// those of the class `inherited` from the enclosing bodies.
    pub(super) fn applied(
        &self,
        context: &Context<'_>,
        element: &Element,
        inherited: Option<&str>,
    ) -> Element {
        self.of_family(context, element, (family(&element.tag), inherited))
    }

    /// Returns an equality constraint, whose tag may be `joint` or `tendon`, completed by the
    /// defaults of equality constraints.
    pub(super) fn equality(&self, context: &Context<'_>, element: &Element) -> Element {
        self.of_family(context, element, ("equality", None))
    }

    fn of_family(
        &self,
        context: &Context<'_>,
        element: &Element,
        (family, inherited): (&str, Option<&str>),
    ) -> Element {
        let mut applied = element.clone();
        let own = element.get("class");
        if let Some(name) = own
            && !self.classes.contains_key(name)
            && name != "main"
        {
            let message = format!("there is no defaults class {}", quoted(name));
            context.error("class", message, &element.place(), "");
        }
        let mut next = Some(own.or(inherited).unwrap_or(&self.main).to_owned());
        // Parents are defined by nesting, so there are no cycles unless a class is defined twice.
        for _ in 0..=self.classes.len() {
            let Some(class) = next.as_ref().and_then(|name| self.classes.get(name)) else { break };
            let oriented = is_oriented(&applied);
            for attribute in class.attributes.get(family).into_iter().flatten() {
                let is_other = oriented && ORIENTATIONS.contains(&attribute.name.as_str());
                if applied.attribute(&attribute.name).is_none() && !is_other {
                    applied.attributes.push(attribute.clone());
                }
            }
            next.clone_from(&class.parent);
        }
        applied
    }
}

fn is_oriented(element: &Element) -> bool {
    ORIENTATIONS.iter().any(|key| element.attribute(key).is_some())
}
