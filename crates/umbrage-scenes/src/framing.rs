//! Cameras: from the keys of a file, or fitted to a model.

use umbrage_core::depth_range::{ViewPyramid, depth_range};
use umbrage_core::glam::{DVec3, UVec2, Vec3};
use umbrage_core::{Aabb, Camera, Geometry, Invalid, light_space::look_along};

/// Direction from which a model is framed: right, above and in front. Other sides are quarter turns
/// of it about y.
const THREE_QUARTER: DVec3 = DVec3::new(1.0, 0.7, 1.4);
/// Another quarter turn is preferred if more of the surface faces it, by this fraction of the
/// model's area.
const BETTER: f64 = 0.05;
/// A room is open to a side if more of its surface faces that side than away from it, by this
/// fraction of its area.
const OPEN: f64 = 0.08;
/// Empty border of a framed image, as a fraction of the image.
const BORDER: f64 = 0.04;

/// Angle of view that replaces a camera without perspective, degrees.
#[cfg(feature = "gltf")]
const NARROW_DEGREES: f32 = 20.0;

/// A pinhole camera whose near and far planes are not yet set.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shot {
    pub(crate) eye: Vec3,
    pub(crate) target: Vec3,
    pub(crate) up: Vec3,
    /// Full vertical angle, radians.
    pub(crate) fov_y: f32,
    pub(crate) size: UVec2,
}

impl Shot {
    /// Returns the shot of a camera. A camera without perspective has a narrow angle.
    #[cfg(feature = "gltf")]
    pub(crate) fn of_camera(camera: &Camera) -> Self {
        let camera = camera.standard();
        let axes = camera.world_from_view.matrix3;
        // The projection scales heights by the inverse of this tangent.
        let stretch = camera.clip_from_view.y_axis.y;
        let has_perspective = camera.clip_from_view.z_axis.w != 0.0;
        let fov_y = if has_perspective {
            2.0 * (1.0 / stretch).atan()
        } else {
            NARROW_DEGREES.to_radians()
        };
        Self {
            eye: camera.eye(),
            target: camera.eye() - Vec3::from(axes.z_axis),
            up: Vec3::from(axes.y_axis),
            fov_y,
            size: camera.size,
        }
    }

    /// Returns the camera. Missing near and far planes are fitted to the visible geometry.
    pub(crate) fn camera(
        &self,
        geometry: &Geometry,
        near_far: [Option<f32>; 2],
    ) -> Result<Camera, Invalid> {
        let near_far = match near_far {
            [Some(near), Some(far)] => [near, far],
            given => complete(given, self.fitted_range(geometry)?),
        };
        Camera::perspective(
            self.eye,
            self.target,
            self.up,
            self.fov_y,
            near_far,
            self.size,
        )
    }

    fn fitted_range(&self, geometry: &Geometry) -> Result<[f32; 2], Invalid> {
        let view_from_world = look_along(self.eye, self.target - self.eye, self.up)
            .map_err(|e| e.within_context("camera"))?;
        let pyramid = ViewPyramid {
            view_from_world,
            tangents: self.tangents(),
        };
        let triangles = (0..geometry.triangles().len() as u32).map(|t| geometry.corners(t));
        let seen = depth_range(&pyramid, triangles);
        // Any range is suitable if only the sky is visible. The target's distance sets the scale.
        let distance = self.eye.distance(self.target);
        Ok(seen.unwrap_or([0.01 * distance, 100.0 * distance]))
    }

    fn tangents(&self) -> [f64; 2] {
        let up = (0.5 * f64::from(self.fov_y)).tan();
        [up * f64::from(self.size.x) / f64::from(self.size.y), up]
    }
}

/// Returns the near and far plane: the given ones, or fitted ones in the right order relative to
/// them.
fn complete(given: [Option<f32>; 2], fitted: [f32; 2]) -> [f32; 2] {
    let [near, far] = fitted;
    match given {
        [Some(given), None] => [given, far.max(2.0 * given)],
        [None, Some(given)] => [near.min(0.5 * given), given],
        _ => [near, far],
    }
}

/// Returns the closest shot from a three-quarter view that contains all of the geometry. `None`
/// without geometry.
pub(crate) fn frame(geometry: &Geometry, fov_y: f32, size: UVec2) -> Option<Shot> {
    frame_from(
        best_side(geometry),
        geometry.positions().iter().copied(),
        fov_y,
        size,
    )
}

