//! Help on commands whose programs are not built yet, which takes minutes.

use crate::{
    WRONG_USAGE,
    commands::{COMMANDS, Program, XtaskCommand},
};
use std::{ffi::OsString, process::ExitCode};

const EXAMPLES: &str = "\
Examples:
  cargo xtask compare                   built-in scenes, all techniques and backends: table, report
  cargo xtask stability --quick         where each technique fails: a matrix with images
  cargo xtask plan cubes --max-time 2   most accurate shadows of a scene within two milliseconds
  cargo xtask test --install-driver     all tests, on a software driver if there is no other
  cargo xtask ci                        all checks of a change";

/// Returns the list of all commands.
pub(crate) fn overview() -> String {
    let mut text =
        "Runs umbrage's development commands\n\nUsage: cargo xtask <COMMAND>\n\nCommands:\n"
            .to_owned();
    for command in &COMMANDS {
        text += &format!("  {:<10} {}\n", command.name, command.summary());
    }
    text += "\nEach command has `--help` with examples: cargo xtask compare --help\n\n";
    text + EXAMPLES
}

/// Returns the error message for an unknown command.
pub(crate) fn unknown(name: &str) -> String {
    let names: Vec<&str> = COMMANDS.iter().map(|command| command.name).collect();
    format!(
        "error: there is no command `{name}`: use one of {}; `cargo xtask --help` describes them",
        names.join(", ")
    )
}

/// Handles `--help` and unknown options. Returns the exit code, or `None` if the program itself
/// must handle the arguments.
pub(crate) fn before_building(command: &XtaskCommand, arguments: &[OsString]) -> Option<ExitCode> {
    if command.program != Program::Measure {
        return None;
    }
    let help = command.help();
    let words: Vec<&str> = arguments
        .iter()
        .filter_map(|argument| argument.to_str())
        .collect();
    if words.contains(&"--help") || words.contains(&"-h") {
        println!("{help}");
        return Some(ExitCode::SUCCESS);
    }
    let option = words.iter().find(|word| is_unknown_option(word, help))?;
    let name = command.name;
    eprintln!("error: `{name}` has no option `{option}`; `cargo xtask {name} --help` lists them");
    Some(ExitCode::from(WRONG_USAGE))
}

/// Reports whether a word is an option (`--size`, `--size=640x480`) that does not occur in the
/// command's help.
fn is_unknown_option(word: &str, help: &str) -> bool {
    let option = word.split('=').next().unwrap_or(word);
    if !option.starts_with("--") || option == "--" {
        return false;
    }
    let known = help
        .split(|c: char| !c.is_ascii_alphanumeric() && c != '-')
        .any(|known| known == option);
    !known
}

#[cfg(test)]
mod tests {
    use super::{is_unknown_option, overview};
    use crate::commands::{COMMANDS, Program, XtaskCommand};

    #[test]
    fn kept_help_names_its_command_and_its_options() {
        let is_kept = |command: &&XtaskCommand| command.program == Program::Measure;
        for command in COMMANDS.iter().filter(is_kept) {
            let text = command.help();
            let usage = format!("Usage: cargo xtask {}", command.name);
            assert!(text.contains(&usage), "{text}");
            assert!(!text.contains("source:"), "{text}");
            // These two print their results.
            let prints = ["bench", "wgsl"].contains(&command.name);
            assert!(is_unknown_option("--out", text) == prints, "{text}");
            assert!(is_unknown_option("--ouch", text));
        }
    }

    #[test]
    fn options_are_separated_from_other_words() {
        let help = "--size <WxH>  Image size\n--map-sizes <SIDE>\n";
        assert!(!is_unknown_option("--size=640x480", help));
        assert!(is_unknown_option("--sizes", help));
        assert!(is_unknown_option("--map", help));
        assert!(!is_unknown_option("cubes", help));
        assert!(!is_unknown_option("-5", help));
        assert!(!is_unknown_option("--", help));
    }

    #[test]
    fn the_overview_names_every_command() {
        let overview = overview();
        for command in &COMMANDS {
            assert!(overview.contains(&format!("\n  {} ", command.name)));
            assert!(overview.contains(command.summary()));
        }
    }
}
