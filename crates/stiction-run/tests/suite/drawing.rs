//! Pictures of mechanisms and the page of a check, read back as another program would read them.

use crate::common::*;
use roxmltree::{Document, Node, ParsingOptions};
use stiction_core::dynamics::{FrictionMode, InverseDynamics, Settings};
use stiction_core::joint::JointType;
use stiction_core::kinematics::{Coordinate, Target};
use stiction_core::mechanism::{BodySpec, GROUND_NAME, JointId, JointSpec, MechanismBuilder};
use stiction_core::spatial::{Mat3, Pose, Vec3};
use stiction_draw::drawing::{Detail, Drawing, Surface, Trail, View};
use stiction_draw::viewer::SCRIPT;
use stiction_format::{ModelFile, gallery};
use stiction_run::check::{Page, draw_page, examine};

fn assembled(model: &ModelFile) -> InverseDynamics {
    let motion = match &model.default_motion {
        Some(name) => model.motion(name).unwrap(),
        None => &model.motions[0].1,
    };
    let coordinates: Vec<_> = motion.coordinates.iter().map(|(c, _)| *c).collect();
    let targets: Vec<_> = motion.at(motion.start).collect();
    let (mechanism, initial_poses) = (model.mechanism.clone(), &model.initial_poses);
    InverseDynamics::new(mechanism, initial_poses, &coordinates, &targets, Settings::default())
        .unwrap()
}

fn picture(solver: &InverseDynamics) -> String {
    let drawing = Drawing::new(solver.mechanism(), &solver.bodies().pose);
    drawing.svg(&drawing.best_view(), Detail::Full, Surface::Inline)
}

fn page(model: &ModelFile) -> Page {
    let job = default_job(model, FrictionMode::Off);
    let findings = examine(&job, |_, _, _| true).unwrap();
    let page = draw_page(&job, &findings, None).unwrap();
    // The page may contain one script, whose text is not XML.
    let script = format!("<script>{SCRIPT}</script>\n");
    assert!(page.html.contains(&script));
    Page { html: page.html.replace(&script, ""), ..page }
}

fn parse(text: &str) -> Document<'_> {
    let options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
    Document::parse_with_options(text, options).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn of_class<'a>(picture: &'a Document<'_>, class: &'a str) -> impl Iterator<Item = Node<'a, 'a>> {
    picture.descendants().filter(move |node| {
        node.attribute("class").is_some_and(|all| all.split(' ').any(|own| own == class))
    })
}

fn names(picture: &Document<'_>, class: &str) -> Vec<String> {
    let mut names: Vec<String> = of_class(picture, class)
        .filter_map(|n| n.attribute("data-name"))
        .map(str::to_owned)
        .collect();
    names.sort();
    names
}

fn value(node: Node<'_, '_>, attribute: &str) -> f64 {
    node.attribute(attribute).unwrap().parse().unwrap()
}

/// Returns the numbers in all attributes of a node.
fn numbers(node: Node<'_, '_>) -> Vec<f64> {
    let geometry = ["x", "y", "x1", "y1", "x2", "y2", "cx", "cy", "r", "points", "d", "viewBox"];
    let texts = node.attributes().filter(|a| geometry.contains(&a.name())).map(|a| a.value());
    let pieces = texts.flat_map(|text| text.split(|c: char| " ,MLAZ".contains(c)));
    pieces.filter(|piece| !piece.is_empty()).map(|piece| piece.parse().unwrap()).collect()
}

/// Checks that a picture is well-formed, contains every body and joint once, and has all numbers
/// inside its frame.
fn check_picture(what: &str, solver: &InverseDynamics, svg: &str) {
    let parsed = parse(svg);
    let mechanism = solver.mechanism();
    let mut joints: Vec<String> = mechanism.joints().iter().map(|j| j.name.clone()).collect();
    joints.sort();
    assert_eq!(names(&parsed, "joint"), joints, "{what}");
    let mut bodies: Vec<String> = mechanism.bodies()[1..].iter().map(|b| b.name.clone()).collect();
    bodies.sort();
    assert_eq!(names(&parsed, "body"), bodies, "{what}");
    for joint in of_class(&parsed, "joint").filter(|node| node.has_attribute("data-name")) {
        let shapes = ["circle", "path", "polygon"];
        let drawn = joint.descendants().any(|node| shapes.contains(&node.tag_name().name()));
        assert!(drawn, "{what}: {:?} has a symbol", joint.attribute("data-name"));
    }
    let frame = numbers(parsed.root_element());
    let (left, top, right, bottom) = (frame[0], frame[1], frame[0] + frame[2], frame[1] + frame[3]);
    assert!(frame[2] > 50.0 && frame[2] < 1500.0 && frame[3] > 50.0 && frame[3] < 1500.0, "{what}");
    for node in parsed.descendants() {
        assert!(numbers(node).iter().all(|x| x.is_finite()), "{what}");
        let points = match node.tag_name().name() {
            "circle" => vec![(value(node, "cx"), value(node, "cy"))],
            "text" => vec![(value(node, "x"), value(node, "y"))],
            "line" => {
                vec![(value(node, "x1"), value(node, "y1")), (value(node, "x2"), value(node, "y2"))]
            }
            "polygon" | "polyline" => {
                numbers(node).chunks(2).map(|pair| (pair[0], pair[1])).collect()
            }
            _ => Vec::new(),
        };
        for (x, y) in points {
            let inside = left <= x && x <= right && top <= y && y <= bottom;
            assert!(inside, "{what}: ({x}, {y}) is cut off: {frame:?}");
        }
    }
}

