#![no_main]

#[path = "../readers.rs"]
#[allow(dead_code, reason = "each target reads one kind of file")]
mod readers;

use std::{env, fs, path::PathBuf};

/// Writes the initial inputs into the folder of this variable. They are generated in code, and no
/// file holds them.
fn write_first_inputs() {
    let Some(folder) = env::var_os("FIRST_INPUTS").map(PathBuf::from) else {
        return;
    };
    for (i, input) in readers::first_gltf_inputs().into_iter().enumerate() {
        fs::write(folder.join(format!("first-{i}")), input).expect("a folder to write to");
    }
}

libfuzzer_sys::fuzz_target!(init: write_first_inputs(), |bytes: &[u8]| readers::gltf(bytes));
