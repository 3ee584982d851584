//! Runs of casters as projected to the light.

use super::{
    super::{
        light_frame::LightFrame,
        outline::{distance_to_origin, outline},
        touches::FaceBounds,
    },
    boxes::{Boxes, ByOutline, FaceBox, FaceOutline, Reach},
};
use std::ops::Range;
use umbrage_core::{
    Geometry, TRIANGLES_A_RUN,
    glam::{Vec2, Vec3, Vec4},
    math::{greater, lesser},
};

/// Number of casters of a run.
pub(super) const RUN: usize = TRIANGLES_A_RUN as usize;

/// Number of boxes up to which a caster's edges are not tested.
const FEW: u32 = 4;

/// Number of casters in a vector.
const LANES: usize = 4;

/// One value per caster of a run.
type OfEach<T> = [T; RUN];

/// Run of casters on a face.
pub(super) struct CasterRun {
    face: u32,
    first: u32,
    /// Corner coordinates by corner, axis and caster, in world space.
    corner: [[OfEach<f32>; 3]; 3],
    low: [OfEach<f32>; 2],
    high: [OfEach<f32>; 2],
    nearest: OfEach<f32>,
    /// Reach of all casters that project to the face.
    pub(super) reach: Reach,
    /// Bits of the casters that project to the face.
    shown: u64,
    /// Bits of the casters so near to a point light that their edges are meaningless.
    is_anywhere: u64,
    /// Bits of the alpha-tested casters.
    has_holes: u64,
    /// Bits of the casters whose outline is computed.
    has_outline: u64,
    outline: OfEach<FaceOutline>,
}

/// Returns the least value over all casters. It uses adjacent vectors, so that the loop is
/// vectorised.
#[inline(always)]
fn least(numbers: &OfEach<f32>) -> f32 {
    let mut out = Vec4::INFINITY;
    for first in (0..RUN).step_by(LANES) {
        out = out.min(Vec4::from_slice(&numbers[first..first + LANES]));
    }
    out.min_element()
}

/// Returns the greatest value over all casters.
#[inline(always)]
fn greatest(numbers: &OfEach<f32>) -> f32 {
    let mut out = Vec4::NEG_INFINITY;
    for first in (0..RUN).step_by(LANES) {
        out = out.max(Vec4::from_slice(&numbers[first..first + LANES]));
    }
    out.max_element()
}

impl CasterRun {
    pub(super) fn new() -> Self {
        Self {
            face: 0,
            first: 0,
            corner: [[[0.0; RUN]; 3]; 3],
            low: [[0.0; RUN]; 2],
            high: [[0.0; RUN]; 2],
            nearest: [0.0; RUN],
            reach: Reach::NOWHERE,
            shown: 0,
            is_anywhere: 0,
            has_holes: 0,
            has_outline: 0,
            outline: [FaceOutline::default(); RUN],
        }
    }

    /// Reads a run of a geometry, with at least one caster.
    #[inline(always)]
    pub(super) fn read(
        &mut self,
        frame: &LightFrame,
        geometry: &Geometry,
        face: u32,
        run: &Range<u32>,
    ) {
        self.face = face;
        self.first = run.start;
        self.shown = u64::MAX >> (RUN - run.len());
        self.is_anywhere = 0;
        self.has_outline = 0;
        self.has_holes = 0;
        // Mark alpha-tested casters.
        if geometry.cut_outs().is_some() {
            for (i, id) in run.clone().enumerate() {
                self.has_holes |= u64::from(geometry.has_holes(id)) << i;
            }
        }
        // Copy the corners.
        let triangles = geometry.run(run);
        let positions = geometry.positions();
        for (i, corners) in triangles.iter().enumerate() {
            for (of_corner, &vertex) in self.corner.iter_mut().zip(corners) {
                let position = positions[vertex as usize];
                of_corner[0][i] = position.x;
                of_corner[1][i] = position.y;
                of_corner[2][i] = position.z;
            }
        }
        // Project them to the face.
        if frame.is_lamp {
            self.place_around_lamp(frame, run.len());
        } else {
            self.place_under_sun(frame);
        }
        // Reset casters outside the face, whose entries may be from a previous run.
        for i in 0..RUN {
            if self.shown >> i & 1 == 0 {
                self.hide_from_all(i);
            }
        }
        self.reach = Reach {
            low: Vec2::new(least(&self.low[0]), least(&self.low[1])),
            high: Vec2::new(greatest(&self.high[0]), greatest(&self.high[1])),
            nearest: least(&self.nearest),
        };
    }

    /// Projects all casters for a directional light, like [`FaceBounds::under_sun`]. It avoids
    /// closures over arrays, which compilers don't inline, so that the loops are vectorised.
    #[inline(always)]
    fn place_under_sun(&mut self, frame: &LightFrame) {
        // Copy the frame, so that the loop's outputs can't alias it.
        let frame = *frame;
        let margin = frame.margin(0.0);
        let [a, b, c] = &self.corner;
        for i in 0..RUN {
            let a = frame.place_as::<false>(Vec3::new(a[0][i], a[1][i], a[2][i]));
            let b = frame.place_as::<false>(Vec3::new(b[0][i], b[1][i], b[2][i]));
            let c = frame.place_as::<false>(Vec3::new(c[0][i], c[1][i], c[2][i]));
            self.low[0][i] = lesser(a.x, lesser(b.x, c.x)) - margin;
            self.low[1][i] = lesser(a.y, lesser(b.y, c.y)) - margin;
            self.high[0][i] = greater(a.x, greater(b.x, c.x)) + margin;
            self.high[1][i] = greater(a.y, greater(b.y, c.y)) + margin;
            self.nearest[i] = frame.before_under_sun(lesser(a.z, lesser(b.z, c.z)));
        }
    }

