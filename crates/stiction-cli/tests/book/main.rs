//! Tests of the book: the program accepts the files on its pages, the commands print what the pages
//! show, the pictures are those of the program, the links have targets, and the tests that the
//! theory names exist.
//!
//! A fenced block `toml` whose first line is `# NAME.toml`, or `xml` after `<!-- NAME.xml -->`, is
//! a file. A block `console` contains commands after `$ ` and their output (standard output, then
//! standard error). In the output, a line `...` matches any lines and `[..]` any characters.
//! `console exit=N` states the exit code of the last command. A line `<!-- picture NAME.svg: FILE
//! -->` compares a picture with a file that the commands wrote; `<!-- picture NAME.svg: error of
//! JOINT in FILE, FILE -->` draws the tracking errors of simulations. `cargo xtask book` updates
//! the generated parts: the reference of the model file and the pictures.

mod links;
mod pages;
mod pictures;
#[path = "../suite/program/mod.rs"]
mod program;
mod reference;
mod theory;

use std::fs;
use std::panic::catch_unwind;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::thread;

/// Folder of the pages.
fn book() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/src")
}

/// All pages, by name.
fn pages() -> Vec<PathBuf> {
    let files = fs::read_dir(book()).unwrap().map(|entry| entry.unwrap().path());
    let mut pages: Vec<_> =
        files.filter(|path| path.extension().is_some_and(|ending| ending == "md")).collect();
    pages.sort();
    assert!(pages.len() > 5, "the book has pages");
    pages
}

/// Returns `true` if the generated parts are to be written instead of compared.
fn renewed() -> bool {
    std::env::var_os("STICTION_BOOK").is_some_and(|word| word == "renew")
}

#[test]
fn pages_show_the_output_of_their_commands() {
    let pages = pages();
    let (next, commands) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let wrong = Mutex::new(Vec::new());
    // A failing page does not prevent tests of the other pages.
    let work = || {
        while let Some(page) = pages.get(next.fetch_add(1, Relaxed)) {
            match catch_unwind(|| pages::carry_out(page)) {
                Ok(count) => {
                    commands.fetch_add(count, Relaxed);
                }
                Err(_) => wrong.lock().unwrap().push(page),
            }
        }
    };
    thread::scope(|scope| {
        for _ in 0..thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(work);
        }
    });
    let wrong = wrong.into_inner().unwrap();
    assert!(wrong.is_empty(), "{wrong:?}, as said above");
    assert!(commands.into_inner() > 5, "the tutorial runs commands");
    pages.iter().for_each(|page| pages::accepted(page));
}

/// The commands of the README print the output that it shows.
#[test]
fn the_readme_shows_the_output_of_its_commands() {
    let readme = book().join("../../README.md");
    assert!(pages::carry_out(&readme) >= 3);
    pages::accepted(&readme);
}
