//! Fitting light spaces: where a shadow map's texels go.

use crate::{
    Aabb, Invalid, Light, PlanError, View,
    depth_range::{Pyramid, depth_range},
    layout::{Layout, LightSpaces, cube_face_views},
    light_space::{Extents, LightSpace, look_along, orthographic, perspective},
};
use glam::{Mat4, Vec3};

/// How a single light space is laid around a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Fit {
    /// As tight as it goes without changing any shadow: sideways around what both casts and is seen to receive, in
    /// depth from the first caster to the last seen receiver.
    #[default]
    Tight,
    /// Textbook style: from `eye` along the light, with explicit extents. Perspective lights use `near` and `far` alone.
    Manual {
        /// Where depth is counted from, world space. Lights with a position use theirs instead.
        eye: Vec3,
        /// The volume, in the light's view space.
        extents: Extents,
    },
}

/// Widest half angle, degrees, of the cone that one perspective map may have to cover.
const WIDEST_HALF_ANGLE: f32 = 75.0;
/// Nearest plane of a perspective fit, as a fraction of its far plane: 2^-14. Depths there are still told apart to 2^-10 of
/// their distance; a caster nearer than that (.6 mm from a lamp over 10 m) is lost rather than everyone's precision.
const NEAREST: f32 = 1.0 / 16_384.0;

impl Fit {
    /// One light space for the view. `size` is the map's side in texels; `margin` is how far, in texels, a kernel
    /// reaches beyond the texel that a receiver falls on.
    ///
    /// # Errors
    /// `Unsupported` when casters surround the light, so that no single map can see them all; `Invalid` for bad input.
    pub fn light_space(&self, view: &View<'_>, size: u32, margin: f32) -> Result<LightSpace, PlanError> {
        match (self, *view.light) {
            (Self::Tight, Light::Directional { direction, .. }) => {
                Ok(tight_orthographic(view, direction, size, margin)?)
            }
            (Self::Manual { eye, extents }, Light::Directional { direction, .. }) => Ok(LightSpace {
                view_from_world: look_along(*eye, direction, Vec3::Y)?,
                clip_from_view: orthographic(*extents)?,
            }),
            (_, light) => self.perspective(view, &light, size, margin),
        }
    }

    /// The light spaces of a layout; parameters as [`Fit::light_space`].
    ///
    /// # Errors
    /// As [`Fit::light_space`]; and `Unsupported` for a cube around a light without a position.
    pub fn light_spaces(
        &self,
        layout: Layout,
        view: &View<'_>,
        size: u32,
        margin: f32,
    ) -> Result<LightSpaces, PlanError> {
        let single = || Ok(LightSpaces { spaces: vec![self.light_space(view, size, margin)?], needed: vec![true] });
        match (layout, view.light.position()) {
            (Layout::Single, _) | (Layout::Auto, None) => single(),
            (Layout::Cube, None) => {
                Err(PlanError::unsupported("a directional light has no place to put a cube around"))
            }
            (Layout::Cube, Some(eye)) => self.cube(view, eye, size, margin),
            (Layout::Auto, Some(eye)) => match single() {
                Err(PlanError::Unsupported(_)) => self.cube(view, eye, size, margin),
                other => other,
            },
        }
    }

    /// Six faces, each a little wider than 90 degrees, so that kernels never reach beyond the face they start in.
    fn cube(&self, view: &View<'_>, eye: Vec3, size: u32, margin: f32) -> Result<LightSpaces, PlanError> {
        if size as f32 - 2.0 * margin - 2.0 < size as f32 / WIDEST_HALF_ANGLE.to_radians().tan() && margin > 0.0 {
            return Err(PlanError::unsupported(format!(
                "a kernel that reaches {margin} texels is too wide for a cube's faces of {size}: use greater maps or a \
                 smaller kernel"
            )));
        }
        let half_angle = widened(45.0_f32.to_radians(), size, margin);
        let mut out = LightSpaces { spaces: Vec::new(), needed: Vec::new() };
        for view_from_world in cube_face_views(eye)? {
            let pyramid = Pyramid { view_from_world, tangents: [f64::from(half_angle.tan()); 2] };
            let [near, far] = match self {
                Self::Manual { extents, .. } => [extents.near, extents.far],
                Self::Tight => perspective_range(view, &view_from_world, half_angle),
            };
            let clip_from_view = perspective(2.0 * half_angle, 1.0, near, far)?;
            out.spaces.push(LightSpace { view_from_world, clip_from_view });
            out.needed.push(is_needed(view, &pyramid));
        }
        Ok(out)
    }

