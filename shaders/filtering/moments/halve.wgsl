// Twin of halve.rs: the means of runs of 2, 4, 8 and so on texels, next to each other along one
// axis.

struct HalveUniforms {
    levels: i32,
    along_columns: u32,
}

fn filter_texel(texel: vec2i, layer: i32) -> vec4f {
    let is_along_columns = kernel.along_columns != 0u;
    // The input is as high as the map. Along columns, its rows hold all levels next to each other.
    let size = size_0().y;
    let place = select(texel.x, texel.y, is_along_columns);
    var start = 0;
    for (var level = 1; level <= kernel.levels; level++) {
        let side = size >> u32(level);
        if place < start + side {
            if is_along_columns && texel.x >= side {
                return vec4f(0.0);
            }
            let count = 1 << u32(level);
            let first = (place - start) * count;
            var sum = vec4f(0.0);
            for (var i = 0; i < count; i++) {
                let along_row = vec2i(first + i, texel.y);
                let along_column = vec2i(start + texel.x, first + i);
                let at = select(along_row, along_column, is_along_columns);
                sum += loaded_moments(load_0(at, layer));
            }
            return stored_moments(sum * (1.0 / f32(count)));
        }
        start += side;
    }
    return vec4f(0.0);
}
