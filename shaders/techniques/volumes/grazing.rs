//! Lifting of light that grazes receiving planes, so that depth can resolve the volumes.
//!
//! A shadow volume's side is parallel to the light's rays. If these graze a plane by the sine s,
//! the sides of volumes on the plane, and of the plane itself, are within s x of it at the distance
//! x from the edge. For a directional light 1e-7 above a floor, this is a micrometre after ten
//! metres. Camera depth is rounded to about 2^-23 w^2 / near metres at the distance w. So the two
//! z-fight, and lit floors are inside their own volume.
//!
//! So volumes are built for a light that is moved off such planes, to [`GRAZE`] above them (or
//! below those that face away). This moves a shadow's edge by at most that fraction of its
//! distance, a hundredth of a pixel. It shortens no shadow on the plane to less than 1/GRAZE of its
//! caster's height. The test which surfaces face away uses the original light.

use crate::techniques::infinite_far::InfiniteFarView;
use glam::{DVec3, DVec4};
use umbrage_core::{Geometry, Receivers, View};

/// Sine of the angle to which light is lifted off a plane: 2^-17, .0004 degrees; 76 micrometres
/// after ten metres.
const GRAZE: f64 = 1.0 / 131_072.0;

/// Planes with a smaller share of the receiving area are ignored, since every light grazes some
/// facets of curved surfaces.
pub(crate) const MIN_SHARE: f64 = 0.001;

/// Maximum number of planes: with more the surface is curved, and each is small.
const MAX_PLANES: usize = 64;

/// Tolerance of planes: triangles are in one plane if their normals, and their distances along them
/// as a fraction of the greatest coordinate, differ by less than this. 2^-20 is the rounding of an
/// instance transform.
const SAME_PLANE: f64 = 1.0 / 1_048_576.0;

/// Light for which volumes are built, and the planes that it was lifted off.
#[derive(Clone, Debug)]
pub(crate) struct LiftedLight {
    /// Homogeneous light position or direction.
    pub(crate) light: DVec4,
    planes: Vec<GrazedPlane>,
    /// Length of the diagonal of the scene's bounds, metres.
    diagonal: f64,
}

/// Receiving plane that the light grazes.
#[derive(Clone, Copy, Debug)]
struct GrazedPlane {
    /// (n, d) with `n . p + d = 0`, n of unit length.
    plane: DVec4,
    /// Twice the area of its triangles, square metres.
    area: f64,
    /// Greatest distance of its corners from a light with a position, metres; 1 for directions.
    distance: f64,
}

impl LiftedLight {
    /// Lifts a homogeneous light off the planes that receive.
    pub(crate) fn new(geometry: &Geometry, light: DVec4) -> Self {
        let bounds = geometry.bounds();
        let reach = if bounds.is_empty() {
            0.0
        } else {
            f64::from(bounds.min.abs().max(bounds.max.abs()).max_element())
        };
        let mut planes = grazed_planes(geometry, light, reach);
        planes.sort_unstable_by(|a, b| b.area.total_cmp(&a.area));
        let light = lift(light, &planes);
        Self {
            light,
            planes,
            diagonal: f64::from(bounds.extent().length()),
        }
    }

    /// Returns the share of visible receivers that are on a grazed plane with too coarse depth.
    /// There, the rounding of depth exceeds the lift of the light over the whole scene, so volumes
    /// can't separate a plane from casters on it.
    pub(crate) fn share_lost(
        &self,
        view: &View<'_>,
        receivers: &Receivers,
        infinite_far: &InfiniteFarView,
    ) -> f64 {
        if self.planes.is_empty() {
            return 0.0;
        }
        let tolerance = SAME_PLANE * self.diagonal.max(f64::MIN_POSITIVE);
        let view_depth = -view.camera.space().view_from_world.as_dmat4().row(2);
        let mut all = 0_u64;
        let mut lost = 0_u64;
        for i in (0..receivers.len()).filter(|&i| receivers.receives[i]) {
            let p = receivers.position(i).as_dvec3().extend(1.0);
            all += 1;
            let too_coarse = infinite_far.rounding(view_depth.dot(p)) > GRAZE * self.diagonal;
            if too_coarse && self.is_on_plane(p, tolerance) {
                lost += 1;
            }
        }
        lost as f64 / all.max(1) as f64
    }

