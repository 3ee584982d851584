use super::super::{parse, read};
use crate::{FilesOnDisk, SceneError};
use std::path::Path;
use umbrage_core::glam::Vec3;
use umbrage_core::{AlphaFilter, Displacement, Geometry, Material, Scene};

const LIGHT: &str = "[[light]]\nkind = \"directional\"\ndirection = [0, -1, 0.5]\n";

/// Loads objects, next to 2 x 2 images `color.png`, `flat.png` (normals) and `heights.png` (16
/// bits).
fn scene(objects: &str) -> Result<Scene, SceneError> {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    image::RgbImage::from_pixel(2, 2, image::Rgb([128, 0, 255]))
        .save(at("color.png"))
        .unwrap();
    image::RgbImage::from_pixel(2, 2, image::Rgb([128, 128, 255]))
        .save(at("flat.png"))
        .unwrap();
    let heights = image::ImageBuffer::from_fn(2, 2, |x, _| image::Luma([65_535 * x as u16]));
    image::DynamicImage::from(heights)
        .save(at("heights.png"))
        .unwrap();
    std::fs::write(at("bare.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3").unwrap();
    std::fs::write(at("broken.png"), "no picture").unwrap();
    std::fs::write(at("scene.toml"), format!("{LIGHT}{objects}")).unwrap();
    read(&at("scene.toml"), &FilesOnDisk)
}

fn message(object: &str) -> String {
    let text = scene(&format!("[[object]]\n{object}"))
        .unwrap_err()
        .to_string();
    text[text.find("scene.toml").unwrap()..].to_owned()
}

#[test]
fn looks_are_read() {
    let text = "[[object]]\nshape = \"box\"\ncolor = [0.8, 0.2, 0]\nshininess = 64\nspecular = 0.5\nemissive = [0, 0, 3]\n";
    let scene = scene(text).unwrap();
    let expected = Material {
        diffuse: Vec3::new(0.8, 0.2, 0.0),
        shininess_log2: 6,
        specular: Vec3::splat(0.5),
        emissive: Vec3::Z * 3.0,
        ..Material::default()
    };
    assert_eq!(
        (scene.materials[0], scene.instances[0].material),
        (expected, Some(0))
    );
}

#[test]
fn objects_without_looks_have_no_material() {
    let scene =
        scene("[[object]]\nshape = \"box\"\n[[object]]\nshape = \"box\"\ncolor = [1, 1, 1]\n")
            .unwrap();
    assert_eq!(
        scene
            .instances
            .iter()
            .map(|i| i.material)
            .collect::<Vec<_>>(),
        [None, Some(0)]
    );
}

#[test]
fn textures_are_read_once_and_decoded_by_meaning() {
    let relief = "height_map = \"heights.png\"\ndisplacement = 0.25\nsubdivisions = 2\n";
    let text = format!(
        "[[object]]\nshape = \"plane\"\ntexture = \"color.png\"\nnormal_map = \"flat.png\"\n{relief}\
         [[object]]\nshape = \"sphere\"\ntexture = \"color.png\"\n[[object]]\nshape = \"box\"\n{relief}"
    );
    let scene = scene(&text).unwrap();
    let names: Vec<_> = scene.textures.iter().map(|t| t.name.as_str()).collect();
    assert_eq!(names, ["color.png", "flat.png", "heights.png"]);
    // 128 as sRGB by the standard's formula, and 128 as data; 16-bit white.
    let first = |i: usize| scene.textures[i].texels.get(1)[0];
    assert!((first(0) - 0.215_861).abs() < 1e-6, "{}", first(0));
    assert_eq!((first(1), first(2)), (128.0 / 255.0, 1.0));
    let [plane, sphere, block] = [0, 1, 2].map(|i| scene.materials[i]);
    let displacement = Some(Displacement {
        texture: 2,
        lambda: 0.25,
        subdivisions: 2,
    });
    assert_eq!(
        (plane.diffuse, plane.diffuse_texture, plane.normal_map),
        (Vec3::ONE, Some(0), Some(1))
    );
    assert_eq!(
        (plane.displacement, block.displacement, sphere.displacement),
        (displacement, displacement, None)
    );
    assert_eq!(
        scene.meshes[0].tangents.len(),
        scene.meshes[0].positions.len()
    );
    let baked = Geometry::bake(&scene).unwrap();
    assert_eq!(baked.triangles().len(), 2 * 16 + 5120 + 12 * 16);
}

#[test]
fn alpha_maps_cut_holes() {
    let scene = scene(
        "[[object]]\nshape = \"plane\"\nalpha_map = \"heights.png\"\n\
         [[object]]\nshape = \"box\"\nalpha_map = \"heights.png\"\nalpha_cutoff = 0\n\
         alpha_filter = \"hashed\"\n",
    )
    .unwrap();
    let alphas: Vec<_> = scene.materials.iter().map(|m| m.alpha.unwrap()).collect();
    let cutoffs = alphas.iter().map(|a| (a.texture, a.cutoff));
    assert_eq!(cutoffs.collect::<Vec<_>>(), [(0, 0.5), (0, 0.0)]);
    let filters = alphas.iter().map(|a| a.filter);
    assert_eq!(
        filters.collect::<Vec<_>>(),
        [AlphaFilter::Nearest, AlphaFilter::Hashed]
    );
    // Black on the left, white on the right.
    let texels = scene.textures[0]
        .texels
        .iter()
        .take(2)
        .map(|texel| texel[3]);
    assert_eq!(texels.collect::<Vec<_>>(), [0.0, 1.0]);
    assert!(Geometry::bake(&scene).unwrap().has_cut_out_casters());
}

#[test]
fn a_textured_sphere_is_the_same_sphere() {
    let corners = |look: &str| {
        let scene = scene(&format!("[[object]]\nshape = \"sphere\"\n{look}")).unwrap();
        let baked = Geometry::bake(&scene).unwrap();
        (0..5120).map(|t| baked.corners(t)).collect::<Vec<_>>()
    };
    assert_eq!(corners(""), corners("texture = \"color.png\""));
}

#[test]
fn one_mesh_serves_looks_with_the_same_needs() {
    let scene = scene(
        "[[object]]\nshape = \"sphere\"\n[[object]]\nshape = \"sphere\"\ncolor = [1, 0, 0]\n\
         [[object]]\nshape = \"sphere\"\ncolor = [0, 1, 0]\n[[object]]\nshape = \"sphere\"\ntexture = \"color.png\"\n",
    )
    .unwrap();
    assert_eq!(
        scene.instances.iter().map(|i| i.mesh).collect::<Vec<_>>(),
        [0, 1, 1, 2]
    );
}

#[test]
fn faults_name_the_line_and_the_key() {
    let cases = [
        ("color = [1, 0]", "`object.color`: has 2 entries, not 3"),
        (
            "color = [1, 0, 1.5]",
            "`object.color`: is [1, 0, 1.5]; use numbers from 0 to 1",
        ),
        (
            "colour = [1, 0, 1]",
            "`object.colour`: is not a known key here; did you mean `color`?",
        ),
        ("specular = 2", "`object.specular`: is 2; use 0 to 1"),
        ("emissive = [0, -1, 0]", "`object.emissive`: is -1"),
        (
            "shininess = 33",
            "`object.shininess`: is 33; use a power of two: 1, 2, 4, 8 and so on to 4096",
        ),
        (
            "shininess = 8192",
            "`object.shininess`: holds 8192; use a whole number from 0 to 4096",
        ),
        (
            "shininess = 0",
            "`object.shininess`: is 0; use a power of two",
        ),
        (
            "shininess = 2.5",
            "`object.shininess`: is a float, not a whole number",
        ),
        ("texture = \"none.png\"", "`object.texture`: "),
        ("texture = \"broken.png\"", "`object.texture`: "),
        ("texture = \"color.gif\"", "`object.texture`: is `"),
        ("texture = 3", "`object.texture`: is an integer, not text"),
        (
            "displacement = 0.1",
            "`object.displacement`: has no effect without `height_map`; add height_map = ",
        ),
        (
            "subdivisions = 2",
            "`object.subdivisions`: has no effect without `height_map`",
        ),
        (
            "alpha_cutoff = 0.3",
            "`object.alpha_cutoff`: has no effect without `alpha_map`; add alpha_map = ",
        ),
        (
            "alpha_filter = \"hashed\"",
            "`object.alpha_filter`: has no effect without `alpha_map`; add alpha_map = ",
        ),
        (
            "height_map = \"heights.png\"",
            "`object.displacement`: is missing; add `displacement = 0.05`",
        ),
    ];
    for (line, start) in cases {
        let text = message(&format!("shape = \"box\"\n{line}\n"));
        let at = if line.starts_with("height_map") { 4 } else { 6 };
        assert!(
            text.starts_with(&format!("scene.toml:{at}: {start}")),
            "{text}\nnot\n{start}"
        );
    }
    assert!(message("shape = \"box\"\ntexture = \"none.png\"").contains("none.png: can't be read"));
    assert!(
        message("shape = \"box\"\ntexture = \"broken.png\"")
            .contains("can't be read as a PNG or JPEG image")
    );
    let deep = "shape = \"box\"\nheight_map = \"heights.png\"\ndisplacement = 1\nsubdivisions = 9";
    assert!(message(deep).starts_with(
        "scene.toml:8: `object.subdivisions`: holds 9; use a whole number from 0 to 8"
    ));
    let beyond = "shape = \"box\"\nalpha_map = \"heights.png\"\nalpha_cutoff = 2";
    assert!(message(beyond).starts_with("scene.toml:7: `object.alpha_cutoff`: is 2; use 0 to 1"));
    let unknown = "shape = \"box\"\nalpha_map = \"heights.png\"\nalpha_filter = \"hash\"";
    let text = message(unknown);
    let start = "scene.toml:7: `object.alpha_filter`: is \"hash\"; use ";
    assert!(text.starts_with(start), "{text}");
    let bare = "mesh = \"bare.obj\"\ntexture = \"color.png\"";
    assert!(message(bare).starts_with(
        "scene.toml:6: `object.texture`: needs texture coordinates, and `bare` has none"
    ));
}

#[test]
fn text_without_a_folder_finds_no_textures() {
    let text = format!("{LIGHT}[[object]]\nshape = \"box\"\ntexture = \"nowhere.png\"");
    assert!(
        parse(&text, Path::new("scene.toml"), Path::new(""), &FilesOnDisk)
            .unwrap_err()
            .to_string()
            .contains("nowhere.png")
    );
}
