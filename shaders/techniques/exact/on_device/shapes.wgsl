// Outlines and least depths of casters on a face around the light, with margins: a receiver whose
// ray may be found to hit the caster is in the outline, and not before the least depth.

// A caster on a face.
struct Shape {
    // Across, down, and depth of a directional light's corners.
    corners: array<vec3f, 3>,
    around: f32,
    // Margin of a directional light's depths, and of a caster that is clipped to a pyramid.
    depth_margin: f32,
    nearest: f32,
    // Rim of a point light's face, beyond which no receiver on the face may hit the caster.
    rim: f32,
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
// Margin around a caster, on a face around a point light, from which on the caster covers the face.
// A smaller margin also means that rounding moves no hit behind the light.
const WIDEST = 0.25;
// Greatest error that the lookup adds around a point light: TEST_ERROR / LEAST_HIT.
const MOST_LOOKUP_ERROR = 0.125;
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

// Returns a shape that covers a face.
fn whole_face(nearest: f32) -> Shape {
    var out: Shape;
    out.is_there = true;
    out.is_box = true;
    out.nearest = nearest;
    out.corners[0] = vec3f(-1.0, -1.0, 0.0);
    out.corners[1] = vec3f(1.0, 1.0, 0.0);
    return out;
}

// Returns the length of a caster's longest side.
fn longest_side(corners: array<vec3f, 3>) -> f32 {
    let u = corners[1] - corners[0];
    let v = corners[2] - corners[0];
    return max(max(length(u), length(v)), length(u - v));
}

// Returns a depth around a point light minus margins: a fraction of it, and an absolute one.
fn depth_before(depth: f32, margin: f32) -> f32 {
    return max(depth * (1.0 - view.down.w) - margin, 0.0);
}

// Returns the rectangle of the part of a caster in a face's pyramid, if some of its corners are
// behind the light (Sutherland and Hodgman 1974, "Reentrant Polygon Clipping").
fn clipped_to_pyramid(shape: Shape) -> Shape {
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
            let p_in = within_side(p, side, shape.rim);
            let q_in = within_side(q, side, shape.rim);
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
            return whole_face(depth_before(shape.nearest, shape.depth_margin));
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
    out.nearest = depth_before(max(low.z, shape.nearest), shape.depth_margin);
    out.corners[0] = vec3f(max(low.xy - shape.around, vec2f(-1.0)), 0.0);
    out.corners[1] = vec3f(min(high + shape.around, vec2f(1.0)), 0.0);
    return out;
}

// Returns whether a point light grazes a caster: the area across its rays is small for its longest
// side. A corner's ray has the angle to the plane whose sine is its distance over its length.
fn is_grazed(corners: array<vec3f, 3>, longest: f32) -> bool {
    let normal = cross(corners[1] - corners[0], corners[2] - corners[0]);
    let farthest = max(max(length(corners[0]), length(corners[1])), length(corners[2]));
    return abs(dot(normal, corners[0])) < longest * longest * GRAZING * farthest;
}

fn shape_on_cube(face: u32, corners: array<vec3f, 3>) -> Shape {
    var out: Shape;
    out.corners = corners;
    let longest = longest_side(corners);
    // A point's depth is at least this fraction of its distance.
    let least_depth = COORDINATE * distance_to_origin(corners);
    let error = TEST_ERROR * longest;
    // Compare before dividing: the light may be in the caster's box.
    if error >= WIDEST * least_depth {
        return whole_face(0.0);
    }
    out.around = view.across.w + error / least_depth;
    // The lookup adds the part of the error that grows with the receiver's distance, but stays on
    // the receiver's face. Double, since the coordinates across change with the face.
    let farthest_error = min(view.origin.w / least_depth, MOST_LOOKUP_ERROR);
    out.rim = 1.0 + 2.0 * (out.around + farthest_error);
    let a = turned(corners[0], face);
    let b = turned(corners[1], face);
    let c = turned(corners[2], face);
    let ends = vec3f(a.z, b.z, c.z) * out.rim;
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
        out.nearest = least_depth;
        let shift = select(SHIFT_DEPTH, GRAZING_SHIFT_DEPTH, is_grazed(corners, longest));
        out.depth_margin = error + longest * shift;
        return clipped_to_pyramid(out);
    }
    // A ray that hits begins behind the nearest corner: its own box test is exact.
    out.nearest = depth_before(max(least_depth, min(min(a.z, b.z), c.z)), 0.0);
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
    let longest = longest_side(corners);
    out.around = view.across.w + TEST_ERROR * longest;
    // A computed hit is at a point of the caster whose depth may be that of any point if the light
    // grazes it, see light_frame.rs.
    out.grazes = abs(u.x * v.y - u.y * v.x) < longest * longest * GRAZING;
    out.depth_margin = out.around + longest * select(SHIFT_DEPTH, GRAZING_SHIFT_DEPTH, out.grazes);
    out.nearest = min(min(corners[0].z, corners[1].z), corners[2].z) - out.depth_margin;
    out.is_there = true;
    return out;
}
