//! Snapshots of error messages: what is wrong, where, and what to do.

use std::fmt::Display;
use umbrage_core::{Camera, Light, Mesh, ShadowTechnique, View, glam::UVec2, glam::Vec3};
use umbrage_techniques::MapFilter as _;
use umbrage_tests::stage;
use umbrage_wgpu::{AdapterChoice, Gpu};

fn line<T, E: Display>(case: &str, result: Result<T, E>) -> String {
    let message = result.map_or_else(|e| e.to_string(), |_| "no error".to_owned());
    assert_ne!(message, "no error", "{case} must be refused");
    format!("{case}\n  {message}\n")
}

#[test]
fn scene_names_and_paths() {
    let cases = [
        "cubse",
        "",
        "nonsense-without-a-neighbour",
        "missing.toml",
        "missing.obj",
        "picture.png",
    ];
    let text: String = cases
        .iter()
        .map(|&name| line(&format!("{name:?}"), umbrage_scenes::by_argument(name)))
        .collect();
    insta::assert_snapshot!(text);
}

const CAMERA: &str = "[camera]\neye = [5, 5, 9]\ntarget = [0, 1, 0]\nsize = [32, 24]\n";
const LIGHT: &str = "[[light]]\nkind = \"point\"\nposition = [0, 9, 0]\n";
const OBJECT: &str = "[[object]]\nshape = \"box\"\n";

#[test]
fn scene_files() {
    let good = [CAMERA, LIGHT, OBJECT].concat();
    umbrage_scenes::parse(&good, "good.toml", ".").expect("the file that the others spoil is good");
    let cases = [
        ("not TOML", "name = [".to_owned()),
        ("an unknown key", good.replace("position", "place")),
        ("a wrong type", good.replace("[0, 9, 0]", "9")),
        ("too few numbers", good.replace("[0, 9, 0]", "[0, 9]")),
        ("an unknown kind of light", good.replace("point", "laser")),
        ("no light", [CAMERA, OBJECT].concat()),
        (
            "an image without pixels",
            good.replace("[32, 24]", "[0, 24]"),
        ),
        (
            "an eye at its target",
            good.replace("[5, 5, 9]", "[0, 1, 0]"),
        ),
        ("not a number", good.replace("[0, 9, 0]", "[nan, 9, 0]")),
        (
            "a missing mesh",
            good.replace("shape = \"box\"", "mesh = \"missing.obj\""),
        ),
        ("a flattened object", good.clone() + "scale = 0\n"),
    ];
    let text: String = cases
        .iter()
        .map(|(case, text)| line(case, umbrage_scenes::parse(text, "scene.toml", ".")))
        .collect();
    insta::assert_snapshot!(text);
}

#[test]
fn parameters() {
    let geometry = stage::geometry(1.0, Vec3::ZERO);
    let camera = stage::camera();
    let light = Light::Point {
        position: Vec3::new(0.0, 9.0, 0.0),
        radius: 0.0,
    };
    let view = View::new(&camera, &light, &geometry);
    let text = [
        line(
            "a map without texels",
            umbrage_techniques::Hard {}.on(map(0)).recipe(&view),
        ),
        line(
            "a kernel too wide",
            umbrage_techniques::Pcf::new(10_000)
                .on(map(64))
                .recipe(&view),
        ),
        line(
            "a kernel too wide to be unrolled",
            umbrage_techniques::Pcf::unrolled(5)
                .on(map(64))
                .recipe(&view),
        ),
        line(
            "no samples",
            umbrage_techniques::Traced { samples: 0 }.recipe(&view),
        ),
        line(
            "a light without direction",
            Light::Directional {
                direction: Vec3::ZERO,
                angular_diameter: 0.0,
            }
            .validate(),
        ),
        line(
            "a mesh without triangles",
            Mesh::new("floor", vec![Vec3::ZERO], Vec::new()),
        ),
        line(
            "an index out of range",
            Mesh::new("floor", vec![Vec3::ZERO; 3], vec![[0, 1, 3]]),
        ),
        line(
            "near beyond far",
            Camera::perspective(Vec3::ONE, Vec3::ZERO, Vec3::Y, 1.0, [2.0, 1.0], UVec2::ONE),
        ),
    ];
    insta::assert_snapshot!(text.concat());
}

fn map(size: u32) -> umbrage_techniques::ShadowMap {
    umbrage_techniques::ShadowMap {
        size,
        ..Default::default()
    }
}

#[test]
fn no_adapter() {
    let choice = AdapterChoice {
        name: Some("no such adapter".to_owned()),
        ..AdapterChoice::default()
    };
    // Filter the list of adapters, which differs from machine to machine.
    insta::with_settings!({filters => vec![(r"found: [^;]*\)", "found: [what there is])")]}, {
        insta::assert_snapshot!(line("an adapter by a wrong name", Gpu::new(&choice)));
    });
}
