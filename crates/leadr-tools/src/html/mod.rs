//! HTML pages. A page consists of fragments without unescaped text, tables, figures, plots, and the frame around the
//! sections.
//!
//! The tests check that the output is also well-formed XML.

mod fragment;
mod page;
mod plot;
mod table;
mod text;
#[cfg(test)]
mod well_formed;

pub use fragment::Html;
pub use page::{PageSection, page};
pub use plot::{Plot, Scale};
pub use table::{Cell, Figure, Table};
pub use text::{address, number, percent};

#[cfg(test)]
mod tests {
    use super::well_formed::well_formed;
    use super::*;

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
