//! The textbooks' shadow effects on one page, faults beside cures: `cargo run --release --example textbook -- [FOLDER]`.
//! Writes `index.html` and the pictures, into `target/textbook` if no folder is named.

use anyhow::Context as _;
use std::{fs, path::PathBuf};
use umbrage::wgpu::AdapterChoice;
use umbrage_lab::{
    compare::Backends,
    textbook::{PlayedEffect, all, html, play},
};

fn main() -> anyhow::Result<()> {
    let folder = std::env::args()
        .nth(1)
        .map_or_else(|| PathBuf::from("target/textbook"), PathBuf::from);
    fs::create_dir_all(&folder)
        .with_context(|| format!("cannot make the folder {}", folder.display()))?;
    let mut backends = Backends::available(&AdapterChoice::from_env())?;
    backends
        .notices
        .iter()
        .for_each(|notice| println!("{notice}"));
    let mut rows = Vec::new();
    for (i, effect) in all().iter().enumerate() {
        println!("{:2} of {}: {}", i + 1, all().len(), effect.title);
        let played = play(effect, &mut backends.playing)?;
        write(&folder, effect.name, &played)?;
        rows.push((effect, played));
    }
    let names: Vec<String> = backends
        .playing
        .iter()
        .map(|b| b.name().to_owned())
        .collect();
    let page = folder.join("index.html");
    fs::write(&page, html(&rows, &names))
        .with_context(|| format!("cannot write {}", page.display()))?;
    println!("gallery: {}", page.display());
    Ok(())
}

fn write(folder: &std::path::Path, name: &str, played: &PlayedEffect) -> anyhow::Result<()> {
    for (half, side) in [("fault", &played.fault), ("cure", &played.cure)] {
        for (what, png) in [("", &side.picture), (".error", &side.error)] {
            let path = folder.join(format!("{name}.{half}{what}.png"));
            fs::write(&path, png).with_context(|| format!("cannot write {}", path.display()))?;
        }
    }
    Ok(())
}
