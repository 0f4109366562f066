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
pub fn man(command: clap::Command, arguments: &ManArgs) -> Result<(), AppError> {
    // The command `help` has no page.
    let mut command = command.disable_help_subcommand(true);
    command.build();
    let name = command.get_name().to_owned();
    let pages = command.get_subcommands().filter(|command| !command.is_hide_set());
    let pages = pages.map(|page| (format!("{name}-{}", page.get_name()), page.clone()));
    for (title, page) in pages.chain([(name.clone(), command.clone())]) {
        let file = arguments.folder.join(format!("{title}.1"));
        let text = page_text(page, title).map_err(|fault| AppError::io("write", &file, fault))?;
        write_atomic(&file, text.as_bytes())?;
    }
    Ok(())
}

/// Returns the manual page of a command: the long help of every flag, and the synopsis and the version in their short forms.
fn page_text(mut page: clap::Command, title: String) -> io::Result<String> {
    let usage = page.render_usage().to_string();
    let page = page.override_usage(usage.trim_start_matches("Usage: ").to_owned()).long_version(None);
    // clap_mangen leaves out the text of flags that the short help hides.
    let page = page.mut_args(|flag| flag.hide_short_help(false)).name(title.clone());
    let mut text = Vec::new();
    clap_mangen::Man::new(page).title(title).render(&mut text)?;
    // In roff, lines flow into one paragraph unless a request breaks them.
    Ok(String::from_utf8_lossy(&text).replace("\n\\- ", "\n.br\n\\- "))
}
