//! Identification from logs with gaps, with a slow beginning, in wrong units, and with models that
//! are wrong or incomplete.

use super::{Folder, columns, json, log, normal, parameter};
use std::fmt::Write as _;

/// Keeps the rows of a log for whose time `keep` returns true.
fn rows_at(text: &str, keep: impl Fn(f64) -> bool) -> String {
    let time = |line: &str| line.split(',').next().unwrap().parse::<f64>();
    let kept = text.lines().filter(|line| time(line).map_or(true, &keep));
    kept.collect::<Vec<_>>().join("\n")
}

/// Checks that gaps are reported and not interpolated: the robot moves far during the gaps, and the
/// fit is as good as without them.
#[test]
fn gaps_are_named_and_not_interpolated() {
    let folder = Folder::new("identify-gaps");
    let missing = [1.3..2.1, 4.0..4.15, 5.0..6.2];
    let gaps = |text: &str| rows_at(text, |t| !missing.iter().any(|gap| gap.contains(&t)));
    folder.write("light.csv", &gaps(&log(&folder, "none", 1, 1.0)));
    folder.write("heavy.csv", &log(&folder, "payload", 2, 1.0));
    folder.write("options.toml", "[[logs]]\nfile = \"heavy.csv\"\nload = \"payload\"\n");
    let options = ["--options", "options.toml", "--filter", "12 Hz", "--json"];
    let wrong = ["--set", "joints.left_elbow.friction.mu=0.12"];
    let said = folder.stiction(
        &[&["identify", "five-bar", "light.csv", "heavy.csv"][..], &options, &wrong].concat(),
    );
    let result = json(said.succeeds());
    let cautions = result["cautions"].to_string();
    // The longest gap is from the row at 4.996 s to that at 6.2 s; the table's first row is line 2.
    for part in ["missing for 1.2040 s from 4.9960 s", "before line 1014", "at 2 more places"] {
        assert!(cautions.contains(part), "{part}: {cautions}");
    }
    assert_eq!(result["verdict"], "identified", "{cautions}");
    let found = parameter(&result, "left_elbow.mu");
    let [mu, sigma] = ["value", "sigma"].map(|key| found[key].as_f64().unwrap());
    assert!((mu - 0.08).abs() < 3.0 * sigma && sigma < 0.03, "{mu} +- {sigma}");
    for name in ["left_motor", "right_motor"] {
        let error = result["predictions"][0]["error_percent"][name].as_f64().unwrap();
        // The noise is one percent of the efforts before the filter.
        assert!(error < 2.0, "{name}: {error}");
    }
}

/// The suggested cut-off frequency suits the whole motion, even if the robot stands still for the
/// first 20 000 rows.
#[test]
fn a_slow_beginning_does_not_set_the_filter() {
    let folder = Folder::new("identify-slow");
    let text = log(&folder, "none", 1, 1.0);
    let mut lines = text.lines();
    let mut long = format!("{}\n", lines.next().unwrap());
    let first: Vec<f64> =
        text.lines().nth(1).unwrap().split(',').map(|x| x.parse().unwrap()).collect();
    let mut noise = normal(8);
    let still = 20_500;
    for k in 0..still {
        let efforts = [first[3], first[4]].map(|effort| effort + 0.02 * noise());
        let positions = [first[1], first[2]].map(|x| x + 1e-6 * noise());
        writeln!(
            long,
            "{},{},{},{},{}",
            0.004 * f64::from(k),
            positions[0],
            positions[1],
            efforts[0],
            efforts[1]
        )
        .unwrap();
    }
    for line in lines {
        let (time, rest) = line.split_once(',').unwrap();
        let time = time.parse::<f64>().unwrap() + 0.004 * f64::from(still);
        writeln!(long, "{time},{rest}").unwrap();
    }
    folder.write("long.csv", &long);
    folder.write("short.csv", &text);
    let cutoff = |file: &str| {
        let said = folder.stiction(&["identify", "five-bar", file, "--json"]);
        let result = json(said.succeeds());
        result["filter_hz"][0].as_f64().unwrap()
    };
    let [long, short] = ["long.csv", "short.csv"].map(cutoff);
    assert!(long > 0.5 * short, "{long} Hz against {short} Hz");
}

