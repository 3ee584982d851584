// Twin of hashed_alpha.rs: the size of a pixel on an alpha texture, and the threshold of its cell.
// Calls math.wgsl and cut_out.wgsl.

fn squared_footprint(uv: vec2f, right: vec2f, below: vec2f, size: vec2u) -> f32 {
    let across = (right - uv) * vec2f(size);
    let down = (below - uv) * vec2f(size);
    let squared_across = across.x * across.x + across.y * across.y;
    let squared_down = down.x * down.x + down.y * down.y;
    if squared_across > squared_down {
        return squared_across;
    }
    return squared_down;
}

fn finer_level(squared: f32, last: u32) -> u32 {
    let exponent = (bitcast<u32>(squared) >> 23u) - 127u;
    return min(exponent >> 1u, last);
}

fn part_to_next_level(squared: f32, level: u32) -> f32 {
    let scaled = bitcast<f32>(bitcast<u32>(squared) - (level << 24u));
    return (scaled - 1.0) / 3.0;
}

fn whole_repeats(t: f32) -> i32 {
    if abs(t) < 8388608.0 {
        return i32(floor(t));
    }
    return 0;
}

fn cell_threshold(uv: vec2f, size: vec2u, level: u32, triangle: u32) -> f32 {
    let repeats = vec2u(bitcast<u32>(whole_repeats(uv.x)), bitcast<u32>(whole_repeats(uv.y)));
    let column = repeats.x * size.x + nearest_texel(uv.x, size.x);
    let row = repeats.y * size.y + nearest_texel(uv.y, size.y);
    return (f32(mixed_words(column, row, level, triangle) >> 9u) + 0.5) * 1.1920928955078125e-7;
}

fn mixed_words(column: u32, row: u32, level: u32, triangle: u32) -> u32 {
    var x = column * 1664525u + 1013904223u;
    var y = row * 1664525u + 1013904223u;
    var z = level * 1664525u + 1013904223u;
    var w = triangle * 1664525u + 1013904223u;
    x += y * w;
    y += z * x;
    z += x * y;
    w += y * z;
    x ^= x >> 16u;
    y ^= y >> 16u;
    w ^= w >> 16u;
    return x + y * w;
}

fn threshold_between(fine: f32, coarse: f32, part: f32) -> f32 {
    let rest = 1.0 - part;
    let mixed = fine * rest + coarse * part;
    let lesser = min(part, rest);
    let greater = max(part, rest);
    let twice = 2.0 * lesser * greater;
    if mixed < lesser {
        return mixed * mixed / twice;
    }
    if mixed < greater {
        return (mixed - 0.5 * lesser) / greater;
    }
    let to_one = 1.0 - mixed;
    return 1.0 - to_one * to_one / twice;
}
