//! Scenes at another scale, elsewhere, under another sun.

use glam::{Affine3A, Mat4, Vec3, Vec3A};
use umbrage_core::{Light, Scene};

/// The scene with all lengths multiplied.
pub fn scaled(scene: &Scene, by: f32) -> Scene {
    let mut out = scene.clone();
    for instance in &mut out.instances {
        instance.world_from_local =
            Affine3A::from_scale(Vec3::splat(by)) * instance.world_from_local;
    }
    for camera in &mut out.cameras {
        camera.world_from_view.translation *= by;
        camera.clip_from_view *= Mat4::from_scale(Vec3::splat(1.0 / by));
    }
    out.lights
        .iter_mut()
        .for_each(|light| *light = placed(light, |p| p * by, by));
    out
}

/// The scene moved by an offset.
pub fn moved(scene: &Scene, by: Vec3) -> Scene {
    let mut out = scene.clone();
    for instance in &mut out.instances {
        instance.world_from_local.translation += Vec3A::from(by);
    }
    for camera in &mut out.cameras {
        camera.world_from_view.translation += Vec3A::from(by);
    }
    out.lights
        .iter_mut()
        .for_each(|light| *light = placed(light, |p| p + by, 1.0));
    out
}

/// A light whose place is mapped and whose extent is multiplied.
fn placed(light: &Light, place: impl Fn(Vec3) -> Vec3, by: f32) -> Light {
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

/// The scene with its first light an ideal sun this many degrees above the horizon, from the azimuth of `low-sun-5`'s.
pub fn under_sun(scene: &Scene, degrees: f64) -> Scene {
    let height = degrees.to_radians();
    let across = height.cos().max(0.0);
    let direction = Vec3::new(
        (0.3 * across) as f32,
        -height.sin() as f32,
        (-0.954 * across) as f32,
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

    #[test]
    fn scaled_and_moved_scenes_are_seen_alike() {
        let scene = (umbrage_scenes::find("cubes").expect("built in").build)();
        let see = |scene: &Scene| {
            let camera: Camera = scene.cameras[0].resized(glam::UVec2::new(80, 60));
            let geometry = Geometry::bake(scene).expect("valid");
            Cpu::new()
                .receivers(&camera, &geometry)
                .expect("valid")
                .triangle
        };
        let plain = see(&scene);
        for other in [
            scaled(&scene, 1e-3),
            scaled(&scene, 1e4),
            moved(&scene, Vec3::new(100.0, 0.0, -50.0)),
        ] {
            let differing = see(&other)
                .iter()
                .zip(&plain)
                .filter(|(a, b)| a != b)
                .count();
            // Pixels on outlines alone may round otherwise.
            assert!(
                differing * 200 < plain.len(),
                "{differing} of {}",
                plain.len()
            );
        }
    }
}
