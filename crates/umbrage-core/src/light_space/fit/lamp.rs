//! Tight fits of lights with a position: pyramids around what can shadow a seen receiver.

use crate::{
    Geometry, Invalid, View,
    light_space::{
        fit::{
            WIDEST_HALF_ANGLE,
            cull::{self, Lookups, Need, Receiving},
            map_space::{MapBounds, MapSpace},
            parallel::inner,
            perspective::MIN_NEAR_OVER_FAR,
            points::{caster_reach, receiver_points},
        },
        layers::cube_face_views,
        look_along,
    },
};
use glam::{DAffine3, DVec3, Mat4, Vec3};

/// Room beside the outermost directions, as a fraction of their tangent: for rounding.
const TANGENT_SLACK: f64 = 1e-3;
/// Half angle, radians, of the pyramid where nothing matters: as good as any.
const DEFAULT_HALF_ANGLE: f64 = 0.5;
/// A pyramid is turned off its axis only if that halves its texels: biases in texels and the search for blockers are exact
/// for surfaces parallel to the map, and lamps are mostly set up straight above what they light.
const MAX_TURNED_OVER_STRAIGHT: f64 = 0.5;
/// Steps towards the axis that makes the widest angle least. Each centres what was found around the last axis.
const MAX_AXIS_STEPS: usize = 4;

/// A light with a position, amid known triangles.
#[derive(Clone, Debug)]
pub(super) struct Lamp<'a> {
    view: &'a View<'a>,
    geometry: &'a Geometry,
    pub(super) eye: Vec3,
    size: u32,
    margin: f32,
    /// World positions of what is seen to receive, if that is known.
    seen: Option<Vec<Vec3>>,
    /// Twice the distance of the farthest receiver, metres.
    pub(super) far: f64,
}

/// A square pyramid: its axis, and the tangent of half its angle.
pub(super) type Aim = (Vec3, f64);

impl<'a> Lamp<'a> {
    /// None where the triangles are not known.
    pub(super) fn new(view: &'a View<'_>, eye: Vec3, size: u32, margin: f32) -> Option<Self> {
        let geometry = view.geometry?;
        let seen = cull::seen(view);
        let farthest = |points: &mut dyn Iterator<Item = Vec3>| {
            points
                .map(|p| p.as_dvec3().distance_squared(eye.as_dvec3()))
                .fold(0.0, f64::max)
                .sqrt()
        };
        let farthest = match &seen {
            Some(points) => farthest(&mut points.iter().copied()),
            None => farthest(&mut receiver_points(view)),
        };
        // Where nothing receives, any distance will do.
        let far = if farthest > 0.0 { 2.0 * farthest } else { 1.0 };
        Some(Self {
            view,
            geometry,
            eye,
            size,
            margin,
            seen,
            far,
        })
    }

    /// A box, in map space, around what casts onto receivers within a pyramid of this tangent: sideways where something
    /// also receives. Empty if nothing can fall on anything there.
    fn needed(&self, view_from_world: &Mat4, tangent: f64) -> MapBounds {
        self.needed_of(self.seen.as_deref(), view_from_world, tangent)
    }

    /// As [`Lamp::needed`], if these are the points seen in the pyramid.
    fn needed_of(&self, seen: Option<&[Vec3]>, view_from_world: &Mat4, tangent: f64) -> MapBounds {
        let view_from_world = DAffine3::from_mat4(view_from_world.as_dmat4());
        let space = MapSpace {
            view_from_world,
            nearest: Some(self.far * f64::from(MIN_NEAR_OVER_FAR)),
        };
        let side = DVec3::splat(tangent * (1.0 + TANGENT_SLACK));
        let column = MapBounds {
            min: -side,
            max: side,
        };
        let receivers = Receiving::new(seen, self.geometry, &space, &column);
        let around = receivers.bounds();
        let last = space.rank(self.far);
        let lookups = self.lookups(&space, &around, tangent);
        let mut first = cull::first_rank(self.geometry, &space, &column);
        let mut found = MapBounds::EMPTY;
        // As for parallel light: asked twice if what matters depends on the first caster that does.
        for _ in 0..if self.view.light.is_ideal() { 1 } else { 2 } {
            let reach = lookups.reach(self.view.light, [first.unwrap_or(last), last]);
            let need = Need::new(space, self.geometry, &receivers, &reach);
            found = need.map_or(MapBounds::EMPTY, |need| {
                need.on_map(&column).around_casters()
            });
            first = Some(found.min.z);
        }
        found.within(&around)
    }

    fn lookups(&self, space: &MapSpace, receivers: &MapBounds, tangent: f64) -> Lookups {
        let texel = 2.0 * tangent / f64::from(inner(self.size, self.margin));
        let nearest = if receivers.is_empty() {
            self.far
        } else {
            space.distance(receivers.min.z)
        };
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
        first_distance(&self.needed(view_from_world, tangent))
    }

