//! Arguments of several commands.

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum BackendName {
    /// The CPU, and wgpu if there is a graphics adapter
    Available,
    /// CPU only
    Cpu,
    /// wgpu only; fails without a graphics adapter
    Wgpu,
    /// Both; fails without a graphics adapter
    Both,
}

/// Parses an image size such as `640x480`.
pub(crate) fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let sides = text
        .split_once('x')
        .and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    match sides {
        Some(size) if size.iter().all(|s| (1..=16_384).contains(s)) => Ok(size),
        Some(_) => Err("each side must be 1 to 16384 pixels".to_owned()),
        None => Err("write width and height like 640x480".to_owned()),
    }
}

/// The `k`-th of `n` parts, from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shard {
    pub(crate) k: usize,
    pub(crate) n: usize,
}

impl Shard {
    /// Reports whether the scene with this index, from 0, belongs to the shard. Neighbours in the
    /// list have similar costs, so they go to different shards.
    pub(crate) fn takes(self, index: usize) -> bool {
        index % self.n == self.k - 1
    }
}

/// Parses a shard such as `2/8`.
pub(crate) fn parse_shard(text: &str) -> Result<Shard, String> {
    let parts = text.split_once('/').and_then(|(k, n)| {
        Some(Shard {
            k: k.parse().ok()?,
            n: n.parse().ok()?,
        })
    });
    match parts {
        Some(shard) if (1..=shard.n).contains(&shard.k) => Ok(shard),
        Some(_) => Err("K must be 1 to N".to_owned()),
        None => Err("write the shard and the number of shards like 2/8".to_owned()),
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
