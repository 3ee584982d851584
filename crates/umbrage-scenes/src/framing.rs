//! Cameras: from a file's words, or found for a model.

use umbrage_core::depth_range::{ViewPyramid, depth_range};
use umbrage_core::glam::{DVec3, UVec2, Vec3};
use umbrage_core::{Camera, Geometry, Invalid, light_space::look_along};

/// Where a framed model is seen from: right, above and in front; or the same turned by quarters about y.
const THREE_QUARTER: DVec3 = DVec3::new(1.0, 0.7, 1.4);
/// The part of a model's area that must face another quarter more, for that to be preferred.
const BETTER: f64 = 0.05;
/// The part of a framed picture that is kept free on each side.
const BORDER: f64 = 0.04;

/// A pinhole camera whose near and far planes are still open.
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
    /// The camera; near and far are fitted to what is seen where they aren't given.
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
            .map_err(|e| e.within("camera"))?;
        let triangles = (0..geometry.triangles().len() as u32).map(|t| geometry.corners(t));
        let seen = depth_range(
            &ViewPyramid {
                view_from_world,
                tangents: self.tangents(),
            },
            triangles,
        );
        // Only sky: any range does, and the target tells the scale.
        let distance = self.eye.distance(self.target);
        Ok(seen.unwrap_or([0.01 * distance, 100.0 * distance]))
    }

    fn tangents(&self) -> [f64; 2] {
        let up = (0.5 * f64::from(self.fov_y)).tan();
        [up * f64::from(self.size.x) / f64::from(self.size.y), up]
    }
}

/// Returns the near and far plane: those that are given, else fitted ones, kept on the right side of the given one.
fn complete(given: [Option<f32>; 2], fitted: [f32; 2]) -> [f32; 2] {
    let [near, far] = fitted;
    match given {
        [Some(given), None] => [given, far.max(2.0 * given)],
        [None, Some(given)] => [near.min(0.5 * given), given],
        _ => [near, far],
    }
}

/// A shot from a three-quarter view that sees all of the geometry, as near as that allows. None without any geometry.
pub(crate) fn frame(geometry: &Geometry, fov_y: f32, size: UVec2) -> Option<Shot> {
    let bounds = geometry.bounds();
    let origin = (!bounds.is_empty()).then(|| bounds.center().as_dvec3())?;
    let forward = -best_side(geometry).normalize();
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
    // A pair of the pyramid's sides touches the points where these reach furthest; the eye's place follows.
    let mut reach = [f64::NEG_INFINITY; 4];
    for p in geometry.positions() {
        let p = p.as_dvec3() - origin;
        let x = p.dot(right);
        let y = p.dot(up);
        let depth = p.dot(forward);
        let ahead = [
            x - depth * tx,
            -x - depth * tx,
            y - depth * ty,
            -y - depth * ty,
        ];
        reach.iter_mut().zip(ahead).for_each(|(r, a)| *r = r.max(a));
    }
    let [right_most, left_most, top, bottom] = reach;
    let depth = (-(right_most + left_most) / (2.0 * tx)).min(-(top + bottom) / (2.0 * ty));
    let x = 0.5 * (right_most - left_most);
    let y = 0.5 * (top - bottom);
    let eye = origin + right * x + up * y + forward * depth;
    shot.eye = eye.as_vec3();
    shot.target = (eye - forward * depth).as_vec3();
    (shot.eye != shot.target).then_some(shot)
}

/// The three-quarter view that the surface faces most on balance. All are alike for closed solids, whose areas add up
/// to zero as vectors; a room without an outside that is open to one side is seen through its opening.
fn best_side(geometry: &Geometry) -> DVec3 {
    let mut vector_area = DVec3::ZERO;
    let mut area = 0.0;
    for t in 0..geometry.triangles().len() as u32 {
        let [a, b, c] = geometry.corners(t).map(|p| p.as_dvec3());
        let n = (b - a).cross(c - a);
        vector_area += n;
        area += n.length();
    }
    let DVec3 { x, y, z } = THREE_QUARTER;
    let sides = [(x, z), (z, -x), (-x, -z), (-z, x)].map(|(x, z)| DVec3::new(x, y, z));
    let better = |a: DVec3, b: DVec3| vector_area.dot(a - b) > BETTER * area;
    sides.into_iter().fold(
        THREE_QUARTER,
        |best, side| if better(side, best) { side } else { best },
    )
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

    /// A box that is seen only from inside, open towards one side.
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
