//! Mutants of twins: the WGSL half with one operator changed.

use std::ops::Range;
use umbrage_core::{Module, Twin};

/// Each operator of interest, and its mutation.
const SLIPS: [(&str, &str); 15] = [
    (" + ", " - "),
    (" - ", " + "),
    (" * ", " + "),
    (" / ", " * "),
    (" < ", " >= "),
    (" <= ", " > "),
    (" > ", " <= "),
    (" >= ", " < "),
    // Mutate the inclusion of the border: many inputs are zero, and few are at other borders.
    (" < 0.0", " <= 0.0"),
    (" <= 0.0", " < 0.0"),
    (" > 0.0", " >= 0.0"),
    (" >= 0.0", " > 0.0"),
    (" && ", " || "),
    (" || ", " && "),
    ("[3]", "[2]"),
];

/// A mutant, and its changed line.
pub type Mutant = (Twin, String);

/// Returns the mutants of a twin, each with one changed operator of its WGSL half. The operators
/// are those of its function, and of functions that it calls in the same module, except `others`,
/// which are twins with their own mutants.
pub fn mutants(twin: &Twin, others: &[&str]) -> Vec<Mutant> {
    let text = twin.module.text;
    let mut out = Vec::new();
    for body in reached_ranges(text, twin.name, others) {
        for (from, to) in SLIPS {
            let slips = text[body.clone()]
                .match_indices(from)
                .map(|(at, _)| body.start + at)
                .filter(|&at| !is_in_comment(text, at));
            out.extend(
                slips.map(|at| {
                    with_text(twin, [&text[..at], to, &text[at + from.len()..]].concat())
                }),
            );
        }
    }
    out
}

fn is_in_comment(text: &str, at: usize) -> bool {
    let line = text[..at].rfind('\n').map_or(0, |end| end + 1);
    text[line..at].contains("//")
}

/// Returns the bodies of a function and of all that it calls except `others`, as ranges of `text`.
fn reached_ranges(text: &str, function: &str, others: &[&str]) -> Vec<Range<usize>> {
    let bodies = bodies(text);
    let mut names = vec![function];
    let mut next = 0;
    while let Some(name) = names.get(next).copied() {
        let body = bodies
            .iter()
            .find(|(n, _)| *n == name)
            .map_or("", |(_, r)| &text[r.clone()]);
        let called = bodies
            .iter()
            .map(|(n, _)| *n)
            .filter(|n| body.contains(&format!("{n}(")) && !names.contains(n))
            .filter(|n| !others.contains(n));
        let called: Vec<_> = called.collect();
        names.extend(called);
        next += 1;
    }
    bodies
        .into_iter()
        .filter(|(n, _)| names.contains(n))
        .map(|(_, r)| r)
        .collect()
}

/// Returns every function's name, and its range from the opening brace on. A closing brace in the
/// first column ends it.
fn bodies(text: &str) -> Vec<(&str, Range<usize>)> {
    let functions = text.match_indices("\nfn ").filter_map(|(at, _)| {
        let name = &text[at + 4..][..text[at + 4..].find('(')?];
        let start = at + text[at..].find('{')?;
        Some((name, start..start + text[start..].find("\n}")?))
    });
    functions.collect()
}

fn with_text(twin: &Twin, text: String) -> Mutant {
    let spoilt = text
        .lines()
        .zip(twin.module.text.lines())
        .find(|(a, b)| a != b);
    let line = spoilt.map_or("", |(line, _)| line.trim()).to_owned();
    // Leak the few mutated texts, since a module's text is static.
    (
        Twin {
            module: Module {
                text: text.leak(),
                ..twin.module
            },
            ..*twin
        },
        line,
    )
}
