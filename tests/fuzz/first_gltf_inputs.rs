//! Writes the first inputs of the fuzzer of glTF into a folder: `first_gltf_inputs FOLDER`.

#[path = "readers.rs"]
#[allow(dead_code, reason = "this writes inputs and reads none")]
mod readers;

use std::{env, fs, path::PathBuf};

fn main() -> std::io::Result<()> {
    let folder = PathBuf::from(env::args().nth(1).expect("a folder"));
    for (i, input) in readers::first_gltf_inputs().into_iter().enumerate() {
        fs::write(folder.join(format!("first-{i}")), input)?;
    }
    Ok(())
}
