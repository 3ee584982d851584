//! The triangle test of four segments at once, bit-equal to
//! [`Segment::hits`](super::ray_triangle::Segment).
//!
//! In the shear of `ray_triangle.rs`, each of the first two rows has two non-zero factors: one for
//! the segment's longest axis and one for another axis. Adding a product with zero changes no bit
//! that a comparison sees, and a sum of two numbers has only one order. Two products and a sum are
//! therefore equivalent to the three products there.

use crate::geometry::ray_box::{EXIT_SLACK, inverse_power, padded_box};
use glam::{Vec3, Vec3A, Vec4};

/// Number of segments tested at once.
pub const SEGMENT_LANES: usize = 4;

/// `N` segments, with one array for each number that tests need.
#[derive(Clone, Copy, Debug)]
pub struct SegmentArrays<const N: usize> {
    origin: [[f32; N]; 3],
    vector: [[f32; N]; 3],
    scale: [f32; N],
    /// Factors of the longest axis in the first two rows of the shear.
    shear: [[f32; N]; 2],
    /// Inverse of the vector's component along its longest axis.
    along: [f32; N],
    axis: [u32; N],
}

impl<const N: usize> Default for SegmentArrays<N> {
    fn default() -> Self {
        Self {
            origin: [[0.0; N]; 3],
            vector: [[0.0; N]; 3],
            scale: [0.0; N],
            shear: [[0.0; N]; 2],
            along: [0.0; N],
            axis: [0; N],
        }
    }
}

/// Returns the longest axis of a segment's vector, with the tie rule of the triangle test: z before
/// x before y.
#[inline(always)]
pub fn longest_axis(d: Vec3) -> u32 {
    let size = d.abs();
    let is_z = size.z >= size.x && size.z >= size.y;
    let is_x = size.x >= size.y;
    if is_z {
        2
    } else if is_x {
        0
    } else {
        1
    }
}

/// Returns the components of `v` along `axis` and the two axes that follow it cyclically. Uses
/// selections instead of an index, so that loops over many vectors are vectorised.
#[inline(always)]
fn turn_axes(v: Vec3, axis: u32) -> [f32; 3] {
    let pick = |x: f32, y: f32, z: f32| {
        if axis == 0 {
            x
        } else if axis == 1 {
            y
        } else {
            z
        }
    };
    [
        pick(v.x, v.y, v.z),
        pick(v.y, v.z, v.x),
        pick(v.z, v.x, v.y),
    ]
}

impl<const N: usize> SegmentArrays<N> {
    /// Sets segment `i` to the one from `o` to `o + d`.
    ///
    /// # Panics
    /// Panics if `i` is not less than `N`.
    #[inline(always)]
    pub fn set(&mut self, i: usize, o: Vec3, d: Vec3) {
        let axis = longest_axis(d);
        let [along, first, second] = turn_axes(d, axis);
        let scale = inverse_power(along.abs());
        for k in 0..3 {
            self.origin[k][i] = o[k];
            self.vector[k][i] = d[k];
        }
        self.scale[i] = scale;
        self.shear[0][i] = -(first / along) * scale;
        self.shear[1][i] = -(second / along) * scale;
        self.along[i] = 1.0 / along;
        self.axis[i] = axis;
    }

    /// Returns the origin of segment `i`.
    #[inline(always)]
    pub fn origin(&self, i: usize) -> Vec3 {
        let [x, y, z] = &self.origin;
        Vec3::new(x[i], y[i], z[i])
    }

    /// Returns the longest axis of segment `i`.
    #[inline(always)]
    pub fn axis(&self, i: usize) -> u32 {
        self.axis[i]
    }

