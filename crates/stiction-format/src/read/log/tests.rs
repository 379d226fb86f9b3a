//! Tests of logs with bad rows, logs of recorders, and tables of steady motions.

use super::*;
use crate::{gallery, read};

fn model() -> ModelFile {
    let text = gallery::get("five-bar").unwrap();
    read(&Source::new("five-bar.toml", text), &|_| Err("no files".into())).unwrap()
}

fn log(header: &str, rows: &[&str], renamed: &[Renamed]) -> Result<Log, Diagnostics> {
    let mut text = format!("{header}\n");
    for k in 0..30 {
        text += &format!("{},1,{k},3\n", 0.01 * f64::from(k));
    }
    for row in rows {
        text += row;
        text.push('\n');
    }
    let format = LogFormat { renamed, ..LogFormat::default() };
    model().read_log("log.csv", Contents::Whole(text), format)
}

#[test]
fn units_and_renamed_columns() {
    let renamed = [
        Renamed {
            column: "q2".into(),
            meaning: "right_motor [deg]".into(),
            factor: -2.0,
            offset: 90.0,
        },
        Renamed { column: "spare".into(), meaning: String::new(), factor: 1.0, offset: 0.0 },
    ];
    let found = log("time [ms],left_motor.effort [mN m],q2,spare", &[], &renamed).unwrap();
    assert!((found.times[2] - 2e-5).abs() < 1e-18);
    assert_eq!(found.columns[0].role, LogRole::Effort(0));
    assert!((found.columns[0].values[0] - 1e-3).abs() < 1e-18);
    // 90 - 2 * 5 degrees.
    assert!((found.columns[1].values[5] - 80f64.to_radians()).abs() < 1e-15);
    assert_eq!(found.columns[2].role, LogRole::Unused);
}

/// Checks that files of recorders are read: lines above the header, units below the header, a time
/// column without a name, and rows that were padded by a spreadsheet or edited by hand.
#[test]
fn files_of_recorders() {
    let mut text = "Date:;2020-07-06 17:01:36,,\nMax. samples:;500,,\n;Velocity;Torque,,\n\
                    ms;rpm;%,,\n0.000;0;-1200,,was -8.9\n"
        .to_owned();
    for k in 1..30 {
        text += &format!("{}.000;{k};-9.4,,\n", 256 * k);
    }
    let renamed = |column: &str, meaning: &str| Renamed {
        column: column.into(),
        meaning: meaning.into(),
        factor: 1.0,
        offset: 0.0,
    };
    let renamed =
        [renamed("Velocity", "d(left_motor)"), renamed("Torque", "left_motor.effort [mN m]")];
    let format = LogFormat { renamed: &renamed, ..LogFormat::default() };
    let found = model().read_log("log.csv", Contents::Whole(text), format).unwrap();
    assert_eq!(found.times[..2], [0.256, 0.512]);
    assert!(matches!(found.columns[0].role, LogRole::Rate(_)));
    assert!((found.columns[0].values[1] - 2.0 * std::f64::consts::PI / 30.0).abs() < 1e-15);
    assert_eq!(found.columns[1].values[0], -9.4e-3);
    assert_eq!(found.bad_rows.count, 1);
    let (line, why) = &found.bad_rows.named[0];
    assert_eq!(*line, 5);
    assert!(why.contains("-1200,,was -8.9"), "{why}");
}

/// Checks that a table of steady motions needs no time column.
#[test]
fn steady_motions() {
    let text = "name,d(left_motor) [rpm],left_motor.effort\na,1,2\nb,-1,-2\nc,2,3\nd,-2,-3\n";
    let renamed =
        [Renamed { column: "name".into(), meaning: String::new(), factor: 1.0, offset: 0.0 }];
    let read = |is_steady| {
        let format = LogFormat { renamed: &renamed, is_steady, ..LogFormat::default() };
        model().read_log("log.csv", Contents::Whole(text.to_owned()), format)
    };
    assert_eq!(read(true).unwrap().times, [0.0, 1.0, 2.0, 3.0]);
    assert!(format!("{:?}", read(false).unwrap_err()).contains("steady = true"));
}

