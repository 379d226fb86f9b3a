//! Samples of a run, stored for the animated robot in the report of this run.
//!
//! For a long run, only some evenly spaced samples are stored. In addition, the samples with
//! extremes of the quantities in the report's tables are stored. The page therefore remains small
//! and shows all peaks.

use crate::bodies::poses_in_world;
use crate::dofs::{Dof, actuated, dofs_of};
use crate::names::Names;
use crate::report::load_points::LoadPoints;
use crate::table::{REACTION, columns};
use std::collections::BTreeMap;
use std::sync::Arc;
use stiction_core::dynamics::InverseDynamics;
use stiction_core::mechanism::Mechanism;
use stiction_core::spatial::{Pose, Quaternion, Vec3};
use stiction_draw::drawing::{Detail, Drawing, Surface, Trail};
use stiction_draw::viewer::{Actuator, Film, Ghost, Mesh, MeshFile, Shot, robot};
use stiction_format::{LoadCase, MeshFormat, ModelFile};

/// Largest size of the samples in a page, bytes of text. The limit allows the page to be sent by
/// e-mail.
const ROOM: usize = 2_000_000;
/// Largest number of evenly spaced samples in a page.
const MOST: usize = 3000;
/// Relative difference below which two values count as equal, as in the summary.
const ROUNDING: f64 = 1e-12;

/// Names of the columns of each friction interface.
const INTERFACE: [&str; 5] = ["speed [m/s]", "load [N]", "friction [N]", "power [W]", "sticks"];
/// Names of the columns of the external load on each body: the force in world axes, and the point
/// at which its arrow starts, in the frame of the body.
const LOAD: [&str; 6] = ["fx [N]", "fy [N]", "fz [N]", "x [m]", "y [m]", "z [m]"];
/// Number of columns in [`LOAD`] for the force.
const FORCE: usize = 3;
/// Number of values of a pose: position and quaternion.
const POSE: usize = 7;

/// Sample that is stored for the animation.
#[derive(Clone, Debug)]
struct Frame {
    index: usize,
    time: f64,
    poses: Vec<f32>,
    values: Vec<f64>,
}

/// Least and greatest value of a quantity, and the samples at which they occur.
#[derive(Clone, Debug, Default)]
struct Extremes {
    least: Option<(f64, Arc<Frame>)>,
    greatest: Option<(f64, Arc<Frame>)>,
}

/// Animation of one run, for a page that shows several runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Reel {
    shot: Shot,
    still: String,
}

/// Largest number of runs that one page shows.
pub(crate) const MOST_RUNS: usize = 8;

/// Returns the HTML of the animated robot of the first run in `runs`. The reader of the page can
/// overlay the robot of another run. Each run has a label. The result is empty without runs.
pub(crate) fn together(runs: Vec<(String, Reel)>, caption: &str) -> String {
    let labelled = |(label, reel): (String, Reel)| (Shot { label, ..reel.shot }, reel.still);
    let mut runs = runs.into_iter().take(MOST_RUNS).map(labelled);
    let Some((first, still)) = runs.next() else { return String::new() };
    let others: Vec<Shot> = runs.map(|(shot, _)| shot).collect();
    robot(&first, &others, &still, caption)
}

/// Collects the samples of a run for the animated robot.
#[derive(Clone, Debug)]
pub(crate) struct Animation {
    mechanism: Mechanism,
    names: Names,
    columns: Vec<String>,
    actuators: Vec<Actuator>,
    meshes: Vec<Mesh>,
    load_points: LoadPoints,
    /// Poses of all bodies in the world at the first sample, the ground first.
    first: Vec<Pose<f64>>,
    origin: Vec3<f64>,
    trail: Option<Trail>,
    /// Largest number of evenly spaced samples that are stored.
    most: usize,
    /// Number of samples from each evenly spaced sample to the next.
    stride: usize,
    count: usize,
    even: BTreeMap<usize, Arc<Frame>>,
    extremes: Vec<Extremes>,
    last: Option<Arc<Frame>>,
    poses: Vec<Pose<f64>>,
    tracked: Vec<f64>,
    /// Number of columns of each actuator.
    quantities: usize,
    /// Number of columns for the whole mechanism: its singularity indices.
    whole: usize,
}

