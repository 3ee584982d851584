//! Controls under all kinds of lights, and corrupted inputs for which they must fail.

use super::*;
use crate::compare::{
    backends::Backends,
    compare,
    options::{CompareOptions, SceneInput},
    result::Comparison,
};
use glam::Affine3A;
use umbrage_core::{BackendError, Camera, Fit, Geometry, Instance, Mesh, Scene};
use umbrage_cpu::Cpu;
use umbrage_plan::truth::{TruthOptions, trace};
use umbrage_techniques::{
    Bias, Hard, ListedTechnique, MapFilter as _, MapTechnique, Pcss, SecondDepth, ShadowMap, Traced,
};

fn options(techniques: &[&str]) -> CompareOptions {
    CompareOptions {
        catalogue: Catalogue::built_in(),
        techniques: techniques.iter().map(|t| (*t).to_owned()).collect(),
        map_sizes: vec![1024],
        max_settings: Some(1),
        size: Some(UVec2::new(96, 72)),
        truth: TruthOptions {
            samples: 64,
            probe_samples: 16,
            ..TruthOptions::default()
        },
        runs: None,
        color: false,
        ..CompareOptions::default()
    }
}

fn scene(name: &str) -> Scene {
    (umbrage_scenes::find(name).expect("built in").build)()
}

fn lit_by(light: Light) -> Scene {
    Scene {
        lights: vec![light],
        ..scene("cubes")
    }
}

fn compare_scene(
    scene: Scene,
    options: &CompareOptions,
    backend: Box<dyn Backend + Send>,
) -> Comparison {
    let input = SceneInput::new(scene, "");
    compare(
        &[input],
        options,
        &mut Backends::from_backends(vec![backend]),
        &mut |_, _| Ok(()),
        &|_| (),
    )
    .expect("valid")
}

/// Lights of every kind that a surface's horizon may hide in part, and ideal ones.
fn lights() -> Vec<Scene> {
    let position = Vec3::new(1.5, 1.1, 1.0);
    let spot = |radius| Light::Spot {
        position,
        direction: -position,
        inner: 0.9,
        outer: 1.0,
        radius,
    };
    let sun = |angular_diameter| Light::Directional {
        direction: Vec3::new(-1.0, -0.05, -0.3),
        angular_diameter,
    };
    let lights = [
        spot(0.1),
        spot(0.0),
        sun(0.3),
        sun(0.0),
        Light::Point {
            position,
            radius: 0.4,
        },
    ];
    let lamps = ["teapot-lamp", "canopy", "rising-boxes"].map(scene);
    lights.into_iter().map(lit_by).chain(lamps).collect()
}

#[test]
fn what_is_right_holds_for_every_technique_under_every_light() {
    for scene in lights() {
        let name = scene.name.clone();
        let light = format!("{:?}", scene.lights[0]);
        let comparison = compare_scene(scene, &options(&[]), Box::new(Cpu::new()));
        let result = &comparison.scenes[0];
        let faults = comparison.faults();
        assert!(faults.is_empty(), "{name}, {light}: {faults:?}");
        let mut measured: Vec<&str> = result
            .rows
            .iter()
            .filter(|r| r.measured_figures().is_some())
            .map(|r| &*r.technique)
            .collect();
        measured.dedup();
        let controlled: Vec<&str> = result.controls.iter().map(|c| &*c.technique).collect();
        assert_eq!(controlled, measured, "every technique is controlled, once");
        let seen = result.controls.iter().filter(|c| c.changed > 0).count();
        assert!(
            seen + 1 >= controlled.len(),
            "{name}, {light}: all but `none` see casters: {:?}",
            result.controls
        );
    }
}

/// The CPU, with masks corrupted if the scene has (or doesn't have) casters.
struct Spoilt<F> {
    cpu: Cpu,
    casters: bool,
    spoil: F,
}

