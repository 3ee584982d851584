//! Shadows of an ideal light around a visible point, as polygons in 64 bits.
//!
//! The point is the intersection of a pixel's ray with the plane of the triangle that the pixel
//! shows. Its *vicinity* on that triangle is the set of points that rounding may reach. It covers
//! rays of the pixel moved by a fraction of a pixel, origins of shadow rays moved sideways, and
//! origins moved along the shadow ray. A caster's shadow on the plane is a convex polygon. The rest
//! of the vicinity, without all shadows, is light.

use super::{
    pixel_ray::PixelRay,
    points::ReceiverPoint,
    polygon::{
        FlatPolygon, area, common, contains, counter_clockwise, cut, hull, minkowski_sum, spread,
        subtract_polygon,
    },
};
use glam::{DVec2, DVec3, Vec3};
use umbrage_core::{
    Camera, CameraRays, Geometry, Light,
    light_sample::{LIFT, SHORT, origin_offset},
};

/// Lighting around a visible point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Around {
    /// Only light.
    Light,
    /// Only shadow.
    Shadow,
    /// Both, or a result that depends on the height of the rays' origins.
    Both,
    /// The light's side of the surface depends on rounding.
    Grazed,
    /// Undefined: the surface faces away, or the point is outside its triangle.
    Neither,
}

/// Greatest share of the vicinity's area that counts as empty. Cuts in 64 bits have errors of about
/// 2^-50 of its length. If it is a hundred times longer than wide, that is 1e-13 of its area.
const MIN_AREA_SHARE: f64 = 1e-9;

/// Height of the lowest origin of a ray, as a share of the highest without the position's own error:
/// 2^-24 of the lengths near the point, the last place of 32 bits. Neighbours in one plane with
/// rounded corners differ by less in height, so they don't shadow each other.
const MIN_LIFT_SHARE: f64 = 1.0 / 32.0;

/// Greatest number of pieces that shadows may leave. With more pieces, a point counts as having
/// both light and shadow around it, since the time to cut is quadratic. This occurs only far from
/// the origin, where vicinities are as wide as whole models.
const MAX_PIECES: usize = 500;

/// Ideal light, camera and casters.
pub(super) struct Vicinity<'a> {
    geometry: &'a Geometry,
    light: ToLight,
    rays: CameraRays,
    /// Greatest movement of the image, pixels.
    pixels: f64,
    /// Centre of a sphere around the casters, which rays to directional lights leave.
    center: DVec3,
    radius: f64,
}

/// Position or direction of the light.
#[derive(Clone, Copy, Debug)]
enum ToLight {
    Direction(DVec3),
    Position(DVec3),
    /// Light with an extent: no shadow has a sharp edge.
    Everywhere,
}

/// Returns the radius of a disc around the visible point that contains a polygon, at least `least`.
fn radius(p: &[DVec2], least: f64) -> f64 {
    p.iter().map(|q| q.length()).fold(least, f64::max)
}

/// Plane of a visible triangle.
struct NearSurface {
    /// The visible point.
    p: DVec3,
    /// Two unit vectors in the plane, and the unit normal towards the camera.
    axes: [DVec3; 3],
    /// Vector from the point to the light, of length 1 for directions.
    to_light: DVec3,
    /// Height of the light above the plane, metres; infinite for directions.
    light_height: f64,
}

impl NearSurface {
    /// Returns coordinates in the plane, relative to the visible point.
    fn flat(&self, v: DVec3) -> DVec2 {
        DVec2::new(v.dot(self.axes[0]), v.dot(self.axes[1]))
    }

    fn height(&self, q: DVec3) -> f64 {
        (q - self.p).dot(self.axes[2])
    }

    /// Returns the sine of the angle between the light and the plane.
    fn sine(&self) -> f64 {
        self.to_light.dot(self.axes[2]) / self.to_light.length()
    }

