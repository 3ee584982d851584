//! What can be said of commands before their programs are built, which takes minutes.

use crate::{
    WRONG_USAGE,
    commands::{COMMANDS, Command},
};
use std::{ffi::OsString, process::ExitCode};

const EXAMPLES: &str = "\
Examples:
  cargo xtask compare                   every built-in scene, technique and backend: table and report
  cargo xtask stability --quick         where each technique fails: a matrix with pictures
  cargo xtask plan cubes --max-time 2   the best shadows for that scene within two milliseconds
  cargo xtask test --install-driver     all tests, on a software driver if need be
  cargo xtask ci                        all that a change has to pass";

/// Returns the list of all commands.
pub(crate) fn overview() -> String {
    let mut text =
        "umbrage's own commands\n\nUsage: cargo xtask <COMMAND>\n\nCommands:\n".to_owned();
    for command in &COMMANDS {
        text += &format!("  {:<10} {}\n", command.name, command.summary);
    }
    text += "\nEach has `--help` with examples: cargo xtask compare --help\n\n";
    text + EXAMPLES
}

/// Returns what to say of a command that does not exist.
pub(crate) fn unknown(name: &str) -> String {
    let names: Vec<&str> = COMMANDS.iter().map(|command| command.name).collect();
    format!(
        "error: there is no command `{name}`: use one of {}; `cargo xtask --help` says what each does",
        names.join(", ")
    )
}

/// Answers a call for help, and one with an option that the command doesn't have. Returns the exit
/// code, or nothing where the program itself has to answer.
pub(crate) fn before_building(command: &Command, arguments: &[OsString]) -> Option<ExitCode> {
    let help = text_of(command.help?);
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

/// Returns a snapshot's text, without the two lines of dashes and what stands between them.
fn text_of(snapshot: &str) -> &str {
    match snapshot.splitn(3, "---\n").nth(2) {
        Some(text) => text,
        None => snapshot,
    }
}

/// Returns whether a word is an option (`--size`, `--size=640x480`) that does not occur in the
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
    use super::{is_unknown_option, overview, text_of};
    use crate::commands::COMMANDS;

    #[test]
    fn kept_help_names_its_command_and_its_options() {
        for command in &COMMANDS {
            let Some(help) = command.help else { continue };
            let text = text_of(help);
            let usage = format!("Usage: cargo xtask {}", command.name);
            assert!(text.contains(&usage), "{text}");
            assert!(!text.contains("source:"), "{text}");
            // These print what they have to say.
            let prints = ["bench", "wgsl"].contains(&command.name);
            assert!(is_unknown_option("--out", text) == prints, "{text}");
            assert!(is_unknown_option("--ouch", text));
        }
    }

    #[test]
    fn options_are_told_from_other_words() {
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
            assert!(overview.contains(command.summary));
        }
    }
}
