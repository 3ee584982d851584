//! Tests of materials and images.

use super::{
    model::{PICTURE, SQUARE, TestModel},
    read_plain, scene_of,
};
use crate::FilesInMemory;
use image::{DynamicImage, ImageBuffer, ImageFormat, Rgb};
use serde_json::{Value, json};
use std::{f32::consts::FRAC_PI_2, io::Cursor};
use umbrage_core::glam::{Vec2, Vec3, Vec4};
use umbrage_core::{AlphaCutout, AlphaFilter, Geometry, Material, Mesh, Scene, Texels, Texture};

const UVS: [f32; 8] = [0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0];

/// A square with texture coordinates, this material, and [`PICTURE`] as texture 0.
fn square(material: Value) -> TestModel {
    let mut model = TestModel::new();
    let positions = model.floats("VEC3", 3, &SQUARE);
    let uvs = model.floats("VEC2", 2, &UVS);
    let normals = model.floats("VEC3", 3, &[0.0, 0.0, 1.0].repeat(4));
    let attributes = json!({ "POSITION": positions, "NORMAL": normals, "TEXCOORD_0": uvs });
    model.mesh(json!({ "attributes": attributes, "mode": 5, "material": 0 }));
    model.add("materials", material);
    let view = model.view(PICTURE);
    model.add(
        "images",
        json!({ "bufferView": view, "mimeType": "image/png" }),
    );
    model.add("textures", json!({ "source": 0 }));
    model.node(json!({ "mesh": 0 }));
    model
}

fn read(material: Value) -> Scene {
    let scene = scene_of(&square(material)).expect("valid");
    scene.validate().expect("valid");
    scene
}

fn base(texture: Value, factor: [f32; 4]) -> Value {
    json!({ "baseColorTexture": texture, "baseColorFactor": factor })
}

#[test]
fn colours_and_their_texture_are_read() {
    let pbr = base(json!({ "index": 0 }), [1.0, 0.5, 0.25, 1.0]);
    let scene = read(json!({ "pbrMetallicRoughness": pbr, "emissiveFactor": [0.5, 0, 2] }));
    let expected = Material {
        diffuse: Vec3::new(1.0, 0.5, 0.25),
        diffuse_texture: Some(0),
        emissive: Vec3::new(0.5, 0.0, 1.0),
        ..Material::default()
    };
    assert_eq!(scene.materials, [expected]);
    assert_eq!(scene.instances[0].material, Some(0));
    let texels = &scene.textures[0].texels;
    assert_eq!(*texels, Texels::Srgb8(vec![[255; 4], [0; 4]].into()));
    // Both count v from the top.
    assert_eq!(
        scene.meshes[0].uvs,
        UVS.as_chunks::<2>()
            .0
            .iter()
            .map(|&uv| Vec2::from_array(uv))
            .collect::<Vec<_>>()
    );
}

#[test]
fn masks_cut_out_and_blended_surfaces_cast_by_half() {
    let cut = |material: Value| {
        let scene = scene_of(&square(material)).map_err(|e| e.to_string())?;
        Ok::<_, String>((scene.materials[0].alpha, scene.instances[0].casts))
    };
    let holes = |cutoff| {
        Some(AlphaCutout {
            texture: 0,
            cutoff,
            filter: AlphaFilter::Nearest,
        })
    };
    let mask = |texture, factor, cutoff: f32| json!({ "alphaMode": "MASK", "alphaCutoff": cutoff, "pbrMetallicRoughness": base(texture, [1.0, 1.0, 1.0, factor]) });
    let texture = || json!({ "index": 0 });
    assert_eq!(cut(mask(texture(), 1.0, 0.25)), Ok((holes(0.25), true)));
    // The factor scales the whole texture: half of it is cut at twice the cut-off.
    assert_eq!(cut(mask(texture(), 0.5, 0.25)), Ok((holes(0.5), true)));
    assert_eq!(cut(mask(json!(null), 0.5, 0.25)), Ok((None, true)));
    assert_eq!(cut(mask(texture(), 1.0, 0.0)), Ok((None, true)));
    for gone in [mask(json!(null), 0.2, 0.25), mask(texture(), 0.2, 0.25)] {
        let message = cut(gone).expect_err("nothing is there");
        assert!(message.contains("has no triangles"), "{message}");
    }
    let usual =
        json!({ "alphaMode": "MASK", "pbrMetallicRoughness": { "baseColorTexture": texture() } });
    assert_eq!(cut(usual), Ok((holes(0.5), true)));
    let opaque = json!({ "pbrMetallicRoughness": base(texture(), [1.0, 1.0, 1.0, 0.1]) });
    assert_eq!(cut(opaque), Ok((None, true)));
    let blend = |texture, factor| json!({ "alphaMode": "BLEND", "pbrMetallicRoughness": base(texture, [1.0, 1.0, 1.0, factor]) });
    assert_eq!(cut(blend(texture(), 1.0)), Ok((holes(0.5), true)));
    assert_eq!(cut(blend(json!(null), 0.6)), Ok((None, true)));
    assert_eq!(cut(blend(json!(null), 0.3)), Ok((None, false)), "glass");
}

