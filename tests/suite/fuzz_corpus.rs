//! Plays the kept corpus of the fuzzers (`tests/fuzz`): what once was an interesting input, or a fault, is read on every run.

#[path = "../fuzz/readers.rs"]
mod readers;

use std::{fs, path::Path};

/// Plays each file of a target's corpus.
fn play(target: &str, read: fn(&[u8])) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("fuzz/corpus")
        .join(target);
    let entries = fs::read_dir(&folder).expect("the target's corpus");
    let mut files: Vec<_> = entries
        .map(|entry| entry.expect("an entry").path())
        .collect();
    // The same order on every machine.
    files.sort();
    assert!(!files.is_empty(), "{} is empty", folder.display());
    for file in files {
        let bytes = fs::read(&file).expect("a file");
        // A panic doesn't name the input: this line does, as tests that fail print what they wrote.
        println!("{}", file.display());
        read(&bytes);
    }
}

#[test]
fn scene_files() {
    play("scene_file", readers::scene_file);
}

#[test]
fn models() {
    play("model", readers::model);
}

#[test]
fn pictures() {
    play("picture", readers::picture);
}

#[test]
fn presets() {
    play("preset", readers::preset);
}

#[test]
fn results() {
    play("results", readers::results);
}
