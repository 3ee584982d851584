//! Points that are lit or not.

use crate::{Facets, FacetsError, Sides, facets::check_finite, morton, suns::unit};
use glam::DVec3;
use rayon::prelude::*;

/// Points whose values are in memory at once. They are computed in up to 256 tasks.
const BLOCK: usize = 1 << 14;
/// Points per task, at least.
const TASK: usize = 64;

/// Points, in the caller's coordinates, with unit normals or without. Rows keep the caller's order.
#[derive(Clone, Debug, Default)]
pub struct Points {
    /// Metres, relative to the anchor.
    pub(crate) positions: Vec<DVec3>,
    /// Anchor of the facets that these points were made for.
    pub(crate) anchor: DVec3,
    /// Unit normals; empty if light from both sides counts.
    pub(crate) normals: Vec<DVec3>,
    /// Rows in an order in which neighbours in space are neighbours.
    order: Vec<u32>,
}

impl Points {
    /// Returns points of a world of facets, in the same units and axes.
    ///
    /// `normals` may have any length. A point with a normal is dark if the sun is behind it.
    /// Without normals, light from both sides counts.
    ///
    /// # Errors
    /// Errors with the first row whose position or normal is not finite or whose normal is zero, if
    /// there are more or fewer normals than positions, or if a point is too far from the facets.
    pub fn new(
        facets: &Facets,
        positions: &[DVec3],
        normals: Option<&[DVec3]>,
    ) -> Result<Self, FacetsError> {
        let normals = normals.unwrap_or(&[]);
        if !normals.is_empty() && normals.len() != positions.len() {
            let why = format!("are {} for {} points", normals.len(), positions.len());
            return Err(FacetsError::new(
                "normals",
                why,
                "use one for each point, or none",
            ));
        }
        check_finite("point", positions)?;
        check_finite("normal", normals)?;
        let units: Vec<DVec3> = normals.iter().map(|&normal| unit(normal)).collect();
        if let Some(row) = units.iter().position(|&normal| normal == DVec3::ZERO) {
            let help = "pass a direction, or no normals for both sides";
            return Err(FacetsError::new(format!("normal {row}"), "is zero", help));
        }
        let positions: Vec<DVec3> = positions.iter().map(|&p| facets.to_local(p)).collect();
        facets.check_reach(&positions)?;
        Ok(Self::sorted(facets, positions, units))
    }

    /// Returns the centre of each facet. With [`Sides::Front`] it has the facet's normal, otherwise
    /// light from both sides counts. Facets without an area have no normal and count on both sides.
    pub fn centres_of(facets: &Facets) -> Self {
        let rows = 0..facets.count() as u32;
        let centre = |row| {
            let [a, b, c] = facets.local_corners(row);
            (a + b + c) / 3.0
        };
        let positions = rows.clone().map(centre).collect();
        let normals = match facets.options().sides {
            Sides::Front => rows.map(|row| facets.normal(row as usize)).collect(),
            Sides::Both => Vec::new(),
        };
        Self::sorted(facets, positions, normals)
    }

    fn sorted(facets: &Facets, positions: Vec<DVec3>, normals: Vec<DVec3>) -> Self {
        let low = positions.iter().fold(DVec3::INFINITY, |m, p| m.min(*p));
        let high = positions.iter().fold(DVec3::NEG_INFINITY, |m, p| m.max(*p));
        let scale = 1.0 / (high - low).max_element().max(f64::MIN_POSITIVE);
        let mut keys: Vec<(u64, u32)> = positions
            .par_iter()
            .enumerate()
            .map(|(row, p)| (morton::code_3d((*p - low) * scale), row as u32))
            .collect();
        keys.par_sort_unstable();
        Self {
            positions,
            anchor: facets.anchor,
            normals,
            order: keys.into_iter().map(|(_, row)| row).collect(),
        }
    }

    /// Computes a value for each point in parallel, and passes rows and values to `visit`, a block
    /// after another. Neighbours in space share memory. `progress` receives the number of computed
    /// points.
    pub(crate) fn visit_rows<M: Default, T: Send>(
        &self,
        compute: impl Fn(&mut M, usize) -> T + Send + Sync,
        mut visit: impl FnMut(usize, T),
        mut progress: impl FnMut(usize),
    ) {
        let mut computed = 0;
        for block in self.order.chunks(BLOCK) {
            let rows = block.par_iter().with_min_len(TASK);
            let values: Vec<T> = rows
                .map_init(M::default, |memory, &row| compute(memory, row as usize))
                .collect();
            for (&row, value) in block.iter().zip(values) {
                visit(row as usize, value);
            }
            computed += block.len();
            progress(computed);
        }
    }

    /// Returns the number of points.
    pub fn count(&self) -> usize {
        self.positions.len()
    }
}
