//! Passage through singular positions, and independence of the results from the rows.

use crate::program::{Folder, column, json};

/// Released from rest without friction, the 3-RPS passes seven singular positions in 1.4 s.
const COLLAPSE: [&str; 10] =
    ["forward", "3rps", "--drives", "none", "--from", "rest", "--friction", "off", "-o", "."];

/// Compares with MuJoCo 4.0 (RK4, hardened connects). Its results with time steps of 0.1 ms and
/// 0.025 ms differ from the limit by 1e-4 m and 2e-5 m.
#[test]
fn a_platform_falls_through_singular_positions() {
    for step in ["0.1", "0.01", "0.0031"] {
        let folder = Folder::new(&format!("forward-collapse-{step}"));
        folder.stiction(&[&COLLAPSE[..], &["--until", "1.4", "--step", step]].concat()).succeeds();
        let bodies = folder.read("bodies.csv");
        let expected = [("x", 0.055_689), ("y", -0.136_471_4), ("z", -17.612_903_4)];
        for (axis, expected) in expected {
            let found = *column(&bodies, &format!("platform.{axis} [m]")).last().unwrap();
            assert!((found - expected).abs() < 1e-4, "{step} {axis}: {found} {expected}");
        }
        let summary = json(&folder.read("summary.json"));
        assert_eq!(summary["events"]["singular"], 7, "{step}");
    }
}

/// Rows at the same instants in runs with different `--step` and `--until` agree in all digits.
#[test]
fn rows_do_not_influence_the_motion() {
    let friction: &[&str] =
        &["forward", "four-bar", "--drives", "A = 2 N m*sin(9*t)", "--from", "rest", "-o", "."];
    let stepping = [friction, &["--method", "time-stepping", "--tolerance", "1e-8"]].concat();
    for (case, options) in [&COLLAPSE[..], friction, &stepping].into_iter().enumerate() {
        let run = |step: &str, until: &str| {
            let folder = Folder::new(&format!("forward-rows-{case}-{step}-{until}"));
            folder.stiction(&[options, &["--until", until, "--step", step]].concat()).succeeds();
            folder.read("forward.csv")
        };
        let coarse = run("0.25", "1");
        for (step, until) in [("0.05", "1"), ("0.25", "1.25"), ("0.01", "1")] {
            let fine = run(step, until);
            for line in coarse.lines() {
                assert!(fine.lines().any(|other| other == line), "{case} {step} {until}: {line}");
            }
        }
    }
}

/// At rest, some pins of the squeezing mechanism bear no load except round-off, and so have no
/// friction.
#[test]
fn joints_without_load_do_not_slip_at_rest() {
    let folder = Folder::new("forward-no-load");
    folder.write("load.toml", "[K7]\nforce = [\"-0.2 N\", \"1.4 N*sin(8*t)\", 0]\n");
    let run = ["forward", "andrews", "--drives", "none", "--from", "rest", "--load", "load.toml"];
    let more = ["--friction", "on", "--until", "0.005", "--method", "event-driven", "-o", "."];
    folder.stiction(&[&run[..], &more].concat()).succeeds();
    assert!(!folder.read("events.csv").contains("slides"));
}

/// A turntable on a vertical axis whose pin bears no load until the push begins.
const TURNTABLE: &str = r#"
gravity = [0, 0, "-9.81 m/s^2"]
[bodies.table]
mass = "1 kg"
com = [0, 0, 0]
inertia = [0.01, 0.01, 0.01]
[joints.A]
type = "R"
from = "ground"
to = "table"
axis = "z"
friction = { mu = 0.2, radius = "5 mm" }
[loads.push]
table = { force = ["1 N*sin(8*t)", 0, 0], at = [0, "100 mm", 0] }
[default]
load = "push"
friction = "on"
"#;

#[test]
fn a_turntable_slips_as_soon_as_it_is_pushed() {
    let folder = Folder::new("forward-turntable");
    folder.write("table.toml", TURNTABLE);
    let run = ["forward", "table.toml", "--drives", "none", "--from", "rest", "--until", "0.1"];
    folder.stiction(&[&run[..], &["--method", "event-driven", "-o", "."]].concat()).succeeds();
    let events = folder.read("events.csv");
    let slip = events.lines().find(|line| line.contains(",slides,A,")).expect("the table slips");
    let time: f64 = slip.split(',').next().unwrap().parse().unwrap();
    assert!(time < 1e-9, "{events}");
}

