//! `leadr completions` and `leadr man`: files that a package installs beside the program.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use clap::{Arg, Args};
use clap_complete::{Shell, generate};

use leadr_maps::new_file::write_atomic;
use leadr_scenes::registry::SCENES;
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
pub fn completions(command: clap::Command, arguments: &CompletionsArgs) -> Result<(), AppError> {
    let mut script = Vec::new();
    let mut command = command.mut_subcommands(|command| command.mut_args(with_words));
    generate(arguments.shell, &mut command, "leadr", &mut script);
    let script = with_files(arguments.shell, &String::from_utf8_lossy(&script));
    // A reader that closes the pipe early has all that it wants.
    let _ = io::stdout().write_all(script.as_bytes());
    Ok(())
}

/// Stands for all files among the words that complete a value.
const FILES: &str = "FILE";

/// Lets a flag complete the words in the name of its value, such as `sky` and `studio` of `sky|studio|FILE.hdr`, and the names of scenes.
fn with_words(flag: Arg) -> Arg {
    let Some([forms]) = flag.get_value_names().filter(|_| flag.get_possible_values().is_empty()) else { return flag };
    let forms = forms.to_string();
    // A colon ends the name of a value in the script of zsh, which alone prints the name.
    let flag = flag.value_name(forms.replace(':', "\\:"));
    let is_word = |form: &&str| form.chars().all(|c| c.is_ascii_lowercase() || c == '-');
    let (mut words, others): (Vec<&str>, Vec<&str>) = forms.split('|').partition(is_word);
    if flag.get_long() == Some("scene") {
        words.extend(SCENES.iter().map(|scene| scene.name));
    }
    if others.iter().any(|form| form.starts_with(FILES)) {
        words.push(FILES);
    } else if !others.is_empty() {
        return flag;
    }
    if words == [FILES] {
        return flag;
    }
    let words: Vec<String> = words.into_iter().map(str::to_owned).collect();
    flag.value_parser(PossibleValuesParser::new(words))
}

/// Replaces the word [`FILES`] in a completion script by the files of the shell.
fn with_files(shell: Shell, script: &str) -> String {
    let (last, open, files, close) = match shell {
        Shell::Bash => (" FILE\" -- \"${cur}\"))", "", "", "\" -- \"${cur}\") $(compgen -f -- \"${cur}\"))"),
        Shell::Zsh => (" FILE)' \\", ":(", ":{compadd - ", "; _files}' \\"),
        Shell::Fish => ("\nFILE\\t''\"", " -r -f -a ", " -r -a ", "\""),
        // The scripts of other shells complete no values.
        _ => return script.to_owned(),
    };
    let mut parts: Vec<String> = script.split(last).map(str::to_owned).collect();
    let ends = parts.len() - 1;
    for part in parts.iter_mut().take(ends) {
        // The list of words begins at the last `open`.
        if let Some(start) = part.rfind(open).filter(|_| !open.is_empty()) {
            part.replace_range(start..start + open.len(), files);
        }
    }
    parts.join(close)
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
