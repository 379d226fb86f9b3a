//! Motions through waypoints: laws, limits, dwells, blends and orientations.

use stiction_format::{ModelFile, Motion, Source, gallery, read};

fn model(name: &str) -> ModelFile {
    let source = Source::new(format!("{name}.toml"), gallery::get(name).unwrap());
    read(&source, &|_| Err("no files".to_owned())).unwrap()
}

fn motion(text: &str) -> Result<Motion, String> {
    motion_of("five-bar", text)
}

fn motion_of(name: &str, text: &str) -> Result<Motion, String> {
    model(name)
        .read_motion(&Source::new("motion.toml", text), &|_| Err("no files".to_owned()))
        .map_err(|diagnostics| diagnostics.to_string())
}

/// A pick-and-place cycle: times follow from the limits of the tool's path.
#[test]
fn durations_follow_from_limits() {
    let motion = motion(
        r#"
        law = "trapezoid"
        limits.tool = { speed = "1 m/s", acceleration = "10 m/s^2" }
        waypoints = [
            { tool.x = "-80 mm", tool.y = "340 mm", dwell = "50 ms" },
            { tool.x = "80 mm" },
            { tool.y = "380 mm", dwell = "0.1 s" },
        ]"#,
    )
    .unwrap();
    // 160 mm: 1/v + v/a per unit distance; 40 mm: a triangle of 2 sqrt(d/a).
    let (first, second) = (0.16 + 0.1, 2.0 * (0.04f64 / 10.0).sqrt());
    assert!((motion.duration - (0.05 + first + second + 0.1)).abs() < 1e-15);
    let at = |t: f64| motion.at(t).collect::<Vec<_>>();
    assert_eq!(at(0.02)[0].value, -0.08);
    let middle = at(0.05 + first / 2.0);
    assert!(middle[0].value.abs() < 1e-15 && (middle[0].rate - 1.0).abs() < 1e-12);
    assert_eq!(middle[1].value, 0.34);
    let up = at(0.05 + first + second / 4.0);
    assert_eq!(up[0].value, 0.08);
    assert!((up[1].acceleration - 10.0).abs() < 1e-9, "{:?}", up[1]);
    let end = at(motion.duration);
    assert_eq!((end[0].value, end[1].value, end[1].rate), (0.08, 0.38, 0.0));
}

/// No limit is exceeded at any instant, and one of them is reached in every move.
#[test]
fn limits_hold_for_every_law() {
    for law in ["quintic", "cycloid", "modified-sine", "trapezoid", "s-curve"] {
        let motion = motion(&format!(
            r#"law = "{law}"
            limits.tool = {{ speed = "0.8 m/s", acceleration = "9 m/s^2", jerk = "300 m/s^3" }}
            waypoints = [{{ tool.x = -0.08, tool.y = 0.34 }}, {{ tool.x = 0.08, tool.y = 0.38 }}]"#,
        ))
        .unwrap();
        let mut most = [0f64; 2];
        for k in 0..=200_000 {
            let both: Vec<_> = motion.at(motion.duration * f64::from(k) / 2e5).collect();
            most[0] = most[0].max(both[0].rate.hypot(both[1].rate));
            most[1] = most[1].max(both[0].acceleration.hypot(both[1].acceleration));
        }
        assert!(most[0] < 0.8 * (1.0 + 1e-12) && most[1] < 9.0 * (1.0 + 1e-12), "{law}: {most:?}");
        // The fastest course is bounded by the speed, the acceleration or the jerk.
        let jerk_bound = matches!(law, "quintic" | "cycloid" | "modified-sine");
        let reached = most[0] > 0.8 * (1.0 - 1e-9) || most[1] > 9.0 * (1.0 - 1e-6);
        assert!(reached || jerk_bound, "{law}: {most:?}");
    }
}

#[test]
fn a_blend_rounds_the_corner() {
    let text = |blend: &str| {
        format!(
            r#"waypoints = [
                {{ tool.x = 0, tool.y = 0.34 }},
                {{ tool.x = 0.05, duration = 0.2, blend = {blend} }},
                {{ tool.y = 0.36, duration = 0.2 }},
            ]"#
        )
    };
    let blended = motion(&text("0.08")).unwrap();
    assert!((blended.duration - 0.32).abs() < 1e-15);
    // At the beginning of the second move both coordinates begin to share.
    let corner: Vec<_> = blended.at(0.16).collect();
    assert!(corner[0].rate > 0.0 && corner[0].value < 0.05 && corner[1].value > 0.34);
    let end: Vec<_> = blended.at(0.32).collect();
    assert_eq!((end[0].value, end[1].value), (0.05, 0.36));
    assert!(motion(&text("0.15")).unwrap_err().contains("half of the shorter"));
    assert_eq!(motion(&text("0")).unwrap().duration, 0.4);
}

