//! A triangle's outline as seen from the light: three edges and a plane, as functions that are above 1 where a ray surely
//! meets the triangle, below -1 where it surely misses it, and between where only the triangle test of rays may tell.
//!
//! Edge functions in homogeneous form (Olano and Greer 1997, "Triangle Scan Conversion using 2D Homogeneous Coordinates"): linear in
//! a direction, whatever face of a cube it falls on, and right for triangles that reach behind the light. With h the corners' directions,
//! the edge opposite to corner a is `h_b x h_c`; the plane is the combination of the three edges that has the corners'
//! depths (for lamps: one over them, which is linear where depth isn't).

use super::light_frame::LightFrame;
use umbrage_core::{
    Geometry, Simd, SimdTask,
    glam::{DVec3, Vec3, Vec4},
};

/// The factors of a direction's coordinates: `x q.x + y q.y + z q.z`, lane by lane: three edges, then the plane. The plane is multiplied by
/// a lamp's depth, and one margin is subtracted from it; a sun's depth is added to it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Outline {
    pub(super) x: Vec4,
    pub(super) y: Vec4,
    pub(super) z: Vec4,
}

/// An outline, and whether it knows its depth.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Traits {
    pub(super) outline: Outline,
    /// Whether the plane says where the triangle lies in depth; else, as where it is steep or thin, only the triangle test does.
    pub(super) knows_depth: bool,
}

impl Outline {
    /// Returns the rows of a shader's table.
    #[inline(always)]
    pub(super) fn rows(&self) -> [[u32; 4]; 3] {
        [self.x, self.y, self.z].map(|v| v.to_array().map(f32::to_bits))
    }

    /// Returns the outline that [`rows`](Self::rows) made rows of.
    #[inline(always)]
    pub(super) fn from_rows(rows: &[[u32; 4]]) -> Self {
        let vector = |row: &[u32; 4]| Vec4::from_array(row.map(f32::from_bits));
        Self {
            x: vector(&rows[0]),
            y: vector(&rows[1]),
            z: vector(&rows[2]),
        }
    }

    /// Returns an outline of a table of [`rows`](Self::rows).
    #[inline(always)]
    pub(super) fn at(table: &[[u32; 4]], number: u32) -> Self {
        let first = 3 * number as usize;
        Self::from_rows(&table[first..first + 3])
    }

    /// Returns the same functions on a face of the cube around a lamp: factors of the coordinate across, of that down, and a summand.
    #[inline(always)]
    pub(super) fn on_face(&self, is_lamp: bool, face: u32) -> [Vec4; 3] {
        let axes = [self.x, self.y, self.z];
        if !is_lamp {
            return axes;
        }
        let axis = face as usize / 2;
        let along = if face % 2 == 1 { -axes[axis] } else { axes[axis] };
        [axes[(axis + 1) % 3], axes[(axis + 2) % 3], along]
    }
}

/// How thin a triangle may be, its area's double over its longest edge's square, for 32 bits to know its plane.
const THINNEST: f32 = 1.0 / 4096.0;

