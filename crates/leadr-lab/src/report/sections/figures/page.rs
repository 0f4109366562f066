//! What the figures have put on the page so far, and the numbers that check them.

use serde::Serialize;

use leadr_tools::html::Html;

/// A number that checks a figure.
#[derive(Clone, Debug, Serialize)]
pub struct Check {
    figure: &'static str,
    what: String,
    value: f64,
}

/// The figures so far.
#[derive(Default)]
pub struct Page {
    /// For people.
    pub html: Html,
    /// Conclusions, each of one figure.
    pub findings: Vec<String>,
    /// For programs.
    pub checks: Vec<Check>,
    figure: &'static str,
}

impl Page {
    /// Begins a figure: its heading and the line that says what it shows.
    pub fn begin(&mut self, figure: &'static str, line: &str) {
        self.figure = figure;
        self.html.heading(figure);
        self.html.paragraph(line);
    }

    /// Notes a number of the figure.
    pub fn check(&mut self, what: impl Into<String>, value: f64) {
        self.checks.push(Check { figure: self.figure, what: what.into(), value });
    }

    /// States what the numbers of the figure say.
    pub fn find(&mut self, sentence: &str) {
        self.findings.push(format!("{}: {sentence}", self.figure));
    }
}
