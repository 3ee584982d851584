//! Tests of the statements in `docs` about code, scenes and techniques.

use std::{fs, path::Path};
use umbrage::{
    glam::UVec2,
    scenes::{self, Kind, motion::MovingScene},
    techniques,
};
use umbrage_examples::failures::failures;
use umbrage_lab::{card, stability};

/// The pages that quote code, and their least number of quotations.
const QUOTING: [(&str, usize); 4] = [
    ("README.md", 2),
    ("docs/add_shadows.md", 9),
    ("docs/light_sets.md", 2),
    ("docs/write_a_technique.md", 16),
];
/// Start of the line before each quotation, which has the name of its file.
const QUOTED: &str = "<!-- quoted from ";

/// A part of a file on a page.
struct Quotation {
    file: String,
    text: String,
}

/// Returns all quotations.
///
/// Panics if code without the name of its file is found.
fn quotations(page: &str) -> Vec<Quotation> {
    let mut out = Vec::new();
    let mut lines = page.lines();
    let mut before = "";
    while let Some(line) = lines.next() {
        if line == "```rust" || line == "```wgsl" {
            let file = before
                .strip_prefix(QUOTED)
                .and_then(|rest| rest.strip_suffix(" -->"))
                .unwrap_or_else(|| panic!("no file is named before {line} behind `{before}`"));
            let quoted: Vec<&str> = lines.by_ref().take_while(|&line| line != "```").collect();
            out.push(Quotation {
                file: file.to_owned(),
                text: quoted.join("\n"),
            });
        }
        before = line;
    }
    out
}

/// Reports whether the file has these lines, all with the same indentation.
fn has_lines(file: &str, text: &str) -> bool {
    (0..8).any(|tabs| {
        let indentation = "    ".repeat(tabs);
        let indented = |line: &str| {
            if line.is_empty() {
                String::new()
            } else {
                format!("{indentation}{line}")
            }
        };
        let lines: Vec<String> = text.lines().map(indented).collect();
        format!("\n{file}").contains(&format!("\n{}\n", lines.join("\n")))
    })
}

#[test]
fn pages_quote_code_to_the_letter() {
    for (page, least) in QUOTING {
        let quotations = quotations(&read(page));
        assert!(quotations.len() >= least, "{page}: {}", quotations.len());
        for Quotation { file, text } in quotations {
            assert!(
                has_lines(&read(&file), &text),
                "{page} quotes text that isn't in {file}; update the quotation:\n{text}"
            );
        }
    }
}

#[test]
fn a_changed_quotation_is_seen() {
    let file = "fn f() {\n    g(1);\n}\n";
    assert!(has_lines(file, "g(1);"));
    assert!(!has_lines(file, "g(2);"));
    assert!(!has_lines(file, "g(1)"), "part of a line");
    let page = "<!-- quoted from a.rs -->\n```rust\ng(1);\n```\n";
    assert_eq!(quotations(page)[0].file, "a.rs");
    let unnamed = std::panic::catch_unwind(|| quotations("```rust\ng(1);\n```\n"));
    assert!(unnamed.is_err(), "code whose file isn't named");
}

