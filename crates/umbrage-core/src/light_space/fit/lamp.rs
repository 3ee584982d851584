//! Tight fits of lights with a position: pyramids around the casters that can shadow a visible
//! receiver.

use crate::{
    geometry::{Geometry, aabb::Aabb},
    invalid::Invalid,
    light_space::{
        fit::{
            cull::{self, Lookups, Need, Receiving},
            input::FitInput,
            map_space::{MapBounds, MapSpace},
            parallel::inner_texels,
            points::{Points, caster_reach, receiver_points},
        },
        layers::cube_face_views,
        look_along,
    },
};
use glam::{DAffine3, DVec3, Mat4, Vec3};

/// Greatest half angle, degrees, of a cone for one perspective map.
pub(super) const WIDEST_HALF_ANGLE: f32 = 75.0;
/// Least near plane of a perspective fit, as a fraction of its far plane: 2^-14. Depths there are
/// distinct to within 2^-10 of their distance. A caster nearer than that (0.6 mm from a light with
/// a range of 10 m) is lost, to keep precision for the others.
pub(super) const MIN_NEAR_OVER_FAR: f32 = 1.0 / 16_384.0;
/// Padding of the outermost directions, as a fraction of their tangent, for rounding.
const TANGENT_SLACK: f64 = 1e-3;
/// Half angle, radians, of the arbitrary pyramid used if no caster can shadow a receiver.
const DEFAULT_HALF_ANGLE: f64 = 0.5;
/// Greatest ratio of the tangents of a tilted and a straight pyramid at which the tilted one is
/// used. Biases in texels and blocker searches are exact for surfaces parallel to the map, and most
/// lights are straight above what they light.
const MAX_TURNED_OVER_STRAIGHT: f64 = 0.5;
/// Steps of the search for the axis with the least angle. Each step turns the axis to the centre of
/// the previous step's result.
const MAX_AXIS_STEPS: usize = 4;

/// A light with a position, in a scene with known triangles.
#[derive(Clone, Debug)]
pub(super) struct Lamp<'a> {
    input: &'a FitInput<'a>,
    geometry: &'a Geometry,
    pub(super) eye: Vec3,
    size: u32,
    margin: f32,
    /// Twice the distance of the farthest receiver, metres.
    pub(super) far: f64,
}

/// A square pyramid with its apex at the light.
#[derive(Clone, Copy, Debug)]
pub(super) struct SquarePyramid {
    /// World space, not zero.
    pub(super) axis: Vec3,
    /// Tangent of half its angle.
    pub(super) tangent: f64,
}

impl<'a> Lamp<'a> {
    /// Returns `None` if the triangles are not known.
    pub(super) fn new(input: &'a FitInput<'_>, eye: Vec3, size: u32, margin: f32) -> Option<Self> {
        let geometry = input.view.geometry?;
        let farthest = greatest_distance(eye, &receiver_points(input));
        // If there are no receivers, any distance will do.
        let far = if farthest > 0.0 { 2.0 * farthest } else { 1.0 };
        Some(Self {
            input,
            geometry,
            eye,
            size,
            margin,
            far,
        })
    }

    /// Returns a box, in map space, around the casters that can shadow receivers within a pyramid.
    /// Its lateral bounds are within the box around these receivers. Empty if no caster can.
    /// `tangent` is that of half the pyramid's angle.
    fn needed_bounds(&self, view_from_world: &Mat4, tangent: f64) -> MapBounds {
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
        let receivers = Receiving::new(self.input.seen.as_ref(), self.geometry, &space, &column);
        let around = receivers.bounds();
        let last = space.rank(self.far);
        let lookups = self.lookups(&space, &around, tangent);
        let need_before = |first: f64| {
            let reach = lookups.reach(self.input.view.light, first, last);
            let need = Need::new(space, self.geometry, &receivers, &reach);
            need.map(|need| need.on_map(&column))
        };
        let mut first = cull::first_rank(self.geometry, &space, &column).unwrap_or(last);
        // As for parallel light: for an area light, the blocker search radius depends on the first
        // caster that matters.
        if !self.input.view.light.is_ideal() {
            first = need_before(first).map_or(f64::INFINITY, |need| need.first_rank());
        }
        let found = need_before(first).map_or(MapBounds::EMPTY, |need| need.around_casters());
        found.intersection(&around)
    }

    /// Returns the lookup parameters of a map over a pyramid. `receivers` is the box around its
    /// receivers.
    fn lookups(&self, space: &MapSpace, receivers: &MapBounds, tangent: f64) -> Lookups {
        let texel = 2.0 * tangent / f64::from(inner_texels(self.size, self.margin));
        let nearest = if receivers.is_empty() {
            self.far
        } else {
            space.distance(receivers.min.z)
        };
        let world = self.eye.abs().max_element().max(caster_reach(self.input));
        Lookups {
            texel: glam::DVec2::splat(texel),
            margin: f64::from(self.margin),
            // 2^-21: 8 units in the last place of world coordinates.
            rounding: f64::from(world) / 2_097_152.0 / nearest,
            tangent,
        }
    }

    /// Returns the distance, metres along the view, of the first caster that matters within a
    /// pyramid; `None` if there is none.
    pub(super) fn near_plane(&self, view_from_world: &Mat4, tangent: f64) -> Option<f32> {
        first_distance(&self.needed_bounds(view_from_world, tangent))
    }

    /// Returns [`Lamp::near_plane`] for all faces of a cube.
    pub(super) fn nears(&self, tangent: f64) -> Result<[Option<f32>; 6], Invalid> {
        Ok(self
            .faces(tangent)?
            .map(|(_, needed)| first_distance(&needed)))
    }

