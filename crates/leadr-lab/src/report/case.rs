//! A picture compared with the truth, kept so that the last section can look for the worst of them.

use serde::{Deserialize, Serialize};

use super::nan::or_nan;
use super::verdict::{Anatomy, Errors, Verdict};
use leadr_tools::html::Figure;

/// What was measured of one picture.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Case {
    /// Section it comes from.
    pub section: String,
    /// What it shows, such as roughness and light.
    pub subject: String,
    /// Technique and rule.
    pub look: String,
    /// What it was compared with.
    pub truth: String,
    /// Errors over the object.
    pub object: Errors,
    /// Errors over its inside.
    pub interior: Errors,
    /// Where the error lies.
    pub anatomy: Anatomy,
    /// Errors inside, against normal-map truth, where that was measured.
    pub normal_map: Option<Errors>,
    /// Relative noise of the truth inside.
    #[serde(deserialize_with = "or_nan")]
    pub noise: f64,
    /// The picture, the truth, and the errors, if they are on the page.
    pub figures: Vec<Figure>,
}

impl Case {
    /// The case of a verdict.
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
