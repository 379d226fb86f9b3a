//! Building a mechanism, with all its defects at once.

use super::{Body, BodyId, Compliance, Defect, GROUND_NAME, Joint, Mechanism, SpringSpec};
use crate::friction::{Combine, Contact, ContactShape, Curve, Law, Supports, contacts_of};
use crate::joint::JointType;
use crate::spatial::{Mat3, Pose, Vec3};
use std::collections::HashMap;

/// Collects the parts of a mechanism by name, in any order.
///
/// ```
/// use stiction::joint::JointType;
/// use stiction::mechanism::{BodySpec, JointSpec, MechanismBuilder};
/// use stiction::spatial::Vec3;
///
/// let pendulum = MechanismBuilder::new("pendulum")
///     .gravity(Vec3::new(0.0, -9.81, 0.0))
///     .body(BodySpec::new("bob").mass(1.0).com(Vec3::new(0.0, -1.0, 0.0)))
///     .joint(JointSpec::new("pivot", JointType::Revolute, "ground", "bob").actuated())
///     .build()?;
/// assert_eq!(pendulum.bodies().len(), 2);
/// # Ok::<(), Vec<stiction::mechanism::Defect>>(())
/// ```
#[derive(Clone, Debug)]
pub struct MechanismBuilder {
    name: String,
    bodies: Vec<BodySpec>,
    joints: Vec<JointSpec>,
    springs: Vec<SpringSpec>,
    gravity: Vec3<f64>,
    base: Pose<f64>,
    characteristic_length: Option<f64>,
}

/// A body to be.
#[derive(Clone, Debug, PartialEq)]
pub struct BodySpec {
    body: Body,
}

/// A joint to be; bodies by name.
#[derive(Clone, Debug, PartialEq)]
pub struct JointSpec {
    name: String,
    joint_type: JointType,
    predecessor: String,
    successor: String,
    frame_j: Pose<f64>,
    frame_k: Pose<f64>,
    pitch: f64,
    actuated: Vec<usize>,
    start: Option<Vec<f64>>,
    friction: Vec<Contact>,
    compliance: Option<Compliance>,
}

impl BodySpec {
    /// A body without mass.
    pub fn new(name: impl Into<String>) -> Self {
        Self {
            body: Body { name: name.into(), mass: 0.0, com: Vec3::zero(), inertia: Mat3::zero() },
        }
    }

    /// Mass, kg.
    pub fn mass(mut self, mass: f64) -> Self {
        self.body.mass = mass;
        self
    }

    /// Centre of mass in the body's frame, m.
    pub fn com(mut self, com: Vec3<f64>) -> Self {
        self.body.com = com;
        self
    }

    /// Inertia about the centre of mass, in the body's axes, kg m^2.
    pub fn inertia(mut self, inertia: Mat3<f64>) -> Self {
        self.body.inertia = inertia;
        self
    }
}

impl JointSpec {
    /// A joint with both frames at the origins of its bodies.
    pub fn new(
        name: impl Into<String>,
        joint_type: JointType,
        predecessor: impl Into<String>,
        successor: impl Into<String>,
    ) -> Self {
        Self {
            name: name.into(),
            joint_type,
            predecessor: predecessor.into(),
            successor: successor.into(),
            frame_j: Pose::identity(),
            frame_k: Pose::identity(),
            pitch: 0.0,
            actuated: Vec::new(),
            start: None,
            friction: Vec::new(),
            compliance: None,
        }
    }

    /// The joint frames in the predecessor (`X_PJ`) and in the successor (`X_SK`).
    pub fn frames(mut self, frame_j: Pose<f64>, frame_k: Pose<f64>) -> Self {
        (self.frame_j, self.frame_k) = (frame_j, frame_k);
        self
    }

    /// Advance of a helical joint, m/rad.
    pub fn pitch(mut self, pitch: f64) -> Self {
        self.pitch = pitch;
        self
    }

    /// All freedoms are actuated.
    pub fn actuated(mut self) -> Self {
        self.actuated = (0..self.joint_type.freedoms().len()).collect();
        self
    }

    /// Only these freedoms are actuated.
    pub fn actuated_freedoms(mut self, freedoms: impl Into<Vec<usize>>) -> Self {
        self.actuated = freedoms.into();
        self
    }

