//! Files dropped on the window or the page.

use std::path::{Path, PathBuf};
use umbrage::scenes;

/// Returns the index of the scene among dropped files, and a note if others could be scenes, too.
/// Scene files precede models, and the first of several is chosen. Other files are named by the
/// scene.
pub(crate) fn scene_among(paths: &[PathBuf]) -> (usize, Option<String>) {
    let those = |is_meant: fn(&Path) -> bool| -> Vec<usize> {
        (0..paths.len()).filter(|&i| is_meant(&paths[i])).collect()
    };
    let scenes = match those(is_scene_file) {
        files if files.is_empty() => those(|path| scenes::is_model(path)),
        files => files,
    };
    match scenes[..] {
        // Try the first file. The error lists supported kinds.
        [] => (0, None),
        [only] => (only, None),
        [first, ..] => {
            let note = format!(
                "{} scenes were dropped together; this is {}.",
                scenes.len(),
                paths[first].display()
            );
            (first, Some(note))
        }
    }
}

/// Returns the message while files are held over the window or the page. Browsers don't report
/// names before the drop.
pub(crate) fn offer(held: &[Option<PathBuf>]) -> Option<String> {
    if held.is_empty() {
        return None;
    }
    let Some(paths) = held.iter().cloned().collect::<Option<Vec<_>>>() else {
        return Some("Drop it here to show it.".to_owned());
    };
    if !paths
        .iter()
        .any(|path| is_scene_file(path) || scenes::is_model(path))
    {
        return Some(
            "These files can't be shown: drop a .toml, .obj, .glb or .gltf file.".to_owned(),
        );
    }
    let (scene, _) = scene_among(&paths);
    let name = paths[scene].file_name().unwrap_or(paths[scene].as_os_str());
    Some(format!("Drop it here to show {}.", name.display()))
}

fn is_scene_file(path: &Path) -> bool {
    path.extension()
        .is_some_and(|ending| ending.eq_ignore_ascii_case("toml"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scene_is_found_among_what_it_names() {
        let among = |names: &[&str]| {
            let paths: Vec<PathBuf> = names.iter().map(PathBuf::from).collect();
            scene_among(&paths)
        };
        assert_eq!(among(&["wood.png", "tile.mtl", "Tile.OBJ"]), (2, None));
        assert_eq!(among(&["tile.obj", "wood.png", "scene.toml"]), (2, None));
        assert_eq!(among(&["tile.bin", "wood.jpg", "tile.gltf"]), (2, None));
        assert_eq!(among(&["scene.toml", "tile.GLB"]), (0, None));
        assert_eq!(among(&["wood.png"]), (0, None));
        let (first, note) = among(&["wood.png", "a.obj", "b.obj"]);
        assert_eq!(first, 1);
        assert_eq!(
            note.as_deref(),
            Some("2 scenes were dropped together; this is a.obj.")
        );
    }

    #[test]
    fn what_is_held_over_the_window_is_named() {
        let held = |names: &[Option<&str>]| {
            let paths: Vec<_> = names.iter().map(|name| name.map(PathBuf::from)).collect();
            offer(&paths)
        };
        assert_eq!(held(&[]), None);
        assert_eq!(
            held(&[Some("/a/wood.png"), Some("/a/tile.obj")]).as_deref(),
            Some("Drop it here to show tile.obj.")
        );
        let words = held(&[Some("/a/wood.png")]).expect("words");
        assert!(words.starts_with("These files can't be shown"), "{words}");
        assert_eq!(
            held(&[None, None]).as_deref(),
            Some("Drop it here to show it.")
        );
    }
}