    /// Returns the four segments from `first` on. They must share the longest axis of the first;
    /// results for others are meaningless.
    ///
    /// # Panics
    /// Panics if there are fewer.
    #[inline(always)]
    pub fn four(&self, first: usize) -> FourSegments {
        let axis = self.axis[first] as usize;
        let axes = following_axes(axis);
        // Use loops instead of closures over arrays: see `FourSegments::hits`.
        let mut origin = [Vec4::ZERO; 3];
        let mut turned_origin = [Vec4::ZERO; 3];
        let mut vector = [Vec4::ZERO; 3];
        for k in 0..3 {
            origin[k] = four_from(&self.origin[k], first);
            turned_origin[k] = four_from(&self.origin[axes[k]], first);
            vector[k] = four_from(&self.vector[k], first);
        }
        FourSegments {
            origin,
            turned_origin,
            vector,
            scale: four_from(&self.scale, first),
            shear: [
                four_from(&self.shear[0], first),
                four_from(&self.shear[1], first),
            ],
            along: four_from(&self.along, first),
            axis,
        }
    }
}

/// Returns four numbers, starting at `first`.
#[inline(always)]
fn four_from(numbers: &[f32], first: usize) -> Vec4 {
    Vec4::from_slice(&numbers[first..first + SEGMENT_LANES])
}

/// Returns an axis and the two that follow it cyclically.
#[inline(always)]
fn following_axes(axis: usize) -> [usize; 3] {
    [axis, (axis + 1) % 3, (axis + 2) % 3]
}

/// Returns the components of four vectors along `axis` and the two axes that follow it cyclically.
#[inline(always)]
fn turned_lanes(v: [Vec4; 3], axis: usize) -> [Vec4; 3] {
    let axes = following_axes(axis);
    [v[axes[0]], v[axes[1]], v[axes[2]]]
}

/// Returns [`inverse_power`] of each number.
#[inline(always)]
fn inverse_powers(numbers: Vec4) -> Vec4 {
    let numbers = numbers.to_array();
    let mut out = [0.0; SEGMENT_LANES];
    for lane in 0..SEGMENT_LANES {
        out[lane] = inverse_power(numbers[lane]);
    }
    Vec4::from_array(out)
}

/// Returns `ray_box::safe_inverse` of each number.
#[inline(always)]
fn safe_inverses(numbers: Vec4) -> Vec4 {
    let is_tiny = numbers.abs().cmplt(Vec4::splat(1e-30));
    let is_positive = numbers.cmpge(Vec4::ZERO);
    let huge = Vec4::select(is_positive, Vec4::splat(1e30), Vec4::splat(-1e30));
    Vec4::select(is_tiny, huge, numbers.recip())
}

/// Four segments that share their longest axis.
#[derive(Clone, Copy, Debug)]
pub struct FourSegments {
    origin: [Vec4; 3],
    /// The components of `origin` along the longest axis and the two that follow it.
    turned_origin: [Vec4; 3],
    vector: [Vec4; 3],
    scale: Vec4,
    shear: [Vec4; 2],
    along: Vec4,
    axis: usize,
}

impl FourSegments {
    /// Returns the segments from these origins along these vectors, one lane per segment. All
    /// vectors must be longest along `axis`.
    #[inline(always)]
    #[must_use]
    pub fn new(origin: [Vec4; 3], vector: [Vec4; 3], axis: u32) -> Self {
        let axis = axis as usize;
        let [along, first, second] = turned_lanes(vector, axis);
        let scale = inverse_powers(along.abs());
        Self {
            origin,
            turned_origin: turned_lanes(origin, axis),
            vector,
            scale,
            shear: [-(first / along) * scale, -(second / along) * scale],
            along: along.recip(),
            axis,
        }
    }

    /// Returns segments with the same vectors from other origins, one lane per segment.
    #[inline(always)]
    #[must_use]
    pub fn with_origins(&self, origin: [Vec4; 3]) -> Self {
        Self {
            origin,
            turned_origin: turned_lanes(origin, self.axis),
            ..*self
        }
    }

