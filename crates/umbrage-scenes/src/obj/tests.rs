use super::*;
use crate::FilesOnDisk;
use std::io::{BufReader, Cursor};
use umbrage_core::Light;

fn read(text: impl AsRef<[u8]>) -> Result<Mesh, SceneError> {
    parse_mesh(Cursor::new(text.as_ref().to_vec()))
}

fn parse_model(text: &str) -> Result<Model, SceneError> {
    let path = Path::new("model.obj");
    parse(path, text.as_bytes(), &|error| {
        SceneError::unreadable_file(path, error, &FilesOnDisk)
    })
}

fn parse_mesh(source: impl BufRead) -> Result<Mesh, SceneError> {
    let path = Path::new("model.obj");
    let unreadable =
        |error: &std::io::Error| SceneError::unreadable_file(path, error, &FilesOnDisk);
    parse(path, source, &unreadable).map(|model| model.mesh)
}

/// Returns the error's line and text.
fn refusal_text(text: impl AsRef<[u8]>) -> (Option<usize>, String) {
    let error = read(text).unwrap_err();
    let text = error.to_string();
    match error {
        SceneError::Fault { place, .. } => (place.line, text),
        _ => (None, text),
    }
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

#[test]
fn one_triangle_is_read_in_every_dress() {
    let plain = read(format!("{TRIANGLE}f 1 2 3\n")).unwrap();
    assert_eq!(plain.positions, [Vec3::ZERO, Vec3::X, Vec3::Y]);
    assert_eq!(plain.triangles, [[0, 1, 2]]);
    let dresses = [
        format!("{TRIANGLE}f -3 -2 -1"),
        format!("{TRIANGLE}f 1 2 3 # a comment"),
        format!("{TRIANGLE}f 1 \\\n 2 \\\r\n3"),
        format!("{TRIANGLE}f 1 2 3\\"),
        format!("{TRIANGLE}f 1 2 3\n").replace('\n', "\r\n"),
        format!("{TRIANGLE}f 1 2 3\n").replace('\n', "\r"),
        format!("\u{feff}{TRIANGLE}f 1 2 3"),
        format!("mtllib missing.mtl\nmtllib\n{TRIANGLE}usemtl nothing\nusemtl\ns off\nf 1 2 3"),
        "f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0".to_owned(),
        "v 0 0 0 2\nv 2 0 0 2\nv 0 .5 0 .5\nf 1 2 3".to_owned(),
        "v 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0 .5 .5 .5 1\nf 1 2 3".to_owned(),
        format!("{TRIANGLE}l 1 2 3\nl 1 2\np 1\nf 1 2\nf 1\nf\nf 1 2 3\ncurv 1 2"),
        format!("o a\n{TRIANGLE}g b\nf 1 2 3\no c\ng d e\n"),
        format!("{TRIANGLE}vn 0 0 1\nvn 0 0 0\nf 1//2 2//1 3//1"),
        format!("{TRIANGLE}vn 0 0 1\nvn nan 0 0\nf 1//2 2//1 3//1"),
        format!("{TRIANGLE}vt nan 0\nf 1/1 2/1 3/1"),
        format!("{TRIANGLE}vt 1 0\nvn 0 0 1\nf 1/1/1 2 3//1"),
    ];
    for text in dresses {
        assert_eq!(read(&text), Ok(plain.clone()), "{text:?}");
    }
}

#[test]
fn names_in_other_encodings_do_no_harm() {
    let mut text = b"# Gr\xfc\xdfe\no B\xe4r\n".to_vec();
    text.extend(format!("{TRIANGLE}f 1 2 3 # \u{2713}").bytes());
    assert_eq!(read(text).unwrap().triangles, [[0, 1, 2]]);
}

#[test]
fn normals_and_texture_coordinates_are_kept_where_all_corners_have_them() {
    let mesh = read(format!(
        "{TRIANGLE}vt 0.25 0\nvt .5\nvt 1 1 0\nvn 0 0 2\nf 1/1/1 2/2/1 3/3/-1"
    ))
    .unwrap();
    assert_eq!(mesh.normals, [Vec3::Z * 2.0; 3]);
    // The first row of a texture is its top.
    assert_eq!(
        mesh.uvs,
        [
            Vec2::new(0.25, 1.0),
            Vec2::new(0.5, 1.0),
            Vec2::new(1.0, 0.0)
        ]
    );
    let half = read(format!(
        "{TRIANGLE}v 1 1 0\nvn 0 0 1\nvn 0 1 0\nf 1//1 2//2 3//1\nf 4 3 2"
    ))
    .unwrap();
    assert!(half.normals.is_empty());
    half.validate().unwrap();
}

#[test]
fn polygons_are_cut_along_their_inside() {
    let arrow = "v 0 0 0\nv 2 0 0\nv .5 .5 0\nv 0 2 0\n";
    assert_eq!(
        read(format!("{arrow}f 2 3 4 1\nf 1 2 3"))
            .unwrap()
            .triangles
            .len(),
        3
    );
    let mesh = read(format!("{arrow}f 2 3 4 1")).unwrap();
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
        0.5 * (b - a).cross(c - a).z
    };
    // Each part faces up. A fan from the first corner would have a part that faces down.
    assert!(mesh.triangles.iter().all(|t| area(t) > 0.0), "{mesh:?}");
    assert!((mesh.triangles.iter().map(area).sum::<f32>() - 1.0).abs() < 1e-6);
}

