use super::*;
use crate::{
    geometry::{Geometry, cut_out::CutOuts},
    light_space::Extents,
    scene::{
        Instance, Mesh, Scene,
        camera::Camera,
        light_sample::hash,
        material::{AlphaCutout, AlphaFilter, Material},
    },
};
use glam::{Affine3A, Vec3};

/// Sides of the texture, texels. They are odd at some levels, which then leave a remainder.
const SIZE: UVec2 = UVec2::new(104, 77);

/// Repeats of the texture along each side of the card, which is 4 x 4 units large.
const REPEATS: f32 = 3.0;

/// Returns a texture of random texels, of which `there` in 256 are opaque.
fn speckled_texture(there: u32) -> Texture {
    let texel = |i: u32| {
        let alpha = if hash(i) % 256 < there { 0.8 } else { 0.3 };
        [1.0, 1.0, 1.0, alpha]
    };
    Texture {
        name: "speckles".into(),
        size: SIZE,
        texels: (0..SIZE.element_product()).map(texel).collect(),
    }
}

/// Returns a card in the plane z = 0, from -2 to 2 both ways.
fn card(there: u32, filter: AlphaFilter) -> Geometry {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let place = |(x, y): (f32, f32)| Vec3::new(2.0 * x, 2.0 * y, 0.0);
    let uv = |(x, y): (f32, f32)| Vec2::new(0.5 * x + 0.5, 0.5 - 0.5 * y) * REPEATS;
    let mut instance = Instance::new(0, Affine3A::IDENTITY);
    instance.material = Some(0);
    let scene = Scene {
        meshes: vec![Mesh {
            name: "card".into(),
            positions: corners.map(place).to_vec(),
            uvs: corners.map(uv).to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        }],
        instances: vec![instance],
        materials: vec![Material {
            alpha: Some(AlphaCutout {
                texture: 0,
                cutoff: 0.5,
                filter,
            }),
            ..Material::default()
        }],
        textures: vec![speckled_texture(there)],
        ..Scene::default()
    };
    Geometry::bake(&scene).unwrap()
}

/// Returns a camera facing the card whose image is `pixels` wide and shows the middle half of it,
/// shifted by `moved` pixels.
fn camera(pixels: u32, moved: f32) -> Camera {
    let eye = Vec3::new(moved * 2.0 / pixels as f32, 0.0, 5.0);
    let extents = Extents {
        left: -1.0,
        right: 1.0,
        bottom: -1.0,
        top: 1.0,
        near: 1.0,
        far: 9.0,
    };
    let target = eye - Vec3::Z;
    Camera::orthographic(eye, target, Vec3::Y, extents, UVec2::splat(pixels)).unwrap()
}

/// Returns whether the card is opaque at each pixel of a camera that shows only the card.
fn shown_pixels(geometry: &Geometry, camera: &Camera) -> Vec<bool> {
    let cut_outs: &CutOuts = geometry.cut_outs().unwrap();
    let rays = camera.rays();
    let mut out = Vec::new();
    for y in 0..camera.size.y {
        for x in 0..camera.size.x {
            // The diagonal from the lower left to the upper right separates the triangles.
            let triangle = u32::from(x + y < camera.size.x);
            let corners = geometry.corners(triangle);
            out.push(!cut_outs.is_hole_at_pixel(triangle, corners, &rays, x, y));
        }
    }
    out
}

fn share(shown: &[bool]) -> f64 {
    shown.iter().filter(|&&is_there| is_there).count() as f64 / shown.len() as f64
}

/// The share of opaque pixels equals the texture's coverage, at any distance.
#[test]
fn coverage_is_kept_from_any_distance() {
    for there in [20, 100, 230] {
        let geometry = card(there, AlphaFilter::Hashed);
        let texels = speckled_texture(there).texels;
        let count = texels.iter().filter(|texel| texel[3] > 0.5).count();
        let expected = count as f64 / texels.len() as f64;
        for pixels in [200, 90, 61, 40] {
            // Shift the image to collect more samples.
            let moves = (0..8).map(|i| 0.37 * i as f32);
            let all: Vec<bool> = moves
                .flat_map(|moved| shown_pixels(&geometry, &camera(pixels, moved)))
                .collect();
            let found = share(&all);
            // Five standard deviations of one image, as the pixels of shifted images are not
            // independent.
            let deviation = (expected * (1.0 - expected)).sqrt() / f64::from(pixels);
            assert!(
                (found - expected).abs() < 5.0 * deviation,
                "{there}, {pixels} pixels: {found} of {expected}"
            );
        }
    }
}

