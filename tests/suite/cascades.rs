//! Tests of cascades: both halves choose the same layers, one of them contains every visible
//! receiver, and maps that follow the camera move in whole texels.

use glam::{UVec2, Vec2, Vec3};
use proptest::prelude::*;
use std::collections::HashSet;
use umbrage_core::{
    Arrangement, Backend, Bvh, Camera, CascadePick, Cascades, Fit, Geometry, LayerPicker, Layout,
    Light, LightSpaces, Receivers, Recipe, RecipeError, ShadowTechnique, SliceEnds, Split, View,
    math::transform,
};
use umbrage_cpu::Cpu;
use umbrage_plan::catalogue::Catalogue;
use umbrage_scenes::find;
use umbrage_techniques::{
    Bias, Border, Evsm, EvsmMoments, Hard, MapFilter as _, MapFormat, MomentPrecision, Msm, Pcf,
    PcfDisc, PcfDithered, PcfHardware, PcfMerged, Pcss, ShadowMap, Surface, TechniquePreset, Vsm,
};
use umbrage_tests::{
    agreed::check_agreement,
    driver_model::{is_chosen, runs_all_cases},
    gpu::gpu,
};

/// A built-in scene with a sun in this direction.
struct CascadePlace {
    geometry: Geometry,
    camera: Camera,
    light: Light,
}

fn place(name: &str, size: UVec2) -> CascadePlace {
    let mut scene = (find(name).expect("a built-in scene").build)();
    CascadePlace {
        geometry: Geometry::bake(&scene).expect("built-in scenes are valid"),
        camera: scene.cameras.remove(0).with_size(size),
        light: scene.lights.remove(0),
    }
}

fn cascade_map(fit: Fit, cascades: Cascades) -> ShadowMap {
    ShadowMap {
        size: 256,
        fit,
        layout: Layout::Cascades(cascades),
        ..ShadowMap::default()
    }
}

fn splits() -> Vec<Split> {
    let ends = SliceEnds::new(&[6.0, 20.0, 20.0, 90.0]).expect("rising");
    vec![
        Split::Log,
        Split::Practical { lambda: 0.5 },
        Split::Receivers,
        Split::Given(ends),
    ]
}

/// Returns the CPU's mask.
///
/// # Errors
/// Returns an error that names the recipe as `label` if the device's mask differs.
fn agreed_mask(view: &View<'_>, recipe: &Recipe, label: &str) -> Result<Vec<f32>, String> {
    let of_cpu = Cpu::new().render(view, recipe).expect("valid");
    let mut gpu = gpu();
    let of_gpu = gpu.render(view, recipe).expect("valid");
    check_agreement(&gpu, label, view, recipe, &of_cpu, &of_gpu)?;
    Ok(of_cpu.mask)
}

