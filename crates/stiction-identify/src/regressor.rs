//! Columns of the regression for a mechanism with loops, computed by the principle of virtual
//! power.
//!
//! Equation (I1) of the book's theory.

use crate::apply::{carried_preload, scale_laws, set_static_excess, set_viscous};
use crate::parameter::{Choice, INERTIA_ENTRIES, Kind, Parameter, catalogue};
use crate::slip::{Rest, Slip, sign};
use crate::solved::Solved;
use nalgebra::{DMatrix, DVector, Dyn, LU};
use stiction_core::dynamics::{
    Data, FrictionMode, InverseDynamics, Model, RotorMotion, Settings, Status,
};
use stiction_core::kinematics::{Bodies, State, Target};
use stiction_core::mechanism::{DriveTrain, Mechanism};
use stiction_core::parameters::{Parameters, RotorParameters};
use stiction_core::spatial::{Mat3, Twist, Vec3, Wrench};
use thiserror::Error;

/// A moment about the free spin axis of a body counts as round-off up to this fraction of the
/// moment that accelerates the body and supports its weight.
const ROUND_OFF: f64 = 1e-12;

/// Reason why a mechanism with its prescribed coordinates cannot be identified.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Unsuitable {
    /// The efforts do not follow from the motion: there are more or fewer actuators than coordinates.
    #[error(
        "the mechanism has {actuators} actuators for {coordinates} independent coordinates, \
        but identification needs one actuator for each"
    )]
    Actuation {
        /// Number of actuators.
        actuators: usize,
        /// Number of prescribed coordinates.
        coordinates: usize,
    },
    /// The forces in the first configuration of the motion have no solution; the text is the
    /// reason.
    #[error("{0}")]
    Singular(String),
}

/// Efforts at one instant as a linear function of the parameters.
#[derive(Clone, Debug)]
pub struct Columns {
    /// Effort of each actuator (rows) per unit of each parameter (columns). For a friction coefficient it is the effort
    /// per unit of friction force and must be multiplied by the normal load; for an excess of static friction, the
    /// factor is the sliding friction at high speed.
    pub matrix: DMatrix<f64>,
    /// Efforts of the model without friction, N or N m.
    pub known: DVector<f64>,
    /// State, sliding or rest, of the friction that each effort contains. Friction at rest is
    /// bounded but not determined.
    pub rest: Vec<Rest>,
}

/// Computation of [`Columns`] at instants of a motion.
#[derive(Clone, Debug)]
pub struct Regressor {
    solver: InverseDynamics,
    model: Model,
    data: Data<f64>,
    unit: Data<f64>,
    parameters: Vec<Parameter>,
    nominal: Parameters<f64>,
    virtual_twists: Vec<Vec<Twist<f64>>>,
    surface_rates: Vec<Vec<[f64; 3]>>,
    /// For each coordinate, the rates of all actuated degrees of freedom at a unit rate of this
    /// coordinate.
    actuator_rates: Vec<Vec<f64>>,
    /// Acceleration of each body at the present motion.
    accelerations: Vec<Twist<f64>>,
    /// Standard deviation of the measured rate of each coordinate, rad/s or m/s.
    rate_noise: Vec<f64>,
    at_motors: bool,
    /// Rotors that spin on bodies, with moments of inertia of 1 kg m^2, each with the index of its
    /// drive train.
    unit_rotors: Vec<(usize, RotorParameters<f64>)>,
    /// True if [`Self::at`] has compiled the model again.
    is_compiled_again: bool,
}

/// Rotors that spin on bodies, each with the index of its drive train. `inertia` returns the moment of
/// inertia of the rotor of a drive train, kg m^2, if it differs from that of the model.
fn spinning_rotors(
    mechanism: &Mechanism,
    inertia: impl Fn(usize) -> Option<f64>,
) -> Vec<(usize, RotorParameters<f64>)> {
    let trains = mechanism.drive_trains().iter().enumerate();
    let each = trains.flat_map(|(index, train)| {
        let rotor_inertia = inertia(index).unwrap_or(train.rotor_inertia);
        let own = DriveTrain { rotor_inertia, ..train.clone() };
        let rotors: Vec<_> = RotorParameters::of(&own).collect();
        rotors.into_iter().map(move |rotor| (index, rotor))
    });
    each.collect()
}

