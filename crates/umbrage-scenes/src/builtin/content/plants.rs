//! Trees, firs, tufts of grass, potted plants. Every leaf is geometry.

use super::{parts::merge_parts, random::Random};
use crate::primitives::{on_circle, tube};
use umbrage_core::Mesh;
use umbrage_core::glam::Vec3;

/// Turn from one branch to the next: the golden angle, as a fraction of a full turn.
const GOLDEN: f64 = 0.381_966;
/// Droop of a leaf at its tip, as a fraction of its length.
const DROOP: f32 = 0.25;

/// Parameters of a tree's growth, in metres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Growth {
    pub(super) seed: i32,
    pub(super) height: f32,
    /// Radius of the trunk at its foot.
    pub(super) girth: f32,
    /// Length of the longest branches.
    pub(super) reach: f32,
    /// The fraction of the trunk without branches.
    pub(super) bare: f32,
    pub(super) branches: u32,
    /// Number of leaves at each twig of a branch, and their length.
    pub(super) leaves: u32,
    pub(super) leaf: f32,
    /// `true` if twigs are geometry, too. Without them, leaves float in the air.
    pub(super) has_twigs: bool,
}

/// A tree whose foot is at the origin.
#[derive(Clone, Debug)]
pub(super) struct Tree {
    pub(super) wood: Mesh,
    pub(super) leaves: Mesh,
}

/// Returns a tree with broad leaves.
pub(super) fn tree(growth: &Growth) -> Tree {
    let mut random = Random::new(growth.seed);
    let trunk = trunk(growth, &mut random);
    let mut wood = vec![tube(&trunk, 14)];
    let mut leaves = Leaves::new();
    for i in 0..growth.branches {
        let t = growth.bare
            + (0.98 - growth.bare) * (i as f32 + random.unit()) / growth.branches as f32;
        let (x, z) = on_circle(GOLDEN * f64::from(i));
        let from = point_along(&trunk, t);
        // Make branches long in the middle of the crown and short at its top. Low ones spread, high
        // ones rise.
        let up = (t - growth.bare) / (1.0 - growth.bare);
        let length =
            growth.reach * (0.45 + 0.9 * up * (1.0 - up) * 2.0) * random.number_between(0.75, 1.1);
        let direction = Vec3::new(x, 0.25 + 0.9 * up, z).normalize();
        let branch = limb(from.0, direction, length, 0.45 * from.1, &mut random);
        wood.push(tube(&branch, 7));
        for k in 0..5 {
            let s = 0.35 + 0.16 * k as f32;
            let start = point_along(&branch, s);
            let aside = direction + 0.9 * random.vector();
            let twig_length = 0.35 * length * random.number_between(0.7, 1.2);
            let twig = limb(
                start.0,
                aside.normalize_or(Vec3::Y),
                twig_length,
                0.5 * start.1,
                &mut random,
            );
            if growth.has_twigs {
                wood.push(tube(&twig, 4));
            }
            for _ in 0..growth.leaves {
                let at = point_along(&twig, random.number_between(0.15, 1.0)).0;
                leaves.hang(at + 0.16 * random.vector(), growth.leaf, &mut random);
            }
        }
    }
    Tree {
        wood: merge_parts("wood", wood),
        leaves: leaves.mesh,
    }
}

/// Returns the path of a trunk that leans and bends a little.
fn trunk(growth: &Growth, random: &mut Random) -> Vec<(Vec3, f32)> {
    const PIECES: u32 = 14;
    let lean = random.vector() * Vec3::new(0.05, 0.0, 0.05);
    let bend = random.vector() * Vec3::new(0.25, 0.0, 0.25);
    let mut path = Vec::new();
    for i in 0..=PIECES {
        let t = i as f32 / PIECES as f32;
        let (_, wave) = on_circle(f64::from(t));
        let flare = 0.8 * (1.0 - t).powi(12);
        // Begin below the ground, which is not level.
        let height = growth.height * t - 0.3;
        let point = (Vec3::Y + lean) * height + bend * wave;
        path.push((point, growth.girth * (1.0 - 0.88 * t + flare)));
    }
    path
}

/// Returns the path of a branch, which rises towards its end.
fn limb(
    from: Vec3,
    direction: Vec3,
    length: f32,
    radius: f32,
    random: &mut Random,
) -> Vec<(Vec3, f32)> {
    const PIECES: u32 = 4;
    let mut path = vec![(from, radius)];
    let mut point = from;
    let mut heading = direction;
    for i in 1..=PIECES {
        heading = (heading + 0.22 * random.vector() + 0.1 * Vec3::Y).normalize();
        point += heading * (length / PIECES as f32);
        let left = 1.0 - i as f32 / PIECES as f32;
        path.push((point, radius * (0.18 + 0.82 * left)));
    }
    path
}

/// Returns the point at a fraction of a path, 0 to 1, and its radius.
fn point_along(path: &[(Vec3, f32)], t: f32) -> (Vec3, f32) {
    let place = t * (path.len() - 1) as f32;
    let before = (place as usize).min(path.len() - 2);
    let rest = place - before as f32;
    let a = path[before];
    let b = path[before + 1];
    (a.0.lerp(b.0, rest), a.1 + (b.1 - a.1) * rest)
}

/// A mesh under construction. Each leaf has two triangles that meet at its rib.
struct Leaves {
    mesh: Mesh,
}

impl Leaves {
    fn new() -> Self {
        let mesh = Mesh {
            name: "leaves".to_owned(),
            ..Mesh::default()
        };
        Self { mesh }
    }

