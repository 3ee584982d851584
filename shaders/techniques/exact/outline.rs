//! Outline of a triangle as projected to the light, for triangles that are larger than a cell. The
//! three edge functions are all above 1 where a ray surely passes within the triangle. One of them
//! is below -1 where it surely misses it. The outline also has the plane's depth.
//!
//! Edge functions are in homogeneous form (Olano and Greer 1997, "Triangle Scan Conversion using 2D
//! Homogeneous Coordinates"). They are linear in a direction on any face of a cube, and correct for
//! triangles that extend behind the light. With the corners' directions h, the edge opposite to
//! corner a is `h_b x h_c`. The plane is the combination of the three edges that has the corners'
//! depths. For point lights it has one over the depths, which is linear where depth isn't.

use super::light_frame::LightFrame;
use umbrage_core::{
    Geometry,
    glam::{DVec3, Vec3, Vec4},
};

/// Factors of a direction's coordinates: `x q.x + y q.y + z q.z`, lane by lane. The lanes are three
/// edges, then the depth of the plane, or one over it for a point light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Outline {
    pub(super) x: Vec4,
    pub(super) y: Vec4,
    pub(super) z: Vec4,
}

/// Outline with the validity of its depth.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Traits {
    pub(super) outline: Outline,
    /// True if the plane's depth is valid. If the plane is steep or the triangle thin, only the
    /// triangle test is valid.
    pub(super) knows_depth: bool,
}

impl Outline {
    /// Returns the same functions on a face of the cube around a point light: factors of the
    /// coordinates across and down, and a summand.
    #[inline(always)]
    pub(super) fn on_face(&self, is_lamp: bool, face: u32) -> [Vec4; 3] {
        let axes = [self.x, self.y, self.z];
        if !is_lamp {
            return axes;
        }
        let axis = face as usize / 2;
        let along = if face % 2 == 1 {
            -axes[axis]
        } else {
            axes[axis]
        };
        [axes[(axis + 1) % 3], axes[(axis + 2) % 3], along]
    }
}

/// Returns the outline of a triangle of a geometry.
pub(super) fn outline_of(frame: &LightFrame, geometry: &Geometry, triangle: u32) -> Traits {
    outline(frame, geometry.corners(triangle).map(|p| frame.place(p)))
}

/// Returns a triangle's outline from its corners in frame space.
pub(super) fn outline(frame: &LightFrame, corners: [Vec3; 3]) -> Traits {
    // Compute homogeneous directions, and the depth that is linear in them.
    let mut directions = [DVec3::ZERO; 3];
    let mut depths = [0.0; 3];
    for (i, corner) in corners.iter().map(|c| c.as_dvec3()).enumerate() {
        if frame.is_lamp {
            let distance = corner.length().max(1e-30);
            directions[i] = corner / distance;
            depths[i] = 1.0 / distance;
        } else {
            directions[i] = corner.with_z(1.0);
            depths[i] = corner.z;
        }
    }
    let nearest = distance_to_origin(corners);
    let margin = frame.margin(nearest);
    let [a, b, c] = directions;
    let edges = [b.cross(c), c.cross(a), a.cross(b)];
    // Measure the edges' lengths across the rays.
    let lengths = edges.map(|e| {
        if frame.is_lamp {
            e.length()
        } else {
            e.truncate().length()
        }
    });
    let longest = lengths.iter().copied().fold(1e-300, f64::max);
    let whole = a.dot(edges[0]);
    let sign = if whole < 0.0 { -1.0 } else { 1.0 };
    // Scale the edges by their error. A short edge has an uncertain direction; the error at its far
    // end is longest / length as large.
    let scaled =
        [0, 1, 2].map(|i| edges[i] * (sign / (f64::from(margin) * (lengths[i] + longest))));
    // Fit the plane through the corners' depths. Its error is the sum of the edges' contributions.
    let shares = [0, 1, 2].map(|i| (depths[i] - depths[0]).abs() * lengths[i]);
    let slope = shares.iter().sum::<f64>() / whole.abs();
    let relative_slope = if frame.is_lamp {
        slope / depths.iter().copied().fold(f64::INFINITY, f64::min)
    } else {
        slope
    };
    // Use the plane's depth only if it is accurate.
    let is_anywhere = frame.is_at_lamp(nearest);
    let depth_margin = f64::from(frame.depth_margin());
    let knows_depth = !is_anywhere && relative_slope * f64::from(margin) <= 0.5 * depth_margin;
    let plane = if knows_depth {
        (edges[0] * depths[0] + edges[1] * depths[1] + edges[2] * depths[2]) / whole
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
    // Use the triangle's bounding box.
    let nearest = low.max(Vec3::ZERO) + high.min(Vec3::ZERO);
    nearest.length()
}
