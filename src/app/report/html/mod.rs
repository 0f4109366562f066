//! The page: fragments of HTML that cannot hold unescaped text, tables, figures, and the frame around the sections.
//!
//! Everything is written as well-formed XML too (every element closed), which is what the tests check.

mod page;
mod table;
mod text;

use std::fmt::Write;

use serde::{Deserialize, Serialize};

use super::plot::Plot;

pub use page::{PageSection, page};
pub use table::{Cell, Figure, Table};
pub use text::{escape, number, percent};

/// A fragment of a page.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Html(String);

impl Html {
    /// Nothing yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The markup.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// A heading inside a section.
    pub fn heading(&mut self, text: &str) {
        let _ = writeln!(self.0, "<h3>{}</h3>", escape(text));
    }

    /// A paragraph.
    pub fn paragraph(&mut self, text: &str) {
        let _ = writeln!(self.0, "<p>{}</p>", escape(text));
    }

    /// What was found: conclusions that the data made.
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

    /// A table; empty ones are left out.
    pub fn table(&mut self, table: &Table) {
        if table.rows.is_empty() {
            return;
        }
        let pictures = table.rows.iter().flatten().any(|cell| matches!(cell, Cell::Figure(_)));
        let class = if pictures { "pictures" } else { "numbers" };
        let _ = writeln!(self.0, "<div class=\"scroll\"><table class=\"{class}\">");
        let _ = writeln!(self.0, "<caption>{}</caption>\n<thead><tr>", escape(&table.caption));
        for (column, head) in table.head.iter().enumerate() {
            let number = |row: &Vec<Cell>| matches!(row.get(column), Some(Cell::Number(_) | Cell::Best(_)));
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
            Cell::Best(value) => (" class=\"n\"", format!("<strong>{}</strong>", number(*value))),
            Cell::Figure(figure) => ("", figure_markup(figure)),
        };
        let _ = write!(self.0, "{open}{class}>{content}{close}");
    }

    /// Pictures side by side.
    pub fn figures(&mut self, figures: &[Figure]) {
        self.0.push_str("<div class=\"row\">\n");
        for figure in figures {
            let _ = writeln!(self.0, "{}", figure_markup(figure));
        }
        self.0.push_str("</div>\n");
    }

    /// A plot.
    pub fn plot(&mut self, plot: &Plot) {
        let _ = writeln!(self.0, "<figure class=\"plot\">{}</figure>", plot.svg());
    }

    /// Folds `inside` away under a line that opens it.
    pub fn details(&mut self, summary: &str, inside: &Self) {
        let _ = writeln!(self.0, "<details><summary>{}</summary>\n{}</details>", escape(summary), inside.0);
    }

    /// Another fragment after this one.
    pub fn append(&mut self, other: &Self) {
        self.0.push_str(&other.0);
    }
}

fn figure_markup(figure: &Figure) -> String {
    let (width, height) = (figure.width * figure.scale, figure.height * figure.scale);
    let (file, alt) = (escape(&figure.file), escape(&figure.alt));
    let caption: Vec<String> = figure.caption.iter().map(|line| escape(line)).collect();
    format!(
        "<figure><a href=\"{file}\"><img src=\"{file}\" alt=\"{alt}\" width=\"{width}\" height=\"{height}\" \
         loading=\"lazy\"/></a><figcaption>{}</figcaption></figure>",
        caption.join("<br/>")
    )
}

#[cfg(test)]
pub(in crate::app) mod tests {
    use super::super::plot::{Plot, Scale};
    use super::*;

    /// Checks that every element is closed in its order, every `&` starts an entity and every attribute is quoted, and
    /// returns the number of elements.
    pub(in crate::app) fn well_formed(html: &str) -> Result<usize, String> {
        let html = html.strip_prefix("<!DOCTYPE html>").unwrap_or(html);
        let (mut open, mut count, mut rest) = (Vec::new(), 0, html);
        while let Some(start) = rest.find('<') {
            check_entities(&rest[..start])?;
            let end = start + rest[start..].find('>').ok_or("a tag does not end")?;
            let tag = &rest[start + 1..end];
            rest = &rest[end + 1..];
            if let Some(name) = tag.strip_prefix('/') {
                let last: Option<&str> = open.pop();
                if last != Some(name) {
                    return Err(format!("</{name}> closes {last:?}"));
                }
                continue;
            }
            count += 1;
            let name = tag.split_whitespace().next().unwrap_or_default().trim_end_matches('/');
            // Between quotes anything goes; outside of them `=` is followed by a quote.
            let mut outside = tag.split('"').step_by(2);
            let closed = tag.matches('"').count() % 2 == 0;
            if !closed || outside.any(|part| part.trim_end_matches('=').contains('=')) || tag.ends_with('=') {
                return Err(format!("an attribute is not quoted: <{tag}>"));
            }
            check_entities(tag)?;
            if !tag.ends_with('/') {
                open.push(name);
            }
            if name == "style" {
                rest = &rest[rest.find("</style>").ok_or("the style does not end")?..];
            }
        }
        if open.is_empty() { Ok(count) } else { Err(format!("not closed: {open:?}")) }
    }

    fn check_entities(text: &str) -> Result<(), String> {
        for (at, _) in text.match_indices('&') {
            let entity = &text[at + 1..text[at..].find(';').map_or(at + 1, |end| at + end)];
            if !["amp", "lt", "gt", "quot", "#39"].contains(&entity) {
                return Err(format!("a bare & in {text:?}"));
            }
        }
        Ok(())
    }

    #[test]
    fn the_checker_refuses_what_is_not_well_formed() {
        for broken in [
            "<p>",
            "</p>",
            "<p><b></p></b>",
            "<p>a & b</p>",
            "<p class=x>y</p>",
            "<p>&nbsp;</p>",
            "<p",
            "<p a=\"1>y</p>",
        ] {
            assert!(well_formed(broken).is_err(), "{broken}");
        }
        assert_eq!(well_formed("<p a=\"1\">x &amp; y<br/></p>"), Ok(2));
    }

    #[test]
    fn hostile_text_stays_text() {
        let hostile = "</td><script>alert('x' & \"y\")</script>";
        let mut table = Table::new(hostile, [hostile, "b"]);
        let figure = Figure {
            file: hostile.to_owned(),
            alt: hostile.to_owned(),
            caption: vec![hostile.to_owned()],
            width: 3,
            height: 4,
            scale: 2,
        };
        table.row([hostile.into(), Cell::Figure(figure.clone())]);
        let mut html = Html::new();
        html.table(&table);
        html.figures(&[figure]);
        html.heading(hostile);
        html.paragraph(hostile);
        html.findings(&[hostile.to_owned()]);
        let mut plot = Plot::new(hostile, (hostile, Scale::Linear), (hostile, Scale::Log));
        plot.line(hostile, vec![(0.0, 1.0), (1.0, 10.0)]);
        html.plot(&plot);
        let mut outer = Html::new();
        outer.details(hostile, &html);
        let sections = [PageSection { name: "a", title: hostile, html: &outer }];
        let page = page(hostile, &[(hostile.to_owned(), hostile.to_owned())], &sections);
        assert!(well_formed(&page).unwrap() > 30);
        assert!(!page.contains("<script"), "{page}");
    }
}