/// A pendulum with friction whose centre of mass is on one side of its axis.
fn pendulum(com: f64) -> String {
    format!(
        "gravity = [0, 0, -9.81]\n[bodies.bar]\nmass = 2\ncom = [{com}, 0, 0]\n\
         inertia = [0.02, 0.02, 0.02]\n[joints.hinge]\ntype = \"R\"\nfrom = \"ground\"\nto = \"bar\"\n\
         axis = \"y\"\nactuated = true\n[actuators.M]\njoint = \"hinge\"\nmotor_friction = {{ constant = 0.6, viscous = 0.4 }}\n\
         [motions.swing]\nhinge = \"0.5*sin(2*pi*0.7*t) + 0.3*sin(2*pi*0.31*t)\"\nduration = 12\n"
    )
}

fn pendulum_log(folder: &Folder, sign: f64) -> String {
    folder.write("true.toml", &pendulum(-0.2));
    let options = ["--motion", "swing", "--step", "5 ms", "--report", "off", "-o", "out"];
    folder.stiction(&[&["inverse", "true.toml"], &options[..]].concat()).succeeds();
    let table = folder.read("out/inverse.csv");
    let rows = columns(&table, ["time", "hinge.position", "M.motor_torque ["]);
    let mut noise = normal(3);
    let mut text = "time [s],hinge [rad],M.motor_torque [N m]\n".to_owned();
    for [t, q, effort] in rows {
        writeln!(text, "{t},{q},{}", sign * (effort + 0.01 * noise())).unwrap();
    }
    text
}

/// A centre of mass on the wrong side of the axis is not mistaken for efforts of the wrong sign,
/// because friction still opposes the motion.
#[test]
fn a_wrong_centre_of_mass_is_no_wrong_sign() {
    let folder = Folder::new("identify-side");
    folder.write("log.csv", &pendulum_log(&folder, 1.0));
    folder.write("reverse.csv", &pendulum_log(&folder, -1.0));
    folder.write("wrong.toml", &pendulum(0.2));
    let run = |model: &str, log: &str| {
        json(folder.stiction(&["identify", model, log, "--filter", "8 Hz", "--json"]).succeeds())
    };
    let result = run("wrong.toml", "log.csv");
    let cautions = result["cautions"].to_string();
    assert!(cautions.contains("check masses and centres of mass"), "{cautions}");
    assert_eq!(result["verdict"], "identified", "{cautions}");
    let error = result["predictions"][0]["error_percent"]["hinge"].as_f64().unwrap();
    assert!(error < 2.0, "{error}");
    // With reversed efforts, the wrong sign is certain with the right model, and suspected with the
    // wrong model.
    let result = run("true.toml", "reverse.csv");
    let cautions = result["cautions"].to_string();
    assert!(cautions.contains("wrong sign on hinge"), "{cautions}");
    assert_eq!(result["verdict"], "failed");
    let result = run("wrong.toml", "reverse.csv");
    let cautions = result["cautions"].to_string();
    assert!(cautions.contains("as negative friction would"), "{cautions}");
    assert_ne!(result["verdict"], "identified");
}

/// A strong prior at a wrong model must not make its own error count as noise: nearly exact data
/// determine the values for any strength of the prior.
#[test]
fn a_wrong_model_does_not_hold_the_values() {
    let folder = Folder::new("identify-prior");
    folder.write("log.csv", &pendulum_log(&folder, 1.0));
    let model = pendulum(-0.2).replace("mass = 2", "mass = 1.4");
    folder.write("light.toml", &model);
    folder.write("strong.toml", "prior = 10000\n");
    let options: [&[&str]; 2] = [&[], &["--options", "strong.toml"]];
    for options in options {
        let arguments = ["identify", "light.toml", "log.csv", "--filter", "8 Hz", "--json"];
        let result = json(folder.stiction(&[&arguments[..], options].concat()).succeeds());
        assert_eq!(result["verdict"], "identified", "{options:?}: {:#}", result["cautions"]);
        let found = parameter(&result, "bar.mx");
        let [value, sigma] = ["value", "sigma"].map(|key| found[key].as_f64().unwrap());
        // Truth: 2 kg at -0.2 m.
        assert!((value + 0.4).abs() < 4.0 * sigma && sigma < 0.002, "{value} +- {sigma}");
    }
}

