//! `merge`: shards in, one report out.

use crate::{args::MergeArguments, verdicts};
use anyhow::Result;
use umbrage_lab::report::merge as join;

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
    crate::compare::conclude(&comparison, stability.as_ref(), &page);
    crate::compare::verdict(&comparison)
}
