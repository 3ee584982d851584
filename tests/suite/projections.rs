//! Tests of other renderers' cameras: reversed depth, no far plane, left-handed views. The light's
//! maps, the rays and the shadows equal those of the standard camera.

use glam::{DMat4, DVec4, UVec2, Vec3, Vec4};
use proptest::{
    prelude::*,
    test_runner::{Config, RngAlgorithm, TestCaseError, TestRng, TestRunner},
};
use umbrage_core::{
    Aabb, Backend, Camera, Extents, Fit, Geometry, Light, LightSpace, Receivers, ShadowTechnique,
    View, math::transform,
};
use umbrage_cpu::Cpu;
use umbrage_techniques::{
    Hard, MapFilter as _, MapTechnique, Pcf, Planar, ShadowMap, ShadowVolumes, Traced,
};

/// Matrix conventions of another renderer for a standard camera.
#[derive(Clone, Copy, Debug)]
struct ProjectionKind {
    /// No far plane. Only with perspective.
    endless: bool,
    /// Depth 1 at near.
    reversed: bool,
    /// The view looks along +z.
    left: bool,
}

/// Returns all kinds of projections; without perspective, those that [`Camera::standard`] can
/// distinguish.
fn kinds(perspective: bool) -> impl Iterator<Item = ProjectionKind> {
    let bits = (0..8).map(|i| ProjectionKind {
        endless: i & 1 != 0,
        reversed: i & 2 != 0,
        left: i & 4 != 0,
    });
    bits.filter(move |k| perspective || !(k.endless || k.reversed && k.left))
}

/// Returns the camera with the matrices of another kind, each computed in `f64` and rounded once.
/// `near_far` are the camera's.
fn as_kind(camera: &Camera, kind: ProjectionKind, near_far: [f32; 2]) -> Camera {
    let [near, far] = near_far.map(f64::from);
    let rows = camera.clip_from_view.as_dmat4().transpose();
    // Depth is (a z + b) / w.
    let perspective = rows.w_axis == DVec4::NEG_Z;
    let [a, b] = match (perspective, kind.endless) {
        (true, true) => [-1.0, -near],
        (true, false) => [-far / (far - near), -near * far / (far - near)],
        (false, _) => [-1.0 / (far - near), -near / (far - near)],
    };
    let usual = DVec4::new(0.0, 0.0, a, b);
    let depth = if kind.reversed {
        rows.w_axis - usual
    } else {
        usual
    };
    let clip_from_view = DMat4 {
        z_axis: depth,
        ..rows
    }
    .transpose();
    let mut out = Camera {
        clip_from_view: clip_from_view.as_mat4(),
        ..*camera
    };
    if kind.left {
        out.clip_from_view.z_axis = -out.clip_from_view.z_axis;
        out.world_from_view.matrix3.z_axis = -out.world_from_view.matrix3.z_axis;
    }
    out
}

/// Parameters of random cameras.
#[derive(Clone, Copy, Debug)]
struct Setup {
    eye: Vec3,
    ahead: Vec3,
    sun: Vec3,
    /// Size of the view, in radians; without perspective, in metres.
    view: f32,
    near_far: [f32; 2],
    /// Fraction of the range from near to far.
    share: f32,
    perspective: bool,
}

impl Setup {
    fn camera(&self) -> Camera {
        let target = self.eye + self.ahead;
        let size = UVec2::new(64, 48);
        let [near, far] = self.near_far;
        if self.perspective {
            return Camera::perspective(self.eye, target, Vec3::Y, self.view, self.near_far, size)
                .expect("valid");
        }
        let right = 4.0 * self.view;
        let top = 3.0 * self.view;
        let extents = Extents {
            left: -right,
            right,
            bottom: -top,
            top,
            near,
            far,
        };
        Camera::orthographic(self.eye, target, Vec3::Y, extents, size).expect("valid")
    }

    fn range(&self) -> f32 {
        let [near, far] = self.near_far;
        near + self.share * (far - near)
    }
}