    #[inline(always)]
    fn place_around_lamp(&mut self, frame: &LightFrame, count: usize) {
        for i in 0..count {
            let [a, b, c] = self.corners(i);
            let placed = [
                frame.place_as::<true>(a),
                frame.place_as::<true>(b),
                frame.place_as::<true>(c),
            ];
            let distance = distance_to_origin(placed);
            let margin = frame.margin(distance);
            if frame.is_at_lamp(distance) {
                self.is_anywhere |= 1 << i;
                self.set_reach(i, frame, &FaceBounds::ANYWHERE, margin);
            } else if let Some(bounds) = FaceBounds::on_cube(self.face, placed, margin) {
                self.set_reach(i, frame, &bounds, margin);
            } else {
                self.shown &= !(1 << i);
            }
        }
    }

    #[inline(always)]
    fn set_reach(&mut self, i: usize, frame: &LightFrame, bounds: &FaceBounds, margin: f32) {
        self.low[0][i] = bounds.low.x - margin;
        self.low[1][i] = bounds.low.y - margin;
        self.high[0][i] = bounds.high.x + margin;
        self.high[1][i] = bounds.high.y + margin;
        self.nearest[i] = frame.depth_before(bounds.nearest);
    }

    #[inline(always)]
    fn hide_from_all(&mut self, i: usize) {
        let nowhere = Reach::NOWHERE;
        self.low[0][i] = nowhere.low.x;
        self.low[1][i] = nowhere.low.y;
        self.high[0][i] = nowhere.high.x;
        self.high[1][i] = nowhere.high.y;
        self.nearest[i] = nowhere.nearest;
    }

    #[inline(always)]
    pub(super) fn reach_of(&self, i: usize) -> Reach {
        Reach {
            low: Vec2::new(self.low[0][i], self.low[1][i]),
            high: Vec2::new(self.high[0][i], self.high[1][i]),
            nearest: self.nearest[i],
        }
    }

    /// Returns a bit for each caster that projects to the face.
    #[inline(always)]
    pub(super) fn all(&self) -> u64 {
        self.shown
    }

    /// Returns the triangle id of caster `i`.
    #[inline(always)]
    pub(super) fn id(&self, i: usize) -> u32 {
        self.first + i as u32
    }

    /// Returns whether caster `i` is alpha-tested.
    #[inline(always)]
    pub(super) fn has_holes(&self, i: usize) -> bool {
        self.has_holes >> i & 1 == 1
    }

    /// Returns the corners of caster `i` in world space.
    #[inline(always)]
    pub(super) fn corners(&self, i: usize) -> [Vec3; 3] {
        let [a, b, c] = &self.corner;
        [
            Vec3::new(a[0][i], a[1][i], a[2][i]),
            Vec3::new(b[0][i], b[1][i], b[2][i]),
            Vec3::new(c[0][i], c[1][i], c[2][i]),
        ]
    }

    /// Returns which of eight boxes caster `i` may hide the light in, and in which it surely does.
    #[inline(always)]
    pub(super) fn meets(&mut self, frame: &LightFrame, i: usize, boxes: &Boxes) -> ByOutline {
        let met = boxes.met_by(&self.reach_of(i));
        if self.has_outline >> i & 1 == 0 {
            // Test edges only if they reject enough boxes now or later.
            if met.count_ones() <= FEW || self.is_anywhere >> i & 1 == 1 {
                return ByOutline { met, covered: 0 };
            }
            self.outline[i] = self.find_outline(frame, i);
            self.has_outline |= 1 << i;
        }
        let by_outline = boxes.met_by_outline(frame, &self.outline[i]);
        let covered = if self.has_holes(i) {
            0
        } else {
            met & by_outline.covered
        };
        ByOutline {
            met: met & by_outline.met,
            covered,
        }
    }

    #[inline(never)]
    fn find_outline(&self, frame: &LightFrame, i: usize) -> FaceOutline {
        let traits = outline(frame, self.corners(i).map(|p| frame.place(p)));
        FaceOutline {
            factors: traits.outline.on_face(frame.is_lamp, self.face),
            knows_depth: traits.knows_depth,
        }
    }

    /// Returns a bit for each caster that may hide the light in a box. Bits of casters outside the
    /// face are undefined.
    #[inline(always)]
    pub(super) fn meeting_bits(&self, bounds: &FaceBox) -> u64 {
        let left = Vec4::splat(bounds.low.x);
        let top = Vec4::splat(bounds.low.y);
        let right = Vec4::splat(bounds.high.x);
        let bottom = Vec4::splat(bounds.high.y);
        let farthest = Vec4::splat(bounds.farthest);
        let mut bits = 0;
        for first in (0..RUN).step_by(LANES) {
            let four = |v: &OfEach<f32>| Vec4::from_slice(&v[first..first + LANES]);
            let across = four(&self.low[0]).cmple(right) & four(&self.high[0]).cmpge(left);
            let down = four(&self.low[1]).cmple(bottom) & four(&self.high[1]).cmpge(top);
            let deep = four(&self.nearest).cmple(farthest);
            bits |= u64::from((across & down & deep).bitmask()) << first;
        }
        bits
    }
}
