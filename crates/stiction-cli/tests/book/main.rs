//! The book's pages are true: their files are accepted, their commands say what is printed, their
//! pictures show what the program writes, their links lead somewhere, and the tests that the theory
//! names are there.
//!
//! A fenced block `toml` whose first line is `# NAME.toml` is a file; a block `console` holds
//! commands after `$ ` and what they say (standard output, then standard error). There, a line `...`
//! stands for any lines and `[..]` for any characters. `console exit=N` is how the last one ends.
//! A line `<!-- picture NAME.svg: FILE -->` says which file of those commands a picture is;
//! `<!-- picture NAME.svg: error of JOINT in FILE, FILE -->` draws how far simulations are from what
//! is wanted. `cargo xtask book` writes anew what is generated: the reference of the model file and
//! the pictures.

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

/// The folder with the pages.
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

/// Whether what is generated is to be written.
fn renewed() -> bool {
    std::env::var_os("STICTION_BOOK").is_some_and(|word| word == "renew")
}

#[test]
fn every_page_is_true() {
    let pages = pages();
    let (next, commands) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let wrong = Mutex::new(Vec::new());
    // A page that is not true does not keep the others from being read.
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

/// The output that the front page shows is that of the program without arguments.
#[test]
fn the_front_page_is_true() {
    let text = fs::read_to_string(book().join("../../README.md")).unwrap();
    assert!(
        pages::shows_output(&text, "zhang2018-regular"),
        "README.md: `stiction` says otherwise"
    );
}
