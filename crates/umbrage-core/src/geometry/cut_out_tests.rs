use super::*;
use crate::{
    geometry::{Geometry, random::Random, ray_triangle::segment_hits},
    scene::{Instance, Mesh, light_sample::hash, material::Material},
};
use glam::Affine3A;

/// Returns a texture whose texels are opaque where `is_there` returns true.
fn texture(size: UVec2, is_there: impl Fn(u32, u32) -> bool) -> Texture {
    let mut texels = Vec::new();
    for y in 0..size.y {
        for x in 0..size.x {
            texels.push([1.0, 1.0, 1.0, f32::from(u8::from(is_there(x, y)))]);
        }
    }
    Texture {
        name: "holes".into(),
        size,
        texels: texels.into(),
    }
}

/// Returns a slanted card, its lower left corner at the origin. The texture repeats `repeats` times
/// over its width.
fn card(texture: Option<Texture>, repeats: f32) -> Scene {
    let corner = |x: f32, y: f32| Vec3::new(3.0 * x, 2.0 * y, x + 0.5 * y);
    let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let mesh = Mesh {
        name: "card".into(),
        positions: corners.map(|(x, y)| corner(x, y)).to_vec(),
        uvs: corners
            .map(|(x, y)| Vec2::new(x * repeats, 1.0 - y))
            .to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    let alpha = texture.is_some().then_some(AlphaCutout {
        texture: 0,
        cutoff: 0.5,
        filter: AlphaFilter::Nearest,
    });
    let mut instance = Instance::new(0, Affine3A::IDENTITY);
    instance.material = Some(0);
    Scene {
        meshes: vec![mesh],
        instances: vec![instance],
        materials: vec![Material {
            alpha,
            ..Material::default()
        }],
        textures: texture.into_iter().collect(),
        ..Scene::default()
    }
}

fn bake_scene(scene: &Scene) -> Geometry {
    Geometry::bake(scene).unwrap()
}

/// Rays hit opaque texels and pass through clear ones, compared with a 64-bit reference.
#[test]
fn rays_pass_through_clear_texels() {
    let size = UVec2::new(13, 7);
    let is_there = |x: u32, y: u32| !hash(x + 100 * y).is_multiple_of(3);
    let g = bake_scene(&card(Some(texture(size, is_there)), 2.5));
    let mut random = Random(3);
    let mut passed = 0;
    let mut met = 0;
    for _ in 0..4000 {
        let [x, y] = [random.unit(), random.unit()];
        // Skip points near borders between texels, where 32 bits may choose either.
        let place = Vec2::new(2.5 * x, 1.0 - y) * size.as_vec2();
        let to_border = (place - place.round()).abs().min_element();
        if to_border < 1e-3 {
            continue;
        }
        let texel = place.as_uvec2() % size;
        let p = Vec3::new(3.0 * x, 2.0 * y, x + 0.5 * y);
        let o = p + random.vector() * 5.0;
        let d = (p - o) * 1.5;
        let hits = |id| {
            let [a, b, c] = g.corners(id);
            segment_hits(o, d, a, b, c)
        };
        if !(hits(0) || hits(1)) {
            continue;
        }
        let expected = is_there(texel.x, texel.y);
        assert_eq!(g.bvh().is_occluded(o, d, u32::MAX), expected, "{place}");
        let nearest = g.bvh().nearest(&g, o, d, u32::MAX);
        assert_eq!(nearest.is_some(), expected, "{place}");
        if expected {
            met += 1;
        } else {
            passed += 1;
        }
    }
    assert!(passed > 500 && met > 1000, "{passed} passed, {met} met");
}

/// A ray that passes through a hole hits the geometry behind it.
#[test]
fn what_is_behind_a_hole_is_hit() {
    let mut scene = card(Some(texture(UVec2::splat(2), |_, _| false)), 1.0);
    scene.instances.push(Instance {
        material: None,
        ..Instance::new(0, Affine3A::from_translation(Vec3::Z * 5.0))
    });
    let g = bake_scene(&scene);
    let o = Vec3::new(1.5, 1.0, -3.0);
    // The alpha-tested card comes first in the list, and is passed at z = 0.75.
    assert_eq!(g.cut_outs().unwrap().runs(), &[0..2, 4..4]);
    let met = g.bvh().nearest(&g, o, Vec3::Z * 10.0, u32::MAX).unwrap();
    assert!((met - 0.875).abs() < 1e-6, "{met}");
    assert!(!g.bvh().is_occluded(o, Vec3::Z * 5.0, u32::MAX));
}

/// A texture without visible holes behaves like no alpha texture, and a clear texture like no
/// geometry.
#[test]
fn textures_without_holes_and_without_anything() {
    // The card shows three quarters of the texture's width, and the hole is in its last fifth.
    let is_shown = |x: u32, _: u32| x < 4;
    let full = bake_scene(&card(Some(texture(UVec2::splat(5), is_shown)), 0.75));
    let clear = bake_scene(&card(Some(texture(UVec2::splat(3), |_, _| false)), 1.0));
    let plain = bake_scene(&card(None, 1.0));
    assert!(plain.cut_outs().is_none() && !plain.has_cut_out_casters());
    assert!(full.has_cut_out_casters());
    assert!(!full.without_casters().has_cut_out_casters());
    let mut random = Random(9);
    let mut hits = 0;
    for _ in 0..4000 {
        let o = random.vector() * 4.0;
        let d = random.vector() * 8.0;
        let expected = plain.bvh().is_occluded(o, d, u32::MAX);
        assert_eq!(full.bvh().is_occluded(o, d, u32::MAX), expected);
        assert!(!clear.bvh().is_occluded(o, d, u32::MAX));
        hits += u32::from(expected);
    }
    assert!(hits > 100, "{hits}");
}

/// An alpha texture without a texel below the cut-off is ignored, for every filter. One such texel
/// changes this, and so does a cut-off that is the next float above all alphas.
#[test]
fn textures_without_a_hole_cut_nothing_out() {
    let has_holes = |alphas: [f32; 4], cutoff, filter| {
        let mut scene = card(Some(texture(UVec2::splat(2), |_, _| true)), 1.0);
        scene.textures[0].texels = alphas.map(|alpha| [1.0, 1.0, 1.0, alpha]).to_vec().into();
        scene.materials[0].alpha = Some(AlphaCutout {
            texture: 0,
            cutoff,
            filter,
        });
        // A material without an alpha texture precedes it in the list.
        scene.materials.insert(0, Material::default());
        scene.instances[0].material = Some(1);
        let geometry = bake_scene(&scene);
        assert_eq!(geometry.has_holes(0), geometry.has_cut_out_casters());
        assert_eq!(geometry.has_holes(0), geometry.cut_outs().is_some());
        geometry.has_holes(0)
    };
    for filter in [AlphaFilter::Nearest, AlphaFilter::Hashed] {
        assert!(!has_holes([1.0; 4], 1.0, filter));
        assert!(!has_holes([0.5; 4], 0.5, filter));
        assert!(!has_holes([0.0; 4], 0.0, filter));
        assert!(has_holes([0.5; 4], 0.5_f32.next_up(), filter));
        assert!(has_holes([0.5, 0.5, 0.5, 0.25], 0.5, filter));
        assert!(!has_holes([0.5, 0.5, 0.5, 0.25], 0.25, filter));
    }
}

/// `is_hole_around` considers all texels in the box.
#[test]
fn what_is_around_a_point() {
    let g = bake_scene(&card(Some(texture(UVec2::splat(2), |x, y| x == y)), 1.0));
    let cut_outs = g.cut_outs().unwrap();
    // Corner b of the first triangle is at the right and the bottom: texel (1, 1).
    let near_b = [[0.1, 0.8, 0.1], [0.05, 0.9, 0.05]];
    assert_eq!(cut_outs.is_hole_around(0, &near_b), Some(false));
    // Corner a is at the left, in texel (0, 1).
    let near_a = [[0.8, 0.1, 0.1], [0.8, 0.0, 0.2]];
    assert_eq!(cut_outs.is_hole_around(0, &near_a), Some(true));
    assert_eq!(cut_outs.is_hole_around(0, &[near_a[0], near_b[1]]), None);
    let far = [[1e300, 0.0, 0.0], [0.0, 1.0, 0.0]];
    assert_eq!(cut_outs.is_hole_around(0, &far), None);
    assert_eq!(cut_outs.is_hole_around(7, &far), Some(false));
}

#[test]
fn uvs_that_are_no_numbers_have_a_texel() {
    for t in [f32::NAN, f32::INFINITY, -1e38, 0.0, 1.0, -5.0] {
        assert_eq!(nearest_texel(t, 4), 0, "{t}");
    }
    assert_eq!(nearest_texel(-1e-9, 4), 3);
    assert_eq!(nearest_texel(-0.3, 4), 2);
    assert_eq!(nearest_texel(7.99, 4), 3);
    assert_eq!(nearest_texel(0.25, 4), 1);
}

/// Materials share the bits of a texture unless their cut-offs differ; the fingerprints of the
/// geometries differ.
#[test]
fn textures_are_kept_once_for_each_cut_off() {
    let rows = |cutoffs: [f32; 2]| {
        let mut scene = card(Some(texture(UVec2::new(20, 10), |x, _| x > 3)), 1.0);
        scene.materials = cutoffs
            .map(|cutoff| Material {
                alpha: Some(AlphaCutout {
                    texture: 0,
                    cutoff,
                    filter: AlphaFilter::Nearest,
                }),
                ..Material::default()
            })
            .to_vec();
        let mut second = scene.instances[0];
        second.material = Some(1);
        scene.instances.push(second);
        let g = bake_scene(&scene);
        (g.cut_outs().unwrap().rows().len(), g.fingerprint())
    };
    // One row, two for each of four triangles, and 200 bits in two rows of 128.
    assert_eq!(rows([0.5, 0.5]).0, 1 + 8 + 2);
    assert_eq!(rows([0.5, 0.25]).0, 1 + 8 + 4);
    assert_ne!(rows([0.5, 0.5]).1, rows([0.5, 0.25]).1);
}

#[test]
fn tables_are_read_back_and_spoilt_ones_refused() {
    let g = bake_scene(&card(Some(texture(UVec2::splat(12), |x, y| x > y)), 1.0));
    let rows = g.cut_outs().unwrap().rows().to_vec();
    let read = CutOuts::from_rows(&rows, &[], 2).unwrap();
    assert_eq!(read.as_deref(), g.cut_outs().map(|c| &**c));
    assert_eq!(CutOuts::from_rows(&[], &[], 2), Ok(None));
    let spoilt = |row: usize, word: usize, value: u32| {
        let mut rows = rows.clone();
        rows[row][word] = value;
        CutOuts::from_rows(&rows, &[], 2).is_err()
    };
    assert!(spoilt(0, 1, 9), "triangles that don't exist");
    assert!(spoilt(0, 2, 1), "runs that do not rise");
    assert!(spoilt(2, 2, 0), "a texture without texels");
    assert!(spoilt(2, 2, 200 | 200 << 16), "a texture beyond the table");
    assert!(spoilt(4, 3, u32::MAX), "bits beyond the table");
    assert!(
        CutOuts::from_rows(&rows[..4], &[], 2).is_err(),
        "a truncated table"
    );
}

#[test]
fn textures_that_are_too_large_are_refused() {
    let long = |is_there| texture(UVec2::new(MAX_ALPHA_SIDE + 1, 1), |_, _| is_there);
    let error = Geometry::bake(&card(Some(long(false)), 1.0)).unwrap_err();
    let expected = "texture `holes`: is 65536 x 1 texels; use at most 65535 on each side where it is an alpha texture";
    assert_eq!(error.to_string(), expected);
    // A texture without holes may have any size.
    assert!(Geometry::bake(&card(Some(long(true)), 1.0)).is_ok());
}

#[test]
fn runs_are_split_where_holes_begin_and_end() {
    let cut_outs = CutOuts {
        runs: [5..8, 10..12],
        rows: Arc::new([]),
        coverage: None,
    };
    let split = |runs: &[Range<u32>]| cut_outs.split(runs);
    assert_eq!(
        split(&[0..15, 15..20]),
        [vec![0..5, 8..10, 12..15, 15..20], vec![5..8, 10..12]]
    );
    assert_eq!(
        split(&[0..3, 6..11]),
        [vec![0..3, 8..10], vec![6..8, 10..11]]
    );
    assert_eq!(
        split(&[6..7, 10..11, 13..14, 16..17]),
        [vec![13..14, 16..17], vec![6..7, 10..11]]
    );
}
