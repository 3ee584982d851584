//! `merge`, and the shards that it joins.

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
    /// Folder of a `stability` run, or its results.json: the report says beside each setting which rows it fails
    #[arg(long, value_name = "FOLDER")]
    pub(crate) stability: Option<PathBuf>,
}

/// The `k`-th of `n` parts, from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shard {
    pub(crate) k: usize,
    pub(crate) n: usize,
}

impl Shard {
    /// Whether the scene in this place, from 0, belongs to it. Neighbours in the list are alike and cost alike, so they
    /// go to different shards.
    pub(crate) fn takes(self, index: usize) -> bool {
        index % self.n == self.k - 1
    }
}

pub(super) fn parse_shard(text: &str) -> Result<Shard, String> {
    let parts = text.split_once('/').and_then(|(k, n)| {
        Some(Shard {
            k: k.parse().ok()?,
            n: n.parse().ok()?,
        })
    });
    match parts {
        Some(shard) if (1..=shard.n).contains(&shard.k) => Ok(shard),
        Some(_) => Err("K must be 1 to N".to_owned()),
        None => Err("write the shard and their number like 2/8".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_are_whole_numbers_within_their_number() {
        assert_eq!(parse_shard("2/8"), Ok(Shard { k: 2, n: 8 }));
        for wrong in ["0/8", "9/8", "1/0", "-1/8", "2", "a/b", "1/2/3", ""] {
            assert!(parse_shard(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn every_scene_belongs_to_one_shard() {
        for index in 0..20 {
            let takers = (1..=3).filter(|&k| Shard { k, n: 3 }.takes(index)).count();
            assert_eq!(takers, 1, "{index}");
        }
    }
}
