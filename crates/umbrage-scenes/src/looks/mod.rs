//! Looks of built-in scenes: linear colours, and textures made in code.

mod bricks;
mod cut_outs;
mod patterns;

pub(crate) use bricks::Bricks;
pub(crate) use cut_outs::{chequered_holes, netting, sprig};
pub(crate) use patterns::{checker, wood};

#[cfg(test)]
mod tests;

use umbrage_core::glam::{UVec2, Vec2, Vec3, Vec4};
use umbrage_core::{Material, Texture};

/// A material and its textures, numbered from 0.
#[derive(Clone, Debug)]
pub(crate) struct Look {
    pub(crate) material: Material,
    pub(crate) textures: Vec<Texture>,
}

/// Colours of the floor, and of the other objects in turn.
pub(crate) const PALETTE: [[f32; 3]; 8] = [
    [0.52, 0.50, 0.46],
    [0.60, 0.17, 0.12],
    [0.10, 0.28, 0.55],
    [0.62, 0.42, 0.08],
    [0.12, 0.42, 0.20],
    [0.42, 0.20, 0.46],
    [0.08, 0.42, 0.44],
    [0.62, 0.30, 0.22],
];

/// One colour with a faint highlight.
pub(crate) fn matte(color: [f32; 3]) -> Look {
    let material = Material {
        diffuse: Vec3::from(color),
        specular: Vec3::splat(0.05),
        ..Material::default()
    };
    Look {
        material,
        textures: Vec::new(),
    }
}

/// One colour with a small bright highlight.
pub(crate) fn glossy(color: [f32; 3]) -> Look {
    let look = matte(color);
    Look {
        material: Material {
            specular: Vec3::splat(0.5),
            shininess_log2: 6,
            ..look.material
        },
        ..look
    }
}

/// Returns a look with the texture's colours.
fn textured_look(texture: Texture) -> Look {
    let look = matte([1.0; 3]);
    Look {
        material: Material {
            diffuse_texture: Some(0),
            ..look.material
        },
        textures: vec![texture],
    }
}

/// Returns a square texture of `side` texels. `at` returns the colour at a texel's centre (u, v),
/// with the origin at the top left.
fn texture(name: &str, side: u32, at: impl Fn(Vec2) -> Vec3) -> Texture {
    texture_with_alpha(name, side, |uv| at(uv).extend(1.0))
}

/// Returns a [`texture`] with alpha as the fourth number.
fn texture_with_alpha(name: &str, side: u32, at: impl Fn(Vec2) -> Vec4) -> Texture {
    let center = |i: u32| (i as f32 + 0.5) / side as f32;
    let texels = (0..side).flat_map(|y| (0..side).map(move |x| Vec2::new(center(x), center(y))));
    Texture {
        name: name.to_owned(),
        size: UVec2::splat(side),
        texels: texels.map(|uv| at(uv).to_array()).collect(),
    }
}