/// A `MASK` or `BLEND` material removes nothing if its texture is opaque everywhere, such as a
/// JPEG, which has no alpha.
#[test]
fn pictures_without_alpha_cut_nothing_out() {
    let opaque = DynamicImage::from(ImageBuffer::from_pixel(8, 8, Rgb([9_u8, 99, 9])));
    let mut jpeg = Cursor::new(Vec::new());
    opaque
        .write_to(&mut jpeg, ImageFormat::Jpeg)
        .expect("encoded");
    for mode in ["MASK", "BLEND"] {
        let has_holes = |picture: &[u8]| {
            let textured = base(json!({ "index": 0 }), [1.0; 4]);
            let mut model = square(json!({ "alphaMode": mode, "pbrMetallicRoughness": textured }));
            let view = model.view(picture);
            model.json["images"][0] = json!({ "bufferView": view });
            let scene = scene_of(&model).expect("valid");
            assert_eq!(scene.textures.len(), 1);
            let geometry = Geometry::bake(&scene).expect("valid");
            geometry.cut_outs().is_some()
        };
        assert!(has_holes(PICTURE), "{mode}");
        assert!(!has_holes(jpeg.get_ref()), "{mode}");
    }
}

/// Alpha tests repeat. A sampler that clamps or mirrors is refused only if a mesh would show a
/// difference. The texture has two texels, of which the right one is a hole.
#[test]
fn masks_that_do_not_repeat_are_refused_where_it_shows() {
    const CLAMPED: u32 = 33071;
    const MIRRORED: u32 = 33648;
    const REPEATED: u32 = 10497;
    let read = |mode: &str, sampler: Value, scale: [f32; 2], offset: f32| {
        let transform = json!({ "scale": scale, "offset": [offset, 0.0] });
        let texture = json!({ "index": 0, "extensions": { "KHR_texture_transform": transform } });
        let mut model = square(
            json!({ "alphaMode": mode, "pbrMetallicRoughness": { "baseColorTexture": texture } }),
        );
        model.json["samplers"] = json!([sampler]);
        model.json["textures"][0]["sampler"] = json!(0);
        scene_of(&model).map(|_| ())
    };
    let along_u = |wrap: u32| json!({ "wrapS": wrap, "magFilter": 9729, "minFilter": 1 });
    for wrap in [CLAMPED, MIRRORED] {
        let is_refused = |scale, offset| match read("MASK", along_u(wrap), scale, offset) {
            Ok(()) => false,
            Err(why) => {
                let expected = "primitive 0, alpha mask: exceeds its texture, which is clamped or mirrored there";
                assert!(why.contains(expected), "{why}");
                true
            }
        };
        assert!(!is_refused([1.0, 1.0], 0.0), "{wrap}");
        // Less than an eighth of a texel counts as rounding.
        assert!(!is_refused([1.05, 1.0], 0.0), "{wrap}");
        assert!(is_refused([1.1, 1.0], 0.0), "{wrap}");
        assert!(is_refused([2.0, 1.0], 0.0), "{wrap}");
        assert!(is_refused([0.5, 1.0], -0.5), "{wrap}");
        assert!(is_refused([1e30, 1.0], 0.0), "{wrap}");
        // Where 64 bits no longer resolve texels, all are equal.
        assert!(!is_refused([1e30, 1.0], -2e30), "{wrap}");
        // There is one texel along v, so wrapping has no effect.
        assert!(!is_refused([1.0, 7.0], 0.0), "{wrap}");
        let along_v = json!({ "wrapS": REPEATED, "wrapT": wrap });
        assert_eq!(read("MASK", along_v, [7.0, 7.0], 0.3), Ok(()));
        assert_eq!(read("OPAQUE", along_u(wrap), [7.0, 7.0], 0.3), Ok(()));
        assert!(read("BLEND", along_u(wrap), [7.0, 7.0], 0.3).is_err());
    }
    // From 1 to 1.5, a clamped texture shows its right half and a repeated one its left half. From
    // 2 to 2.5, a mirrored one shows its left half, too.
    assert!(read("MASK", along_u(MIRRORED), [0.5, 1.0], 1.0).is_err());
    assert_eq!(read("MASK", along_u(MIRRORED), [0.5, 1.0], 2.0), Ok(()));
    assert!(read("MASK", along_u(CLAMPED), [0.5, 1.0], 2.0).is_err());
    assert_eq!(read("MASK", along_u(CLAMPED), [0.5, 1.0], 2.5), Ok(()));
    // An invalid mode counts as repeated, like a missing one.
    assert_eq!(read("MASK", along_u(REPEATED), [7.0, 7.0], 0.3), Ok(()));
    assert_eq!(read("MASK", along_u(5), [7.0, 7.0], 0.3), Ok(()));
}