#[test]
fn every_robot_of_the_gallery_is_drawn() {
    for name in gallery::names() {
        let solver = assembled(&model(name));
        let trail = Trail::new(solver.mechanism(), &solver.bodies().pose);
        let drawing = Drawing::new(solver.mechanism(), &solver.bodies().pose).with_trail(&trail);
        let views = [drawing.best_view(), View::front(), View::side(), View::top()];
        for view in views {
            for detail in [Detail::Full, Detail::Small] {
                for surface in [Surface::Inline, Surface::Paper] {
                    check_picture(name, &solver, &drawing.svg(&view, detail, surface));
                }
            }
        }
    }
}

#[test]
fn planar_robots_are_seen_face_on() {
    for name in gallery::names() {
        let solver = assembled(&model(name));
        let drawing = Drawing::new(solver.mechanism(), &solver.bodies().pose);
        let is_planar = ["3rrr", "five-bar", "four-bar", "slider-crank"].contains(&name);
        if is_planar {
            assert!(drawing.is_planar(), "{name}");
            assert!((drawing.best_view().toward.z - 1.0).abs() < 1e-9, "{name}");
        }
        if ["3rps", "6sps", "bricard", "gough", "zhang2018"].contains(&name) {
            assert!(!drawing.is_planar(), "{name}");
            let View { right, up, toward } = drawing.best_view();
            assert!(toward.z > 0.2 && up.z > 0.5 && right.z.abs() < 1e-9, "{name}: from above");
        }
        let View { right, up, toward } = drawing.best_view();
        assert!((right.cross(up) - toward).norm() < 1e-12, "{name}: not mirrored");
    }
}

/// Returns the centre of a joint that is drawn as a single circle.
fn place(picture: &Document<'_>, name: &str) -> (f64, f64) {
    let joint =
        of_class(picture, "joint").find(|n| n.attribute("data-name") == Some(name)).unwrap();
    let circle = joint
        .descendants()
        .find(|node| node.has_tag_name(("http://www.w3.org/2000/svg", "circle")));
    let circle = circle.unwrap();
    (value(circle, "cx"), value(circle, "cy"))
}

/// Tests distances of joints relative to the scale bar, and directions relative to the axes.
#[test]
fn pictures_are_to_scale() {
    let solver = assembled(&model("four-bar"));
    let svg = picture(&solver);
    let parsed = parse(&svg);
    let scale = of_class(&parsed, "scale").next().unwrap();
    let bar = scale.first_element_child().unwrap();
    let length = value(bar, "x2") - value(bar, "x1");
    let text = scale.descendants().find_map(|node| node.text()).unwrap();
    let millimetres: f64 = text.strip_suffix(" mm").unwrap().parse().unwrap();
    let scale = length / (1e-3 * millimetres);
    let origins = &solver.bodies().frame_j;
    let mechanism = solver.mechanism();
    let joint = |name: &str| origins[mechanism.joint_id(name).unwrap().0].position;
    for (a, b) in [("A", "B"), ("A", "D"), ("C", "B"), ("D", "C")] {
        let apart = (joint(b) - joint(a)) * scale;
        let (from, to) = (place(&parsed, a), place(&parsed, b));
        // Coordinates have one decimal. The error of the scale bar is multiplied by the ratio of
        // the lengths.
        let tolerance = 0.2 + 0.1 * apart.norm() / length;
        assert!((to.0 - from.0 - apart.x).abs() < tolerance, "{a} {b}: x to the right");
        assert!((from.1 - to.1 - apart.y).abs() < tolerance, "{a} {b}: y upwards");
    }
}

