//! The report, which repeats and extends the papers' tables, pictures and plots on one page.

mod case;
mod configuration;
mod facts;
mod kept;
mod nan;
mod outside;
mod page;
mod run;
mod section;
mod sections;
mod shared;
mod studio;
mod subject;
mod truth;
mod verdict;
mod visible_surface;

pub use run::{ReportConfig, ReportSummary, report};
pub use sections::{SECTIONS, SectionEntry};
