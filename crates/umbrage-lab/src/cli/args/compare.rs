//! Arguments of `compare`.

use super::{Backend, Shard, merge::parse_shard, parse_size};
use clap::Args;
use std::path::PathBuf;
use umbrage_techniques::SOFT_ERRORS;

#[derive(Args, Clone, Debug, PartialEq)]
#[command(after_help = "Examples:
  cargo xtask compare                                        the built-in suite: frames of real size, then checks
  cargo xtask compare --full                                 the same with every setting, every pixel judged: hours
  cargo xtask compare street nave-soft --all-moves           two frames; charts count what is made anew if all moves
  cargo xtask compare --list                                 what there is to compare
  cargo xtask compare cubes --technique pcf --backend cpu    one scene, technique and backend
  cargo xtask compare lamp.toml model.obj --quick            scenes of your own, small and fast
  cargo xtask compare 'model.glb#night'                      one of a glTF file's scenes, by its name or number
  cargo xtask compare cubes --preset mine.toml               settings of your own, or of `plan`
  cargo xtask compare nave-soft --max-error 0.02             `soft` with an error of your own
  cargo xtask compare cubes --size 640x480 --map-sizes 512,2048 --arrays --out report
  cargo xtask compare figure --color --map-sizes 1024        with shaded pictures
  cargo xtask compare --deterministic --shard 2/8 --out s2   an eighth of the suite, for `cargo xtask merge`
  cargo xtask compare --stability target/stability           and what each setting fails there
  cargo xtask compare --baseline old/results.json            fail if anything got slower or less accurate")]
pub(crate) struct CompareArguments {
    /// Built-in scenes by name, scene files (.toml) or models (.obj, .glb, .gltf); none: the built-in suite
    #[arg(value_name = "SCENE")]
    pub(crate) scenes: Vec<String>,
    /// Only these techniques; may be repeated, or separated by commas
    #[arg(long = "technique", value_name = "NAME", value_delimiter = ',')]
    pub(crate) techniques: Vec<String>,
    /// A technique with settings of your own, as `plan` writes it (.preset.toml), played beside the others under its file's name; may be
    /// repeated. `--technique none,hard` leaves these beside it
    #[arg(long = "preset", value_name = "FILE")]
    pub(crate) presets: Vec<PathBuf>,
    /// `soft` with this root mean square error at straight edges, 0.002 to 0.2, played beside the others as `soft-E`
    #[arg(long, value_name = "E", value_parser = parse_soft_error)]
    pub(crate) max_error: Option<f32>,
    /// Which backends play
    #[arg(long, value_name = "NAME", default_value = "available")]
    pub(crate) backend: Backend,
    /// Graphics adapter by part of its name, such as llvmpipe
    #[arg(long, value_name = "NAME")]
    pub(crate) adapter: Option<String>,
    /// Image size in pixels; else each scene's own (1280x720 for frames of real size)
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub(crate) size: Option<[u32; 2]>,
    /// Sides of the shadow maps, texels, in any order; every setting is compared at the middle one, each technique's first at
    /// all; else 512, 1024 and 2048 (1024 and 2048, with --full 4096, too, for frames of real size), or one with --quick
    #[arg(long, value_name = "SIDE", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(1..=16_384))]
    pub(crate) map_sizes: Vec<u32>,
    /// Prices of work, as `bench --costs --write` or `card` (.json) measures them; else the built-in ones
    #[arg(long, value_name = "FILE")]
    pub(crate) prices: Option<PathBuf>,
    /// Truth's rays a pixel for lights with an extent
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u32).range(1..=65_536))]
    pub(crate) samples: Option<u32>,
    /// Timed runs of each row; their median is kept
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) runs: Option<u32>,
    /// Folder for the report; else target/compare in the repository
    #[arg(long, value_name = "FOLDER")]
    pub(crate) out: Option<PathBuf>,
    /// Small images, few samples, few runs, without techniques that take long: a look rather than a measurement
    #[arg(long)]
    pub(crate) quick: bool,
    /// Every setting of every technique, and truth at every pixel, on frames of real size, too
    #[arg(long, conflicts_with = "quick")]
    pub(crate) full: bool,
    /// Frames in which nothing moves: charts and tables count the lookup alone
    #[arg(long, conflicts_with_all = ["camera_moves", "all_moves"])]
    pub(crate) still: bool,
    /// Frames in which the camera moves: charts and tables count what is made anew for it (the default)
    #[arg(long, conflicts_with = "all_moves")]
    pub(crate) camera_moves: bool,
    /// Frames in which casters, lights and camera move: charts and tables count all, hierarchies over the triangles included
    #[arg(long)]
    pub(crate) all_moves: bool,
    /// Write NumPy arrays of truth, distance and every mask, too
    #[arg(long)]
    pub(crate) arrays: bool,
    /// Shade every row in colour, too, and compare the colours between backends
    #[arg(long)]
    pub(crate) color: bool,
    /// No wall-clock times and no date, so that the report is the same, byte for byte, whenever it is made
    #[arg(long, conflicts_with = "runs")]
    pub(crate) deterministic: bool,
    /// Compare with the results.json of an earlier run, kept in another folder than this report's, and fail if anything got
    /// slower or less accurate beyond the noise, is missing or can't be compared any more
    #[arg(long, value_name = "RESULTS.JSON")]
    pub(crate) baseline: Option<PathBuf>,
    /// What may be missing or changed since the baseline: a scene, technique, backend or `technique (settings)`; may be
    /// repeated
    #[arg(long, value_name = "NAME", requires = "baseline")]
    pub(crate) baseline_except: Vec<String>,
    /// Folder of a `stability` run, or its results.json: the report says beside each setting which rows it fails; else
    /// target/stability in the repository, if it is there (but not with --deterministic)
    #[arg(long, value_name = "FOLDER")]
    pub(crate) stability: Option<PathBuf>,
    /// Only every N-th scene, from the K-th on; `cargo xtask merge` joins the shards
    #[arg(long, value_name = "K/N", value_parser = parse_shard)]
    pub(crate) shard: Option<Shard>,
    /// Measure every scene anew, even if the folder has it from a run that was stopped
    #[arg(long)]
    pub(crate) fresh: bool,
    /// List scenes and techniques, and end
    #[arg(long)]
    pub(crate) list: bool,
}

fn parse_soft_error(text: &str) -> Result<f32, String> {
    let [least, greatest] = SOFT_ERRORS;
    let error = text.parse().ok();
    error
        .filter(|error| (least..=greatest).contains(error))
        .ok_or_else(|| format!("use {least} to {greatest}"))
}
