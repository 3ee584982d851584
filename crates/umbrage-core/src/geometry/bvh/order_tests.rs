//! Property tests: query results don't depend on the order of the search. Covers both hierarchies,
//! shuffled lists, and positions up to 1e6 m from the origin.

use crate::{
    geometry::{
        Geometry,
        bvh::{tree::tests::geometry, wide::SHALLOW},
        random::Random,
        ray_box::{enters_box, slab_inverse},
        ray_triangle::{Corners, Segment},
    },
    scene::light_sample::{hash, origin_offset},
};
use glam::{EulerRot, Quat, Vec3};

/// The two-way hierarchy as shaders store it, searched by their rule. `turn` chooses which child is
/// visited first.
struct Tables {
    nodes: Vec<[u32; 4]>,
    triangles: Vec<[u32; 4]>,
}

impl Tables {
    fn from_geometry(g: &Geometry) -> Self {
        Self {
            nodes: g.bvh().node_rows(),
            triangles: g.bvh().triangle_rows(g),
        }
    }

    fn is_occluded(&self, o: Vec3, d: Vec3, skip: u32, mut turn: impl FnMut() -> bool) -> bool {
        let vector = |row: [u32; 4]| {
            Vec3::new(
                f32::from_bits(row[0]),
                f32::from_bits(row[1]),
                f32::from_bits(row[2]),
            )
        };
        let segment = Segment::new(o, d);
        let inverse = slab_inverse(d);
        let mut stack = vec![0];
        while let Some(node) = stack.pop() {
            let low = self.nodes[2 * node];
            let high = self.nodes[2 * node + 1];
            if !enters_box(o.into(), inverse, [vector(low).into(), vector(high).into()]) {
                continue;
            }
            let first = low[3] as usize;
            let count = high[3] as usize;
            if count == 0 {
                let children = [first, first + 1];
                stack.extend(if turn() {
                    children
                } else {
                    [children[1], children[0]]
                });
            }
            for i in first..first + count {
                let rows = [0, 1, 2].map(|k| self.triangles[3 * i + k]);
                if rows[0][3] != skip && segment.hits(&Corners::new(rows.map(vector))) {
                    return true;
                }
            }
        }
        false
    }
}

/// Returns a geometry with its triangles shuffled.
fn shuffle_triangles(g: &Geometry, random: &mut Random) -> Geometry {
    let mut triangles = g.triangles().to_vec();
    for i in (1..triangles.len()).rev() {
        random.0 = hash(random.0);
        triangles.swap(i, random.0 as usize % (i + 1));
    }
    geometry(g.positions().to_vec(), triangles)
}

/// A ball of radius 0.2 over a floor and a fence of thin wires, at this distance from the origin.
/// At 1e6 m float steps are 6 cm: most of the ball's triangles lose their area.
fn far_scene(metres: f32) -> Geometry {
    let at = Vec3::new(1.0, 0.0, 0.9) * metres;
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    let mut add = |corners: [Vec3; 3]| {
        let first = positions.len() as u32;
        positions.extend(corners.map(|v| at + v));
        triangles.push([first, first + 1, first + 2]);
    };
    let tilt = Quat::from_euler(EulerRot::XYZ, 0.4, 0.0, 0.7);
    let on_ball = |ring: u32, side: u32| {
        let (s, c) = (ring as f32 / 24.0 * std::f32::consts::PI).sin_cos();
        let (sk, ck) = (side as f32 / 32.0 * std::f32::consts::TAU).sin_cos();
        Vec3::new(1.2, 1.5, 0.3) + tilt * Vec3::new(s * ck, c, s * sk) * 0.2
    };
    for (ring, side) in (0..24).flat_map(|ring| (0..32).map(move |side| (ring, side))) {
        let a = on_ball(ring, side);
        let b = on_ball(ring + 1, side);
        let c = on_ball(ring, side + 1);
        let d = on_ball(ring + 1, side + 1);
        add([a, b, c]);
        add([c, b, d]);
    }
    for i in -40..40 {
        let foot = Vec3::new(i as f32 * 0.1, 0.0, -1.5);
        add([foot, foot + Vec3::Y, foot + Vec3::new(0.002, 1.0, 0.0)]);
        add([
            foot + Vec3::Y * 0.5,
            foot + Vec3::new(3.0, 0.5, 0.0),
            foot + Vec3::new(3.0, 0.501, 0.0),
        ]);
    }
    for (x, z) in (-8..8).flat_map(|x| (-8..8).map(move |z| (x as f32 * 0.5, z as f32 * 0.5))) {
        let corner = |i: f32, k: f32| Vec3::new(x + i * 0.5, 0.0, z + k * 0.5);
        add([corner(0.0, 0.0), corner(0.0, 1.0), corner(1.0, 1.0)]);
        add([corner(0.0, 0.0), corner(1.0, 1.0), corner(1.0, 0.0)]);
    }
    geometry(positions, triangles)
}

