//! `bias`: the default bias against all others. All the work is the lab's.

use crate::{
    bias::{BiasOptions, Staged, Summary, markdown, measure, staged, write},
    cli::{
        args::shared::{BackendName, parse_size},
        inputs,
        program::Program,
    },
};
use anyhow::{Context as _, Result};
use clap::Args;
use std::{path::PathBuf, time::Instant};
use umbrage_core::{Scene, glam::UVec2};

#[derive(Args, Clone, Debug, PartialEq)]
#[command(after_help = "Examples:
  cargo xtask bias                                the built-in scenes under ideal lights
  cargo xtask bias stairs town --sides 2048       two scenes, one map size
  cargo xtask bias bunny.obj --backend cpu        a model on a floor, under two suns, a spot and a bulb
  cargo xtask bias room.glb#night                 a model under its own lights, where it has some")]
pub(crate) struct BiasArguments {
    /// Built-in scenes by name, scene files (.toml) or models (.obj, .glb, .gltf); none: all
    /// built-in scenes
    ///
    /// All under their own lights as if they had no size; a model that brings none stands on a
    /// floor under four.
    #[arg(value_name = "SCENE")]
    pub(crate) scenes: Vec<String>,
    /// Which backends execute the default bias; its rivals run on the CPU
    #[arg(long, value_name = "NAME", default_value = "available")]
    pub(crate) backend: BackendName,
    /// Graphics adapter by part of its name, such as llvmpipe
    #[arg(long, value_name = "NAME")]
    pub(crate) adapter: Option<String>,
    /// Image size in pixels; else each scene's own
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub(crate) size: Option<[u32; 2]>,
    /// Sides of the shadow maps, texels; else 512 and 2048
    #[arg(long, value_name = "SIDE", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(1..=16_384))]
    pub(crate) sides: Vec<u32>,
    /// Folder for the tables; else target/bias in the repository
    #[arg(long, value_name = "FOLDER")]
    pub(crate) out: Option<PathBuf>,
}

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
        let (staged, line) = stage(program, name)?;
        if let Some(line) = line {
            println!("{line}");
        }
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

/// Returns a scene with its lights, and, of a model, the line that says which these are.
fn stage(program: &Program, name: &str) -> Result<(Staged, Option<String>)> {
    let scene: Scene = inputs::scene(program, name)?;
    let is_model = umbrage_scenes::is_model(name);
    let is_unlit = is_model && !umbrage_scenes::brings_light(name)?;
    let staged = staged(scene, is_unlit)?;
    let line = is_model.then(|| told_lights(name, is_unlit, &staged));
    Ok((staged, line))
}

fn told_lights(name: &str, is_unlit: bool, staged: &Staged) -> String {
    let lights: Vec<&str> = staged
        .lights
        .iter()
        .map(|(name, _)| name.as_str())
        .collect();
    let lights = lights.join(", ");
    match is_unlit {
        true => format!("{name} brings no light: on a floor, under {lights}"),
        false => format!("{name} under its own lights, as if they had no size: {lights}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use umbrage_core::Light;

    /// A triangle, and nodes with two lights of which one is wide and one is off.
    const LIT: &str = r#"{
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0, 1, 2, 3] }, { "name": "day", "nodes": [0] }],
        "nodes": [
            { "mesh": 0 },
            { "translation": [1, 5, 2], "extensions": { "KHR_lights_punctual": { "light": 0 } } },
            { "extensions": { "KHR_lights_punctual": { "light": 1 } } },
            { "rotation": [-0.6, 0, 0, 0.8], "extensions": { "KHR_lights_punctual": { "light": 2 } } }
        ],
        "extensions": { "KHR_lights_punctual": { "lights": [
            { "type": "point", "extras": { "radius": 0.5 } }, { "type": "point", "intensity": 0 }, { "type": "directional" }
        ] } },
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
        "accessors": [{ "bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3 }],
        "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
        "buffers": [{ "byteLength": 36, "uri": "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA" }]
    }"#;

    #[test]
    fn a_model_is_measured_under_its_own_lights_where_it_has_some() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("lit.gltf");
        fs::write(&path, LIT).expect("a file");
        let program = Program::default();
        let name = path.display().to_string();
        let (own, line) = stage(&program, &name).expect("valid");
        let [(first, point), (second, sun)] = &own.lights[..] else {
            panic!("{:?}", own.lights);
        };
        assert_eq!([first.as_str(), second], ["0 point", "1 directional"]);
        let expected = Light::Point {
            position: [1.0, 5.0, 2.0].into(),
            radius: 0.0,
        };
        assert_eq!(*point, expected);
        assert!(sun.is_ideal());
        // As `compare` and `plan` see it: without a floor.
        assert_eq!(own.scene.instances.len(), 1);
        let line = line.expect("a model");
        let end = "lit.gltf under its own lights, as if they had no size: 0 point, 1 directional";
        assert!(line.ends_with(end), "{line}");
        // Another scene of the file has none, as has an OBJ file.
        let obj = folder.path().join("plain.obj");
        fs::write(&obj, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3").expect("a file");
        for name in [format!("{name}#day"), obj.display().to_string()] {
            let (_, line) = stage(&program, &name).expect("valid");
            let line = line.expect("a model");
            let end = " brings no light: on a floor, under sun, low sun, spot, bulb";
            assert!(line.ends_with(end), "{line}");
        }
        let (_, line) = stage(&program, "cubes").expect("built in");
        assert_eq!(line, None);
    }
}
