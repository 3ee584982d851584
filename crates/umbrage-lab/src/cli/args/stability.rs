//! `stability`: arguments.

use super::Backend;
use clap::Args;
use std::path::PathBuf;

#[derive(Args, Clone, Debug, PartialEq)]
#[command(after_help = "Examples:
  cargo xtask stability                              all rows, all sweeps, all windows of bias
  cargo xtask stability --list                       the rows, and what each is judged by
  cargo xtask stability 3 12 --technique hard,pcf    two rows, two techniques
  cargo xtask stability --technique pcf              one technique in all rows, and its window
  cargo xtask stability thin-plate --backend cpu     one case, on the CPU alone
  cargo xtask stability --quick --out look           small images and maps, in a folder of your own")]
pub(crate) struct StabilityArguments {
    /// Rows by number, or cases by name; none: all rows, and each technique's window of bias; without --technique all sweeps, too
    #[arg(value_name = "ROW")]
    pub(crate) rows: Vec<String>,
    /// Only these techniques; may be repeated, or separated by commas
    #[arg(long = "technique", value_name = "NAME", value_delimiter = ',')]
    pub(crate) techniques: Vec<String>,
    /// Which backends play: figures are the first's, the others must agree; of moving rows they play the first and the last
    /// frame, of sweeps the ends and the middle. Else those available, with --quick the CPU
    #[arg(long, value_name = "NAME")]
    pub(crate) backend: Option<Backend>,
    /// Graphics adapter by part of its name, such as llvmpipe
    #[arg(long, value_name = "NAME")]
    pub(crate) adapter: Option<String>,
    /// Small images and maps, few frames and samples: a look rather than a measurement
    #[arg(long)]
    pub(crate) quick: bool,
    /// Folder for the report; else target/stability in the repository
    #[arg(long, value_name = "FOLDER")]
    pub(crate) out: Option<PathBuf>,
    /// List the rows with their scenes, measures and limits, and end
    #[arg(long)]
    pub(crate) list: bool,
}
