//! Stores a picture compared with the truth for the last section, which lists the worst pictures.

use serde::{Deserialize, Serialize};

use super::nan::or_nan;
use super::verdict::{Anatomy, Errors, Verdict};
use leadr_tools::html::Figure;

/// Measured errors of one picture.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Case {
    /// Name of the section that made the picture.
    pub section: String,
    /// Subject of the picture, such as roughness and light.
    pub subject: String,
    /// Technique and rule of the picture.
    pub look: String,
    /// Name of the truth in the comparison.
    pub truth: String,
    /// Errors over the object.
    pub object: Errors,
    /// Errors over the object's interior.
    pub interior: Errors,
    /// Distribution of the error.
    pub anatomy: Anatomy,
    /// Interior errors against the normal-map truth, if measured.
    pub normal_map: Option<Errors>,
    /// Relative noise of the truth in the interior.
    #[serde(deserialize_with = "or_nan")]
    pub noise: f64,
    /// Figures on the page: picture, truth and errors.
    pub figures: Vec<Figure>,
}

impl Case {
    /// Builds the case of a verdict.
    pub fn new(
        section: &str,
        subject: impl Into<String>,
        look: impl Into<String>,
        truth: &str,
        verdict: &Verdict,
    ) -> Self {
        let Verdict { object, interior, anatomy, noise, .. } = *verdict;
        let (section, truth) = (section.to_owned(), truth.to_owned());
        let (subject, look) = (subject.into(), look.into());
        Self { section, subject, look, truth, object, interior, anatomy, normal_map: None, noise, figures: Vec::new() }
    }
}
