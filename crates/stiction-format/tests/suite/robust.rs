//! No input causes a panic or an endless computation in the reader.

use proptest::prelude::*;
use std::time::{Duration, Instant};
use stiction_format::{Diagnostics, ModelFile, Source, gallery, read};

/// Reads a text and renders any messages in all formats.
fn attempt(text: &str) -> Result<ModelFile, Diagnostics> {
    let files = |_: &str| Ok("time, A\n0, 1\n1, 2\n".into());
    let result = read(&Source::new("model.toml", text), &files);
    let diagnostics = match &result {
        Ok(model) => &model.warnings,
        Err(diagnostics) => {
            assert!(diagnostics.has_errors());
            diagnostics
        }
    };
    let plain = diagnostics.render(false);
    assert!(diagnostics.is_empty() || !plain.is_empty());
    let _ = diagnostics.render(true);
    let _ = diagnostics.to_json();
    result
}

/// CPU time of this thread, so that other programs do not count (Linux).
fn busy(since: Instant) -> Duration {
    let own = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = own.and_then(|text| text.split(' ').next()?.parse().ok());
    nanoseconds.map_or_else(|| since.elapsed(), Duration::from_nanos)
}

fn takes_less_than(limit: Duration, text: &str) {
    let start = Instant::now();
    let before = busy(start);
    let _ = attempt(text);
    let time = busy(start).saturating_sub(before);
    assert!(time < limit, "{time:?} for {} bytes", text.len());
}

#[test]
fn odd_texts() {
    let deep_table = format!("[{}]\nx = 1", vec!["a"; 60].join("."));
    let deep_list = format!("x = {}1{}", "[".repeat(5000), "]".repeat(5000));
    let open_lists = format!("x = {}", "[".repeat(5000));
    let deep_inline = format!("x = {}1{}", "{a = ".repeat(5000), "}".repeat(5000));
    let inner = format!("{{{} = ", vec!["a"; 70].join("."));
    let deepest = format!("x = {}1{}", inner.repeat(70), "}".repeat(70));
    for text in [
        "",
        "\u{feff}",
        "\0",
        "\r",
        "\n\n\n",
        "PK\u{3}\u{4}\u{14}\u{0}binary",
        "\u{1b}[31m = 1",
        "[",
        "]",
        "[[",
        "=",
        "\"",
        "'''",
        "gravity = [0, 0, nan]",
        "gravity = [0, 0, inf]\nbodies = 3\njoints = []\nlegs = 1\nmotions = \"x\"\ndefault = [1]",
        "gravity = [1e308, 1e308, 1e308]\n[bodies.a]\nmass = 1e308\ncom = [1e308, 0, 0]\ninertia = [1e308, 1e308, 1e308]\n[joints.A]\ntype = \"R\"\nfrom = \"ground\"\nto = \"a\"\naxis = [1e308, 1e308, 1e308]\nat = [1e308, 1e308, 1e308]",
        "gravity = 1979-05-27",
        "[bodies]\na = 1\nb = []\n[joints]\nA = 1\n[legs]\nchain = 3\nangles = 3\nplace = 3",
        "[a]\n[a.b]\n[a]\n[[a]]\n[a.b.c]\na.b = 1",
        "[[a]]\n[a]\n[[a.b]]\n[a.b]\n[[a.b.c]]",
        "x = {a = 1, a = 2}\nx.b = 3\n[x.c]",
        deep_table.as_str(),
        deep_list.as_str(),
        open_lists.as_str(),
        deep_inline.as_str(),
        deepest.as_str(),
    ] {
        let result = attempt(text);
        assert!(result.is_err() || text.contains("1e308"), "{}", &text[..text.len().min(50)]);
    }
}

/// A byte order mark and other line ends do not change a model.
#[test]
fn line_ends_do_not_matter() {
    for name in gallery::names() {
        let text = gallery::get(name).unwrap();
        let plain = attempt(text).unwrap();
        let other = attempt(&format!("\u{feff}{}", text.replace('\n', "\r\n"))).unwrap();
        assert_eq!(plain.mechanism, other.mechanism);
        assert_eq!(
            plain.source.lines().collect::<Vec<_>>(),
            other.source.lines().collect::<Vec<_>>()
        );
        let windows =
            format!("\u{feff}{}", text.replace("mass =", "masss =").replace('\n', "\r\n"));
        let unix = text.replace("mass =", "masss =");
        let (windows, unix) = (attempt(&windows).unwrap_err(), attempt(&unix).unwrap_err());
        assert_eq!(windows.to_string(), unix.to_string());
    }
}

