//! Alpha-tested triangles: one rule for rays and pixels.
//!
//! A segment's line meets a triangle's plane at a point. The point's barycentric coordinates are
//! the areas of the triangle test (`ray_triangle.rs`) over their sum. They determine the point's
//! uv, and the uv determines its nearest texel (textures repeat). One bit per texel is set unless
//! its alpha is less than the material's cut-off. A clear bit is a hole: the segment passes
//! through.
//!
//! Pixels use the same test, along the ray through the pixel's centre ([`CameraRays`]). Rasteriser
//! interpolation therefore has no influence. CPU, GPU and truth have bit-equal holes, if the driver
//! evaluates WGSL arithmetic as written.
//!
//! Both backends use the same table, with rows of four words:
//!
//! * Row 0: the two runs of alpha-tested triangles, as first, end, first, end.
//! * Two rows per alpha-tested triangle, in the order of ids. They contain the uvs of its corners
//!   as x, y, x, y and x, y; width and height of its texture (the lower and the upper 16 bits of a
//!   word); and the row at which the texture begins.
//! * Textures: one bit a texel, in rows from the top, lowest bits first; 1 for opaque texels. Each
//!   texture begins with a row of the table.
//!
//! `Geometry::bake` sorts triangles so that alpha-tested ones are adjacent. A geometry without them
//! has no table, and uses the code and shaders of opaque casters. `umbrage-cpu` has a separate test
//! in `raster/holes.rs` in addition to `NoHoles`. `umbrage-wgpu` has separate pipelines for the two
//! runs. `traced`, `exact` and `soft` have separate caster tests. Techniques that treat casters as
//! opaque reject alpha-tested ones (`check_no_holes`).
//!
//! Images may use the test in `hashed_alpha.rs` instead if their pixels are larger than texels;
//! rays and truth don't.

use crate::{
    gbuffer::resolve::at_pixel,
    geometry::{
        hashed_alpha::{Coverage, CoverageBuilder, Levels, squared_footprint},
        placed::PlacedMeshes,
        ray_triangle::{Corners, Segment},
    },
    invalid::Invalid,
    recipe::shader::Module,
    scene::{
        Scene,
        camera::CameraRays,
        material::{AlphaCutout, AlphaFilter, Texture},
    },
};
use glam::{UVec2, Vec2, Vec3, Vec4};
use std::{collections::BTreeMap, ops::Range, sync::Arc};
#[cfg(feature = "rays")]
use {crate::geometry::ray_triangle::volumes_in_f64, glam::DVec2};

/// The WGSL half. It calls [`RAY_BOX`](super::bvh::RAY_BOX) and
/// [`RAY_TRIANGLE`](super::bvh::RAY_TRIANGLE).
pub const CUT_OUT: Module = crate::module!("cut_out");

/// The WGSL of [`CutOuts::is_hole`]. It calls [`CUT_OUT`] and `fn cut_out_row(i: u32) -> vec4u`,
/// which the shader that binds the table must declare.
pub const HOLE: Module = crate::module!("hole");

/// Greatest side of an alpha texture, texels: the range of 16 bits.
pub const MAX_ALPHA_SIDE: u32 = 65_535;

/// Texels per row of the table.
const TEXELS_A_ROW: u32 = 128;

/// Floats from here on are whole numbers.
pub(super) const WHOLE_NUMBERS: f32 = 8_388_608.0;

/// The alpha-tested triangles of a [`Geometry`](crate::Geometry).
#[derive(Clone, Debug, PartialEq)]
pub struct CutOuts {
    /// Ids of the alpha-tested triangles: rising and disjoint. Either may be empty.
    runs: [Range<u32>; 2],
    /// The table.
    rows: Arc<[[u32; 4]]>,
    /// Mipmapped coverages of textures; `None` if no material uses them.
    coverage: Option<Coverage>,
}

/// Table record of one triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Record {
    uvs: [Vec2; 3],
    /// Size of the texture, texels.
    size: UVec2,
    /// The row at which the texture begins.
    first_row: u32,
}

impl Record {
    fn read(first: [u32; 4], second: [u32; 4]) -> Self {
        let uv = |x: u32, y: u32| Vec2::new(f32::from_bits(x), f32::from_bits(y));
        Self {
            uvs: [
                uv(first[0], first[1]),
                uv(first[2], first[3]),
                uv(second[0], second[1]),
            ],
            size: UVec2::new(second[2] & 0xffff, second[2] >> 16),
            first_row: second[3],
        }
    }

