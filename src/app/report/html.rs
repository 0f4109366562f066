//! The page: fragments of HTML that cannot hold unescaped text, tables, figures, and the frame around the sections.
//!
//! Everything is written as well-formed XML too (every element closed), which is what the tests check.

use std::fmt::Write;

use super::plot::Plot;

/// Text as it may stand in an element or in a quoted attribute.
#[must_use]
pub fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            _ => escaped.push(c),
        }
    }
    escaped
}

/// A number with three significant digits as people write it: `0.123`, `12.3`, `1230`, `1.23e-5`; `–` for NaN.
#[must_use]
pub fn number(value: f64) -> String {
    let size = value.abs();
    match size {
        _ if value.is_nan() => "–".to_owned(),
        _ if value.is_infinite() => if value > 0.0 { "∞" } else { "−∞" }.to_owned(),
        0.0 => "0".to_owned(),
        _ if !(1e-4..1e6).contains(&size) => format!("{value:.2e}"),
        _ => {
            let digits = (2 - size.log10().floor() as i32).clamp(0, 6) as usize;
            format!("{value:.digits$}")
        }
    }
}

/// A share as percent with its sign if `signed`: `12.3 %`.
#[must_use]
pub fn percent(share: f64, signed: bool) -> String {
    let value = number(share * 100.0);
    let sign = if signed && share > 0.0 { "+" } else { "" };
    format!("{sign}{value} %")
}

/// A picture of the report: a file beside the page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Figure {
    /// Path of the file from the page.
    pub file: String,
    /// What it shows, for who cannot see it.
    pub alt: String,
    /// Lines under it.
    pub caption: Vec<String>,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Length of a pixel on the page.
    pub scale: u32,
}

impl Figure {
    /// The picture with pixels `scale` times as large, for those that are small.
    #[must_use]
    pub fn enlarged(self, scale: u32) -> Self {
        Self { scale, ..self }
    }
}

/// What stands in a table.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Words.
    Text(String),
    /// A number, as [`number`] writes it.
    Number(f64),
    /// The number of its row or column that is to stand out.
    Best(f64),
    /// A picture.
    Figure(Figure),
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<f64> for Cell {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

/// A table; the first cell of a row is its head.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// What it shows.
    pub caption: String,
    /// Heads of the columns.
    pub head: Vec<String>,
    /// The rows, each as long as the head.
    pub rows: Vec<Vec<Cell>>,
}

impl Table {
    /// A table without rows.
    #[must_use]
    pub fn new<S: Into<String>>(caption: impl Into<String>, head: impl IntoIterator<Item = S>) -> Self {
        Self { caption: caption.into(), head: head.into_iter().map(Into::into).collect(), rows: Vec::new() }
    }

    /// Adds a row.
    pub fn row(&mut self, cells: impl IntoIterator<Item = Cell>) {
        self.rows.push(cells.into_iter().collect());
    }

    /// Lets the smallest number of every column, or with `down` false of every row, stand out.
    pub fn mark_smallest(&mut self, down: bool) {
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let lines: Vec<Vec<(usize, usize)>> = if down {
            (0..columns).map(|c| (0..self.rows.len()).map(|r| (r, c)).collect()).collect()
        } else {
            (0..self.rows.len()).map(|r| (0..columns).map(|c| (r, c)).collect()).collect()
        };
        for line in lines {
            let number = |&(r, c): &(usize, usize)| match self.rows[r].get(c) {
                Some(&Cell::Number(value)) if value.is_finite() => Some(((r, c), value)),
                _ => None,
            };
            let smallest = line.iter().filter_map(number).min_by(|a, b| a.1.total_cmp(&b.1));
            if let Some(((r, c), value)) = smallest {
                self.rows[r][c] = Cell::Best(value);
            }
        }
    }
}

/// A fragment of a page.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
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

/// One section of the page.
#[derive(Clone, Debug)]
pub struct PageSection<'a> {
    /// Name in links.
    pub name: &'a str,
    /// Heading.
    pub title: &'a str,
    /// Content.
    pub html: &'a Html,
}

/// The whole page: a title, facts about the run, links to the sections, the sections.
#[must_use]
pub fn page(title: &str, facts: &[(String, String)], sections: &[PageSection<'_>]) -> String {
    let title = escape(title);
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n<title>{title}</title>\n\
         <style>\n{STYLE}</style>\n</head>\n<body>\n<header>\n<h1>{title}</h1>\n<dl>\n"
    );
    for (name, value) in facts {
        let _ = writeln!(page, "<div><dt>{}</dt><dd>{}</dd></div>", escape(name), escape(value));
    }
    page.push_str("</dl>\n<nav><ol>\n");
    for section in sections {
        let _ = writeln!(page, "<li><a href=\"#{}\">{}</a></li>", escape(section.name), escape(section.title));
    }
    page.push_str("</ol></nav>\n</header>\n<main>\n");
    for section in sections {
        let (name, title) = (escape(section.name), escape(section.title));
        let _ = writeln!(page, "<section id=\"{name}\">\n<h2>{title}</h2>\n{}</section>", section.html.as_str());
    }
    page.push_str("</main>\n</body>\n</html>\n");
    page
}