    /// Adds a leaf from its stalk along a vector. `across` extends from its rib to one side.
    fn add(&mut self, from: Vec3, along: Vec3, across: Vec3) {
        let first = self.mesh.positions.len() as u32;
        let broadest = from + 0.45 * along;
        let tip = from + along - DROOP * along.length() * Vec3::Y;
        self.mesh
            .positions
            .extend([from, broadest + across, tip, broadest - across]);
        self.mesh.triangles.push([first, first + 1, first + 2]);
        self.mesh.triangles.push([first, first + 2, first + 3]);
    }

    /// Adds a leaf that faces up rather than down.
    fn hang(&mut self, from: Vec3, length: f32, random: &mut Random) {
        let normal = (random.vector() + 0.7 * Vec3::Y).normalize_or(Vec3::Y);
        let heading = random.vector().reject_from(normal).normalize_or(Vec3::X);
        let size = length * random.number_between(0.7, 1.2);
        let across = normal.cross(heading) * (0.32 * size);
        self.add(from, heading * size, across);
    }
}

/// Returns a heap of fallen leaves over a square of 4 m, up to `rise` above the ground.
pub(super) fn litter(seed: i32, count: u32, rise: f32) -> Mesh {
    let mut random = Random::new(seed);
    let mut leaves = Leaves::new();
    for _ in 0..count {
        let x = random.signed_number(2.0);
        let z = random.signed_number(2.0);
        let y = rise * random.unit();
        let turn = f64::from(random.unit());
        let (cos, sin) = on_circle(turn);
        let size = random.number_between(0.07, 0.13);
        let along = Vec3::new(cos, random.signed_number(0.5), sin) * size;
        let across = Vec3::new(-sin, random.signed_number(0.4), cos) * (0.35 * size);
        leaves.add(Vec3::new(x, y, z), along, across);
    }
    leaves.mesh
}

/// Returns a tuft of blades of grass, up to `height` high and as wide.
pub(super) fn tuft(seed: i32, blades: u32, height: f32) -> Mesh {
    let mut random = Random::new(seed);
    let mut out = Mesh {
        name: "grass".to_owned(),
        ..Mesh::default()
    };
    for _ in 0..blades {
        let (cos, sin) = on_circle(f64::from(random.unit()));
        let outwards = Vec3::new(cos, 0.0, sin);
        let foot = outwards * (0.3 * height * random.unit());
        let length = height * random.number_between(0.5, 1.0);
        let lean = outwards * (length * random.number_between(0.1, 0.6));
        let aside = Vec3::new(-sin, 0.0, cos) * random.number_between(0.004, 0.009);
        let knee = foot + 0.35 * lean + 0.6 * length * Vec3::Y;
        let tip = foot + lean + (length * random.number_between(0.8, 1.0)) * Vec3::Y;
        let first = out.positions.len() as u32;
        let sunk = foot - 0.05 * Vec3::Y;
        out.positions.extend([
            sunk - aside,
            sunk + aside,
            knee + 0.8 * aside,
            knee - 0.8 * aside,
            tip,
        ]);
        out.triangles.push([first, first + 1, first + 2]);
        out.triangles.push([first, first + 2, first + 3]);
        out.triangles.push([first + 3, first + 2, first + 4]);
    }
    out
}

/// Returns a fern, or the leaves of a potted plant: arching fronds from the origin, with leaflets
/// on both sides.
pub(super) fn fern(seed: i32, fronds: u32, length: f32) -> Mesh {
    const LEAFLETS: u32 = 16;
    let mut random = Random::new(seed);
    let mut leaves = Leaves::new();
    for i in 0..fronds {
        let (cos, sin) = on_circle(GOLDEN * f64::from(i) + 0.02 * f64::from(random.unit()));
        let outwards = Vec3::new(cos, 0.0, sin);
        let aside = Vec3::new(-sin, 0.0, cos);
        let reach = length * random.number_between(0.7, 1.0);
        let rise = random.number_between(0.5, 1.1);
        let at = |t: f32| outwards * (reach * t) + Vec3::Y * (reach * rise * t * (1.6 - 1.3 * t));
        for k in 1..=LEAFLETS {
            let t = k as f32 / LEAFLETS as f32;
            let size = 0.28 * length * (1.15 - t) * (0.3 + t.min(0.7));
            let forward = (at(t) - at(t - 0.05)).normalize();
            for side in [-1.0, 1.0] {
                let along = (aside * side + 0.5 * forward) * size;
                leaves.add(at(t), along, forward * (0.2 * size));
            }
        }
        let rib: Vec<_> = (0..=8).map(|k| at(k as f32 / 8.0)).collect();
        for ends in rib.windows(2) {
            leaves.add(ends[0], 1.6 * (ends[1] - ends[0]), 0.008 * aside);
        }
    }
    leaves.mesh
}

/// Returns a fir of 1 m: a trunk and tiers of drooping boughs.
pub(super) fn fir(seed: i32) -> Mesh {
    const TIERS: u32 = 11;
    const BOUGHS: u32 = 15;
    let mut random = Random::new(seed);
    let mut boughs = Leaves::new();
    for tier in 0..TIERS {
        let t = tier as f32 / TIERS as f32;
        let height = 0.16 + 0.82 * t;
        for bough in 0..BOUGHS {
            let turn = (f64::from(bough) + f64::from(random.unit())) / f64::from(BOUGHS);
            let (cos, sin) = on_circle(turn + 0.03 * f64::from(tier));
            let length = (0.21 * (1.0 - t) + 0.025) * random.number_between(0.8, 1.15);
            let along = Vec3::new(cos, -0.2, sin) * length;
            let across = Vec3::new(-sin, 0.12, cos) * (0.27 * length);
            boughs.add(height * Vec3::Y, along, across);
        }
    }
    let trunk = tube(&[(-0.02 * Vec3::Y, 0.02), (Vec3::Y, 0.003)], 7);
    merge_parts("fir", [trunk, boughs.mesh])
}
