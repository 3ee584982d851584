//! House style beyond clippy and rustfmt: sizes of functions and files, density of code, unique
//! names of public types, and WGSL, TOML and Markdown files.

pub(crate) mod files;
mod names;
mod rules;
mod rust;
mod wgsl;
mod words;

use crate::run::root;
use anyhow::{Result, bail};
use comfy_table::Table;
use files::SourceFile;
use std::collections::BTreeMap;

/// Measures and their limits. Density is the number of tokens per line of code, without comments.
const LIMITS: [(&str, usize); 6] = [
    ("tokens of Rust functions", 850),
    ("lines of Rust functions", 220),
    ("lines of Rust files", 700),
    ("tokens per line of Rust files", 14),
    ("lines of WGSL functions", 70),
    ("lines of WGSL files", 200),
];

/// Size of a function or a file.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Length {
    size: usize,
    /// `path:line name`
    place: String,
}

/// Findings in the files.
#[derive(Debug, Default)]
struct Findings {
    /// Sizes of each kind, in the order of [`LIMITS`].
    lengths: [Vec<Length>; LIMITS.len()],
    /// Places that define each public type name.
    types: BTreeMap<String, Vec<String>>,
    /// Faults as `path:line: fault, and remedy`.
    faults: Vec<String>,
}

/// Prints the table of sizes. Errors if anything is too large or breaks a rule.
pub(crate) fn tidy() -> Result<()> {
    let sources = files::read_all(root())?;
    let mut findings = examine(&sources)?;
    findings.faults.extend(names::faults(root(), &sources));
    println!("{}", table(&findings));
    if findings.faults.is_empty() {
        println!("tidy: {} files, no faults", sources.len());
        return Ok(());
    }
    bail!("tidy found faults:\n  {}", findings.faults.join("\n  "))
}

/// Measures files, and checks sizes, names and text.
fn examine(sources: &[SourceFile]) -> Result<Findings> {
    let mut out = Findings::default();
    let mut prose = words::Prose::default();
    for source in sources {
        match source.extension() {
            "rs" => rust::examine(source, &mut out)?,
            "wgsl" => {
                out.lengths[4].extend(wgsl::lengths(source));
                out.lengths[5].push(lines_of(source));
            }
            _ => {}
        }
        out.faults.extend(rules::faults(source));
        prose.add(source);
    }
    out.faults.extend(prose.faults());
    for (name, places) in out.types.iter().filter(|(_, places)| places.len() > 1) {
        out.faults.push(format!(
            "{}: the type name `{name}` is also defined at {}; rename one of them",
            places[0],
            places[1..].join(", ")
        ));
    }
    for ((name, limit), lengths) in LIMITS.iter().zip(&mut out.lengths) {
        lengths.sort();
        for Length { size, place } in lengths.iter().filter(|length| length.size > *limit) {
            let fault = format!("{place}: {size} {name}, limit {limit}: split it");
            out.faults.push(fault);
        }
    }
    Ok(out)
}

fn lines_of(source: &SourceFile) -> Length {
    Length {
        size: source.text.lines().count(),
        place: source.path.clone(),
    }
}

