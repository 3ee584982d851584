// Twin of `MomentMapKernel` in blur.rs: moments of depths, averaged over squares of texels.

// Values of `MOMENTS`: see blur.rs.
const VARIANCE = 0u;
const EXPONENTIALS = 1u;
const POWERS = 2u;

// Number of moments that a workgroup keeps: see tile.rs.
const CAPACITY = 1020u;
// Side of a workgroup, invocations.
const LANES = 8;
// More than any moment.
const GREATEST = 3e38;

struct MomentMapUniforms {
    rising: f32,
    falling: f32,
    radius: i32,
    // Weight of each texel of a row or a column.
    share: f32,
    // Size of the tile that a workgroup writes, texels.
    tile: vec2i,
    // Number of rows of depths that a workgroup reads at a time.
    rows: i32,
}

// The means along rows of the tile and its surroundings, `tile.x` a row. Behind them are the
// moments of the rows that were read last.
var<workgroup> kept: array<vec4f, CAPACITY>;

fn moments_of(depth: f32) -> vec4f {
    if MOMENTS == VARIANCE {
        return vec4f(variance_moments(depth), 0.0, 0.0);
    }
    if MOMENTS == EXPONENTIALS {
        return exponential_moments(depth, kernel.rising, kernel.falling);
    }
    return power_moments(depth);
}

// Returns the mean of moments `step` apart.
fn mean_of_kept(first: i32, step: i32) -> vec4f {
    var sum = vec4f(0.0);
    for (var i = 0; i <= 2 * kernel.radius; i++) {
        sum += kept[first + i * step];
    }
    return sum * kernel.share;
}

// Keeps the moments of some rows of depths, each wider than the tile by the radius on both sides.
fn keep_moments(start: vec2i, layer: i32, lane: vec2i, place: i32) {
    let width = kernel.tile.x + 2 * kernel.radius;
    let last = size_0() - 1;
    for (var y = lane.y; y < kernel.rows; y += LANES) {
        for (var x = lane.x; x < width; x += LANES) {
            // The edge of the map repeats.
            let texel = clamp(start + vec2i(x, y), vec2i(0), last);
            kept[place + y * width + x] = moments_of(stored_depth(texel, layer));
        }
    }
}

fn filter_tile(tile: vec2i, layer: i32, lane: vec2i) {
    let size = kernel.tile;
    let first = tile * size;
    let width = size.x + 2 * kernel.radius;
    let height = size.y + 2 * kernel.radius;
    let place = size.x * height;
    // Average along rows.
    for (var row = 0; row < height; row += kernel.rows) {
        let start = first + vec2i(-kernel.radius, row - kernel.radius);
        keep_moments(start, layer, lane, place);
        workgroupBarrier();
        let rows = min(kernel.rows, height - row);
        for (var y = lane.y; y < rows; y += LANES) {
            for (var x = lane.x; x < size.x; x += LANES) {
                kept[(row + y) * size.x + x] = mean_of_kept(place + y * width + x, 1);
            }
        }
        workgroupBarrier();
    }
    // Average along columns.
    let last = size_0() - 1;
    for (var y = lane.y; y < size.y; y += LANES) {
        for (var x = lane.x; x < size.x; x += LANES) {
            let texel = first + vec2i(x, y);
            if all(texel <= last) {
                let mean = mean_of_kept(y * size.x + x, size.x);
                // The bounds change nothing, but keep drivers from moving the factor of the mean
                // out of differences of two moments, which would round differently.
                let bounded = min(max(mean, vec4f(-GREATEST)), vec4f(GREATEST));
                store_texel(texel, layer, stored_moments(bounded));
            }
        }
    }
}