/// Between two orientations the body turns about a fixed axis: at half the way by half the angle.
#[test]
fn orientations_are_interpolated_on_the_rotation_group() {
    let motion = motion_of(
        "gough",
        r#"waypoints = [
            { platform.rotation = { axis = "x", angle = "20 deg" } },
            { platform.rotation = { zyx = ["30 deg", "10 deg", "-15 deg"] }, duration = 1 },
        ]"#,
    )
    .unwrap();
    let rotation = |t: f64| {
        let r: Vec<f64> = motion.at(t).map(|target| target.value).collect();
        nalgebra::Rotation3::from_scaled_axis(nalgebra::Vector3::new(r[0], r[1], r[2]))
    };
    let (from, half, to) = (rotation(0.0), rotation(0.5), rotation(1.0));
    let expected = from.slerp(&to, 0.5);
    assert!((half.matrix() - expected.matrix()).norm() < 1e-14);
    let zyx = nalgebra::Rotation3::from_euler_angles(
        (-15f64).to_radians(),
        10f64.to_radians(),
        30f64.to_radians(),
    );
    assert!((to.matrix() - zyx.matrix()).norm() < 1e-14);
    let h = 1e-5;
    for axis in 0..3 {
        let [low, at, high] = [0.3 - h, 0.3, 0.3 + h].map(|t| motion.at(t).nth(axis).unwrap());
        assert!(((high.value - low.value) / (2.0 * h) - at.rate).abs() < 1e-8);
        assert!(((high.rate - low.rate) / (2.0 * h) - at.acceleration).abs() < 1e-7);
    }
}

#[test]
fn defects_are_explained() {
    for (text, says) in [
        ("waypoints = 3", "a list of at least two tables"),
        ("waypoints = [{ tool.x = 0 }]", "a list of at least two tables"),
        ("waypoints = [{ tool.x = 0 }, { tool.x = 1 }]", "the duration of the move"),
        ("waypoints = [{ tool.x = 0 }, { tool.y = 1, at = 1 }]", "does not give `tool.y`"),
        ("waypoints = [{ tool.x = 0, at = 0 }, { tool.x = 1, at = 1 }]", "cannot have `at`"),
        ("waypoints = [{ tool.x = 0 }, { tool.x = 1, at = -1 }]", "longer than no time"),
        (
            "waypoints = [{ tool.x = 0 }, { tool.x = 1, duration = 1 }]\nduration = 2",
            "cannot have `duration`",
        ),
        ("law = \"quintic\"\ntool.x = 1", "needs `waypoints`"),
        (
            "tool.y = 1\nwaypoints = [{ tool.x = 0 }, { tool.x = 1, at = 1 }]",
            "both waypoints and expressions",
        ),
        (
            "limits.tool.speed = 1\nwaypoints = [{ tool.x = 0 }, { tool.x = 1, duration = 0.5 }]",
            "within its limits it needs 1.875 s",
        ),
        (
            "limits.tool.speed = 1\nlaw = \"trapezoid\"\nwaypoints = [{ tool.x = 0 }, { tool.x = 1 }]",
            "needs a limit of the acceleration",
        ),
        (
            "limits.left_motor.speed = 1\nwaypoints = [{ tool.x = 0 }, { tool.x = 1 }]",
            "`left_motor` is no coordinate of the waypoints",
        ),
        (
            "limits.tool.acceleration = 9\nwaypoints = [{ tool.x = 0, tool.y = 0.3 }, { tool.x = 0.1, blend = 0.09 }, { tool.x = 0 }]",
            "of `tool` reaches",
        ),
        (
            "waypoints = [{ tool.rotation = { axis = \"z\", angle = 0 } }, { tool.rotation = { axis = \"z\", angle = 1 }, at = 1, blend = 0.1 }, { tool.rotation = { axis = \"z\", angle = 1.5 }, at = 2 }]",
            "no `blend` between orientations",
        ),
        ("limits.speed = 1\nwaypoints = [{ tool.x = 0 }, { tool.x = 1 }]", "needs the name"),
        (
            "waypoints = [{ tool.x = 0 }, { tool.x = 1, law = \"sin\", at = 1 }]",
            "`sin` is not understood",
        ),
        ("waypoints = [{ toool.x = 0 }, { tool.x = 1, at = 1 }]", "did you mean `tool`"),
        (
            "waypoints = [{ tool.rotation = { axis = \"z\", angle = 0 } },
                { tool.rotation = { axis = \"z\", angle = 2 }, at = 1 },
                { tool.rotation = { axis = \"z\", angle = 3.5 }, at = 2 }]",
            "half a turn",
        ),
    ] {
        let message = motion(text).unwrap_err();
        assert!(message.contains(says), "{text}: {message}");
    }
}
