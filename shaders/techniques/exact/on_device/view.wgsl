// A light's view: frame space and the faces around the light, like light_frame.rs. It uses device
// arithmetic, whose rounding is within the margins.

struct LightView {
    // 1 if the light has a position; half the size of a face, across and down; w is unused.
    face: vec4f,
    // Frame space's origin, world space; w: error of the triangle test for the farthest receivers.
    origin: vec4f,
    // Rows of the matrix from the world, relative to the origin, to frame space. w: the least
    // margin across the rays.
    across: vec4f,
    // w: the margin in depth from a point light, as a fraction of depth.
    down: vec4f,
    // w: value subtracted from a directional light's depth.
    away: vec4f,
}

// A point's greatest coordinate is at least this fraction of its distance.
const COORDINATE = 0.577;

fn is_lamp() -> bool {
    return view.face.x == 1.0;
}

fn faces() -> u32 {
    return select(1u, 6u, is_lamp());
}

fn frame_point(p: vec3f) -> vec3f {
    let v = p - view.origin.xyz;
    if is_lamp() {
        return v;
    }
    return vec3f(dot3(view.across.xyz, v), dot3(view.down.xyz, v), dot3(view.away.xyz, v) - view.away.w);
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