#[test]
fn coordinates_are_scaled_turned_and_moved() {
    let transform = json!({ "scale": [2, 3], "rotation": FRAC_PI_2, "offset": [10, 20] });
    let texture = json!({ "index": 0, "extensions": { "KHR_texture_transform": transform } });
    let scene = read(json!({ "pbrMetallicRoughness": { "baseColorTexture": texture } }));
    // A quarter turn counter-clockwise takes right to up, which is decreasing v: (u, v) becomes (v,
    // -u).
    for (found, uv) in scene.meshes[0].uvs.iter().zip(UVS.as_chunks::<2>().0) {
        let expected = Vec2::new(3.0 * uv[1] + 10.0, -2.0 * uv[0] + 20.0);
        assert!(found.distance(expected) < 1e-5, "{uv:?} became {found}");
    }
    // The mesh doesn't have this other set of coordinates.
    let other = json!({ "index": 0, "texCoord": 1 });
    let scene = read(json!({ "pbrMetallicRoughness": { "baseColorTexture": other } }));
    assert_eq!(scene.materials[0].diffuse_texture, None);
    let moved = json!({ "index": 0, "extensions": { "KHR_texture_transform": { "texCoord": 0 } }, "texCoord": 1 });
    let scene = read(json!({ "pbrMetallicRoughness": { "baseColorTexture": moved } }));
    assert_eq!(scene.materials[0].diffuse_texture, Some(0));
}

#[test]
fn normal_maps_bring_tangents() {
    let scene = read(json!({ "normalTexture": { "index": 0 } }));
    assert_eq!(
        (
            scene.materials[0].normal_map,
            scene.materials[0].diffuse_texture
        ),
        (Some(0), None)
    );
    assert_eq!(scene.textures[0].texels.get(0), [1.0; 4]);
    // u runs along x, v against y: the frame of a picture on a wall.
    assert_eq!(scene.meshes[0].tangents, [Vec4::new(1.0, 0.0, 0.0, 1.0); 4]);
    let mesh: &Mesh = &scene.meshes[0];
    assert!(mesh.normals.iter().all(|n| n.distance(Vec3::Z) < 1e-6));
    // Normal maps with other coordinates than the colours are not supported.
    let moved =
        json!({ "index": 0, "extensions": { "KHR_texture_transform": { "scale": [2, 2] } } });
    let both = |normals: &Value, colours: &Value| {
        let pbr = json!({ "baseColorTexture": colours });
        read(json!({ "normalTexture": normals, "pbrMetallicRoughness": pbr })).materials[0]
            .normal_map
    };
    let plain = json!({ "index": 0 });
    assert_eq!(both(&moved, &plain), None);
    assert_eq!(
        both(&plain, &plain),
        Some(1),
        "the picture once more, as numbers"
    );
    assert_eq!(both(&moved, &moved), Some(1));
}