/// Checks that a single wrong time invalidates one row only, whether the time is too early or too
/// late.
#[test]
fn a_jump_of_the_time_blames_one_row() {
    let header = "time [s],left_motor.effort,left_motor,right_motor";
    for jump in ["99.0,1,1,1", "0.002,1,1,1"] {
        let rows = ["0.3,1,1,1", jump, "0.31,1,1,1", "0.32,1,1,1", "0.33,1,1,1"];
        let found = log(header, &rows, &[]).unwrap();
        assert_eq!((found.times.len(), found.bad_rows.count), (34, 1), "{jump}");
        assert_eq!(found.bad_rows.named[0].0, 33);
        assert!(found.columns.iter().all(|c| c.values.len() == 34));
    }
}

#[test]
fn bad_rows_have_a_line_and_a_reason() {
    let header = "time [s],left_motor.effort,left_motor,right_motor";
    let rows = ["0.3,,was -8.9,1", "0.31,1,1e999,2", "0.32,1", "0.1,1,1,1", "0.33,1,5.3e-43,1"];
    let found = log(header, &rows, &[]).unwrap();
    assert_eq!((found.times.len(), found.bad_rows.count), (31, 4));
    let lines: Vec<usize> = found.bad_rows.named.iter().map(|(line, _)| *line).collect();
    assert_eq!(lines, [32, 33, 34, 35]);
    assert!(found.bad_rows.named[0].1.contains("is empty"));
    assert!(found.bad_rows.named[3].1.contains("not later than the time of the previous row"));
    assert!(log(header, &["x,1,1,1"; 40], &[]).is_err());
}

fn read_with(
    text: String,
    renamed: &[Renamed],
    header: &[&str],
    step: Option<f64>,
) -> Result<Log, Diagnostics> {
    let header: Vec<String> = header.iter().map(|name| (*name).to_owned()).collect();
    let format = LogFormat { renamed, is_steady: false, header: &header, step };
    model().read_log("log.csv", Contents::Whole(text), format)
}

/// Checks that options can name the columns of a log without a header, that the error for a log
/// without names suggests this option, and that blanks can separate columns.
#[test]
fn logs_without_a_header() {
    let rows: String =
        (0..30).map(|k| format!("  {}  0.5 1.5   {k}\n", 0.01 * f64::from(k))).collect();
    let header = ["time", "left_motor [rad]", "right_motor [rad]", "left_motor.effort [N m]"];
    let found = read_with(rows.clone(), &[], &header, None).unwrap();
    assert_eq!((found.times.len(), found.bad_rows.count), (30, 0));
    assert_eq!(found.columns[2].values[7], 7.0);
    assert_eq!(found.lines[0], 1);
    let refused = format!("{:?}", read_with(rows.clone(), &[], &[], None).unwrap_err());
    assert!(refused.contains("has no column names") && refused.contains("header ="), "{refused}");
    let unknown = read_with(rows, &[], &["time", "left_moter", "right_motor", "x"], None);
    assert!(format!("{:?}", unknown.unwrap_err()).contains("left_motor"));
}

/// Checks that dates with times of day are read, and that the header may be in a comment.
#[test]
fn times_of_day() {
    let row = |k: i32| {
        let second = 59.9 + 0.01 * f64::from(k);
        let (minute, second) = if second < 60.0 { (58, second) } else { (59, second - 60.0) };
        format!("2024-02-28T23:{minute}:{second:05.2}Z,1,2,3\n")
    };
    let rows: String = (0..30).map(row).collect();
    let text = format!("# by a recorder\n# time,left_motor,right_motor,left_motor.effort\n{rows}");
    let found = read_with(text, &[], &[], None).unwrap();
    assert_eq!((found.times.len(), found.bad_rows.count), (30, 0));
    for pair in found.times.windows(2) {
        // Seconds from 1970 have a rounding of 2e-7 s.
        assert!((pair[1] - pair[0] - 0.01).abs() < 1e-6);
    }
    assert_eq!(found.lines[0], 3);
}

