//! Arguments of `card`.

use clap::{Args, ValueEnum};
use std::path::PathBuf;

#[derive(Args, Clone, Debug, PartialEq)]
#[command(after_help = "Examples:
  cargo xtask card                                    all parts on the best adapter, within three minutes on a card
  cargo xtask card --adapter nvidia --by 'Ada L.' --out docs/cards/my-card.json
  cargo xtask card --parts adapter,agreement          what it rounds, and whether its masks are the CPU's
  cargo xtask card --page                             write docs/cards.md from the files in docs/cards
  cargo xtask card --pack card                        a folder for a machine without a compiler or network")]
pub(crate) struct CardArguments {
    /// Graphics adapter by part of its name, such as nvidia; else WGPU_ADAPTER_NAME's, else the
    /// best one
    #[arg(long, value_name = "NAME")]
    pub(crate) adapter: Option<String>,
    /// Parts to measure; all if none is named
    #[arg(long, value_name = "PART", value_delimiter = ',', value_enum)]
    pub(crate) parts: Vec<CardPart>,
    /// File for the figures (JSON), rewritten after each part; else target/card/card.json in the
    /// repository. Parts that are not measured keep what the file has of the same adapter, driver
    /// and commit; a file named here may hold no other card
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    /// Who measures, for the page
    #[arg(long, value_name = "NAME")]
    pub(crate) by: Option<String>,
    /// The commit that was built, where there is no repository
    #[arg(long, value_name = "HASH")]
    pub(crate) commit: Option<String>,
    /// Write the page of all cards instead: FOLDER.md from the files in FOLDER
    #[arg(long, value_name = "FOLDER", num_args = 0..=1, default_missing_value = "docs/cards", conflicts_with_all = ["adapter", "parts", "out", "by", "commit"])]
    pub(crate) page: Option<PathBuf>,
    /// Build, and pack programs, drivers' loader and a run script into a folder instead
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["adapter", "parts", "out", "by", "commit", "page"])]
    pub(crate) pack: Option<PathBuf>,
}

/// A part of what is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum CardPart {
    /// Name, driver, limits, and how it rounds: seconds
    Adapter,
    /// Its masks against the CPU's
    Agreement,
    /// Milliseconds of the settings that stand for each technique
    Times,
    /// A light set against a program written by hand
    LightSet,
    /// Prices of work for the planner
    Prices,
}