/// Bounds of a mass and of a centre of mass hold; a value at its bound is no longer identified and is named. Bounds
/// without the value of the model, of several kinds or with a single value are refused.
#[test]
fn bounds_of_a_body_hold() {
    let folder = Folder::new("identify-body-bounds");
    folder.write("log.csv", &pendulum_log(&folder, 1.0));
    let run = |bounds: &str, format: &[&str]| {
        folder.write("options.toml", &format!("[bounds]\n{bounds}\n"));
        let options = ["--filter", "8 Hz", "--options", "options.toml"];
        // The centre of mass of the model is at -0.15 m, the true one at -0.2 m.
        let set = ["--set", "bodies.bar.com=[-0.15, 0, 0]"];
        folder
            .stiction(&[&["identify", "true.toml", "log.csv"][..], &options, &set, format].concat())
    };
    let free = json(run("\"bar.com.x\" = [-0.5, 0]", &["--json"]).succeeds());
    let found = parameter(&free, "bar.mx");
    let [value, sigma] = ["value", "sigma"].map(|key| found[key].as_f64().unwrap());
    assert!((value + 0.4).abs() < 4.0 * sigma && found["verdict"] == "identified", "{found:#}");
    let held =
        json(run("\"bar.com.x\" = [-0.16, 0]\n\"bar.mass\" = [1.9, 2.1]", &["--json"]).succeeds());
    let value = |name: &str| parameter(&held, name)["value"].as_f64().unwrap();
    let (mass, com) = (value("bar.mass"), value("bar.mx") / value("bar.mass"));
    assert!((mass - 2.1).abs() < 1e-9 && (com + 0.16).abs() < 1e-9, "{mass} {com}");
    assert_eq!(parameter(&held, "bar.mx")["verdict"], "fits only");
    let cautions = held["cautions"].to_string();
    for part in ["bar.com.x lies at its bound -0.16", "bar.mass lies at its bound 2.1"] {
        assert!(cautions.contains(part), "{part}: {cautions}");
    }
    run("\"bar.mass\" = [3, 4]", &[])
        .fails(2, &["bar.mass", "3 to 4 kg", "value of the model, 2 kg"]);
    run("\"bar.*\" = [0, 4]", &[]).fails(2, &["bar.mass", "bar.mx", "different kinds"]);
    run("\"bar.mass\" = [2, 2]", &[]).fails(2, &["only one value for `bar.mass`", "hold"]);
    run("\"bar.com\" = [0, 1]", &[]).fails(2, &["no parameter matches `bar.com`"]);
}