    /// Returns the shadow of the part of a triangle that is higher than `above` and lower than the
    /// light.
    fn shadow(&self, corners: [DVec3; 3], above: f64) -> FlatPolygon {
        let mut part = cut(&corners, |q| self.height(q) - above);
        if self.light_height.is_finite() {
            part = cut(&part, |q| {
                self.light_height * f64::from(SHORT) - self.height(q)
            });
        }
        counter_clockwise(part.into_iter().map(|q| self.project(q)).collect())
    }

    /// Returns the barycentric coordinates of the point of a triangle's plane whose shadow is at
    /// `q`. They are not finite if the light is parallel to that plane.
    fn weights_above(&self, q: DVec2, corners: [DVec3; 3]) -> [f64; 3] {
        let foot = self.p + self.axes[0] * q.x + self.axes[1] * q.y;
        let way = if self.light_height.is_finite() {
            self.p + self.to_light - foot
        } else {
            self.to_light
        };
        let [a, b, c] = corners.map(|corner| corner - foot);
        // Volumes over the triangle's sides, as seen along `way`.
        let u = way.dot(b.cross(c));
        let v = way.dot(c.cross(a));
        let w = way.dot(a.cross(b));
        let whole = u + v + w;
        [u / whole, v / whole, w / whole]
    }

    /// Returns a point's shadow: the intersection of the line from the light through the point with
    /// the plane.
    fn project(&self, q: DVec3) -> DVec2 {
        let height = self.height(q);
        let offset = q - self.p;
        if self.light_height.is_finite() {
            let from_light = offset - self.to_light;
            let t = self.light_height / (self.light_height - height);
            return self.flat(self.to_light + from_light * t);
        }
        let t = height / self.to_light.dot(self.axes[2]);
        self.flat(offset - self.to_light * t)
    }
}

impl<'a> Vicinity<'a> {
    pub(super) fn new(camera: &Camera, geometry: &'a Geometry, light: &Light, pixels: f64) -> Self {
        let bounds = geometry.caster_bounds();
        let empty = bounds.is_empty();
        Self {
            geometry,
            light: match *light {
                Light::Directional { direction, .. } => {
                    ToLight::Direction(-direction.as_dvec3().normalize())
                }
                Light::Point { position, .. } | Light::Spot { position, .. } => {
                    ToLight::Position(position.as_dvec3())
                }
                Light::Rect { .. } | Light::Disc { .. } => ToLight::Everywhere,
            },
            rays: camera.rays(),
            pixels,
            center: if empty {
                DVec3::ZERO
            } else {
                bounds.center().as_dvec3()
            },
            radius: if empty {
                0.0
            } else {
                (bounds.max.as_dvec3() - bounds.min.as_dvec3()).length()
            },
        }
    }

    /// Returns the lighting around the point that a pixel shows. `ids` is scratch memory.
    pub(super) fn around_point(
        &self,
        point: &ReceiverPoint,
        pixel: [u32; 2],
        ids: &mut Vec<u32>,
    ) -> Around {
        let corners = self.geometry.corners(point.triangle).map(Vec3::as_dvec3);
        // Seen edge-on to the last bit, the point could be anywhere.
        let Some(surface) = self.surface(corners, pixel) else {
            return Around::Both;
        };
        if surface.sine().abs() < f64::from(LIFT) {
            return Around::Grazed;
        }
        if surface.sine() < 0.0 {
            return Around::Neither;
        }
        let offset = f64::from(point.offset());
        let highest = 2.0 * offset;
        // Origins may move as far along the surface.
        let moved = offset + f64::from(point.position_error.length());
        let lowest = 2.0 * MIN_LIFT_SHARE * f64::from(origin_offset(point.position, point.reach));
        let unclipped = self.unclipped_vicinity(&surface, pixel, moved);
        if let Some(unclipped) = &unclipped {
            // Return early for most points, which have no casters nearby: they need only this
            // polygon.
            self.casters_near(&surface, radius(unclipped, highest), ids);
            ids.retain(|&id| id != point.triangle);
            if ids.is_empty() {
                return Around::Light;
            }
        }
        // Clip the vicinity to the triangle.
        let triangle = corners.map(|c| surface.flat(c - surface.p));
        let triangle = counter_clockwise(triangle.to_vec());
        let vicinity = match &unclipped {
            Some(unclipped) => common(unclipped, &triangle),
            None => triangle,
        };
        let whole = area(&vicinity);
        if whole <= 0.0 {
            return Around::Neither;
        }
        // Compare the shadows for the lowest and the highest origin of rays.
        self.casters_near(&surface, radius(&vicinity, highest), ids);
        ids.retain(|&id| id != point.triangle);
        let from_lowest = self.left(&surface, &vicinity, ids, lowest);
        if from_lowest == Around::Both {
            return Around::Both;
        }
        let from_highest = self.left(&surface, &vicinity, ids, highest);
        if from_lowest == from_highest {
            from_lowest
        } else {
            Around::Both
        }
    }