fn setups() -> impl Strategy<Value = Setup> {
    let place = || (-50.0_f32..50.0, -50.0_f32..50.0, -50.0_f32..50.0).prop_map(Vec3::from);
    let direction = || place().prop_filter("a direction", |d| d.length() > 1.0);
    let near_far = (-4.0_f32..0.0, 1.0_f32..3.0)
        .prop_map(|(n, ratio)| [10_f32.powf(n), 10_f32.powf(n + ratio)]);
    let parts = (
        place(),
        direction(),
        direction(),
        0.2_f32..2.4,
        near_far,
        0.02_f32..0.9,
        any::<bool>(),
    );
    parts.prop_map(
        |(eye, ahead, sun, view, near_far, share, perspective)| Setup {
            eye,
            ahead,
            sun,
            view,
            near_far,
            share,
            perspective,
        },
    )
}

/// Returns the map of 1024 texels around a camera's view up to `range`, without known casters or
/// receivers.
fn stable(camera: &Camera, sun: Vec3, range: f32) -> LightSpace {
    let light = Light::Directional {
        direction: sun,
        angular_diameter: 0.0,
    };
    let view = View {
        nearest_caster: 0.0,
        camera,
        light: &light,
        casters: Aabb::EMPTY,
        geometry: None,
        receivers: None,
        fits: None,
    };
    Fit::Stable { range }
        .light_space(&view, 1024, 0.0)
        .expect("it fits")
}

/// Returns the corners of a camera's view at this distance.
fn corners(camera: &Camera, distance: f32) -> [Vec3; 4] {
    let world_from_clip = camera.space().clip_from_world().as_dmat4().inverse();
    let forward = -camera.standard().world_from_view.matrix3.z_axis.as_dvec3();
    let eye = camera.eye().as_dvec3();
    [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)].map(|(x, y)| {
        // The line of a pixel, through two of its depths.
        let [from, to] =
            [0.0, 0.5].map(|z| world_from_clip.project_point3(glam::DVec3::new(x, y, z)));
        let per_step = (to - from).dot(forward);
        (from + (to - from) * ((f64::from(distance) - (from - eye).dot(forward)) / per_step))
            .as_vec3()
    })
}

/// Tests a property on random setups, which are the same in every run.
fn each(
    setups: impl Strategy<Value = Setup>,
    property: impl Fn(Setup) -> Result<(), TestCaseError>,
) {
    let config = Config {
        cases: 512,
        failure_persistence: None,
        ..Config::default()
    };
    let mut runner =
        TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha));
    runner
        .run(&setups, property)
        .unwrap_or_else(|e| panic!("{e}"));
}

/// 24 bits represent near to 1e-7 of itself, and far (a small difference of two entries) to 1e-7
/// far / near.
#[test]
fn stable_maps_hold_as_much_and_no_more() {
    each(setups(), |setup| {
        let usual = setup.camera();
        let [near, far] = setup.near_far;
        for range in [setup.range(), 2.0 * far] {
            let expected = stable(&usual, setup.sun, range);
            let beyond = range > far;
            let rounding = if beyond { 1e-6 * far / near } else { 1e-5 };
            for kind in kinds(setup.perspective).filter(|k| !(beyond && k.endless)) {
                let camera = as_kind(&usual, kind, setup.near_far);
                let space = stable(&camera, setup.sun, range);
                let ratio = space.clip_from_view.x_axis.x / expected.clip_from_view.x_axis.x;
                prop_assert!(
                    (ratio - 1.0).abs() <= rounding,
                    "{kind:?} up to {range} m: scale {ratio}"
                );
                let clip_from_world = space.clip_from_world();
                let last = range.min(far) * (1.0 - rounding);
                // The rounding of positions is less than the margin of two texels around the
                // sphere.
                for p in corners(&usual, near)
                    .into_iter()
                    .chain(corners(&usual, last))
                {
                    let clip = transform(clip_from_world, p);
                    let on_map = clip.x.abs().max(clip.y.abs()) <= 1.0 && clip.z <= 1.0;
                    prop_assert!(on_map, "{kind:?}: {p} falls on {clip}");
                }
            }
        }
        Ok(())
    });
}

/// A camera without a far plane has the given range, regardless of its size.
#[test]
fn stable_maps_end_at_the_range_without_a_far_plane() {
    each(
        setups().prop_filter("perspective", |s| s.perspective),
        |setup| {
            let usual = setup.camera();
            let range = 20.0 * setup.near_far[1];
            for kind in kinds(true).filter(|k| k.endless) {
                let camera = as_kind(&usual, kind, setup.near_far);
                let side = 2.0 / stable(&camera, setup.sun, range).clip_from_view.x_axis.x;
                // The map is at least as large as the view at that distance, and at most as large
                // as the sphere around the eye through its corners.
                let [a, b, _, d] = corners(&camera, range);
                prop_assert!(
                    side >= a.distance(b) * 0.999,
                    "{kind:?}: {side} m for {}",
                    a.distance(b)
                );
                prop_assert!(
                    side <= 2.0 * d.distance(usual.eye()) * 1.01,
                    "{kind:?}: {side} m"
                );
            }
            Ok(())
        },
    );
}

