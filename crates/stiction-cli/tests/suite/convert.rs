//! The command `stiction convert`.

use crate::program::Folder;
use serde_json::Value;

/// Removes everything that differs between versions and between libraries of trigonometric
/// functions: numbers keep nine digits, and values of rounding size become zero.
fn stable(text: &str) -> String {
    let text = text.replace(env!("CARGO_PKG_VERSION"), "VERSION");
    let mut stable = String::new();
    for token in text.split_inclusive([' ', '"', ',', '[', ']', '\n']) {
        let (word, end) = token.split_at(token.len() - 1);
        match word.parse::<f64>() {
            Ok(number) if number.abs() < 1e-15 => stable.push('0'),
            Ok(number) => {
                let rounded: f64 = format!("{number:.8e}").parse().unwrap();
                stable += &rounded.to_string();
            }
            Err(_) => stable.push_str(word),
        }
        stable.push_str(end);
    }
    stable
}

#[test]
fn a_linkage_in_both_formats() {
    let folder = Folder::new("convert");
    let json = folder.stiction(&["convert", "four-bar", "--to", "json"]);
    assert_eq!(json.err, "");
    insta::assert_snapshot!("four-bar-json", stable(json.succeeds()));
    let mjcf = folder.stiction(&["convert", "four-bar", "--to", "mjcf"]);
    assert!(mjcf.err.starts_with("note: friction at 4 of 4 friction interfaces"), "{}", mjcf.err);
    assert_eq!(mjcf.err.matches("note: ").count(), 1);
    insta::assert_snapshot!("four-bar-mjcf", stable(mjcf.succeeds()));
}

#[test]
fn a_file_is_written_whole() {
    let folder = Folder::new("convert-file");
    for format in ["json", "mjcf"] {
        let printed = folder.stiction(&["convert", "3rps", "--to", format]);
        for name in ["robot", "deep/er/robot"] {
            let said = folder.stiction(&["convert", "3rps", "--to", format, "-o", name]);
            assert_eq!(said.succeeds(), "");
            assert!(said.err.ends_with(&format!("wrote {name}\n")), "{}", said.err);
            assert_eq!(folder.read(name), printed.out);
        }
    }
    assert_eq!(folder.files(), ["deep", "robot"]);
}

/// A model that is written and read again has the same efforts and reactions.
#[test]
fn a_written_model_has_the_same_forces() {
    let folder = Folder::new("convert-model");
    for name in ["3rps", "andrews", "delta", "five-bar", "gough", "slider-crank"] {
        let text = folder.stiction(&["convert", name, "--to", "model"]);
        folder.write("copy.toml", text.succeeds());
        let again = folder.stiction(&["convert", "copy.toml", "--to", "model"]);
        assert_eq!(stable(again.succeeds()), stable(&text.out), "{name}");
        let first = |model: &str, rest: &[&str]| {
            let options = ["--load", "none", "-o", "out"];
            folder.stiction(&[&["inverse", model], &options[..], rest].concat()).succeeds();
            let table = folder.read("out/inverse.csv");
            let mut lines = table.lines();
            let (header, row) = (lines.next().unwrap(), lines.next().unwrap());
            let cells = header.split(',').zip(row.split(','));
            let drives = cells.filter(|(name, _)| name.contains(".drive ["));
            drives.map(|(name, x)| (name.to_owned(), x.parse().unwrap())).collect::<Vec<_>>()
        };
        let (original, copy): (Vec<(String, f64)>, _) = (first(name, &[]), first("copy.toml", &[]));
        let largest = original.iter().fold(0.0_f64, |max, (_, x)| max.max(x.abs()));
        assert!(!original.is_empty() && original.len() == copy.len());
        for ((name, x), (copied, y)) in original.iter().zip(&copy) {
            // Numbers are written without loss; axes and angles of rotations are rounded in their
            // last digits.
            assert!(name == copied && (x - y).abs() <= 1e-12 * largest, "{name} {x}, {copied} {y}");
        }
    }
}

