//! Tests of the hierarchy against brute force, and of edge cases of its box test.

use crate::{
    gbuffer::receivers::NO_TRIANGLE,
    geometry::{Geometry, random::Random, ray_triangle::segment_hits},
    scene::{Instance, Mesh, Scene},
};
use glam::{Affine3A, Vec3};

pub(super) fn geometry(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Geometry {
    let mesh = Mesh::new("test", positions, triangles).expect("valid");
    let instances = vec![Instance::new(0, Affine3A::IDENTITY)];
    Geometry::bake(&Scene {
        meshes: vec![mesh],
        instances,
        ..Scene::default()
    })
    .expect("valid")
}

/// Small triangles, some of them axis-aligned.
fn soup(random: &mut Random, count: u32, scale: f32) -> Geometry {
    let mut positions = Vec::new();
    for i in 0..count {
        let center = random.vector() * scale;
        for _ in 0..3 {
            let mut corner = random.vector() * 0.1 * scale;
            if i % 3 == 0 {
                corner.y = 0.0;
            }
            positions.push(center + corner);
        }
    }
    geometry(
        positions,
        (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
    )
}

fn brute_force(g: &Geometry, o: Vec3, d: Vec3, skip: u32) -> bool {
    g.casters().filter(|&i| i != skip).any(|i| {
        let [a, b, c] = g.corners(i);
        segment_hits(o, d, a, b, c)
    })
}

#[test]
fn agrees_with_brute_force_at_every_scale() {
    let mut random = Random(7);
    for scale in [1e-3, 1.0, 1e4] {
        let g = soup(&mut random, 500, scale);
        let mut hits = 0;
        for i in 0..4000 {
            let o = random.vector() * 1.5 * scale;
            let mut d = random.vector() * 2.0 * scale;
            if i % 4 == 0 {
                d = Vec3::Y * d.y;
            }
            let skip = i % 500;
            let expected = brute_force(&g, o, d, skip);
            hits += u32::from(expected);
            assert_eq!(
                g.bvh().is_occluded(o, d, skip),
                expected,
                "from {o} along {d}"
            );
        }
        assert!(
            (200..3800).contains(&hits),
            "too few hits to be meaningful: {hits}"
        );
    }
}

/// Results don't change when the scene is scaled by powers of two, up to the range of 32-bit
/// floats.
#[test]
fn answers_are_the_same_at_extreme_scales() {
    let g = soup(&mut Random(29), 1000, 1.0);
    for power in [-90, -60, -30, 30, 60, 90, 120] {
        let scale = 2.0_f32.powi(power);
        let scaled = geometry(
            g.positions().iter().map(|p| p * scale).collect(),
            g.triangles().to_vec(),
        );
        let mut random = Random(8);
        let mut hits = 0;
        for i in 0..2000 {
            let o = random.vector() * 1.5;
            let d = random.vector() * 3.0;
            let skip = i % 1000;
            let expected = g.bvh().nearest(&g, o, d, skip);
            hits += u32::from(expected.is_some());
            assert_eq!(
                scaled.bvh().nearest(&scaled, o * scale, d * scale, skip),
                expected,
                "2^{power}: {o} along {d}"
            );
            assert_eq!(
                scaled.bvh().is_occluded(o * scale, d * scale, skip),
                expected.is_some(),
                "2^{power}"
            );
        }
        assert!(hits > 200, "too few hits to be meaningful: {hits}");
    }
}

#[test]
fn an_occluder_answers_like_the_search() {
    let mut random = Random(3);
    let g = soup(&mut random, 500, 1.0);
    for _ in 0..2000 {
        let o = random.vector();
        let d = random.vector() * 2.0;
        if let Some(i) = g.bvh().occluder(o, d, NO_TRIANGLE) {
            assert!(g.bvh().hits(i, o, d, NO_TRIANGLE));
            assert!(!g.bvh().hits(i, o + Vec3::splat(10.0), d, NO_TRIANGLE));
        }
    }
}

/// `obvhs`'s box test skips boxes that end before t = 1e-4. Such boxes must be tested here, for
/// segments of any length.
#[test]
fn occluders_close_to_the_origin_are_found() {
    let g = geometry(vec![Vec3::ZERO, Vec3::X, Vec3::Z], vec![[0, 1, 2]]);
    for gap in [1e-1, 1e-3, 1e-5] {
        let o = Vec3::new(0.2, -gap, 0.2);
        assert!(
            g.bvh()
                .is_occluded(o, Vec3::new(3.0, 1000.0, 5.0), NO_TRIANGLE),
            "a gap of {gap} m"
        );
        assert!(
            !g.bvh()
                .is_occluded(o, Vec3::new(3.0, -1000.0, 5.0), NO_TRIANGLE)
        );
    }
}

#[test]
fn nothing_casts_nothing_occludes() {
    let g = geometry(vec![Vec3::ZERO, Vec3::X, Vec3::Z], vec![[0, 1, 2]]).without_casters();
    assert!(
        !g.bvh()
            .is_occluded(Vec3::new(0.2, 1.0, 0.2), Vec3::NEG_Y * 2.0, NO_TRIANGLE)
    );
}

/// No segment escapes from within a closed, finely tessellated ball, whether aimed at corners,
/// edges or interiors.
#[test]
fn closed_meshes_have_no_cracks() {
    let rings = 48_u32;
    let sides = 64_u32;
    let mut positions = vec![Vec3::Y, Vec3::NEG_Y];
    for r in 1..rings {
        let (s, c) = (r as f32 / rings as f32 * std::f32::consts::PI).sin_cos();
        positions.extend((0..sides).map(|k| {
            let (sk, ck) = (k as f32 / sides as f32 * std::f32::consts::TAU).sin_cos();
            Vec3::new(s * ck, c, s * sk)
        }));
    }
    let at = |r: u32, k: u32| 2 + (r - 1) * sides + k % sides;
    let mut triangles = Vec::new();
    for k in 0..sides {
        triangles.push([0, at(1, k), at(1, k + 1)]);
        triangles.push([1, at(rings - 1, k), at(rings - 1, k + 1)]);
        for r in 1..rings - 1 {
            triangles.push([at(r, k), at(r + 1, k), at(r, k + 1)]);
            triangles.push([at(r, k + 1), at(r + 1, k), at(r + 1, k + 1)]);
        }
    }
    let g = geometry(positions, triangles);
    let mut random = Random(11);
    for i in 0..60_000_u32 {
        let corners = g.corners(i % g.triangles().len() as u32);
        let target = match i % 3 {
            0 => corners[0],
            1 => corners[0].lerp(corners[1], random.signed_unit().abs()),
            _ => (corners[0] + corners[1] + corners[2]) / 3.0,
        };
        let o = random.vector() * 0.5;
        assert!(
            g.bvh().is_occluded(o, (target - o) * 3.0, NO_TRIANGLE),
            "from {o} to {target}"
        );
    }
}

/// No segment within a clear region is occluded. The random regions include clear and not clear
/// ones.
#[test]
fn clear_regions_hide_nothing() {
    let mut random = Random(23);
    let g = soup(&mut random, 300, 1.0);
    let mut clear = 0;
    let mut hidden = 0;
    for _ in 0..3000 {
        let o = random.vector() * 2.0;
        let center = random.vector() * 2.0;
        let u = random.vector() * 0.1;
        let v = random.vector() * 0.1;
        let corners = [
            center + u + v,
            center - u + v,
            center - u - v,
            center + u - v,
        ];
        let planes = [0, 1, 2, 3].map(|k| {
            let n = (corners[k] - o).cross(corners[(k + 1) % 4] - o);
            let inward = if n.dot(center - o) < 0.0 { -n } else { n };
            (inward, inward.dot(o))
        });
        let clear_now = g.bvh().is_clear(&g, &planes);
        clear += u32::from(clear_now);
        for _ in 0..16 {
            let target = center + u * random.signed_unit() + v * random.signed_unit();
            let occluded = brute_force(&g, o, target - o, NO_TRIANGLE);
            assert!(!(occluded && clear_now), "from {o} to {target}");
            hidden += u32::from(occluded);
        }
    }
    assert!(
        clear > 300 && hidden > 3000,
        "too few cases to be meaningful: {clear} clear, {hidden} hidden"
    );
}

/// The nearest hit equals the minimum over all triangles.
#[test]
fn the_nearest_hit_is_the_nearest() {
    let mut random = Random(11);
    let g = soup(&mut random, 500, 1.0);
    let mut hits = 0;
    for i in 0..2000 {
        let o = random.vector() * 1.5;
        let d = random.vector() * 3.0;
        let skip = i % 500;
        let fraction = |id: u32| {
            let [a, b, c] = g.corners(id);
            let n = (b - a).cross(c - a).as_dvec3();
            segment_hits(o, d, a, b, c).then(|| n.dot((a - o).as_dvec3()) / n.dot(d.as_dvec3()))
        };
        let expected = g
            .casters()
            .filter(|&id| id != skip)
            .filter_map(fraction)
            .min_by(f64::total_cmp);
        let found = g.bvh().nearest(&g, o, d, skip).map(f64::from);
        hits += u32::from(found.is_some());
        assert_eq!(found.is_some(), expected.is_some(), "from {o} along {d}");
        // Both are rounded to 32 bits once.
        assert!(
            found
                .zip(expected)
                .is_none_or(|(a, b)| (a - b).abs() < 1e-6),
            "{found:?} for {expected:?}"
        );
    }
    assert!(
        (100..1900).contains(&hits),
        "too few hits to be meaningful: {hits}"
    );
}