#[test]
fn tangents_of_the_file_are_kept() {
    let mut model = square(json!({ "normalTexture": { "index": 0 } }));
    let own = [0.6, 0.8, 0.0, -1.0];
    let tangents = model.floats("VEC4", 4, &own.repeat(4));
    let attributes = &mut model.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["TANGENT"] = json!(tangents);
    let scene = scene_of(&model).expect("valid");
    assert_eq!(scene.meshes[0].tangents, [Vec4::from_array(own); 4]);
}

/// Reads a square with or without an image of this name next to it.
fn with_image_file(uri: &str, picture: Option<&[u8]>, mode: &str) -> Result<Vec<Texture>, String> {
    let pbr = json!({ "baseColorTexture": { "index": 0 } });
    let mut model = square(json!({ "alphaMode": mode, "pbrMetallicRoughness": pbr }));
    model.json["images"] = json!([{ "uri": uri, "name": "bark" }]);
    let mut files = FilesInMemory::default();
    files.insert("models/tree.glb", model.glb());
    if let Some(picture) = picture {
        files.insert("looks/bark 1.png", picture);
    }
    let scene = read_plain("models/tree.glb", &files).map_err(|e| e.to_string())?;
    Ok(scene.textures)
}

#[test]
fn pictures_may_be_jpeg_and_files_and_missing() {
    let color = DynamicImage::from(ImageBuffer::from_pixel(16, 8, Rgb([255_u8, 0, 0])));
    let mut jpeg = Cursor::new(Vec::new());
    color
        .write_to(&mut jpeg, ImageFormat::Jpeg)
        .expect("encoded");
    let jpeg = jpeg.into_inner();
    for picture in [PICTURE, &jpeg] {
        let textures =
            with_image_file("../looks/bark%201.png", Some(picture), "OPAQUE").expect("valid");
        assert_eq!(textures.len(), 1, "whatever its name says");
        assert!(
            (textures[0].texels.get(0)[0] - 1.0).abs() < 0.02,
            "{:?}",
            textures[0].texels.get(0)
        );
    }
    // Without looks, a model is read like one of OBJ. An alpha test needs them.
    assert_eq!(with_image_file("bark.png", None, "OPAQUE"), Ok(Vec::new()));
    let message = with_image_file("bark.png", None, "MASK").expect_err("no mask");
    assert!(
        message.contains("material 0, alpha mask: needs the texture"),
        "{message}"
    );
    assert_eq!(
        with_image_file("../looks/bark%201.png", Some(b"DDS "), "OPAQUE").expect_err("a lie"),
        "node 0, mesh 0, primitive 0, material 0, image 0 `bark`, its bytes: are neither a PNG nor a JPEG image; save it as one of the two"
    );
    let half = &PICTURE[..PICTURE.len() / 2];
    let message =
        with_image_file("../looks/bark%201.png", Some(half), "OPAQUE").expect_err("cut off");
    assert!(
        message.contains("image 0 `bark`, its bytes: can't be decoded"),
        "{message}"
    );
    let message =
        with_image_file("https://example.com/bark.png", None, "OPAQUE").expect_err("far away");
    assert!(
        message.contains("its URI: begins with `https:`"),
        "{message}"
    );
    assert_eq!(
        with_image_file("data:image/webp;base64,UklGRg==", None, "OPAQUE"),
        Ok(Vec::new())
    );
    let message =
        with_image_file("data:image/png;base64,UklGRg==", None, "OPAQUE").expect_err("a lie");
    assert!(
        message.contains("are neither a PNG nor a JPEG image"),
        "{message}"
    );
}

/// Files for colours of this size.
struct Sized(FilesInMemory, u32);

impl crate::Files for Sized {
    fn open(&self, path: &std::path::Path) -> std::io::Result<Box<dyn crate::OpenFile + '_>> {
        self.0.open(path)
    }

    fn color_side(&self) -> u32 {
        self.1
    }
}

#[test]
fn images_that_only_colour_surfaces_are_not_read_for_shadows() {
    let read = |mode: &str| {
        let texture = json!({ "index": 0 });
        let model = square(json!({
            "alphaMode": mode, "normalTexture": texture.clone(),
            "pbrMetallicRoughness": { "baseColorTexture": texture },
        }));
        let files = Sized([("a.glb", model.glb())].into_iter().collect(), 0);
        let wanted = crate::scene_of_file::SceneOfFile::of_path(std::path::Path::new("a.glb"));
        let bytes = files.0.bytes_of(std::path::Path::new("a.glb"));
        super::super::read(&bytes, &wanted.expect("a glTF file"), &files).expect("valid")
    };
    let opaque = read("OPAQUE");
    assert!(opaque.textures.is_empty());
    assert_eq!(opaque.notices, [""; 0]);
    let masked = read("MASK");
    assert_eq!(masked.textures.len(), 1);
    assert!(masked.materials[0].alpha.is_some() && masked.materials[0].normal_map.is_none());
}