    /// As [`Lamp::near`], of all faces of a cube.
    pub(super) fn nears(&self, tangent: f64) -> Result<[Option<f32>; 6], Invalid> {
        Ok(self
            .faces(tangent)?
            .map(|(_, needed)| first_distance(&needed)))
    }

    /// What each face of a cube needs, and its view. Points are dealt out first, since each is seen in a face or two.
    fn faces(&self, tangent: f64) -> Result<[(Mat4, MapBounds); 6], Invalid> {
        let seen = self
            .seen
            .as_ref()
            .map(|points| dealt_out(points, self.eye, tangent as f32));
        let views = cube_face_views(self.eye)?;
        Ok(std::array::from_fn(|i| {
            let seen = seen.as_ref().map(|seen| &seen[i][..]);
            (views[i], self.needed_of(seen, &views[i], tangent))
        }))
    }

    /// The pyramid around all that matters, within one that is given: on its axis, or on another if it is so much narrower.
    pub(super) fn narrowed(&self, (axis, tangent): Aim) -> Result<Aim, Invalid> {
        let view_from_world = look_along(self.eye, axis, Vec3::Y)?;
        let needed = self.needed(&view_from_world, tangent);
        if needed.is_empty() {
            return Ok((axis, tangent));
        }
        let straight = needed
            .min
            .abs()
            .max(needed.max.abs())
            .truncate()
            .max_element()
            .min(tangent);
        let turned = self.around(&corners(&view_from_world, &needed))?;
        Ok(turned
            .filter(|n| n.1 < straight * MAX_TURNED_OVER_STRAIGHT)
            .unwrap_or((axis, straight)))
    }

    /// The pyramid around all that matters in any direction; none if it would be too wide. Anything if nothing matters.
    pub(super) fn aimed(&self) -> Result<Option<Aim>, Invalid> {
        let mut directions = Vec::new();
        for (face, needed) in self.faces(1.0)? {
            directions.extend(corners(&face, &needed));
        }
        if directions.is_empty() {
            return Ok(Some((Vec3::NEG_Y, DEFAULT_HALF_ANGLE.tan())));
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
        for _ in 0..MAX_AXIS_STEPS {
            if axis.length() < 1e-9 {
                break;
            }
            let direction = axis.normalize().as_vec3();
            let view_from_world = look_along(self.eye, direction, Vec3::Y)?.as_dmat4();
            let in_view: Vec<DVec3> = directions
                .iter()
                .map(|&d| view_from_world.transform_vector3(d))
                .collect();
            if in_view.is_empty() || in_view.iter().any(|d| -d.z < 1e-6 * d.length()) {
                break;
            }
            let b = MapBounds::around(in_view.iter().map(|d| *d / -d.z));
            let tangent = b.min.abs().max(b.max.abs()).truncate().max_element();
            if best.is_none_or(|best| tangent < best.1) {
                best = Some((direction, tangent));
            }
            axis = view_from_world
                .transpose()
                .transform_vector3(((b.min + b.max) * 0.5).with_z(-1.0));
        }
        Ok(best)
    }
}

/// The distance of the first caster in a box of map space.
fn first_distance(needed: &MapBounds) -> Option<f32> {
    (!needed.is_empty()).then(|| (-(1.0 - TANGENT_SLACK) / needed.min.z) as f32)
}

/// The points that may lie in each face of a cube, in the order of its views; those near an edge in each that it borders.
fn dealt_out(points: &[Vec3], eye: Vec3, tangent: f32) -> [Vec<Vec3>; 6] {
    let wide = tangent * (1.0 + 2.0 * TANGENT_SLACK as f32);
    let mut faces: [Vec<Vec3>; 6] = Default::default();
    for &p in points {
        let d = p - eye;
        let most = d.abs().max_element();
        for (i, along) in [d.x, -d.x, d.y, -d.y, d.z, -d.z].into_iter().enumerate() {
            if along * wide.max(1.0) >= most {
                faces[i].push(p);
            }
        }
    }
    faces
}

/// The directions, in the world, of a box's corners on a map.
fn corners(view_from_world: &Mat4, b: &MapBounds) -> Vec<DVec3> {
    if b.is_empty() {
        return Vec::new();
    }
    let world_from_view = view_from_world.as_dmat4().transpose();
    let corner = |x: f64, y: f64| world_from_view.transform_vector3(DVec3::new(x, y, -1.0));
    vec![
        corner(b.min.x, b.min.y),
        corner(b.min.x, b.max.y),
        corner(b.max.x, b.min.y),
        corner(b.max.x, b.max.y),
    ]
}
