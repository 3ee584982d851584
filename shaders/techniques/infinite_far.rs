//! View of the camera without a far plane, for geometry at infinity.
//!
//! Everitt and Kilgard 2002, "Practical and robust stenciled shadow volumes": with the far plane at
//! infinity, clip z is w minus a constant. Here clip z is slightly smaller, so that rounding never
//! gives a depth of 1 or more. No such projection exists without perspective; a [`FarClampPlane`]
//! is used instead.

use glam::{DMat4, DVec3, DVec4, Mat4, Vec4};
use umbrage_core::{
    Geometry, LightSpace, NO_TRIANGLE, Receivers, View,
    depth_range::{ViewPyramid, depth_range},
};

/// Slack of planes that must not cut visible geometry, as a fraction of their distance.
const SLACK: f64 = 1e-3;

/// Depth of a point at infinity: less than 1 by 16 times the rounding error of devices.
const DEPTH_AT_INFINITY: f32 = 1.0 - 1.0 / 1_048_576.0;

/// Light space of the camera, changed so that nothing is beyond the far plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct InfiniteFarView {
    /// Projection to the camera's pixels with different depths.
    pub(crate) space: LightSpace,
    /// Plane onto which more distant geometry is flattened; `None` with perspective.
    pub(crate) clamp_plane: Option<FarClampPlane>,
}

/// Plane across the view, beyond all geometry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FarClampPlane {
    /// Unit vector along the view.
    pub(crate) forward: DVec3,
    /// Row whose dot product with a homogeneous point is its distance along the view, times its w.
    pub(crate) depth: DVec4,
    /// Distance of the plane along the view, metres.
    pub(crate) distance: f64,
}

impl InfiniteFarView {
    /// Returns the space for the part of a geometry that a view sees. Its near plane is just before
    /// the nearest visible geometry, since depth is rounded to about 2^-23 w^2 / near.
    pub(crate) fn new(view: &View<'_>, geometry: &Geometry) -> Self {
        let space = view.camera.space();
        if space.clip_from_view.row(3) == Vec4::W {
            return Self::orthographic(space, geometry);
        }
        let nearest = match view.receivers {
            Some(receivers) => nearest_pixel(&space, receivers),
            None => nearest_triangle(&space, geometry),
        };
        Self {
            space: infinite_perspective(space, nearest * (1.0 - SLACK)),
            clamp_plane: None,
        }
    }

    /// Returns the rounding error of depths at this distance along the view, metres. It is a unit
    /// in the last place of depths in 0.5..1 (2^-24) for the drawn depth, and another for the
    /// compared depth.
    pub(crate) fn rounding(&self, distance: f64) -> f64 {
        let m = self.space.clip_from_view.as_dmat4();
        let per_metre = match self.clamp_plane {
            Some(_) => m.z_axis.z.abs(),
            // Depth is 1 - near / distance.
            None => -m.w_axis.z / m.z_axis.w.abs() / (distance * distance),
        };
        1.0 / f64::from(1 << 23) / per_metre
    }

    fn orthographic(space: LightSpace, geometry: &Geometry) -> Self {
        let view = space.view_from_world.as_dmat4();
        let depth = -view.row(2);
        let farthest = geometry
            .bounds()
            .corners()
            .map(|p| depth.dot(p.as_dvec3().extend(1.0)))
            .fold(0.0, f64::max);
        let m = space.clip_from_view.as_dmat4();
        let near = m.w_axis.z / m.z_axis.z;
        let distance = near + (farthest - near).max(1.0 / m.z_axis.z.abs()) * (1.0 + SLACK);
        // Place the clamp plane halfway to the new far plane, so that rounding moves nothing beyond
        // that.
        let per_metre = 0.5 / (distance - near);
        let mut clip_from_view = m;
        clip_from_view.z_axis.z = -per_metre;
        clip_from_view.w_axis.z = -near * per_metre;
        let clamp_plane = FarClampPlane {
            forward: depth.truncate(),
            depth,
            distance,
        };
        Self {
            space: LightSpace {
                clip_from_view: clip_from_view.as_mat4(),
                ..space
            },
            clamp_plane: Some(clamp_plane),
        }
    }
}

/// Returns the space with an infinite far plane: clip z becomes w minus its value on the near
/// plane, times [`DEPTH_AT_INFINITY`]. The near plane is at least `nearest` metres away.
fn infinite_perspective(space: LightSpace, nearest: f64) -> LightSpace {
    let m = space.clip_from_view;
    let own_near = w_at_near(&m);
    let w_per_metre = f64::from(-m.z_axis.w);
    let near = if nearest.is_finite() {
        own_near.max(nearest * w_per_metre)
    } else {
        own_near
    };
    let mut clip_from_view = m;
    clip_from_view.x_axis.z = DEPTH_AT_INFINITY * m.x_axis.w;
    clip_from_view.y_axis.z = DEPTH_AT_INFINITY * m.y_axis.w;
    clip_from_view.z_axis.z = DEPTH_AT_INFINITY * m.z_axis.w;
    clip_from_view.w_axis.z = DEPTH_AT_INFINITY * (m.w_axis.w - near as f32);
    LightSpace {
        clip_from_view,
        ..space
    }
}

/// Returns clip w where clip z is 0, at the centre of the image.
fn w_at_near(clip_from_view: &Mat4) -> f64 {
    let m: DMat4 = clip_from_view.as_dmat4();
    let p = m.inverse() * DVec4::W;
    1.0 / p.w
}

/// Returns the distance along the view to the nearest visible geometry, metres; infinite if there
/// is none.
fn nearest_pixel(space: &LightSpace, receivers: &Receivers) -> f64 {
    let depth = -space.view_from_world.as_dmat4().row(2);
    let seen = (0..receivers.len()).filter(|&i| receivers.triangle[i] != NO_TRIANGLE);
    seen.map(|i| depth.dot(receivers.position(i).as_dvec3().extend(1.0)))
        .fold(f64::INFINITY, f64::min)
}

/// Returns the least distance along the view of all parts of triangles within the camera's pyramid.
fn nearest_triangle(space: &LightSpace, geometry: &Geometry) -> f64 {
    let m = space.clip_from_view.as_dmat4();
    let own_near = w_at_near(&space.clip_from_view);
    // Use the wider half if the projection's centre is shifted.
    let tangents = [
        (m.z_axis.w.abs() + m.z_axis.x.abs()) / m.x_axis.x.abs(),
        (m.z_axis.w.abs() + m.z_axis.y.abs()) / m.y_axis.y.abs(),
    ];
    let pyramid = ViewPyramid {
        view_from_world: space.view_from_world,
        tangents,
    };
    let row = space.view_from_world.row(2);
    let mut nearest = f32::INFINITY;
    for t in 0..geometry.triangles().len() as u32 {
        let corners = geometry.corners(t);
        let first = corners
            .map(|p| -row.dot(p.extend(1.0)))
            .into_iter()
            .fold(f32::INFINITY, f32::min);
        // Most triangles are farther than the current nearest: clip only the others.
        if first < nearest && f64::from(nearest) > own_near {
            let range = depth_range(&pyramid, std::iter::once(corners));
            nearest = range.map_or(nearest, |[near, _]| nearest.min(near));
        }
    }
    f64::from(nearest)
}
