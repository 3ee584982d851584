//! Which tiles of a frame's faces each triangle touches.

use super::{
    light_frame::LightFrame,
    outline::{Outline, Traits},
};
use umbrage_core::glam::{UVec2, Vec2, Vec3, Vec4};

/// The finest cells along a tile's side, as a power of two.
pub(super) const FINEST: u32 = 7;

/// A triangle on a face: where its box lies, in finest cells of the face, and how near to the light it comes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Touch {
    /// Its place among the casters; the highest bit says that its outline does not know its depth.
    pub(super) caster: u32,
    /// Least depth on this face, less the margin.
    pub(super) nearest: f32,
    pub(super) low: [u16; 2],
    /// Inclusive.
    pub(super) high: [u16; 2],
}

/// The bit of [`Touch::caster`] and of list items that says that only the triangle test of rays tells depth.
pub(super) const DEPTH_UNKNOWN: u32 = 1 << 31;

/// The touches of some triangles, by tile.
#[derive(Debug, Default)]
pub(super) struct TouchesByTile {
    /// Where each tile's touches begin; one more at the end.
    starts: Vec<u32>,
    touches: Vec<Touch>,
}

impl TouchesByTile {
    /// Returns a tile's touches.
    pub(super) fn of_tile(&self, tile: usize) -> &[Touch] {
        &self.touches[self.starts[tile] as usize..self.starts[tile + 1] as usize]
    }

    /// Finds which tiles triangles touch, and writes their outlines. `corners` are in frame space.
    pub(super) fn find(
        frame: &LightFrame,
        first_caster: u32,
        corners: impl Iterator<Item = [Vec3; 3]>,
        outlines: &mut [[u32; 4]],
    ) -> Self {
        let mut found = Found {
            frame,
            tiles: Vec::new(),
            touches: Vec::new(),
        };
        for ((i, corners), rows) in corners.enumerate().zip(outlines.chunks_exact_mut(3)) {
            let traits = Traits::new(frame, corners);
            rows.copy_from_slice(&traits.outline.rows());
            found.add(first_caster + i as u32, corners, &traits);
        }
        found.by_tile()
    }
}

/// Touches in the order in which they are found, and the tile of each.
struct Found<'a> {
    frame: &'a LightFrame,
    tiles: Vec<u32>,
    touches: Vec<Touch>,
}

impl Found<'_> {
    fn add(&mut self, caster: u32, corners: [Vec3; 3], traits: &Traits) {
        let bit = if traits.knows_depth { 0 } else { DEPTH_UNKNOWN };
        let caster = caster | bit;
        if !self.frame.is_lamp {
            let [a, b, c] = corners;
            let low = a.min(b).min(c);
            let high = a.max(b).max(c);
            let bounds = FaceBounds {
                low: low.truncate(),
                high: high.truncate(),
                nearest: low.z,
            };
            self.add_on_face(caster, 0, &bounds, traits);
            return;
        }
        for face in 0..6 {
            if traits.is_anywhere {
                let bounds = FaceBounds {
                    low: Vec2::NEG_ONE,
                    high: Vec2::ONE,
                    nearest: 0.0,
                };
                self.add_on_face(caster, face, &bounds, traits);
            } else if let Some(bounds) = FaceBounds::on_cube(face, corners, traits.margin) {
                self.add_on_face(caster, face, &bounds, traits);
            }
        }
    }

    fn add_on_face(&mut self, caster: u32, face: u32, bounds: &FaceBounds, traits: &Traits) {
        let frame = self.frame;
        let cells_a_unit = frame.tiles_a_unit * (1 << FINEST) as f32;
        let last = (frame.tiles << FINEST) - UVec2::ONE;
        let to_cell = |at: Vec2| (at + frame.half) * cells_a_unit;
        let low = to_cell(bounds.low - traits.margin);
        let high = to_cell(bounds.high + traits.margin);
        // What lies beside a lamp's face shows on another one.
        let is_beside = high.cmplt(Vec2::ZERO).any() || low.cmpge((last + 1).as_vec2()).any();
        if is_beside {
            return;
        }
        let low = low.max(Vec2::ZERO).as_uvec2().min(last);
        let high = high.max(Vec2::ZERO).as_uvec2().min(last);
        let touch = Touch {
            caster,
            nearest: frame.before(bounds.nearest),
            low: [low.x as u16, low.y as u16],
            high: [high.x as u16, high.y as u16],
        };
        let [first, end] = [low >> FINEST, high >> FINEST];
        let face_start = face * frame.tiles.x * frame.tiles.y;
        let is_small = (end - first).max_element() == 0;
        let has_edges = !traits.is_anywhere && !is_small;
        let on_face = traits.outline.on_face(frame.is_lamp, face);
        for y in first.y..=end.y {
            for x in first.x..=end.x {
                if has_edges && !touches_tile(frame, &on_face, UVec2::new(x, y)) {
                    continue;
                }
                self.tiles.push(face_start + y * frame.tiles.x + x);
                self.touches.push(touch);
            }
        }
    }

    /// Sorts by tile; within one, the order stays.
    fn by_tile(self) -> TouchesByTile {
        let mut starts = vec![0; self.frame.tile_count() + 1];
        for &tile in &self.tiles {
            starts[tile as usize + 1] += 1;
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        let mut next = starts.clone();
        let nothing = Touch {
            caster: 0,
            nearest: 0.0,
            low: [0; 2],
            high: [0; 2],
        };
        let mut touches = vec![nothing; self.touches.len()];
        for (&tile, &touch) in self.tiles.iter().zip(&self.touches) {
            let place = &mut next[tile as usize];
            touches[*place as usize] = touch;
            *place += 1;
        }
        TouchesByTile { starts, touches }
    }
}