impl Animation {
    /// Creates an empty animation with room for `count` samples. `quantities` contains the names of
    /// the columns for each actuator, the effort first; `whole` contains the names of the columns
    /// for singularity indices, if any.
    pub(crate) fn new(
        model: &ModelFile,
        names: &Names,
        quantities: &[&str],
        whole: &[&str],
        count: usize,
    ) -> Self {
        let mechanism = &model.mechanism;
        let dofs = dofs_of(mechanism);
        let mut all = Vec::new();
        for (name, unit) in &names.drives {
            all.extend(quantities.iter().map(|quantity| format!("{name}.{quantity} [{unit}]")));
        }
        all.extend(columns(names.joints.iter().map(String::as_str), &REACTION));
        all.extend(names.friction_columns(&INTERFACE));
        // Joints and bodies may have the same names.
        let loads = mechanism.bodies()[1..].iter().map(|body| format!("load on {}", body.name));
        all.extend(columns(loads.collect::<Vec<_>>().iter().map(String::as_str), &LOAD));
        all.extend(whole.iter().map(|name| (*name).to_owned()));
        let places = actuated(&dofs);
        let actuators = names.drives.iter().zip(&places);
        let actuators =
            actuators.map(|((name, unit), &place)| actuator(mechanism, name, unit, &dofs[place]));
        let bytes = 4 * POSE * mechanism.bodies().len() + 8 * (1 + all.len());
        // Base64 has four letters for three bytes.
        let most = (ROOM * 3 / 4 / bytes).clamp(2, MOST);
        Self {
            mechanism: mechanism.clone(),
            meshes: meshes_of(model),
            load_points: LoadPoints::default(),
            actuators: actuators.collect(),
            columns: all,
            first: Vec::new(),
            origin: Vec3::zero(),
            trail: None,
            most,
            stride: count.div_ceil(most).max(1),
            count: 0,
            even: BTreeMap::new(),
            extremes: Vec::new(),
            last: None,
            poses: Vec::new(),
            tracked: Vec::new(),
            names: names.clone(),
            quantities: quantities.len(),
            whole: whole.len(),
        }
    }

    /// Sets the load case whose points of application are the starts of the arrows of loads.
    pub(crate) fn with_loads(self, load: &LoadCase) -> Self {
        let load_points = LoadPoints::new(load, self.mechanism.bodies().len());
        Self { load_points, ..self }
    }

    /// Creates an empty animation of `count` samples without forces.
    pub(crate) fn of_motion(model: &ModelFile, count: usize) -> Self {
        Self::new(model, &Names::default(), &[], &[], count)
    }

    /// Adds a sample without forces; the poses are those of `solver`.
    pub(crate) fn push_motion(&mut self, time: f64, solver: &InverseDynamics) {
        self.push_pose(
            time,
            &poses_in_world(solver.bodies(), solver.parameters().origin).collect::<Vec<_>>(),
        );
    }

    /// Adds a sample without forces; `poses` contains the poses of all bodies in the world, the
    /// ground first.
    pub(crate) fn push_pose(&mut self, time: f64, poses: &[Pose<f64>]) {
        let loads = vec![0.0; LOAD.len() * (self.mechanism.bodies().len() - 1)];
        self.push(time, poses.iter().copied(), loads);
    }

