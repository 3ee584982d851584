//! Triangle setup for many triangles at once, as simple loops over arrays that the compiler
//! vectorises.

use crate::raster::{
    Rounding,
    bin::Bins,
    mode::Mode,
    plane_error::{PlaneShift, plane_error},
    record::{DepthPlane, Record, doubled_area, small_edge_function},
    viewport::{on_grid, snap},
    whole::Whole,
};
use glam::{UVec2, Vec3};
use umbrage_core::{Cull, DepthPlanes, RasterBias, Snapping};

/// Triangles per group: as many as bits in a word.
pub(crate) const GROUP: usize = 64;

type Floats = [f32; GROUP];
type Ints = [i32; GROUP];

/// Parameters of a draw for setup.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SetupRules {
    /// Image size, pixels.
    pub(crate) size: UVec2,
    /// Faces to cull.
    pub(crate) cull: Cull,
    /// Polygon offset.
    pub(crate) bias: RasterBias,
    /// Test and update of the image.
    pub(crate) mode: Mode,
    /// Rounding of vertices and depths.
    pub(crate) rounding: Rounding,
}

impl SetupRules {
    /// Returns the polygon offset as defined by Vulkan: `m * slope + r * constant`. m is the
    /// greater slope of a triangle (depth per pixel). r is the spacing of the image's depths; for
    /// floats, it is that at the triangle's greatest depth.
    #[inline(always)]
    fn offset(&self, greatest_depth: f32, slope: f32) -> f32 {
        let unit = if self.mode.is_fixed_point() {
            self.rounding.snapping.offset_unit.depth()
        } else {
            spacing(greatest_depth)
        };
        let offset = unit * self.bias.constant as f32 + slope * self.bias.slope;
        clamp_offset(offset, self.bias.clamp)
    }
}

/// Window-space triangles that wait for setup, one array per number.
#[derive(Clone, Debug)]
pub(crate) struct Group {
    x: [Floats; 3],
    y: [Floats; 3],
    z: [Floats; 3],
    id: [u32; GROUP],
    len: usize,
    lanes: Lanes,
}

/// Results of setup: the sign of the area (0 if not drawn), snapped corners, pixel bounds and depth
/// planes.
#[derive(Clone, Debug)]
struct Lanes {
    sign: Ints,
    x: [Ints; 3],
    y: [Ints; 3],
    min_x: Ints,
    min_y: Ints,
    max_x: Ints,
    max_y: Ints,
    at_origin: Floats,
    dx: Floats,
    dy: Floats,
    offset: Floats,
    at_min: [Ints; 3],
    edge_x: [Ints; 2],
    edge_y: [Ints; 2],
}

impl Lanes {
    const ZERO: Self = Self {
        sign: [0; GROUP],
        x: [[0; GROUP]; 3],
        y: [[0; GROUP]; 3],
        min_x: [0; GROUP],
        min_y: [0; GROUP],
        max_x: [0; GROUP],
        max_y: [0; GROUP],
        at_origin: [0.0; GROUP],
        dx: [0.0; GROUP],
        dy: [0.0; GROUP],
        offset: [0.0; GROUP],
        at_min: [[0; GROUP]; 3],
        edge_x: [[0; GROUP]; 2],
        edge_y: [[0; GROUP]; 2],
    };
}

impl Group {
    /// Returns an empty group.
    pub(crate) fn new() -> Self {
        let zero = [[0.0; GROUP]; 3];
        Self {
            x: zero,
            y: zero,
            z: zero,
            id: [0; GROUP],
            len: 0,
            lanes: Lanes::ZERO,
        }
    }

    /// Adds a triangle, and sets the group up when it is full.
    #[inline(always)]
    pub(crate) fn push(&mut self, corners: [Vec3; 3], id: u32, rules: &SetupRules, out: &mut Bins) {
        // The length is always below GROUP here; the remainder avoids the bounds checks.
        let i = self.len % GROUP;
        let [a, b, c] = corners;
        (self.x[0][i], self.x[1][i], self.x[2][i]) = (a.x, b.x, c.x);
        (self.y[0][i], self.y[1][i], self.y[2][i]) = (a.y, b.y, c.y);
        (self.z[0][i], self.z[1][i], self.z[2][i]) = (a.z, b.z, c.z);
        self.id[i] = id;
        self.len = i + 1;
        if self.len == GROUP {
            self.flush(rules, out);
        }
    }

