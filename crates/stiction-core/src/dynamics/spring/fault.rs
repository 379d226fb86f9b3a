//! Positions at which the force of a spring is not defined.

use super::SpringForce;
use super::bushing::BushingForce;
use crate::joint::Motion;
use crate::kinematics::Bodies;
use crate::mechanism::Mechanism;
use crate::parameters::Parameters;
use crate::topology::Topology;

/// Largest deviation of the wrapped angle of a cut joint from the centre of its full turn, rad. At
/// half a turn the wrapped angle jumps, and a motion may cross this point unnoticed between two
/// samples.
const COUNTED: f64 = 170.0 * core::f64::consts::PI / 180.0;

/// A spring whose force is not defined.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SpringFault {
    /// Spring, by index, whose ends coincide, so that the force has no direction.
    NoDirection(usize),
    /// Bushing, by index, that is twisted by nearly half a turn; with the angle of twist, rad.
    Twisted(usize, f64),
    /// Spring, by index, on a cut joint whose angle, rad, is nearly half a turn from the middle of
    /// its range.
    Uncounted(usize, f64),
}

impl SpringFault {
    /// Finds the first spring whose force is not defined.
    pub(crate) fn first(
        topology: &Topology,
        parameters: &Parameters<f64>,
        bodies: &Bodies<f64>,
    ) -> Option<Self> {
        let coincide = parameters.springs.iter().position(|spring| {
            !SpringForce::of(spring, bodies).has_direction(spring, parameters.length)
        });
        coincide.map(Self::NoDirection).or_else(|| Self::first_turned(topology, parameters, bodies))
    }

    /// Finds the first bushing or joint spring that is rotated too far.
    pub(crate) fn first_turned(
        topology: &Topology,
        parameters: &Parameters<f64>,
        bodies: &Bodies<f64>,
    ) -> Option<Self> {
        let bushings = parameters.bushings.iter().enumerate();
        let mut twisted = bushings.filter_map(|(index, bushing)| {
            let force = BushingForce::of(bushing, bodies);
            (!force.has_direction()).then(|| Self::Twisted(index, force.deflection.1.norm()))
        });
        let joints = parameters.joint_springs.iter().zip(&bodies.spring_coordinates).enumerate();
        let mut uncounted = joints.filter_map(|(index, (spring, angle))| {
            let off = angle - spring.middle;
            let counts =
                topology.node_of(spring.joint).is_some() || spring.dof.motion != Motion::Rotation;
            (!counts && off.abs() > COUNTED).then_some(Self::Uncounted(index, off))
        });
        twisted.next().or_else(|| uncounted.next())
    }

    /// Returns the name of the spring and a description of the problem; `None` if the ends
    /// coincide, which has an error variant of its own.
    pub(crate) fn in_words(self, mechanism: &Mechanism) -> (String, Option<String>) {
        let degrees = |angle: f64| format!("{:.1} deg", angle.to_degrees());
        match self {
            Self::NoDirection(index) => (mechanism.springs()[index].name.clone(), None),
            Self::Twisted(index, angle) => {
                let problem = format!(
                    "it is twisted by {}, and near half a turn its moment has no direction; use torsion springs on the \
                     joints for large angles",
                    degrees(angle)
                );
                (mechanism.bushings()[index].name.clone(), Some(problem))
            }
            Self::Uncounted(index, off) => {
                let spring = &mechanism.joint_springs()[index];
                let joint = &mechanism.joints()[spring.joint.0];
                let problem = format!(
                    "it acts on joint `{}`, which closes a loop, so that full turns of its angle \
                     cannot be counted, and the angle is {} from {}; give the joint a `range` \
                     whose middle is near the angles that occur",
                    joint.name,
                    degrees(off.abs()),
                    if spring.middle == 0.0 {
                        "zero".to_owned()
                    } else {
                        "the middle of its range".to_owned()
                    },
                );
                (spring.name.clone(), Some(problem))
            }
        }
    }
}
