//! Tiles of a moment map, each written by a workgroup that reads every depth once.

use glam::UVec2;

/// Number of moments that a workgroup keeps: 16,320 bytes. WebGPU guarantees 16,384, and OpenGL ES
/// 3.1 16,352.
const CAPACITY: u32 = 1020;
/// Number of a workgroup's invocations along each axis.
const LANES: u32 = 8;

/// A tile, and the way in which a workgroup fills it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct MomentTile {
    /// Width and height, texels. The width is a multiple of 8.
    pub(crate) size: UVec2,
    /// Number of rows of depths that are read at a time.
    pub(crate) rows: u32,
}

impl MomentTile {
    /// Returns the tile for a blur of this radius, texels.
    ///
    /// A workgroup keeps the means along rows of the tile and its surroundings, and the moments of
    /// `rows` wider rows. The tile is the one that fits and reads the fewest depths per texel.
    /// Fewer rows than invocations leave some idle, so they are only chosen for radii above 27,
    /// for which nothing else fits.
    pub(crate) fn for_radius(radius: u32) -> Self {
        for rows in [LANES, LANES / 2, LANES / 4, 1] {
            let widths = (1..=8).map(|count| count * LANES);
            let tiles = widths.filter_map(|width| Self::highest(radius, width, rows));
            let best = tiles.min_by(|a, b| a.reads(radius).total_cmp(&b.reads(radius)));
            if let Some(tile) = best {
                return tile;
            }
        }
        // The narrowest tile of one row holds all radii up to `MAX_BLUR`, which recipes check.
        Self {
            size: UVec2::new(LANES, LANES),
            rows: 1,
        }
    }

    /// Returns the highest tile of this width that fits; `None` if it has fewer rows than a
    /// workgroup.
    fn highest(radius: u32, width: u32, rows: u32) -> Option<Self> {
        let left = CAPACITY.checked_sub(rows * (width + 2 * radius))?;
        let height = (left / width).checked_sub(2 * radius)?;
        (height >= LANES).then_some(Self {
            size: UVec2::new(width, height),
            rows,
        })
    }

    /// Returns the number of depths read for each texel of a full tile.
    pub(crate) fn reads(self, radius: u32) -> f32 {
        let read = self.size + 2 * radius;
        (read.x * read.y) as f32 / (self.size.x * self.size.y) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filtering::moments::map::MAX_BLUR;

    /// Every tile fits into a workgroup's memory and has work for all invocations.
    #[test]
    fn tiles_fit() {
        for radius in 0..=MAX_BLUR {
            let MomentTile { size, rows } = MomentTile::for_radius(radius);
            let means = size.x * (size.y + 2 * radius);
            let moments = rows * (size.x + 2 * radius);
            assert!(means + moments <= CAPACITY, "radius {radius}");
            assert!(size.min_element() >= LANES, "radius {radius}");
            assert_eq!(size.x % LANES, 0, "radius {radius}");
        }
    }

    /// Bytes moved for a texel: depths read and moments written. Without tiles there are three
    /// filters: moments, rows, columns. Counted here are each image's reads and writes, with each
    /// texel read once by a filter, which favours the three.
    #[test]
    fn tiles_move_less_than_half() {
        let depth = 4.0;
        // (radius, bytes of a texel, greatest share of the bytes of three filters)
        let cases = [
            (1, 16.0, 0.26),
            (3, 16.0, 0.27),
            (3, 8.0, 0.33),
            (3, 4.0, 0.43),
            (8, 16.0, 0.34),
            (8, 8.0, 0.47),
        ];
        for (radius, texel, most) in cases {
            let before = depth + 5.0 * texel;
            let after = depth * MomentTile::for_radius(radius).reads(radius) + texel;
            let share = after / before;
            assert!(share <= most, "radius {radius}, {texel} bytes: {share}");
            assert!(
                share > 0.9 * most,
                "radius {radius}, {texel} bytes: {share}"
            );
        }
    }
}
