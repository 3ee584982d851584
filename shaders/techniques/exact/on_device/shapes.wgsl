// Outlines and least depths of casters on a face around the light, with margins: a receiver whose
// ray may be found to hit the caster is in the outline, and not before the least depth.

// A caster on a face.
struct Shape {
    // Across, down, and depth of a directional light's corners.
    corners: array<vec3f, 3>,
    around: f32,
    // Margin of a directional light's depths.
    before: f32,
    nearest: f32,
    is_there: bool,
    // True if a computed hit may have the depth of any of its points.
    grazes: bool,
    // True if it is not divided: the first two corners are those of its rectangle.
    is_box: bool,
}

// Error of the triangle test, as a fraction of the distance between the receiver and the farthest
// corner: 32 roundings, see light_frame.rs. A caster's length is added to its outline, the distance
// by the lookup.
const TEST_ERROR = 1.9073486e-6;
// Twice the area of a caster that the light grazes, at most, over its longest side squared.
const GRAZING = 0.001953125;
// Margin of the depth of a computed hit, as a fraction of the longest side, see light_frame.rs.
const SHIFT_DEPTH = 0.001953125;
const GRAZING_SHIFT_DEPTH = 1.5;

// The faces of a point light are next to each other in a strip.
const FACE_STEP = 3.0;
// Value of a caster that may be anywhere on all faces.
const EVERYWHERE = 7u;

// Returns how far a point is within the pyramid of a face, for one of its four sides.
fn within_side(p: vec3f, side: u32, rim: f32) -> f32 {
    let across = select(p.x, p.y, side >= 2u);
    return p.z * rim - select(across, -across, (side & 1u) == 1u);
}

fn whole_face(nearest: f32) -> Shape {
    var out: Shape;
    out.is_there = true;
    out.is_box = true;
    out.nearest = max(before(nearest), 0.0);
    out.corners[0] = vec3f(-1.0, -1.0, 0.0);
    out.corners[1] = vec3f(1.0, 1.0, 0.0);
    return out;
}

// Returns the rectangle of the part of a caster in a face's pyramid, if some of its corners are
// behind the light (Sutherland and Hodgman 1974, "Reentrant Polygon Clipping").
fn clipped_to_pyramid(shape: Shape, rim: f32) -> Shape {
    var out = shape;
    var polygon: array<vec3f, 8>;
    for (var i = 0u; i < 3u; i++) {
        polygon[i] = shape.corners[i];
    }
    var count = 3u;
    for (var side = 0u; side < 4u; side++) {
        var clipped: array<vec3f, 8>;
        var kept = 0u;
        for (var i = 0u; i < count; i++) {
            let p = polygon[i];
            let q = polygon[select(i + 1u, 0u, i + 1u == count)];
            let p_in = within_side(p, side, rim);
            let q_in = within_side(q, side, rim);
            if p_in >= 0.0 {
                clipped[min(kept, 7u)] = p;
                kept += 1u;
            }
            if (p_in < 0.0) != (q_in < 0.0) {
                clipped[min(kept, 7u)] = p + (q - p) * (p_in / (p_in - q_in));
                kept += 1u;
            }
        }
        if kept > 8u {
            // Rounding made the polygon concave.
            return whole_face(shape.nearest);
        }
        polygon = clipped;
        count = kept;
    }
    var low = vec3f(3e38);
    var high = vec2f(-3e38);
    for (var i = 0u; i < count; i++) {
        let p = polygon[i];
        let on_face = clamp(p.xy / max(p.z, 1e-30), vec2f(-1.0), vec2f(1.0));
        low = min(low, vec3f(on_face, p.z));
        high = max(high, on_face);
    }
    out.is_there = count > 0u;
    out.is_box = true;
    out.nearest = max(before(max(low.z, shape.nearest)), 0.0);
    out.corners[0] = vec3f(max(low.xy - shape.around, vec2f(-1.0)), 0.0);
    out.corners[1] = vec3f(min(high + shape.around, vec2f(1.0)), 0.0);
    return out;
}

fn shape_on_cube(face: u32, corners: array<vec3f, 3>) -> Shape {
    var out: Shape;
    out.corners = corners;
    let distance = distance_to_origin(corners);
    if distance < view.face.w {
        return whole_face(0.0);
    }
    out.around = margin(distance);
    let rim = 1.0 + 2.0 * out.around;
    let a = turned(corners[0], face);
    let b = turned(corners[1], face);
    let c = turned(corners[2], face);
    let ends = vec3f(a.z, b.z, c.z) * rim;
    let x = vec3f(a.x, b.x, c.x);
    let y = vec3f(a.y, b.y, c.y);
    if all(x > ends) || all(-x > ends) || all(y > ends) || all(-y > ends) {
        return out;
    }
    out.is_there = true;
    if any(ends <= vec3f(0.0)) {
        out.corners[0] = a;
        out.corners[1] = b;
        out.corners[2] = c;
        out.nearest = distance * COORDINATE;
        return clipped_to_pyramid(out, rim);
    }
    out.nearest = max(before(max(distance * COORDINATE, min(min(a.z, b.z), c.z))), 0.0);
    out.corners[0] = vec3f(a.xy / a.z, 0.0);
    out.corners[1] = vec3f(b.xy / b.z, 0.0);
    out.corners[2] = vec3f(c.xy / c.z, 0.0);
    return out;
}

fn shape_of(face: u32, corners: array<vec3f, 3>) -> Shape {
    if is_lamp() {
        return shape_on_cube(face, corners);
    }
    var out: Shape;
    out.corners = corners;
    let u = corners[1] - corners[0];
    let v = corners[2] - corners[0];
    let longest = max(max(length(u), length(v)), length(u - v));
    out.around = view.across.w + TEST_ERROR * longest;
    // A computed hit is at a point of the caster whose depth may be that of any point if the light
    // grazes it, see light_frame.rs.
    out.grazes = abs(u.x * v.y - u.y * v.x) < longest * longest * GRAZING;
    out.before = out.around + longest * select(SHIFT_DEPTH, GRAZING_SHIFT_DEPTH, out.grazes);
    out.nearest = min(min(corners[0].z, corners[1].z), corners[2].z) - out.before;
    out.is_there = true;
    return out;
}