    /// Coordinates from which assembly starts.
    pub fn start(mut self, coordinates: impl Into<Vec<f64>>) -> Self {
        self.start = Some(coordinates.into());
        self
    }

    /// How much the joint gives under load.
    pub fn compliance(mut self, compliance: Compliance) -> Self {
        self.compliance = Some(compliance);
        self
    }

    /// Adds a friction.
    pub fn friction(mut self, contact: Contact) -> Self {
        self.friction.push(contact);
        self
    }
}

impl MechanismBuilder {
    /// An empty mechanism in a world without gravity.
    pub fn new(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            bodies: Vec::new(),
            joints: Vec::new(),
            springs: Vec::new(),
            gravity: Vec3::zero(),
            base: Pose::identity(),
            characteristic_length: None,
        }
    }

    /// Acceleration of gravity in world axes, m/s^2.
    pub fn gravity(mut self, gravity: Vec3<f64>) -> Self {
        self.gravity = gravity;
        self
    }

    /// `X_WG`: the ground's frame in the world.
    pub fn base(mut self, base: Pose<f64>) -> Self {
        self.base = base;
        self
    }

    /// Declares [`Mechanism::characteristic_length`], m.
    pub fn characteristic_length(mut self, length: f64) -> Self {
        self.characteristic_length = Some(length);
        self
    }

    /// Adds a body.
    pub fn body(mut self, body: BodySpec) -> Self {
        self.bodies.push(body);
        self
    }

    /// Adds a joint.
    pub fn joint(mut self, joint: JointSpec) -> Self {
        self.joints.push(joint);
        self
    }

    /// Adds a spring.
    pub fn spring(mut self, spring: SpringSpec) -> Self {
        self.springs.push(spring);
        self
    }

    /// The mechanism, or everything that is wrong with it.
    ///
    /// # Errors
    /// All [`Defect`]s of the description.
    pub fn build(self) -> Result<Mechanism, Vec<Defect>> {
        let mut defects = Vec::new();
        check_finite(&mut defects, "gravity", &self.gravity.to_array());
        check_finite(&mut defects, "the place of the base", &pose_numbers(&self.base));

        let ground = BodySpec::new(GROUND_NAME).body;
        let mut ids = HashMap::from([(GROUND_NAME.to_owned(), BodyId::GROUND)]);
        let mut bodies = vec![ground];
        if self.bodies.is_empty() {
            defects.push(Defect::NoBodies);
        }
        for spec in self.bodies {
            check_body(&mut defects, &spec.body);
            if spec.body.name == GROUND_NAME {
                defects.push(Defect::GroundTaken);
            } else if ids.insert(spec.body.name.clone(), BodyId(bodies.len())).is_some() {
                let name = spec.body.name.clone();
                defects.push(Defect::DuplicateName { what: "bodies", name });
            }
            bodies.push(spec.body);
        }

        let mut names = std::collections::HashSet::new();
        let mut joints = Vec::new();
        for spec in self.joints {
            if !names.insert(spec.name.clone()) {
                let name = spec.name.clone();
                defects.push(Defect::DuplicateName { what: "joints", name });
            }
            joints.extend(spec.resolve(&ids, &mut defects));
        }

        let mut names = std::collections::HashSet::new();
        let mut springs = Vec::new();
        for spec in self.springs {
            if !names.insert(spec.name().to_owned()) {
                let name = spec.name().to_owned();
                defects.push(Defect::DuplicateName { what: "springs", name });
            }
            springs.extend(spec.resolve(&ids, &mut defects));
        }

        // Connection makes sense only once every joint knows its bodies.
        if defects.is_empty() {
            defects.extend(disconnected(&bodies, &joints));
        }
        if let Some(length) = self.characteristic_length
            && !(length > 0.0 && length.is_finite())
        {
            defects.push(Defect::CharacteristicLength(length));
        }
        if !defects.is_empty() {
            return Err(defects);
        }
        let characteristic_length =
            self.characteristic_length.unwrap_or_else(|| own_length(&bodies, &joints));
        Ok(Mechanism {
            name: self.name,
            bodies,
            joints,
            springs,
            gravity: self.gravity,
            base: self.base,
            characteristic_length,
        })
    }
}

