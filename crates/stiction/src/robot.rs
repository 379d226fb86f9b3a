//! A robot: a mechanism with its named motions and loads.

mod model_text;

pub use model_text::{Import, ModelParts, ModelText};

use crate::error::Error;
use crate::files::Files;
use crate::names::Names;
use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use stiction_core::mechanism::{
    BodySpec, BushingSpec, JointSpec, JointSpringSpec, Mechanism, MechanismBuilder, SpringSpec,
};
use stiction_core::spatial::Vec3;
use stiction_format::{
    Contents, Control, Diagnostics, Drives, LoadCase, ModelFile, Motion, Note, Source,
};

/// A mechanism with its named motions and loads, as a model file describes it.
///
/// Cheap to clone: clones share the model.
#[derive(Clone, Debug)]
pub struct Robot {
    model: Arc<ModelFile>,
    names: Arc<Names>,
    files: Files,
    /// Folder of the files that options name; `None` for the current folder.
    folder: Option<Arc<Path>>,
    /// Text from which the robot was read; `None` for a robot described by code.
    text: Option<Arc<ModelText>>,
}

impl Robot {
    /// Reads a model file, or a URDF, MJCF or SDF file. Paths in the file are relative to its
    /// folder.
    ///
    /// # Errors
    /// The file cannot be read, or its content is invalid; the error then lists all defects, each
    /// with its place.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, Error> {
        ModelText::file(path.as_ref(), None)?.read()
    }

    /// Reads a robot from the text of a model. Paths in the text are relative to the current
    /// folder.
    ///
    /// # Errors
    /// The text is invalid; the error lists all defects, each with its place.
    pub fn parse(text: &str) -> Result<Self, Error> {
        ModelText::text(text).read()
    }

    /// Reads a built-in model, for example `gough` or `five-bar`; [`gallery::names`](crate::gallery::names) lists
    /// all.
    ///
    /// # Errors
    /// No built-in model has that name.
    pub fn builtin(name: &str) -> Result<Self, Error> {
        ModelText::builtin(name)?.read()
    }

    /// Returns the robot with one value of its model changed: `KEY = VALUE` with the path of a key
    /// (`bodies.platform.mass = 2 kg`) or the name of a parameter (`mu = 0.12`).
    ///
    /// # Errors
    /// The model has no such key, the value is not valid for the key, or the robot was described by code.
    pub fn with(&self, change: &str) -> Result<Self, Error> {
        let text = self.text.as_deref().ok_or_else(|| {
            Error::input("the robot has no model text to change: it was described in code")
                .with_help("build the robot again with the new value")
        })?;
        let changed = text.clone().with(change).read()?;
        Ok(Self { folder: self.folder.clone(), ..changed })
    }

    /// Returns the robot with another folder for the relative paths in its options, such as the recording of a motion.
    /// Default: the current folder of the process at the time of the call that names the file.
    #[must_use]
    pub fn in_folder(&self, folder: &Path) -> Self {
        Self { folder: Some(folder.into()), ..self.clone() }
    }

    /// Tests if a value of the model has an influence on friction alone, so that it has no effect while friction is off.
    /// `key` is the path of a key or the name of a parameter, as in [`Self::with`].
    pub fn affects_only_friction(&self, key: &str) -> bool {
        let draft = self.text.as_deref().and_then(|text| text.draft().ok());
        draft.is_some_and(|draft| draft.affects_only_friction(key))
    }

    /// Begins the description of a robot in code instead of a file.
    pub fn builder(name: impl Into<String>) -> RobotBuilder {
        RobotBuilder {
            mechanism: MechanismBuilder::new(name),
            motions: Vec::new(),
            loads: Vec::new(),
        }
    }

    pub(crate) fn new(model: ModelFile, files: Files) -> Self {
        let names = Arc::new(Names::new(&model.mechanism));
        Self { model: Arc::new(model), names, files, folder: None, text: None }
    }

    pub(crate) fn of_text(mut model: ModelFile, text: ModelText) -> Self {
        for warning in text.notes().iter().filter_map(Note::warning) {
            model.warnings.push(warning);
        }
        Self { text: Some(Arc::new(text.clone())), ..Self::new(model, text.files().clone()) }
    }

    /// Name of the model.
    pub fn name(&self) -> &str {
        &self.model.name
    }

    /// Title of the model, one line; empty if the file has none.
    pub fn title(&self) -> &str {
        &self.model.title
    }

    /// Warnings about the model, each with its place. Those with the code `import` state how results differ from those of
    /// the imported robot file; the others do not affect results.
    pub fn warnings(&self) -> &Diagnostics {
        &self.model.warnings
    }

    /// Names of the actuators, in the order of the efforts in results.
    pub fn actuators(&self) -> impl Iterator<Item = &str> {
        self.names.actuators.iter().map(|(name, _)| name.as_str())
    }

    /// Names of the joints, in the order of the reactions in results.
    pub fn joints(&self) -> impl Iterator<Item = &str> {
        self.names.joints.iter().map(String::as_str)
    }

    /// Names of the bodies; the first is the ground.
    pub fn bodies(&self) -> impl Iterator<Item = &str> {
        self.names.bodies.iter().map(String::as_str)
    }

    /// Names of the friction interfaces: the name of the joint, followed by that of the interface if the joint has
    /// several.
    pub fn friction_interfaces(&self) -> impl Iterator<Item = &str> {
        self.names.interfaces.iter().map(String::as_str)
    }

    /// Names of the motors, one for each drive train of the model.
    pub fn motors(&self) -> impl Iterator<Item = &str> {
        self.mechanism().drive_trains().iter().map(|train| train.name.as_str())
    }

    /// Names of the motions of the model.
    pub fn motions(&self) -> impl Iterator<Item = &str> {
        self.model.motions.iter().map(|(name, _)| name.as_str())
    }

    /// Names of the loads of the model.
    pub fn loads(&self) -> impl Iterator<Item = &str> {
        self.model.loads.iter().map(|(name, _)| name.as_str())
    }

    /// Remarks of the import of a URDF, MJCF or SDF file, each with its places in the file; empty for model files.
    pub fn import_notes(&self) -> &[Note] {
        self.text.as_deref().map_or(&[], ModelText::notes)
    }

    /// Names of the default motion, if the model has one, and of the default load.
    pub fn defaults(&self) -> (Option<String>, String) {
        (self.default_motion().map(|(_, name)| name), self.default_load().1)
    }

    /// Units of the actuators' efforts, `N` or `N m`, in the order of [`Self::actuators`].
    pub fn effort_units(&self) -> impl Iterator<Item = &'static str> {
        let joints = self.mechanism().joints();
        self.mechanism().actuators().map(|(id, dof)| joints[id.0].joint_type.dofs()[dof].units().1)
    }

    /// Parameters of the model with their values and SI units, in the order of the file.
    pub fn parameters(&self) -> impl Iterator<Item = (&str, f64, String)> {
        self.model.parameters()
    }

    /// The text from which the robot was read, with the changes made by [`Self::with`]; `None` for a robot described
    /// by code.
    pub fn text(&self) -> Option<&ModelText> {
        self.text.as_deref()
    }

    /// Draws the robot at the most legible instant of its default motion, or at its home position, as SVG in light or
    /// dark colours according to the reader's preference.
    ///
    /// # Errors
    /// The robot cannot be assembled, or cannot follow its motion.
    pub fn drawing(&self) -> Result<String, Error> {
        let check = self.check_along();
        let job = check.job()?;
        let locked = job.locked_start()?;
        let job = match &locked {
            Some((motion, _)) => stiction_run::Job { motion, ..job },
            None => job,
        };
        Ok(stiction_run::Portrait::of(&job)?.inline_svg())
    }

    /// The underlying model, for use with `stiction_core`, `stiction_format` and `stiction_run`.
    pub fn model(&self) -> &ModelFile {
        &self.model
    }

    /// The mechanism of the model.
    pub fn mechanism(&self) -> &Mechanism {
        &self.model.mechanism
    }

    /// Full paths of all files that have been read for this robot so far.
    pub fn files_read(&self) -> Vec<PathBuf> {
        self.files.paths()
    }

    pub(crate) fn shared_model(&self) -> &Arc<ModelFile> {
        &self.model
    }

    pub(crate) fn names(&self) -> &Arc<Names> {
        &self.names
    }

    /// Reads a measured log.
    pub(crate) fn log_contents(&self, file: &str) -> Result<Contents, Error> {
        let read = self.files.log(&self.place(Path::new(file)));
        read.map_err(|reason| Error::input(format!("cannot read {file}: {reason}")))
    }

    /// Reads the text of a file that is short enough to be read as a whole.
    pub(crate) fn file_text(&self, path: &Path) -> Result<String, Error> {
        let read = self.files.text(&self.place(path));
        read.map_err(|reason| Error::input(format!("cannot read {}: {reason}", path.display())))
    }

    fn contents(&self, file: &str) -> Result<Contents, String> {
        self.files.contents(&self.place(Path::new(file)))
    }

    /// Returns the path of a file that an option names, in the folder of [`Self::in_folder`].
    fn place<'a>(&self, file: &'a Path) -> Cow<'a, Path> {
        match &self.folder {
            Some(folder) => folder.join(file).into(),
            None => file.into(),
        }
    }

    /// Reads a motion from its name in the model, the name of a file, or assignments; returns it with its label in
    /// results.
    pub(crate) fn parse_motion(&self, text: &str) -> Result<(Motion, String), Error> {
        let filter = self.text.as_ref().and_then(|text| text.filter());
        let source = Source::new("motion", text).with_filter(filter);
        let motion = self.model.parse_motion(&source, &|file| self.contents(file))?;
        Ok((motion, label(text)))
    }

    /// Parses a state, given by assignments of coordinates such as `A = 60 deg + 2 rad/s*t`.
    pub(crate) fn parse_state(&self, text: &str) -> Result<Motion, Error> {
        Ok(self.model.parse_motion(&Source::new("from", text), &|file| self.contents(file))?)
    }

    /// Name of the model's default motion, or else of its only motion; `None` if the model has
    /// neither.
    pub(crate) fn default_motion_name(&self) -> Option<&str> {
        let only = match self.model.motions.as_slice() {
            [(name, _)] => Some(name),
            _ => None,
        };
        self.model.default_motion.as_ref().or(only).map(String::as_str)
    }

    /// The model's default motion, or else its only motion, with its name; `None` if the model has
    /// neither.
    pub(crate) fn default_motion(&self) -> Option<(Motion, String)> {
        let name = self.default_motion_name()?;
        Some((self.model.motion(name)?.clone(), name.to_owned()))
    }

    /// Creates the error for a request that has no motion, because none was set and the model has
    /// no default motion.
    pub(crate) fn motion_missing(&self) -> Error {
        let error = Error::input("no motion is given, and the model has no default motion");
        let names: Vec<&str> = self.motions().collect();
        error
            .with_help(match names.as_slice() {
                [] => {
                    "give a motion, for example \"JOINT = 0; duration = 0\" for a single pose, or add \
                     [motions.NAME] to the model"
                        .to_owned()
                }
                names => format!("choose one of its motions: {}", names.join(", ")),
            })
            .with_option("motion")
    }

    /// Reads a load from its name in the model, a file or assignments; returns it with its label in results.
    pub(crate) fn parse_load(&self, text: &str) -> Result<(LoadCase, String), Error> {
        let load =
            self.model.parse_load(&Source::new("load", text), &|file| self.contents(file))?;
        Ok((load, label(text)))
    }

    /// The model's default load with its name; no load, with the name `none`, if the model has no
    /// default load.
    pub(crate) fn default_load(&self) -> (LoadCase, String) {
        match &self.model.default_load {
            Some(name) => (self.model.load(name).cloned().unwrap_or_default(), name.clone()),
            None => (LoadCase::default(), "none".to_owned()),
        }
    }

    /// Reads actuator efforts for `model`, which is this robot's model or the same model with additional actuators.
    pub(crate) fn parse_drives(
        &self,
        model: &ModelFile,
        text: &str,
    ) -> Result<(Drives, String), Error> {
        let drives =
            model.parse_drives(&Source::new("drives", text), &|file| self.contents(file))?;
        Ok((drives, label(text)))
    }

    /// Reads a controller for `model`, which is this robot's model or the same model with additional actuators.
    pub(crate) fn parse_controller(
        &self,
        model: &ModelFile,
        text: &str,
    ) -> Result<(Control, String), Error> {
        let source = Source::new("controller", text);
        Ok((model.parse_control(&source, &|file| self.contents(file))?, label(text)))
    }
}