impl Regressor {
    /// Prepares the computation; `solver` is in the first configuration of the motion.
    ///
    /// # Errors
    /// [`Unsuitable`] if the numbers of actuators and coordinates differ, or if the configuration
    /// is singular.
    pub fn new(mut solver: InverseDynamics, choice: &Choice) -> Result<Self, Unsuitable> {
        let coordinates = solver.constraints().coordinates().len();
        let actuators = solver.mechanism().actuators().count();
        if coordinates != actuators {
            return Err(Unsuitable::Actuation { actuators, coordinates });
        }
        // The solution of the forces compiles the model for this configuration.
        solver.settings_mut().friction = FrictionMode::Off;
        solver.solve(&[]).map_err(|error| Unsuitable::Singular(error.to_string()))?;
        let model = solver.model().map_err(|error| Unsuitable::Singular(error.to_string()))?;
        let settings = Settings { friction: FrictionMode::Off, ..Settings::default() };
        let data = model.data(solver.state(), settings);
        let parameters = catalogue(solver.mechanism(), choice);
        let nominal = model.parameters().clone();
        let unit = data.clone();
        let interfaces = nominal.interfaces.len();
        let bodies = solver.mechanism().bodies().len();
        let unit_rotors = spinning_rotors(solver.mechanism(), |_| Some(1.0));
        Ok(Self {
            solver,
            model,
            unit,
            data,
            parameters,
            nominal,
            virtual_twists: vec![vec![Twist::zero(); bodies]; coordinates],
            surface_rates: vec![vec![[0.0; 3]; interfaces]; coordinates],
            actuator_rates: vec![vec![0.0; actuators]; coordinates],
            accelerations: vec![Twist::zero(); bodies],
            rate_noise: vec![0.0; coordinates],
            at_motors: choice.at_motors,
            unit_rotors,
            is_compiled_again: false,
        })
    }

    /// Sets the standard deviation of the measured rate of each coordinate, rad/s or m/s. The
    /// direction of friction is unknown if a speed is less than three standard deviations.
    pub fn set_rate_noise(&mut self, noise: &[f64]) {
        self.rate_noise.clear();
        self.rate_noise.extend_from_slice(noise);
    }

    /// Returns the parameters in the order of the columns.
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// Returns the names of the bodies that can spin freely about their own axis, such as a rod
    /// between two ball joints. The inertia of such a body is treated as symmetric about this axis.
    pub fn spinning_bodies(&self) -> Vec<&str> {
        let spins = self.model.constraints().spins().iter();
        spins.map(|spin| self.mechanism().bodies()[spin.body.0].name.as_str()).collect()
    }

    /// Mechanism whose efforts are computed.
    pub fn mechanism(&self) -> &Mechanism {
        self.solver.mechanism()
    }

    /// Compiled model of the mechanism.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Motion of all bodies at the last call of [`Self::at`].
    pub fn bodies(&self) -> &Bodies<f64> {
        &self.data.kinematics.bodies
    }

    /// State of the mechanism at the last call of [`Self::at`].
    pub fn state(&self) -> &State<f64> {
        &self.data.state
    }

    /// Makes the next call of [`Self::at`] start from `state`, a state of the same mechanism, and
    /// therefore in the assembly mode of `state`.
    pub fn start_from(&mut self, state: &State<f64>) {
        // A state of another mechanism is not used.
        if state.coordinates.len() == self.data.state.coordinates.len() {
            self.data.start_from(state);
        }
    }

