//! Tables and figures as data, without markup.

use serde::{Deserialize, Serialize};

/// A picture on the page, in a separate file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Figure {
    /// Path of the file from the page, with `/`. The page encodes it as an address.
    pub file: String,
    /// The alternative text.
    pub alt: String,
    /// The lines of the caption.
    pub caption: Vec<String>,
    /// The width in pixels.
    pub width: u32,
    /// The height in pixels.
    pub height: u32,
    /// The number of CSS pixels per picture pixel.
    pub scale: u32,
}

impl Figure {
    /// Returns the picture enlarged by `scale`.
    #[must_use]
    pub fn enlarged(self, scale: u32) -> Self {
        Self { scale, ..self }
    }
}

/// The content of a table's cell.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// A text.
    Text(String),
    /// A number, formatted with three digits.
    Number(f64),
    /// A picture.
    Figure(Figure),
    /// The name of a section of the page, as a link.
    Section(String),
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

/// A table. The first cell of each row is the row's heading.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// The caption of the table.
    pub caption: String,
    /// The column headings.
    pub head: Vec<String>,
    /// The rows, each with as many cells as the head.
    pub rows: Vec<Vec<Cell>>,
}

impl Table {
    /// Creates a table without rows.
    pub fn new<S: Into<String>>(caption: impl Into<String>, head: impl IntoIterator<Item = S>) -> Self {
        Self { caption: caption.into(), head: head.into_iter().map(Into::into).collect(), rows: Vec::new() }
    }

    /// Adds a row.
    pub fn row(&mut self, cells: impl IntoIterator<Item = Cell>) {
        self.rows.push(cells.into_iter().collect());
    }
}
