//! A furnished room at night with three lights: a point light in a cage under the ceiling, which is
//! the compared one, a spot light on a desk, and a floor lamp next to an armchair.

use super::{
    SIZE,
    furniture::{
        armchair, basket, bookcase, books, cage, chair, curtain, desk_lamp, drawers, frame,
        lamp_pole, rug, shade, table, vessel,
    },
    parts::{merge_parts, transform_mesh, translation, turned_placement},
    plants::fern,
    random::Random,
};
use crate::{
    looks::{Look, glossy, matte, wood},
    primitives::{block, icosphere, slabs_around, tile_mesh},
    stage::Stage,
};
use umbrage_core::glam::{Affine3A, Quat, Vec2, Vec3};
use umbrage_core::{Light, Material, Mesh, Scene};

/// Inner bounds of the room, metres.
const LOW: Vec3 = Vec3::new(-2.9, 0.0, -2.3);
const HIGH: Vec3 = Vec3::new(2.9, 2.7, 2.6);
/// Positions of the lights, metres.
const BULB: Vec3 = Vec3::new(0.05, 1.98, 0.1);
const DESK_SPOT: Vec3 = Vec3::new(1.55, 1.17, -1.85);
const FLOOR_LAMP: Vec3 = Vec3::new(-2.35, 1.48, 1.02);
/// Height of the desk, metres.
const DESK: f32 = 0.75;

const WALL: [f32; 3] = [0.55, 0.50, 0.42];
const CEILING: [f32; 3] = [0.64, 0.62, 0.58];
const OAK: [f32; 3] = [0.36, 0.21, 0.10];
const DARK_OAK: [f32; 3] = [0.21, 0.12, 0.06];
const IRON: [f32; 3] = [0.06, 0.06, 0.07];
const BOOKS: [[f32; 3]; 3] = [[0.45, 0.12, 0.09], [0.10, 0.22, 0.34], [0.48, 0.38, 0.20]];
const CLOTH: [f32; 3] = [0.16, 0.27, 0.26];
const RUG: [f32; 3] = [0.40, 0.13, 0.11];
const CURTAIN: [f32; 3] = [0.48, 0.28, 0.14];
const LEAF: [f32; 3] = [0.12, 0.30, 0.09];
const CLAY: [f32; 3] = [0.50, 0.24, 0.14];
const PORCELAIN: [f32; 3] = [0.62, 0.63, 0.64];
const PAPER: [f32; 3] = [0.66, 0.60, 0.46];

/// Radii of the emitting balls and disc, metres: the point light, the spot and the floor lamp.
type LampRadii = [f32; 3];

pub(crate) fn night_room() -> Scene {
    lit_by("night-room", [0.0; 3])
}

pub(crate) fn night_room_soft() -> Scene {
    lit_by("night-room-soft", [0.08, 0.04, 0.09])
}

fn lit_by(name: &str, radii: LampRadii) -> Scene {
    let stage = lamps(small_things(furnish_stage(room(Stage::new(name)))));
    stage
        .light(Light::Point {
            position: BULB,
            radius: radii[0],
        })
        .light(Light::Spot {
            position: DESK_SPOT,
            direction: Vec3::NEG_Y,
            inner: 38.0_f32.to_radians(),
            outer: 52.0_f32.to_radians(),
            radius: radii[1],
        })
        .light(Light::Point {
            position: FLOOR_LAMP,
            radius: radii[2],
        })
        .shoot([2.45, 1.62, 2.35], [-0.75, 0.78, -0.95], 58.0, SIZE)
}

fn room(stage: Stage) -> Stage {
    let [floor, ceiling, left, right, back, front] = slabs_around(LOW, HIGH, 0.12);
    stage
        .put(tile_mesh(floor, Vec2::new(4.0, 4.0)))
        .look(wood())
        .put(ceiling)
        .look(matte(CEILING))
        .put(merge_parts("walls", [left, right, back, front]))
        .look(matte(WALL))
        .put(skirting())
        .look(matte(CEILING))
}

fn skirting() -> Mesh {
    let boards = [
        block(LOW, [HIGH.x, 0.1, LOW.z + 0.018]),
        block(LOW, [LOW.x + 0.018, 0.1, HIGH.z]),
    ];
    merge_parts("skirting", boards)
}

