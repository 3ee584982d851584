//! `bias`: the default bias against all others. All the work is the lab's.

use crate::args::BiasArguments;
use crate::inputs;
use crate::program::Program;
use anyhow::{Context as _, Result};
use std::time::Instant;
use umbrage_core::{Scene, glam::UVec2};
use umbrage_lab::bias::{BiasOptions, Staged, Summary, markdown, measure, staged, write};

/// Plays, prints a line a scene, then the table.
pub(crate) fn bias(program: &Program, arguments: &BiasArguments) -> Result<()> {
    let mut backends = inputs::open(arguments.backend, arguments.adapter.as_ref())?;
    backends.notices.iter().for_each(|line| println!("{line}"));
    backends
        .playing
        .iter()
        .for_each(|b| println!("on {}", b.name()));
    let base = BiasOptions::default();
    let sides = if arguments.sides.is_empty() {
        base.sides
    } else {
        arguments.sides.clone()
    };
    let options = BiasOptions {
        size: arguments.size.map(UVec2::from),
        sides,
    };
    let names = names(&arguments.scenes);
    let start = Instant::now();
    let mut rows = Vec::new();
    for (i, name) in names.iter().enumerate() {
        let staged = stage(program, name)?;
        let found =
            measure(&staged, &options, &mut backends).with_context(|| format!("scene `{name}`"))?;
        let Summary {
            rows: count,
            good,
            mean,
            max,
            ..
        } = Summary::of(found.iter());
        let place = format!("{:>2}/{}", i + 1, names.len());
        println!(
            "{place} {name:<26} {good:>3} of {count:<3} within 10 %, mean ratio {mean:.3}, greatest {max:.2}"
        );
        rows.extend(found);
    }
    println!("\n{}", markdown(&rows));
    let folder = program.folder(arguments.out.as_deref(), "bias");
    let page = write(&rows, &folder)?;
    println!(
        "table: {} ({:.0} s)",
        page.display(),
        start.elapsed().as_secs_f64()
    );
    Ok(())
}

fn names(asked: &[String]) -> Vec<String> {
    if asked.is_empty() {
        return umbrage_scenes::all()
            .iter()
            .map(|entry| entry.name.to_owned())
            .collect();
    }
    asked.to_vec()
}

fn stage(program: &Program, name: &str) -> Result<Staged> {
    let scene: Scene = inputs::scene(program, name)?;
    Ok(staged(scene, umbrage_scenes::is_model(name))?)
}