/// When friction stops a mechanism of one degree of freedom, all joints stick at once.
#[test]
fn a_mechanism_that_stops_sticks_in_all_joints() {
    let folder = Folder::new("forward-stops");
    let from = "beta = -0.06171389001427645 rad - 12 rad/s*t";
    let run = ["forward", "andrews", "--from", from, "--drives", "none", "--friction", "on"];
    let more = ["--until", "0.03", "--method", "event-driven", "-o", "."];
    folder.stiction(&[&run[..], &more].concat()).succeeds();
    let events = folder.read("events.csv");
    let stops: Vec<&str> = events.lines().filter(|line| line.contains(",sticks,")).collect();
    let time = |line: &str| line.split(',').next().map(str::to_owned);
    assert_eq!(stops.len(), 10, "{events}");
    assert!(stops.iter().all(|line| time(line) == time(stops[0])), "{events}");
    let mut after = events.lines().skip_while(|line| time(line) != time(stops[0]));
    assert!(!after.any(|line| line.contains(",slides,")), "{events}");
    assert_eq!(column(&folder.read("forward.csv"), "beta.rate [rad/s]").last(), Some(&0.0));
}

/// A robot thrown against its jammed joints: the solution from zero friction ends before full friction, so only friction
/// from the branch in which everything sticks satisfies all laws. No friction supplies energy in the jump.
#[test]
fn a_motion_that_jams_at_its_start_goes_on() {
    let folder = Folder::new("forward-jam-at-start");
    let mut text = folder.stiction(&["models", "3upu"]).succeeds().to_owned();
    for mu in ["mu = 0.05", "mu = 0.08"] {
        assert!(text.contains(mu), "{text}");
        text = text.replace(mu, "mu = 0.3");
    }
    folder.write("robot.toml", &text);
    let from = "leg1.P = 0.6216610667026612 m + 0.78 m/s*t; leg2.P = 0.701043851591247 m + -0.26 m/s*t; \
                leg3.P = 0.7010438515912469 m + -0.52 m/s*t";
    let run = ["forward", "robot.toml", "--from", from, "--drives", "none", "--friction", "on"];
    folder.stiction(&[&run[..], &["--until", "0.05", "-o", "."]].concat()).succeeds();
    assert!(folder.read("events.csv").contains("\n0,jump,"));
    let energy = folder.read("energy.csv");
    let columns = energy.lines().next().unwrap().split(',');
    for name in columns.filter(|name| name.ends_with(".dissipated [J]")) {
        let lost = column(&energy, name);
        assert!(lost.is_sorted(), "{name}: {lost:?}");
    }
}

/// A jam stops the mechanism twice at instants without accelerations. At rest, frictions within all limits hold it. The
/// first time, the least-norm frictions exceed a limit; the second time, they leave normal loads that are much larger than
/// necessary.
/// Writes `robot.toml`: the robot `3rps` with other friction laws of R, P and S.
fn write_3rps(folder: &Folder, laws: [&str; 3]) {
    let mut text = folder.stiction(&["models", "3rps"]).succeeds().to_owned();
    let common = r#"mu = 0.12, viscous = "0.02 N s/m""#;
    for (old, law) in [", radius = \"12.5 mm\"", "", ", radius = \"25 mm\""].iter().zip(laws) {
        let old = format!("{{ {common}{old} }}");
        assert!(text.contains(&old), "{old}");
        text = text.replace(&old, &format!("{{ {law} }}"));
    }
    folder.write("robot.toml", &text);
}

#[test]
fn a_jam_close_to_a_singular_position_closes_its_energy_balance() {
    let folder = Folder::new("forward-jam-energy");
    let laws = [
        r#"mu = 0.2573599358469207, viscous = "0.02 N s/m", radius = "12.5 mm""#,
        r#"mu = 0.2744473505190332, viscous = "0.02 N s/m""#,
        r#"mu = 0.2276577803997749, mu_static = 0.24181452514243226, stribeck_velocity = "0.022728809853568004 m/s", radius = "25 mm""#,
    ];
    write_3rps(&folder, laws);
    folder.write(
        "load.toml",
        "[platform]\nforce = [\"-20.796 N\", \"7.2 N*sin(4.141*t)\", \"-4.277 N\"]\n",
    );
    let from = "leg1.P = 0.6427058610342992 m + -0.22202878134935572 m/s*t; \
                leg2.P = 0.6583224906083829 m + 0.07123850110353959 m/s*t; \
                leg3.P = 0.6583224906083827 m + 0.18559305896224934 m/s*t";
    let run = ["forward", "robot.toml", "--from", from, "--drives", "none", "--load", "load.toml"];
    folder
        .stiction(&[&run[..], &["--friction", "on", "--until", "1.3", "-o", "."]].concat())
        .succeeds();
    let summary = json(&folder.read("summary.json"));
    assert!(summary["events"]["jump"].as_u64() > Some(0), "{}", summary["events"]);
    // Frictions of 1e17 N that stress the mechanism against itself would leave errors of 1e-2 by their
    // round-off; the impulses of the jump correspond to 1e9 N.
    assert!(summary["energy"]["error_relative"].as_f64().unwrap() < 1e-4, "{}", summary["energy"]);
}

