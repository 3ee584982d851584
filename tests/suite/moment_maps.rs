//! Tests of the filter of moment maps, whose GPU half computes tiles with their surroundings:
//! random sizes, layers and blurs on both backends.

use glam::{IVec2, UVec2};
use proptest::{
    prelude::*,
    test_runner::{Config, RngAlgorithm, TestRng, TestRunner},
};
use umbrage_core::{Format, Geometry, Image, Recipe, View};
use umbrage_cpu::Cpu;
use umbrage_scenes::find;
use umbrage_techniques::{
    Evsm, EvsmMoments, MapFilter as _, MapFormat, MomentPrecision, Msm, ShadowMap, TechniquePreset,
    Vsm,
};
use umbrage_tests::gpu::gpu;

/// A moment map of random depths.
#[derive(Clone, Debug)]
struct MomentMap {
    recipe: Recipe,
    images: Vec<Image>,
    blur: u32,
}

/// Kinds of moments: each of 32 and of 16 bits.
const KINDS: u32 = 8;

fn technique(kind: u32, blur: u32, map: ShadowMap) -> TechniquePreset {
    let precision = match kind % 2 {
        0 => MomentPrecision::Bits32,
        _ => MomentPrecision::Bits16,
    };
    let evsm = Evsm {
        blur,
        precision,
        ..Evsm::default()
    };
    match kind / 2 {
        0 => Vsm {
            blur,
            precision,
            ..Vsm::default()
        }
        .on(map)
        .into(),
        1 => Evsm {
            moments: EvsmMoments::Two,
            ..evsm
        }
        .on(map)
        .into(),
        2 => Evsm {
            moments: EvsmMoments::Four,
            ..evsm
        }
        .on(map)
        .into(),
        _ => Msm {
            blur,
            precision,
            ..Msm::default()
        }
        .on(map)
        .into(),
    }
}

impl MomentMap {
    /// Returns the images and the filter of a technique, with images of this size that hold these
    /// depths, repeated.
    fn new(size: UVec2, layers: u32, kind: u32, blur: u32, packed: bool, depths: &[f32]) -> Self {
        let scene = (find("cubes").expect("a built-in scene").build)();
        let geometry = Geometry::bake(&scene).expect("valid");
        let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
        let map = ShadowMap {
            size: 256,
            format: if packed {
                MapFormat::Rgba8
            } else {
                MapFormat::Depth32
            },
            ..ShadowMap::default()
        };
        let technique = technique(kind, blur, map).technique();
        let mut recipe = technique.recipe(&view).expect("serves the sun");
        recipe.casts.clear();
        for desc in &mut recipe.images {
            desc.size = size;
            desc.layers = layers;
        }
        let images = recipe.images.iter().map(|&desc| {
            let mut image = Image::filled_with(desc, 0.0);
            for (texel, depth) in image.texels.iter_mut().zip(depths.iter().cycle()) {
                *texel = match desc.format {
                    // Channels of 8 bits.
                    Format::Rgba8 => (depth * 255.0).round() * (1.0 / 255.0),
                    _ => *depth,
                };
            }
            image
        });
        let images = images.collect();
        Self {
            recipe,
            images,
            blur,
        }
    }

    /// Returns the index of the filter of moments, the last one.
    fn filter(&self) -> usize {
        self.recipe.filters.len() - 1
    }

    fn on_cpu(&self) -> Image {
        let map = Cpu::new().replay_filter(&self.recipe, self.filter(), &self.images);
        map.expect("filters")
    }

    fn on_gpu(&self) -> Image {
        let map = gpu().replay_filter(&self.recipe, self.filter(), &self.images);
        map.expect("filters")
    }

    /// Returns the greatest difference of a texel that roundings explain: none with the pinned
    /// driver. Elsewhere each of the sums' terms and the moments may be rounded otherwise, and a
    /// channel of 16 bits to a neighbouring step.
    fn tolerance(&self, texel: f32) -> f32 {
        if gpu().promises_bits() {
            return 0.0;
        }
        let roundings = (2 * (2 * self.blur + 1) + 16) as f32;
        let step = match self.recipe.images[self.recipe.filters[self.filter()].output].format {
            Format::Rg16 | Format::Rgba16 => 1.0 / 65_535.0,
            _ => 0.0,
        };
        roundings * f32::EPSILON * texel.abs().max(1.0) + step
    }

