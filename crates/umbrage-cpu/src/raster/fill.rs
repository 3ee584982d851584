//! Filling of a triangle's pixels within a tile, several pixels of a row at a time.

use crate::raster::{
    bin::TILE,
    holes::HoleTest,
    mode::{DepthOp, TileAttachments},
    record::{Record, edge_function},
    tile::{LANES, STRIDE, TINY_ROWS, TileBuffer},
};

/// Indices of the lanes.
const LANE: [i32; LANES] = [0, 1, 2, 3, 4, 5, 6, 7];
const LANE_F: [f32; LANES] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];

/// Greatest width and height of triangles that are filled without skipping blocks that are entirely
/// inside or outside.
const SMALL: i32 = 16;

/// Pixels that a triangle may cover in a tile, with its edge functions there.
#[derive(Clone, Copy, Debug)]
struct Patch {
    /// Least x and y, pixels of the image.
    min: [i32; 2],
    /// Greatest x and y.
    max: [i32; 2],
    /// Edge functions at `min`.
    at_min: [i32; 3],
    /// Change of the edge functions per pixel to the right.
    dx: [i32; 3],
    /// Change of the edge functions per pixel down.
    dy: [i32; 3],
}

/// Buffer of a tile with its position.
pub(crate) struct Canvas<'a> {
    /// Buffer to draw into.
    pub(crate) buffer: &'a mut TileBuffer,
    /// First pixel of the tile.
    pub(crate) origin: [i32; 2],
}

/// Draws a triangle into a tile.
#[inline(always)]
pub(crate) fn fill<P: DepthOp, C: HoleTest>(canvas: &mut Canvas<'_>, r: &Record, holes: &C) {
    // Measure from the first pixel to the last: 0 for a single one.
    let width = i32::from(r.max[0] - r.min[0]);
    let height = i32::from(r.max[1] - r.min[1]);
    let patch = Patch::new(r, canvas.origin);
    if width < LANES as i32 && height < TINY_ROWS {
        // Use a fixed number of rows, since the branch predictor can't guess the actual one. Rows
        // below the triangle are outside its edges.
        let right = patch.min[0] - i32::from(r.min[0]);
        let down = patch.min[1] - i32::from(r.min[1]);
        let edges = Edges::new(r.at_min, &patch, right, down);
        fill_strip::<P, C, true>(canvas, r, holes, edges, patch.min, TINY_ROWS);
    } else if width < SMALL && height < SMALL {
        fill_small::<P, C>(canvas, r, holes, &patch);
    } else if let Some(patch) = patch.with_edges(r) {
        fill_blocks::<P, C>(canvas, r, holes, &patch);
    }
}

/// Fills a small triangle a few columns at a time.
#[inline(always)]
fn fill_small<P: DepthOp, C: HoleTest>(
    canvas: &mut Canvas<'_>,
    r: &Record,
    holes: &C,
    patch: &Patch,
) {
    let down = patch.min[1] - i32::from(r.min[1]);
    let rows = patch.max[1] - patch.min[1] + 1;
    let mut x = patch.min[0];
    while x <= patch.max[0] {
        let right = x - i32::from(r.min[0]);
        let edges = Edges::new(r.at_min, patch, right, down);
        fill_strip::<P, C, true>(canvas, r, holes, edges, [x, patch.min[1]], rows);
        x += LANES as i32;
    }
}

impl Patch {
    /// Returns the part of a triangle's bounds in the tile.
    #[inline(always)]
    fn new(r: &Record, origin: [i32; 2]) -> Self {
        let last = TILE as i32 - 1;
        // An edge along (x, y) has the function `x down - y right`. The three edges add up to zero,
        // and so do the changes.
        let ax = -r.edge_a[1];
        let ay = r.edge_a[0];
        let bx = -r.edge_b[1];
        let by = r.edge_b[0];
        Self {
            min: [
                i32::from(r.min[0]).max(origin[0]),
                i32::from(r.min[1]).max(origin[1]),
            ],
            max: [
                i32::from(r.max[0]).min(origin[0] + last),
                i32::from(r.max[1]).min(origin[1] + last),
            ],
            at_min: [0; 3],
            dx: [ax, bx, -(ax + bx)],
            dy: [ay, by, -(ay + by)],
        }
    }