impl JointSpec {
    /// The joint, unless its bodies are unknown; all else that is wrong goes to `defects`.
    fn resolve(self, ids: &HashMap<String, BodyId>, defects: &mut Vec<Defect>) -> Option<Joint> {
        let joint = &self.name;
        let place = |what: &str| format!("{what} of joint `{joint}`");
        check_finite(defects, &place("the frame on the predecessor"), &pose_numbers(&self.frame_j));
        check_finite(defects, &place("the frame on the successor"), &pose_numbers(&self.frame_k));

        let helical = self.joint_type == JointType::Helical;
        if !self.pitch.is_finite() || helical != (self.pitch != 0.0) {
            defects.push(Defect::Pitch { joint: joint.clone() });
        }

        let mut actuated = vec![false; self.joint_type.freedoms().len()];
        for &freedom in &self.actuated {
            match actuated.get_mut(freedom) {
                Some(driven) if self.joint_type.has_scalar_coordinates() => *driven = true,
                _ => defects.push(Defect::NotActuable { joint: joint.clone(), freedom }),
            }
        }

        let expected = self.joint_type.coordinates();
        let start = self.start.clone().unwrap_or_else(|| {
            let mut q = vec![0.0; expected];
            self.joint_type.write_zero(&mut q);
            q
        });
        if start.len() != expected {
            let found = start.len();
            defects.push(Defect::StartLength { joint: joint.clone(), found, expected });
        }
        check_finite(defects, &place("the start"), &start);
        self.check_friction(defects);
        self.check_compliance(defects);

        let mut body = |name: &str| {
            let id = ids.get(name).copied();
            if id.is_none() {
                let (joint, body) = (joint.clone(), name.to_owned());
                defects.push(Defect::UnknownBody { joint, body });
            }
            id
        };
        let (predecessor, successor) = (body(&self.predecessor), body(&self.successor));
        let (predecessor, successor) = (predecessor?, successor?);
        if predecessor == successor {
            defects.push(Defect::SameBody { joint: joint.clone(), body: self.successor });
            return None;
        }
        Some(Joint {
            name: self.name,
            joint_type: self.joint_type,
            predecessor,
            successor,
            frame_j: self.frame_j,
            frame_k: self.frame_k,
            pitch: self.pitch,
            actuated,
            start,
            friction: self.friction,
            compliance: self.compliance,
        })
    }

    fn check_compliance(&self, defects: &mut Vec<Defect>) {
        let parts = self.compliance.iter().flat_map(Compliance::parts);
        for (part, value) in parts.filter(|(_, value)| *value != 0.0) {
            let problem = if !(value > 0.0 && value.is_finite()) {
                "must be a finite number of at least 0"
            } else if !Compliance::applies(self.joint_type, part) {
                "has nothing to give to: the joint moves freely that way"
            } else {
                continue;
            };
            defects.push(Defect::Compliance { joint: self.name.clone(), part, problem });
        }
    }

    fn check_friction(&self, defects: &mut Vec<Defect>) {
        let joint = || self.name.clone();
        let places = contacts_of(self.joint_type);
        for (i, contact) in self.friction.iter().enumerate() {
            let Some((_, shape)) = places.get(contact.place) else {
                let joint_type = self.joint_type.symbol();
                defects.push(Defect::NoContact { joint: joint(), joint_type });
                continue;
            };
            if self.friction[..i].iter().any(|other| other.place == contact.place) {
                defects.push(Defect::DuplicateContact { joint: joint() });
            }
            match contact.radius {
                None if shape.turns() => defects.push(Defect::Radius {
                    joint: joint(),
                    problem: "a friction on a turning contact needs the contact's radius",
                }),
                Some(_) if !shape.turns() => defects.push(Defect::Radius {
                    joint: joint(),
                    problem: "a friction on a straight guide takes no radius",
                }),
                _ => {}
            }
            let mut check = Checks { joint: &self.name, defects };
            check.load(contact, *shape, self.joint_type);
            check.number("radius", contact.radius, POSITIVE);
            check.law(&contact.law);
            if let Some(law) = &contact.backward {
                check.law(law);
                if !shape.has_one_freedom() {
                    check.problem("only a contact with one freedom slides forward or backward");
                }
            }
        }
    }
}

const POSITIVE: &str = "greater than 0";
const NOT_NEGATIVE: &str = "at least 0";