#[test]
fn a_jammed_mechanism_at_rest_is_event_driven() {
    let folder = Folder::new("forward-jam-at-rest");
    let laws = [
        r#"mu = 0.2921877544138823, mu_static = 0.3727646923126022, viscous = "0.02 N s/m", radius = "12.5 mm""#,
        "mu = 0.1657264513408693, mu_static = 0.21798093975881616",
        r#"mu = 0.1006509711286229, radius = "25 mm""#,
    ];
    write_3rps(&folder, laws);
    folder.write(
        "load.toml",
        "[platform]\nforce = [\"-10.8 N\", \"33.559 N*sin(18.128*t)\", \"17.35 N\"]\n",
    );
    let from = "leg1.P = 0.6427058610342992 m + -0.5480471576463448 m/s*t; \
                leg2.P = 0.6583224906083829 m + -0.09569411441137207 m/s*t; \
                leg3.P = 0.6583224906083827 m + -0.22450987331764952 m/s*t";
    let drives = "leg1.P = -82.682 N*cos(1.591*t); leg2.P = -42.0978 N*cos(0.913*t); \
                  leg3.P = 30.1088 N*cos(11.494*t)";
    let run = ["forward", "robot.toml", "--from", from, "--drives", drives, "--load", "load.toml"];
    // How near to a singular position the mechanism stops depends on the tolerance.
    for tolerance in ["1e-10", "4e-10", "1e-7"] {
        let options = ["--friction", "on", "--until", "1", "--tolerance", tolerance, "-o", "."];
        folder.stiction(&[&run[..], &options].concat()).succeeds();
        let summary = json(&folder.read("summary.json"));
        assert!(summary["events"]["jump"].as_u64() > Some(0), "{}", summary["events"]);
        assert_eq!(column(&folder.read("forward.csv"), "leg1.P.rate [m/s]").last(), Some(&0.0));
        let events = folder.read("events.csv");
        assert!(events.lines().last().unwrap().ends_with("event-driven"), "{tolerance}: {events}");
        assert!(summary["method"]["time_stepping"].as_f64().unwrap() < 0.1, "{tolerance}");
        // The last position is within 1e-9 of a singular one. The least-norm frictions leave normal loads
        // of 1e6 N there; those that the friction limits require are of the order of 1e3 N.
        let friction = folder.read("friction.csv");
        for joint in ["leg1.P", "leg2.S", "leg3.P"] {
            let loads = column(&friction, &format!("{joint}.load [N]"));
            let sticks = column(&friction, &format!("{joint}.sticks"));
            let held = loads.iter().zip(&sticks).filter(|(_, sticks)| **sticks == 1.0);
            let largest = held.fold(0.0_f64, |m, (load, _)| m.max(*load));
            assert!((100.0..1e4).contains(&largest), "{tolerance}, {joint}: {largest} N");
        }
    }
}

#[test]
fn a_time_limit_ends_a_run_that_resumes() {
    let folder = Folder::new("forward-time-limit");
    let run = ["forward", "3rps", "--until", "1000", "--step", "0.001", "-o", "."];
    let limited = [&run[..], &["--time-limit", "300 ms"]].concat();
    let said = folder.stiction(&limited);
    said.fails(1, &["the time limit of 0.3 s ended the run at t = ", "--resume"]);
    assert!(folder.files().contains(&"checkpoint.json".to_owned()));
    assert!(folder.read("forward.csv").lines().count() > 2);
    folder
        .stiction(&["forward", "3rps", "--time-limit", "-1"])
        .fails(2, &["--time-limit is -1 s, but must be greater than 0"]);
}
