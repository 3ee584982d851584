//! The inside of a church: columns, arcades, a gallery, windows, a ribbed vault, benches, lamps on
//! chains. The sun shines in through the windows.

use super::{
    SIZE,
    parts::{
        arch_outline, box_at, crease_mesh, merge_parts, pierced_wall, smooth_tube, stick,
        transform_mesh, translation, turned_placement,
    },
    things::{baluster, bench, chain, fluted_column, oil_lamp},
};
use crate::{
    looks::{checker, glossy, matte},
    primitives::{block, grid, on_circle, prism, tile_mesh},
    stage::Stage,
};
use umbrage_core::glam::{Affine3A, Vec2, Vec3};
use umbrage_core::{Light, Mesh, Scene};

/// Bays along the nave (along z), and their length, metres. Columns stand at their ends.
const BAYS: i32 = 10;
const BAY: f32 = 4.0;
/// Half the length of the nave; distances from its centre line to the columns and to the outer
/// walls, metres.
const LENGTH: f32 = 0.5 * BAY * BAYS as f32;
const ROW: f32 = 4.4;
const WIDTH: f32 = 8.4;
/// Half the thickness of all walls, metres.
const WALL: f32 = 0.28;
/// Heights of the columns, the gallery's floor, its roof, and the foot of the vault, metres.
const SPRING: f32 = 4.3;
const GALLERY: f32 = 6.6;
const ROOF: f32 = 10.4;
const VAULT: f32 = 14.0;
/// Radii of the vault's inner face and of its ribs, metres.
const VAULT_RADIUS: f32 = ROW - WALL;
const RIB: f32 = 0.16;

const STONE: [f32; 3] = [0.78, 0.71, 0.60];
const PALE_STONE: [f32; 3] = [0.88, 0.83, 0.74];
const IRON: [f32; 3] = [0.07, 0.07, 0.08];
const BRASS: [f32; 3] = [0.55, 0.38, 0.12];
const OAK: [f32; 3] = [0.44, 0.26, 0.13];
const CARPET: [f32; 3] = [0.42, 0.05, 0.06];

pub(crate) fn nave() -> Scene {
    lit_by("nave", 0.0)
}

pub(crate) fn nave_soft() -> Scene {
    lit_by("nave-soft", 3.0_f32.to_radians())
}

fn lit_by(name: &str, angular_diameter: f32) -> Scene {
    let stage = furnish_stage(walls(Stage::new(name)));
    stage
        .light(Light::Directional {
            direction: Vec3::new(-0.85, -0.36, -0.40),
            angular_diameter,
        })
        .shoot([2.7, 2.9, 14.8], [-2.4, 3.6, -1.0], 62.0, SIZE)
}

/// Returns placements on both sides at the end or centre of a bay, whose z points to the nave.
fn both_sides(x: f32, y: f32, z: f32) -> [Affine3A; 2] {
    let quarter = std::f32::consts::FRAC_PI_2;
    [
        turned_placement([-x, y, z], quarter),
        turned_placement([x, y, z], -quarter),
    ]
}

/// Returns the placements at the ends of all bays.
fn at_ends(x: f32, y: f32) -> Vec<Affine3A> {
    let ends = (0..=BAYS).map(|i| BAY * i as f32 - LENGTH);
    ends.flat_map(|z| both_sides(x, y, z)).collect()
}

/// Returns the placements at the centres of all bays.
fn in_middles(x: f32, y: f32) -> Vec<Affine3A> {
    let middles = (0..BAYS).map(|i| BAY * (i as f32 + 0.5) - LENGTH);
    middles.flat_map(|z| both_sides(x, y, z)).collect()
}

fn walls(stage: Stage) -> Stage {
    let floor = tile_mesh(
        grid([WIDTH + WALL, LENGTH + 1.0], [16, 40], |_, _| 0.0),
        Vec2::new(9.0, 22.0),
    );
    stage
        .put(floor)
        .look(checker())
        .put_many(fluted_column(SPRING, 0.37), at_ends(ROW, 0.0))
        .look(matte(PALE_STONE))
        .put_many(arcade(), in_middles(ROW, SPRING))
        .look(matte(STONE))
        .put_many(gallery(), in_middles(ROW, GALLERY))
        .look(matte(STONE))
        .put_many(fluted_column(2.2, 0.16), in_middles(ROW, GALLERY))
        .look(matte(PALE_STONE))
        .put_many(clerestory(), in_middles(ROW, ROOF))
        .look(matte(STONE))
        .put_many(outer_wall(), in_middles(WIDTH, 0.0))
        .look(matte(STONE))
        .put_many(floors_of_a_bay(), in_middles(0.5 * (ROW + WIDTH), GALLERY))
        .look(matte(STONE))
        .put_many(glazing(), in_middles(WIDTH, 0.0))
        .look(matte(IRON))
        .put(vault())
        .look(matte(PALE_STONE))
        .put_many(ribs(), rib_places())
        .look(matte(STONE))
        .put(ends())
        .look(matte(STONE))
}

