//! Messages about repairs and ignored content. In strict mode, what needs a repair is refused.

use std::sync::{Mutex, MutexGuard, PoisonError};

use super::json::Read;
use crate::fault::ModelFault;

/// The maximum number of stored remarks. Further remarks are only counted.
const MAX_REMARKS: usize = 64;

#[derive(Default)]
pub(super) struct Log {
    /// Whether violations of glTF are errors.
    pub(super) strict: bool,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    remarks: Vec<Remark>,
    omitted: usize,
    lost: Option<ModelFault>,
}

struct Remark {
    kind: String,
    text: String,
    /// The number of further remarks of the same kind.
    more: usize,
}

impl Log {
    pub(super) fn new(strict: bool) -> Self {
        Self { strict, ..Self::default() }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds a message. Messages that differ only in numbers are joined.
    pub(super) fn remark(&self, text: impl Into<String>) {
        let text = text.into();
        self.add(without_numbers(&text), text);
    }

    fn add(&self, kind: String, text: String) {
        let mut state = self.state();
        if let Some(same) = state.remarks.iter_mut().find(|remark| remark.kind == kind) {
            same.more += 1;
        } else if state.remarks.len() < MAX_REMARKS {
            state.remarks.push(Remark { kind, text, more: 0 });
        } else {
            state.omitted += 1;
        }
    }

    /// Returns the fault in strict mode only.
    pub(super) fn refuse(&self, fault: ModelFault) -> Read<()> {
        if self.strict { Err(fault) } else { Ok(()) }
    }

    /// Reports a violation and its repair, a clause such as "it is ignored". Returns the fault in strict mode, and if a limit is
    /// exceeded.
    pub(super) fn repair(&self, fault: ModelFault, repair: &str) -> Read<()> {
        self.admit(fault, repair).map(drop)
    }

    /// Like [`Self::repair`], for faults by which triangles are lost. The first such fault is the reason for refusing a model of
    /// which no triangle is left.
    pub(super) fn lose(&self, fault: ModelFault, repair: &str) -> Read<()> {
        let fault = self.admit(fault, repair)?;
        self.state().lost.get_or_insert(fault);
        Ok(())
    }

    fn admit(&self, fault: ModelFault, repair: &str) -> Read<ModelFault> {
        if self.strict || matches!(fault, ModelFault::TooLarge { .. }) {
            return Err(fault);
        }
        match &fault {
            ModelFault::Invalid { location, what } => {
                let text = format!("{location}: {what}; {repair}");
                self.add(without_numbers(&text), text);
            }
            ModelFault::Damaged { what } => self.add(repair.to_owned(), format!("{what}; {repair}")),
            fault => self.add(repair.to_owned(), format!("{fault}; {repair}")),
        }
        Ok(fault)
    }

    /// Returns the first fault by which triangles were lost.
    pub(super) fn first_loss(&self) -> Option<ModelFault> {
        self.state().lost.take()
    }

    pub(super) fn into_remarks(self) -> Vec<String> {
        let State { remarks, omitted, .. } = self.state.into_inner().unwrap_or_else(PoisonError::into_inner);
        let mut all: Vec<String> = remarks
            .into_iter()
            .map(
                |Remark { text, more, .. }| if more > 0 { format!("{text} (and {more} more like this)") } else { text },
            )
            .collect();
        if omitted > 0 {
            all.push(format!("{omitted} further remarks are omitted"));
        }
        all
    }
}

fn without_numbers(text: &str) -> String {
    let words = text.split(' ').filter(|word| !word.contains(|c: char| c.is_ascii_digit()));
    words.collect::<Vec<_>>().join(" ")
}