/// Tests the ends of a spring that connects the places of two joints.
#[test]
fn springs_are_drawn_between_their_points() {
    let text = r#"
        gravity = [0, 0, 0]
        [bodies.crank]
        mass = 1
        com = ["50 mm", 0, 0]
        inertia = [1e-3, 1e-3, 1e-3]
        [bodies.arm]
        mass = 1
        com = ["50 mm", 0, 0]
        inertia = [1e-3, 1e-3, 1e-3]
        [joints.A]
        type = "R"
        from = "ground"
        to = "crank"
        axis = "z"
        actuated = true
        [joints.B]
        type = "R"
        from = "crank"
        to = "arm"
        at = ["100 mm", 0, 0]
        axis = "z"
        actuated = true
        [springs.s]
        from = "ground"
        to = "arm"
        stiffness = "200 N/m"
        free_length = "40 mm"
        [motions.m]
        A = "50 deg"
        B = "30 deg"
        duration = 0
    "#;
    let model = model_of("arms", text);
    let svg = picture(&assembled(&model));
    let picture = parse(&svg);
    let springs: Vec<_> = of_class(&picture, "elastic").collect();
    assert_eq!(springs.len(), 1);
    assert_eq!(springs[0].attribute("data-name"), Some("s"));
    let zigzag = springs[0].descendants().find(|node| node.has_tag_name("polyline")).unwrap();
    let corners: Vec<f64> = numbers(zigzag);
    let ends = [(corners[0], corners[1]), (corners[corners.len() - 2], corners[corners.len() - 1])];
    for (end, joint) in ends.into_iter().zip(["A", "B"]) {
        let (x, y) = place(&picture, joint);
        assert!((end.0 - x).abs() < 0.2 && (end.1 - y).abs() < 0.2, "{end:?} {x} {y}");
    }
    assert!(svg.contains(">spring<"), "the legend names springs");
}

/// Returns approximate bounding boxes of the labels of joints, bodies and legs.
fn boxes(picture: &Document<'_>) -> Vec<(String, [f64; 4])> {
    let texts = picture.descendants().filter(|node| {
        node.has_tag_name(("http://www.w3.org/2000/svg", "text"))
            && node.attribute("text-anchor") == Some("middle")
            && node.parent().is_some_and(|parent| {
                parent.is_root()
                    || !parent.has_attribute("class")
                    || parent.attribute("class") == Some("mechanism")
            })
    });
    texts
        .map(|node| {
            let content = node.text().unwrap().to_owned();
            let half = 0.5 * 0.5 * 14.0 * content.chars().count() as f64;
            let (x, y) = (value(node, "x"), value(node, "y"));
            (content, [x - half, x + half, y - 10.0, y])
        })
        .collect()
}

#[test]
fn labels_do_not_cover_each_other() {
    for name in gallery::names() {
        let solver = assembled(&model(name));
        let svg = picture(&solver);
        let parsed = parse(&svg);
        let boxes = boxes(&parsed);
        assert!(boxes.len() >= solver.mechanism().joints().len(), "{name}: {boxes:?}");
        for (k, (a, one)) in boxes.iter().enumerate() {
            for (b, other) in &boxes[..k] {
                let apart = one[1] <= other[0] || other[1] <= one[0];
                assert!(apart || one[3] <= other[2] || other[3] <= one[2], "{name}: {a} on {b}");
            }
        }
    }
}

#[test]
fn a_leg_is_one_colour_and_named_once() {
    let solver = assembled(&model("3rps"));
    let svg = picture(&solver);
    let parsed = parse(&svg);
    let elements = parsed.descendants().filter(Node::is_element);
    let texts: Vec<&str> = elements.filter_map(|node| node.text()).collect();
    for leg in ["leg1", "leg2", "leg3"] {
        assert_eq!(texts.iter().filter(|text| **text == leg).count(), 1, "{leg}");
    }
    // Cylinder and rod form a leg; the platform is not part of one.
    let colour = |body: &str| {
        let body = of_class(&parsed, "body").find(|n| n.attribute("data-name") == Some(body));
        let shape = body.unwrap().last_element_child().unwrap();
        let class = shape.attribute("class").unwrap();
        class.split(' ').find(|class| class.starts_with('b')).map(str::to_owned)
    };
    assert!(colour("leg1.cylinder").is_some());
    assert_eq!(colour("leg1.cylinder"), colour("leg1.rod"));
    assert_ne!(colour("leg1.rod"), colour("leg2.rod"));
    assert_eq!(colour("platform"), None);
    let driven = of_class(&parsed, "joint").filter(|joint| {
        joint.has_attribute("data-name")
            && joint.descendants().any(|n| n.attribute("class") == Some("drive-face"))
    });
    let driven: Vec<_> = driven.map(|joint| joint.attribute("data-name").unwrap()).collect();
    let expected = ["leg1.P", "leg2.P", "leg3.P"];
    assert!(driven.len() == 3 && expected.iter().all(|name| driven.contains(name)), "{driven:?}");
}

