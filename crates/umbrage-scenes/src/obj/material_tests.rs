use super::{
    material::{Losses, parse},
    read_scene,
};
use crate::{FilesOnDisk, SceneError, SizedFilesOnDisk, detail::TextureFiles};
use std::path::Path;
use umbrage_core::glam::Vec3;
use umbrage_core::{Geometry, Scene};

const QUADS: &str = "mtllib looks.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\nvt 0 0\nvt 1 0\nvt 1 1\n\
                     usemtl red\nf 1/1 2/2 3/3 4/1\nusemtl brick\nf 2/1 5/2 6/3\nusemtl red\nf 2/1 6/2 3/3\n\
                     usemtl unknown\nf 1/1 4/2 3/3\n";

fn load(mtl: Option<&str>, images: &[(&str, [u8; 3])]) -> Result<Scene, SceneError> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("m.obj"), QUADS).unwrap();
    if let Some(mtl) = mtl {
        std::fs::write(folder.path().join("looks.mtl"), mtl).unwrap();
    }
    for (name, color) in images {
        image::RgbImage::from_pixel(2, 2, image::Rgb(*color))
            .save(folder.path().join(name))
            .unwrap();
    }
    let mut scene = read_scene(&folder.path().join("m.obj"), &FilesOnDisk)?;
    // Ignore the floor, which comes last.
    assert_eq!(
        scene.meshes.pop().map(|mesh| mesh.name),
        Some("floor".to_owned())
    );
    scene.instances.pop();
    scene.materials.pop();
    Ok(scene)
}

const LOOKS: &str = "# by hand\nnewmtl red\nKd 0.8 0.1 0\nKs .5\nNs 50 # near 64\nKe 0 0 2\nillum 2\r\n\nnewmtl brick\n\
                     map_Kd -s 1 1 1 .\\brick.png\nmap_Bump -bm 0.5 bumps.png\n";

#[test]
fn faces_are_grouped_by_material() {
    let scene = load(
        Some(LOOKS),
        &[("brick.png", [128, 255, 0]), ("bumps.png", [128, 128, 255])],
    )
    .unwrap();
    scene.validate().unwrap();
    let triangles: Vec<_> = scene
        .meshes
        .iter()
        .map(|mesh| mesh.triangles.len())
        .collect();
    assert_eq!(
        triangles,
        [3, 1, 1],
        "red twice, brick, and what nobody knows"
    );
    let materials: Vec<_> = scene.instances.iter().map(|i| i.material).collect();
    assert_eq!(materials, [Some(0), Some(1), None]);
    let red = scene.materials[0];
    assert_eq!(
        (red.diffuse, red.specular, red.shininess_log2),
        (Vec3::new(0.8, 0.1, 0.0), Vec3::splat(0.5), 6)
    );
    assert_eq!(red.emissive, Vec3::Z, "cut off at 1");
    let brick = scene.materials[1];
    let [color, normals] = [brick.diffuse_texture, brick.normal_map]
        .map(|id| scene.textures[id.unwrap()].texels.get(0));
    // sRGB 128 by the standard's formula; normals without conversion.
    assert!(
        (color[0] - 0.215_861).abs() < 1e-6 && normals[0] == 128.0 / 255.0,
        "{color:?} {normals:?}"
    );
    assert!(!scene.meshes[1].tangents.is_empty() && scene.meshes[0].tangents.is_empty());
    assert_eq!(Geometry::bake(&scene).unwrap().triangles().len(), 5);
}

#[test]
fn what_is_not_there_is_left_aside() {
    let plain = load(None, &[]).unwrap();
    assert_eq!((plain.meshes.len(), plain.materials.len()), (1, 0));
    let bare = load(Some(LOOKS), &[]).unwrap();
    assert_eq!((bare.materials.len(), bare.textures.len()), (2, 0));
    // Grey bump maps are heights without a scale.
    let grey = load(Some(LOOKS), &[("bumps.png", [128, 128, 128])]).unwrap();
    assert_eq!(grey.materials[1].normal_map, None);
    let other = load(Some("newmtl brick\nmap_Kd brick.jpg"), &[]).unwrap();
    assert_eq!(other.materials[0].diffuse_texture, None);
}

