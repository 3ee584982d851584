//! Tests of the triangle test: edges, cracks, and distant false hits.

use super::*;
use crate::geometry::random::Random;
use glam::Vec3Swizzles;

const A: Vec3 = Vec3::new(-1.0, 0.0, -1.0);
const B: Vec3 = Vec3::new(1.0, 0.0, -1.0);
const C: Vec3 = Vec3::new(0.0, 0.0, 1.0);

#[test]
fn both_sides_edges_corners_and_ends_are_hit() {
    let down =
        |x: f32, z: f32| segment_hits(Vec3::new(x, 1.0, z), Vec3::new(0.0, -2.0, 0.0), A, B, C);
    let up =
        |x: f32, z: f32| segment_hits(Vec3::new(x, -1.0, z), Vec3::new(0.0, 1.0, 0.0), A, B, C);
    for (x, z) in [
        (0.0, 0.0),
        (0.0, -1.0),
        (-1.0, -1.0),
        (1.0, -1.0),
        (0.0, 1.0),
        (0.5, 0.0),
    ] {
        assert!(down(x, z) && up(x, z), "({x}, {z})");
    }
    for (x, z) in [(0.0, -1.001), (0.51, 0.0), (-0.51, 0.0), (0.0, 1.001)] {
        assert!(!down(x, z) && !up(x, z), "({x}, {z})");
    }
}

#[test]
fn segments_that_end_before_or_begin_behind_miss() {
    let hit =
        |o: f32, d: f32| segment_hits(Vec3::new(0.0, o, 0.0), Vec3::new(0.0, d, 0.0), A, B, C);
    assert!(hit(1.0, -1.0) && hit(0.0, 1.0));
    assert!(!hit(1.0, -0.999) && !hit(-0.001, -1.0) && !hit(0.001, 1.0));
}

#[test]
fn flat_triangles_and_parallel_segments_miss() {
    assert!(!segment_hits(Vec3::Y, Vec3::NEG_Y * 2.0, A, B, B));
    assert!(!segment_hits(Vec3::Y, Vec3::X, A, B, C));
    assert!(!segment_hits(
        Vec3::new(-5.0, 0.0, 0.0),
        Vec3::X * 10.0,
        A,
        B,
        C
    ));
}

/// Segments aimed at the corners and edges of a fan around the origin each hit one of its
/// triangles.
#[test]
fn fans_have_no_cracks() {
    let mut state = Random(1);
    let mut random = || 0.5 * state.signed_unit();
    for _ in 0..2_000 {
        let hub = Vec3::new(random(), random() * 0.1, random());
        let rim: Vec<Vec3> = (0..7)
            .map(|i| {
                let angle = i as f32 * 0.9 + random() * 0.2;
                hub + Vec3::new(angle.cos(), random() * 0.1, angle.sin())
            })
            .collect();
        let triangles: Vec<[Vec3; 3]> = (0..7).map(|i| [hub, rim[i], rim[(i + 1) % 7]]).collect();
        for (i, &corner) in rim.iter().enumerate() {
            let target = hub.lerp(corner, (random() + 0.5) * 0.9 * (i % 2) as f32);
            let o = target + Vec3::new(random() * 3.0, 4.0 + random(), random() * 3.0);
            let d = (target - o) * 2.0;
            assert!(
                triangles
                    .iter()
                    .any(|t| segment_hits(o, d, t[0], t[1], t[2])),
                "a crack at {target}"
            );
        }
    }
}

/// Returns -0.5..0.5.
fn random(state: &mut Random) -> f32 {
    state.unit() - 0.5
}

fn random_vector(state: &mut Random) -> Vec3 {
    Vec3::new(random(state), random(state), random(state))
}

/// Returns triangles of all kinds around `middle`: regular, thin, tiny, flat in one axis, and
/// without area.
fn triangle(state: &mut Random, kind: u32, middle: Vec3) -> [Vec3; 3] {
    let at = |v: Vec3| middle + v;
    let p = random_vector(state);
    let along = random_vector(state);
    let aside = random_vector(state);
    match kind {
        0 => [at(p), at(along), at(aside)],
        1 => [at(p), at(p + along), at(p + along * 0.4 + aside * 1e-5)],
        2 => [at(p), at(p + along * 1e-5), at(p + aside * 1e-5)],
        3 => [p, along, aside].map(|v| at(v * Vec3::new(1.0, 0.0, 1.0))),
        4 => [at(p), at(p + along), at(p + along * (0.5 + random(state)))],
        _ => [
            at(p),
            at(p + Vec3::X * along.x),
            at(p + Vec3::new(along.x * 0.5, aside.x * 1e-4, aside.y * 1e-4)),
        ],
    }
}

