//! The pictures and figures of `docs/failures.md`: `cargo run --release --example failures [FOLDER]`.
//!
//! Writes pictures into the folder, `docs/failures` if none is given, and then also the page's table of figures.

use anyhow::Context as _;
use std::{fmt::Write as _, fs, path::Path};
use umbrage_examples::failures::{PlayedFailure, PlayedSide, SIZE, failures};

const FOLDER: &str = "docs/failures";
const PAGE: &str = "docs/failures.md";
const BEGINS: &str = "<!-- figures: written by `cargo run --release --example failures` -->\n";
const ENDS: &str = "<!-- end of figures -->";

fn main() -> anyhow::Result<()> {
    let given = std::env::args().nth(1);
    let folder = Path::new(given.as_deref().unwrap_or(FOLDER));
    fs::create_dir_all(folder)
        .with_context(|| format!("cannot make the folder {}", folder.display()))?;
    let mut table =
        String::from("| fault | scene | no shadow | fault | cure |\n|---|---|--:|--:|--:|\n");
    for failure in failures() {
        let played = failure
            .play(SIZE)
            .with_context(|| format!("in {}", failure.name))?;
        for (half, side) in [("fault", &played.fault), ("cure", &played.cure)] {
            write(folder, &format!("{}.{half}", failure.name), side)?;
        }
        let [none, fault, cure] = figures(&played);
        println!(
            "{}: no shadow {none}, fault {fault}, cure {cure}",
            failure.name
        );
        // As addresses name headings; titles have no other signs than these.
        let anchor = failure.title.to_lowercase().replace(' ', "-");
        let link = format!("[{}](#{anchor})", failure.title);
        writeln!(
            table,
            "| {link} | `{}` | {none} | {fault} | {cure} |",
            failure.scene
        )?;
    }
    println!("pictures: {}", folder.display());
    if given.is_none() {
        write_table(&table)?;
        println!("figures: {PAGE}");
    }
    Ok(())
}

/// Returns the root mean square errors of no shadow, of the fault and of the cure, in words.
fn figures(played: &PlayedFailure) -> [String; 3] {
    let all = [&played.no_shadow, &played.fault.errors, &played.cure.errors];
    all.map(|errors| match errors.rmse {
        0.0 => "0".to_owned(),
        rmse => format!("{rmse:.3}").trim_start_matches('0').to_owned(),
    })
}

fn write(folder: &Path, name: &str, side: &PlayedSide) -> anyhow::Result<()> {
    for (what, png) in [("", &side.mask), (".error", &side.error)] {
        let path = folder.join(format!("{name}{what}.png"));
        fs::write(&path, png).with_context(|| format!("cannot write {}", path.display()))?;
    }
    Ok(())
}

/// Puts the table between its marks.
fn write_table(table: &str) -> anyhow::Result<()> {
    let page = fs::read_to_string(PAGE).with_context(|| format!("cannot read {PAGE}"))?;
    let parts = page.split_once(BEGINS).and_then(|(before, rest)| {
        let (_, after) = rest.split_once(ENDS)?;
        Some((before, after))
    });
    let (before, after) = parts.with_context(|| {
        format!(
            "{PAGE} has no place for the figures: put the lines `{BEGINS}` and `{ENDS}` into it"
        )
    })?;
    fs::write(PAGE, format!("{before}{BEGINS}{table}{ENDS}{after}"))
        .with_context(|| format!("cannot write {PAGE}"))
}