    /// Returns the lighting of a polygon, given the shadows of all casters that are higher than
    /// `above`.
    fn left(
        &self,
        surface: &NearSurface,
        vicinity: &FlatPolygon,
        ids: &[u32],
        above: f64,
    ) -> Around {
        let whole = area(vicinity);
        let min_area = MIN_AREA_SHARE * whole;
        // Collect the shadows, without alpha-tested holes.
        let shadow =
            |id: &u32| surface.shadow(self.geometry.corners(*id).map(Vec3::as_dvec3), above);
        let mut shadows: Vec<FlatPolygon> = Vec::with_capacity(ids.len());
        for id in ids {
            let shadow = shadow(id);
            if area(&shadow) <= min_area {
                continue;
            }
            match self.is_hole_over(surface, vicinity, *id, &shadow) {
                Some(true) => {}
                Some(false) => shadows.push(shadow),
                None => return Around::Both,
            }
        }
        // Test some points first: they identify most vicinities with both light and shadow, without
        // cuts.
        let points = spread(vicinity);
        let dark = points
            .iter()
            .filter(|q| shadows.iter().any(|shadow| contains(shadow, **q)))
            .count();
        if dark > 0 && dark < points.len() {
            return Around::Both;
        }
        // Clip the shadows to the vicinity.
        let mut parts: Vec<(f64, FlatPolygon)> = Vec::new();
        for shadow in &shadows {
            let part = common(vicinity, shadow);
            let size = area(&part);
            if size > min_area {
                parts.push((size, part));
            }
        }
        if parts.is_empty() {
            return Around::Light;
        }
        if dark == 0 {
            return Around::Both;
        }
        // Subtract the largest first, so that fewer pieces are left to cut.
        parts.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
        let mut left = vec![vicinity.clone()];
        for (_, part) in &parts {
            left = subtract_polygon(left, part, min_area);
            if left.len() > MAX_PIECES {
                return Around::Both;
            }
        }
        let left: f64 = left.iter().map(|p| area(p)).sum();
        if left <= min_area {
            Around::Shadow
        } else {
            Around::Both
        }
    }

    /// Returns `Some(true)` if the alpha test removes all of the caster's part that may shadow a
    /// polygon of the plane, and `Some(false)` if it removes nothing. Returns `None` if it removes
    /// some of it. `shadow` is the caster's shadow on the plane.
    fn is_hole_over(
        &self,
        surface: &NearSurface,
        vicinity: &FlatPolygon,
        id: u32,
        shadow: &FlatPolygon,
    ) -> Option<bool> {
        let Some(cut_outs) = self.geometry.cut_outs() else {
            return Some(false);
        };
        if cut_outs.record_row(id).is_none() {
            return Some(false);
        }
        let part = common(vicinity, shadow);
        if part.is_empty() {
            // The caster has no shadow here.
            return Some(true);
        }
        // Lines stay straight when projected back to the caster, so the corners' uvs bound those of
        // the whole part.
        let corners = self.geometry.corners(id).map(Vec3::as_dvec3);
        let weights: Vec<[f64; 3]> = part
            .iter()
            .map(|&q| surface.weights_above(q, corners))
            .collect();
        cut_outs.is_hole_around(id, &weights)
    }

