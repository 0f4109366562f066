//! The frame around the sections.

use std::fmt::Write;

use super::fragment::Html;
use super::text::escape;

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
