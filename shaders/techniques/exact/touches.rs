//! Tiles of a frame's faces that each triangle touches.

use super::{
    light_frame::LightFrame,
    outline::{distance_to_origin, outline_of},
};
use umbrage_core::{
    Geometry,
    glam::{IVec2, UVec2, Vec2, Vec3, Vec4},
    math::{greater, lesser},
};

/// Number of box steps along a tile's side, as a power of two.
pub(super) const STEPS: u32 = 12;

/// Triangle in a tile.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Touch {
    /// Index in the list of triangles.
    pub(super) caster: u32,
    /// Least depth on this face, minus the margin.
    pub(super) nearest: f32,
    /// Bounding box clipped to the tile, in steps.
    pub(super) low: [u16; 2],
    /// Inclusive.
    pub(super) high: [u16; 2],
    /// Area of the whole triangle, in areas of a tile.
    pub(super) area: f32,
    /// True if the triangle is larger than a tile.
    pub(super) is_large: bool,
}

/// Touches of some triangles, by tile.
#[derive(Debug, Default)]
pub(super) struct TouchesByTile {
    /// Start of each tile's touches; one more at the end.
    starts: Vec<u32>,
    touches: Vec<Touch>,
}

impl TouchesByTile {
    /// Returns a tile's touches.
    pub(super) fn of_tile(&self, tile: usize) -> &[Touch] {
        &self.touches[self.starts[tile] as usize..self.starts[tile + 1] as usize]
    }

    /// Finds the tiles that some casters touch.
    pub(super) fn find(
        frame: &LightFrame,
        geometry: &Geometry,
        casters: std::ops::Range<u32>,
    ) -> Self {
        let mut found = Found {
            frame,
            geometry,
            tiles: Vec::with_capacity(casters.len()),
            touches: Vec::with_capacity(casters.len()),
        };
        for id in casters {
            let [a, b, c] = geometry.corners(id);
            if frame.is_lamp {
                let place = |p| frame.place_as::<true>(p);
                found.add_around_lamp(id, [place(a), place(b), place(c)]);
            } else {
                let place = |p| frame.place_as::<false>(p);
                found.add_under_sun(id, [place(a), place(b), place(c)]);
            }
        }
        found.by_tile()
    }
}

/// Touches in the order of discovery, and the tile of each.
struct Found<'a> {
    frame: &'a LightFrame,
    geometry: &'a Geometry,
    tiles: Vec<u32>,
    touches: Vec<Touch>,
}

impl Found<'_> {
    #[inline]
    fn add_under_sun(&mut self, caster: u32, corners: [Vec3; 3]) {
        let bounds = FaceBounds::under_sun(corners);
        self.add_on_face(caster, 0, &bounds, self.frame.margin(0.0));
    }

    fn add_around_lamp(&mut self, caster: u32, corners: [Vec3; 3]) {
        let distance = distance_to_origin(corners);
        let margin = self.frame.margin(distance);
        let is_anywhere = self.frame.is_at_lamp(distance);
        for face in 0..6 {
            if is_anywhere {
                self.add_on_face(caster, face, &FaceBounds::ANYWHERE, 0.0);
            } else if let Some(bounds) = FaceBounds::on_cube(face, corners, margin) {
                self.add_on_face(caster, face, &bounds, margin);
            }
        }
    }

    #[inline]
    fn add_on_face(&mut self, caster: u32, face: u32, bounds: &FaceBounds, margin: f32) {
        let frame = self.frame;
        let steps_a_unit = frame.tiles_a_unit * (1 << STEPS) as f32;
        let end = (frame.tiles << STEPS).as_ivec2();
        // Round down from -1 on, and to a negative number below.
        let to_step = |at: Vec2| {
            let steps = (at + frame.half) * steps_a_unit;
            (steps.max(Vec2::splat(-1e6)) + 1.0).as_ivec2() - 1
        };
        let low = to_step(bounds.low - margin);
        let high = to_step(bounds.high + margin);
        // Parts outside a point light's face are on another face.
        if high.cmplt(IVec2::ZERO).any() || low.cmpge(end).any() {
            return;
        }
        // Clip the box to the face.
        let low = low.max(IVec2::ZERO).as_uvec2();
        let high = high.min(end - 1).as_uvec2();
        let [first, last] = [low >> STEPS, high >> STEPS];
        let first_tile = face * frame.tiles.x * frame.tiles.y;
        let mut touch = Touch {
            caster,
            nearest: frame.depth_before(bounds.nearest),
            low: [0; 2],
            high: [0; 2],
            area: bounds.area * frame.tiles_a_unit * frame.tiles_a_unit,
            is_large: (high - low).max_element() > 1 << STEPS,
        };
        // Use the outline of large triangles.
        let has_edges = touch.is_large && !bounds.is_anywhere;
        let mut on_face = [Vec4::ZERO; 3];
        if has_edges {
            let traits = outline_of(frame, self.geometry, caster);
            on_face = traits.outline.on_face(frame.is_lamp, face);
        }
        // Add a touch for each tile.
        for y in first.y..=last.y {
            for x in first.x..=last.x {
                let tile = UVec2::new(x, y);
                if has_edges && !touches_tile(frame, &on_face, tile) {
                    continue;
                }
                let tile_low = tile << STEPS;
                let tile_high = tile_low + ((1 << STEPS) - 1);
                touch.low = (low.max(tile_low) - tile_low).to_array().map(|v| v as u16);
                touch.high = (high.min(tile_high) - tile_low)
                    .to_array()
                    .map(|v| v as u16);
                self.tiles.push(first_tile + y * frame.tiles.x + x);
                self.touches.push(touch);
            }
        }
    }

    /// Sorts by tile, keeping the order within a tile.
    fn by_tile(self) -> TouchesByTile {
        let mut starts = vec![0; self.frame.tile_count() + 1];
        for &tile in &self.tiles {
            starts[tile as usize + 1] += 1;
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        let mut next = starts.clone();
        let mut touches = vec![Touch::default(); self.touches.len()];
        for (&tile, &touch) in self.tiles.iter().zip(&self.touches) {
            let place = &mut next[tile as usize];
            touches[*place as usize] = touch;
            *place += 1;
        }
        TouchesByTile { starts, touches }
    }
}