    #[inline(always)]
    fn uv_met(&self, segment: &Segment, corners: &Corners) -> Vec2 {
        let [a, b, c] = self.uvs;
        uv_met(segment, corners, Vec4::new(a.x, a.y, b.x, b.y), c)
    }

    fn rows(&self) -> [[u32; 4]; 2] {
        let [a, b, c] = self.uvs.map(|uv| [uv.x.to_bits(), uv.y.to_bits()]);
        let size = self.size.x | self.size.y << 16;
        [[a[0], a[1], b[0], b[1]], [c[0], c[1], size, self.first_row]]
    }
}

/// Returns the ray through a pixel's centre.
#[inline(always)]
fn pixel_ray(rays: &CameraRays, x: u32, y: u32) -> Segment {
    let o = at_pixel(rays.origin, rays.origin_dx, rays.origin_dy, x, y);
    let d = at_pixel(rays.dir, rays.dir_dx, rays.dir_dy, x, y);
    Segment::new(o, d)
}

/// Returns the texel, among `n` along one axis, that contains a texture coordinate. Numbers that
/// are not finite have fraction 0, as whole numbers do.
#[inline(always)]
pub(super) fn nearest_texel(t: f32, n: u32) -> u32 {
    if t.abs() < WHOLE_NUMBERS {
        let part = t - t.floor();
        // The fraction of a tiny negative number rounds to 1, and the product may round to n.
        ((part * n as f32) as u32).min(n.wrapping_sub(1))
    } else {
        0
    }
}

/// Returns the uv at which a segment's line meets a triangle's plane. `uv_ab` are the uvs of
/// corners a and b. Not finite if the segment is parallel to the plane.
#[inline(always)]
pub(super) fn uv_met(segment: &Segment, corners: &Corners, uv_ab: Vec4, uv_c: Vec2) -> Vec2 {
    let areas = segment.areas(corners);
    let whole = areas.x + areas.y + areas.z;
    // Add from left to right, as in the twin.
    let across = (uv_ab.x * areas.x + uv_ab.z * areas.y + uv_c.x * areas.z) / whole;
    let down = (uv_ab.y * areas.x + uv_ab.w * areas.y + uv_c.y * areas.z) / whole;
    Vec2::new(across, down)
}

/// Returns the index of the texel nearest to a uv in a texture of this size; 0 along an axis where
/// the uv is not finite.
#[inline(always)]
pub(super) fn texel_at(uv: Vec2, size: UVec2) -> u32 {
    nearest_texel(uv.y, size.y)
        .wrapping_mul(size.x)
        .wrapping_add(nearest_texel(uv.x, size.x))
}

impl CutOuts {
    /// Returns the table, for shaders.
    pub fn rows(&self) -> &Arc<[[u32; 4]]> {
        &self.rows
    }

    /// Returns the ids of the alpha-tested triangles: two rising runs; either may be empty.
    pub fn runs(&self) -> &[Range<u32>; 2] {
        &self.runs
    }

    /// Splits rising runs of triangles into opaque and alpha-tested parts: rising, none empty.
    pub fn split(&self, runs: &[Range<u32>]) -> [Vec<Range<u32>>; 2] {
        let mut whole = Vec::new();
        let mut cut_out = Vec::new();
        for run in runs {
            let mut start = run.start;
            for holes in &self.runs {
                let from = holes.start.clamp(start, run.end);
                let to = holes.end.clamp(from, run.end);
                whole.push(start..from);
                cut_out.push(from..to);
                start = to;
            }
            whole.push(start..run.end);
        }
        [whole, cut_out].map(|runs| runs.into_iter().filter(|run| !run.is_empty()).collect())
    }

    /// Returns the row at which a triangle's record begins; `None` if it is opaque.
    #[inline]
    pub fn record_row(&self, triangle: u32) -> Option<u32> {
        let [first, second] = &self.runs;
        if first.contains(&triangle) {
            Some(1 + 2 * (triangle - first.start))
        } else if second.contains(&triangle) {
            Some(1 + 2 * (triangle - second.start + first.len() as u32))
        } else {
            None
        }
    }

