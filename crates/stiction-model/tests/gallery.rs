//! The models that ship are right, and what they say is what they mean.

use stiction_model::{Source, gallery, read};

#[test]
fn all_models_are_read_without_a_word() {
    for name in gallery::names() {
        let text = gallery::get(name).unwrap();
        match read(&Source::new(format!("{name}.toml"), text), &|_| Err("no files".into())) {
            Ok(model) => {
                assert!(model.warnings.is_empty(), "{name}:\n{}", model.warnings);
                assert_eq!(model.name, name);
                assert!(!model.title.is_empty() && !model.source.is_empty());
                assert!(model.default_motion.is_some());
            }
            Err(diagnostics) => panic!("{diagnostics}"),
        }
    }
}

mod reference {
    use stiction::dynamics::{FrictionMode, InverseDynamics, Settings};
    use stiction_model::{Model, Source, gallery, read};

    fn model(name: &str) -> Model {
        let text = gallery::get(name).unwrap();
        read(&Source::new(format!("{name}.toml"), text), &|_| Err("no files".into())).unwrap()
    }

    /// The rows of a reference file as cells.
    fn rows(file: &str) -> (Vec<String>, Vec<Vec<String>>) {
        let path = format!("{}/../../reference/{file}", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(path).unwrap();
        let mut lines = text
            .lines()
            .filter(|line| !line.starts_with('#'))
            .map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
        (lines.next().unwrap(), lines.collect())
    }

    /// The driving forces at an instant of the default motion under a load.
    fn drives(model: &Model, load: &str, friction: FrictionMode, t: f64) -> Vec<f64> {
        let motion = model.motion(model.default_motion.as_ref().unwrap()).unwrap();
        let coordinates: Vec<_> = motion.coordinates.iter().map(|(c, _)| *c).collect();
        let targets: Vec<_> = motion.at(t).collect();
        let settings = Settings { friction, ..Settings::default() };
        let mechanism = model.mechanism.clone();
        let mut solver =
            InverseDynamics::new(mechanism, &model.homes, &coordinates, &targets, settings)
                .unwrap();
        let loads: Vec<_> = model.load(load).unwrap().at(t).collect();
        solver.solve(&loads).unwrap().drives.clone()
    }

    #[test]
    fn the_3rps_is_that_of_the_reference() {
        let model = model("3rps");
        assert_eq!(model.default_friction, Some(FrictionMode::Off));
        let (_, rows) = rows("3rps_symmetric_actuator.csv");
        for row in rows.iter().step_by(10) {
            let row: Vec<f64> = row.iter().map(|cell| cell.parse().unwrap()).collect();
            let found = drives(&model, "reference", FrictionMode::Off, row[0]);
            for (found, expected) in found.iter().zip(&row[1..]) {
                // Five programs agree on these numbers of order 100 N within 1e-12 of them.
                assert!((found - expected).abs() < 1e-10, "{}: {found} {expected}", row[0]);
            }
        }
    }

    #[test]
    fn the_regular_twin_is_that_of_the_reference() {
        let model = model("zhang2018-regular");
        assert_eq!(model.default_friction, Some(FrictionMode::Converged));
        let (header, rows) = rows("3rps_parallel_axis_regular_L0.csv");
        let column = |name: &str| header.iter().position(|cell| cell == name).unwrap();
        for row in &rows {
            let friction = match row[column("case")].as_str() {
                "frictionless" => FrictionMode::Off,
                "onepass" => FrictionMode::OnePass,
                _ => FrictionMode::Converged,
            };
            let t = row[column("t")].parse().unwrap();
            let found = drives(&model, "L0", friction, t);
            for (found, name) in found.iter().zip(["tau1", "tau2", "tau3"]) {
                let expected: f64 = row[column(name)].parse().unwrap();
                // The reference is printed with ten digits.
                assert!((found - expected).abs() < 1e-7, "{t} {name}: {found} {expected}");
            }
        }
    }

    /// Along all its motions and under all its loads, with and without friction.
    #[test]
    fn the_five_bar_moves() {
        let mut model = model("five-bar");
        for (motion, _) in model.motions.clone() {
            model.default_motion = Some(motion.clone());
            for (load, _) in &model.loads {
                let duration = model.motion(&motion).unwrap().duration;
                for k in 0..=20 {
                    let t = duration * f64::from(k) / 20.0;
                    for friction in [FrictionMode::Off, FrictionMode::Converged] {
                        let drives = drives(&model, load, friction, t);
                        assert_eq!(drives.len(), 2);
                        // Two kilograms at a fifth of a metre and some accelerations of gravity.
                        assert!(drives.iter().all(|drive| drive.abs() < 20.0), "{motion} {t}");
                    }
                }
            }
        }
    }
}
