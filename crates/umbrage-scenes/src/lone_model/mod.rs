//! What a model alone needs to make a good first picture: a floor, a camera and a sun.
//!
//! * A model that brings no ground of its own gets a floor under it ([`ground`]). It is seen from a
//!   three-quarter view from slightly above, from as near as shows all of it and of its shadow.
//! * A model with ground of its own is seen from there, too, without a floor; a room that is open
//!   to one side through its opening.
//! * A building around its own floor is seen from inside ([`interior`]): from where the view is
//!   deepest.
//! * The sun comes from the left, from above and from behind the model, so that shadows fall to the
//!   right and towards the eye. Without a floor of ours another one may show more ([`sun`]).

mod ground;
mod interior;
mod sun;

use crate::{
    SceneError,
    error::Place,
    framing::{Shot, best_side, frame_from, opening_side},
    looks::{PALETTE, matte},
};
use umbrage_core::glam::{Affine3A, UVec2, Vec3};
use umbrage_core::{Geometry, Instance, Light, Scene};

/// The picture of a model without a camera.
pub(crate) const SIZE: UVec2 = UVec2::new(640, 360);
/// Its full vertical angle, degrees.
pub(crate) const FOV_Y_DEGREES: f32 = 36.0;
/// The sun's width in the sky, degrees.
const SUN_DEGREES: f32 = 0.53;
/// Sizes in metres between which 32-bit geometry works: areas are squared on the way to unit
/// normals.
pub(crate) const SIZES: [f32; 2] = [1e-6, 1e8];

/// Adds floor, camera and sun to a scene that holds a model alone, whose triangles are `geometry`.
///
/// # Errors
/// Errors if the model is too small or too large.
pub(crate) fn complete(
    scene: &mut Scene,
    geometry: &Geometry,
    place: &Place,
) -> Result<(), SceneError> {
    let invalid = |fault| SceneError::Invalid {
        file: place.file.clone(),
        fault,
    };
    check_size(geometry, place)?;
    let ground = ground::Ground::of(geometry);
    let inside = interior::shot(geometry, &ground, SIZE);
    let outside = || of_model(geometry, &ground);
    let shot = inside
        .or_else(outside)
        .ok_or_else(|| too(geometry, place))?;
    let mut direction = sun::from_left(&shot);
    if let Some(floor) = ground.floor(geometry.bounds()) {
        let material = scene.materials.len();
        scene.materials.push(matte(PALETTE[0]).material);
        let mut instance = Instance::new(scene.meshes.len(), Affine3A::IDENTITY);
        instance.material = Some(material);
        // Nothing lies below it; and maps fitted around all casters stay as fine as the model asks
        // for.
        instance.casts = false;
        scene.meshes.push(floor);
        scene.instances.push(instance);
    } else {
        direction = sun::that_shows_most(geometry, &shot, direction);
    }
    let whole = Geometry::bake(scene).map_err(invalid)?;
    let camera = shot.camera(&whole, [None, None]).map_err(invalid)?;
    scene.cameras.push(camera);
    scene.lights.push(sunlight(direction));
    Ok(())
}

/// Adds what a scene of a model's file lacks, whose triangles are `geometry`: all that a model
/// alone gets if it has neither a camera nor a light; else the one of these that is missing, and no
/// floor, since somebody arranged the scene.
///
/// # Errors
/// Errors if the model is too small or too large.
#[cfg(feature = "gltf")]
pub(crate) fn add_missing(
    scene: &mut Scene,
    geometry: &Geometry,
    place: &Place,
) -> Result<(), SceneError> {
    check_size(geometry, place)?;
    match (scene.cameras.first(), scene.lights.is_empty()) {
        (None, true) => complete(scene, geometry, place)?,
        (None, false) => {
            let ground = ground::Ground::of(geometry);
            let shot = interior::shot(geometry, &ground, SIZE)
                .or_else(|| of_model(geometry, &ground))
                .ok_or_else(|| too(geometry, place))?;
            let camera = shot.camera(geometry, [None, None]);
            scene
                .cameras
                .push(camera.map_err(|fault| SceneError::Invalid {
                    file: place.file.clone(),
                    fault,
                })?);
        }
        (Some(camera), true) => {
            let shot = Shot::of(camera);
            let usual = sun::from_left(&shot);
            scene
                .lights
                .push(sunlight(sun::that_shows_most(geometry, &shot, usual)));
        }
        (Some(_), false) => {}
    }
    Ok(())
}

/// Returns the sun whose light travels this way.
fn sunlight(direction: Vec3) -> Light {
    Light::Directional {
        direction,
        angular_diameter: SUN_DEGREES.to_radians(),
    }
}

/// Returns the shot of a model from outside, from as near as shows all of it and of its shadow on a
/// floor of ours.
fn of_model(geometry: &Geometry, ground: &ground::Ground) -> Option<Shot> {
    let side = if ground.own.is_some() {
        opening_side(geometry).unwrap_or_else(|| best_side(geometry))
    } else {
        best_side(geometry)
    };
    let fov_y = FOV_Y_DEGREES.to_radians();
    let points = geometry.positions().iter().copied();
    let shot = frame_from(side, points.clone(), fov_y, SIZE)?;
    let Some(height) = ground.floor_height(geometry.bounds()) else {
        return Some(shot);
    };
    // The light's way depends on the view's directions alone, which stay.
    let light = sun::from_left(&shot);
    let shadows = points
        .clone()
        .map(move |p| p + light * ((height - p.y) / light.y));
    frame_from(side, points.chain(shadows), fov_y, SIZE)
}

/// Errors if the geometry is too small or too large for 32-bit floats.
pub(crate) fn check_size(geometry: &Geometry, place: &Place) -> Result<(), SceneError> {
    let extent = geometry.bounds().extent().max_element();
    if (SIZES[0]..=SIZES[1]).contains(&extent) {
        Ok(())
    } else {
        Err(too(geometry, place))
    }
}

/// Returns the error of geometry that is too small or too large.
pub(crate) fn too(geometry: &Geometry, place: &Place) -> SceneError {
    let extent = geometry.bounds().extent().max_element();
    SceneError::Fault {
        place: place.clone(),
        why: format!("is {extent:e} m across"),
        help: format!("scale it to between {:e} and {:e} m", SIZES[0], SIZES[1]),
    }
}

/// Returns the triangle's area as a vector: along its normal, as long as twice its area.
fn twice_area(corners: [Vec3; 3]) -> Vec3 {
    let [a, b, c] = corners;
    (b - a).cross(c - a)
}

#[cfg(test)]
mod tests;
