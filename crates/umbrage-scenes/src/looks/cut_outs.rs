//! Alpha-tested patterns.

use super::{Look, matte, texture_with_alpha};
use crate::{builtin::noise::uniform, detail::USUAL_CUTOFF};
use umbrage_core::glam::{IVec3, Vec2, Vec3, Vec4};
use umbrage_core::{AlphaCutout, AlphaFilter, Material, Texture};

/// Texels along a side of a sprig and of a piece of netting.
const SPRIG_SIDE: u32 = 128;
const NETTING_SIDE: u32 = 64;

/// A sprig on a square. Its stalk starts at the middle of the lower side, with leaves of this
/// colour on both sides.
pub(crate) fn sprig(color: [f32; 3]) -> Look {
    cut_out(texture_with_alpha("sprig", SPRIG_SIDE, |uv| {
        on_sprig(uv, Vec3::from(color))
    }))
}

/// Netting of crossed wires. The texture covers one mesh of it; wires run along both diagonals.
/// Their width is `thickness`, as a fraction of the texture's side.
pub(crate) fn netting(color: [f32; 3], thickness: f32) -> Look {
    // Across a diagonal, u + v (or u - v) grows by the square root of 2 per unit.
    let half = 0.5 * thickness * std::f32::consts::SQRT_2;
    cut_out(texture_with_alpha("netting", NETTING_SIDE, |uv| {
        let from_falling = distance_to_whole(uv.x + uv.y);
        let from_rising = distance_to_whole(uv.x - uv.y);
        let is_wire = from_falling.min(from_rising) < half;
        Vec3::from(color).extend(f32::from(u8::from(is_wire)))
    }))
}

/// Squares of one texel each, every second one a hole. The texture's lower left is a hole if
/// `squares` is even.
pub(crate) fn chequered_holes(squares: u32) -> Look {
    cut_out(texture_with_alpha("chequered holes", squares, |uv| {
        let place = (uv * squares as f32).as_uvec2();
        let is_there = (place.x + place.y).is_multiple_of(2);
        Vec3::splat(0.4).extend(f32::from(u8::from(is_there)))
    }))
}

/// Returns a look with the texture's colours where its alpha is one half or more.
fn cut_out(texture: Texture) -> Look {
    let alpha = AlphaCutout {
        texture: 0,
        cutoff: USUAL_CUTOFF,
        filter: AlphaFilter::Nearest,
    };
    let material = Material {
        diffuse_texture: Some(0),
        alpha: Some(alpha),
        ..matte([1.0; 3]).material
    };
    Look {
        material,
        textures: vec![texture],
    }
}

fn distance_to_whole(t: f32) -> f32 {
    (t - t.round()).abs()
}

/// Returns colour and alpha at a point of a sprig's square, with v from the top.
fn on_sprig(uv: Vec2, color: Vec3) -> Vec4 {
    const PAIRS: i32 = 5;
    // Coordinates from the foot of the stalk: x to the right, y up.
    let p = Vec2::new(uv.x - 0.5, 1.0 - uv.y);
    let is_stalk = p.x.abs() < 0.012 && p.y < 0.9;
    let mut shade = is_stalk.then_some(0.6);
    // Draw from the foot up, so that upper leaves cover lower ones.
    for pair in 0..PAIRS {
        let height = 0.08 + 0.155 * pair as f32;
        for side in [-1.0, 1.0] {
            // Make upper leaves shorter and more upright.
            let along = Vec2::new(side, 0.35 + 0.2 * pair as f32).normalize();
            let length = 0.5 - 0.055 * pair as f32;
            if is_on_leaf(p - Vec2::new(0.0, height), along, length) {
                let number = 2 * pair + i32::from(side > 0.0);
                shade = Some(0.8 + 0.4 * uniform(IVec3::new(number, 3, 7)));
            }
        }
    }
    if is_on_leaf(p - Vec2::new(0.0, 0.72), Vec2::Y, 0.27) {
        shade = Some(1.1);
    }
    let alpha = f32::from(u8::from(shade.is_some()));
    (color * shade.unwrap_or(1.0)).extend(alpha)
}

/// Reports whether a point, relative to a leaf's stalk, is on the leaf: between two parabolas that
/// meet at its ends.
fn is_on_leaf(p: Vec2, along: Vec2, length: f32) -> bool {
    const WIDTH: f32 = 0.36;
    let t = p.dot(along) / length;
    let aside = p.dot(along.perp()).abs() / length;
    aside < 2.0 * WIDTH * t * (1.0 - t)
}
