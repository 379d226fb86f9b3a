//! Methods of [`Robot`] that create the requests for all computations.

use crate::breakaway::Breakaway;
use crate::check::{Check, Report};
use crate::compensation::Compensation;
use crate::control_loop::ControlLoop;
use crate::error::Error;
use crate::export::Export;
use crate::forward::Forward;
use crate::inverse::Inverse;
use crate::operating_point::{Linearize, Rests};
use crate::robot::Robot;
use crate::states::Compile;
use crate::sweep::Sweep;

impl Robot {
    /// Creates a request to compute actuator efforts, joint reactions and joint friction along a
    /// motion (inverse dynamics).
    pub fn inverse(&self) -> Inverse {
        Inverse::of(self)
    }

    /// Creates a request to simulate the motion under efforts, controllers and loads, with joints
    /// locked or prescribed (forward dynamics).
    pub fn forward(&self) -> Forward {
        Forward::of(self)
    }

    /// Checks mobility, redundancy and singularities along the model's default motion. A model
    /// without motions is checked at its home position.
    ///
    /// # Errors
    /// The model has several motions but no default motion, or the mechanism cannot follow the
    /// motion.
    pub fn check(&self) -> Result<Report, Error> {
        self.check_along().run()
    }

    /// Creates a request to check mobility, redundancy and singularities along a motion.
    pub fn check_along(&self) -> Check {
        Check::of(self)
    }

    /// Creates a request to compute static friction of the robot at rest at a position of its
    /// motion: the interval of efforts of each actuator for which the robot remains at rest, and
    /// the efforts at which motion begins.
    pub fn breakaway(&self) -> Breakaway {
        Breakaway::of(self)
    }

    /// Creates a request to find the static equilibrium without friction: the position in which the
    /// robot rests under gravity, springs, loads and given efforts, and the stability of this
    /// position.
    ///
    /// # Errors
    /// The options contradict each other.
    pub fn equilibrium(&self) -> Result<Rests, Error> {
        Rests::of(self)
    }

    /// Creates a request to linearise the equations of motion about an operating point: matrices A,
    /// B, C, D of the state-space model in independent coordinates.
    ///
    /// ```
    /// let robot = stiction::Robot::builtin("five-bar")?;
    /// let model = robot.linearize()?.friction(false).run()?;
    /// assert_eq!((model.states.len(), model.inputs.len()), (4, 2));
    /// # Ok::<(), stiction::Error>(())
    /// ```
    ///
    /// # Errors
    /// The options contradict each other.
    pub fn linearize(&self) -> Result<Linearize, Error> {
        Linearize::of(self)
    }

    /// Creates a request to compile the robot for inverse dynamics, poses, Jacobians and mass
    /// matrices of batches of states, each a row of coordinates.
    pub fn states(&self) -> Compile {
        Compile::of(self)
    }

    /// Compiles inverse dynamics for a control loop, at the first instant of the default motion and with the
    /// actuators as independent coordinates. The data are allocated once.
    ///
    /// ```
    /// let robot = stiction::Robot::builtin("five-bar")?;
    /// let stiction::ControlLoop { model, mut data, position } = robot.control_loop()?;
    /// // In each cycle: positions, rates and accelerations of the actuators in, efforts out.
    /// let (rate, acceleration) = ([0.1, 0.1], [0.0, 0.0]);
    /// let status = model.inverse_dynamics(&mut data, &position, &rate, &acceleration, &[]);
    /// assert!(status.is_converged());
    /// println!("{:?} N m", data.efforts());
    /// # Ok::<(), stiction::Error>(())
    /// ```
    ///
    /// # Errors
    /// The model has several motions but no default motion, the actuators do not determine the
    /// motion, or the position is singular.
    pub fn control_loop(&self) -> Result<ControlLoop, Error> {
        ControlLoop::new(self)
    }

    /// Creates an export of inverse dynamics with friction as source code for a controller. The
    /// inputs of the code are the positions, rates and accelerations of the actuators.
    ///
    /// ```
    /// let robot = stiction::Robot::builtin("five-bar")?;
    /// let files = robot.export().vectors(5).files()?;
    /// assert_eq!((files[0].name.as_str(), files[1].name.as_str()), ("five_bar.h", "five_bar.c"));
    /// # Ok::<(), stiction::Error>(())
    /// ```
    pub fn export(&self) -> Export {
        Export::of(self)
    }

    /// Creates a comparison of control laws on the simulated robot: laws without friction
    /// compensation, with constant friction of each actuator, and with the friction of the model.
    pub fn compensation(&self) -> Compensation {
        Compensation::of(self)
    }

    /// Creates a study of many designs. Each row of the study contains statistics of inverse
    /// dynamics for one set of parameter values.
    ///
    /// # Errors
    /// The robot was described by code and has no text whose values could be changed.
    pub fn sweep(&self) -> Result<Sweep, Error> {
        Sweep::of(self)
    }
}