/// Alpha of `map_Kd` is used if the image has some, and `map_d` overrides it.
#[test]
fn alpha_cuts_holes() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let leaf = |alpha: [u8; 2]| {
        image::RgbaImage::from_fn(2, 1, |x, _| image::Rgba([9, 99, 9, alpha[x as usize]]))
    };
    leaf([255, 0]).save(at("leaf.png")).unwrap();
    leaf([255, 200]).save(at("full.png")).unwrap();
    let holes = image::GrayImage::from_fn(2, 1, |x, _| image::Luma([255 * x as u8]));
    holes.save(at("holes.png")).unwrap();
    std::fs::write(at("m.obj"), QUADS).unwrap();
    let alpha = |look: &str| {
        std::fs::write(at("looks.mtl"), format!("newmtl red\n{look}\n")).unwrap();
        let scene = read_scene(&at("m.obj"), &FilesOnDisk).unwrap();
        let alpha = scene.materials[0].alpha?;
        assert_eq!(alpha.cutoff, 0.5);
        let texels = &scene.textures[alpha.texture].texels;
        Some(texels.iter().map(|texel| texel[3]).collect::<Vec<_>>())
    };
    assert_eq!(alpha("map_Kd leaf.png"), Some(vec![1.0, 0.0]));
    assert_eq!(alpha("map_Kd full.png"), None);
    assert_eq!(
        alpha("map_Kd full.png\nmap_d holes.png"),
        Some(vec![0.0, 1.0])
    );
    assert_eq!(alpha("map_Kd leaf.png\nmap_d full.png"), None);
    assert_eq!(alpha("map_d missing.png"), None);
}

/// Returns the notices of a model with these materials, without the model's name. It is read with
/// colours, and for shadows alone.
fn notices(mtl: &str, obj: &str) -> [Vec<String>; 2] {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("m.obj"), obj).unwrap();
    std::fs::write(at("looks.mtl"), mtl).unwrap();
    let grey = image::RgbImage::from_pixel(2, 2, image::Rgb([128, 128, 128]));
    grey.save(at("grey.png")).unwrap();
    let model = format!("{}: ", at("m.obj").display());
    let prefix = format!("{}/", folder.path().display());
    [64, 0].map(|color_side| {
        let scene = crate::read(at("m.obj"), &SizedFilesOnDisk { color_side }).unwrap();
        let short = |notice: &String| notice.replace(&model, "").replace(&prefix, "");
        scene.notices.iter().map(short).collect()
    })
}

#[test]
fn losses_of_materials_are_listed() {
    let text = "newmtl red\nKd 1 0 0\nKa 1 1 1\nNi 1.5\nillum 2\nd 1\nTr 1\nmap_Kd -s 2 2 1 -o 0 0 0 grey.png\n\
                map_Ks shine.png\nmap_Bump -bm 1 grey.png\n\
                newmtl brick\nd -halo 0.5\nmap_Kd brick.jpg\nmap_d -clamp on holes.tga\nmap_bump gone.png\n\
                disp -s 1 1 1 heights.png\nnewmtl unused\nd 0.1\nmap_Ks other.png\n";
    let [all, for_shadows] = notices(text, QUADS);
    let shadows = [
        "ignored keys of materials: disp, map_Kd -s, map_d -clamp",
        "textures other than PNG and JPEG are ignored: holes.tga",
        "transparency (`d`, `Tr`) below 1 is ignored; these materials cast full shadows: brick",
        "undefined materials: unknown",
    ];
    assert_eq!(for_shadows, shadows);
    let expected = [
        "grey bump maps are ignored (heights without a scale): grey.png",
        "ignored keys of materials: disp, map_Kd -s, map_Ks, map_d -clamp",
        "textures are missing: brick.jpg, gone.png",
        "textures other than PNG and JPEG are ignored: holes.tga",
        "transparency (`d`, `Tr`) below 1 is ignored; these materials cast full shadows: brick",
        "undefined materials: unknown",
    ];
    assert_eq!(all, expected);
    // Faces without texture coordinates.
    let bare = QUADS.replace("/1", "").replace("/2", "").replace("/3", "");
    let text = "newmtl red\nmap_Kd grey.png\nnewmtl brick\nnewmtl unknown\n";
    let [bare, _] = notices(text, &bare);
    let why = "textures of these materials are ignored, since their faces have no texture coordinates: red";
    assert_eq!(bare, [why]);
    // An empty library.
    let [empty, _] = notices("", QUADS);
    assert_eq!(empty, ["undefined materials: brick, red, unknown"]);
    // Keys without an effect are no loss.
    let usual = "newmtl red\nKa 0 0 0\nKd 1 0 0\nTf 1 1 1\nTr 0\nNi 1\nillum 7\nmap_Ka grey.png\n\
                 newmtl brick\nd 1.0\nmap_Kd -s 1 1 1 -t 0 0 0 -clamp off grey.png\nnewmtl unknown\n";
    assert_eq!(notices(usual, QUADS), [[""; 0]; 2]);
}

