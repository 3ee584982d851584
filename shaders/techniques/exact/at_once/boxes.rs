//! Groups of eight boxes on a face of a light's frame, with depth ranges.

use super::super::{light_frame::LightFrame, outline::distance_to_origin};
use umbrage_core::{
    Aabb,
    glam::{Vec2, Vec4},
    math::{greater, lesser},
};

/// Number of boxes that are tested at once.
pub(super) const BOXES: usize = 8;
/// Number of boxes in a vector.
const LANES: usize = 4;

/// One value per box.
type Eight = [f32; BOXES];

/// Region of a face in which a caster may hide the light, including margins.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reach {
    pub(super) low: Vec2,
    pub(super) high: Vec2,
    /// Least depth.
    pub(super) nearest: f32,
}

/// Bounds of receivers on a face.
#[derive(Clone, Copy, Debug)]
pub(super) struct FaceBox {
    pub(super) low: Vec2,
    pub(super) high: Vec2,
    /// Least depth.
    nearest: f32,
    /// Greatest depth.
    pub(super) farthest: f32,
}

/// Eight such boxes; unused ones are empty.
#[derive(Clone, Copy, Debug)]
pub(super) struct Boxes {
    low: [Eight; 2],
    high: [Eight; 2],
    nearest: Eight,
    farthest: Eight,
}

/// Edges and plane of a large caster, as functions on a face.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct FaceOutline {
    /// Factors of the coordinates across and down, and a summand. The lanes are three edges and the
    /// plane.
    pub(super) factors: [Vec4; 3],
    /// True if the plane's function is valid.
    pub(super) knows_depth: bool,
}

impl Reach {
    /// Reach of no caster.
    pub(super) const NOWHERE: Self = Self {
        low: Vec2::INFINITY,
        high: Vec2::NEG_INFINITY,
        nearest: f32::INFINITY,
    };
    /// Reach of casters that may be anywhere.
    const ANYWHERE: Self = Self {
        low: Vec2::NEG_INFINITY,
        high: Vec2::INFINITY,
        nearest: 0.0,
    };

    /// Returns the region of a face in which casters in a world-space box may hide the light, if
    /// any.
    #[inline(always)]
    pub(super) fn of_box(frame: &LightFrame, face: u32, bounds: &Aabb) -> Option<Self> {
        if frame.is_lamp {
            Self::of_box_at_lamp(frame, face, bounds)
        } else {
            Some(Self::of_box_under_sun(frame, bounds))
        }
    }

    #[inline(always)]
    fn of_box_under_sun(frame: &LightFrame, bounds: &Aabb) -> Self {
        let center = bounds.center();
        let half = bounds.max - center;
        let placed = frame.place_as::<false>(center);
        let [across, down, deep] = frame.rows.map(|row| row.abs().dot(half));
        // Add the rounding of the products, with a large safety factor.
        let margin = frame.margin(0.0) + frame.rounding;
        let at = placed.truncate();
        let half = Vec2::new(across, down) + margin;
        Self {
            low: at - half,
            high: at + half,
            nearest: frame.depth_before(placed.z - deep) - margin,
        }
    }

    #[inline(always)]
    fn of_box_at_lamp(frame: &LightFrame, face: u32, bounds: &Aabb) -> Option<Self> {
        let low = frame.place_as::<true>(bounds.min);
        let high = frame.place_as::<true>(bounds.max);
        let distance = distance_to_origin([low, high, high]);
        if frame.is_at_lamp(distance) {
            return Some(Self::ANYWHERE);
        }
        let margin = 2.0 * frame.margin(distance);
        // Find the depth range along the face's axis.
        let axis = face as usize / 2;
        let [near, far] = if face % 2 == 1 {
            [-high[axis], -low[axis]]
        } else {
            [low[axis], high[axis]]
        };
        if far < 0.0 {
            return None;
        }
        // Reject boxes outside the face's pyramid.
        let widest = far * (1.0 + margin);
        let sides = [(axis + 1) % 3, (axis + 2) % 3];
        if sides.iter().any(|&k| low[k] > widest || -high[k] > widest) {
            return None;
        }
        if near <= 0.0 {
            return Some(Self::ANYWHERE);
        }
        // Directions are coordinates divided by the depth, which is between the two.
        let least = |k: usize| low[k] / if low[k] < 0.0 { near } else { far };
        let greatest = |k: usize| high[k] / if high[k] < 0.0 { far } else { near };
        let [across, down] = sides;
        Some(Self {
            low: Vec2::new(least(across), least(down)) - margin,
            high: Vec2::new(greatest(across), greatest(down)) + margin,
            nearest: frame.depth_before(near),
        })
    }
}

impl FaceBox {
    /// Box around nothing.
    pub(super) const EMPTY: Self = Self {
        low: Vec2::INFINITY,
        high: Vec2::NEG_INFINITY,
        nearest: f32::INFINITY,
        farthest: f32::NEG_INFINITY,
    };

