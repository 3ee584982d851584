//! Names in backticks and commands on the overview pages: each must exist in the repository.

use super::files::SourceFile;
use crate::cli::Cli;
use clap::CommandFactory as _;
use pulldown_cmark::{CodeBlockKind, Event, Options, Parser, Tag, TagEnd};
use std::{collections::BTreeSet, path::Path};

/// Pages whose names are checked.
const PAGES: [&str; 2] = ["ARCHITECTURE.md", "README.md"];
/// This file has wrong names as examples.
const OWN_PATH: &str = "xtask/upkeep/src/tidy/names.rs";
/// The list of the commands of `cargo xtask`.
const COMMANDS: &str = "xtask/src/commands.rs";
/// The page with the list of techniques, which a test compares with the registry.
const TECHNIQUES: &str = "README.md";
/// Names are short for packages: `core` is `umbrage-core`.
const PACKAGE_PREFIX: &str = "umbrage-";

/// All that a page may name.
#[derive(Debug, Default)]
struct Names<'a> {
    /// Paths of files, and of the folders that they are in.
    paths: BTreeSet<&'a str>,
    /// Words of Rust and WGSL outside comments.
    code: BTreeSet<&'a str>,
    /// Functions that Rust or WGSL declares.
    functions: BTreeSet<&'a str>,
    /// Commands of `cargo xtask`.
    commands: BTreeSet<&'a str>,
    /// Packages and their programs, features and techniques.
    listed: BTreeSet<&'a str>,
}

/// Returns the names on the overview pages that do not exist, each as `path:line: fault, and
/// remedy`.
pub(super) fn faults(root: &Path, sources: &[SourceFile]) -> Vec<String> {
    let names = Names::new(sources);
    let is_checked = |source: &&SourceFile| PAGES.contains(&source.path.as_str());
    let pages = sources.iter().filter(is_checked);
    pages.flat_map(|page| names.faults(root, page)).collect()
}

impl<'a> Names<'a> {
    fn new(sources: &'a [SourceFile]) -> Self {
        let mut out = Self::default();
        for SourceFile { path, text } in sources {
            out.paths.insert(path);
            for (end, _) in path.match_indices('/') {
                out.paths.insert(&path[..end]);
            }
            if path == COMMANDS {
                let list = text.split_once("COMMANDS: [").map_or("", |(_, list)| list);
                out.commands = list.split('"').skip(1).step_by(2).collect();
            }
            if path == TECHNIQUES {
                let rows = text.lines().filter_map(|line| line.strip_prefix("| `"));
                out.listed
                    .extend(rows.filter_map(|row| row.split('`').next()));
            }
            if path.ends_with("Cargo.toml") {
                out.add_manifest(text);
            }
            if path != OWN_PATH && (path.ends_with(".rs") || path.ends_with(".wgsl")) {
                out.add_code(text);
            }
        }
        out
    }

    /// Adds the packages, programs and features of a manifest.
    fn add_manifest(&mut self, text: &'a str) {
        let mut section = "";
        for line in text.lines() {
            let (key, value) = line.split_once(" = ").unwrap_or((line, ""));
            if key.starts_with('[') {
                section = key;
            } else if section == "[features]" {
                self.listed.insert(key);
            } else if key == "name" {
                let name = value.trim_matches('"');
                self.listed.insert(name);
                self.listed.extend(name.strip_prefix(PACKAGE_PREFIX));
            }
        }
    }

    fn add_code(&mut self, text: &'a str) {
        for line in text.lines() {
            let code = line.split("//").next().unwrap_or_default();
            let mut before = "";
            for word in words(code) {
                self.code.insert(word);
                if before == "fn" {
                    self.functions.insert(word);
                }
                before = word;
            }
        }
    }

    fn faults(&self, root: &Path, page: &SourceFile) -> Vec<String> {
        let mut out = Vec::new();
        for (line, text) in quoted_code(&page.text) {
            let fault = if text.starts_with("cargo ") {
                self.fault_of_command(root, &text)
            } else if is_path(&text) {
                let is_known = alternatives(&text)
                    .iter()
                    .all(|path| self.has_path(root, path));
                (!is_known).then(|| "no file or folder has this path".to_owned())
            } else {
                self.fault_of_name(root, &text)
            };
            if let Some(fault) = fault {
                let place = format!("{}:{line}", page.path);
                out.push(format!("{place}: `{text}`: {fault}; correct the page"));
            }
        }
        out
    }