    /// Returns the plane of a triangle at the point that a pixel shows. Returns `None` if the plane
    /// is seen edge-on or the light has an extent.
    fn surface(&self, corners: [DVec3; 3], pixel: [u32; 2]) -> Option<NearSurface> {
        let ray = PixelRay::new(&self.rays, pixel, DVec2::ZERO);
        let edge_1 = corners[1] - corners[0];
        let edge_2 = corners[2] - corners[0];
        let normal = edge_1.cross(edge_2).try_normalize()?;
        let t = normal.dot(corners[0] - ray.origin) / normal.dot(ray.direction);
        let p = ray.origin + ray.direction * t;
        let normal = if normal.dot(ray.direction) > 0.0 {
            -normal
        } else {
            normal
        };
        let (u, v) = normal.any_orthonormal_pair();
        let (to_light, light_height) = match self.light {
            ToLight::Direction(to_light) => (to_light, f64::INFINITY),
            ToLight::Position(position) => (position - p, (position - p).dot(normal)),
            ToLight::Everywhere => return None,
        };
        p.is_finite().then_some(NearSurface {
            p,
            axes: [u, v, normal],
            to_light,
            light_height,
        })
    }

    /// Returns the vicinity of a point as if its triangle were unbounded, for rays whose origins
    /// may move by `offset`, metres. Returns `None` if the plane's horizon is so close that any
    /// point of the triangle may be visible.
    fn unclipped_vicinity(
        &self,
        s: &NearSurface,
        pixel: [u32; 2],
        offset: f64,
    ) -> Option<FlatPolygon> {
        // Intersect moved pixel rays with the plane.
        let mut seen = Vec::with_capacity(16);
        for k in 0..16 {
            let direction = DVec2::from_angle(std::f64::consts::FRAC_PI_8 * f64::from(k));
            let ray = PixelRay::new(&self.rays, pixel, direction * self.pixels);
            let t = s.axes[2].dot(s.p - ray.origin) / s.axes[2].dot(ray.direction);
            if !(t > 0.0 && t.is_finite()) {
                return None;
            }
            seen.push(s.flat(ray.origin + ray.direction * t - s.p));
        }
        // A ray from above intersects the plane behind its origin, seen from the light.
        let back = s.flat(s.to_light) * (-2.0 * offset / s.to_light.dot(s.axes[2]));
        let mut moves = Vec::with_capacity(8);
        for (i, j) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
            let aside = DVec2::new(i, j) * offset;
            moves.extend([aside, aside + back]);
        }
        Some(minkowski_sum(&hull(seen), &hull(moves)))
    }

    /// Finds the casters whose shadows may be within `radius` of the visible point.
    fn casters_near(&self, s: &NearSurface, radius: f64, ids: &mut Vec<u32>) {
        let to_light = match self.light {
            ToLight::Direction(to_light) => {
                to_light * (1.01 * ((s.p - self.center).length() + self.radius))
            }
            ToLight::Position(_) | ToLight::Everywhere => s.to_light,
        };
        let origin = s.p.as_vec3();
        let to_light = to_light.as_vec3();
        // Both ends are rounded to 32 bits.
        let max_coordinates = origin.abs().max_element() + to_light.abs().max_element();
        let rounding = max_coordinates * f32::EPSILON;
        ids.clear();
        self.geometry
            .bvh()
            .triangles_near(origin, to_light, radius as f32 + rounding, ids);
    }
}