    /// Grows the box around a point. NaN is skipped, but then nothing covers the box.
    #[inline(always)]
    pub(super) fn add(&mut self, at: Vec2, depth: f32) {
        let is_number = at.x + at.y + depth < f32::INFINITY;
        let bounded = if is_number { depth } else { f32::NEG_INFINITY };
        self.nearest = lesser(bounded, self.nearest);
        self.low = Vec2::new(lesser(at.x, self.low.x), lesser(at.y, self.low.y));
        self.high = Vec2::new(greater(at.x, self.high.x), greater(at.y, self.high.y));
        self.farthest = greater(depth, self.farthest);
    }

    /// Grows the box around another box.
    #[inline(always)]
    pub(super) fn add_box(&mut self, other: &Self) {
        self.low = self.low.min(other.low);
        self.high = self.high.max(other.high);
        self.nearest = lesser(other.nearest, self.nearest);
        self.farthest = greater(other.farthest, self.farthest);
    }
}

impl Boxes {
    const EMPTY: Self = Self {
        low: [[f32::INFINITY; BOXES]; 2],
        high: [[f32::NEG_INFINITY; BOXES]; 2],
        nearest: [f32::INFINITY; BOXES],
        farthest: [f32::NEG_INFINITY; BOXES],
    };

    /// Groups up to eight boxes, and returns them with their bounding box.
    #[inline(always)]
    pub(super) fn around_boxes(boxes: &[FaceBox]) -> (Self, FaceBox) {
        let mut all = FaceBox::EMPTY;
        let mut out = Self::EMPTY;
        for (i, one) in boxes.iter().enumerate() {
            all.add_box(one);
            for axis in 0..2 {
                out.low[axis][i] = one.low[axis];
                out.high[axis][i] = one.high[axis];
            }
            out.nearest[i] = one.nearest;
            out.farthest[i] = one.farthest;
        }
        (out, all)
    }

    /// Returns box `i`.
    #[inline(always)]
    pub(super) fn get(&self, i: usize) -> FaceBox {
        FaceBox {
            low: Vec2::new(self.low[0][i], self.low[1][i]),
            high: Vec2::new(self.high[0][i], self.high[1][i]),
            nearest: self.nearest[i],
            farthest: self.farthest[i],
        }
    }

    /// Returns a bit for each box in which a caster may hide the light.
    #[inline(always)]
    pub(super) fn met_by(&self, caster: &Reach) -> u32 {
        let left = Vec4::splat(caster.low.x);
        let top = Vec4::splat(caster.low.y);
        let right = Vec4::splat(caster.high.x);
        let bottom = Vec4::splat(caster.high.y);
        let nearest = Vec4::splat(caster.nearest);
        let mut bits = 0;
        for first in (0..BOXES).step_by(LANES) {
            let across =
                four(&self.low[0], first).cmple(right) & four(&self.high[0], first).cmpge(left);
            let down =
                four(&self.low[1], first).cmple(bottom) & four(&self.high[1], first).cmpge(top);
            let deep = four(&self.farthest, first).cmpge(nearest);
            bits |= (across & down & deep).bitmask() << first;
        }
        bits
    }

    /// Tests each box against a caster's outline.
    #[inline(always)]
    pub(super) fn met_by_outline(&self, frame: &LightFrame, outline: &FaceOutline) -> ByOutline {
        let [across, down, summand] = outline.factors;
        let mut out = ByOutline::default();
        for first in (0..BOXES).step_by(LANES) {
            let at = |v: &Eight| four(v, first);
            let low = [at(&self.low[0]), at(&self.low[1])];
            let high = [at(&self.high[0]), at(&self.high[1])];
            // Find the maximum of a linear function in the box, or its minimum with negated
            // factors.
            let extreme = |edge: usize, sign: f32| {
                let [x, y] = [across[edge], down[edge]];
                let u = if x * sign > 0.0 { high[0] } else { low[0] };
                let v = if y * sign > 0.0 { high[1] } else { low[1] };
                Vec4::splat(summand[edge]) + u * x + v * y
            };
            let greatest = |edge: usize| extreme(edge, 1.0);
            let least = |edge: usize| extreme(edge, -1.0);
            // Test the edges.
            let mut met = greatest(0).cmpge(Vec4::NEG_ONE)
                & greatest(1).cmpge(Vec4::NEG_ONE)
                & greatest(2).cmpge(Vec4::NEG_ONE);
            // Test the plane's depth.
            if outline.knows_depth {
                let [near, far] = [least(3), greatest(3)];
                let nearest = frame.four_nearest_of_plane(near, far);
                met &= at(&self.farthest).cmpge(nearest);
                let inside = least(0).cmpgt(Vec4::ONE)
                    & least(1).cmpgt(Vec4::ONE)
                    & least(2).cmpgt(Vec4::ONE);
                let farthest = frame.four_farthest_of_plane(near, far);
                let covered = inside & at(&self.nearest).cmpgt(farthest);
                out.covered |= covered.bitmask() << first;
            }
            out.met |= met.bitmask() << first;
        }
        out
    }
}

/// Results of a caster's outline for eight boxes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ByOutline {
    /// Bits of the boxes that are partly inside the edges and extend behind the plane.
    pub(super) met: u32,
    /// Bits of the boxes whose rays are all surely blocked by the caster.
    pub(super) covered: u32,
}

#[inline(always)]
fn four(numbers: &Eight, first: usize) -> Vec4 {
    Vec4::from_slice(&numbers[first..first + LANES])
}
