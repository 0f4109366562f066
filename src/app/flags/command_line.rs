//! A command line of flags that were given, to be changed and written down again.

use std::ffi::{OsStr, OsString};
use std::fmt;

use clap::parser::ValueSource;
use clap::{ArgMatches, Args, Command};

/// Flags and their values, in order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CommandLine {
    flags: Vec<(String, Option<OsString>)>,
}

impl CommandLine {
    /// The flags among those of `A` that the user gave.
    #[must_use]
    pub fn given<A: Args>(matches: &ArgMatches) -> Self {
        let mut line = Self::default();
        for argument in A::augment_args(Command::new("given")).get_arguments() {
            let (id, Some(long)) = (argument.get_id().as_str(), argument.get_long()) else { continue };
            if matches.value_source(id) != Some(ValueSource::CommandLine) {
                continue;
            }
            let name = format!("--{long}");
            if !argument.get_action().takes_values() {
                line.flags.push((name, None));
                continue;
            }
            for occurrence in matches.get_raw_occurrences(id).into_iter().flatten() {
                let values: Vec<&OsStr> = occurrence.collect();
                line.flags.push((name.clone(), Some(values.join(OsStr::new(",")))));
            }
        }
        line
    }

    /// Says a flag anew, or no longer.
    pub fn set(&mut self, name: &str, value: Option<impl Into<OsString>>) {
        self.remove(name);
        if let Some(value) = value {
            self.flags.push((name.to_owned(), Some(value.into())));
        }
    }

    /// The value of a flag, if it is said and has one.
    pub fn value(&self, name: &str) -> Option<&OsStr> {
        self.flags.iter().find(|(known, _)| known == name)?.1.as_deref()
    }

    /// Says a flag no longer.
    pub fn remove(&mut self, name: &str) {
        self.flags.retain(|(known, _)| known != name);
    }

    /// Says a flag before all others.
    pub fn begin_with(&mut self, name: &str, value: impl Into<OsString>) {
        self.flags.insert(0, (name.to_owned(), Some(value.into())));
    }
}

impl fmt::Display for CommandLine {
    /// As a shell takes it, with a space before each flag.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (name, value) in &self.flags {
            write!(f, " {name}")?;
            let Some(value) = value.as_ref().map(|value| value.to_string_lossy()) else { continue };
            // A value that begins with a minus sign could be taken for a flag.
            let joint = if value.starts_with('-') { "=" } else { " " };
            let plain = |c: char| c.is_ascii_alphanumeric() || "-_.,:/+=@%".contains(c);
            if !value.is_empty() && value.chars().all(plain) {
                write!(f, "{joint}{value}")?;
            } else {
                write!(f, "{joint}'{}'", value.replace('\'', r"'\''"))?;
            }
        }
        Ok(())
    }
}