    fn differs(&self, a: f32, b: f32) -> bool {
        let equal = a.to_bits() == b.to_bits() || (a - b).abs() <= self.tolerance(a);
        !equal
    }
}

/// Inputs of a random moment map.
#[derive(Clone, Copy, Debug)]
struct RandomMap {
    size: UVec2,
    layers: u32,
    kind: u32,
    blur: u32,
    packed: bool,
    /// Seed of the depths.
    seed: u32,
}

impl RandomMap {
    fn map(self) -> MomentMap {
        // Depths of about 24 random bits each.
        let depth = |i: u32| {
            let mixed = (i ^ self.seed).wrapping_mul(0x9e37_79b9);
            let mixed = (mixed ^ (mixed >> 15)).wrapping_mul(0x85eb_ca6b);
            (mixed >> 8) as f32 * (1.0 / 16_777_216.0)
        };
        let depths: Vec<f32> = (0..997).map(depth).collect();
        let Self {
            size, layers, kind, ..
        } = self;
        MomentMap::new(size, layers, kind, self.blur, self.packed, &depths)
    }
}

fn random_maps() -> impl Strategy<Value = RandomMap> {
    // Sizes on both sides of a tile's, most of them no multiple of it.
    let size = (1..=70_u32, 1..=70_u32).prop_map(|(x, y)| UVec2::new(x, y));
    let blur = prop_oneof![4 => 0..=9_u32, 1 => 10..=32_u32];
    let kinds = (0..KINDS, any::<bool>());
    (size, 1..=3_u32, blur, kinds, any::<u32>()).prop_map(|(size, layers, blur, kinds, seed)| {
        let (kind, packed) = kinds;
        RandomMap {
            size,
            layers,
            kind,
            blur,
            packed,
            seed,
        }
    })
}

#[test]
fn random_sizes_agree() {
    let config = Config {
        cases: 80,
        failure_persistence: None,
        ..Config::default()
    };
    let random = TestRng::from_seed(RngAlgorithm::ChaCha, &[43; 32]);
    let mut runner = TestRunner::new_with_rng(config, random);
    let agree = |random: RandomMap| {
        let map = random.map();
        let cpu = map.on_cpu();
        let gpu = map.on_gpu();
        let pairs = cpu.texels.iter().zip(&gpu.texels);
        let differing = pairs.filter(|(a, b)| map.differs(**a, **b)).count();
        prop_assert_eq!(differing, 0, "of {} values", cpu.texels.len());
        Ok(())
    };
    let result = runner.run(&random_maps(), agree);
    result.unwrap_or_else(|e| panic!("{e}"));
}

/// One other depth changes the texels within the blur's radius, and no others. So a tile that reads
/// too few or wrong surroundings is noticed.
#[test]
fn one_other_depth_is_noticed_as_far_as_the_blur() {
    let size = UVec2::new(75, 61);
    let depths: Vec<f32> = (0..997).map(|i| 0.5 + 0.4 * (i as f32).sin()).collect();
    // Texels at an edge, at the border of tiles and inside of one.
    for (blur, spoilt) in [(0, (24, 26)), (3, (23, 25)), (3, (0, 60)), (9, (40, 31))] {
        let mut map = MomentMap::new(size, 2, 0, blur, false, &depths);
        let before = map.on_gpu();
        let index = before.view().index(spoilt.0, spoilt.1, 1) / 2;
        map.images[0].texels[index] += 0.1;
        let after = map.on_gpu();
        for (i, (a, b)) in before.texels.iter().zip(&after.texels).enumerate() {
            let texel = i as i32 / 2;
            let row = texel / size.x as i32;
            let at = IVec2::new(texel % size.x as i32, row % size.y as i32);
            let distance = (at - IVec2::from(spoilt)).abs().max_element();
            let is_near = distance <= blur as i32 && row >= size.y as i32;
            assert_eq!(a != b, is_near, "blur {blur}, {spoilt:?}: at {at}");
        }
        // The CPU's map of the other depths differs, too.
        let cpu = map.on_cpu();
        let pairs = cpu.texels.iter().zip(&before.texels);
        assert!(pairs.filter(|(a, b)| map.differs(**a, **b)).count() > 0);
    }
}
