//! Selection of the casters that matter on fitted maps.

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

/// Returns the ids of the casters that can change the result of a lookup: those that are before a
/// visible receiver, within reach. If visible receivers are unknown, all receiving triangles count.
/// The other casters may be omitted from the maps in `spaces` without changing any result.
/// [`Fit::Tight`](super::Fit::Tight) covers these casters.
///
/// `size` is the side of the maps in texels. `margin` is the reach of a kernel, in texels, beyond
/// the texel that contains the receiver; the radius of blocker searches is added to it. Biases may
/// move receivers away from the light by 1/64 of the map's depth range, and along their plane by a
/// tenth of the range per texel. Polygon offsets must not be negative, as the casters' depths are
/// used without them.
///
/// The ids are rising and unique; empty if the view has no triangles.
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
    let map = MapSpace::of_light_space(space);
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

/// Returns the bounds of a map, in map space.
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
    MapBounds::from_points([corner(-1.0, -1.0, 0.0), corner(1.0, 1.0, 1.0)])
}