fn furnish_stage(stage: Stage) -> Stage {
    let mut balusters = Vec::new();
    for place in in_middles(ROW, GALLERY) {
        for i in 0..20 {
            let along = -1.66 + 3.32 * (i as f32 + 0.5) / 20.0;
            balusters.push(place * translation(along, 0.0, 0.15));
        }
    }
    let mut benches = Vec::new();
    for row in 0..14 {
        let z = 8.0 - 1.25 * row as f32;
        benches.push(translation(2.15, 0.0, z));
        benches.push(translation(-2.15, 0.0, z));
    }
    let mut lamps = Vec::new();
    for row in 0..5 {
        let z = 9.0 - 6.0 * row as f32;
        lamps.push(translation(2.2, 5.2, z));
        lamps.push(translation(-2.2, 5.2, z));
    }
    let chains: Vec<_> = lamps
        .iter()
        .map(|lamp| *lamp * translation(0.0, 0.5, 0.0))
        .collect();
    stage
        .put_many(baluster(0.95), balusters)
        .look(matte(PALE_STONE))
        .put_many(rail(), in_middles(ROW, GALLERY))
        .look(matte(PALE_STONE))
        .put_many(bench(2.6), benches)
        .look(matte(OAK))
        .put_many(oil_lamp(), lamps)
        .look(glossy(BRASS))
        .put_many(chain(11.6), chains)
        .look(matte(IRON))
        .put(carpet())
        .look(matte(CARPET))
        .put(altar())
        .look(matte(PALE_STONE))
        .put(candlesticks())
        .look(glossy(BRASS))
}

fn wall_of(outline: &[(f32, f32)]) -> Mesh {
    crease_mesh(&prism(outline, WALL, -WALL))
}

/// Returns the wall of a bay above its arch, with its foot at the springing line.
fn arcade() -> Mesh {
    let half = 0.5 * BAY;
    let opening = arch_outline(0.0, 1.62, 0.0, 0.08);
    let wall = wall_of(&pierced_wall(half, 0.0, GALLERY - SPRING, &[opening]));
    let cornice = block([-half, 2.05, WALL], [half, 2.3, WALL + 0.12]);
    merge_parts("arcade", [wall, archivolt(0.0, 1.7, 0.08), cornice])
}

/// Returns a round moulding along an arch's rim.
fn archivolt(middle: f32, radius: f32, spring: f32) -> Mesh {
    let mut knots = Vec::new();
    for i in 0..=32 {
        let (cos, sin) = on_circle(0.5 - f64::from(i) / 64.0);
        let point = Vec3::new(middle + radius * cos, spring + radius * sin, WALL);
        knots.push((point, 0.07));
    }
    smooth_tube(&knots, 1, 10)
}

/// Returns the gallery's wall of a bay: two arches with a small column between them.
fn gallery() -> Mesh {
    let openings = [-0.93, 0.93].map(|middle| arch_outline(middle, 0.75, 0.0, 2.2));
    let wall = wall_of(&pierced_wall(0.5 * BAY, 0.0, ROOF - GALLERY, &openings));
    let rims = [-0.93, 0.93].map(|middle| archivolt(middle, 0.79, 2.2));
    merge_parts("gallery", [wall].into_iter().chain(rims))
}

/// Returns the wall of a bay above the aisles: one window and its bars.
fn clerestory() -> Mesh {
    let sill = 0.5;
    let top = VAULT - ROOF;
    let half = 0.5 * BAY;
    let opening = arch_outline(0.0, 1.4, sill, 1.95);
    let wall = wall_of(&pierced_wall(half, sill, top, &[opening]));
    let below = block([-half, 0.0, -WALL], [half, sill, WALL]);
    let mullions = [-0.4, 0.4].map(|x| block([x - 0.05, sill, -0.08], [x + 0.05, 3.2, 0.08]));
    let rim = archivolt(0.0, 1.46, 1.95);
    merge_parts("clerestory", [wall, below, rim].into_iter().chain(mullions))
}

/// Returns the outer wall of a bay: a window to the aisle, one to the gallery.
fn outer_wall() -> Mesh {
    let half = 0.5 * BAY;
    let slab = |foot: f32, top: f32| block([-half, foot, -WALL], [half, top, WALL]);
    let lower = pierced_wall(half, 1.1, GALLERY, &[arch_outline(0.0, 1.6, 1.1, 4.4)]);
    let upper = pierced_wall(
        half,
        GALLERY + 0.9,
        ROOF,
        &[arch_outline(0.0, 1.5, GALLERY + 0.9, GALLERY + 2.1)],
    );
    merge_parts(
        "outer wall",
        [
            slab(0.0, 1.1),
            wall_of(&lower),
            slab(GALLERY, GALLERY + 0.9),
            wall_of(&upper),
        ],
    )
}

