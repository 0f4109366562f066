//! The content of one section of the report.

use serde::{Deserialize, Serialize};

use leadr_tools::error::LabError;
use leadr_tools::html::Html;

/// The content of a section.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Section {
    /// HTML content for the page.
    pub html: Html,
    /// Machine-readable data.
    pub data: serde_json::Value,
    /// Conclusions computed from the data.
    pub findings: Vec<String>,
}

impl Section {
    /// Creates a section with an introduction, its findings, and the supporting tables and plots.
    ///
    /// # Errors
    /// If the data cannot be written as JSON.
    pub fn new(intro: &str, findings: Vec<String>, shown: &Html, data: impl Serialize) -> Result<Self, LabError> {
        let mut html = Html::new();
        html.paragraph(intro);
        html.findings(&findings);
        html.append(shown);
        let data = serde_json::to_value(data).map_err(|e| LabError::json(&e))?;
        Ok(Self { html, data, findings })
    }
}