/// The static coefficient of a joint with Stribeck's curve is found from the friction at low speed, and written to the
/// identified model. Held at the value of the model, it is not changed.
#[test]
fn a_static_coefficient_is_found_from_slow_motion() {
    let folder = Folder::new("identify-stribeck");
    let model = |mu_static: f64| {
        let text = pendulum(-0.2);
        let (before, after) = text.split_once("[actuators.M]").unwrap();
        let after = after.split_once("[motions.swing]").unwrap().1;
        format!(
            "{before}friction = {{ mu = 0.1, radius = \"20 mm\", preload = \"300 N\", viscous = \"300 N s/m\", \
             mu_static = {mu_static}, stribeck_velocity = \"10 mm/s\" }}\n\
             [actuators.M]\njoint = \"hinge\"\n[motions.swing]{after}"
        )
    };
    folder.write("true.toml", &model(0.18));
    let options = ["--motion", "swing", "--step", "5 ms", "--report", "off", "-o", "out"];
    let said =
        folder.stiction(&[&["inverse", "true.toml", "--friction", "on"], &options[..]].concat());
    said.succeeds();
    let rows =
        columns(&folder.read("out/inverse.csv"), ["time", "hinge.position", "hinge.drive ["]);
    let mut noise = normal(3);
    let mut text = "time [s],hinge [rad],hinge.effort [N m]\n".to_owned();
    for [t, q, effort] in rows {
        writeln!(text, "{t},{q},{}", effort + 0.01 * noise()).unwrap();
    }
    folder.write("log.csv", &text);
    folder.write("model.toml", &model(0.13));
    let run = |options: &str, more: &[&str]| {
        folder.write("options.toml", options);
        let arguments = ["identify", "model.toml", "log.csv", "--filter", "8 Hz", "--json"];
        let options = ["--options", "options.toml"];
        json(folder.stiction(&[&arguments[..], &options, more].concat()).succeeds())
    };
    // One payload cannot separate the load-dependent from the constant friction.
    let result = run("hold = [\"hinge.mu\"]\n", &["-o", "found"]);
    let found = parameter(&result, "hinge.static_excess");
    let [value, sigma, prior] = ["value", "sigma", "prior"].map(|key| found[key].as_f64().unwrap());
    assert!((value - 0.8).abs() < 4.0 * sigma && sigma < 0.05, "{value} +- {sigma}");
    assert!((prior - 0.3).abs() < 1e-12 && found["verdict"] == "identified", "{found:#}");
    let coulomb = parameter(&result, "hinge.coulomb");
    let [value, sigma] = ["value", "sigma"].map(|key| coulomb[key].as_f64().unwrap());
    assert!((value - 0.6).abs() < 4.0 * sigma && sigma < 0.02, "{value} +- {sigma}");
    assert_eq!(result["verdict"], "identified", "{:#}", result["cautions"]);
    // The efforts of the identified model are those of the true one.
    let again =
        ["inverse", "found/identified.toml", "--motion", "hinge = 0.05*sin(4*t); duration = 2 s"];
    let efforts = |model: &str| {
        let options = ["--friction", "on", "--step", "10 ms", "--report", "off", "-o", "again"];
        folder.stiction(&[&["inverse", model], &again[2..], &options].concat()).succeeds();
        columns(&folder.read("again/inverse.csv"), ["hinge.drive ["])
    };
    let [own, truth] = ["found/identified.toml", "true.toml"].map(efforts);
    for ([own], [truth]) in own.iter().zip(&truth) {
        assert!((own - truth).abs() < 0.05, "{own} {truth}");
    }
    // With the wrong static coefficient held, friction at low speed is missing.
    let held = run("hold = [\"hinge.mu\", \"hinge.static_excess\"]\n", &[]);
    let value = parameter(&held, "hinge.static_excess")["value"].as_f64().unwrap();
    assert!((value - 0.3).abs() < 1e-12, "{value}");
    assert!(held["missing"].to_string().contains("Stribeck"), "{:#}", held["missing"]);
}

/// The stated error of the model's inertias is that of values which only the model determines.
#[test]
fn the_error_of_the_model_is_stated() {
    let folder = Folder::new("identify-prior-error");
    folder.write("log.csv", &pendulum_log(&folder, 1.0));
    let run = |options: &str, format: &[&str]| {
        folder.write("options.toml", options);
        let arguments = ["identify", "true.toml", "log.csv", "--filter", "8 Hz"];
        folder.stiction(&[&arguments[..], &["--options", "options.toml"], format].concat())
    };
    let sigma = |options: &str| {
        let result = json(run(options, &["--json"]).succeeds());
        let found = parameter(&result, "bar.mass");
        assert_eq!(found["verdict"], "not excited");
        found["sigma"].as_f64().unwrap() / found["value"].as_f64().unwrap()
    };
    let [usual, known] =
        ["prior = 10", "prior = 10\nprior_error = \"5 %\""].map(|text| sigma(&format!("{text}\n")));
    // The data add little to this value.
    assert!((usual / known - 6.0).abs() < 0.5, "{usual} {known}");
    run("prior_error = 0\n", &[]).fails(2, &["`prior_error`", "from 1 to 100 %"]);
    run("prior_error = \"0.3\"\n", &[]).fails(2, &["`prior_error`", "10 %"]);
}