    /// Computes the columns for positions, rates and accelerations of the prescribed coordinates.
    ///
    /// # Errors
    /// Returns the reason why the efforts have no solution. The next call then starts from the last
    /// valid configuration.
    pub fn at(&mut self, q: &[f64], v: &[f64], a: &[f64]) -> Result<Columns, Status> {
        let status = self.efforts_at(q, v, a);
        if !status.is_converged() && !self.compiled_again(q, v, a) {
            return Err(status);
        }
        let known = DVector::from_column_slice(self.data.efforts());
        let count = q.len();
        let mut rates = vec![0.0; count];
        let rest = vec![0.0; count];
        let mut actuation = DMatrix::zeros(count, count);
        self.unit.start_from(&self.data.state);
        self.set_accelerations([q, v, a]);
        for k in 0..count {
            rates.fill(0.0);
            rates[k] = 1.0;
            let status = self.model.move_to(&mut self.unit, q, &rates, &rest);
            if !status.is_converged() {
                return Err(status);
            }
            let bodies = &self.unit.kinematics.bodies;
            self.virtual_twists[k].clone_from(&bodies.twist);
            let topology = self.model.topology();
            for (row, (joint, dof)) in self.mechanism().actuators().enumerate() {
                actuation[(k, row)] = bodies.joint_rates(topology, joint.0)[dof];
            }
            for (index, interface) in self.nominal.interfaces.iter().enumerate() {
                let pitch = self.nominal.pitch[interface.joint];
                let surface = bodies.surface_velocity(topology, interface, pitch);
                self.surface_rates[k][index] = surface;
            }
            self.actuator_rates[k].clear();
            self.actuator_rates[k].extend(actuation.row(k).iter());
        }
        let lu = actuation.lu();
        if !lu.is_invertible() {
            return Err(Status::Singular);
        }
        Ok(self.assembled(known, &lu))
    }

    /// Sets the accelerations of the bodies. The free spin of a body accelerates by the unbalanced
    /// moment divided by the body's small inertia. If this moment is round-off, the acceleration is
    /// that of the prescribed motion without spin.
    fn set_accelerations(&mut self, [q, v, a]: [&[f64]; 3]) {
        let bodies = &self.data.kinematics.bodies;
        self.accelerations.clone_from(&bodies.acceleration);
        let spins = self.model.constraints().spins();
        if spins.is_empty() || !self.model.move_to(&mut self.unit, q, v, a).is_converged() {
            return;
        }
        let length = self.solver.mechanism().characteristic_length();
        for body in spins.iter().map(|spin| spin.body.0) {
            let calm = self.unit.kinematics.bodies.acceleration[body];
            let change = (bodies.acceleration[body].angular - calm.angular).norm();
            let linear = calm.velocity_at(bodies.pose[body].position) - self.nominal.gravity;
            let size = self.nominal.mass[body] * linear.norm() * length;
            let axis = self.nominal.inertia[body];
            let least = (0..3).map(|k| axis.at(k, k)).fold(f64::INFINITY, f64::min);
            if change * least <= ROUND_OFF * size {
                self.accelerations[body] = calm;
            }
        }
    }

    /// Returns the sliding velocity of each friction interface, m/s, followed by a vector for each
    /// actuator, whose first entry is the rate of the actuator, m/s or rad/s. Friction changes its
    /// sign where one of these velocities or rates reverses. Returns `None` if the model cannot
    /// follow the motion.
    pub fn sliding(&mut self, q: &[f64], v: &[f64], a: &[f64]) -> Option<Vec<[f64; 3]>> {
        self.unit.start_from(&self.data.state);
        if !self.model.move_to(&mut self.unit, q, v, a).is_converged() {
            return None;
        }
        self.data.start_from(&self.unit.state);
        let (bodies, topology) = (&self.unit.kinematics.bodies, self.model.topology());
        let interfaces = self.nominal.interfaces.iter().map(|interface| {
            bodies.surface_velocity(topology, interface, self.nominal.pitch[interface.joint])
        });
        let actuators = self.mechanism().actuators();
        let rates = actuators.map(|(id, dof)| [bodies.joint_rates(topology, id.0)[dof], 0.0, 0.0]);
        Some(interfaces.chain(rates).collect())
    }

    fn efforts_at(&mut self, q: &[f64], v: &[f64], a: &[f64]) -> Status {
        self.model.inverse_dynamics_with(&self.nominal, &mut self.data, q, v, a, &[])
    }