fn furnish_stage(mut stage: Stage) -> Stage {
    let chairs = [
        turned_placement([-0.45, 0.012, -0.62], 0.15),
        turned_placement([0.5, 0.012, -0.58], -0.2),
        turned_placement([-1.05, 0.012, 0.25], 1.75),
        turned_placement([0.42, 0.012, 0.98], 2.75),
        turned_placement([1.45, 0.0, -1.22], 3.4),
    ];
    let case = turned_placement([LOW.x, 0.0, -0.75], std::f32::consts::FRAC_PI_2);
    for (mesh, color) in books().into_iter().zip(BOOKS) {
        stage = stage.put_many(mesh, [case]).look(matte(color));
    }
    stage
        .put_many(bookcase(), [case])
        .look(matte(DARK_OAK))
        .put_many(table([0.8, 0.48]), [translation(0.0, 0.012, 0.12)])
        .look(matte(OAK))
        .put_many(table([0.78, 0.32]), [translation(1.55, 0.0, LOW.z + 0.36)])
        .look(matte(DARK_OAK))
        .put_many(
            drawers([0.22, 0.2], 0.6),
            [translation(2.3, 0.0, LOW.z + 0.38)],
        )
        .look(matte(OAK))
        .put_many(chair(), chairs)
        .look(matte(OAK))
        .put_many(armchair(), [turned_placement([-2.15, 0.0, 1.55], 1.9)])
        .look(matte(CLOTH))
        .put_many(rug([1.5, 1.05]), [translation(0.0, 0.0, 0.15)])
        .look(matte(RUG))
        .put_many(curtain(1.5, 2.25), [translation(-0.85, 2.35, LOW.z + 0.1)])
        .look(matte(CURTAIN))
}

fn small_things(stage: Stage) -> Stage {
    let pot = [
        (0.0, 0.0),
        (0.13, 0.0),
        (0.18, 0.3),
        (0.20, 0.31),
        (0.20, 0.35),
        (0.17, 0.35),
        (0.16, 0.31),
        (0.0, 0.30),
    ];
    let pots = [
        translation(0.38, 0.0, LOW.z + 0.33),
        translation(-2.55, 0.0, 0.52),
    ];
    let greens = pots.map(|pot| pot * translation(0.0, 0.30, 0.0));
    let frames = [
        translation(0.55, 1.75, LOW.z),
        translation(1.35, 1.85, LOW.z),
        translation(2.15, 1.72, LOW.z),
    ];
    let side_frame = turned_placement([LOW.x, 1.6, 1.5], std::f32::consts::FRAC_PI_2);
    let hung: Vec<Affine3A> = frames.into_iter().chain([side_frame]).collect();
    let pictures = hung.clone();
    let picture = block([-0.18, -0.25, 0.0], [0.18, 0.25, 0.012]);
    stage
        .put_many(vessel(&pot), pots)
        .look(matte(CLAY))
        .put_many(fern(8, 21, 0.62), greens)
        .look(matte(LEAF))
        .put_many(frame([0.26, 0.34]), hung)
        .look(matte(DARK_OAK))
        .put_many(picture, pictures)
        .look(matte(PAPER))
        .put_many(
            basket(),
            [translation(-1.5, 0.0, -1.95), translation(0.95, 0.0, -1.9)],
        )
        .look(matte([0.45, 0.32, 0.16]))
        .put(on_the_table())
        .look(glossy(PORCELAIN))
        .put(fruits())
        .look(matte([0.58, 0.20, 0.06]))
        .put(papers())
        .look(matte(PAPER))
}