/// The two halves agree for every technique with a map, every split, and both fits, with and
/// without blending.
#[test]
fn both_halves_agree() {
    let place = place("far-range", UVec2::new(96, 60));
    let mut cpu = Cpu::new();
    let seen = cpu.receivers(&place.camera, &place.geometry).expect("seen");
    let view = View::new(&place.camera, &place.light, &place.geometry).with_receivers(&seen);
    let soft_light = Light::Directional {
        direction: Vec3::new(0.6, -0.5, 0.3),
        angular_diameter: 0.02,
    };
    let soft = View {
        light: &soft_light,
        ..view
    };
    let mut compared = 0;
    let mut blended = 0;
    let mut dark = 0;
    let mut picked = HashSet::new();
    let mut turn = 0;
    let mut number = 0;
    for (i, split) in splits().into_iter().enumerate() {
        for fit in [Fit::Tight, Fit::Stable { range: 150.0 }] {
            for blend in [0.0, 12.0] {
                let cascades = Cascades {
                    count: 4,
                    split,
                    blend,
                    ..Cascades::default()
                };
                let map = cascade_map(fit, cascades);
                let wide = Pcss::default().on(map);
                let catalogue = Catalogue::built_in();
                let mut cases: Vec<(TechniquePreset, &View<'_>)> = Vec::new();
                for technique in techniques(map, i) {
                    cases.push((technique, &view));
                }
                cases.push((of_moments(map, turn), &view));
                turn += 1;
                cases.push((TechniquePreset::from(wide), &soft));
                for (technique, view) in &cases {
                    number += 1;
                    if !is_chosen(number) {
                        continue;
                    }
                    let recipe = technique.recipe(view).expect("plans");
                    let label = format!("{}, {}", technique.name(), technique.settings());
                    let mask = agreed_mask(view, &recipe, &label).expect("both agree");
                    dark += mask.iter().filter(|&&v| v == 0.0).count();
                    let kernel = catalogue.kernel(&recipe);
                    picked.extend((0..seen.len()).map(|i| kernel.layer(seen.position(i))));
                    compared += 1;
                    blended += usize::from(blend > 0.0);
                }
            }
        }
    }
    assert!(compared >= 4, "{compared} compared");
    if !runs_all_cases() {
        return;
    }
    assert!(compared >= 40 && blended >= 20, "{compared} compared");
    assert!(turn >= MOMENT_MAPS, "{turn} maps of moments were tested");
    assert!(dark > 1000, "{dark} pixels are dark");
    let all_layers = (0..4).all(|layer| picked.contains(&Some(layer)));
    assert!(all_layers, "{picked:?} are looked up");
}

/// Number of techniques of [`of_moments`].
const MOMENT_MAPS: usize = 9;

/// Returns the techniques with maps of moments, in turn.
fn of_moments(map: ShadowMap, turn: usize) -> TechniquePreset {
    match turn % MOMENT_MAPS {
        0 => TechniquePreset::from(Vsm::default().on(map)),
        1 => TechniquePreset::from(Evsm::default().on(map)),
        2 => TechniquePreset::from(Msm::default().on(map)),
        6 => TechniquePreset::from(
            Vsm {
                mipmaps: 3,
                ..Vsm::default()
            }
            .on(map),
        ),
        7 => TechniquePreset::from(
            Evsm {
                mipmaps: 2,
                precision: MomentPrecision::Bits16,
                ..Evsm::default()
            }
            .on(map),
        ),
        8 => TechniquePreset::from(
            Msm {
                mipmaps: 4,
                ..Msm::default()
            }
            .on(map),
        ),
        3 => TechniquePreset::from(
            Evsm {
                moments: EvsmMoments::Two,
                ..Evsm::default()
            }
            .on(map),
        ),
        4 => TechniquePreset::from(
            Msm {
                precision: MomentPrecision::Bits16,
                ..Msm::default()
            }
            .on(map),
        ),
        _ => TechniquePreset::from(
            Vsm {
                precision: MomentPrecision::Bits16,
                ..Vsm::default()
            }
            .on(map),
        ),
    }
}

/// Returns all techniques, with each bias in turn.
fn techniques(map: ShadowMap, turn: usize) -> Vec<TechniquePreset> {
    let biases = [
        Bias::ADAPTIVE,
        Bias::NORMAL_OFFSET,
        Bias::SLOPE,
        Bias::RECEIVER_PLANE,
    ];
    let map = ShadowMap {
        bias: biases[turn % 4],
        ..map
    };
    vec![
        TechniquePreset::from(Hard {}.on(ShadowMap {
            border: Border::Clamp,
            format: MapFormat::Rgba8,
            ..map
        })),
        TechniquePreset::from(Pcf::new(2).on(map)),
        TechniquePreset::from(PcfDisc::default().on(map)),
        TechniquePreset::from(PcfDithered {}.on(map)),
        TechniquePreset::from(PcfHardware::default().on(map)),
        TechniquePreset::from(PcfMerged::default().on(map)),
        TechniquePreset::from(Hard {}.on(ShadowMap {
            surface: Surface::Midpoint,
            ..map
        })),
    ]
}

/// Returns the mask of each backend.
fn masks(view: &View<'_>, recipe: &Recipe) -> [Vec<f32>; 2] {
    let of_cpu = Cpu::new().render(view, recipe).expect("valid");
    let of_gpu = gpu().render(view, recipe).expect("valid");
    [of_cpu.mask, of_gpu.mask]
}

/// Several equal cascades result in the bits of a single map, regardless of the choice. A cascade
/// at another position is detected.
#[test]
fn equal_cascades_give_the_bits_of_a_single_map() {
    let place = place("far-range", UVec2::new(96, 60));
    let view = View::new(&place.camera, &place.light, &place.geometry);
    let map = ShadowMap {
        size: 512,
        ..ShadowMap::default()
    };
    let technique = Hard {}.on(map);
    let single = map.spaces(&view, 0.0).expect("one map");
    for blend in [0.0, 40.0] {
        let pick = CascadePick { reach: 0.0, blend };
        let several = LightSpaces::cascades(vec![single.spaces[0]; 8], pick);
        let mut spoilt = several.clone();
        spoilt.spaces[0] = spoilt.spaces[0].nudge_by(Vec2::splat(0.4), 0.0, UVec2::splat(map.size));
        let of = |spaces: &LightSpaces| {
            let recipe = map.recipe_in(spaces, &view, 0.0, |lookup| {
                umbrage_techniques::HardKernel(
                    umbrage_techniques::shadow_map::layers::MapOnlyUniforms { lookup },
                )
            });
            masks(&view, &recipe)
        };
        let of_single = masks(&view, &technique.recipe(&view).expect("plans"));
        assert!(of(&several) == of_single);
        let spoilt = of(&spoilt);
        assert!(spoilt[0] != of_single[0], "a displaced cascade on the CPU");
        assert!(spoilt[1] != of_single[1], "a displaced cascade on wgpu");
    }
}

/// One slice equals the single map of the fit.
#[test]
fn one_cascade_is_the_single_map() {
    let place = place("far-range", UVec2::new(64, 40));
    let view = View::new(&place.camera, &place.light, &place.geometry);
    for fit in [Fit::Tight, Fit::Stable { range: 80.0 }] {
        let one = Cascades {
            count: 1,
            ..Cascades::default()
        };
        let cascades = fit
            .light_spaces(Layout::Cascades(one), &view, 512, 2.0)
            .expect("fits");
        let single = fit
            .light_spaces(Layout::Single, &view, 512, 2.0)
            .expect("fits");
        assert_eq!(cascades, single);
    }
}

/// Ends that are computed and then given result in the same spaces, so that a program may keep
/// them.
#[test]
fn given_ends_cut_like_found_ones() {
    let place = place("far-range", UVec2::new(64, 40));
    let seen = Cpu::new()
        .receivers(&place.camera, &place.geometry)
        .expect("a good camera");
    let view = View::new(&place.camera, &place.light, &place.geometry).with_receivers(&seen);
    for fit in [Fit::Tight, Fit::Stable { range: 150.0 }] {
        let found = Cascades {
            split: Split::Receivers,
            ..Cascades::default()
        };
        let ends = fit.slice_ends(&found, &view).expect("slices");
        assert_eq!(ends.as_slice().len(), 4);
        assert_eq!(ends.stabilized(&ends), ends);
        let given = Cascades {
            split: Split::Given(ends),
            ..found
        };
        let of = |cascades: Cascades| {
            fit.light_spaces(Layout::Cascades(cascades), &view, 256, 1.0)
                .expect("fits")
        };
        assert_eq!(of(given), of(found));
    }
}

#[test]
fn what_cannot_be_cut_is_refused() {
    let place = place("far-range", UVec2::new(32, 20));
    let view = View::new(&place.camera, &place.light, &place.geometry);
    let layout = Layout::Cascades(Cascades::default());
    let error = Fit::Whole
        .light_spaces(layout, &view, 256, 0.0)
        .expect_err("it doesn't follow the camera");
    assert!(matches!(error, RecipeError::Invalid(_)), "{error}");
    assert!(error.to_string().contains("use the fit `tight`"), "{error}");
    let lamp = Light::Point {
        position: Vec3::Y,
        radius: 0.0,
    };
    let view = View::new(&place.camera, &lamp, &place.geometry);
    let error = Fit::Tight
        .light_spaces(layout, &view, 256, 0.0)
        .expect_err("a lamp");
    assert!(matches!(error, RecipeError::Unsupported(_)), "{error}");
}

fn suns() -> impl Strategy<Value = Light> {
    (-1.0..1.0_f32, -1.0..-0.05_f32, -1.0..1.0_f32).prop_map(|(x, y, z)| Light::Directional {
        direction: Vec3::new(x, y, z),
        angular_diameter: 0.0,
    })
}

/// Position and direction of a camera.
#[derive(Clone, Copy, Debug)]
struct CameraWalk {
    eye: Vec3,
    /// Turn about the vertical, radians.
    turn: f32,
    /// Angle above the horizon, radians.
    tilt: f32,
    /// Vertical field of view, degrees.
    fov: f32,
}

fn walks() -> impl Strategy<Value = CameraWalk> {
    let eyes = (-30.0..30.0_f32, 0.3..25.0_f32, -90.0..20.0_f32);
    (eyes, -3.2..3.2_f32, -0.8..0.4_f32, 20.0..100.0_f32).prop_map(
        |((x, y, z), turn, tilt, fov)| CameraWalk {
            eye: Vec3::new(x, y, z),
            turn,
            tilt,
            fov,
        },
    )
}

impl CameraWalk {
    fn camera(&self) -> Camera {
        let along = Vec3::new(self.turn.cos(), 0.0, self.turn.sin()) * self.tilt.cos();
        let ahead = along + Vec3::Y * self.tilt.sin();
        let size = UVec2::new(64, 40);
        let fov = self.fov.to_radians();
        let target = self.eye + ahead;
        Camera::perspective(self.eye, target, Vec3::Y, fov, [0.1, 400.0], size)
            .expect("a good camera")
    }
}

fn random_cascades() -> impl Strategy<Value = (Cascades, Fit)> {
    let splits = prop_oneof![
        Just(Split::Log),
        (0.0..1.0_f32).prop_map(|lambda| Split::Practical { lambda }),
        Just(Split::Receivers),
    ];
    let fits = prop_oneof![
        Just(Fit::Tight),
        (5.0..600.0_f32).prop_map(|range| Fit::Stable { range })
    ];
    let blends = prop_oneof![Just(0.0), 1.0..30.0_f32];
    (2..9_u32, splits, 0.0..20.0_f32, blends, fits).prop_map(
        |(count, split, nearest, blend, fit)| {
            let cascades = Cascades {
                count,
                split,
                nearest,
                blend,
            };
            (cascades, fit)
        },
    )
}

/// Far plane beyond the scene, metres.
const FAR: f32 = 1e4;

/// Returns the receivers that no cascade contains with a margin for the kernel.
fn not_held(seen: &Receivers, spaces: &LightSpaces, size: u32) -> Vec<usize> {
    let Arrangement::Cascades(pick) = spaces.arrangement else {
        return Vec::new();
    };
    let picker = LayerPicker::new(spaces, size);
    let rim = 1.0 - 2.0 * pick.reach / size as f32;
    let mut out = Vec::new();
    for i in (0..seen.len()).filter(|&i| seen.receives[i]) {
        let p = seen.position(i);
        let layer = picker.layer_at(p).expect("a layer");
        let clip = transform(picker.clip_from_world(layer), p);
        let is_held = clip.x.abs().max(clip.y.abs()) < rim && clip.z <= 1.0;
        if !is_held {
            out.push(i);
        }
    }
    out
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, ..ProptestConfig::default() })]

    /// Over random cameras, suns, splits and fits: a receiver outside all cascades is lit in the
    /// reference, or is beyond the stable fit's range. With a hard comparison, both halves agree.
    #[test]
    fn what_is_seen_is_held(walk in walks(), light in suns(), (cascades, fit) in random_cascades(), known in any::<bool>()) {
        let place = place("far-range", UVec2::new(64, 40));
        let camera = walk.camera();
        let mut cpu = Cpu::new();
        let seen = cpu.receivers(&camera, &place.geometry).expect("seen");
        let plain = View::new(&camera, &light, &place.geometry);
        let view = if known { plain.with_receivers(&seen) } else { plain };
        let map = cascade_map(fit, cascades);
        let reach = 3.0;
        let spaces = map.spaces(&view, reach).expect("fits");
        prop_assert_eq!(spaces.spaces.len(), cascades.count as usize);
        let bvh = Bvh::build(&place.geometry);
        let range = match fit {
            Fit::Stable { range } => range,
            _ => f32::INFINITY,
        };
        let view_from_world = camera.space().view_from_world;
        for i in not_held(&seen, &spaces, map.size) {
            let p = seen.position(i);
            let distance = -transform(view_from_world, p).z;
            if distance >= range * 0.999 {
                continue;
            }
            let to_light = light.direction_from(p) * FAR;
            let is_shadowed = bvh.is_occluded(p, to_light, seen.triangle[i]);
            prop_assert!(!is_shadowed, "{p} at {distance} m is shadowed, and in no cascade");
        }
        let recipe = Hard {}.on(map).recipe(&view).expect("plans");
        let agreed = agreed_mask(&view, &recipe, "hard");
        prop_assert!(agreed.is_ok(), "{}", agreed.unwrap_err());
    }
}

