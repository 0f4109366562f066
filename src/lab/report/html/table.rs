//! Tables and pictures, before they are markup.

use serde::{Deserialize, Serialize};

/// A picture of the report: a file beside the page.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Figure {
    /// Path of the file from the page.
    pub file: String,
    /// What it shows, for readers who cannot see it.
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

/// The content of a table's cell.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Words.
    Text(String),
    /// A number, as [`number`] writes it.
    Number(f64),
    /// The best number of its row or column, highlighted.
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

    /// Highlights the smallest number of every column, or with `down` false of every row.
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

#[cfg(test)]
mod tests {
    use super::*;

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
