//! Specification of a drive train by names of joints, and checks of its parameters.

use super::{DriveTrain, GearLoss, Mesh, MotorFriction, MotorLimits, RotorAxis};
use crate::mechanism::scalar_dof::{self, Coefficients};
use crate::mechanism::{Body, BodyId, Defect, GearedDof, Joint};
use crate::spatial::Vec3;
use core::f64::consts::FRAC_PI_2;
use std::collections::HashMap;

/// Specification of a drive train, which refers to joints by name. A mechanism built with the
/// specification has actuators on the driven degrees of freedom.
#[must_use = "a specification has no effect until it is passed to a `MechanismBuilder`"]
#[derive(Clone, Debug, PartialEq)]
pub struct DriveTrainSpec {
    /// Names of the driven joints or degrees of freedom, each with its coefficient in the output
    /// coordinate of the gear.
    joints: Vec<(String, f64)>,
    train: DriveTrain,
    /// Name of the body that carries the rotor, and the rotor's axis in the frame of this body.
    rotor_axis: Option<(String, Vec3<f64>)>,
}

const POSITIVE: &str = "greater than 0";
const NOT_NEGATIVE: &str = "at least 0";

impl DriveTrainSpec {
    /// Creates a motor without inertia and losses, coupled directly to a degree of freedom. `joint` is the name of
    /// the joint or, if the joint has several actuators, `joint.dof`.
    pub fn new(name: impl Into<String>, joint: impl Into<String>) -> Self {
        Self::of_joints(name, [(joint, 1.0)])
    }

    /// Creates a motor without inertia and losses whose output coordinate is a weighted sum of
    /// joint coordinates, as in a differential. `joints` are pairs of name and coefficient.
    pub fn of_joints<N: Into<String>>(
        name: impl Into<String>,
        joints: impl IntoIterator<Item = (N, f64)>,
    ) -> Self {
        let train = DriveTrain {
            name: name.into(),
            dofs: Vec::new(),
            ratio: 1.0,
            lead: None,
            share: 1.0,
            rotor_inertia: 0.0,
            rotor_axis: None,
            gear: GearLoss::NONE,
            motor_friction: MotorFriction::default(),
            torque_constant: None,
            limits: MotorLimits::default(),
        };
        let joints = joints.into_iter().map(|(joint, coefficient)| (joint.into(), coefficient));
        Self { joints: joints.collect(), train, rotor_axis: None }
    }

    pub(in crate::mechanism) fn name(&self) -> &str {
        &self.train.name
    }

    /// Sets the transmission ratio: revolutions of the motor per revolution of the gear's output,
    /// of the screw or of the pulley.
    pub fn ratio(mut self, ratio: f64) -> Self {
        self.train.ratio = ratio;
        self
    }

    /// Sets the travel per revolution of the screw or pulley, m.
    pub fn lead(mut self, lead: f64) -> Self {
        self.train.lead = Some(lead);
        self
    }

    /// Sets the share of this motor, from 0 to 1. If several motors drive one degree of freedom,
    /// the share is the fraction of the effort that this motor exerts. If several motors drive
    /// several degrees of freedom together, the share is a weight: the efforts of the motors
    /// minimise the sum of `effort^2 / share`.
    pub fn share(mut self, share: f64) -> Self {
        self.train.share = share;
        self
    }

    /// Sets the moment of inertia of all parts that turn with the motor, about the motor's axis, kg
    /// m^2.
    pub fn rotor_inertia(mut self, inertia: f64) -> Self {
        self.train.rotor_inertia = inertia;
        self
    }

    /// Sets the body that carries the rotor, and the rotor's axis in the frame of that body.
    pub fn rotor_axis(mut self, body: impl Into<String>, axis: Vec3<f64>) -> Self {
        self.rotor_axis = Some((body.into(), axis));
        self
    }

    /// Sets the load-dependent loss of the gear or screw.
    pub fn gear(mut self, gear: GearLoss) -> Self {
        self.train.gear = gear;
        self
    }

