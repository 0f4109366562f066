//! Fragments of the page. A fragment is markup that cannot contain unescaped text.

use std::fmt::Write;

use serde::{Deserialize, Serialize};

use super::plot::Plot;
use super::table::{Cell, Figure, Table};
use super::text::{address, escape, number};

/// A fragment of a page.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Html(String);

impl Html {
    /// Creates an empty fragment.
    pub fn new() -> Self {
        Self::default()
    }

    /// Returns the markup.
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// Adds a heading inside a section.
    pub fn heading(&mut self, text: &str) {
        let _ = writeln!(self.0, "<h3>{}</h3>", escape(text));
    }

    /// Adds a paragraph.
    pub fn paragraph(&mut self, text: &str) {
        let _ = writeln!(self.0, "<p>{}</p>", escape(text));
    }

    /// Adds a list of conclusions from the data.
    pub fn findings(&mut self, lines: &[String]) {
        if lines.is_empty() {
            return;
        }
        self.0.push_str("<ul class=\"findings\">\n");
        for line in lines {
            let _ = writeln!(self.0, "<li>{}</li>", escape(line));
        }
        self.0.push_str("</ul>\n");
    }

    /// Adds a table. Empty tables are skipped.
    pub fn table(&mut self, table: &Table) {
        if table.rows.is_empty() {
            return;
        }
        let pictures = table.rows.iter().flatten().any(|cell| matches!(cell, Cell::Figure(_)));
        let class = if pictures { "pictures" } else { "numbers" };
        let _ = writeln!(self.0, "<div class=\"scroll\"><table class=\"{class}\">");
        let _ = writeln!(self.0, "<caption>{}</caption>\n<thead><tr>", escape(&table.caption));
        for (column, head) in table.head.iter().enumerate() {
            let number = |row: &Vec<Cell>| matches!(row.get(column), Some(Cell::Number(_)));
            let class = if table.rows.iter().any(number) { " class=\"n\"" } else { "" };
            let _ = write!(self.0, "<th scope=\"col\"{class}>{}</th>", escape(head));
        }
        self.0.push_str("</tr></thead>\n<tbody>\n");
        for row in &table.rows {
            self.0.push_str("<tr>");
            for (column, cell) in row.iter().enumerate() {
                self.cell(cell, column == 0);
            }
            self.0.push_str("</tr>\n");
        }
        self.0.push_str("</tbody></table></div>\n");
    }

    fn cell(&mut self, cell: &Cell, head: bool) {
        let (open, close) = if head { ("<th scope=\"row\"", "</th>") } else { ("<td", "</td>") };
        let (class, content) = match cell {
            Cell::Text(text) => ("", escape(text)),
            Cell::Number(value) => (" class=\"n\"", number(*value)),
            Cell::Figure(figure) => ("", figure_markup(figure)),
            Cell::Section(name) => ("", format!("<a href=\"#{0}\">{0}</a>", escape(name))),
        };
        let _ = write!(self.0, "{open}{class}>{content}{close}");
    }

    /// Adds pictures side by side.
    pub fn figures(&mut self, figures: &[Figure]) {
        self.0.push_str("<div class=\"row\">\n");
        for figure in figures {
            let _ = writeln!(self.0, "{}", figure_markup(figure));
        }
        self.0.push_str("</div>\n");
    }

    /// Adds a plot.
    pub fn plot(&mut self, plot: &Plot) {
        let _ = writeln!(self.0, "<figure class=\"plot\">{}</figure>", plot.svg());
    }

    /// Adds `inside` as a collapsed block that opens with a click on the line `summary`.
    pub fn details(&mut self, summary: &str, inside: &Self) {
        let _ = writeln!(self.0, "<details><summary>{}</summary>\n{}</details>", escape(summary), inside.0);
    }

    /// Appends another fragment.
    pub fn append(&mut self, other: &Self) {
        self.0.push_str(&other.0);
    }
}

fn figure_markup(figure: &Figure) -> String {
    let (width, height) = (figure.width * figure.scale, figure.height * figure.scale);
    let (file, alt) = (address(figure.file.as_bytes()), escape(&figure.alt));
    let caption: Vec<String> = figure.caption.iter().map(|line| escape(line)).collect();
    format!(
        "<figure><a href=\"{file}\"><img src=\"{file}\" alt=\"{alt}\" width=\"{width}\" height=\"{height}\" \
         loading=\"lazy\"/></a><figcaption>{}</figcaption></figure>",
        caption.join("<br/>")
    )
}
