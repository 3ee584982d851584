//! Test support: what truth should say, found in another way. Every triangle is asked, in 64 bits, by the signs of volumes
//! (Segura, Feito 2001, "Algorithms to Test Ray-Triangle Intersection"): no hierarchy, no shear, no polygons.
//!
//! Its own rounding is some 2^-50 of the lengths in play, a millionth of what 32 bits round. It is sure of an answer if that
//! stays what it is while pixel and origin are moved about at random, within what it is told.

use glam::{DAffine3, DMat4, DVec2, DVec3, Mat4, Vec3, Vec4};
use std::ops::Range;
use umbrage_core::{
    Camera, Geometry, Light,
    light_sample::{LIFT, SHORT, hash},
};

pub(super) struct Oracle<'a> {
    corners: Vec<[DVec3; 3]>,
    casters: Range<u32>,
    receivers: Range<u32>,
    camera: &'a Camera,
    light: &'a Light,
}

/// How a pixel's question is moved.
#[derive(Clone, Copy, Debug, Default)]
struct Moved {
    /// The image, pixels.
    pixels: DVec2,
    /// The ray's origin, in multiples of the traced offset: along two axes of the surface, and up.
    offsets: DVec3,
}

impl<'a> Oracle<'a> {
    pub(super) fn new(geometry: &Geometry, camera: &'a Camera, light: &'a Light) -> Self {
        let corners = |i| geometry.corners(i).map(Vec3::as_dvec3);
        Self {
            corners: (0..geometry.triangles().len() as u32)
                .map(corners)
                .collect(),
            casters: geometry.casters(),
            receivers: geometry.receivers(),
            camera,
            light,
        }
    }

    /// The fraction of the light that a pixel sees: 0 where it is unlit, 1 where nothing receives. `shown` is the triangle
    /// that it shows, if that is not to be found out.
    pub(super) fn answer(&self, pixel: [u32; 2], shown: Option<u32>) -> f64 {
        self.ask(pixel, Moved::default(), shown)
    }

    fn ask(&self, pixel: [u32; 2], moved: Moved, shown: Option<u32>) -> f64 {
        let (eye, d) = self.ray(center(pixel) + moved.pixels);
        let distances = (0..)
            .zip(&self.corners)
            .filter_map(|(id, t)| Some((meets(eye, d, t)?, id)));
        let nearest = || {
            distances
                .filter(|(t, _)| *t > 1e-9)
                .min_by(|a, b| a.0.total_cmp(&b.0))
        };
        let on_plane = |id: u32| (distance_to_plane(eye, d, &self.corners[id as usize]), id);
        let first = shown.map(on_plane).or_else(nearest);
        let Some((t, id)) = first.filter(|(_, id)| self.receivers.contains(id)) else {
            return 1.0;
        };
        let p = eye + d * t;
        let corners = self.corners[id as usize];
        let across = (corners[1] - corners[0])
            .cross(corners[2] - corners[0])
            .normalize();
        let normal = if across.dot(d) > 0.0 { -across } else { across };
        let (u, v) = normal.any_orthonormal_pair();
        let lengths = corners.map(|c| (c - p).abs().max_element());
        let length = lengths
            .into_iter()
            .fold((eye - p).length().max(p.abs().max_element()), f64::max);
        let by = moved.offsets * length * f64::from(LIFT);
        // The least height keeps neighbours in the same plane, whose corners are rounded, from shadowing each other.
        let o = p + u * by.x + v * by.y + normal * by.z.max(length * 2.0_f64.powi(-24));
        let to_light = self.to_light(o, length);
        let lit = normal.dot(to_light) > 0.0 && !self.outside_cone(o);
        let hides = |id: u32| {
            meets(o, to_light, &self.corners[id as usize]).is_some_and(|t| (0.0..=1.0).contains(&t))
        };
        let seen = lit
            && !self
                .casters
                .clone()
                .any(|caster| caster != id && hides(caster));
        f64::from(u8::from(seen))
    }

