//! Crowns of trees and bushes from leaf cards: quads with alpha-tested leaves.

use super::content::random::Random;
use umbrage_core::Mesh;
use umbrage_core::glam::{Vec2, Vec3};

/// Shape of a crown, in metres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crown {
    pub(crate) seed: i32,
    pub(crate) middle: Vec3,
    /// Half its size.
    pub(crate) half: Vec3,
    pub(crate) cards: u32,
    /// Approximate side of a card.
    pub(crate) side: f32,
}

/// Returns the cards of a crown, two triangles each. The texture covers each card once.
pub(crate) fn crown(shape: &Crown) -> Mesh {
    let mut random = Random::new(shape.seed);
    let mut out = Mesh {
        name: "leaf cards".to_owned(),
        ..Mesh::default()
    };
    for _ in 0..shape.cards {
        let outwards = random.vector().normalize_or(Vec3::Y);
        // Put more cards near the rim than in the centre.
        let from_middle = random.unit().sqrt();
        let at = shape.middle + shape.half * outwards * from_middle;
        let normal = (outwards + 0.8 * random.vector()).normalize_or(Vec3::Y);
        let up = (outwards + Vec3::Y + 0.5 * random.vector()).reject_from(normal);
        let up = up.normalize_or(normal.any_orthonormal_vector());
        let half = 0.5 * shape.side * random.number_between(0.7, 1.2);
        let right = up.cross(normal);
        let first = out.positions.len() as u32;
        for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            out.positions.push(at + half * (x * right + y * up));
            out.uvs.push(Vec2::new(0.5 + 0.5 * x, 0.5 - 0.5 * y));
        }
        out.triangles.push([first, first + 1, first + 2]);
        out.triangles.push([first, first + 2, first + 3]);
    }
    out
}