#[test]
fn images_are_reduced_unless_their_alpha_casts() {
    let holes = |x: u32, y: u32| if (x, y) == (9, 4) { 0 } else { 255 };
    let picture = ImageBuffer::from_fn(64, 32, |x, y| {
        image::Rgba([200, 4 * x as u8, 100, holes(x, y)])
    });
    let mut png = Cursor::new(Vec::new());
    let encoded = DynamicImage::from(picture).write_to(&mut png, ImageFormat::Png);
    encoded.expect("encoded");
    let read = |mode: &str, color_side: u32| {
        let textured = base(json!({ "index": 0 }), [1.0; 4]);
        let mut model = square(json!({ "alphaMode": mode, "pbrMetallicRoughness": textured }));
        let view = model.view(png.get_ref());
        model.json["images"][0] = json!({ "bufferView": view });
        let files = [("a.glb", model.glb())].into_iter().collect();
        let scene = crate::read("a.glb", &Sized(files, color_side)).expect("valid");
        let geometry = Geometry::bake(&scene).expect("valid");
        let holes = geometry.cut_outs().map(|holes| holes.rows().to_vec());
        let textures = scene.textures.iter();
        let sides: Vec<u32> = textures.map(|texture| texture.size.x).collect();
        let shown = scene.materials[0].diffuse_texture;
        let alpha = scene.materials[0].alpha.map(|alpha| sides[alpha.texture]);
        (
            shown.map(|shown| scene.textures[shown].clone()),
            alpha,
            holes,
        )
    };
    let whole = read("OPAQUE", 64).0.expect("a texture");
    let reduced = read("OPAQUE", 16).0.expect("a texture");
    assert_eq!(
        [whole.size.to_array(), reduced.size.to_array()],
        [[64, 32], [16, 8]]
    );
    // Compare the middle of each reduced texel.
    for (i, texel) in reduced.texels.iter().enumerate() {
        let expected = whole.texels.get((4 * (i / 16) + 2) * 64 + 4 * (i % 16) + 2);
        let off = Vec3::from_slice(&texel).distance(Vec3::from_slice(&expected));
        assert!(off < 0.05, "{texel:?}, {expected:?}");
    }
    // The mask that casts shadows is that of the whole image, whatever the size of the colours.
    let (_, _, holes) = read("MASK", 64);
    assert!(holes.is_some());
    for (side, width) in [(0, 64), (16, 16)] {
        let (shown, mask, found) = read("MASK", side);
        assert_eq!(
            (shown.map(|shown| shown.size.x), mask),
            (Some(width), Some(64))
        );
        assert_eq!(found, holes, "{side}");
    }
}

/// An image that can't be decoded is reported by its own name, not by that of a mask that is read
/// after it.
#[test]
fn errors_of_images_name_no_other_material() {
    let textured = |texture: usize| base(json!({ "index": texture }), [1.0; 4]);
    let mut model = square(json!({ "pbrMetallicRoughness": textured(1) }));
    // A header of the right kind, and no pixels.
    let view = model.view(&PICTURE[..PICTURE.len() / 2]);
    model.add(
        "images",
        json!({ "bufferView": view, "mimeType": "image/png", "name": "bark" }),
    );
    model.add("textures", json!({ "source": 1 }));
    let mask = model.add(
        "materials",
        json!({ "alphaMode": "MASK", "pbrMetallicRoughness": textured(0) }),
    );
    let mut primitive = model.json["meshes"][0]["primitives"][0].clone();
    primitive["material"] = json!(mask);
    model.mesh(primitive);
    model.node(json!({ "mesh": 1 }));
    let message = scene_of(&model).expect_err("half an image").to_string();
    assert!(
        message.contains("image 1 `bark`, its bytes: can't be decoded"),
        "{message}"
    );
    assert!(!message.contains("material 1"), "{message}");
}
