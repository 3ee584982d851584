use super::*;
use crate::shadow_map::coord::{clip_w, point_over_w, texel_from_point};
use glam::Vec3;
use umbrage_core::{
    Extents,
    light_space::{look_along, orthographic, perspective},
};

const SIZE: u32 = 512;

fn perspective_space(eye: Vec3) -> LightSpace {
    let view_from_world = look_along(eye, Vec3::NEG_Y, Vec3::Z).unwrap();
    LightSpace {
        view_from_world,
        clip_from_view: perspective(1.8, 1.0, 0.5, 20.0).unwrap(),
    }
}

fn one(space: LightSpace) -> LightSpaces {
    LightSpaces::with_all_casters(vec![space])
}

/// Returns texel coordinates and depth.
fn project(space: &LightSpace, p: Vec3) -> Vec3 {
    let clip_from_world = space.clip_from_world();
    let w = clip_w(&clip_from_world, p);
    texel_from_point(point_over_w(&clip_from_world, p, w), SIZE as f32)
}

/// Returns two offsets, texels from the receiver, of the ray to the light's point `q` (of its half
/// axes) at `blocker_y`: by the formula, and by geometry.
fn both(
    light: &Light,
    space: &LightSpace,
    receiver: Vec3,
    light_point: Vec3,
    q: Vec2,
    blocker_y: f32,
) -> [Vec2; 2] {
    let extent = LightExtent::new(light, &one(*space), SIZE);
    let from = project(space, receiver);
    let half = SIZE as f32 * 0.5;
    let a = light_axes(
        extent.half_axis_u[0],
        extent.half_axis_v[0],
        Vec2::new(from.x - half, from.y - half),
    );
    let k = (blocker_y - receiver.y) / (light_point.y - receiver.y);
    let passed = project(space, receiver + (light_point - receiver) * k);
    let reach = from.z - passed.z;
    let rule = Vec2::new(a.x * q.x + a.z * q.y, a.y * q.x + a.w * q.y) * reach;
    [rule, passed.truncate() - from.truncate()]
}

/// For an area light parallel to the map nothing is approximated, so differences come from
/// rounding. (Depths round to 6e-8, times 300 texels per unit of depth, times 4 for the near
/// plane.)
#[test]
fn parallel_lamps_are_exact() {
    let eye = Vec3::new(1.0, 6.0, -2.0);
    let u = Vec3::new(0.4, 0.0, 0.1);
    let v = Vec3::new(-0.2, 0.0, 0.7);
    let light = Light::Rect {
        center: eye,
        half_u: u,
        half_v: v,
    };
    let space = perspective_space(eye);
    for (x, z) in [(0.0, 0.0), (3.0, 1.0), (-2.5, -4.0)] {
        for q in [Vec2::X, Vec2::Y, Vec2::new(-0.7, 0.4)] {
            let point = eye + u * q.x + v * q.y;
            let [rule, truth] = both(&light, &space, Vec3::new(x, 0.0, z), point, q, 2.5);
            assert!((rule - truth).length() < 2e-3, "{rule} instead of {truth}");
            assert!(truth.length() > 5.0, "{truth}: too short for a comparison");
        }
    }
}

/// For an area light perpendicular to the map, the error is its depth over the receiver's distance,
/// 0.3 of 6. Without the tilt's term, the error would be its whole length.
#[test]
fn tilted_lamps_are_wrong_by_their_depth_over_distance() {
    let eye = Vec3::new(0.0, 6.0, 0.0);
    let u = Vec3::new(0.0, 0.3, 0.0);
    let v = Vec3::new(0.3, 0.0, 0.0);
    let light = Light::Rect {
        center: eye,
        half_u: u,
        half_v: v,
    };
    let [rule, truth] = both(
        &light,
        &perspective_space(eye),
        Vec3::new(4.0, 0.0, 1.0),
        eye + u,
        Vec2::X,
        2.0,
    );
    let off = (rule - truth).length() / truth.length();
    assert!(
        off < 0.3 / 6.0 * 1.1 && truth.length() > 3.0,
        "{rule} instead of {truth}"
    );
}

/// Projects the edge of a ball's disc, which faces the receiver, along the ray onto the map's
/// plane.
#[test]
fn balls_are_ellipses() {
    let radius = 0.5_f32;
    let scale = 100.0_f32;
    let t = Vec2::new(0.8, -0.4);
    let a = light_axes(
        Vec4::new(radius * scale, 0.0, 0.0, 1.0 / scale),
        Vec4::ZERO,
        t * scale,
    );
    // The component of a point s on the map's plane perpendicular to the ray (t, 1) must equal the
    // radius.
    let ray = Vec3::new(t.x, t.y, 1.0).normalize();
    for i in 0..16 {
        let q = Vec2::from_angle(i as f32 * 0.4);
        let s = Vec3::new(a.x * q.x + a.z * q.y, a.y * q.x + a.w * q.y, 0.0) / scale;
        let across = (s - ray * s.dot(ray)).length();
        assert!((across - radius).abs() < 1e-6, "{across}");
    }
}

/// The edge of a directional light moves a blocker 2 m above the receiver by 2 tan(angle / 2)
/// metres.
#[test]
fn suns_move_blockers_by_their_tangent() {
    let extents = Extents {
        left: -5.0,
        right: 5.0,
        bottom: -2.0,
        top: 8.0,
        near: 1.0,
        far: 11.0,
    };
    let view_from_world = look_along(Vec3::Y * 9.0, Vec3::NEG_Y, Vec3::Z).unwrap();
    let space = LightSpace {
        view_from_world,
        clip_from_view: orthographic(extents).unwrap(),
    };
    let light = Light::Directional {
        direction: Vec3::NEG_Y,
        angular_diameter: 0.2,
    };
    let extent = LightExtent::new(&light, &one(space), SIZE);
    let reach = project(&space, Vec3::ZERO).z - project(&space, Vec3::Y * 2.0).z;
    let axes = light_axes(extent.half_axis_u[0], extent.half_axis_v[0], Vec2::ZERO) * reach;
    let truth = 2.0 * 0.1_f32.tan() * SIZE as f32 / 10.0;
    assert!(
        (axes.x - truth).abs() < 1e-3 && (axes.w.abs() - truth).abs() < 1e-3,
        "{axes} instead of {truth}"
    );
}

#[test]
fn ideal_lights_have_no_extent() {
    let light = Light::Point {
        position: Vec3::Y * 6.0,
        radius: 0.0,
    };
    let extent = LightExtent::new(&light, &one(perspective_space(Vec3::Y * 6.0)), SIZE);
    let axes = light_axes(
        extent.half_axis_u[0],
        extent.half_axis_v[0],
        Vec2::new(100.0, -30.0),
    );
    assert!(
        axes == Vec4::ZERO && extent.half_axis_v[0].w.is_finite(),
        "{axes}"
    );
}
