//! Meshes of grids, for examples and tests.

use umbrage_surfaces::glam::DVec3;

/// A triangle mesh.
#[derive(Clone, Default)]
pub(crate) struct Mesh {
    pub(crate) vertices: Vec<DVec3>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// Adds a grid of squares, two triangles each. `place` returns the position of a corner, given
    /// its fractions of the columns and of the rows. The front has columns to the right and rows
    /// upwards, or the other way round if `is_turned`.
    pub(crate) fn add_grid(
        &mut self,
        squares: [u32; 2],
        is_turned: bool,
        place: impl Fn(f64, f64) -> DVec3,
    ) {
        let [columns, rows] = squares;
        let first = self.vertices.len() as u32;
        for j in 0..=rows {
            for i in 0..=columns {
                let across = f64::from(i) / f64::from(columns);
                self.vertices
                    .push(place(across, f64::from(j) / f64::from(rows)));
            }
        }
        for j in 0..rows {
            for i in 0..columns {
                let a = first + j * (columns + 1) + i;
                let c = a + columns + 2;
                let [b, d] = if is_turned {
                    [c - 1, a + 1]
                } else {
                    [a + 1, c - 1]
                };
                self.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }

    /// Adds the six sides of a box. `place` returns the position of a point of the unit cube.
    pub(crate) fn add_box(&mut self, squares: [u32; 3], place: impl Fn(DVec3) -> DVec3) {
        for axis in 0..3 {
            let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
            for end in [0.0, 1.0] {
                self.add_grid([squares[u], squares[v]], end == 0.0, |across, up| {
                    let mut p = DVec3::ZERO;
                    p[axis] = end;
                    p[u] = across;
                    p[v] = up;
                    place(p)
                });
            }
        }
    }
}