/// Label of a motion or load in results: its name, or `as given` if it was given as assignments.
fn label(text: &str) -> String {
    let text = text.trim();
    if text.contains('=') { "as given".to_owned() } else { text.to_owned() }
}

/// Describes a robot by code; see [`Robot::builder`].
#[derive(Clone, Debug)]
pub struct RobotBuilder {
    mechanism: MechanismBuilder,
    motions: Vec<(String, String)>,
    loads: Vec<(String, String)>,
}

impl RobotBuilder {
    /// Sets the acceleration of gravity in world axes, m/s².
    pub fn gravity(mut self, gravity: [f64; 3]) -> Self {
        let [x, y, z] = gravity;
        self.mechanism = self.mechanism.gravity(Vec3::new(x, y, z));
        self
    }

    /// Adds a body.
    pub fn body(mut self, body: BodySpec) -> Self {
        self.mechanism = self.mechanism.body(body);
        self
    }

    /// Adds a joint.
    pub fn joint(mut self, joint: JointSpec) -> Self {
        self.mechanism = self.mechanism.joint(joint);
        self
    }

    /// Adds a spring on a degree of freedom of a joint.
    pub fn joint_spring(mut self, spring: JointSpringSpec) -> Self {
        self.mechanism = self.mechanism.joint_spring(spring);
        self
    }

