//! A dancer: head, hands with fingers, limbs, bodice, a skirt of strips, ribbons, a staff. She
//! faces +z, stands on the toes of her right foot (at -x) at the origin, and lifts the other leg
//! behind her. Metres.

use super::{
    parts::{merge_parts, sheet, smooth_tube, transform_mesh},
    random::Random,
};
use crate::primitives::{icosphere, lathe, on_circle, torus, tube};
use umbrage_core::Mesh;
use umbrage_core::glam::{Affine3A, Quat, Vec3};

/// Sides of limbs and fingers, and segments between two of their knots.
const LIMB: [u32; 2] = [48, 16];
const FINGER: [u32; 2] = [16, 6];
/// Strips in each layer of the skirt, and cells in each strip.
const STRIPS: u32 = 44;
const STRIP_CELLS: [u32; 2] = [6, 56];
/// The waist: the upper rim of the skirt.
const WAIST: Vec3 = Vec3::new(0.0, 1.08, 0.0);

/// The meshes of the figure, one for each colour.
#[derive(Clone, Debug)]
pub(super) struct Dancer {
    pub(super) skin: Mesh,
    pub(super) hair: Mesh,
    pub(super) bodice: Mesh,
    pub(super) upper_skirt: Mesh,
    pub(super) lower_skirt: Mesh,
    pub(super) shoes: Mesh,
    pub(super) ribbons: Mesh,
    pub(super) staff: Mesh,
}

/// Wrists: the right one, whose hand holds the staff, and the left one.
const STAFF_WRIST: Vec3 = Vec3::new(-0.56, 1.72, 0.16);
const OPEN_WRIST: Vec3 = Vec3::new(0.66, 1.60, 0.20);
/// Direction of the staff.
const STAFF: Vec3 = Vec3::new(-0.16, 1.0, 0.10);

pub(super) fn dancer() -> Dancer {
    Dancer {
        skin: skin(),
        hair: hair(),
        bodice: bodice(),
        upper_skirt: skirt(3, 0.34, -0.02),
        lower_skirt: skirt(4, 0.52, 0.08),
        shoes: shoes(),
        ribbons: ribbons(),
        staff: staff(),
    }
}

/// Returns a limb through knots of x, y, z and radius.
fn limb(knots: &[[f32; 4]]) -> Mesh {
    let knots: Vec<_> = knots
        .iter()
        .map(|k| (Vec3::new(k[0], k[1], k[2]), k[3]))
        .collect();
    smooth_tube(&knots, LIMB[1], LIMB[0])
}

fn skin() -> Mesh {
    let standing = limb(&[
        [-0.09, 0.98, 0.0, 0.085],
        [-0.09, 0.78, 0.02, 0.082],
        [-0.07, 0.54, 0.04, 0.056],
        [-0.05, 0.38, 0.0, 0.058],
        [-0.02, 0.16, -0.02, 0.034],
        [0.0, 0.10, 0.0, 0.032],
    ]);
    let lifted = limb(&[
        [0.09, 0.98, -0.02, 0.085],
        [0.15, 0.90, -0.26, 0.082],
        [0.20, 0.86, -0.48, 0.056],
        [0.16, 0.98, -0.64, 0.057],
        [0.10, 1.16, -0.78, 0.034],
        [0.08, 1.21, -0.83, 0.032],
    ]);
    let staff_arm = limb(&[
        [-0.10, 1.40, 0.0, 0.050],
        [-0.26, 1.43, 0.02, 0.045],
        [-0.42, 1.47, 0.05, 0.034],
        [-0.51, 1.61, 0.12, 0.034],
        [-0.56, 1.72, 0.16, 0.020],
    ]);
    let open_arm = limb(&[
        [0.10, 1.40, 0.0, 0.050],
        [0.27, 1.45, 0.02, 0.044],
        [0.43, 1.50, 0.07, 0.033],
        [0.56, 1.56, 0.14, 0.033],
        [0.66, 1.60, 0.20, 0.019],
    ]);
    let neck = limb(&[
        [0.0, 1.36, -0.01, 0.07],
        [0.0, 1.46, 0.0, 0.047],
        [0.01, 1.56, 0.01, 0.045],
        [0.015, 1.62, 0.02, 0.05],
    ]);
    let joints = [
        icosphere([-0.155, 1.412, 0.0], 0.048, 4),
        icosphere([0.155, 1.412, 0.0], 0.048, 4),
        icosphere(STAFF_WRIST, 0.0225, 3),
        icosphere(OPEN_WRIST, 0.0215, 3),
    ];
    let hands = [staff_hand(), open_hand()].concat();
    let limbs = [standing, lifted, staff_arm, open_arm, neck, head()];
    merge_parts("skin", limbs.into_iter().chain(joints).chain(hands))
}