    /// Returns whether a homogeneous point (w = 1) is on a grazed plane.
    fn is_on_plane(&self, p: DVec4, tolerance: f64) -> bool {
        self.planes
            .iter()
            .any(|plane| plane.plane.dot(p).abs() <= tolerance)
    }
}

/// Returns the planes of receiving triangles that the light grazes but is not in, with more
/// than [`MIN_SHARE`] of the area. `reach` is the geometry's greatest coordinate, metres.
fn grazed_planes(geometry: &Geometry, light: DVec4, reach: f64) -> Vec<GrazedPlane> {
    let mut planes: Vec<GrazedPlane> = Vec::new();
    let mut area = 0.0;
    for t in geometry.receivers() {
        let [a, b, c] = geometry.corners(t).map(|p| p.as_dvec3());
        let n = (b - a).cross(c - a);
        let Some(unit) = n.try_normalize() else {
            continue;
        };
        area += n.length();
        // Skip planes that the light does not graze.
        let plane = unit.extend(-unit.dot(a));
        let distance = if light.w == 0.0 {
            1.0
        } else {
            let lamp = light.truncate();
            let nearer = lamp.distance(a).max(lamp.distance(b));
            nearer.max(lamp.distance(c))
        };
        let sine = plane.dot(light) / distance;
        if sine == 0.0 || sine.abs() >= GRAZE || planes.len() > MAX_PLANES {
            continue;
        }
        // Merge triangles in the same plane.
        match planes.iter_mut().find(|known| known.is_same(plane, reach)) {
            Some(known) => {
                known.area += n.length();
                known.distance = known.distance.max(distance);
            }
            None => planes.push(GrazedPlane {
                plane,
                area: n.length(),
                distance,
            }),
        }
    }
    // Drop small planes.
    planes.retain(|plane| plane.area > MIN_SHARE * area);
    planes
}

impl GrazedPlane {
    /// Returns whether it is the same plane, in either orientation.
    fn is_same(&self, other: DVec4, reach: f64) -> bool {
        let turned = if self.plane.truncate().dot(other.truncate()) < 0.0 {
            -other
        } else {
            other
        };
        let difference = self.plane - turned;
        difference.truncate().length() < SAME_PLANE && difference.w.abs() < SAME_PLANE * reach
    }
}