#[test]
fn the_motion_selects_the_position() {
    let folder = Folder::new("convert-motion");
    let at = |motion: &[&str]| {
        let arguments = [&["convert", "four-bar", "--to", "json"], motion].concat();
        let said = folder.stiction(&arguments);
        let value: Value = serde_json::from_str(said.succeeds()).unwrap();
        value["joints"][0]["dofs"][0]["coordinate"].as_f64().unwrap().to_degrees()
    };
    assert!((at(&[]) - 60.0).abs() < 1e-12);
    assert!((at(&["--motion", "A = 75 deg; duration = 0"]) - 75.0).abs() < 1e-12);
}

/// A model without a motion is written in its home configuration, with a note.
#[test]
fn a_model_without_a_motion_is_converted() {
    let folder = Folder::new("convert-pose");
    let text = "gravity = [0, 0, -9.81]\n[bodies.b]\nmass = \"1 kg\"\ncom = [0.1, 0, 0]\ninertia = [1, 1, 1]\n\
                [joints.j]\ntype = \"R\"\nfrom = \"ground\"\nto = \"b\"\naxis = \"y\"\nactuated = true\n";
    folder.write("arm.toml", text);
    for format in ["json", "model", "mjcf", "urdf", "sdf"] {
        let said = folder.stiction(&["convert", "arm.toml", "--to", format]);
        said.succeeds();
        assert!(said.err.contains("the initial guess is used for j"), "{}", said.err);
    }
}

#[test]
fn misuse_is_reported() {
    let folder = Folder::new("convert-wrong");
    let convert = |rest: &[&str]| folder.stiction(&[&["convert"], rest].concat());
    convert(&["four-bar"]).fails(2, &["the format of the output is not known", "--to"]);
    let step = convert(&["four-bar", "--to", "step"]);
    step.fails(2, &["invalid value 'step'", "json, mjcf, urdf, sdf, model"]);
    convert(&["--to", "json"]).fails(2, &["<MODEL>"]);
    convert(&["fourbar", "--to", "json"]).fails(2, &["no built-in model", "`four-bar`"]);
    let motion = ["four-bar", "--to", "json", "--motion", "trun"];
    convert(&motion).fails(2, &["trun"]);
    let beyond = ["slider-crank", "--to", "mjcf", "--motion", "guide = 1 m; duration = 0"];
    let said = convert(&beyond);
    said.fails(1, &["at t = 0 s"]);
    assert_eq!(said.out, "");
    folder
        .stiction(&["convert", "four-bar", "--to", "json", "-o", "."])
        .fails(2, &["cannot write .: it is a folder", "give the name of a file with -o"]);
    folder.write("taken", "a file");
    convert(&["four-bar", "--to", "json", "-o", "taken/robot"]).fails(2, &["taken"]);
    folder.stiction(&["covnert"]).fails(2, &["did you mean `stiction convert`?"]);
    assert_eq!((folder.files(), folder.read("taken").as_str()), (vec!["taken".into()], "a file"));
}

/// A mechanism that MuJoCo does not support causes an error with a suggestion.
#[test]
fn a_body_without_mass_is_reported() {
    let folder = Folder::new("convert-massless");
    let text = folder.stiction(&["models", "four-bar"]).out;
    let from = text.find("[bodies.coupler]").unwrap();
    let to = from + text[from..].find("\n\n").unwrap();
    // A spring is fixed to the coupler: otherwise its joints would be joints of the next body.
    let spring = "\n[springs.S]\nfrom = \"ground\"\nat = [0, \"1 m\", 0]\nto = \"coupler\"\nto_at = [0, 0, 0]\nstiffness = \"1 N/m\"\nfree_length = \"1 m\"\n";
    let text = format!("{}[bodies.coupler]{}{spring}", &text[..from], &text[to..]);
    folder.write("light.toml", &text);
    folder.stiction(&["convert", "light.toml", "--to", "json"]).succeeds();
    folder.stiction(&["convert", "light.toml", "--to", "mjcf"]).fails(
        2,
        &[
            "MuJoCo rejects moving bodies without mass, such as `coupler`",
            "help: give the body a small mass",
        ],
    );
}

