//! Receivers without a camera.

use crate::{
    gbuffer::receivers::{NO_TRIANGLE, Receivers},
    geometry::Geometry,
    invalid::Invalid,
    scene::{
        anchor::Anchor,
        camera::{Camera, MAX_SIDE},
        light::Light,
    },
    view::View,
};
use glam::{DVec3, UVec2, Vec3};

/// Points per row of the image that holds them.
const WIDTH: usize = 1024;

/// Points, with normals or without, as receivers of techniques that trace rays or test triangles:
/// `Traced`, `Exact` and `Soft`. There is no camera, and answers depend on none.
///
/// Rays start above a point by what the rounding of its own position needs. Points are sorted, so
/// that neighbours in space are neighbours in memory; [`PointReceivers::in_rows`] restores the
/// caller's order.
///
/// For lit areas and hours of sun, with stated errors, see the crate `umbrage-surfaces`.
#[derive(Clone, Debug)]
pub struct PointReceivers {
    /// At the origin: `ray_origin` then lifts rays by the point's distance from there.
    camera: Camera,
    receivers: Receivers,
    /// The caller's row of each pixel.
    rows: Vec<u32>,
}

impl PointReceivers {
    /// Returns the receivers of a light at points (world space, metres). `normals` may have any
    /// length. A point without a normal, if `normals` is `None`, faces the light: light from both
    /// sides counts. Geometry and light are relative to the same anchor.
    ///
    /// # Errors
    /// Errors if there are no points or too many, if there are more or fewer normals than points,
    /// with the first normal that is zero, or with the first number that is not finite. Errors if a
    /// position is rounded by more than `max_error_m` metres.
    pub fn new(
        points: &[DVec3],
        normals: Option<&[Vec3]>,
        light: &Light,
        anchor: Anchor,
        max_error_m: f32,
    ) -> Result<Self, Invalid> {
        let most = WIDTH * MAX_SIDE as usize;
        let counts = [points.len(), normals.map_or(points.len(), <[Vec3]>::len)];
        if points.is_empty() || points.len() > most || counts[0] != counts[1] {
            let why = format!("are {} with {} normals", counts[0], counts[1]);
            let help = format!("use 1 to {most}, with a normal for each or none");
            return Err(Invalid::new("points", why, help));
        }
        let mut rows: Vec<u32> = (0..points.len() as u32).collect();
        let low = points.iter().fold(DVec3::INFINITY, |low, p| low.min(*p));
        let high = points
            .iter()
            .fold(DVec3::NEG_INFINITY, |high, p| high.max(*p));
        let cells = 255.0 / (high - low).max_element().max(f64::MIN_POSITIVE);
        // Morton codes of 8 bits along each axis.
        rows.sort_by_cached_key(|&row| {
            let cell = ((points[row as usize] - low) * cells).as_uvec3().to_array();
            (0..24).fold(0_u32, |code, bit| {
                code | (cell[bit % 3] >> (bit / 3) & 1) << bit
            })
        });
        let height = points.len().div_ceil(WIDTH);
        let mut receivers = Receivers::empty(UVec2::new(WIDTH as u32, height as u32));
        for (i, &row) in rows.iter().enumerate() {
            let exact = points[row as usize] - anchor.point();
            let position = exact.as_vec3();
            let loss = (exact - position.as_dvec3()).abs().max_element();
            // False if a number is not finite.
            let is_held = loss <= f64::from(max_error_m);
            if !is_held {
                let why = format!(
                    "is {} and loses {loss:.1e} m in 32 bits",
                    points[row as usize]
                );
                let help = "use finite positions, an anchor nearby, or a greater `max_error_m`";
                return Err(Invalid::new(format!("point {row}"), why, help));
            }
            let normal = match normals {
                Some(normals) => normals[row as usize]
                    .as_dvec3()
                    .normalize_or_zero()
                    .as_vec3(),
                None => light.direction_from(position).normalize_or_zero(),
            };
            if normal == Vec3::ZERO {
                let help = "use directions, or no normals for both sides";
                return Err(Invalid::new(format!("normal {row}"), "is zero", help));
            }
            [receivers.x[i], receivers.y[i], receivers.z[i]] = position.to_array();
            [receivers.nx[i], receivers.ny[i], receivers.nz[i]] = normal.to_array();
            receivers.receives[i] = true;
            receivers.triangle[i] = NO_TRIANGLE;
        }
        let near_far = [1.0, 2.0];
        let size = receivers.size;
        Ok(Self {
            camera: Camera::perspective(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, 1.0, near_far, size)?,
            receivers,
            rows,
        })
    }

    /// Returns the view of these points, for [`ShadowTechnique::recipe`] and [`Backend::render`].
    ///
    /// [`ShadowTechnique::recipe`]: crate::ShadowTechnique::recipe
    /// [`Backend::render`]: crate::Backend::render
    pub fn view<'a>(&'a self, light: &'a Light, geometry: &'a Geometry) -> View<'a> {
        View::new(&self.camera, light, geometry).with_receivers(&self.receivers)
    }

    /// Returns the values of a mask of this view, one for each of the caller's points.
    ///
    /// # Panics
    /// Panics if the mask has fewer pixels than there are points.
    pub fn in_rows(&self, mask: &[f32]) -> Vec<f32> {
        let mut out = vec![0.0; self.rows.len()];
        for (&row, &visibility) in self.rows.iter().zip(&mask[..self.rows.len()]) {
            out[row as usize] = visibility;
        }
        out
    }
}
