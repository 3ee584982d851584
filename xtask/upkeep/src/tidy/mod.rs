//! House style that no linter knows: short functions, short files, nothing left for later.

mod files;
mod functions;
mod rules;
mod wgsl;

use crate::run::root;
use anyhow::{Result, bail};
use comfy_table::Table;
use files::Source;

/// Longest Rust function, Rust file, WGSL function and WGSL file, lines.
const LIMITS: [(&str, usize); 4] = [
    ("Rust functions", 70),
    ("Rust files", 450),
    ("WGSL functions", 70),
    ("WGSL files", 200),
];

/// A length in lines, and whose.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Length {
    lines: usize,
    /// `path:line name`
    place: String,
}

/// Prints the table of lengths, and objects to what is too long or against the rules.
pub(crate) fn tidy() -> Result<()> {
    let sources = files::read_all(root())?;
    let lengths = measure(&sources)?;
    println!("{}", table(&lengths));
    let mut faults: Vec<String> = sources.iter().flat_map(rules::faults).collect();
    faults.extend(too_long(&lengths));
    if faults.is_empty() {
        println!("tidy: {} files, nothing to object to", sources.len());
        return Ok(());
    }
    bail!("tidy objects:\n  {}", faults.join("\n  "))
}

/// Lengths of the four kinds, in the order of [`LIMITS`], sorted.
fn measure(sources: &[Source]) -> Result<[Vec<Length>; 4]> {
    let mut out: [Vec<Length>; 4] = Default::default();
    for source in sources {
        let file = Length {
            lines: source.text.lines().count(),
            place: source.path.clone(),
        };
        match source.extension() {
            "rs" => {
                out[0].extend(functions::lengths(source)?);
                out[1].push(file);
            }
            "wgsl" => {
                out[2].extend(wgsl::lengths(source));
                out[3].push(file);
            }
            _ => {}
        }
    }
    out.iter_mut().for_each(|lengths| lengths.sort());
    Ok(out)
}

fn table(lengths: &[Vec<Length>; 4]) -> Table {
    let mut table = Table::new();
    table.set_header([
        "lines of",
        "count",
        "median",
        "90 %",
        "longest",
        "limit",
        "the longest",
    ]);
    for ((name, limit), lengths) in LIMITS.iter().zip(lengths) {
        let at = |part: usize| {
            lengths.get((lengths.len() * part / 100).min(lengths.len().saturating_sub(1)))
        };
        let lines = |part| at(part).map_or_else(|| "-".to_owned(), |l| l.lines.to_string());
        let longest = at(100).map_or("-", |l| &l.place);
        let (count, limit) = (lengths.len().to_string(), limit.to_string());
        table.add_row([
            *name,
            &count,
            &lines(50),
            &lines(90),
            &lines(100),
            &limit,
            longest,
        ]);
    }
    table
}

fn too_long(lengths: &[Vec<Length>; 4]) -> Vec<String> {
    let over = LIMITS
        .iter()
        .zip(lengths)
        .flat_map(|((name, limit), lengths)| {
            lengths
                .iter()
                .filter(move |l| l.lines > *limit)
                .map(move |l| {
                    format!(
                        "{}: {} lines, and {name} may have {limit}: split it",
                        l.place, l.lines
                    )
                })
        });
    over.collect()
}

#[cfg(test)]
mod tests {
    use super::{Source, measure, too_long};

    fn faults(path: &str, text: String) -> Vec<String> {
        too_long(
            &measure(&[Source {
                path: path.to_owned(),
                text,
            }])
            .expect("good code"),
        )
    }

    #[test]
    fn long_functions_and_files_are_refused() {
        let function = |lines: usize| format!("fn f() {{\n{}}}\n", "    g();\n".repeat(lines - 2));
        assert_eq!(faults("a.rs", function(70)), Vec::<String>::new());
        assert_eq!(faults("a.rs", function(71)).len(), 1);
        assert_eq!(faults("a.wgsl", function(71)).len(), 1);
        assert_eq!(faults("a.rs", function(70).repeat(7)).len(), 1, "490 lines");
        assert_eq!(
            faults("a.wgsl", function(67).repeat(3)).len(),
            1,
            "201 lines"
        );
    }
}
