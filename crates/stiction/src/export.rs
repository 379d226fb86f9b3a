//! Export of the inverse dynamics of a robot as source code for controllers.

mod fmu;
mod plant;

pub use fmu::Fmu;
pub use plant::PlantExport;

use crate::check::Check;
use crate::coordinates::named;
use crate::error::Error;
use crate::robot::Robot;
use crate::states::guesses;
use stiction_core::dynamics::{InverseDynamics, Settings};
use stiction_core::joint::JointType;
use stiction_core::kinematics::{AssemblyError, Coordinate, Target};
use stiction_core::mechanism::{BodyId, JointId};
use stiction_format::did_you_mean;
use stiction_program::emit::{
    Adapters, Functions, Labels, Language, Precision, SourceFile, SourceOptions, TestVector,
};
use stiction_program::{Feedforward, RecordError, Tunable};
use stiction_run::exchange::Home;

/// Maximum number of positions along the motion at which a program is recorded.
const POSITIONS: u32 = 20;

/// Export of a robot as source code; see [`Robot::export`].
#[derive(Clone, Debug)]
pub struct Export {
    robot: Robot,
    language: Language,
    options: SourceOptions,
    named: Option<String>,
    motion: Option<String>,
    frictions: bool,
    masses: bool,
    payload: Option<String>,
    forces_on: Vec<String>,
    coordinates: Option<Vec<String>>,
    vectors: usize,
}

/// Recorded program of a robot, with all data that the source files require.
pub(crate) struct Recorded {
    pub(crate) program: Feedforward,
    pub(crate) solver: InverseDynamics,
    /// Values of the coordinates of the code at positions along the motion; the first entry
    /// is the home position.
    signal: Vec<Vec<Target<f64>>>,
    pub(crate) labels: Labels,
    options: SourceOptions,
}

impl Export {
    pub(crate) fn of(robot: &Robot) -> Self {
        Self {
            robot: robot.clone(),
            language: Language::C,
            options: SourceOptions::new(robot.name()),
            named: None,
            motion: None,
            frictions: true,
            masses: false,
            payload: None,
            forces_on: Vec::new(),
            coordinates: None,
            vectors: 200,
        }
    }

    /// Sets the programming language; C by default.
    pub fn language(mut self, language: Language) -> Self {
        self.language = language;
        self
    }

    /// Sets the name of the files and the prefix of all names in the code: a lower-case letter,
    /// then lower-case letters, digits and underscores, at most 20 characters in total. By default,
    /// the name is derived from the name of the model.
    pub fn name(mut self, name: &str) -> Self {
        self.named = Some(name.to_owned());
        self
    }

    /// Sets the motion near which the code is recorded and tested, as in [`crate::Request::motion`].
    /// Default: the default motion of the model.
    pub fn motion(mut self, motion: &str) -> Self {
        self.motion = Some(motion.to_owned());
        self
    }

    /// Sets the floating-point type; double precision by default.
    pub fn precision(mut self, precision: Precision) -> Self {
        self.options.precision = precision;
        self
    }

    /// Includes sine and cosine in the code, instead of calling those of the mathematical library.
    pub fn own_math(mut self, own: bool) -> Self {
        self.options.own_math = own;
        self
    }

    /// Selects the parameters of the code that can be changed at run time: with `frictions`, the
    /// coefficients of all friction interfaces; with `masses`, the masses of all bodies. Default:
    /// only the friction coefficients.
    pub fn tunable(mut self, frictions: bool, masses: bool) -> Self {
        (self.frictions, self.masses) = (frictions, masses);
        self
    }

    /// Adds functions besides inverse dynamics: forward kinematics with Jacobians, joint reactions, derivatives,
    /// forward dynamics. Default: none.
    pub fn functions(mut self, functions: Functions) -> Self {
        self.options.functions = functions;
        self
    }

    /// Adds a point mass on a body. The mass, kg, and the position in the frame of the body, m, are
    /// parameters of the code.
    pub fn payload(mut self, body: &str) -> Self {
        self.payload = Some(body.to_owned());
        self
    }

