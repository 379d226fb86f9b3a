//! Loads given as formulas of the measured state.

use crate::program::{Folder, column};

/// Model of a block on a prismatic joint, followed by the text `more`.
fn block(more: &str) -> String {
    format!(
        "gravity = [0, 0, -9.81]\n[bodies.block]\nmass = 2\ncom = [0, 0, 0]\ninertia = [1, 1, 1]\n\
         [joints.X]\ntype = \"P\"\nfrom = \"ground\"\nto = \"block\"\naxis = \"x\"\nactuated = true\n{more}"
    )
}

/// A spring and damper given as a load acts like a spring of the model. A one-sided wall stops the
/// block at the position that follows from the energy.
#[test]
fn loads_of_the_state_are_springs_and_walls() {
    let folder = Folder::new("load-formulas");
    folder.write(
        "spring.toml",
        &block("[springs.S]\njoint = \"X\"\nstiffness = 50\nrest = 0\ndamping = 3\n"),
    );
    folder.write("block.toml", &block("[loads.held.block]\nfx = \"-50 N/m*X - 3 N s/m*d(X)\"\n"));
    let run = |model: &str, load: &str, out: &str| {
        let from = ["--from", "X = 0.1 m; d(X) = 0.2 m/s", "--until", "1", "--drives", "none"];
        let all = ["forward", model, "--load", load, "-o", out, "--report", "off"];
        folder.stiction(&[&all[..], &from].concat()).succeeds();
        column(&folder.read(&format!("{out}/forward.csv")), "X.position [m]")
    };
    let expected = run("spring.toml", "none", "spring");
    // The tolerance follows from that of the integration, 1e-10 of 0.1 m.
    for (load, out) in
        [("held", "named"), ("block.fx = -50 N/m*block.x - 3 N s/m*d(block.x)", "given")]
    {
        let found = run("block.toml", load, out);
        assert_eq!(found.len(), expected.len());
        for (a, b) in found.iter().zip(&expected) {
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
    }
    // A block of 2 kg at 0.2 m/s penetrates a wall of 5 kN/m at 0.15 m by 4 mm and returns at the
    // same speed.
    let wall = run("block.toml", "block.fx = -5 kN/m*max(0 mm, X - 150 mm)", "wall");
    let depth = wall.iter().fold(0.0_f64, |most, x| most.max(*x)) - 0.15;
    assert!(depth > 0.003 && depth < 0.004 + 1e-9, "{depth}");
    let (a, b) = (wall[wall.len() - 2], wall[wall.len() - 1]);
    assert!(((b - a) / 0.01 + 0.2).abs() < 1e-8, "{a} {b}");
}

#[test]
fn other_commands_refuse_such_loads() {
    let folder = Folder::new("load-formulas-refused");
    folder.write(
        "block.toml",
        &block("[motions.m]\nX = 0\nduration = 0\n[default]\nmotion = \"m\"\n"),
    );
    for command in ["inverse", "breakaway"] {
        let said = folder.stiction(&[command, "block.toml", "--load", "block.fx = -50 N/m*X"]);
        said.fails(2, &["the load on `block` is a formula of measured coordinates"]);
    }
    // Without friction, the block oscillates about its equilibrium with sqrt(50 / 2) rad/s.
    let said = folder.stiction(&["equilibrium", "block.toml", "--load", "block.fx = -50 N/m*X"]);
    assert!(said.succeeds().contains("oscillates at 0.7958 Hz"), "{}", said.out);
    let forward =
        |load: &str| folder.stiction(&["forward", "block.toml", "--until", "1", "--load", load]);
    forward("block.fx = -50 N*X").fails(2, &["block.fx"]);
    forward("block.fx = -50 N/m*Y").fails(2, &["`Y`"]);
    // Beyond 0.1 m, the square root is undefined.
    let from = ["--from", "X = 0; d(X) = 1 m/s", "--drives", "none", "--until", "1"];
    let load = ["forward", "block.toml", "--load", "block.fx = -1 N*sqrt(0.1 - X/(1 m))"];
    let said = folder.stiction(&[&load[..], &from].concat());
    said.fails(2, &["the formula of the load on `block` cannot be evaluated at t = "]);
    // A potential barrier of 100 J stops the block before the end of its domain, although trial
    // steps extend beyond it.
    let from = ["--from", "X = 0; d(X) = 9.9 m/s", "--drives", "none", "--until", "0.1"];
    let load = ["forward", "block.toml", "--load", "block.fx = 1000 N*log(1 - X/(100 mm))"];
    let more = ["--tolerance", "1e-4", "--step", "0.1 ms", "-o", "barrier", "--report", "off"];
    folder.stiction(&[&load[..], &from, &more].concat()).succeeds();
    let x = column(&folder.read("barrier/forward.csv"), "X.position [m]");
    let most = x.iter().fold(0.0_f64, |most, x| most.max(*x));
    assert!(most > 0.08 && most < 0.1 && x.iter().any(|x| *x < -0.01), "{most}");
}
