//! Lights of the extension `KHR_lights_punctual`, and their sizes.

use super::{document::element_name, nodes::PlacedNode};
use gltf::{
    json::Extras,
    khr_lights_punctual::{Kind, Light as FileLight},
};
use umbrage_core::glam::DVec3;
use umbrage_core::{Invalid, Light, invalid};

/// Names of the radius of a light, metres: Blender's own, and the usual one.
const RADIUS: [&str; 2] = ["shadow_soft_size", "radius"];
/// Name of the angular diameter of a sun, radians: Blender's.
const ANGLE: [&str; 1] = ["angle"];
/// Greatest half angle of a cone here, degrees. The format has cones of up to 90.
const WIDEST: f32 = 89.9;

/// Returns the light of a node. `None` if it is off: black, or of no intensity.
pub(super) fn light(
    light: &FileLight<'_>,
    node: &PlacedNode<'_>,
) -> Result<Option<Light>, Invalid> {
    make_light(light, node)
        .map_err(|e| e.within_context(element_name("light", light.index(), light.name())))
}

fn make_light(file: &FileLight<'_>, node: &PlacedNode<'_>) -> Result<Option<Light>, Invalid> {
    invalid::not_negative("intensity", file.intensity())?;
    for channel in file.color() {
        invalid::not_negative("color", channel)?;
    }
    if let Some(range) = file.range() {
        invalid::positive("range", range)?;
    }
    if file.intensity() == 0.0 || file.color() == [0.0; 3] {
        return Ok(None);
    }
    let extras = [file.extras(), node.node.extras()];
    let light = match file.kind() {
        Kind::Directional => Light::Directional {
            direction: node.direction(DVec3::NEG_Z)?,
            angular_diameter: size(extras, &ANGLE)?,
        },
        Kind::Point => Light::Point {
            position: node.position()?,
            radius: size(extras, &RADIUS)?,
        },
        Kind::Spot {
            inner_cone_angle,
            outer_cone_angle,
        } => Light::Spot {
            position: node.position()?,
            direction: node.direction(DVec3::NEG_Z)?,
            inner: cone("innerConeAngle", inner_cone_angle)?,
            outer: cone("outerConeAngle", outer_cone_angle)?,
            radius: size(extras, &RADIUS)?,
        },
    };
    light.validate()?;
    Ok(Some(light))
}

/// Returns half of a cone, radians, at most the widest one that can have shadows.
fn cone(what: &str, angle: f32) -> Result<f32, Invalid> {
    invalid::not_negative(what, angle)?;
    if angle > std::f32::consts::FRAC_PI_2 {
        return Err(Invalid::new(
            what,
            format!("is {angle}"),
            "use 0 to pi/2 radians",
        ));
    }
    Ok(angle.min(WIDEST.to_radians()))
}

/// Returns a light's size from the first of these names in the extras of the light, or else of its
/// node; 0 without any.
///
/// The format has no sizes of lights. Blender writes an object's custom properties into its node's
/// `extras`, and those of its data into the light's, but not the radius, which needs a custom
/// property.
fn size(extras: [&Extras; 2], names: &[&str]) -> Result<f32, Invalid> {
    for extras in extras.into_iter().flatten() {
        // Extras may be anything. Ignore everything but lists of names.
        let Ok(value) = serde_json::from_str::<serde_json::Value>(extras.get()) else {
            continue;
        };
        for name in names {
            if let Some(number) = value.get(name).and_then(serde_json::Value::as_f64) {
                invalid::not_negative(&format!("`{name}` in extras"), number as f32)?;
                return Ok(number as f32);
            }
        }
    }
    Ok(0.0)
}