    /// Sets the friction at the motor's shaft.
    pub fn motor_friction(mut self, friction: MotorFriction) -> Self {
        self.train.motor_friction = friction;
        self
    }

    /// Sets the torque constant of the motor: torque per unit current, N m/A.
    pub fn torque_constant(mut self, constant: f64) -> Self {
        self.train.torque_constant = Some(constant);
        self
    }

    /// Sets the torque and speed limits of the motor.
    pub fn limits(mut self, limits: MotorLimits) -> Self {
        self.train.limits = limits;
        self
    }

    /// Builds the drive train and marks its degrees of freedom as actuated. Appends all defects to
    /// `defects`. Returns `None` if the drive train names unsuitable joints or coefficients, or if
    /// its `lead` does not match the type of its degrees of freedom.
    pub(in crate::mechanism) fn resolve(
        mut self,
        ids: &HashMap<String, BodyId>,
        joints: &mut [Joint],
        defects: &mut Vec<Defect>,
    ) -> Option<DriveTrain> {
        self.check_numbers(defects);
        self.train.rotor_axis = self.carrier(ids, defects);
        let name = &self.train.name;
        let (mut driven, problems) = match scalar_dof::resolve(joints, &self.joints) {
            Ok(driven) => (driven, Vec::new()),
            Err(problems) => (Vec::new(), problems),
        };
        let misfits = problems.into_iter().map(|problem| match problem {
            Coefficients::Unknown(joint) => {
                Defect::UnknownJointOfActuator { actuator: name.clone(), joint }
            }
            Coefficients::OutOfRange(value) => Defect::ActuatorParameter {
                actuator: name.clone(),
                parameter: "joints",
                value,
                range: "other than 0",
            },
            Coefficients::Unfit(problem) => Defect::Actuator { actuator: name.clone(), problem },
        });
        let before = defects.len();
        defects.extend(misfits);
        if defects.len() > before {
            return None;
        }
        let Some(&first) = driven.first() else {
            let problem = "it drives no joint: name at least one".to_owned();
            defects.push(Defect::Actuator { actuator: name.clone(), problem });
            return None;
        };
        let sliding = driven.iter().copied().find(|driven: &GearedDof| driven.translates);
        let misfit = match (sliding, self.train.lead) {
            (Some(sliding), None) => {
                Some((sliding, "translates: give the `lead` of its screw or pulley"))
            }
            (None, Some(_)) => Some((first, "turns: give a `ratio` instead of a `lead`")),
            _ => None,
        };
        if let Some((misfit, problem)) = misfit {
            let problem = format!("`{}` {problem}", joints[misfit.joint.0].dof_name(misfit.dof));
            defects.push(Defect::Actuator { actuator: name.clone(), problem });
            return None;
        }
        if let [only] = &mut driven[..] {
            self.train.ratio *= only.coefficient;
            only.coefficient = 1.0;
        }
        for driven in &driven {
            joints[driven.joint.0].actuated[driven.dof] = true;
        }
        self.train.dofs = driven;
        Some(self.train)
    }

    fn carrier(
        &self,
        ids: &HashMap<String, BodyId>,
        defects: &mut Vec<Defect>,
    ) -> Option<RotorAxis> {
        let (name, axis) = self.rotor_axis.as_ref()?;
        let actuator = || self.train.name.clone();
        let body = ids.get(name).copied();
        if body.is_none() {
            let body = name.clone();
            defects.push(Defect::UnknownBodyOfActuator { actuator: actuator(), body });
        }
        let axis = axis.direction();
        if axis.is_none() {
            let problem = "its `rotor_axis` is a zero vector, which has no direction".to_owned();
            defects.push(Defect::Actuator { actuator: actuator(), problem });
        }
        Some(RotorAxis { body: body?, axis: axis? })
    }

