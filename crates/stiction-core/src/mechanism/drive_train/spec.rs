//! Specification of a drive train, and its checks.

use super::{DriveTrain, GearLoss, Mesh, MotorFriction, MotorLimits};
use crate::joint::Motion;
use crate::mechanism::{Defect, Joint, JointId};
use core::f64::consts::FRAC_PI_2;

/// Specification of a drive train; the joint by name. It actuates its degree of freedom.
#[must_use = "it has no effect unless a mechanism is built with it"]
#[derive(Clone, Debug, PartialEq)]
pub struct DriveTrainSpec {
    joint: String,
    train: DriveTrain,
}

const POSITIVE: &str = "greater than 0";
const NOT_NEGATIVE: &str = "at least 0";

impl DriveTrainSpec {
    /// A motor without inertia and losses, coupled directly to a degree of freedom: the name of the joint,
    /// followed by that of the degree of freedom where the joint has several actuators.
    pub fn new(name: impl Into<String>, joint: impl Into<String>) -> Self {
        let train = DriveTrain {
            name: name.into(),
            joint: JointId(0),
            dof: 0,
            ratio: 1.0,
            lead: None,
            share: 1.0,
            rotor_inertia: 0.0,
            gear: GearLoss::NONE,
            motor_friction: MotorFriction::default(),
            torque_constant: None,
            limits: MotorLimits::default(),
        };
        Self { joint: joint.into(), train }
    }

    pub(in crate::mechanism) fn name(&self) -> &str {
        &self.train.name
    }

    /// Revolutions of the motor per revolution of the joint, screw or pulley.
    pub fn ratio(mut self, ratio: f64) -> Self {
        self.train.ratio = ratio;
        self
    }

    /// Travel per revolution of the screw or pulley, m.
    pub fn lead(mut self, lead: f64) -> Self {
        self.train.lead = Some(lead);
        self
    }

    /// Part of the effort that this motor exerts, where several drive one degree of freedom.
    pub fn share(mut self, share: f64) -> Self {
        self.train.share = share;
        self
    }

    /// Moment of inertia of all that turns with the motor, kg m^2.
    pub fn rotor_inertia(mut self, inertia: f64) -> Self {
        self.train.rotor_inertia = inertia;
        self
    }

    /// Load-dependent loss.
    pub fn gear(mut self, gear: GearLoss) -> Self {
        self.train.gear = gear;
        self
    }

    /// Friction on the side of the motor.
    pub fn motor_friction(mut self, friction: MotorFriction) -> Self {
        self.train.motor_friction = friction;
        self
    }

    /// Torque per current, N m/A.
    pub fn torque_constant(mut self, constant: f64) -> Self {
        self.train.torque_constant = Some(constant);
        self
    }

    /// Limits of the motor.
    pub fn limits(mut self, limits: MotorLimits) -> Self {
        self.train.limits = limits;
        self
    }

    /// Builds the drive train and actuates its degree of freedom; defects go to `defects`.
    pub(in crate::mechanism) fn resolve(
        mut self,
        joints: &mut [Joint],
        defects: &mut Vec<Defect>,
    ) -> Option<DriveTrain> {
        self.check_numbers(defects);
        let name = || self.train.name.clone();
        let Some((joint, dof)) = find(joints, &self.joint) else {
            let joint = self.joint.clone();
            let problem = match joints.iter().find(|known| known.name == joint) {
                Some(known) if known.joint_type.has_scalar_coordinates() => {
                    let dofs: Vec<_> = (0..known.joint_type.dofs().len())
                        .map(|dof| format!("`{}`", known.dof_name(dof)))
                        .collect();
                    format!(
                        "joint `{joint}` has several degrees of freedom: name one of {}",
                        dofs.join(", ")
                    )
                }
                Some(_) => {
                    format!("joint `{joint}` has no degree of freedom that an actuator could drive")
                }
                None => {
                    defects.push(Defect::UnknownJointOfActuator { actuator: name(), joint });
                    return None;
                }
            };
            defects.push(Defect::Actuator { actuator: name(), problem });
            return None;
        };
        let translates = joints[joint].joint_type.dofs()[dof].motion == Motion::Translation;
        let problem = match (translates, self.train.lead) {
            (true, None) => Some("translates: give the `lead` of its screw or pulley"),
            (false, Some(_)) => Some("turns: it takes a `ratio` and no `lead`"),
            _ => None,
        };
        if let Some(problem) = problem {
            let problem = format!("`{}` {problem}", joints[joint].dof_name(dof));
            defects.push(Defect::Actuator { actuator: name(), problem });
            return None;
        }
        joints[joint].actuated[dof] = true;
        (self.train.joint, self.train.dof) = (JointId(joint), dof);
        Some(self.train)
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
                // Where this fails, friction keeps the screw from turning.
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

/// Joint and degree of freedom of this name: a joint with one degree of freedom or one actuator, or `joint.dof`.
fn find(joints: &[Joint], name: &str) -> Option<(usize, usize)> {
    let scalar = |(_, joint): &(usize, &Joint)| joint.joint_type.has_scalar_coordinates();
    joints.iter().enumerate().filter(scalar).find_map(|(id, joint)| {
        let mut driven = joint.actuated_dofs();
        let of_joint = match (joint.joint_type.dofs(), driven.next(), driven.next()) {
            ([_], ..) => Some(0),
            (_, only, None) => only,
            _ => None,
        };
        let named = || (0..joint.actuated.len()).find(|dof| joint.dof_name(*dof) == name);
        let dof = of_joint.filter(|_| joint.name == name).or_else(named)?;
        Some((id, dof))
    })
}

/// Checks that the shares of motors on one degree of freedom sum to one.
pub(in crate::mechanism) fn check_shares(
    trains: &[DriveTrain],
    joints: &[Joint],
    defects: &mut Vec<Defect>,
) {
    for (k, train) in trains.iter().enumerate() {
        let of_same = |other: &&DriveTrain| (other.joint, other.dof) == (train.joint, train.dof);
        if trains[..k].iter().any(|other| of_same(&other)) {
            continue;
        }
        let all: Vec<_> = trains.iter().filter(of_same).collect();
        let sum: f64 = all.iter().map(|train| train.share).sum();
        if (sum - 1.0).abs() <= 1e-9 {
            continue;
        }
        let names: Vec<_> = all.iter().map(|train| format!("`{}`", train.name)).collect();
        let problem = format!(
            "the shares of {} in the effort of `{}` sum to {sum}: give each a `share`, together 1",
            names.join(", "),
            joints[train.joint.0].dof_name(train.dof),
        );
        let actuator = all.last().map_or_else(String::new, |train| train.name.clone());
        defects.push(Defect::Actuator { actuator, problem });
    }
}
