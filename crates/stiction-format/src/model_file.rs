//! A model: a mechanism, its motions and its loads.

use crate::diagnostic::{Diagnostics, number};
use crate::law::Law;
use crate::parameters::Parameters;
use crate::signal::Signal;
use crate::signal::samples::SampleTimes;
use crate::visual::{self, Visual};
use stiction_core::dynamics::{AppliedLoad, FrictionMode, LoadAxes};
use stiction_core::kinematics::{Coordinate, Target};
use stiction_core::mechanism::{Body, BodyId, JointId, Mechanism};
use stiction_core::spatial::{Pose, Vec3};

/// Contents of a model file: a mechanism, its motions and its loads.
#[derive(Clone, Debug)]
pub struct ModelFile {
    /// Name of the mechanism.
    pub name: String,
    /// One-line description, including the changes made to the text ([`crate::Source::with_changes`]); may be empty.
    pub title: String,
    /// Source of the model's numbers, such as a publication; may be empty.
    pub source: String,
    /// Mechanism of the model.
    pub mechanism: Mechanism,
    /// Initial guesses of body poses, in the ground's frame.
    pub initial_poses: Vec<(BodyId, Pose<f64>)>,
    /// Motions by name, in the order of the file.
    pub motions: Vec<(String, Motion)>,
    /// Loads by name, in the order of the file.
    pub loads: Vec<(String, LoadCase)>,
    /// Name of the motion used by default.
    pub default_motion: Option<String>,
    /// Name of the load used by default.
    pub default_load: Option<String>,
    /// Friction mode used by default.
    pub default_friction: Option<FrictionMode>,
    /// Legs of robots with equal legs around an axis; empty for other models.
    pub legs: Vec<Leg>,
    /// Meshes for the display of bodies; [`Self::load_meshes`] reads their files.
    pub visuals: Vec<Visual>,
    /// Warnings about suspicious input. They do not affect results.
    pub warnings: Diagnostics,
    pub(crate) parameters: Parameters,
}

impl From<Mechanism> for ModelFile {
    /// Creates a model with this mechanism, without motions, loads or parameters.
    fn from(mechanism: Mechanism) -> Self {
        Self {
            name: mechanism.name().to_owned(),
            title: String::new(),
            source: String::new(),
            mechanism,
            initial_poses: Vec::new(),
            motions: Vec::new(),
            loads: Vec::new(),
            default_motion: None,
            default_load: None,
            default_friction: None,
            legs: Vec::new(),
            visuals: Vec::new(),
            warnings: Diagnostics::new(),
            parameters: Parameters::default(),
        }
    }
}

/// Leg of a model that defines its legs by one common chain.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Leg {
    /// Name, by default the prefix of the names of its joints and bodies: `leg1` of `leg1.P`.
    pub name: String,
    /// Joints, from the base to the platform.
    pub joints: Vec<JointId>,
    /// Bodies between the joints.
    pub bodies: Vec<BodyId>,
}

/// A prescribed motion.
#[derive(Clone, Debug)]
pub struct Motion {
    /// One-line description; may be empty.
    pub title: String,
    /// Time of the first sample, s.
    pub start: f64,
    /// Duration, s; zero for a single pose.
    pub duration: f64,
    /// Time step of the computed results, s; `None` for the default.
    pub step: Option<f64>,
    /// Sample times of the recording that defines the motion, s, strictly increasing; `None` if the
    /// motion is not a recording.
    pub samples: Option<SampleTimes>,
    /// Prescribed coordinates with their signals, rad or m.
    pub coordinates: Vec<(Coordinate, Signal)>,
    /// Description, in words, of the interpolation between the samples of a recording or between
    /// waypoints; `None` if the coordinates are formulas.
    pub interpolation: Option<String>,
    /// Peak speeds and accelerations of recorded coordinates, one sentence each.
    pub notes: Vec<String>,
    /// Warnings about the text of the motion, and about doubtful data of a recording: noise,
    /// outliers, columns that contradict each other.
    pub warnings: Diagnostics,
}

impl Motion {
    /// Creates a motion of zero duration that prescribes no coordinates.
    pub fn pose() -> Self {
        Self {
            title: String::new(),
            start: 0.0,
            duration: 0.0,
            step: None,
            samples: None,
            coordinates: Vec::new(),
            interpolation: None,
            notes: Vec::new(),
            warnings: Diagnostics::default(),
        }
    }

