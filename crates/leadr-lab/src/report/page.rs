//! Collects the figures of the page, and the numbers that check the figures.

use serde::Serialize;

use leadr_tools::html::Html;

/// A number that checks a figure.
#[derive(Clone, Debug, Serialize)]
pub struct Check {
    figure: &'static str,
    what: String,
    value: f64,
}

/// The figures, findings and checks that are collected for the page.
#[derive(Default)]
pub struct Page {
    /// The HTML content of the page.
    pub html: Html,
    /// The conclusions, each about one figure.
    pub findings: Vec<String>,
    /// The machine-readable numbers.
    pub checks: Vec<Check>,
    figure: &'static str,
}

impl Page {
    /// Starts a figure with its heading and caption.
    pub fn begin(&mut self, figure: &'static str, line: &str) {
        self.figure = figure;
        self.html.heading(figure);
        self.html.paragraph(line);
    }

    /// Records a number that checks the figure.
    pub fn check(&mut self, what: impl Into<String>, value: f64) {
        self.checks.push(Check { figure: self.figure, what: what.into(), value });
    }

    /// Adds a conclusion about the figure.
    pub fn find(&mut self, sentence: &str) {
        self.findings.push(format!("{}: {sentence}", self.figure));
    }
}