/// Returns the head with nose and chin.
fn head() -> Mesh {
    let mut head = icosphere(Vec3::ZERO, 1.0, 5);
    head.normals.clear();
    for p in &mut head.positions {
        let chin = (-p.y).max(0.0) * (0.4 + 0.6 * p.z.max(0.0));
        let from_nose = p.distance(Vec3::new(0.0, -0.12, 0.98));
        let nose = (1.0 - from_nose / 0.3).max(0.0);
        let narrow = 1.0 - 0.25 * (-p.y).max(0.0);
        *p *= Vec3::new(0.074 * narrow, 0.108, 0.095);
        p.z += 0.016 * nose;
        p.y -= 0.012 * chin;
    }
    let tilt = Quat::from_rotation_z(-0.16) * Quat::from_rotation_y(0.35);
    let place = Vec3::new(0.02, 1.70, 0.03);
    transform_mesh(head, Affine3A::from_rotation_translation(tilt, place))
}

fn hair() -> Mesh {
    let mut cap = icosphere(Vec3::ZERO, 1.0, 4);
    cap.normals.clear();
    for p in &mut cap.positions {
        *p *= Vec3::new(0.080, 0.104, 0.097);
    }
    let cap = transform_mesh(
        cap,
        Affine3A::from_translation(Vec3::new(0.025, 1.722, 0.008)),
    );
    let bun = icosphere([0.03, 1.80, -0.07], 0.048, 4);
    let band = Affine3A::from_rotation_translation(
        Quat::from_rotation_x(-0.9),
        Vec3::new(0.03, 1.775, -0.045),
    );
    let band = transform_mesh(torus(0.042, 0.008, [48, 12]), band);
    let mut parts = vec![cap, bun, band];
    // Add loose locks of hair.
    for i in 0..7 {
        let side = i as f32 / 6.0 - 0.5;
        let root = Vec3::new(0.03 + 0.1 * side, 1.76, -0.075);
        let end = root + Vec3::new(0.16 * side - 0.05, -0.16, -0.12);
        let middle = root.lerp(end, 0.5) + Vec3::new(0.0, 0.04, -0.03);
        let knots = [(root, 0.006), (middle, 0.004), (end, 0.001)];
        parts.push(smooth_tube(&knots, 10, 8));
    }
    merge_parts("hair", parts)
}

/// Returns the torso, flattened from front to back, with a collar's rim.
fn bodice() -> Mesh {
    let outline = [
        (0.0, 0.90),
        (0.10, 0.90),
        (0.155, 0.95),
        (0.15, 1.03),
        (0.118, 1.10),
        (0.115, 1.14),
        (0.135, 1.22),
        (0.15, 1.29),
        (0.152, 1.35),
        (0.165, 1.40),
        (0.15, 1.44),
        (0.08, 1.47),
        (0.0, 1.475),
    ];
    // Split straight segments, so that they can be rounded.
    let mut profile = vec![outline[0]];
    for ends in outline.windows(2) {
        for k in 1..=6 {
            let t = k as f32 / 6.0;
            let r = ends[0].0 + (ends[1].0 - ends[0].0) * t;
            profile.push((r, ends[0].1 + (ends[1].1 - ends[0].1) * t));
        }
    }
    let mut torso = lathe(&profile, 72);
    for p in &mut torso.positions {
        p.z *= 0.68;
        let chest = (1.0 - ((p.y - 1.30) / 0.09).powi(2)).max(0.0);
        if p.z > 0.0 {
            p.z *= 1.0 + 0.25 * chest;
        }
    }
    merge_parts("bodice", [torso])
}

