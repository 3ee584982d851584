//! Alpha test of casters: a triangle does not hide points of the light whose rays pass it at a
//! transparent texel.
//!
//! `hidden.rs` finds the points that a triangle's outline covers, row by row. Those of an
//! alpha-tested triangle are then tested one by one, by the rule for rays (core's `cut_out.rs`).

use super::{
    hidden::{LANES, Seers, Shade, Words},
    lattice::Lattice,
};
use umbrage_core::{CutOuts, Module, glam::Vec3, module};

/// WGSL variant without alpha-tested casters.
pub(super) const NO_HOLES: Module = module!("soft_no_holes", "no_holes.wgsl");

/// The WGSL half.
pub(super) const HOLES: Module = module!("soft_holes", "holes.wgsl");

/// Alpha-tested triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leaf<'a> {
    pub(super) cut_outs: &'a CutOuts,
    pub(super) id: u32,
    pub(super) corners: [Vec3; 3],
}

impl<'a> Leaf<'a> {
    /// Returns an alpha-tested triangle; `None` if it is opaque.
    #[inline(always)]
    pub(super) fn new(cut_outs: Option<&'a CutOuts>, id: u32, corners: [Vec3; 3]) -> Option<Self> {
        let cut_outs = cut_outs?;
        cut_outs.record_row(id).map(|_| Self {
            cut_outs,
            id,
            corners,
        })
    }

    /// Hides the points of a row that the triangle hides. `shade` is the triangle's.
    pub(super) fn close<const LAMP: bool>(
        &self,
        shade: &Shade,
        seers: &Seers,
        lattice: &Lattice,
        row: usize,
        open: &mut Words,
    ) {
        let first = lattice.first_of(row);
        let covered = shade.covered_samples::<LAMP>(first);
        for lane in 0..LANES {
            let mut rest = covered[lane] & open[lane];
            while rest != 0 {
                let place = rest.trailing_zeros();
                rest &= rest - 1;
                let point = first + lattice.step * place as f32;
                let [o, d] = seers.ray(lane, point);
                if !self.cut_outs.is_hole(self.id, self.corners, o, d) {
                    open[lane] &= !(1 << place);
                }
            }
        }
    }
}
