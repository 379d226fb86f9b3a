//! Values of varied keys, and models read repeatedly.

use stiction_format::{Draft, Setting, Source, Values, Variation, gallery, read};

fn values(text: &str) -> (String, Vec<String>) {
    let variation = Variation::parse(text).unwrap_or_else(|error| panic!("{error}"));
    let count = variation.count().unwrap();
    let all = (0..count).map(|k| variation.at(k));
    let changes = all.map(|setting| variation.key.change(&setting).unwrap()).collect();
    (variation.key.to_string(), changes)
}

#[test]
fn ranges_have_their_ends_and_decimal_values() {
    let (header, found) = values("mu = 0.05..0.3 in 6");
    assert_eq!(header, "mu");
    assert_eq!(found, ["mu = 0.05", "mu = 0.1", "mu = 0.15", "mu = 0.2", "mu = 0.25", "mu = 0.3"]);
    let (header, found) = values("  legs.P.travel=20 mm .. 4 cm in 3");
    assert_eq!(header, "legs.P.travel [mm]");
    assert_eq!(found, ["legs.P.travel = 20 mm", "legs.P.travel = 30 mm", "legs.P.travel = 40 mm"]);
    assert_eq!(values("k = 0..1 kN/m in 2").1, ["k = 0 kN/m", "k = 1 kN/m"]);
    assert_eq!(values("a = -1e-3..1e-3 in 3").1, ["a = -0.001", "a = 0", "a = 0.001"]);
    assert_eq!(values("a = 1..2 in 1").1, ["a = 1"]);
    assert_eq!(values("a = 1 in..2 in in 2").1, ["a = 1 in", "a = 2 in"]);
    assert_eq!(values("c = 1e-6..1e-2 in 5 log").1[1..3], ["c = 0.00001", "c = 0.0001"]);
}

#[test]
fn lists_are_numbers_of_one_unit_or_texts() {
    assert_eq!(
        values("crank = [200 mm, 0.25 m]"),
        ("crank [mm]".to_owned(), vec!["crank = 200 mm".to_owned(), "crank = 250 mm".to_owned()],)
    );
    assert_eq!(values("gravity = [[0, 0, -9.81], [0, -9.81, 0],]").1[1], "gravity = [0, -9.81, 0]");
    assert_eq!(values("law = [\"a, b\", 'c']").1, ["law = \"a, b\"", "law = 'c'"]);
    assert_eq!(values("m = [2*m1, 1 kg]").1, ["m = 2*m1", "m = 1 kg"]);
}

#[test]
fn sampled_intervals_reach_all_values() {
    let sampled = Variation::parse("mu = 0.1..0.3").unwrap();
    assert_eq!(sampled.count(), None);
    assert!(matches!(sampled.values, Values::Range { count: None, .. }));
    assert_eq!(sampled.within(0.0), Setting::Number(0.1));
    assert_eq!(sampled.within(0.5), Setting::Number(0.2));
    let list = Variation::parse("a = [1, 2, 3]").unwrap();
    let at = [0.0, 0.33, 0.34, 0.67, 0.999].map(|part| list.within(part));
    assert_eq!(at, [1.0, 1.0, 2.0, 3.0, 3.0].map(Setting::Number));
}

#[test]
fn defects_have_places() {
    let mut all = String::new();
    for text in [
        "",
        "mu",
        " = 1..2 in 3",
        "mu = 0.2",
        "mu = ",
        "mu = 1..2 in 0",
        "mu = 1..2 in 3 steps",
        "mu = a..2 in 3",
        "mu = 20..40 mm in 3",
        "mu = 20 mm..4 kg in 3",
        "mu = 0..1 in 3 log",
        "mu = 1..1e400 in 3",
        "mu = [1, 2",
        "mu = [1,,2]",
        "mu = []",
        "mu = [1 mm, 2 kg]",
        "mu = [1 mm, 2]",
    ] {
        all += &format!("{}\n", Variation::parse(text).expect_err(text));
    }
    insta::assert_snapshot!(all);
}

/// Reading a draft with changes gives the same model as reading the changed text.
#[test]
fn drafts_read_as_texts_do() {
    let files = |_: &str| Err("no files".to_owned());
    for name in gallery::names() {
        let source = Source::new(format!("{name}.toml"), gallery::get(name).unwrap());
        let draft = Draft::parse(&source).unwrap();
        for changes in [
            vec![],
            vec!["gravity = [0, -1, 0]"],
            vec!["title = 'x'", "gravity = [1, 0, 'y']"],
            vec!["a"],
        ] {
            let text =
                |read: Result<stiction_format::ModelFile, stiction_format::Diagnostics>| match read
                {
                    Ok(model) => {
                        format!("{:?}", (model.title, model.mechanism, model.motions, model.loads))
                    }
                    Err(error) => error.to_string(),
                };
            let whole = read(&source.clone().with_changes(&changes), &files);
            assert_eq!(text(draft.read(&changes, &files)), text(whole), "{name} {changes:?}");
        }
    }
    let changed =
        Source::new("a.toml", gallery::get("five-bar").unwrap()).with_changes(["crank = 300 mm"]);
    let draft = Draft::parse(&changed).unwrap();
    let title = |changes: &[&str]| draft.read(changes, &files).unwrap().title;
    assert!(title(&["crank = 0.25 m"]).ends_with("with crank = 300 mm, crank = 0.25 m"));
    assert!(
        draft.check_keys(&["crank = nonsense"]).is_ok()
            && draft.check_keys(&["krank = 1"]).is_err()
    );
}