/// Returns the outline of a triangle around a lamp, its corners in frame space.
fn lamp_outline(frame: &LightFrame, corners: [Vec3; 3]) -> Traits {
    let distances = corners.map(|c| c.as_dvec3().length().max(1e-30));
    let directions = [0, 1, 2].map(|i| corners[i].as_dvec3() / distances[i]);
    let inverse_depths = distances.map(|d| 1.0 / d);
    let nearest = distance_to_origin(corners);
    let is_anywhere = frame.is_at_lamp(nearest);
    let margin = frame.margin(nearest);
    let [a, b, c] = directions;
    let edges = [b.cross(c), c.cross(a), a.cross(b)];
    let lengths = edges.map(DVec3::length);
    let longest = lengths.iter().copied().fold(1e-300, f64::max);
    let whole = a.dot(edges[0]);
    let sign = if whole < 0.0 { -1.0 } else { 1.0 };
    // Along a short edge the direction is known only roughly: at its far end the error is longest / length as large.
    let scaled =
        [0, 1, 2].map(|i| edges[i] * (sign / (f64::from(margin) * (lengths[i] + longest))));
    // The plane through the corners' depths. What the edges are wrong by moves it by the sum of their shares.
    let differences = inverse_depths.map(|d| d - inverse_depths[0]);
    let shares = [0, 1, 2].map(|i| differences[i].abs() * lengths[i]);
    let slope = shares.iter().sum::<f64>() / whole.abs();
    let relative_slope = slope / inverse_depths.iter().copied().fold(f64::INFINITY, f64::min);
    let depth_margin = f64::from(frame.depth_margin());
    let knows_depth = !is_anywhere && relative_slope * f64::from(margin) <= 0.5 * depth_margin;
    let plane = if knows_depth {
        let sum = edges[0] * inverse_depths[0]
            + edges[1] * inverse_depths[1]
            + edges[2] * inverse_depths[2];
        sum / (whole * depth_margin)
    } else {
        DVec3::ZERO
    };
    let lanes = |f: fn(&DVec3) -> f64| {
        let [e0, e1, e2] = [0, 1, 2].map(|i| f(&scaled[i]) as f32);
        Vec4::new(e0, e1, e2, f(&plane) as f32)
    };
    Traits {
        outline: Outline {
            x: lanes(|v| v.x),
            y: lanes(|v| v.y),
            z: lanes(|v| v.z),
        },
        knows_depth,
    }
}

/// Returns a lower bound of the distance between the origin and a triangle.
pub(super) fn distance_to_origin(corners: [Vec3; 3]) -> f32 {
    let [a, b, c] = corners;
    let low = a.min(b).min(c);
    let high = a.max(b).max(c);
    // Of the box around it.
    let nearest = low.max(Vec3::ZERO) + high.min(Vec3::ZERO);
    nearest.length()
}

/// Triangles that are outlined at once.
const BATCH: usize = 16;

/// A number of each triangle of a batch.
type Lanes = [f32; BATCH];

/// Outlines a batch of triangles under a sun.
struct OutlineSun<'a> {
    frame: &'a LightFrame,
    /// World positions of the corners, less the frame's origin: x, y, z of each.
    corners: &'a [[Lanes; 3]; 3],
}

/// The outlines of a batch of triangles under a sun.
struct SunOutlines {
    /// x, y and z of three edges and the plane, as in [`Outline`].
    functions: [[Lanes; 3]; 4],
    /// 1 where the plane says where the triangle lies in depth, else 0.
    knows_depth: Lanes,
}

impl SunOutlines {
    /// Returns a triangle's outline.
    #[inline(always)]
    fn traits(&self, lane: usize) -> Traits {
        let axis = |axis: usize| {
            let [e0, e1, e2, plane] = [0, 1, 2, 3].map(|k: usize| self.functions[k][axis][lane]);
            Vec4::new(e0, e1, e2, plane)
        };
        Traits {
            outline: Outline {
                x: axis(0),
                y: axis(1),
                z: axis(2),
            },
            knows_depth: self.knows_depth[lane] > 0.0,
        }
    }
}

