//! Independent computation of truth for tests. It tests every triangle, in 64 bits, by the signs of
//! volumes (Segura, Feito 2001, "Algorithms to Test Ray-Triangle Intersection"), without a
//! hierarchy, shear or polygons.
//!
//! Its rounding is about 2^-50 of the scene's lengths, a millionth of that of 32 bits. A visibility
//! is certain if it stays the same while the pixel and the shadow ray's origin move at random
//! within given limits.

use glam::{DAffine3, DMat4, DVec2, DVec3, Mat4, Vec3, Vec4};
use std::ops::Range;
use umbrage_core::{
    Camera, Geometry, Light,
    light_sample::{LIFT, SHORT, hash},
};

/// Greatest movement of a ray's origin by the rounding of its own triangle's corners, as a share of
/// the pixel's width there. On larger triangles, 32-bit rounding would decide visible shadows, and
/// truth must be better. The rule does not use [`GIANT`](super::points::GIANT), which it judges.
const CORNERS_SHARE: f64 = 0.1;

/// Number of points of an area light along each side.
const LIGHT_SIDE: u32 = 32;

pub(super) struct Oracle<'a> {
    corners: Vec<[DVec3; 3]>,
    casters: Range<u32>,
    receivers: Range<u32>,
    camera: &'a Camera,
    light: &'a Light,
}

/// Movement of the pixel's ray and the shadow ray's origin.
#[derive(Clone, Copy, Debug, Default)]
struct Moved {
    /// Movement of the image, pixels.
    pixels: DVec2,
    /// Movement of the ray's origin, in multiples of the traced offset: along two axes of the
    /// surface, and up.
    offsets: DVec3,
}

/// Ray from the camera.
struct OracleRay {
    origin: DVec3,
    direction: DVec3,
}

/// Intersection of a ray with a triangle.
struct Hit {
    /// Distance, in lengths of the ray's direction.
    t: f64,
    id: u32,
}

impl<'a> Oracle<'a> {
    pub(super) fn new(geometry: &Geometry, camera: &'a Camera, light: &'a Light) -> Self {
        let mut corners = Vec::new();
        for i in 0..geometry.triangles().len() as u32 {
            corners.push(geometry.corners(i).map(Vec3::as_dvec3));
        }
        Self {
            corners,
            casters: geometry.casters(),
            receivers: geometry.receivers(),
            camera,
            light,
        }
    }

    /// Returns the fraction of the light visible from a pixel: 0 if it is unlit, 1 without a
    /// receiver. `shown` is the triangle that the pixel shows, or `None` to find it.
    ///
    /// Rays to area lights start at the traced offset. Truth doesn't mark casters that are closer to
    /// the surface, unlike those of ideal lights.
    pub(super) fn answer(&self, pixel: [u32; 2], shown: Option<u32>) -> f64 {
        let mut moved = Moved::default();
        if !self.light.is_ideal() {
            moved.offsets = DVec3::Z;
        }
        self.visibility(pixel, moved, shown)
    }

    fn visibility(&self, pixel: [u32; 2], moved: Moved, shown: Option<u32>) -> f64 {
        // Find the visible triangle.
        let ray = self.ray(center(pixel) + moved.pixels);
        let hit = match shown {
            Some(id) => Some(Hit {
                t: distance_to_plane(ray.origin, ray.direction, &self.corners[id as usize]),
                id,
            }),
            None => self.nearest(&ray),
        };
        let Some(hit) = hit.filter(|hit| self.receivers.contains(&hit.id)) else {
            return 1.0;
        };
        let eye = ray.origin;
        // Compute the shadow ray's origin.
        let p = eye + ray.direction * hit.t;
        let corners = self.corners[hit.id as usize];
        let across = (corners[1] - corners[0])
            .cross(corners[2] - corners[0])
            .normalize();
        let normal = if across.dot(ray.direction) > 0.0 {
            -across
        } else {
            across
        };
        let (u, v) = normal.any_orthonormal_pair();
        let nearby = (eye - p).length().max(p.abs().max_element());
        let farthest = corners
            .map(|c| (c - p).abs().max_element())
            .into_iter()
            .fold(0.0, f64::max);
        // Corners count while their rounding is within the pixel's resolution.
        let resolution = CORNERS_SHARE * self.width_of_pixel(pixel, hit.t);
        let length = if f64::from(LIFT) * farthest <= resolution {
            nearby.max(farthest)
        } else {
            nearby
        };
        let by = moved.offsets * length * f64::from(LIFT);
        // The least height keeps neighbours in the same plane, with rounded corners, from shadowing
        // each other.
        let o = p + u * by.x + v * by.y + normal * by.z.max(length * 2.0_f64.powi(-24));
        if self.is_outside_cone(o) {
            return 0.0;
        }
        let is_lit = |to_light: &DVec3| {
            normal.dot(*to_light) > 0.0 && !self.is_shadowed(o, *to_light, hit.id)
        };
        let Light::Rect { .. } = self.light else {
            let to_light = self.to_light(o, length.max(farthest));
            return f64::from(u8::from(is_lit(&to_light)));
        };
        // Points of the light below the surface's plane are not visible.
        let to_light: Vec<DVec3> = self.to_points_of_light(o).collect();
        let lit = to_light.iter().filter(|to_light| is_lit(to_light)).count();
        lit as f64 / to_light.len() as f64
    }

