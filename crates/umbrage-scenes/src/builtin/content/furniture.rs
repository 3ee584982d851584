//! Furniture, lamps and small objects of a room. Objects for the floor have their foot at y = 0 and
//! face +z.

use super::{
    parts::{
        box_at, crease_mesh, merge_parts, sheet, smooth_tube, stick, transform_mesh, translation,
    },
    random::Random,
};
use crate::primitives::{block, icosphere, lathe, on_circle, torus};
use umbrage_core::Mesh;
use umbrage_core::glam::{Affine3A, Quat, Vec3};

/// Signs of the x and z of four feet.
const FEET: [[f32; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]];

/// Returns a chair whose back is made of spindles.
pub(super) fn chair() -> Mesh {
    let mut parts = Vec::new();
    parts.push(block([-0.22, 0.42, -0.21], [0.22, 0.45, 0.22]));
    for x in [-1.0, 1.0] {
        parts.push(turned_leg(
            Vec3::new(0.20 * x, 0.0, 0.20),
            Vec3::new(0.17 * x, 0.42, 0.17),
        ));
        parts.push(turned_leg(
            Vec3::new(0.20 * x, 0.0, -0.22),
            Vec3::new(0.17 * x, 0.42, -0.17),
        ));
        parts.push(stick(
            [0.185 * x, 0.2, 0.185],
            [0.185 * x, 0.17, -0.195],
            0.009,
        ));
        parts.push(stick(
            [0.19 * x, 0.45, -0.19],
            [0.21 * x, 0.92, -0.27],
            0.015,
        ));
    }
    for i in 0..7 {
        let x = 0.05 * (i as f32 - 3.0);
        let foot = Vec3::new(x, 0.45, -0.19);
        parts.push(stick(foot, [1.1 * x, 0.9, -0.268], 0.006));
    }
    let mut arc = Vec::new();
    for i in 0..=12 {
        let t = i as f32 / 6.0 - 1.0;
        let point = Vec3::new(0.22 * t, 0.91, -0.29 + 0.03 * t * t);
        arc.push((point, 0.018));
    }
    parts.push(smooth_tube(&arc, 2, 14));
    merge_parts("chair", parts)
}

/// Returns a leg with bulges.
fn turned_leg(foot: Vec3, top: Vec3) -> Mesh {
    let radii = [0.012, 0.015, 0.013, 0.021, 0.016, 0.023, 0.017, 0.019];
    let mut knots = Vec::new();
    for (i, radius) in radii.into_iter().enumerate() {
        let t = i as f32 / (radii.len() - 1) as f32;
        knots.push((foot.lerp(top, t), radius));
    }
    smooth_tube(&knots, 4, 16)
}

/// Returns a table with turned legs.
pub(super) fn table(half: [f32; 2]) -> Mesh {
    let [x, z] = half;
    let mut parts = vec![
        block([-x, 0.71, -z], [x, 0.75, z]),
        block([0.12 - x, 0.62, 0.1 - z], [x - 0.12, 0.71, 0.12 - z]),
        block([0.12 - x, 0.62, z - 0.12], [x - 0.12, 0.71, z - 0.1]),
    ];
    for corner in FEET {
        let place = Vec3::new(corner[0] * (x - 0.11), 0.0, corner[1] * (z - 0.11));
        let foot = turned_leg(place, place + 0.71 * Vec3::Y);
        parts.push(foot);
    }
    merge_parts("table", parts)
}

/// Heights of the boards of a bookcase; half its width and its depth, metres.
const BOARDS: [f32; 7] = [0.06, 0.42, 0.76, 1.08, 1.40, 1.72, 2.02];
const CASE: f32 = 0.95;
const CASE_DEPTH: f32 = 0.30;

/// Returns a bookcase, its back at z = 0.
pub(super) fn bookcase() -> Mesh {
    let mut parts = vec![
        block([-CASE, 0.0, 0.0], [CASE, 2.04, 0.015]),
        block([-CASE - 0.03, 0.0, 0.0], [-CASE, 2.06, CASE_DEPTH]),
        block([CASE, 0.0, 0.0], [CASE + 0.03, 2.06, CASE_DEPTH]),
        block([-0.012, 0.06, 0.0], [0.012, 2.02, CASE_DEPTH - 0.01]),
    ];
    for y in BOARDS {
        parts.push(block(
            [-CASE, y - 0.012, 0.0],
            [CASE, y + 0.012, CASE_DEPTH],
        ));
    }
    merge_parts("bookcase", parts)
}

