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