/// Returns the closest shot from this side that contains all points. `side` is the direction from
/// the target to the eye, of any length. `None` without points.
pub(crate) fn frame_from(
    side: DVec3,
    points: impl Iterator<Item = Vec3> + Clone,
    fov_y: f32,
    size: UVec2,
) -> Option<Shot> {
    let bounds = Aabb::from_points(points.clone());
    if bounds.is_empty() {
        return None;
    }
    let origin = bounds.center().as_dvec3();
    let forward = -side.normalize();
    let right = forward.cross(DVec3::Y).normalize();
    let up = right.cross(forward);
    let mut shot = Shot {
        eye: Vec3::ZERO,
        target: Vec3::ZERO,
        up: Vec3::Y,
        fov_y,
        size,
    };
    let [tx, ty] = shot.tangents().map(|t| t * (1.0 - 2.0 * BORDER));
    // A side of the view pyramid from an eye at (x, y, depth) contains all points if, for the right
    // side, `p.x - p.depth tx <= x - depth tx`. Only the greatest such number of each side matters.
    // Two opposite sides that touch their points determine x, or y, and a depth.
    let mut right_most = f64::NEG_INFINITY;
    let mut left_most = f64::NEG_INFINITY;
    let mut top = f64::NEG_INFINITY;
    let mut bottom = f64::NEG_INFINITY;
    for p in points {
        let p = p.as_dvec3() - origin;
        let x = p.dot(right);
        let y = p.dot(up);
        let depth = p.dot(forward);
        right_most = right_most.max(x - depth * tx);
        left_most = left_most.max(-x - depth * tx);
        top = top.max(y - depth * ty);
        bottom = bottom.max(-y - depth * ty);
    }
    let depth_of_width = -(right_most + left_most) / (2.0 * tx);
    let depth_of_height = -(top + bottom) / (2.0 * ty);
    // Choose the farther one, which contains all points.
    let depth = depth_of_width.min(depth_of_height);
    let x = 0.5 * (right_most - left_most);
    let y = 0.5 * (top - bottom);
    let eye = origin + right * x + up * y + forward * depth;
    shot.eye = eye.as_vec3();
    shot.target = (eye - forward * depth).as_vec3();
    (shot.eye != shot.target).then_some(shot)
}

/// Returns a view nearly straight into a room that is open to one side, along x or z. `None` if
/// there is no such side.
pub(crate) fn opening_side(geometry: &Geometry) -> Option<DVec3> {
    let (on_balance, area) = vector_area(geometry);
    let level = on_balance.with_y(0.0);
    let towards = if level.x.abs() >= level.z.abs() {
        DVec3::X * level.x.signum()
    } else {
        DVec3::Z * level.z.signum()
    };
    let across = DVec3::Y.cross(towards);
    let is_open = level.dot(towards) > OPEN * area;
    is_open.then_some(towards + 0.25 * across + 0.2 * DVec3::Y)
}

/// Returns the sum of the triangles' area vectors, and the sum of their lengths, both times two.
fn vector_area(geometry: &Geometry) -> (DVec3, f64) {
    let mut on_balance = DVec3::ZERO;
    let mut area = 0.0;
    for t in 0..geometry.triangles().len() as u32 {
        let [a, b, c] = geometry.corners(t).map(|p| p.as_dvec3());
        let n = (b - a).cross(c - a);
        on_balance += n;
        area += n.length();
    }
    (on_balance, area)
}

/// Returns the three-quarter view that most of the surface faces. All views are equal for closed
/// solids, whose area vectors add up to zero. A room without outer surfaces that is open to one
/// side is seen through its opening.
pub(crate) fn best_side(geometry: &Geometry) -> DVec3 {
    let (vector_area, area) = vector_area(geometry);
    let mut best = THREE_QUARTER;
    let mut side = THREE_QUARTER;
    for _ in 0..3 {
        // Turn a quarter about y.
        side = DVec3::new(side.z, side.y, -side.x);
        if vector_area.dot(side - best) > BETTER * area {
            best = side;
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::primitives::block;
    use umbrage_core::glam::Affine3A;
    use umbrage_core::{Instance, Mesh, Scene};

    fn side_of(mesh: Mesh) -> DVec3 {
        let instances = vec![Instance::new(0, Affine3A::IDENTITY)];
        best_side(
            &Geometry::bake(&Scene {
                meshes: vec![mesh],
                instances,
                ..Scene::default()
            })
            .unwrap(),
        )
    }

    /// A box with inner surfaces only, open to one side.
    fn room(axis: usize, sign: f32) -> Mesh {
        let mut mesh = block(Vec3::NEG_ONE, Vec3::ONE);
        mesh.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        let open = |t: &[u32; 3]| t.iter().all(|&v| mesh.positions[v as usize][axis] == sign);
        mesh.triangles.retain(|t| !open(t));
        mesh
    }

    #[test]
    fn solids_are_seen_from_the_front_and_rooms_through_their_opening() {
        assert_eq!(side_of(block(Vec3::NEG_ONE, Vec3::ONE)), THREE_QUARTER);
        for (axis, sign) in [(0, 1.0), (0, -1.0), (2, 1.0), (2, -1.0)] {
            let side = side_of(room(axis, sign));
            assert!(
                side[axis] * f64::from(sign) > 1.0,
                "open to {sign} along {axis}: seen from {side}"
            );
        }
    }
}