#[test]
fn groups_become_one_mesh_with_shared_vertices() {
    let mesh = read(format!(
        "o a\n{TRIANGLE}f 1 2 3\no b\nusemtl x\nv 1 1 0\nf 2 4 3"
    ))
    .unwrap();
    assert_eq!((mesh.positions.len(), mesh.triangles.len()), (4, 2));
}

#[test]
fn faults_are_refused_with_their_line() {
    let bad = [
        ("v nan 0 0\nf 1 2 4\n", 4, "vertex holds NaN"),
        ("v 0 inf 0\nf 1 -1 2\n", 4, "vertex holds inf"),
        ("v 1e39 0 0\nf 4/ 1 2\n", 4, "vertex holds inf"),
        ("v 0 0\n", 4, "vertex has 2 numbers of 3"),
        ("v 0 1,5 0\n", 4, "`1,5`, which is not a number"),
        ("v 1 0 0 0\nf 1 2 4\n", 4, "vertex holds 1 over 0"),
        ("f 1 2 4\n", 4, "names vertex 4, but the file has 3"),
        ("f 1 2 0\n", 4, "names vertex 0"),
        (
            "f 1 2 -4\n",
            4,
            "names vertex -4, but there are 3 before it",
        ),
        (
            "f 1 2 -9223372036854775808\n",
            4,
            "names vertex -9223372036854775808",
        ),
        (
            "f 1 2 9223372036854775807\n",
            4,
            "names vertex 9223372036854775807",
        ),
        (
            "f 1 2 99999999999999999999\n",
            4,
            "`99999999999999999999` is not an index",
        ),
        ("f 1/1/1/1 2 3\n", 4, "too many parts"),
        ("f a b c\n", 4, "`a` is not an index"),
        ("f 1.5 2 3\n", 4, "`1.5` is not an index"),
        ("f 1 2 / \n", 4, "`/` is not an index"),
        ("# a\0b\n", 4, "is not text"),
    ];
    for (text, line, why) in bad {
        let (at, message) = refusal_text(format!("{TRIANGLE}{text}f 1 2 3\n"));
        assert_eq!(at, Some(line), "{text}: {message}");
        assert!(message.contains(why), "{text}: {message}");
        assert!(
            message.starts_with(&format!("model.obj:{line}: ")) && message.contains("; "),
            "{message}"
        );
    }
}