    /// Returns a bit for each segment that meets the triangle, edges and ends included.
    #[inline(always)]
    pub fn hits(&self, corners: [Vec3; 3]) -> u32 {
        // Use loops instead of closures over arrays: compilers don't always inline the closures,
        // and then emit no vector instructions.
        let axes = following_axes(self.axis);
        let origin = self.turned_origin;
        let mut along_axis = [Vec4::ZERO; 3];
        let mut x = [Vec4::ZERO; 3];
        let mut y = [Vec4::ZERO; 3];
        for i in 0..3 {
            let corner = corners[i].to_array();
            // Compute components along the longest axis and the two that follow it.
            let along = Vec4::splat(corner[axes[0]]) - origin[0];
            let first = Vec4::splat(corner[axes[1]]) - origin[1];
            let second = Vec4::splat(corner[axes[2]]) - origin[2];
            along_axis[i] = along;
            x[i] = self.scale * first + self.shear[0] * along;
            y[i] = self.scale * second + self.shear[1] * along;
        }
        let areas = [
            x[1] * y[2] - y[1] * x[2],
            x[2] * y[0] - y[2] * x[0],
            x[0] * y[1] - y[0] * x[1],
        ];
        let least = areas[0].min(areas[1]).min(areas[2]);
        let greatest = areas[0].max(areas[1]).max(areas[2]);
        let inside = least.cmpge(Vec4::ZERO) | greatest.cmple(Vec4::ZERO);
        let inside = inside.bitmask();
        if inside == 0 {
            return 0;
        }
        inside & self.meets_plane_and_box(corners, along_axis, x, y, areas)
    }

    /// Performs the rest of the test, which few segments need.
    #[inline(always)]
    fn meets_plane_and_box(
        &self,
        corners: [Vec3; 3],
        along_axis: [Vec4; 3],
        x: [Vec4; 3],
        y: [Vec4; 3],
        areas: [Vec4; 3],
    ) -> u32 {
        let z = [
            along_axis[0] * self.along,
            along_axis[1] * self.along,
            along_axis[2] * self.along,
        ];
        let whole = areas[0] + areas[1] + areas[2];
        let along = areas[0] * z[0] + areas[1] * z[1] + areas[2] * z[2];
        let zero = Vec4::ZERO;
        let before = whole.cmpgt(zero) & along.cmpge(zero) & along.cmple(whole);
        let behind = whole.cmplt(zero) & along.cmple(zero) & along.cmpge(whole);
        let between = (before | behind).bitmask();
        if between == 0 {
            return 0;
        }
        let holds = |v: [Vec4; 3]| {
            let least = v[0].min(v[1]).min(v[2]);
            let greatest = v[0].max(v[1]).max(v[2]);
            least.cmple(zero) & greatest.cmpge(zero)
        };
        let holds_origin = (holds(x) & holds(y)).bitmask();
        between
            & holds_origin
            & !self.leaves(corners)
            & self.enters(padded_box([
                Vec3A::from(corners[0]),
                Vec3A::from(corners[1]),
                Vec3A::from(corners[2]),
            ]))
    }

    /// Returns a bit for each segment that starts outside the triangle's exact box and moves away
    /// from it along an axis.
    #[inline(always)]
    fn leaves(&self, corners: [Vec3; 3]) -> u32 {
        let [a, b, c] = corners;
        let low = a.min(b).min(c);
        let high = a.max(b).max(c);
        let zero = Vec4::ZERO;
        let mut leaves = 0;
        for axis in 0..3 {
            let origin = self.origin[axis];
            let vector = self.vector[axis];
            let above = origin.cmpgt(Vec4::splat(high[axis])) & vector.cmpge(zero);
            let below = origin.cmplt(Vec4::splat(low[axis])) & vector.cmplt(zero);
            leaves |= (above | below).bitmask();
        }
        leaves
    }

    /// Returns a bit for each segment that enters a box, given its least and greatest corner.
    #[inline(always)]
    fn enters(&self, corners: [Vec3A; 2]) -> u32 {
        let [low, high] = corners;
        let mut entry = Vec4::ZERO;
        let mut exit = Vec4::ONE;
        for axis in 0..3 {
            // Compute the inverse here: few segments need it, so storing it for every segment would
            // cost more.
            let inverse = safe_inverses(self.vector[axis]);
            let a = (Vec4::splat(low[axis]) - self.origin[axis]) * inverse;
            let b = (Vec4::splat(high[axis]) - self.origin[axis]) * inverse;
            entry = entry.max(a.min(b));
            exit = exit.min(a.max(b));
        }
        entry.cmple(exit * EXIT_SLACK).bitmask()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        geometry::{random::Random, ray_box::safe_inverse, ray_triangle::segment_hits},
        scene::light_sample::hash,
    };