fn table(findings: &Findings) -> Table {
    let mut table = Table::new();
    table.set_header(["", "count", "median", "90 %", "most", "limit", "largest"]);
    for ((name, limit), lengths) in LIMITS.iter().zip(&findings.lengths) {
        let last = lengths.len().saturating_sub(1);
        let at = |percent: usize| lengths.get((lengths.len() * percent / 100).min(last));
        let size = |percent| at(percent).map_or("-".to_owned(), |length| length.size.to_string());
        table.add_row([
            (*name).to_owned(),
            lengths.len().to_string(),
            size(50),
            size(90),
            size(100),
            limit.to_string(),
            at(100).map_or("-".to_owned(), |length| length.place.clone()),
        ]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::{Findings, SourceFile, examine};

    fn examine_files(files: &[(&str, &str)]) -> Findings {
        let source = |(path, text): &(&str, &str)| SourceFile {
            path: (*path).to_owned(),
            text: (*text).to_owned(),
        };
        let sources: Vec<SourceFile> = files.iter().map(source).collect();
        examine(&sources).expect("good code")
    }

    fn faults(path: &str, text: &str) -> usize {
        examine_files(&[(path, text)]).faults.len()
    }

    fn function(lines: usize, line: &str) -> String {
        format!("fn f() {{\n{}}}\n", line.repeat(lines - 2))
    }

    #[test]
    fn long_functions_and_files_are_refused() {
        for (path, text, count) in [
            ("a.rs", function(220, "    g;\n"), 0),
            ("a.rs", function(221, "    g;\n"), 1),
            // 707 lines.
            ("a.rs", function(101, "    g;\n").repeat(7), 1),
            ("a.wgsl", function(71, "    g();\n"), 1),
            // 201 lines.
            ("a.wgsl", function(67, "    g();\n").repeat(3), 1),
            // 20 tokens per line.
            ("a.rs", function(30, &("g(); ".repeat(4) + "g();\n")), 1),
            // Over 850 tokens.
            ("a.rs", function(110, "    g(1, 2, 3);\n"), 1),
        ] {
            assert_eq!(faults(path, &text), count, "{path}: {text}");
        }
    }

    #[test]
    fn functions_of_every_kind_are_found() {
        let text = "/// Doc.\nfn a() {}\nimpl T {\n    fn b(\n        x: u8,\n    ) {\n        fn c() {\n        }\n    }\n}\n\
                    trait U {\n    fn d();\n    fn e() {\n        \"fn f() {\";\n    }\n}\n";
        let [_, lines, ..] = examine_files(&[("x.rs", text)]).lengths;
        let found: Vec<_> = lines.iter().map(|l| (l.size, l.place.as_str())).collect();
        let expected = [
            (1, "x.rs:2 a"),
            (2, "x.rs:7 c"),
            (3, "x.rs:13 e"),
            (6, "x.rs:4 b"),
        ];
        assert_eq!(found, expected);
    }

    #[test]
    fn tokens_are_counted_without_comments() {
        // `fn f ( a : u8 ) {`, `g ( a , 1 ) ;`, `}`
        let text = "//! Doc.\n\n/// Doc.\n#[inline]\nfn f(a: u8) {\n    // Why.\n    /** Doc. */\n    g(a, 1);\n}\n";
        assert_eq!(examine_files(&[("x.rs", text)]).lengths[0][0].size, 16);
    }

    #[test]
    fn a_public_type_name_may_be_defined_once() {
        let count = |texts: [&str; 2]| {
            let texts = texts.map(|text| format!("{text}\n"));
            examine_files(&[("a.rs", &texts[0]), ("b.rs", &texts[1])])
                .faults
                .len()
        };
        assert_eq!(
            count(["pub struct A; struct B;", "struct A; pub enum B {}"]),
            0
        );
        assert_eq!(count(["pub struct A;", "pub enum A {}"]), 1);
        assert_eq!(
            count(["pub trait A {} pub mod m { pub type A = u8; }", ""]),
            1
        );
    }

    #[test]
    fn parameters_are_names() {
        assert_eq!(faults("a.rs", "fn f(a: [u8; 2], S { x }: S) {}\n"), 0);
        assert_eq!(faults("a.rs", "fn f([a, b]: [u8; 2]) {}\n"), 1);
        let both = "impl T { fn f((a, b): (u8, u8), [c]: [u8; 1]) {} }\n";
        assert_eq!(faults("a.rs", both), 2);
    }

    #[test]
    fn every_rule_for_text_objects() {
        let tidy = "#[expect(dead_code, reason = \"why\")]\nfn f() {}\n";
        assert_eq!(faults("x.rs", tidy), 0);
        assert_eq!(faults("x.wgsl", "fn f() {}\n"), 0);
        for bad in [
            "fn f() {}",
            "fn f() {}\n\n",
            "\tfn f() {}\n",
            "fn f() {} \n",
            concat!("// TO", "DO\n"),
            concat!("// FIX", "ME\n"),
            concat!("// XX", "X\n"),
            concat!("#[ig", "nore]\nfn f() {}\n"),
        ] {
            assert_eq!(faults("x.rs", bad), 1, "{bad}");
        }
    }
}