/// Checks of one joint's friction.
struct Checks<'a> {
    joint: &'a str,
    defects: &'a mut Vec<Defect>,
}

impl Checks<'_> {
    fn problem(&mut self, problem: &'static str) {
        self.defects.push(Defect::Friction { joint: self.joint.to_owned(), problem });
    }

    fn number(&mut self, parameter: &'static str, value: Option<f64>, range: &'static str) {
        let Some(value) = value else { return };
        let inside = if range == POSITIVE { value > 0.0 } else { value >= 0.0 };
        self.require(parameter, value, inside, range);
    }

    fn require(&mut self, parameter: &'static str, value: f64, inside: bool, range: &'static str) {
        if !inside || !value.is_finite() {
            let joint = self.joint.to_owned();
            self.defects.push(Defect::FrictionParameter { joint, parameter, value, range });
        }
    }

    fn load(&mut self, contact: &Contact, shape: ContactShape, joint_type: JointType) {
        let map = &contact.load;
        self.number("preload", Some(map.preload), NOT_NEGATIVE);
        self.number("bending span", map.bending_span, POSITIVE);
        self.number("collar ratio", map.axial_ratio, NOT_NEGATIVE);
        self.number("torsion arm", map.torsion_arm, POSITIVE);
        self.number("smoothing", map.smoothing, POSITIVE);
        let is_thread = shape == ContactShape::Thread;
        match map.flank_cosine {
            None if is_thread => self.problem("the friction of a thread needs its flank angle"),
            Some(_) if !is_thread => self.problem("only a thread has a flank angle"),
            Some(cosine) => {
                let inside = cosine > 0.0 && cosine <= 1.0;
                self.require("flank cosine", cosine, inside, "greater than 0 and at most 1");
            }
            None => {}
        }
        match (map.combine, shape) {
            (Combine::Pads, ContactShape::Ball | ContactShape::Plate) => {
                self.problem("a ball or a plate has no pads");
            }
            (Combine::RootSumSquare, ContactShape::Thread) => {
                self.problem("the loads of a thread add as a sum, or as those of two pads");
            }
            _ => {}
        }
        if is_thread && map.smoothing.is_some() {
            self.problem("the load of a thread cannot be smoothed");
        }
        let slides = matches!(
            joint_type,
            JointType::Prismatic | JointType::Cylindrical | JointType::Helical
        );
        if !slides && map.supports != Supports::Predecessor {
            self.problem("supports travel only where a joint slides along its axis");
        }
        if let Supports::OneOnEach { gland, piston } = map.supports {
            let inside = gland.is_finite() && gland != piston;
            self.require("place of the gland", gland, inside, "other than that of the piston");
            self.require("place of the piston", piston, true, "finite");
            if map.bending_span.is_some() {
                self.problem("with supports on both bodies the bending span is not constant");
            }
        }
    }

    fn law(&mut self, law: &Law) {
        const NOT_BELOW: &str = "at least the coefficient while sliding";
        self.number("coefficient", Some(law.coulomb), NOT_NEGATIVE);
        self.number("viscous coefficient", Some(law.viscous), NOT_NEGATIVE);
        let coefficient = "coefficient at rest";
        match &law.curve {
            Curve::Constant => {}
            Curve::Breakaway { coefficient: breakaway } => {
                self.require(coefficient, *breakaway, *breakaway >= law.coulomb, NOT_BELOW);
            }
            Curve::Stribeck { breakaway, velocity, exponent } => {
                self.require(coefficient, *breakaway, *breakaway >= law.coulomb, NOT_BELOW);
                self.number("Stribeck velocity", Some(*velocity), POSITIVE);
                self.number("Stribeck exponent", Some(exponent.value()), POSITIVE);
            }
            Curve::Table(rows) => self.table(rows),
        }
        self.number("velocity of regularisation", law.regularisation, POSITIVE);
        if let Some(bristles) = law.bristles {
            self.number("stiffness of bristles", Some(bristles.stiffness), POSITIVE);
            self.number("damping of bristles", Some(bristles.damping), NOT_NEGATIVE);
            if law.regularisation.is_some() {
                self.problem("a law with a state is not regularised: its state is what sticks");
            }
            let positive = match &law.curve {
                Curve::Table(rows) => rows.iter().all(|row| row[1] > 0.0),
                _ => law.coulomb > 0.0,
            };
            if !positive {
                self.problem("a law with a state needs coefficients greater than 0");
            }
        }
    }

    fn table(&mut self, rows: &[[f64; 2]]) {
        if rows.len() < 2 {
            self.problem("a table of coefficients needs two rows at least");
        }
        if rows.iter().flatten().any(|number| !number.is_finite()) {
            self.problem("a table of coefficients holds a number that is not finite");
        }
        if rows.first().is_some_and(|row| row[0] != 0.0) {
            self.problem("a table of coefficients begins at the speed 0");
        }
        if rows.iter().zip(rows.iter().skip(1)).any(|(a, b)| a[0] >= b[0]) {
            self.problem("the speeds in a table of coefficients must increase");
        }
        if rows.iter().any(|row| row[1] < 0.0) {
            self.problem("a table of coefficients holds a negative one");
        }
    }
}

