// Twin of exact.rs: queries the list of a receiver's cell. Tables: tiles (table_0), cells
// (table_1), items (table_2), the casters' corners (table_3). frame_point.wgsl calls it, and
// caster_opaque.wgsl or caster_cut_out.wgsl defines the intersection test.

// Greatest number below 1.
const BELOW_ONE = 0.99999994;

const NO_CASTER = 0xffffffffu;

fn corner_of(row: u32) -> vec3f {
    return bitcast<vec3f>(table_3[row].xyz);
}

fn is_shadowed(o: vec3f, d: vec3f, own: u32) -> bool {
    let point = frame_point(o);
    let size = vec2f(kernel.tiles.xy);
    let on_grid = (point.on_face + kernel.grid.xy) * kernel.grid.z;
    let is_inside = on_grid.x >= 0.0 && on_grid.y >= 0.0 && on_grid.x < size.x && on_grid.y < size.y;
    // Faces of a point light are adjacent, so only directional lights have an outside.
    if kernel.tiles.z == 0u && !is_inside {
        return false;
    }
    let at = clamp(on_grid, vec2f(0.0), size * BELOW_ONE);
    let tile = vec2u(at);
    let number = (point.face * kernel.tiles.y + tile.y) * kernel.tiles.x + tile.x;
    let tiles = table_0[number / 2u];
    let first_and_side = select(tiles.xy, tiles.zw, number % 2u == 1u);
    let in_tile = product2(at - floor(at), vec2f(f32(1u << first_and_side.y)));
    let cell_at = vec2u(in_tile);
    let cell_number = first_and_side.x + (cell_at.y << first_and_side.y) + cell_at.x;
    let cell = table_1[cell_number];
    if point.depth > bitcast<f32>(cell.y) {
        return true;
    }
    let steps = (point.depth - bitcast<f32>(cell.z)) * bitcast<f32>(cell.w);
    if point.depth < bitcast<f32>(cell.z) {
        return false;
    }
    let depth = u32(min(steps, KEY_STEPS - 1.0));
    let step = vec2u((in_tile - floor(in_tile)) * KEY_STEPS);
    let least = step.x | (step.y << FIELD);
    let greatest = ((LAST - step.x) << (2u * FIELD)) | ((LAST - step.y) << (3u * FIELD));
    let asking = least | greatest | (depth << (4u * FIELD)) | GUARDS;
    let end = table_1[cell_number + 1u].x;
    // Use two loops; the inner one skips casters by their words. Where many invocations run in
    // lockstep, all wait for a triangle test of any. So each finds its next candidate, and all run
    // the test together (Aila and Laine 2009, "Understanding the Efficiency of Ray Traversal on
    // GPUs").
    let rows = shear_rows(d);
    var i = cell.x;
    loop {
        var caster = NO_CASTER;
        while i < end {
            let items = table_2[i / 2u];
            let item = select(items.xy, items.zw, i % 2u == 1u);
            let fields = (asking - item.y) & GUARDS;
            // The item is deeper than the receiver, and so are all after it.
            i = select(i + 1u, end, (fields & DEPTH_GUARD) == 0u);
            if item.x != own && fields == GUARDS {
                caster = item.x;
                break;
            }
        }
        if caster == NO_CASTER {
            break;
        }
        if meets_caster(o, d, rows, caster) {
            return true;
        }
    }
    return false;
}