/// Files with textures of at most 8 texels a side, and without textures, in OBJ and scene files.
#[test]
fn color_maps_are_reduced_and_alpha_maps_are_not() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let brick = image::RgbImage::from_fn(32, 32, |x, _| image::Rgb([8 * x as u8, 99, 9]));
    brick.save(at("brick.png")).unwrap();
    let leaf = image::RgbaImage::from_fn(32, 32, |x, y| {
        image::Rgba([9, 99, 9, if x == y { 0 } else { 255 }])
    });
    leaf.save(at("leaf.png")).unwrap();
    std::fs::write(at("m.obj"), QUADS).unwrap();
    let text = "newmtl red\nmap_Kd leaf.png\nnewmtl brick\nmap_Kd brick.png\nmap_d leaf.png\n\
                map_Bump brick.png\n";
    std::fs::write(at("looks.mtl"), text).unwrap();
    let text = "[[light]]\nkind = \"directional\"\ndirection = [0, -1, 0.5]\n[[object]]\nshape = \"box\"\n\
                texture = \"leaf.png\"\nalpha_map = \"leaf.png\"\nnormal_map = \"brick.png\"\n\
                height_map = \"brick.png\"\ndisplacement = 0.1\n";
    std::fs::write(at("s.toml"), text).unwrap();
    let sides = |file: &str, color_side: u32| {
        let scene = crate::read(at(file), &SizedFilesOnDisk { color_side }).unwrap();
        let textures = scene.textures.iter();
        let sides: Vec<(String, u32)> = textures.map(|t| (t.name.clone(), t.size.x)).collect();
        let holes = Geometry::bake(&scene).unwrap().cut_outs().cloned();
        (sides, holes)
    };
    let named = |sides: &[(&str, u32)]| -> Vec<(String, u32)> {
        let owned = sides.iter().map(|(name, side)| ((*name).to_owned(), *side));
        owned.collect()
    };
    let (leaf, brick) = ("leaf.png", "brick.png");
    let all = named(&[(leaf, 32), (leaf, 8), (brick, 8), (leaf, 32), (brick, 8)]);
    let (found, holes) = sides("m.obj", 8);
    assert_eq!((found, holes.is_some()), (all, true));
    let cast = named(&[(leaf, 32), (leaf, 32)]);
    assert_eq!(sides("m.obj", 0), (cast, holes));
    let all = named(&[(leaf, 8), (brick, 8), (brick, 32), (leaf, 32)]);
    let (found, holes) = sides("s.toml", 8);
    assert_eq!((found, holes.is_some()), (all, true));
    let cast = named(&[(brick, 32), (leaf, 32)]);
    assert_eq!(sides("s.toml", 0), (cast, holes));
}

#[test]
fn broken_looks_are_refused_with_their_line() {
    let message = |mtl: &str| load(Some(mtl), &[]).unwrap_err().to_string();
    let text = message("newmtl red\n\nKd red\n");
    assert!(text.ends_with(
        "looks.mtl:3: `Kd`: holds `red`, which is not a number; write numbers as 0.5, one or three"
    ));
    assert!(message("newmtl red\nNs\n").contains("looks.mtl:2: `Ns`: holds nothing"));
    assert!(message("newmtl red\nKs 1 nan 0\n").contains("holds `nan`"));
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("m.obj"), QUADS).unwrap();
    std::fs::write(folder.path().join("looks.mtl"), LOOKS).unwrap();
    std::fs::write(folder.path().join("brick.png"), "no picture").unwrap();
    let text = read_scene(&folder.path().join("m.obj"), &FilesOnDisk)
        .unwrap_err()
        .to_string();
    assert!(
        text.contains("brick.png: can't be read as a PNG or JPEG image"),
        "{text}"
    );
}