    /// Inverting four numbers at once is bit-equal to inverting each, for tiny numbers and signed
    /// zeros, too.
    #[test]
    fn lanes_are_inverted_as_single_numbers_are() {
        let numbers = [
            0.0,
            -0.0,
            1e-31,
            -1e-31,
            1e-30,
            -2.5,
            3.0,
            1e30,
            -1e-38,
            f32::INFINITY,
            f32::MAX,
            0.1,
        ];
        for four in numbers.chunks_exact(SEGMENT_LANES) {
            let inverses = safe_inverses(Vec4::from_slice(four));
            let powers = inverse_powers(Vec4::from_slice(four).abs());
            for (lane, &number) in four.iter().enumerate() {
                assert_eq!(inverses[lane].to_bits(), safe_inverse(number).to_bits());
                assert_eq!(
                    powers[lane].to_bits(),
                    inverse_power(number.abs()).to_bits()
                );
            }
        }
    }

    /// Returns a point of a coarse grid, so that segments pass through edges and corners, and along
    /// planes.
    fn grid_point(random: &mut Random) -> Vec3 {
        (random.vector() * 3.0).round()
    }

    /// Each lane agrees with the test of one segment, also on edges, at corners and in planes.
    #[test]
    fn lanes_say_what_the_test_of_one_segment_says() {
        let mut random = Random(7);
        let mut hits = 0;
        let mut tested = 0;
        for i in 0..60_000_u32 {
            let is_coarse = i % 2 == 0;
            let point = |random: &mut Random| {
                if is_coarse {
                    grid_point(random)
                } else {
                    random.vector()
                }
            };
            let far = [0.0, 1e3, 1e6][i as usize / 2 % 3];
            let corners = [0; 3].map(|_| point(&mut random) + far);
            let mut arrays = SegmentArrays::<4>::default();
            let segments = [0; 4].map(|_| {
                let o = point(&mut random) + far;
                // Aim at a corner, an edge, the interior, or anywhere.
                let inner = corners[0]
                    .lerp(corners[1], 0.5)
                    .lerp(corners[2], random.signed_unit().abs());
                let d = match hash(random.0) % 4 {
                    0 => (corners[0] - o) * 2.0,
                    1 => (corners[0].lerp(corners[1], 0.5) - o) * 1.5,
                    2 => (inner - o) * 2.0,
                    _ => point(&mut random),
                };
                (o, d)
            });
            for (lane, &(o, d)) in segments.iter().enumerate() {
                arrays.set(lane, o, d);
            }
            let bits = arrays.four(0).hits(corners);
            let lanes = |of: fn(&(Vec3, Vec3)) -> Vec3| {
                [0, 1, 2].map(|k| Vec4::from_array(segments.map(|s| of(&s)[k])))
            };
            let made_at_once = FourSegments::new(lanes(|s| s.0), lanes(|s| s.1), arrays.axis(0));
            let bits_at_once = made_at_once.hits(corners);
            for (lane, &(o, d)) in segments.iter().enumerate() {
                if arrays.axis(lane) != arrays.axis(0) {
                    continue;
                }
                let expected = segment_hits(o, d, corners[0], corners[1], corners[2]);
                assert_eq!(
                    bits >> lane & 1 == 1,
                    expected,
                    "{corners:?} from {o} along {d}"
                );
                assert_eq!(bits_at_once >> lane & 1, bits >> lane & 1, "four at once");
                hits += u32::from(expected);
                tested += 1;
            }
        }
        assert!(
            hits > tested / 10 && hits < tested,
            "too few hits to be meaningful: {hits} of {tested}"
        );
    }
}
