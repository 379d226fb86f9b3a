//! Options with values that cannot be used: messages in terms of what the user has written.

use crate::program::Folder;

#[test]
fn times_and_masses_are_neither_angles_nor_percentages() {
    let folder = Folder::new("options-dimensions");
    for arguments in [
        ["inverse", "--step", "2 deg"],
        ["inverse", "--step", "20 %"],
        ["forward", "--until", "20 deg"],
        ["forward", "--time-limit", "20 deg"],
        ["breakaway", "--at", "5 deg"],
        ["excite", "--duration", "10 deg"],
        ["compensate", "--delay", "10 %"],
    ] {
        let [command, option, value] = arguments;
        folder
            .stiction(&[command, "five-bar", option, value])
            .fails(2, &[option, "a time, found a"]);
    }
    folder
        .stiction(&["inverse", "five-bar", "--set", "tool.mass=50 %"])
        .fails(2, &["expected a mass", "found a number in percent"]);
}

/// Checks that a negative number is a value of the option before it, also with a unit.
#[test]
fn negative_values_belong_to_their_options() {
    let folder = Folder::new("options-negative");
    for (arguments, says) in [
        (["inverse", "--threads", "0"], "a whole number above 0"),
        (["inverse", "--threads", "-3"], "a whole number above 0"),
        (["inverse", "--step", "-1 ms"], "must be greater than 0"),
        (["compensate", "--known-to", "-10%"], "relative accuracy"),
    ] {
        let [command, option, value] = arguments;
        let said = folder.stiction(&[command, "five-bar", option, value]);
        assert!(!said.err.contains("use '--"), "{}", said.err);
        said.fails(2, &[says]);
    }
}

#[test]
fn messages_name_the_value_at_fault() {
    let folder = Folder::new("options-values");
    for (arguments, says) in [
        (
            ["compensate", "--period", "5"],
            &["a sampling period of 5.000 s", "bandwidth of 5.000 Hz"][..],
        ),
        (
            ["forward", "--from", "A = 10 deg; d(A) = 5 m/s"],
            &["the rate `d(A)` is `5 m/s`", "expected an angular speed, found a velocity"],
        ),
        (["excite", "--limit", "A = 40 mm"], &["--limit of A is 40 mm", "measured in rad"]),
    ] {
        let [command, option, value] = arguments;
        folder.stiction(&[command, "slider-crank", option, value]).fails(2, says);
    }
}

#[test]
fn studies_have_a_limit() {
    let folder = Folder::new("options-sweep");
    let sweep = |range: &str| {
        let vary = format!("crank.mass=1 kg..2 kg in {range}");
        let objective = ["--objective", "peak(A.effort)"];
        folder.stiction(&[&["sweep", "slider-crank", "--vary", &vary][..], &objective].concat())
    };
    sweep("10000000000").fails(2, &["has 10000000000 rows", "the maximum is 1000000000"]);
    sweep("1").fails(2, &["which cannot be both of its ends", "in 2"]);
}