/// Returns whether a triangle's edges, as functions on the face, leave any of a tile.
fn touches_tile(frame: &LightFrame, on_face: &[Vec4; 3], tile: UVec2) -> bool {
    let side = 1.0 / frame.tiles_a_unit;
    let low = tile.as_vec2() * side - frame.half;
    let [across, down, summand] = on_face;
    let at_low = *summand + *across * low.x + *down * low.y;
    let greatest = at_low + (*across * side).max(Vec4::ZERO) + (*down * side).max(Vec4::ZERO);
    greatest.truncate().cmpge(Vec3::NEG_ONE).all()
}

/// The box around what shows of a triangle on a face, in units of a direction, and its least depth.
#[derive(Clone, Copy, Debug)]
struct FaceBounds {
    low: Vec2,
    high: Vec2,
    nearest: f32,
}

impl FaceBounds {
    /// Returns what shows of a triangle on a face of the cube around a lamp, and a little beyond its rim; none where nothing does.
    /// `corners` are relative to the lamp.
    fn on_cube(face: u32, corners: [Vec3; 3], margin: f32) -> Option<Self> {
        let axis = face as usize / 2;
        let sign = if face % 2 == 1 { -1.0 } else { 1.0 };
        // Across and down the face, and along its axis.
        let turned = corners.map(|c| Vec3::new(c[(axis + 1) % 3], c[(axis + 2) % 3], sign * c[axis]));
        let rim = 1.0 + 2.0 * margin;
        // The four sides of the pyramid that is seen through the face, a little widened: positive within.
        let sides: [fn(Vec3, f32) -> f32; 4] = [
            |v, rim| v.z * rim - v.x,
            |v, rim| v.z * rim + v.x,
            |v, rim| v.z * rim - v.y,
            |v, rim| v.z * rim + v.y,
        ];
        let mut is_whole = true;
        for side in sides {
            let inside = turned.map(|v| side(v, rim) >= 0.0);
            if inside == [false; 3] {
                return None;
            }
            is_whole &= inside == [true; 3];
        }
        if is_whole {
            return Self::around(&turned);
        }
        let mut polygon = turned.to_vec();
        for side in sides {
            polygon = clip(&polygon, |v| side(v, rim));
        }
        Self::around(&polygon)
    }

    /// Returns the bounds of points in front of the lamp; none of no points.
    fn around(points: &[Vec3]) -> Option<Self> {
        let mut out = Self {
            low: Vec2::INFINITY,
            high: Vec2::NEG_INFINITY,
            nearest: f32::INFINITY,
        };
        for v in points {
            let depth = v.z.max(1e-30);
            let at = v.truncate() / depth;
            out.low = out.low.min(at);
            out.high = out.high.max(at);
            out.nearest = out.nearest.min(v.z);
        }
        (!points.is_empty()).then_some(out)
    }
}

/// Returns the part of a convex polygon where a linear function is not negative (Sutherland, Hodgman 1974, "Reentrant Polygon
/// Clipping").
fn clip(polygon: &[Vec3], side: impl Fn(Vec3) -> f32) -> Vec<Vec3> {
    let mut out = Vec::new();
    for (i, &from) in polygon.iter().enumerate() {
        let to = polygon[(i + 1) % polygon.len()];
        let [start, end] = [side(from), side(to)];
        if start >= 0.0 {
            out.push(from);
        }
        if (start >= 0.0) != (end >= 0.0) {
            out.push(from.lerp(to, start / (start - end)));
        }
    }
    out
}

impl Outline {
    /// Returns the outline of a caster in a table of [`rows`](Self::rows).
    #[inline(always)]
    pub(super) fn of_caster(table: &[[u32; 4]], caster: u32) -> Self {
        let first = 3 * caster as usize;
        Self::from_rows(&table[first..first + 3])
    }
}