    /// Values, rates and accelerations of the prescribed coordinates at time `t` (s), in the order
    /// of `coordinates`.
    pub fn at(&self, t: f64) -> impl Iterator<Item = Target<f64>> + '_ {
        self.signals().map(move |signal| signal.at(t))
    }

    /// Returns the warnings about the motion, one sentence each, with advice.
    pub fn cautions(&self) -> impl Iterator<Item = String> {
        self.warnings.iter().map(|doubt| match &doubt.help {
            Some(help) => format!("{}; {help}", doubt.message),
            None => doubt.message.clone(),
        })
    }

    /// Signals of all prescribed coordinates.
    pub fn signals(&self) -> impl Iterator<Item = &Signal> {
        self.coordinates.iter().map(|(_, signal)| signal)
    }
}

/// Actuator efforts as functions of time, or as formulas that also depend on the measured state.
#[derive(Clone, Debug, Default)]
pub struct Drives {
    /// One-line description; may be empty.
    pub title: String,
    /// Efforts as functions of time, N or N m, by actuator index ([`Mechanism::actuators`]).
    /// Actuators that are neither in this list nor in `laws` have zero effort.
    pub efforts: Vec<(usize, Signal)>,
    /// Efforts as formulas of measured coordinates, N or N m, by actuator index; no actuator is in
    /// both lists.
    pub laws: Vec<(usize, Law)>,
    /// Sample times of recorded efforts, s, strictly increasing; `None` if the efforts are not
    /// recorded.
    pub samples: Option<SampleTimes>,
    /// Description of the interpolation between the samples of recorded efforts, in words.
    pub interpolation: Option<String>,
}

impl Drives {
    /// Indices of all actuators that have an effort.
    pub fn actuators(&self) -> impl Iterator<Item = usize> {
        let laws = self.laws.iter().map(|(actuator, _)| *actuator);
        self.efforts.iter().map(|(actuator, _)| *actuator).chain(laws)
    }
}

/// Control law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ControlType {
    /// Proportional-derivative control of each actuator.
    Pd,
    /// Proportional-integral-derivative control of each actuator.
    Pid,
    /// Inverse dynamics for the reference acceleration, corrected by the tracking errors.
    ComputedTorque,
}

/// Motion at which a computed-torque controller evaluates its friction model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrictionFeed {
    /// No friction compensation.
    Off,
    /// The reference motion.
    Reference,
    /// The measured motion of the actuators' joints.
    Measured,
}

/// Controller of the actuators: control law, sampling and gains.
#[derive(Clone, Debug, PartialEq)]
pub struct Control {
    /// One-line description; may be empty.
    pub title: String,
    /// Control law.
    pub control: ControlType,
    /// Motion at which the controller evaluates friction for its compensation.
    pub friction: FrictionFeed,
    /// Sampling period, s; zero for a controller in continuous time.
    pub period: f64,
    /// Natural frequency of the closed loop without friction, rad/s, if given.
    pub bandwidth: Option<f64>,
    /// Damping ratio of the closed loop without friction.
    pub damping: f64,
    /// True if rates are computed as differences of measured positions.
    pub differences: bool,
    /// Settings of each actuator, by actuator index ([`Mechanism::actuators`]).
    pub channels: Vec<Channel>,
    /// Indices of the actuators for which the file has settings.
    pub named: Vec<usize>,
}

impl Control {
    /// Natural frequency of the closed loop of default gains, rad/s. A controller with coupled
    /// actuators may need a lower one.
    pub const USUAL_BANDWIDTH: f64 = core::f64::consts::TAU * 10.0;
}

impl Channel {
    /// Channel without given gains, with exact measurement and without an effort limit.
    pub const NONE: Self = Self {
        proportional: None,
        derivative: None,
        integral: None,
        tracking: None,
        resolution: 0.0,
        limit: f64::INFINITY,
    };
}

/// Settings of a controller for one actuator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Channel {
    /// Position gain, N/m or N m/rad, if given.
    pub proportional: Option<f64>,
    /// Rate gain, N s/m or N m s/rad, if given.
    pub derivative: Option<f64>,
    /// Integral gain, N/(m s) or N m/(rad s), if given.
    pub integral: Option<f64>,
    /// Time constant, s, with which the integral term leaves saturation (anti-windup tracking), if given.
    pub tracking: Option<f64>,
    /// Resolution of the measured position, m or rad; zero for exact positions.
    pub resolution: f64,
    /// Effort limit, N or N m; infinite for no limit.
    pub limit: f64,
}

/// Load case: external forces and moments on bodies, and payloads.
#[derive(Clone, Debug, Default)]
pub struct LoadCase {
    /// One-line description; may be empty.
    pub title: String,
    /// Forces and moments on bodies as functions of time, at most one entry per body.
    pub wrenches: Vec<AppliedWrench>,
    /// Force and moment components that are formulas of the measured state, in addition to
    /// `wrenches`; only simulations use them.
    pub laws: Vec<LoadLaw>,
    /// Payloads that bodies carry during intervals of time.
    pub payloads: Vec<Payload>,
}