/// Returns the books of a [`bookcase`] in three colours: upright ones, leaning ones, stacks, gaps.
pub(super) fn books() -> [Mesh; 3] {
    let mut random = Random::new(17);
    let mut colors: [Vec<Mesh>; 3] = Default::default();
    for boards in BOARDS.windows(2) {
        let room = boards[1] - boards[0] - 0.06;
        let mut x = 0.03 - CASE;
        while x < CASE - 0.06 {
            let thick = random.number_between(0.014, 0.045);
            let tall = room * random.number_between(0.68, 0.98);
            let deep = random.number_between(0.15, 0.22);
            let color = random.number_between(0.0, 2.99) as usize;
            let leans = random.chance(0.06);
            let foot = translation(x, boards[0] + 0.012, 0.0);
            let tilt = if leans { -0.22 } else { 0.0 };
            let place = foot * Affine3A::from_rotation_z(tilt);
            colors[color].push(transform_mesh(book([thick, tall, deep]), place));
            x += thick + if leans { 0.24 * tall } else { 0.002 };
            if random.chance(0.05) {
                x += random.number_between(0.06, 0.16);
            }
            // Skip the board in the middle.
            if x < 0.015 && x + 0.06 > -0.015 {
                x = 0.016;
            }
        }
    }
    colors.map(|parts| merge_parts("books", parts))
}

/// Returns a book of this thickness, height and depth: two covers, a rounded spine and inset pages.
fn book(size: [f32; 3]) -> Mesh {
    let [thick, tall, deep] = size;
    let cover = 0.1 * thick;
    let spine = sheet([8, 1], |u, v| {
        let (cos, sin) = on_circle(0.5 * f64::from(1.0 - u));
        let x = 0.5 * thick * (1.0 + cos);
        Vec3::new(x, tall * (1.0 - v), deep + 0.25 * thick * sin)
    });
    let parts = [
        block([0.0, 0.0, 0.03], [cover, tall, deep]),
        block([thick - cover, 0.0, 0.03], [thick, tall, deep]),
        block([cover, 0.008, 0.036], [thick - cover, tall - 0.008, deep]),
        spine,
    ];
    merge_parts("book", parts)
}

/// Returns a cushion: a ball stretched towards a box of this half size.
pub(super) fn cushion(middle: impl Into<Vec3>, half: impl Into<Vec3>) -> Mesh {
    let (middle, half) = (middle.into(), half.into());
    let mut ball = icosphere(Vec3::ZERO, 1.0, 4);
    ball.normals.clear();
    for p in &mut ball.positions {
        // Move the point of the unit ball part of the way to the box around it.
        let to_box = 1.0 / p.abs().max_element();
        *p *= 0.25 + 0.75 * to_box;
        let pillow = 1.0 - 0.12 * (p.x * p.x + p.z * p.z);
        *p = middle + half * *p * Vec3::new(1.0, pillow, 1.0);
    }
    ball
}

/// Returns an armchair of cushions on four feet.
pub(super) fn armchair() -> Mesh {
    let mut parts = vec![
        cushion([0.0, 0.30, 0.0], [0.38, 0.12, 0.36]),
        cushion([0.0, 0.46, 0.05], [0.29, 0.09, 0.33]),
        cushion([0.0, 0.64, -0.30], [0.36, 0.32, 0.11]),
        cushion([-0.38, 0.42, 0.02], [0.09, 0.20, 0.36]),
        cushion([0.38, 0.42, 0.02], [0.09, 0.20, 0.36]),
    ];
    for corner in FEET {
        let top = Vec3::new(0.32 * corner[0], 0.22, 0.28 * corner[1]);
        let foot = top + Vec3::new(0.03 * corner[0], -0.22, 0.03 * corner[1]);
        parts.push(stick(foot, top, 0.018));
    }
    merge_parts("armchair", parts)
}

