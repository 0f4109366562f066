//! The frame of the page around the sections.

use std::fmt::Write;

use super::fragment::Html;
use super::text::escape;

/// One section of the page.
#[derive(Clone, Debug)]
pub struct PageSection<'a> {
    /// The anchor name of the section.
    pub name: &'a str,
    /// The heading of the section.
    pub title: &'a str,
    /// The content of the section.
    pub html: &'a Html,
}

/// Returns a page with its title, facts about the run, links to the sections, and the sections.
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

/// The style sheet supports light and dark modes and narrow screens, and loads no external files. Plot lines have the
/// colours of Okabe and Ito, which colour-blind readers can distinguish.
const STYLE: &str = include_str!("page.css");
