//! A clearing in a wood behind a fence. Crowns and bushes are quads with alpha-tested leaves, and
//! the fence is one alpha-tested quad.

use super::{
    SIZE,
    parts::{scaled_placement, translation},
    plants::{Growth, tree},
    random::scatter_points,
};
use crate::{
    builtin::{
        crowns::{Crown, crown},
        noise::fractal,
    },
    looks::{matte, netting, sprig},
    primitives::{grid, pillar, quad, tile_mesh},
    stage::Stage,
};
use umbrage_core::glam::{Affine3A, Vec2, Vec3};
use umbrage_core::{Light, Scene};

/// Half the side of the ground, metres, and its cells.
const HALF: f32 = 70.0;
const CELLS: u32 = 200;
/// Radius of the clearing around the origin, where the ground is level, metres.
const CLEARING: f32 = 6.0;
/// The camera's z, metres.
const EYE: f32 = 8.5;

const SOIL: [f32; 3] = [0.33, 0.33, 0.15];
const BARK: [f32; 3] = [0.22, 0.16, 0.11];
const STEEL: [f32; 3] = [0.30, 0.31, 0.33];
const LEAVES: [[f32; 3]; 3] = [[0.15, 0.32, 0.06], [0.20, 0.36, 0.08], [0.34, 0.34, 0.08]];
const BUSHES: [f32; 3] = [0.12, 0.27, 0.09];
const WEEDS: [f32; 3] = [0.22, 0.36, 0.09];

pub(crate) fn leaf_cards() -> Scene {
    lit_by("leaf-cards", 0.0)
}

pub(crate) fn leaf_cards_soft() -> Scene {
    lit_by("leaf-cards-soft", 2.0_f32.to_radians())
}

fn lit_by(name: &str, angular_diameter: f32) -> Scene {
    let ground = grid([HALF, HALF], [CELLS, CELLS], height);
    let stage = Stage::new(name).put(ground).look(matte(SOIL));
    fence(bushes(trees(stage)))
        .light(Light::Directional {
            direction: Vec3::new(0.42, -0.80, 0.36),
            angular_diameter,
        })
        .shoot([1.2, 1.7, EYE], [-0.5, 1.1, -2.0], 56.0, SIZE)
}

/// Returns the ground's height, metres: level in the clearing, rolling around it.
fn height(x: f32, z: f32) -> f32 {
    let outside = ((x.hypot(z) - CLEARING) / 12.0).clamp(0.0, 1.0);
    2.2 * outside * fractal(Vec3::new(x, 0.0, z) / 16.0, 3)
}

/// Returns placements with a random turn and scale, one for each cell of a grid. None is within
/// `clear` of the centre of the clearing, or right in front of the camera.
fn around_clearing(seed: i32, half: f32, pitch: f32, sizes: [f32; 2], clear: f32) -> Vec<Affine3A> {
    scatter_points(seed, half, pitch, |[x, z], random| {
        let scale = Vec3::splat(random.number_between(sizes[0], sizes[1]));
        let turn = random.signed_number(3.1);
        let at_eye = (x - 1.2).hypot(z - EYE) < 2.0 + 0.4 * clear;
        let is_clear = x.hypot(z) >= clear && !at_eye;
        is_clear.then(|| scaled_placement([x, height(x, z), z], turn, scale))
    })
}

fn trees(mut stage: Stage) -> Stage {
    let places = around_clearing(31, 60.0, 7.5, [0.8, 1.2], CLEARING + 0.5);
    let mut stands: [Vec<Affine3A>; LEAVES.len()] = Default::default();
    for (i, place) in places.into_iter().enumerate() {
        stands[i % LEAVES.len()].push(place);
    }
    for (kind, places) in stands.into_iter().enumerate() {
        let tall = 1.5 * kind as f32;
        let wood = Growth {
            seed: 60 + kind as i32,
            height: 10.0 + tall,
            girth: 0.22,
            reach: 3.0,
            bare: 0.3,
            branches: 16,
            leaves: 0,
            leaf: 0.0,
            has_twigs: false,
        };
        let leaves = Crown {
            seed: 70 + kind as i32,
            middle: Vec3::new(0.0, 0.64 * wood.height, 0.0),
            half: Vec3::new(3.1, 0.38 * wood.height, 3.1),
            cards: 420,
            side: 1.0,
        };
        stage = stage
            .put_many(tree(&wood).wood, places.clone())
            .look(matte(BARK))
            .put_many(crown(&leaves), places)
            .look(sprig(LEAVES[kind]));
    }
    stage
}

/// Adds bushes around the clearing, and weeds all over it.
fn bushes(stage: Stage) -> Stage {
    let leaves = Crown {
        seed: 80,
        middle: Vec3::new(0.0, 0.45, 0.0),
        half: Vec3::new(0.7, 0.5, 0.7),
        cards: 70,
        side: 0.45,
    };
    let weeds = Crown {
        seed: 81,
        middle: Vec3::new(0.0, 0.06, 0.0),
        half: Vec3::new(0.3, 0.1, 0.3),
        cards: 14,
        side: 0.24,
    };
    let bush_places = around_clearing(32, 24.0, 3.1, [0.6, 1.4], CLEARING);
    let weed_places = around_clearing(33, 12.0, 0.8, [0.5, 1.3], 0.0);
    stage
        .put_many(crown(&leaves), bush_places)
        .look(sprig(BUSHES))
        .put_many(crown(&weeds), weed_places)
        .look(sprig(WEEDS))
}

/// Adds a fence across the clearing: one quad of netting with meshes of 6 cm, between posts.
fn fence(stage: Stage) -> Stage {
    const LENGTH: f32 = 12.0;
    const HEIGHT: f32 = 1.3;
    const MESH: f32 = 0.06;
    let from = Vec3::new(-6.4, 0.0, 4.4);
    let along = Vec3::new(0.96, 0.0, -0.28) * LENGTH;
    let up = HEIGHT * Vec3::Y;
    let netting_corners = [from, from + along, from + along + up, from + up];
    let posts = (0..5).map(|i| {
        let foot = from + along * (0.25 * i as f32);
        translation(foot.x, -0.1, foot.z)
    });
    stage
        .put(tile_mesh(
            quad(netting_corners),
            Vec2::new(LENGTH, HEIGHT) / MESH,
        ))
        .look(netting(STEEL, 0.06))
        .put_many(pillar(0.035, HEIGHT + 0.2, 12), posts)
        .look(matte(STEEL))
}
