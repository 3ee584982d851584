//! `wgsl`: prints the shader text of a technique.

use crate::cli::{args::WgslArguments, presets, program::Program, usage::Usage};
use crate::{LabError, assembled_wgsl};
use anyhow::Result;
use umbrage_techniques::TechniquePreset;

/// Prints the text that a user pastes into a shader; errors if there is no such technique.
pub(crate) fn wgsl(program: &Program, arguments: &WgslArguments) -> Result<()> {
    let preset = chosen(program, arguments)?;
    let text = assembled_wgsl(&*preset.technique(), &arguments.prefix);
    print!("{}", text.map_err(in_usage)?);
    Ok(())
}

fn chosen(program: &Program, arguments: &WgslArguments) -> Result<TechniquePreset> {
    if let Some(file) = &arguments.preset {
        return Ok(presets::one(program, file)?.preset);
    }
    let names: Vec<String> = arguments.name.iter().cloned().collect();
    let entries = program.catalogue.select(&names);
    let entries = entries.map_err(|e| Usage(e.to_string()))?;
    Ok((entries[0].technique.preset)())
}

fn in_usage(error: LabError) -> anyhow::Error {
    match error {
        LabError::Invalid(e) => Usage(e.to_string()).into(),
        LabError::Plan(e) => Usage(e.to_string()).into(),
        e => e.into(),
    }
}
