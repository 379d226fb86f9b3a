//! A robot as described by its file, in terms of bodies and joints: the intermediate form between the readers of all
//! formats and the writer of the model file.

use crate::source::Place;
use stiction_core::joint::JointType;
use stiction_core::spatial::{Mat3, Pose, Vec3};
use toml::Table;

/// Index of the ground among the bodies.
pub(super) const GROUND: usize = 0;

/// Description of a robot: bodies, joints, springs, gearings and motors.
#[derive(Clone, Debug)]
pub(super) struct Description {
    /// Name of the imported file's format, for comments in the model file.
    pub(super) format: &'static str,
    pub(super) name: String,
    pub(super) gravity: Vec3<f64>,
    /// Friction mode that the model uses by default: `on`, `off` or `one-pass`.
    pub(super) friction: Option<String>,
    /// Bodies; the first is the ground.
    pub(super) bodies: Vec<Body>,
    pub(super) joints: Vec<Joint>,
    pub(super) springs: Vec<Spring>,
    /// Springs defined by extension elements: name, and table in the form of the model file.
    pub(super) spring_tables: Vec<(String, Table)>,
    /// Motors defined by extension elements: name, and table in the form of the model file.
    pub(super) motor_tables: Vec<(String, Table)>,
    /// Gearings defined by extension elements: name, and table in the form of the model file.
    pub(super) gearing_tables: Vec<(String, Table)>,
    /// Bushings defined by extension elements: name, and table in the form of the model file.
    pub(super) bushing_tables: Vec<(String, Table)>,
    pub(super) motors: Vec<Motor>,
    pub(super) joint_motors: Vec<JointMotor>,
    pub(super) gearings: Vec<Gearing>,
    /// Extension elements of this program in the file.
    pub(super) extensions: Vec<super::extension::Entry>,
    /// Phrase for the configuration in which the file starts the joints, such as a keyframe.
    pub(super) position: &'static str,
}

/// Body with its mass properties and meshes.
#[derive(Clone, Debug)]
pub(super) struct Body {
    pub(super) name: String,
    pub(super) mass: f64,
    pub(super) com: Vec3<f64>,
    /// Inertia about the centre of mass, in the body's axes, kg m^2.
    pub(super) inertia: Mat3<f64>,
    /// Meshes that show the body.
    pub(super) visuals: Vec<VisualMesh>,
    pub(super) place: Option<Place>,
    /// Comment to be written above the body's table.
    pub(super) comment: Option<String>,
}

/// A mesh that shows a body.
#[derive(Clone, Debug)]
pub(super) struct VisualMesh {
    pub(super) file: String,
    /// Scale factors of the coordinates x, y and z of the mesh.
    pub(super) scale: [f64; 3],
    /// Pose of the scaled mesh in the frame of the body.
    pub(super) pose: Pose<f64>,
}

impl Body {
    /// Creates a body without mass.
    pub(super) fn massless(name: impl Into<String>, place: Option<Place>) -> Self {
        Self {
            name: name.into(),
            mass: 0.0,
            com: Vec3::zero(),
            inertia: Mat3::zero(),
            visuals: Vec::new(),
            place,
            comment: None,
        }
    }

    pub(super) fn is_massless(&self) -> bool {
        self.mass == 0.0 && self.inertia == Mat3::zero()
    }
}

/// A joint between two bodies.
#[derive(Clone, Debug)]
pub(super) struct Joint {
    pub(super) name: String,
    pub(super) kind: JointType,
    pub(super) from: usize,
    pub(super) to: usize,
    /// Pose of frame J in the body `from`; the z axis of this frame is the axis of the joint.
    pub(super) frame_j: Pose<f64>,
    /// Pose of frame K in the body `to`; frames J and K coincide at zero coordinates.
    pub(super) frame_k: Pose<f64>,
    /// Pitch of a screw joint, m/rad.
    pub(super) pitch: f64,
    /// Properties of each scalar coordinate, in the joint's order; empty for joints without scalar
    /// coordinates (spherical, free, fixed).
    pub(super) dofs: Vec<Coordinate>,
    /// Damping of all rotations of a spherical joint, N m s/rad.
    pub(super) damping: f64,
    /// Pose of frame K in frame J in the file's configuration, for joints without scalar
    /// coordinates.
    pub(super) start: Option<Pose<f64>>,
    /// True for a joint that closes a loop: it is not part of the tree of bodies.
    pub(super) closes: bool,
    /// Friction table in the form of the model file, from an extension element.
    pub(super) friction: Option<Table>,
    /// Ranges in the form of the model file, from an extension element.
    pub(super) range: Option<Table>,
    pub(super) place: Option<Place>,
    pub(super) comment: Option<String>,
}

impl Joint {
    /// Creates a joint whose frames J and K coincide with the frames of its bodies.
    pub(super) fn new(name: impl Into<String>, kind: JointType, ends: (usize, usize)) -> Self {
        let dofs = if kind.has_scalar_coordinates() { kind.dofs().len() } else { 0 };
        Self {
            name: name.into(),
            kind,
            from: ends.0,
            to: ends.1,
            frame_j: Pose::identity(),
            frame_k: Pose::identity(),
            pitch: 0.0,
            dofs: vec![Coordinate::default(); dofs],
            damping: 0.0,
            start: None,
            closes: false,
            friction: None,
            range: None,
            place: None,
            comment: None,
        }
    }

    /// Returns `true` if an extension element gives the joint friction or a range, which belong to its type.
    pub(super) fn is_extended(&self) -> bool {
        self.friction.is_some() || self.range.is_some()
    }

    /// Name of a degree of freedom in motions: the name of the joint, followed by a dot and the
    /// name of the degree of freedom if the joint has several.
    pub(super) fn dof_name(&self, dof: usize) -> String {
        match self.kind.dofs() {
            [_] => self.name.clone(),
            several => format!("{}.{}", self.name, several[dof].name),
        }
    }

