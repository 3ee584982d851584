//! The environment of a comparison: machine, commit and date.

use super::{commit::commit, result::Environment};
use std::{
    path::Path,
    process::Command,
    time::{SystemTime, UNIX_EPOCH},
};

impl Environment {
    /// Returns this machine and, if `dated`, the current time. The caller sets backends and
    /// adapter.
    pub fn of_this_machine(dated: bool) -> Self {
        let date = if dated {
            let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH);
            Some(format_date(since_1970.map_or(0, |d| d.as_secs())))
        } else {
            None
        };
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            commit: commit(Path::new(".")),
            date,
            cpu: processor(),
            threads: rayon::current_num_threads(),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            adapter: None,
            snapping: None,
            backends: Vec::new(),
        }
    }
}

/// Runs a program and returns its output. `None` if it can't be run or fails.
fn output(program: &str, arguments: &[&str]) -> Option<String> {
    let out = Command::new(program).args(arguments).output().ok()?;
    if !out.status.success() {
        return None;
    }
    Some(String::from_utf8_lossy(&out.stdout).trim().to_owned())
}

/// Returns the processor's name, with one method per operating system: Linux, macOS, Windows.
fn processor() -> String {
    linux_processor()
        .or_else(|| output("sysctl", &["-n", "machdep.cpu.brand_string"]))
        .or_else(|| std::env::var("PROCESSOR_IDENTIFIER").ok())
        .unwrap_or_else(|| "unknown".to_owned())
}

fn linux_processor() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|l| l.starts_with("model name"))?;
    let (_, name) = line.split_once(':')?;
    Some(name.trim().to_owned())
}

/// Formats seconds since 1970 as date and time, `2026-11-21 03:25`.
///
/// Uses `civil_from_days` of Hinnant 2013, "chrono-Compatible Low-Level Date Algorithms", with the
/// same constants. An era is 400 years or 146,097 days. Years begin in March, so that a leap day is
/// the last day of its year.
fn format_date(seconds: u64) -> String {
    let second_of_day = seconds % 86_400;
    // Days from 0000-03-01 to 1970-01-01.
    let days = seconds / 86_400 + 719_468;
    let era = days / 146_097;
    let day_of_era = days % 146_097;
    let year_of_era =
        (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let shifted_month = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * shifted_month + 2) / 5 + 1;
    let month = if shifted_month < 10 {
        shifted_month + 3
    } else {
        shifted_month - 9
    };
    let year = year_of_era + era * 400 + u64::from(month <= 2);
    format!(
        "{year:04}-{month:02}-{day:02} {:02}:{:02}",
        second_of_day / 3600,
        second_of_day / 60 % 60
    )
}

#[cfg(test)]
mod tests {
    use super::format_date;

    #[test]
    fn dates_are_right_around_leap_days() {
        for (seconds, expected) in [
            (0, "1970-01-01 00:00"),
            (951_782_399, "2000-02-28 23:59"),
            (951_782_400, "2000-02-29 00:00"),
            (951_868_800, "2000-03-01 00:00"),
            (1_795_231_500, "2026-11-21 03:25"),
        ] {
            assert_eq!(format_date(seconds), expected);
        }
    }
}
