//! Events between two rows are not missed.

use crate::program::{Folder, column};

/// Positions and references count full turns between two rows: 20 rad/s, one row per second.
#[test]
fn turns_between_rows_count() {
    let folder = Folder::new("forward-spin");
    let model = r#"
        gravity = [0, 0, 0]
        [bodies.wheel]
        mass = 1
        com = [0, 0, 0]
        inertia = [0.1, 0.1, 0.1]
        [joints.axle]
        type = "R"
        from = "ground"
        to = "wheel"
        axis = "z"
        actuated = true
        [motions.spin]
        duration = 5
        axle = "20 rad/s*t"
        "#;
    folder.write("wheel.toml", model);
    let controller = "type = pd; kp = 0.01; kd = 0.05; period = 0.5 s";
    let spin = ["forward", "wheel.toml", "--step", "1", "-o", ".", "--controller", controller];
    folder.stiction(&spin).succeeds();
    let table = folder.read("forward.csv");
    for name in ["axle.position [rad]", "axle.reference [rad]"] {
        let angles = column(&table, name);
        assert_eq!(angles.len(), 6);
        for (second, angle) in angles.iter().enumerate() {
            assert!((angle - 20.0 * second as f64).abs() < 1e-10, "{name}: {angles:?}");
        }
    }
}

/// Simulates a mass of 1 kg on a level guide under an effort given as a formula; returns its final
/// rate and its table of events.
fn pushed(folder: &Folder, mu: &str, drive: &str, step: &str) -> (f64, String) {
    let model = format!(
        r#"
        gravity = [0, 0, "-10 m/s^2"]
        [bodies.block]
        mass = 1
        com = [0, 0, 0]
        inertia = [1, 1, 1]
        [joints.guide]
        type = "P"
        from = "ground"
        to = "block"
        axis = "x"
        actuated = true
        {mu}
        "#
    );
    folder.write("block.toml", &model);
    let drive = format!("guide = {drive}");
    let run =
        ["forward", "block.toml", "--until", "2", "--step", step, "-o", ".", "--drives", &drive];
    folder.stiction(&run).succeeds();
    let rates = column(&folder.read("forward.csv"), "guide.rate [m/s]");
    (*rates.last().unwrap(), folder.read("events.csv"))
}

/// Inputs shorter than a step of a steady mechanism are resolved, independent of the rows: a push
/// of 1000 N for 0.6 ms, including ramps of 0.2 ms on either side (0.6 N s in total).
#[test]
fn a_short_push_is_not_missed() {
    let folder = Folder::new("forward-push");
    let push = "1000 N*(smooth(t, 1.0021, 1.0023) - smooth(t, 1.0027, 1.0029))";
    for step in ["0.01", "0.1", "1"] {
        let (rate, _) = pushed(&folder, "", push, step);
        assert!((rate - 0.6).abs() < 1e-10, "{step}: {rate}");
        let (_, events) = pushed(&folder, "friction = { mu = 0.5 }", push, step);
        assert!(events.contains("slides"), "{step}: {events}");
    }
}

/// A force that oscillates 50 times per second is zero at every row and still exceeds friction in
/// between; a force that exceeds it by 1e-4 for a moment starts the slip at that moment.
#[test]
fn oscillating_forces_between_rows_start_slip() {
    let folder = Folder::new("forward-swing");
    let begins = |events: &str| -> f64 {
        let first = events.lines().nth(1).unwrap_or_else(|| panic!("nothing happens: {events}"));
        assert!(first.contains("slides"), "{first}");
        first.split(',').next().unwrap().parse().unwrap()
    };
    for step in ["0.01", "0.1"] {
        let (_, events) = pushed(&folder, "friction = { mu = 0.5 }", "10 N*sin(2*pi*50*t)", step);
        // Slip starts at half of the amplitude; the block then slides back and forth without
        // sticking.
        assert!((begins(&events) - 1.0 / 600.0).abs() < 1e-10, "{step}: {events}");
        assert_eq!(events.matches("reverses").count(), 199, "{step}: {events}");
    }
    let first = (5.0 / 5.0005_f64).asin() / std::f64::consts::TAU;
    for step in ["0.01", "0.07", "0.1"] {
        let both = "friction = { mu = 0.2, mu_static = 0.5 }";
        let (_, events) = pushed(&folder, both, "5.0005 N*sin(2*pi*t)", step);
        let at = begins(&events);
        // Slip starts at a relative excess of 1e-9 over the limit: near a peak this delays it by
        // 1e-9/(2 pi cos).
        let forgiven = 1e-9 / (std::f64::consts::TAU * (1.0 - (5.0 / 5.0005_f64).powi(2)).sqrt());
        assert!((at - first).abs() < 1.1 * forgiven, "{step}: {at} {first}");
        // Once per half turn.
        assert_eq!(events.matches("slides").count(), 4, "{step}: {events}");
    }
}