    /// Adds a force (N) and a moment (N m) on a body, at its origin and along world axes, as
    /// parameters of the code.
    pub fn force_on(mut self, body: &str) -> Self {
        self.forces_on.push(body.to_owned());
        self
    }

    /// Sets the coordinates of the code, by name: joint coordinates such as `leg1.P`, and coordinates that the motion
    /// prescribes, such as `platform.z`. Default: all actuators.
    pub fn coordinates<S: AsRef<str>>(mut self, names: &[S]) -> Self {
        self.coordinates = Some(names.iter().map(|name| name.as_ref().to_owned()).collect());
        self
    }

    /// Adds programs and files that run the code in other environments; C only. Default: none.
    pub fn adapters(mut self, adapters: Adapters) -> Self {
        self.options.adapters = adapters;
        self
    }

    /// Sets the number of test vectors; 200 by default. Positions near singularities and states
    /// with a friction interface at rest are skipped, so the code may have fewer test vectors.
    pub fn vectors(mut self, count: usize) -> Self {
        self.vectors = count;
        self
    }

    /// Exports the robot as a plant instead of a feed-forward: forward dynamics with stick and
    /// slip, as a functional mock-up unit. Of the options set so far, only the name and the motion
    /// apply to the plant.
    pub fn plant(&self) -> PlantExport {
        let name = self.checked_options().map(|options| match self.named {
            Some(_) => options.name,
            None => format!("{}_plant", options.name),
        });
        let plant = PlantExport::new(self.robot.clone(), name);
        match &self.motion {
            Some(motion) => plant.motion(motion),
            None => plant,
        }
    }

    /// Records the program, computes test vectors with the general solver, and writes the files.
    ///
    /// # Errors
    /// The program cannot be recorded for this robot (the error states the reason), or an option
    /// contains an unknown name.
    pub fn files(&self) -> Result<Vec<SourceFile>, Error> {
        if self.language == Language::Rust && self.options.own_math {
            let error = Error::input(
                "--own-math applies to C only: code in Rust gets its mathematical functions through a trait",
            );
            return Err(error.with_help("leave --own-math out"));
        }
        if self.language == Language::Rust && self.options.adapters != Adapters::default() {
            return Err(Error::input("adapters are for C").with_help("leave --adapters out"));
        }
        let Recorded { program, solver, signal, labels, options } = self.record()?;
        let vectors = TestVector::random(&solver, &signal, self.vectors, 1);
        if vectors.is_empty() && self.vectors > 0 {
            let message = format!(
                "cannot generate code for `{}`: the solver found no solution at any of {} random states near \
                 the motion",
                self.robot.name(),
                20 * self.vectors
            );
            return Err(Error::input(message).with_help(
                "`stiction check` shows whether the motion is near singular positions",
            ));
        }
        program.files(self.language, &labels, &options, &vectors).map_err(|error| {
            let (help, option) = match error {
                RecordError::ActuatorCount { .. } => ("leave `accelerations` out", "functions"),
                _ => ("choose double precision", "precision"),
            };
            Error::input(format!("cannot generate code for `{}`: {error}", self.robot.name()))
                .with_help(help)
                .with_option(option)
        })
    }

    /// Records the program of inverse dynamics, whose inputs are the coordinates of the code.
    pub(crate) fn record(&self) -> Result<Recorded, Error> {
        let options = self.checked_options()?;
        let (solver, named) = self.driven()?;
        if solver.mechanism().actuators().next().is_none() {
            let error = Error::input(format!(
                "cannot generate code for `{}`: it has no actuator",
                self.robot.name()
            ));
            return Err(error.with_help("add `actuated` to the joints that are driven"));
        }
        let signal = self.positions(&solver, &named)?;
        let tunables = self.tunables(&solver)?;
        let program = Feedforward::record(&solver, &signal, &tunables).and_then(|program| {
            match options.functions.need_derivatives() {
                true => program.with_derivatives(&solver, &signal),
                false => Ok(program),
            }
        });
        let program = program.map_err(|error| {
            let message = format!("cannot generate code for `{}`: {error}", self.robot.name());
            Error::input(message).with_help(match error {
                RecordError::NoTunable(_) => "choose a body with a mass for the payload",
                RecordError::Gearings => {
                    "`stiction inverse` computes the efforts of mechanisms with gearings"
                }
                _ => "choose another motion, away from singular positions",
            })
        })?;
        let labels = self.labels(&solver, &named);
        Ok(Recorded { program, solver, signal, labels, options })
    }

