//! `wgsl`: arguments.

use clap::Args;
use std::path::PathBuf;

#[derive(Args, Clone, Debug, PartialEq)]
#[command(after_help = "Examples:
  cargo xtask wgsl hard                            with the default settings
  cargo xtask wgsl --preset street.preset.toml     with settings from a file
  cargo xtask wgsl pcf --prefix sun_ > sun.wgsl    with a prefix of yours before each name")]
pub(crate) struct WgslArguments {
    /// The technique
    #[arg(
        value_name = "NAME",
        required_unless_present = "preset",
        conflicts_with = "preset"
    )]
    pub(crate) name: Option<String>,
    /// File with the settings of a technique, as `plan` writes it
    #[arg(long, value_name = "FILE")]
    pub(crate) preset: Option<PathBuf>,
    /// What each name of the text begins with
    #[arg(long, value_name = "TEXT", default_value = "shadow_")]
    pub(crate) prefix: String,
}
