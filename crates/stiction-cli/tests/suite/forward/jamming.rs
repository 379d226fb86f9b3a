//! A mechanism that jams: the guide P4 locks where it reverses.

use crate::program::{Folder, column, json};

const JAMS: &str = r#"
gravity = [-3.305, -1.94, -4.07]
[bodies.b1]
mass = 2.646
com = [0.0081, -0.1762, 0.1757]
inertia = { xx = 0.0594, yy = 0.0504, zz = 0.0373, xy = 0.0014, xz = -0.001 }
[bodies.b2]
mass = 1.519
com = [0.1741, 0.2367, 0.2902]
inertia = { xx = 0.0656, yy = 0.0661, zz = 0.0415, xy = 0.0021, xz = -0.0014 }
[bodies.b3]
mass = 2.045
com = [0.1642, 0.1647, 0.1298]
inertia = { xx = 0.0571, yy = 0.0609, zz = 0.0671, xy = 0.0025, xz = -0.0018 }
[bodies.b4]
mass = 0.868
com = [0.2752, 0.0013, -0.1157]
inertia = { xx = 0.0539, yy = 0.069, zz = 0.0474, xy = 0.0016, xz = -0.0011 }
[joints.S0]
type = "S"
from = "b1"
to = "ground"
at = [-0.0106, -0.3073, -0.2516]
to_at = [-0.0106, -0.3073, -0.2516]
[joints.R1]
type = "R"
from = "b1"
to = "b2"
at = [0.0953, -0.3496, 0.1417]
to_at = [0.0953, -0.3496, 0.1417]
axis = [-0.5395, -0.9637, -0.9592]
actuated = true
[joints.R2]
type = "R"
from = "b3"
to = "b2"
at = [-0.4072, -0.1833, -0.0381]
to_at = [-0.4072, -0.1833, -0.0381]
axis = [-0.5966, -0.3398, -0.2985]
[joints.R3]
type = "R"
from = "b3"
to = "b4"
at = [-0.2635, -0.0185, -0.2054]
to_at = [-0.2635, -0.0185, -0.2054]
axis = [-0.6676, -0.1946, 0.0738]
[joints.P4]
type = "P"
from = "ground"
to = "b4"
at = [-0.0156, 0.3714, -0.4638]
to_at = [-0.0156, 0.3714, -0.4638]
axis = [0.4701, 0.1429, -0.2069]
friction = { mu = 0.1042, gland = 0.3, piston = -0.2 }
[loads.l]
b2 = { force = [0.9393, -7.8539, -35.3983], moment = [-0.3958, -4.774, -1.6986], at = [0.0893, 0.0792, 0.0335] }
[default]
load = "l"
"#;

/// The velocity jump that ends the motion dissipates all kinetic energy, although the product of
/// friction and sliding velocity has no correct digit where the guide reverses.
#[test]
fn a_jump_dissipates_the_energy_that_is_lost() {
    let folder = Folder::new("forward-jams");
    folder.write("jams.toml", JAMS);
    let run = [
        "forward",
        "jams.toml",
        "--drives",
        "R1 = 11.6 N m*sin(5*t)",
        "--from",
        "R1 = 0 rad",
        "--until",
        "0.65",
        "--report",
        "off",
        "--json",
    ];
    for method in ["automatic", "time-stepping"] {
        let said = folder.stiction(&[&run[..], &["--method", method, "-o", method]].concat());
        let summary = json(said.succeeds());
        assert!(summary["events"]["jump"].as_u64() > Some(0), "{method}: {}", summary["events"]);
        let energy = folder.read(&format!("{method}/energy.csv"));
        let of = |name: &str| column(&energy, name);
        let [kinetic, dissipated, error] =
            ["kinetic [J]", "P4.dissipated [J]", "error [J]"].map(of);
        let most = kinetic.iter().copied().fold(0.0, f64::max);
        assert!(most > 3.0 && kinetic.last().is_some_and(|last| *last < 1e-6), "{kinetic:?}");
        assert!(dissipated.windows(2).all(|pair| pair[1] >= pair[0] - 1e-12), "{dissipated:?}");
        assert!(error.iter().all(|error| error.abs() < 1e-3 * most), "{error:?}");
    }
}
