//! Mechanisms that jam.

use crate::program::{Folder, column, json};

/// The guide P4 locks where it reverses.
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

/// Two guides stick while the other joints move fast, and the pin R5 jams at its dead centre.
const DEAD_CENTRE: &str = r#"
gravity = [-2.862, -6.382, -6.879]
[bodies.b1]
mass = 1.4884
com = [0.0367, -0.083, -0.0233]
inertia = { xx = 0.0283, yy = 0.0440, zz = 0.0238 }
[bodies.b2]
mass = 1.3742
com = [-0.146, -0.0507, 0.1024]
inertia = { xx = 0.0406, yy = 0.0317, zz = 0.0284 }
[bodies.b3]
mass = 2.3344
com = [-0.0587, 0.1894, -0.102]
inertia = { xx = 0.0415, yy = 0.0526, zz = 0.0508 }
[bodies.b4]
mass = 0.3275
com = [-0.1334, 0.2376, -0.1067]
inertia = { xx = 0.0052, yy = 0.0064, zz = 0.0082 }
[bodies.b5]
mass = 0.3505
com = [0.2451, -0.2488, -0.2398]
inertia = { xx = 0.0102, yy = 0.0055, zz = 0.0074 }
[bodies.b6]
mass = 0.9518
com = [0.157, -0.198, 0.2213]
inertia = { xx = 0.0282, yy = 0.0204, zz = 0.0260 }
[bodies.b7]
mass = 0.3943
com = [0.2831, -0.1763, -0.0385]
inertia = { xx = 0.0094, yy = 0.0070, zz = 0.0110 }
[joints.R0]
type = "R"
from = "b1"
to = "ground"
at = [0.408, -0.0889, 0.1077]
to_at = [0.408, -0.0889, 0.1077]
axis = [0.3719, -0.9283, 0.0023]
friction = { mu = 0.4169, radius = 0.0175 }
[joints.P1]
type = "P"
from = "b2"
to = "b1"
at = [0.4848, -0.1979, -0.1513]
to_at = [0.4848, -0.1979, -0.1513]
axis = [-0.6394, 0.7118, -0.2908]
friction = { mu = 0.5890, bending_span = 0.1818 }
[joints.C2]
type = "C"
from = "b3"
to = "b2"
at = [0.2747, -0.2113, 0.0864]
to_at = [0.2747, -0.2113, 0.0864]
axis = [-0.7577, -0.4154, 0.5033]
friction = { mu = 0.2021, radius = 0.0091, bending_span = 0.1538, preload = 2.381, mu_static = 1.0400 }
[joints.R3]
type = "R"
from = "b3"
to = "b4"
at = [0.1785, -0.2907, -0.1683]
to_at = [0.1785, -0.2907, -0.1683]
axis = [0.6502, 0.6846, 0.3295]
friction = { mu = 0.6611, radius = 0.0121, bending_span = 0.1833, mu_static = 1.0400 }
[joints.P4]
type = "P"
from = "b5"
to = "b4"
at = [0.001, -0.5154, -0.1622]
to_at = [0.001, -0.5154, -0.1622]
axis = [0.8669, 0.1464, -0.4764]
friction = { mu = 0.5219, bending_span = 0.1429, preload = 4.347 }
[joints.R5]
type = "R"
from = "b5"
to = "b6"
at = [-0.3645, -0.3547, -0.0628]
to_at = [-0.3645, -0.3547, -0.0628]
axis = [0.7993, -0.1601, 0.5792]
friction = { mu = 0.3947, radius = 0.0057, bending_span = 0.1664 }
[joints.R6]
type = "R"
from = "b6"
to = "b7"
at = [-0.4976, -0.2033, 0.0531]
to_at = [-0.4976, -0.2033, 0.0531]
axis = [-0.7997, 0.3390, -0.4956]
friction = { mu = 0.5831, radius = 0.0112 }
[joints.R7]
type = "R"
from = "ground"
to = "b7"
at = [-0.3312, 0.0543, -0.0263]
to_at = [-0.3312, 0.0543, -0.0263]
axis = [0.3926, -0.6805, 0.6187]
friction = { mu = 0.5273, radius = 0.0101, bending_span = 0.1474, mu_static = 1.0400 }
"#;

