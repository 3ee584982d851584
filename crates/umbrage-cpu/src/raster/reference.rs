//! Reference implementation of the rasterisation rules, pixel by pixel and as simple as possible,
//! for tests of the fast rasteriser. Both share clipping and the handling of clipped triangles.

use crate::raster::{
    Draw, Mode, Position, Rounding,
    clip::{clip, is_culled, outcode},
    record::DepthPlane,
    viewport::Viewport,
    whole::Whole,
};
use glam::{IVec2, Vec3};
use umbrage_core::{Cull, DepthPlanes, NO_TRIANGLE, RasterBias, Snapping};

/// Texels and ids of an image.
pub(crate) type DrawnImages = (Vec<f32>, Vec<u32>);

/// Draws the triangles one after the other into a clear image. `other` is the image that the mode
/// reads.
pub(crate) fn draw<P: Position>(draw: &Draw<'_, P>, other: &[f32]) -> DrawnImages {
    draw_on(Snapping::default(), draw, other)
}

/// Draws like [`draw`], with this rounding of vertices.
pub(crate) fn draw_on<P: Position>(
    snapping: Snapping,
    draw: &Draw<'_, P>,
    other: &[f32],
) -> DrawnImages {
    let n = (draw.size.x * draw.size.y) as usize;
    let start = if draw.mode == Mode::StencilDepthFail {
        0.0
    } else {
        1.0
    };
    let mut drawn = (vec![start; n], vec![NO_TRIANGLE; n]);
    let viewport = Viewport::new(draw.size);
    let culls_twice = snapping.planes == DepthPlanes::Unsnapped;
    // Clip each triangle and fill its pieces.
    for (i, triangle) in draw.triangles.iter().enumerate() {
        let corners = triangle.map(|v| draw.positions[v as usize].to_clip(draw.clip_from_world));
        let codes = corners.map(outcode);
        let id = draw.first_id + i as u32;
        let mut piece = |window: [Vec3; 3], whole: Option<&Whole>| {
            fill(draw, snapping, window, whole, id, other, &mut drawn)
        };
        if codes == [0; 3] {
            piece(corners.map(|c| viewport.project(c)), None);
        } else if codes[0] & codes[1] & codes[2] == 0 {
            let rounding = Rounding {
                snapping,
                ..Rounding::default()
            };
            let whole = Whole::new(corners, &viewport, rounding);
            clip(
                corners,
                codes[0] | codes[1] | codes[2],
                &viewport,
                |window| match &whole {
                    None if culls_twice && is_culled(window, draw.cull) => {}
                    None => piece(window, None),
                    Some(whole) => {
                        whole
                            .place(window)
                            .into_iter()
                            .for_each(|placed| piece(placed, Some(whole)));
                    }
                },
            );
        }
    }
    drawn
}

/// Returns the new value of a texel when depth `z` of a front or back face is drawn over it, or
/// `None` if it is unchanged. `other` is the texel of the image that the mode reads.
fn drawn_over(mode: Mode, texel: f32, other: Option<&f32>, z: f32, front: bool) -> Option<f32> {
    let other = other.copied().unwrap_or(f32::NAN);
    match mode {
        Mode::Depth | Mode::DepthWithIds => (z < texel).then_some(z),
        Mode::Depth16 => (steps(z) < stored_steps(texel)).then_some(of_steps(steps(z))),
        Mode::DepthPeel => (z > other && z < texel).then_some(z),
        Mode::DepthPeel16 => {
            let between = steps(z) > stored_steps(other) && steps(z) < stored_steps(texel);
            between.then_some(of_steps(steps(z)))
        }
        Mode::StencilDepthFail => {
            let by = if front { -1 } else { 1 };
            let before = z < other;
            (!before).then_some((texel as i32 + by).rem_euclid(256) as f32)
        }
    }
}

/// Returns a depth in whole steps of 16 bits: the factor is rounded, and so is the product.
fn steps(z: f32) -> i64 {
    (f64::from(z * (65_535.0_f32 / 65_536.0)) * 65_536.0).round_ties_even() as i64
}

fn of_steps(steps: i64) -> f32 {
    steps as f32 * (1.0 / 65_535.0)
}

/// Returns the stored value of a texel in whole steps.
fn stored_steps(texel: f32) -> i64 {
    (f64::from(texel) * 65_535.0).round() as i64
}