/// What shadows don't need is ignored with a notice: the text, and the end of the notice.
#[test]
fn attributes_that_can_t_be_read_are_ignored_with_a_notice() {
    let plain = read(format!("{TRIANGLE}f 1 2 3\n")).unwrap();
    let cases = [
        (
            "vn 0 0\nf 1//1 2//1 3//1",
            "normals are ignored: line 4: normal has 2 numbers of 3",
        ),
        (
            "vt\nf 1/1 2/1 3/1",
            "texture coordinates are ignored: line 4: texture coordinate has 0 numbers of 1",
        ),
        (
            "vn 0 0 x\nf 1//1 2//1 3//1",
            "normals are ignored: line 4: normal holds `x`, which is not a number",
        ),
        (
            "f 1/1 2/1 3/1",
            "texture coordinates are ignored: line 4: face names texture coordinate 1, but the file has 0",
        ),
        (
            "\n\nf 1/-9223372036854775808 2 3",
            "line 6: face names texture coordinate -9223372036854775808, but there are 0 before it",
        ),
        (
            "f 1//9223372036854775807 2 3",
            "normals are ignored: line 4: face names normal 9223372036854775807, but the file has 0",
        ),
        (
            "vt nan 0\nf 1/1 2/1 3/1",
            "texture coordinates are ignored: some corners have none, or NaN",
        ),
        (
            "vn 0 0 0\nf 1//1 2//1 3//1",
            "normals are ignored: some corners have none, or zero, or NaN",
        ),
        (
            "v nan 0 0\nf 1 2 3",
            "1 vertices that no face uses are ignored: line 4: vertex holds NaN",
        ),
        (
            "l 1 2\nl 2 3\ns 1\nf 1 2 3",
            "statements are ignored: l (2), s (1)",
        ),
    ];
    for (text, end) in cases {
        let model = parse_model(&format!("{TRIANGLE}{text}\n")).unwrap();
        assert_eq!(model.mesh, plain, "{text:?}");
        let [notice] = &model.notices[..] else {
            panic!("{text:?}: {:?}", model.notices);
        };
        assert!(notice.ends_with(end), "{text:?}: {notice}");
    }
    // The other attribute is kept.
    let text = format!("{TRIANGLE}vt 0 0\nvt 1 0\nvt 0 1\nf 1/1/9 2/2/9 3/3/9\n");
    let mesh = parse_model(&text).unwrap().mesh;
    assert_eq!((mesh.uvs.len(), mesh.normals.len()), (3, 0));
    // These are applied: the obsolete form of faces, and names that end in a backslash.
    let model = parse_model(&format!("{TRIANGLE}usemtl a\\b\\\nfo 1 2 3\n")).unwrap();
    assert_eq!(model.mesh, plain);
    assert_eq!(model.looks.runs, [(0, "a\\b\\".to_owned())]);
    assert_eq!(model.notices, [""; 0]);
}

#[test]
fn files_without_faces_are_refused() {
    for text in [
        "",
        "\n\n",
        "# nothing",
        TRIANGLE,
        "v 0 0 0\nl 1 1",
        "\u{feff}",
    ] {
        let (line, message) = refusal_text(text);
        assert_eq!(
            (line, message.contains("has no face")),
            (None, true),
            "{message}"
        );
    }
}

#[test]
fn what_is_no_obj_is_refused() {
    let utf_16: Vec<u8> = "v 0 0 0\nf 1 1 1"
        .encode_utf16()
        .flat_map(u16::to_le_bytes)
        .collect();
    assert!(refusal_text(utf_16).1.contains("is not text"));
    let endless = vec![b'v'; 17 << 20];
    assert!(refusal_text(endless).1.contains("is over 16 MiB long"));
    let wide = format!("{TRIANGLE}f{}", " 1".repeat(5000));
    assert_eq!(refusal_text(wide).0, Some(4));
}

#[test]
fn a_source_that_fails_is_distinguished_from_bad_text() {
    struct Broken;
    impl std::io::Read for Broken {
        fn read(&mut self, _: &mut [u8]) -> std::io::Result<usize> {
            Err(std::io::Error::other("the disk is gone"))
        }
    }
    let error = parse_mesh(BufReader::new(Broken)).unwrap_err();
    assert!(error.to_string().contains("the disk is gone"), "{error}");
}