impl<F: FnMut(&mut Shadows, &View<'_>)> Backend for Spoilt<F> {
    fn name(&self) -> &str {
        "spoilt"
    }
    fn kind(&self) -> &'static str {
        "cpu"
    }
    fn render(&mut self, view: &View<'_>, recipe: &Recipe) -> Result<Shadows, BackendError> {
        let mut shadows = self.cpu.render(view, recipe)?;
        if view
            .geometry
            .is_some_and(|g| g.casters().is_empty() != self.casters)
        {
            (self.spoil)(&mut shadows, view);
        }
        Ok(shadows)
    }
}

/// Returns the controls of all techniques but `none`, with masks corrupted with (or without)
/// casters.
fn spoil_masks(
    casters: bool,
    scene: Scene,
    spoil: impl FnMut(&mut Shadows, &View<'_>) + Send + 'static,
) -> Vec<Control> {
    let backend = Spoilt {
        cpu: Cpu::new(),
        casters,
        spoil,
    };
    let mut controls = compare_scene(scene, &options(&[]), Box::new(backend))
        .scenes
        .remove(0)
        .controls;
    controls.retain(|c| c.technique != "none");
    assert!(controls.len() > 9, "{controls:?}");
    controls
}

#[test]
fn casters_that_leave_no_trace_are_noticed_in_every_technique() {
    // Open casters, and casters smaller than texels, are excused: the cubes are closed and wide.
    let lit = |shadows: &mut Shadows, _: &View<'_>| shadows.mask.fill(1.0);
    for control in spoil_masks(true, scene("cubes"), lit) {
        let keeps_far_sides = ["second_depth", "midpoint"].contains(&&*control.technique);
        assert!(control.shadowed > 0 && control.changed == 0, "{control:?}");
        assert_eq!(control.holds, keeps_far_sides, "{control:?}");
    }
}

#[test]
fn casters_that_stay_are_noticed_in_every_technique() {
    // A floor under a sun from above must be lit everywhere: one dark pixel is an error.
    let darken_one = |shadows: &mut Shadows, view: &View<'_>| {
        let receivers = view.receivers.expect("given");
        let pixel = (0..receivers.len())
            .find(|&i| receivers.receives[i] && receivers.ny[i] > 0.9)
            .expect("a floor");
        shadows.mask[pixel] = 0.0;
    };
    for control in spoil_masks(false, scene("cubes"), darken_one) {
        assert!(control.wrong_without == 1 && !control.holds, "{control:?}");
    }
}

/// Returns the control of one technique with the given settings.
fn control<T: ListedTechnique>(scene: &Scene, technique: T, backend: &mut dyn Backend) -> Control {
    let technique = TechniquePreset::from(technique);
    let geometry = Geometry::bake(scene).expect("valid");
    let options = options(&[]);
    let camera = options.camera(&scene.cameras[0]);
    let light = &scene.lights[0];
    let mut cpu = Cpu::new();
    let find = &mut |c: &Camera, g: &Geometry| cpu.receivers(c, g);
    let truth = trace(&camera, light, &geometry, &options.truth, find, &|_, _| ()).expect("valid");
    let view = SceneView {
        camera: &camera,
        light,
        geometry: &geometry,
    };
    let recipe = technique
        .recipe(&view.core().with_receivers(&truth.receivers))
        .expect("supported");
    let with_casters = backend.render(&view.core(), &recipe).expect("valid");
    let catalogue = Catalogue::built_in();
    run(
        backend,
        &technique,
        &view,
        &truth,
        &recipe,
        &with_casters,
        &catalogue,
    )
    .expect("valid")
    .expect("planned")
}

