// The point of a receiver over the light's view, and the children of nodes that contain it. Calls
// tree_walk.wgsl.

const FACE_STEP = 3.0;
// That of rects.wgsl.
const TEST_ERROR = 1.9073486e-6;
const GUARDS = vec2u(0x80808080u);
const ONES = 0x01010101u;
const ROWS = 4u;

// Position on the faces in a strip, and depth.
struct Ray {
    point: vec3f,
}

fn ray_of(o: vec3f, d: vec3f) -> Ray {
    let at = frame_point(o);
    return Ray(vec3f(at.on_face + vec2f(FACE_STEP * f32(at.face), 0.0), at.depth));
}

// Returns the top bits of four bytes as four bits.
fn top_bits(word: u32) -> u32 {
    return (((word >> 7u) & ONES) * 0x01020408u) >> 24u;
}

// Returns the children of a node that contain a point and begin before it, as bits.
fn children_at(node: u32, ray: Ray) -> u32 {
    walked += 1u;
    let first = nodes[4u * node];
    let inverse = bitcast<vec3f>(((vec3u(first.w) >> vec3u(0u, 8u, 16u)) & vec3u(0xffu)) << vec3u(23u));
    let difference = ray.point - bitcast<vec3f>(first.xyz);
    let steps = difference * inverse;
    // A 64th of a step is more than the rounding of differences. Under a directional light, the
    // error of the triangle test is added; for a point light it is part of the rectangles.
    let error = select(TEST_ERROR * max(difference.z, 0.0), 0.0, kernel.tiles.z == 1u);
    let slack = error * inverse + 0.015625;
    let up = floor(steps + slack);
    let down = ceil(steps.xy - slack.xy);
    if any(up < vec3f(0.0)) || any(down > vec2f(127.0)) {
        return 0u;
    }
    let least = vec3u(min(up, vec3f(127.0)));
    let greatest = vec2u(max(down, vec2f(0.0)));
    let across = nodes[4u * node + 1u];
    let along = nodes[4u * node + 2u];
    let depth = nodes[4u * node + 3u];
    let begun = ((vec2u(least.x * ONES) | GUARDS) - across.xy) & ((vec2u(least.y * ONES) | GUARDS) - along.xy);
    let not_over = (across.zw - greatest.x * ONES) & (along.zw - greatest.y * ONES);
    let all_of = begun & not_over & ((vec2u(least.z * ONES) | GUARDS) - depth.xy);
    return top_bits(all_of.x) | (top_bits(all_of.y) << 4u);
}
