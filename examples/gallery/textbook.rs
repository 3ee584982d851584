//! Textbook shadow effects on one page.

use anyhow::{Context as _, Result};
use std::{fs, path::Path};
use umbrage::gpu::AdapterChoice;
use umbrage_lab::{
    compare::Backends,
    textbook::{all, html, measure},
};

pub(crate) fn write(folder: &Path) -> Result<()> {
    fs::create_dir_all(folder)
        .with_context(|| format!("cannot make the folder {}", folder.display()))?;
    let write = |name: &str, contents: &[u8]| {
        let path = folder.join(name);
        fs::write(&path, contents).with_context(|| format!("cannot write {}", path.display()))
    };
    let mut backends = Backends::available(&AdapterChoice::from_env())?;
    for notice in &backends.notices {
        println!("{notice}");
    }
    let mut rows = Vec::new();
    for (i, effect) in all().iter().enumerate() {
        println!("{:2} of {}: {}", i + 1, all().len(), effect.title);
        let rendered = measure(effect, &mut backends.backends)?;
        for (half, side) in [("fault", &rendered.fault), ("cure", &rendered.cure)] {
            let name = effect.name;
            write(&format!("{name}.{half}.png"), &side.picture)?;
            write(&format!("{name}.{half}.error.png"), &side.error)?;
        }
        rows.push((effect, rendered));
    }
    let names: Vec<String> = backends
        .backends
        .iter()
        .map(|backend| backend.name().to_owned())
        .collect();
    write("index.html", html(&rows, &names).as_bytes())?;
    println!("gallery: {}", folder.join("index.html").display());
    Ok(())
}