#[test]
fn rays_are_those_of_the_usual_camera() {
    each(setups(), |setup| {
        let usual = setup.camera();
        for kind in kinds(setup.perspective) {
            let camera = as_kind(&usual, kind, setup.near_far);
            let expected = usual.rays();
            let found = camera.rays();
            // Entries of the projection are rounded, and near without perspective is a quotient of
            // two.
            let near = |a: Vec4, b: Vec4| a.distance(b) <= 1e-5 * (1.0 + a.length());
            prop_assert!(
                near(expected.dir, found.dir) && near(expected.dir_dx, found.dir_dx),
                "{kind:?}: {found:?}"
            );
            prop_assert!(near(expected.origin, found.origin), "{kind:?}: {found:?}");
            prop_assert_eq!(camera.standard().standard(), camera.standard());
        }
        prop_assert_eq!(usual.standard(), usual);
        Ok(())
    });
}

fn scene() -> (Geometry, Light) {
    let scene = umbrage_scenes::find("cubes").expect("a built-in scene");
    let scene = (scene.build)();
    (Geometry::bake(&scene).expect("valid"), scene.lights[0])
}

/// Techniques that use the camera in different ways.
fn techniques() -> [Box<dyn ShadowTechnique>; 5] {
    let stable = ShadowMap {
        fit: Fit::Stable { range: 6.0 },
        size: 256,
        ..ShadowMap::default()
    };
    [
        Box::new(Hard {}.on(stable)),
        Box::new(MapTechnique::<Pcf>::default()),
        Box::new(Planar::default()),
        Box::new(ShadowVolumes::default()),
        Box::new(Traced::default()),
    ]
}

/// Ids and results are equal at every pixel: clip x, y and w have the same bits for every kind, and
/// no two surfaces of the scene are as close to each other as the rounding of depth.
#[test]
fn pictures_are_those_of_the_usual_camera() {
    let (geometry, light) = scene();
    let near_far = [0.1, 100.0];
    let eye = Vec3::new(3.0, 4.0, 6.0);
    let size = UVec2::new(96, 72);
    let perspective =
        Camera::perspective(eye, Vec3::ZERO, Vec3::Y, 0.8, near_far, size).expect("valid");
    let extents = Extents {
        left: -4.0,
        right: 4.0,
        bottom: -3.0,
        top: 3.0,
        near: 0.1,
        far: 100.0,
    };
    let flat = Camera::orthographic(eye, Vec3::ZERO, Vec3::Y, extents, size).expect("valid");
    for (usual, with_perspective) in [(perspective, true), (flat, false)] {
        let seen = Cpu::new().receivers(&usual, &geometry).expect("valid");
        let masks: Vec<_> = techniques()
            .iter()
            .map(|t| mask(&**t, &usual, &light, &geometry))
            .collect();
        for kind in kinds(with_perspective) {
            let camera = as_kind(&usual, kind, near_far);
            let found: Receivers = Cpu::new().receivers(&camera, &geometry).expect("valid");
            assert_eq!(found.triangle, seen.triangle, "{kind:?}");
            for (technique, expected) in techniques().iter().zip(&masks) {
                let mask = mask(&**technique, &camera, &light, &geometry);
                let differing = mask.iter().zip(expected).filter(|(a, b)| a != b).count();
                assert!(
                    expected.contains(&0.0) && expected.contains(&1.0),
                    "{} shows no edge",
                    technique.name()
                );
                assert_eq!(
                    differing,
                    0,
                    "{} seen by {kind:?}, perspective {with_perspective}",
                    technique.name()
                );
            }
        }
    }
}

fn mask(
    technique: &dyn ShadowTechnique,
    camera: &Camera,
    light: &Light,
    geometry: &Geometry,
) -> Vec<f32> {
    let view = View::new(camera, light, geometry);
    let recipe = technique.recipe(&view).expect("it plans");
    Cpu::new().render(&view, &recipe).expect("it renders").mask
}