    /// Returns the patch with the edge functions of any triangle, or `None` if it covers nothing
    /// here.
    #[inline(always)]
    fn with_edges(mut self, r: &Record) -> Option<Self> {
        let pixel = [self.min[0] << 8, self.min[1] << 8];
        let second = [r.corner[0] + r.edge_a[0], r.corner[1] + r.edge_a[1]];
        let third = [second[0] + r.edge_b[0], second[1] + r.edge_b[1]];
        let edge_c = [r.corner[0] - third[0], r.corner[1] - third[1]];
        let starts = [(r.corner, r.edge_a), (second, r.edge_b), (third, edge_c)];
        // Include pixels right of the patch, which lanes may evaluate.
        let width = i64::from(self.max[0] - self.min[0]) + LANES as i64 - 1;
        let height = i64::from(self.max[1] - self.min[1]);
        for (k, &(corner, edge)) in starts.iter().enumerate() {
            let value = edge_function(corner, edge, pixel);
            // Compute the change of the function over the patch's width and height.
            let right = i64::from(self.dx[k]) * width;
            let down = i64::from(self.dy[k]) * height;
            if value + right.max(0) + down.max(0) < 0 {
                return None;
            }
            if value + right.min(0) + down.min(0) >= 0 {
                // The whole patch is inside this edge, so the edge is dropped. The others pass
                // through the patch, so that their values fit 32 bits.
                self.at_min[k] = 0;
                self.dx[k] = 0;
                self.dy[k] = 0;
            } else {
                self.at_min[k] = value as i32;
            }
        }
        Some(self)
    }

    /// Returns the edge functions at a pixel.
    #[inline(always)]
    fn edges_at(&self, x: i32, y: i32) -> [i32; 3] {
        let right = x - self.min[0];
        let down = y - self.min[1];
        let mut values = [0; 3];
        for (k, value) in values.iter_mut().enumerate() {
            *value = self.at_min[k] + self.dx[k] * right + self.dy[k] * down;
        }
        values
    }

    /// Returns the greatest fall and rise of the edge functions over a block of `LANES` by `LANES`
    /// pixels.
    #[inline(always)]
    fn reach(&self) -> ([i32; 3], [i32; 3]) {
        let last = LANES as i32 - 1;
        let mut fall = [0; 3];
        let mut rise = [0; 3];
        for k in 0..3 {
            fall[k] = last * (self.dx[k].min(0) + self.dy[k].min(0));
            rise[k] = last * (self.dx[k].max(0) + self.dy[k].max(0));
        }
        (fall, rise)
    }
}

/// Fills a patch block by block. Skips blocks outside an edge, and tests no pixels in blocks inside
/// all edges.
#[inline(always)]
fn fill_blocks<P: DepthOp, C: HoleTest>(
    canvas: &mut Canvas<'_>,
    r: &Record,
    holes: &C,
    patch: &Patch,
) {
    let (fall, rise) = patch.reach();
    let mut y = patch.min[1];
    while y <= patch.max[1] {
        let rows = (patch.max[1] - y + 1).min(LANES as i32);
        let mut x = patch.min[0];
        while x <= patch.max[0] {
            let at = patch.edges_at(x, y);
            // The sign bit of a bitwise or is set if any of the numbers is negative.
            let outside = (at[0] + rise[0]) | (at[1] + rise[1]) | (at[2] + rise[2]);
            let inside = (at[0] + fall[0]) | (at[1] + fall[1]) | (at[2] + fall[2]);
            if inside >= 0 {
                fill_strip::<P, C, false>(canvas, r, holes, Edges::NONE, [x, y], rows);
            } else if outside >= 0 {
                let edges = Edges::new(at, patch, 0, 0);
                fill_strip::<P, C, true>(canvas, r, holes, edges, [x, y], rows);
            }
            x += LANES as i32;
        }
        y += LANES as i32;
    }
}

