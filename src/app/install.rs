//! `leadr completions` and `leadr man`: files that a package installs beside the program.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::Args;
use clap_complete::{Shell, generate};

use leadr_maps::new_file::write_atomic;
use leadr_tools::command::error::AppError;

/// Arguments of `leadr completions`.
#[derive(Clone, Debug, Args)]
pub struct CompletionsArgs {
    /// The shell that reads the script
    pub shell: Shell,
}

/// Arguments of `leadr man`.
#[derive(Clone, Debug, Args)]
pub struct ManArgs {
    /// The folder for the pages, one per command
    #[arg(value_name = "FOLDER")]
    pub folder: PathBuf,
}

/// Prints the completion script of a shell.
pub fn completions(mut command: clap::Command, arguments: &CompletionsArgs) -> Result<(), AppError> {
    let mut script = Vec::new();
    generate(arguments.shell, &mut command, "leadr", &mut script);
    // A reader that closes the pipe early has all that it wants.
    let _ = io::stdout().write_all(&script);
    Ok(())
}

/// Writes the manual pages of all commands.
pub fn man(mut command: clap::Command, arguments: &ManArgs) -> Result<(), AppError> {
    command.build();
    let name = command.get_name().to_owned();
    let pages = command.get_subcommands().filter(|command| !command.is_hide_set() && command.get_name() != "help");
    let pages = pages.map(|page| (format!("{name}-{}", page.get_name()), page.clone()));
    for (title, page) in pages.chain([(name.clone(), command.clone())]) {
        let file = arguments.folder.join(format!("{title}.1"));
        let mut text = Vec::new();
        let page = clap_mangen::Man::new(page.name(title.clone())).title(title);
        page.render(&mut text).map_err(|fault| AppError::io("write", &file, fault))?;
        write_atomic(&file, &text)?;
    }
    Ok(())
}
