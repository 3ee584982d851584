//! Tests of every technique with a map at the points of the closed forms, on both backends. If a
//! point is farther from shadow edges than the kernel's radius, the result must be that of the
//! formula. (Volumes and planar shadows need a camera's pixels: `exact.rs`.)

use glam::{Mat2, UVec2, Vec2, Vec3};
use umbrage_core::{
    Backend, Geometry, Light, NO_TRIANGLE, Receivers, Recipe, RecipeError, Scene, ShadowTechnique,
    View,
};
use umbrage_cpu::Cpu;
use umbrage_plan::catalogue::ClosedFormDemand;
use umbrage_plan::truth::{ReceiverPoint, TruthOptions, trace_points};
use umbrage_scenes::{ClosedForm, Sample, all};
use umbrage_techniques::{Bias, ShadowMap, TechniquePreset};
use umbrage_tests::gpu::gpu;
use umbrage_wgpu::Gpu;

/// Returns the requirements of each technique for closed forms. Those that need a camera's pixels
/// (`exact.rs`) have none.
fn demands() -> Vec<ClosedFormDemand<TechniquePreset>> {
    let map = ShadowMap {
        size: 2048,
        bias: Bias::ADAPTIVE,
        ..ShadowMap::default()
    };
    let entries = umbrage_plan::catalogue::all().iter();
    let own = entries.filter_map(|entry| (entry.closed_form)(map));
    own.chain(narrow_moment_maps(map)).collect()
}

/// Moment maps with the narrowest blur, since the default one is wider.
fn narrow_moment_maps(map: ShadowMap) -> impl Iterator<Item = ClosedFormDemand<TechniquePreset>> {
    let wide = ["vsm", "evsm", "msm"].into_iter().filter_map(move |name| {
        let entry = umbrage_plan::catalogue::find(name).expect("a built-in technique");
        (entry.closed_form)(map)
    });
    wide.map(|demand| {
        let text = demand.technique.to_toml().expect("written");
        let mut table: toml::Table = text.parse().expect("a table");
        let blur = table["blur"].as_integer().expect("texels");
        table["blur"] = 1.into();
        let text = toml::to_string(&table).expect("written");
        ClosedFormDemand {
            technique: TechniquePreset::from_toml(&text).expect("a preset"),
            reach: demand.reach - blur as f32 + 1.0,
            ..demand
        }
    })
}

/// Scenes of closed solids: neither sheets nor rooms without an outside.
const CLOSED_BODIES: [&str; 5] = [
    "c1-box-sun",
    "c2-sphere-sun",
    "c3-sphere-bulb",
    "c3b-sphere-level-bulb",
    "c8-faceted-sphere",
];

/// A scene under a light without extent, whose formula only has light and dark.
struct ClosedFormCase {
    name: &'static str,
    scene: Scene,
    geometry: Geometry,
    samples: Vec<Sample>,
    receivers: Receivers,
}

fn cases() -> Vec<ClosedFormCase> {
    let with_form = all()
        .iter()
        .filter_map(|entry| entry.closed_form.map(|form| (entry, form())));
    let ideal =
        with_form.map(|(entry, form)| ClosedFormCase::new(entry.name, (entry.build)(), form));
    ideal
        .filter(|case| case.scene.lights[0].is_ideal() && !case.samples.is_empty())
        .collect()
}

impl ClosedFormCase {
    fn new(name: &'static str, scene: Scene, form: ClosedForm) -> Self {
        let geometry = Geometry::bake(&scene).expect("built-in scenes are valid");
        let samples: Vec<Sample> = form
            .samples
            .into_iter()
            .filter(|s| cosine(&scene.lights[0], s) > LEAST_COSINE)
            .collect();
        let receivers = receivers(&samples, &geometry);
        Self {
            name,
            scene,
            geometry,
            samples,
            receivers,
        }
    }

