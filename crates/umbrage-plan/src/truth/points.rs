//! Truth at given points.

use super::{
    options::TruthOptions,
    pixel_ray::PixelRay,
    tracer::{Memory, Tracer},
};
use glam::{DVec2, Vec3};
use rayon::prelude::*;
use umbrage_core::{
    Camera, Geometry, Invalid, Light, NO_TRIANGLE, Receivers,
    invalid::finite,
    light_sample::{self, origin_offset},
};

/// Greatest extent of a triangle, in multiples of the coordinates of a point and its distance from
/// the eye, at which the ray's offset also covers the rounding of the triangle's own corners.
///
/// In 32 bits, the bound of an intersection's rounding is proportional to the corners' coordinates,
/// at any point of the triangle. On a ground of 200 km it is centimetres, and would leave out the
/// whole shadow of a box. Rays among larger triangles are therefore traced in 64 bits. Their offset
/// covers the coordinates of the point, and the position's actual error. Other rays keep the offset
/// of the `traced` technique, and its speed.
pub(super) const GIANT: f32 = 64.0;

/// Point that may be lit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReceiverPoint {
    /// World position, metres.
    pub position: Vec3,
    /// Geometric unit normal, on the visible side.
    pub normal: Vec3,
    /// Triangle that contains the point and never shadows it; [`NO_TRIANGLE`] if unknown.
    pub triangle: u32,
    /// Greatest length other than the position's coordinates whose rounding the ray's offset must
    /// exceed, metres: the distance to the eye, or the triangle's extent. The ray's offset is
    /// proportional to it.
    pub reach: f32,
    /// Rounding error of the position, metres, if the triangle is so large that the offset doesn't
    /// cover it; otherwise 0. It is mostly along the ray of the camera.
    pub position_error: Vec3,
    /// Scrambling seed of the samples: [`light_sample::seed`].
    pub seed: u32,
}

impl ReceiverPoint {
    /// Returns a point without a camera. Its ray's offset is proportional to the whole geometry.
    pub fn new(position: Vec3, normal: Vec3, geometry: &Geometry) -> Self {
        let bounds = geometry.bounds();
        let reach = bounds.min.abs().max(bounds.max.abs()).max_element();
        let seed = light_sample::seed(
            position.x.to_bits() ^ position.y.to_bits(),
            position.z.to_bits(),
        );
        Self {
            position,
            normal,
            triangle: NO_TRIANGLE,
            reach: if reach.is_finite() { reach } else { 0.0 },
            position_error: Vec3::ZERO,
            seed,
        }
    }

    /// Returns the point that a camera sees at pixel `i`.
    ///
    /// # Panics
    /// Panics if there is no such pixel, or it shows nothing.
    pub fn of_pixel(camera: &Camera, geometry: &Geometry, receivers: &Receivers, i: usize) -> Self {
        let position = receivers.position(i);
        let triangle = receivers.triangle[i];
        let corners = geometry.corners(triangle);
        let x = i as u32 % receivers.size.x;
        let y = i as u32 / receivers.size.x;
        let to_eye = (camera.eye() - position).length();
        let farthest = corners
            .map(|corner| (corner - position).abs().max_element())
            .into_iter()
            .fold(0.0, f32::max);
        let is_giant = farthest > GIANT * to_eye.max(position.abs().max_element());
        let (reach, position_error) = if is_giant {
            (to_eye, rounding_of(camera, [x, y], position, corners))
        } else {
            (to_eye.max(farthest), Vec3::ZERO)
        };
        Self {
            position,
            normal: receivers.normal(i),
            triangle,
            reach,
            position_error,
            seed: light_sample::seed(x, y),
        }
    }

    /// Returns the offset of rays from the position along the normal, metres. It covers the
    /// position's distance from the plane of its triangle.
    pub(super) fn offset(&self) -> f32 {
        let from_plane = self.position_error.dot(self.normal).abs();
        origin_offset(self.position, self.reach) + from_plane
    }
}

