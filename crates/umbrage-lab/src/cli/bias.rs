//! `bias`: compares the default bias with all others. The lab does the work.

use crate::{
    bias::{BiasOptions, Staged, Summary, markdown, measure, stage_scene, write},
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
  cargo xtask bias                            the built-in scenes under ideal lights
  cargo xtask bias stairs town --sides 2048   two scenes, one map size
  cargo xtask bias bunny.obj --backend cpu    a model on a floor under four lights
  cargo xtask bias room.glb#night             a model under its own lights, if it has any")]
pub(crate) struct BiasArguments {
    /// Scenes: built-in names, scene files (.toml) or models (.obj, .glb, .gltf). Default: all
    /// built-in scenes
    ///
    /// Scenes are lit by their own lights, reduced to ideal ones without extent. A model without
    /// lights is placed on a floor under four lights.
    #[arg(value_name = "SCENE")]
    pub(crate) scenes: Vec<String>,
    /// Backends that render with the default bias; all other biases run on the CPU only
    #[arg(long, value_name = "NAME", default_value = "available")]
    pub(crate) backend: BackendName,
    /// Graphics adapter, by part of its name, such as llvmpipe
    #[arg(long, value_name = "NAME")]
    pub(crate) adapter: Option<String>,
    /// Image size in pixels. Default: each scene's own
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub(crate) size: Option<[u32; 2]>,
    /// Sides of the shadow maps, texels. Default: 512 and 2048
    #[arg(long, value_name = "SIDE", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(1..=16_384))]
    pub(crate) sides: Vec<u32>,
    /// Folder for the tables. Default: target/bias in the repository
    #[arg(long, value_name = "FOLDER")]
    pub(crate) out: Option<PathBuf>,
}

/// Measures all scenes, prints a line for each, and then the table.
pub(crate) fn bias(program: &Program, arguments: &BiasArguments) -> Result<()> {
    let mut backends = inputs::open(arguments.backend, arguments.adapter.as_ref())?;
    backends.notices.iter().for_each(|line| println!("{line}"));
    backends
        .backends
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
        } = Summary::from_rows(found.iter());
        let place = format!("{:>2}/{}", i + 1, names.len());
        println!(
            "{place} {name:<26} {good:>3} of {count:<3} within 10 %, mean ratio {mean:.3}, maximum {max:.2}"
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

fn names(requested: &[String]) -> Vec<String> {
    if requested.is_empty() {
        return umbrage_scenes::all()
            .iter()
            .map(|entry| entry.name.to_owned())
            .collect();
    }
    requested.to_vec()
}

/// Returns a scene with its lights. For a model, also returns a line that lists these lights.
fn stage(program: &Program, name: &str) -> Result<(Staged, Option<String>)> {
    let scene: Scene = inputs::scene(program, name)?;
    let is_model = umbrage_scenes::is_model(name);
    let is_unlit = is_model && !umbrage_scenes::brings_light(name)?;
    let staged = stage_scene(scene, is_unlit)?;
    let line = is_model.then(|| lights_line(name, is_unlit, &staged));
    Ok((staged, line))
}

fn lights_line(name: &str, is_unlit: bool, staged: &Staged) -> String {
    let lights: Vec<&str> = staged
        .lights
        .iter()
        .map(|(name, _)| name.as_str())
        .collect();
    let lights = lights.join(", ");
    match is_unlit {
        true => format!("{name} has no lights: placed on a floor under {lights}"),
        false => format!("{name} under its own lights, reduced to ideal ones: {lights}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use umbrage_core::Light;

    /// A triangle, and nodes with three lights: one has a radius and one is off.
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
        // `compare` and `plan` use the model without a floor, too.
        assert_eq!(own.scene.instances.len(), 1);
        let line = line.expect("a model");
        let end = "lit.gltf under its own lights, reduced to ideal ones: 0 point, 1 directional";
        assert!(line.ends_with(end), "{line}");
        // Neither another scene of the file nor an OBJ file has lights.
        let obj = folder.path().join("plain.obj");
        fs::write(&obj, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3").expect("a file");
        for name in [format!("{name}#day"), obj.display().to_string()] {
            let (_, line) = stage(&program, &name).expect("valid");
            let line = line.expect("a model");
            let end = " has no lights: placed on a floor under sun, low sun, spot, bulb";
            assert!(line.ends_with(end), "{line}");
        }
        let (_, line) = stage(&program, "cubes").expect("built in");
        assert_eq!(line, None);
    }
}