/// Negative control of the test above: displaced cascades leave receivers in shadow outside all
/// cascades.
#[test]
fn cascades_that_lie_elsewhere_hold_too_little() {
    let place = place("far-range", UVec2::new(64, 40));
    let mut cpu = Cpu::new();
    let seen = cpu
        .receivers(&place.camera, &place.geometry)
        .expect("a good camera");
    let view = View::new(&place.camera, &place.light, &place.geometry).with_receivers(&seen);
    let map = cascade_map(Fit::Tight, Cascades::default());
    let mut spaces = map.spaces(&view, 3.0).expect("fits");
    let bvh = Bvh::build(&place.geometry);
    let in_shadow = |i: &usize| {
        let p = seen.position(*i);
        bvh.is_occluded(p, place.light.direction_from(p) * FAR, seen.triangle[*i])
    };
    let shadowed_outside = |spaces: &LightSpaces| {
        not_held(&seen, spaces, map.size)
            .iter()
            .filter(|i| in_shadow(i))
            .count()
    };
    assert_eq!(shadowed_outside(&spaces), 0);
    for space in &mut spaces.spaces {
        *space = space.nudge_by(Vec2::new(200.0, 0.0), 0.0, UVec2::splat(map.size));
    }
    assert!(shadowed_outside(&spaces) > 0);
}