/// Light and dark, and narrow screens; nothing is fetched from elsewhere. Colours of the plot lines after Okabe and
/// Ito, who chose them so that colour-blind eyes can tell them apart.
const STYLE: &str = "\
:root { color-scheme: light dark; --ink: #1c1e21; --paper: #fdfdfb; --faint: #6a6f76; --line: #d9dadb; --box: #f3f3ef;
  --link: #0b5cad; --good: #0a6e3c; --s0: #0072b2; --s1: #d55e00; --s2: #009e73; --s3: #b1608e; --s4: #9a7500;
  --s5: #3f96c4; --s6: #6b6b6b; --s7: #a83232; --s8: #5b4bb0; --s9: #2e6b2e; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e4e5e6; --paper: #16181b; --faint: #9aa0a6; --line: #34383d; --box: #1e2125; --link: #7ab8f5;
    --good: #62cf96; --s0: #5db5ec; --s1: #ff8b3d; --s2: #35d0a2; --s3: #e79dc6; --s4: #e6c14a; --s5: #8fd3f7;
    --s6: #b5b5b5; --s7: #f08080; --s8: #ab9ef0; --s9: #8fcf8f; }
}
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 1.5rem clamp(0.8rem, 3vw, 3rem) 4rem; max-width: 88rem; color: var(--ink);
  background: var(--paper); font: 1rem/1.5 system-ui, sans-serif; }
h1 { margin: 0 0 0.6rem; font-size: 1.9rem; line-height: 1.2; }
h2 { margin: 3rem 0 0.5rem; padding-top: 0.8rem; border-top: 2px solid var(--line); font-size: 1.45rem; }
h3 { margin: 1.8rem 0 0.3rem; font-size: 1.1rem; }
p, ul { max-width: 62rem; margin: 0.5rem 0; }
a { color: var(--link); }
dl { display: flex; flex-wrap: wrap; gap: 0.3rem 2rem; margin: 0; }
dt { color: var(--faint); font-size: 0.8rem; }
dd { margin: 0; overflow-wrap: anywhere; }
nav ol { columns: 20rem; padding-left: 1.4rem; }
.findings { padding: 0.6rem 1rem 0.6rem 2rem; background: var(--box); border-left: 3px solid var(--good); }
.scroll { overflow-x: auto; margin: 0.8rem 0; }
table { border-collapse: collapse; font-size: 0.9rem; }
caption { text-align: left; color: var(--faint); padding: 0.2rem 0; }
th, td { padding: 0.25rem 0.6rem; border-bottom: 1px solid var(--line); text-align: left; vertical-align: top; }
thead th { border-bottom-width: 2px; }
th[scope=row] { font-weight: 600; }
.numbers th[scope=row] { white-space: nowrap; }
td.n, th.n { text-align: right; font-variant-numeric: tabular-nums; }
td.n { white-space: nowrap; }
td strong { color: var(--good); }
.row { display: flex; flex-wrap: wrap; gap: 0.8rem; margin: 0.8rem 0; }
figure { margin: 0; }
figcaption { font-size: 0.8rem; line-height: 1.35; color: var(--faint); font-variant-numeric: tabular-nums; }
.pictures td { padding: 0.3rem; }
img { display: block; max-width: 100%; height: auto; background: #000; image-rendering: pixelated; }
.pictures img { max-width: none; }
details { margin: 0.6rem 0; }
summary { cursor: pointer; color: var(--link); }
.plot { max-width: 52rem; margin: 1rem 0; }
svg { display: block; width: 100%; height: auto; }
svg text { fill: var(--ink); font: 12px system-ui, sans-serif; }
svg .title { font-weight: 600; font-size: 13px; }
svg .tick { fill: var(--faint); font-size: 11px; }
svg .grid { stroke: var(--line); stroke-width: 1; }
svg .frame { stroke: var(--faint); fill: none; }
svg .series { fill: none; stroke-width: 2; stroke-linejoin: round; }
";

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

    #[test]
    fn numbers_have_three_digits() {
        let cases = [
            (0.0, "0"),
            (0.123_456, "0.123"),
            (12.345, "12.3"),
            (1234.5, "1234"),
            (0.001_234, "0.00123"),
            (1.234e-5, "1.23e-5"),
            (-0.5, "-0.500"),
            (2.5e7, "2.50e7"),
            (f64::NAN, "–"),
            (f64::INFINITY, "∞"),
        ];
        for (value, text) in cases {
            assert_eq!(number(value), text);
        }
        assert_eq!((percent(0.025, true), percent(-0.1, true), percent(0.5, false)), {
            ("+2.50 %".to_owned(), "-10.0 %".to_owned(), "50.0 %".to_owned())
        });
    }

    #[test]
    fn the_smallest_number_stands_out() {
        let mut table = Table::new("t", ["", "a", "b"]);
        table.row(["x".into(), 2.0.into(), f64::NAN.into()]);
        table.row(["y".into(), 1.0.into(), 3.0.into()]);
        let mut across = table.clone();
        table.mark_smallest(true);
        assert_eq!(table.rows[1], ["y".into(), Cell::Best(1.0), Cell::Best(3.0)]);
        assert_eq!(table.rows[0][1], Cell::Number(2.0));
        across.mark_smallest(false);
        assert_eq!((&across.rows[0][1], &across.rows[1][2]), (&Cell::Best(2.0), &Cell::Number(3.0)));
    }
}