    /// Reports whether a path, or the end of a path, exists. The sources are not all files.
    fn has_path(&self, root: &Path, path: &str) -> bool {
        let path = path.trim_end_matches('/');
        let end = format!("/{path}");
        self.paths.contains(path)
            || self.paths.iter().any(|whole| whole.ends_with(&end))
            || root.join(path).exists()
    }

    fn fault_of_command(&self, root: &Path, text: &str) -> Option<String> {
        let words: Vec<&str> = text.split_whitespace().collect();
        let rest = match words.as_slice() {
            ["cargo", "xtask", rest @ ..] => rest,
            ["cargo", "run", rest @ ..] => {
                let is_unknown = |pair: &&[&str]| {
                    ["--example", "-p"].contains(&pair[0]) && !self.listed.contains(pair[1])
                };
                let unknown = rest.windows(2).find(is_unknown)?;
                return Some(format!("no package or example is named `{}`", unknown[1]));
            }
            _ => return Some("only `cargo xtask` and `cargo run` are checked".to_owned()),
        };
        let name = rest.first().unwrap_or(&"");
        if *name != "--help" && !self.commands.contains(name) {
            return Some(format!("{COMMANDS} has no command `{name}`"));
        }
        let mut options = rest.iter().filter(|word| word.starts_with("--"));
        let unknown = options.find(|option| !has_option(root, name, option))?;
        Some(format!("`{name}` has no option `{unknown}`"))
    }

    /// Returns the fault of an option, a plain name, an item or an expression.
    fn fault_of_name(&self, root: &Path, text: &str) -> Option<String> {
        if text.starts_with("--") {
            let is_known = self
                .commands
                .iter()
                .any(|name| has_option(root, name, text));
            return (!is_known).then(|| "no command has this option".to_owned());
        }
        if self.is_plain_name(text) {
            return None;
        }
        // A plain word that only occurs in code, such as a variable, is too vague.
        if text
            .chars()
            .all(|c| c.is_ascii_lowercase() || "-_".contains(c))
        {
            return Some(
                "no command, technique, feature, package, top folder or function has this name"
                    .to_owned(),
            );
        }
        let is_number = |word: &str| word.starts_with(|c: char| c.is_ascii_digit());
        let is_unknown = |word: &&str| {
            !(is_number(word) || self.code.contains(word) || self.is_plain_name(word))
        };
        let unknown = words(text).find(is_unknown)?;
        Some(format!("`{unknown}` does not occur in code"))
    }

    fn is_plain_name(&self, word: &str) -> bool {
        [&self.commands, &self.listed, &self.functions, &self.paths]
            .iter()
            .any(|names| names.contains(word))
    }
}

/// Reports whether a command has an option, by its kept help or its declaration.
fn has_option(root: &Path, command: &str, option: &str) -> bool {
    let kept = root.join(format!("xtask/help/{command}.snap"));
    let is_in_help = std::fs::read_to_string(kept).is_ok_and(|help| {
        let is_outside = |c: char| !(c.is_ascii_alphanumeric() || c == '-');
        help.split(is_outside).any(|word| word == option)
    });
    let upkeep = Cli::command();
    let is_declared = upkeep.find_subcommand(command).is_some_and(|declared| {
        let mut options = declared.get_arguments().filter_map(|a| a.get_long());
        options.any(|long| option.strip_prefix("--") == Some(long))
    });
    is_in_help || is_declared || option == "--help"
}

