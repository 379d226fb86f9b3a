//! Requests: computations on a robot, with the options that all kinds of computation share.

use crate::error::Error;
use crate::robot::Robot;
use crate::stream::{Sender, Stream};
use stiction_core::dynamics::FrictionMode;
use stiction_format::{LoadCase, Motion};
use stiction_run::{Job, SinkError};

/// A computation on a robot, with the options common to all computations. `T` contains the options
/// of one kind of computation: [`Inverse`](crate::Inverse), [`Forward`](crate::Forward),
/// [`Check`](crate::Check), [`Breakaway`](crate::Breakaway) or [`Compile`](crate::Compile).
///
/// By default, a request uses the default motion and the default load of the model. A check has no
/// load.
#[derive(Clone, Debug)]
pub struct Request<T> {
    pub(crate) robot: Robot,
    pub(crate) motion: Option<(Motion, String)>,
    pub(crate) load: (LoadCase, String),
    pub(crate) step: Option<f64>,
    pub(crate) task: T,
}

/// Marker for kinds of computation that accept loads.
pub trait Loaded {}

impl<T> Request<T> {
    pub(crate) fn new(robot: &Robot, task: T) -> Self {
        let (motion, load) = (robot.default_motion(), robot.default_load());
        Self { robot: robot.clone(), motion, load, step: None, task }
    }

    /// Sets the motion: its name in the model, the name of a file (CSV or TOML), or assignments such as
    /// `"platform.x = 5 mm*sin(2*pi*t); duration = 2 s"`.
    ///
    /// # Errors
    /// There is no such motion, or the file or the assignments are defective.
    pub fn motion(mut self, motion: &str) -> Result<Self, Error> {
        self.motion = Some(self.robot.parse_motion(motion)?);
        Ok(self)
    }

    /// Sets the load: its name in the model, or assignments such as `"platform.fz = -100 N"`.
    ///
    /// # Errors
    /// There is no such load, or the assignments are defective.
    pub fn load(mut self, load: &str) -> Result<Self, Error>
    where
        T: Loaded,
    {
        self.load = self.robot.parse_load(load)?;
        Ok(self)
    }

    /// Sets the time between samples, s. Default: the time step of the motion, else 0.01 s. The
    /// time between samples does not affect the integration steps.
    pub fn step(mut self, step: f64) -> Self {
        self.step = Some(step);
        self
    }

    /// Converts the request to a job of `stiction_run` along the motion, with the given friction
    /// mode.
    pub(crate) fn along(&self, friction: FrictionMode) -> Result<Job<'_>, Error> {
        let (motion, name) = self.motion.as_ref().ok_or_else(|| self.robot.motion_missing())?;
        let load = (self.load.1.as_str(), &self.load.0);
        let along = Job::new(self.robot.model(), (name, motion), load);
        Ok(Job { friction, step: self.step, ..along })
    }
}

/// Kind of computation that returns samples one by one.
pub trait Sampled: Clone + Send + 'static {
    /// Results at one instant.
    type Sample: Send + 'static;
    /// Results for the whole computation.
    type Outcome: Send + 'static;

    /// Completes and checks the options.
    #[doc(hidden)]
    fn complete(request: &Request<Self>) -> Result<Request<Self>, Error>;

    /// Computes all samples of a complete request.
    #[doc(hidden)]
    fn compute(
        request: &Request<Self>,
        receive: &mut dyn FnMut(Self::Sample) -> Result<(), SinkError>,
        is_stopped: &dyn Fn() -> bool,
    ) -> Result<Self::Outcome, Error>;
}

impl<T: Sampled> Request<T> {
    /// Starts the computation and returns its samples one by one, in the order of time.
    ///
    /// The computation runs on a separate thread, at most 64 samples ahead, so that memory is
    /// bounded for any duration. The computation stops when the iterator is dropped. If the
    /// computation cannot continue, the last item of the iterator is an error.
    ///
    /// # Errors
    /// There is no motion, or the options contradict each other.
    pub fn samples(&self) -> Result<Samples<T>, Error> {
        let request = T::complete(self)?;
        let stream = Stream::start(move |sender: &Sender<T::Sample>| {
            T::compute(&request, &mut |sample| sender.send(sample), &|| sender.is_stopped())
        })?;
        Ok(Samples { stream })
    }

    /// Computes all samples on the calling thread and passes each to `receive`, in the order of
    /// time. Stops at the first error that `receive` returns.
    ///
    /// # Errors
    /// The errors of [`Request::samples`]; the computation cannot continue; or the error of
    /// `receive`.
    pub fn each(
        &self,
        mut receive: impl FnMut(T::Sample) -> Result<(), Error>,
    ) -> Result<T::Outcome, Error> {
        T::compute(&T::complete(self)?, &mut |sample| Ok(receive(sample)?), &|| false)
    }

    /// Computes all samples and keeps them in memory.
    ///
    /// # Errors
    /// See [`Request::each`].
    pub fn collect(&self) -> Result<Vec<T::Sample>, Error> {
        let mut all = Vec::new();
        self.each(|sample| {
            all.push(sample);
            Ok(())
        })?;
        Ok(all)
    }
}

/// Iterator over the samples of a computation; see [`Request::samples`].
pub struct Samples<T: Sampled> {
    stream: Stream<T::Sample, T::Outcome>,
}

impl<T: Sampled> Samples<T> {
    /// Results for the whole computation, available after the iterator has returned all samples.
    /// Inverse dynamics returns mobility, uniqueness and passages through singular positions; a
    /// simulation returns its events.
    pub fn outcome(&self) -> Option<&T::Outcome> {
        self.stream.result()
    }
}

impl<T: Sampled> Iterator for Samples<T> {
    type Item = Result<T::Sample, Error>;

    fn next(&mut self) -> Option<Self::Item> {
        self.stream.next()
    }
}