/// Returns a bowl, a vase and cups on the table.
fn on_the_table() -> Mesh {
    let top = DESK + 0.012;
    let bowl = [
        (0.0, 0.0),
        (0.06, 0.0),
        (0.06, 0.012),
        (0.13, 0.05),
        (0.17, 0.10),
        (0.162, 0.10),
        (0.12, 0.055),
        (0.0, 0.02),
    ];
    let vase = [
        (0.0, 0.0),
        (0.045, 0.0),
        (0.07, 0.08),
        (0.06, 0.17),
        (0.025, 0.24),
        (0.035, 0.28),
        (0.028, 0.28),
        (0.018, 0.24),
        (0.0, 0.22),
    ];
    let cup = [
        (0.0, 0.0),
        (0.028, 0.0),
        (0.038, 0.03),
        (0.040, 0.08),
        (0.036, 0.08),
        (0.034, 0.03),
        (0.0, 0.012),
    ];
    let mut parts = vec![
        transform_mesh(vessel(&bowl), translation(-0.12, top, 0.1)),
        transform_mesh(vessel(&vase), translation(0.34, top, -0.08)),
    ];
    for [x, z] in [[-0.5, 0.28], [0.12, 0.42], [0.58, 0.2]] {
        parts.push(transform_mesh(vessel(&cup), translation(x, top, z)));
        let upright = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
        let handle = Vec3::new(x + 0.045, top + 0.042, z);
        let ring = crate::primitives::torus(0.021, 0.005, [24, 10]);
        parts.push(transform_mesh(
            ring,
            Affine3A::from_rotation_translation(upright, handle),
        ));
    }
    merge_parts("crockery", parts)
}

fn fruits() -> Mesh {
    let middle = Vec3::new(-0.12, DESK + 0.012, 0.1);
    let places = [
        [0.055, 0.075, 0.0],
        [-0.04, 0.075, 0.05],
        [-0.045, 0.075, -0.045],
        [0.005, 0.135, 0.0],
    ];
    let balls = places.map(|place| icosphere(middle + Vec3::from(place), 0.042, 4));
    merge_parts("fruits", balls)
}

/// Returns sheets and a stack of books on the desk and the table.
fn papers() -> Mesh {
    let mut random = Random::new(41);
    let mut parts = Vec::new();
    for i in 0..5 {
        let half = Vec3::new(0.15 - 0.01 * i as f32, 0.015, 0.11);
        let place = Vec3::new(1.05, DESK + 0.015 + 0.03 * i as f32, -1.95);
        let stacked = block(-half, half);
        parts.push(transform_mesh(
            stacked,
            turned_placement(place, random.signed_number(0.25)),
        ));
    }
    for i in 0..6 {
        let half = Vec3::new(0.105, 0.0006, 0.148);
        let x = 1.5 + random.signed_number(0.16);
        let place = Vec3::new(x, DESK + 0.001 + 0.0013 * i as f32, -1.83);
        parts.push(transform_mesh(
            block(-half, half),
            turned_placement(place, random.signed_number(0.5)),
        ));
    }
    let open = turned_placement([-0.42, DESK + 0.018, -0.12], 0.4);
    for side in [-1.0, 1.0] {
        let half = Vec3::new(0.075, 0.006, 0.11);
        let page = transform_mesh(block(-half, half), Affine3A::from_rotation_z(0.09 * side));
        parts.push(transform_mesh(
            page,
            open * translation(0.076 * side, 0.006, 0.0),
        ));
    }
    merge_parts("papers", parts)
}

/// Returns an emissive look.
fn glowing_look(color: [f32; 3]) -> Look {
    let look = matte(color);
    let material = Material {
        emissive: Vec3::from(color),
        ..look.material
    };
    Look { material, ..look }
}

/// Adds the bodies of the lamps. Emitters neither cast nor receive shadows.
fn lamps(stage: Stage) -> Stage {
    let bulbs = [BULB, DESK_SPOT, FLOOR_LAMP].map(Affine3A::from_translation);
    let pole = translation(FLOOR_LAMP.x, 0.0, FLOOR_LAMP.z);
    stage
        .put_many(cage(0.15, HIGH.y - BULB.y), [bulbs[0]])
        .look(matte(IRON))
        .put_many(desk_lamp(DESK_SPOT.y - DESK), [bulbs[1]])
        .look(glossy([0.10, 0.24, 0.20]))
        .put_many(lamp_pole(FLOOR_LAMP.y - 0.05), [pole])
        .look(matte(IRON))
        .put_many(shade(0.24, 0.15, 0.28), [bulbs[2]])
        .look(matte(PAPER))
        .put_many(icosphere(Vec3::ZERO, 0.035, 3), bulbs)
        .look(glowing_look([1.0, 0.9, 0.7]))
        .last_roles(false, false)
}
