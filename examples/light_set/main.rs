//! Times of light sets: `cargo run --release --example light_set -- --compare`.
//!
//! `--compare` draws the same image in turn with a program written by hand for exactly that, and
//! prints the ratio of frame times. `--casters` prints how long the processor prepares and records
//! a frame of 65 and of 10,000 casters. Both also measure without a driver.
//! `--lists [SCENE]...` prints how long the device takes to build a hierarchy of all casters,
//! compared with drawing a map.

use anyhow::Result;
use umbrage_examples::light_set;

fn main() -> Result<()> {
    let argument = std::env::args().nth(1);
    match argument.as_deref() {
        Some("--compare") => light_set::compare(),
        Some("--casters") => light_set::casters(),
        Some("--lists") => {
            let names: Vec<String> = std::env::args().skip(2).collect();
            light_set::lists(&names)
        }
        _ => anyhow::bail!("use `--compare`, `--casters` or `--lists [SCENE]...`"),
    }
}
