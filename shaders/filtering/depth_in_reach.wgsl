// Twin of depth_in_reach.rs: the least depth that may hide part of the light from a receiver in a
// cell.

struct DepthInReachUniforms {
    square: u32,
    cells: u32,
    cell: f32,
    half: f32,
    extent: LightExtent,
}

fn cell_reach(cell: vec2i, layer: i32) -> vec2f {
    var reach = vec2f(0.0, 0.0);
    for (var corner = 0; corner < 4; corner++) {
        let x = f32(cell.x + (corner & 1)) * kernel.cell - kernel.half;
        let y = f32(cell.y + (corner >> 1u)) * kernel.cell - kernel.half;
        let axes = light_axes(kernel.extent.half_axis_u[layer], kernel.extent.half_axis_v[layer], vec2f(x, y));
        reach = max(reach, reach_along(kernel.square, axes));
    }
    return reach;
}

fn cells_between(a: i32, b: i32) -> f32 {
    return f32(max(abs(a - b) - 1, 0)) * kernel.cell;
}

fn filter_texel(cell: vec2i, layer: i32) -> vec4f {
    let reach = cell_reach(cell, layer);
    let most = kernel.extent.half_axis_v[layer].w;
    let cells = i32(kernel.cells);
    // Add a cell for rounding; no cell farther away is reached, since no depth is below 0.
    let beyond = vec2i(min(reach * (min(most, 1.0) / kernel.cell), vec2f(f32(cells)))) + 2;
    let first = max(cell - beyond, vec2i(0));
    let end = min(cell + beyond + 1, vec2i(cells));
    var least = 1.0;
    for (var y = first.y; y < end.y; y++) {
        let down = cells_between(cell.y, y);
        for (var x = first.x; x < end.x; x++) {
            let depth = load_0(vec2i(x, y), layer).x;
            let nearer = min(1.0 - depth, most);
            if cells_between(cell.x, x) <= reach.x * nearer && down <= reach.y * nearer {
                least = min(least, depth);
            }
        }
    }
    return vec4f(least, 0.0, 0.0, 0.0);
}
