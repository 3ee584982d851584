// Boxes of casters' pieces in the world.

struct World {
    low: vec4f,
    // w: error of the triangle test, metres.
    high: vec4f,
}

@group(0) @binding(0) var<uniform> world: World;

// Number of workgroups in a row of a dispatch.
const GROUPS_A_ROW = 32768u;
const MOST_PIECES = 32.0;
const ALLOWED_AREA = 4.0;
const LEAST_SHARE = 0.01;
override WASTE: f32 = 1.0;

fn half_surface(size: vec3f) -> f32 {
    return size.x * size.y + size.y * size.z + size.z * size.x;
}

fn corners_of(id: u32) -> array<vec3f, 3> {
    return array<vec3f, 3>(corners[3u * id].xyz, corners[3u * id + 1u].xyz, corners[3u * id + 2u].xyz);
}

fn pieces_of(points: array<vec3f, 3>) -> u32 {
    let low = min(min(points[0], points[1]), points[2]);
    let high = max(max(points[0], points[1]), points[2]);
    let n = abs(cross(points[1] - points[0], points[2] - points[0])) * 0.5;
    let waste = half_surface(high - low) - n.x - n.y - n.z;
    let share = half_surface(world.high.xyz - world.low.xyz) / f32(made.casters);
    let area = n.x + n.y + n.z;
    let allowed = min(share, ALLOWED_AREA * area + LEAST_SHARE * share);
    return u32(clamp(sqrt(max(waste, 0.0) / (WASTE * allowed)), 1.0, MOST_PIECES));
}

struct Part {
    low: vec3f,
    high: vec3f,
}

fn turned_to(v: vec3f, axis: u32) -> vec3f {
    return select(select(v.zxy, v.yzx, axis == 1u), v, axis == 0u);
}

fn turned_back(v: vec3f, axis: u32) -> vec3f {
    return select(select(v.yzx, v.zxy, axis == 1u), v, axis == 0u);
}

fn piece_of(points: array<vec3f, 3>, number: u32, count: u32) -> Part {
    let lowest = min(min(points[0], points[1]), points[2]);
    let highest = max(max(points[0], points[1]), points[2]);
    let size = highest - lowest;
    let around = world.high.w + 2e-7 * max(max(abs(lowest.x), abs(lowest.y)), abs(lowest.z));
    if count == 1u {
        return Part(lowest - around, highest + around);
    }
    let axis = select(select(2u, 1u, size.y >= size.z), 0u, size.x >= max(size.y, size.z));
    let begin = turned_to(lowest, axis).x;
    let long = turned_to(size, axis).x;
    let wider = around + long * (1.0 / 512.0);
    let first = begin + long * (f32(number) / f32(count)) - wider;
    let last = begin + long * (f32(number + 1u) / f32(count)) + wider;
    var low = vec3f(3e38);
    var high = vec3f(-3e38);
    for (var i = 0u; i < 3u; i++) {
        let p = turned_to(points[i], axis);
        let q = turned_to(points[(i + 1u) % 3u], axis);
        if p.x >= first && p.x <= last {
            low = min(low, p);
            high = max(high, p);
        }
        for (var end = 0u; end < 2u; end++) {
            let at = select(first, last, end == 1u);
            if (p.x < at) != (q.x < at) {
                let crossing = vec3f(at, p.yz + (q.yz - p.yz) * ((at - p.x) / (q.x - p.x)));
                low = min(low, crossing);
                high = max(high, crossing);
            }
        }
    }
    return Part(turned_back(low, axis) - around, turned_back(high, axis) + around);
}