/// Returns a file of the repository.
fn read(path: &str) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    fs::read_to_string(root.join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// Returns the error of a link to the viewer, from `?` on.
fn fault_of_query(query: &str) -> Option<String> {
    for pair in query.trim_start_matches('?').split('&') {
        let (key, value) = pair.split_once('=').unwrap_or((pair, ""));
        let is_known = match key {
            "scene" => scenes::find(value).is_some(),
            "failure" => {
                let mut moving = MovingScene::ALL.iter();
                scenes::find(value).is_some_and(|entry| matches!(entry.kind, Kind::Failure(_)))
                    || moving.any(|moving| moving.name == value)
            }
            "left" | "right" => techniques::find(value).is_some(),
            "split" => value
                .parse::<f32>()
                .is_ok_and(|at| (0.0..=1.0).contains(&at)),
            "over" => [
                "nothing", "error", "truth", "mask", "texels", "cascades", "lists",
            ]
            .contains(&value),
            _ => false,
        };
        if !is_known {
            return Some(format!("`{pair}`"));
        }
    }
    None
}

/// The site's links to the viewer name existing scenes and techniques. The viewer itself would
/// replace others and show a message.
#[test]
fn links_to_the_viewer_name_what_there_is() {
    let mut links = 0;
    for page in ["docs/live.md", "docs/failures.md"] {
        let text = read(page);
        for after in text.split("live.md?").skip(1) {
            let query = after.split(')').next().unwrap_or("");
            assert_eq!(fault_of_query(query), None, "{page}");
            links += 1;
        }
        for after in text.split("<!-- viewer: ").skip(1) {
            let query = after.split(" -->").next().unwrap_or("");
            assert_eq!(fault_of_query(query), None, "{page}");
        }
    }
    assert!(links > 15, "{links}");
    for bad in [
        "scene=nowhere",
        "failure=cubes",
        "scene=cubes&left=magic",
        "over=all",
        "scenes=cubes",
    ] {
        assert!(fault_of_query(bad).is_some(), "{bad}");
    }
}

/// Each artefact of the page has a heading, its images, a description of its settings, the row that
/// detects it, and a link to its scene.
#[test]
fn the_page_of_failures_shows_each_of_them() {
    let page = read("docs/failures.md");
    let titles: Vec<&str> = stability::rows().iter().map(|row| row.title).collect();
    for failure in failures() {
        let name = failure.name;
        assert!(titles.contains(&failure.row), "{name}: {}", failure.row);
        let scene = failure.scene;
        for text in [
            format!("\n## {}\n", failure.title),
            format!("(failures/{name}.png)"),
            format!(
                "Left: {}; right: {}.",
                failure.fault.words, failure.cure.words
            ),
            format!("Row: **{}**", failure.row),
        ] {
            assert!(page.contains(&text), "docs/failures.md lacks {text}");
        }
        let links = ["scene", "failure"].map(|key| format!("(live.md?{key}={scene}"));
        assert!(
            links.iter().any(|link| page.contains(link)),
            "docs/failures.md has no link to {scene}"
        );
    }
}

/// In every example, the fix has a far smaller error than the artefact, and the page's table has
/// both errors.
#[test]
fn cures_are_better_than_faults() {
    let page = read("docs/failures.md");
    let size = UVec2::new(160, 120);
    for failure in failures() {
        let name = failure.name;
        assert!(page.contains(&format!("| `{}` |", failure.scene)), "{name}");
        let scene = umbrage::scenes::by_argument(failure.scene).expect("built in");
        // Skip area lights, whose reference takes long. Their figures are those of the command that
        // writes the page.
        if !scene.lights[0].is_ideal() {
            continue;
        }
        let rendered = failure.render(size).expect("valid");
        let [fault, cure] = [rendered.fault.rmse, rendered.cure.rmse];
        assert!(cure < 0.9 * fault, "{name}: {cure} against {fault}");
    }
}

/// The page of graphics cards is the output of `cargo xtask card --page`, and has no invented
/// figures.
#[test]
fn the_page_of_cards_shows_what_is_committed() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
    let cards = card::read_all(&docs.join("cards")).expect("cards");
    assert!(cards.len() >= 2, "only {} cards", cards.len());
    let page = fs::read_to_string(docs.join("cards.md")).expect("the page");
    assert_eq!(
        page,
        card::page(&cards),
        "rewrite it: cargo xtask card --page"
    );
    // The README's statement of equal bits needs a card without differences.
    let has_equal_bits = |card: &card::Card| {
        let agreement = card.agreement.as_ref();
        let techniques = card::exact_techniques();
        agreement.is_some_and(|a| {
            techniques
                .iter()
                .all(|t| a.differing_bits.get(t.name()) == Some(&0))
        })
    };
    assert!(cards.iter().any(|c| !c.is_software && has_equal_bits(c)));
}