    /// Adds a bushing between frames of two bodies.
    pub fn bushing(mut self, bushing: BushingSpec) -> Self {
        self.mechanism = self.mechanism.bushing(bushing);
        self
    }

    /// Adds a spring between points of two bodies.
    pub fn spring(mut self, spring: SpringSpec) -> Self {
        self.mechanism = self.mechanism.spring(spring);
        self
    }

    /// Adds a motion, as assignments with units: `"pivot = 30 deg*sin(2*pi*t/s); duration = 2 s"`.
    pub fn motion(mut self, name: impl Into<String>, assignments: impl Into<String>) -> Self {
        self.motions.push((name.into(), assignments.into()));
        self
    }

    /// Adds a load, as assignments with units: `"platform.fz = -100 N"`.
    pub fn load(mut self, name: impl Into<String>, assignments: impl Into<String>) -> Self {
        self.loads.push((name.into(), assignments.into()));
        self
    }

    /// Builds the robot.
    ///
    /// # Errors
    /// The mechanism, a motion or a load is defective; the error lists all defects of the mechanism at once.
    pub fn build(self) -> Result<Robot, Error> {
        let mechanism =
            self.mechanism.build().map_err(|defects| Error::input(defects.to_string()))?;
        let mut model = ModelFile::from(mechanism);
        for (name, text) in self.motions {
            let source = Source::new(format!("motion {name}"), text);
            let motion = model.parse_motion(&source, &|_| Err("no files here".to_owned()))?;
            model.motions.push((name, motion));
        }
        for (name, text) in self.loads {
            let source = Source::new(format!("load {name}"), text);
            let load = model.parse_load(&source, &|_| Err("no files here".to_owned()))?;
            model.loads.push((name, load));
        }
        Ok(Robot::new(model, Files::default()))
    }
}

impl From<Mechanism> for Robot {
    /// A robot without named motions and loads.
    fn from(mechanism: Mechanism) -> Self {
        Self::new(ModelFile::from(mechanism), Files::default())
    }
}