    fn checked_options(&self) -> Result<SourceOptions, Error> {
        let Some(name) = &self.named else { return Ok(self.options.clone()) };
        let options = SourceOptions { name: SourceOptions::new(name).name, ..self.options.clone() };
        if options.name != *name {
            let message = format!(
                "the name `{}` is not allowed: a name begins with a lower-case letter, consists of lower-case \
                 letters, digits and underscores, has at most 20 characters, and is not the name of a header of the \
                 C library",
                name.escape_debug()
            );
            return Err(Error::input(message)
                .with_help(format!("for example `{}`", options.name))
                .with_option("name"));
        }
        Ok(options)
    }

    fn tunables(&self, solver: &InverseDynamics) -> Result<Vec<Tunable>, Error> {
        let parameters = solver.parameters();
        let mut tunables = Vec::new();
        if self.frictions {
            tunables.extend(Tunable::frictions(parameters));
        }
        if self.masses {
            tunables.extend(Tunable::masses(parameters));
        }
        if let Some(name) = &self.payload {
            let body = self.body(name)?;
            if parameters.mass[body] <= 0.0 {
                let message =
                    format!("body `{name}` has no mass, so a payload cannot be added to it");
                return Err(Error::input(message).with_help("give the body a mass"));
            }
            tunables.push(Tunable::Payload(BodyId(body)));
        }
        for name in &self.forces_on {
            tunables.push(Tunable::Wrench(BodyId(self.body(name)?)));
        }
        Ok(tunables)
    }

    /// Index of the body with the given name. The ground is rejected.
    fn body(&self, name: &str) -> Result<usize, Error> {
        let names: Vec<&str> = self.robot.bodies().collect();
        let found = names.iter().skip(1).position(|known| *known == name);
        found.map(|body| body + 1).ok_or_else(|| {
            let error = Error::input(format!("there is no body `{}`", name.escape_debug()));
            let near = did_you_mean(name, "body", names.iter().skip(1).copied());
            let all = || format!("the bodies are {}", names[1..].join(", "));
            error.with_help(near.unwrap_or_else(all))
        })
    }

    /// Creates a request for the motion near which the code is recorded.
    fn along(&self) -> Result<Check, Error> {
        let check = self.robot.check_along();
        match &self.motion {
            Some(motion) => check.motion(motion),
            None => Ok(check),
        }
    }

    /// Values of the given coordinates at positions along the motion, up to the first singular or
    /// unreachable position.
    fn positions(
        &self,
        solver: &InverseDynamics,
        named: &[Named],
    ) -> Result<Vec<Vec<Target<f64>>>, Error> {
        let check = self.along()?;
        let job = check.job()?;
        let mut follower = job.assemble(job.motion.start)?;
        let types = joint_types(solver);
        let mut own = solver.clone();
        let at_rest = |value| Target { value, rate: 0.0, acceleration: 0.0 };
        let mut positions = vec![named.iter().map(|(.., value)| at_rest(*value)).collect()];
        for k in 1..POSITIONS {
            let time = job.motion.start + job.motion.duration * f64::from(k) / f64::from(POSITIONS);
            if job.motion.duration == 0.0 || follower.go_to(time).is_err() {
                break;
            }
            let before = &positions[positions.len() - 1];
            let prescribed: Vec<Target<f64>> = job.motion.at(time).collect();
            let now: Vec<Target<f64>> = named
                .iter()
                .zip(before)
                .map(|((_, which, _), before): (&Named, &Target<f64>)| {
                    let mut known = job.motion.coordinates.iter().zip(&prescribed);
                    let known = known.find(|((coordinate, _), _)| coordinate == which);
                    let found = match (known, *which) {
                        (Some((_, target)), _) => target.value,
                        (None, Coordinate::Joint { joint, dof }) => {
                            follower.solver.joint_motion(joint, dof).value
                        }
                        (None, _) => before.value,
                    };
                    let turn = if which.is_angle(&types) { TURN } else { f64::INFINITY };
                    // The solver returns angles within half a turn of zero. Subtracting whole turns
                    // makes the angles continuous along the motion.
                    let turns = ((found - before.value) / turn).round();
                    let value = if turns == 0.0 { found } else { found - turns * turn };
                    at_rest(value)
                })
                .collect();
            let mut next = own.clone();
            // Beyond a singular position the coordinates no longer determine the motion.
            if next.move_to(&now).is_err() || next.side() != own.side() {
                break;
            }
            own = next;
            positions.push(now);
        }
        Ok(positions)
    }

