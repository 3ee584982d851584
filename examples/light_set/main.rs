//! A forward renderer with three spots and a sun in one light set: `cargo run --release --example light_set`. Writes `light_set.png`.
//!
//! With `--compare` it plays the same picture in turn with a program that was written by hand for exactly that, and prints how long
//! frames take beside its; with `--casters` it prints what preparing 10,000 casters takes; with `--lists [SCENE]...` what lists of all casters take,
//! made anew by the device, beside a map.

use anyhow::Result;
use umbrage_examples::light_set;

fn main() -> Result<()> {
    let argument = std::env::args().nth(1);
    match argument.as_deref() {
        None => light_set::picture(),
        Some("--compare") => light_set::frames(),
        Some("--casters") => light_set::casters(),
        Some("--lists") => {
            let names: Vec<String> = std::env::args().skip(2).collect();
            light_set::lists(&names)
        }
        Some(other) => {
            anyhow::bail!("`{other}` is no option; use `--compare`, `--casters`, `--lists` or none")
        }
    }
}
