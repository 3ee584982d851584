//! Tight fits of lights with a position: pyramids around what can shadow a seen receiver.

use super::{
    WIDEST_HALF_ANGLE,
    cull::{self, Lookups, Need},
    map_space::{Bounds, MapSpace},
    parallel::inner,
    perspective::NEAREST,
    points::{caster_reach, receiver_points},
};
use crate::{Geometry, Invalid, View, layout::cube_face_views, light_space::look_along};
use glam::{DAffine3, DVec3, Mat4, Vec3};

/// Room beside the outermost directions, as a fraction of their tangent: for rounding.
const SLACK: f64 = 1e-3;
/// Half angle, radians, of the pyramid where nothing matters: as good as any.
const ANYTHING: f64 = 0.5;
/// A pyramid is only turned off its axis if that makes texels smaller by a tenth or more.
const WORTHWHILE: f64 = 0.9;
/// Steps towards the axis that makes the widest angle least. Each centres what was found around the last axis.
const STEPS: usize = 4;

/// A light with a position, amid known triangles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lamp<'a> {
    view: &'a View<'a>,
    geometry: &'a Geometry,
    pub(super) eye: Vec3,
    size: u32,
    margin: f32,
    /// Twice the distance of the farthest receiver, metres.
    far: f64,
}

/// A square pyramid: its axis, and the tangent of half its angle.
pub(super) type Aim = (Vec3, f64);

impl<'a> Lamp<'a> {
    /// None where the triangles are not known.
    pub(super) fn new(view: &'a View<'_>, eye: Vec3, size: u32, margin: f32) -> Option<Self> {
        let geometry = view.geometry?;
        let farthest = receiver_points(view).map(|p| p.distance_squared(eye)).fold(0.0, f32::max);
        let far = 2.0 * f64::from(farthest).sqrt().max(f64::from(f32::MIN_POSITIVE));
        Some(Self { view, geometry, eye, size, margin, far })
    }

    /// A box, in map space, around what casts onto receivers within a pyramid of this tangent: sideways where something
    /// also receives. Empty if nothing can fall on anything there.
    pub(super) fn needed(&self, view_from_world: &Mat4, tangent: f64) -> Bounds {
        let view_from_world = DAffine3::from_mat4(view_from_world.as_dmat4());
        let space = MapSpace { view_from_world, nearest: Some(self.far * f64::from(NEAREST)) };
        let side = DVec3::splat(tangent * (1.0 + SLACK));
        let column = Bounds { min: -side, max: side };
        let receivers = cull::receivers(self.view, self.geometry, &space, &column);
        let around = receivers.iter().fold(Bounds::EMPTY, |b, r| b.union(r));
        let last = space.rank(self.far);
        let lookups = self.lookups(&space, &around, tangent);
        let mut first = cull::first_rank(self.geometry, &space, &column);
        let mut found = Bounds::EMPTY;
        // As for parallel light: asked twice if what matters depends on the first caster that does.
        for _ in 0..if self.view.light.is_ideal() { 1 } else { 2 } {
            let reach = lookups.reach(self.view.light, [first.unwrap_or(last), last]);
            let need = Need::new(space, self.geometry, &receivers, &reach);
            found = need.map_or(Bounds::EMPTY, |need| need.around_casters());
            first = Some(found.min.z);
        }
        found.within(&around)
    }

    fn lookups(&self, space: &MapSpace, receivers: &Bounds, tangent: f64) -> Lookups {
        let texel = 2.0 * tangent / f64::from(inner(self.size, self.margin));
        let nearest = if receivers.is_empty() { self.far } else { space.distance(receivers.min.z) };
        let world = self.eye.abs().max_element().max(caster_reach(self.view));
        Lookups {
            texel: glam::DVec2::splat(texel),
            margin: f64::from(self.margin),
            // Of world coordinates, 8 units in the last place.
            rounding: f64::from(world) / 2_097_152.0 / nearest,
            tangent,
        }
    }

    /// The distance of the first caster that matters within a pyramid; none if there is none.
    pub(super) fn near(&self, view_from_world: &Mat4, tangent: f64) -> Option<f32> {
        let needed = self.needed(view_from_world, tangent);
        (!needed.is_empty()).then(|| (-(1.0 - SLACK) / needed.min.z) as f32)
    }

    /// The pyramid around all that matters, within one that is given; that itself if it is hardly wider.
    pub(super) fn narrowed(&self, (axis, tangent): Aim) -> Result<Aim, Invalid> {
        let view_from_world = look_along(self.eye, axis, Vec3::Y)?;
        let directions = corners(&view_from_world, &self.needed(&view_from_world, tangent));
        let narrowed = self.around(&directions)?;
        Ok(narrowed.filter(|n| n.1 < tangent * WORTHWHILE).unwrap_or((axis, tangent)))
    }

    /// The pyramid around all that matters in any direction; none if it would be too wide. Anything if nothing matters.
    pub(super) fn aimed(&self) -> Result<Option<Aim>, Invalid> {
        let mut directions = Vec::new();
        for face in cube_face_views(self.eye)? {
            directions.extend(corners(&face, &self.needed(&face, 1.0)));
        }
        if directions.is_empty() {
            return Ok(Some((Vec3::NEG_Y, ANYTHING.tan())));
        }
        let widest = f64::from(WIDEST_HALF_ANGLE.to_radians()).tan();
        match self.around(&directions)?.filter(|aim| aim.1 <= widest) {
            Some(aim) => self.narrowed(aim).map(Some),
            None => Ok(None),
        }
    }

    /// A narrow pyramid around directions; none if half of the sphere does not hold them, or there are none.
    fn around(&self, directions: &[DVec3]) -> Result<Option<Aim>, Invalid> {
        let mut axis = directions.iter().map(|d| d.normalize()).sum::<DVec3>();
        let mut best: Option<Aim> = None;
        for _ in 0..STEPS {
            if axis.length() < 1e-9 {
                break;
            }
            let direction = axis.normalize().as_vec3();
            let view_from_world = look_along(self.eye, direction, Vec3::Y)?.as_dmat4();
            let in_view: Vec<DVec3> = directions.iter().map(|&d| view_from_world.transform_vector3(d)).collect();
            if in_view.is_empty() || in_view.iter().any(|d| -d.z < 1e-6 * d.length()) {
                break;
            }
            let b = Bounds::around(in_view.iter().map(|d| *d / -d.z));
            let tangent = b.min.abs().max(b.max.abs()).truncate().max_element();
            if best.is_none_or(|best| tangent < best.1) {
                best = Some((direction, tangent));
            }
            axis = view_from_world.transpose().transform_vector3(((b.min + b.max) * 0.5).with_z(-1.0));
        }
        Ok(best)
    }
}

/// The directions, in the world, of a box's corners on a map.
fn corners(view_from_world: &Mat4, b: &Bounds) -> Vec<DVec3> {
    if b.is_empty() {
        return Vec::new();
    }
    let world_from_view = view_from_world.as_dmat4().transpose();
    let corner = |x: f64, y: f64| world_from_view.transform_vector3(DVec3::new(x, y, -1.0));
    vec![corner(b.min.x, b.min.y), corner(b.min.x, b.max.y), corner(b.max.x, b.min.y), corner(b.max.x, b.max.y)]
}