    /// Sets up the pending triangles and appends a record for each that may cover a pixel.
    #[inline(always)]
    pub(crate) fn flush(&mut self, rules: &SetupRules, out: &mut Bins) {
        self.set_up(rules);
        self.emit(rules, out);
    }

    /// Sets up pieces of one triangle with a known plane, and appends their records.
    #[cold]
    pub(crate) fn flush_pieces(&mut self, whole: &Whole, rules: &SetupRules, out: &mut Bins) {
        // Without an area, the triangle has no facing.
        let cull = if whole.has_area() {
            rules.cull
        } else {
            Cull::None
        };
        self.set_up(&SetupRules { cull, ..*rules });
        let plane = whole.depth();
        let slope = plane.dx.abs().max(plane.dy.abs());
        let offset = rules.offset(whole.greatest_depth(), slope);
        let shift = rules.rounding.plane_shift.for_triangle(self.id[0]) * whole.error();
        let l = &mut self.lanes;
        l.at_origin = [plane.at_origin; GROUP];
        l.dx = [plane.dx; GROUP];
        l.dy = [plane.dy; GROUP];
        l.offset = [offset + shift; GROUP];
        self.emit(rules, out);
    }

    #[inline(always)]
    fn set_up(&mut self, rules: &SetupRules) {
        if rules.rounding.snapping == Snapping::default() {
            self.snap_and_bound(rules.size);
        } else {
            self.snap_otherwise(rules);
        }
        self.find_signs(rules.cull);
        self.find_edges();
        self.drop_uncovered();
        self.find_planes();
        self.lanes.offset = [0.0; GROUP];
        if rules.bias.constant != 0 || rules.bias.slope != 0.0 {
            self.find_offsets(rules);
        }
        if rules.rounding.plane_shift != PlaneShift::NONE {
            self.shift_planes(rules.rounding.plane_shift);
        }
    }

    /// Shifts depths by parts of the rounding bound.
    #[cold]
    fn shift_planes(&mut self, shift: PlaneShift) {
        for i in 0..self.len {
            let corners = [0, 1, 2].map(|k| {
                let corner = Vec3::new(self.x[k][i], self.y[k][i], self.z[k][i]);
                corner.as_dvec3()
            });
            self.lanes.offset[i] += shift.for_triangle(self.id[i]) * plane_error(corners);
        }
    }

    #[inline(always)]
    fn emit(&mut self, rules: &SetupRules, out: &mut Bins) {
        let mut drawn = self.drawn_bits();
        while drawn != 0 {
            out.push(self.record(drawn.trailing_zeros() as usize, rules.mode));
            drawn &= drawn - 1;
        }
        self.len = 0;
    }

    /// Returns a bit for each triangle that must be drawn.
    #[inline(always)]
    fn drawn_bits(&self) -> u64 {
        let mut bits = 0;
        for i in 0..GROUP {
            bits |= u64::from(self.lanes.sign[i] != 0) << i;
        }
        // Mask the unused slots of a partial group.
        if self.len == GROUP {
            bits
        } else {
            bits & ((1 << self.len) - 1)
        }
    }

    /// Snaps the corners and computes the pixel bounds. A triangle covers pixels from its least
    /// coordinate, rounded up, to just below its greatest. Pixels on the right or bottom edge
    /// belong to its neighbour.
    #[inline(always)]
    fn snap_and_bound(&mut self, size: UVec2) {
        let last_x = size.x as i32 - 1;
        let last_y = size.y as i32 - 1;
        let l = &mut self.lanes;
        for i in 0..GROUP {
            let x = [snap(self.x[0][i]), snap(self.x[1][i]), snap(self.x[2][i])];
            let y = [snap(self.y[0][i]), snap(self.y[1][i]), snap(self.y[2][i])];
            l.min_x[i] = ((x[0].min(x[1]).min(x[2]) + 255) >> 8).max(0);
            l.min_y[i] = ((y[0].min(y[1]).min(y[2]) + 255) >> 8).max(0);
            l.max_x[i] = ((x[0].max(x[1]).max(x[2]) - 1) >> 8).min(last_x);
            l.max_y[i] = ((y[0].max(y[1]).max(y[2]) - 1) >> 8).min(last_y);
            (l.x[0][i], l.x[1][i], l.x[2][i]) = (x[0], x[1], x[2]);
            (l.y[0][i], l.y[1][i], l.y[2][i]) = (y[0], y[1], y[2]);
        }
    }

