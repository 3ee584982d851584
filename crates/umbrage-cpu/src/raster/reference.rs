//! The rasterisation rules again, pixel by pixel and as plainly as can be: what the fast rasteriser is tested against.
//! Only clipping is shared with it.

use super::{
    Draw,
    clip::{clip, outcode},
    viewport::Viewport,
};
use glam::{IVec2, Vec3};
use umbrage_core::{Cull, NO_TRIANGLE, RasterBias, math::transform};

/// Depths and ids of a clear image with the triangles drawn one after the other, depth test "less".
pub(crate) fn draw(draw: &Draw<'_>) -> (Vec<f32>, Vec<u32>) {
    let n = (draw.size.x * draw.size.y) as usize;
    let (mut depth, mut ids) = (vec![1.0; n], vec![NO_TRIANGLE; n]);
    let viewport = Viewport::new(draw.size);
    for (i, triangle) in draw.triangles.iter().enumerate() {
        let corners = triangle.map(|v| transform(draw.clip_from_world, draw.positions[v as usize]));
        let codes = corners.map(outcode);
        let mut piece = |window: [Vec3; 3]| fill(draw, window, draw.first_id + i as u32, &mut depth, &mut ids);
        if codes == [0; 3] {
            piece(corners.map(|c| viewport.project(c)));
        } else if codes[0] & codes[1] & codes[2] == 0 {
            clip(corners, codes[0] | codes[1] | codes[2], &viewport, piece);
        }
    }
    (depth, ids)
}

fn fill(draw: &Draw<'_>, window: [Vec3; 3], id: u32, depth: &mut [f32], ids: &mut [u32]) {
    let snapped = window.map(|v| {
        let snap = |v: f32| ((v - 0.5) * 256.0).round_ties_even().clamp(-4_194_304.0, 4_194_304.0) as i32;
        IVec2::new(snap(v.x), snap(v.y))
    });
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
    let [v0, v1, v2] = if area > 0 { window } else { [window[0], window[2], window[1]] };
    let clockwise = if area > 0 { [a, c, b] } else { [a, b, c] };
    let (d01, d20) = (v0 - v1, v2 - v0);
    let r = 1.0 / (d01.x * d20.y - d01.y * d20.x);
    let dx = d01.z * (d20.y * r) - d20.z * (d01.y * r);
    let dy = d20.z * (d01.x * r) - d01.z * (d20.x * r);
    let at_origin = v0.z - (dx * (v0.x - 0.5) + dy * (v0.y - 0.5));
    let offset = offset(&draw.bias, [v0, v1, v2], r);
    for y in 0..draw.size.y {
        for x in 0..draw.size.x {
            let p = IVec2::new(x as i32, y as i32).as_i64vec2() * 256;
            let inside = (0..3).all(|k| {
                let (from, to) = (clockwise[k], clockwise[(k + 1) % 3]);
                let d = to - from;
                let e = d.x * (p.y - from.y) - d.y * (p.x - from.x);
                e > 0 || (e == 0 && (d.y < 0 || (d.y == 0 && d.x > 0)))
            });
            let z = (dy.mul_add(y as f32, dx.mul_add(x as f32, at_origin)) + offset).clamp(0.0, 1.0);
            let i = (y * draw.size.x + x) as usize;
            if inside && z < depth[i] {
                (depth[i], ids[i]) = (z, id);
            }
        }
    }
}

fn offset(bias: &RasterBias, [v0, v1, v2]: [Vec3; 3], r: f32) -> f32 {
    if bias.constant == 0 && bias.slope == 0.0 {
        return 0.0;
    }
    let (d01, d20) = (v0 - v1, v2 - v0);
    let dzdx = ((d20.z * d01.y - d20.y * d01.z) * r).abs();
    let dzdy = ((d20.x * d01.z - d20.z * d01.x) * r).abs();
    let greatest = v0.z.abs().max(v1.z.abs()).max(v2.z.abs());
    let unit = if greatest < 2.0_f32.powi(-126) { 0.0 } else { 2.0_f32.powf(greatest.log2().floor() - 23.0) };
    let offset = unit * bias.constant as f32 + dzdx.max(dzdy) * bias.slope;
    match bias.clamp {
        c if c > 0.0 => offset.min(c),
        c if c < 0.0 => offset.max(c),
        _ => offset,
    }
}