/// Creates a chain with one body for each joint type, each body one step along x from the previous
/// one.
fn chain(types: &[JointType], step: f64, name: &str) -> InverseDynamics {
    let mut builder = MechanismBuilder::new(name).characteristic_length(step.abs().max(1e-3));
    let mut last = GROUND_NAME.to_owned();
    for (k, kind) in types.iter().enumerate() {
        let body = BodySpec::new(format!("{name}{k}")).mass(1.0).inertia(Mat3::identity());
        builder = builder.body(body.com(Vec3::new(0.5 * step, 0.0, 0.0)));
        let next = format!("{name}{k}");
        let at = if k == 0 { 0.0 } else { step };
        let pitch = if *kind == JointType::Helical { 1e-3 } else { 0.0 };
        let frame = Pose::at(Vec3::new(at, 0.0, 0.0));
        let joint = JointSpec::new(format!("{name}-{k}"), *kind, last, next.as_str());
        builder = builder.joint(joint.frames(frame, Pose::identity()).pitch(pitch));
        last = next;
    }
    let mechanism = builder.build().unwrap();
    let mut coordinates = Vec::new();
    for (k, kind) in types.iter().enumerate() {
        for dof in 0..kind.dofs().len() {
            coordinates.push(Coordinate::Joint { joint: JointId(k), dof });
        }
    }
    let zero = Target { value: 0.0, rate: 0.0, acceleration: 0.0 };
    let targets = vec![zero; coordinates.len()];
    InverseDynamics::new(mechanism, &[], &coordinates, &targets, Settings::default()).unwrap()
}

const SCALAR: [JointType; 7] = [
    JointType::Revolute,
    JointType::Prismatic,
    JointType::Helical,
    JointType::Cylindrical,
    JointType::Universal,
    JointType::Planar,
    JointType::Fixed,
];

#[test]
fn every_type_of_joint_is_drawn_at_any_size() {
    for step in [1e-9, 0.2, 1e9, 0.0] {
        let solver = chain(&SCALAR, step, "link");
        let drawing = Drawing::new(solver.mechanism(), &solver.bodies().pose);
        for view in [drawing.best_view(), View::front(), View::side(), View::top()] {
            let svg = drawing.svg(&view, Detail::Full, Surface::Inline);
            check_picture(&format!("steps of {step} m"), &solver, &svg);
        }
    }
    for kind in SCALAR {
        for step in [0.0, 0.3] {
            let solver = chain(&[kind], step, "alone");
            check_picture(kind.symbol(), &solver, &picture(&solver));
        }
    }
}

#[test]
fn a_free_body_and_a_ball_are_drawn() {
    let text = r#"
        gravity = [0, 0, -9.81]
        [bodies.stone]
        mass = 2
        com = [0, 0, 0.1]
        inertia = [0.1, 0.1, 0.1]
        [bodies.rider]
        [joints.nothing]
        type = "free"
        from = "ground"
        to = "stone"
        [joints.ball]
        type = "S"
        from = "stone"
        to = "rider"
        [motions.fall]
        stone.x = "0.1*t"
        stone.y = 0
        stone.z = "-9.81/2*t^2"
        stone.rx = 0
        stone.ry = 0
        stone.rz = 0
        rider.rx = 0
        rider.ry = 0
        rider.rz = 0
        [default]
        motion = "fall"
        load = "none"
        [loads.none]
    "#;
    let model = model_of("stone", text);
    let solver = assembled(&model);
    check_picture("stone", &solver, &picture(&solver));
    parse(&page(&model).html);
}

#[test]
fn names_are_escaped() {
    let solver = chain(&[JointType::Revolute, JointType::Revolute], 0.2, "<b>&\"it's\"");
    let svg = picture(&solver);
    check_picture("odd names", &solver, &svg);
    assert!(!svg.contains("<b>") && svg.contains("&lt;b&gt;&amp;&quot;it&#39;s&quot;"));

    let text = gallery::get("four-bar").unwrap();
    let title = "</title><script>alert('x')</script> & more";
    let source = text.lines().map(|line| match line {
        line if line.starts_with("title = ") && !text[..text.find(line).unwrap()].contains('[') => {
            format!("title = \"{title}\"\n")
        }
        line => format!("{line}\n"),
    });
    let model = model_of("four-bar", &source.collect::<String>());
    assert_eq!(model.title, title);
    let page = page(&model);
    let parsed = parse(&page.html);
    assert!(!page.html.contains("<script>"));
    assert!(parsed.descendants().any(|node| node.text() == Some(title)));
}

