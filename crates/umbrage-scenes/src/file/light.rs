//! The table `[[light]]`.

use super::table::{Item, Table};
use crate::SceneError;
use umbrage_core::{Anchor, Light, invalid};

const KINDS: &[&str] = &["directional", "point", "spot", "rect", "disc"];

pub(super) fn read(table: &Table<'_>, anchor: Anchor) -> Result<Light, SceneError> {
    let light = match table.need("kind", "\"directional\"")?.word(KINDS)? {
        "directional" => directional(table),
        "point" => point(table, anchor),
        "spot" => spot(table, anchor),
        "rect" => rect(table, anchor),
        _ => disc(table, anchor),
    }?;
    table.check(light.validate())?;
    Ok(light)
}

fn directional(table: &Table<'_>) -> Result<Light, SceneError> {
    table.only(&["kind", "direction", "angular_diameter_degrees"])?;
    let angular_diameter = match table.get("angular_diameter_degrees") {
        Some(item) => angle(&item, 180.0)?,
        None => 0.0,
    };
    Ok(Light::Directional {
        direction: table.direction("direction")?,
        angular_diameter,
    })
}

fn point(table: &Table<'_>, anchor: Anchor) -> Result<Light, SceneError> {
    table.only(&["kind", "position", "radius"])?;
    Ok(Light::Point {
        position: table.position("position", anchor)?,
        radius: table.size_or_zero("radius")?,
    })
}

fn spot(table: &Table<'_>, anchor: Anchor) -> Result<Light, SceneError> {
    table.only(&[
        "kind",
        "position",
        "direction",
        "inner_degrees",
        "outer_degrees",
        "radius",
    ])?;
    let position = table.position("position", anchor)?;
    let direction = table.direction("direction")?;
    let outer_item = table.need("outer_degrees", "30")?;
    let outer = angle(&outer_item, 90.0)?;
    outer_item.check(invalid::positive("", outer))?;
    let inner = match table.get("inner_degrees") {
        Some(item) => {
            let inner = angle(&item, 90.0)?;
            item.require(
                inner <= outer,
                "is wider than outer_degrees",
                "make it the smaller",
            )?;
            inner
        }
        None => outer,
    };
    Ok(Light::Spot {
        position,
        direction,
        inner,
        outer,
        radius: table.size_or_zero("radius")?,
    })
}

fn rect(table: &Table<'_>, anchor: Anchor) -> Result<Light, SceneError> {
    table.only(&["kind", "center", "half_u", "half_v"])?;
    let half_u = table.direction("half_u")?;
    let half_v = table.direction("half_v")?;
    Ok(Light::Rect {
        center: table.position("center", anchor)?,
        half_u,
        half_v,
    })
}

fn disc(table: &Table<'_>, anchor: Anchor) -> Result<Light, SceneError> {
    table.only(&["kind", "center", "normal", "radius"])?;
    let radius = table
        .need("radius", "0.5")?
        .read_checked_number(invalid::positive)?;
    Ok(Light::Disc {
        center: table.position("center", anchor)?,
        normal: table.direction("normal")?,
        radius,
    })
}

/// Reads degrees from 0 to less than `below`, and returns radians.
fn angle(item: &Item<'_>, below: f32) -> Result<f32, SceneError> {
    let degrees = item.read_checked_number(invalid::not_negative)?;
    item.require(
        degrees < below,
        &format!("is {degrees}"),
        &format!("use 0 to less than {below}"),
    )?;
    Ok(degrees.to_radians())
}