/// Returns a segment from a surface point of the scene to the sun or a point light; some run along
/// the floor or along an axis. The suns' coordinates need many bits, but their ratios are whole
/// numbers. On a coarse grid, many upright triangles without area are therefore in line with a
/// segment, except for rounding.
fn segment(g: &Geometry, random: &mut Random, i: u32) -> (Vec3, Vec3, u32) {
    let id = hash(i) % g.triangles().len() as u32;
    let [a, b, c] = g.corners(id);
    let p = a
        .lerp(b, random.signed_unit().abs())
        .lerp(c, random.signed_unit().abs());
    let o = p + Vec3::Y * origin_offset(p, 0.0);
    let d = match i % 8 {
        0 => Vec3::new(random.signed_unit(), 0.02, random.signed_unit()) * 12.0,
        1 => [Vec3::X, Vec3::NEG_Z, Vec3::Y][i as usize / 8 % 3] * 7.0,
        2 => g.corners(hash(i + 1) % g.triangles().len() as u32)[0] - o,
        3 => Vec3::new(5.0, 7.0, 3.0).normalize() * 24.7,
        4 => Vec3::new(6.0, 7.0, 2.0).normalize() * 24.7,
        5 => Vec3::new(-1.0, 7.0, 3.0).normalize() * 24.7,
        6 => Vec3::new(-3.0, 7.0, -2.0).normalize() * 24.7,
        _ => Vec3::new(5.0, 7.0, 3.0).normalize() * 24.7,
    };
    (o, d, id)
}

#[test]
fn every_order_gives_the_same_answer() {
    let mut random = Random(31);
    for metres in [0.0, 1e2, 1e4, 1e5, 3e5, 1e6] {
        let g = far_scene(metres);
        let other = shuffle_triangles(&g, &mut random);
        let tables = [Tables::from_geometry(&g), Tables::from_geometry(&other)];
        let mut hits = 0;
        for i in 0..4_000 {
            let (o, d, id) = segment(&g, &mut random, i);
            let [a, b, c] = g.corners(id);
            // The triangle has another index in the other list; duplicates of it match as well.
            let segment = Segment::new(o, d);
            let expected = g
                .casters()
                .any(|k| k != id && segment.hits(&Corners::new(g.corners(k))));
            let twin = |k: &u32| other.corners(*k) == [a, b, c];
            let other_id = other.casters().find(twin).expect("all are there");
            hits += u32::from(expected);
            let mut turn = || random.signed_unit() > 0.0;
            let answers = [
                g.bvh().is_occluded(o, d, id),
                g.bvh().nearest(&g, o, d, id).is_some(),
                tables[0].is_occluded(o, d, id, &mut turn),
                tables[0].is_occluded(o, d, id, || true),
                other.bvh().is_occluded(o, d, other_id),
                tables[1].is_occluded(o, d, other_id, &mut turn),
            ];
            assert_eq!(
                answers, [expected; 6],
                "at {metres} m, triangle {id}, from {o} along {d}"
            );
        }
        assert!(
            (400..3_600).contains(&hits),
            "at {metres} m too few hits to be meaningful: {hits}"
        );
    }
}

/// The first hit is also bit-equal.
#[test]
fn the_nearest_hit_is_the_same_in_every_order() {
    let mut random = Random(5);
    for metres in [0.0, 1e3, 1e6] {
        let g = far_scene(metres);
        let other = shuffle_triangles(&g, &mut random);
        for i in 0..4_000 {
            let (o, d, _) = segment(&g, &mut random, i);
            let [found, expected] = [&g, &other].map(|g| g.bvh().nearest(g, o, d, u32::MAX));
            assert_eq!(
                found.map(f32::to_bits),
                expected.map(f32::to_bits),
                "at {metres} m, from {o} along {d}"
            );
        }
    }
}

/// Clusters of every size, each within the box of the next: the deepest trees, with several nodes
/// to visit at every level.
#[test]
fn deep_trees_are_searched_to_the_end() {
    let mut random = Random(2);
    let mut positions = Vec::new();
    for size in (-50..60).map(|e| 2.0_f32.powi(e)) {
        for _ in 0..12 {
            let corner = Vec3::splat(size) + random.vector() * size * 0.3;
            positions.extend(
                [Vec3::ZERO, random.vector(), random.vector()].map(|v| corner + v * size * 0.1),
            );
        }
    }
    let count = positions.len() as u32 / 3;
    let g = geometry(
        positions,
        (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
    );
    assert!(
        g.bvh().wide.depth > SHALLOW,
        "depth is only {}",
        g.bvh().wide.depth
    );
    let tables = Tables::from_geometry(&g);
    let mut hits = 0;
    for i in 0..count {
        let outward = Vec3::ONE + random.vector() * 0.3;
        let target = g.corners(i).iter().sum::<Vec3>() / 3.0;
        for (o, d) in [
            (Vec3::ZERO, outward * 1e19),
            (Vec3::ZERO, target * 1.01),
            (target * 1.01, -target),
        ] {
            let segment = Segment::new(o, d);
            let expected = g
                .casters()
                .any(|k| segment.hits(&Corners::new(g.corners(k))));
            hits += u32::from(expected);
            let answers = [
                g.bvh().is_occluded(o, d, u32::MAX),
                tables.is_occluded(o, d, u32::MAX, || true),
            ];
            assert_eq!(answers, [expected; 2], "triangle {i}, from {o} along {d}");
        }
    }
    assert!(hits > count && hits < 3 * count, "{hits} of {count}");
}
