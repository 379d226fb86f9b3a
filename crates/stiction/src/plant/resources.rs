//! Files in the folder `resources` of an exported plant: the text of the model, the files that the
//! model names, and the options.

use super::{Plant, Unit};
use crate::error::Error;
use crate::files::Files;
use crate::robot::{ModelParts, ModelText, Robot};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use stiction_format::Contents;
use stiction_program::emit::SourceFile;

const MODEL: &str = "model.toml";
const PLANT: &str = "plant.json";

/// Version of the format of [`PLANT`].
const FORMAT: u64 = 1;

/// Number of bytes of a recording that are read at once.
const PIECE: usize = 1 << 16;

/// Options of a plant in a functional mock-up unit, as texts and numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct PlantOptions {
    /// Motion at whose first instant the plant starts; `None` for the default motion.
    pub(crate) motion: Option<String>,
    /// Initial state, as in [`crate::Forward::from`]; `None` for the state of the motion.
    pub(crate) from: Option<String>,
    /// Load that acts inside the plant; `None` for the default load.
    pub(crate) load: Option<String>,
    /// Joint friction on or off; `None` for the setting of the model.
    pub(crate) friction: Option<bool>,
    /// Tolerance for the relative error of an integration step; `None` for the default.
    pub(crate) tolerance: Option<f64>,
    /// Names of the bodies on which a force and a moment act as inputs.
    pub(crate) forces_on: Vec<String>,
}

impl PlantOptions {
    /// Creates the plant of a robot with these options.
    pub(crate) fn plant(&self, robot: &Robot) -> Result<Plant, Error> {
        let mut forward = robot.forward();
        if let Some(motion) = &self.motion {
            forward = forward.motion(motion)?;
        }
        if let Some(load) = &self.load {
            forward = forward.load(load)?;
        }
        if let Some(from) = &self.from {
            forward = forward.from(from)?;
        }
        if let Some(on) = self.friction {
            forward = forward.friction(on);
        }
        if let Some(tolerance) = self.tolerance {
            forward = forward.tolerance(tolerance)?;
        }
        forward.plant()
    }

    fn json(&self) -> Value {
        json!({
            "motion": self.motion,
            "from": self.from,
            "load": self.load,
            "friction": self.friction,
            "tolerance": self.tolerance,
            "forces_on": self.forces_on,
        })
    }

    fn from_json(value: &Value) -> Option<Self> {
        let text = |key: &str| value[key].as_str().map(str::to_owned);
        let bodies = value["forces_on"].as_array()?.iter();
        Some(Self {
            motion: text("motion"),
            from: text("from"),
            load: text("load"),
            friction: value["friction"].as_bool(),
            tolerance: value["tolerance"].as_f64(),
            forces_on: bodies
                .map(|body| body.as_str().map(str::to_owned))
                .collect::<Option<_>>()?,
        })
    }
}

/// Returns files from which [`read`] creates the plant again. A plant must have been created from
/// `robot` and `options` before this call, so that all files named in them are known.
///
/// # Errors
/// The robot was described by code, or a file cannot be read again.
pub(crate) fn write(robot: &Robot, options: &PlantOptions) -> Result<Vec<SourceFile>, Error> {
    let text = robot.text().ok_or_else(|| {
        Error::input("the robot has no model text, which an FMU needs: it was described in code")
            .with_help("write the robot to a model file first")
    })?;
    let ModelParts { name, text: model, folder, changes, filter } = text.parts();
    let folder = folder.unwrap_or_default();
    let mut files = Vec::new();
    let mut named = serde_json::Map::new();
    for path in text.files().named() {
        let read = text.files().contents(&path).and_then(whole);
        let content =
            read.map_err(|why| Error::input(format!("cannot read {}: {why}", path.display())))?;
        let name = path.strip_prefix(&folder).unwrap_or(&path).display().to_string();
        let place = format!("files/{}.csv", named.len());
        if named.insert(name.clone(), Value::from(place.as_str())).is_some() {
            return Err(Error::input(format!("two files have the name {name}"))
                .with_help("rename one of them"));
        }
        files.push(SourceFile { name: place, text: content });
    }
    let file_name = Path::new(&name).file_name().unwrap_or_default().to_string_lossy().into_owned();
    let plant = json!({
        "format": FORMAT,
        "name": file_name,
        "changes": changes,
        "filter": filter,
        "files": named,
        "options": options.json(),
    });
    files.push(SourceFile { name: MODEL.to_owned(), text: model });
    files.push(SourceFile { name: PLANT.to_owned(), text: format!("{plant:#}\n") });
    Ok(files)
}

/// Returns the whole text of a file, also of a long recording.
fn whole(contents: Contents) -> Result<String, String> {
    let store = match contents {
        Contents::Whole(text) => return Ok(text),
        Contents::Stored(store) => store,
    };
    let (mut bytes, mut piece) = (Vec::new(), vec![0; PIECE]);
    loop {
        match store.read_at(bytes.len() as u64, &mut piece)? {
            0 => break,
            count => bytes.extend_from_slice(&piece[..count]),
        }
    }
    String::from_utf8(bytes).map_err(|_| "it is not UTF-8 text".to_owned())
}

/// Reads a plant from the folder that contains the files of [`write()`].
///
/// # Errors
/// The files are not those of a plant, or the plant cannot be created.
pub(super) fn read(folder: &Path) -> Result<Unit, Error> {
    let text = |name: &str| {
        let path = folder.join(name);
        Files::default().text(&path).map_err(|why| {
            Error::input(format!("cannot read {}: {why}", path.display()))
                .with_help("give the path of the folder `resources` of the extracted FMU")
        })
    };
    let (model, plant) = (text(MODEL)?, text(PLANT)?);
    let wrong = || Error::input(format!("{PLANT} does not describe a plant"));
    let plant: Value = serde_json::from_str(&plant).map_err(|_| wrong())?;
    if plant["format"].as_u64() != Some(FORMAT) {
        return Err(wrong().with_help(
            "export the FMU again with the version of Stiction that contains this library",
        ));
    }
    let strings = |value: &Value| -> Option<Vec<String>> {
        value.as_array()?.iter().map(|text| text.as_str().map(str::to_owned)).collect()
    };
    let places = plant["files"].as_object().ok_or_else(wrong)?.iter();
    let places =
        places.map(|(name, place)| Some((PathBuf::from(name), folder.join(place.as_str()?))));
    let places: Vec<_> = places.collect::<Option<_>>().ok_or_else(wrong)?;
    let parts = ModelParts {
        name: plant["name"].as_str().ok_or_else(wrong)?.to_owned(),
        text: model,
        folder: Some(PathBuf::new()),
        changes: strings(&plant["changes"]).ok_or_else(wrong)?,
        filter: plant["filter"].as_f64(),
    };
    let options = PlantOptions::from_json(&plant["options"]).ok_or_else(wrong)?;
    let robot = ModelText::packed(parts, Files::packed(places)).read()?;
    Unit::new(&robot, &options)
}
