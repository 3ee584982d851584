//! Textures in both languages. They repeat, and are filtered bilinearly with explicit loads, since
//! the weights of samplers have 8 bits on most hardware.
//!
//! A texture is `(first texel, width, height, 0)` in a table of texels. A width of 0 means no
//! texture.

use glam::{UVec2, UVec4, Vec2, Vec4};
use std::{iter::repeat_n, sync::Arc};
use umbrage_core::{Module, Texture, module};

/// WGSL half. The including module declares the texel table and how to load from it.
pub(crate) const TEXTURE: Module = module!("texture");

/// Returns the two texels along an axis of `size` texels whose centres are around the texture
/// coordinate `u`.
#[inline(always)]
pub(crate) fn neighbours(u: f32, size: u32) -> UVec2 {
    let x = ((u - u.floor()) * size as f32 - 0.5).floor();
    let last = size.wrapping_sub(1);
    let first = (x.max(0.0) as u32).min(last);
    if x < 0.0 {
        return UVec2::new(last, first);
    }
    // Textures repeat: the last texel's neighbour is the first.
    let second = if first == last {
        0
    } else {
        first.wrapping_add(1)
    };
    UVec2::new(first, second)
}

/// Returns the position of `u` between the centres of its two [`neighbours`], 0 to 1.
#[inline(always)]
pub(crate) fn fraction(u: f32, size: u32) -> f32 {
    let x = (u - u.floor()) * size as f32 - 0.5;
    x - x.floor()
}

/// Returns the linear blend from `a` to `b`. It is exact if both are equal, so that flat maps stay
/// flat.
#[inline(always)]
pub(crate) fn blend(a: Vec4, b: Vec4, t: f32) -> Vec4 {
    a + (b - a) * t
}

/// Returns the texture's value at `uv`, with the origin at the top left. `texels` is the table of
/// all textures.
#[inline(always)]
pub(crate) fn bilinear(texels: &[[u32; 4]], texture: UVec4, uv: Vec2) -> Vec4 {
    let columns = neighbours(uv.x, texture.y);
    let rows = neighbours(uv.y, texture.z);
    let above = texture.x + rows.x * texture.y;
    let below = texture.x + rows.y * texture.y;
    let s = fraction(uv.x, texture.y);
    let top = blend(
        load(texels, above + columns.x),
        load(texels, above + columns.y),
        s,
    );
    let bottom = blend(
        load(texels, below + columns.x),
        load(texels, below + columns.y),
        s,
    );
    blend(top, bottom, fraction(uv.y, texture.z))
}

#[inline(always)]
fn load(texels: &[[u32; 4]], index: u32) -> Vec4 {
    Vec4::from_array(texels[index as usize].map(f32::from_bits))
}

/// Returns the texels of all textures in sequence, and each texture's location among them. The
/// table is one row of zeros if there are none. Textures of `None` have no texels and the width 0.
pub(crate) fn rows(textures: &[Option<&Texture>]) -> (Arc<[[u32; 4]]>, Vec<UVec4>) {
    // Allocate once: a growing vector, and its conversion, would hold up to three times the texels.
    let shown = textures.iter().flatten();
    let count: usize = shown.map(|texture| texture.texels.len()).sum();
    let mut table: Arc<[[u32; 4]]> = repeat_n([0; 4], count.max(1)).collect();
    let rows = Arc::make_mut(&mut table);
    let mut places = Vec::new();
    let mut first = 0;
    for texture in textures {
        let Some(texture) = texture else {
            places.push(UVec4::ZERO);
            continue;
        };
        places.push(UVec4::new(first as u32, texture.size.x, texture.size.y, 0));
        for (row, texel) in rows[first..].iter_mut().zip(texture.texels.iter()) {
            *row = texel.map(f32::to_bits);
        }
        first += texture.texels.len();
    }
    (table, places)
}

/// All twins of this module, for the tests that compare them.
#[cfg(feature = "testing")]
pub(crate) const TWINS: &[umbrage_core::Twin] = &[
    umbrage_core::twin!(TEXTURE, neighbours(u: f32, size: u32) -> UVec2),
    umbrage_core::twin!(TEXTURE, fraction(u: f32, size: u32) -> f32),
    umbrage_core::twin!(TEXTURE, blend(a: Vec4, b: Vec4, t: f32) -> Vec4),
];

#[cfg(test)]
mod tests {
    use super::*;

    /// Red, green over blue, white: every flip or rotation changes the image.
    fn texture() -> Texture {
        let texels = vec![
            [1.0, 0.0, 0.0, 1.0],
            [0.0, 1.0, 0.0, 1.0],
            [0.0, 0.0, 1.0, 1.0],
            [1.0; 4],
        ];
        Texture {
            name: "2x2".to_owned(),
            size: UVec2::splat(2),
            texels: texels.into(),
        }
    }

    fn read(u: f32, v: f32) -> [f32; 4] {
        let other = Texture {
            size: UVec2::ONE,
            texels: vec![[9.0; 4]].into(),
            ..texture()
        };
        let (rows, places) = rows(&[Some(&other), None, Some(&texture())]);
        assert_eq!((rows.len(), places[1]), (5, UVec4::ZERO));
        bilinear(&rows, places[2], Vec2::new(u, v)).to_array()
    }

    /// u grows to the right, v down; texel centres are at quarters.
    #[test]
    fn the_origin_is_top_left() {
        let [red, green, blue, white] = [0, 1, 2, 3].map(|i| texture().texels.get(i));
        assert_eq!(
            [
                read(0.25, 0.25),
                read(0.75, 0.25),
                read(0.25, 0.75),
                read(0.75, 0.75)
            ],
            [red, green, blue, white]
        );
    }

    #[test]
    fn between_centres_texels_blend_and_beyond_the_edge_they_repeat() {
        assert_eq!(read(0.5, 0.25), [0.5, 0.5, 0.0, 1.0]);
        // Three quarters of the way from blue to white, blended equally with the row above.
        assert_eq!(read(0.625, 0.75), [0.75, 0.75, 1.0, 1.0]);
        assert_eq!(
            read(0.0, 0.25),
            [0.5, 0.5, 0.0, 1.0],
            "half way from the last column to the first"
        );
        for (u, v) in [(0.375, 0.625), (0.0, 0.0), (0.9375, 0.125)] {
            for (x, y) in [(1.0, 0.0), (-3.0, 2.0), (0.0, -1.0)] {
                assert_eq!(
                    read(u + x, v + y),
                    read(u, v),
                    "({u}, {v}) moved by ({x}, {y})"
                );
            }
        }
    }

    #[test]
    fn flat_textures_are_flat_everywhere() {
        let flat = Texture {
            name: "flat".to_owned(),
            size: UVec2::new(5, 3),
            texels: vec![[0.1, 0.5, 0.7, 1.0]; 15].into(),
        };
        let (rows, places) = rows(&[Some(&flat)]);
        for i in 0..1000 {
            let uv = Vec2::new(i as f32 * 0.377, i as f32 * -0.061);
            assert_eq!(
                bilinear(&rows, places[0], uv).to_array(),
                [0.1, 0.5, 0.7, 1.0],
                "{uv}"
            );
        }
    }

    #[test]
    fn coordinates_that_round_to_the_edge_stay_inside() {
        for u in [-1e-9, 1.0 - 1e-8, 1e30, -1e30, f32::NAN, 0.999_999_94] {
            for size in [1, 2, 3, 1000] {
                let found = neighbours(u, size);
                assert!(found.max_element() < size, "{u}, {size}: {found}");
            }
        }
    }
}
