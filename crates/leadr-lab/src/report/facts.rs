//! Facts about a run, such as the device, the program and the time.

use std::time::{SystemTime, UNIX_EPOCH};

use serde::Serialize;

use leadr_gpu::Gpu;
use leadr_tools::program::{VERSION, commit};

/// The device, program and time of a run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Facts {
    /// The name of the device as the driver reports it.
    pub device: String,
    /// The name and version of the driver.
    pub driver: String,
    /// The start time of the run in UTC.
    pub date: String,
    /// The command that repeats the run.
    pub call: String,
    /// Whether pictures are smaller, and samples fewer, than in the papers.
    pub quick: bool,
}

impl Facts {
    /// Gathers the facts of a run that starts now.
    pub fn gather(gpu: &Gpu, quick: bool) -> Self {
        let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
        let arguments: Vec<String> = std::env::args().skip(1).collect();
        Self {
            device: gpu.device_name().to_owned(),
            driver: gpu.driver_info().to_owned(),
            date: utc(seconds),
            call: format!("leadr-lab {}", arguments.join(" ")),
            quick,
        }
    }

    /// Returns the names and values for the head of the page.
    pub fn rows(&self) -> Vec<(String, String)> {
        let size = if self.quick { "quick: small pictures, few samples" } else { "full" };
        [
            ("device", self.device.as_str()),
            ("driver", &self.driver),
            ("program", &format!("leadr {VERSION}, commit {}", commit())),
            ("date", &self.date),
            ("command", &self.call),
            ("form", size),
        ]
        .map(|(name, value)| (name.to_owned(), value.to_owned()))
        .to_vec()
    }
}

/// Formats seconds since 1970 by the Gregorian calendar, such as `2026-01-31 23:59 UTC`.
fn utc(seconds: u64) -> String {
    let (mut day, minute) = (seconds / 86_400, seconds / 60 % 1440);
    let leap = |year: u64| year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
    let mut year = 1970;
    while day >= 365 + u64::from(leap(year)) {
        day -= 365 + u64::from(leap(year));
        year += 1;
    }
    let lengths = [31, 28 + u64::from(leap(year)), 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
    let mut month = 0;
    while day >= lengths[month] {
        day -= lengths[month];
        month += 1;
    }
    format!("{year:04}-{:02}-{:02} {:02}:{:02} UTC", month + 1, day + 1, minute / 60, minute % 60)
}

#[cfg(test)]
mod tests {
    use super::utc;

    #[test]
    fn dates_match_the_calendar() {
        assert_eq!(utc(0), "1970-01-01 00:00 UTC");
        assert_eq!(utc(951_782_399), "2000-02-28 23:59 UTC");
        assert_eq!(utc(951_782_400), "2000-02-29 00:00 UTC");
        assert_eq!(utc(1_000_000_000), "2001-09-09 01:46 UTC");
        assert_eq!(utc(4_107_542_399), "2100-02-28 23:59 UTC");
        assert_eq!(utc(4_107_542_400), "2100-03-01 00:00 UTC");
    }
}