/// The time is proportional to the size of the text; the limits are a hundred times the expected
/// time.
#[test]
fn large_texts_are_read_or_refused_quickly() {
    let second = Duration::from_secs(10);
    takes_less_than(second, &"x".repeat(100 << 20));
    takes_less_than(second, &"=\n".repeat(1 << 18));
    takes_less_than(second, &"[[[[[[[[\n".repeat(200_000));
    takes_less_than(second, &format!("x = {}", "1,".repeat(1 << 20)));
    let many = |line: &dyn Fn(usize) -> String| (0..30_000).map(line).collect::<String>();
    takes_less_than(second, &many(&|i| format!("unknown_key_{i} = {i}\n")));
    takes_less_than(
        second,
        &format!("[parameters]\n{}", many(&|i| format!("p{i} = \"p{} + qq{i}\"\n", i + 1))),
    );
    takes_less_than(
        second,
        &format!("[parameters]\n{}p30000 = 1", many(&|i| format!("p{i} = \"p{}\"\n", i + 1))),
    );
    takes_less_than(
        second,
        &format!("[parameters]\n{}", many(&|i| format!("p{i} = \"p{}\"\n", (i + 1) % 30_000))),
    );
    let joints = many(&|i| {
        format!(
            "[bodies.b{i}]\n[joints.j{i}]\ntype=\"R\"\nfrom=\"nobody{i}\"\nto=\"c{i}\"\naxis=\"z\"\n"
        )
    });
    takes_less_than(3 * second, &joints[..(2 << 20) - 1000]);
    takes_less_than(
        second,
        &format!("[motions.m]\n{}", many(&|i| format!("body{i}.x = \"tt{i}\"\n"))),
    );
    takes_less_than(second, &format!("x = \"{}\"", "1 + ".repeat(400_000)));
    takes_less_than(second, &format!("gravity = [\"{}1\", 0, 0]", "1 + ".repeat(400_000)));
}

/// Deeply nested expressions are read or refused on a stack of two megabytes, the default of
/// threads.
#[test]
fn deep_expressions() {
    let deep = |open: &str, close: &str| {
        [200, 30_000].map(|n| format!("{}1{}", open.repeat(n), close.repeat(n)))
    };
    let robot = attempt(gallery::get("3rps").unwrap()).unwrap();
    let none = |_: &str| Err("none".to_owned());
    for (open, close) in [
        ("(", ")"),
        ("-", ""),
        ("sin(", ")"),
        ("2^", ""),
        ("1/", ""),
        ("max(1, ", ")"),
        ("(", ""),
        ("", ")"),
        ("[", "]"),
        ("1 m^", ""),
        ("+(-", ")"),
        ("", " m"),
        ("", "*m"),
        ("", "^2"),
    ] {
        for text in deep(open, close) {
            takes_less_than(Duration::from_secs(10), &format!("gravity = [\"{text}\", 0, 0]"));
            takes_less_than(Duration::from_secs(10), &format!("[parameters]\na = \"{text}\""));
            for given in [format!("platform.z = {text}"), format!("platform.z = 1 {text}")] {
                let given = Source::new("--motion", given);
                match robot.parse_motion(&given, &none) {
                    Ok(motion) => motion.at(0.3).for_each(|target| {
                        assert!(!target.value.is_nan(), "{open}1{close}");
                    }),
                    Err(diagnostics) => assert!(!diagnostics.to_string().is_empty()),
                }
            }
            let head = format!("time [{text}], platform.z [{text}], d({text})\n0,1,2\n1,2,3\n");
            let _ = robot.read_motion(&Source::new("motion.csv", head), &none);
        }
    }
}