    /// Snaps to another grid, whose points are all on the finest. Leaves the corners for later
    /// steps that compute planes.
    #[cold]
    fn snap_otherwise(&mut self, rules: &SetupRules) {
        let unsnapped = (self.x, self.y);
        for v in self
            .x
            .as_flattened_mut()
            .iter_mut()
            .chain(self.y.as_flattened_mut())
        {
            *v = on_grid(*v, rules.rounding.snapping);
        }
        self.snap_and_bound(rules.size);
        if rules.rounding.snapping.planes == DepthPlanes::Unsnapped {
            (self.x, self.y) = unsnapped;
        }
    }

    #[inline(always)]
    fn find_signs(&mut self, cull: Cull) {
        let keep_front = i32::from(cull != Cull::Front);
        let keep_back = i32::from(cull != Cull::Back);
        let l = &mut self.lanes;
        for i in 0..GROUP {
            let area = doubled_area(
                [l.x[0][i], l.x[1][i], l.x[2][i]],
                [l.y[0][i], l.y[1][i], l.y[2][i]],
            );
            let sign = i32::from(area > 0) * keep_front - i32::from(area < 0) * keep_back;
            let bounded = l.min_x[i] <= l.max_x[i] && l.min_y[i] <= l.max_y[i];
            l.sign[i] = sign * i32::from(bounded);
        }
    }

    /// Returns the differences v0 - v1 and v2 - v0 of a coordinate, in counter-clockwise order.
    #[inline(always)]
    fn differences(v: &[Floats; 3], sign: i32, i: usize) -> (f32, f32) {
        let [a, b, c] = [v[0][i], v[1][i], v[2][i]];
        if sign < 0 {
            (a - c, b - a)
        } else {
            (a - b, c - a)
        }
    }

    /// Computes the plane through the corners before snapping, or as `snap_otherwise` left them.
    #[inline(always)]
    fn find_planes(&mut self) {
        let l = &mut self.lanes;
        for i in 0..GROUP {
            let (x01, x20) = Self::differences(&self.x, l.sign[i], i);
            let (y01, y20) = Self::differences(&self.y, l.sign[i], i);
            let (z01, z20) = Self::differences(&self.z, l.sign[i], i);
            let r = 1.0 / (x01 * y20 - y01 * x20);
            let dx = z01 * (y20 * r) - z20 * (y01 * r);
            let dy = z20 * (x01 * r) - z01 * (x20 * r);
            l.at_origin[i] = self.z[0][i] - (dx * (self.x[0][i] - 0.5) + dy * (self.y[0][i] - 0.5));
            l.dx[i] = dx;
            l.dy[i] = dy;
        }
    }

    #[inline(always)]
    fn find_offsets(&mut self, rules: &SetupRules) {
        let l = &mut self.lanes;
        for i in 0..GROUP {
            let (x01, x20) = Self::differences(&self.x, l.sign[i], i);
            let (y01, y20) = Self::differences(&self.y, l.sign[i], i);
            let (z01, z20) = Self::differences(&self.z, l.sign[i], i);
            let r = 1.0 / (x01 * y20 - y01 * x20);
            let slope_x = ((z20 * y01 - y20 * z01) * r).abs();
            let slope_y = ((x20 * z01 - z20 * x01) * r).abs();
            let greatest = self.z[0][i]
                .abs()
                .max(self.z[1][i].abs())
                .max(self.z[2][i].abs());
            l.offset[i] = rules.offset(greatest, slope_x.max(slope_y));
        }
    }

