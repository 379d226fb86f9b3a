//! Composition of a picture from back to front, with labels last.

use super::hull::hull;
use super::labels::{Area, Label, Obstacles, area_of, place, view_box};
use super::layout::{ends, mean};
use super::legend::{Entry, entries, scale_and_axes};
use super::springs::{spring_ends, zigzag};
use super::style::{COLOURS, Surface, style};
use super::svg::{Point, circle, corners, line};
use super::symbols::{Pen, sample_frame, word};
use super::view::View;
use super::{Detail, Drawing};
use crate::xml::escape;
use stiction_core::joint::JointType;
use stiction_core::mechanism::{BodyId, Joint, Mechanism};
use stiction_core::spatial::Vec3;

/// Width and height of the area for the mechanism in a full picture, px.
const ROOM: [f64; 2] = [540.0, 420.0];
const SMALL_ROOM: [f64; 2] = [230.0, 200.0];
/// Largest number of joints, and of legs, that get labels. If a mechanism has more, their names
/// appear only in browsers, at the pointer.
const LABELLED: usize = 48;

pub(super) struct Sheet<'a> {
    pub(super) drawing: &'a Drawing<'a>,
    pub(super) pen: Pen,
    detail: Detail,
    /// Scale of the picture, px per m.
    scale: f64,
    /// Point of the projected mechanism at the centre of the picture, m.
    centre: Point,
    /// Centre of mass of each body in world axes, relative to the common origin of the poses, m.
    coms: Vec<Vec3<f64>>,
    /// SVG markup of the drawn parts, each with its depth towards the viewer, px.
    parts: Vec<(f64, String)>,
    pub(super) obstacles: Obstacles,
    labels: Vec<Label>,
}

impl<'a> Sheet<'a> {
    pub(super) fn new(drawing: &'a Drawing<'a>, view: &View, detail: Detail) -> Self {
        let frames = &drawing.placed;
        let bodies = drawing.placed.mechanism.bodies();
        let coms: Vec<Vec3<f64>> =
            frames.pose.iter().zip(bodies).map(|(pose, body)| pose.apply(body.com)).collect();
        let mut points: Vec<Vec3<f64>> = drawing.layout.places.clone();
        let lonely = |body: &usize| drawing.layout.joints[*body].len() < 2;
        points.extend((1..bodies.len()).filter(lonely).map(|body| coms[body]));
        points.extend(spring_ends(frames).into_iter().flatten());
        points.extend(drawing.trail.iter().flat_map(|trail| trail.paths()).flatten());
        points.extend(&drawing.extent);
        let seen = area_of(points.iter().map(|point| view.project(*point)), 0.0);
        let room = if detail == Detail::Full { ROOM } else { SMALL_ROOM };
        let length = drawing.placed.mechanism.characteristic_length();
        let (mut scale, centre) = fit(&seen, room, length);
        if detail == Detail::Small {
            // All views along the world axes share one scale, so that they can be compared.
            for other in [View::front(), View::side(), View::top()] {
                let seen = area_of(points.iter().map(|point| other.project(*point)), 0.0);
                scale = scale.min(fit(&seen, room, length).0);
            }
        }
        let mut sheet = Self {
            drawing,
            pen: Pen { view: *view, size: 0.0 },
            detail,
            scale,
            centre,
            coms,
            parts: Vec::new(),
            obstacles: Obstacles::default(),
            labels: Vec::new(),
        };
        sheet.pen.size = sheet.symbol_size();
        sheet
    }

    /// Draws the paths alone; returns their SVG markup and the area of the picture, px.
    pub(super) fn paths(mut self) -> (String, Area) {
        self.draw_trails();
        self.composed()
    }

    /// Draws the mechanism without paths, labels and legend; returns the SVG markup and the area of
    /// the picture, px.
    pub(super) fn bare(mut self) -> (String, Area) {
        self.draw_mechanism();
        self.composed()
    }