/// The number of legs cannot be a parameter, so that a short file describes a small robot.
/// Parameters that are used many times are evaluated once.
#[test]
fn short_texts_make_small_models() {
    let doubling: String =
        (1..200).map(|k| format!("p{k} = \"p{} + p{}\"\n", k - 1, k - 1)).collect();
    takes_less_than(Duration::from_secs(10), &format!("[parameters]\np0 = 1e-30\n{doubling}"));
    let legs = "[legs]\nchain = \"R P* S\"\nto = \"a\"\nangles = 1000000000\n";
    takes_less_than(Duration::from_secs(10), legs);
    let long = format!("[legs]\nchain = \"{}\"\nto = \"a\"\nangles = [0]\n", "R ".repeat(20_000));
    takes_less_than(Duration::from_secs(20), &long);
    let repeated = format!("{}{}{}", long, "[bodies.a]\n", "[joints.A]\n");
    takes_less_than(Duration::from_secs(20), &repeated);
}

fn mutated(text: &str, edits: &[(usize, usize, String)]) -> String {
    let mut text = text.to_owned();
    for (at, length, new) in edits {
        let boundary = |text: &str, at: usize| {
            let mut at = at % (text.len() + 1);
            while !text.is_char_boundary(at) {
                at -= 1;
            }
            at
        };
        let from = boundary(&text, *at);
        let to = boundary(&text, (from + length).min(text.len())).max(from);
        text.replace_range(from..to, new);
    }
    text
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn random_bytes(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let _ = attempt(&String::from_utf8_lossy(&bytes));
    }

    /// Random sequences of words of the format.
    #[test]
    fn random_words(words in prop::collection::vec(prop::sample::select(vec![
        "[", "]", "[[", "]]", "{", "}", "=", ".", ",", "\"", "'", "\n", "\n", "\n", " ", "#",
        "bodies", "joints", "legs", "motions", "loads", "default", "parameters", "a", "b", "A",
        "mass", "com", "inertia", "type", "from", "to", "axis", "friction", "mu", "chain", "place",
        "angles", "1", "0.5", "\"1 mm\"", "\"R\"", "\"ground\"", "\"R a S\"", "nan", "x", "rx", "order",
        "\"\"\"", "\\", "é", "true",
    ]), 0..60)) {
        let _ = attempt(&words.concat());
    }

    /// A valid file in which a few characters are changed, removed or inserted.
    #[test]
    fn damaged_models(
        model in prop::sample::select(gallery::names().collect::<Vec<_>>()),
        edits in prop::collection::vec((any::<usize>(), 0..12usize, prop::sample::select(vec![
            "", "\"", "[", "]", "{", "}", "=", "\n", "0", "-", "x", ".", "*", "é", "(", ")", "1e999", "t",
            "#", "\r", "\\", "[[", "a.b", "nan",
        ]).prop_map(str::to_owned)), 1..6),
    ) {
        let _ = attempt(&mutated(gallery::get(model).unwrap(), &edits));
    }

    /// Random assignments and recordings.
    #[test]
    fn damaged_motions(
        text in "[A-Za-z0-9.;=,\\[\\]()\"'* \n#-]{0,60}",
        edits in prop::collection::vec((any::<usize>(), 0..6usize, "[a-z0-9,;=.()\\[\\]\n]{0,4}"), 0..4),
    ) {
        let model = attempt(gallery::get("3rps").unwrap()).unwrap();
        let none = |_: &str| Err("none".to_owned());
        let line = "platform.z = 0.55 + 1 mm*sin(t); leg1.P = 0.6; duration = 2 s";
        let table = "time [s], platform.z [mm], d(platform.z) [mm/s], leg1.P\n0,1,2,3\n1,2,3,4\n2,3,4,5\n";
        for text in [text.clone(), mutated(line, &edits)] {
            let given = Source::new("--motion", text);
            let motion = model.parse_motion(&given, &none).err();
            let load = model.parse_load(&given, &none).err();
            for diagnostics in motion.into_iter().chain(load) {
                prop_assert!(!diagnostics.to_string().is_empty());
            }
        }
        for text in [text, mutated(table, &edits)] {
            match model.read_motion(&Source::new("motion.csv", text), &none) {
                Ok(motion) => {
                    let t = motion.start + 0.3 * motion.duration;
                    prop_assert!(motion.at(t).all(|target| target.value.is_finite()));
                }
                Err(diagnostics) => prop_assert!(!diagnostics.to_string().is_empty()),
            }
        }
    }
}
