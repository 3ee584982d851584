//! The images and figures of `docs/failures.md`.

use anyhow::{Context as _, Result};
use std::{fmt::Write as _, fs, path::Path};
use umbrage::metrics::Errors;
use umbrage_examples::failures::{SIZE, failures};

const PAGE: &str = "docs/failures.md";
const BEGINS: &str =
    "<!-- figures: written by `cargo run --release --example gallery -- failures` -->\n";
const ENDS: &str = "<!-- end of figures -->";

pub(crate) fn write(given: Option<&Path>) -> Result<()> {
    let folder = given.unwrap_or(Path::new("docs/failures"));
    let mut table =
        String::from("| fault | scene | no shadow | fault | cure |\n|---|---|--:|--:|--:|\n");
    for failure in failures() {
        let name = failure.name;
        let rendered = failure.render(SIZE).with_context(|| format!("in {name}"))?;
        rendered.images.save(&folder.join(format!("{name}.png")))?;
        let [none, fault, cure] = [&rendered.no_shadow, &rendered.fault, &rendered.cure].map(label);
        println!("{name}: no shadow {none}, fault {fault}, cure {cure}");
        // Titles only have letters and spaces, so this matches the anchors of headings.
        let anchor = failure.title.to_lowercase().replace(' ', "-");
        let link = format!("[{}](#{anchor})", failure.title);
        let scene = failure.scene;
        writeln!(table, "| {link} | `{scene}` | {none} | {fault} | {cure} |")?;
    }
    if given.is_none() {
        write_table(&table)?;
        println!("figures: {PAGE}");
    }
    Ok(())
}

/// Formats the root mean square error.
fn label(errors: &Errors) -> String {
    match errors.rmse {
        0.0 => "0".to_owned(),
        rmse => format!("{rmse:.3}").trim_start_matches('0').to_owned(),
    }
}

/// Writes the table between its marks.
fn write_table(table: &str) -> Result<()> {
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
