//! `stiction models`: the built-in models.

use crate::answer;
use crate::arguments::Models;
use crate::failure::Failure;
use crate::print;
use serde_json::json;
use stiction::{Robot, gallery};

pub(crate) fn run(options: &Models) -> Result<(), Failure> {
    list(options).map_err(|failure| failure.into_json(options.json))
}

fn list(options: &Models) -> Result<(), Failure> {
    if let Some(name) = &options.name {
        let text = gallery::get(name).ok_or_else(|| crate::sources::unknown_model(name))?;
        return match options.json {
            true => {
                answer::give(&json!({ "name": name, "text": text }));
                Ok(())
            }
            false => print(text),
        };
    }
    let models: Vec<(&str, Robot)> = gallery::names()
        .map(|name| Ok((name, Robot::builtin(name)?)))
        .collect::<Result<_, Failure>>()?;
    if options.json {
        let list: Vec<_> = models
            .iter()
            .map(|(name, model)| {
                json!({
                    "name": name,
                    "title": model.title(),
                    "motions": model.motions().collect::<Vec<_>>(),
                    "loads": model.loads().collect::<Vec<_>>(),
                })
            })
            .collect();
        answer::give(&json!(list));
        return Ok(());
    }
    let wide = models.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
    let mut out = String::new();
    for (name, model) in &models {
        let indent = " ".repeat(wide + 2);
        let name = format!("{name:wide$}  ");
        out += &crate::fold::folded_as(model.title(), &name, &indent);
        out.push('\n');
    }
    out += "\n`stiction models NAME` prints a model's file, `stiction inverse NAME` runs it.\n";
    print(&out)
}
