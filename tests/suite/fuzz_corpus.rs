//! Runs the kept corpus of the fuzzers (`tests/fuzz`). All previously interesting inputs and bugs
//! are read in every run.

#[path = "../fuzz/readers.rs"]
mod readers;

use std::{fs, path::Path};

/// Runs each file of a target's corpus.
fn run_target(target: &str, read: fn(&[u8])) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("fuzz/corpus")
        .join(target);
    let entries = fs::read_dir(&folder).expect("the target's corpus");
    let mut files: Vec<_> = entries
        .map(|entry| entry.expect("an entry").path())
        .collect();
    // Use the same order on every machine.
    files.sort();
    assert!(!files.is_empty(), "{} is empty", folder.display());
    for file in files {
        let bytes = fs::read(&file).expect("a file");
        // Print the input's name: a panic doesn't include it, and failing tests show their output.
        println!("{}", file.display());
        read(&bytes);
    }
}

#[test]
fn scene_files() {
    run_target("scene_file", readers::scene_file);
}

/// Scene files that name models, including glTF, and damaged copies of them with one byte replaced.
#[test]
fn scene_files_with_models() {
    for mesh in [
        "model.obj",
        "0.glb",
        "0.glb#other",
        "1.glb",
        "2.glb",
        "3.glb",
    ] {
        for look in ["", "casts = false\n", "color = [1, 0, 0]\n"] {
            let input = format!(
                "[[light]]\nkind = \"directional\"\ndirection = [0, -1, 0.5]\n\
                 [[object]]\nmesh = \"{mesh}\"\nscale = [1, 2, -3]\n{look}"
            );
            readers::scene_file(input.as_bytes());
            for place in (0..input.len()).step_by(3) {
                let mut damaged = input.clone().into_bytes();
                damaged[place] = damaged[place].wrapping_mul(31).wrapping_add(place as u8);
                readers::scene_file(&damaged);
            }
        }
    }
}

#[test]
fn models() {
    run_target("model", readers::model);
}

/// The corpus is generated in code. Each input is also read in damaged copies: truncated, and with
/// one byte replaced.
#[test]
fn gltf_models() {
    let inputs = readers::first_gltf_inputs();
    assert!(!inputs.is_empty());
    for input in inputs {
        readers::gltf(&input);
        for end in (0..input.len()).step_by(7) {
            readers::gltf(&input[..end]);
        }
        for place in (0..input.len()).step_by(5) {
            let mut damaged = input.clone();
            damaged[place] = damaged[place].wrapping_mul(31).wrapping_add(place as u8);
            readers::gltf(&damaged);
        }
    }
}

#[test]
fn pictures() {
    run_target("picture", readers::picture);
}

#[test]
fn presets() {
    run_target("preset", readers::preset);
}

#[test]
fn results() {
    run_target("results", readers::results);
}
