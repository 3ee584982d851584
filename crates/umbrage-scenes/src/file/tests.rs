use super::*;
use crate::FilesOnDisk;
use umbrage_core::Light;
use umbrage_core::glam::{Affine3A, UVec2, Vec3};

fn read(text: &str) -> Result<Scene, SceneError> {
    parse(text, Path::new("scene.toml"), Path::new(""), &FilesOnDisk)
}

const CAMERA: &str = "[camera]\neye = [0, 1, 5]\ntarget = [0, 0, 0]\n";
const LIGHT: &str = "[[light]]\nkind = \"directional\"\ndirection = [0, -1, 0.5]\n";
/// Start of the error for an object whose mesh `a.glb` is missing.
#[cfg(feature = "gltf")]
const GLTF: &str = "scene.toml:5: `object.mesh`: a.glb: can't be read";
#[cfg(not(feature = "gltf"))]
const GLTF: &str = "scene.toml:5: `object.mesh`: a.glb: is a glTF file, which this program was built without; build umbrage-scenes with its feature `gltf`";
const OBJECT: &str = "[[object]]\nshape = \"box\"\n";

/// Reads a light and an object from these lines.
fn one(light: &str, object: &str) -> Result<(Light, Affine3A), SceneError> {
    read(&format!("[[light]]\n{light}\n[[object]]\n{object}\n"))
        .map(|s| (s.lights[0], s.instances[0].world_from_local))
}

fn light(text: &str) -> Light {
    one(text, "shape = \"box\"").unwrap().0
}

#[test]
fn the_example_of_the_documentation_is_read_as_written() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(
        folder.path().join("teapot.obj"),
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3",
    )
    .unwrap();
    let text = r#"
name = "teapot under a lamp"
[camera]
eye = [5, 5.2, 9]
target = [0, 1, 0]
up = [0, 1, 0]
fov_y_degrees = 36
size = [320, 240]
[[light]]
kind = "rect"
center = [0, 9, 0]
half_u = [1, 0, 0]
half_v = [0, 0, 1]
[[object]]
mesh = "teapot.obj"
matrix = [[1,0,0,7],[0,2,0,8],[0,0,1,9],[0,0,0,1]]
casts = true
receives = false
"#;
    let path = folder.path().join("lamp.toml");
    std::fs::write(&path, text).unwrap();
    let scene = super::read(&path, &FilesOnDisk).unwrap();
    assert_eq!(scene.name, "teapot under a lamp");
    assert_eq!(scene.cameras[0].size, UVec2::new(320, 240));
    assert!(scene.cameras[0].eye().distance(Vec3::new(5.0, 5.2, 9.0)) < 1e-5);
    assert_eq!(
        scene.lights,
        [Light::Rect {
            center: Vec3::Y * 9.0,
            half_u: Vec3::X,
            half_v: Vec3::Z
        }]
    );
    let object = scene.instances[0];
    assert_eq!((object.casts, object.receives), (true, false));
    assert_eq!(
        object.world_from_local.transform_point3(Vec3::ONE),
        Vec3::new(8.0, 10.0, 10.0)
    );
    assert_eq!(scene.meshes[0].name, "teapot");
}

/// A scene whose positions are relative to `middle`.
fn scene_around(middle: [f64; 3], anchor: &str) -> String {
    let [x, y, z] = middle;
    let at = |a: f64, b: f64, c: f64| format!("[{:?}, {:?}, {:?}]", x + a, y + b, z + c);
    let lights: String = [
        ("point", "position"),
        ("spot", "position"),
        ("rect", "center"),
        ("disc", "center"),
    ]
    .map(|(kind, key)| {
        let rest = match kind {
            "spot" => "direction = [0, -1, 0]\nouter_degrees = 20",
            "rect" => "half_u = [1, 0, 0]\nhalf_v = [0, 0, 1]",
            "disc" => "normal = [0, 1, 0]\nradius = 0.5",
            _ => "",
        };
        format!(
            "[[light]]\nkind = \"{kind}\"\n{key} = {}\n{rest}\n",
            at(0.25, 4.0, -0.125)
        )
    })
    .concat();
    let [eye, target, ball] = [at(0.0, 1.5, 5.0), at(0.0, 0.5, 0.0), at(0.75, 0.5, -2.5)];
    let [tx, ty, tz] = [x - 3.0, y + 0.5, z + 0.25];
    format!(
        "{anchor}\n[camera]\neye = {eye}\ntarget = {target}\n{lights}\
         [[object]]\nshape = \"sphere\"\nscale = 0.3\nrotate_degrees = [10, 20, 30]\ntranslate = {ball}\n\
         [[object]]\nshape = \"box\"\nmatrix = [[1, 0, 0, {tx:?}], [0, 0.5, 0.1, {ty:?}], [0, 0, 1, {tz:?}], [0, 0, 0, 1]]\n"
    )
}

