// Storage of touches between passes.

// A touch has four words: caster and face, the box's corners, and the least depth.
fn keep_touch(place: u32, id: u32, touch: Touch) {
    touches[place] = vec4u(
        id | (touch.face << 29u),
        touch.low.x | (touch.low.y << 16u),
        touch.high.x | (touch.high.y << 16u),
        bitcast<u32>(touch.nearest),
    );
}

fn kept_touch(place: u32) -> Touch {
    let words = touches[place];
    let low = vec2u(words.y & 0xffffu, words.y >> 16u);
    let high = vec2u(words.z & 0xffffu, words.z >> 16u);
    return Touch(words.x >> 29u, low, high, bitcast<f32>(words.w));
}

fn kept_id(place: u32) -> u32 {
    return touches[place].x & 0x1fffffffu;
}

// Touches of large casters are stored from the end on, each preceded by its edges.
fn large_place(number: u32) -> u32 {
    return made.touches - LARGE_TOUCH * (number + 1u);
}

fn keep_edges(place: u32, edges: Edges) {
    touches[place + 1u] = bitcast<vec4u>(edges.across);
    touches[place + 2u] = bitcast<vec4u>(edges.down);
    touches[place + 3u] = bitcast<vec4u>(edges.summand);
    touches[place + 4u] = vec4u(bitcast<vec2u>(edges.base), select(0u, 1u, edges.knows_depth), 0u);
}

fn kept_edges(place: u32) -> Edges {
    let rest = touches[place + 4u];
    return Edges(
        bitcast<vec4f>(touches[place + 1u]),
        bitcast<vec4f>(touches[place + 2u]),
        bitcast<vec4f>(touches[place + 3u]),
        bitcast<vec2f>(rest.xy),
        rest.z != 0u,
    );
}
