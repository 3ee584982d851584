//! `bias`: arguments.

use super::{Backend, parse_size};
use clap::Args;
use std::path::PathBuf;

#[derive(Args, Clone, Debug, PartialEq)]
#[command(after_help = "Examples:
  cargo xtask bias                                the built-in scenes under ideal lights
  cargo xtask bias stairs town --sides 2048       two scenes, one map size
  cargo xtask bias bunny.obj --backend cpu        a model on a floor, under two suns, a spot and a bulb
  cargo xtask bias room.glb#night                 a model under its own lights, where it has some")]
pub(crate) struct BiasArguments {
    /// Built-in scenes by name, scene files (.toml) or models (.obj, .glb, .gltf); none: all built-in scenes
    ///
    /// All under their own lights as if they had no size; a model that brings none stands on a floor under four.
    #[arg(value_name = "SCENE")]
    pub(crate) scenes: Vec<String>,
    /// Which backends play the default bias; its rivals are played on the CPU
    #[arg(long, value_name = "NAME", default_value = "available")]
    pub(crate) backend: Backend,
    /// Graphics adapter by part of its name, such as llvmpipe
    #[arg(long, value_name = "NAME")]
    pub(crate) adapter: Option<String>,
    /// Image size in pixels; else each scene's own
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub(crate) size: Option<[u32; 2]>,
    /// Sides of the shadow maps, texels; else 512 and 2048
    #[arg(long, value_name = "SIDE", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(1..=16_384))]
    pub(crate) sides: Vec<u32>,
    /// Folder for the tables; else target/bias in the repository
    #[arg(long, value_name = "FOLDER")]
    pub(crate) out: Option<PathBuf>,
}
