//! The command line.

pub(crate) mod shared;

use super::{
    bench::BenchArguments, bias::BiasArguments, card::CardArguments, compare::CompareArguments,
    merge::MergeArguments, plan::PlanArguments, stability::StabilityArguments, wgsl::WgslArguments,
    which::WhichArguments,
};
use clap::{CommandFactory as _, FromArgMatches as _, Parser, Subcommand};

/// The program's invocation in help texts. [`parse`] replaces it by that of the program.
const INVOCATION: &str = "cargo xtask";

/// Measures shadow techniques: speed, and error against ray-traced truth.
#[derive(Debug, Parser)]
#[command(disable_help_subcommand = true)]
#[command(after_help = "Examples:
  cargo xtask compare                   built-in scenes, all techniques and backends: table, report
  cargo xtask stability --quick         where each technique fails: a matrix with images
  cargo xtask plan cubes --max-time 2   most accurate shadows of a scene within two milliseconds")]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Measure techniques on scenes: speed, and error against ray-traced truth
    Compare(CompareArguments),
    /// Run the failure tests: where each technique passes, degrades or fails
    Stability(StabilityArguments),
    /// Plan the cheapest technique and setting within bounds of error, time or memory
    Plan(PlanArguments),
    /// Write recommendations by light, size, motion and budget, from measured results
    Which(WhichArguments),
    /// Compare the default bias with the best manually tuned one
    Bias(BiasArguments),
    /// Join the reports of the shards of a comparison
    Merge(MergeArguments),
    /// Time the CPU backend, the wgpu backend and ray tracing against reference programs
    Bench(BenchArguments),
    /// Measure a graphics card: its rounding, agreement with the CPU, and frame times
    Card(CardArguments),
    /// Print the shader text of a technique, to paste into a shader
    Wgsl(WgslArguments),
}

/// Parses the command line. Ends the process after `--help` (0) and wrong usage (2).
pub(crate) fn parse(invocation: &'static str) -> Command {
    let matches = command(invocation).get_matches();
    match Cli::from_arg_matches(&matches) {
        Ok(cli) => cli.command,
        Err(error) => error.exit(),
    }
}

/// Returns the command line's description, with examples that start with `invocation`.
fn command(invocation: &'static str) -> clap::Command {
    let whole = Cli::command().name(invocation).bin_name(invocation);
    let whole = with_own_examples(whole, invocation);
    let whole = whole.mut_subcommands(|subcommand| with_own_examples(subcommand, invocation));
    if invocation == INVOCATION {
        return whole;
    }
    whole.mut_subcommand("card", without_pack)
}

/// Hides `--pack` in the help of `card`, since it only works in umbrage's repository.
fn without_pack(card: clap::Command) -> clap::Command {
    let examples = card.get_after_help().map(ToString::to_string);
    let examples = examples.unwrap_or_default();
    let kept: Vec<&str> = examples.lines().filter(|l| !l.contains("--pack")).collect();
    card.mut_arg("pack", |pack| pack.hide(true))
        .after_help(kept.join("\n"))
}

fn with_own_examples(command: clap::Command, invocation: &str) -> clap::Command {
    let Some(examples) = command.get_after_help().map(ToString::to_string) else {
        return command;
    };
    command.after_help(examples.replace(INVOCATION, invocation))
}

#[cfg(test)]
mod tests {
    use super::{INVOCATION, command};

    /// The help of every command, as `--help` prints it to a terminal of 100 columns. `cargo xtask`
    /// prints these files until the program is built.
    #[test]
    fn help() {
        let mut whole = command(INVOCATION).term_width(100);
        whole.build();
        let names: Vec<String> = whole
            .get_subcommands()
            .map(|subcommand| subcommand.get_name().to_owned())
            .collect();
        insta::with_settings!({
            snapshot_path => concat!(env!("CARGO_MANIFEST_DIR"), "/../../xtask/help"),
            prepend_module_to_snapshot => false,
            omit_expression => true,
        }, {
            for name in names {
                let subcommand = whole.find_subcommand_mut(&name).expect("a command of the list");
                insta::assert_snapshot!(name, subcommand.render_long_help().to_string());
            }
        });
    }

    #[test]
    fn every_command_shows_examples() {
        for subcommand in command("umbrage").get_subcommands() {
            let help = subcommand.clone().render_long_help().to_string();
            let example = format!("Examples:\n  umbrage {}", subcommand.get_name());
            assert!(help.contains(&example), "{help}");
            assert!(
                !help.contains("--pack"),
                "works in the repository only: {help}"
            );
        }
    }

    /// Errors after wrong usage.
    #[test]
    fn usage_errors() {
        let wrong: [&[&str]; 21] = [
            &[],
            &["compere"],
            &["compare", "--size", "640"],
            &["compare", "--size", "0x480"],
            &["compare", "--map-sizes", "512,0"],
            &["compare", "--backend", "cuda"],
            &["compare", "--runs", "0"],
            &["compare", "cubes", "--max-error", "0.001"],
            &["compare", "cubes", "--max-error", "nan"],
            &["plan"],
            &["plan", "cubes", "--max-error", "nan"],
            &["plan", "cubes", "--max-time", "-1"],
            &["plan", "--regret", "--max-error", "0.1"],
            &["plan", "cubes", "--hold", "0%"],
            &["plan", "cubes", "--must-pass", "1"],
            &["plan", "cubes", "--budget-ms", "2", "--max-error", "0.1"],
            &["compare", "--shard", "9/8"],
            &["compare", "--deterministic", "--runs", "3"],
            &["merge", "s1", "s2"],
            &["wgsl"],
            &["wgsl", "hard", "--preset", "a.toml"],
        ];
        let mut text = String::new();
        for arguments in wrong {
            let error = command(INVOCATION)
                .try_get_matches_from(std::iter::once(&"xtask").chain(arguments))
                .expect_err("wrong usage");
            assert_eq!(error.exit_code(), 2, "{arguments:?}");
            text += &format!("$ cargo xtask {}\n{error}\n", arguments.join(" "));
        }
        insta::assert_snapshot!(text);
    }
}
