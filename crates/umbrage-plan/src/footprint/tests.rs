//! Tests on a level plane below a camera and a sun that both point straight down, so that every
//! figure is known.

use super::*;
use umbrage_core::footprint::texels_per_pixel;
use umbrage_core::{
    Camera, Extents, Fit, Geometry, Instance, Light, Mesh, Scene, ShadowTechnique,
    footprint::side_for,
    glam::{Affine3A, Vec3},
};
use umbrage_cpu::Cpu;
use umbrage_techniques::{Hard, MapFilter as _, Pcf, ShadowMap};

const SUN: Light = Light::Directional {
    direction: Vec3::NEG_Y,
    angular_diameter: 0.0,
};
/// Side of the map, texels.
const SIDE: u32 = 64;

/// Returns a camera 10 m above the plane, `half` metres to each side, 32 x 32 pixels.
fn camera(half: f32) -> Camera {
    let extents = Extents {
        left: -half,
        right: half,
        bottom: -half,
        top: half,
        near: 1.0,
        far: 20.0,
    };
    Camera::orthographic(
        Vec3::Y * 10.0,
        Vec3::ZERO,
        Vec3::Z,
        extents,
        UVec2::splat(32),
    )
    .unwrap()
}

/// Returns a plane of 8 x 8 m.
fn plane() -> Geometry {
    let corner = |x, z| Vec3::new(x, 0.0, z);
    let corners = vec![
        corner(-1.0, -1.0),
        corner(-1.0, 1.0),
        corner(1.0, 1.0),
        corner(1.0, -1.0),
    ];
    let quad = Mesh::new("quad", corners, vec![[0, 1, 2], [0, 2, 3]]).unwrap();
    let instances = vec![Instance::new(0, Affine3A::from_scale(Vec3::splat(4.0)))];
    Geometry::bake(&Scene {
        name: "plane".into(),
        meshes: vec![quad],
        instances,
        ..Scene::default()
    })
    .unwrap()
}

/// Returns a map of 4 m to each side.
fn map() -> ShadowMap {
    let extents = Extents {
        left: -4.0,
        right: 4.0,
        bottom: -4.0,
        top: 4.0,
        near: 0.0,
        far: 9.0,
    };
    ShadowMap {
        size: SIDE,
        fit: Fit::Manual {
            eye: Vec3::Y * 5.0,
            extents,
        },
        ..ShadowMap::default()
    }
}

fn measure_footprint(half: f32, technique: &dyn ShadowTechnique, reach: f32) -> RecipeFootprint {
    let (camera, geometry) = (camera(half), plane());
    let receivers = Cpu::new().receivers(&camera, &geometry).unwrap();
    let view = View::new(&camera, &SUN, &geometry).with_receivers(&receivers);
    let recipe = technique.recipe(&view).unwrap();
    let catalogue = Catalogue::built_in();
    measure(&view, &recipe, &receivers, reach, catalogue.kernel(&recipe))
}

/// Pixels of 1/8 m on texels of 1/8 m, over a quarter of the map.
#[test]
fn a_quarter_of_the_map_is_looked_up_once() {
    let f = measure_footprint(2.0, &Hard {}.on(map()), 0.0);
    assert_eq!(f.casts.len(), 1);
    assert_eq!((f.total.unused, f.casts[0].unused), (0.75, 0.75));
    assert_eq!(
        f.casts[0].lookups.iter().filter(|&&n| n == 1).count(),
        32 * 32
    );
    let row = |y: usize| f.casts[0].lookups[y * 64..][..64].iter().sum::<u32>();
    assert_eq!([row(15), row(16), row(47), row(48)], [0, 32, 32, 0]);
    let [least, median, most] = f.total.texels_per_pixel.unwrap();
    assert!(
        (least - 1.0).abs() < 1e-4 && (median - 1.0).abs() < 1e-4 && (most - 1.0).abs() < 1e-4,
        "{f:?}"
    );
}

/// The kernel adds three texels around the quarter, and 49 lookups within it.
#[test]
fn kernels_touch_what_they_reach() {
    let f = measure_footprint(2.0, &Pcf::new(3).on(map()), 3.0);
    let touched = 38 * 38;
    assert_eq!(
        f.total.unused,
        1.0 - f64::from(touched) / f64::from(SIDE * SIDE)
    );
    assert_eq!(f.casts[0].lookups[32 * 64 + 32], 49);
}

/// With pixels of 1/4 m, every second texel is skipped, and half the side is enough.
#[test]
fn a_map_too_fine_is_reported() {
    let f = measure_footprint(4.0, &Hard {}.on(map()), 0.0);
    assert_eq!(f.total.unused, 0.75);
    assert!(
        (f.total.texels_per_pixel.unwrap()[1] - 2.0).abs() < 1e-4,
        "{:?}",
        f.total.texels_per_pixel
    );
}

#[test]
fn nothing_seen_is_no_use() {
    let (camera, geometry) = (camera(2.0), plane());
    let view = View::new(&camera, &SUN, &geometry);
    let nothing = Receivers::empty(camera.size);
    let recipe = Hard {}.on(map()).recipe(&view).unwrap();
    let catalogue = Catalogue::built_in();
    let f = measure(&view, &recipe, &nothing, 0.0, catalogue.kernel(&recipe));
    assert_eq!((f.total.unused, f.total.texels_per_pixel), (1.0, None));
}