#[test]
fn places_are_read_relative_to_the_anchor() {
    let near = read(&scene_around([0.0; 3], "")).unwrap();
    let far = [1_000_448.0, -2048.0, -7_340_032.0];
    // Any nearby point selects the anchor.
    let anchor = "anchor = [1e6, -2000, -7_340_000.5]";
    let mut relative = read(&scene_around(far, anchor)).unwrap();
    let point = std::mem::take(&mut relative.anchor).point();
    assert_eq!((relative, point.to_array()), (near.clone(), far));
    // Without it, the anchor near the camera is chosen, and listed.
    let mut chosen = read(&scene_around(far, "")).unwrap();
    let notices = std::mem::take(&mut chosen.notices);
    let point = std::mem::take(&mut chosen.anchor).point();
    assert_eq!((chosen, point.to_array()), (near, far));
    assert!(
        notices.len() == 1 && notices[0].contains("`anchor = [1000448, -2048, -7340032]`"),
        "{notices:?}"
    );
    // An object without a position is at the world's origin.
    let plane = format!("anchor = [1024, 0, 0]\n{CAMERA}{LIGHT}{OBJECT}");
    let place = read(&plane).unwrap().instances[0].world_from_local;
    assert_eq!(place.translation, Vec3::new(-1024.0, 0.0, 0.0).into());
    for (anchor, why) in [
        ("[1e300, 0, 0]", "use finite coordinates up to 9.2"),
        ("[nan, 0, 0]", "is at [NaN, 0, 0]"),
        ("[0, 0]", "has 2 entries, not 3"),
        ("\"here\"", "is a string, not a list of 3"),
    ] {
        let text = format!("anchor = {anchor}\n{CAMERA}{LIGHT}{OBJECT}");
        let error = read(&text).unwrap_err().to_string();
        let begins = error.starts_with("scene.toml:1: `anchor`: ");
        assert!(begins && error.contains(why), "{error}");
    }
}

#[test]
fn every_kind_of_light_is_read() {
    let position = Vec3::new(1.0, 2.0, 3.0);
    let direction = Vec3::NEG_Y;
    let sun =
        light("kind = \"directional\"\ndirection = [0, -1, 0]\nangular_diameter_degrees = 180e-1");
    assert_eq!(
        sun,
        Light::Directional {
            direction,
            angular_diameter: 18.0_f32.to_radians()
        }
    );
    assert_eq!(
        light("kind = \"point\"\nposition = [1, 2, 3]"),
        Light::Point {
            position,
            radius: 0.0
        }
    );
    let spot = "kind = \"spot\"\nposition = [1, 2, 3]\ndirection = [0, -1, 0]\nouter_degrees = 30\nradius = 0x2";
    let [inner, outer] = [20.0_f32, 30.0].map(f32::to_radians);
    assert_eq!(
        light(spot),
        Light::Spot {
            position,
            direction,
            inner: outer,
            outer,
            radius: 2.0
        }
    );
    let soft = light(&format!("{spot}\ninner_degrees = 20"));
    assert_eq!(
        soft,
        Light::Spot {
            position,
            direction,
            inner,
            outer,
            radius: 2.0
        }
    );
    let disc = light("kind = \"disc\"\ncenter = [1, 2, 3]\nnormal = [0, -1, 0]\nradius = 0.5");
    assert_eq!(
        disc,
        Light::Disc {
            center: position,
            normal: direction,
            radius: 0.5
        }
    );
}

