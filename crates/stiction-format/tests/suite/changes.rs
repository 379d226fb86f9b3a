//! Changes of single values of a model's text.

use stiction_format::{ModelFile, Source, gallery, read};

fn changed(model: &str, changes: &[&str]) -> Result<ModelFile, String> {
    let source = Source::new(format!("{model}.toml"), gallery::get(model).unwrap());
    read(&source.with_changes(changes), &|_| Err("no files".to_owned()))
        .map_err(|diagnostics| diagnostics.to_string())
}

fn mass(model: &ModelFile, body: &str) -> f64 {
    model.mechanism.bodies()[model.mechanism.body_id(body).unwrap().0].mass
}

#[test]
fn a_key_a_part_and_a_parameter_can_be_changed() {
    for change in ["bodies.tool.mass=0.7kg", "tool.mass = 700 g", "bodies.tool.mass=0.7"] {
        let model = changed("five-bar", &[change]).unwrap();
        assert_eq!(mass(&model, "tool"), 0.7, "{change}");
        assert!(model.title.ends_with(&format!("with {}", change.trim())), "{}", model.title);
    }
    let longer = changed("five-bar", &["crank = 220 mm"]).unwrap();
    let com = longer.mechanism.bodies()[1].com;
    assert_eq!(com.x, 0.11);
    // A later change of the same value takes precedence.
    assert_eq!(mass(&changed("five-bar", &["tool.mass=1", "tool.mass=2"]).unwrap(), "tool"), 2.0);
}

#[test]
fn a_change_of_legs_concerns_all_that_have_the_key() {
    let model = changed("delta", &["legs.rod.mass=2kg"]).unwrap();
    let rods: Vec<f64> = model
        .mechanism
        .bodies()
        .iter()
        .filter(|body| body.name.ends_with("rod"))
        .map(|body| body.mass)
        .collect();
    assert_eq!(rods, [2.0; 6]);
    let model = changed("delta", &["legs.1.bodies.rod.mass=2kg"]).unwrap();
    assert_eq!(model.mechanism.bodies().iter().filter(|body| body.mass == 2.0).count(), 3);
}

#[test]
fn keys_that_the_text_does_not_have_are_added() {
    let model = changed("five-bar", &["default.friction=off", "gravity=[0, 0, 0]"]).unwrap();
    assert_eq!(model.default_friction, Some(stiction_core::dynamics::FrictionMode::Off));
    assert_eq!(model.mechanism.gravity().y, 0.0);
    let with = changed("five-bar", &["joints.tip.friction.mu_static=0.2"]).unwrap();
    assert!(with.mechanism != changed("five-bar", &[]).unwrap().mechanism);
}

#[test]
fn a_defective_change_is_shown() {
    let message = |change: &str| changed("five-bar", &["crank=210mm", change]).unwrap_err();
    for (change, says) in [
        ("tool.mass", "a change needs a key and a value"),
        ("bodies.toool.mass=1", "did you mean `tool`?"),
        ("cranck=1", "did you mean `crank`?"),
        ("tool.masss=1", "did you mean `mass`?"),
        ("tool.mass=1 mm", "--set:2:11"),
        ("tool.mass.x=1", "has no keys"),
        ("=", "the model has no ``"),
        ("legs.rod.mass=1", "legs"),
        ("cranc.mass=1", "did you mean `crank`?"),
        ("tool.com.0=1", "the model has no `com.0`"),
        ("tool.com.0=1", "did you mean `com.1`"),
    ] {
        let message = message(change);
        assert!(message.contains(says), "{change}: {message}");
        assert!(message.contains("--set:2:"), "{change}: {message}");
    }
}

/// Lists need no quotes around their entries, as single values need none.
#[test]
fn entries_of_a_list_need_no_quotes() {
    let com = |list: &str| {
        let model = changed("five-bar", &[&format!("tool.com={list}")]).unwrap();
        model.mechanism.bodies()[model.mechanism.body_id("tool").unwrap().0].com.to_array()
    };
    assert_eq!(com("[20 mm, 3cm, 0]"), [0.02, 0.03, 0.0]);
    assert_eq!(com("[\"20 mm\", 0.5*crank, 0]"), [0.02, 0.1, 0.0]);
    let nested = "[".repeat(10_000);
    assert!(changed("five-bar", &[&format!("tool.com={nested}")]).is_err());
}

