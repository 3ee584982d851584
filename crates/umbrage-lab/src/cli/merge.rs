//! `merge`: shards in, one report out.

use crate::{
    cli::{compare, verdicts},
    report::merge as join,
};
use anyhow::Result;
use clap::Args;
use std::path::PathBuf;

#[derive(Args, Clone, Debug, PartialEq)]
#[command(after_help = "Examples:
  cargo xtask merge s1 s2 s3 --out report    one report of three shards of `cargo xtask compare --shard`
  cargo xtask merge shards/* --out report    the same, whatever their number")]
pub(crate) struct MergeArguments {
    /// Folders that `cargo xtask compare --shard` wrote
    #[arg(value_name = "FOLDER", required = true)]
    pub(crate) folders: Vec<PathBuf>,
    /// Folder for the whole report
    #[arg(long, value_name = "FOLDER")]
    pub(crate) out: PathBuf,
    /// Folder of a `stability` run, or its results.json: the report says beside each setting which
    /// rows it fails
    #[arg(long, value_name = "FOLDER")]
    pub(crate) stability: Option<PathBuf>,
}

/// Joins, and fails if any shard had faults.
pub(crate) fn merge(options: &MergeArguments) -> Result<()> {
    let stability = match &options.stability {
        Some(path) => Some(verdicts::read(path)?),
        None => None,
    };
    let (comparison, page) = join(&options.folders, &options.out, stability.as_ref())?;
    println!(
        "{} scenes of {} folders",
        comparison.scenes.len(),
        options.folders.len()
    );
    compare::conclude(&comparison, stability.as_ref(), &page);
    compare::verdict(&comparison)
}