#[test]
fn placements_scale_then_turn_about_x_y_z_then_move() {
    let sun = "kind = \"directional\"\ndirection = [0, -1, 0]";
    let place = |object: &str| one(sun, &format!("shape = \"box\"\n{object}")).unwrap().1;
    let p = |object: &str, v: Vec3| place(object).transform_point3(v);
    // Sines and cosines of right angles have rounding errors.
    let near = |a: Vec3, b: Vec3| assert!(a.distance(b) < 1e-5, "{a} {b}");
    near(p("", Vec3::ONE), Vec3::ONE);
    near(
        p("scale = 2\ntranslate = [1, 0, 0]", Vec3::ONE),
        Vec3::new(3.0, 2.0, 2.0),
    );
    near(
        p("scale = [1, 2, -3]", Vec3::ONE),
        Vec3::new(1.0, 2.0, -3.0),
    );
    near(p("rotate_degrees = [90, 0, 0]", Vec3::Y), Vec3::Z);
    near(p("rotate_degrees = [0, 90, 0]", Vec3::Z), Vec3::X);
    near(p("rotate_degrees = [0, 0, 90]", Vec3::X), Vec3::Y);
    near(
        p(
            "rotate_degrees = [90, 90, 0]\nscale = 2\ntranslate = [0, 0, 1]",
            Vec3::Y,
        ),
        Vec3::new(2.0, 0.0, 1.0),
    );
}

#[test]
fn shapes_reach_from_minus_one_to_one() {
    for (shape, height) in [("plane", 0.0), ("box", 1.0), ("sphere", 1.0)] {
        let scene = read(&format!("{LIGHT}[[object]]\nshape = \"{shape}\"")).unwrap();
        let bounds = Geometry::bake(&scene).unwrap().bounds();
        let expected = Vec3::new(1.0, height, 1.0);
        // A sphere need not have vertices on the axes.
        assert!(
            bounds.max.distance(expected) < 0.01 && bounds.min.distance(-expected) < 0.01,
            "{shape} {bounds:?}"
        );
    }
}

#[test]
fn defaults_are_as_documented() {
    let scene = read(&format!("{LIGHT}{OBJECT}{OBJECT}casts = false")).unwrap();
    assert_eq!(
        (scene.name.as_str(), scene.cameras[0].size),
        ("scene", UVec2::new(640, 360))
    );
    assert_eq!(
        scene.lights[0],
        Light::Directional {
            direction: Vec3::new(0.0, -1.0, 0.5),
            angular_diameter: 0.0
        }
    );
    let roles: Vec<_> = scene
        .instances
        .iter()
        .map(|i| (i.casts, i.receives))
        .collect();
    assert_eq!(roles, [(true, true), (false, true)]);
    assert_eq!(scene.meshes.len(), 1, "the same shape twice is one mesh");
}

#[test]
fn near_and_far_are_fitted_where_absent() {
    let range = |planes: &str| {
        let scene = read(&format!("{CAMERA}{planes}\n{LIGHT}{OBJECT}")).unwrap();
        let m = scene.cameras[0].clip_from_view;
        [m.w_axis.z / m.z_axis.z, m.w_axis.z / (m.z_axis.z + 1.0)]
    };
    let near = |a: [f32; 2], b: [f32; 2]| {
        assert!(
            (a[0] / b[0] - 1.0).abs() < 1e-2 && (a[1] / b[1] - 1.0).abs() < 1e-2,
            "{a:?}"
        )
    };
    // The box from -1 to 1, seen from (0, 1, 5) towards the origin.
    near(range(""), [3.92, 6.27]);
    near(range("near = 1"), [1.0, 6.27]);
    near(range("far = 50"), [3.92, 50.0]);
    near(range("near = 0.5\nfar = 5"), [0.5, 5.0]);
    near(range("near = 20"), [20.0, 40.0]);
    near(range("far = 1"), [0.5, 1.0]);
}

/// Returns the line of an error and its text.
fn refusal_text(text: &str) -> (Option<usize>, String) {
    let error = read(text).unwrap_err();
    let text = error.to_string();
    match error {
        SceneError::Fault { place, .. } | SceneError::Named { place, .. } => (place.line, text),
        _ => (None, text),
    }
}

