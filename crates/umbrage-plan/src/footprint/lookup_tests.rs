//! Tests of unused texels against the kernels: the content of texels that no lookup touches has no
//! effect.

use super::*;
use umbrage_core::{Backend as _, Geometry, Image, Inputs, Scene, ShadowTechnique as _, Simd};
use umbrage_cpu::Cpu;
use umbrage_techniques::{
    Bias, MapFilter as _, Pattern, Pcf, PcfDisc, PcfHardware, PcfMerged, ShadowMap, TechniquePreset,
};

/// A directional light with an extent, a rectangle, and a point light with a cube map.
const SCENES: [&str; 4] = ["cubes", "rising-boxes", "c4-edge-square", "lamp-in-room"];

/// Returns every technique with a range of kernel widths.
fn presets() -> Vec<TechniquePreset> {
    let map = ShadowMap::default();
    let mut out = TechniquePreset::defaults();
    out.extend([2, 5].map(|radius| TechniquePreset::from(Pcf::new(radius).on(map))));
    out.extend([2, 3, 4].map(|samples| TechniquePreset::from(PcfHardware { samples }.on(map))));
    out.extend([2, 3].map(|radius| TechniquePreset::from(PcfMerged { radius }.on(map))));
    let disc = |pattern| {
        PcfDisc {
            radius: 6.5,
            taps: 32,
            pattern,
            ..PcfDisc::default()
        }
        .on(ShadowMap::default())
    };
    out.extend([Pattern::Vogel, Pattern::Grid].map(|pattern| TechniquePreset::from(disc(pattern))));
    let biased = |bias| {
        move |p: &TechniquePreset| {
            p.map().map(|&map| {
                p.with_map(ShadowMap {
                    size: 160,
                    bias,
                    ..map
                })
            })
        }
    };
    let of = |bias| out.iter().filter_map(biased(bias)).collect::<Vec<_>>();
    of(Bias::NONE)
        .into_iter()
        .chain(of(Bias::ADAPTIVE))
        .collect()
}

/// Returns the visibility of the receivers from these images.
fn looked_up_visibilities(recipe: &Recipe, images: &[Image], receivers: &Receivers) -> Vec<f32> {
    let views: Vec<_> = recipe
        .receive
        .inputs
        .iter()
        .map(|&id| images[id].view())
        .collect();
    let inputs = Inputs {
        images: &views,
        simd: Simd::Native,
    };
    let width = receivers.size.x as usize;
    let mut out = vec![1.0; receivers.len()];
    for (y, row) in out.chunks_mut(width).enumerate() {
        recipe
            .receive
            .kernel
            .receive(&inputs, &receivers.span(y * width, width), row);
    }
    (0..out.len())
        .filter(|&i| receivers.receives[i])
        .map(|i| out[i])
        .collect()
}

/// Returns the images with a blocker at the light in each texel whose number of lookups is
/// `chosen`.
fn spoil_images(
    recipe: &Recipe,
    images: &[Image],
    footprint: &RecipeFootprint,
    chosen: impl Fn(u32) -> bool,
) -> Vec<Image> {
    let mut images = images.to_vec();
    for cast in &footprint.casts {
        let image = &mut images[recipe.receive.inputs[0]];
        let channels = image.desc.format.channels();
        let start = cast.layer as usize * cast.lookups.len();
        for (i, _) in cast.lookups.iter().enumerate().filter(|(_, n)| chosen(**n)) {
            image.texels[(start + i) * channels..][..channels].fill(0.0);
        }
    }
    images
}

#[test]
fn texels_never_looked_up_may_hold_anything() {
    let mut checked = 0;
    for name in SCENES {
        let scene: Scene = umbrage_scenes::by_argument(name).unwrap();
        let camera = scene.cameras[0].with_size(UVec2::new(96, 64));
        let geometry = Geometry::bake(&scene).unwrap();
        let receivers = Cpu::new().receivers(&camera, &geometry).unwrap();
        let view = View::new(&camera, &scene.lights[0], &geometry).with_receivers(&receivers);
        for technique in presets() {
            let label = format!("{name}: {} ({})", technique.name(), technique.settings());
            let Ok(mut recipe) = technique.recipe(&view) else {
                continue;
            };
            recipe.keep_images = true;
            let images = Cpu::new().render(&view, &recipe).unwrap().images;
            let footprint = recipe_footprint(
                &technique,
                &view,
                &recipe,
                &receivers,
                &Catalogue::built_in(),
            )
            .expect("it has a map");
            let right = looked_up_visibilities(&recipe, &images, &receivers);
            let unused = spoil_images(&recipe, &images, &footprint, |n| n == 0);
            assert_eq!(
                looked_up_visibilities(&recipe, &unused, &receivers),
                right,
                "{label}"
            );
            let used = spoil_images(&recipe, &images, &footprint, |n| n > 0);
            assert_ne!(
                looked_up_visibilities(&recipe, &used, &receivers),
                right,
                "{label}: nothing was looked up"
            );
            checked += usize::from(footprint.total.unused > 0.0);
        }
    }
    assert!(checked > 100, "only {checked} recipes left texels unused");
}
