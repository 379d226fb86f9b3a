//! Events between two rows of the table.

use crate::program::{Folder, column};

/// Positions and references count full turns between two rows: the joint rotates at 20 rad/s, with
/// one row per second.
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

/// Inputs shorter than the integration steps of a mechanism that hardly changes its motion are
/// resolved, independently of the rows: a force pulse of 1000 N lasts 0.6 ms, including ramps of
/// 0.2 ms on both sides (0.6 N s in total).
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

/// A force that oscillates 50 times per second is zero at every row and exceeds the static friction
/// limit in between. A force that exceeds this limit by a fraction of 1e-4 for a short time starts
/// slip at that time.
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
        // Slip starts at a relative excess of 1e-9 over the static friction limit, which delays
        // slip near a peak by 1e-9/(2 pi cos).
        let forgiven = 1e-9 / (std::f64::consts::TAU * (1.0 - (5.0 / 5.0005_f64).powi(2)).sqrt());
        assert!((at - first).abs() < 1.1 * forgiven, "{step}: {at} {first}");
        // The block slides once in each half period.
        assert_eq!(events.matches("slides").count(), 4, "{step}: {events}");
    }
}

/// The legs of a robot jam, so that time stepping replaces the event-driven method, and the robot
/// comes to rest between two rows. In every step, positions are the integral of the rates, even if
/// joints begin to stick at the end of the step.
#[test]
fn rows_close_the_loops_before_joints_stick() {
    let folder = Folder::new("forward-jamming");
    let legs = [
        "U1.friction.mu=0.10155264526369119",
        "P.friction.mu=0.33039930145108765",
        "P.friction.viscous=0 N s/m",
        "P.friction.mu_static=0.45836599542880513",
        "U2.friction.mu=0.12971136105871844",
        "U2.friction.mu_static=0.1406775307057612",
        "U2.friction.stribeck_velocity=0.006145652977075363 m/s",
    ];
    let legs = legs.map(|value| format!("legs.joints.{value}"));
    let load = "platform.fx = -16.082 N; platform.fy = 17.965 N*sin(10*t); platform.fz = -2.522 N";
    let from = "leg1.P = 0.621661066702661 m - 0.12998833461605017 m/s*t; \
        leg2.P = 0.7010438515912469 m - 0.08306442217389003 m/s*t; \
        leg3.P = 0.701043851591247 m - 0.04497533440020313 m/s*t";
    let drives = "leg1.P = -69.6924 N*cos(4.946*t); leg2.P = -34.0897 N*cos(11.598*t); \
        leg3.P = 34.0876 N*cos(0.240*t)";
    let mut run = vec!["forward", "3upu"];
    legs.iter().for_each(|value| run.extend(["--set", value]));
    run.extend(["--load", load, "--from", from, "--drives", drives, "--friction", "on"]);
    run.extend(["--until", "0.55", "--step", "0.001", "--report", "off", "-o", "."]);
    folder.stiction(&run).succeeds();
    let table = folder.read("forward.csv");
    assert!(folder.read("events.csv").contains("method,,time-stepping"));
    let time = column(&table, "time [s]");
    let (length, rate) = ("leg1.P.position [m]", "leg1.P.rate [m/s]");
    let (length, rate) = (column(&table, length), column(&table, rate));
    for k in 1..time.len() {
        // The rates jump at 0.2748 s, within a row, where the legs jam.
        if (0.27..0.28).contains(&time[k]) {
            continue;
        }
        let step = time[k] - time[k - 1];
        let moved = length[k] - length[k - 1] - 0.5 * step * (rate[k] + rate[k - 1]);
        // Accelerations jump where joints begin to stick or slip, by at most some tens of m/s^2.
        assert!(moved.abs() < 1e-5, "{}: {moved:e}", time[k]);
    }
}
