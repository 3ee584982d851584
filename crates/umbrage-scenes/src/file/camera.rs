//! The table `[camera]`.

use super::table::Table;
use crate::{
    SceneError,
    framing::Shot,
    lone_model::{FOV_Y_DEGREES, SIZE},
};
use umbrage_core::glam::{UVec2, Vec3};
use umbrage_core::{Anchor, Camera, Geometry, MAX_SIDE, invalid};

const KEYS: &[&str] = &[
    "eye",
    "target",
    "up",
    "fov_y_degrees",
    "size",
    "near",
    "far",
];

pub(super) fn read(
    table: &Table<'_>,
    geometry: &Geometry,
    anchor: Anchor,
) -> Result<Camera, SceneError> {
    table.only(KEYS)?;
    let eye = table.position("eye", anchor)?;
    let target = table.need("target", "[x, y, z]")?;
    let shot = Shot {
        eye,
        target: target.position(anchor)?,
        up: table
            .get("up")
            .map_or(Ok(Vec3::Y), |item| item.direction())?,
        fov_y: field_of_view(table)?.to_radians(),
        size: size(table)?,
    };
    target.require(
        shot.eye != shot.target,
        "equals `eye`",
        "move one of the two",
    )?;
    let plane = |key| {
        table
            .get(key)
            .map(|item| item.read_checked_number(invalid::positive))
            .transpose()
    };
    let near_far = [plane("near")?, plane("far")?];
    if let ([Some(near), Some(far)], Some(item)) = (near_far, table.get("far")) {
        item.require(
            near < far,
            &format!("is {far}, and near is {near}"),
            "make near the smaller",
        )?;
    }
    table.check(shot.camera(geometry, near_far))
}

fn field_of_view(table: &Table<'_>) -> Result<f32, SceneError> {
    let Some(item) = table.get("fov_y_degrees") else {
        return Ok(FOV_Y_DEGREES);
    };
    let degrees = item.read_checked_number(invalid::positive)?;
    item.require(
        degrees < 180.0,
        &format!("is {degrees}"),
        "use more than 0 and less than 180",
    )?;
    Ok(degrees)
}

fn size(table: &Table<'_>) -> Result<UVec2, SceneError> {
    let Some(item) = table.get("size") else {
        return Ok(SIZE);
    };
    let sides: Vec<u32> = item
        .list(2, "[width, height]")?
        .iter()
        .map(|side| side.whole(1..=MAX_SIDE))
        .collect::<Result<_, _>>()?;
    Ok(UVec2::from_slice(&sides))
}