    /// Compiles the model again, because its elimination order is unsuitable for the configuration
    /// of the given motion. Returns whether the efforts can then be computed.
    fn compiled_again(&mut self, q: &[f64], v: &[f64], a: &[f64]) -> bool {
        let targets: Vec<Target<f64>> = (q.iter().zip(v).zip(a))
            .map(|((&value, &rate), &acceleration)| Target { value, rate, acceleration })
            .collect();
        if self.solver.move_to(&targets).is_err() || self.solver.solve(&[]).is_err() {
            return false;
        }
        let Ok(model) = self.solver.model() else { return false };
        let settings = self.data.settings;
        self.data = model.data(self.solver.state(), settings);
        self.unit = self.data.clone();
        self.model = model;
        self.is_compiled_again = true;
        self.efforts_at(q, v, a).is_converged()
    }

    /// Returns true if [`Self::at`] has compiled the model again, because the first configuration did
    /// not suit it. Later solutions of the forces need the new model, too.
    pub fn is_compiled_again(&self) -> bool {
        self.is_compiled_again
    }

    fn assembled(&self, known: DVector<f64>, actuation: &LU<f64, Dyn, Dyn>) -> Columns {
        let count = known.len();
        let bodies = &self.data.kinematics.bodies;
        let topology = self.model.topology();
        let mut matrix = DMatrix::zeros(count, self.parameters.len());
        let mut known = known;
        let mut rest = vec![Rest::Sliding; count];
        let slips: Vec<Slip> = (0..self.nominal.interfaces.len()).map(|i| self.slip(i)).collect();
        for (slip, index) in slips.iter().zip(0..) {
            if slip.rest != Rest::Sliding {
                self.mark_rest(index, slip.rest, actuation, &mut rest);
            }
        }
        for (column, parameter) in self.parameters.iter().enumerate() {
            let mut target = matrix.column_mut(column);
            match parameter.kind {
                Kind::Mass(body) | Kind::Moment(body, _) | Kind::Inertia(body, _) => {
                    let change = self.accelerations[body];
                    let unit = self.unit_wrench(parameter.kind, body, (bodies, change));
                    for k in 0..count {
                        target[k] = self.virtual_twists[k][body].power(unit);
                    }
                }
                Kind::Mu(i) | Kind::StaticExcess(i) | Kind::Coulomb(i) | Kind::Viscous(i) => {
                    let slip = &slips[i];
                    let factor = self.friction_per_unit(parameter.kind, i, slip.velocity);
                    for k in 0..count {
                        let rates = &self.surface_rates[k][i];
                        let along: f64 =
                            slip.direction.iter().zip(rates).map(|(d, rate)| d * rate).sum();
                        target[k] = factor * along;
                    }
                }
                Kind::Rotor(train) => {
                    for (body, unit) in self.unit_moments(train, bodies) {
                        for k in 0..count {
                            target[k] += self.virtual_twists[k][body].power(unit);
                        }
                    }
                }
                // Efforts of single actuators are written below.
                _ => {}
            }
        }
        // The virtual powers equal those of the efforts: A^T tau = W theta.
        let mut matrix = actuation.solve(&matrix).unwrap_or(matrix);
        for (column, parameter) in self.parameters.iter().enumerate() {
            match parameter.kind {
                Kind::Rotor(train) => {
                    // The efforts of the model contain the moment on the carrier of the rotor, but
                    // not the torque that accelerates the rotor itself.
                    known.axpy(-parameter.prior, &matrix.column(column), 1.0);
                    let along = self.rotors_of(train).map(|rotor| {
                        let axis = bodies.pose[rotor.body].rotation * rotor.axis;
                        axis.dot(self.accelerations[rotor.body].angular)
                    });
                    let along: f64 = along.sum();
                    let train = &self.mechanism().drive_trains()[train];
                    let at = (train.dofs[0].joint.0, train.dofs[0].dof);
                    let motion = bodies.joint_motion(topology, &self.nominal, at, 0.0);
                    let n = train.transmission();
                    if let Some(row) = self.actuator_of(at) {
                        matrix[(row, column)] += n * n * motion.acceleration + n * along;
                    }
                }
                Kind::DriveCoulomb(row) | Kind::DriveViscous(row) => {
                    let Some((rate, own)) = self.actuator_rate(row) else { continue };
                    let is_coulomb = matches!(parameter.kind, Kind::DriveCoulomb(_));
                    if is_coulomb {
                        rest[row] = rest[row].max(own);
                    }
                    matrix[(row, column)] = if is_coulomb { sign(rate) } else { rate };
                }
                Kind::Offset(row) => matrix[(row, column)] = 1.0,
                _ => {}
            }
        }
        self.add_motor_friction(&mut known, &mut rest);
        Columns { matrix, known, rest }
    }