/// Returns a segment's origin and vector: towards the triangle's interior, an edge or a corner, or
/// along it.
fn ray_towards(state: &mut Random, triangle: [Vec3; 3], far: f32) -> (Vec3, Vec3) {
    let [a, b, c] = triangle;
    let s = random(state) + 0.5;
    let t = random(state) + 0.5;
    let target = match (random(state) * 8.0) as i32 {
        0 => a,
        1 => b,
        2 => a.lerp(b, s),
        3 => b.lerp(c, s),
        _ => a.lerp(b, s).lerp(c, t),
    };
    let o = match (random(state) * 4.0) as i32 {
        0 => target + (b - a) * 3.0 + random_vector(state) * 1e-6,
        _ => target + random_vector(state) * far,
    };
    (o, (target - o) * (1.05 + s))
}

/// Returns the weights of the corners at the plane's origin after rounding, if the triangle
/// contains it. Products of two 24-bit numbers are exact in 53 bits, and so is the comparison of
/// two products.
fn exact_weights(segment: &Segment, corners: &Corners) -> Option<[f64; 3]> {
    let x = segment.along_row(0, corners).to_array().map(f64::from);
    let y = segment.along_row(1, corners).to_array().map(f64::from);
    let sign = |i: usize, k: usize| {
        let p = x[i] * y[k];
        let q = y[i] * x[k];
        i8::from(p > q) - i8::from(p < q)
    };
    let signs = [sign(1, 2), sign(2, 0), sign(0, 1)];
    let holds = signs.iter().all(|&s| s >= 0) || signs.iter().all(|&s| s <= 0);
    let area = |i: usize, k: usize| x[i] * y[k] - y[i] * x[k];
    let areas = [area(1, 2), area(2, 0), area(0, 1)];
    let whole: f64 = areas.iter().sum();
    (holds && whole != 0.0).then(|| areas.map(|a| a / whole))
}

/// Tests 2 and 3 reject no triangle that contains the origin and meets the segment, as derived in
/// the module documentation.
#[test]
fn rectangle_and_box_refuse_no_triangle_that_holds_the_origin() {
    let mut state = Random(5);
    let mut held = 0;
    for i in 0..600_000_u32 {
        let distance = [0.0, 1.0, 300.0, 1e4, 1e6][(i / 6 % 5) as usize];
        let size = [1.0, 1e-3, 50.0][(i / 30 % 3) as usize];
        let middle = Vec3::new(0.8, 0.1, -0.6) * distance;
        let corners = triangle(&mut state, i % 6, middle / size).map(|v| v * size);
        let far = [3.0, 100.0, 1e4][(i / 90 % 3) as usize];
        let (o, d) = ray_towards(&mut state, corners, far * size);
        let segment = Segment::new(o, d);
        let t = Corners::new(corners);
        let Some(weights) = exact_weights(&segment, &t) else {
            continue;
        };
        let depths = segment.along_row(2, &t).to_array();
        let depth: f64 = weights
            .iter()
            .zip(depths)
            .map(|(w, z)| w * f64::from(z))
            .sum();
        if !(0.0..=1.0).contains(&depth) {
            continue;
        }
        held += 1;
        let x = segment.along_row(0, &t);
        let y = segment.along_row(1, &t);
        assert!(
            holds_origin(x, y),
            "the rectangle of {corners:?}, from {o} along {d}"
        );
        assert!(
            enters_box(segment.origin, segment.inverse, t.padded_box()),
            "the box of {corners:?}, from {o} along {d}"
        );
    }
    assert!(held > 100_000, "too few cases to be meaningful: {held}");
}

