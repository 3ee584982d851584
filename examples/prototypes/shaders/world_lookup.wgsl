// A receiver's ray in the world, and the children of nodes that it enters. Calls tree_walk.wgsl.

const ROWS = 5u;

struct Ray {
    o: vec3f,
    inverse: vec3f,
}

fn ray_of(o: vec3f, d: vec3f) -> Ray {
    return Ray(o, slab_inverse(d));
}

fn bytes_of(word: u32) -> vec4f {
    return vec4f((vec4u(word) >> vec4u(0u, 8u, 16u, 24u)) & vec4u(0xffu));
}

// Returns which of four children a ray enters (Kay and Kajiya 1986).
fn entered(low: vec3u, high: vec3u, start: vec3f, step: vec3f) -> u32 {
    let ax = bytes_of(low.x) * step.x + start.x;
    let bx = bytes_of(high.x) * step.x + start.x;
    let ay = bytes_of(low.y) * step.y + start.y;
    let by = bytes_of(high.y) * step.y + start.y;
    let az = bytes_of(low.z) * step.z + start.z;
    let bz = bytes_of(high.z) * step.z + start.z;
    let entry = max(max(min(ax, bx), min(ay, by)), max(min(az, bz), vec4f(0.0)));
    let leave = min(min(max(ax, bx), max(ay, by)), min(max(az, bz), vec4f(1.0)));
    let hits = select(vec4u(0u), vec4u(1u, 2u, 4u, 8u), entry <= leave * 1.00001 + 1e-30);
    // Absent children are reversed.
    let is_there = select(vec4u(0u), vec4u(1u, 2u, 4u, 8u), bytes_of(low.x) <= bytes_of(high.x));
    let both = hits & is_there;
    return both.x | both.y | both.z | both.w;
}

fn children_at(node: u32, ray: Ray) -> u32 {
    walked += 1u;
    let first = nodes[5u * node];
    let exponents = (vec3u(first.w) >> vec3u(0u, 8u, 16u)) & vec3u(0xffu);
    let step = bitcast<vec3f>((vec3u(254u) - exponents) << vec3u(23u));
    // A 64th of a step is more than the rounding of differences.
    let start = (bitcast<vec3f>(first.xyz) - ray.o) * ray.inverse;
    let scaled = step * ray.inverse;
    let a = nodes[5u * node + 1u];
    let b = nodes[5u * node + 2u];
    let c = nodes[5u * node + 3u];
    let front = entered(vec3u(a.x, a.z, b.x), vec3u(b.z, c.x, c.z), start, scaled);
    let back = entered(vec3u(a.y, a.w, b.y), vec3u(b.w, c.y, c.w), start, scaled);
    return front | (back << 4u);
}
