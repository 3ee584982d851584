// Nodes over the light's view: rectangles and least depths. Calls blocks.wgsl and pieces.wgsl.

fn size_of(low: vec3f, high: vec3f) -> f32 {
    let size = max(high.xy - low.xy, vec2f(0.0));
    return size.x * size.y;
}

// Returns positions across and down, size, and depth.
fn keys_of(i: u32) -> vec4f {
    if !is_item(i) {
        return vec4f(BEYOND);
    }
    let sum = lows[i].xy + highs[i].xy;
    return vec4f(sum, size_of(lows[i], highs[i]), lows[i].z);
}

fn load_reference(at: u32, lane: u32) {
    let reference = references[numbers[at]];
    let id = reference.x & 0x1fffffffu;
    tables[4u * made.ids + at] = id;
    if reference.y == NO_REFERENCE {
        return;
    }
    let face = reference.x >> 29u;
    let shape = shape_of(face, corners_of(id));
    let rect = rect_of(face, shape, reference.y & 0xffffu, reference.y >> 16u);
    // Leave out casters that are not finite: they would make all boxes around them infinite.
    let corners = abs(vec4f(rect.low, rect.high));
    if rect.is_there && all(corners < vec4f(BEYOND)) && abs(rect.nearest) < BEYOND {
        lows[lane] = vec3f(rect.low, rect.nearest);
        highs[lane] = vec3f(rect.high, rect.nearest);
    }
}

const GUARD = 0x80u;

// Four rows: low corner and exponents, then 8 bits for each of 8 children's low and high x, low and
// high y, and least depth, then 6 bits for each child's number in its block, and 8 bits for which
// of them exist. Returns the high corner as a child.
fn put_node(node: u32, first: u32, low: vec3f, high: vec3f) -> vec3f {
    let exponents = vec3u(
        inverse_exponent(high.x - low.x),
        inverse_exponent(high.y - low.y),
        inverse_exponent(high.z - low.z),
    );
    let inverse = bitcast<vec3f>(exponents << vec3u(23u));
    var planes: array<vec2u, 5>;
    var children = vec2u(0u);
    for (var i = 0u; i < 8u; i++) {
        var least = vec3u(127u);
        var most = vec2u(0u);
        if is_item(first + i) {
            // A 32nd of a step is more than the rounding of differences.
            let steps = (lows[first + i] - low) * inverse;
            least = vec3u(clamp(floor(steps - 0.03125), vec3f(0.0), vec3f(127.0)));
            let ends = (highs[first + i].xy - low.xy) * inverse.xy;
            most = vec2u(clamp(ceil(ends + 0.03125), vec2f(0.0), vec2f(127.0)));
        }
        let word = i / 4u;
        let shift = 8u * (i % 4u);
        planes[0][word] |= least.x << shift;
        planes[1][word] |= (most.x | GUARD) << shift;
        planes[2][word] |= least.y << shift;
        planes[3][word] |= (most.y | GUARD) << shift;
        planes[4][word] |= least.z << shift;
        children[i / 5u] |= item_numbers[first + i] << (6u * (i % 5u));
        children.y |= select(0u, 1u, is_item(first + i)) << (24u + i);
    }
    let packed = exponents.x | (exponents.y << 8u) | (exponents.z << 16u);
    let row = made.nodes + HEADER + 4u * node;
    put_row(row, vec4u(bitcast<vec3u>(low), packed));
    put_row(row + 1u, vec4u(planes[0], planes[1]));
    put_row(row + 2u, vec4u(planes[2], planes[3]));
    put_row(row + 3u, vec4u(planes[4], children));
    // Children only have a least depth.
    return vec3f(high.xy, low.z);
}
