//! Dependencies of each feature. A renderer alone must not compile scene files, images and search
//! trees.

use std::{collections::BTreeSet, path::Path, process::Command};

/// Returns the names of the packages that the facade needs with some features, according to cargo.
fn packages(features: &str) -> BTreeSet<String> {
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
    let out = Command::new(env!("CARGO"))
        .args(["tree", "--offline", "--edges", "normal", "--prefix", "none"])
        .args(["--no-default-features", "--features", features])
        .arg("--manifest-path")
        .arg(manifest)
        .output()
        .expect("cargo runs");
    let reported = String::from_utf8_lossy(&out.stdout);
    assert!(
        out.status.success(),
        "{}",
        String::from_utf8_lossy(&out.stderr)
    );
    reported
        .lines()
        .filter_map(|line| line.split_whitespace().next())
        .map(str::to_owned)
        .collect()
}

fn assert_without(features: &str, unwanted: &[&str]) {
    let packages = packages(features);
    let found: Vec<_> = unwanted
        .iter()
        .filter(|name| packages.contains(**name))
        .collect();
    assert!(
        packages.contains("umbrage-core"),
        "not a package list: {packages:?}"
    );
    assert!(found.is_empty(), "`{features}` needs {found:?}");
}

#[test]
fn the_renderer_needs_no_scenes_and_no_planner() {
    let unwanted = [
        "image",
        "tobj",
        "rstar",
        "umbrage-scenes",
        "umbrage-plan",
        "umbrage-cpu",
        "umbrage-lab",
    ];
    assert_without("default", &unwanted);
    // Parallelism, SIMD, ray tracing and settings as TOML are chosen by name.
    let unwanted = ["rayon", "obvhs", "pulp", "rdst", "toml", "serde"];
    assert_without("default", &unwanted);
    assert!(packages("default").contains("wgpu"));
    let of_all = packages("default,parallel,presets,rays,simd");
    for name in unwanted {
        assert!(of_all.contains(name), "{name}");
    }
}

#[test]
fn the_planner_needs_no_gpu_and_no_scene_files() {
    let unwanted = [
        "wgpu",
        "image",
        "tobj",
        "rstar",
        "umbrage-scenes",
        "umbrage-wgpu",
        "umbrage-lab",
    ];
    assert_without("plan", &unwanted);
}

#[test]
fn scenes_without_gltf_need_neither_its_crates_nor_jpeg() {
    assert_without("scenes", &["gltf", "gltf-json", "zune-jpeg"]);
}

/// The same list shows the crates that are needed, so the tests above can't pass by reading
/// nothing.
#[test]
fn scenes_need_what_they_read() {
    let of_scenes = packages("scenes");
    for name in ["image", "tobj", "rstar", "umbrage-scenes"] {
        assert!(of_scenes.contains(name), "{name}");
    }
    let of_gltf = packages("gltf");
    for name in ["gltf", "zune-jpeg", "umbrage-scenes"] {
        assert!(of_gltf.contains(name), "{name}");
    }
}