/// A texel of the map is as large as a pixel at the side N with 8 m / N = 2 half / 32. With light
/// at an angle, the map is equally long along the slope, but the plane is foreshortened.
#[test]
fn the_side_that_pixels_need() {
    let geometry = plane();
    for (half, side) in [(2.0, 64), (4.0, 32), (1.0, 128)] {
        let camera = camera(half);
        let receivers = Cpu::new().receivers(&camera, &geometry).unwrap();
        let view = View::new(&camera, &SUN, &geometry).with_receivers(&receivers);
        let spaces = map().spaces(&view, 0.0).unwrap();
        for quantile in [0.0, 0.5, 1.0] {
            // One more if rounding puts the quotient above the whole number.
            let found = side_for(&view, &receivers, &spaces, quantile).unwrap();
            assert!(found == side || found == side + 1, "{found} for {side}");
        }
    }
    let camera = camera(2.0);
    let nothing = Receivers::empty(camera.size);
    let view = View::new(&camera, &SUN, &geometry);
    assert_eq!(
        side_for(&view, &nothing, &map().spaces(&view, 0.0).unwrap(), 0.5),
        None
    );
}

/// Under light at 60 degrees from the vertical, a pixel's step along the slope spans half as much
/// of the map, so the side doubles.
#[test]
fn slanting_light_needs_more() {
    let (camera, geometry) = (camera(2.0), plane());
    let direction = Vec3::new(3.0_f32.sqrt(), -1.0, 0.0);
    let sun = Light::Directional {
        direction,
        angular_diameter: 0.0,
    };
    let receivers = Cpu::new().receivers(&camera, &geometry).unwrap();
    let view = View::new(&camera, &sun, &geometry).with_receivers(&receivers);
    let found = side_for(&view, &receivers, &map().spaces(&view, 0.0).unwrap(), 0.9).unwrap();
    assert!(found == 128 || found == 129, "{found}");
}

/// The map side for a view is enough for the requested share, and a slightly smaller one is not.
#[test]
fn maps_take_the_size_that_a_view_needs() {
    for name in ["cubes", "teapot-lamp", "lamp-in-room"] {
        let scene = umbrage_scenes::by_argument(name).unwrap();
        let camera = scene.cameras[0].with_size(UVec2::new(320, 240));
        let geometry = Geometry::bake(&scene).unwrap();
        let receivers = Cpu::new().receivers(&camera, &geometry).unwrap();
        let view = View::new(&camera, &scene.lights[0], &geometry).with_receivers(&receivers);
        for (quantile, start) in [(0.9, 1024), (0.9, 64), (0.5, 1024)] {
            let map = ShadowMap {
                size: start,
                ..ShadowMap::default()
            };
            let map = map.sized_for(&view, &receivers, quantile).unwrap();
            assert_eq!(map.size % 16, 0);
            let enough = |size| {
                let mut texels =
                    texels_per_pixel(&view, &receivers, &map.spaces(&view, 0.0).unwrap(), size);
                texels.sort_unstable_by(f32::total_cmp);
                at_least(&texels, quantile).unwrap() >= 1.0
            };
            assert!(
                enough(map.size) && !enough(map.size * 9 / 10),
                "{name}: {}",
                map.size
            );
        }
        let nothing = Receivers::empty(camera.size);
        assert_eq!(
            ShadowMap::default()
                .sized_for(&view, &nothing, 0.9)
                .unwrap(),
            ShadowMap::default()
        );
    }
}

/// Five maps are shown, three in a row, downscaled. The sums of lookups are kept.
#[test]
fn small_pictures_show_all_maps() {
    let lookups = |n: u32| (0..100).map(|i| if i == 57 { n } else { 0 }).collect();
    let cast = |n| CastFootprint {
        size: [10, 10],
        lookups: lookups(n),
        ..CastFootprint::default()
    };
    let heat = RecipeFootprint {
        casts: (1..=5).map(cast).collect(),
        ..RecipeFootprint::default()
    }
    .heat(4)
    .unwrap();
    // Ten texels in blocks of three by three are four pixels, with four pixels between maps.
    assert_eq!(heat.size, [3 * 4 + 2 * 4, 2 * 4 + 4]);
    let at = |x: usize, y: usize| heat.lookups[y * 20 + x];
    // Texel (7, 5) is in pixel (2, 1).
    assert_eq!(
        [at(2, 1), at(10, 1), at(18, 1), at(2, 9), at(10, 9)],
        [1, 2, 3, 4, 5]
    );
    assert_eq!([at(18, 9), at(5, 5), at(0, 0)], [Heat::GAP, Heat::GAP, 0]);
    assert_eq!(
        heat.lookups.iter().filter(|&&n| n == Heat::GAP).count(),
        20 * 12 - 5 * 16
    );
    assert_eq!(RecipeFootprint::default().heat(4), None);
}

/// One map is described by its figures, several maps by ranges. Equal figures appear once.
#[test]
fn several_maps_are_found_by_their_ranges() {
    let map = |unused, texels, side| MapUse {
        unused,
        texels,
        side,
        ..MapUse::default()
    };
    let (coarse, fine) = (
        map(0.2, Some(0.5), Some(512)),
        map(0.4, Some(2.0), Some(512)),
    );
    let one = "20 % of the map's texels never looked up; 9 in 10 pixels facing the light span at least 0.50 texels (1 with a side of \
               512)";
    assert_eq!(coarse.words(), one);
    assert_eq!(words(&[coarse]).as_deref(), Some(one));
    let both = words(&[fine, coarse, map(0.3, None, None)]).expect("some maps");
    assert!(
        both.starts_with("20 to 40 % of")
            && both.contains("0.50 to 2.00 texels (1 with a side of 512)"),
        "{both}"
    );
    assert_eq!(words(&[]), None);
    // No map is fine enough: the line reports the side and an alternative.
    let giant = map(1.0, Some(0.000_744), Some(1_376_345)).words();
    let end = "at least 0.00074 texels (1 with a side of 1376345; use cascades, or a technique \
               without a map)";
    assert!(giant.ends_with(end), "{giant}");
}