/// Moves a light off planes by the shortest way: along up to three linearly independent normals,
/// those of the largest planes first.
fn lift(light: DVec4, planes: &[GrazedPlane]) -> DVec4 {
    // Orthonormalise the normals in sequence (Gram and Schmidt): each plane moves the light along
    // the remainder of its normal.
    let mut basis: Vec<DVec3> = Vec::new();
    let mut lifted = light;
    for plane in planes {
        let n = plane.plane.truncate();
        let mut rest = n;
        for direction in &basis {
            rest -= *direction * rest.dot(*direction);
        }
        // The normal is nearly in the span of the others: moving along it would move the light far.
        if rest.length() < 0.1 {
            continue;
        }
        let side = plane.plane.dot(light).signum();
        let wanted = side * GRAZE * plane.distance;
        let along = (wanted - plane.plane.dot(lifted)) / rest.length_squared();
        lifted += (rest * along).extend(0.0);
        basis.push(rest.normalize());
        if basis.len() == 3 {
            break;
        }
    }
    lifted
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage_core::{
        Camera, Instance, Mesh, Scene,
        glam::{Affine3A, UVec2, Vec3},
    };

    /// Returns squares of 10 m, each from its corner and two sides.
    fn squares(corners: &[[Vec3; 3]]) -> Geometry {
        let mut scene = Scene::default();
        for (i, &[p, u, v]) in corners.iter().enumerate() {
            let positions = vec![p, p + u * 10.0, p + u * 10.0 + v * 10.0, p + v * 10.0];
            let mesh = Mesh::new("square", positions, vec![[0, 1, 2], [0, 2, 3]]);
            scene.meshes.push(mesh.expect("valid"));
            scene.instances.push(Instance::new(i, Affine3A::IDENTITY));
        }
        Geometry::bake(&scene).expect("valid")
    }

    const FLOOR: [Vec3; 3] = [Vec3::ZERO, Vec3::Z, Vec3::X];
    const WALL: [Vec3; 3] = [Vec3::ZERO, Vec3::X, Vec3::Y];

    #[test]
    fn a_sun_that_grazes_planes_is_lifted_off_each_to_the_side_it_is_on() {
        let geometry = squares(&[FLOOR, WALL]);
        let lifted = LiftedLight::new(&geometry, DVec4::new(-1.0, 1e-7, -3e-7, 0.0)).light;
        assert!(
            (lifted - DVec4::new(-1.0, GRAZE, -GRAZE, 0.0)).length() < 1e-12,
            "{lifted}"
        );
        // Test planes at an acute angle, too.
        let slope = [Vec3::ZERO, Vec3::X, Vec3::new(0.0, 0.6, 0.8)];
        let geometry = squares(&[FLOOR, slope]);
        let lifted = LiftedLight::new(&geometry, DVec4::new(-1.0, 1e-7, 2e-7, 0.0)).light;
        let sines = [DVec3::Y, DVec3::new(0.0, 0.8, -0.6)].map(|n| lifted.truncate().dot(n));
        assert!(
            (sines[0] - GRAZE).abs() < 1e-12 && (sines[1] + GRAZE).abs() < 1e-12,
            "{sines:?}"
        );
    }

    #[test]
    fn a_lamp_is_lifted_in_proportion_to_how_far_it_shines() {
        let lifted = LiftedLight::new(&squares(&[FLOOR]), DVec4::new(5.0, 1e-6, 5.0, 1.0)).light;
        assert!(
            (lifted.y - GRAZE * 50.0_f64.sqrt()).abs() < 1e-9,
            "{lifted}"
        );
        assert_eq!(lifted.with_y(0.0), DVec4::new(5.0, 0.0, 5.0, 1.0));
    }

    #[test]
    fn light_that_grazes_nothing_or_lies_in_a_plane_stays() {
        let geometry = squares(&[FLOOR]);
        for light in [
            DVec4::new(-0.6, 0.8, 0.0, 0.0),
            DVec4::new(-1.0, 1e-4, 0.0, 0.0),
            DVec4::new(-1.0, 0.0, 0.0, 0.0),
        ] {
            assert_eq!(LiftedLight::new(&geometry, light).light, light);
        }
        // Add a facet with a thousandth of the area.
        let facet = [Vec3::ZERO, Vec3::X * 0.01, Vec3::Y * 0.01];
        let light = DVec4::new(-0.6, 0.8, 1e-7, 0.0);
        assert_eq!(
            LiftedLight::new(&squares(&[FLOOR, facet]), light).light,
            light
        );
    }

    /// From 30 m, depth resolves a lifted light's shadows. From 30 km, with the near plane at the
    /// eye, it doesn't.
    #[test]
    fn where_depth_is_too_coarse_there_is_no_hope() {
        let geometry = squares(&[FLOOR]);
        let lifted = LiftedLight::new(&geometry, DVec4::new(-1.0, 1e-7, 0.0, 0.0));
        let size = UVec2::new(2, 1);
        let share = |distance: f32| {
            let eye = Vec3::new(5.0, distance, 5.0);
            let camera = Camera::perspective(
                eye,
                Vec3::new(5.0, 0.0, 5.0),
                Vec3::X,
                0.5,
                [1.0, 1e6],
                size,
            )
            .expect("valid");
            let mut receivers = Receivers::empty(size);
            receivers.x = vec![5.0, 5.0];
            // One is on the floor, the other in front of the eye.
            receivers.y = vec![0.0, distance - 1.0];
            receivers.z = vec![5.0, 5.0];
            receivers.triangle = vec![0, 1];
            receivers.receives = vec![true, true];
            let light = umbrage_core::Light::Directional {
                direction: Vec3::X,
                angular_diameter: 0.0,
            };
            let view = View::new(&camera, &light, &geometry).with_receivers(&receivers);
            lifted.share_lost(&view, &receivers, &InfiniteFarView::new(&view, &geometry))
        };
        assert_eq!([share(30.0), share(30_000.0)], [0.0, 0.5]);
    }
}
