//! Tests that any-hit rays don't depend on the order of triangles: in the CPU's eight-way
//! hierarchy, in the shader's two-way one, and in a shuffled list; up to 1e6 m from the origin.

use std::fmt::Write as _;
use umbrage_core::{
    Aabb, Backend, Geometry, Scene, ShadowTechnique, View,
    bvh::segment_hits,
    glam::{Vec2, Vec3},
    light_sample::{LightSampler, hash, origin_offset, segment},
};
use umbrage_cpu::Cpu;
use umbrage_techniques::Traced;
use umbrage_tests::gpu::gpu;

/// Spheres over a floor at this distance from the origin along x and z. At 1e6 m, positions are on
/// a grid of 6 cm, and most of the triangles have no area. In the past, a ray could hit one of them
/// anywhere in its plane, unless a hierarchy skipped it.
fn far_scene(metres: f64, light: &str) -> Scene {
    let at = |x: f64, y: f64, z: f64| format!("[{}, {y:?}, {}]", metres + x, metres + z);
    let mut text = format!(
        "name = \"far\"\nanchor = [0, 0, 0]\n[camera]\neye = {}\ntarget = {}\nfov_y_degrees = 40\nsize = [160, 120]\n[[light]]\n{light}\n",
        at(3.0, 3.0, 5.0),
        at(0.0, 0.5, 0.0)
    );
    for (shape, scale, place) in [
        ("plane", 4.0, at(0.0, 0.0, 0.0)),
        ("sphere", 0.6, at(0.2, 0.8, 0.3)),
        ("sphere", 0.2, at(-1.0, 1.5, 0.5)),
    ] {
        writeln!(
            text,
            "[[object]]\nshape = \"{shape}\"\nscale = {scale}\ntranslate = {place}"
        )
        .expect("fits");
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("far.toml");
    std::fs::write(&path, text).expect("written");
    umbrage_scenes::by_argument(path.to_str().expect("plain")).expect("a good scene")
}

const SUN: &str = "kind = \"directional\"\ndirection = [-0.5, -0.7, -0.3]";

/// Returns the result of `traced` for each pixel, computed without a hierarchy.
fn brute_force(view: &View<'_>, geometry: &Geometry, order: &[u32]) -> Vec<f32> {
    let receivers = view.receivers.expect("given");
    let eye = view.camera.eye();
    let all = geometry.bounds().union(&Aabb::from_points([eye]));
    let far = 2.0 * all.extent().length();
    let light = LightSampler::new(view.light);
    let mut mask = vec![1.0; receivers.len()];
    for (i, visibility) in mask.iter_mut().enumerate() {
        if !receivers.receives[i] {
            continue;
        }
        let p: Vec3 = receivers.position(i);
        let n: Vec3 = receivers.normal(i);
        let to_eye = (eye - p).abs().max_element();
        let reach = to_eye.max(geometry.receiver_reach());
        let origin = p + n * origin_offset(p, reach);
        let to_light = segment(&light, origin, Vec2::ZERO, far);
        let faces_away = n.dot(to_light) <= 0.0;
        let hides = |&id: &u32| {
            let [a, b, c] = geometry.corners(id);
            id != receivers.triangle[i] && segment_hits(origin, to_light, a, b, c)
        };
        if faces_away || order.iter().any(hides) {
            *visibility = 0.0;
        }
    }
    mask
}

#[test]
fn hierarchies_and_lists_in_any_order_agree_up_to_a_million_metres() {
    for metres in [0.0, 1e2, 1e4, 1e5, 1e6] {
        let scene = far_scene(metres, SUN);
        let geometry = Geometry::bake(&scene).expect("valid");
        let mut cpu = Cpu::new();
        let receivers = cpu.receivers(&scene.cameras[0], &geometry).expect("valid");
        let view =
            View::new(&scene.cameras[0], &scene.lights[0], &geometry).with_receivers(&receivers);
        let recipe = Traced::default().recipe(&view).expect("served");
        let mine = cpu.render(&view, &recipe).expect("renders").mask;
        let mut order: Vec<u32> = geometry.casters().collect();
        order.sort_by_key(|&id| hash(id));
        let expected = brute_force(&view, &geometry, &order);
        let differing = |mask: &[f32]| mask.iter().zip(&expected).filter(|(a, b)| a != b).count();
        assert_eq!(differing(&mine), 0, "pixels on the CPU at {metres} m");
        let mut gpu = gpu();
        let theirs = gpu.render(&view, &recipe).expect("renders").mask;
        // Other drivers may divide, and therefore shear, differently.
        if gpu.promises_bits() {
            assert_eq!(differing(&theirs), 0, "pixels on the GPU at {metres} m");
        }
        let dark = expected.iter().filter(|v| **v == 0.0).count();
        assert!(
            (300..15_000).contains(&dark),
            "at {metres} m the test proves little: {dark} dark pixels"
        );
    }
}

/// Negative control of the scene: at 1e6 m, many triangles have distinct corners but no area.
#[test]
fn far_away_triangles_lose_their_area() {
    let geometry = Geometry::bake(&far_scene(1e6, SUN)).expect("valid");
    let mut count = 0;
    for id in geometry.casters() {
        let [a, b, c] = geometry.corners(id);
        let has_no_area = (b - a).cross(c - a) == Vec3::ZERO;
        count += u32::from(has_no_area && a != b && b != c && c != a);
    }
    assert!(count > 100, "{count}");
}
