// Nodes in the world: boxes. Calls tree_blocks.wgsl and world_boxes.wgsl.

fn size_of(low: vec3f, high: vec3f) -> f32 {
    return half_surface(max(high - low, vec3f(0.0)));
}

// Returns the position, and the size.
fn keys_of(i: u32) -> vec4f {
    if !is_item(i) {
        return vec4f(NOTHING);
    }
    return vec4f(lows[i] + highs[i], size_of(lows[i], highs[i]));
}

fn load_reference(at: u32, lane: u32) {
    let reference = references[values[at]];
    ids[at] = reference.x;
    if reference.y == NO_REFERENCE {
        return;
    }
    let part = piece_of(corners_of(reference.x), reference.y & 0xffffu, reference.y >> 16u);
    lows[lane] = part.low;
    highs[lane] = part.high;
}

// Five rows: low corner and exponents, then 8 bits for each of 8 children's low and high corners,
// then the children's numbers. Returns the high corner as a child.
fn put_node(node: u32, first: u32, low: vec3f, high: vec3f) -> vec3f {
    let exponents = vec3u(
        inverse_exponent(high.x - low.x),
        inverse_exponent(high.y - low.y),
        inverse_exponent(high.z - low.z),
    );
    let inverse = bitcast<vec3f>(exponents << vec3u(23u));
    var planes: array<vec2u, 6>;
    var children = vec2u(0u);
    for (var i = 0u; i < 8u; i++) {
        var least = vec3u(255u);
        var most = vec3u(0u);
        if is_item(first + i) {
            // A 32nd of a step is more than the rounding of differences.
            least = vec3u(clamp(floor((lows[first + i] - low) * inverse - 0.03125), vec3f(0.0), vec3f(127.0)));
            most = vec3u(clamp(ceil((highs[first + i] - low) * inverse + 0.03125), vec3f(0.0), vec3f(127.0)));
        }
        let word = i / 4u;
        let shift = 8u * (i % 4u);
        planes[0][word] |= least.x << shift;
        planes[1][word] |= least.y << shift;
        planes[2][word] |= least.z << shift;
        planes[3][word] |= most.x << shift;
        planes[4][word] |= most.y << shift;
        planes[5][word] |= most.z << shift;
        children[i / 5u] |= item_numbers[first + i] << (6u * (i % 5u));
    }
    let packed = exponents.x | (exponents.y << 8u) | (exponents.z << 16u);
    nodes[5u * node] = vec4u(bitcast<vec3u>(low), packed);
    nodes[5u * node + 1u] = vec4u(planes[0], planes[1]);
    nodes[5u * node + 2u] = vec4u(planes[2], planes[3]);
    nodes[5u * node + 3u] = vec4u(planes[4], planes[5]);
    nodes[5u * node + 4u] = vec4u(children, 0u, 0u);
    return high;
}