/// Points of the world keep their position within the texels of every stable cascade when the
/// camera pans and turns.
#[test]
fn stable_cascades_move_by_whole_texels() {
    let place = place("far-range", UVec2::new(64, 40));
    let size = 512;
    let cascades = Cascades::default();
    let fit = Fit::Stable { range: 120.0 };
    let camera_of = |frame: i32| {
        let along = Vec3::new(0.137, 0.011, -0.093) * frame as f32;
        let turn = frame as f32 * 0.013;
        let walk = CameraWalk {
            eye: Vec3::new(1.0, 1.7, 6.0) + along,
            turn,
            tilt: -0.1,
            fov: 60.0,
        };
        walk.camera()
    };
    let spaces_of = |frame: i32| {
        let camera = camera_of(frame);
        let view = View::new(&camera, &place.light, &place.geometry);
        fit.light_spaces(Layout::Cascades(cascades), &view, size, 1.0)
            .expect("fits")
    };
    let first = spaces_of(0);
    let mut moved = 0.0_f32;
    for frame in 1..20 {
        let now = spaces_of(frame);
        for (before, now) in first.spaces.iter().zip(&now.spaces) {
            let before = before.clip_from_world();
            let now = now.clip_from_world();
            assert_eq!(
                before.x_axis.truncate().truncate(),
                now.x_axis.truncate().truncate()
            );
            let shift = (now.w_axis - before.w_axis).truncate().truncate();
            let texels = shift * 0.5 * size as f32;
            assert!(
                (texels - texels.round()).abs().max_element() < 2e-3,
                "{texels}"
            );
            moved = moved.max(texels.abs().max_element());
        }
    }
    assert!(
        moved > 2.0,
        "the maps moved by {moved} texels: the test is void"
    );
}