/// Mipmap levels of a texture without holes have none, which is why [`Geometry::bake`] ignores such
/// textures. With one hole they do.
#[test]
fn levels_of_whole_textures_have_no_holes() {
    let holes = |texture: &Texture| {
        let mut builder = CoverageBuilder::new(1);
        builder.add(0, (0, 0.5_f32.to_bits()), texture);
        let coverage = builder.finish().unwrap().unwrap();
        let levels = coverage.levels_of(0).unwrap();
        let is_clear = |texel: u32| texture.texels.get(texel as usize)[3] < 0.5;
        let is_hole = |i: u32| {
            let unit = |k| hash(3 * i + k) as f32 / u32::MAX as f32;
            let uv = Vec2::new(4.0 * unit(0) - 2.0, 4.0 * unit(1) - 2.0);
            // Test footprints from one texel to far more than the texture.
            let squared = 4.0_f32.powf(9.0 * unit(2)).next_up();
            levels.is_hole(uv, squared, i % 7, is_clear)
        };
        (0..200_000).filter(|&i| is_hole(i)).count()
    };
    let mut texture = speckled_texture(256);
    assert_eq!(holes(&texture), 0);
    let mut texels: Vec<[f32; 4]> = texture.texels.iter().collect();
    texels[5][3] = 0.0;
    texture.texels = texels.into();
    assert!(holes(&texture) > 0);
}

/// Pixels no larger than a texel use the nearest texel, and a clear texture leaves no pixel opaque.
#[test]
fn near_pixels_and_clear_textures_are_as_without_hashes() {
    let hashed = card(120, AlphaFilter::Hashed);
    let nearest = card(120, AlphaFilter::Nearest);
    // Half of the card shows 1.5 repeats of the texture.
    let near = camera(SIZE.x * 3 / 2 + 1, 0.2);
    assert_eq!(shown_pixels(&hashed, &near), shown_pixels(&nearest, &near));
    let far = camera(40, 0.2);
    assert_ne!(shown_pixels(&hashed, &far), shown_pixels(&nearest, &far));
    let clear = card(0, AlphaFilter::Hashed);
    for pixels in [150, 70, 20, 2, 1] {
        let camera = camera(pixels, 0.2);
        assert!(
            shown_pixels(&clear, &camera)
                .iter()
                .all(|&is_there| !is_there)
        );
    }
}

/// The image moves with the camera: fewer pixels change than with the nearest texel.
#[test]
fn moved_cameras_see_the_same() {
    let changes = |filter| {
        let geometry = card(120, filter);
        let mut changed = 0;
        for pixels in [60, 45, 33] {
            for step in 0..8 {
                let moved = 0.1 * step as f32;
                let before = shown_pixels(&geometry, &camera(pixels, moved));
                let after = shown_pixels(&geometry, &camera(pixels, moved + 0.1));
                changed += before.iter().zip(&after).filter(|(a, b)| a != b).count();
            }
        }
        changed
    };
    let hashed = changes(AlphaFilter::Hashed);
    let nearest = changes(AlphaFilter::Nearest);
    assert!(2 * hashed < nearest, "{hashed} and {nearest}");
}

