//! The text of a model before it is interpreted: from a file, standard input or a built-in model.
//! URDF, MJCF and SDF files are first converted to the text of a model file.

use crate::error::Error;
use crate::files::{Files, ReadProgress, standard_input};
use crate::names::find;
use crate::robot::Robot;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use stiction_format::{
    Contents, Draft, ImportOptions, Note, Source, gallery, import, is_robot_file,
};

/// Options of the import of a URDF, MJCF or SDF file.
#[derive(Clone, Debug, Default)]
pub struct Import {
    /// If `true`, every joint is imported as it is in the file. If `false`, groups of joints by
    /// which the file imitates other joint types are replaced by joints of these types, such as
    /// hinges or spherical joints.
    pub literal: bool,
    /// Folders in which packages and models are searched (`package://`, `model://`).
    pub package_paths: Vec<PathBuf>,
}

impl Import {
    /// Reads the file `name` to which a robot file in `folder` refers.
    fn bytes(&self, folder: &Path, name: &str, files: &Files) -> Result<Vec<u8>, String> {
        let paths = self.candidates(folder, name);
        let path = paths.iter().find(|path| path.is_file()).or(paths.first());
        path.map_or(Err("there is no such file".to_owned()), |path| files.bytes(path))
    }

    /// Possible paths of the file `name` to which a robot file in `folder` refers.
    fn candidates(&self, folder: &Path, name: &str) -> Vec<PathBuf> {
        let schemes = ["package://", "model://", "file://"];
        let Some(rest) = schemes.iter().find_map(|scheme| name.strip_prefix(scheme)) else {
            let others = self.package_paths.iter().map(|path| path.join(name));
            return std::iter::once(folder.join(name)).chain(others).collect();
        };
        if name.starts_with("file://") {
            return vec![folder.join(rest)];
        }
        let (package, within) = rest.split_once('/').unwrap_or((rest, ""));
        let mut all = Vec::new();
        for path in &self.package_paths {
            all.push(path.join(rest));
            if path.file_name().is_some_and(|own| own == package) {
                all.push(path.join(within));
            }
        }
        // The robot file is usually inside the package to which its paths refer.
        let own = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
        for above in own.ancestors() {
            if above.file_name().is_some_and(|own| own == package) {
                all.push(above.join(within));
            }
            all.push(above.join(rest));
        }
        all
    }
}

/// The text of a model before it is interpreted, so that single values can still be changed.
///
/// ```
/// use stiction::ModelText;
///
/// let robot = ModelText::builtin("five-bar")?.with("tool.mass = 0.7 kg").read()?;
/// # Ok::<(), stiction::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct ModelText {
    source: Source,
    /// Folder of the files to which the model refers; `None` for a built-in model, which refers to
    /// no files.
    folder: Option<PathBuf>,
    files: Files,
    changes: Vec<String>,
    /// Cut-off frequency of the filter for recorded motions, Hz.
    filter: Option<f64>,
    /// Remarks of the import of a URDF, MJCF or SDF file.
    notes: Arc<Vec<Note>>,
    /// True if the text was converted from a URDF, MJCF or SDF file; `import` then contains the
    /// options of the conversion.
    imported: bool,
    import: Import,
    /// Mesh files by name; `None` if meshes are read from the folder.
    meshes: Option<Arc<Vec<MeshFile>>>,
}

/// Name and content of a mesh file.
type MeshFile = (String, Vec<u8>);

/// Parts of a [`ModelText`], for storage or transfer.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelParts {
    /// Name by which messages refer to the text.
    pub name: String,
    /// The text.
    pub text: String,
    /// Folder of the files that the model names; `None` for a built-in model.
    pub folder: Option<PathBuf>,
    /// Changes of single values, as in [`ModelText::with`].
    pub changes: Vec<String>,
    /// Cut-off frequency of the filter for recorded motions, Hz.
    pub filter: Option<f64>,
}

impl ModelText {
    /// Reads a model file, or a URDF, MJCF or SDF file. Files that the model names are searched in
    /// the folder of the file.
    ///
    /// # Errors
    /// The file cannot be read, or cannot be converted.
    pub fn file(path: &Path, progress: Option<Arc<ReadProgress>>) -> Result<Self, Error> {
        Self::robot_file(path, progress, &Import::default())
    }