/// Returns a finger through three joints. It starts at `root` along one vector and bends towards
/// another.
fn finger(root: Vec3, along: Vec3, bend: Vec3) -> Mesh {
    let knots = [
        (root, 0.0095),
        (root + 0.4 * along + 0.08 * bend, 0.0088),
        (root + 0.72 * along + 0.3 * bend, 0.0078),
        (root + 0.95 * along + 0.62 * bend, 0.0055),
        (root + 0.98 * along + 0.66 * bend, 0.001),
    ];
    smooth_tube(&knots, FINGER[1], FINGER[0])
}

/// Returns a hand. Its palm extends from the wrist along `ahead`; its fingers are spread along
/// `aside` and bend towards `palm`.
fn hand(wrist: Vec3, ahead: Vec3, aside: Vec3, curl: f32) -> Vec<Mesh> {
    let down = ahead.cross(aside).normalize();
    let mut palm = icosphere(Vec3::ZERO, 1.0, 3);
    palm.normals.clear();
    for p in &mut palm.positions {
        *p = wrist + ahead * (0.045 + 0.052 * p.x) + aside * (0.036 * p.y) + down * (0.017 * p.z);
    }
    let mut parts = vec![palm];
    let lengths = [0.070, 0.080, 0.076, 0.060];
    for (i, length) in lengths.into_iter().enumerate() {
        let off = i as f32 - 1.5;
        let root = wrist + 0.085 * ahead + (0.018 * off) * aside;
        let along = (ahead + 0.14 * off * aside).normalize() * length;
        parts.push(finger(root, along, down * (curl * length)));
    }
    let root = wrist + 0.03 * ahead - 0.032 * aside;
    let thumb = (0.6 * ahead - 0.8 * aside) * 0.06;
    parts.push(finger(root, thumb, down * (0.05 * curl)));
    parts
}

/// Returns the left hand, its fingers spread.
fn open_hand() -> Vec<Mesh> {
    let ahead = Vec3::new(0.82, 0.42, 0.38).normalize();
    let aside = ahead.cross(Vec3::Y).normalize();
    hand(OPEN_WRIST, ahead, aside, -0.35)
}

/// Returns the right hand, its fingers around the staff.
fn staff_hand() -> Vec<Mesh> {
    let ahead = Vec3::new(-0.3, 0.55, 0.78).normalize();
    let aside = STAFF.reject_from(ahead).normalize();
    hand(STAFF_WRIST, ahead, aside, 0.9)
}

/// Returns a layer of the skirt that extends `reach` beyond the hips. Its strips swing without
/// touching each other.
fn skirt(seed: i32, reach: f32, drop: f32) -> Mesh {
    let mut random = Random::new(seed);
    let mut strips = Vec::new();
    for i in 0..STRIPS {
        let turn = (f64::from(i) + 0.3 * f64::from(random.unit())) / f64::from(STRIPS);
        let swing = random.number_between(0.85, 1.15);
        let lift = random.signed_number(0.05);
        let phase = f64::from(random.unit());
        let width = random.number_between(0.68, 0.92) / f64::from(STRIPS) as f32;
        strips.push(sheet(STRIP_CELLS, |u, v| {
            // Let strips trail behind the turning waist.
            let lag = 0.09 * v * v;
            let around = turn + f64::from((u - 0.5) * width - lag);
            let (cos, sin) = on_circle(around);
            let (_, wave) = on_circle(f64::from(1.3 * v) + phase);
            let (_, fold) = on_circle(f64::from(u) + phase);
            let out = 0.115 + reach * swing * v * (1.25 - 0.35 * v);
            let flat = 0.75 + 0.25 * v;
            let fall = (0.30 + drop) * v * v + 0.05 * v - lift * v;
            let ripple = 0.035 * wave * v + 0.012 * fold * v;
            WAIST + Vec3::new(out * cos, ripple - fall, -out * sin * flat)
        }));
    }
    let rim = torus(0.122, 0.014, [96, 12]);
    let flat =
        Affine3A::from_scale_rotation_translation(Vec3::new(1.0, 1.0, 0.75), Quat::IDENTITY, WAIST);
    strips.push(transform_mesh(rim, flat));
    merge_parts("skirt", strips)
}