#[test]
fn paths_that_hold_no_file_are_refused() {
    let folder = tempfile::Builder::new().suffix(".obj").tempdir().unwrap();
    let error = read_scene(folder.path(), &FilesOnDisk)
        .unwrap_err()
        .to_string();
    assert!(error.contains("is not a file"), "{error}");
    let error = read_scene(&folder.path().join("missing.obj"), &FilesOnDisk)
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("missing.obj: can't be read") && error.contains("check the path"),
        "{error}"
    );
}

#[test]
fn a_big_file_is_read_whole() {
    let mut text = String::new();
    for i in 0..60_000 {
        text += &format!("v {i} 0 0\nv {i} 1 0\nv {i} 0 1\nf -1 -2 -3\n");
    }
    let mesh = read(text).unwrap();
    assert_eq!(
        (mesh.positions.len(), mesh.triangles.len()),
        (180_000, 60_000)
    );
    assert_eq!(mesh.positions[179_997], Vec3::new(59_999.0, 0.0, 1.0));
}

fn model_file(scale: f32, offset: f32) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = |x: f32| x * scale + offset;
    let mut text = String::new();
    for i in 0..8 {
        let [x, y, z] = [i & 1, i >> 1 & 1, i >> 2].map(|k| at(k as f32));
        text += &format!("v {x} {y} {z}\n");
    }
    text += "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    std::fs::write(folder.path().join("cube.obj"), text).unwrap();
    folder
}

/// Returns the positions of the corners, and of their shadows on the floor, in the image, -1 to 1.
/// Depths within near and far are in range.
fn framed_corners(scene: &Scene) -> Vec<Vec3> {
    let clip_from_world = scene.cameras[0].space().clip_from_world();
    let Light::Directional { direction, .. } = scene.lights[0] else {
        panic!("a sun");
    };
    let floor = scene.meshes[1].positions[0].y;
    let corners = scene.meshes[0].positions.iter().copied();
    let shadows = corners
        .clone()
        .map(|p| p + direction * ((floor - p.y) / direction.y));
    corners
        .chain(shadows)
        .map(|p| clip_from_world.project_point3(p))
        .collect()
}

#[test]
fn models_of_any_size_fill_the_picture() {
    for (scale, offset) in [
        (1.0, 0.0),
        (5e-3, 0.0),
        (3_700.0, -900.0),
        (1e-6, 0.0),
        (1e8, 0.0),
        (1.0, 1000.0),
    ] {
        let folder = model_file(scale, offset);
        let scene = read_scene(&folder.path().join("cube.obj"), &FilesOnDisk).unwrap();
        scene.validate().unwrap();
        assert_eq!((scene.name.as_str(), scene.lights.len()), ("cube", 1));
        let corners = framed_corners(&scene);
        let reach = corners
            .iter()
            .map(|p| p.truncate().abs().max_element())
            .fold(0.0, f32::max);
        assert!(
            reach > 0.9 && reach < 0.95,
            "scale {scale}: reaches {reach}"
        );
        assert!(
            corners.iter().all(|p| p.z > 0.0 && p.z < 1.0),
            "scale {scale}: {corners:?}"
        );
    }
}

#[test]
fn models_beyond_32_bit_floats_are_refused() {
    for scale in [0.0, 1e-9, 1e12] {
        let folder = model_file(scale, 0.0);
        let error = read_scene(&folder.path().join("cube.obj"), &FilesOnDisk)
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("m across; scale it to between 1e-6 and 1e8 m"),
            "{error}"
        );
    }
}

/// If `tobj` reads one of these correctly in a later version, the cleaner no longer needs its
/// guard.
#[test]
fn the_parser_alone_would_misread() {
    let alone = |text: String| {
        let read = tobj::load_obj_buf(&mut Cursor::new(text), &tobj::GPU_LOAD_OPTIONS, |_| {
            Ok(Default::default())
        });
        read.map(|(models, _)| {
            models
                .iter()
                .map(|m| m.mesh.indices.len() / 3)
                .sum::<usize>()
        })
    };
    assert_eq!(alone(format!("{TRIANGLE}f 1 2 3")), Ok(1));
    assert_eq!(
        alone(format!("{TRIANGLE}l 1 2 3")),
        Ok(1),
        "a line is no face"
    );
    assert!(
        alone(format!("\u{feff}{TRIANGLE}f 1 2 3")).is_err(),
        "the first vertex got lost"
    );
    assert!(alone(format!("{TRIANGLE}f 1 2 3 # comment")).is_err());
    assert!(alone(format!("{TRIANGLE}f 1 2 \\\n3")).is_err());
    assert!(alone("v 0 0 0 1 1 1\nv 1 0 0\nv 0 1 0\nf 1 2 3".to_owned()).is_err());
    assert!(alone(format!("{TRIANGLE}usemtl\nf 1 2 3")).is_err());
}

