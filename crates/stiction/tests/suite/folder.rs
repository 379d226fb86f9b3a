//! Folder of the relative paths in the options of a robot.

use super::pendulum;
use std::fs;
use std::path::Path;

/// Checks that motions, options of identification and logs are read in the folder of the robot, also
/// after a change of the robot, and not in the folder of the process.
#[test]
fn relative_paths_are_those_of_the_folder() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("in-folder");
    fs::create_dir_all(&folder).unwrap();
    let mut log = "time [s],pivot [rad],pivot.effort [N m]\n".to_owned();
    for k in 0..200 {
        let t = 0.01 * f64::from(k);
        log += &format!("{t:.2},{},{}\n", (3.0 * t).sin(), 2.0 * (3.0 * t).cos());
    }
    let without_effort = |line: &str| line.rsplit_once(',').unwrap().0.to_owned() + "\n";
    let motion: String = log.lines().map(without_effort).collect();
    for (name, text) in
        [("log.csv", &log), ("motion.csv", &motion), ("options.toml", &String::new())]
    {
        fs::write(folder.join(name), text).unwrap();
    }
    let robot = pendulum().in_folder(&folder).with("bodies.bob.mass = 2.5 kg").unwrap();
    robot.inverse().motion("motion.csv").unwrap();
    let settings = robot.identify_settings(Path::new("options.toml")).unwrap();
    robot.measured_log("log.csv", &settings).unwrap();
    assert!(pendulum().inverse().motion("motion.csv").is_err());
    assert!(pendulum().measured_log("log.csv", &settings).is_err());
}
