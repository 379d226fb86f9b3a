//! Configurations at which the force of a spring is undefined.

use super::SpringForce;
use super::bushing::BushingForce;
use crate::joint::Motion;
use crate::kinematics::Bodies;
use crate::mechanism::Mechanism;
use crate::parameters::Parameters;
use crate::topology::Topology;

/// Largest accepted deviation of the angle of a cut joint from the middle of the joint's range,
/// rad. The angle of a cut joint is known only up to full turns and jumps at a deviation of half a
/// turn. A motion may cross this jump unnoticed between two samples.
const COUNTED: f64 = 170.0 * core::f64::consts::PI / 180.0;

/// Spring whose force is undefined, and the reason.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SpringFault {
    /// The ends of the spring with this index coincide, so the force has no direction.
    NoDirection(usize),
    /// The bushing with this index is twisted by nearly half a turn. The second value is the angle
    /// of twist, rad.
    Twisted(usize, f64),
    /// The spring with this index acts on a cut joint whose angle is nearly half a turn from the
    /// middle of its range. The second value is the angle minus the middle of the range, rad.
    Uncounted(usize, f64),
}

impl SpringFault {
    /// Searches the springs, then the bushings, then the joint springs, and returns the first
    /// spring whose force is undefined.
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

    /// Searches the bushings, then the joint springs. Returns the first bushing that is twisted by
    /// nearly half a turn, or the first spring on a cut joint whose angle is nearly half a turn
    /// from the middle of its range.
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

    /// Returns the name of the spring and a description of the problem. The description is `None`
    /// if the ends of the spring coincide, because a separate error variant reports this case.
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
                    "it acts on joint `{}`, which closes a loop: full turns of this joint cannot \
                     be counted, and its angle is {} from {}; give the joint a `range` with its \
                     middle near the angles that occur",
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
