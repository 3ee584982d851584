//! The look of an `[[object]]`.

use super::table::{Item, Table};
use crate::{
    SceneError,
    detail::{Meaning, TextureFiles, USUAL_CUTOFF, kinds_of_pictures, picture_format},
};
use std::path::Path;
use umbrage_core::glam::Vec3;
use umbrage_core::{
    AlphaCutout, AlphaFilter, Displacement, MAX_SHININESS_LOG2, MAX_SUBDIVISIONS, Material, Scene,
    invalid,
};

const ALPHA_FILTER: &str = "alpha_filter";

/// The keys of looks, among the other keys of an object.
pub(super) const KEYS: [&str; 12] = [
    "color",
    "texture",
    "alpha_map",
    "alpha_cutoff",
    ALPHA_FILTER,
    "normal_map",
    "height_map",
    "displacement",
    "subdivisions",
    "shininess",
    "specular",
    "emissive",
];

/// A material, and its requirements for the mesh.
#[derive(Clone, Debug)]
pub(super) struct LookTable<'a> {
    pub(super) material: Material,
    /// The first key that needs texture coordinates.
    pub(super) textured: Option<Item<'a>>,
}

/// Reads a look. Returns `None` for an object without the keys, or with `alpha_filter` alone, which
/// applies to the looks of its model.
pub(super) fn read<'a>(
    table: &Table<'a>,
    folder: &Path,
    files: &mut TextureFiles<'_>,
    scene: &mut Scene,
) -> Result<Option<LookTable<'a>>, SceneError> {
    if KEYS.iter().all(|key| table.get(key).is_none()) || filter_of_model(table)?.is_some() {
        return Ok(None);
    }
    // Read the textures.
    let mut texture = |key: &str, meaning| -> Result<Option<usize>, SceneError> {
        let Some(item) = table.get(key) else {
            return Ok(None);
        };
        let path = folder.join(item.text()?);
        item.require(
            picture_format(&path).is_some(),
            &format!(
                "is `{}`, not a {} file",
                path.display(),
                kinds_of_pictures()
            ),
            "name an image of this kind",
        )?;
        let named = |fault| SceneError::Named {
            place: item.place(),
            fault: Box::new(fault),
        };
        files
            .index(&path, meaning, &mut scene.textures)
            .map_err(named)
    };
    let diffuse_texture = texture("texture", Meaning::Color)?;
    let normal_map = texture("normal_map", Meaning::Normals)?;
    let height_map = texture("height_map", Meaning::Heights)?;
    let alpha_map = texture("alpha_map", Meaning::Alpha)?;
    // Build the material from the other keys and the defaults.
    let plain = Material {
        diffuse_texture,
        normal_map,
        ..Material::default()
    };
    let material = Material {
        diffuse: color(table, "color")?.unwrap_or(if table.get("texture").is_some() {
            Vec3::ONE
        } else {
            plain.diffuse
        }),
        specular: specular(table)?.unwrap_or(plain.specular),
        shininess_log2: shininess(table)?.unwrap_or(plain.shininess_log2),
        emissive: emissive(table)?,
        displacement: displacement(table, height_map)?,
        alpha: alpha(table, alpha_map)?,
        ..plain
    };
    let textured = ["texture", "normal_map", "height_map", "alpha_map"]
        .iter()
        .find_map(|key| table.get(key));
    Ok(Some(LookTable { material, textured }))
}

/// Returns the filter that an object sets for the alpha tests of its model, with its item. Returns
/// `None` without the key, and for an object with its own look, to which the key then belongs.
pub(super) fn filter_of_model<'a>(
    table: &Table<'a>,
) -> Result<Option<(AlphaFilter, Item<'a>)>, SceneError> {
    let others = KEYS.iter().filter(|&&key| key != ALPHA_FILTER);
    if table.get("mesh").is_none() || others.into_iter().any(|key| table.get(key).is_some()) {
        return Ok(None);
    }
    let Some(item) = table.get(ALPHA_FILTER) else {
        return Ok(None);
    };
    Ok(Some((alpha_filter(&item)?, item)))
}

