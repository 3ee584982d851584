//! All tests, on a graphics adapter that is there or gets installed. Never without one.

use crate::{
    adapter,
    cli::TestOptions,
    run::{cargo, run, spell},
};
use anyhow::{Context as _, Result, bail};
use std::{
    io::{BufRead as _, BufReader},
    process::Stdio,
    time::Instant,
};

/// Builds the tests, makes sure of an adapter, and runs them.
pub(crate) fn test(options: &TestOptions) -> Result<()> {
    let start = Instant::now();
    run(cargo().args(["test", "--workspace", "--all-features", "--no-run"]))?;
    let adapter = match adapter::find()? {
        Some(name) => name,
        None if options.install_driver => {
            adapter::install_driver()?;
            adapter::find()?.context("the driver is installed, yet no graphics adapter is found")?
        }
        None => bail!(
            "no graphics adapter, and the tests need one: run `cargo xtask test --install-driver`, or as root `{}`",
            adapter::by_hand()
        ),
    };
    println!("testing on {adapter}");
    let totals = run_tests(&options.arguments)?;
    let minutes = start.elapsed().as_secs_f64() / 60.0;
    let Totals { passed, failed, programs, .. } = totals;
    let verdict = if totals.good { "passed" } else { "FAILED" };
    println!(
        "tests {verdict}: {passed} passed, {failed} failed in {programs} programs, {minutes:.1} min, on {adapter}"
    );
    if totals.good { Ok(()) } else { bail!("{failed} tests failed; what each says stands above") }
}

/// What all test programs say together.
#[derive(Debug, Default, PartialEq)]
struct Totals {
    passed: usize,
    failed: usize,
    programs: usize,
    good: bool,
}

impl Totals {
    /// Reads a line such as `test result: ok. 3 passed; 0 failed; 0 ignored; ..`.
    fn add(&mut self, line: &str) {
        let Some(rest) = line.strip_prefix("test result: ") else { return };
        let words: Vec<&str> = rest.split([' ', ';']).collect();
        let before = |word| {
            let at = words.iter().position(|&w| w == word)?;
            words.get(at.checked_sub(1)?)?.parse::<usize>().ok()
        };
        self.passed += before("passed").unwrap_or(0);
        self.failed += before("failed").unwrap_or(0);
        self.programs += 1;
    }
}

fn run_tests(arguments: &[String]) -> Result<Totals> {
    let mut command = cargo();
    command.args(["test", "--all-features", "--no-fail-fast"]);
    if !arguments.iter().any(|a| a.starts_with("-p") || a.starts_with("--package")) {
        command.arg("--workspace");
    }
    command.args(arguments).stdout(Stdio::piped());
    let line = spell(&command);
    let mut child =
        adapter::with_runtime_dir(&mut command)?.spawn().with_context(|| format!("`{line}` did not start"))?;
    let mut totals = Totals::default();
    for line in child.stdout.take().map(BufReader::new).into_iter().flat_map(BufReader::lines) {
        let line = line?;
        println!("{line}");
        totals.add(&line);
    }
    totals.good = child.wait()?.success();
    Ok(totals)
}

#[cfg(test)]
mod tests {
    use super::Totals;

    #[test]
    fn counts_come_from_the_result_lines() {
        let mut totals = Totals::default();
        totals.add("running 3 tests");
        totals.add("test result: ok. 3 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.00s");
        totals.add("test result: FAILED. 4 passed; 2 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.00s");
        assert_eq!(totals, Totals { passed: 7, failed: 2, programs: 2, good: false });
    }
}
