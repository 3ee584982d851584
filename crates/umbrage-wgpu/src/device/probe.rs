//! Probe of a rasteriser's vertex rounding, which no graphics API reports completely.
//!
//! Draws one small image (`probe.wgsl`) and reads it back. It contains 64 triangles whose right
//! edges start at 64 positions over an eighth of a pixel, between two points that belong to every
//! grid. The row in which an edge crosses its column of pixel centres shows the snapped position of
//! its upper end, to a thousandth of a pixel. The number of different positions shows the grid
//! step.

use crate::{
    device::{
        probe_image::{draw_and_read, record_draw},
        probe_offset::probe_offset_unit,
    },
    resources::pipelines::{Targets, fullscreen_pipeline},
};
use glam::DVec2;
use umbrage_core::{BackendError, DepthPlanes, Snapping};
use wgpu::{Device, Queue, TextureFormat};

/// Number of triangles, from left to right.
const STRIPS: usize = 64;
/// Width of each triangle's part of the image, pixels.
const STRIP: usize = 4;
/// Height of the image, pixels.
const ROWS: usize = 512;

/// Draws triangles on a device and returns the vertex rounding of its rasteriser. Takes a few
/// milliseconds.
///
/// # Errors
/// Errors if the device fails.
pub fn probe_snapping(device: &Device, queue: &Queue) -> Result<Snapping, BackendError> {
    let depths = draw(device, queue)?;
    let snapping = snapping_of_image(&depths);
    let offset_unit = probe_offset_unit(device, queue)?;
    Ok(Snapping {
        offset_unit,
        ..snapping
    })
}

/// Returns the depths of the triangles' pixels, 0 elsewhere, row by row.
fn draw(device: &Device, queue: &Queue) -> Result<Vec<f32>, BackendError> {
    let label = "umbrage probe";
    let format = TextureFormat::R32Float;
    let pipeline = fullscreen_pipeline(
        device,
        label,
        include_str!("probe.wgsl"),
        ["place", "depth"],
        &Targets::Colors(&[format]),
        &[],
    );
    let size = [(STRIPS * STRIP) as u32, ROWS as u32];
    draw_and_read(device, queue, label, size, format, |encoder, view| {
        record_draw(encoder, view, &pipeline, 3 * STRIPS as u32);
    })
}

/// Returns the rounding of vertices and planes in the image. An image that matches no known
/// rounding counts as the coarsest.
fn snapping_of_image(depths: &[f32]) -> Snapping {
    let rows: Vec<usize> = (0..STRIPS)
        .map(|strip| rows_right_of_centers(depths, strip))
        .collect();
    if rows.contains(&0) {
        return Snapping::COARSEST;
    }
    let mut distinct = rows.clone();
    distinct.sort_unstable();
    distinct.dedup();
    // An eighth of a pixel is 2^(bits - 3) steps. Rounding to nearest reaches the points at both
    // ends, which is one more position than there are steps; rounding down doesn't.
    let bits = distinct.len().ilog2() + 3;
    let unsnapped = Snapping {
        sub_pixel_bits: bits.clamp(*Snapping::BITS.start(), *Snapping::BITS.end()),
        ..Snapping::default()
    };
    // Sums of the squared errors of both rules for depth planes.
    let mut unsnapped_error = 0.0;
    let mut snapped_error = 0.0;
    let step = f64::from(unsnapped.step());
    for (strip, &rows) in rows.iter().enumerate() {
        let drawn = f64::from(depths[strip * STRIP + 2]);
        let snapped_edge = (upper_end(rows) / step).round() * step;
        unsnapped_error += (neighbouring_depth(edge_start(strip)) - drawn).powi(2);
        snapped_error += (neighbouring_depth(snapped_edge) - drawn).powi(2);
    }
    let planes = if snapped_error < unsnapped_error {
        DepthPlanes::Snapped
    } else {
        DepthPlanes::Unsnapped
    };
    Snapping {
        planes,
        ..unsnapped
    }
}

/// Returns the start of a triangle's right edge, pixels right of the grid point.
fn edge_start(strip: usize) -> f64 {
    (strip as f64 + 0.5) / 512.0
}

/// Returns the number of bottom rows of the image in which a triangle's right edge is right of its
/// column of pixel centres. Returns 0 if the triangle covers no pixel there.
fn rows_right_of_centers(depths: &[f32], strip: usize) -> usize {
    let column = strip * STRIP + 3;
    let first = (0..ROWS).find(|row| depths[row * STRIPS * STRIP + column] > 0.0);
    ROWS - first.unwrap_or(ROWS)
}