/// Each error is inserted as the last line of its table. The message must have that line, its key
/// and a remedy.
#[test]
fn faults_name_line_key_and_remedy() {
    let spot = "[[light]]\nkind = \"spot\"\nposition = [0, 3, 0]\ndirection = [0, -1, 0]\n";
    let disc = "[[light]]\nkind = \"disc\"\ncenter = [0, 3, 0]\nnormal = [0, -1, 0]\n";
    let cases = [
        (
            CAMERA,
            "tagret = [0, 0, 0]",
            "`camera.tagret`",
            "did you mean `target`?",
        ),
        (
            CAMERA,
            "up = [0, 0, 0]",
            "`camera.up`",
            "use a direction of any length greater than zero",
        ),
        (CAMERA, "up = [0, 1]", "`camera.up`", "write [x, y, z]"),
        (
            CAMERA,
            "up = 1",
            "`camera.up`: is an integer, not a list of 3",
            "write [x, y, z]",
        ),
        (
            CAMERA,
            "up = [0, \"1\", 0]",
            "`camera.up`: is a string, not a number",
            "without quotes",
        ),
        (
            CAMERA,
            "up = [0, nan, 0]",
            "`camera.up`: holds NaN",
            "use finite numbers",
        ),
        (
            CAMERA,
            "fov_y_degrees = 180",
            "`camera.fov_y_degrees`: is 180",
            "less than 180",
        ),
        (
            CAMERA,
            "fov_y_degrees = 0",
            "`camera.fov_y_degrees`: is 0",
            "greater than zero",
        ),
        (
            CAMERA,
            "size = [0, 10]",
            "`camera.size`: holds 0",
            "from 1 to 16384",
        ),
        (
            CAMERA,
            "size = [100000, 10]",
            "`camera.size`: holds 100000",
            "from 1 to 16384",
        ),
        (
            CAMERA,
            "size = [1.5, 10]",
            "`camera.size`: is a float, not a whole number",
            "from 1 to 16384",
        ),
        (
            CAMERA,
            "size = 640",
            "`camera.size`",
            "write [width, height]",
        ),
        (
            CAMERA,
            "near = -1",
            "`camera.near`: is -1",
            "greater than zero",
        ),
        (
            CAMERA,
            "far = inf",
            "`camera.far`: holds inf",
            "use finite numbers",
        ),
        (
            CAMERA,
            "near = 2\nfar = 1",
            "`camera.far`: is 1, and near is 2",
            "make near the smaller",
        ),
        (CAMERA, "near = 1e99", "`camera.near`", "use"),
        (
            LIGHT,
            "radius = 1",
            "`light.radius`: is not a known key here",
            "use `kind`, `direction` or `angular_diam",
        ),
        (
            LIGHT,
            "angular_diameter_degrees = -1",
            "`light.angular_diameter_degrees`: is -1",
            "use zero or more",
        ),
        (
            LIGHT,
            "angular_diameter_degrees = 200",
            "`light.angular_diameter_degrees`: is 200",
            "0 to less than 180",
        ),
        (
            spot,
            "outer_degrees = 90",
            "`light.outer_degrees`: is 90",
            "0 to less than 90",
        ),
        (
            spot,
            "outer_degrees = 0",
            "`light.outer_degrees`: is 0",
            "greater than zero",
        ),
        (
            spot,
            "outer_degrees = 20\ninner_degrees = 30",
            "`light.inner_degrees`: is wider",
            "make it the smaller",
        ),
        (
            disc,
            "radius = 0",
            "`light.radius`: is 0",
            "greater than zero",
        ),
        (
            disc,
            "radius = true",
            "`light.radius`: is a boolean, not a number",
            "write it as",
        ),
        (
            OBJECT,
            "casts = \"no\"",
            "`object.casts`: is a string, not true or false",
            "write true or false",
        ),
        (OBJECT, "shadow = true", "`object.shadow`", "use `mesh`"),
        (
            OBJECT,
            "recieves = true",
            "`object.recieves`",
            "did you mean `receives`?",
        ),
        (
            OBJECT,
            "mesh = \"a.obj\"",
            "`object.mesh`: conflicts with `shape`",
            "keep one",
        ),
        (
            OBJECT,
            "scale = 0",
            "`object.scale`: flattens",
            "sizes other than zero",
        ),
        (
            OBJECT,
            "scale = [1, 0, 1]",
            "`object.scale`: flattens",
            "sizes other than zero",
        ),
        (
            OBJECT,
            "matrix = [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,1,1]]",
            "`object.matrix`: ends in",
            "[0, 0, 0, 1]",
        ),
        (
            OBJECT,
            "matrix = [[1,0,0,0],[0,1,0,0],[0,0,0,0],[0,0,0,1]]",
            "`object.matrix`: flattens",
            "other than zero",
        ),
        (
            OBJECT,
            "matrix = [[1,0,0],[0,1,0],[0,0,1]]",
            "`object.matrix`: has 3 entries, not 4",
            "four rows",
        ),
        (
            OBJECT,
            "matrix = 3",
            "`object.matrix`: is an integer",
            "four rows",
        ),
        (
            OBJECT,
            "translate = [1, 2, 1e39]",
            "`object.translate`: holds inf",
            "use finite numbers",
        ),
    ];
    for (table, line, why, help) in cases {
        let rest = [CAMERA, LIGHT, OBJECT]
            .into_iter()
            .filter(|t| t.lines().next() != table.lines().next());
        let text = format!("name = \"x\"\n{table}{line}\n{}", rest.collect::<String>());
        let expected = 1 + table.lines().count() + line.lines().count();
        let (at, message) = refusal_text(&text);
        assert_eq!(at, Some(expected), "{message}\nfor\n{text}");
        assert!(
            message.starts_with(&format!("scene.toml:{expected}: ")),
            "{message}"
        );
        assert!(
            message.contains(why) && message.contains(help),
            "{line}: {message}"
        );
    }
}