/// A key without the tables that contain it is refused with whole paths, which can be changed.
#[test]
fn the_tables_of_a_key_are_shown() {
    for (model, path, count) in [
        ("3rps", "legs.joints.R.friction.mu", 3),
        ("delta", "legs.1.joints.R.friction.mu", 9),
        ("five-bar", "joints.left_motor.friction.mu", 5),
    ] {
        let message = changed(model, &["mu=0.2"]).unwrap_err();
        assert!(message.contains("the model has no `mu`"), "{message}");
        assert!(message.contains(&format!("{count} tables have a key `mu`")), "{message}");
        assert!(message.contains(&format!("`{path}`")), "{message}");
        changed(model, &[&format!("{path}=0.2")]).unwrap();
    }
    let message = changed("3rps", &["angles=[0, 90, 180]"]).unwrap_err();
    assert!(message.contains("write the whole path: `legs.angles`"), "{message}");
}

/// A part of the legs is addressed by its name in the chain, with or without `legs`. Other names
/// are refused, with a list of the existing names.
#[test]
fn parts_of_legs_are_named_as_in_the_chain() {
    for change in ["legs.tube.mass=2kg", "tube.mass=2kg", "legs.bodies.tube.mass=2kg"] {
        let model = changed("gough", &[change]).unwrap();
        assert_eq!(mass(&model, "leg4.tube"), 2.0, "{change}");
    }
    let model = changed("delta", &["rod.mass=2kg"]).unwrap();
    assert_eq!(mass(&model, "leg2.rod"), 2.0);
    assert_eq!(mass(&model, "twin2.rod"), 2.0);
    for (change, says) in [
        ("legs.tubes.mass=2kg", "did you mean `tube`?"),
        ("legs.rod.mass=2kg", "known keys: `tube`, `screw`, `U`, `P`, `S`"),
        ("tubes.mass=2kg", "did you mean `tube`?"),
    ] {
        let message = changed("gough", &[change]).unwrap_err();
        assert!(message.contains(says), "{change}: {message}");
    }
    // The path cannot continue below a parameter; the message suggests parts with similar names.
    let message = changed("delta", &["arm_mass.com=2kg"]).unwrap_err();
    assert!(message.contains("`arm_mass` is a value, which has no keys"), "{message}");
}

/// A misspelt name of a gearing is refused and does not add a gearing.
#[test]
fn gearings_are_changed_by_name() {
    let text = "gravity = [0, 0, 0]\n[bodies.a]\n[bodies.b]\n\
        [joints.p]\ntype = \"R\"\nfrom = \"ground\"\nto = \"a\"\naxis = \"z\"\n\
        [joints.q]\ntype = \"R\"\nfrom = \"ground\"\nto = \"b\"\naxis = \"z\"\n\
        [gearings.belt]\njoints = { p = 1, q = -2 }\n";
    let read = |change: &str| {
        let source = Source::new("gears.toml", text).with_changes([change]);
        read(&source, &|_| Err("no files".to_owned())).map_err(|defects| defects.to_string())
    };
    assert!(read("gearings.belt.offset=30 deg").is_ok());
    assert!(read("belt.offset=30 deg").is_ok());
    assert!(read("gearings.bellt.offset=30 deg").unwrap_err().contains("did you mean `belt`?"));
}

/// Names in the model address parts of a single leg; the other legs keep their values.
#[test]
fn a_part_of_one_leg_can_be_changed() {
    let masses = |change: &str| {
        let model = changed("3rps", &[change]).unwrap();
        [1, 2, 3].map(|leg| mass(&model, &format!("leg{leg}.rod")))
    };
    for change in ["bodies.leg2.rod.mass=3kg", "leg2.rod.mass=3kg"] {
        assert_eq!(masses(change), [2.07, 3.0, 2.07], "{change}");
    }
    assert_eq!(masses("leg2.rod.mass=3kg").len(), 3);
    let both = changed("3rps", &["leg1.rod.mass=3", "leg1.rod.mass=4", "leg3.rod.mass=5"]).unwrap();
    assert_eq!([1, 2, 3].map(|leg| mass(&both, &format!("leg{leg}.rod"))), [4.0, 2.07, 5.0]);
    // Unchanged values of the changed table are those of all legs.
    let model = changed("3rps", &["joints.leg3.P.friction.mu=0.3"]).unwrap();
    let law = |joint: &str| {
        let id = model.mechanism.joint_id(joint).unwrap();
        let law = &model.mechanism.joints()[id.0].friction[0].law;
        [law.mu, law.viscous]
    };
    assert_eq!([law("leg1.P"), law("leg3.P")], [[0.12, 0.02], [0.3, 0.02]]);
    // The numbering continues across groups, and legs may have names.
    let model = changed("delta", &["twin2.rod.mass=1", "leg3.rod.mass=2"]).unwrap();
    assert_eq!(
        ["leg2.rod", "twin2.rod", "leg3.rod"].map(|body| mass(&model, body)),
        [0.06, 1.0, 2.0]
    );
    for wrong in ["leg4.rod.mass=1", "leg2.rood.mass=1", "leg2.rod.masss=1"] {
        assert!(changed("3rps", &[wrong]).is_err(), "{wrong}");
    }
}