    fn check_numbers(&self, defects: &mut Vec<Defect>) {
        let DriveTrain { ratio, lead, share, rotor_inertia, motor_friction, .. } = self.train;
        let limits = self.train.limits;
        let mut check = |parameter: &'static str, value: Option<f64>, range: &'static str| {
            let Some(value) = value else { return };
            let inside = match range {
                POSITIVE => value > 0.0,
                NOT_NEGATIVE => value >= 0.0,
                "other than 0" => value != 0.0,
                "from 0 to 1" => (0.0..=1.0).contains(&value),
                "greater than 0 and at most 1" => value > 0.0 && value <= 1.0,
                "at most 1" => value <= 1.0,
                "from 0 to below 90 degrees" => (0.0..FRAC_PI_2).contains(&value),
                _ => value > 0.0 && value < FRAC_PI_2,
            };
            if !inside || !value.is_finite() {
                let actuator = self.train.name.clone();
                defects.push(Defect::ActuatorParameter { actuator, parameter, value, range });
            }
        };
        check("ratio", Some(ratio), "other than 0");
        check("lead", lead, "other than 0");
        check("share", Some(share), "from 0 to 1");
        check("rotor_inertia", Some(rotor_inertia), NOT_NEGATIVE);
        check("motor_friction.constant", Some(motor_friction.constant), NOT_NEGATIVE);
        check("motor_friction.viscous", Some(motor_friction.viscous), NOT_NEGATIVE);
        check("torque_constant", self.train.torque_constant, POSITIVE);
        check("limits.peak", limits.peak, POSITIVE);
        check("limits.rated", limits.rated, POSITIVE);
        check("limits.speed", limits.speed, POSITIVE);
        match self.train.gear {
            GearLoss::Efficiency { forward, backward } => {
                check("efficiency", Some(forward), "greater than 0 and at most 1");
                check("backward_efficiency", Some(backward), "at most 1");
            }
            GearLoss::Mesh(Mesh { mu, lead_angle, flank_angle }) => {
                check("mesh.mu", Some(mu), NOT_NEGATIVE);
                check("mesh.lead_angle", Some(lead_angle), "between 0 and 90 degrees");
                check("mesh.flank_angle", Some(flank_angle), "from 0 to below 90 degrees");
                // If the forward efficiency is zero or negative, friction prevents the motor from
                // turning the screw.
                let (forward, _) = self.train.gear.efficiencies();
                if defects.is_empty() && forward <= 0.0 {
                    let problem = format!(
                        "its mesh jams: with mu = {mu} no torque turns a screw of this lead angle"
                    );
                    let actuator = self.train.name.clone();
                    defects.push(Defect::Actuator { actuator, problem });
                }
            }
        }
    }
}

/// Checks that the inertia of each body includes the inertia of the rotors that the body carries.
/// About the axis of each rotor, the body's moment of inertia must be at least the sum of the
/// contributions of all its rotors.
pub(in crate::mechanism) fn check_rotors(
    trains: &[DriveTrain],
    bodies: &[Body],
    defects: &mut Vec<Defect>,
) {
    // Tolerance for the round-off of a body whose inertia is exactly that of its rotor.
    const ROUND_OFF: f64 = 1e-12;
    let about = |train: &DriveTrain| Some((train.rotor_axis?, train.rotor_inertia));
    for train in trains {
        let Some(RotorAxis { body, axis }) = train.rotor_axis else { continue };
        if body == BodyId::GROUND {
            continue;
        }
        let whole = axis.dot(bodies[body.0].inertia * axis);
        let of_rotors: f64 = trains
            .iter()
            .filter_map(about)
            .filter(|(other, _)| other.body == body)
            .map(|(other, inertia)| inertia * other.axis.dot(axis).powi(2))
            .sum();
        if of_rotors > whole * (1.0 + ROUND_OFF) {
            defects.push(Defect::ActuatorParameter {
                actuator: train.name.clone(),
                parameter: "rotor_inertia",
                value: train.rotor_inertia,
                range: "at most the moment of inertia about `rotor_axis` of the body that carries \
                        the rotor (the inertia of a body includes all rotors on it)",
            });
        }
    }
}
