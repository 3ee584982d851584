//! Texels of a map projected onto receivers: the mask of a perfect map, and distances from edges in
//! texels.
//!
//! A map stores one value per texel, at its center. In a *perfect map* it is the exact visibility
//! of the point where the light's ray through the center meets the receiver's own plane. Such a map
//! has no acne, no gap and no leak, but its shadow edges run along texels. Its error is the edge
//! aliasing of that size, and so the reference for measures that aliasing bounds.

use glam::{DMat4, DVec2, DVec3, Vec3};
use umbrage_core::{Geometry, Invalid, Light, LightSpace, LightSpaces, Receivers, light_sample};
use umbrage_plan::truth::{PointTruth, ReceiverPoint, TruthOptions, trace_points};

/// Maps of one size in their light spaces.
#[derive(Clone, Debug)]
pub struct MapTexels {
    spaces: Vec<ClipSpace>,
    /// Side of each map, texels.
    size: f64,
}

/// A light space's matrices in 64 bits.
#[derive(Clone, Copy, Debug)]
struct ClipSpace {
    clip_from_world: DMat4,
    world_from_clip: DMat4,
}

impl ClipSpace {
    fn new(space: &LightSpace) -> Self {
        let clip_from_world = space.clip_from_view.as_dmat4() * space.view_from_world.as_dmat4();
        Self {
            clip_from_world,
            world_from_clip: clip_from_world.inverse(),
        }
    }

    /// Reports whether a point is in front of the light and within the map's sides.
    fn shows(&self, position: DVec3) -> bool {
        let clip = self.clip_from_world * position.extend(1.0);
        clip.w > 0.0 && clip.x.abs() <= clip.w && clip.y.abs() <= clip.w
    }
}

/// Greatest sine of the angle between a plane and the light's ray at which the footprint is
/// unusable: a small step on the map is an unbounded one on the plane.
const GRAZING: f64 = 1e-6;

impl MapTexels {
    /// Returns the texels of maps of `size` texels a side in these light spaces.
    pub fn new(spaces: &LightSpaces, size: u32) -> Self {
        Self {
            spaces: spaces.spaces.iter().map(ClipSpace::new).collect(),
            size: f64::from(size),
        }
    }

    /// Returns the point of the plane through `position` whose map coordinates are those of
    /// `position` moved by `to`. Map coordinates are in texels from the top left; points are in
    /// world space, metres. `None` if no map contains the position, or its plane is edge-on.
    pub fn moved_position(
        &self,
        position: Vec3,
        normal: Vec3,
        to: impl Fn(DVec2) -> DVec2,
    ) -> Option<Vec3> {
        let position = position.as_dvec3();
        let normal = normal.as_dvec3();
        let space = self.spaces.iter().find(|space| space.shows(position))?;
        let ndc = space.clip_from_world.project_point3(position);
        let uv = DVec2::new(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y);
        let moved_uv = to(uv * self.size) / self.size;
        let moved_x = 2.0 * moved_uv.x - 1.0;
        let moved_y = 1.0 - 2.0 * moved_uv.y;
        let near = space
            .world_from_clip
            .project_point3(DVec3::new(moved_x, moved_y, 0.0));
        let far = space
            .world_from_clip
            .project_point3(DVec3::new(moved_x, moved_y, 1.0));
        // Intersect the light's ray through the moved coordinates with the plane.
        let ray = far - near;
        let slope = normal.dot(ray);
        let t = normal.dot(position - near) / slope;
        let moved = near + ray * t;
        let has_footprint = slope.abs() > GRAZING * ray.length();
        (has_footprint && moved.is_finite()).then_some(moved.as_vec3())
    }

    /// Returns each receiver moved to another point of its plane, and the traced visibility there.
    ///
    /// `to` moves its map coordinates (as in [`MapTexels::moved_position`]). `keep` may move the point
    /// again, given the receiver's index. `None` if nothing receives or no map contains the
    /// receiver.
    ///
    /// # Errors
    /// Errors if the light is not valid.
    pub fn seen_texels(
        &self,
        geometry: &Geometry,
        light: &Light,
        receivers: &Receivers,
        options: &TruthOptions,
        to: impl Fn(DVec2) -> DVec2,
        keep: impl Fn(usize, Vec3) -> Vec3,
    ) -> Result<Vec<Option<(Vec3, PointTruth)>>, Invalid> {
        let mut places: Vec<(usize, Vec3)> = Vec::new();
        for i in (0..receivers.len()).filter(|&i| receivers.receives[i]) {
            if let Some(moved) =
                self.moved_position(receivers.position(i), receivers.normal(i), &to)
            {
                places.push((i, keep(i, moved)));
            }
        }
        let any = ReceiverPoint::new(Vec3::ZERO, Vec3::Y, geometry);
        let points: Vec<ReceiverPoint> = places
            .iter()
            .map(|&(i, position)| point_at(&any, receivers, i, position))
            .collect();
        let traced = trace_points(geometry, light, &points, options)?;
        let mut out = vec![None; receivers.len()];
        for ((i, position), truth) in places.into_iter().zip(traced) {
            out[i] = Some((position, truth));
        }
        Ok(out)
    }
}

