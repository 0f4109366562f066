//! The report: tables, pictures and plots of the papers, measured again and taken further, on one page.

mod case;
mod facts;
mod kept;
mod look;
mod nan;
mod outside;
mod run;
mod section;
mod sections;
mod shared;
mod studio;
mod subject;
mod truth;
mod verdict;

pub use run::{ReportConfig, ReportSummary, report};
pub use sections::{SECTIONS, SectionEntry};
