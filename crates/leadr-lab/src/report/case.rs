//! A picture that is compared with the truth. The report's last section lists the worst pictures.

use serde::{Deserialize, Serialize};

use super::nan::or_nan;
use super::verdict::{Anatomy, Errors, Verdict};
use leadr_tools::html::Figure;

/// The measured errors of one picture.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Case {
    /// The name of the section that made the picture.
    pub section: String,
    /// The subject of the picture, such as roughness and light.
    pub subject: String,
    /// The technique and rule of the picture.
    pub look: String,
    /// The name of the truth in the comparison.
    pub truth: String,
    /// The errors over the whole object.
    pub object: Errors,
    /// The errors over the object's interior.
    pub interior: Errors,
    /// The distribution of the error.
    pub anatomy: Anatomy,
    /// The interior errors against the normal-map truth, if measured.
    pub normal_map: Option<Errors>,
    /// The relative noise of the truth in the interior.
    #[serde(deserialize_with = "or_nan")]
    pub noise: f64,
    /// The figures on the page: the picture, the truth and the errors.
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
