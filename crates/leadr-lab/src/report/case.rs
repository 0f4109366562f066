//! A picture compared with the truth, kept for the last section, which lists the worst ones.

use serde::{Deserialize, Serialize};

use super::nan::or_nan;
use super::verdict::{Anatomy, Errors, Verdict};
use leadr_tools::html::Figure;

/// Measurements of one picture.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Case {
    /// Section of the picture.
    pub section: String,
    /// Subject, such as roughness and light.
    pub subject: String,
    /// Technique and rule.
    pub look: String,
    /// Truth of the comparison.
    pub truth: String,
    /// Errors over the object.
    pub object: Errors,
    /// Errors over its interior.
    pub interior: Errors,
    /// Distribution of the error.
    pub anatomy: Anatomy,
    /// Interior errors against normal-map truth, if measured.
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