    /// Adds a sample: poses of all bodies in the world, the ground first, and the values of all
    /// columns. The order of the columns is actuators, joints, friction interfaces, loads of
    /// bodies, singularity indices. The load of a body is its force, N, and its moment about the
    /// origin of the body's frame, N m, in world axes.
    pub(crate) fn push(
        &mut self,
        time: f64,
        poses: impl IntoIterator<Item = Pose<f64>>,
        mut values: Vec<f64>,
    ) {
        self.poses.clear();
        self.poses.extend(poses);
        self.replace_moments(&mut values);
        if self.first.is_empty() {
            self.first.clone_from(&self.poses);
            self.origin = Drawing::new(&self.mechanism, &self.poses).middle();
            self.trail = Some(Trail::new(&self.mechanism, &self.poses));
        } else if let Some(trail) = &mut self.trail {
            trail.add(&self.mechanism, &self.poses);
        }
        let mut poses = Vec::with_capacity(POSE * self.poses.len());
        for pose in &self.poses {
            let mut orientation = [0.0; 4];
            Quaternion::from_rotation(pose.rotation).write(&mut orientation);
            let position = (pose.position - self.origin).to_array();
            poses.extend(position.into_iter().chain(orientation).map(|x| x as f32));
        }
        self.track(&values);
        let frame = Arc::new(Frame { index: self.count, time, poses, values });
        self.extremes.resize_with(self.tracked.len(), Extremes::default);
        for (extremes, &value) in self.extremes.iter_mut().zip(&self.tracked) {
            let margin = |known: f64| known.abs() * ROUNDING;
            let is_less = |known: &(f64, _)| value < known.0 - margin(known.0);
            if value.is_finite() && extremes.least.as_ref().is_none_or(is_less) {
                extremes.least = Some((value, Arc::clone(&frame)));
            }
            let is_greater = |known: &(f64, _)| value > known.0 + margin(known.0);
            if value.is_finite() && extremes.greatest.as_ref().is_none_or(is_greater) {
                extremes.greatest = Some((value, Arc::clone(&frame)));
            }
        }
        if self.count.is_multiple_of(self.stride) {
            self.even.insert(self.count, Arc::clone(&frame));
        }
        self.last = Some(frame);
        self.count += 1;
    }

    /// Replaces the moments of the loads on bodies in `values` by the points at which the arrows of
    /// these loads start.
    fn replace_moments(&self, values: &mut [f64]) {
        let first = self.columns.len() - self.whole - LOAD.len() * (self.poses.len() - 1);
        let loads = values[first..].chunks_exact_mut(LOAD.len()).zip(&self.poses[1..]);
        for (body, (load, pose)) in loads.enumerate() {
            let vector = |at: usize| Vec3::new(load[at], load[at + 1], load[at + 2]);
            let start = self.load_points.start(body + 1, pose, [vector(0), vector(FORCE)]);
            load[FORCE..].copy_from_slice(&start.to_array());
        }
    }

    /// Collects the values whose extremes are stored: efforts, magnitudes of reactions, normal
    /// loads, friction forces and their powers, singularity indices.
    fn track(&mut self, values: &[f64]) {
        let (drives, quantities) = (self.names.drives.len(), self.quantities);
        self.tracked.clear();
        self.tracked.extend((0..drives).map(|k| values[k * quantities]));
        let mut at = drives * quantities;
        let size = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        for row in values[at..].chunks_exact(REACTION.len()).take(self.names.joints.len()) {
            self.tracked.extend([size(&row[..3]), size(&row[3..6])]);
        }
        at += REACTION.len() * self.names.joints.len();
        for row in values[at..].chunks_exact(INTERFACE.len()).take(self.names.interfaces.len()) {
            self.tracked.extend_from_slice(&row[1..4]);
        }
        self.tracked.extend_from_slice(&values[values.len() - self.whole..]);
    }

    /// Returns the HTML of the animated robot with a still picture; `title` describes the motion,
    /// and `ghost` is the least-constrained motion at one sample, if it is shown. The result is
    /// empty without samples.
    pub(crate) fn figure(&self, title: &str, ghost: Option<Ghost>) -> String {
        let Some(mut reel) = self.reel(1) else { return String::new() };
        reel.shot.film.ghost = ghost;
        // Sentences of the viewer follow.
        let caption = if title.is_empty() { String::new() } else { format!("{title}.") };
        robot(&reel.shot, &[], &reel.still, &caption)
    }

    /// Returns the animation for an HTML page that shows `runs` runs; `None` if no samples were
    /// added.
    pub(crate) fn reel(&self, runs: usize) -> Option<Reel> {
        if self.first.is_empty() {
            return None;
        }
        let drawing = Drawing::new(&self.mechanism, &self.first);
        let drawing = match &self.trail {
            Some(trail) => drawing.with_trail(trail),
            None => drawing,
        };
        let still = drawing.svg(&drawing.best_view(), Detail::Full, Surface::Inline);
        let film = self.film(runs.clamp(1, MOST_RUNS));
        Some(Reel { shot: Shot { label: String::new(), scene: drawing.scene(), film }, still })
    }