/// Efforts in mN m that are declared as N m are reported.
#[test]
fn a_wrong_unit_of_efforts_is_named() {
    let folder = Folder::new("identify-unit");
    folder.write("log.csv", &pendulum_log(&folder, 1000.0));
    let said = folder.stiction(&["identify", "true.toml", "log.csv", "--filter", "8 Hz"]);
    assert!(said.succeeds().contains("times those of the model: check their unit"), "{}", said.out);
}

/// Log from another engine (Pinocchio, see `validation/identify_log.py`), identified with CAD data
/// that are wrong by 20 % and friction that is wrong by half. The true values lie within the
/// intervals, and the predicted efforts agree with the log up to noise.
#[test]
fn a_log_of_another_engine_with_a_wrong_prior() {
    let folder = Folder::new("identify-pinocchio");
    folder.write("log.csv", include_str!("five_bar_pinocchio.csv"));
    let model = folder.stiction(&["models", "five-bar"]).succeeds().to_owned();
    let friction = |from: &str, own: &str, text: &str| {
        assert!(text.contains(from), "{from}");
        text.replace(from, own)
    };
    // 0.04 N m and 0.02 N m s/rad at the motors, 0.02 and 0.01 at the elbows, no friction at the tip.
    let motor =
        "friction = { mu = 0.002, viscous = \"2 N s/m\", radius = \"10 mm\", preload = \"20 N\" }";
    let elbow = "friction = { mu = 0.08, radius = \"5 mm\" }";
    let text =
        friction(motor, "friction = { viscous = \"200 N s/m\", radius = \"10 mm\" }", &model);
    let text = text.replacen(elbow, "friction = { viscous = \"400 N s/m\", radius = \"5 mm\" }", 2);
    let text = friction(elbow, "", &text);
    folder.write("model.toml", &text);
    let wrong =
        ["bodies.tool.mass=0.6", "bodies.left_crank.mass=0.28", "bodies.right_coupler.mass=0.264"];
    let mut run = vec!["identify", "model.toml", "log.csv", "--filter", "15 Hz", "--json"];
    wrong.iter().for_each(|value| run.extend(["--set", value]));
    let result = json(folder.stiction(&run).succeeds());
    assert_eq!(result["verdict"], "identified", "{:#}", result["cautions"]);
    let truth = [
        ("left_motor.coulomb", 0.08),
        ("left_elbow.coulomb", 0.04),
        ("right_motor.coulomb", 0.06),
        ("right_elbow.coulomb", 0.03),
        ("left_motor.viscous", 0.03),
        ("left_elbow.viscous", 0.015),
        ("right_motor.viscous", 0.02),
        ("right_elbow.viscous", 0.012),
    ];
    let mut identified = 0;
    for (name, truth) in truth {
        let found = parameter(&result, name);
        let [value, sigma] = ["value", "sigma"].map(|key| found[key].as_f64().unwrap());
        // Eight intervals, each of 99.9 %.
        assert!((value - truth).abs() < 3.3 * sigma, "{name}: {value} +- {sigma}");
        identified += usize::from(found["verdict"] == "identified");
    }
    assert!(identified >= 4, "{identified}");
    for (name, error) in result["predictions"][0]["error_percent"].as_object().unwrap() {
        // The noise is 1 % of the efforts before the filter.
        assert!(error.as_f64().unwrap() < 2.0, "{name}: {error}");
    }
}