/// Checks that repeated time stamps are rejected with the advice to give a time step, and that a
/// log with a given step also counts the step of bad rows.
#[test]
fn a_step_stands_for_the_time() {
    let row = |k: i32| match k {
        5 => "0,x,2,3\n".to_owned(),
        k => format!("{},1,2,3\n", k / 10),
    };
    let rows: String = (0..60).map(row).collect();
    let text = format!("time,left_motor,right_motor,left_motor.effort\n{rows}");
    let refused = format!("{:?}", read_with(text.clone(), &[], &[], None).unwrap_err());
    assert!(refused.contains("step ="), "{refused}");
    let found = read_with(text, &[], &[], Some(1e-3)).unwrap();
    assert_eq!((found.times.len(), found.bad_rows.count), (59, 1));
    assert!((found.times[58] - 0.059).abs() < 1e-15 && (found.times[5] - 0.006).abs() < 1e-15);
}

/// Checks that a pattern excludes several columns, but not a column whose meaning is given
/// separately.
#[test]
fn a_pattern_of_columns_that_are_not_used() {
    let unused = |column: &str, meaning: &str| Renamed {
        column: column.into(),
        meaning: meaning.into(),
        factor: 1.0,
        offset: 0.0,
    };
    let renamed = [unused("x*", ""), unused("x1", "left_motor")];
    let found = log("t,x1,x2,x 3 [V]", &[], &renamed).unwrap();
    assert!(matches!(found.columns[0].role, LogRole::Coordinate(_)));
    assert_eq!((found.columns[1].role, found.columns[2].role), (LogRole::Unused, LogRole::Unused));
}

/// Checks that the names of columns may be numbers if the options state their meaning.
#[test]
fn names_of_columns_may_be_numbers() {
    let rows: String = (0..30).map(|k| format!("{},0.5,1.5,{k}\n", 0.01 * f64::from(k))).collect();
    let meanings = ["time [s]", "left_motor [rad]", "right_motor [rad]", "left_motor.effort [N m]"];
    let renamed: Vec<Renamed> = (0..4)
        .map(|k| Renamed {
            column: k.to_string(),
            meaning: meanings[k].into(),
            factor: 1.0,
            offset: 0.0,
        })
        .collect();
    let found = read_with(format!("0,1,2,3\n{rows}"), &renamed, &[], None).unwrap();
    assert_eq!((found.times.len(), found.bad_rows.count), (30, 0));
}

/// Checks that times of day are in seconds even if the time column has another unit.
#[test]
fn times_of_day_are_in_seconds() {
    let rows: String = (10..40).map(|k| format!("12:05:01.{k},1,2,3\n")).collect();
    let text = format!("time [ms],left_motor,right_motor,left_motor.effort\n{rows}");
    let found = read_with(text, &[], &[], None).unwrap();
    for pair in found.times.windows(2) {
        // Numbers of 4e4 s have a rounding of 7e-12 s.
        assert!((pair[1] - pair[0] - 0.01).abs() < 1e-9, "{pair:?}");
    }
}

/// Checks that `05:12` is rejected with advice: it may be hours and minutes, or minutes and
/// seconds.
#[test]
fn times_of_two_numbers_are_refused() {
    let text = |time: fn(usize) -> String| {
        let rows: String = (0..30).map(|k| format!("{},1,2,3\n", time(k))).collect();
        format!("time,left_motor,right_motor,left_motor.effort\n{rows}")
    };
    let ambiguous = text(|k| format!("{:02}:{:02}", k / 60 + 5, k % 60));
    let said = read_with(ambiguous, &[], &[], None).unwrap_err().to_string();
    for part in ["hours and minutes or minutes and seconds", "hh:mm:ss", "step ="] {
        assert!(said.contains(part), "{said}");
    }
    let decimal = text(|k| format!("05:{:04.1}", 0.5 * k as f64));
    let found = read_with(decimal, &[], &[], None).unwrap();
    assert_eq!((found.times[0], found.times[1]), (300.0, 300.5));
}