    /// Returns whether the line of the segment from `o` to `o + d` meets a hole of a triangle,
    /// given its corners. False for opaque triangles.
    pub fn is_hole(&self, triangle: u32, corners: [Vec3; 3], o: Vec3, d: Vec3) -> bool {
        self.is_hole_met(triangle, &Corners::new(corners), &Segment::new(o, d))
    }

    /// [`is_hole`](Self::is_hole) with precomputed arguments, for many tests.
    pub(crate) fn is_hole_met(&self, triangle: u32, corners: &Corners, segment: &Segment) -> bool {
        let Some(record) = self.record(triangle) else {
            return false;
        };
        let uv = record.uv_met(segment, corners);
        self.is_clear(&record, texel_at(uv, record.size))
    }

    /// Returns the result of [`is_hole`](Self::is_hole) with the uv interpolated in 64 bits, for
    /// triangles so large that its rounding in 32 bits exceeds a texel. It has no twin.
    #[cfg(feature = "rays")]
    pub(crate) fn is_hole_in_f64(
        &self,
        triangle: u32,
        corners: [Vec3; 3],
        o: Vec3,
        d: Vec3,
    ) -> bool {
        let Some(record) = self.record(triangle) else {
            return false;
        };
        let weights = volumes_in_f64(o, d, corners);
        let whole: f64 = weights.iter().sum();
        let weighted = record.uvs.iter().zip(weights);
        let uv: DVec2 = weighted.map(|(uv, weight)| uv.as_dvec2() * weight).sum();
        // Keep the fraction, which 32 bits hold to a part of a texel: textures repeat. It may not
        // round to 1, which is the first texel.
        let fraction = (uv / whole).map(|t| t - t.floor()).as_vec2();
        let below_one = Vec2::splat(1.0 - 0.5 * f32::EPSILON);
        self.is_clear(&record, texel_at(fraction.min(below_one), record.size))
    }

    /// Returns whether the ray through a pixel's centre meets a hole of a triangle, given its
    /// corners. `rays` are those of the pixels' image, a camera's or a map's. If the material's
    /// [`AlphaFilter`] requests it, the alpha depends on the pixel's footprint on the texture;
    /// otherwise the result is that of [`is_hole`](Self::is_hole).
    pub fn is_hole_at_pixel(
        &self,
        triangle: u32,
        corners: [Vec3; 3],
        rays: &CameraRays,
        x: u32,
        y: u32,
    ) -> bool {
        let corners = Corners::new(corners);
        let segment = pixel_ray(rays, x, y);
        let Some(levels) = self.levels_of(triangle) else {
            return self.is_hole_met(triangle, &corners, &segment);
        };
        let Some(record) = self.record(triangle) else {
            return false;
        };
        let uv = record.uv_met(&segment, &corners);
        let right = record.uv_met(&pixel_ray(rays, x.wrapping_add(1), y), &corners);
        let below = record.uv_met(&pixel_ray(rays, x, y.wrapping_add(1)), &corners);
        let squared = squared_footprint(uv, right, below, record.size);
        // Also false for NaN.
        if squared > 1.0 {
            let is_clear = |texel| self.is_clear(&record, texel);
            levels.is_hole(uv, squared, triangle, is_clear)
        } else {
            self.is_clear(&record, texel_at(uv, record.size))
        }
    }

    /// Returns the table of mipmapped coverages, for shaders; `None` if no material's
    /// [`AlphaFilter`] requests it.
    pub fn coverage_rows(&self) -> Option<&Arc<[[u32; 4]]>> {
        self.coverage.as_ref().map(Coverage::rows)
    }