/// A component of a force or moment on a body as a formula of the measured state.
#[derive(Clone, Debug)]
pub struct LoadLaw {
    /// Body on which the force or moment acts.
    pub body: BodyId,
    /// Point of application, in the frame of the body, m.
    pub point: Vec3<f64>,
    /// Axes in which the force or moment is expressed.
    pub axes: LoadAxes,
    /// Component: 0 to 2 of the force, 3 to 5 of the moment about the point.
    pub component: usize,
    /// Formula of the component, N or N m.
    pub law: Law,
}

impl LoadLaw {
    /// Returns a load whose component `component` has the value `value`, N or N m; all other
    /// components are zero.
    pub fn load(&self, value: f64) -> AppliedLoad<f64> {
        let mut components = [0.0; 6];
        components[self.component.min(5)] = value;
        let [fx, fy, fz, mx, my, mz] = components;
        AppliedLoad {
            body: self.body,
            point: self.point,
            axes: self.axes,
            force: Vec3::new(fx, fy, fz),
            moment: Vec3::new(mx, my, mz),
        }
    }
}

/// Part that a body carries during an interval of time.
#[derive(Clone, Debug, PartialEq)]
pub struct Payload {
    /// Body that carries the payload.
    pub body: BodyId,
    /// Mass, centre of mass and inertia of the part, in the frame of the body that carries it.
    pub part: Body,
    /// Time at which the payload is picked up, s; -infinity if it is carried from the beginning.
    pub from: f64,
    /// Time at which the payload is placed, s; infinity if it is never placed.
    pub until: f64,
}

/// Event at which a payload is picked up or placed.
#[derive(Clone, Copy, Debug)]
pub struct PayloadChange<'a> {
    /// Time of the change, s.
    pub time: f64,
    /// Payload that is picked up or placed.
    pub payload: &'a Payload,
    /// True if the payload is picked up, false if it is placed.
    pub picked_up: bool,
}

impl PayloadChange<'_> {
    /// Tests if the change occurs at this time, s, or earlier.
    pub fn is_due(&self, time: f64) -> bool {
        self.time <= time + SAME_TIME
    }
}

/// Side of an instant. A load may be discontinuous at the instant and differ between both sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Just before the instant.
    Before,
    /// Just after the instant.
    After,
}

/// Tolerance of times, s: times that differ by less are regarded as the same instant.
const SAME_TIME: f64 = 1e-9;

impl Payload {
    /// Tests if the body carries the payload just before or just after the time `time`, s.
    pub fn is_carried(&self, time: f64, side: Side) -> bool {
        let time = match side {
            Side::Before => time - SAME_TIME,
            Side::After => time + SAME_TIME,
        };
        (self.from..self.until).contains(&time)
    }

    /// Tests if the payload is picked up or placed at the time `time`, s.
    pub fn changes_at(&self, time: f64) -> bool {
        self.is_carried(time, Side::Before) != self.is_carried(time, Side::After)
    }
}

impl LoadCase {
    /// Returns the mechanism with all payloads fixed to their bodies, and this load case without
    /// payloads, valid from `start` to `end`, s.
    ///
    /// # Errors
    /// If a payload is picked up or placed within this interval, returns this payload.
    pub fn attached(
        &self,
        mechanism: &Mechanism,
        (start, end): (f64, f64),
    ) -> Result<(Mechanism, Self), &Payload> {
        if let Some(change) = self.payload_changes((start, end)).first() {
            return Err(change.payload);
        }
        let loaded = self.loaded(mechanism, start);
        Ok((loaded, Self { payloads: Vec::new(), ..self.clone() }))
    }