    /// Adds the motor friction of the model at joints that also have joint friction. Efforts
    /// measured at motors contain both frictions, and the regression cannot distinguish them.
    fn add_motor_friction(&self, known: &mut DVector<f64>, rest: &mut [Rest]) {
        for (row, train) in self.motors_with_joint_friction() {
            let Some((rate, own)) = self.actuator_rate(row) else { continue };
            let (n, friction) = (train.transmission(), train.motor_friction);
            known[row] +=
                friction.constant * n.abs() * sign(rate) + friction.viscous * n * n * rate;
            if friction.constant > 0.0 {
                rest[row] = rest[row].max(own);
            }
        }
    }

    /// Returns the rate of the actuated degree of freedom in the row `row`, m/s or rad/s, and its
    /// state, sliding or rest; `None` for a row without an actuator.
    pub fn actuator_rate(&self, row: usize) -> Option<(f64, Rest)> {
        let (joint, dof) = self.mechanism().actuators().nth(row)?;
        let topology = self.model.topology();
        let rate = self.data.kinematics.bodies.joint_rates(topology, joint.0)[dof];
        let variance = self.actuator_rates.iter().zip(&self.rate_noise);
        let variance: f64 = variance.map(|(rates, noise)| (rates[row] * noise).powi(2)).sum();
        Some((rate, Rest::of(rate.abs(), variance)))
    }

    fn rotors_of(&self, train: usize) -> impl Iterator<Item = &RotorParameters<f64>> {
        let own = self.unit_rotors.iter().filter(move |(index, _)| *index == train);
        own.map(|(_, rotor)| rotor)
    }

    fn actuator_of(&self, (joint, dof): (usize, usize)) -> Option<usize> {
        self.mechanism().actuators().position(|(id, own)| (id.0, own) == (joint, dof))
    }

    fn slip(&self, index: usize) -> Slip {
        let interface = &self.nominal.interfaces[index];
        let pitch = self.nominal.pitch[interface.joint];
        let bodies = &self.data.kinematics.bodies;
        let surface = bodies.surface_velocity(self.model.topology(), interface, pitch);
        let speed = surface.iter().map(|s| s * s).sum::<f64>().sqrt();
        let rates = self.surface_rates.iter().zip(&self.rate_noise);
        let variance: f64 = rates
            .map(|(rates, noise)| rates[index].iter().map(|s| (s * noise).powi(2)).sum::<f64>())
            .sum();
        let rest = Rest::of(speed, variance);
        let is_resting = rest == Rest::Resting;
        let direction = if is_resting { [0.0; 3] } else { surface.map(|s| s / speed) };
        Slip { direction, velocity: speed.copysign(surface[0]), rest }
    }

    /// Sets the excess of static friction of all interfaces with Stribeck's curve, on which other
    /// columns of these interfaces depend, to its value in `values`.
    pub fn set_static_excess(&mut self, values: &[f64]) {
        for (parameter, &value) in self.parameters.iter().zip(values) {
            if let Kind::StaticExcess(i) = parameter.kind {
                set_static_excess(&mut self.nominal.interfaces[i].law, value);
            }
        }
    }

