//! Lights inside a closed object, such as a lamp in its own bulb.

use glam::Vec3;
use umbrage_core::{Geometry, Invalid, Light, Scene};

/// Number of directions in which the object must block the light.
const DIRECTIONS: u32 = 64;

/// Index that excludes no triangle from a ray query.
const NONE: u32 = u32::MAX;

/// Returns a sentence about the object that encloses a scene's first light. `None` if no single
/// object does.
///
/// Bakes each object alone, so call it only if nothing is lit. A room also encloses its lamps, but
/// lights what is in it.
pub(super) fn enclosed_light(scene: &Scene) -> Result<Option<String>, Invalid> {
    let Some(centre) = scene.lights.first().and_then(centre) else {
        return Ok(None);
    };
    for (i, instance) in scene.instances.iter().enumerate() {
        if !instance.casts {
            continue;
        }
        let mut alone = *instance;
        alone.mesh = 0;
        alone.material = None;
        let geometry = Geometry::bake(&Scene {
            meshes: vec![scene.meshes[instance.mesh].clone()],
            instances: vec![alone],
            ..Scene::default()
        })?;
        if encloses(&geometry, centre) {
            let number = i + 1;
            return Ok(Some(format!(
                "light 1 is enclosed by object {number}, so nothing is lit: \
                 let the object cast no shadow, or move the light"
            )));
        }
    }
    Ok(None)
}

/// Returns the centre of a light. `None` for suns.
fn centre(light: &Light) -> Option<Vec3> {
    match *light {
        Light::Directional { .. } => None,
        Light::Spot { position, .. } | Light::Point { position, .. } => Some(position),
        Light::Rect { center, .. } | Light::Disc { center, .. } => Some(center),
    }
}

/// Reports whether the geometry blocks rays from a point in all directions.
fn encloses(geometry: &Geometry, point: Vec3) -> bool {
    let bounds = geometry.bounds();
    let is_within = point.cmpgt(bounds.min).all() && point.cmplt(bounds.max).all();
    is_within
        && (0..DIRECTIONS).all(|i| {
            // Distribute the directions evenly: points of a Fibonacci spiral.
            let y = 1.0 - 2.0 * (i as f32 + 0.5) / DIRECTIONS as f32;
            let angle = i as f32 * std::f32::consts::PI * (3.0 - 5.0_f32.sqrt());
            let radius = (1.0 - y * y).sqrt();
            let way = Vec3::new(radius * angle.cos(), y, radius * angle.sin());
            let way = way * (2.0 * bounds.diagonal());
            geometry.bvh().is_occluded(point, way, NONE)
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a scene of a lamp, a plane, and a second object with these keys.
    fn scene(light: &str, object: &str) -> Scene {
        let text = format!(
            "[camera]\neye = [3, 2.5, 4]\ntarget = [0, 0.5, 0]\nfov_y_degrees = 40\n\
             [[light]]\n{light}\n\
             [[object]]\nshape = \"plane\"\nscale = [8, 1, 8]\n\
             [[object]]\n{object}\n"
        );
        umbrage_scenes::parse(&text, "scene.toml", ".").unwrap()
    }

    #[test]
    fn lamps_in_closed_objects_are_reported() {
        let lamp = "kind = \"point\"\nposition = [0, 1.5, 0]\nradius = 0.05";
        let bulb = "shape = \"sphere\"\nscale = 0.15\ntranslate = [0, 1.5, 0]";
        let found = |light: &str, object: &str| enclosed_light(&scene(light, object)).unwrap();
        let line = found(lamp, bulb).unwrap();
        assert!(
            line.starts_with("light 1 is enclosed by object 2,"),
            "{line}"
        );
        let boxed = bulb.replace("sphere", "box");
        assert!(found(lamp, &boxed).is_some());
        let off_center = bulb.replace("[0, 1.5, 0]", "[0.4, 1.5, 0]");
        assert_eq!(found(lamp, &off_center), None);
        assert_eq!(found(lamp, &format!("{bulb}\ncasts = false")), None);
        assert_eq!(
            found("kind = \"directional\"\ndirection = [0, -1, 0]", bulb),
            None
        );
        let mut open = scene(lamp, bulb);
        // One eighth of the sphere is missing.
        let sphere = open.instances[1].mesh;
        let positions = open.meshes[sphere].positions.clone();
        open.meshes[sphere].triangles.retain(|t| {
            !t.iter()
                .all(|&v| positions[v as usize].min_element() >= 0.0)
        });
        assert_eq!(enclosed_light(&open).unwrap(), None);
    }
}
