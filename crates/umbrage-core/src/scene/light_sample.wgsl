// Twin of light_sample.rs: the end points of shadow rays on a light.

const LIGHT_DIRECTION = 0u;
const LIGHT_CAP = 1u;
const LIGHT_POINT = 2u;
const LIGHT_RECT = 3u;
const LIGHT_DISC = 4u;
const LIGHT_BALL = 5u;

const LIGHT_SHORT: f32 = 1.0 - 1.0 / 16384.0;
const LIGHT_LIFT: f32 = 1.0 / 1048576.0;

struct LightSampler {
    shape: vec4u,
    center: vec4f,
    half_u: vec4f,
    half_v: vec4f,
}

fn small_sin(x: f32) -> f32 {
    let q = x * x;
    let last = -1.984127e-4 + product(q, 2.755732e-6);
    return x * (1.0 + product(q, -1.6666667e-1 + product(q, 8.333333e-3 + product(q, last))));
}

fn small_cos(x: f32) -> f32 {
    let q = x * x;
    let last = -1.3888889e-3 + product(q, 2.4801587e-5);
    return 1.0 + product(q, -0.5 + product(q, 4.1666668e-2 + product(q, last)));
}

fn disc_point(uv: vec2f) -> vec2f {
    let quarter_pi = 0.7853981633974483f;
    let a = 2.0 * uv.x - 1.0;
    let b = 2.0 * uv.y - 1.0;
    if a == 0.0 && b == 0.0 {
        return vec2f(0.0, 0.0);
    }
    if abs(a) > abs(b) {
        let angle = quarter_pi * quotient(b, a);
        return vec2f(a * small_cos(angle), a * small_sin(angle));
    }
    let angle = quarter_pi * quotient(a, b);
    return vec2f(b * small_sin(angle), b * small_cos(angle));
}

fn tangent(n: vec3f) -> vec3f {
    let sign = select(-1.0, 1.0, n.z >= 0.0);
    let a = quotient(-1.0, sign + n.z);
    return vec3f(1.0 + product(sign * n.x * n.x, a), sign * (n.x * n.y * a), -sign * n.x);
}

fn bitangent(n: vec3f) -> vec3f {
    let sign = select(-1.0, 1.0, n.z >= 0.0);
    let a = quotient(-1.0, sign + n.z);
    return vec3f(n.x * n.y * a, sign + product(n.y * n.y, a), -n.y);
}

fn cap_direction(axis: vec3f, u: vec3f, v: vec3f, cap: f32, q: vec2f) -> vec3f {
    let h = product(product(q.x, q.x) + product(q.y, q.y), cap);
    let side = root(cap * (2.0 - h));
    return product3(axis, vec3f(1.0 - h)) + product3(u, vec3f(q.x * side)) + product3(v, vec3f(q.y * side));
}

fn segment(s: LightSampler, p: vec3f, uv: vec2f, far: f32) -> vec3f {
    let center = s.center.xyz;
    let u = s.half_u.xyz;
    let v = s.half_v.xyz;
    let kind = s.shape.x;
    if kind == LIGHT_DIRECTION {
        return center * far;
    }
    if kind == LIGHT_CAP {
        return cap_direction(center, u, v, s.half_u.w, disc_point(uv)) * far;
    }
    let to_center = center - p;
    if kind == LIGHT_POINT {
        return to_center * LIGHT_SHORT;
    }
    if kind == LIGHT_RECT {
        return (to_center + product3(u, vec3f(2.0 * uv.x - 1.0)) + product3(v, vec3f(2.0 * uv.y - 1.0))) * LIGHT_SHORT;
    }
    let q = disc_point(uv);
    if kind == LIGHT_DISC {
        return (to_center + product3(u, vec3f(q.x)) + product3(v, vec3f(q.y))) * LIGHT_SHORT;
    }
    let n = unit3(to_center);
    let r = q * s.half_u.w;
    return (to_center + product3(tangent(n), vec3f(r.x)) + product3(bitangent(n), vec3f(r.y))) * LIGHT_SHORT;
}

fn origin_offset(p: vec3f, reach: f32) -> f32 {
    return max(max(max(abs(p.x), abs(p.y)), abs(p.z)), reach) * LIGHT_LIFT;
}

fn ray_origin(p: vec3f, n: vec3f, eye: vec3f, plane_reach: f32) -> vec3f {
    let to_eye = abs(eye - p);
    let reach = max(max(max(to_eye.x, to_eye.y), to_eye.z), plane_reach);
    let lift = origin_offset(p, reach);
    return vec3f(p.x + product(n.x, lift), p.y + product(n.y, lift), p.z + product(n.z, lift));
}

fn hash(word: u32) -> u32 {
    var x = word;
    x ^= x >> 16u;
    x *= 0x7feb352du;
    x ^= x >> 15u;
    x *= 0x846ca68bu;
    x ^= x >> 16u;
    return x;
}

fn seed(x: u32, y: u32) -> u32 {
    return hash(x + hash(y + 0x9e3779b9u));
}

fn owen(reversed: u32, seed: u32) -> u32 {
    var x = reversed;
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16u) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

fn sobol_second(i: u32) -> u32 {
    var rest = i;
    var direction = 0x80000000u;
    var bits = 0u;
    while rest != 0u {
        if (rest & 1u) == 1u {
            bits ^= direction;
        }
        direction ^= direction >> 1u;
        rest >>= 1u;
    }
    return bits;
}

fn unit_square(i: u32, seed: u32) -> vec2f {
    let x = reverseBits(owen(i, seed));
    let y = reverseBits(owen(reverseBits(sobol_second(i)), hash(seed ^ 0x68bc21ebu)));
    return vec2f(f32(x >> 8u), f32(y >> 8u)) * (1.0 / 16777216.0);
}