    /// Returns the mipmap levels of a triangle's texture; `None` if it is opaque or doesn't use
    /// hashed alpha.
    fn levels_of(&self, triangle: u32) -> Option<Levels<'_>> {
        let coverage = self.coverage.as_ref()?;
        let record = (self.record_row(triangle)? - 1) / 2;
        coverage.levels_of(record)
    }

    fn record(&self, triangle: u32) -> Option<Record> {
        let row = self.record_row(triangle)? as usize;
        Some(Record::read(self.rows[row], self.rows[row + 1]))
    }

    fn is_clear(&self, record: &Record, texel: u32) -> bool {
        let row = self.rows[(record.first_row + texel / TEXELS_A_ROW) as usize];
        let word = row[(texel / 32 % 4) as usize];
        word >> (texel % 32) & 1 == 0
    }

    /// Classifies the texels of a triangle in the box around some uvs: `Some(true)` if all are
    /// holes, `Some(false)` if none is or the triangle is opaque. `None` if there are both, or too
    /// many texels to test. `weights` are barycentric coordinates of points of the triangle.
    pub fn is_hole_around(&self, triangle: u32, weights: &[[f64; 3]]) -> Option<bool> {
        const MAX_TEXELS: f64 = 4096.0;
        let Some(record) = self.record(triangle) else {
            return Some(false);
        };
        // Find the box around the uvs, in texels.
        let uvs = record.uvs.map(|uv| uv.as_dvec2());
        let size = record.size.as_dvec2();
        let mut low = glam::DVec2::INFINITY;
        let mut high = glam::DVec2::NEG_INFINITY;
        for &[u, v, w] in weights {
            let place = (uvs[0] * u + uvs[1] * v + uvs[2] * w) * size;
            low = low.min(place);
            high = high.max(place);
        }
        // Rounding of a uv in 32 bits, texels.
        let rounding = 8.0 * f64::from(f32::EPSILON) * (size + low.abs().max(high.abs()));
        let low = (low - rounding).floor();
        let high = (high + rounding).floor();
        let count = high - low + 1.0;
        let is_near = low.abs().max(high.abs()).max_element() < f64::from(WHOLE_NUMBERS);
        if !is_near || count.element_product() > MAX_TEXELS {
            return None;
        }
        // Compare all texels in the box.
        let first = low.as_i64vec2();
        let last = high.as_i64vec2();
        let size = record.size.as_i64vec2();
        let mut found = None;
        for y in first.y..=last.y {
            for x in first.x..=last.x {
                let texel = y.rem_euclid(size.y) * size.x + x.rem_euclid(size.x);
                let is_clear = self.is_clear(&record, texel as u32);
                if found.is_some_and(|known| known != is_clear) {
                    return None;
                }
                found = Some(is_clear);
            }
        }
        found
    }

    /// Builds the table of these runs of placed triangles; `None` if they are empty.
    ///
    /// # Errors
    /// Errors if a texture is too large.
    pub(super) fn new(
        scene: &Scene,
        placed: &PlacedMeshes,
        runs: [Range<u32>; 2],
    ) -> Result<Option<Arc<Self>>, Invalid> {
        let count = runs[0].len() + runs[1].len();
        if count == 0 {
            return Ok(None);
        }
        // Reserve the header and the records.
        let header = [runs[0].start, runs[0].end, runs[1].start, runs[1].end];
        let mut rows = vec![header];
        rows.resize(1 + 2 * count, [0; 4]);
        // The first row of each texture, for each cut-off used with it.
        let mut places: BTreeMap<(usize, u32), u32> = BTreeMap::new();
        let mut coverage = CoverageBuilder::new(count);
        for (k, id) in runs.iter().cloned().flatten().enumerate() {
            let Some(alpha) = alpha_of(scene, placed.materials.get(id as usize)) else {
                continue;
            };
            let texture = &scene.textures[alpha.texture];
            let key = (alpha.texture, alpha.cutoff.to_bits());
            let first_row = match places.get(&key) {
                Some(&row) => row,
                None => {
                    let row = append_texture(&mut rows, texture, &alpha)?;
                    places.insert(key, row);
                    row
                }
            };
            // Write the record of the triangle.
            let record = Record {
                uvs: placed.triangles[id as usize].map(|v| placed.uvs[v as usize]),
                size: texture.size,
                first_row,
            };
            rows[1 + 2 * k..3 + 2 * k].copy_from_slice(&record.rows());
            if alpha.filter == AlphaFilter::Hashed {
                coverage.add(k, key, texture);
            }
        }
        Ok(Some(Arc::new(Self {
            runs,
            rows: rows.into(),
            coverage: coverage.finish()?,
        })))
    }

    /// Restores alpha-tested triangles from a table and a table of coverages, for a geometry with
    /// this number of triangles. `None` if the table is empty.
    ///
    /// # Errors
    /// Errors if they are not tables as returned by [`CutOuts::rows`] and
    /// [`CutOuts::coverage_rows`].
    #[cfg(feature = "serde")]
    pub(super) fn from_rows(
        rows: &[[u32; 4]],
        coverage_rows: &[[u32; 4]],
        triangles: usize,
    ) -> Result<Option<Arc<Self>>, Invalid> {
        let Some(&[first, first_end, second, second_end]) = rows.first() else {
            return Ok(None);
        };
        let bad = |why: &str| Err(Invalid::new("geometry's cut-outs", why, "write it again"));
        let rise = first <= first_end && first_end <= second && second <= second_end;
        if !rise || second_end as usize > triangles {
            return bad("refer to triangles that don't exist");
        }
        let runs = [first..first_end, second..second_end];
        let records = runs[0].len() + runs[1].len();
        if rows.len() < 1 + 2 * records {
            return bad("are shorter than their list of triangles");
        }
        let mut sizes = Vec::with_capacity(records);
        for pair in rows[1..1 + 2 * records].chunks_exact(2) {
            let record = Record::read(pair[0], pair[1]);
            sizes.push(record.size);
            let texels = u64::from(record.size.x) * u64::from(record.size.y);
            let end = u64::from(record.first_row) + texels.div_ceil(u64::from(TEXELS_A_ROW));
            if texels == 0 || end > rows.len() as u64 {
                return bad("have a texture without texels or beyond the end of the table");
            }
        }
        Ok(Some(Arc::new(Self {
            runs,
            rows: rows.into(),
            coverage: Coverage::from_rows(coverage_rows, &sizes)?,
        })))
    }
}

