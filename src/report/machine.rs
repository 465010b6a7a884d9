//! Where and when a figure was measured. Without it a time means nothing.

use serde::{Deserialize, Serialize};
use std::process::Command;
use std::time::{SystemTime, UNIX_EPOCH};

/// The machine, the program's version and the day of a measurement.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Machine {
    /// Processor as it names itself.
    pub device: String,
    pub threads: usize,
    /// Git revision of the checkout that the program was built in ("-dirty" with local changes), else "unknown".
    pub commit: String,
    /// UTC, `YYYY-MM-DD`.
    pub date: String,
}

impl Machine {
    /// This machine, now.
    pub fn here(threads: usize) -> Self {
        let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
        Self { device: cpu_name(), threads, commit: commit(), date: civil_date(now / 86_400) }
    }
}

/// The processor as it names itself, else its architecture.
pub fn cpu_name() -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = info.lines().find_map(|l| l.strip_prefix("model name")?.split_once(':').map(|(_, n)| n.trim()));
    name.unwrap_or(std::env::consts::ARCH).to_owned()
}

/// Asks in the folder of the sources, not in the current one: that may be someone else's repository. HALFPIXEL_COMMIT stands
/// for it where a program runs without them (scripts/gpu_check.sh).
fn commit() -> String {
    if let Some(commit) = std::env::var("HALFPIXEL_COMMIT").ok().filter(|commit| !commit.is_empty()) {
        return commit;
    }
    Command::new("git")
        .args(["-C", env!("CARGO_MANIFEST_DIR"), "describe", "--always", "--dirty", "--abbrev=12", "--exclude=*"])
        .output()
        .ok()
        .filter(|out| out.status.success())
        .and_then(|out| String::from_utf8(out.stdout).ok())
        .map(|rev| rev.trim().to_owned())
        .filter(|rev| !rev.is_empty())
        .unwrap_or_else(|| "unknown".into())
}

/// Largest resident set of this process so far in bytes; `None` where the system doesn't say.
pub fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib * 1024)
}

/// Days since 1970-01-01 as a Gregorian date. Counts in 400-year eras from 1 March, so that a leap day ends its year
/// (H. Hinnant, "chrono-Compatible Low-Level Date Algorithms", 2013, civil_from_days; here for days from 1970 on).
fn civil_date(days: u64) -> String {
    const DAYS_A_ERA: u64 = 146_097;
    let day = days + 719_468;
    let (era, of_era) = (day / DAYS_A_ERA, day % DAYS_A_ERA);
    let year_of_era = (of_era - of_era / 1_460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let from_march = (5 * of_year + 2) / 153;
    let month = if from_march < 10 { from_march + 3 } else { from_march - 9 };
    let year = era * 400 + year_of_era + u64::from(month <= 2);
    format!("{year:04}-{month:02}-{:02}", of_year - (153 * from_march + 2) / 5 + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_around_leap_days() {
        assert_eq!(civil_date(0), "1970-01-01");
        assert_eq!(civil_date(11_016), "2000-02-29");
        assert_eq!(civil_date(11_017), "2000-03-01");
        assert_eq!(civil_date(20_819), "2027-01-01");
    }

    #[test]
    fn this_machine_has_a_name() {
        let here = Machine::here(2);
        assert!(!here.device.is_empty() && !here.commit.is_empty());
        assert_eq!(here.date.len(), 10);
    }
}