fn alpha_filter(item: &Item<'_>) -> Result<AlphaFilter, SceneError> {
    Ok(match item.word(&["nearest", "hashed"])? {
        "hashed" => AlphaFilter::Hashed,
        _ => AlphaFilter::Nearest,
    })
}

fn alpha(table: &Table<'_>, alpha_map: Option<usize>) -> Result<Option<AlphaCutout>, SceneError> {
    let items = ["alpha_cutoff", ALPHA_FILTER].map(|key| table.get(key));
    let Some(texture) = alpha_map else {
        return match items.iter().flatten().next() {
            None => Ok(None),
            Some(item) => Err(item.fault(
                "has no effect without `alpha_map`",
                "add alpha_map = \"leaf.png\"",
            )),
        };
    };
    let [cutoff, filter] = items;
    let cutoff = match cutoff {
        None => USUAL_CUTOFF,
        Some(item) => {
            let cutoff = item.number()?;
            let fits = (0.0..=1.0).contains(&cutoff);
            item.require(fits, &format!("is {cutoff}"), "use 0 to 1")?;
            cutoff
        }
    };
    let filter = match filter {
        None => AlphaFilter::Nearest,
        Some(item) => alpha_filter(&item)?,
    };
    Ok(Some(AlphaCutout {
        texture,
        cutoff,
        filter,
    }))
}

fn displacement(
    table: &Table<'_>,
    height_map: Option<usize>,
) -> Result<Option<Displacement>, SceneError> {
    let items = ["height_map", "displacement", "subdivisions"].map(|key| table.get(key));
    match (height_map, items) {
        (None, [_, None, None]) => Ok(None),
        (None, [_, Some(item), _] | [_, _, Some(item)]) => Err(item.fault(
            "has no effect without `height_map`",
            "add height_map = \"heights.png\"",
        )),
        (Some(texture), [_, Some(metres), subdivisions]) => {
            let subdivisions =
                subdivisions.map_or(Ok(0), |item| item.whole(0..=MAX_SUBDIVISIONS))?;
            Ok(Some(Displacement {
                texture,
                lambda: metres.number()?,
                subdivisions,
            }))
        }
        (Some(_), _) => {
            table.need("displacement", "0.05")?;
            Ok(None)
        }
    }
}

/// Reads a linear colour, 0 to 1.
fn color(table: &Table<'_>, key: &str) -> Result<Option<Vec3>, SceneError> {
    let Some(item) = table.get(key) else {
        return Ok(None);
    };
    let color = item.vec3()?;
    let fits = color.to_array().iter().all(|v| (0.0..=1.0).contains(v));
    item.require(
        fits,
        &format!("is {color}"),
        "use numbers from 0 to 1 (linear, not sRGB)",
    )?;
    Ok(Some(color))
}

/// Reads one number for all channels, or one for each.
fn specular(table: &Table<'_>) -> Result<Option<Vec3>, SceneError> {
    let Some(item) = table.get("specular").filter(|item| !item.value.is_array()) else {
        return color(table, "specular");
    };
    let number = item.number()?;
    item.require(
        (0.0..=1.0).contains(&number),
        &format!("is {number}"),
        "use 0 to 1",
    )?;
    Ok(Some(Vec3::splat(number)))
}

fn emissive(table: &Table<'_>) -> Result<Vec3, SceneError> {
    let Some(item) = table.get("emissive") else {
        return Ok(Vec3::ZERO);
    };
    let color = item.vec3()?;
    color
        .to_array()
        .into_iter()
        .try_for_each(|v| item.check(invalid::not_negative("", v)))?;
    Ok(color)
}

/// Reads a power of two, and returns its exponent.
fn shininess(table: &Table<'_>) -> Result<Option<u32>, SceneError> {
    let Some(item) = table.get("shininess") else {
        return Ok(None);
    };
    let most = 1 << MAX_SHININESS_LOG2;
    let power = item.whole(0..=most)?;
    let help = format!("use a power of two: 1, 2, 4, 8 and so on to {most}");
    item.require(power.is_power_of_two(), &format!("is {power}"), &help)?;
    Ok(Some(power.trailing_zeros()))
}

#[cfg(test)]
#[path = "look_tests.rs"]
mod tests;
