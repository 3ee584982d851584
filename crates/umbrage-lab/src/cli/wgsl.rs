//! `wgsl`: prints the shader text of a technique.

use crate::assembled_wgsl;
use crate::cli::{args::WgslArguments, presets, program::Program};
use anyhow::Result;
use umbrage_techniques::TechniquePreset;

/// Prints the text that a user pastes into a shader; errors if there is no such technique.
pub(crate) fn wgsl(program: &Program, arguments: &WgslArguments) -> Result<()> {
    let preset = chosen(program, arguments)?;
    let text = assembled_wgsl(&*preset.technique(), &arguments.prefix)?;
    println!("{}", text.trim_end());
    Ok(())
}

fn chosen(program: &Program, arguments: &WgslArguments) -> Result<TechniquePreset> {
    if let Some(file) = &arguments.preset {
        return Ok(presets::one(program, file)?.preset);
    }
    let names: Vec<String> = arguments.name.iter().cloned().collect();
    let entries = program.catalogue.select(&names)?;
    Ok((entries[0].technique.preset)())
}
