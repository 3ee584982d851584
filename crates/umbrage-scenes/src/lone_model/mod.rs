//! Completion of a lone model for its first image: a floor, a camera and a sun.
//!
//! * A model without ground receives a floor ([`ground`]). Its view is a three-quarter view from
//!   slightly above, as close as the model and its shadow permit.
//! * A model with its own ground has the same view, without a floor. Small objects on wide ground
//!   fill the view with their shadows. A room that is open to one side is seen through its opening.
//! * A building around its own floor is seen from inside ([`interior`]): from the position with the
//!   greatest depth that the fronts of surfaces surround, also if the building is furnished.
//! * The sun is on the left, above and behind the model, so that shadows fall to the right and
//!   towards the eye. Without an added floor, another sun may show more ([`sun`]).

mod ground;
mod interior;
mod sun;

use crate::{
    SceneError,
    error::Place,
    framing::{Shot, best_side, frame_from, opening_side},
    looks::{PALETTE, matte},
};
use umbrage_core::glam::{Affine3A, DVec3, UVec2, Vec3};
use umbrage_core::{Geometry, Instance, Light, Scene};

/// Image size for a model without a camera.
pub(crate) const SIZE: UVec2 = UVec2::new(640, 360);
/// Full vertical angle for a model without a camera, degrees.
pub(crate) const FOV_Y_DEGREES: f32 = 36.0;
/// Angular diameter of the sun, degrees.
const SUN_DEGREES: f32 = 0.53;
/// Valid range of sizes for 32-bit geometry, metres. Areas are squared when normals are normalised.
pub(crate) const SIZES: [f32; 2] = [1e-6, 1e8];

/// Adds a floor, a camera and a sun to the scene of a lone model with the triangles `geometry`.
///
/// # Errors
/// Returns an error if the model is too small or too large.
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
    let ground = ground::Ground::of_geometry(geometry);
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
        // Nothing is below the floor. Maps that are fitted around all casters keep their resolution
        // for the model.
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

/// Adds the missing parts to a scene of a model's file with the triangles `geometry`. A scene with
/// neither a camera nor a light is completed like a lone model. Otherwise the missing one is added,
/// without a floor, since the scene was arranged by its author.
///
/// # Errors
/// Returns an error if the model is too small or too large.
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
            let ground = ground::Ground::of_geometry(geometry);
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
            let shot = Shot::of_camera(camera);
            let usual = sun::from_left(&shot);
            scene
                .lights
                .push(sunlight(sun::that_shows_most(geometry, &shot, usual)));
        }
        (Some(_), false) => {}
    }
    Ok(())
}

/// Returns the sun with this direction of light.
fn sunlight(direction: Vec3) -> Light {
    Light::Directional {
        direction,
        angular_diameter: SUN_DEGREES.to_radians(),
    }
}

/// Returns the closest shot of a model from outside that contains all of it, and its shadow on an
/// added floor. Of small objects on wide ground, it contains the objects and their shadows.
fn of_model(geometry: &Geometry, ground: &ground::Ground) -> Option<Shot> {
    let points = geometry.positions().iter().copied();
    let side = best_side(geometry);
    let Some(own) = ground.own else {
        let height = ground.floor_height(geometry.bounds())?;
        return with_shadows(side, points, height);
    };
    let objects = ground.objects_on_it(geometry);
    if !objects.is_empty() {
        return with_shadows(side, objects.iter().copied(), own);
    }
    let side = opening_side(geometry).unwrap_or(side);
    frame_from(side, points, FOV_Y_DEGREES.to_radians(), SIZE)
}

/// Returns the closest shot from this side that contains all points, and their shadows on ground of
/// this height.
fn with_shadows(
    side: DVec3,
    points: impl Iterator<Item = Vec3> + Clone,
    height: f32,
) -> Option<Shot> {
    let fov_y = FOV_Y_DEGREES.to_radians();
    // The light only depends on the view's directions, which are those of any shot from this side.
    let light = sun::from_left(&frame_from(side, points.clone(), fov_y, SIZE)?);
    let shadows = points
        .clone()
        .map(move |p| p + light * ((height - p.y) / light.y));
    frame_from(side, points.chain(shadows), fov_y, SIZE)
}

/// Returns an error if the geometry is too small or too large for 32-bit floats.
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

/// Returns the triangle's area vector: along its normal, with twice its area as length.
fn twice_area(corners: [Vec3; 3]) -> Vec3 {
    let [a, b, c] = corners;
    (b - a).cross(c - a)
}

#[cfg(test)]
mod tests;
#[cfg(test)]
mod view_tests;
