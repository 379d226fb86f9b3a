//! `stiction completions` and `stiction man`: completion scripts and manual page.

use crate::arguments::Arguments;
use crate::failure::Failure;
use crate::print;
use clap::CommandFactory;

pub(crate) fn completions(shell: clap_complete::Shell) -> Result<(), Failure> {
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut Arguments::command(), "stiction", &mut text);
    print(&String::from_utf8_lossy(&text))
}

/// Prints a single manual page with all commands.
pub(crate) fn manual() -> Result<(), Failure> {
    let mut page = Vec::new();
    let failure = |error: std::io::Error| Failure::input(format!("cannot write the page: {error}"));
    clap_mangen::Man::new(Arguments::command()).render(&mut page).map_err(failure)?;
    let mut program = Arguments::command();
    program.build();
    for command in program.get_subcommands().filter(|command| command.get_name() != "help") {
        let man = clap_mangen::Man::new(command.clone());
        let mut text: Vec<u8> = Vec::new();
        man.render_synopsis_section(&mut text).map_err(failure)?;
        man.render_options_section(&mut text).map_err(failure)?;
        page.extend_from_slice(&text);
    }
    print(&String::from_utf8_lossy(&page))
}