/// Checks that a first column without a name is the time, as programs write the index of a table,
/// unless it numbers the rows.
#[test]
fn a_first_column_without_a_name_is_the_time() {
    let header = ",left_motor [rad],right_motor [rad],left_motor.effort [N m]";
    assert_eq!(log(header, &[], &[]).unwrap().times[..2], [0.0, 0.01]);
    let rows: String = (0..30).map(|k| format!("{k},0.5,1.5,{k}\n")).collect();
    let refused = read_with(format!("{header}\n{rows}"), &[], &[], None).unwrap_err().to_string();
    assert!(refused.contains("the column `time` is missing"), "{refused}");
}

/// Checks that a number whose square could overflow invalidates its row only.
#[test]
fn absurd_numbers_are_bad_rows() {
    let header = "time [s],left_motor.effort,left_motor,right_motor";
    for absurd in ["1e31", "-1e160", "1e200", "1e308"] {
        let found = log(header, &[&format!("0.3,{absurd},1,1")], &[]).unwrap();
        assert_eq!((found.times.len(), found.bad_rows.count), (30, 1), "{absurd}");
        let (line, why) = &found.bad_rows.named[0];
        assert_eq!(*line, 32);
        assert!(why.contains(absurd) && why.contains("1e30"), "{why}");
    }
    assert_eq!(log(header, &["0.3,1e29,1,1"], &[]).unwrap().times.len(), 31);
}

#[test]
fn misspelt_units_and_times_get_advice() {
    let said = |header: &str| log(header, &[], &[]).unwrap_err().to_string();
    let unit = said("time [s],left_motor.effort [Nm],left_motor,right_motor");
    assert!(unit.contains("write `N m`"), "{unit}");
    for name in ["Time [s]", "Time (s)", "timestamp"] {
        let time = said(&format!("{name},left_motor.effort,left_motor,right_motor"));
        assert!(time.contains("the name `time`") && time.contains("under [columns]"), "{time}");
    }
}

/// Checks that the advice for two columns of one name does not remove both.
#[test]
fn a_repeated_column_is_removed_in_the_file() {
    let said = |header: &str| log(header, &[], &[]).unwrap_err().to_string();
    let same = said("time,left_motor.effort,left_motor,left_motor");
    assert!(same.contains("delete or rename") && !same.contains("[columns]"), "{same}");
    let other = said("time,left_motor.effort,left_motor,left_motor.position");
    assert!(other.contains("[columns]") || other.contains("delete"), "{other}");
}

#[test]
fn times_of_day_pass_midnight() {
    let time = |k: usize| match k {
        0..15 => format!("23:59:59.{:02}", 85 + k),
        _ => format!("00:00:00.{:02}", k - 15),
    };
    let rows: String = (0..30).map(|k| format!("{},1,2,3\n", time(k))).collect();
    let text = format!("time,left_motor,right_motor,left_motor.effort\n{rows}");
    let found = read_with(text, &[], &[], None).unwrap();
    assert_eq!((found.times.len(), found.bad_rows.count), (30, 0));
    assert!(found.times.windows(2).all(|pair| (pair[1] - pair[0] - 0.01).abs() < 1e-9));
}

#[test]
fn minutes_with_seconds_pass_the_hour() {
    let time = |k: usize| format!("{}:{:04.1}", 59 + k / 10, 6.0 * (k % 10) as f64);
    let rows: String = (0..30).map(|k| format!("{},1,2,3\n", time(k))).collect();
    let text = format!("time,left_motor,right_motor,left_motor.effort\n{rows}");
    let found = read_with(text, &[], &[], None).unwrap();
    assert_eq!((found.times[0], found.times[29]), (3540.0, 3714.0));
}
