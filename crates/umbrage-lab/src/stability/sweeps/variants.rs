//! Copies of a scene at another scale, at another position, or under another sun.

use glam::{Affine3A, Mat4, Vec3, Vec3A};
use umbrage_core::{Light, Scene};

/// Returns the scene with all lengths multiplied.
pub fn scale_scene(scene: &Scene, by: f32) -> Scene {
    let mut out = scene.clone();
    for instance in &mut out.instances {
        instance.world_from_local =
            Affine3A::from_scale(Vec3::splat(by)) * instance.world_from_local;
    }
    for camera in &mut out.cameras {
        camera.world_from_view.translation *= by;
        camera.clip_from_view *= Mat4::from_scale(Vec3::splat(1.0 / by));
    }
    for light in &mut out.lights {
        *light = place_light(light, |position| position * by, by);
    }
    out
}

/// Returns the scene moved by an offset, metres.
pub fn move_scene(scene: &Scene, by: Vec3) -> Scene {
    let mut out = scene.clone();
    for instance in &mut out.instances {
        instance.world_from_local.translation += Vec3A::from(by);
    }
    for camera in &mut out.cameras {
        camera.world_from_view.translation += Vec3A::from(by);
    }
    for light in &mut out.lights {
        *light = place_light(light, |position| position + by, 1.0);
    }
    out
}

/// Returns a light whose position is mapped by `place` and whose extent is multiplied.
fn place_light(light: &Light, place: impl Fn(Vec3) -> Vec3, by: f32) -> Light {
    match *light {
        directional @ Light::Directional { .. } => directional,
        Light::Point { position, radius } => Light::Point {
            position: place(position),
            radius: radius * by,
        },
        Light::Spot {
            position,
            direction,
            inner,
            outer,
            radius,
        } => Light::Spot {
            position: place(position),
            direction,
            inner,
            outer,
            radius: radius * by,
        },
        Light::Rect {
            center,
            half_u,
            half_v,
        } => Light::Rect {
            center: place(center),
            half_u: half_u * by,
            half_v: half_v * by,
        },
        Light::Disc {
            center,
            normal,
            radius,
        } => Light::Disc {
            center: place(center),
            normal,
            radius: radius * by,
        },
    }
}

/// Returns the scene with its first light replaced by an ideal sun (no extent) this many degrees
/// above the horizon, from the same azimuth as the sun of the scene `low-sun-5`.
pub fn under_sun(scene: &Scene, degrees: f64) -> Scene {
    let elevation = degrees.to_radians();
    let horizontal = elevation.cos().max(0.0);
    // (0.3, -0.954) is that azimuth as a unit vector of (x, z).
    let direction = Vec3::new(
        (0.3 * horizontal) as f32,
        -elevation.sin() as f32,
        (-0.954 * horizontal) as f32,
    );
    let mut out = scene.clone();
    if let Some(light) = out.lights.first_mut() {
        *light = Light::Directional {
            direction,
            angular_diameter: 0.0,
        };
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage_core::{Camera, Geometry};
    use umbrage_cpu::Cpu;

    /// Returns the triangle at each pixel of the scene's first camera.
    fn visible_triangles(scene: &Scene) -> Vec<u32> {
        let camera: Camera = scene.cameras[0].with_size(glam::UVec2::new(80, 60));
        let geometry = Geometry::bake(scene).expect("valid");
        let receivers = Cpu::new().receivers(&camera, &geometry).expect("valid");
        receivers.triangle
    }

    #[test]
    fn scaled_and_moved_scenes_are_seen_alike() {
        let scene = (umbrage_scenes::find("cubes").expect("built in").build)();
        let plain = visible_triangles(&scene);
        for other in [
            scale_scene(&scene, 1e-3),
            scale_scene(&scene, 1e4),
            move_scene(&scene, Vec3::new(100.0, 0.0, -50.0)),
        ] {
            let differing = visible_triangles(&other)
                .iter()
                .zip(&plain)
                .filter(|(a, b)| a != b)
                .count();
            // Only pixels on outlines may differ, by rounding.
            assert!(
                differing * 200 < plain.len(),
                "{differing} of {}",
                plain.len()
            );
        }
    }
}