    /// Pose of frame K in frame J in the file's configuration.
    pub(super) fn across(&self) -> Pose<f64> {
        if let Some(start) = self.start {
            return start;
        }
        if self.dofs.is_empty() {
            return Pose::identity();
        }
        let q: Vec<f64> = self.dofs.iter().map(|dof| dof.position).collect();
        self.kind.pose(&q, self.pitch)
    }

    /// Pose of the body `to` in the body `from` in the file's configuration.
    pub(super) fn relative(&self) -> Pose<f64> {
        self.frame_j * self.across() * self.frame_k.inverse()
    }
}

/// Properties of one scalar coordinate of a joint, in SI units.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Coordinate {
    /// Value of the coordinate in the file's configuration.
    pub(super) position: f64,
    pub(super) range: Option<[f64; 2]>,
    pub(super) damping: f64,
    /// Friction that depends neither on the load nor on the speed, N or N m.
    pub(super) friction: f64,
    /// Inertia added at the coordinate, kg or kg m^2.
    pub(super) armature: f64,
    /// Spring at the coordinate: its stiffness, N/m or N m/rad, and the coordinate at which it is
    /// relaxed.
    pub(super) spring: Option<[f64; 2]>,
    pub(super) actuated: bool,
}

/// Spring with a damper between points of two bodies.
#[derive(Clone, Debug)]
pub(super) struct Spring {
    pub(super) name: String,
    pub(super) ends: [usize; 2],
    pub(super) points: [Vec3<f64>; 2],
    pub(super) stiffness: f64,
    pub(super) free_length: f64,
    pub(super) damping: f64,
}

/// Linear constraint on coordinates of joints: the sum of the coordinates times their factors is constant.
#[derive(Clone, Debug)]
pub(super) struct Gearing {
    pub(super) name: String,
    /// Terms of the sum: index of the joint, degree of freedom and factor.
    pub(super) terms: Vec<(usize, usize, f64)>,
    pub(super) constant: f64,
    pub(super) place: Option<Place>,
}

/// Motor that drives one coordinate of a joint.
#[derive(Clone, Debug)]
pub(super) struct Motor {
    pub(super) name: String,
    pub(super) joint: usize,
    pub(super) dof: usize,
    /// Ratio of joint effort to motor torque; not 0.
    pub(super) gear: f64,
    /// Greatest effort at the joint, N or N m.
    pub(super) effort: Option<f64>,
    /// Greatest rate of the joint, m/s or rad/s.
    pub(super) rate: Option<f64>,
    pub(super) place: Option<Place>,
}

/// Motor that drives several joints together.
#[derive(Clone, Debug)]
pub(super) struct JointMotor {
    pub(super) name: String,
    /// Joints with one degree of freedom, each with its coefficient in the output coordinate of the
    /// motor.
    pub(super) terms: Vec<(usize, f64)>,
    /// Ratio of the effort at the output to the motor torque; not 0.
    pub(super) gear: f64,
    /// Greatest effort at the output, N or N m.
    pub(super) effort: Option<f64>,
    /// Inertia at the output coordinate, kg or kg m^2.
    pub(super) armature: f64,
    /// Constant friction at the output coordinate, N or N m.
    pub(super) friction: f64,
    /// Damping at the output coordinate, N s/m or N m s/rad.
    pub(super) damping: f64,
    pub(super) place: Option<Place>,
}

impl Description {
    pub(super) fn new(format: &'static str, name: impl Into<String>, gravity: Vec3<f64>) -> Self {
        Self {
            format,
            name: name.into(),
            gravity,
            friction: None,
            bodies: vec![Body::massless("ground", None)],
            joints: Vec::new(),
            springs: Vec::new(),
            spring_tables: Vec::new(),
            motor_tables: Vec::new(),
            gearing_tables: Vec::new(),
            bushing_tables: Vec::new(),
            motors: Vec::new(),
            joint_motors: Vec::new(),
            gearings: Vec::new(),
            extensions: Vec::new(),
            position: "zero coordinates",
        }
    }

    /// Changes joint coordinates so that they satisfy the gearings. The first joint of each gearing
    /// is moved; the other joints of the gearing keep their coordinates.
    pub(super) fn place_followers(&mut self) {
        // A joint moved by one gearing may in turn move the first joint of another gearing.
        for _ in 0..self.gearings.len() {
            for gearing in &self.gearings {
                let Some((&(own, dof, factor), rest)) = gearing.terms.split_first() else {
                    continue;
                };
                let others: f64 = rest
                    .iter()
                    .map(|(joint, dof, factor)| factor * self.joints[*joint].dofs[*dof].position)
                    .sum();
                self.joints[own].dofs[dof].position = (gearing.constant - others) / factor;
            }
        }
    }

    /// Poses of all bodies in the ground's frame in the file's configuration, computed first along
    /// joints that close no loop. `None` for bodies that are not connected to the ground.
    pub(super) fn poses(&self) -> Vec<Option<Pose<f64>>> {
        let mut poses = vec![None; self.bodies.len()];
        poses[GROUND] = Some(Pose::identity());
        for closures in [false, true] {
            loop {
                let mut changed = false;
                for joint in self.joints.iter().filter(|joint| closures || !joint.closes) {
                    match (poses[joint.from], poses[joint.to]) {
                        (Some(from), None) => poses[joint.to] = Some(from * joint.relative()),
                        (None, Some(to)) => {
                            poses[joint.from] = Some(to * joint.relative().inverse());
                        }
                        _ => continue,
                    }
                    changed = true;
                }
                if !changed {
                    break;
                }
            }
        }
        poses
    }
}
