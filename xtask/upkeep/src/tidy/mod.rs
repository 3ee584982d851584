//! House style that no linter knows: functions and files that are not too long, code that is not too dense, one meaning for every
//! type name, nothing left for later.

pub(crate) mod files;
mod functions;
mod names;
mod rules;
mod tokens;
mod wgsl;

use crate::run::root;
use anyhow::{Result, bail};
use comfy_table::Table;
use files::Source;
use tokens::Tokens;

/// What is measured, and its bound. Density counts the tokens of a file over its lines of code, comments apart.
const LIMITS: [(&str, usize); 6] = [
    ("tokens of Rust functions", 850),
    ("lines of Rust functions", 220),
    ("lines of Rust files", 700),
    ("tokens a line of Rust files", 14),
    ("lines of WGSL functions", 70),
    ("lines of WGSL files", 200),
];

/// Files with fewer lines of code are too short to have a density.
const LINES_FOR_DENSITY: usize = 30;

/// A size, and whose.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Length {
    size: usize,
    /// `path:line name`
    place: String,
}

/// Sizes of each kind, in the order of [`LIMITS`].
type Lengths = [Vec<Length>; LIMITS.len()];

/// Prints the table of sizes; errors if anything is too large or against the rules.
pub(crate) fn tidy() -> Result<()> {
    let sources = files::read_all(root())?;
    let lengths = measure(&sources)?;
    println!("{}", table(&lengths));
    let mut faults: Vec<String> = sources.iter().flat_map(rules::faults).collect();
    faults.extend(names::faults(&sources));
    faults.extend(too_long(&lengths));
    if faults.is_empty() {
        println!("tidy: {} files, nothing to object to", sources.len());
        return Ok(());
    }
    bail!("tidy objects:\n  {}", faults.join("\n  "))
}

/// Returns all sizes, sorted.
fn measure(sources: &[Source]) -> Result<Lengths> {
    let mut out = Lengths::default();
    for source in sources {
        match source.extension() {
            "rs" => measure_rust(source, &mut out)?,
            "wgsl" => {
                out[4].extend(wgsl::lengths(source));
                out[5].push(lines_of(source));
            }
            _ => {}
        }
    }
    out.iter_mut().for_each(|lengths| lengths.sort());
    Ok(out)
}

fn measure_rust(source: &Source, out: &mut Lengths) -> Result<()> {
    let tokens = Tokens::of(source)?;
    for function in functions::all(source)? {
        out[0].push(Length {
            size: tokens.within(function.first_line, function.last_line),
            place: function.place.clone(),
        });
        out[1].push(Length {
            size: function.last_line - function.first_line + 1,
            place: function.place,
        });
    }
    out[2].push(lines_of(source));
    let (count, lines) = tokens.counts();
    if lines >= LINES_FOR_DENSITY {
        out[3].push(Length {
            size: (count as f64 / lines as f64).round() as usize,
            place: source.path.clone(),
        });
    }
    Ok(())
}

fn lines_of(source: &Source) -> Length {
    Length {
        size: source.text.lines().count(),
        place: source.path.clone(),
    }
}

fn table(lengths: &Lengths) -> Table {
    let mut table = Table::new();
    table.set_header(["", "count", "median", "90 %", "most", "limit", "the most"]);
    for ((name, limit), lengths) in LIMITS.iter().zip(lengths) {
        let longest = percentile(lengths, 100);
        table.add_row([
            (*name).to_owned(),
            lengths.len().to_string(),
            size(percentile(lengths, 50)),
            size(percentile(lengths, 90)),
            size(longest),
            limit.to_string(),
            longest.map_or_else(|| "-".to_owned(), |length| length.place.clone()),
        ]);
    }
    table
}

/// Returns the length than which this percentage is shorter, of sorted lengths; none without lengths.
fn percentile(sorted: &[Length], percent: usize) -> Option<&Length> {
    let last = sorted.len().checked_sub(1)?;
    sorted.get((sorted.len() * percent / 100).min(last))
}

fn size(length: Option<&Length>) -> String {
    length.map_or_else(|| "-".to_owned(), |length| length.size.to_string())
}

fn too_long(lengths: &Lengths) -> Vec<String> {
    let mut faults = Vec::new();
    for ((name, limit), lengths) in LIMITS.iter().zip(lengths) {
        for length in lengths.iter().filter(|l| l.size > *limit) {
            faults.push(format!(
                "{}: {} {name}, and {limit} are allowed: split it",
                length.place, length.size
            ));
        }
    }
    faults
}

#[cfg(test)]
mod tests {
    use super::{Source, measure, too_long};

    fn faults(path: &str, text: String) -> Vec<String> {
        let source = Source {
            path: path.to_owned(),
            text,
        };
        too_long(&measure(&[source]).expect("good code"))
    }

    fn function(lines: usize, line: &str) -> String {
        format!("fn f() {{\n{}}}\n", line.repeat(lines - 2))
    }

    #[test]
    fn long_functions_and_files_are_refused() {
        let rust = |lines| function(lines, "    g;\n");
        assert_eq!(faults("a.rs", rust(220)), Vec::<String>::new());
        assert_eq!(faults("a.rs", rust(221)).len(), 1);
        assert_eq!(faults("a.rs", rust(101).repeat(7)).len(), 1, "707 lines");
        assert_eq!(faults("a.wgsl", function(71, "    g();\n")).len(), 1);
        assert_eq!(
            faults("a.wgsl", function(67, "    g();\n").repeat(3)).len(),
            1,
            "201 lines"
        );
    }

    #[test]
    fn dense_code_is_refused() {
        let calls = "g(); ".repeat(5) + "\n";
        assert_eq!(
            faults("a.rs", function(30, &calls)).len(),
            1,
            "20 tokens a line"
        );
        let many = "    g(1, 2, 3);\n";
        assert_eq!(
            faults("a.rs", function(110, many)).len(),
            1,
            "over 850 tokens"
        );
    }
}
