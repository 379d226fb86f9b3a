//! Export of forward dynamics as a functional mock-up unit (FMU).

use super::Fmu;
use crate::error::Error;
use crate::plant::Unit;
use crate::plant::resources::{self, PlantOptions};
use crate::robot::{ModelText, Robot};
use stiction_program::emit::SourceFile;
use stiction_program::emit::fmu::{Description, Fmi};

const INDEX: &str = include_str!("plant.html");

const LICENSE: &str = "The library in binaries/ is a part of Stiction, licensed under MIT or Apache-2.0, at your \
option.\nThe model in resources/ is yours.\n";

/// Export of a robot as a plant: a functional mock-up unit for co-simulation that contains the engine of
/// [`Robot::forward`]; see [`crate::Export::plant`].
///
/// ```
/// use stiction::{Fmi, Robot};
///
/// let plant = Robot::builtin("five-bar")?.export().plant().from("rest").force_on("tool");
/// let unit = plant.fmu(Fmi::Three)?;
/// assert!(unit.files.iter().any(|file| file.name == "resources/model.toml"));
/// # Ok::<(), stiction::Error>(())
/// ```
#[derive(Debug)]
pub struct PlantExport {
    robot: Robot,
    name: Result<String, Error>,
    options: PlantOptions,
}

impl PlantExport {
    pub(super) fn new(robot: Robot, name: Result<String, Error>) -> Self {
        Self { robot, name, options: PlantOptions::default() }
    }

    /// Sets the motion at whose first instant the plant starts, as in [`crate::Request::motion`].
    pub fn motion(mut self, motion: &str) -> Self {
        self.options.motion = Some(motion.to_owned());
        self
    }

    /// Sets the initial state, as in [`crate::Forward::from`]: `motion`, `rest`, or assignments.
    pub fn from(mut self, start: &str) -> Self {
        self.options.from = Some(start.to_owned());
        self
    }

    /// Sets the load that acts inside the plant, as in [`crate::Request::load`]. Default: the
    /// default load of the model.
    pub fn load(mut self, load: &str) -> Self {
        self.options.load = Some(load.to_owned());
        self
    }

    /// Switches joint friction on or off. Default: the setting of the model or, if it has none, on.
    pub fn friction(mut self, on: bool) -> Self {
        self.options.friction = Some(on);
        self
    }

    /// Sets the tolerance for the relative error of one integration step.
    pub fn tolerance(mut self, tolerance: f64) -> Self {
        self.options.tolerance = Some(tolerance);
        self
    }

    /// Adds a force (N) and a moment (N m) on a body, at its origin and along world axes, as inputs
    /// of the plant.
    pub fn force_on(mut self, body: &str) -> Self {
        self.options.forces_on.push(body.to_owned());
        self
    }

    /// Files of the unit, without the library that contains the engine; that library must be named
    /// [`Fmu::identifier`] in the unit.
    ///
    /// # Errors
    /// An option contains an unknown name, the robot cannot be assembled at the start, or the robot
    /// was described in code instead of a file.
    pub fn fmu(&self, fmi: Fmi) -> Result<Fmu, Error> {
        let identifier = match &self.name {
            Ok(name) => name.clone(),
            Err(error) => {
                return Err(Error::new(error.kind(), error.message())
                    .with_help(error.help().unwrap_or_default())
                    .with_option("name"));
            }
        };
        // Files that other requests of this robot have read are not part of the plant.
        let robot = match self.robot.text() {
            Some(text) => ModelText::from_parts(text.parts()).read()?,
            None => self.robot.clone(),
        };
        let unit = Unit::new(&robot, &self.options)?;
        let description = Description {
            fmi,
            identifier: identifier.clone(),
            model: self.robot.name().to_owned(),
            about:
                "Forward dynamics with stick and slip in the joints: a plant without a controller"
                    .to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            token: unit.token().to_owned(),
            sources: Vec::new(),
            categories: vec![
                ("logEvents", "Stick onsets, slip onsets and other events"),
                ("logStatusError", "Rejected calls and failed steps"),
                ("logStatusFatal", "Defects of the library"),
            ],
            has_events: true,
            step: 0.001,
            start: unit.time(),
            stop: None,
            variables: unit.variables().to_vec(),
        };
        let file = |name: &str, text: String| SourceFile { name: name.to_owned(), text };
        let mut files = vec![file("modelDescription.xml", description.xml())];
        for part in resources::write(&robot, &self.options)? {
            files.push(file(&format!("resources/{}", part.name), part.text));
        }
        files.push(file("documentation/index.html", INDEX.replace("@IDENTIFIER@", &identifier)));
        files.push(file("documentation/licenses/license.txt", LICENSE.to_owned()));
        Ok(Fmu { identifier, files, sources: Vec::new() })
    }
}