/// Draws a triangle given by its window corners, or a piece of a whole one with the whole one's
/// plane and polygon offset.
fn fill<P>(
    draw: &Draw<'_, P>,
    snapping: Snapping,
    window: [Vec3; 3],
    whole: Option<&Whole>,
    id: u32,
    other: &[f32],
    drawn: &mut DrawnImages,
) {
    let (texels, ids) = drawn;
    // Number of grid points per pixel.
    let steps = 2.0_f32.powi(snapping.sub_pixel_bits as i32);
    let snapped = window.map(|v| IVec2::new(in_sub_pixels(v.x, steps), in_sub_pixels(v.y, steps)));
    let window = match snapping.planes {
        DepthPlanes::Unsnapped => window,
        DepthPlanes::Snapped => {
            window.map(|v| Vec3::new(on_grid(v.x, steps), on_grid(v.y, steps), v.z))
        }
    };
    // Cull by the orientation on the grid.
    let [a, b, c] = snapped.map(|v| v.as_i64vec2());
    let area = (a.x - b.x) * (c.y - a.y) - (c.x - a.x) * (a.y - b.y);
    let culled = match draw.cull {
        Cull::None => area == 0,
        Cull::Front => area >= 0,
        Cull::Back => area <= 0,
    };
    if culled {
        return;
    }
    let [v0, v1, v2] = if area > 0 {
        window
    } else {
        [window[0], window[2], window[1]]
    };
    let clockwise = if area > 0 { [a, c, b] } else { [a, b, c] };
    // Test each pixel of the image.
    let plane = depth_plane(draw, snapping, [v0, v1, v2], whole);
    for y in 0..draw.size.y {
        for x in 0..draw.size.x {
            let p = IVec2::new(x as i32, y as i32).as_i64vec2() * 256;
            let inside = (0..3).all(|k| {
                let from = clockwise[k];
                let d = clockwise[(k + 1) % 3] - from;
                let e = d.x * (p.y - from.y) - d.y * (p.x - from.x);
                let is_top_left = d.y < 0 || (d.y == 0 && d.x > 0);
                e > 0 || (e == 0 && is_top_left)
            });
            let z = (plane
                .dy
                .mul_add(y as f32, plane.dx.mul_add(x as f32, plane.at_origin))
                + plane.offset)
                .clamp(0.0, 1.0);
            let i = (y * draw.size.x + x) as usize;
            let kept = drawn_over(draw.mode, texels[i], other.get(i), z, area > 0);
            let is_hole = draw.holes.is_some_and(|holes| holes.is_hole(id, x, y));
            if let Some(texel) = kept.filter(|_| inside && !is_hole) {
                texels[i] = texel;
                ids[i] = id;
            }
        }
    }
}

/// Returns the depth plane through window corners, counter-clockwise, with its polygon offset. For
/// a piece, returns those of the whole triangle.
fn depth_plane<P>(
    draw: &Draw<'_, P>,
    snapping: Snapping,
    corners: [Vec3; 3],
    whole: Option<&Whole>,
) -> DepthPlane {
    let [v0, v1, v2] = corners;
    let d01 = v0 - v1;
    let d20 = v2 - v0;
    let r = 1.0 / (d01.x * d20.y - d01.y * d20.x);
    let dx = d01.z * (d20.y * r) - d20.z * (d01.y * r);
    let dy = d20.z * (d01.x * r) - d01.z * (d20.x * r);
    let at_origin = v0.z - (dx * (v0.x - 0.5) + dy * (v0.y - 0.5));
    let slope_x = ((d20.z * d01.y - d20.y * d01.z) * r).abs();
    let slope_y = ((d20.x * d01.z - d20.z * d01.x) * r).abs();
    let mut plane = DepthPlane {
        at_origin,
        dx,
        dy,
        offset: 0.0,
    };
    let mut slope = slope_x.max(slope_y);
    let mut greatest = v0.z.abs().max(v1.z.abs()).max(v2.z.abs());
    if let Some(whole) = whole {
        plane = whole.depth();
        slope = plane.dx.abs().max(plane.dy.abs());
        greatest = whole.greatest_depth();
    }
    let unit = match draw.mode {
        Mode::Depth16 | Mode::DepthPeel16 => snapping.offset_unit.depth(),
        _ => float_spacing(greatest),
    };
    plane.offset = offset(&draw.bias, unit, slope);
    plane
}

/// Rounds a window coordinate to a grid of `steps` points per pixel. Returns it in 256ths of a
/// pixel from the centre of the first one.
fn in_sub_pixels(v: f32, steps: f32) -> i32 {
    let snapped = ((v - 0.5) * steps).round_ties_even() * (256.0 / steps);
    snapped.clamp(-4_194_304.0, 4_194_304.0) as i32
}

/// Rounds a window coordinate to a grid of `steps` points per pixel.
fn on_grid(v: f32, steps: f32) -> f32 {
    ((v - 0.5) * steps).round_ties_even() / steps + 0.5
}

/// Returns the spacing of floats of a magnitude, or 0 if it would be denormal.
fn float_spacing(magnitude: f32) -> f32 {
    if magnitude < 2.0_f32.powi(-126) {
        0.0
    } else {
        2.0_f32.powf(magnitude.log2().floor() - 23.0)
    }
}

/// Returns the polygon offset for a unit and a slope (depth per pixel).
fn offset(bias: &RasterBias, unit: f32, slope: f32) -> f32 {
    if bias.constant == 0 && bias.slope == 0.0 {
        return 0.0;
    }
    let offset = unit * bias.constant as f32 + slope * bias.slope;
    match bias.clamp {
        c if c > 0.0 => offset.min(c),
        c if c < 0.0 => offset.max(c),
        _ => offset,
    }
}
