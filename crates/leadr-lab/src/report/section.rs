//! The content of one section of the report.

use serde::{Deserialize, Serialize};

use leadr_tools::error::LabError;
use leadr_tools::html::Html;

/// The content of a section.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Section {
    /// The HTML content for the page.
    pub html: Html,
    /// The machine-readable data.
    pub data: serde_json::Value,
    /// The conclusions that are computed from the data.
    pub findings: Vec<String>,
}

impl Section {
    /// Creates a section from an introduction, its findings, and the tables and plots that support them.
    ///
    /// # Errors
    /// Fails if the data cannot be written as JSON.
    pub fn new(intro: &str, findings: Vec<String>, shown: &Html, data: impl Serialize) -> Result<Self, LabError> {
        let mut html = Html::new();
        html.paragraph(intro);
        html.findings(&findings);
        html.append(shown);
        let data = serde_json::to_value(data).map_err(|e| LabError::json(&e))?;
        Ok(Self { html, data, findings })
    }
}