/// Returns code in backticks and the commands of shell blocks, with their lines.
fn quoted_code(page: &str) -> Vec<(usize, String)> {
    let mut out = Vec::new();
    let mut is_shell = false;
    for (event, place) in Parser::new_ext(page, Options::ENABLE_TABLES).into_offset_iter() {
        let line = 1 + page[..place.start].matches('\n').count();
        match event {
            Event::Start(Tag::CodeBlock(kind)) => {
                is_shell = matches!(kind, CodeBlockKind::Fenced(language) if &*language == "sh");
            }
            Event::End(TagEnd::CodeBlock) => is_shell = false,
            Event::Code(text) => out.push((line, text.into_string())),
            Event::Text(text) if is_shell => {
                for (i, command) in text.lines().enumerate() {
                    let command = command.split('#').next().unwrap_or_default();
                    out.push((line + i, command.trim().to_owned()));
                }
            }
            _ => {}
        }
    }
    out
}

fn is_path(text: &str) -> bool {
    let has_extension = [".rs", ".wgsl", ".toml", ".md", "}"]
        .iter()
        .any(|end| text.ends_with(end));
    !text.contains(' ') && (text.contains('/') || has_extension)
}

/// Returns the paths that one with alternatives stands for: `a.{rs,wgsl}` is `a.rs` and `a.wgsl`.
fn alternatives(path: &str) -> Vec<String> {
    let Some((start, rest)) = path.split_once('{') else {
        return vec![path.to_owned()];
    };
    let (inside, end) = rest.split_once('}').unwrap_or((rest, ""));
    let parts = inside.split(',');
    parts.map(|part| format!("{start}{part}{end}")).collect()
}

/// Returns the identifiers and numbers of a text.
fn words(text: &str) -> impl Iterator<Item = &str> {
    let is_outside = |c: char| !(c.is_ascii_alphanumeric() || c == '_');
    text.split(is_outside).filter(|word| !word.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{run::root, tidy::files::read_all};

    #[test]
    fn every_name_on_the_overview_pages_exists() {
        let sources = read_all(root()).expect("readable");
        let faults = faults(root(), &sources);
        assert!(faults.is_empty(), "{}", faults.join("\n"));
        for path in PAGES {
            let page = sources.iter().find(|source| source.path == path);
            let names = quoted_code(&page.expect("there").text).len();
            assert!(names > 50, "{path}: {names} names");
        }
    }

    #[test]
    fn every_kind_of_stale_name_is_a_fault() {
        let sources = read_all(root()).expect("readable");
        let names = Names::new(&sources);
        for (path, good, bad) in [
            (
                "ARCHITECTURE.md",
                "`techniques/hard.rs`",
                "`techniques/hart.rs`",
            ),
            ("ARCHITECTURE.md", "`coord.wgsl`", "`cord.wgsl`"),
            (
                "ARCHITECTURE.md",
                "resolve.{rs,wgsl}`",
                "resolve.{rs,glsl}`",
            ),
            (
                "ARCHITECTURE.md",
                "`light_space/fit/`",
                "`light_space/fits/`",
            ),
            ("ARCHITECTURE.md", "`LightSpaces`", "`LightPlaces`"),
            (
                "ARCHITECTURE.md",
                "`Camera::standard`",
                "`Camera::standart`",
            ),
            ("ARCHITECTURE.md", "`twin!`", "`twins_of!`"),
            ("ARCHITECTURE.md", "`visibilities`", "`visibility_list`"),
            ("ARCHITECTURE.md", "`hard`", "`hart`"),
            ("ARCHITECTURE.md", "`umbrage-plan`", "`umbrage-planner`"),
            ("ARCHITECTURE.md", "{cpu, techniques}", "{cpu, technics}"),
            (
                "ARCHITECTURE.md",
                "`cargo xtask card`",
                "`cargo xtask cart`",
            ),
            ("README.md", "`--install-driver`", "`--install-drivers`"),
            ("README.md", "compare --quick ", "compare --quickest "),
            ("README.md", "--example forward`", "--example foreword`"),
            ("README.md", "-p umbrage-viewer ", "-p umbrage-viewers "),
            ("README.md", "cargo xtask site ", "cargo xtask measure "),
        ] {
            let page = sources.iter().find(|source| source.path == path);
            let spoilt = SourceFile {
                path: path.to_owned(),
                text: page.expect("there").text.replacen(good, bad, 1),
            };
            assert!(spoilt.text.contains(bad), "{path} has no {good} to spoil");
            let faults = names.faults(root(), &spoilt);
            assert_eq!(faults.len(), 1, "{bad}: {faults:?}");
        }
    }
}
