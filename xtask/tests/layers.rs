//! Tests that the modules of every crate form layers: no module uses itself through others.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// For each module, the modules that it uses, each with the path of a file as an example.
type Uses = BTreeMap<String, BTreeMap<String, PathBuf>>;

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<_> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

/// Reads code; removes comments and the tests at its end.
fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap();
    let text = text.split("\n#[cfg(test)]\nmod tests {").next().unwrap_or("");
    text.lines().map(|line| line.split("//").next().unwrap_or("").to_owned() + "\n").collect()
}

/// Names that follow each occurrence of `prefix`; a list in braces contributes each of its names.
fn named(code: &str, prefix: &str) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    let is_letter = |c: char| c.is_alphanumeric() || c == '_';
    for (at, _) in code.match_indices(prefix) {
        if code[..at].ends_with(|c| is_letter(c) || c == ':') {
            continue;
        }
        let rest = &code[at + prefix.len()..];
        let list = match rest.strip_prefix('{') {
            Some(rest) => top_level(rest),
            None => vec![rest],
        };
        for item in list {
            let name: String = item.trim_start().chars().take_while(|c| is_letter(*c)).collect();
            names.insert(name);
        }
    }
    names
}

/// Splits a list after its opening brace into items.
fn top_level(text: &str) -> Vec<&str> {
    let (mut depth, mut start, mut items) = (0, 0, Vec::new());
    for (at, letter) in text.char_indices() {
        match letter {
            '{' => depth += 1,
            '}' if depth == 0 => {
                items.push(&text[start..at]);
                break;
            }
            '}' => depth -= 1,
            ',' if depth == 0 => {
                items.push(&text[start..at]);
                start = at + 1;
            }
            _ => {}
        }
    }
    items
}

/// Paths to the root of the crate from a file: `crate` or a `super` for each level.
fn roots(inside: &Path) -> [String; 2] {
    let is_folder = inside.file_name().is_some_and(|name| name == "mod.rs");
    let depth = inside.components().count() - usize::from(is_folder);
    ["crate::".to_owned(), "super::".repeat(depth)]
}

fn uses_of(source: &Path) -> Uses {
    let mut paths = Vec::new();
    sources(source, &mut paths);
    let is_root = |inside: &Path| inside == Path::new("lib.rs") || inside == Path::new("main.rs");
    let module = |inside: &Path| {
        let first = inside.components().next().unwrap().as_os_str().to_string_lossy();
        first.trim_end_matches(".rs").to_owned()
    };
    let insides: Vec<PathBuf> =
        paths.iter().map(|path| path.strip_prefix(source).unwrap().to_owned()).collect();
    let mut uses: Uses = insides
        .iter()
        .filter(|inside| !is_root(inside))
        .map(|inside| (module(inside), BTreeMap::new()))
        .collect();
    // A name that the root re-exports stands for its module.
    let mut re_exports = BTreeMap::new();
    for (path, inside) in paths.iter().zip(&insides).filter(|(_, inside)| is_root(inside)) {
        let code = code(path);
        for name in uses.keys() {
            for prefix in [format!("{name}::"), format!("self::{name}::")] {
                re_exports
                    .extend(named(&code, &prefix).into_iter().map(|what| (what, name.clone())));
            }
        }
        assert!(!code.is_empty(), "{}", inside.display());
    }
    for (path, inside) in paths.iter().zip(&insides).filter(|(_, inside)| !is_root(inside)) {
        if inside
            .components()
            .any(|part| part.as_os_str() == "tests" || part.as_os_str() == "tests.rs")
        {
            continue;
        }
        let (code, own) = (code(path), module(inside));
        for name in roots(inside).iter().flat_map(|root| named(&code, root)) {
            let target = if uses.contains_key(&name) { Some(&name) } else { re_exports.get(&name) };
            if let Some(target) = target.filter(|target| **target != own).cloned() {
                uses.get_mut(&own).unwrap().entry(target).or_insert_with(|| inside.clone());
            }
        }
    }
    uses
}

/// Returns a cycle of modules, if there is one.
fn cycle(uses: &Uses) -> Option<Vec<String>> {
    // Removes modules without remaining uses until none is left.
    let mut left: BTreeSet<&String> = uses.keys().collect();
    loop {
        let free: Vec<&String> = left
            .iter()
            .filter(|name| uses[**name].keys().all(|used| !left.contains(used)))
            .copied()
            .collect();
        if free.is_empty() {
            break;
        }
        free.iter().for_each(|name| {
            left.remove(name);
        });
    }
    let mut path = vec![(*left.first()?).clone()];
    loop {
        let next = uses[path.last()?].keys().find(|used| left.contains(used))?.clone();
        if let Some(begin) = path.iter().position(|name| *name == next) {
            return Some(path.split_off(begin));
        }
        path.push(next);
    }
}

#[test]
fn modules_form_layers() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let folders = ["crates", "studies"].map(|folder| fs::read_dir(root.join(folder)).unwrap());
    let entries = folders.into_iter().flatten();
    let mut entries: Vec<PathBuf> = entries.map(|e| e.unwrap().path().join("src")).collect();
    entries.sort();
    let mut edges = 0;
    for source in entries {
        let uses = uses_of(&source);
        edges += uses.values().map(BTreeMap::len).sum::<usize>();
        let Some(cycle) = cycle(&uses) else { continue };
        let mut description = String::new();
        for (from, to) in cycle.iter().zip(cycle.iter().cycle().skip(1)) {
            description +=
                &format!("\n  {from} uses {to}, for example in {}", uses[from][to].display());
        }
        panic!("modules of {} use each other in a cycle:{description}", source.display());
    }
    assert!(edges > 100, "found only {edges} uses");
}

#[test]
fn finds_cycles() {
    let uses = |list: &[(&str, &[&str])]| -> Uses {
        let used = |to: &&str| ((*to).to_owned(), PathBuf::new());
        list.iter().map(|(from, to)| ((*from).to_owned(), to.iter().map(used).collect())).collect()
    };
    let layered = uses(&[("a", &["b", "c"]), ("b", &["c"]), ("c", &[])]);
    assert_eq!(cycle(&layered), None);
    let round = uses(&[("a", &["b"]), ("b", &["c"]), ("c", &["b"]), ("d", &["a"])]);
    assert_eq!(cycle(&round).unwrap(), ["b", "c"]);

    let code =
        "use crate::one::Two;\nuse crate::{three::{self, four}, five};\nlet x = super::six();";
    let expected: BTreeSet<String> = ["one", "three", "five"].map(str::to_owned).into();
    assert_eq!(named(code, "crate::"), expected);
    assert_eq!(named(code, "super::"), BTreeSet::from(["six".to_owned()]));
    assert!(named(code, "super::super::").is_empty());
    assert_eq!(roots(Path::new("a/mod.rs")), ["crate::", "super::"]);
    assert_eq!(roots(Path::new("a/b.rs")), ["crate::", "super::super::"]);
}