impl SimdTask for OutlineSun<'_> {
    type Output = SunOutlines;

    /// As [`lamp_outline`], in 32 bits: edges are differences of corners, and begin at a corner each, so that nothing cancels.
    #[inline(always)]
    fn run(self) -> SunOutlines {
        let frame = *self.frame;
        // Copies, so that the loop becomes one of vector instructions: what it writes can't be what it reads.
        let corners = *self.corners;
        let mut out = SunOutlines {
            functions: [[[0.0; BATCH]; 3]; 4],
            knows_depth: [0.0; BATCH],
        };
        let margin = frame.margin(0.0);
        let depth_margin = frame.depth_margin();
        let steepest = 0.5 * depth_margin / margin;
        let [across, down, away] = frame.rows;
        for i in 0..BATCH {
            let place = |corner: usize| {
                let [x, y, z] = [0, 1, 2].map(|axis| corners[corner][axis][i]);
                let row = |r: Vec3| r.x * x + r.y * y + r.z * z;
                [row(across), row(down), row(away) - frame.nearest]
            };
            let [a, b, c] = [place(0), place(1), place(2)];
            // Normals of the edges opposite to a, b, c, which begin at b, c, a.
            let normals = [
                [b[1] - c[1], c[0] - b[0]],
                [c[1] - a[1], a[0] - c[0]],
                [a[1] - b[1], b[0] - a[0]],
            ];
            let starts = [b, c, a];
            let lengths = normals.map(|n| (n[0] * n[0] + n[1] * n[1]).sqrt());
            let longest = greater(greater(lengths[0], lengths[1]), greater(lengths[2], 1e-20));
            // Twice the area.
            let whole = normals[2][1] * (c[1] - a[1]) + normals[2][0] * (c[0] - a[0]);
            let sign = if whole < 0.0 { -1.0 } else { 1.0 };
            for k in 0..3 {
                let scale = sign / (margin * (lengths[k] + longest));
                let x = normals[k][0] * scale;
                let y = normals[k][1] * scale;
                out.functions[k][0][i] = x;
                out.functions[k][1][i] = y;
                out.functions[k][2][i] = -(x * starts[k][0] + y * starts[k][1]);
            }
            let to_b = b[2] - a[2];
            let to_c = c[2] - a[2];
            let size = whole.abs();
            let is_flat = to_b.abs() * lengths[1] + to_c.abs() * lengths[2] <= steepest * size;
            let is_wide = size >= THINNEST * longest * longest && size > 1e-30;
            let knows_depth = is_flat && is_wide;
            out.knows_depth[i] = if knows_depth { 1.0 } else { 0.0 };
            let scale = if knows_depth { -1.0 / (whole * depth_margin) } else { 0.0 };
            let x = (normals[1][0] * to_b + normals[2][0] * to_c) * scale;
            let y = (normals[1][1] * to_b + normals[2][1] * to_c) * scale;
            let at_a = if knows_depth { -a[2] / depth_margin } else { 0.0 };
            out.functions[3][0][i] = x;
            out.functions[3][1][i] = y;
            out.functions[3][2][i] = at_a - (x * a[0] + y * a[1]);
        }
        out
    }
}

/// The greater of two numbers, as one vector instruction has it.
#[inline(always)]
pub(super) fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The lesser of two numbers, likewise.
#[inline(always)]
pub(super) fn lesser(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// Returns the outlines of some triangles of a list of triangles, passes each to `take`, in their order.
pub(super) fn outlines(
    frame: &LightFrame,
    geometry: &Geometry,
    triangles: impl Iterator<Item = u32>,
    mut take: impl FnMut(Traits),
) {
    if frame.is_lamp {
        for id in triangles {
            take(lamp_outline(frame, geometry.corners(id).map(|p| frame.place(p))));
        }
        return;
    }
    let positions = geometry.positions();
    let mut corners = [[[0.0; BATCH]; 3]; 3];
    let mut lane = 0;
    let mut finish = |corners: &[[Lanes; 3]; 3], count: usize| {
        let batch = Simd::Native.run_task(OutlineSun { frame, corners });
        for lane in 0..count {
            take(batch.traits(lane));
        }
    };
    for id in triangles {
        for (corner, &vertex) in geometry.triangles()[id as usize].iter().enumerate() {
            let p = positions[vertex as usize] - frame.origin;
            corners[corner][0][lane] = p.x;
            corners[corner][1][lane] = p.y;
            corners[corner][2][lane] = p.z;
        }
        lane += 1;
        if lane == BATCH {
            finish(&corners, lane);
            lane = 0;
        }
    }
    if lane > 0 {
        finish(&corners, lane);
    }
}
