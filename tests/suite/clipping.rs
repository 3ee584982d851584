//! Tests that no technique depends on the clipping of triangles by a rasteriser. The CPU's
//! rasteriser clips in the ways that hardware may.

use glam::{UVec2, Vec3, Vec4Swizzles};
use std::sync::Arc;
use umbrage_core::{
    Backend, Cascades, Faces, Fit, Geometry, Layout, Recipe, RecipeError, Scene, ShadowTechnique,
    Source, View, metrics::Pixel,
};
use umbrage_cpu::{Clipping, Cpu, CpuOptions, VertexSums};
use umbrage_lab::compare;
use umbrage_plan::truth::{TruthOptions, trace};
use umbrage_techniques::{MapFilter as _, Pcf, Planar, ShadowMap, ShadowVolumes, TechniquePreset};

/// Number of pixels in a false shadow on an NVIDIA H200 when volumes ended at infinity.
const FALSE_ON_CARD: [(&str, usize); 2] = [("bar-at-lamp", 6322), ("two-blockers", 6552)];

/// Scenes with volumes around the eye, and those of planar shadows.
const SCENES: &[&str] = &[
    "bar-at-lamp",
    "two-blockers",
    "c1-box-sun",
    "c3-room",
    "c3b-sphere-level-bulb",
    "c6c-seam",
    "c7-closed-room",
    "cubes",
    "figure",
    "low-sun-2",
    "thin-plate",
    "open-shells",
    "lamp-in-room",
    "eye-in-umbra",
    "eye-in-umbra-lamp",
    "broken-meshes-lamp",
    "stairs-lamp",
    "spot-above",
    "far-range",
    "tower-out-of-view",
];

/// Greatest width of images, pixels.
const WIDTH: u32 = 320;

struct ClippingScene {
    scene: Scene,
    geometry: Geometry,
}

impl ClippingScene {
    fn new(name: &str) -> Self {
        let scene = (umbrage_scenes::find(name).expect("a built-in scene").build)();
        let geometry = Geometry::bake(&scene).expect("built-in scenes are valid");
        Self { scene, geometry }
    }

    fn of_width(name: &str, width: u32) -> Self {
        let mut stage = Self::new(name);
        let camera = &mut stage.scene.cameras[0];
        if camera.size.x > width {
            let height = width * camera.size.y / camera.size.x;
            *camera = camera.with_size(UVec2::new(width, height));
        }
        stage
    }

    fn view(&self) -> View<'_> {
        View::new(
            &self.scene.cameras[0],
            &self.scene.lights[0],
            &self.geometry,
        )
    }
}

fn cpu(clipping: Clipping) -> Cpu {
    cpu_with(&CpuOptions::default().clipping(clipping))
}

fn cpu_with(options: &CpuOptions) -> Cpu {
    Cpu::with_options(options).expect("valid options")
}

/// Returns the ways of clipping and of summation on devices.
fn devices() -> Vec<CpuOptions> {
    let clipping = Clipping::INEXACT.map(|clipping| CpuOptions::default().clipping(clipping));
    let sums = VertexSums::OTHERS.map(|sums| CpuOptions::default().vertex_sums(sums));
    [&clipping[..], &sums].concat()
}

/// Returns the recipe of shadow volumes with their far ends moved to infinity, as in Everitt and
/// Kilgard 2002.
fn ends_at_infinity(recipe: &Recipe, lamp: Vec3) -> Recipe {
    let mut out = recipe.clone();
    for cast in &mut out.casts {
        let m = &mut cast.space.clip_from_view;
        (m.x_axis.z, m.y_axis.z, m.z_axis.z) = (m.x_axis.w, m.y_axis.w, m.z_axis.w);
        if let Source::Faces(faces) = &cast.source {
            cast.source = Source::Faces(Arc::new(with_far_ends_at_infinity(faces, lamp)));
        }
    }
    out
}

/// Returns the faces with their far ends at infinity. The first vertices are those of the casters,
/// followed by as many that are moved away from the light.
fn with_far_ends_at_infinity(faces: &Faces, lamp: Vec3) -> Faces {
    let first_cap = faces.triangles[0];
    let first_far_cap = faces.triangles[1];
    let count = (first_far_cap[0] - first_cap[0]) as usize;
    let mut out = faces.clone();
    for i in 0..count {
        out.vertices[count + i] = (faces.vertices[i].xyz() - lamp).extend(0.0);
    }
    out
}

