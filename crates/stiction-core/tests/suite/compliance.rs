//! Redundant constraints share a load according to the declared compliances of the joints.

use stiction_core::dynamics::{AppliedLoad, InverseDynamics, LoadAxes, Settings, Weighting};
use stiction_core::joint::JointType;
use stiction_core::kinematics::{Coordinate, Target};
use stiction_core::mechanism::{
    BodyId, BodySpec, Compliance, JointId, JointSpec, MechanismBuilder,
};
use stiction_core::spatial::{Mat3, Pose, Vec3};

/// Half the distance between the hinges, m.
const HALF: f64 = 0.4;
/// Loads on the door: a moment perpendicular to the line through the hinges, N m, and a force along
/// this line (`ALONG`), N.
const MOMENT: f64 = 30.0;
const ALONG: f64 = 50.0;

/// Creates a door on an upper and a lower hinge with the given compliances.
fn door(compliances: [Option<Compliance>; 2]) -> InverseDynamics {
    let at = |z: f64| Pose { rotation: Mat3::identity(), position: Vec3::new(0.0, 0.0, z) };
    let mut builder =
        MechanismBuilder::new("door").body(BodySpec::new("leaf").mass(1.0).com(Vec3::zero()));
    for (name, z, compliance) in [("upper", HALF, compliances[0]), ("lower", -HALF, compliances[1])]
    {
        let mut hinge =
            JointSpec::new(name, JointType::Revolute, "ground", "leaf").frames(at(z), at(z));
        if z > 0.0 {
            hinge = hinge.actuated();
        }
        if let Some(compliance) = compliance {
            hinge = hinge.compliance(compliance);
        }
        builder = builder.joint(hinge);
    }
    let angle = Coordinate::Joint { joint: JointId(0), dof: 0 };
    let still = Target { value: 0.0, rate: 0.0, acceleration: 0.0 };
    InverseDynamics::new(builder.build().unwrap(), &[], &[angle], &[still], Settings::default())
        .unwrap()
}

fn load() -> AppliedLoad<f64> {
    AppliedLoad {
        body: BodyId(1),
        force: Vec3::new(0.0, 0.0, ALONG),
        moment: Vec3::new(MOMENT, 0.0, 0.0),
        point: Vec3::zero(),
        axes: LoadAxes::World,
    }
}

#[test]
fn two_hinges_share_force_and_moment_by_their_stiffness() {
    let each = Compliance { radial: 2e-8, axial: 3e-8, bending: 5e-7, torsional: 0.0 };
    let stiffer = Compliance { axial: 1e-8, ..each };
    let mut door = door([Some(each), Some(stiffer)]);
    assert_eq!(door.weighting(), Some(Weighting::LeastEnergy));
    // Closed form: the leaf tilts by the angle w; at distance h from the middle, the hinges are
    // displaced by w h and tilt by w.
    let tilt = -MOMENT / (2.0 * (HALF * HALF / each.radial + 1.0 / each.bending));
    let radial = tilt * HALF / each.radial;
    let bending = tilt / each.bending;
    let down = -ALONG / (1.0 / each.axial + 1.0 / stiffer.axial);
    for carefully in [false, true] {
        let forces = if carefully {
            door.solve_dense(&[load()]).unwrap()
        } else {
            door.solve(&[load()]).unwrap()
        };
        for (joint, (sign, axial)) in [(-1.0, each.axial), (1.0, stiffer.axial)].iter().enumerate()
        {
            let (force, moment) = forces.reactions[joint];
            let error = (force - Vec3::new(0.0, sign * radial, down / axial)).norm()
                + (moment - Vec3::new(bending, 0.0, 0.0)).norm();
            assert!(error < 1e-10, "{joint} {carefully}: {force:?}, {moment:?}");
        }
    }
}

#[test]
fn a_rigid_joint_beside_a_compliant_one_carries_all() {
    // One hinge is compliant along its axis; the other declares no compliance and is rigid there.
    let soft = Compliance { axial: 1e-8, ..Compliance::default() };
    let mut door = door([Some(soft), None]);
    let forces = door.solve(&[load()]).unwrap();
    let [upper, lower] = [forces.reactions[0].0, forces.reactions[1].0];
    assert!(upper.z.abs() < 1e-10 && (lower.z + ALONG).abs() < 1e-10, "{upper:?} {lower:?}");
    // The default rule shares components without declared compliance equally.
    assert!((upper.y + lower.y).abs() < 1e-10 && upper.y.abs() > 1.0, "{upper:?} {lower:?}");
}

#[test]
fn a_compliance_where_the_joint_moves_is_a_defect() {
    let twist = Compliance { torsional: 1e-6, ..Compliance::default() };
    let hinge = JointSpec::new("a", JointType::Revolute, "ground", "leaf").compliance(twist);
    let defects = MechanismBuilder::new("x").body(BodySpec::new("leaf")).joint(hinge).build();
    let text = defects.unwrap_err()[0].to_string();
    assert!(text.contains("torsional") && text.contains("moves freely"), "{text}");
}
