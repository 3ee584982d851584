//! Visible surface points, one per pixel.

use crate::invalid::Invalid;
use crate::parallel::prelude::*;
use glam::{UVec2, Vec3};
use std::ops::Range;

/// Triangle id of an empty pixel.
pub const NO_TRIANGLE: u32 = u32::MAX;

/// Visible surface points, rows from the top. Each component has its own array, so that kernels can
/// process a row at a time. All arrays have `width * height` entries.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Receivers {
    /// Image size, pixels.
    pub size: UVec2,
    /// World position x, metres; 0 in empty pixels, as in all other fields.
    pub x: Vec<f32>,
    /// World position y.
    pub y: Vec<f32>,
    /// World position z.
    pub z: Vec<f32>,
    /// Geometric unit normal x, turned to the camera.
    pub nx: Vec<f32>,
    /// Geometric normal y.
    pub ny: Vec<f32>,
    /// Geometric normal z.
    pub nz: Vec<f32>,
    /// Interpolated unit shading normals, turned to the camera; empty if not requested.
    pub shading_normals: Vec<Vec3>,
    /// Camera depth after projection, 0 near to 1 far; 1 in empty pixels.
    pub depth: Vec<f32>,
    /// Distance along the unit ray from the eye, metres; for an orthographic camera, from the near
    /// plane.
    pub distance: Vec<f32>,
    /// Triangle id; [`NO_TRIANGLE`] in empty pixels.
    pub triangle: Vec<u32>,
    /// True if the pixel shows a surface that receives shadows.
    pub receives: Vec<bool>,
}

impl Receivers {
    /// Returns an image of empty pixels.
    pub fn empty(size: UVec2) -> Self {
        let pixels = size.x as usize * size.y as usize;
        let zeros = vec![0.0; pixels];
        Self {
            size,
            x: zeros.clone(),
            y: zeros.clone(),
            z: zeros.clone(),
            nx: zeros.clone(),
            ny: zeros.clone(),
            nz: zeros.clone(),
            shading_normals: Vec::new(),
            depth: vec![1.0; pixels],
            distance: zeros,
            triangle: vec![NO_TRIANGLE; pixels],
            receives: vec![false; pixels],
        }
    }

    /// Checks that kernels can read the receivers.
    ///
    /// # Errors
    /// Errors with the first fault found: an array whose length is not the number of pixels, or a
    /// number that is not finite. Positions and normals must be finite at pixels that receive
    /// shadows.
    pub fn validate(&self) -> Result<(), Invalid> {
        let pixels = self.size.x as usize * self.size.y as usize;
        // Check the lengths of the arrays.
        let lengths = [
            self.x.len(),
            self.y.len(),
            self.z.len(),
            self.nx.len(),
            self.ny.len(),
            self.nz.len(),
            self.triangle.len(),
            self.receives.len(),
        ];
        if lengths.iter().any(|&length| length != pixels) {
            let why = format!(
                "are for an image of {} x {} pixels, but an array has another length",
                self.size.x, self.size.y
            );
            return Err(Invalid::new(
                "receivers",
                why,
                format!("give every array {pixels} entries"),
            ));
        }
        // Find the first number that is not finite, row by row.
        let width = (self.size.x as usize).max(1);
        let fault = (0..pixels / width)
            .into_par_iter()
            .filter(|row| !self.is_finite_within(row * width..(row + 1) * width))
            .find_map_first(|row| {
                (row * width..(row + 1) * width).find(|&i| !self.is_finite_within(i..i + 1))
            });
        let Some(i) = fault else {
            return Ok(());
        };
        let column = i as u32 % self.size.x;
        let row = i as u32 / self.size.x;
        let what = format!("receiver at pixel ({column}, {row})");
        let why = format!("is {} with the normal {}", self.position(i), self.normal(i));
        let help = "use finite numbers, or set `receives` to false for this pixel";
        Err(Invalid::new(what, why, help))
    }

    /// Returns whether positions and normals are finite at all pixels of a range that receive
    /// shadows.
    fn is_finite_within(&self, pixels: Range<usize>) -> bool {
        let count = pixels.len();
        // Use slices of equal length and no early return, so that the loop is vectorised.
        let [x, y, z] = [&self.x, &self.y, &self.z].map(|all| &all[pixels.clone()][..count]);
        let [nx, ny, nz] = [&self.nx, &self.ny, &self.nz].map(|all| &all[pixels.clone()][..count]);
        let receives = &self.receives[pixels.clone()][..count];
        let mut is_faulty = false;
        for i in 0..count {
            let is_finite = (x[i] + nx[i]).is_finite()
                & (y[i] + ny[i]).is_finite()
                & (z[i] + nz[i]).is_finite();
            is_faulty |= receives[i] & !is_finite;
        }
        !is_faulty
    }

    /// Returns the number of pixels.
    pub fn len(&self) -> usize {
        self.triangle.len()
    }

    /// Returns whether the image has no pixels.
    pub fn is_empty(&self) -> bool {
        self.triangle.is_empty()
    }

    /// Returns the world position of a pixel.
    pub fn position(&self, i: usize) -> Vec3 {
        Vec3::new(self.x[i], self.y[i], self.z[i])
    }

    /// Returns the geometric unit normal of a pixel, turned to the camera.
    pub fn normal(&self, i: usize) -> Vec3 {
        Vec3::new(self.nx[i], self.ny[i], self.nz[i])
    }

    /// Returns the world positions of all pixels that receive shadows.
    pub fn positions(&self) -> impl Iterator<Item = Vec3> + '_ {
        (0..self.len())
            .filter(|&i| self.receives[i])
            .map(|i| self.position(i))
    }

    /// Returns the pixels `first..first + count`, which must be in one row.
    pub fn span(&self, first: usize, count: usize) -> Span<'_> {
        let width = self.size.x as usize;
        let range = first..first + count;
        Span {
            first: UVec2::new((first % width) as u32, (first / width) as u32),
            x: &self.x[range.clone()],
            y: &self.y[range.clone()],
            z: &self.z[range.clone()],
            nx: &self.nx[range.clone()],
            ny: &self.ny[range.clone()],
            nz: &self.nz[range.clone()],
            triangle: &self.triangle[range],
        }
    }
}

/// Part of a row of [`Receivers`]: the input of a receive kernel's Rust half. All slices have the
/// same length. Empty pixels are included, with zeros; the kernel's output for them is discarded.
#[derive(Clone, Copy, Debug)]
pub struct Span<'a> {
    /// Pixel coordinates of the first entry; the others follow to its right.
    pub first: UVec2,
    /// World position x.
    pub x: &'a [f32],
    /// World position y.
    pub y: &'a [f32],
    /// World position z.
    pub z: &'a [f32],
    /// Geometric unit normal x.
    pub nx: &'a [f32],
    /// Geometric unit normal y.
    pub ny: &'a [f32],
    /// Geometric unit normal z.
    pub nz: &'a [f32],
    /// Triangle id, [`NO_TRIANGLE`] in empty pixels.
    pub triangle: &'a [u32],
}

impl Span<'_> {
    /// Returns the number of pixels.
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// Returns whether there are no pixels.
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// Returns the world position of a pixel.
    #[inline(always)]
    pub fn position(&self, i: usize) -> Vec3 {
        Vec3::new(self.x[i], self.y[i], self.z[i])
    }

    /// Returns the geometric unit normal of a pixel.
    #[inline(always)]
    pub fn normal(&self, i: usize) -> Vec3 {
        Vec3::new(self.nx[i], self.ny[i], self.nz[i])
    }
}