    /// Returns the friction at the surface of an interface, N, per unit of one of the interface's
    /// parameters. For a friction coefficient, the normal load is one newton; for the excess of
    /// static friction, the sliding friction is. `velocity`, m/s, is the speed with the sign of the
    /// velocity's first component.
    pub fn friction_per_unit(&self, kind: Kind, index: usize, velocity: f64) -> f64 {
        let interface = &self.nominal.interfaces[index];
        let over_arm = 1.0 / interface.arms(self.nominal.pitch[interface.joint])[0].abs();
        let speed = velocity.abs();
        let law = match &interface.backward {
            Some(backward) if velocity < 0.0 => backward,
            _ => &interface.law,
        };
        let shape =
            if interface.law.mu > 0.0 { law.coefficient(speed) / interface.law.mu } else { 1.0 };
        match kind {
            Kind::Mu(_) => shape,
            Kind::StaticExcess(_) => {
                let mut excess = law.clone();
                set_static_excess(&mut excess, 1.0);
                excess.coefficient(speed) / law.mu - 1.0
            }
            Kind::Coulomb(_) => shape * over_arm,
            Kind::Viscous(_) => speed * over_arm * over_arm,
            _ => 0.0,
        }
    }

    /// Records `own`, the state of the interface `index`, in `rest` for each effort that the
    /// friction of this interface changes.
    fn mark_rest(&self, index: usize, own: Rest, actuation: &LU<f64, Dyn, Dyn>, rest: &mut [Rest]) {
        for dof in 0..3 {
            let power = self.surface_rates.iter().map(|rates| rates[index][dof]);
            let right = DVector::from_iterator(rest.len(), power);
            let Some(efforts) = actuation.solve(&right) else { continue };
            for (mark, effort) in rest.iter_mut().zip(efforts.iter()) {
                if effort.abs() > 1e-9 {
                    *mark = (*mark).max(own);
                }
            }
        }
    }

    /// Lists the bodies whose required wrenches depend on a parameter.
    pub fn loaded_bodies(&self, kind: Kind) -> Vec<usize> {
        match kind {
            Kind::Mass(body) | Kind::Moment(body, _) | Kind::Inertia(body, _) => vec![body],
            Kind::Rotor(train) => {
                // Rotors on the ground load no joint.
                self.rotors_of(train).map(|rotor| rotor.body).filter(|body| *body > 0).collect()
            }
            _ => Vec::new(),
        }
    }

    /// Returns the wrenches about the reference point, in world axes, that bodies require per unit
    /// of a parameter for the motion of `bodies`.
    pub(crate) fn unit_demands(
        &self,
        kind: Kind,
        bodies: &Bodies<f64>,
    ) -> Vec<(usize, Wrench<f64>)> {
        match kind {
            Kind::Mass(body) | Kind::Moment(body, _) | Kind::Inertia(body, _) => {
                vec![(body, self.unit_wrench(kind, body, (bodies, bodies.acceleration[body])))]
            }
            Kind::Rotor(train) => self.unit_moments(train, bodies).collect(),
            _ => Vec::new(),
        }
    }

    /// Yields the moments that the carriers of the rotors of a drive train require because these
    /// rotors spin, per unit of the moment of inertia.
    fn unit_moments(
        &self,
        train: usize,
        bodies: &Bodies<f64>,
    ) -> impl Iterator<Item = (usize, Wrench<f64>)> {
        let topology = self.model.topology();
        self.rotors_of(train).map(move |rotor| {
            let moment = RotorMotion::of(rotor, topology, &self.nominal, bodies).moment;
            (rotor.body, Wrench { force: Vec3::zero(), moment })
        })
    }

