//! `stiction models`: the gallery.

use crate::arguments::Models;
use crate::failure::Failure;
use crate::print;
use serde_json::json;
use stiction_format::{ModelFile, Source, gallery};

pub(crate) fn run(options: &Models) -> Result<(), Failure> {
    list(options).map_err(|failure| failure.for_programs(options.json))
}

fn list(options: &Models) -> Result<(), Failure> {
    if let Some(name) = &options.name {
        let text = gallery::get(name).ok_or_else(|| crate::sources::unknown_model(name))?;
        return match options.json {
            true => print(&format!("{:#}\n", json!({ "name": name, "text": text }))),
            false => print(text),
        };
    }
    let models: Vec<(&str, ModelFile)> =
        gallery::names().map(|name| Ok((name, read(name)?))).collect::<Result<_, Failure>>()?;
    if options.json {
        let list: Vec<_> = models
            .iter()
            .map(|(name, model)| {
                let names = |list: Vec<&String>| json!(list);
                json!({
                    "name": name,
                    "title": model.title,
                    "motions": names(model.motions.iter().map(|(name, _)| name).collect()),
                    "loads": names(model.loads.iter().map(|(name, _)| name).collect()),
                })
            })
            .collect();
        return print(&format!("{:#}\n", json!(list)));
    }
    let wide = models.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
    let mut out = String::new();
    for (name, model) in &models {
        out += &format!("{name:wide$}  {}\n", model.title);
    }
    out += "\n`stiction models NAME` prints a model's file, `stiction inverse NAME` runs it.\n";
    print(&out)
}

fn read(name: &str) -> Result<ModelFile, Failure> {
    let text = gallery::get(name).unwrap_or_default();
    let source = Source::new(format!("{name}.toml"), text);
    Ok(stiction_format::read(&source, &|_| Err("the gallery has no other files".to_owned()))?)
}