    /// Draws all parts of the picture; returns the complete SVG file.
    pub(super) fn finish(mut self, surface: Surface) -> String {
        self.draw_trails();
        self.draw_mechanism();
        let (mut drawn, mut area) = self.composed();
        if self.detail == Detail::Full {
            self.ask_for_labels();
            let (labels, own) = place(&self.labels, &mut self.obstacles, [0.0; 2]);
            drawn += &labels;
            area.include(&own);
            drawn += &format!(r#"<g class="legend">{}</g>"#, entries(&self.legend(), &mut area));
        }
        drawn += &scale_and_axes(&self.pen.view, self.scale, &mut area);
        area.least = area.least.map(|x| (x - 8.0).floor());
        area.greatest = area.greatest.map(|x| (x + 8.0).ceil());
        let name = match self.pen.view.words() {
            Some(words) => format!("{}, {words}", self.drawing.placed.mechanism.name()),
            None => self.drawing.placed.mechanism.name().to_owned(),
        };
        let name = escape(&name);
        // In a page, the heading contains the name; a title would show it wherever the pointer rests.
        let (sheet, title) = match surface {
            Surface::Inline => (String::new(), String::new()),
            Surface::Paper => (sheet(&area), format!("<title>{name}</title>")),
        };
        format!(
            r#"<svg xmlns="http://www.w3.org/2000/svg" class="mechanism" role="img" aria-label="{name}" viewBox="{}">{title}<style>{}</style>{sheet}{drawn}</svg>"#,
            view_box(&area),
            style(surface),
        )
    }

    fn draw_mechanism(&mut self) {
        self.draw_ground_plate();
        for body in 1..self.drawing.layout.joints.len() {
            self.draw_body(body);
        }
        for joint in 0..self.joints().len() {
            self.draw_joint(joint);
        }
        self.draw_springs();
    }

    /// Sorts the drawn parts from back to front; returns their SVG markup and the area of the
    /// picture, px.
    fn composed(&mut self) -> (String, Area) {
        self.parts.sort_by(|a, b| a.0.total_cmp(&b.0));
        let drawn: String = self.parts.iter().map(|(_, part)| part.as_str()).collect();
        let mut area = Area::empty();
        for (place, joint) in self.drawing.layout.places.iter().zip(self.joints()) {
            let half = self.pen.reach(joint.joint_type);
            area.include(&Area::around(self.at(*place), [half; 2]));
        }
        area.include(&area_of(self.obstacles.points.iter().copied(), 6.0));
        // Small pictures have the same width, so that their letters have the same size.
        let wide = if self.detail == Detail::Small { 0.5 * SMALL_ROOM[0] + 20.0 } else { 1.0 };
        area.include(&Area::around([0.0; 2], [wide, 1.0]));
        self.obstacles.areas.iter().for_each(|own| area.include(own));
        (drawn, area)
    }

    fn joints(&self) -> &'a [Joint] {
        self.drawing.placed.mechanism.joints()
    }

    /// Projects a point into the picture, px. The point is in world axes, relative to the common
    /// origin of the poses, m.
    pub(super) fn at(&self, point: Vec3<f64>) -> Point {
        let [x, y] = self.pen.view.project(point);
        [(x - self.centre[0]) * self.scale, (y - self.centre[1]) * self.scale]
    }

    /// Returns the depth of a point, px, positive towards the viewer.
    pub(super) fn depth(&self, point: Vec3<f64>) -> f64 {
        self.pen.view.depth(point) * self.scale
    }

    /// Returns the size of the joint symbols, px; small if joints are close to each other in the
    /// picture.
    fn symbol_size(&self) -> f64 {
        let places = match self.drawing.extent.as_slice() {
            [] => &self.drawing.layout.places,
            extent => &extent[..self.drawing.layout.places.len().min(extent.len())],
        };
        let points: Vec<Point> = places.iter().take(200).map(|place| self.at(*place)).collect();
        let nearest = |k: usize| {
            let gaps = points.iter().map(|p| (p[0] - points[k][0]).hypot(p[1] - points[k][1]));
            // Joints that coincide, such as a slider and its pin, do not count: smaller symbols would not separate
            // them.
            gaps.filter(|gap| *gap > 4.0).fold(f64::INFINITY, f64::min)
        };
        let mut gaps: Vec<f64> = (0..points.len()).map(nearest).collect();
        gaps.sort_by(f64::total_cmp);
        let typical = gaps.get(gaps.len() / 4).copied().unwrap_or(f64::INFINITY);
        let range = if self.detail == Detail::Full { (5.5, 10.0) } else { (3.5, 6.0) };
        (0.17 * typical).clamp(range.0, range.1)
    }

