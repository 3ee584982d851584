//! Finds out how a device's rasteriser rounds vertices: no graphics API says all of it.
//!
//! One small image is drawn (`probe.wgsl`) and read back. Upper ends of edges lie at 64 places over an eighth of a pixel, from
//! one point of every grid to another. The row in which an edge passes its column of pixel centres tells where its upper end
//! was moved to, to a thousandth of a pixel; how many different places there are tells the grid's step.

use crate::{
    device::readback::{ReadBack, Spare},
    filter::color_attachment,
    resources::{
        counters::{Counters, ResourceFactory},
        pipelines::{Targets, fullscreen_pipeline},
    },
};
use umbrage_core::{BackendError, DepthPlanes, Snapping};
use wgpu::{
    Color, CommandEncoderDescriptor, Device, Extent3d, Queue, RenderPassDescriptor,
    TextureDescriptor, TextureDimension, TextureFormat, TextureUsages, TextureViewDescriptor,
};

/// Triangles, and pixels between them.
const STRIPS: usize = 64;
const STRIP: usize = 4;
/// The image's height.
const ROWS: usize = 512;

/// Draws triangles on a device and tells how its rasteriser rounded their vertices. Takes some milliseconds.
///
/// # Errors
/// Errors if the device fails.
pub fn probe_snapping(device: &Device, queue: &Queue) -> Result<Snapping, BackendError> {
    Ok(of_image(&draw(device, queue)?))
}

/// Depths of the triangles' pixels, 0 elsewhere.
fn draw(device: &Device, queue: &Queue) -> Result<Vec<f32>, BackendError> {
    let mut counters = Counters::default();
    let mut spare = Spare::default();
    let label = "umbrage probe";
    let format = TextureFormat::R32Float;
    let size = Extent3d {
        width: (STRIPS * STRIP) as u32,
        height: ROWS as u32,
        depth_or_array_layers: 1,
    };
    let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC;
    let dimension = TextureDimension::D2;
    let mip_level_count = 1;
    let sample_count = 1;
    let image = ResourceFactory {
        device,
        queue,
        counters: &mut counters,
    }
    .texture(&TextureDescriptor {
        label: Some(label),
        size,
        mip_level_count,
        sample_count,
        dimension,
        format,
        usage,
        view_formats: &[],
    });
    let entries = ["place", "depth"];
    let pipeline = fullscreen_pipeline(
        device,
        label,
        include_str!("probe.wgsl"),
        entries,
        &Targets::Colors(&[format]),
        &[],
    );
    let mut encoder = device.create_command_encoder(&CommandEncoderDescriptor::default());
    let view = image.create_view(&TextureViewDescriptor::default());
    let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
        label: Some(label),
        color_attachments: &[Some(color_attachment(&view, Color::TRANSPARENT))],
        ..RenderPassDescriptor::default()
    });
    pass.set_pipeline(&pipeline);
    pass.draw(0..3 * STRIPS as u32, 0..1);
    drop(pass);
    let mut back = ReadBack::new(device, &mut counters, &mut spare);
    let ticket = back.texture(&mut encoder, &image);
    queue.submit([encoder.finish()]);
    back.wait()?;
    back.read(ticket)
}

/// What the image says. One that makes no sense is taken for the coarsest device's.
fn of_image(depths: &[f32]) -> Snapping {
    let rows: Vec<usize> = (0..STRIPS)
        .map(|strip| rows_beyond(depths, strip))
        .collect();
    if rows.contains(&0) {
        return Snapping::COARSEST;
    }
    let mut places = rows.clone();
    places.sort_unstable();
    places.dedup();
    // An eighth of a pixel is 2^(bits - 3) steps. Rounding to nearest reaches the points at both ends, which is one more
    // place than there are steps; rounding down doesn't.
    let bits = (places.len().ilog2() + 3).clamp(*Snapping::BITS.start(), *Snapping::BITS.end());
    let found = Snapping {
        sub_pixel_bits: bits,
        planes: DepthPlanes::Unsnapped,
    };
    // The squares of the distances from the depths drawn to those of each rule.
    let mut far = [0.0; 2];
    for (strip, &rows) in rows.iter().enumerate() {
        let drawn = f64::from(depths[strip * STRIP + 2]);
        let step = f64::from(found.step());
        let moved = (upper_end(rows) / step).round() * step;
        far[0] += (depth_beside(beyond_grid(strip)) - drawn).powi(2);
        far[1] += (depth_beside(moved) - drawn).powi(2);
    }
    let planes = if far[1] < far[0] {
        DepthPlanes::Snapped
    } else {
        DepthPlanes::Unsnapped
    };
    Snapping { planes, ..found }
}