/// Edge functions in the lanes of one row, with their change per row down.
#[derive(Clone, Copy)]
struct Edges {
    values: [[i32; LANES]; 3],
    dy: [i32; 3],
}

impl Edges {
    const NONE: Self = Self {
        values: [[0; LANES]; 3],
        dy: [0; 3],
    };

    /// Returns the edge functions at `right` pixels right of and `down` pixels below a pixel with
    /// the values `start`.
    #[inline(always)]
    fn new(start: [i32; 3], patch: &Patch, right: i32, down: i32) -> Self {
        let mut values = [[0; LANES]; 3];
        for k in 0..3 {
            for i in 0..LANES {
                let change_right = patch.dx[k].wrapping_mul(LANE[i] + right);
                let change_down = patch.dy[k].wrapping_mul(down);
                values[k][i] = start[k]
                    .wrapping_add(change_right)
                    .wrapping_add(change_down);
            }
        }
        Self {
            values,
            dy: patch.dy,
        }
    }

    /// Returns a number per lane that is negative outside the triangle.
    #[inline(always)]
    fn outside_lanes(&self) -> [i32; LANES] {
        let [a, b, c] = &self.values;
        let mut out = [0; LANES];
        for (i, out) in out.iter_mut().enumerate() {
            *out = a[i] | b[i] | c[i];
        }
        out
    }

    #[inline(always)]
    fn step_down(&mut self) {
        for k in 0..3 {
            for i in 0..LANES {
                self.values[k][i] = self.values[k][i].wrapping_add(self.dy[k]);
            }
        }
    }
}

/// Fills `rows` rows of `LANES` pixels from pixel `first` on; with `TEST`, only the pixels inside
/// the edges.
#[inline(always)]
fn fill_strip<P: DepthOp, C: HoleTest, const TEST: bool>(
    canvas: &mut Canvas<'_>,
    r: &Record,
    holes: &C,
    mut edges: Edges,
    first: [i32; 2],
    rows: i32,
) {
    let start =
        (first[1] - canvas.origin[1]) as usize * STRIDE + (first[0] - canvas.origin[0]) as usize;
    let px = first[0] as f32;
    let mut py = first[1] as f32;
    // Evaluate the depth plane for the columns.
    let mut column = [0.0_f32; LANES];
    for i in 0..LANES {
        column[i] = r.plane.dx.mul_add(px + LANE_F[i], r.plane.at_origin);
    }
    let TileBuffer { texels, ids, other } = &mut *canvas.buffer;
    let mut ids = if P::MODE.has_ids() {
        &mut ids[start..]
    } else {
        &mut []
    };
    let mut other = if P::MODE.reads_other_image() {
        &other[start..]
    } else {
        &[]
    };
    let mut y = first[1];
    // Draw row by row.
    for row in texels[start..].chunks_exact_mut(STRIDE).take(rows as usize) {
        let Some(stored) = row.first_chunk_mut::<LANES>() else {
            return;
        };
        let outside = if TEST {
            edges.outside_lanes()
        } else {
            [0; LANES]
        };
        let mut z = [0.0; LANES];
        for i in 0..LANES {
            let drawn = unit_clamp(r.plane.dy.mul_add(py, column[i]) + r.plane.offset);
            z[i] = if outside[i] >= 0 { drawn } else { 1.0 };
        }
        if C::HAS_HOLES {
            holes.take_holes(r.tag, [first[0], y], &mut z, stored);
            y += 1;
        }
        P::write(stored, TileAttachments { ids, other }, &z, &outside, r.tag);
        if P::MODE.has_ids() {
            ids = ids.get_mut(STRIDE..).unwrap_or_default();
        }
        if P::MODE.reads_other_image() {
            other = other.get(STRIDE..).unwrap_or_default();
        }
        if TEST {
            edges.step_down();
        }
        py += 1.0;
    }
}

/// Clamps to 0..=1. NaN becomes 1, which is never closer than the stored depth.
#[inline(always)]
fn unit_clamp(z: f32) -> f32 {
    let z = if z < 1.0 { z } else { 1.0 };
    if z > 0.0 { z } else { 0.0 }
}