#[test]
fn pages_are_well_formed_and_complete() {
    for name in gallery::names() {
        let model = model(name);
        let page = page(&model);
        let parsed = parse(&page.html);
        let heading = |text: &str| {
            parsed.descendants().any(|n| n.tag_name().name() == "h2" && n.text() == Some(text))
        };
        for text in [
            "The mechanism",
            "Degrees of freedom",
            "Redundancy and uniqueness",
            "Nearest singular positions",
            "Masses",
            "Along the motion",
        ] {
            assert!(heading(text), "{name}: {text}");
        }
        for word in ["NaN", "inf ", "http:", "https:"] {
            // The SVG namespace is an identifier that browsers do not load. Samples are excluded,
            // because their Base64 text may contain any letters.
            let own = page.html.replace("http://www.w3.org/2000/svg", "");
            let (before, data) = own.split_once("<script").unwrap_or((&own, "</script>"));
            let own = format!("{before}{}", data.split_once("</script>").unwrap().1);
            assert!(!own.contains(word), "{name}: {word}");
        }
        // The page loads nothing. Its scripts except the viewer are data.
        let foreign = ["link", "img", "iframe", "image", "use"];
        assert!(parsed.descendants().all(|n| !foreign.contains(&n.tag_name().name())), "{name}");
        let mut scripts = parsed.descendants().filter(|n| n.tag_name().name() == "script");
        assert!(scripts.all(|n| n.attribute("type") == Some("application/json")), "{name}");
        parse(&page.picture);
        // Every body has its mass, and every joint with coordinates its range.
        let cells: Vec<&str> = parsed
            .descendants()
            .filter(|n| n.tag_name().name() == "td")
            .filter_map(|n| n.text())
            .collect();
        for body in &model.mechanism.bodies()[1..] {
            assert!(cells.contains(&body.name.as_str()), "{name}: {}", body.name);
        }
    }
}

/// Tests the numbers in the table against those in JSON.
#[test]
fn self_stresses_are_listed_by_joint() {
    let model = model("zhang2018");
    let html = page(&model).html;
    let parsed = parse(&html);
    let details: Vec<_> =
        parsed.descendants().filter(|n| n.tag_name().name() == "details").collect();
    assert_eq!(details.len(), 1);
    let rows: Vec<Vec<&str>> = details[0]
        .descendants()
        .filter(|n| n.tag_name().name() == "tr")
        .map(|row| row.children().filter_map(|cell| cell.text()).collect())
        .collect();
    assert_eq!(rows.len(), 1 + 9);
    let force = |joint: &str| -> f64 {
        let number = rows.iter().find(|row| row[0] == joint).unwrap()[2];
        number.replace('−', "-").parse().unwrap()
    };
    // The three parallel forces along y are in equilibrium. By the printed geometry, the distances
    // of the platform's S joints from the line of the resultant are in the ratio 2 : -1 : -1.
    let (one, two, three) = (force("leg1.S"), force("leg2.S"), force("leg3.S"));
    // The table has four digits.
    assert!((one + two + three).abs() < 2e-4 * one.abs() && (two - three).abs() < 2e-4);
}

/// Tests that the picture in the book equals that of the program, except for the last digits.
#[test]
fn the_picture_of_the_book_is_current() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/src/pictures/3rps.svg");
    let book = std::fs::read_to_string(path).unwrap();
    let own = page(&model("3rps")).picture;
    let (book, own) = (parse(&book), parse(&own));
    let elements = |picture: &Document<'_>| -> Vec<(String, Option<String>)> {
        let elements = picture.descendants().filter(Node::is_element);
        elements.map(|n| (n.tag_name().name().into(), n.text().map(str::to_owned))).collect()
    };
    assert_eq!(elements(&book), elements(&own), "stiction check 3rps -o DIR writes it");
    for (a, b) in book.descendants().zip(own.descendants()) {
        for (a, b) in numbers(a).iter().zip(numbers(b)) {
            // Coordinates have one decimal, which may be rounded differently on other machines.
            assert!((a - b).abs() < 0.15, "stiction check 3rps -o DIR writes it anew");
        }
    }
}