fn pose_numbers(pose: &Pose<f64>) -> Vec<f64> {
    let [x, y, z] = pose.rotation.columns;
    [x, y, z, pose.position].iter().flat_map(|v| v.to_array()).collect()
}

fn check_finite(defects: &mut Vec<Defect>, place: &str, numbers: &[f64]) {
    if numbers.iter().any(|x| !x.is_finite()) {
        defects.push(Defect::NotFinite { place: place.to_owned() });
    }
}

fn check_body(defects: &mut Vec<Defect>, body: &Body) {
    let name = || body.name.clone();
    let tensor = nalgebra::Matrix3::from(body.inertia);
    let before = defects.len();
    for (what, numbers) in [
        ("the mass", vec![body.mass]),
        ("the centre of mass", body.com.to_array().to_vec()),
        ("the inertia", tensor.as_slice().to_vec()),
    ] {
        check_finite(defects, &format!("{what} of body `{}`", body.name), &numbers);
    }
    if defects.len() > before {
        return;
    }
    if body.mass < 0.0 {
        defects.push(Defect::NegativeMass { body: name(), mass: body.mass });
    }
    // Typed-in tensors carry rounding; what exceeds a part in 1e9 is a mistake.
    let slack = 1e-9 * tensor.amax();
    if (tensor - tensor.transpose()).amax() > slack {
        defects.push(Defect::AsymmetricInertia { body: name() });
        return;
    }
    let [smallest, ..] = body.principal_moments();
    if smallest < -slack {
        defects.push(Defect::NegativeInertia { body: name(), moment: smallest });
    }
}

fn disconnected(bodies: &[Body], joints: &[Joint]) -> Vec<Defect> {
    let mut reached = vec![false; bodies.len()];
    reached[BodyId::GROUND.0] = true;
    loop {
        let mut grew = false;
        for joint in joints {
            let (a, b) = (joint.predecessor.0, joint.successor.0);
            if reached[a] != reached[b] {
                (reached[a], reached[b]) = (true, true);
                grew = true;
            }
        }
        if !grew {
            break;
        }
    }
    bodies
        .iter()
        .zip(reached)
        .filter(|(_, reached)| !reached)
        .map(|(body, _)| Defect::Disconnected { body: body.name.clone() })
        .collect()
}

/// See [`Mechanism::characteristic_length`].
fn own_length(bodies: &[Body], joints: &[Joint]) -> f64 {
    let mut squares = Vec::new();
    let mut points_of: Vec<Vec<Vec3<f64>>> = vec![Vec::new(); bodies.len()];
    for joint in joints {
        points_of[joint.predecessor.0].push(joint.frame_j.position);
        points_of[joint.successor.0].push(joint.frame_k.position);
    }
    for ((id, body), mut points) in bodies.iter().enumerate().zip(points_of) {
        points.extend((id != BodyId::GROUND.0).then_some(body.com));
        for (i, &a) in points.iter().enumerate() {
            squares.extend(points[..i].iter().map(|&b| (a - b).norm_squared()));
        }
    }
    // Coinciding points (two joints at one place) say nothing about the size, nor may the rounding
    // of their coordinates.
    let largest = squares.iter().copied().fold(0.0, f64::max);
    squares.retain(|&square| square > 1e-18 * largest);
    if squares.is_empty() {
        return 1.0;
    }
    // Sorted, so that the order of bodies and joints does not even change the rounding.
    squares.sort_by(f64::total_cmp);
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}