    /// Returns the view of each face of a cube, and the result of [`Lamp::needed_bounds`] for it.
    fn faces(&self, tangent: f64) -> Result<[(Mat4, MapBounds); 6], Invalid> {
        Ok(cube_face_views(self.eye)?.map(|view| (view, self.needed_bounds(&view, tangent))))
    }

    /// Returns the pyramid around all casters that matter within a given one. Keeps the axis unless
    /// another one makes it narrower by [`MAX_TURNED_OVER_STRAIGHT`].
    pub(super) fn narrow_pyramid(&self, pyramid: SquarePyramid) -> Result<SquarePyramid, Invalid> {
        let view_from_world = look_along(self.eye, pyramid.axis, Vec3::Y)?;
        let needed = self.needed_bounds(&view_from_world, pyramid.tangent);
        if needed.is_empty() {
            return Ok(pyramid);
        }
        let straight = SquarePyramid {
            axis: pyramid.axis,
            tangent: greatest_tangent(&needed).min(pyramid.tangent),
        };
        let turned = self.pyramid_around(&corners(&view_from_world, &needed))?;
        match turned {
            Some(turned) if turned.tangent < straight.tangent * MAX_TURNED_OVER_STRAIGHT => {
                Ok(turned)
            }
            _ => Ok(straight),
        }
    }

    /// Returns the pyramid around all casters that matter in any direction. `None` if it would be
    /// too wide; an arbitrary pyramid if no caster matters.
    pub(super) fn aimed_pyramid(&self) -> Result<Option<SquarePyramid>, Invalid> {
        let mut directions = Vec::new();
        for (face, needed) in self.faces(1.0)? {
            directions.extend(corners(&face, &needed));
        }
        if directions.is_empty() {
            return Ok(Some(SquarePyramid {
                axis: Vec3::NEG_Y,
                tangent: DEFAULT_HALF_ANGLE.tan(),
            }));
        }
        let widest = f64::from(WIDEST_HALF_ANGLE.to_radians()).tan();
        match self.pyramid_around(&directions)? {
            Some(pyramid) if pyramid.tangent <= widest => self.narrow_pyramid(pyramid).map(Some),
            _ => Ok(None),
        }
    }

    /// Returns a narrow pyramid around directions (world space, any length). `None` if there are
    /// none, or if they are not all in front of one plane through the light.
    ///
    /// The search starts at the mean direction. Each step looks along the axis, computes the box
    /// around the directions on the plane at distance 1, and turns the axis to the box's centre.
    fn pyramid_around(&self, directions: &[DVec3]) -> Result<Option<SquarePyramid>, Invalid> {
        let mut axis = directions.iter().map(|d| d.normalize()).sum::<DVec3>();
        let mut best: Option<SquarePyramid> = None;
        for _ in 0..MAX_AXIS_STEPS {
            if axis.length() < 1e-9 {
                break;
            }
            let unit_axis = axis.normalize().as_vec3();
            let view_from_world = look_along(self.eye, unit_axis, Vec3::Y)?.as_dmat4();
            let in_view: Vec<DVec3> = directions
                .iter()
                .map(|&d| view_from_world.transform_vector3(d))
                .collect();
            // Directions perpendicular to the axis or behind it have no tangent.
            if in_view.is_empty() || in_view.iter().any(|d| -d.z < 1e-6 * d.length()) {
                break;
            }
            let bounds = MapBounds::from_points(in_view.iter().map(|d| *d / -d.z));
            let tangent = greatest_tangent(&bounds);
            if best.is_none_or(|best| tangent < best.tangent) {
                best = Some(SquarePyramid {
                    axis: unit_axis,
                    tangent,
                });
            }
            let center = ((bounds.min + bounds.max) * 0.5).with_z(-1.0);
            // The transpose of a rotation is its inverse.
            axis = view_from_world.transpose().transform_vector3(center);
        }
        Ok(best)
    }
}

/// Returns the greatest distance from `eye` to one of some points, metres; 0 without any.
fn greatest_distance(eye: Vec3, points: &Points<'_>) -> f64 {
    // More than the relative rounding of sums of squares.
    const ROUNDING: f64 = 1e-12;
    let eye = eye.as_dvec3();
    let bound = |b: &Aabb| {
        let farthest = (b.min.as_dvec3() - eye)
            .abs()
            .max((b.max.as_dvec3() - eye).abs());
        -farthest.length_squared() * (1.0 + ROUNDING)
    };
    let value = |p: Vec3| -p.as_dvec3().distance_squared(eye);
    (-points.least(bound, value)).max(0.0).sqrt()
}

/// Returns the tangent of half the angle of the square pyramid, around the view's axis, that
/// contains a box in map space.
fn greatest_tangent(b: &MapBounds) -> f64 {
    b.min.abs().max(b.max.abs()).truncate().max_element()
}

/// Returns the distance, metres along the view, just before the first caster in a box in map space;
/// `None` if the box is empty.
fn first_distance(needed: &MapBounds) -> Option<f32> {
    // The rank is minus one over the distance.
    (!needed.is_empty()).then(|| (-(1.0 - TANGENT_SLACK) / needed.min.z) as f32)
}

/// Returns the directions, world space, of the four corners of a box on a map; empty if the box is.
fn corners(view_from_world: &Mat4, b: &MapBounds) -> Vec<DVec3> {
    if b.is_empty() {
        return Vec::new();
    }
    let world_from_view = view_from_world.as_dmat4().transpose();
    [
        DVec3::new(b.min.x, b.min.y, -1.0),
        DVec3::new(b.min.x, b.max.y, -1.0),
        DVec3::new(b.max.x, b.min.y, -1.0),
        DVec3::new(b.max.x, b.max.y, -1.0),
    ]
    .map(|corner| world_from_view.transform_vector3(corner))
    .to_vec()
}