/// Returns the bars in the windows of the [`outer_wall`].
fn glazing() -> Mesh {
    let mut bars = Vec::new();
    for i in 0..5 {
        let x = 0.45 * (i as f32 - 2.0);
        let foot = Vec3::new(x, 1.1, 0.0);
        bars.push(stick(foot, foot + 4.55 * Vec3::Y, 0.018));
        let upper_foot = Vec3::new(x, GALLERY + 0.9, 0.0);
        bars.push(stick(upper_foot, upper_foot + 2.6 * Vec3::Y, 0.018));
    }
    for i in 0..12 {
        let y = 1.5 + 0.7 * i as f32;
        let from = Vec3::new(-1.35, y, 0.0);
        bars.push(stick(from, from + 2.7 * Vec3::X, 0.014));
    }
    merge_parts("glazing", bars)
}

/// Returns the gallery's floor and roof over one bay.
fn floors_of_a_bay() -> Mesh {
    let half = Vec3::new(0.5 * BAY, 0.12, 0.5 * (WIDTH - ROW) + WALL);
    let floor = box_at([0.0, -0.12, 0.0], half);
    let roof = box_at([0.0, ROOF - GALLERY + 0.12, 0.0], half);
    merge_parts("gallery floor", [floor, roof])
}

/// Returns the barrel vault over the nave.
fn vault() -> Mesh {
    const PIECES: u32 = 96;
    let mut outline = Vec::new();
    let mut add = |i: u32, radius: f32| {
        let (cos, sin) = on_circle(0.5 * f64::from(i) / f64::from(PIECES));
        outline.push((radius * cos, VAULT + radius * sin));
    };
    for i in 0..=PIECES {
        add(i, ROW + WALL);
    }
    for i in (0..=PIECES).rev() {
        add(i, VAULT_RADIUS);
    }
    crease_mesh(&prism(&outline, LENGTH, -LENGTH))
}

/// Returns the ribs of one bay: one across at its end, and two diagonal ones.
fn ribs() -> Mesh {
    let arc = |from: f32, to: f32, radius: f32| {
        let mut knots = Vec::new();
        for i in 0..=40 {
            let t = i as f32 / 40.0;
            let (cos, sin) = on_circle(0.5 * f64::from(t));
            let z = from + (to - from) * t;
            let point = Vec3::new(VAULT_RADIUS * cos, VAULT_RADIUS * sin, z);
            knots.push((point, radius));
        }
        smooth_tube(&knots, 1, 12)
    };
    let ribs = [
        arc(0.0, 0.0, 1.5 * RIB),
        arc(0.0, BAY, RIB),
        arc(BAY, 0.0, RIB),
    ];
    merge_parts("ribs", ribs)
}

fn rib_places() -> Vec<Affine3A> {
    let bays = 0..BAYS;
    bays.map(|i| translation(0.0, VAULT, BAY * i as f32 - LENGTH))
        .collect()
}

/// Returns the walls at both ends: a solid one behind the camera, and one with three tall windows
/// in front of it.
fn ends() -> Mesh {
    let wide = WIDTH + WALL;
    let top = VAULT + ROW + WALL;
    let rear = block([-wide, 0.0, LENGTH], [wide, top, LENGTH + 0.5]);
    let windows = [-2.4, 0.0, 2.4].map(|middle| arch_outline(middle, 0.8, 4.5, 11.5));
    let pane = prism(&pierced_wall(wide, 4.5, top, &windows), 0.25, -0.25);
    let front = transform_mesh(crease_mesh(&pane), translation(0.0, 0.0, -LENGTH));
    let sill = block([-wide, 0.0, -LENGTH - 0.25], [wide, 4.5, -LENGTH + 0.25]);
    merge_parts("ends", [rear, front, sill])
}

/// Returns the rail on the balusters of the gallery.
fn rail() -> Mesh {
    let top = box_at([0.0, 1.0, 0.15], [1.68, 0.05, 0.13]);
    let foot = box_at([0.0, 0.03, 0.15], [1.68, 0.03, 0.13]);
    merge_parts("rail", [top, foot])
}

fn carpet() -> Mesh {
    block([-0.7, 0.0, -15.0], [0.7, 0.012, 12.0])
}

/// Returns three steps with a four-legged table on them.
fn altar() -> Mesh {
    let mut parts = Vec::new();
    for i in 0..3 {
        let rise = 0.17 * i as f32;
        let depth = 4.0 - 0.5 * i as f32;
        let low = Vec3::new(-3.9, rise, -LENGTH);
        parts.push(block(low, [3.9, rise + 0.17, -LENGTH + depth]));
    }
    parts.push(box_at([0.0, 1.5, -LENGTH + 1.6], [1.4, 0.06, 0.5]));
    for x in [-1.2, -0.4, 0.4, 1.2] {
        let foot = translation(x, 0.51, -LENGTH + 1.6);
        parts.push(transform_mesh(fluted_column(0.93, 0.1), foot));
    }
    merge_parts("altar", parts)
}

/// Returns tall candlesticks along the centre line.
fn candlesticks() -> Mesh {
    let mut parts = Vec::new();
    for row in 0..6 {
        for x in [-1.02, 1.02] {
            let z = -10.0 + 3.75 * row as f32;
            let foot = translation(x * 0.78, 0.0, z);
            parts.push(transform_mesh(baluster(1.5), foot));
        }
    }
    merge_parts("candlesticks", parts)
}