    pub(super) fn add(&mut self, depth: f64, part: String) {
        self.parts.push((depth, part));
    }

    fn draw_trails(&mut self) {
        let Some(trail) = self.drawing.trail else { return };
        for path in trail.paths() {
            let points: Vec<Point> = path.iter().map(|point| self.at(*point)).collect();
            let area = area_of(points.iter().copied(), 0.0);
            let size = (area.greatest[0] - area.least[0]).max(area.greatest[1] - area.least[1]);
            if size > 2.0 {
                points.windows(2).for_each(|pair| self.obstacles.add_line(pair[0], pair[1]));
                self.add(f64::MAX, corners("trail", &points, false));
            }
        }
    }

    /// Draws the ground plate of a spatial mechanism: the convex hull of the joints on the ground,
    /// unless all these joints lie on a line in the picture.
    fn draw_ground_plate(&mut self) {
        let layout = &self.drawing.layout;
        if self.drawing.is_planar() {
            return;
        }
        let points = layout.joints[BodyId::GROUND.0].iter().map(|&j| self.at(layout.places[j]));
        let outline = hull(points.collect());
        if outline.len() >= 3 {
            self.add(f64::MIN, corners("plate", &outline, true));
            self.obstacles_along(&outline);
        }
    }

    fn obstacles_along(&mut self, outline: &[Point]) {
        for (k, a) in outline.iter().enumerate() {
            self.obstacles.add_line(*a, outline[(k + 1) % outline.len()]);
        }
    }