/// How far right of the grid's point the right edge of a triangle begins, pixels.
fn beyond_grid(strip: usize) -> f64 {
    (strip as f64 + 0.5) / 512.0
}

/// How many rows there are from that on in which a triangle's right edge passes its column of pixel centres; none if it
/// covers no pixel there.
fn rows_beyond(depths: &[f32], strip: usize) -> usize {
    let column = strip * STRIP + 3;
    let first = (0..ROWS).find(|row| depths[row * STRIPS * STRIP + column] > 0.0);
    ROWS - first.unwrap_or(ROWS)
}

/// Where an edge begins, pixels right of the grid's point, that lies right of its column's centres in so many rows. The point
/// lies a quarter pixel left of the centres and the edge's lower end an eighth right of them: by similar triangles,
/// `rows : ROWS = 1/8 : 3/8 - beginning`.
fn upper_end(rows: usize) -> f64 {
    0.375 - 0.125 * ROWS as f64 / rows as f64
}

/// The depth at the first row's pixel left of the column, of the plane through a triangle whose right edge begins so far
/// right of the grid's point. Places are relative to the column's centres and the image's upper edge.
fn depth_beside(beginning: f64) -> f64 {
    let a = [beginning - 0.25, 0.0, 0.25];
    let b = [0.125, ROWS as f64, 0.25];
    let c = [-3.0, 0.0, 0.75];
    let x = -1.0;
    let y = 0.5;
    // Barycentric weight of `c`; the other two have the same depth.
    let twice_area = |p: [f64; 3], q: [f64; 3], r: [f64; 2]| {
        (q[0] - p[0]) * (r[1] - p[1]) - (r[0] - p[0]) * (q[1] - p[1])
    };
    let of_c = twice_area(a, b, [x, y]) / twice_area(a, b, [c[0], c[1]]);
    a[2] + (c[2] - a[2]) * of_c
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a device draws that moves edges' upper ends with `edge`, and depth planes' with `plane`.
    fn image(edge: impl Fn(f64) -> f64, plane: impl Fn(f64) -> f64) -> Vec<f32> {
        let mut depths = vec![0.0; STRIPS * STRIP * ROWS];
        for strip in 0..STRIPS {
            let begins = edge(beyond_grid(strip)) - 0.25;
            let of_plane = plane(beyond_grid(strip));
            depths[strip * STRIP + 2] = depth_beside(of_plane) as f32;
            for row in 0..ROWS {
                let down = (row as f64 + 0.5) / ROWS as f64;
                let left = -3.0 + 3.125 * down;
                let right = begins + (0.125 - begins) * down;
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
            let [unsnapped, snapped] =
                [DepthPlanes::Unsnapped, DepthPlanes::Snapped].map(|planes| Snapping {
                    sub_pixel_bits: bits,
                    planes,
                });
            assert_eq!(of_image(&image(nearest, |v| v)), unsnapped);
            assert_eq!(of_image(&image(nearest, nearest)), snapped);
            assert_eq!(of_image(&image(down, |v| v)), unsnapped);
            assert_eq!(of_image(&image(down, down)), snapped);
        }
    }

    #[test]
    fn finer_grids_are_taken_for_the_finest_known() {
        let fine = |v: f64| (v * 4096.0).round() / 4096.0;
        assert_eq!(of_image(&image(fine, |v| v)), Snapping::default());
        assert_eq!(of_image(&image(|v| v, |v| v)), Snapping::default());
    }

    #[test]
    fn images_without_sense_are_taken_for_the_coarsest() {
        assert_eq!(
            of_image(&vec![0.0; STRIPS * STRIP * ROWS]),
            Snapping::COARSEST
        );
        assert_eq!(
            of_image(&vec![f32::NAN; STRIPS * STRIP * ROWS]),
            Snapping::COARSEST
        );
        let mut one_missing = image(|v| v, |v| v);
        one_missing
            .iter_mut()
            .skip(3)
            .step_by(STRIPS * STRIP)
            .for_each(|depth| *depth = 0.0);
        assert_eq!(of_image(&one_missing), Snapping::COARSEST);
    }
}
