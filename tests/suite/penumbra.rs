//! Tests of the widths of PCSS's penumbrae against analytic ones: c4 and c4b, an edge under a
//! square area light.

use umbrage_core::{Backend, Geometry, Layout, Light, Receivers, ShadowTechnique, View};
use umbrage_cpu::Cpu;
use umbrage_scenes::find;
use umbrage_techniques::{
    Bias, Hard, ListedTechnique as _, MapFilter as _, MapTechnique, Pattern, Pcss, ShadowMap,
};
use umbrage_tests::gpu::gpu;

/// Greatest relative error of a width, 5 %: the remainder of a texel and 64 taps.
const TOLERANCE: f64 = 0.05;

/// Scenes and their true ramps: visibility is (x - start) / width between 0 and 1.
const RAMPS: [(&str, f64, f64); 2] = [
    ("c4-edge-square", -0.5, 1.0),
    ("c4b-low-edge-square", 0.042_857, 0.142_857),
];

/// Returns the ratio of the penumbra's width to the true one. A line is fitted to visibility
/// against x for the floor's pixels whose true visibility is .25 to .75. The width of a ramp is the
/// inverse of its slope.
fn width_ratio(mask: &[f32], receivers: &Receivers, start: f64, width: f64) -> f64 {
    // Collect the true and measured visibility of each pixel.
    let mut middle: Vec<(f64, f64)> = Vec::new();
    for (i, &visibility) in mask.iter().enumerate() {
        let position = receivers.position(i);
        let is_on_floor = receivers.receives[i] && position.y.abs() < 1e-3;
        let x = (f64::from(position.x) - start) / width;
        if is_on_floor && (0.25..=0.75).contains(&x) {
            middle.push((x, f64::from(visibility)));
        }
    }
    assert!(
        middle.len() > 400,
        "{} pixels are too few to fit a line to",
        middle.len()
    );
    let n = middle.len() as f64;
    let mean = |f: fn(&(f64, f64)) -> f64| middle.iter().map(f).sum::<f64>() / n;
    let x = mean(|p| p.0);
    let v = mean(|p| p.1);
    let variance = mean(|p| p.0 * p.0) - x * x;
    variance / (mean(|p| p.0 * p.1) - x * v)
}

/// Returns the technique's ratio under an area light whose sides are `scale` times the scene's.
fn measure_penumbra(
    backend: &mut dyn Backend,
    technique: &MapTechnique<Pcss>,
    ramp: (&str, f64, f64),
    scale: f32,
) -> f64 {
    let (name, start, width) = ramp;
    let mut scene = (find(name).expect("a built-in scene").build)();
    if let Light::Rect { half_u, half_v, .. } = &mut scene.lights[0] {
        *half_u *= scale;
        *half_v *= scale;
    }
    let geometry = Geometry::bake(&scene).expect("built-in scenes are valid");
    let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
    let recipe = technique.recipe(&view).expect("maps serve square lamps");
    let shadows = backend.render(&view, &recipe).expect("renders");
    width_ratio(
        &shadows.mask,
        &shadows.receivers.expect("found from the geometry"),
        start,
        width,
    )
}

fn techniques() -> impl Iterator<Item = MapTechnique<Pcss>> {
    let patterns = [Pattern::Vogel, Pattern::Poisson, Pattern::Grid];
    patterns.into_iter().map(|pattern| {
        Pcss {
            pattern,
            blocker_taps: 64,
            filter_taps: 64,
            ..Pcss::default()
        }
        .on(ShadowMap::default())
    })
}

fn check(backend: &mut dyn Backend) {
    for technique in techniques() {
        for ramp in RAMPS {
            let ratio = measure_penumbra(backend, &technique, ramp, 1.0);
            let settings = technique.settings();
            assert!(
                (ratio - 1.0).abs() <= TOLERANCE,
                "{} {settings}: {ratio} of the true width",
                ramp.0
            );
        }
    }
}

#[test]
fn penumbrae_are_as_wide_as_they_should_be() {
    check(&mut Cpu::new());
}

#[test]
fn penumbrae_are_as_wide_on_the_gpu() {
    check(&mut *gpu());
}

/// Negative control: an area light that is a tenth too large must fail.
#[test]
fn a_lamp_too_large_is_caught() {
    for technique in techniques() {
        for ramp in RAMPS {
            let ratio = measure_penumbra(&mut Cpu::new(), &technique, ramp, 1.1);
            assert!(
                (ratio - 1.0).abs() > TOLERANCE,
                "{} {}: {ratio}",
                ramp.0,
                technique.settings()
            );
        }
    }
}

/// Under a light without extent, every tap is the receiver's own: the mask equals the hard one, bit
/// for bit, and has no NaN.
#[test]
fn ideal_lights_throw_hard_shadows() {
    for (name, layout) in [
        ("cubes", Layout::Auto),
        ("figure", Layout::Cube),
        ("c3-sphere-bulb", Layout::Auto),
    ] {
        let scene = (find(name).expect("a built-in scene").build)();
        let light = ideal(scene.lights[0]);
        let geometry = Geometry::bake(&scene).expect("built-in scenes are valid");
        let view = View::new(&scene.cameras[0], &light, &geometry);
        let map = ShadowMap {
            bias: Bias::ADAPTIVE,
            layout,
            ..ShadowMap::default()
        };
        let mask = |technique: &dyn ShadowTechnique| {
            let recipe = technique.recipe(&view).expect("maps serve these lights");
            Cpu::new().render(&view, &recipe).expect("renders").mask
        };
        let hard = mask(&Hard {}.on(map));
        let soft = mask(&Pcss::default().on(map));
        assert!(hard.contains(&0.0), "{name} shows no shadow");
        assert!(hard == soft, "{name} {layout:?}");
    }
}

fn ideal(light: Light) -> Light {
    match light {
        Light::Directional { direction, .. } => Light::Directional {
            direction,
            angular_diameter: 0.0,
        },
        Light::Spot {
            position,
            direction,
            inner,
            outer,
            ..
        } => Light::Spot {
            position,
            direction,
            inner,
            outer,
            radius: 0.0,
        },
        other => other,
    }
}
