//! Computes the shadows of an ideal light around a seen point as polygons, in 64 bits.
//!
//! The point is where a pixel's ray meets the plane of the triangle that the pixel shows. Around
//! it, on that triangle, lies its *vicinity*: where the ray of a pixel moved by some fraction of
//! itself meets the plane, where the origin of a shadow ray may be moved aside, and where the line
//! of a shadow ray meets the plane that starts above it. A caster's shadow on the plane is a convex
//! polygon; what all of them leave of the vicinity is light.

use super::{
    points::ReceiverPoint,
    polygon::{
        Polygon, area, common, contains, counter_clockwise, cut, hull, minkowski_sum, spread,
        without,
    },
};
use glam::{DVec2, DVec3, Vec3, Vec4};
use umbrage_core::{
    Camera, CameraRays, Geometry, Light,
    light_sample::{LIFT, SHORT, origin_offset},
};

/// What lies around a seen point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Around {
    /// No shadow.
    Light,
    /// Nothing but shadow.
    Shadow,
    /// Both, or which of them depends on the height at which rays start.
    Both,
    /// Which side the light is on is rounding.
    Grazed,
    /// Neither is told: the surface faces away, or the point lies beyond its triangle.
    Neither,
}

/// Parts of the vicinity with a smaller share of its area count as nothing. Cuts in 64 bits err by
/// some 2^-50 of its length; where it is a hundred times longer than wide, that is 1e-13 of its
/// area.
const MIN_AREA_SHARE: f64 = 1e-9;

/// The lowest origin of a ray, as a share of the highest: 2^-24 of the lengths in play, the last
/// place of 32 bits. Neighbours in one plane, whose corners are rounded to that, lie above each
/// other by less: they don't shadow each other.
const MIN_LIFT_SHARE: f64 = 1.0 / 32.0;

/// The most pieces that shadows may leave; with more, a point counts as having both light and
/// shadow around it, as the time to cut grows with the square. Only far from the origin, where
/// vicinities are as wide as whole models, are there so many.
const MAX_PIECES: usize = 500;

/// An ideal light, a camera, and casters.
pub(super) struct Vicinity<'a> {
    geometry: &'a Geometry,
    light: ToLight,
    rays: CameraRays,
    /// How far the image may move, pixels.
    pixels: f64,
    /// A ball around the casters: rays to directional lights leave it.
    center: DVec3,
    radius: f64,
}

/// Where the light is.
#[derive(Clone, Copy, Debug)]
enum ToLight {
    Direction(DVec3),
    Position(DVec3),
    /// It has an extent: no shadow has an edge.
    Everywhere,
}

/// A camera's ray through a pixel.
#[derive(Clone, Copy)]
struct PixelRay {
    origin: DVec3,
    direction: DVec3,
}

/// The radius of a disc around the seen point that a polygon lies in, `least` or more.
fn radius(p: &[DVec2], least: f64) -> f64 {
    p.iter().map(|q| q.length()).fold(least, f64::max)
}

/// `base + dx * x + dy * y` in 64 bits.
fn linear(base: Vec4, dx: Vec4, dy: Vec4, x: f64, y: f64) -> DVec3 {
    (base.as_dvec4() + dx.as_dvec4() * x + dy.as_dvec4() * y).truncate()
}

/// The plane of a seen triangle.
struct Surface {
    /// The seen point.
    p: DVec3,
    /// Two unit vectors across, and the unit normal towards the camera.
    axes: [DVec3; 3],
    /// From the point to the light; for directions of length 1.
    to_light: DVec3,
    /// How high the light is, metres; infinite for directions.
    light_height: f64,
}

impl Surface {
    /// Coordinates in the plane, from the seen point.
    fn flat(&self, v: DVec3) -> DVec2 {
        DVec2::new(v.dot(self.axes[0]), v.dot(self.axes[1]))
    }

    fn height(&self, q: DVec3) -> f64 {
        (q - self.p).dot(self.axes[2])
    }

    /// The sine of the angle between the light and the plane.
    fn sine(&self) -> f64 {
        self.to_light.dot(self.axes[2]) / self.to_light.length()
    }

    /// Returns the shadow of a triangle's part that is higher than `above`, and lower than the
    /// light.
    fn shadow(&self, corners: [DVec3; 3], above: f64) -> Polygon {
        let mut part = cut(&corners, |q| self.height(q) - above);
        if self.light_height.is_finite() {
            part = cut(&part, |q| {
                self.light_height * f64::from(SHORT) - self.height(q)
            });
        }
        counter_clockwise(part.into_iter().map(|q| self.project(q)).collect())
    }

    /// Returns the barycentric coordinates of the point of a triangle's plane whose shadow is at
    /// `q`: not finite where the light runs along that plane.
    fn weights_above(&self, q: DVec2, corners: [DVec3; 3]) -> [f64; 3] {
        let foot = self.p + self.axes[0] * q.x + self.axes[1] * q.y;
        let way = if self.light_height.is_finite() {
            self.p + self.to_light - foot
        } else {
            self.to_light
        };
        let [a, b, c] = corners.map(|corner| corner - foot);
        // Volumes over the triangle's sides, as seen along the way.
        let u = way.dot(b.cross(c));
        let v = way.dot(c.cross(a));
        let w = way.dot(a.cross(b));
        let whole = u + v + w;
        [u / whole, v / whole, w / whole]
    }

    /// Returns where the line from the light through a point meets the plane: the point's shadow.
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