/// Returns the alpha test of a material, given its index in the scene's list.
fn alpha_of(scene: &Scene, material: Option<&u32>) -> Option<AlphaCutout> {
    let material = scene.materials.get(*material? as usize)?;
    material.alpha
}

/// Appends a texture's bits, and returns the row at which they begin.
fn append_texture(
    rows: &mut Vec<[u32; 4]>,
    texture: &Texture,
    alpha: &AlphaCutout,
) -> Result<u32, Invalid> {
    if texture.size.max_element() > MAX_ALPHA_SIDE {
        let why = format!("is {} x {} texels", texture.size.x, texture.size.y);
        let help =
            format!("use at most {MAX_ALPHA_SIDE} on each side where it is an alpha texture");
        return Err(Invalid::new(
            format!("texture `{}`", texture.name),
            why,
            help,
        ));
    }
    let first_row = rows.len();
    let count = texture.texels.len();
    for first in (0..count).step_by(TEXELS_A_ROW as usize) {
        let end = count.min(first + TEXELS_A_ROW as usize);
        let mut row = [0; 4];
        for (bit, i) in (first..end).enumerate() {
            let is_there = alpha.is_there(&texture.texels.get(i));
            row[bit / 32] |= u32::from(is_there) << (bit % 32);
        }
        rows.push(row);
    }
    u32::try_from(first_row).map_err(|_| {
        Invalid::new(
            "alpha textures",
            "have more texels than fit in a table",
            "use smaller textures",
        )
    })
}

/// The twins, for the lockstep tests.
#[cfg(feature = "testing")]
pub const TWINS: &[crate::recipe::twin::Twin] = &[
    crate::twin!(CUT_OUT, nearest_texel(t: f32, n: u32) -> u32,
        needs [super::ray_box::RAY_BOX, super::ray_triangle::RAY_TRIANGLE]),
    crate::twin!(CUT_OUT, cut_out_texel(o: Vec3, d: Vec3, a: Vec3, b: Vec3, c: Vec3, uv_ab: Vec4, uv_c: Vec2, size: UVec2) -> u32,
        needs [super::ray_box::RAY_BOX, super::ray_triangle::RAY_TRIANGLE]),
];

#[cfg(feature = "testing")]
#[expect(clippy::too_many_arguments, reason = "the twin's are as many")]
fn cut_out_texel(
    o: Vec3,
    d: Vec3,
    a: Vec3,
    b: Vec3,
    c: Vec3,
    uv_ab: Vec4,
    uv_c: Vec2,
    size: UVec2,
) -> u32 {
    let uv = uv_met(&Segment::new(o, d), &Corners::new([a, b, c]), uv_ab, uv_c);
    texel_at(uv, size)
}

#[cfg(test)]
#[path = "cut_out_tests.rs"]
mod tests;