    fn draw_body(&mut self, body: usize) {
        let layout = &self.drawing.layout;
        let content = &self.drawing.placed.mechanism.bodies()[body];
        let joints = &layout.joints[body];
        let mut points: Vec<Vec3<f64>> = Vec::new();
        for &joint in joints {
            let place = layout.places[joint];
            if points.iter().all(|known| (*known - place).norm() * self.scale > 0.5) {
                points.push(place);
            }
        }
        // A body with fewer than two distinct joint positions extends to its centre of mass.
        let com = self.coms[body];
        let reaches = points.len() < 2 && content.mass > 0.0;
        let to_com = reaches && points.iter().all(|at| (*at - com).norm() * self.scale > 2.0);
        if to_com {
            points.push(com);
        }
        let class = match layout.branch[body] {
            Some(branch) => format!("b{}", branch % COLOURS),
            None => "hub".to_owned(),
        };
        let outline: Vec<Point> = points.iter().map(|point| self.at(*point)).collect();
        let wide = hull(outline.clone());
        let mut shape = String::new();
        match wide.len() {
            0 => shape += &circle("com", self.at(com), 3.0),
            1 => {}
            2 => {
                let kind = thickness(self.drawing.placed.mechanism, joints, body);
                shape += &line(&format!("halo {kind}-halo"), wide[0], wide[1]);
                shape += &line(&format!("{kind} {class}"), wide[0], wide[1]);
                self.obstacles.add_line(wide[0], wide[1]);
            }
            _ => {
                shape += &corners(&format!("hub {class}"), &wide, true);
                self.obstacles_along(&wide);
            }
        }
        if to_com {
            shape += &circle("com", self.at(com), 3.0);
        }
        // Depth of the body's farthest point, so that its own joints are drawn above it.
        let depth = points.iter().map(|point| self.depth(*point)).fold(self.depth(com), f64::min);
        let name = escape(&content.name);
        let part =
            format!(r#"<g class="body" data-name="{name}"><title>{name}</title>{shape}</g>"#);
        self.add(depth, part);
    }

    fn draw_joint(&mut self, index: usize) {
        let joint = &self.joints()[index];
        let mechanism = self.drawing.placed.mechanism;
        let point = self.drawing.layout.places[index];
        let at = self.at(point);
        let frames = &self.drawing.placed;
        let (frame_j, frame_k) = (&frames.frame_j[index], &frames.frame_k[index]);
        let driven = joint.actuated.contains(&true);
        let ground = self.ground_mark(index, at);
        let symbol = self.pen.joint(joint.joint_type, driven, at, frame_j, frame_k);
        let r = self.pen.size;
        let half = match joint.joint_type {
            JointType::Prismatic | JointType::Cylindrical | JointType::Helical => {
                let axis = frame_j.rotation.columns[2];
                let (a, b) = (self.pen.go(at, axis, -2.4 * r), self.pen.go(at, axis, 2.4 * r));
                [(0.5 * (a[0] - b[0]).abs()).max(1.3 * r), (0.5 * (a[1] - b[1]).abs()).max(1.3 * r)]
            }
            JointType::Universal => [1.9 * r; 2],
            JointType::Planar => [2.4 * r; 2],
            _ => [1.35 * r; 2],
        };
        self.obstacles.areas.push(Area::around(at, half));
        if joint.joint_type == JointType::Revolute {
            let axis = frame_j.rotation.columns[2];
            let (a, b) = (self.pen.go(at, axis, -3.4 * r), self.pen.go(at, axis, 3.4 * r));
            self.obstacles.add_line(a, b);
        }
        let (p, s) = ends(mechanism, index);
        let name = escape(&joint.name);
        let title = format!(
            "{}: {}{}, {} to {}",
            joint.name,
            word(joint.joint_type),
            if driven { ", driven" } else { "" },
            mechanism.bodies()[p].name,
            mechanism.bodies()[s].name,
        );
        let part = format!(
            r#"<g class="joint" data-name="{name}" data-type="{}"><title>{}</title>{ground}{symbol}</g>"#,
            joint.joint_type.symbol(),
            escape(&title),
        );
        // A joint is drawn above its bodies, and a pin above the slide through which it passes.
        let slides = matches!(joint.joint_type, JointType::Prismatic | JointType::Planar);
        let before = if slides { 0.5 } else { 1.0 };
        self.add(self.depth(point) + before * r, part);
    }

    fn stroke(&self, joint: usize) -> (f64, f64) {
        let trail = self.drawing.trail;
        trail.and_then(|trail| trail.stroke(&self.drawing.placed, joint)).unwrap_or((0.0, 0.0))
    }

    /// Draws the ground mark of a joint that connects a body to the ground: a hatched line on the
    /// side away from the body, or along the axis of a sliding joint.
    fn ground_mark(&mut self, index: usize, at: Point) -> String {
        let joint = &self.joints()[index];
        let (p, s) = ends(self.drawing.placed.mechanism, index);
        if p != BodyId::GROUND.0 && s != BodyId::GROUND.0 || joint.joint_type == JointType::Free {
            return String::new();
        }
        let r = self.pen.size;
        let other = if p == BodyId::GROUND.0 { s } else { p };
        let point = self.drawing.layout.places[index];
        let leads_to = self.drawing.layout.joints[other]
            .iter()
            .filter(|&&joint| joint != index)
            .map(|&joint| self.drawing.layout.places[joint]);
        let leads_to = mean(leads_to).unwrap_or(self.coms[other]);
        let goes_down = self.at(leads_to)[1] > at[1] + 0.5 * self.scale * (leads_to - point).norm();
        let slides = matches!(joint.joint_type, JointType::Prismatic | JointType::Cylindrical);
        if slides {
            let axis = self.drawing.placed.frame_j[index].rotation.columns[2];
            let [x, y] = self.pen.view.project(axis);
            let across = x.hypot(y);
            if across > 0.1 {
                let (back, forth) = self.stroke(index);
                // If the successor is the ground, the axis moves with the body.
                let (back, forth) =
                    if s == BodyId::GROUND.0 { (-forth, -back) } else { (back, forth) };
                // The hatching lies on the lower side.
                let (mut u, mut v) = (x / across, y / across);
                let (mut from, mut to) = (back * self.scale * across, forth * self.scale * across);
                if u < 0.0 {
                    (u, v, from, to) = (-u, -v, -to, -from);
                }
                let (from, to) = (from - 3.2 * r, to + 3.2 * r);
                let (nx, ny) = (-v, u);
                let base = |t: f64| [at[0] + u * t + nx * 1.25 * r, at[1] + v * t + ny * 1.25 * r];
                self.obstacles.add_line(base(from), base(to));
                return hatched(base(from), base(to));
            }
        }
        let sign = if goes_down { -1.0 } else { 1.0 };
        let y = at[1] + sign * 2.1 * r;
        let (a, b) = ([at[0] - 1.9 * r, y], [at[0] + 1.9 * r, y]);
        let stem = line("rail", at, [at[0], y]);
        self.obstacles.areas.push(Area::around([at[0], y + sign * 3.0], [1.9 * r, 5.0]));
        // The hatching lies on the side away from the joint.
        stem + &if goes_down { hatched(b, a) } else { hatched(a, b) }
    }

    /// Collects the labels in the order in which they are placed. Labels of joints come first,
    /// because they must lie near their joints; labels of bodies and legs have more space.
    fn ask_for_labels(&mut self) {
        if self.joints().len() <= LABELLED {
            for joint in 0..self.joints().len() {
                let label = self.joint_label(joint);
                self.labels.push(label);
            }
        }
        let drawing = self.drawing;
        let (layout, bodies) = (&drawing.layout, drawing.placed.mechanism.bodies());
        for body in (1..bodies.len()).filter(|&body| layout.hubs[body]) {
            let at = self.at(layout.middle(body).unwrap_or(self.coms[body]));
            let (class, content) = ("name".to_owned(), bodies[body].name.clone());
            self.labels.push(Label { at, radius: 2.0, class, content, inside: true });
        }
        if layout.branches.len() > LABELLED {
            return;
        }
        for (branch, name) in layout.branches.iter().enumerate() {
            if let Some(at) = self.middle_of_branch(branch) {
                let class = format!("name t{}", branch % COLOURS);
                let content = name.clone();
                self.labels.push(Label { at, radius: 7.0, class, content, inside: false });
            }
        }
    }

    fn joint_label(&self, index: usize) -> Label {
        let layout = &self.drawing.layout;
        let name = &self.joints()[index].name;
        let branch = layout.branch_of_joint(self.drawing.placed.mechanism, index);
        // The label of the leg already contains the first part of the name.
        let content = match (name.split_once('.'), branch) {
            (Some((leg, rest)), Some(branch)) if layout.branches[branch] == leg => rest,
            _ => name,
        };
        let class = branch.map_or(String::new(), |branch| format!("t{}", branch % COLOURS));
        let at = self.at(layout.places[index]);
        let radius = 1.3 * self.pen.size;
        Label { at, radius, class, content: content.to_owned(), inside: false }
    }

    /// Returns the middle of the longest line of a branch in the picture, px; `None` for a branch
    /// without bodies.
    fn middle_of_branch(&self, branch: usize) -> Option<Point> {
        let layout = &self.drawing.layout;
        let mut best: Option<(f64, Point)> = None;
        let members = (0..layout.branch.len()).filter(|&b| layout.branch[b] == Some(branch));
        for body in members {
            let mut points: Vec<Point> =
                layout.joints[body].iter().map(|&joint| self.at(layout.places[joint])).collect();
            if points.len() < 2 {
                points.push(self.at(self.coms[body]));
            }
            for (k, a) in points.iter().enumerate() {
                for b in &points[..k] {
                    let length = (a[0] - b[0]).hypot(a[1] - b[1]);
                    // Selects the first of several lines whose lengths differ by round-off only.
                    if best.is_none_or(|(known, _)| length > known * (1.0 + 1e-6)) {
                        best = Some((length, [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]));
                    }
                }
            }
            best = best.or_else(|| points.first().map(|point| (0.0, *point)));
        }
        best.map(|(_, middle)| middle)
    }

    fn legend(&self) -> Vec<Entry> {
        let pen = Pen { size: self.pen.size.min(6.5), ..self.pen };
        let planar = self.drawing.is_planar();
        let joint_entry = |kind: JointType| {
            self.joints().iter().position(|joint| joint.joint_type == kind)?;
            let frame = sample_frame(&pen.view, kind, planar);
            let symbol = move |at: Point| {
                format!(r#"<g class="joint">{}</g>"#, pen.joint(kind, false, at, &frame, &frame))
            };
            let meaning = match kind {
                JointType::Fixed | JointType::Free => word(kind).to_owned(),
                _ => format!("{} {}", kind.symbol(), word(kind)),
            };
            Some(Entry { symbol: Box::new(symbol), half: pen.sample_half(kind, planar), meaning })
        };
        let mut legend: Vec<Entry> = JointType::ALL.into_iter().filter_map(joint_entry).collect();
        if self.joints().iter().any(|joint| joint.actuated.contains(&true)) {
            let symbol =
                |at: Point| format!(r#"<g class="joint">{}</g>"#, circle("drive-face", at, 6.5));
            let meaning = "driven".to_owned();
            legend.push(Entry { symbol: Box::new(symbol), half: 8.0, meaning });
        }
        if !self.drawing.layout.joints[BodyId::GROUND.0].is_empty() {
            let symbol =
                |at: Point| hatched([at[0] - 13.0, at[1] - 3.0], [at[0] + 13.0, at[1] - 3.0]);
            let meaning = "ground".to_owned();
            legend.push(Entry { symbol: Box::new(symbol), half: 15.0, meaning });
        }
        if !self.drawing.placed.mechanism.springs().is_empty() {
            let symbol = |at: Point| zigzag([at[0] - 15.0, at[1]], [at[0] + 15.0, at[1]], 5.0);
            let meaning = "spring".to_owned();
            legend.push(Entry { symbol: Box::new(symbol), half: 16.0, meaning });
        }
        if self.parts.iter().any(|(_, part)| part.contains(r#"class="trail""#)) {
            let symbol = |at: Point| line("trail", [at[0] - 12.0, at[1]], [at[0] + 12.0, at[1]]);
            let meaning = "path in the motion".to_owned();
            legend.push(Entry { symbol: Box::new(symbol), half: 13.0, meaning });
        }
        legend
    }
}

/// Returns the SVG markup of a white rectangle that covers `area` like a sheet of paper.
pub(super) fn sheet(area: &Area) -> String {
    let [x, y] = area.least;
    let [right, bottom] = area.greatest;
    corners("sheet", &[[x, y], [right, y], [right, bottom], [x, bottom]], true)
}

/// Returns the CSS class for the line width of a body. Of two bodies that a sliding joint connects,
/// the predecessor is drawn thicker.
pub(super) fn thickness(mechanism: &Mechanism, joints: &[usize], body: usize) -> &'static str {
    let slides = |joint: &&usize| {
        let kind = mechanism.joints()[**joint].joint_type;
        matches!(kind, JointType::Prismatic | JointType::Cylindrical | JointType::Helical)
    };
    match joints.iter().find(slides).map(|&joint| ends(mechanism, joint)) {
        Some((p, _)) if p == body => "tube",
        Some(_) => "stem",
        None => "bone",
    }
}

/// Returns the scale (px per m) and the centre (m) with which the area `seen` (m) fits into the
/// size `room` (px). `length` is the characteristic length of the mechanism, m.
fn fit(seen: &Area, room: Point, length: f64) -> (f64, Point) {
    let size = |k: usize| seen.greatest[k] - seen.least[k];
    let middle = |k: usize| 0.5 * (seen.greatest[k] + seen.least[k]);
    let ratio = |k: usize| room[k] / size(k);
    let by_size = ratio(0).min(ratio(1));
    // If all points coincide or there are none, the characteristic length determines the scale.
    let scale = if by_size.is_finite() && by_size > 0.0 && size(0).max(size(1)) > 1e-6 * length {
        by_size
    } else {
        0.25 * room[0] / length
    };
    let scale = if scale.is_finite() && scale > 0.0 { scale } else { 100.0 };
    let centre = [middle(0), middle(1)];
    (scale, if centre.iter().all(|c| c.is_finite()) { centre } else { [0.0; 2] })
}

/// Draws a line with short strokes on its right side, as seen from `a` towards `b`.
fn hatched(a: Point, b: Point) -> String {
    let length = (b[0] - a[0]).hypot(b[1] - a[1]).max(1e-9);
    let (u, v) = ((b[0] - a[0]) / length, (b[1] - a[1]) / length);
    let mut drawn = line("rail", a, b);
    let count = (length / 6.0).round().clamp(2.0, 80.0);
    for k in 0..count as usize {
        let t = (k as f64 + 0.7) / count * length;
        let foot = [a[0] + u * t, a[1] + v * t];
        let end = [foot[0] - 5.0 * u - 6.0 * v, foot[1] - 5.0 * v + 6.0 * u];
        drawn += &line("hatch", foot, end);
    }
    drawn
}
