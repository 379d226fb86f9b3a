//! Program that writes the pages of the playground: `playground-pages ENGINE FOLDER [SHADED]`.
//! ENGINE is the compiled WebAssembly module, FOLDER the output folder, and SHADED the script of
//! the shaded view that the module contains.
//!
//! The program writes two pages: `index.html`, with the module as a separate file, for any web
//! server; and `stiction-playground.html`, which contains the module and can be opened as a file.

use std::env::args_os;
use std::fs::{copy, create_dir_all, read, read_to_string, write};
use std::io;
use std::path::Path;
use std::process::ExitCode;
use stiction_playground::{ENGINE, Engine, page};

fn main() -> ExitCode {
    let arguments: Vec<_> = args_os().skip(1).collect();
    let (engine, folder, shaded) = match arguments.as_slice() {
        [engine, folder] => (engine, folder, None),
        [engine, folder, shaded] => (engine, folder, Some(Path::new(shaded))),
        _ => {
            eprintln!("usage: playground-pages ENGINE FOLDER [SHADED]");
            return ExitCode::from(2);
        }
    };
    match build(Path::new(engine), Path::new(folder), shaded) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {}: {error}", Path::new(folder).display());
            ExitCode::FAILURE
        }
    }
}

fn build(engine: &Path, folder: &Path, shaded: Option<&Path>) -> io::Result<()> {
    let shaded = shaded.map_or(Ok(String::new()), read_to_string)?;
    create_dir_all(folder)?;
    copy(engine, folder.join(ENGINE))?;
    write(folder.join("index.html"), page(Engine::Beside, &shaded)?)?;
    write(folder.join("stiction-playground.html"), page(Engine::Inside(&read(engine)?), &shaded)?)
}
