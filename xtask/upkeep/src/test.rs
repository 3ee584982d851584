//! Runs all tests on a graphics adapter, which is installed if needed. Tests that compare backends
//! then run again on a second driver, and some with shaders rewritten so that the first driver
//! rounds differently.

use crate::{
    adapter,
    cli::{DriverTests, TestOptions},
    run::{cargo, run, spell},
    swiftshader::{self, SwiftShader},
};
use anyhow::{Context as _, Result, anyhow, bail};
use std::{
    io::{BufRead as _, BufReader},
    num::NonZero,
    process::{Command, Stdio},
    time::Instant,
};

/// Builds the tests, checks that there is an adapter, and runs them.
pub(crate) fn test(options: &TestOptions) -> Result<()> {
    let start = Instant::now();
    build_and_fetch(options)?;
    let adapter = match adapter::find()? {
        Some(name) => name,
        None if options.install_driver => {
            adapter::install_driver()?;
            adapter::find()?.context("the driver is installed, but no graphics adapter is found")?
        }
        None => bail!(
            "no graphics adapter, and the tests need one: run `cargo xtask test --install-driver`, or as root `{}`",
            adapter::by_hand()
        ),
    };
    let second = second_driver(options)?;
    if options.pinned_driver {
        adapter::check_pinned()?;
    }
    // Run all tests on the adapter.
    println!("testing on {adapter}");
    let mut command = cargo();
    command.args(["test", "--all-features", "--no-fail-fast"]);
    if options.pinned_driver {
        command.env("UMBRAGE_PINNED_DRIVER", "required");
    }
    let totals = run_tests(command.args(&options.arguments), options.drivers)?;
    let mut failed = print_totals(&totals, start, &adapter);
    // Run the tests that compare backends on the second driver.
    if let Some(driver) = second {
        println!("testing on SwiftShader");
        let start = Instant::now();
        let mut command = cargo();
        driver.select(command.args(SECOND));
        if options.drivers == DriverTests::Part {
            command.env(NTH_CASE, NTH_ON_SECOND);
        }
        let totals = run_tests(&mut command, options.drivers)?;
        failed += print_totals(&totals, start, "SwiftShader");
        // Filters that match no test are a failure, too.
        failed += usize::from(totals.passed == 0);
    }
    // Run some tests under each model of a driver.
    if runs_second_driver(options) {
        for model in DRIVER_MODELS {
            failed += test_under(model, options.drivers, &adapter)?;
        }
    }
    if failed == 0 {
        Ok(())
    } else {
        bail!("{failed} tests or programs failed; see their output above")
    }
}

/// Builds the tests, and meanwhile fetches the packages of drivers to install: building uses the
/// cores, and fetching the network.
fn build_and_fetch(options: &TestOptions) -> Result<()> {
    let fetch_second = runs_second_driver(options) && options.install_driver;
    std::thread::scope(|scope| {
        let fetching = scope.spawn(|| {
            // One after the other: apt-get runs once at a time.
            if options.install_driver && !adapter::has_driver() {
                adapter::install_driver()?;
            }
            if fetch_second {
                SwiftShader::fetch_library()?;
            }
            Ok(())
        });
        let built = run(cargo().args(["test", "--all-features", "--no-run"]));
        let fetched = fetching
            .join()
            .map_err(|_| anyhow!("fetching drivers panicked"))
            .flatten();
        built.and(fetched)
    })
}

/// Reports whether some tests run again on the second driver: unless the user selected tests.
const fn runs_second_driver(options: &TestOptions) -> bool {
    options.arguments.is_empty()
}

/// Arguments for the tests on the second driver: tests that compare backends, and its own.
#[rustfmt::skip]
const SECOND: [&str; 11] = [
    "test", "--all-features", "--no-fail-fast", "--test=nets", "--test=second_driver", "--",
    "agreement::", "rasterisers::", "light_set::alike::", "light_set::masks::", "on_the_second_driver",
];

/// Environment variable with the rewriting of the tests' shaders, and its values: see
/// `tests/driver_model.rs`.
const DRIVER_MODEL: &str = "UMBRAGE_DRIVER_MODEL";
const DRIVER_MODELS: [&str; 3] = ["fused", "reassociated", "inaccurate"];

/// Environment variable that makes tests run each Nth of their cases: see `tests/driver_model.rs`.
const NTH_CASE: &str = "UMBRAGE_EVERY_NTH_CASE";
/// Divisors of the number of cases under each model of a driver, and on the second driver. Drivers
/// on the CPU take longer to compile each case's shaders than to run them, and the second driver
/// takes longest.
const NTH_UNDER_MODELS: &str = "10";
const NTH_ON_SECOND: &str = "30";

