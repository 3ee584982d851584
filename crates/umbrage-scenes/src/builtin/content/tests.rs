//! Tests that content scenes have their stated size, and that the scenes of a pair differ by their
//! light alone.

use crate::{Kind, all, find};
use umbrage_core::glam::{UVec2, Vec3};
use umbrage_core::{Geometry, Light, Scene};

/// Names without `-soft`, and minimum numbers of triangles.
const SCENES: [(&str, usize); 7] = [
    ("nave", 250_000),
    ("street", 250_000),
    ("forest", 1_000_000),
    ("valley", 1_000_000),
    ("dancer", 100_000),
    ("night-room", 100_000),
    ("leaf-cards", 250_000),
];

/// Rays across and down an image, for estimating its fraction in shadow.
const RAYS: UVec2 = UVec2::new(64, 36);

fn build_scene(name: &str) -> Scene {
    (find(name).expect("built in").build)()
}

fn soft_name(name: &str) -> String {
    format!("{name}-soft")
}

/// Returns the scene without the properties that differ within its pair.
fn without_light(scene: Scene) -> Scene {
    Scene {
        name: String::new(),
        lights: Vec::new(),
        ..scene
    }
}

#[test]
fn each_has_an_ideal_and_a_wide_light() {
    let listed = all().iter().filter(|entry| entry.kind == Kind::Content);
    assert_eq!(listed.count(), 2 * SCENES.len());
    for (name, _) in SCENES {
        let ideal = build_scene(name);
        let soft = build_scene(&soft_name(name));
        assert!(ideal.lights.iter().all(Light::is_ideal), "{name}");
        assert!(!soft.lights.iter().any(Light::is_ideal), "{name}");
        assert_eq!(ideal.lights.len(), soft.lights.len(), "{name}");
        assert_eq!(ideal.cameras[0].size, UVec2::new(1280, 720), "{name}");
        assert_eq!(without_light(ideal), without_light(soft), "{name}");
    }
    assert_eq!(build_scene("night-room").lights.len(), 3);
}

#[test]
fn each_is_as_large_and_as_shady_as_content_is() {
    for (name, least) in SCENES {
        let scene = build_scene(name);
        let geometry = Geometry::bake(&scene).unwrap();
        let triangles = geometry.triangles().len();
        assert!(triangles >= least, "{name}: {triangles} triangles");
        let most_if_quick = if find(name).unwrap().quick {
            1_000_000
        } else {
            usize::MAX
        };
        assert!(triangles <= most_if_quick, "{name} is not for quick runs");
        let shade = shade(&scene, &geometry);
        assert!((0.1..=0.9).contains(&shade), "{name}: {shade} in shadow");
    }
}

/// The figure alone, without floor and curtain, has as many triangles as the scene needs.
#[test]
fn the_dancer_is_large_without_her_stage() {
    let scene = build_scene("dancer");
    let names = [
        "skin", "hair", "bodice", "skirt", "shoes", "ribbons", "staff",
    ];
    let parts = scene
        .meshes
        .iter()
        .filter(|m| names.contains(&m.name.as_str()));
    let triangles: usize = parts.map(|mesh| mesh.triangles.len()).sum();
    assert!(triangles >= 100_000, "{triangles}");
}

/// Returns the shadowed fraction of the visible points that face the light.
fn shade(scene: &Scene, geometry: &Geometry) -> f32 {
    let bvh = geometry.bvh();
    let rays = scene.cameras[0].with_size(RAYS).rays();
    let light = scene.lights[0];
    let mut facing = 0.0;
    let mut dark = 0.0;
    for y in 0..RAYS.y {
        for x in 0..RAYS.x {
            let right = x as f32 + 0.5;
            let down = y as f32 + 0.5;
            let o = rays.origin + rays.origin_dx * right + rays.origin_dy * down;
            let d = rays.dir + rays.dir_dx * right + rays.dir_dy * down;
            let view = d.truncate().normalize();
            let Some(seen) = seen_surface(geometry, o.truncate(), view) else {
                continue;
            };
            let to_light = match light.position() {
                Some(position) => 0.999 * (position - seen.point),
                None => 1.0e4 * light.direction_from(seen.point),
            };
            if seen.normal.dot(to_light) > 0.0 && is_reached(&light, to_light) {
                facing += 1.0;
                let above = seen.point + seen.lift * seen.normal;
                if bvh.is_occluded(above, to_light, u32::MAX) {
                    dark += 1.0;
                }
            }
        }
    }
    dark / facing
}

/// Reports whether the light reaches a point, from the direction to the light: a spot only reaches
/// points within its cone.
fn is_reached(light: &Light, to_light: Vec3) -> bool {
    match *light {
        Light::Spot {
            direction, outer, ..
        } => direction.angle_between(-to_light) < outer,
        _ => true,
    }
}

/// The first hit of a ray.
struct SeenSurface {
    point: Vec3,
    /// Unit normal towards the eye.
    normal: Vec3,
    /// An offset from the surface that exceeds the rounding of every ray, metres.
    lift: f32,
}

/// Returns the first hit of a ray. Two neighbouring rays determine the normal.
fn seen_surface(geometry: &Geometry, o: Vec3, view: Vec3) -> Option<SeenSurface> {
    const ASIDE: f32 = 1.0e-4;
    let far = 1.0e4 * view;
    let distance = |ray: Vec3| geometry.bvh().nearest(geometry, o, ray, u32::MAX);
    let u = view.any_orthonormal_vector();
    let v = view.cross(u);
    let across_u = far + 1.0e4 * ASIDE * u;
    let across_v = far + 1.0e4 * ASIDE * v;
    let t = distance(far)?;
    let point = o + far * t;
    let offset_u = o + across_u * distance(across_u)?;
    let offset_v = o + across_v * distance(across_v)?;
    let across = (offset_u - point)
        .cross(offset_v - point)
        .normalize_or_zero();
    let normal = if across.dot(view) > 0.0 {
        -across
    } else {
        across
    };
    let lift = 1.0e-3 * (1.0 + 0.01 * point.distance(o));
    Some(SeenSurface {
        point,
        normal,
        lift,
    })
}