    /// Executes a recipe for the whole scene at the samples alone, on the CPU and on the device, if any.
    fn masks(
        &self,
        technique: &dyn ShadowTechnique,
        device: Option<&mut Gpu>,
    ) -> Option<(Recipe, Vec<Vec<f32>>)> {
        let camera = self.scene.cameras[0].with_size(self.receivers.size);
        let view = View::new(&camera, &self.scene.lights[0], &self.geometry);
        let recipe = match technique.recipe(&view) {
            Err(RecipeError::Unsupported(_)) => return None,
            other => other.expect("parameters are valid"),
        };
        let view = view.with_receivers(&self.receivers);
        let mut cpu = Cpu::new();
        let mut backends: Vec<&mut dyn Backend> = vec![&mut cpu];
        if let Some(gpu) = device {
            backends.push(gpu);
        }
        let rendered = backends
            .into_iter()
            .map(|backend| backend.render(&view, &recipe).expect("renders").mask);
        let masks = rendered.collect();
        Some((recipe, masks))
    }

    /// Reports whether the reference is the same at a sample and everywhere within the kernel's
    /// radius.
    fn is_decided(&self, i: usize, recipe: &Recipe, reach: f32) -> bool {
        let sample = &self.samples[i];
        let Some(around) = points_around(sample, recipe, reach) else {
            return false;
        };
        let points: Vec<ReceiverPoint> = around
            .into_iter()
            .map(|place| {
                let mut point = ReceiverPoint::new(place, sample.normal, &self.geometry);
                point.triangle = self.receivers.triangle[i];
                point
            })
            .collect();
        let light = &self.scene.lights[0];
        let seen = trace_points(&self.geometry, light, &points, &TruthOptions::default());
        let mut seen = seen.expect("valid").into_iter();
        seen.all(|s| s.visibility == sample.visibility)
    }
}

/// Least cosine of the light's angle. Below half a degree, results only show the rounding of maps;
/// faces turned away are left to shading.
const LEAST_COSINE: f32 = 0.01;

fn cosine(light: &Light, s: &Sample) -> f32 {
    let to_light = match (light, light.position()) {
        (Light::Directional { direction, .. }, _) => -*direction,
        (_, position) => position.expect("all other lights have a place") - s.point,
    };
    to_light.normalize().dot(s.normal)
}

/// Distance between the reference points around a sample, texels. It is less than the narrowest
/// slit of the scenes, which is 1.2 texels wide on a map of 2048.
const SPACING: f32 = 0.75;

/// Returns the points of a sample's plane that a kernel's taps may cover: a grid over the square of
/// texels within its radius, and the receiver's own texel. A grid, and not the rim alone, includes
/// narrow lights within the square. `None` if the light is at too low an angle to the plane.
fn points_around(sample: &Sample, recipe: &Recipe, reach: f32) -> Option<Vec<Vec3>> {
    let (u, v) = sample.normal.any_orthonormal_pair();
    let p = sample.point;
    let farthest = reach + 1.5;
    let steps = (farthest / SPACING).ceil() as i32;
    let mut out = Vec::new();
    for cast in &recipe.casts {
        let size = recipe.images[cast.image].size;
        let texel = |p: Vec3| {
            let clip = cast.space.clip_from_world() * p.extend(1.0);
            Vec2::new(clip.x, clip.y) / clip.w * 0.5 * size.as_vec2()
        };
        let along = |way: Vec3| (texel(p + way * 1e-3) - texel(p)) * 1e3;
        let metres_from_texels = Mat2::from_cols(along(u), along(v)).inverse();
        if !metres_from_texels.is_finite() {
            return None;
        }
        for y in -steps..=steps {
            for x in -steps..=steps {
                let texels = Vec2::new(x as f32, y as f32) * (farthest / steps as f32);
                let metres = metres_from_texels * texels;
                out.push(p + u * metres.x + v * metres.y);
            }
        }
    }
    Some(out)
}

fn receivers(samples: &[Sample], geometry: &Geometry) -> Receivers {
    let mut out = Receivers::empty(UVec2::new(samples.len() as u32, 1));
    for (i, sample) in samples.iter().enumerate() {
        out.x[i] = sample.point.x;
        out.y[i] = sample.point.y;
        out.z[i] = sample.point.z;
        out.nx[i] = sample.normal.x;
        out.ny[i] = sample.normal.y;
        out.nz[i] = sample.normal.z;
        out.depth[i] = 0.5;
        out.distance[i] = 1.0;
        out.receives[i] = true;
        out.triangle[i] = sample.triangle(geometry).unwrap_or(NO_TRIANGLE);
    }
    out
}