    /// Returns the distance between the rays of neighbouring pixels, `t` lengths of their directions
    /// from the camera.
    fn width_of_pixel(&self, pixel: [u32; 2], t: f64) -> f64 {
        let ray = self.ray(center(pixel));
        let next = self.ray(center(pixel) + DVec2::X);
        let end = ray.origin + ray.direction * t;
        (next.origin + next.direction * t - end).length()
    }

    /// Returns the first triangle that a ray intersects.
    fn nearest(&self, ray: &OracleRay) -> Option<Hit> {
        let mut nearest: Option<Hit> = None;
        for (id, corners) in (0..).zip(&self.corners) {
            let Some(t) = meets(ray.origin, ray.direction, corners) else {
                continue;
            };
            let is_nearer = nearest.as_ref().is_none_or(|hit| t < hit.t);
            if t > 1e-9 && is_nearer {
                nearest = Some(Hit { t, id });
            }
        }
        nearest
    }

    /// Returns whether any caster except the triangle `own` is between `o` and the light.
    fn is_shadowed(&self, o: DVec3, to_light: DVec3, own: u32) -> bool {
        self.casters.clone().filter(|&id| id != own).any(|id| {
            let t = meets(o, to_light, &self.corners[id as usize]);
            t.is_some_and(|t| (0.0..=1.0).contains(&t))
        })
    }

    /// Returns whether the visibility changes within `pixels` of the pixel's centre and `offsets`
    /// of the traced ray's offset, by `samples` random movements. If `shown` is given, no other
    /// triangle hides it, since rounding moves each triangle's image separately.
    pub(super) fn changes(
        &self,
        pixel: [u32; 2],
        shown: Option<u32>,
        pixels: f64,
        offsets: f64,
        samples: u32,
    ) -> bool {
        let unmoved = self.answer(pixel, shown);
        (0..samples).any(|i| {
            // Move the first ones to the border, along the axes.
            let angle;
            let share;
            if i < 4 {
                angle = 0.25 * f64::from(i);
                share = 1.0;
            } else {
                angle = random(pixel, i, 0);
                share = random(pixel, i, 1).sqrt();
            }
            let aside = DVec2::new(random(pixel, i, 2), random(pixel, i, 3)) * 2.0 - 1.0;
            let up = 2.0 * random(pixel, i, 4);
            let moved = Moved {
                pixels: DVec2::from_angle(std::f64::consts::TAU * angle) * pixels * share,
                offsets: aside.extend(up) * offsets,
            };
            // Skip moved rays that miss the given triangle.
            let is_outside = shown.is_some_and(|id| self.misses(pixel, moved, id));
            !is_outside && self.visibility(pixel, moved, shown) != unmoved
        })
    }

    fn misses(&self, pixel: [u32; 2], moved: Moved, id: u32) -> bool {
        let ray = self.ray(center(pixel) + moved.pixels);
        meets(ray.origin, ray.direction, &self.corners[id as usize]).is_none()
    }