/// Checks that compliance which the model lacks is reported: the motor with its encoder drives the
/// link through a spring, so the weight and inertia of the link deflect it from the measured angle.
#[test]
fn compliance_that_the_model_lacks_is_noticed() {
    let folder = Folder::new("identify-compliance");
    folder.write("model.toml", &pendulum(-0.2));
    // The link angle is q and the motor angle is q + effort/k, with the effort of a rigid pendulum.
    // The spring deflects by at least a tenth of the motion.
    let mut noise = normal(5);
    let mut text = "time [s],hinge [rad],M.motor_torque [N m]\n".to_owned();
    let (stiffness, tau) = (12.0, std::f64::consts::TAU);
    for k in 0..2400 {
        let t = 5e-3 * f64::from(k);
        let waves = [(0.5, 0.7 * tau), (0.3, 0.31 * tau), (0.15, 2.1 * tau)];
        let sum = |f: fn(f64, f64) -> f64| waves.map(|(a, w)| a * f(w, w * t)).iter().sum::<f64>();
        let (q, a) = (sum(|_, p| p.sin()), sum(|w, p| -w * w * p.sin()));
        let v = sum(|w, p| w * p.cos());
        // The spring carries the weight and inertia of the link without friction; the friction is
        // that of the motor.
        let spring = 0.1 * a + 0.4 * 9.81 * q.cos();
        let motor = q + spring / stiffness;
        let effort = spring + 0.6 * v.signum() + 0.4 * v;
        writeln!(text, "{t:.3},{motor},{}", effort + 0.01 * noise()).unwrap();
    }
    folder.write("log.csv", &text);
    let run = ["identify", "model.toml", "log.csv", "--filter", "8 Hz", "--json"];
    let result = json(folder.stiction(&run).succeeds());
    assert_ne!(result["verdict"], "identified", "{:#}", result["cautions"]);
    let cautions = result["cautions"].to_string();
    assert!(cautions.contains("the model lacks an effect, such as compliance"), "{cautions}");
}

/// A constant load on the platform that the model lacks, along a motion that is repeated four times: inertias cannot explain
/// it, so that the best prediction has absurd ones. The prior holds them, and none counts as identified.
#[test]
fn a_load_that_the_model_lacks_gives_no_absurd_masses() {
    let folder = Folder::new("identify-load");
    let motion = "platform.z = 550 mm + 25 mm*sin(2*pi*0.2*t) + 12 mm*sin(2*pi*0.6*t + 1); \
                  platform.rx = 0.12 rad*sin(2*pi*0.2*t + 0.4) + 0.06 rad*sin(2*pi*0.8*t); \
                  platform.ry = 0.12 rad*sin(2*pi*0.4*t + 2) + 0.06 rad*sin(2*pi*0.6*t + 0.7); duration = 20 s";
    let run = ["inverse", "3rps", "--motion", motion, "--load", "reference", "--friction", "on"];
    let more = ["--step", "10 ms", "--report", "off", "-o", "out"];
    folder.stiction(&[&run[..], &more].concat()).succeeds();
    let names = ["leg1.P", "leg2.P", "leg3.P"];
    let [a, b, c] = names.map(|name| format!("{name}.position ["));
    let [d, e, f] = names.map(|name| format!("{name}.drive ["));
    let table = columns(&folder.read("out/inverse.csv"), ["time", &a, &b, &c, &d, &e, &f]);
    let mut text = "time [s]".to_owned();
    names.iter().for_each(|name| write!(text, ",{name} [m]").unwrap());
    names.iter().for_each(|name| write!(text, ",{name}.effort [N]").unwrap());
    let mut noise = normal(6);
    for [t, p, q, r, x, y, z] in table {
        let [x, y, z] = [x, y, z].map(|effort| effort + 0.5 * noise());
        write!(text, "\n{t},{p:.6},{q:.6},{r:.6},{x},{y},{z}").unwrap();
    }
    folder.write("log.csv", &text);
    let arguments = ["identify", "3rps", "log.csv", "--filter", "5 Hz", "--json"];
    let result = json(folder.stiction(&arguments).succeeds());
    assert_eq!(result["verdict"], "fits only", "{:#}", result["cautions"]);
    for name in ["leg1.cylinder.mass", "leg2.cylinder.mass", "leg3.cylinder.mass"] {
        let found = parameter(&result, name);
        let [value, sigma] = ["value", "sigma"].map(|key| found[key].as_f64().unwrap());
        // Truth: 5.15 kg. No effort depends on this mass alone.
        assert!((value - 5.15).abs() < 3.0 * sigma && value < 20.0, "{name}: {value} +- {sigma}");
        assert_eq!(found["verdict"], "not excited", "{name}: {value} +- {sigma}");
    }
    for p in result["parameters"].as_array().unwrap() {
        let [value, sigma, prior] = ["value", "sigma", "prior"].map(|key| p[key].as_f64().unwrap());
        assert!(
            p["verdict"] != "identified" || (value - prior).abs() < 3.0 * sigma,
            "{}: {value} +- {sigma} instead of {prior}",
            p["name"]
        );
    }
}
