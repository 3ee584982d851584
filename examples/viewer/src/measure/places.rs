//! Pictures of where lookups go: texels of maps, cascades, lists of casters.

use super::planned_view;
use anyhow::Result;
use std::sync::Arc;
use umbrage::{
    Aabb, Camera, Geometry, Light, Receivers, ShadowTechnique, View,
    plan::footprint::{MapPlace, MapPlaces},
    techniques::{AskedCell, Exact},
};

/// Colours of layers, sRGB: those of Okabe and Ito 2008, "Color universal design", which most people tell apart.
const LAYERS: [[u8; 3]; 8] = [
    [230, 159, 0],
    [86, 180, 233],
    [0, 158, 115],
    [240, 228, 66],
    [0, 114, 178],
    [213, 94, 0],
    [204, 121, 167],
    [150, 150, 150],
];
/// Opacity of what is laid over.
const OPACITY: u8 = 165;
const NOTHING: [u8; 4] = [0; 4];

/// Which picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Places {
    /// Each texel, light and dark in turn, in its layer's colour.
    Texels,
    /// Each layer in a colour of its own.
    Layers,
    /// How many casters a lookup in lists asks.
    Lists,
}

/// What a picture is of.
pub(crate) struct SeenFrom<'a> {
    pub camera: &'a Camera,
    pub light: &'a Light,
    pub geometry: &'a Geometry,
    /// The box around all casters for which a light set plans: a little larger than they are.
    pub casters: Aabb,
    pub receivers: &'a Receivers,
}

impl SeenFrom<'_> {
    /// Returns the view for which a light set plans.
    pub(crate) fn planned_view(&self) -> View<'_> {
        planned_view(self.camera, self.light, self.geometry, self.casters)
    }
}

/// Returns what makes a picture as sRGB and opacity, a byte each; none if the technique has nothing of that kind. It owns what it needs, so
/// that a thread can play it, and errors if the technique refuses the light.
pub(crate) fn job(
    kind: Places,
    technique: Arc<dyn ShadowTechnique>,
    seen: &SeenFrom<'_>,
    receivers: Arc<Receivers>,
) -> impl FnOnce() -> Result<Option<Vec<u8>>> + Send + 'static {
    let (camera, light, casters) = (*seen.camera, *seen.light, seen.casters);
    let geometry = seen.geometry.clone();
    move || {
        let seen = SeenFrom {
            camera: &camera,
            light: &light,
            geometry: &geometry,
            casters,
            receivers: &receivers,
        };
        picture(kind, &*technique, &seen)
    }
}

fn picture(
    kind: Places,
    technique: &dyn ShadowTechnique,
    seen: &SeenFrom<'_>,
) -> Result<Option<Vec<u8>>> {
    let view = seen.planned_view();
    if kind == Places::Lists {
        return lists(technique, &view, seen.receivers);
    }
    let recipe = technique.recipe(&view)?;
    let Some(places) = MapPlaces::new(&recipe) else {
        return Ok(None);
    };
    let texel = |i: usize| {
        if !seen.receivers.receives[i] {
            return NOTHING;
        }
        let place = places.at(seen.receivers.position(i));
        place.map_or(NOTHING, |place| match kind {
            Places::Texels => texel_color(&place),
            _ => layer_color(&place),
        })
    };
    Ok(Some((0..seen.receivers.len()).flat_map(texel).collect()))
}

fn layer_color(place: &MapPlace) -> [u8; 4] {
    let [r, g, b] = LAYERS[place.layer as usize % LAYERS.len()];
    [r, g, b, OPACITY]
}

fn texel_color(place: &MapPlace) -> [u8; 4] {
    let [column, row] = place.texel.to_array().map(|x| x as u32);
    let [r, g, b, a] = layer_color(place);
    if (column + row) % 2 == 0 {
        [r, g, b, a]
    } else {
        [r / 4, g / 4, b / 4, a]
    }
}

fn lists(
    technique: &dyn ShadowTechnique,
    view: &View<'_>,
    receivers: &Receivers,
) -> Result<Option<Vec<u8>>> {
    if technique.name() != Exact::default().name() {
        return Ok(None);
    }
    let with_receivers = (*view).with_receivers(receivers);
    let cells = Exact::default().asked_cells(&with_receivers)?;
    Ok(Some(cells.iter().flat_map(length_color).collect()))
}

/// From blue (none) over white (7) to red (63 casters and more), as the panel's legend says; green where one caster covers the whole cell.
fn length_color(cell: &Option<AskedCell>) -> [u8; 4] {
    let Some(cell) = cell else {
        return NOTHING;
    };
    if cell.is_covered {
        return [0, 130, 80, OPACITY];
    }
    let share = ((cell.length as f32 + 1.0).log2() / 6.0).min(1.0);
    let rising = (255.0 * share).round() as u8;
    let falling = 255 - rising;
    if share < 0.5 {
        [2 * rising.min(127), 2 * rising.min(127), 255, OPACITY]
    } else {
        [255, 2 * falling.min(127), 2 * falling.min(127), OPACITY]
    }
}