/// Returns the distance between a triangle and the line of a segment, along the shorter axes of its
/// vector.
fn miss(ray: [Vec3; 2], corners: [Vec3; 3]) -> f64 {
    let [o, d] = ray.map(|v| v.as_dvec3());
    let sheared = corners.map(|v| {
        let v = v.as_dvec3() - o;
        let (x, y, z) = match d.abs().max_position() {
            0 => (v.y - d.y / d.x * v.x, v.z - d.z / d.x * v.x, v.x),
            1 => (v.z - d.z / d.y * v.y, v.x - d.x / d.y * v.y, v.y),
            _ => (v.x - d.x / d.z * v.z, v.y - d.y / d.z * v.z, v.z),
        };
        (glam::DVec2::new(x, y), z)
    });
    let edge = |i: usize| {
        let a = sheared[i].0;
        let b = sheared[(i + 1) % 3].0;
        let along = (-a.dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        if along.is_finite() {
            a.lerp(b, along).length()
        } else {
            a.length()
        }
    };
    let signs = [0, 1, 2].map(|i| sheared[i].0.perp_dot(sheared[(i + 1) % 3].0));
    let inside = signs.iter().all(|s| *s > 0.0) || signs.iter().all(|s| *s < 0.0);
    if inside {
        0.0
    } else {
        (0..3).map(edge).fold(f64::INFINITY, f64::min)
    }
}

/// Returns a needle without area, its corners exactly collinear along an axis or a diagonal, and a
/// segment that passes it. The segment is in the plane of the needle and its own direction, or
/// almost parallel to the needle.
fn needle_and_passer(state: &mut Random, distance: f32) -> ([Vec3; 3], [Vec3; 2]) {
    let on_grid = |v: Vec3| (v * 1024.0).round() / 1024.0;
    let place = (Vec3::new(0.8, 0.1, -0.6) * distance * 16.0).round() / 16.0
        + on_grid(random_vector(state));
    if random(state) > 0.0 {
        let end = Vec3::Y * random(state);
        let d = random_vector(state) * 8.0;
        let o = place + end * (1.0 + 40.0 * random(state)) - d * (random(state) + 0.5);
        (
            [place, place + end, place + end * (random(state) + 0.5)],
            [o, d],
        )
    } else {
        let ends = [1.0, 0.5 + random(state)].map(|t| place + on_grid(Vec3::splat(t)));
        let ulps = |state: &mut Random| (random(state) * 8.0).round() * f32::EPSILON;
        let d = Vec3::new(1.0 + ulps(state), 1.0 + ulps(state), 1.0) * 4.0;
        let o = place + Vec3::splat(0.5) + random_vector(state) - d * 0.5;
        ([place, ends[0], ends[1]], [o, d])
    }
}

/// Every hit is within a few roundings of the lengths in the test, as derived in the module
/// documentation.
#[test]
fn nothing_is_hit_from_afar() {
    let mut state = Random(3);
    let mut hits = 0;
    let mut worst = 0.0_f64;
    for i in 0..1_200_000_u32 {
        let distance = [0.0, 1.0, 300.0, 1e4, 1e6][(i / 12 % 5) as usize];
        let (corners, [o, d]) = if i % 2 == 0 {
            needle_and_passer(&mut state, distance)
        } else {
            let corners = triangle(&mut state, i % 12 / 2, Vec3::new(0.8, 0.1, -0.6) * distance);
            let (o, d) = ray_towards(&mut state, corners, 30.0);
            let aside = random_vector(&mut state);
            (corners, [o + aside * aside.length().powi(8), d])
        };
        if !segment_hits(o, d, corners[0], corners[1], corners[2]) {
            continue;
        }
        hits += 1;
        let length = corners
            .iter()
            .map(|c| (c - o).abs().max_element())
            .fold(0.0, f32::max);
        worst = worst.max(miss([o, d], corners) / f64::from(length * f32::EPSILON / 2.0));
    }
    assert!(hits > 50_000, "too few hits to be meaningful: {hits}");
    // Six roundings of the greatest length along each of two axes, and two more for signs that
    // round to 0.
    assert!(worst < 2.0_f64.sqrt() * 8.0, "{worst} roundings");
}

/// Rays that start just above a giant plane don't hit its other triangles, however low they are.
/// The side that two triangles share passes near the rays' origins, where rounding decides which of
/// them contains the origin in the shear.
#[test]
fn rays_leave_giant_planes_across_an_axis() {
    let mut state = Random(8);
    for i in 0..100_000_u32 {
        let half = 1e3 * 10.0_f32.powi((i % 5) as i32);
        // Turn the plane and its side by exchanging axes.
        let turned = |v: Vec3| match i % 3 {
            0 => v,
            1 => v.yzx(),
            _ => v.zxy(),
        };
        let corner = |x: f32, z: f32| turned(Vec3::new(x * half, 0.25, z * half));
        let corners = [[-1.0, -1.0], [1.0, 1.0], [1.0, -1.0]].map(|[x, z]| corner(x, z));
        let along = 10.0 * random(&mut state);
        let aside = 0.1 * random(&mut state);
        let height = 0.25 + 1e-6 * (0.5 + state.unit());
        let o = turned(Vec3::new(along + aside, height, along - aside));
        let low = Vec3::new(random(&mut state), 0.02 * state.unit(), random(&mut state));
        let d = turned(low * 4.0 * half);
        let [a, b, c] = corners;
        assert!(
            !segment_hits(o, d, a, b, c),
            "{corners:?} from {o} along {d}"
        );
        // The same ray downwards hits, unless it passes the side.
        let down = turned(low * Vec3::new(1.0, -1.0, 1.0) * 4.0 * half);
        let is_clearly_inside = aside > 0.01 * half.max(1.0).log2();
        assert!(!is_clearly_inside || segment_hits(o, down, a, b, c));
    }
}
