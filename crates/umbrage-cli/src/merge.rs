//! `merge`: shards in, one report out.

use crate::args::MergeArguments;
use anyhow::Result;
use umbrage_lab::report::merge as join;

/// Joins, and fails if any shard had faults.
pub(crate) fn merge(options: &MergeArguments) -> Result<()> {
    let (comparison, page) = join(&options.folders, &options.out)?;
    println!(
        "{} scenes of {} folders",
        comparison.scenes.len(),
        options.folders.len()
    );
    crate::compare::conclude(&comparison, &page);
    crate::compare::verdict(&comparison)
}
