//! A dancer on a stage before a curtain, under one spot.

use super::{
    SIZE,
    figure::dancer as figure,
    parts::{box_at, merge_parts, sheet, stick, transform_mesh, translation},
};
use crate::{
    looks::{glossy, matte, wood},
    primitives::{block, grid, lathe, on_circle, tile_mesh},
    stage::Stage,
};
use umbrage_core::glam::{Vec2, Vec3};
use umbrage_core::{Light, Mesh, Scene};

/// Position of the spot light and its target on the stage, metres.
const SPOT: Vec3 = Vec3::new(-2.2, 2.7, 4.3);
const AIM: Vec3 = Vec3::new(0.4, 1.0, -0.7);
/// The curtain's plane, z in metres.
const BACK: f32 = -1.9;

const SKIN: [f32; 3] = [0.58, 0.36, 0.26];
const HAIR: [f32; 3] = [0.10, 0.05, 0.03];
const BODICE: [f32; 3] = [0.10, 0.14, 0.38];
const UPPER_SKIRT: [f32; 3] = [0.62, 0.60, 0.68];
const LOWER_SKIRT: [f32; 3] = [0.22, 0.30, 0.58];
const RIBBONS: [f32; 3] = [0.72, 0.16, 0.14];
const GOLD: [f32; 3] = [0.60, 0.42, 0.13];
const CURTAIN: [f32; 3] = [0.46, 0.40, 0.36];

pub(crate) fn dancer() -> Scene {
    lit_by("dancer", 0.0)
}

pub(crate) fn dancer_soft() -> Scene {
    lit_by("dancer-soft", 0.25)
}

fn lit_by(name: &str, radius: f32) -> Scene {
    let figure = figure();
    set(Stage::new(name))
        .put(figure.skin)
        .look(matte(SKIN))
        .put(figure.hair)
        .look(glossy(HAIR))
        .put(figure.bodice)
        .look(matte(BODICE))
        .put(figure.upper_skirt)
        .look(matte(UPPER_SKIRT))
        .put(figure.lower_skirt)
        .look(matte(LOWER_SKIRT))
        .put(figure.shoes)
        .look(matte(RIBBONS))
        .put(figure.ribbons)
        .look(matte(RIBBONS))
        .put(figure.staff)
        .look(glossy(GOLD))
        .light(Light::Spot {
            position: SPOT,
            direction: AIM - SPOT,
            inner: 19.0_f32.to_radians(),
            outer: 25.0_f32.to_radians(),
            radius,
        })
        .shoot([1.35, 1.5, 4.5], [0.3, 1.34, -0.4], 39.0, SIZE)
}

/// Returns the stage without the figure: boards, curtain, a rail in front of it, and props.
fn set(stage: Stage) -> Stage {
    let floor = tile_mesh(grid([5.0, 4.0], [10, 8], |_, _| 0.0), Vec2::new(6.0, 9.0));
    stage
        .put(floor)
        .look(wood())
        .put(curtain())
        .look(matte(CURTAIN))
        .put(barre())
        .look(matte([0.33, 0.19, 0.09]))
        .put(stool())
        .look(matte([0.42, 0.12, 0.10]))
        .put(vases())
        .look(glossy([0.12, 0.30, 0.30]))
}

/// Returns the wall and a curtain in front of it. The folds of the curtain are deeper near the
/// floor.
fn curtain() -> Mesh {
    let cloth = sheet([420, 30], |u, v| {
        let x = 5.0 * (2.0 * u - 1.0);
        let (_, fold) = on_circle(f64::from(26.0 * u));
        let (_, slow) = on_circle(f64::from(7.3 * u + 0.2));
        let depth = 0.03 + 0.05 * v;
        let z = BACK + depth * (fold + 0.6 * slow);
        Vec3::new(x, 4.2 * (1.0 - v) + 0.015, z)
    });
    let wall = block([-5.0, 0.0, BACK - 0.5], [5.0, 4.6, BACK - 0.3]);
    merge_parts("curtain", [cloth, wall])
}

/// Returns a dancers' rail on thin posts.
fn barre() -> Mesh {
    let z = BACK + 0.55;
    let from = Vec3::new(-2.6, 1.02, z);
    let low = 0.3 * Vec3::Y;
    let mut parts = vec![
        stick(from, from + 5.2 * Vec3::X, 0.022),
        stick(from - low, from - low + 5.2 * Vec3::X, 0.018),
    ];
    for i in 0..5 {
        let x = -2.5 + 1.25 * i as f32;
        let foot = Vec3::new(x, 0.0, z);
        parts.push(stick(foot, foot + 1.02 * Vec3::Y, 0.02));
        parts.push(box_at(foot + 0.012 * Vec3::Y, [0.05, 0.012, 0.16]));
    }
    merge_parts("barre", parts)
}

fn stool() -> Mesh {
    let middle = Vec3::new(-1.35, 0.0, -0.55);
    let seat = [
        (0.0, 0.44),
        (0.17, 0.44),
        (0.185, 0.46),
        (0.17, 0.49),
        (0.0, 0.50),
    ];
    let mut parts = vec![transform_mesh(
        lathe(&seat, 48),
        translation(middle.x, 0.0, middle.z),
    )];
    for i in 0..4 {
        let (cos, sin) = on_circle(f64::from(i) / 4.0 + 0.1);
        let foot = middle + Vec3::new(0.2 * cos, 0.0, 0.2 * sin);
        let top = middle + Vec3::new(0.12 * cos, 0.44, 0.12 * sin);
        parts.push(stick(foot, top, 0.013));
        let (next_cos, next_sin) = on_circle(f64::from(i + 1) / 4.0 + 0.1);
        let across = middle + Vec3::new(0.17 * next_cos, 0.17, 0.17 * next_sin);
        let from = middle + Vec3::new(0.17 * cos, 0.17, 0.17 * sin);
        parts.push(stick(from, across, 0.008));
    }
    merge_parts("stool", parts)
}

/// Returns a vase with bare twigs at the right.
fn vases() -> Mesh {
    let outline = [
        (0.0, 0.0),
        (0.09, 0.0),
        (0.15, 0.12),
        (0.16, 0.24),
        (0.10, 0.40),
        (0.055, 0.48),
        (0.075, 0.54),
        (0.06, 0.54),
        (0.04, 0.48),
        (0.0, 0.46),
    ];
    let place = translation(1.55, 0.0, -0.95);
    let mut parts = vec![lathe(&outline, 56)];
    for i in 0..11 {
        let (cos, sin) = on_circle(f64::from(i) * 0.381_966);
        let spread = 0.1 + 0.025 * i as f32;
        let tip = Vec3::new(spread * cos, 1.0 + 0.03 * i as f32, spread * sin);
        let foot = Vec3::new(0.02 * cos, 0.48, 0.02 * sin);
        parts.push(stick(foot, tip, 0.004));
        let fork = foot.lerp(tip, 0.55);
        let aside = Vec3::new(-0.14 * sin, 0.22, 0.14 * cos);
        parts.push(stick(fork, fork + aside, 0.003));
    }
    transform_mesh(merge_parts("vase", parts), place)
}