    /// Whether the answer changes within `pixels` of the pixel's centre and `offsets` of the traced ray's offset, as far as
    /// `samples` of all the ways to move it tell. If the triangle that it shows is given, nothing hides that: rounding moves
    /// each triangle's image by itself.
    pub(super) fn changes(
        &self,
        pixel: [u32; 2],
        shown: Option<u32>,
        pixels: f64,
        offsets: f64,
        samples: u32,
    ) -> bool {
        let as_it_is = self.answer(pixel, shown);
        (0..samples).any(|i| {
            let random = |k: u32| {
                f64::from(hash(hash(i * 8 + k) ^ pixel[0] ^ (pixel[1] << 16))) / 4_294_967_296.0
            };
            // The first ones to the rim, along the axes.
            let (angle, share) = if i < 4 {
                (0.25 * f64::from(i), 1.0)
            } else {
                (random(0), random(1).sqrt())
            };
            let aside = DVec2::new(random(2), random(3)) * 2.0 - 1.0;
            let moved = Moved {
                pixels: DVec2::from_angle(std::f64::consts::TAU * angle) * pixels * share,
                offsets: aside.extend(2.0 * random(4)) * offsets,
            };
            let beside = shown.is_some_and(|id| self.misses(pixel, moved, id));
            !beside && self.ask(pixel, moved, shown) != as_it_is
        })
    }

    fn misses(&self, pixel: [u32; 2], moved: Moved, id: u32) -> bool {
        let (eye, d) = self.ray(center(pixel) + moved.pixels);
        meets(eye, d, &self.corners[id as usize]).is_none()
    }

    fn ray(&self, at: DVec2) -> (DVec3, DVec3) {
        let world_from_view =
            DAffine3::from_mat4(Mat4::from(self.camera.world_from_view).as_dmat4());
        let view_from_clip: DMat4 = self.camera.clip_from_view.as_dmat4().inverse();
        let ndc = DVec2::new(2.0, -2.0) * at / self.camera.size.as_dvec2() + DVec2::new(-1.0, 1.0);
        let near = view_from_clip.project_point3(ndc.extend(0.0));
        if self.camera.clip_from_view.row(3) == Vec4::W {
            return (
                world_from_view.transform_point3(near),
                world_from_view.transform_vector3(-DVec3::Z),
            );
        }
        (
            world_from_view.translation,
            world_from_view.transform_vector3(near / -near.z),
        )
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
                panic!("the oracle knows ideal lights alone")
            }
        }
    }

    fn outside_cone(&self, o: DVec3) -> bool {
        let Light::Spot {
            position,
            direction,
            outer,
            ..
        } = *self.light
        else {
            return false;
        };
        (o - position.as_dvec3())
            .normalize()
            .dot(direction.as_dvec3().normalize())
            < f64::from(outer).cos()
    }
}

fn center(pixel: [u32; 2]) -> DVec2 {
    DVec2::new(f64::from(pixel[0]) + 0.5, f64::from(pixel[1]) + 0.5)
}

/// Where along `d` the line from `o` meets a triangle.
fn meets(o: DVec3, d: DVec3, corners: &[DVec3; 3]) -> Option<f64> {
    let [a, b, c] = corners.map(|v| v - o);
    let volumes = [d.dot(b.cross(c)), d.dot(c.cross(a)), d.dot(a.cross(b))];
    let inside = volumes.iter().all(|v| *v >= 0.0) || volumes.iter().all(|v| *v <= 0.0);
    let t = distance_to_plane(o, d, corners);
    (inside && t.is_finite()).then_some(t)
}

/// Where along `d` the line from `o` meets a triangle's plane.
fn distance_to_plane(o: DVec3, d: DVec3, corners: &[DVec3; 3]) -> f64 {
    let edge_1 = corners[1] - corners[0];
    let edge_2 = corners[2] - corners[0];
    let normal = edge_1.cross(edge_2);
    normal.dot(corners[0] - o) / normal.dot(d)
}
