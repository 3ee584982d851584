//! `merge`: joins the reports of shards into one.

use crate::{
    cli::{compare, verdicts},
    report::merge as join,
};
use anyhow::Result;
use clap::Args;
use std::path::PathBuf;

#[derive(Args, Clone, Debug, PartialEq)]
#[command(after_help = "Examples:
  cargo xtask merge s1 s2 s3 --out report    one report of three shards of `compare --shard`
  cargo xtask merge shards/* --out report    the same for any number of shards")]
pub(crate) struct MergeArguments {
    /// Folders written by `compare --shard`
    #[arg(value_name = "FOLDER", required = true)]
    pub(crate) folders: Vec<PathBuf>,
    /// Folder for the joined report
    #[arg(long, value_name = "FOLDER")]
    pub(crate) out: PathBuf,
    /// Folder or results.json of a `stability` run: the report lists the failed rows of each
    /// setting
    #[arg(long, value_name = "FOLDER")]
    pub(crate) stability: Option<PathBuf>,
}

/// Joins the reports. Errors if any shard has faults.
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
