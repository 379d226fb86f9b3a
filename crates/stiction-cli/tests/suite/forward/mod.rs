//! The command `stiction forward`: output files of a run.

mod between_rows;
mod differential;
mod given;
mod jamming;
mod motion;
mod passages;
mod refusals;
mod resume;

use crate::program::{Folder, column, json};

/// Files that every run writes into its folder.
const FILES: [&str; 8] = [
    "bodies.csv",
    "energy.csv",
    "events.csv",
    "forward.csv",
    "friction.csv",
    "motion.csv",
    "reactions.csv",
    "summary.json",
];

#[test]
fn without_arguments_a_controller_follows_the_robots_own_motion() {
    let said = Folder::new("forward-default").stiction(&["forward"]);
    let out = said.succeeds();
    assert!(
        said.err.contains("computed-torque controller without friction compensation"),
        "{}",
        said.err
    );
    // Values that differ between machines are omitted.
    let stable: Vec<&str> = out.lines().filter(|line| !line.starts_with("loop closure")).collect();
    insta::assert_snapshot!("forward-default", stable.join("\n"));
}

#[test]
fn the_files_are_complete() {
    let folder = Folder::new("forward-files");
    folder.stiction(&["forward", "-o", "new/deep", "--until", "0.2"]).succeeds();
    let inner = Folder(folder.0.join("new/deep"));
    let mut expected = FILES.to_vec();
    expected.extend(["drives.svg", "energy.svg", "error.svg", "friction.svg", "motion.svg"]);
    expected.extend(["path.svg", "report.html", "space-error.svg"]);
    expected.sort_unstable();
    assert_eq!(inner.files(), expected);

    // The tracking error of the path is consistent with the position of the body in the same table.
    let bodies = inner.read("bodies.csv");
    let of = |name: &str| column(&bodies, &format!("platform.{name}"));
    let axes = ["x", "y", "z"]
        .map(|axis| (of(&format!("{axis} [m]")), of(&format!("reference.{axis} [m]"))));
    let error = of("error [m]");
    for (k, found) in error.iter().enumerate() {
        let sum: f64 = axes.iter().map(|(actual, wanted)| (actual[k] - wanted[k]).powi(2)).sum();
        assert!((found - sum.sqrt()).abs() < 1e-15 + 1e-12 * sum.sqrt(), "{k}: {found}");
    }
    assert!(error.iter().any(|x| *x > 1e-6) && error.iter().all(|x| *x < 1e-2), "{error:?}");
    assert!(of("error_angle [rad]").iter().all(|x| *x < 0.1));
    // The motion prescribes the height of the reference.
    for (t, z) in column(&bodies, "time [s]").iter().zip(&axes[2].1) {
        let wanted = 0.5 + 0.03 * (std::f64::consts::TAU * t).cos();
        assert!((z - wanted).abs() < 1e-9, "{t}: {z} {wanted}");
    }

    let forward = inner.read("forward.csv");
    let times = column(&forward, "time [s]");
    assert_eq!((times.len(), times[0], times[20]), (21, 0.0, 0.2));
    let (position, wanted) =
        (column(&forward, "leg1.P.position [m]"), column(&forward, "leg1.P.reference [m]"));
    // The actuator follows the motion, except for the effect of friction.
    assert!(position.iter().zip(&wanted).all(|(a, b)| (a - b).abs() < 1e-3 && *a > 0.5));
    assert!(column(&forward, "closure [m]").iter().all(|x| *x < 1e-12));
    assert_eq!(column(&forward, "leg2.R.rate [rad/s]").len(), 21);

    let friction = inner.read("friction.csv");
    for interface in ["leg1.R", "leg2.P", "leg3.S"] {
        let get = |what: &str| column(&friction, &format!("{interface}.{what}"));
        let (force, limit, sticks) = (get("friction [N]"), get("limit [N]"), get("sticks"));
        for ((force, limit), sticks) in force.iter().zip(limit).zip(sticks) {
            assert!(sticks == 0.0 || force.abs() <= limit * (1.0 + 1e-8), "{interface}");
        }
    }
    let energy = inner.read("energy.csv");
    let turnover = column(&energy, "turnover [J]")[20];
    assert!(column(&energy, "error [J]").iter().all(|x| x.abs() < 1e-9 * turnover));
    let summary = json(&inner.read("summary.json"));
    assert_eq!(summary["ended"], "reached");
    assert_eq!(summary["options"]["controller"], "computed-torque");
    assert!(inner.read("events.csv").starts_with("time [s],event,at,detail\n"));
    let svg = inner.read("friction.svg");
    assert!(svg.contains("friction interfaces that stick") && !svg.contains("NaN"));
}

#[test]
fn programs_get_one_json_text() {
    let folder = Folder::new("forward-json");
    let said = folder.stiction(&["forward", "five-bar", "--json", "--until", "0.02"]);
    assert_eq!(
        (json(said.succeeds())["model"]["name"].as_str(), said.err.as_str()),
        (Some("five-bar"), "")
    );
    let said = folder.stiction(&["forward", "--drives", "leg1.Q = 1 N", "--json"]);
    assert_eq!((said.code, said.err.as_str()), (2, ""));
    assert_eq!(json(&said.out)["error"]["diagnostics"][0]["code"], "unknown-name");
}

/// The last row is at the requested instant, whether or not the step divides the duration.
#[test]
fn signals_end_a_run() {
    let folder = Folder::new("forward-last");
    for (until, rows) in [("0.025", 4), ("0.03", 4), ("0.004", 2)] {
        let run = ["forward", "four-bar", "--until", until, "--step", "0.01", "-o", "."];
        folder.stiction(&run).succeeds();
        let times = column(&folder.read("forward.csv"), "time [s]");
        assert_eq!((times.len(), times.last()), (rows, until.parse().ok().as_ref()), "{times:?}");
    }
}

#[test]
fn plots_of_an_earlier_run_do_not_remain() {
    let folder = Folder::new("forward-stale");
    let run = ["forward", "--until", "0.1", "-o", "out"];
    folder.stiction(&run).succeeds();
    let out = Folder(folder.0.join("out"));
    let of_references = ["error.svg", "space-error.svg"].map(str::to_owned);
    assert!(of_references.iter().all(|name| out.files().contains(name)), "{:?}", out.files());
    // Without controller, there is no reference.
    folder.stiction(&[&run[..], &["--controller", "none"]].concat()).succeeds();
    assert!(of_references.iter().all(|name| !out.files().contains(name)), "{:?}", out.files());
}
