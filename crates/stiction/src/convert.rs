//! Conversion of a robot to the formats of other programs.

use crate::check::Check;
use crate::error::Error;
use stiction_run::Job;
use stiction_run::exchange::{
    Home, Instant, Mjcf, Sdf, Unfit, Urdf, json_text, mjcf, model_file, sdf, urdf,
};

/// File format to which a robot can be converted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Conversion {
    /// JSON in which all quantities are plain numbers.
    Json,
    /// A model file of Stiction without formulas, parameters and legs.
    Model,
    /// The format of MuJoCo.
    Mjcf,
    /// URDF, with a YAML file that defines loop closures and motors.
    Urdf,
    /// SDF, the format of Gazebo.
    Sdf,
}

/// A converted robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Converted {
    /// Text of the file.
    pub text: String,
    /// Text of an additional YAML file with the same base name, which defines the loop closures and
    /// motors of a URDF; `None` if no such file is needed.
    pub beside: Option<String>,
    /// Notes on omitted or changed properties.
    pub notes: Vec<String>,
}

impl Check {
    /// Converts the robot in its configuration at the first instant of the motion. Coordinates that the motion does not
    /// determine have the values of the initial guess.
    ///
    /// ```
    /// use stiction::{Conversion, Robot};
    ///
    /// let robot = Robot::builtin("3rps")?;
    /// assert!(robot.check_along().convert(Conversion::Mjcf)?.text.contains("<mujoco"));
    /// # Ok::<(), stiction::Error>(())
    /// ```
    ///
    /// # Errors
    /// The robot cannot be assembled, or the format cannot express it.
    pub fn convert(&self, to: Conversion) -> Result<Converted, Error> {
        let job = self.job()?;
        let locked = job.locked_start()?;
        let job = match &locked {
            Some((motion, _)) => Job { motion, ..job },
            None => job,
        };
        let home = Home::of(&job)?;
        let mut converted = self.written(&home, to)?;
        if let Some((_, names)) = &locked {
            converted.notes.push(format!(
                "the motion does not determine the position: the initial guess is used for {}",
                names.join(", ")
            ));
        }
        Ok(converted)
    }

    fn written(&self, home: &Home<'_>, to: Conversion) -> Result<Converted, Error> {
        let plain = |text: String| Converted { text, beside: None, notes: Vec::new() };
        let unfit = |unfit: Unfit| Error::input(unfit.to_string()).with_help(unfit.help());
        match to {
            Conversion::Json => Ok(plain(json_text(home))),
            Conversion::Model => {
                let friction = self.robot.model().default_friction;
                let instant = Instant { motion: &home.motion, loads: &[], friction };
                let text = model_file(&home.mechanism, self.robot.title(), instant);
                text.map(plain).map_err(|unwritable| {
                    Error::input(unwritable.to_string()).with_help(
                        "use the same law in both directions; the coefficients may differ",
                    )
                })
            }
            Conversion::Mjcf => {
                let Mjcf { text, notes } = mjcf(home).map_err(unfit)?;
                Ok(Converted { text, beside: None, notes })
            }
            Conversion::Sdf => {
                let Sdf { text, notes } = sdf(home).map_err(unfit)?;
                Ok(Converted { text, beside: None, notes })
            }
            Conversion::Urdf => {
                let Urdf { text, yaml, notes } = urdf(home).map_err(unfit)?;
                Ok(Converted { text, beside: yaml, notes })
            }
        }
    }
}
