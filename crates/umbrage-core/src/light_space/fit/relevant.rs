//! Which casters matter on maps that are fitted already.

use crate::{
    gbuffer::seen_points::SeenPoints,
    geometry::Geometry,
    light_space::{
        LightSpace,
        fit::{
            cull::{Lookups, Need, Receiving},
            map_space::{MapBounds, MapSpace},
        },
        layers::LightSpaces,
    },
    view::View,
};
use glam::DVec3;

/// Ids of the casters that can change the answer of a lookup: for each receiver that is seen (each
/// triangle that receives, where that is unknown), what lies before it within reach. The others may
/// be left out of the maps that lie in `spaces` without changing any answer. It is what
/// [`Fit::Tight`](super::Fit::Tight) goes around.
///
/// `size` is the maps' side in texels; `margin` is how far, in texels, a kernel reaches beyond the
/// texel that a receiver falls on; searches for blockers, as wide as the light's extent asks for,
/// come on top. Biases may move receivers away from the light by 1/64 of the map's depth range, and
/// along their plane by a tenth a texel; casters' depths are taken as they are, so polygon offsets
/// must not be negative.
///
/// In order, each once; empty where the view has no triangles.
pub fn relevant_casters(view: &View<'_>, spaces: &LightSpaces, size: u32, margin: f32) -> Vec<u32> {
    let Some(geometry) = view.geometry else {
        return Vec::new();
    };
    let mut out: Vec<u32> = Vec::new();
    for (layer, space) in spaces.spaces.iter().enumerate() {
        if !spaces.is_needed(layer) {
            continue;
        }
        out.extend(on_map(view, geometry, space, size, margin));
    }
    out.sort_unstable();
    out.dedup();
    out
}

fn on_map(
    view: &View<'_>,
    geometry: &Geometry,
    space: &LightSpace,
    size: u32,
    margin: f32,
) -> Vec<u32> {
    let map = MapSpace::of(space);
    let column = column(space, &map);
    let side = (column.max - column.min).truncate();
    let world = geometry.bounds();
    let world = f64::from(world.min.abs().max(world.max.abs()).max_element());
    let seen = view.receivers.map(SeenPoints::new);
    let receivers = Receiving::new(seen.as_ref(), geometry, &map, &column);
    let lookups = Lookups {
        texel: side / f64::from(size.max(1)),
        margin: f64::from(margin),
        rounding: world / 2_097_152.0 / map.nearest.unwrap_or(1.0),
        tangent: if map.nearest.is_some() {
            side.max_element() * 0.5
        } else {
            0.0
        },
    };
    let reach = lookups.reach(view.light, column.min.z, column.max.z);
    Need::new(map, geometry, &receivers, &reach).map_or(Vec::new(), |need| need.casters())
}

/// What a map covers, in map space.
fn column(space: &LightSpace, map: &MapSpace) -> MapBounds {
    let view_from_clip = space.clip_from_view.as_dmat4().inverse();
    let corner = |x: f64, y: f64, depth: f64| {
        let p = view_from_clip.project_point3(DVec3::new(x, y, depth));
        let across = if map.nearest.is_some() {
            p.truncate() / -p.z
        } else {
            p.truncate()
        };
        across.extend(map.rank(-p.z))
    };
    MapBounds::around([corner(-1.0, -1.0, 0.0), corner(1.0, 1.0, 1.0)])
}