    /// Returns the stored samples for a page that shows `runs` runs, without the columns of loads
    /// that never act. The more runs a page shows, the fewer samples of each run are returned.
    pub(crate) fn film(&self, runs: usize) -> Film {
        let sparse = self.even.len().div_ceil((self.most / runs).max(2)).max(1);
        let even = self.even.iter().step_by(sparse);
        let mut frames: BTreeMap<usize, Arc<Frame>> =
            even.map(|(index, frame)| (*index, Arc::clone(frame))).collect();
        let ends = self.extremes.iter().flat_map(|extremes| [&extremes.least, &extremes.greatest]);
        let peaks = ends.flatten().map(|(_, frame)| frame).chain(&self.last);
        frames.extend(peaks.map(|frame| (frame.index, Arc::clone(frame))));
        let bodies: Vec<&str> =
            self.mechanism.bodies()[1..].iter().map(|body| body.name.as_str()).collect();
        let loads = LOAD.len() * bodies.len();
        let first = self.columns.len() - loads - self.whole;
        let acts = |body: usize| {
            let from = first + LOAD.len() * body;
            frames.values().any(|frame| frame.values[from..from + FORCE].iter().any(|x| *x != 0.0))
        };
        let mut keep = vec![true; self.columns.len()];
        for body in (0..bodies.len()).filter(|&body| !acts(body)) {
            keep[first + LOAD.len() * body..][..LOAD.len()].fill(false);
        }
        let kept = |k: &usize| keep[*k];
        Film {
            times: frames.values().map(|frame| frame.time).collect(),
            of: self.count,
            origin: self.origin.to_array(),
            poses: frames.values().flat_map(|frame| frame.poses.iter().copied()).collect(),
            columns: (0..keep.len()).filter(kept).map(|k| self.columns[k].clone()).collect(),
            values: frames
                .values()
                .flat_map(|frame| (0..keep.len()).filter(kept).map(|k| frame.values[k]))
                .collect(),
            interfaces: self.names.interfaces.clone(),
            actuators: self.actuators.clone(),
            ghost: None,
            meshes: self.meshes.clone(),
        }
    }
}

/// Returns the loaded meshes of a model.
fn meshes_of(model: &ModelFile) -> Vec<Mesh> {
    // Visuals that refer to the same file share its content.
    let mut files: Vec<(*const stiction_format::Mesh, Arc<MeshFile>)> = Vec::new();
    let mut meshes = Vec::new();
    for visual in &model.visuals {
        let Some(mesh) = &visual.mesh else { continue };
        let known = files.iter().find(|(known, _)| *known == Arc::as_ptr(mesh));
        let file = known.map(|(_, file)| Arc::clone(file)).unwrap_or_else(|| {
            let format = match mesh.format {
                MeshFormat::Stl => "stl",
                MeshFormat::Obj => "obj",
                MeshFormat::Gltf => "gltf",
            };
            let (name, bytes) = (visual.file.clone(), mesh.bytes.clone());
            let file = Arc::new(MeshFile { name, format, bytes });
            files.push((Arc::as_ptr(mesh), Arc::clone(&file)));
            file
        });
        let mut quaternion = [0.0; 4];
        Quaternion::from_rotation(visual.pose.rotation).write(&mut quaternion);
        let position = visual.pose.position.to_array();
        meshes.push(Mesh { body: visual.body.0, scale: visual.scale, position, quaternion, file });
    }
    meshes
}

fn actuator(mechanism: &Mechanism, name: &str, unit: &'static str, dof: &Dof) -> Actuator {
    let joint = &mechanism.joints()[dof.joint.0];
    let second = joint.joint_type == stiction_core::joint::JointType::Universal && dof.index == 1;
    Actuator {
        name: name.to_owned(),
        unit,
        joint: dof.joint.0,
        axis: joint.joint_type.dofs()[dof.index].axis,
        second,
        turns: !dof.translates,
    }
}