/// Rays are counted, not estimated: one missing or additional ray is detected, both where the light
/// is fully visible and where the horizon cuts it.
#[test]
fn a_single_ray_is_noticed() {
    let samples = 4;
    let lamp = scene("teapot-lamp");
    let traced = Traced { samples };
    let whole = |v: f32| v == 1.0;
    let cut = |v: f32| v > 0.0 && v < 1.0;
    let spoilt = |change: f32, wanted: fn(f32) -> bool| {
        let spoil = move |shadows: &mut Shadows, view: &View<'_>| {
            let receives = &view.receivers.expect("given").receives;
            // Use the last pixel: the image's upper rows may see the level of the light.
            let pixel = (0..receives.len())
                .rfind(|&i| receives[i] && wanted(shadows.mask[i]))
                .expect("there");
            shadows.mask[pixel] += change;
        };
        control(
            &lamp,
            traced,
            &mut Spoilt {
                cpu: Cpu::new(),
                casters: false,
                spoil,
            },
        )
    };
    assert!(spoilt(0.0, whole).holds);
    let ray = 1.0 / samples as f32;
    for (change, wanted) in [(-ray, whole as fn(f32) -> bool), (-ray, cut), (ray, cut)] {
        let control = spoilt(change, wanted);
        assert!(
            control.wrong_without == 1 && !control.holds,
            "{change}: {control:?}"
        );
    }
}

/// An error of the visible share is detected where the horizon cuts the light, for a kernel that
/// accounts for the horizon.
#[test]
fn a_share_that_is_wrong_is_noticed() {
    let lamp = scene("teapot-lamp");
    let spoilt = |change: f32| {
        let spoil = move |shadows: &mut Shadows, _: &View<'_>| {
            let cut = |v: &f32| *v > 0.1 && *v < 0.9;
            let pixel = shadows
                .mask
                .iter()
                .rposition(cut)
                .expect("a pot turns some of its sides away");
            shadows.mask[pixel] += change;
        };
        control(
            &lamp,
            MapTechnique::<Pcss>::default(),
            &mut Spoilt {
                cpu: Cpu::new(),
                casters: false,
                spoil,
            },
        )
    };
    assert!(spoilt(0.0).holds);
    for change in [-0.01, 0.01] {
        let control = spoilt(change);
        assert!(
            control.wrong_without == 1 && !control.holds,
            "{change}: {control:?}"
        );
    }
}

/// The floor of `cubes`, and a leaf of this half side 1.5 m above it.
fn leaf(half: f32) -> Scene {
    let mut scene = scene("cubes");
    let corners = [(-half, -half), (-half, half), (half, half), (half, -half)]
        .map(|(x, z)| Vec3::new(x, 1.0, z));
    scene
        .meshes
        .push(Mesh::new("leaf", corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).expect("valid"));
    scene.instances.truncate(1);
    scene
        .instances
        .push(Instance::new(scene.meshes.len() - 1, Affine3A::IDENTITY));
    scene
}

/// Maps may miss the shadow if their texels are wider than it, or if they keep far sides, which a
/// leaf doesn't have.
#[test]
fn maps_may_miss_what_they_cannot_hold() {
    let map = |size| ShadowMap {
        size,
        bias: Bias::RECEIVER_PLANE,
        fit: Fit::Whole,
        ..ShadowMap::default()
    };
    let small = leaf(0.2);
    let coarse = control(&small, Hard {}.on(map(8)), &mut Cpu::new());
    let fine = control(&small, Hard {}.on(map(1024)), &mut Cpu::new());
    assert!(
        coarse.holds && coarse.shadowed > 0 && coarse.changed == 0,
        "{coarse:?}"
    );
    assert!(fine.holds && fine.changed > 0, "{fine:?}");
    let far_sides = control(
        &leaf(1.0),
        MapTechnique::<SecondDepth>::default(),
        &mut Cpu::new(),
    );
    assert!(
        far_sides.holds && far_sides.shadowed > 0 && far_sides.changed == 0,
        "{far_sides:?}"
    );
    assert!(control(&leaf(1.0), MapTechnique::<Hard>::default(), &mut Cpu::new()).changed > 0);
}