#[test]
fn damaged_files_are_read_or_refused_without_panic() {
    let text = format!(
        "o a\n{TRIANGLE}v 1 1 -1 1\nvt 0 .5\nvn 0 0 1\nf 1//1 2//-1 3/1/1\nf 1/1 2/-1 4/1 3/1 \\\n-1\nl 1 2"
    );
    let mut refused = 0;
    let mut usable = 0;
    for damaged in crate::damage::damaged_texts(&text, 4000) {
        match read(damaged) {
            Ok(mesh) => {
                usable += 1;
                mesh.validate().unwrap();
            }
            Err(_) => refused += 1,
        }
    }
    assert!(
        refused > 400 && usable > 400,
        "{refused} refused, {usable} read"
    );
}

/// Text with every kind of statement.
const ALL_KINDS: &str = "o a\nmtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1 1\nvt 0 0\nvt 1 0\nvt 0 1\n\
    vn 0 0 1\ng b\nusemtl red\ns 1\nf 1/1/1 2/2/1 3/3/1\nf 1 2 -1\nl 1 2\np 1\nfo 2 3 4\n";

/// Changes lines of a text: one is removed, duplicated, moved to the end, or has a changed word.
fn mutated_lines(text: &str, seed: i32) -> String {
    let pick = |what: i32, of: usize| {
        crate::builtin::noise::hash(umbrage_core::glam::IVec3::new(seed, what, 43)) as usize % of
    };
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    for step in (0..10 * (1 + pick(0, 3) as i32)).step_by(10) {
        let line = pick(step + 1, lines.len());
        match pick(step + 2, 4) {
            0 => drop(lines.remove(line)),
            1 => lines.insert(line, lines[line].clone()),
            2 => {
                let moved = lines.remove(line);
                lines.push(moved);
            }
            _ => {
                let odd = [
                    "nan", "-1", "0", "7", "1e39", "x", "1//9", "2/9", "", "vn", "\\",
                ];
                let mut words: Vec<&str> = lines[line].split(' ').collect();
                let word = pick(step + 3, words.len());
                words[word] = odd[pick(step + 4, odd.len())];
                lines[line] = words.join(" ");
            }
        }
    }
    lines.join("\n")
}

#[test]
fn mutated_models_never_panic_and_list_what_is_ignored() {
    const COUNT: i32 = 500;
    const APPLIED: [&str; 9] = ["v", "vt", "vn", "f", "fo", "o", "g", "usemtl", "mtllib"];
    let mut loaded = 0;
    for seed in 0..COUNT {
        let text = mutated_lines(ALL_KINDS, seed);
        let Ok(model) = parse_model(&text) else {
            continue;
        };
        loaded += 1;
        let is_continued = text.lines().any(|line| line.trim_end().ends_with('\\'));
        if is_continued {
            continue;
        }
        // The end of smoothing groups is applied.
        let lines = text.lines().filter(|line| line.trim() != "s 0");
        let keywords = lines.filter_map(|line| line.split_whitespace().next());
        let others = keywords.filter(|keyword| !APPLIED.contains(keyword));
        let listed = model
            .notices
            .iter()
            .find(|notice| notice.starts_with("statements are"));
        for keyword in others {
            let has_it = listed
                .is_some_and(|notice| notice.contains(&format!(" {} (", keyword.escape_debug())));
            assert!(has_it, "{keyword:?} of {seed}: {:?}", model.notices);
        }
    }
    assert!(3 * loaded >= COUNT, "{loaded} of {COUNT} files load");
}