/// Returns an open shade around the origin, from the radii of its lower and upper rim, and its
/// height.
pub(super) fn shade(lower: f32, upper: f32, height: f32) -> Mesh {
    let cloth = sheet([72, 6], |u, v| {
        let (cos, sin) = on_circle(f64::from(u));
        let (_, pleat) = on_circle(f64::from(36.0 * u));
        let radius = (upper + (lower - upper) * v) * (1.0 + 0.008 * pleat);
        Vec3::new(radius * cos, height * (0.5 - v), -radius * sin)
    });
    let rim = |radius: f32, y: f32| {
        transform_mesh(torus(radius, 0.005, [64, 8]), translation(0.0, y, 0.0))
    };
    let spokes = (0..3).map(|i| {
        let (cos, sin) = on_circle(f64::from(i) / 3.0);
        let end = Vec3::new(upper * cos, 0.5 * height, upper * sin);
        stick(end, 0.5 * height * Vec3::Y, 0.003)
    });
    let rims = [rim(lower, -0.5 * height), rim(upper, 0.5 * height)];
    merge_parts("shade", [cloth].into_iter().chain(rims).chain(spokes))
}

/// Returns the pole and foot of a floor lamp of this height.
pub(super) fn lamp_pole(height: f32) -> Mesh {
    let foot = [
        (0.0, 0.0),
        (0.16, 0.0),
        (0.165, 0.015),
        (0.14, 0.03),
        (0.03, 0.045),
        (0.012, 0.08),
        (0.012, 0.9),
        (0.022, 0.92),
        (0.012, 0.94),
        (0.010, height),
        (0.0, height),
    ];
    lathe(&foot, 40)
}

/// Returns a cage of wires around the origin, of this radius, which hangs from a cable of this
/// length.
pub(super) fn cage(radius: f32, cable: f32) -> Mesh {
    const WIRES: u32 = 10;
    let mut parts = Vec::new();
    for i in 0..WIRES {
        let (cos, sin) = on_circle(f64::from(i) / f64::from(WIRES));
        let mut knots = Vec::new();
        for k in 0..=10 {
            let (up, out) = on_circle(0.5 * (0.06 + 0.9 * f64::from(k) / 10.0));
            let point = Vec3::new(out * cos, 1.15 * up, out * sin) * radius;
            knots.push((point, 0.0012));
        }
        parts.push(smooth_tube(&knots, 1, 6));
    }
    for (size, y) in [(0.99, 0.0), (0.72, 0.8), (0.72, -0.8)] {
        let ring = torus(size * radius, 0.0014, [48, 6]);
        parts.push(transform_mesh(ring, translation(0.0, y * radius, 0.0)));
    }
    let socket = [
        (0.0, 0.055),
        (0.022, 0.055),
        (0.026, 0.12),
        (0.04, 0.19),
        (0.01, 0.24),
        (0.0, 0.24),
    ];
    parts.push(lathe(&socket, 24));
    parts.push(stick(0.2 * Vec3::Y, cable * Vec3::Y, 0.005));
    merge_parts("cage", parts)
}

/// Returns a desk lamp on two arms. Its head is at the origin and points along -y; its foot is
/// `drop` below.
pub(super) fn desk_lamp(drop: f32) -> Mesh {
    let head = sheet([48, 10], |u, v| {
        let (cos, sin) = on_circle(f64::from(u));
        let radius = 0.022 + 0.075 * v * (1.6 - 0.6 * v);
        Vec3::new(radius * cos, 0.075 - 0.115 * v, -radius * sin)
    });
    let foot = Vec3::new(0.24, -drop, -0.02);
    let elbow = Vec3::new(0.42, -0.12, -0.06);
    let top = 0.075 * Vec3::Y;
    let base = [
        (0.0, 0.0),
        (0.085, 0.0),
        (0.085, 0.015),
        (0.02, 0.03),
        (0.0, 0.035),
    ];
    let parts = [
        head,
        transform_mesh(lathe(&base, 40), Affine3A::from_translation(foot)),
        stick(foot, elbow, 0.006),
        stick(foot + 0.02 * Vec3::Z, elbow + 0.02 * Vec3::Z, 0.004),
        stick(elbow, top, 0.006),
        icosphere(elbow, 0.014, 3),
        icosphere(top, 0.024, 3),
    ];
    merge_parts("desk lamp", parts)
}

/// Returns a vessel by its profile of radius and height.
pub(super) fn vessel(profile: &[(f32, f32)]) -> Mesh {
    lathe(profile, 48)
}

