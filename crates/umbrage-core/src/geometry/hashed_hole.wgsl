// Hashed alpha test of a pixel. Calls hashed_alpha.wgsl, hole.wgsl, and
// `fn coverage_row(i: u32) -> vec4u`, which the shader that binds the table of hashed_alpha.rs
// declares.

// Returns the coverage of a level, 0 to 255, and the threshold of its cell. `levels` is the row at
// which a texture's levels begin, `bits` the row of the other table at which its texels do.
fn coverage_and_threshold(uv: vec2f, level: u32, levels: u32, bits: u32, triangle: u32) -> vec2f {
    let head = coverage_row(levels + level);
    let size = vec2u(head.x & 0xffffu, head.x >> 16u);
    let texel = nearest_texel(uv.y, size.y) * size.x + nearest_texel(uv.x, size.x);
    let threshold = cell_threshold(uv, size, level, triangle);
    if level == 0u {
        let is_clear = is_texel_clear(cut_out_row(bits + (texel >> 7u)), texel);
        return vec2f(select(255.0, 0.0, is_clear), threshold);
    }
    let row = coverage_row(head.y + (texel >> 4u));
    let word = row[(texel >> 2u) & 3u];
    let coverage = (word >> (8u * (texel & 3u))) & 255u;
    return vec2f(f32(coverage), threshold);
}

// Returns whether there is a hole. `squared` is the square of the footprint, more than 1.
fn is_hashed_hole(uv: vec2f, squared: f32, levels: u32, bits: u32, triangle: u32) -> bool {
    let last = coverage_row(levels).z;
    let level = finer_level(squared, last);
    let fine = coverage_and_threshold(uv, level, levels, bits, triangle);
    if level == last {
        return fine.x < 255.0 * fine.y;
    }
    let coarse = coverage_and_threshold(uv, level + 1u, levels, bits, triangle);
    let part = part_to_next_level(squared, level);
    let coverage = fine.x + (coarse.x - fine.x) * part;
    return coverage < 255.0 * threshold_between(fine.y, coarse.y, part);
}