    /// Returns what lies around the point that a pixel shows. `ids` is scratch memory.
    pub(super) fn around(
        &self,
        point: &ReceiverPoint,
        pixel: [u32; 2],
        ids: &mut Vec<u32>,
    ) -> Around {
        let corners = self.geometry.corners(point.triangle).map(Vec3::as_dvec3);
        // Seen along its plane to the last bit, it could lie anywhere.
        let Some(surface) = self.surface(corners, pixel) else {
            return Around::Both;
        };
        if surface.sine().abs() < f64::from(LIFT) {
            return Around::Grazed;
        }
        if surface.sine() < 0.0 {
            return Around::Neither;
        }
        let offset = f64::from(origin_offset(point.position, point.reach));
        let highest = 2.0 * offset;
        let unclipped = self.unclipped_vicinity(&surface, pixel, offset);
        if let Some(unclipped) = &unclipped {
            // Most points have no caster near: they need no polygon but this one.
            self.casters_near(&surface, radius(unclipped, highest), ids);
            ids.retain(|&id| id != point.triangle);
            if ids.is_empty() {
                return Around::Light;
            }
        }
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
        self.casters_near(&surface, radius(&vicinity, highest), ids);
        ids.retain(|&id| id != point.triangle);
        let from_lowest = self.left(&surface, &vicinity, ids, highest * MIN_LIFT_SHARE);
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

    /// Returns what lies in a polygon, given the shadows of all casters that are higher than
    /// `above`.
    fn left(&self, surface: &Surface, vicinity: &Polygon, ids: &[u32], above: f64) -> Around {
        let whole = area(vicinity);
        let min_area = MIN_AREA_SHARE * whole;
        let shadow =
            |id: &u32| surface.shadow(self.geometry.corners(*id).map(Vec3::as_dvec3), above);
        let mut shadows: Vec<Polygon> = Vec::with_capacity(ids.len());
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
        // Some points find most of the vicinities that hold both, before anything is cut.
        let points = spread(vicinity);
        let dark = points
            .iter()
            .filter(|q| shadows.iter().any(|shadow| contains(shadow, **q)))
            .count();
        if dark > 0 && dark < points.len() {
            return Around::Both;
        }
        let mut parts: Vec<(f64, Polygon)> = Vec::new();
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
        // The largest first: then fewer pieces are left to be cut.
        parts.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
        let mut left = vec![vicinity.clone()];
        for (_, part) in &parts {
            left = without(left, part, min_area);
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

    /// Returns whether the part of a caster that may shadow a polygon of the plane is all hole
    /// (true) or none of it is (false); none if both. `shadow` is the caster's shadow on the plane.
    fn is_hole_over(
        &self,
        surface: &Surface,
        vicinity: &Polygon,
        id: u32,
        shadow: &Polygon,
    ) -> Option<bool> {
        let Some(cut_outs) = self.geometry.cut_outs() else {
            return Some(false);
        };
        if cut_outs.record_row(id).is_none() {
            return Some(false);
        }
        let part = common(vicinity, shadow);
        if part.is_empty() {
            // It throws no shadow here.
            return Some(true);
        }
        // Lines keep straight on the way back to the caster, so the corners' uvs bound those of all
        // of the part.
        let corners = self.geometry.corners(id).map(Vec3::as_dvec3);
        let weights: Vec<[f64; 3]> = part
            .iter()
            .map(|&q| surface.weights_above(q, corners))
            .collect();
        cut_outs.is_hole_around(id, &weights)
    }

    /// Returns the plane of a triangle at the point that a pixel shows; none where the plane is
    /// seen edge-on or the light has an extent.
    fn surface(&self, corners: [DVec3; 3], pixel: [u32; 2]) -> Option<Surface> {
        let ray = self.ray(pixel, DVec2::ZERO);
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
        p.is_finite().then_some(Surface {
            p,
            axes: [u, v, normal],
            to_light,
            light_height,
        })
    }

    /// Returns the ray through a pixel's center, moved by some pixels.
    fn ray(&self, pixel: [u32; 2], by: DVec2) -> PixelRay {
        let x = f64::from(pixel[0]) + 0.5 + by.x;
        let y = f64::from(pixel[1]) + 0.5 + by.y;
        let rays = &self.rays;
        PixelRay {
            origin: linear(rays.origin, rays.origin_dx, rays.origin_dy, x, y),
            direction: linear(rays.dir, rays.dir_dx, rays.dir_dy, x, y),
        }
    }

    /// Returns the vicinity of a point as if its triangle had no end, for rays whose origins may be
    /// moved by `offset`, metres. None where the plane's horizon is so near that any point of the
    /// triangle may be seen.
    fn unclipped_vicinity(&self, s: &Surface, pixel: [u32; 2], offset: f64) -> Option<Polygon> {
        let mut seen = Vec::with_capacity(16);
        for k in 0..16 {
            let direction = DVec2::from_angle(std::f64::consts::FRAC_PI_8 * f64::from(k));
            let ray = self.ray(pixel, direction * self.pixels);
            let t = s.axes[2].dot(s.p - ray.origin) / s.axes[2].dot(ray.direction);
            if !(t > 0.0 && t.is_finite()) {
                return None;
            }
            seen.push(s.flat(ray.origin + ray.direction * t - s.p));
        }
        // A ray from above meets the plane behind its origin, seen from the light.
        let back = s.flat(s.to_light) * (-2.0 * offset / s.to_light.dot(s.axes[2]));
        let mut moves = Vec::with_capacity(8);
        for (i, j) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
            let aside = DVec2::new(i, j) * offset;
            moves.extend([aside, aside + back]);
        }
        Some(minkowski_sum(&hull(seen), &hull(moves)))
    }

    /// Finds the casters whose shadows may fall within `radius` of the seen point.
    fn casters_near(&self, s: &Surface, radius: f64, ids: &mut Vec<u32>) {
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
            .near(origin, to_light, radius as f32 + rounding, ids);
    }
}
