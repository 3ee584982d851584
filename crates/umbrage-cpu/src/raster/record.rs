//! Triangle that is ready to be filled.

/// Depth as a linear function of the pixel: `fma(dy, py, fma(dx, px, at_origin)) + offset`, clamped
/// to 0..=1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct DepthPlane {
    /// Depth at the centre of the image's first pixel.
    pub(crate) at_origin: f32,
    /// Change per pixel to the right.
    pub(crate) dx: f32,
    /// Change per pixel down.
    pub(crate) dy: f32,
    /// Polygon offset.
    pub(crate) offset: f32,
}

/// Triangle after setup, in the order of corners in which its inside has positive edge functions.
///
/// An edge function changes by multiples of 256 from pixel to pixel. All are therefore stored
/// divided by 256 and rounded down, which keeps their signs: a pixel is covered if none is
/// negative.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Record {
    /// First corner, sub-pixels; pixel centres are multiples of 256.
    pub(crate) corner: [i32; 2],
    /// Vector from the first corner to the second, sub-pixels.
    pub(crate) edge_a: [i32; 2],
    /// Vector from the second corner to the third, sub-pixels.
    pub(crate) edge_b: [i32; 2],
    /// Edge functions at pixel `min` for small triangles; unspecified for others.
    pub(crate) at_min: [i32; 3],
    /// Depth plane.
    pub(crate) plane: DepthPlane,
    /// Least x and y, pixels.
    pub(crate) min: [u16; 2],
    /// Greatest x and y, pixels.
    pub(crate) max: [u16; 2],
    /// Id of the triangle. For
    /// [`Mode::StencilDepthFail`](crate::raster::mode::Mode::StencilDepthFail), it is the change of
    /// a count in two's complement: +1 for a back face, -1 for a front face.
    pub(crate) tag: u32,
}

/// Returns twice a triangle's area in square sub-pixels, positive for counter-clockwise on screen
/// (window y points down).
#[inline(always)]
pub(crate) fn doubled_area(x: [i32; 3], y: [i32; 3]) -> i64 {
    i64::from(x[0] - x[1]) * i64::from(y[2] - y[0])
        - i64::from(x[2] - x[0]) * i64::from(y[0] - y[1])
}

/// Returns the function of the edge from `start` along the vector `edge` at the point `p`, divided
/// by 256; all in sub-pixels. It is negative outside. Points on the edge are inside if it is a top
/// or a left edge.
#[inline(always)]
pub(crate) fn edge_function(start: [i32; 2], edge: [i32; 2], p: [i32; 2]) -> i64 {
    let right = i64::from(p[0] - start[0]);
    let down = i64::from(p[1] - start[1]);
    let value = i64::from(edge[0]) * down - i64::from(edge[1]) * right;
    // On other edges, 0 is also outside.
    (value - i64::from(!is_top_left(edge))) >> 8
}

/// Returns whether an edge, clockwise on screen (y points down), is a top or a left edge of its
/// triangle.
#[inline(always)]
fn is_top_left(edge: [i32; 2]) -> bool {
    let is_left = edge[1] < 0;
    let is_top = (edge[1] == 0) & (edge[0] > 0);
    is_left | is_top
}

/// Returns [`edge_function`] for a triangle of few pixels and a point near it, for which all
/// numbers fit 32 bits. The result is unspecified for others.
#[inline(always)]
pub(crate) fn small_edge_function(start: [i32; 2], edge: [i32; 2], p: [i32; 2]) -> i32 {
    let right = p[0] - start[0];
    let down = p[1] - start[1];
    let value = edge[0]
        .wrapping_mul(down)
        .wrapping_sub(edge[1].wrapping_mul(right));
    value.wrapping_sub(i32::from(!is_top_left(edge))) >> 8
}