#[test]
fn powers_are_rounded_to_powers_of_two() {
    for (ns, expected) in [
        ("0", 0),
        ("-3", 0),
        ("1", 0),
        ("1.5", 1),
        ("10", 3),
        ("32", 5),
        ("250", 8),
        ("1e9", 12),
    ] {
        let entries = parse(&format!("newmtl a\nNs {ns}"), Path::new("a.mtl")).unwrap();
        let material = entries[0]
            .textured(
                false,
                &mut TextureFiles::new(&FilesOnDisk),
                &mut Vec::new(),
                &mut Losses::new(),
            )
            .unwrap()
            .material(&[], &mut Losses::new());
        assert_eq!(material.shininess_log2, expected, "{ns}");
    }
}

#[test]
fn damaged_files_are_read_or_refused_without_panic() {
    let mut refused = 0;
    let mut usable = 0;
    for damaged in crate::damage::damaged_texts(LOOKS, 2000) {
        match parse(&String::from_utf8_lossy(&damaged), Path::new("a.mtl")) {
            Ok(_) => usable += 1,
            Err(_) => refused += 1,
        }
    }
    assert!(
        refused > 100 && usable > 100,
        "{refused} refused, {usable} read"
    );
}

/// Faces through which all light passes cast nothing. `d` precedes `Tr`.
#[test]
fn materials_without_opacity_cast_no_shadow() {
    let casts = |opacity: &str| {
        let scene = load(Some(&format!("newmtl red\n{opacity}\n")), &[]).unwrap();
        let part = scene.instances.iter().find(|i| i.material == Some(0));
        let others = scene.instances.iter().filter(|i| i.material != Some(0));
        assert!(others.into_iter().all(|other| other.casts));
        part.unwrap().casts
    };
    for clear in ["d 0", "Tr 1", "d 0.0\nTr 0", "d -halo 0"] {
        assert!(!casts(clear), "{clear}");
    }
    for opaque in ["", "d 1", "Tr 0", "d 1\nTr 1", "d 0.01", "Tr 0.5"] {
        assert!(casts(opaque), "{opaque}");
    }
    let [all, _] = notices(
        "newmtl red\nd 0\nnewmtl brick\nd 0.5\nnewmtl unknown\n",
        QUADS,
    );
    let expected = [
        "materials without opacity (`d`, `Tr`) cast no shadows: red",
        "transparency (`d`, `Tr`) below 1 is ignored; these materials cast full shadows: brick",
    ];
    assert_eq!(all, expected);
}

/// JPEG images colour surfaces and cut holes, in OBJ and in scene files.
#[cfg(feature = "gltf")]
#[test]
fn jpeg_images_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let grey = image::RgbImage::from_pixel(8, 8, image::Rgb([128; 3]));
    grey.save(at("grey.jpg")).unwrap();
    let holes = image::GrayImage::from_fn(16, 16, |x, _| image::Luma([255 * (x / 8) as u8]));
    holes.save(at("holes.JPEG")).unwrap();
    std::fs::write(at("m.obj"), QUADS).unwrap();
    let text = "newmtl red\nmap_Kd grey.jpg\nmap_d holes.JPEG\n";
    std::fs::write(at("looks.mtl"), text).unwrap();
    let text = "[[light]]\nkind = \"directional\"\ndirection = [0, -1, 0.5]\n[[object]]\nshape = \"box\"\n\
                texture = \"grey.jpg\"\nalpha_map = \"holes.JPEG\"\n";
    std::fs::write(at("s.toml"), text).unwrap();
    for file in ["m.obj", "s.toml"] {
        let scene = crate::read(at(file), &FilesOnDisk).unwrap();
        let material = scene.materials[0];
        let color = scene.textures[material.diffuse_texture.unwrap()]
            .texels
            .get(0);
        assert!((color[0] - 0.215_861).abs() < 0.01, "{file}: {color:?}");
        let alpha = &scene.textures[material.alpha.unwrap().texture].texels;
        assert!(alpha.get(0)[3] < 0.1 && alpha.get(15)[3] > 0.9, "{file}");
    }
}