/// Returns the vector from the exact intersection of the pixel's ray with the plane of its triangle,
/// computed in 64 bits, to a position; 0 if the ray is parallel to the plane.
fn rounding_of(camera: &Camera, pixel: [u32; 2], position: Vec3, corners: [Vec3; 3]) -> Vec3 {
    let ray = PixelRay::new(&camera.rays(), pixel, DVec2::ZERO);
    let exact = ray.on_plane(corners.map(Vec3::as_dvec3));
    exact.map_or(Vec3::ZERO, |exact| (position.as_dvec3() - exact).as_vec3())
}

/// Truth at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointTruth {
    /// Visible fraction of the light, 0..=1.
    pub visibility: f32,
    /// Standard error of the visibility; 0 for ideal lights.
    pub error: f32,
    /// True if the point faces entirely away from the light or is outside a spot's outer cone.
    pub unlit: bool,
}

impl PointTruth {
    /// Truth of pixels without a receiver.
    pub(super) const NOTHING: Self = Self {
        visibility: 1.0,
        error: 0.0,
        unlit: false,
    };
}

/// Traces truth at given points, on all cores.
///
/// # Errors
/// Errors if the light is not valid, or a point has numbers that are not finite.
pub fn trace_points(
    geometry: &Geometry,
    light: &Light,
    points: &[ReceiverPoint],
    options: &TruthOptions,
) -> Result<Vec<PointTruth>, Invalid> {
    for (i, p) in points.iter().enumerate() {
        finite(
            &format!("point {i}"),
            &[p.position.to_array(), p.normal.to_array()].concat(),
        )?;
    }
    let tracer = Tracer::new(geometry, light, options)?;
    Ok(points
        .par_iter()
        .map_init(Memory::default, |memory, p| {
            tracer.trace_point(p, 1.0, memory)
        })
        .collect())
}

/// Pixels of an image at which truth is traced.
#[derive(Clone, Copy, Debug)]
pub struct TruthRequest<'a> {
    /// The camera.
    pub camera: &'a Camera,
    /// The triangles.
    pub geometry: &'a Geometry,
    /// Points visible to the camera.
    pub receivers: &'a Receivers,
    /// Indices of the pixels in the image.
    pub pixels: &'a [u32],
}

/// Number of pixels that one thread traces before it reports. Neighbours' rays often hit the same
/// occluder.
const CHUNK: usize = 256;

impl TruthRequest<'_> {
    /// Traces truth at the pixels, in order. `lift` multiplies the rays' offset.
    pub(super) fn trace(
        &self,
        tracer: &Tracer,
        lift: f32,
        report: &(dyn Fn(usize) + Sync),
    ) -> Vec<PointTruth> {
        let mut out = vec![PointTruth::NOTHING; self.pixels.len()];
        out.par_chunks_mut(CHUNK)
            .zip(self.pixels.par_chunks(CHUNK))
            .for_each(|(out, pixels)| {
                let mut memory = Memory::default();
                for (seen, &i) in out.iter_mut().zip(pixels) {
                    if !self.receivers.receives[i as usize] {
                        continue;
                    }
                    let point = ReceiverPoint::of_pixel(
                        self.camera,
                        self.geometry,
                        self.receivers,
                        i as usize,
                    );
                    *seen = tracer.trace_point(&point, lift, &mut memory);
                }
                report(pixels.len());
            });
        out
    }

    /// Returns for each pixel whether it shows an unlit receiver, without rays.
    pub(super) fn unlit_points(&self, tracer: &Tracer) -> Vec<bool> {
        self.pixels
            .par_iter()
            .map(|&i| {
                let i = i as usize;
                let point =
                    || ReceiverPoint::of_pixel(self.camera, self.geometry, self.receivers, i);
                self.receivers.receives[i] && tracer.is_unlit(&point())
            })
            .collect()
    }
}
