//! Finds the cheapest technique whose error is below a limit:
//! `cargo run --release --example auto [SCENE [ERROR]]`. Writes its settings to `auto.preset.toml`,
//! which the examples `forward` and `deferred` read.

use anyhow::Context as _;
use umbrage::{Budget, RendererData};

fn main() -> anyhow::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let name = arguments.next().unwrap_or_else(|| "cubes".to_owned());
    let error = arguments.next().unwrap_or_else(|| "0.1".to_owned());
    let error = error
        .parse()
        .with_context(|| format!("`{error}` is not an error: use a number such as 0.1"))?;
    let scene = umbrage::scenes::by_argument(&name)?;
    // Plan for a renderer whose triangles are only on the GPU.
    let budget = Budget {
        renderer: RendererData::CasterBox,
        ..Budget::error(error)
    };
    let preset = umbrage::auto(&scene, &budget)?.to_toml()?;
    std::fs::write("auto.preset.toml", &preset)?;
    println!("{preset}");
    Ok(())
}
