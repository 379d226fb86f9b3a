//! Recordings that a model names are included in its FMU.

use crate::importer::{Extracted, Importer, Version};
use std::fmt::Write;
use std::{env, fs, process};
use stiction::{Robot, gallery};

#[test]
fn a_recording_is_packed_with_its_model() {
    let folder = env::temp_dir().join(format!("stiction-fmu-recording-{}", process::id()));
    fs::create_dir_all(folder.join("logs")).unwrap();
    let mut table = "time [s],left_motor [rad],right_motor [rad]\n".to_owned();
    for k in 0..20 {
        let time = 0.01 * f64::from(k);
        let _ = writeln!(table, "{time},{},{}", 2.2 + time * time, 0.9 - time * time);
    }
    fs::write(folder.join("logs/log 1.csv"), &table).unwrap();
    let model = gallery::get("five-bar").unwrap();
    let model = format!("{model}\n[motions.log]\nfile = \"logs/log 1.csv\"\n");
    fs::write(folder.join("robot.toml"), model).unwrap();
    let robot = Robot::load(folder.join("robot.toml")).unwrap();
    // A file that another request reads is not part of the plant.
    let other = folder.join("other.csv");
    fs::write(&other, &table).unwrap();
    robot.forward().motion(other.to_str().unwrap()).unwrap();
    fs::remove_file(&other).unwrap();
    let export = robot.export().plant().motion("log").from("rest");
    let unit = Extracted::new("recording", &export);
    fs::remove_dir_all(&folder).unwrap();
    let plant = Importer::new(&unit, Version::Three { events: false });
    plant.enter(0.0);
    assert_eq!(plant.exit(), 0, "{}", plant.said());
    assert!((plant.get("left_motor.position") - 2.2).abs() < 1e-9);
    plant.step(0.0, 1e-3);
}