    /// Returns the wrench about the reference point, in world axes, that a unit of an inertial
    /// parameter requires for the motion of `bodies` with the acceleration `change` of the body.
    fn unit_wrench(
        &self,
        kind: Kind,
        body: usize,
        (bodies, change): (&Bodies<f64>, Twist<f64>),
    ) -> Wrench<f64> {
        let (pose, twist) = (&bodies.pose[body], bodies.twist[body]);
        let (w, dw) = (twist.angular, change.angular);
        let origin = pose.position;
        let velocity = twist.velocity_at(origin);
        let acceleration = change.velocity_at(origin) + w.cross(velocity) - self.nominal.gravity;
        // Force, and moment about the body's origin.
        let (force, moment) = match kind {
            Kind::Mass(_) => (acceleration, Vec3::zero()),
            Kind::Moment(_, axis) => {
                let e = pose.rotation * Vec3::unit(axis);
                (dw.cross(e) + w.cross(w.cross(e)), e.cross(acceleration))
            }
            Kind::Inertia(_, entry) => {
                let (row, column) = INERTIA_ENTRIES[entry];
                let (a, b) = (pose.rotation * Vec3::unit(row), pose.rotation * Vec3::unit(column));
                let times = |v: Vec3<f64>| match row == column {
                    true => a * a.dot(v),
                    false => a * b.dot(v) + b * a.dot(v),
                };
                (Vec3::zero(), times(dw) + w.cross(times(w)))
            }
            _ => (Vec3::zero(), Vec3::zero()),
        };
        Wrench { force, moment: moment + origin.cross(force) }
    }

    /// Computes static friction limits in the configuration of the last call of [`Self::at`]. The
    /// matrix contains the limit of each effort (rows) per unit of each parameter (columns); for a
    /// coefficient of friction, also per unit of normal load. The vector contains the limits of
    /// friction that is not estimated, N or N m. `None` if the configuration is singular.
    pub fn limits(&self) -> Option<(DMatrix<f64>, DVector<f64>)> {
        let count = self.actuator_rates.len();
        let actuation = DMatrix::from_fn(count, count, |k, row| self.actuator_rates[k][row]).lu();
        let mut matrix = DMatrix::zeros(count, self.parameters.len());
        for (column, parameter) in self.parameters.iter().enumerate() {
            match parameter.kind {
                Kind::Mu(i) | Kind::Coulomb(i) => {
                    let mut squares = DVector::zeros(count);
                    for dof in 0..3 {
                        let power = self.surface_rates.iter().map(|rates| rates[i][dof]);
                        let efforts = actuation.solve(&DVector::from_iterator(count, power))?;
                        squares += efforts.map(|effort: f64| effort * effort);
                    }
                    let interface = &self.nominal.interfaces[i];
                    let laws = [Some(&interface.law), interface.backward.as_ref()].into_iter();
                    let laws = laws.flatten().filter(|law| law.mu > 0.0);
                    let ratio = laws.map(|law| law.at_rest() / law.mu).fold(1.0, f64::max);
                    let arm = match parameter.kind {
                        Kind::Mu(_) => 1.0,
                        _ => interface.arms(self.nominal.pitch[interface.joint])[0].abs(),
                    };
                    matrix.set_column(column, &squares.map(|s: f64| s.sqrt() * ratio / arm));
                }
                Kind::DriveCoulomb(row) => matrix[(row, column)] = 1.0,
                _ => {}
            }
        }
        let mut fixed = DVector::zeros(count);
        for (row, train) in self.motors_with_joint_friction() {
            fixed[row] += train.motor_friction.constant * train.transmission().abs();
        }
        Some((matrix, fixed))
    }

    /// Iterates over the drive trains whose motor friction is not estimated but has the value of
    /// the model, because their joints also have joint friction. Each drive train comes with the
    /// row of its actuator. There are none if efforts are measured at joints.
    fn motors_with_joint_friction(&self) -> impl Iterator<Item = (usize, &DriveTrain)> {
        let trains = self.mechanism().drive_trains().iter().filter(|_| self.at_motors);
        trains.filter_map(|train| {
            let (joint, dof) = train.only_dof()?;
            let row = self.actuator_of((joint.0, dof))?;
            let is_shared = !self.mechanism().joints()[joint.0].friction.is_empty();
            (is_shared && train.has_motor_friction()).then_some((row, train))
        })
    }

