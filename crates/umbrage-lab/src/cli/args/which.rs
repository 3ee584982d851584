//! `which`: arguments.

use clap::Args;
use std::path::PathBuf;

#[derive(Args, Clone, Debug, PartialEq)]
#[command(after_help = "Examples:
  cargo xtask which                                              from the last `compare` and `stability`
  cargo xtask which target/compare target/stability --out docs   docs/which.md, docs/which.html, pictures in docs/which")]
pub(crate) struct WhichArguments {
    /// Folder that `cargo xtask compare` wrote, with frames of real size; else target/compare in the repository
    #[arg(value_name = "COMPARED")]
    pub(crate) compared: Option<PathBuf>,
    /// Folder that `cargo xtask stability` wrote; else target/stability in the repository
    #[arg(value_name = "STABILITY")]
    pub(crate) stability: Option<PathBuf>,
    /// Folder for the page and its pictures; else target/which in the repository
    #[arg(long, value_name = "FOLDER")]
    pub(crate) out: Option<PathBuf>,
}
