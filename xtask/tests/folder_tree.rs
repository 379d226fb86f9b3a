//! Tests that every file and folder in the folder tree of `ARCHITECTURE.md` exists.

use std::fs;
use std::path::{Path, PathBuf};

/// Column at which the descriptions begin.
const DESCRIPTIONS: usize = 30;

/// Finds an entry in a folder, or in its folder `src`.
fn found(folder: &Path, name: &str) -> Option<PathBuf> {
    [folder.join(name), folder.join("src").join(name)].into_iter().find(|path| path.exists())
}

#[test]
fn the_folder_tree_lists_what_exists() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let text = fs::read_to_string(root.join("ARCHITECTURE.md")).unwrap();
    let (_, tree) = text.split_once("## Folder tree\n\n```text\n").unwrap();
    let (tree, _) = tree.split_once("```").unwrap();
    // Folders around the present line, each with its indentation.
    let mut around: Vec<(usize, PathBuf)> = Vec::new();
    let mut count = 0;
    for line in tree.lines() {
        let indent = line.len() - line.trim_start().len();
        // Long descriptions continue on the next line.
        if indent >= DESCRIPTIONS {
            continue;
        }
        let names = line.trim_start().split("  ").next().unwrap();
        around.retain(|(outer, _)| *outer < indent);
        let folder = around.last().map_or_else(|| root.to_path_buf(), |(_, folder)| folder.clone());
        for name in names.split(", ") {
            let path = found(&folder, name);
            around.push((
                indent,
                path.unwrap_or_else(|| panic!("no {name} in {}", folder.display())),
            ));
            count += 1;
        }
    }
    assert!(count > 200, "{count}");
}