    fn perspective(&self, view: &View<'_>, light: &Light, size: u32, margin: f32) -> Result<LightSpace, PlanError> {
        let eye = light.position().unwrap_or_default();
        let (axis, half_angle) = match *light {
            Light::Spot { direction, outer, .. } => (direction, outer),
            _ => cone_around_casters(view, eye)?,
        };
        if half_angle.to_degrees() > WIDEST_HALF_ANGLE {
            return Err(PlanError::unsupported(format!(
                "the {} light needs a cone of {:.0} degrees (a spot its own, others one that holds all casters), and one \
                 map covers at most {:.0}: use `Layout::Cube`",
                light.kind(),
                2.0 * half_angle.to_degrees(),
                2.0 * WIDEST_HALF_ANGLE
            )));
        }
        let view_from_world = look_along(eye, axis, Vec3::Y)?;
        let widened = widened(half_angle, size, margin);
        let [near, far] = match self {
            Self::Manual { extents, .. } => [extents.near, extents.far],
            Self::Tight => perspective_range(view, &view_from_world, widened),
        };
        Ok(LightSpace { view_from_world, clip_from_view: perspective(2.0 * widened, 1.0, near, far)? })
    }
}

/// Wider by the kernel's reach, so that the outermost receivers' taps stay on the map.
fn widened(half_angle: f32, size: u32, margin: f32) -> f32 {
    let tangent = half_angle.tan() * size as f32 / (size as f32 - 2.0 * margin - 2.0).max(1.0);
    // A kernel as wide as the map would open the angle without end.
    tangent.atan().min(WIDEST_HALF_ANGLE.to_radians().max(half_angle))
}

/// Whether something casts and something seen receives within a cube's face.
fn is_needed(view: &View<'_>, pyramid: &Pyramid) -> bool {
    let Some(g) = view.geometry else { return true };
    let meets = |triangles: std::ops::Range<u32>| depth_range(pyramid, triangles.map(|t| g.corners(t))).is_some();
    let receives = || match view.receivers {
        Some(r) => r.positions().any(|p| pyramid.holds(p)),
        None => meets(g.receivers()),
    };
    meets(g.casters()) && receives()
}

fn points<'a>(
    view: &'a View<'_>,
    aabb: Aabb,
    triangles: impl Fn(&crate::Geometry) -> std::ops::Range<u32>,
) -> Box<dyn Iterator<Item = Vec3> + 'a> {
    match view.geometry {
        Some(g) => Box::new(g.vertices_of(triangles(g))),
        None => Box::new(aabb.corners()),
    }
}

fn caster_points<'a>(view: &'a View<'_>) -> Box<dyn Iterator<Item = Vec3> + 'a> {
    points(view, view.casters, crate::Geometry::casters)
}

/// What is seen if it is known, else all that may receive, else the casters themselves.
fn receiver_points<'a>(view: &'a View<'_>) -> Box<dyn Iterator<Item = Vec3> + 'a> {
    match view.receivers {
        Some(r) => Box::new(r.positions()),
        None => points(view, view.casters, crate::Geometry::receivers),
    }
}

/// Bounds in view space, grown so that the rounding of later lookups cannot put a point outside: by 2^-16 of their reach,
/// and by 8 units in the last place of the world coordinates that lookups start from.
fn bounds_in(view_from_world: &Mat4, points: impl Iterator<Item = Vec3>) -> Aabb {
    let view_from_world = glam::DAffine3::from_mat4(view_from_world.as_dmat4());
    let mut world = 0.0_f32;
    let mut b = Aabb::around(points.map(|p| {
        world = world.max(p.abs().max_element());
        view_from_world.transform_point3(p.as_dvec3()).as_vec3()
    }));
    let reach = b.min.abs().max(b.max.abs()).max_element();
    let pad = if reach.is_finite() { (reach / 65_536.0).max(world / 2_097_152.0) } else { 0.0 };
    (b.min, b.max) = (b.min - pad, b.max + pad);
    b
}

fn tight_orthographic(view: &View<'_>, direction: Vec3, size: u32, margin: f32) -> Result<LightSpace, Invalid> {
    // An eye amid the casters keeps numbers small when the scene is far from the origin.
    let eye = if view.casters.is_empty() { Vec3::ZERO } else { view.casters.center() };
    let view_from_world = look_along(eye, direction, Vec3::Y)?;
    let casters = bounds_in(&view_from_world, caster_points(view));
    let receivers = bounds_in(&view_from_world, receiver_points(view));
    let mut b = casters.intersection(&receivers);
    // View z falls away from the light: from the first caster (greatest z) to the last receiver (least z).
    (b.min.z, b.max.z) = (receivers.min.z, casters.max.z);
    if b.is_empty() {
        // Nothing can fall on anything: any space will do.
        b = Aabb { min: Vec3::splat(-1.0), max: Vec3::splat(1.0) };
    }
    let grow =
        (b.extent() / (size as f32 - 2.0 * margin - 2.0).max(1.0) * (margin + 1.0)).max(Vec3::splat(f32::MIN_POSITIVE));
    let extents = Extents {
        left: b.min.x - grow.x,
        right: b.max.x + grow.x,
        bottom: b.min.y - grow.y,
        top: b.max.y + grow.y,
        near: -b.max.z,
        far: -b.min.z,
    };
    Ok(LightSpace { view_from_world, clip_from_view: orthographic(extents)? })
}