/// Writing to a device does not replace it, a symbolic link keeps its target, and the model itself
/// is not overwritten.
#[cfg(unix)]
#[test]
fn existing_files_are_kept() {
    let folder = Folder::new("convert-kept");
    let model = folder.stiction(&["models", "four-bar"]).succeeds().to_owned();
    folder.write("own.toml", &model);
    folder
        .stiction(&["convert", "own.toml", "--to", "json", "-o", "own.toml"])
        .fails(2, &["cannot write own.toml: it is an input of this conversion"]);
    assert_eq!(folder.read("own.toml"), model);

    folder.write("target.json", "old");
    std::os::unix::fs::symlink("target.json", folder.0.join("link.json")).unwrap();
    folder.stiction(&["convert", "four-bar", "--to", "json", "-o", "link.json"]).succeeds();
    assert!(folder.0.join("link.json").is_symlink());
    assert!(folder.read("target.json").starts_with('{'));

    let said = folder.stiction(&["convert", "four-bar", "--to", "json", "-o", "/dev/stdout"]);
    assert!(said.succeeds().starts_with('{'), "{}", said.out);
    folder
        .stiction(&["convert", "four-bar", "--to", "json", "-o", "own.toml/x.json"])
        .fails(2, &["own.toml is a file"]);
    folder
        .stiction(&["convert", "four-bar", "--to", "json", "-o", "new/"])
        .fails(2, &["it is a folder"]);
}

/// The YAML file beside a URDF is not named by the user, so only a file of this program is replaced.
#[test]
fn a_foreign_yaml_file_is_kept() {
    let folder = Folder::new("convert-yaml");
    folder.write("robot.yaml", "closed_loop: [['a', 'b']]\n");
    folder
        .stiction(&["convert", "four-bar", "-o", "robot.urdf"])
        .fails(2, &["robot.yaml, which exists and was not written by", "help: move that file"]);
    assert_eq!(folder.read("robot.yaml"), "closed_loop: [['a', 'b']]\n");
    assert!(!folder.0.join("robot.urdf").exists());
    for _ in 0..2 {
        folder.stiction(&["convert", "four-bar", "-o", "own.urdf"]).succeeds();
    }
}

/// Remarks that affect results are shown by every command, those that do not are counted.
#[test]
fn remarks_that_affect_results_are_shown_by_every_command() {
    let folder = Folder::new("convert-warnings");
    let text = "<mujoco><worldbody><body name='b'><joint name='j' axis='0 1 0'/><geom size='0.1' pos='0.2 0 0'/>
        <body name='c' pos='0.2 0 0'><joint name='k' axis='0 1 0' armature='0.1'/><geom size='0.1' pos='0.1 0 0'/>
        </body></body></worldbody><equality><joint joint1='k' joint2='j' polycoef='0 2 0 0 0'/></equality>
        <actuator><motor joint='j'/></actuator></mujoco>";
    folder.write("arm.xml", text);
    let motion = ["--motion", "j = t; duration = 0.1 s"];
    let lost = "the armature of a joint without a motor of its own";
    for command in ["inverse", "check", "view"] {
        let run = folder.stiction(&[&[command, "arm.xml"], &motion[..]].concat());
        assert!(run.err.contains("warning[import]") && run.err.contains(lost), "{}", run.err);
    }
    let converted = folder.stiction(&["convert", "arm.xml"]).succeeds().to_owned();
    assert!(converted.contains(lost), "{converted}");
    for command in ["inverse", "check", "forward"] {
        let motion = if command == "forward" { &["--until", "0.01 s"] } else { &motion[..] };
        let run = folder.stiction(&[&[command, "arm.xml", "--json"], motion].concat());
        let json: serde_json::Value = serde_json::from_str(&run.out).unwrap();
        let warnings = json["warnings"].as_array().unwrap_or_else(|| panic!("{command}: {json}"));
        let count = warnings.iter().filter(|own| own.as_str().unwrap().contains(lost)).count();
        assert_eq!(count, 1, "{command}: {warnings:?}");
    }
    // Also if the command fails.
    let run = folder.stiction(&["forward", "arm.xml", "--json", "--until=-1"]);
    let json: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    assert!(json.get("error").is_some() && json["warnings"].to_string().contains(lost), "{json}");
}
