//! Writes the playground: `playground-pages ENGINE FOLDER`, with the compiled module and the folder.
//!
//! The folder receives `index.html` with the module as a separate file, for any web server, and
//! `stiction-playground.html`, which contains the module and can be opened as a file.

use std::env::args_os;
use std::fs::{copy, create_dir_all, read, write};
use std::io;
use std::path::Path;
use std::process::ExitCode;
use stiction_playground::{ENGINE, Engine, page};

fn main() -> ExitCode {
    let arguments: Vec<_> = args_os().skip(1).collect();
    let [engine, folder] = arguments.as_slice() else {
        eprintln!("usage: playground-pages ENGINE FOLDER");
        return ExitCode::from(2);
    };
    match build(Path::new(engine), Path::new(folder)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {}: {error}", Path::new(folder).display());
            ExitCode::FAILURE
        }
    }
}

fn build(engine: &Path, folder: &Path) -> io::Result<()> {
    create_dir_all(folder)?;
    copy(engine, folder.join(ENGINE))?;
    write(folder.join("index.html"), page(Engine::Beside)?)?;
    write(folder.join("stiction-playground.html"), page(Engine::Inside(&read(engine)?))?)
}