/// Returns receiver `i` as a point to trace, moved to another position on its plane. `any` is any
/// point of the same geometry; the fields that all points share are copied from it.
pub(super) fn point_at(
    any: &ReceiverPoint,
    receivers: &Receivers,
    i: usize,
    position: Vec3,
) -> ReceiverPoint {
    let x = i as u32 % receivers.size.x;
    let y = i as u32 / receivers.size.x;
    ReceiverPoint {
        position,
        normal: receivers.normal(i),
        triangle: receivers.triangle[i],
        seed: light_sample::seed(x, y),
        ..*any
    }
}

/// Returns the last point within a triangle on the segment from `p` to `q`, both on its plane; `p`
/// itself if it is outside.
pub(super) fn last_point_inside(p: Vec3, q: Vec3, triangle: [Vec3; 3]) -> Vec3 {
    let edge_1 = triangle[1] - triangle[0];
    let edge_2 = triangle[2] - triangle[0];
    let normal = edge_1.cross(edge_2);
    let mut share = 1.0_f32;
    for k in 0..3 {
        let from = triangle[k];
        let to = triangle[(k + 1) % 3];
        // Positive on the triangle's side of the edge.
        let inward = normal.cross(to - from);
        let p_side = inward.dot(p - from);
        let q_side = inward.dot(q - from);
        if q_side >= 0.0 {
            continue;
        }
        let share_to_edge = (p_side / (p_side - q_side)).max(0.0);
        share = share.min(share_to_edge);
    }
    p + (q - p) * share
}

/// Returns the center of the texel that contains a point, both in texels.
pub fn to_center(texel: DVec2) -> DVec2 {
    texel.floor() + 0.5
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage_core::{glam::Mat4, light_space};

    /// Returns a map of 10 texels that looks straight down on 10 x 10 m.
    fn texels() -> MapTexels {
        let view_from_world =
            light_space::look_along(Vec3::Y * 5.0, Vec3::NEG_Y, Vec3::NEG_Z).expect("valid");
        let extents = light_space::Extents {
            left: -5.0,
            right: 5.0,
            bottom: -5.0,
            top: 5.0,
            near: 0.0,
            far: 10.0,
        };
        let clip_from_view: Mat4 = light_space::orthographic(extents).expect("valid");
        let space = LightSpace {
            view_from_world,
            clip_from_view,
        };
        let spaces = LightSpaces::with_all_casters(vec![space]);
        MapTexels::new(&spaces, 10)
    }

    #[test]
    fn places_snap_to_texel_centres_along_the_receivers_plane() {
        let t = texels();
        let flat = t
            .moved_position(Vec3::new(0.2, 1.0, 3.9), Vec3::Y, to_center)
            .expect("on the map");
        assert!(flat.distance(Vec3::new(0.5, 1.0, 3.5)) < 1e-5, "{flat}");
        // On a plane that rises by one along x, moving .3 m in x raises the point by as much.
        let n = Vec3::new(-1.0, 1.0, 0.0).normalize();
        let sloped = t
            .moved_position(Vec3::new(0.2, 1.0, 3.5), n, to_center)
            .expect("on the map");
        assert!(sloped.distance(Vec3::new(0.5, 1.3, 3.5)) < 1e-5, "{sloped}");
    }

    #[test]
    fn ways_end_at_the_triangles_edge() {
        let triangle = [Vec3::ZERO, Vec3::Z * 4.0, Vec3::X * 4.0];
        let p = Vec3::new(1.0, 0.0, 1.0);
        for (q, expected) in [
            (Vec3::new(2.0, 0.0, 1.0), Vec3::new(2.0, 0.0, 1.0)),
            (Vec3::new(-1.0, 0.0, 1.0), Vec3::new(0.0, 0.0, 1.0)),
            (Vec3::new(5.0, 0.0, 5.0), Vec3::new(2.0, 0.0, 2.0)),
        ] {
            assert!(
                last_point_inside(p, q, triangle).distance(expected) < 1e-6,
                "{q}"
            );
        }
        assert_eq!(last_point_inside(-p, p * -2.0, triangle), -p);
    }

    #[test]
    fn points_off_the_map_or_edge_on_have_no_position() {
        assert_eq!(
            texels().moved_position(Vec3::new(5.2, 0.0, 0.0), Vec3::Y, to_center),
            None
        );
        assert_eq!(
            texels().moved_position(Vec3::ZERO, Vec3::X, to_center),
            None
        );
    }
}