    /// Like [`Self::file`], with options for the import of a URDF, MJCF or SDF file.
    ///
    /// # Errors
    /// The file cannot be read, or cannot be converted.
    pub fn robot_file(
        path: &Path,
        progress: Option<Arc<ReadProgress>>,
        options: &Import,
    ) -> Result<Self, Error> {
        let files = Files::with_progress(progress);
        let name = path.display().to_string();
        let text = files.text(path).map_err(|why| {
            Error::input(format!("cannot read the model {name}: {why}"))
                .with_help("give a model file, or the name of a built-in model")
        })?;
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        Self::converted(Source::new(name, text), folder, files, options)
    }

    /// Converts the text of a URDF, MJCF or SDF file to that of a model file. Uses the text of a
    /// model file unchanged.
    fn converted(
        source: Source,
        folder: PathBuf,
        files: Files,
        options: &Import,
    ) -> Result<Self, Error> {
        if !is_robot_file(&source.text) {
            return Ok(Self::new(source, Some(folder), files));
        }
        let load = |name: &str| options.bytes(&folder, name, &files);
        let choices = ImportOptions { literal: options.literal };
        let imported = import(&source, choices, &load)?;
        let source = Source::new(format!("{} as a model file", source.name), imported.text);
        Ok(Self {
            notes: Arc::new(imported.notes),
            imported: true,
            import: options.clone(),
            ..Self::new(source, Some(folder), files)
        })
    }

    /// Remarks of the import of a URDF, MJCF or SDF file: properties that the model cannot express, or that were
    /// interpreted differently from how they are written.
    pub fn notes(&self) -> &[Note] {
        &self.notes
    }

    /// True if the text was converted from a URDF, MJCF or SDF file.
    pub fn is_imported(&self) -> bool {
        self.imported
    }

    /// The text of the model file, without changes.
    pub fn as_text(&self) -> &str {
        &self.source.text
    }

    /// Reads standard input up to its end. Files that the model names are searched in the current folder.
    ///
    /// # Errors
    /// Standard input cannot be read.
    pub fn standard_input(progress: Option<Arc<ReadProgress>>) -> Result<Self, Error> {
        let text = standard_input().map_err(|why| {
            Error::input(format!("cannot read the model from standard input: {why}"))
                .with_help("give a model file, or the name of a built-in model")
        })?;
        let files = Files::with_progress(progress);
        let source = Source::new("standard input", text);
        Self::converted(source, PathBuf::new(), files, &Import::default())
    }

    /// Creates a model text from the given text of a model file. Files that the model names are
    /// searched in the current folder.
    pub fn text(text: impl Into<String>) -> Self {
        Self::new(Source::new("model", text), Some(PathBuf::new()), Files::default())
    }

    /// Returns a built-in model; [`gallery::names`] lists all.
    ///
    /// # Errors
    /// No built-in model has that name.
    pub fn builtin(name: &str) -> Result<Self, Error> {
        let known: Vec<String> = gallery::names().map(str::to_owned).collect();
        find("built-in model", name, &known)?;
        let text = gallery::get(name).unwrap_or_default();
        Ok(Self::new(Source::new(format!("{name}.toml"), text), None, Files::default()))
    }

    /// Reads a file, a built-in model or a text, as `source` suggests: several lines or an equals sign make it the
    /// text of a model; a folder, an extension or an existing file of this name make it a file name; anything else is
    /// the name of a built-in model.
    ///
    /// # Errors
    /// The file cannot be read, or there is no such built-in model.
    pub fn find(source: &str) -> Result<Self, Error> {
        if source.contains(['\n', '=']) && !Path::new(source).is_file() {
            return Ok(Self::text(source));
        }
        let path = Path::new(source);
        let looks_like_file = path.extension().is_some() || path.components().count() > 1;
        if gallery::get(source).is_some() || !looks_like_file && !path.exists() {
            return Self::builtin(source);
        }
        Self::file(path, None)
    }

    /// Returns the parts from which [`Self::from_parts`] restores this text.
    pub fn parts(&self) -> ModelParts {
        ModelParts {
            name: self.source.name.clone(),
            text: self.source.text.clone(),
            folder: self.folder.clone(),
            changes: self.changes.clone(),
            filter: self.filter,
        }
    }

