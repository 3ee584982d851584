//! A triangle's outline as seen from the light: three edges and a plane, as functions that are above 1 where a ray surely
//! meets the triangle, below -1 where it surely misses it, and between where only the triangle test of rays may tell.
//!
//! Sutherland and Hodgman's edge functions in homogeneous form (Olano and Greer 1997, "Triangle Scan Conversion using 2D
//! Homogeneous Coordinates"): linear in a direction, whatever face of a cube it falls on, and right for triangles that reach behind
//! the light. With h the corners' directions, the edge opposite to corner a is `h_b x h_c`; the plane is
//! the combination of the three edges that has the corners' depths (for lamps: one over them, which is linear where depth isn't).

use super::light_frame::LightFrame;
use umbrage_core::glam::{DVec3, Vec3, Vec4};

/// The factors of a direction's coordinates: `at(q) = x q.x + y q.y + z q.z`, lane by lane: three edges, then the plane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Outline {
    pub(super) x: Vec4,
    pub(super) y: Vec4,
    pub(super) z: Vec4,
}

/// An outline, and what else lists need to know of its triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Traits {
    pub(super) outline: Outline,
    /// Margin in units of a direction, by which all that the triangle covers is grown.
    pub(super) margin: f32,
    /// Whether the plane says where the triangle lies in depth; else, as where it is steep or thin, only the triangle test does.
    pub(super) knows_depth: bool,
    /// Whether it may lie anywhere: it is so near to a lamp that its outline means nothing.
    pub(super) is_anywhere: bool,
}

impl Outline {
    /// Returns the functions' values in a direction, before [`LightFrame::depth_terms`].
    #[inline(always)]
    pub(super) fn at(&self, q: Vec3) -> Vec4 {
        self.x * q.x + self.y * q.y + self.z * q.z
    }

    /// Returns the rows of a shader's table.
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

impl Traits {
    /// Returns a triangle's outline, its corners in frame space.
    pub(super) fn new(frame: &LightFrame, corners: [Vec3; 3]) -> Self {
        // Homogeneous directions, and what is linear in them: a sun's depth, or one over a lamp's.
        let mut directions = [DVec3::ZERO; 3];
        let mut depths = [0.0; 3];
        let mut nearest = f32::INFINITY;
        for (i, corner) in corners.iter().enumerate() {
            if frame.is_lamp {
                let distance = corner.as_dvec3().length().max(1e-30);
                directions[i] = corner.as_dvec3() / distance;
                depths[i] = 1.0 / distance;
            } else {
                directions[i] = DVec3::new(f64::from(corner.x), f64::from(corner.y), 1.0);
                depths[i] = f64::from(corner.z);
            }
        }
        if frame.is_lamp {
            nearest = distance_to_origin(corners);
        }
        let is_anywhere = frame.is_at_lamp(nearest);
        let margin = frame.margin(nearest);
        let [a, b, c] = directions;
        let edges = [b.cross(c), c.cross(a), a.cross(b)];
        // How long the edges are, across the rays.
        let lengths = edges.map(|e| {
            if frame.is_lamp { e.length() } else { e.truncate().length() }
        });
        let longest = lengths.iter().copied().fold(1e-300, f64::max);
        let whole = a.dot(edges[0]);
        let sign = if whole < 0.0 { -1.0 } else { 1.0 };
        // Along a short edge the direction is known only roughly: at its far end the error is longest / length as large.
        let scaled = [0, 1, 2].map(|i| {
            edges[i] * (sign / (f64::from(margin) * (lengths[i] + longest)))
        });
        // The plane through the corners' depths. The area's rounding moves it by the sum of the edges' shares.
        let differences = depths.map(|d| d - depths[0]);
        let slope = (0..3).map(|i| differences[i].abs() * lengths[i]).sum::<f64>() / whole.abs();
        let relative = if frame.is_lamp {
            slope / depths.iter().copied().fold(f64::INFINITY, f64::min)
        } else {
            slope
        };
        let depth_margin = f64::from(frame.depth_margin());
        let knows_depth =
            !is_anywhere && relative * f64::from(margin) <= 0.5 * depth_margin && relative.is_finite();
        let plane = if knows_depth {
            let sum = edges[0] * depths[0] + edges[1] * depths[1] + edges[2] * depths[2];
            let toward = if frame.is_lamp { 1.0 } else { -1.0 };
            sum * (toward / (whole * depth_margin))
        } else {
            DVec3::ZERO
        };
        let lanes = |f: fn(&DVec3) -> f64| {
            Vec4::new(
                f(&scaled[0]) as f32,
                f(&scaled[1]) as f32,
                f(&scaled[2]) as f32,
                f(&plane) as f32,
            )
        };
        Self {
            outline: Outline {
                x: lanes(|v| v.x),
                y: lanes(|v| v.y),
                z: lanes(|v| v.z),
            },
            margin,
            knows_depth,
            is_anywhere,
        }
    }
}

/// Returns a lower bound of the distance between the origin and a triangle.
fn distance_to_origin(corners: [Vec3; 3]) -> f32 {
    let [a, b, c] = corners;
    let low = a.min(b).min(c);
    let high = a.max(b).max(c);
    // Of the box around it.
    let nearest = low.max(Vec3::ZERO) + high.min(Vec3::ZERO);
    nearest.length()
}