#[test]
fn faults_in_the_whole_are_reported() {
    let cases = [
        ("nmae = \"x\"".to_owned(), "scene.toml:1: `nmae`: is not a known key here; did you mean `name`?"),
        ("name = 3".to_owned(), "scene.toml:1: `name`: is an integer, not text; put it in quotes"),
        ("name = \" \"".to_owned(), "scene.toml:1: `name`: is empty"),
        (String::new(), "scene.toml:1: has no [[light]]"),
        (LIGHT.to_owned(), "scene.toml:1: has no [[object]]"),
        (
            format!("{LIGHT}{OBJECT}[camera]\neye = [0, 0, 0]"),
            "scene.toml:6: `camera.target`: is missing; add `target = [",
        ),
        (
            format!("{LIGHT}{OBJECT}[camera]\neye = [0, 0, 0]\ntarget = [0, 0, 0.0]"),
            "scene.toml:8: `camera.target`: equals `eye`",
        ),
        (
            "[light]\nkind = \"point\"".to_owned(),
            "scene.toml:1: `light`: is a table, not a list of tables; write [[light]]",
        ),
        ("light = [1]".to_owned(), "scene.toml:1: `light`"),
        (
            format!("{LIGHT}{OBJECT}[[camera]]"),
            "scene.toml:6: `camera`: is a list, but there is only one; write [camera]",
        ),
        ("[[light]]".to_owned(), "scene.toml:1: `light.kind`: is missing"),
        ("[[light]]\nkind = \"sun\"".to_owned(), "scene.toml:2: `light.kind`: is \"sun\"; use `directional`, `point`"),
        (format!("{LIGHT}[[object]]\ncasts = true"), "scene.toml:4: `object`: has neither `shape` nor `mesh`"),
        (
            format!("{LIGHT}[[object]]\nshape = \"cube\""),
            "scene.toml:5: `object.shape`: is \"cube\"; use `plane`, `box` or",
        ),
        (format!("{LIGHT}[[object]]\nmesh = \"a.stl\""), "scene.toml:5: `object.mesh`: is `a.stl`, not a .obj, .glb or .gltf file; name a model"),
        (format!("{LIGHT}[[object]]\nmesh = \"a.stl#1\""), "scene.toml:5: `object.mesh`: is `a.stl#1`, not a .obj, .glb or .gltf file"),
        (format!("{LIGHT}[[object]]\nmesh = \"a.glb\""), GLTF),
        (format!("{LIGHT}{OBJECT}scale = 2\nmatrix = []"), "scene.toml:6: `object.scale`: conflicts with `matrix`"),
        ("a = 1\nname = \"x".to_owned(), "scene.toml:2: "),
        ("name = \"x\"\nname = \"y\"".to_owned(), "scene.toml:2: "),
        (
            format!("name = \"{}\"\n{LIGHT}{OBJECT}", "x".repeat(5000)),
            "scene.toml:1: `name`: is 5000 bytes long; use at most 200",
        ),
        (
            "[[light]]\nkind = \"rect\"\ncenter = [0, 1, 0]\nhalf_u = [1, 0, 0]\nhalf_v = [2, 0, 0]".to_owned(),
            "scene.toml:1: `light`: rect light, half_u x half_v is the zero vector",
        ),
    ];
    check_all(&cases);
}

