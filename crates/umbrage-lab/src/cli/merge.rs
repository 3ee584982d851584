//! `merge`: shards in, one report out.

use crate::cli::{args::MergeArguments, verdicts};
use crate::report::merge as join;
use anyhow::Result;

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
    crate::cli::compare::conclude(&comparison, stability.as_ref(), &page);
    crate::cli::compare::verdict(&comparison)
}
