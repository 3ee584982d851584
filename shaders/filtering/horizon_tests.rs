use super::*;
use umbrage_core::{
    LightSpace,
    light_space::{look_along, perspective},
    math::unit3,
};

/// Number of points along each side of a grid that represents a light.
const SIDE: i32 = 400;

/// Returns the fraction of even points of a square or disc whose height is not negative.
fn counted_share(square: bool, h: Vec3) -> f32 {
    let at = |i: i32| (i as f32 + 0.5) / SIDE as f32 * 2.0 - 1.0;
    let points = (0..SIDE * SIDE).map(|i| Vec2::new(at(i % SIDE), at(i / SIDE)));
    let points: Vec<Vec2> = points.filter(|q| square || q.length() <= 1.0).collect();
    let above = points
        .iter()
        .filter(|q| h.x + h.y * q.x + h.z * q.y >= 0.0)
        .count();
    above as f32 / points.len() as f32
}

/// Compares fractions with counts. A line crosses at most 2 sqrt(2) SIDE of SIDE^2 points, of which
/// half are on the wrong side at worst.
#[test]
fn shares_are_areas() {
    let axes = [
        Vec2::new(1.0, 0.0),
        Vec2::new(0.3, -0.8),
        Vec2::new(-0.6, 0.6),
        Vec2::new(0.0, 2.0),
    ];
    for axis in axes {
        for step in -12..=12 {
            let h = Vec3::new(step as f32 * 0.13, axis.x, axis.y);
            for (square, share) in [(true, square_share(h)), (false, disc_share(h))] {
                let right = counted_share(square, h);
                assert!(
                    (share - right).abs() < 1.5 / SIDE as f32,
                    "square {square}, {h}: {share} instead of {right}"
                );
            }
        }
    }
}

/// A light edge-on to its own plane, or without extent, is fully visible or not at all, never NaN.
#[test]
fn without_extent_all_or_nothing_is_seen() {
    for (height, share) in [(1.0, 1.0), (0.0, 1.0), (-1.0, 0.0)] {
        let h = Vec3::new(height, 0.0, 0.0);
        assert_eq!([square_share(h), disc_share(h)], [share; 2], "{height}");
    }
}

fn spaces(eye: Vec3, along: Vec3) -> LightSpaces {
    let space = LightSpace {
        view_from_world: look_along(eye, along, Vec3::Z).unwrap(),
        clip_from_view: perspective(1.8, 1.0, 0.5, 20.0).unwrap(),
    };
    LightSpaces::with_all_casters(vec![space])
}

fn heights(light: &Light, spaces: &LightSpaces, p: Vec3, n: Vec3) -> Vec3 {
    let space = &spaces.spaces[0];
    let in_view = space.view_from_world.transform_point3(p);
    let t = Vec2::new(in_view.x, -in_view.y) / -in_view.z;
    let tangent = 1.0 / space.clip_from_view.x_axis.x;
    let middle = crate::shading::facing::homogeneous(light);
    Horizon::new(light, spaces).heights(middle, &space.clip_from_world(), p, n, t, tangent)
}

/// Compares the computed heights of points of flat lights with those from their positions.
#[test]
fn heights_are_those_of_the_lights_points() {
    let center = Vec3::new(1.0, 6.0, -2.0);
    let u = Vec3::new(0.4, 0.1, 0.0);
    let v = Vec3::new(0.0, -0.3, 0.7);
    let light = Light::Rect {
        center,
        half_u: u,
        half_v: v,
    };
    let spaces = spaces(center, Vec3::NEG_Y);
    let p = Vec3::new(3.0, 0.5, 1.0);
    let n = unit3(Vec3::new(-0.3, 0.2, 0.9));
    let h = heights(&light, &spaces, p, n);
    for (x, y) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (-0.5, 0.8)] {
        let right = n.dot(center + u * x + v * y - p);
        assert!((h.x + h.y * x + h.z * y - right).abs() < 1e-5, "({x}, {y})");
    }
}

/// A plane through a ball's centre cuts its disc in half. The edge's height over the plane is the
/// radius, anywhere on the map.
#[test]
fn a_balls_rim_is_as_high_as_its_radius() {
    let position = Vec3::new(1.0, 6.0, -2.0);
    let light = Light::Point {
        position,
        radius: 0.5,
    };
    let spaces = spaces(position, Vec3::NEG_Y);
    for p in [
        Vec3::new(1.0, 0.0, -2.0),
        Vec3::new(5.0, 1.0, 1.0),
        Vec3::new(-3.0, 0.0, -5.0),
    ] {
        let to_light = unit3(position - p);
        for other in [Vec3::X, Vec3::Z, Vec3::new(1.0, 0.3, -0.7)] {
            let n = unit3(to_light.cross(other));
            let h = heights(&light, &spaces, p, n);
            let rim = h.y.hypot(h.z);
            assert!(
                h.x.abs() < 1e-5 && (rim - 0.5).abs() < 1e-5,
                "{p} {n}: {h}, rim {rim}"
            );
        }
    }
}

/// For a plane below a ball's centre, the test searches the disc that faces the receiver for its
/// highest and lowest points.
#[test]
fn a_balls_share_is_that_of_the_disc_that_faces_the_receiver() {
    let position = Vec3::new(1.0, 6.0, -2.0);
    let radius = 0.5;
    let light = Light::Point { position, radius };
    let horizon = Horizon::new(&light, &spaces(position, Vec3::NEG_Y));
    for (p, n) in [
        (Vec3::new(1.0, 5.0, -2.3), Vec3::X),
        (Vec3::new(2.0, 5.7, -1.0), Vec3::Y),
        (Vec3::ZERO, Vec3::Z),
    ] {
        let to_light = unit3(position - p);
        let (u, v) = to_light.any_orthonormal_pair();
        let h = Vec3::new(n.dot(position - p), n.dot(u) * radius, n.dot(v) * radius);
        let share = horizon.share(0, crate::shading::facing::homogeneous(&light), p, n);
        assert!(
            (share - disc_share(h)).abs() < 1e-5,
            "{p} {n}: {share} instead of {}",
            disc_share(h)
        );
    }
}

/// The edge of a directional light is as high as its tangent over a plane along its rays.
#[test]
fn a_suns_rim_is_as_high_as_its_tangent() {
    let light = Light::Directional {
        direction: Vec3::new(1.0, -2.0, 0.5),
        angular_diameter: 0.2,
    };
    let n = unit3(Vec3::new(1.0, -2.0, 0.5).cross(Vec3::X));
    let h = heights(
        &light,
        &spaces(Vec3::ZERO, Vec3::new(1.0, -2.0, 0.5)),
        Vec3::new(3.0, 1.0, 2.0),
        n,
    );
    assert!(
        h.x.abs() < 1e-6 && (h.y.hypot(h.z) - 0.1_f32.tan()).abs() < 1e-6,
        "{h}"
    );
}