/// Arguments for the tests with rewritten shaders: some of each kind, and all that compare an
/// adapter with the CPU.
#[rustfmt::skip]
const PART_ON_EVERY_DRIVER: [&str; 15] = [
    "test", "--all-features", "--no-fail-fast", "--test=nets", "--test=second_driver", "--", "every_driver::", "agreement::random_scenes",
    "cascades::both_halves_agree", "soft::both_halves_agree", "lists::lamps_amid_triangles", "random_scenes_are_listed",
    "shadow_volumes_are_exact", "gives_the_bits_that_it_gives_alone", "the_suite_agrees",
];
#[rustfmt::skip]
const ALL_ON_EVERY_DRIVER: [&str; 15] = [
    "test", "--all-features", "--no-fail-fast", "--test=nets", "--test=second_driver", "--", "every_driver::", "agreement::", "lists::",
    "exact::", "soft::", "cascades::", "light_set::", "cut_outs::", "on_the_second_driver",
];

/// Runs tests with shaders rewritten by a model of drivers. Returns the number of failures.
fn test_under(model: &str, tests: DriverTests, adapter: &str) -> Result<usize> {
    println!("testing with shaders rewritten to model a driver: {model} arithmetic");
    let start = Instant::now();
    let mut command = cargo();
    command.env(DRIVER_MODEL, model);
    match tests {
        DriverTests::Part => {
            command.args(PART_ON_EVERY_DRIVER);
            command.env(NTH_CASE, NTH_UNDER_MODELS);
        }
        DriverTests::All => {
            command.args(ALL_ON_EVERY_DRIVER);
        }
    }
    // Tests of a second driver run on an adapter by name: select the same one.
    let name = adapter.split(" (").next().unwrap_or(adapter);
    command.env("WGPU_ADAPTER_NAME", name);
    let totals = run_tests(&mut command, tests)?;
    let failed = print_totals(&totals, start, &format!("{adapter}, {model}"));
    Ok(failed + usize::from(totals.passed == 0))
}

/// Returns the driver on which some tests run again, and prints a message if it is missing. `None`
/// if the user selected tests.
fn second_driver(options: &TestOptions) -> Result<Option<SwiftShader>> {
    if !runs_second_driver(options) {
        return Ok(None);
    }
    let there = SwiftShader::unpacked_driver()?;
    if there.is_none() {
        println!(
            "no tests on SwiftShader, a second driver with other rounding: {}",
            swiftshader::HELP
        );
    }
    Ok(there)
}

/// Prints the result of tests, and returns the number of failures.
fn print_totals(totals: &Totals, start: Instant, adapter: &str) -> usize {
    let minutes = start.elapsed().as_secs_f64() / 60.0;
    let verdict = if totals.good { "passed" } else { "FAILED" };
    println!(
        "tests {verdict}: {} passed, {} failed in {} programs, {minutes:.1} min, on {adapter}",
        totals.passed, totals.failed, totals.programs
    );
    // Programs that don't start count as one failure.
    totals.failed.max(usize::from(!totals.good))
}

/// Sums over all test programs.
#[derive(Debug, Default, PartialEq)]
struct Totals {
    passed: usize,
    failed: usize,
    programs: usize,
    /// Whether cargo succeeded.
    good: bool,
}

impl Totals {
    /// Reads a line such as `test result: ok. 3 passed; 0 failed; 0 ignored; ..`.
    fn add(&mut self, line: &str) {
        let Some(rest) = line.strip_prefix("test result: ") else {
            return;
        };
        let words: Vec<&str> = rest.split([' ', ';']).collect();
        for pair in words.windows(2) {
            let count = pair[0].parse::<usize>().unwrap_or(0);
            match pair[1] {
                "passed" => self.passed += count,
                "failed" => self.failed += count,
                _ => {}
            }
        }
        self.programs += 1;
    }
}

/// Number of parallel tests per core. Many wait for a shared graphics device or for its driver's
/// threads, and leave their core idle.
const TESTS_A_CORE: usize = 3;

/// Environment variable of Mesa's software drivers, and the value that compiles shaders without
/// LLVM's optimisations. The arithmetic stays the same, and the tests compile more than they
/// execute: 16 tests of `nets` took 97 s of the processor instead of 179 s.
const UNOPTIMISED: (&str, &str) = ("GALLIVM_PERF", "nopt");

/// Runs tests and prints their output.
fn run_tests(command: &mut Command, drivers: DriverTests) -> Result<Totals> {
    // `--drivers all` tests the driver as users have it.
    if drivers == DriverTests::Part && std::env::var_os(UNOPTIMISED.0).is_none() {
        command.env(UNOPTIMISED.0, UNOPTIMISED.1);
    }
    // Keep a number that the user has set.
    const THREADS: &str = "RUST_TEST_THREADS";
    if std::env::var_os(THREADS).is_none() {
        let cores = std::thread::available_parallelism().map_or(1, NonZero::get);
        command.env(THREADS, (TESTS_A_CORE * cores).to_string());
    }
    let line = spell(command.stdout(Stdio::piped()));
    let mut child = adapter::with_runtime_dir(command)?
        .spawn()
        .with_context(|| format!("`{line}` did not start"))?;
    let mut totals = Totals::default();
    let output = child.stdout.take().context("tests have no output")?;
    for line in BufReader::new(output).lines() {
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
        assert_eq!(
            totals,
            Totals {
                passed: 7,
                failed: 2,
                programs: 2,
                good: false
            }
        );
    }
}