    fn labels(&self, solver: &InverseDynamics, named: &[Named]) -> Labels {
        let types = joint_types(solver);
        let unit = |which: &Coordinate| if which.is_angle(&types) { "rad" } else { "m" };
        let coordinates = named.iter().map(|(name, which, _)| (name.clone(), unit(which)));
        let mut actuators = Vec::new();
        for ((joint, dof), name) in solver.mechanism().actuators().zip(self.robot.actuators()) {
            let effort = if translates(solver, joint, dof) { "N" } else { "N m" };
            actuators.push((name.to_owned(), effort));
        }
        let owned = |names: &mut dyn Iterator<Item = &str>| names.map(str::to_owned).collect();
        Labels {
            model: self.robot.name().to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            coordinates: coordinates.collect(),
            actuators,
            joints: owned(&mut self.robot.joints()),
            interfaces: owned(&mut self.robot.friction_interfaces()),
            bodies: owned(&mut self.robot.bodies()),
        }
    }
}

const TURN: f64 = core::f64::consts::TAU;

fn translates(solver: &InverseDynamics, joint: JointId, dof: usize) -> bool {
    solver.mechanism().joints()[joint.0].joint_type.dofs()[dof].translates()
}

fn joint_types(solver: &InverseDynamics) -> Vec<JointType> {
    solver.mechanism().joints().iter().map(|joint| joint.joint_type).collect()
}

/// Name of a coordinate, the coordinate, and its value at the home position.
type Named = (String, Coordinate, f64);

impl Export {
    /// Creates the solver at the first instant of the motion, with the coordinates of the
    /// code as independent coordinates. Returns the solver and these coordinates.
    fn driven(&self) -> Result<(InverseDynamics, Vec<Named>), Error> {
        let check = self.along()?;
        let job = check.job()?;
        let home = Home::of(&job)?;
        let named = named(&self.robot, &home, self.coordinates.as_deref())
            .map_err(|error| error.with_option("coordinates"))?;
        let coordinates: Vec<Coordinate> = named.iter().map(|(_, which, _)| *which).collect();
        let at_rest = |value| Target { value, rate: 0.0, acceleration: 0.0 };
        let targets: Vec<_> = named.iter().map(|(.., value)| at_rest(*value)).collect();
        let poses = guesses(&home);
        let settings = Settings::default();
        let solver = InverseDynamics::new(home.mechanism, &poses, &coordinates, &targets, settings)
            .map_err(|error| self.undetermined(&error))?;
        Ok((solver, named))
    }

    fn undetermined(&self, error: &AssemblyError) -> Error {
        let name = self.robot.name();
        match &self.coordinates {
            None => {
                Error::input(format!("cannot generate code for `{name}`: with its actuators as inputs, {error}"))
                    .with_help(
                        "choose actuators that determine the motion (`stiction check` shows the mobility), or choose \
                         other coordinates with --coordinates",
                    )
            }
            Some(names) => Error::input(format!(
                "cannot generate code for `{name}`: with {} as inputs, {error}",
                names.join(", ").escape_debug()
            ))
            .with_help("choose other coordinates, one for each degree of freedom")
            .with_option("coordinates"),
        }
    }
}
