//! Processing of each kind of file that a fuzzer makes: the file is read, and the result is used.
//! An error is a valid result; a panic, a hang or a wrong number is a bug. The tests run the kept
//! corpus with the same functions (`tests/suite/fuzz_corpus.rs`).
//!
//! Scene files, models, images, presets and results come from untrusted sources. `tests/fuzz` is a
//! separate workspace with a libFuzzer target for each kind of file; `tests/fuzz/run.sh` continues
//! from the kept corpus. The corpus has no glTF files: `umbrage-scenes`' `gltf/tests/model.rs`
//! generates the initial inputs. Memory sanitizers are off, since the workspace forbids unsafe
//! code.

#[path = "../../crates/umbrage-scenes/src/gltf/tests/model.rs"]
#[expect(dead_code, reason = "the reader's own tests use more of it")]
mod gltf_model;

use std::{cell::RefCell, fs, path::PathBuf};
use tempfile::TempDir;
use umbrage::{
    Anchor, Backend as _, Camera, Geometry, Light, Scene, ShadowTechnique, View,
    cpu::{Cpu, CpuOptions},
    glam::{UVec2, Vec3},
    plan::cost::PriceList,
    scenes::{self, FilesInMemory},
    techniques::{Exact, LightPreset, MapFilter as _, Pcf, ShadowMap, TechniquePreset},
};
use umbrage_lab::{
    baseline::{self, Except},
    stability::{Demand, report::StabilityResults},
};

/// Image size that is small enough to render for each input.
const SIZE: UVec2 = UVec2::new(16, 9);
/// Greatest number of triangles of rendered scenes. Others are only read and baked.
const MAX_TRIANGLES: usize = 2_000;
/// Greatest size of the maps of rendered settings. Others are only read.
const MAX_IMAGE_BYTES: u64 = 1 << 20;
/// Separator between the files of one input: first the main one, then one that it names.
const PART: &[u8] = b"\n%%%%\n";

thread_local! {
    /// A folder for files that are read by path.
    static FOLDER: TempDir = tempfile::tempdir().expect("a folder for temporary files");
    /// One thread, since several fuzzers run at the same time.
    static CPU: RefCell<Cpu> = RefCell::new(
        Cpu::with_options(&CpuOptions::default().threads(1)).expect("a thread"),
    );
}

/// Writes a file into the folder, and returns its path.
fn file(name: &str, bytes: &[u8]) -> PathBuf {
    FOLDER.with(|folder| {
        let path = folder.path().join(name);
        fs::write(&path, bytes).expect("a temporary file");
        path
    })
}

/// Splits an input at the first separator.
fn split_bytes(bytes: &[u8]) -> (&[u8], &[u8]) {
    match bytes.windows(PART.len()).position(|piece| piece == PART) {
        Some(at) => (&bytes[..at], &bytes[at + PART.len()..]),
        None => (bytes, &[]),
    }
}

/// Renders a scene's first light with two techniques.
fn run_scene(scene: &Scene) {
    let triangles: usize = scene
        .instances
        .iter()
        .filter_map(|instance| scene.meshes.get(instance.mesh))
        .map(|mesh| mesh.triangles.len())
        .sum();
    let geometry = match Geometry::bake(scene) {
        Ok(geometry) => geometry,
        // A scene that was read is valid.
        Err(error) => panic!("a scene that was read can't be baked: {error}"),
    };
    let (Some(camera), Some(light)) = (scene.cameras.first(), scene.lights.first()) else {
        panic!("a scene that was read has no camera or no light");
    };
    if triangles > MAX_TRIANGLES {
        return;
    }
    let camera = Camera {
        size: SIZE,
        ..*camera
    };
    let view = View::new(&camera, light, &geometry);
    let pcf = Pcf::default().on(umbrage::techniques::ShadowMap {
        size: 64,
        ..ShadowMap::default()
    });
    render(&view, &pcf);
    render(&view, &Exact::default());
}

fn render(view: &View<'_>, technique: &dyn ShadowTechnique) {
    let Ok(recipe) = technique.recipe(view) else {
        return;
    };
    if recipe.image_bytes() > MAX_IMAGE_BYTES {
        return;
    }
    let Ok(shadows) = CPU.with_borrow_mut(|cpu| cpu.render(view, &recipe)) else {
        return;
    };
    let is_share = |v: &f32| (0.0..=1.0).contains(v);
    assert!(
        shadows.mask.iter().all(is_share),
        "visibility outside of 0 to 1"
    );
}

/// Processes a scene file, with models that it may name, and as cameras of a path. All files that
/// it names are read from memory, so that none of the machine's files is read.
pub(super) fn scene_file(bytes: &[u8]) {
    let mut files = models();
    files.insert("scene.toml", bytes);
    if let Ok(scene) = scenes::read("scene.toml", &files) {
        run_scene(&scene);
    }
    let cube = scenes::find("cubes").expect("built in");
    let geometry = Geometry::bake(&(cube.build)()).expect("built in");
    if let Ok(cameras) = scenes::cameras(&file("path.toml", bytes), &geometry, Anchor::ORIGIN) {
        assert!(!cameras.is_empty());
    }
}