/// Returns the start of an edge, pixels right of the grid point, given the number of rows in which
/// it is right of its column's centres. The grid point is a quarter pixel left of the centres, the
/// edge's lower end an eighth right of them. By similar triangles,
/// `rows : ROWS = 1/8 : 3/8 - start`.
fn upper_end(rows: usize) -> f64 {
    0.375 - 0.125 * ROWS as f64 / rows as f64
}

/// Returns the depth of a triangle's plane at the first row's pixel left of the column. `start` is
/// the start of the triangle's right edge, pixels right of the grid point. Coordinates are relative
/// to the column's centres and the image's upper edge.
fn neighbouring_depth(start: f64) -> f64 {
    // Upper and lower end of the right edge, which have the same depth, and the left corner.
    let upper = DVec2::new(start - 0.25, 0.0);
    let lower = DVec2::new(0.125, ROWS as f64);
    let left = DVec2::new(-3.0, 0.0);
    let edge_depth = 0.25;
    let left_depth = 0.75;
    let pixel = DVec2::new(-1.0, 0.5);
    // Barycentric weight of the left corner.
    let weight = twice_area(upper, lower, pixel) / twice_area(upper, lower, left);
    edge_depth + (left_depth - edge_depth) * weight
}

/// Returns twice the signed area of a triangle.
fn twice_area(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the image of a device that rounds the upper ends of edges with `edge`, and those of
    /// depth planes with `plane`.
    fn image(edge: impl Fn(f64) -> f64, plane: impl Fn(f64) -> f64) -> Vec<f32> {
        let mut depths = vec![0.0; STRIPS * STRIP * ROWS];
        for strip in 0..STRIPS {
            let start = edge(edge_start(strip)) - 0.25;
            let plane_start = plane(edge_start(strip));
            depths[strip * STRIP + 2] = neighbouring_depth(plane_start) as f32;
            for row in 0..ROWS {
                let down = (row as f64 + 0.5) / ROWS as f64;
                let left = -3.0 + 3.125 * down;
                let right = start + (0.125 - start) * down;
                let column = row * STRIPS * STRIP + strip * STRIP + 3;
                depths[column] = if left < 0.0 && right > 0.0 { 0.25 } else { 0.0 };
            }
        }
        depths
    }

    #[test]
    fn every_rounding_is_recognised() {
        for bits in Snapping::BITS {
            let steps = f64::from(1_u32 << bits);
            let nearest = |v: f64| (v * steps).round_ties_even() / steps;
            let down = |v: f64| (v * steps).floor() / steps;
            let unsnapped = Snapping {
                sub_pixel_bits: bits,
                planes: DepthPlanes::Unsnapped,
                ..Snapping::default()
            };
            let snapped = Snapping {
                sub_pixel_bits: bits,
                planes: DepthPlanes::Snapped,
                ..Snapping::default()
            };
            assert_eq!(snapping_of_image(&image(nearest, |v| v)), unsnapped);
            assert_eq!(snapping_of_image(&image(nearest, nearest)), snapped);
            assert_eq!(snapping_of_image(&image(down, |v| v)), unsnapped);
            assert_eq!(snapping_of_image(&image(down, down)), snapped);
        }
    }

    #[test]
    fn finer_grids_are_taken_for_the_finest_known() {
        let fine = |v: f64| (v * 4096.0).round() / 4096.0;
        assert_eq!(snapping_of_image(&image(fine, |v| v)), Snapping::default());
        assert_eq!(snapping_of_image(&image(|v| v, |v| v)), Snapping::default());
    }

    #[test]
    fn images_without_sense_are_taken_for_the_coarsest() {
        assert_eq!(
            snapping_of_image(&vec![0.0; STRIPS * STRIP * ROWS]),
            Snapping::COARSEST
        );
        assert_eq!(
            snapping_of_image(&vec![f32::NAN; STRIPS * STRIP * ROWS]),
            Snapping::COARSEST
        );
        let mut one_missing = image(|v| v, |v| v);
        one_missing
            .iter_mut()
            .skip(3)
            .step_by(STRIPS * STRIP)
            .for_each(|depth| *depth = 0.0);
        assert_eq!(snapping_of_image(&one_missing), Snapping::COARSEST);
    }
}