/// The axis and half angle (radians) of a cone from `eye` that holds all casters.
fn cone_around_casters(view: &View<'_>, eye: Vec3) -> Result<(Vec3, f32), PlanError> {
    let directions = || caster_points(view).map(move |p| (p - eye).as_dvec3().normalize_or_zero());
    let sum: glam::DVec3 = directions().sum();
    let center = Aabb::around(caster_points(view)).center() - eye;
    let axis = if sum.length() > 1e-9 { sum.normalize() } else { center.as_dvec3().normalize_or(-glam::DVec3::Y) };
    let widest = directions().map(|d| d.dot(axis)).fold(1.0, f64::min);
    if view.casters.is_empty() {
        return Ok((Vec3::NEG_Y, 0.5));
    }
    let half_angle = widest.clamp(-1.0, 1.0).acos() as f32 + 1e-3;
    Ok((axis.as_vec3(), half_angle))
}

/// Distances along the view to the nearest caster and beyond the farthest receiver. The far plane is put at twice that
/// distance: perspective depth hardly depends on it, and rounding cannot push receivers beyond it.
fn perspective_range(view: &View<'_>, view_from_world: &Mat4, half_angle: f32) -> [f32; 2] {
    let casters = bounds_in(view_from_world, caster_points(view));
    let receivers = bounds_in(view_from_world, receiver_points(view));
    let far = if receivers.is_empty() { -casters.min.z } else { -receivers.min.z };
    let far = if far.is_finite() && far > 0.0 { 2.0 * far } else { 1.0 };
    let near = match view.geometry {
        Some(g) => {
            let tangents = [f64::from(half_angle.tan()); 2];
            let pyramid = Pyramid { view_from_world: *view_from_world, tangents };
            depth_range(&pyramid, g.casters().map(|t| g.corners(t))).map(|[near, _]| near)
        }
        // Of a box, nothing is known but its nearest corner.
        None => Some(-casters.max.z * 0.999).filter(|near| near.is_finite()),
    };
    [near.unwrap_or(far * 0.5).clamp(far * NEAREST, far * 0.5), far]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Camera, Geometry, Instance, Mesh, Scene, math::transform};
    use glam::{Affine3A, UVec2};

    /// A floor of 20 m through (0, 0, 0) and a small quad `h` above it.
    fn floor_and_quad(h: f32) -> Geometry {
        let corner = |x, z| Vec3::new(x, 0.0, z);
        let corners = vec![corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)];
        let quad = Mesh::new("quad", corners, vec![[0, 1, 2], [0, 2, 3]]).unwrap();
        let place = |scale: f32, y: f32| {
            let up = Affine3A::from_translation(Vec3::Y * y);
            Instance::new(0, up * Affine3A::from_scale(Vec3::new(scale, 1.0, scale)))
        };
        let instances = vec![place(10.0, 0.0), place(0.002, h)];
        let scene = Scene { name: "test".into(), meshes: vec![quad], instances, ..Scene::default() };
        Geometry::bake(&scene).unwrap()
    }

    fn spot(position: Vec3, direction: Vec3) -> Light {
        Light::Spot { position, direction, inner: 0.3, outer: 0.6, radius: 0.0 }
    }

    fn space(light: &Light, geometry: &Geometry) -> LightSpace {
        let size = UVec2::splat(8);
        let camera = Camera::perspective(Vec3::splat(9.0), Vec3::ZERO, Vec3::Y, 1.0, [0.1, 99.0], size).unwrap();
        Fit::Tight.light_space(&View::new(&camera, light, geometry), 1024, 1.0).unwrap()
    }

    /// The floor reaches behind the lamp's plane, but not into its cone above the ground.
    #[test]
    fn a_floor_that_crosses_the_lamps_plane_costs_no_precision() {
        let light = spot(Vec3::new(0.0, 5.0, 0.0), Vec3::new(0.6, -0.8, 0.0));
        let m = space(&light, &floor_and_quad(1.0)).clip_from_view;
        // depth = f/(f-n) (1 - n/distance): the near plane is where it is 0.
        let near = m.w_axis.z / m.z_axis.z;
        assert!(near > 3.5 && near < 4.2, "{near}");
    }

    /// However the lamp is tilted, and with a caster close to it, no receiver is pushed beyond the far plane.
    #[test]
    fn rounding_keeps_receivers_before_the_far_plane() {
        for i in 0..50 {
            let turn = i as f32 * 0.37;
            let direction = Vec3::new(turn.cos() * 0.4, -1.0, turn.sin() * 0.4);
            let geometry = floor_and_quad(4.99);
            let clip_from_world = space(&spot(Vec3::new(0.0, 5.0, 0.0), direction), &geometry).clip_from_world();
            for p in geometry.vertices_of(geometry.receivers()) {
                let clip = transform(clip_from_world, p);
                assert!(clip.w <= 0.0 || clip.z / clip.w <= 1.0, "{p} at tilt {i}: {}", clip.z / clip.w);
            }
        }
    }
}