    /// Solves for the forces, with friction and reactions converged. `engine` is the result of
    /// [`Self::engine_parameters`], `data` that of [`Self::engine_data`].
    ///
    /// # Errors
    /// Returns the reason why the forces have no solution.
    pub fn loads(
        &self,
        engine: &Parameters<f64>,
        data: &mut Data<f64>,
        motion: [&[f64]; 3],
    ) -> Result<Solved, Status> {
        let [q, v, a] = motion;
        match self.model.inverse_dynamics_with(engine, data, q, v, a, &[]) {
            Status::Converged => Ok(Solved::of(engine, data)),
            status => Err(status),
        }
    }

    /// Creates the data for [`Self::loads`], in the configuration of the last call of [`Self::at`].
    pub fn engine_data(&self) -> Data<f64> {
        let mut data = self.data.clone();
        data.settings = Settings::default();
        data
    }

    /// Returns the parameters of the inverse-dynamics kernel for the parameter values `values`.
    pub fn engine_parameters(&self, values: &[f64]) -> Parameters<f64> {
        let mut engine = self.nominal.clone();
        for (body, inertial) in crate::physical::bodies(&self.parameters, values) {
            if inertial[0] > 0.0 {
                // The difference from the model is added, so that payloads of the solver remain.
                let prior: Vec<f64> = self.prior_of(body);
                let total: Vec<f64> = self.nominal_inertial(body);
                let sum: [f64; 10] = std::array::from_fn(|i| total[i] + inertial[i] - prior[i]);
                let (mass, com, inertia) = crate::physical::central(&sum);
                (engine.mass[body], engine.com[body], engine.inertia[body]) = (mass, com, inertia);
            }
        }
        let rotors = spinning_rotors(self.mechanism(), |train| {
            let mut own = self.parameters.iter().zip(values);
            let found = own.find(|(parameter, _)| parameter.kind == Kind::Rotor(train));
            found.map(|(_, value)| *value)
        });
        engine.rotors = rotors.into_iter().map(|(_, rotor)| rotor).collect();
        for (parameter, &value) in self.parameters.iter().zip(values) {
            let (Kind::Mu(i) | Kind::Viscous(i)) = parameter.kind else { continue };
            let interface = &mut engine.interfaces[i];
            let arm = interface.arms(engine.pitch[interface.joint])[0].abs();
            if let Kind::Mu(_) = parameter.kind {
                scale_laws(&mut interface.law, interface.backward.as_mut(), value);
            } else {
                let viscous = value / (arm * arm);
                set_viscous(&mut interface.law, interface.backward.as_mut(), viscous);
            }
        }
        for (parameter, &value) in self.parameters.iter().zip(values) {
            let Kind::Coulomb(i) = parameter.kind else { continue };
            let interface = &mut engine.interfaces[i];
            let arm = interface.arms(engine.pitch[interface.joint])[0].abs();
            let (law, backward) = (&mut interface.law, interface.backward.as_mut());
            interface.load.preload = carried_preload(law, backward, value / arm);
        }
        for (parameter, &value) in self.parameters.iter().zip(values) {
            if let Kind::StaticExcess(i) = parameter.kind {
                set_static_excess(&mut engine.interfaces[i].law, value);
            }
        }
        engine
    }

    fn prior_of(&self, body: usize) -> Vec<f64> {
        let own = self.parameters.iter().filter(|p| p.body() == Some(body));
        own.map(|p| p.prior).collect()
    }

    fn nominal_inertial(&self, body: usize) -> Vec<f64> {
        let nominal = &self.nominal;
        crate::physical::about_origin(nominal.mass[body], nominal.com[body], nominal.inertia[body])
            .to_vec()
    }

    /// Replaces the inertias in the known efforts by those of `mechanism`, for a log with a payload.
    pub fn carry(&mut self, mechanism: &Mechanism) {
        let other: Parameters<f64> = Parameters::new(mechanism);
        let zero = Mat3::zero();
        for body in 1..other.mass.len() {
            // Inertia added to bodies with a local degree of freedom remains.
            let extra = self.nominal.inertia[body] + self.mechanism().bodies()[body].inertia * -1.0;
            self.nominal.mass[body] = other.mass[body];
            self.nominal.com[body] = other.com[body];
            self.nominal.inertia[body] =
                other.inertia[body] + if extra == zero { zero } else { extra };
        }
    }
}
