//! `wgsl`: prints the shader text of a technique.

use crate::{
    assembled::assembled_wgsl,
    cli::{presets, program::Program},
};
use anyhow::Result;
use clap::Args;
use std::path::PathBuf;
use umbrage_techniques::TechniquePreset;

#[derive(Args, Clone, Debug, PartialEq)]
#[command(after_help = "Examples:
  cargo xtask wgsl hard                            default settings
  cargo xtask wgsl --preset street.preset.toml     settings from a file
  cargo xtask wgsl pcf --prefix sun_ > sun.wgsl    all names begin with `sun_`")]
pub(crate) struct WgslArguments {
    /// Name of the technique
    #[arg(
        value_name = "NAME",
        required_unless_present = "preset",
        conflicts_with = "preset"
    )]
    pub(crate) name: Option<String>,
    /// Preset file, as written by `plan`
    #[arg(long, value_name = "FILE")]
    pub(crate) preset: Option<PathBuf>,
    /// Prefix of all names in the text
    #[arg(long, value_name = "TEXT", default_value = "shadow_")]
    pub(crate) prefix: String,
}

/// Prints the text to paste into a shader. Errors if there is no such technique.
pub(crate) fn wgsl(program: &Program, arguments: &WgslArguments) -> Result<()> {
    let preset = chosen_preset(program, arguments)?;
    let text = assembled_wgsl(&*preset.technique(), &arguments.prefix)?;
    println!("{}", text.trim_end());
    Ok(())
}

fn chosen_preset(program: &Program, arguments: &WgslArguments) -> Result<TechniquePreset> {
    if let Some(file) = &arguments.preset {
        return Ok(presets::one(program, file)?.preset);
    }
    let names: Vec<String> = arguments.name.iter().cloned().collect();
    let entries = program.catalogue.select(&names)?;
    Ok((entries[0].technique.preset)())
}