    /// Computes the edges, clockwise on screen: the order in which their functions are positive
    /// inside.
    #[inline(always)]
    fn find_edges(&mut self) {
        let l = &mut self.lanes;
        for i in 0..GROUP {
            let flip = l.sign[i] > 0;
            // Order the corners p, q and r clockwise: swap the last two if they are
            // counter-clockwise.
            let [px, x1, x2] = [l.x[0][i], l.x[1][i], l.x[2][i]];
            let [py, y1, y2] = [l.y[0][i], l.y[1][i], l.y[2][i]];
            let (qx, rx) = if flip { (x2, x1) } else { (x1, x2) };
            let (qy, ry) = if flip { (y2, y1) } else { (y1, y2) };
            let edge_a = [qx - px, qy - py];
            let edge_b = [rx - qx, ry - qy];
            let edge_c = [px - rx, py - ry];
            let first_pixel = [l.min_x[i] << 8, l.min_y[i] << 8];
            l.at_min[0][i] = small_edge_function([px, py], edge_a, first_pixel);
            l.at_min[1][i] = small_edge_function([qx, qy], edge_b, first_pixel);
            l.at_min[2][i] = small_edge_function([rx, ry], edge_c, first_pixel);
            l.edge_x[0][i] = edge_a[0];
            l.edge_y[0][i] = edge_a[1];
            l.edge_x[1][i] = edge_b[0];
            l.edge_y[1][i] = edge_b[1];
        }
    }

    /// Drops triangles up to two pixels wide and high that cover no pixel, which are frequent in
    /// fine meshes.
    #[inline(always)]
    fn drop_uncovered(&mut self) {
        let l = &mut self.lanes;
        for i in 0..GROUP {
            let ax = l.edge_x[0][i];
            let ay = l.edge_y[0][i];
            let bx = l.edge_x[1][i];
            let by = l.edge_y[1][i];
            let [a, b, c] = [l.at_min[0][i], l.at_min[1][i], l.at_min[2][i]];
            // The sign bit is set outside an edge, at this many pixels to the right and down.
            let outside = |right: i32, down: i32| {
                let a = a.wrapping_sub(ay * right).wrapping_add(ax * down);
                let b = b.wrapping_sub(by * right).wrapping_add(bx * down);
                let c = c
                    .wrapping_add((ay + by) * right)
                    .wrapping_sub((ax + bx) * down);
                a | b | c
            };
            let covers_none = outside(0, 0) & outside(1, 0) & outside(0, 1) & outside(1, 1) < 0;
            let is_small = (l.max_x[i] - l.min_x[i] < 2) & (l.max_y[i] - l.min_y[i] < 2);
            l.sign[i] = if covers_none & is_small { 0 } else { l.sign[i] };
        }
    }

    #[inline(always)]
    fn record(&self, i: usize, mode: Mode) -> Record {
        let l = &self.lanes;
        // Front faces are counter-clockwise, so their sign is 1 and their change is -1.
        let count_change = l.sign[i].wrapping_neg() as u32;
        Record {
            corner: [l.x[0][i], l.y[0][i]],
            edge_a: [l.edge_x[0][i], l.edge_y[0][i]],
            edge_b: [l.edge_x[1][i], l.edge_y[1][i]],
            at_min: [l.at_min[0][i], l.at_min[1][i], l.at_min[2][i]],
            plane: DepthPlane {
                at_origin: l.at_origin[i],
                dx: l.dx[i],
                dy: l.dy[i],
                offset: l.offset[i],
            },
            min: [l.min_x[i] as u16, l.min_y[i] as u16],
            max: [l.max_x[i] as u16, l.max_y[i] as u16],
            tag: if mode == Mode::StencilDepthFail {
                count_change
            } else {
                self.id[i]
            },
        }
    }
}

/// Returns the spacing of floats of `z`'s magnitude (greater than zero), or 0 if it would be
/// denormal.
#[inline(always)]
fn spacing(z: f32) -> f32 {
    let exponent = (z.to_bits() & 0x7f80_0000) as i32;
    f32::from_bits((exponent - (23 << 23)).max(0) as u32)
}

#[inline(always)]
fn clamp_offset(offset: f32, clamp: f32) -> f32 {
    if clamp > 0.0 {
        offset.min(clamp)
    } else if clamp < 0.0 {
        offset.max(clamp)
    } else {
        offset
    }
}
