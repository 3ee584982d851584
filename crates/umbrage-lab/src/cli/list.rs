//! `list`: prints the scenes and techniques that can be compared.

use crate::cli::program::Program;
use anyhow::Result;
use comfy_table::{Table, presets::NOTHING};

/// Prints the built-in scenes and the techniques.
pub(crate) fn list(program: &Program) -> Result<()> {
    let mut scenes = Table::new();
    scenes
        .load_style(NOTHING)
        .set_header(["scene", "", "kind", "what it shows"]);
    for entry in umbrage_scenes::all() {
        let suite = if entry.suite { "" } else { "by name only" };
        scenes.add_row([entry.name, suite, &entry.kind.to_string(), entry.summary]);
    }
    let mut techniques = Table::new();
    techniques
        .load_style(NOTHING)
        .set_header(["technique", "what it does"]);
    for entry in program.catalogue.all() {
        techniques.add_row([entry.technique.name, entry.technique.summary]);
    }
    println!(
        "{scenes}\n\n{techniques}\n\nOr give the path of a scene file (.toml) or a model (.obj, .glb, .gltf)."
    );
    Ok(())
}