/// Each level has the mean of the texture, and each texel the coverage of its area.
#[test]
fn levels_keep_the_mean() {
    let texture = speckled_texture(77);
    let there: Vec<f32> = texture
        .texels
        .iter()
        .map(|texel| f32::from(u8::from(texel[3] > 0.5)))
        .collect();
    let mean = |values: &[f32]| values.iter().sum::<f32>() / values.len() as f32;
    let mut level = there.clone();
    let mut size = SIZE;
    while size != UVec2::ONE {
        let next = half_size(size);
        level = shrink_coverages(&level, size, next);
        size = next;
        assert_eq!(level.len() as u32, size.element_product());
        assert!((mean(&level) - mean(&there)).abs() < 1e-4, "{size}");
    }
    let line = [0.0, 0.0, 1.0, 1.0, 1.0];
    let halves = shrink_coverages(&line, UVec2::new(5, 1), UVec2::new(2, 1));
    assert!((halves[0] - 0.2).abs() < 1e-6 && (halves[1] - 1.0).abs() < 1e-6);
}

/// Thresholds are uniform from 0 to 1, also between two levels.
#[test]
fn thresholds_are_even() {
    const BINS: usize = 16;
    for part in [0.0, 0.1, 0.5, 0.8] {
        let mut counts = [0_u32; BINS];
        let mut total = 0;
        for row in 0..64 {
            for column in 0..256 {
                let uv = Vec2::new(column as f32 + 0.5, row as f32 - 31.5) / 32.0;
                let fine = cell_threshold(uv, UVec2::splat(32), 3, 5);
                let coarse = cell_threshold(uv + 40.0, UVec2::splat(32), 4, 5);
                let threshold = threshold_between(fine, coarse, part);
                assert!(threshold > 0.0 && threshold <= 1.0, "{threshold}");
                counts[((threshold * BINS as f32) as usize).min(BINS - 1)] += 1;
                total += 1;
            }
        }
        // Six standard deviations.
        let expected = f64::from(total) / BINS as f64;
        for count in counts {
            let off = (f64::from(count) - expected).abs();
            assert!(off < 6.0 * expected.sqrt(), "{part}: {counts:?}");
        }
    }
}

#[test]
fn footprints_have_levels() {
    for (footprint, level, part) in [
        (1.0_f32, 0, 0.0),
        (1.5, 0, (2.25 - 1.0) / 3.0),
        (2.0, 1, 0.0),
        (3.9, 1, (3.9 * 3.9 / 4.0 - 1.0) / 3.0),
        (8.0, 3, 0.0),
    ] {
        let squared = footprint * footprint;
        assert_eq!(finer_level(squared, 9), level, "{footprint}");
        let found = part_to_next_level(squared, level);
        assert!((found - part).abs() < 1e-6, "{footprint}: {found}");
    }
    assert_eq!(finer_level(1e30, 6), 6);
    assert_eq!(finer_level(f32::INFINITY, 6), 6);
}

#[test]
fn tables_are_read_back_and_spoilt_ones_refused() {
    let geometry = card(90, AlphaFilter::Hashed);
    let json = serde_json::to_value(&geometry).unwrap();
    let read: Geometry = serde_json::from_value(json).unwrap();
    assert_eq!(read.cut_outs(), geometry.cut_outs());
    assert_eq!(read.fingerprint(), geometry.fingerprint());
    let nearest = card(90, AlphaFilter::Nearest);
    assert_ne!(nearest.fingerprint(), geometry.fingerprint());
    assert!(nearest.cut_outs().unwrap().coverage_rows().is_none());
    let cut_outs = geometry.cut_outs().unwrap();
    let rows = cut_outs.coverage_rows().unwrap().to_vec();
    let sizes = [SIZE; 2];
    assert!(Coverage::from_rows(&rows, &sizes).unwrap().is_some());
    assert_eq!(Coverage::from_rows(&[], &sizes), Ok(None));
    let spoilt = |row: usize, word: usize, value: u32| {
        let mut rows = rows.clone();
        rows[row][word] = value;
        Coverage::from_rows(&rows, &sizes).is_err()
    };
    assert!(spoilt(0, 1, u32::MAX), "levels beyond the table");
    assert!(spoilt(1, 0, 5), "a size that is not the texture's");
    assert!(spoilt(2, 1, u32::MAX), "texels beyond the table");
    assert!(spoilt(3, 2, 40), "another last level");
    assert!(Coverage::from_rows(&rows[..4], &sizes).is_err());
    assert!(Coverage::from_rows(&rows, &vec![SIZE; 900_000]).is_err());
}