/// Returns `model.obj`, and files from `0.glb` on that cover everything that is read of glTF.
fn models() -> FilesInMemory {
    let mut files = FilesInMemory::default();
    files.insert(
        "model.obj",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1",
    );
    for (i, model) in gltf_model::first_inputs().into_iter().enumerate() {
        files.insert(format!("{i}.glb"), model.glb());
    }
    files
}

/// Processes a model, followed by [`PART`] and its materials.
pub(super) fn model(bytes: &[u8]) {
    let (obj, mtl) = split_bytes(bytes);
    let files: FilesInMemory = [("model.obj", obj), ("looks.mtl", mtl)]
        .into_iter()
        .collect();
    if let Ok(scene) = scenes::read("model.obj", &files) {
        run_scene(&scene);
    }
}

/// Processes a glTF model: a whole `.glb` file; or a document, [`PART`] and the bytes that it
/// names, as separate files and as one file.
pub(super) fn gltf(bytes: &[u8]) {
    if bytes.starts_with(b"glTF") {
        return gltf_of([("model.glb", bytes.to_vec())], "model.glb");
    }
    let (json, data) = split_bytes(bytes);
    let whole = gltf_model::glb(json, data);
    gltf_of([("model.glb", whole)], "model.glb#1");
    let parts = [("model.gltf", json.to_vec()), ("data", data.to_vec())];
    gltf_of(parts, "model.gltf");
}

fn gltf_of<const N: usize>(files: [(&str, Vec<u8>); N], path: &str) {
    let files: FilesInMemory = files.into_iter().collect();
    // Fall back to the default scene if there is no other.
    let scene =
        scenes::read(path, &files).or_else(|_| scenes::read(path.trim_end_matches("#1"), &files));
    if let Ok(scene) = scene {
        run_scene(&scene);
    }
}

/// Returns inputs that together cover everything that is read of glTF.
pub(super) fn first_gltf_inputs() -> Vec<Vec<u8>> {
    let mut out = Vec::new();
    for model in gltf_model::first_inputs() {
        out.push(model.glb());
        let mut parts = model.text(Some("data")).into_bytes();
        parts.extend(PART);
        parts.extend(&model.bytes);
        out.push(parts);
    }
    out
}

/// Processes an image as texture, as heights or as normals, depending on the first byte.
pub(super) fn picture(bytes: &[u8]) {
    let Some((&which, png)) = bytes.split_first() else {
        return;
    };
    let look = match which % 3 {
        0 => "texture = 'picture.png'",
        1 => "height_map = 'picture.png'\ndisplacement = 0.3\nsubdivisions = 2",
        _ => "normal_map = 'picture.png'",
    };
    let scene = format!(
        "[[light]]\nkind = 'directional'\ndirection = [1, -2, 0.5]\n\
         [[object]]\nshape = 'plane'\n{look}"
    );
    let files: FilesInMemory = [("scene.toml", scene.as_bytes()), ("picture.png", png)]
        .into_iter()
        .collect();
    if let Ok(scene) = scenes::read("scene.toml", &files) {
        run_scene(&scene);
    }
}

/// Processes a preset: it is read, written, read again, and rendered.
pub(super) fn preset(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return;
    };
    let preset = TechniquePreset::from_toml(text);
    if let Ok(light) = LightPreset::from_toml(text) {
        let written = light.to_toml().expect("what was read can be written");
        let again = LightPreset::from_toml(&written).expect("what was written can be read");
        let twice = again.to_toml().expect("what was read can be written");
        assert_eq!(written, twice);
        assert!(preset.is_ok(), "a preset with rules is a preset");
    }
    if let Ok(preset) = preset {
        let cube = scenes::find("cubes").expect("built in");
        let scene = (cube.build)();
        let geometry = Geometry::bake(&scene).expect("built in");
        let camera = Camera {
            size: SIZE,
            ..scene.cameras[0]
        };
        let lights = [
            scene.lights[0],
            Light::Point {
                position: Vec3::new(1.0, 4.0, 0.5),
                radius: 0.1,
            },
        ];
        for light in &lights {
            render(&View::new(&camera, light, &geometry), &*preset.technique());
        }
    }
    if let Ok(prices) = PriceList::from_toml(text) {
        let written = prices.to_toml().expect("finite prices");
        assert_eq!(PriceList::from_toml(&written).as_ref(), Ok(&prices));
    }
}

/// Processes results of `compare` and of `stability`, as a baseline and as input of a plan.
pub(super) fn results(bytes: &[u8]) {
    let path = file("results.json", bytes);
    if let Ok(comparison) = baseline::read(&path) {
        let changes = baseline::changes(&comparison, &comparison, &Except::default());
        assert!(
            changes.lost.is_empty(),
            "results lack their own contents: {:?}",
            changes.lost
        );
        let lines = umbrage_lab::report::lines(&comparison);
        let _ = umbrage_lab::report::to_csv(&lines);
    }
    if let Ok(StabilityResults { stability, .. }) = StabilityResults::read(&path) {
        let _ = stability.meets("pcf", &Demand::FailNone);
        let _ = stability.meets("pcf", &Demand::Pass(vec!["3".to_owned()]));
        let _ = stability.setting_verdicts();
    }
}