    /// Returns all events between two times, s, at which payloads are picked up or placed, in order
    /// of time. At the same instant, payloads are placed before others are picked up.
    pub fn payload_changes(&self, (start, end): (f64, f64)) -> Vec<PayloadChange<'_>> {
        let inside = |time: f64| (start + SAME_TIME..end - SAME_TIME).contains(&time);
        let mut changes: Vec<PayloadChange<'_>> = Vec::new();
        for payload in self.payloads.iter().filter(|payload| payload.from < payload.until) {
            for (time, picked_up) in [(payload.until, false), (payload.from, true)] {
                if inside(time) {
                    changes.push(PayloadChange { time, payload, picked_up });
                }
            }
        }
        changes.sort_by(|a, b| a.time.total_cmp(&b.time).then(a.picked_up.cmp(&b.picked_up)));
        changes
    }

    /// Returns a caution for each payload that is never carried between two times, s.
    pub fn cautions(&self, mechanism: &Mechanism, (start, end): (f64, f64)) -> Vec<String> {
        let is_carried = |payload: &Payload| match start < end {
            true => payload.from.max(start) + SAME_TIME < payload.until.min(end),
            false => payload.is_carried(start, Side::After),
        };
        let never = self.payloads.iter().filter(|payload| !is_carried(payload));
        let caution = |payload: &Payload| {
            let body = &mechanism.bodies()[payload.body.0].name;
            let (mass, reason) = (
                number(payload.part.mass),
                match payload.from + SAME_TIME < end {
                    true => format!(
                        "is placed at {} s, but the computation begins at {} s",
                        number(payload.until),
                        number(start)
                    ),
                    false => format!(
                        "is picked up at {} s, but the computation ends at {} s",
                        number(payload.from),
                        number(end)
                    ),
                },
            );
            format!(
                "the payload of {mass} kg on `{body}` is never carried: it {reason}; correct its `from` and `until`"
            )
        };
        never.map(caution).collect()
    }

    /// Returns the mechanism with the payloads that are carried just after `time`, s, fixed to
    /// their bodies.
    pub fn loaded(&self, mechanism: &Mechanism, time: f64) -> Mechanism {
        let carried = self.payloads.iter().filter(|payload| payload.is_carried(time, Side::After));
        carried.fold(mechanism.clone(), |mechanism, payload| {
            mechanism.with_payload(payload.body, &payload.part)
        })
    }

    /// Tests if any payload is picked up or placed at the time `time`, s.
    pub fn jumps_at(&self, time: f64) -> bool {
        self.payloads.iter().any(|payload| payload.changes_at(time))
    }

    /// Forces and moments at time `t` (s), without payloads.
    pub fn at(&self, t: f64) -> impl Iterator<Item = AppliedLoad<f64>> + '_ {
        self.wrenches.iter().map(move |wrench| wrench.at(t))
    }

    /// Signals of all force and moment components of the wrenches.
    pub fn signals(&self) -> impl Iterator<Item = &Signal> {
        self.wrenches.iter().flat_map(|wrench| wrench.force.iter().chain(&wrench.moment))
    }
}

/// A force and a moment on a body as functions of time.
#[derive(Clone, Debug)]
pub struct AppliedWrench {
    /// Body on which the force and the moment act.
    pub body: BodyId,
    /// Point of application, in the frame of the body, m.
    pub point: Vec3<f64>,
    /// Axes in which force and moment are expressed.
    pub axes: LoadAxes,
    /// Components of the force, N.
    pub force: [Signal; 3],
    /// Components of the moment about the point, N m.
    pub moment: [Signal; 3],
}

impl AppliedWrench {
    /// Force and moment at time `t` (s).
    pub fn at(&self, t: f64) -> AppliedLoad<f64> {
        let vector = |signals: &[Signal; 3]| {
            let [x, y, z] = signals.each_ref().map(|signal| signal.at(t).value);
            Vec3::new(x, y, z)
        };
        AppliedLoad {
            body: self.body,
            point: self.point,
            axes: self.axes,
            force: vector(&self.force),
            moment: vector(&self.moment),
        }
    }
}

impl ModelFile {
    /// Messages of the warnings that state how results differ from those of the imported robot file.
    pub fn import_warnings(&self) -> impl Iterator<Item = String> {
        self.warnings.iter().filter(|own| own.code == "import").map(|own| own.message.clone())
    }

    /// Reads the files of the meshes; `files` returns the bytes of a file that the model names, or
    /// the reason for a failure. A mesh that cannot be shown adds a warning to `warnings`.
    pub fn load_meshes(&mut self, files: &dyn Fn(&str) -> Result<Vec<u8>, String>) {
        visual::load(&mut self.visuals, &mut self.warnings, files);
    }

    /// Parameters with their values and SI units, in the order of the file; an angle is in rad, and the unit
    /// of a plain number is empty.
    pub fn parameters(&self) -> impl Iterator<Item = (&str, f64, String)> {
        self.parameters.all()
    }

    /// Returns the motion with this name.
    pub fn motion(&self, name: &str) -> Option<&Motion> {
        self.motions.iter().find(|(known, _)| known == name).map(|(_, motion)| motion)
    }

    /// Returns the load case with this name.
    pub fn load(&self, name: &str) -> Option<&LoadCase> {
        self.loads.iter().find(|(known, _)| known == name).map(|(_, load)| load)
    }

    /// Returns the leg to which a joint belongs; `None` for a joint outside the legs.
    pub fn leg_of_joint(&self, joint: JointId) -> Option<&Leg> {
        self.legs.iter().find(|leg| leg.joints.contains(&joint))
    }
}