/// The cause of false shadows on an H200: corners at clip w = 0, on the side of 0 that results from
/// rounding.
#[test]
fn faces_at_zero_w_are_drawn_wrongly_as_on_a_card() {
    for (name, false_on_card) in FALSE_ON_CARD {
        let stage = ClippingScene::new(name);
        let lamp = stage.scene.lights[0].position().expect("a lamp");
        let receivers = Cpu::new()
            .receivers(&stage.scene.cameras[0], &stage.geometry)
            .expect("valid");
        let view = stage.view().with_receivers(&receivers);
        let finite = ShadowVolumes::default().recipe(&view).expect("supported");
        let infinite = ends_at_infinity(&finite, lamp);
        let render = |clipping, recipe| cpu(clipping).render(&view, recipe).expect("valid").mask;
        let expected = render(Clipping::Exact, &finite);
        let differing = |mask: Vec<f32>| {
            let pairs = expected.iter().zip(&mask);
            pairs.filter(|(a, b)| a != b).count()
        };
        assert_eq!(differing(render(Clipping::Exact, &infinite)), 0, "{name}");
        let wrong = differing(render(Clipping::ZeroWBehind, &infinite));
        println!("{name}: {wrong} wrong pixels, {false_on_card} on an H200");
        assert!(
            wrong.abs_diff(false_on_card) * 10 <= false_on_card,
            "{name}: {wrong}"
        );
        for clipping in [Clipping::ZeroWDropped, Clipping::ZeroWBehind] {
            assert_eq!(
                differing(render(clipping, &finite)),
                0,
                "{name}: {clipping:?}"
            );
        }
    }
}

/// Volumes and planar shadows don't change where the reference is certain.
#[test]
fn exact_techniques_stay_exact() {
    let techniques: [&dyn ShadowTechnique; 2] = [&ShadowVolumes::default(), &Planar::default()];
    let mut compared = [0; 2];
    for (turn, name) in SCENES.iter().enumerate() {
        let stage = ClippingScene::of_width(name, WIDTH);
        let mut exact = Cpu::new();
        let mut find = |camera: &_, geometry: &_| exact.receivers(camera, geometry);
        // Both techniques ignore the light's extent, and so does what is certain.
        let light = stage.scene.lights[0].without_extent();
        let truth = trace(
            &stage.scene.cameras[0],
            &light,
            &stage.geometry,
            &TruthOptions::default(),
            &mut find,
            &|_, _| {},
        )
        .expect("built-in scenes are valid");
        let view = stage.view().with_receivers(&truth.receivers);
        for (technique, compared) in techniques.iter().zip(&mut compared) {
            let Ok(recipe) = technique.recipe(&view) else {
                continue;
            };
            let expected = Cpu::new().render(&view, &recipe).expect("valid").mask;
            // Half of the devices for each scene, in turn.
            for device in devices().into_iter().skip(turn % 2).step_by(2) {
                // At outlines of visible surfaces, another triangle may cover a pixel.
                let own = cpu_with(&device).render(&stage.view(), &recipe);
                let own = own.expect("valid");
                let seen = own.receivers.expect("none were given").triangle;
                let counted = (0..seen.len()).filter(|&i| {
                    truth.pixels[i] == Pixel::Counted && seen[i] == truth.receivers.triangle[i]
                });
                let wrong = counted.filter(|&i| own.mask[i] != expected[i]).count();
                assert_eq!(wrong, 0, "{} in {name}: {device:?}", technique.name());
            }
            *compared += 1;
        }
    }
    println!("{compared:?} scenes");
    assert!(
        compared[0] >= 15 && compared[1] >= 8,
        "too few scenes: {compared:?}"
    );
}

/// Returns the headline settings of all techniques, and `pcf` on cascades.
fn techniques() -> Vec<TechniquePreset> {
    let mut out: Vec<_> = umbrage_plan::catalogue::all()
        .iter()
        .flat_map(|entry| (entry.headline)(&[256], Fit::Tight))
        .collect();
    let map = ShadowMap {
        size: 256,
        fit: Fit::Tight,
        layout: Layout::Cascades(Cascades::default()),
        ..ShadowMap::default()
    };
    out.push(TechniquePreset::from(Pcf::default().on(map)));
    out
}

/// Decided pixels of each technique don't change: in a sun's maps, cubes around a point light, and
/// cascades.
#[test]
fn no_decided_pixel_changes() {
    let mut maps = 0;
    for name in ["cubes", "lamp-in-room", "far-range"] {
        let stage = ClippingScene::of_width(name, 160);
        let view = stage.view();
        for technique in techniques() {
            let label = format!("{} {} in {name}", technique.name(), technique.settings());
            let recipe = match technique.recipe(&view) {
                Ok(recipe) => recipe,
                Err(RecipeError::Unsupported(_)) => continue,
                Err(why) => panic!("{label}: {why}"),
            };
            let mut exact = Cpu::new();
            let expected = exact.render(&view, &recipe).expect("valid");
            for clipping in Clipping::INEXACT {
                let other = cpu(clipping).render(&view, &recipe).expect("valid");
                let agreement = compare::agree(&view, &recipe, &expected, &other, exact.snapping())
                    .expect("masks of one size");
                assert!(agreement.holds(), "{label}: {clipping:?}: {agreement:?}");
            }
            maps += recipe.casts.len();
        }
    }
    assert!(maps >= 60, "only {maps} layers were drawn");
}
