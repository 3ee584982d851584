use super::*;
use crate::Place;
use umbrage_core::Invalid;

#[test]
fn arguments_are_names_or_paths() {
    assert_eq!(by_argument("cubes").unwrap().name, "cubes");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("Model.OBJ");
    std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3").unwrap();
    assert_eq!(by_argument(path.to_str().unwrap()).unwrap().name, "Model");
}

#[test]
fn unknown_names_bring_near_ones() {
    let message = by_argument("teapot").unwrap_err().to_string();
    assert_eq!(
        message,
        format!(
            "there is no scene `teapot`; did you mean `teapot-lamp`, or the path of a {ENDINGS} file?"
        )
    );
    let message = by_argument("cube").unwrap_err().to_string();
    assert!(message.contains("`cubes`"), "{message}");
    let message = by_argument("").unwrap_err().to_string();
    assert_eq!(
        message,
        format!(
            "there is no scene ``; name a built-in scene, or give the path of a {ENDINGS} file"
        )
    );
}

#[test]
fn other_files_are_refused() {
    for name in ["scene.gltf2", "scene", "", "a.obj.zip", "a#1.toml.zip"] {
        let message = load(name).unwrap_err().to_string();
        assert!(
            message.contains(&format!("is not a {ENDINGS} file")),
            "{message}"
        );
    }
}

#[cfg(not(feature = "gltf"))]
#[test]
fn files_that_need_a_feature_name_it() {
    for name in ["model.glb", "model.GLTF", "model.glb#night"] {
        let message = load(name).unwrap_err().to_string();
        assert!(message.contains("its feature `gltf`"), "{message}");
        assert_eq!(by_argument(name).unwrap_err().to_string(), message);
        assert!(!is_model(name));
        assert_eq!(file_of(name), None);
    }
}

#[test]
fn text_is_read_without_a_file() {
    let text = "[[light]]\nkind = \"point\"\nposition = [0, 3, 0]\n[[object]]\nshape = \"sphere\"";
    assert_eq!(parse(text, "inline.toml", "").unwrap().name, "inline");
    assert!(
        parse("light", "inline.toml", "")
            .unwrap_err()
            .to_string()
            .starts_with("inline.toml:1: ")
    );
}

#[test]
fn scene_files_bring_light_and_obj_files_don_t() {
    assert_eq!(brings_light("scene.toml"), Ok(true));
    assert_eq!(brings_light("model.obj"), Ok(false));
    assert!(brings_light("cubes").is_err());
}

/// Programs print an error and then its sources. A source must not repeat the error.
#[test]
fn errors_are_reported_once() {
    let invalid = SceneError::Invalid {
        file: "a.obj".into(),
        fault: Invalid::new("mesh", "is empty", "add a triangle"),
    };
    let named = SceneError::Named {
        place: Place {
            file: "a.toml".into(),
            line: Some(3),
            key: None,
        },
        fault: Box::new(invalid.clone()),
    };
    let reported = "a.obj: mesh: is empty; add a triangle";
    assert_eq!(invalid.to_string(), reported);
    assert_eq!(named.to_string(), format!("a.toml:3: {reported}"));
    for error in [invalid, named] {
        assert!(std::error::Error::source(&error).is_none(), "{error:?}");
    }
}
