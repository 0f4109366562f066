//! Simulates driver failures on demand. The n-th call of a kind fails as it would with a failing driver.
//!
//! Only tests request failures, through functions behind the feature `internals`.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use ash::vk;

/// A kind of driver call that may fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriverCall {
    /// An allocation of memory for a buffer or image. A simulated failure is a memory shortage.
    Allocation,
    /// The creation of a pipeline. A simulated failure is a memory shortage.
    Pipeline,
    /// A submission of commands to the queue. A simulated failure loses the device.
    Submission,
    /// A wait for commands. A simulated failure loses the device.
    Wait,
}

impl DriverCall {
    /// All kinds of calls.
    pub const ALL: [Self; 4] = [Self::Allocation, Self::Pipeline, Self::Submission, Self::Wait];

    /// Returns the name that `LEADR_FAIL` uses for the kind.
    const fn name(self) -> &'static str {
        match self {
            Self::Allocation => "allocation",
            Self::Pipeline => "pipeline",
            Self::Submission => "submission",
            Self::Wait => "wait",
        }
    }

    const fn loses_the_device(self) -> bool {
        matches!(self, Self::Submission | Self::Wait)
    }
}

/// The number of calls so far and the number of the call that fails, for each kind of call.
#[derive(Debug, Default)]
pub(super) struct Faults {
    made: [AtomicU32; DriverCall::ALL.len()],
    /// The number of the call that fails, for each kind of call, counted from 1. The value 0 means no failure.
    failing: [AtomicU32; DriverCall::ALL.len()],
    lost: AtomicBool,
}

impl Faults {
    /// Returns the failure that the environment requests, such as `LEADR_FAIL=submission:7`, in builds with debug assertions.
    pub(super) fn wanted() -> Self {
        let faults = Self::default();
        if cfg!(debug_assertions)
            && let Ok(wanted) = std::env::var("LEADR_FAIL")
            && let Some((call, number)) = parse(&wanted)
        {
            faults.fail(call, number);
        }
        faults
    }

    /// Counts a call, and returns an error if a failure was requested for it. A lost device stays lost.
    pub(super) fn check(&self, call: DriverCall) -> Result<(), vk::Result> {
        let number = self.made[call as usize].fetch_add(1, Ordering::Relaxed) + 1;
        let fails = self.failing[call as usize].load(Ordering::Relaxed) == number;
        if !call.loses_the_device() {
            return if fails { Err(vk::Result::ERROR_OUT_OF_DEVICE_MEMORY) } else { Ok(()) };
        }
        if fails {
            self.lost.store(true, Ordering::Relaxed);
        }
        if self.lost.load(Ordering::Relaxed) { Err(vk::Result::ERROR_DEVICE_LOST) } else { Ok(()) }
    }

    pub(super) fn made(&self, call: DriverCall) -> u32 {
        self.made[call as usize].load(Ordering::Relaxed)
    }

    pub(super) fn fail(&self, call: DriverCall, number: u32) {
        self.failing[call as usize].store(number, Ordering::Relaxed);
    }
}

/// Parses a request of the form `kind:number`.
fn parse(wanted: &str) -> Option<(DriverCall, u32)> {
    let (name, number) = wanted.split_once(':')?;
    let call = DriverCall::ALL.into_iter().find(|call| call.name() == name)?;
    Some((call, number.parse().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_call_is_refused_and_a_lost_device_stays_lost() {
        let faults = Faults::default();
        faults.fail(DriverCall::Allocation, 2);
        let refused: Vec<bool> = (0..4).map(|_| faults.check(DriverCall::Allocation).is_err()).collect();
        assert_eq!(refused, [false, true, false, false]);
        faults.fail(DriverCall::Submission, 1);
        assert!(faults.check(DriverCall::Wait).is_ok());
        assert_eq!(faults.check(DriverCall::Submission), Err(vk::Result::ERROR_DEVICE_LOST));
        assert_eq!(faults.check(DriverCall::Submission), Err(vk::Result::ERROR_DEVICE_LOST));
        assert_eq!(faults.check(DriverCall::Wait), Err(vk::Result::ERROR_DEVICE_LOST));
        assert!(faults.check(DriverCall::Pipeline).is_ok());
    }

    #[test]
    fn faults_are_read_from_text() {
        assert_eq!(parse("submission:7"), Some((DriverCall::Submission, 7)));
        assert_eq!([parse("submission"), parse("nap:7"), parse("wait:x")], [None; 3]);
    }
}