    /// Returns the camera's ray through a point of the image, pixels from its top left.
    fn ray(&self, at: DVec2) -> OracleRay {
        let world_from_view =
            DAffine3::from_mat4(Mat4::from(self.camera.world_from_view).as_dmat4());
        let view_from_clip: DMat4 = self.camera.clip_from_view.as_dmat4().inverse();
        let ndc = DVec2::new(2.0, -2.0) * at / self.camera.size.as_dvec2() + DVec2::new(-1.0, 1.0);
        let near = view_from_clip.project_point3(ndc.extend(0.0));
        if self.camera.clip_from_view.row(3) == Vec4::W {
            return OracleRay {
                origin: world_from_view.transform_point3(near),
                direction: world_from_view.transform_vector3(-DVec3::Z),
            };
        }
        OracleRay {
            origin: world_from_view.translation,
            direction: world_from_view.transform_vector3(near / -near.z),
        }
    }

    fn to_light(&self, o: DVec3, length: f64) -> DVec3 {
        match *self.light {
            Light::Directional { direction, .. } => {
                -direction.as_dvec3().normalize() * 10.0 * length
            }
            Light::Point { position, .. } | Light::Spot { position, .. } => {
                (position.as_dvec3() - o) * f64::from(SHORT)
            }
            Light::Rect { .. } | Light::Disc { .. } => {
                panic!("the oracle has one ray to ideal lights only")
            }
        }
    }

    /// Returns the vectors from `o` to the centres of equal cells of a rectangular light.
    fn to_points_of_light(&self, o: DVec3) -> impl Iterator<Item = DVec3> {
        let Light::Rect {
            center,
            half_u,
            half_v,
            ..
        } = *self.light
        else {
            panic!("the oracle supports no other area lights")
        };
        let [center, half_u, half_v] = [center, half_u, half_v].map(Vec3::as_dvec3);
        let share = |i: u32| (2.0 * f64::from(i) + 1.0) / f64::from(LIGHT_SIDE) - 1.0;
        (0..LIGHT_SIDE * LIGHT_SIDE).map(move |i| {
            let u = half_u * share(i % LIGHT_SIDE);
            let v = half_v * share(i / LIGHT_SIDE);
            (center + u + v - o) * f64::from(SHORT)
        })
    }

    fn is_outside_cone(&self, o: DVec3) -> bool {
        match *self.light {
            Light::Spot {
                position,
                direction,
                outer,
                ..
            } => {
                let cosine = (o - position.as_dvec3())
                    .normalize()
                    .dot(direction.as_dvec3().normalize());
                cosine < f64::from(outer).cos()
            }
            Light::Directional { .. }
            | Light::Point { .. }
            | Light::Rect { .. }
            | Light::Disc { .. } => false,
        }
    }
}

/// Returns number `k` of movement `i` of a pixel, 0 to 1, the same on every run.
fn random(pixel: [u32; 2], i: u32, k: u32) -> f64 {
    f64::from(hash(hash(i * 8 + k) ^ pixel[0] ^ (pixel[1] << 16))) / 4_294_967_296.0
}

fn center(pixel: [u32; 2]) -> DVec2 {
    DVec2::new(f64::from(pixel[0]) + 0.5, f64::from(pixel[1]) + 0.5)
}

/// Returns the intersection of the line from `o` with a triangle, in lengths of `d`.
fn meets(o: DVec3, d: DVec3, corners: &[DVec3; 3]) -> Option<f64> {
    let [a, b, c] = corners.map(|v| v - o);
    let volumes = [d.dot(b.cross(c)), d.dot(c.cross(a)), d.dot(a.cross(b))];
    let inside = volumes.iter().all(|v| *v >= 0.0) || volumes.iter().all(|v| *v <= 0.0);
    let t = distance_to_plane(o, d, corners);
    (inside && t.is_finite()).then_some(t)
}

/// Returns the intersection of the line from `o` with a triangle's plane, in lengths of `d`.
fn distance_to_plane(o: DVec3, d: DVec3, corners: &[DVec3; 3]) -> f64 {
    let edge_1 = corners[1] - corners[0];
    let edge_2 = corners[2] - corners[0];
    let normal = edge_1.cross(edge_2);
    normal.dot(corners[0] - o) / normal.dot(d)
}