/// Returns whether a triangle's edges, as functions on the face, leave any part of a tile inside.
fn touches_tile(frame: &LightFrame, on_face: &[Vec4; 3], tile: UVec2) -> bool {
    let side = 1.0 / frame.tiles_a_unit;
    let low = tile.as_vec2() * side - frame.half;
    let [across, down, summand] = on_face;
    let at_low = *summand + *across * low.x + *down * low.y;
    let greatest = at_low + (*across * side).max(Vec4::ZERO) + (*down * side).max(Vec4::ZERO);
    greatest.truncate().cmpge(Vec3::NEG_ONE).all()
}

/// Bounds of a triangle's projection to a face, in units of a direction, and its least depth.
#[derive(Clone, Copy, Debug)]
pub(super) struct FaceBounds {
    pub(super) low: Vec2,
    pub(super) high: Vec2,
    pub(super) nearest: f32,
    area: f32,
    /// Set for a triangle so near to a point light that its edges are meaningless.
    pub(super) is_anywhere: bool,
}

impl FaceBounds {
    /// Bounds of a triangle at a point light, which may be anywhere.
    pub(super) const ANYWHERE: Self = Self {
        low: Vec2::NEG_ONE,
        high: Vec2::ONE,
        nearest: 0.0,
        area: 4.0,
        is_anywhere: true,
    };

    /// Returns the projection of a triangle for a directional light.
    #[inline(always)]
    pub(super) fn under_sun(corners: [Vec3; 3]) -> Self {
        let [a, b, c] = corners;
        let least = |axis: usize| lesser(a[axis], lesser(b[axis], c[axis]));
        let greatest = |axis: usize| greater(a[axis], greater(b[axis], c[axis]));
        let low = Vec3::new(least(0), least(1), least(2));
        Self {
            low: low.truncate(),
            high: Vec2::new(greatest(0), greatest(1)),
            nearest: low.z,
            area: 0.5 * (b - a).truncate().perp_dot((c - a).truncate()).abs(),
            is_anywhere: false,
        }
    }

    /// Returns the projection of a triangle to a face of the cube around a point light, and
    /// slightly beyond its edge. Returns `None` if it is empty. `corners` are relative to the
    /// light.
    pub(super) fn on_cube(face: u32, corners: [Vec3; 3], margin: f32) -> Option<Self> {
        let axis = face as usize / 2;
        let sign = if face % 2 == 1 { -1.0 } else { 1.0 };
        // Rotate to coordinates across, down and along the face's axis.
        let turned =
            corners.map(|c| Vec3::new(c[(axis + 1) % 3], c[(axis + 2) % 3], sign * c[axis]));
        let rim = 1.0 + 2.0 * margin;
        // Widen the four sides of the face's pyramid slightly; they are positive within.
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
            return Self::around_points(&turned);
        }
        let mut polygon = turned.to_vec();
        for side in sides {
            polygon = clip(&polygon, |v| side(v, rim));
        }
        Self::around_points(&polygon)
    }

    /// Returns the bounds of points in front of the point light; `None` without points.
    fn around_points(points: &[Vec3]) -> Option<Self> {
        let mut out = Self {
            low: Vec2::INFINITY,
            high: Vec2::NEG_INFINITY,
            nearest: f32::INFINITY,
            area: 0.0,
            is_anywhere: false,
        };
        let place = |v: &Vec3| v.truncate() / v.z.max(1e-30);
        let first = points.first().map_or(Vec2::ZERO, place);
        let mut last = first;
        for v in points {
            let at = place(v);
            // Sum the areas of a fan around the first corner.
            out.area += 0.5 * (last - first).perp_dot(at - first).abs();
            last = at;
            out.low = out.low.min(at);
            out.high = out.high.max(at);
            out.nearest = out.nearest.min(v.z);
        }
        (!points.is_empty()).then_some(out)
    }
}

/// Clips a convex polygon to where a linear function is not negative (Sutherland, Hodgman 1974,
/// "Reentrant Polygon Clipping").
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
