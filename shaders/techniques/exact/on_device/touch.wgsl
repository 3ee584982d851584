// Part of a light's grid that a caster touches, like light_frame.rs and touches.rs. It uses device
// arithmetic, whose rounding is within the margins.

struct ListsGrid {
    // Frame space's origin, world space; w: error of the triangle test.
    origin: vec4f,
    // Rows of the matrix from the world, relative to the origin, to frame space. w: the least
    // margin across the rays.
    across: vec4f,
    // w: the margin in depth.
    down: vec4f,
    // w: value subtracted from a directional light's depth.
    away: vec4f,
    // Half the size of a face, across and down; tiles per unit of a direction; distance from a
    // point light within which casters may be anywhere.
    face: vec4f,
    // Number of tiles of a face, across and down; 1 if the light has a position; greatest number of
    // cells along a tile's side, as a power of two.
    tiles: vec4u,
}

// Number of steps along a tile's side, as a power of two.
const STEPS = 12u;
// A point's greatest coordinate is at least this fraction of its distance.
const COORDINATE = 0.577;
const NO_FACE = 7u;

struct Touch {
    face: u32,
    // Bounding box of the caster on the face, in steps, inclusive.
    low: vec2u,
    high: vec2u,
    // Least depth, minus the margin.
    nearest: f32,
}

fn is_lamp() -> bool {
    return grid.tiles.z == 1u;
}

fn faces() -> u32 {
    return select(1u, 6u, is_lamp());
}

fn frame_point(p: vec3f) -> vec3f {
    let v = p - grid.origin.xyz;
    if is_lamp() {
        return v;
    }
    return vec3f(dot3(grid.across.xyz, v), dot3(grid.down.xyz, v), dot3(grid.away.xyz, v) - grid.away.w);
}

// Rotates to coordinates across and down a face of the cube around a point light, and along its
// axis.
fn turned(v: vec3f, face: u32) -> vec3f {
    let sign = select(1.0, -1.0, (face & 1u) == 1u);
    let axis = face / 2u;
    if axis == 0u {
        return vec3f(v.y, v.z, sign * v.x);
    }
    if axis == 1u {
        return vec3f(v.z, v.x, sign * v.y);
    }
    return vec3f(v.x, v.y, sign * v.z);
}

// Returns a lower bound of the distance between the origin and a triangle: that of its bounding
// box.
fn distance_to_origin(corners: array<vec3f, 3>) -> f32 {
    let low = min(min(corners[0], corners[1]), corners[2]);
    let high = max(max(corners[0], corners[1]), corners[2]);
    return length(max(low, vec3f(0.0)) + min(high, vec3f(0.0)));
}

fn margin(distance: f32) -> f32 {
    if !is_lamp() {
        return grid.across.w + grid.origin.w;
    }
    return grid.across.w + grid.origin.w / (distance * COORDINATE);
}

// `before` returns the depth minus the margin, `behind` the depth plus the margin.
fn before(depth: f32) -> f32 {
    if is_lamp() {
        return depth * (1.0 - grid.down.w) - grid.origin.w;
    }
    return depth - grid.down.w;
}

fn behind(depth: f32) -> f32 {
    if is_lamp() {
        return depth * (1.0 + grid.down.w) + grid.origin.w;
    }
    return depth + grid.down.w;
}

fn touch_in_box(face: u32, low: vec2f, high: vec2f, nearest: f32) -> Touch {
    let steps_a_unit = grid.face.z * f32(1u << STEPS);
    let end = vec2i(grid.tiles.xy << vec2u(STEPS));
    let limit = vec2f(1e6);
    let first = vec2i(floor(clamp((low + grid.face.xy) * steps_a_unit, -limit, limit)));
    let last = vec2i(floor(clamp((high + grid.face.xy) * steps_a_unit, -limit, limit)));
    let misses = any(last < vec2i(0)) || any(first >= end);
    let inside = vec2u(max(first, vec2i(0)));
    return Touch(select(face, NO_FACE, misses), inside, vec2u(clamp(last, vec2i(0), end - 1)), max(before(nearest), 0.0));
}

// Projects to a point light's face with the pyramid around it. The result is empty if all corners
// are beyond one of its sides. If some are behind the light, it is the whole face. Otherwise it is
// the bounding box of the corners.
fn touch_on_cube(face: u32, corners: array<vec3f, 3>, distance: f32) -> Touch {
    let around = margin(distance);
    let rim = 1.0 + 2.0 * around;
    let a = turned(corners[0], face);
    let b = turned(corners[1], face);
    let c = turned(corners[2], face);
    let ends = vec3f(a.z, b.z, c.z) * rim;
    let x = vec3f(a.x, b.x, c.x);
    let y = vec3f(a.y, b.y, c.y);
    if all(x > ends) || all(-x > ends) || all(y > ends) || all(-y > ends) {
        return Touch(NO_FACE, vec2u(0u), vec2u(0u), 0.0);
    }
    let nearest = max(distance * COORDINATE, min(min(a.z, b.z), c.z));
    if any(ends <= vec3f(0.0)) {
        return touch_in_box(face, vec2f(-1.0), vec2f(1.0), nearest);
    }
    let p = a.xy / a.z;
    let q = b.xy / b.z;
    let r = c.xy / c.z;
    return touch_in_box(face, min(min(p, q), r) - around, max(max(p, q), r) + around, nearest);
}

fn touch_on(face: u32, corners: array<vec3f, 3>) -> Touch {
    if is_lamp() {
        let distance = distance_to_origin(corners);
        if distance < grid.face.w {
            return touch_in_box(face, vec2f(-1.0), vec2f(1.0), 0.0);
        }
        return touch_on_cube(face, corners, distance);
    }
    let low = min(min(corners[0], corners[1]), corners[2]);
    let high = max(max(corners[0], corners[1]), corners[2]);
    let around = margin(0.0);
    return touch_in_box(0u, low.xy - around, high.xy + around, low.z);
}
