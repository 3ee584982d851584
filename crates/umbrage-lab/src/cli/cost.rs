//! Prints the expected duration and memory of a comparison before it begins.

use crate::cli::usage::Usage;
use crate::compare::{Backends, CompareOptions, Expected, SceneInput, pilot};
use anyhow::Result;
use std::time::Duration;

/// Comparisons of more pixels than this get a time estimate first: some take days.
const MANY_PIXELS: u64 = 1 << 24;

/// Prints the amount of work and, if it is large, an estimate of the duration.
///
/// # Errors
/// Errors if the comparison doesn't fit into this machine's memory.
pub(crate) fn announce(
    inputs: &[SceneInput],
    options: &CompareOptions,
    backends: &mut Backends,
) -> Result<()> {
    if inputs.is_empty() {
        return Ok(());
    }
    let expected = Expected::new(inputs, options, backends.backends.len())?;
    println!("{}", count_line(&expected));
    if let Some(refusal) = refusal(expected.bytes, memory()) {
        return Err(Usage(refusal).into());
    }
    if expected.pixels > MANY_PIXELS {
        println!("estimating the duration at a small image size ..");
        let time = pilot(inputs, options, backends)?;
        println!("estimated duration on this machine: {}", time_text(time));
    }
    Ok(())
}

fn count_line(expected: &Expected) -> String {
    let scenes = expected.scenes;
    let rows = expected.rows;
    let of_scenes = plural(scenes);
    let of_rows = plural(rows);
    format!(
        "{scenes} scene{of_scenes}, {rows} row{of_rows}, {} pixels; at most {} rays for truth, about {} of memory",
        short(expected.pixels),
        short(expected.rays),
        size(expected.bytes),
    )
}

fn plural(count: usize) -> &'static str {
    if count == 1 { "" } else { "s" }
}

/// Returns why so much memory can't be allocated. `None` if it can, or if the machine's memory is
/// unknown.
fn refusal(bytes: u64, memory: Option<u64>) -> Option<String> {
    let memory = memory.filter(|memory| bytes > *memory)?;
    let needed = size(bytes);
    let there = size(memory);
    Some(format!(
        "the comparison needs about {needed} of memory, but this machine has {there}; use smaller images (--size), or fewer rows \
         (--technique, --backend, --map-sizes)"
    ))
}

/// Returns the machine's memory, bytes. `None` if the system doesn't report it.
fn memory() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text
        .lines()
        .find_map(|line| line.strip_prefix("MemTotal:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}

/// Formats a count with a unit: `4.2 k`, `268 M`.
fn short(count: u64) -> String {
    let units = [(1e12, " T"), (1e9, " G"), (1e6, " M"), (1e3, " k")];
    let unit = units.into_iter().find(|(unit, _)| count as f64 >= *unit);
    let Some((unit, name)) = unit else {
        return count.to_string();
    };
    let value = count as f64 / unit;
    let digits = if value < 10.0 { 1 } else { 0 };
    format!("{value:.digits$}{name}")
}

fn size(bytes: u64) -> String {
    let mebibytes = bytes as f64 / f64::from(1 << 20);
    if mebibytes < 1024.0 {
        format!("{:.0} MiB", mebibytes.max(1.0))
    } else {
        format!("{:.1} GiB", mebibytes / 1024.0)
    }
}

/// Formats a duration in one unit: `7 s`, `10 min`.
pub(crate) fn time_text(time: Duration) -> String {
    let seconds = time.as_secs_f64();
    match seconds {
        _ if seconds < 100.0 => format!("{seconds:.0} s"),
        _ if seconds < 100.0 * 60.0 => format!("{:.0} min", seconds / 60.0),
        _ if seconds < 72.0 * 3600.0 => format!("{:.0} h", seconds / 3600.0),
        _ => format!("{:.0} days", seconds / 86_400.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cost_is_said_in_units_that_people_know() {
        let expected = Expected {
            scenes: 1,
            rows: 154,
            pixels: 1 << 28,
            rays: 7 << 28,
            bytes: 219 << 30,
        };
        let line = count_line(&expected);
        assert_eq!(
            line,
            "1 scene, 154 rows, 268 M pixels; at most 1.9 G rays for truth, about 219.0 GiB of memory"
        );
        let small = Expected {
            scenes: 2,
            rows: 6,
            pixels: 600,
            rays: 4200,
            bytes: 1000,
        };
        assert_eq!(
            count_line(&small),
            "2 scenes, 6 rows, 600 pixels; at most 4.2 k rays for truth, about 1 MiB of memory"
        );
        let times = [7, 600, 7200 * 2, 86_400 * 9].map(|s| time_text(Duration::from_secs(s)));
        assert_eq!(times, ["7 s", "10 min", "4 h", "9 days"]);
    }

    #[test]
    fn what_cannot_fit_is_refused_with_what_to_do() {
        let refused = refusal(219 << 30, Some(8 << 30)).expect("too much");
        assert!(
            refused.contains("219.0 GiB")
                && refused.contains("8.0 GiB")
                && refused.contains("--size"),
            "{refused}"
        );
        assert_eq!(refusal(1 << 30, Some(8 << 30)), None);
        assert_eq!(refusal(219 << 30, None), None, "unknown memory");
    }
}
