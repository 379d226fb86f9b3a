//! Computations on a robot.

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
    /// Computes actuator efforts, joint reactions and joint friction along a motion (inverse dynamics).
    pub fn inverse(&self) -> Inverse {
        Inverse::of(self)
    }

    /// Computes the motion under given efforts, controllers, loads and locks (forward dynamics).
    pub fn forward(&self) -> Forward {
        Forward::of(self)
    }

    /// Checks mobility, redundancy and singularities along the model's default motion.
    ///
    /// # Errors
    /// The model has no default motion, or the mechanism cannot follow it.
    pub fn check(&self) -> Result<Report, Error> {
        self.check_along().run()
    }

    /// Checks mobility, redundancy and singularities along a motion that the request sets.
    pub fn check_along(&self) -> Check {
        Check::of(self)
    }

    /// Computes static friction of the robot at rest at a position of its motion: the interval in which each
    /// actuator's effort can lie, and the efforts at which motion begins.
    pub fn breakaway(&self) -> Breakaway {
        Breakaway::of(self)
    }

    /// Finds the static equilibrium without friction: the position in which the robot rests under gravity, springs,
    /// loads and given efforts, and its stability.
    ///
    /// # Errors
    /// The options contradict each other.
    pub fn equilibrium(&self) -> Result<Rests, Error> {
        Rests::of(self)
    }

    /// Computes a linear model about an operating point: A, B, C, D in independent coordinates.
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

    /// Computes inverse dynamics, poses, Jacobians and mass matrices for batches of states (rows of coordinates).
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
    /// The model has no default motion, the actuators do not determine the motion, or the position is
    /// singular.
    pub fn control_loop(&self) -> Result<ControlLoop, Error> {
        ControlLoop::new(self)
    }

    /// Exports inverse dynamics with friction as source code for a controller; its inputs are the coordinates of the
    /// actuators.
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

    /// Compares control laws on the simulated robot: without friction compensation, with constant friction of each
    /// actuator, and with the friction of the model.
    pub fn compensation(&self) -> Compensation {
        Compensation::of(self)
    }

    /// Studies many designs. Each row of the study contains statistics of inverse dynamics for one
    /// set of parameter values.
    ///
    /// # Errors
    /// The robot was described by code and has no text whose values could be changed.
    pub fn sweep(&self) -> Result<Sweep, Error> {
        Sweep::of(self)
    }
}