#[test]
fn sizes_and_places_are_bounded() {
    let cases = [
        (
            format!("{LIGHT}{OBJECT}scale = 1e-9"),
            "scene.toml:6: `object.scale`: makes the object 2e-9 m across along one of its axes; use sizes from 1e-6 to 1e8 m",
        ),
        (
            format!("{CAMERA}{LIGHT}{OBJECT}scale = 1e-20"),
            "scene.toml:9: `object.scale`: makes the object 2e-20 m across",
        ),
        (
            format!("{CAMERA}{LIGHT}{OBJECT}scale = 1e30"),
            "scene.toml:9: `object.scale`: makes the object 2e30 m across",
        ),
        (
            format!("{CAMERA}{LIGHT}{OBJECT}scale = [1, 1e-20, 1]"),
            "scene.toml:9: `object.scale`: makes the object 2e-20",
        ),
        (
            format!("{CAMERA}{LIGHT}{OBJECT}matrix = [[1e9,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]"),
            "scene.toml:9: `object.matrix`: makes the object 2e9 m across",
        ),
        (
            format!("{CAMERA}{LIGHT}{OBJECT}scale = 2\ntranslate = [0, 1e30, 0]"),
            "scene.toml:10: `object.translate`: puts the object 1e30 m from the origin; use positions within 1e8 m",
        ),
    ];
    check_all(&cases);
}

/// Checks that each text is refused with a message that starts like this.
fn check_all(cases: &[(String, &str)]) {
    for (text, start) in cases {
        let (_, message) = refusal_text(text);
        assert!(message.starts_with(start), "{message}\nnot\n{start}");
    }
}

#[test]
fn faults_of_a_model_are_reported_with_both_places() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    let scene = format!("{LIGHT}[[object]]\nmesh = \"broken.obj\"\n");
    std::fs::write(&path, scene).unwrap();
    let message = super::read(&path, &FilesOnDisk).unwrap_err().to_string();
    assert!(
        message.contains("scene.toml:5: `object.mesh`: ") && message.contains("can't be read"),
        "{message}"
    );
    std::fs::write(folder.path().join("broken.obj"), "v 0 0 0\nf 1 2 3").unwrap();
    let message = super::read(&path, &FilesOnDisk).unwrap_err().to_string();
    assert!(
        message.contains("scene.toml:5: `object.mesh`: ") && message.contains("broken.obj:2: "),
        "{message}"
    );
}

#[test]
fn files_that_hold_no_text_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let message = |path: &Path| super::read(path, &FilesOnDisk).unwrap_err().to_string();
    assert!(message(&folder.path().join("none.toml")).contains("check the path"));
    assert!(message(folder.path()).contains("is not a file"));
    let binary = folder.path().join("binary.toml");
    std::fs::write(&binary, [0xff, 0xfe, 0x00]).unwrap();
    assert!(message(&binary).contains("UTF-8"), "{}", message(&binary));
}

#[test]
fn damaged_files_are_read_or_refused_without_panic() {
    let turned = "matrix = [[1,0,0,0],[0,2,0,0],[0,0,1,0],[0,0,0,1]]\nreceives = false\n";
    let spot = "[[light]]\nkind = \"spot\"\nposition = [0, 3, 0]\ndirection = [0, -1, 0]\nouter_degrees = 30\n";
    let text =
        format!("name = \"x\"\n{CAMERA}size = [64, 48]\nnear = 0.1\n{LIGHT}{spot}{OBJECT}{turned}");
    read(&text).unwrap();
    let mut refused = 0;
    let mut usable = 0;
    for damaged in crate::damage::damaged_texts(&text, 4000) {
        match read(&String::from_utf8_lossy(&damaged)) {
            Ok(scene) => {
                usable += 1;
                scene.validate().unwrap();
            }
            Err(_) => refused += 1,
        }
    }
    // TOML rejects most damage.
    assert!(
        refused > 400 && usable > 40,
        "{refused} refused, {usable} read"
    );
}