/// Number of decided samples, light and dark, number of cases on the device, and the wrong results.
#[derive(Debug, Default)]
struct Answers {
    decided: [usize; 2],
    on_device: usize,
    wrong: Vec<String>,
}

/// Compares a technique with the formulas. It runs on the device for every third case that it
/// serves, from a case on that depends on its `number`. The agreement of both backends has tests of
/// its own.
fn run_technique(
    cases: &[ClosedFormCase],
    number: usize,
    demand: &ClosedFormDemand<TechniquePreset>,
    spoil: impl Fn(f32) -> f32,
) -> Answers {
    let mut out = Answers::default();
    let mut gpu = gpu();
    let technique = demand.technique.technique();
    let served =
        |case: &&ClosedFormCase| !demand.closed_bodies || CLOSED_BODIES.contains(&case.name);
    let mut turn = number;
    for case in cases.iter().filter(served) {
        let device = if turn.is_multiple_of(3) {
            Some(&mut *gpu)
        } else {
            None
        };
        let Some((recipe, masks)) = case.masks(&*technique, device) else {
            continue;
        };
        turn += 1;
        out.on_device += masks.len() - 1;
        for (i, sample) in case
            .samples
            .iter()
            .enumerate()
            .filter(|(i, _)| case.is_decided(*i, &recipe, demand.reach))
        {
            out.decided[usize::from(sample.visibility > 0.5)] += 1;
            let expected = spoil(sample.visibility);
            if let Some(got) = masks
                .iter()
                .map(|m| m[i])
                .find(|&got| (got - expected).abs() > demand.tolerance)
            {
                out.wrong.push(format!(
                    "{} at {}: {got} for {expected}",
                    case.name, sample.point
                ));
            }
        }
    }
    out
}

#[test]
fn every_technique_meets_the_closed_forms() {
    let cases = cases();
    let mut faults = Vec::new();
    for (number, demand) in demands().iter().enumerate() {
        let name = demand.technique.technique().name();
        let answers = run_technique(&cases, number, demand, |v| v);
        println!("{name}: {answers:?}");
        let is_weak = answers.decided.iter().any(|&n| n < 5) || answers.on_device == 0;
        if is_weak || !answers.wrong.is_empty() {
            faults.push((name, answers));
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

/// Negative control: with the opposite formula, every decided sample must fail.
#[test]
fn wrong_formulas_are_noticed() {
    let cases = cases();
    let demands = demands();
    let answers = run_technique(&cases, 0, &demands[0], |v| 1.0 - v);
    assert_eq!(answers.wrong.len(), answers.decided.iter().sum::<usize>());
}

/// A slit that is narrower than the kernel can be between two dark points of its rim. Points next
/// to the slit are still undecided.
#[test]
fn light_within_reach_is_seen() {
    let cases = cases();
    let slit = cases.iter().find(|case| case.name == "c6b-thick-slit");
    let slit = slit.expect("a closed form");
    let preset = demands().swap_remove(0).technique;
    let (recipe, _) = slit.masks(&*preset.technique(), None).expect("served");
    let dark = |&i: &usize| slit.samples[i].visibility == 0.0;
    let decided = |reach: f32| {
        let all = (0..slit.samples.len()).filter(dark);
        all.filter(|&i| slit.is_decided(i, &recipe, reach)).count()
    };
    let dark_samples = (0..slit.samples.len()).filter(dark).count();
    assert_eq!(dark_samples, 2);
    // A tenth of a texel, and the radii of kernels of 3x3, 7x7 and 17x17 texels.
    assert_eq!(decided(-1.4), 2);
    for reach in [2.0, 4.0, 9.0] {
        assert_eq!(decided(reach), 0, "{reach} texels");
    }
}