fn shoes() -> Mesh {
    let standing = limb(&[
        [-0.015, 0.14, -0.01, 0.038],
        [0.0, 0.10, 0.01, 0.038],
        [0.0, 0.05, 0.012, 0.032],
        [0.0, 0.015, 0.012, 0.020],
        [0.0, 0.0, 0.012, 0.014],
    ]);
    let lifted = limb(&[
        [0.09, 1.185, -0.80, 0.036],
        [0.075, 1.22, -0.84, 0.037],
        [0.045, 1.27, -0.90, 0.031],
        [0.02, 1.31, -0.95, 0.018],
        [0.015, 1.32, -0.96, 0.008],
    ]);
    let laces = (0..3).map(|i| {
        let up = 0.15 + 0.035 * i as f32;
        let tilt = Quat::from_rotation_z(if i % 2 == 0 { 0.3 } else { -0.3 });
        let place = Vec3::new(-0.015 - 0.01 * i as f32, up, -0.018);
        let ring = torus(0.037, 0.004, [32, 8]);
        transform_mesh(ring, Affine3A::from_rotation_translation(tilt, place))
    });
    merge_parts("shoes", [standing, lifted].into_iter().chain(laces))
}

/// Returns two ribbons that fly from the staff's end, and one from the open hand.
fn ribbons() -> Mesh {
    let end = STAFF_WRIST + 0.95 * STAFF;
    let fly = |from: Vec3, drift: Vec3, turns: f32, wide: f32| {
        sheet([4, 260], |u, v| {
            let (cos, sin) = on_circle(f64::from(turns * v));
            let radius = 0.20 * v * (1.3 - 0.5 * v);
            let curl = Vec3::new(
                0.4 * radius * sin,
                radius * cos - 0.2 * radius,
                radius * sin,
            );
            let across = Vec3::new(0.35 * sin, 0.9, 0.35 * cos).normalize();
            from + drift * v + curl * v.min(0.3) / 0.3 + across * (wide * (u - 0.5))
        })
    };
    let open_end = OPEN_WRIST + Vec3::new(0.06, 0.02, 0.03);
    merge_parts(
        "ribbons",
        [
            fly(end, Vec3::new(1.35, -0.22, -0.25), 3.2, 0.055),
            fly(end, Vec3::new(0.95, -0.6, 0.35), 2.6, 0.04),
            fly(open_end, Vec3::new(0.75, -0.55, 0.1), 2.3, 0.045),
        ],
    )
}

/// Returns the staff with rings and a knob.
fn staff() -> Mesh {
    let grip = STAFF_WRIST + Vec3::new(-0.018, 0.035, 0.052);
    let along = STAFF.normalize();
    let foot = grip - 0.75 * along;
    let end = grip + 0.95 * along;
    let mut parts = vec![
        tube(&[(foot, 0.010), (grip, 0.011), (end, 0.008)], 20),
        icosphere(end, 0.026, 4),
        icosphere(foot, 0.016, 3),
    ];
    let upright = Quat::from_rotation_arc(Vec3::Y, along);
    for i in 0..4 {
        let place = end - (0.05 + 0.03 * i as f32) * along;
        let ring = torus(0.013, 0.004, [24, 8]);
        parts.push(transform_mesh(
            ring,
            Affine3A::from_rotation_translation(upright, place),
        ));
    }
    merge_parts("staff", parts)
}