/// The locks of joints that stick at a dead centre stop the mechanism: an instant later they no longer
/// permit the velocities. The energy that is lost is dissipated.
#[test]
fn a_stop_at_a_dead_centre_dissipates_the_energy() {
    let folder = Folder::new("forward-dead-centre");
    folder.write("loop.toml", DEAD_CENTRE);
    let from = "d(R0) = 3.612 rad/s; d(P1) = 0.142 m/s; d(C2.slide) = 0.998 m/s";
    let run = ["forward", "loop.toml", "--drives", "none", "--from", from, "--until", "0.05"];
    let said = folder.stiction(&[&run[..], &["--report", "off", "--json", "-o", "."]].concat());
    let summary = json(said.succeeds());
    assert!(summary["events"]["jump"].as_u64() > Some(1), "{}", summary["events"]);
    let energy = folder.read("energy.csv");
    let [kinetic, error] = ["kinetic [J]", "error [J]"].map(|name| column(&energy, name));
    assert!(kinetic[0] > 100.0 && *kinetic.last().unwrap() < 1e-6, "{kinetic:?}");
    assert!(error.iter().all(|error| error.abs() < 1e-3 * kinetic[0]), "{error:?}");
}

/// The sleeve C0 jumps to and fro between two speeds, at first every six microseconds.
const HOPS: &str = r#"
gravity = [9.466, 1.814, -1.829]
[bodies.b1]
mass = 0.4126
com = [-0.0641, 0.106, -0.2192]
inertia = { xx = 0.0114, yy = 0.0068, zz = 0.0122 }
[bodies.b2]
mass = 2.0099
com = [-0.1247, -0.2624, -0.2333]
inertia = { xx = 0.0335, yy = 0.0514, zz = 0.0353 }
[bodies.b3]
mass = 1.9184
com = [0.096, 0.0796, -0.297]
inertia = { xx = 0.0446, yy = 0.0366, zz = 0.0305 }
[bodies.b4]
mass = 0.9553
com = [-0.2101, 0.1523, -0.125]
inertia = { xx = 0.0153, yy = 0.0200, zz = 0.0236 }
[joints.C0]
type = "C"
from = "ground"
to = "b1"
at = [0.4052, 0.0943, -0.1027]
to_at = [0.4052, 0.0943, -0.1027]
axis = [0.8768, -0.2006, -0.4370]
friction = { mu = 0.9045, radius = 0.0095, bending_span = 0.0989, mu_static = 1.3000 }
[joints.S1]
type = "S"
from = "b1"
to = "b2"
at = [0.4053, -0.3855, -0.092]
to_at = [0.4053, -0.3855, -0.092]
friction = { mu = 0.8677, radius = 0.0070 }
[joints.R2]
type = "R"
from = "b3"
to = "b2"
at = [-0.0525, -0.5479, 0.0724]
to_at = [-0.0525, -0.5479, 0.0724]
axis = [-0.4674, -0.0966, -0.8788]
friction = { mu = 0.6932, radius = 0.0075, mu_static = 1.3000 }
[joints.U3]
type = "U"
from = "b4"
to = "b3"
at = [-0.2231, -0.329, 0.0637]
to_at = [-0.2231, -0.329, 0.0637]
axis = [0.6916836261189848, -0.7064734401310065, 0.1498967636353556]
second_axis = [-0.2173118024274146, -0.005660381350751162, 0.976085826456215]
friction = { mu = 0.7261, radius = 0.0159, bending_span = 0.1662 }
[joints.H4]
type = "H"
from = "b4"
to = "ground"
at = [-0.4318, 0.0039, -0.1759]
to_at = [-0.4318, 0.0039, -0.1759]
axis = [0.3459, 0.6235, 0.7011]
pitch = -0.0146
friction = { mu = 0.8360, radius = 0.0355, bending_span = 0.1020, flank_angle = "30 deg" }
"#;

/// Dense velocity jumps are not located one by one, which took more than thirty steps for each.
#[test]
fn dense_jumps_are_not_located() {
    let folder = Folder::new("forward-hops");
    folder.write("loop.toml", HOPS);
    let run = ["forward", "loop.toml", "--drives", "none", "--from", "rest", "--until", "0.01"];
    let said = folder.stiction(&[&run[..], &["--report", "off", "--json", "-o", "."]].concat());
    let summary = json(said.succeeds());
    let jumps = summary["events"]["jump"].as_u64();
    assert!(jumps >= Some(40) && jumps < Some(50), "{}", summary["events"]);
    let evaluations = summary["verdicts"]["evaluations"].as_u64();
    assert!(evaluations < Some(20_000), "{evaluations:?}");
}