/// Returns a basket woven of rings around upright sticks.
pub(super) fn basket() -> Mesh {
    const RINGS: u32 = 15;
    let radius = |t: f32| 0.15 + 0.06 * t;
    let mut parts = Vec::new();
    for i in 0..RINGS {
        let t = i as f32 / (RINGS - 1) as f32;
        let ring = torus(radius(t), 0.011, [40, 8]);
        parts.push(transform_mesh(
            ring,
            translation(0.0, 0.012 + 0.32 * t, 0.0),
        ));
    }
    for i in 0..24 {
        let (cos, sin) = on_circle(f64::from(i) / 24.0);
        let foot = Vec3::new(radius(0.0) * cos, 0.0, radius(0.0) * sin);
        let top = Vec3::new(radius(1.0) * cos, 0.36, radius(1.0) * sin);
        parts.push(stick(foot, top, 0.007));
    }
    parts.push(lathe(
        &[(0.0, 0.0), (0.15, 0.0), (0.15, 0.01), (0.0, 0.01)],
        40,
    ));
    merge_parts("basket", parts)
}

/// Returns a rug of this half size with fringes at both ends.
pub(super) fn rug(half: [f32; 2]) -> Mesh {
    let [x, z] = half;
    let mut parts = vec![block([-x, 0.0, -z], [x, 0.012, z])];
    let mut random = Random::new(23);
    let fringes = (2.0 * z / 0.025) as u32;
    for i in 0..fringes {
        let along = z * (2.0 * (i as f32 + 0.5) / fringes as f32 - 1.0);
        for side in [-1.0, 1.0] {
            let root = Vec3::new(side * x, 0.008, along);
            let end = root + Vec3::new(0.07 * side, -0.004, random.signed_number(0.02));
            parts.push(stick(root, end, 0.0035));
        }
    }
    merge_parts("rug", parts)
}

/// Returns a framed picture of half this size, its back at z = 0.
pub(super) fn frame(half: [f32; 2]) -> Mesh {
    let [x, y] = half;
    let edge = 0.03;
    let parts = [
        block([-x, -y, 0.0], [x, edge - y, 0.03]),
        block([-x, y - edge, 0.0], [x, y, 0.03]),
        block([-x, edge - y, 0.0], [edge - x, y - edge, 0.03]),
        block([x - edge, edge - y, 0.0], [x, y - edge, 0.03]),
        block([-x, -y, 0.0], [x, y, 0.008]),
    ];
    merge_parts("frame", parts)
}

/// Returns a curtain of this width and height on a rod with rings. The origin is the centre of its
/// top.
pub(super) fn curtain(width: f32, height: f32) -> Mesh {
    let folds = f64::from(9.0 * width);
    let cloth = sheet([260, 36], |u, v| {
        let (_, fold) = on_circle(folds * f64::from(u));
        let (_, slow) = on_circle(f64::from(2.3 * u + 0.1 * v));
        let z = (0.018 + 0.03 * v) * (fold + 0.5 * slow);
        Vec3::new(width * (u - 0.5), -height * v, z)
    });
    let half = 0.5 * width + 0.12;
    let rod = stick([-half, 0.03, 0.0], [half, 0.03, 0.0], 0.012);
    let upright = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2);
    let rings = (0..14).map(|i| {
        let x = width * (i as f32 / 13.0 - 0.5);
        let place = Affine3A::from_rotation_translation(upright, Vec3::new(x, 0.028, 0.0));
        transform_mesh(torus(0.022, 0.003, [20, 6]), place)
    });
    merge_parts("curtain", [cloth, rod].into_iter().chain(rings))
}

/// Returns a chest of drawers, or the drawers of a desk: a box with fronts and knobs.
pub(super) fn drawers(half: [f32; 2], height: f32) -> Mesh {
    let [x, z] = half;
    let mut parts = vec![block([-x, 0.03, -z], [x, height, z])];
    let count = 3;
    for i in 0..count {
        let low = 0.06 + (height - 0.08) * i as f32 / count as f32;
        let high = low + (height - 0.08) / count as f32 - 0.02;
        parts.push(block([0.02 - x, low, z], [x - 0.02, high, z + 0.015]));
        let knob = Vec3::new(0.0, 0.5 * (low + high), z + 0.03);
        parts.push(icosphere(knob, 0.014, 3));
    }
    for corner in FEET {
        let foot = Vec3::new(corner[0] * (x - 0.03), 0.015, corner[1] * (z - 0.03));
        parts.push(box_at(foot, [0.02, 0.015, 0.02]));
    }
    crease_mesh(&merge_parts("drawers", parts))
}