    /// Restores a text from its parts; the file is not read again.
    pub fn from_parts(parts: ModelParts) -> Self {
        let ModelParts { name, text, folder, changes, filter } = parts;
        let source = Source::new(name, text);
        Self { changes, filter, ..Self::new(source, folder, Files::default()) }
    }

    /// Restores a text as [`Self::from_parts`] does, but files that the model names are read from
    /// `files`.
    pub(crate) fn packed(parts: ModelParts, files: Files) -> Self {
        Self { files, ..Self::from_parts(parts) }
    }

    fn new(source: Source, folder: Option<PathBuf>, files: Files) -> Self {
        Self {
            source,
            folder,
            files,
            changes: Vec::new(),
            filter: None,
            notes: Arc::default(),
            imported: false,
            import: Import::default(),
            meshes: None,
        }
    }

    /// Sets the name and content of each mesh file, so that no mesh is read from the folder of the
    /// model. A mesh of the model is found by the last component of its path.
    #[must_use]
    pub fn with_meshes(mut self, files: impl IntoIterator<Item = (String, Vec<u8>)>) -> Self {
        self.meshes = Some(Arc::new(files.into_iter().collect()));
        self
    }

    /// Changes a value: `KEY = VALUE` with the path of a key (`bodies.platform.mass = 2 kg`) or the name
    /// of a parameter (`mu = 0.12`). See [`Source::with_changes`].
    #[must_use]
    pub fn with(mut self, change: impl Into<String>) -> Self {
        self.changes.push(change.into());
        self
    }

    /// Keys and parameters whose values were changed by [`Self::with`], in the order of the changes.
    pub fn changed_keys(&self) -> impl Iterator<Item = &str> {
        self.changes.iter().filter_map(|change| Some(change.split_once('=')?.0.trim()))
    }

    /// Makes the path of the folder in which files that the model names are searched absolute, so
    /// that later changes of the current folder have no effect.
    #[must_use]
    pub fn with_fixed_folder(mut self) -> Self {
        self.folder = self.folder.map(|folder| {
            // `absolute` refuses an empty path.
            let is_current = folder.as_os_str().is_empty();
            let named = if is_current { Path::new(".") } else { &folder };
            std::path::absolute(named).unwrap_or(folder)
        });
        self
    }

    /// Sets the cut-off frequency, in Hz, of a low-pass filter for all recorded motions of the robot: motions of the
    /// model, whose own `filter` it replaces, and motions from files given later.
    #[must_use]
    pub fn with_filter(mut self, cutoff: f64) -> Self {
        self.filter = Some(cutoff);
        self
    }

    /// Interprets the text and creates the robot.
    ///
    /// # Errors
    /// The text or a change is defective: the error lists all defects, each with its place.
    pub fn read(self) -> Result<Robot, Error> {
        let mut model = stiction_format::read(&self.changed(), &|file| self.contents(file))?;
        // The meshes of a packed model are not read: it is only simulated in an FMU, not drawn.
        if !self.files.is_packed() {
            model.load_meshes(&|file| self.mesh(file));
        }
        Ok(Robot::of_text(model, self))
    }

    fn changed(&self) -> Source {
        self.source.clone().with_changes(&self.changes).with_filter(self.filter)
    }

    /// Parses the text, so that the model can be read repeatedly with different values.
    pub(crate) fn draft(&self) -> Result<Draft, Error> {
        Ok(Draft::parse(&self.changed())?)
    }

    /// Reads a file that the model names.
    pub(crate) fn contents(&self, file: &str) -> Result<Contents, String> {
        match &self.folder {
            Some(folder) => self.files.contents(&folder.join(file)),
            None => Err("a built-in model has no other files".to_owned()),
        }
    }

    /// Returns the content of the mesh file that the imported robot file refers to as `file`.
    fn mesh(&self, file: &str) -> Result<Vec<u8>, String> {
        if let Some(given) = &self.meshes {
            let last = file.rsplit(['/', '\\']).next().unwrap_or(file);
            let found = given.iter().find(|(name, _)| name == last);
            return found.map_or(Err("its file is not given".to_owned()), |own| Ok(own.1.clone()));
        }
        match &self.folder {
            Some(folder) => self.import.bytes(folder, file, &self.files),
            None => Err("a built-in model has no other files".to_owned()),
        }
    }

    pub(crate) fn filter(&self) -> Option<f64> {
        self.filter
    }

    pub(crate) fn files(&self) -> &Files {
        &self.files
    }
}
