// Bounding rectangles and least depths of a caster's pieces on a face around the light, with the
// margins of touch.wgsl. Calls touch.wgsl of the library.
//
// A long caster across the axes fills little of its rectangle. It is divided into strips across its
// longer side, each with a rectangle of its own (Ernst and Greiner 2007, "Early Split Clipping for
// Bounding Volume Hierarchies").

struct Rect {
    low: vec2f,
    high: vec2f,
    nearest: f32,
    is_there: bool,
}

// A caster on a face.
struct Shape {
    // Across, down, and depth of a directional light's corners.
    corners: array<vec3f, 3>,
    around: f32,
    nearest: f32,
    // Greatest depth of a caster of a point light that is not divided at its pyramid.
    farthest: f32,
    is_there: bool,
    // True if a computed hit may have the depth of any of its points.
    grazes: bool,
    // True if it is not divided: the first two corners are those of its rectangle.
    is_box: bool,
}

// Rounding of a position relative to a directional light, of casters and receivers: 16 roundings of
// 1. And that of the triangle test, as a fraction of the distance between the receiver and the
// farthest corner: 32 roundings, four times the bound of ray_triangle.rs. The caster's length is
// added to its rectangle, the distance by the lookup.
const LEAST_AROUND = 9.5367432e-7;
const TEST_ERROR = 1.9073486e-6;

// The faces of a point light are beside one another in a strip.
const FACE_STEP = 3.0;
// Value of a caster that may be anywhere on all faces.
const EVERYWHERE = 7u;
// Greatest number of pieces of a caster.
const MOST_PIECES = 32.0;

// Number of workgroups in a row of a dispatch.
const GROUPS_A_ROW = 32768u;

// Waste from which a caster is divided, as a multiple of its allowance. A higher one gives fewer
// references.
override WASTE: f32 = 1.0;
// A caster's allowance: a multiple of its area, and at least this part of its share of the face. At
// most its share.
const ALLOWED_AREA = 4.0;
const LEAST_SHARE = 0.01;

fn no_rect() -> Rect {
    return Rect(vec2f(3e38), vec2f(-3e38), 3e38, false);
}

// Returns how far a point is within the pyramid of a face, for one of its four sides.
fn within_side(p: vec3f, side: u32, rim: f32) -> f32 {
    let across = select(p.x, p.y, side >= 2u);
    return p.z * rim - select(across, -across, (side & 1u) == 1u);
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
            if p_in >= 0.0 && kept < 8u {
                clipped[kept] = p;
                kept += 1u;
            }
            if (p_in < 0.0) != (q_in < 0.0) && kept < 8u {
                clipped[kept] = p + (q - p) * (p_in / (p_in - q_in));
                kept += 1u;
            }
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
    if distance < grid.face.w {
        out.is_there = true;
        out.is_box = true;
        out.corners[0] = vec3f(-1.0, -1.0, 0.0);
        out.corners[1] = vec3f(1.0, 1.0, 0.0);
        return out;
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
    out.farthest = behind(max(max(a.z, b.z), c.z));
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
    out.around = LEAST_AROUND + TEST_ERROR * longest;
    out.nearest = max(min(min(corners[0].z, corners[1].z), corners[2].z) - out.around, 0.0);
    out.is_there = true;
    // Depths of computed hits are those of points at most a 1024th of the length away, unless the
    // light grazes the caster.
    out.grazes = abs(u.x * v.y - u.y * v.x) < longest * longest * (1.0 / 1024.0);
    return out;
}

// Returns the number of pieces. The sum of all rectangles, for a number of pieces, is least if each
// number follows the root of the waste.
fn pieces_of(shape: Shape) -> u32 {
    if shape.is_box {
        return 1u;
    }
    let a = shape.corners[0].xy;
    let b = shape.corners[1].xy;
    let c = shape.corners[2].xy;
    let rim = select(vec2f(3e38), vec2f(1.0), is_lamp());
    let low = max(min(min(a, b), c), -rim);
    let high = min(max(max(a, b), c), rim);
    let size = max(high - low, vec2f(0.0));
    let u = b - a;
    let v = c - a;
    let area = 0.5 * abs(u.x * v.y - u.y * v.x);
    let waste = size.x * size.y - area;
    let share = select(4.0 * grid.face.x * grid.face.y, 24.0, is_lamp()) / f32(made.casters);
    let allowed = min(share, ALLOWED_AREA * area + LEAST_SHARE * share);
    return u32(clamp(sqrt(max(waste, 0.0) / (WASTE * allowed)), 1.0, MOST_PIECES));
}

struct Part {
    low: vec3f,
    high: vec3f,
}

// Returns the bounds of the part of a triangle between two values of x.
fn clip_to_strip(corners: array<vec3f, 3>, first: f32, last: f32) -> Part {
    var low = vec3f(3e38);
    var high = vec3f(-3e38);
    for (var i = 0u; i < 3u; i++) {
        let p = corners[i];
        let q = corners[(i + 1u) % 3u];
        if p.x >= first && p.x <= last {
            low = min(low, p);
            high = max(high, p);
        }
        let step = q - p;
        for (var end = 0u; end < 2u; end++) {
            let at = select(first, last, end == 1u);
            if (p.x < at) != (q.x < at) {
                let crossing = vec3f(at, p.yz + step.yz * ((at - p.x) / step.x));
                low = min(low, crossing);
                high = max(high, crossing);
            }
        }
    }
    return Part(low, high);
}

// Returns the rectangle of piece `number` of `count`.
fn rect_of(face: u32, shape: Shape, number: u32, count: u32) -> Rect {
    if face == EVERYWHERE {
        return Rect(vec2f(-1.0), vec2f(5.0 * FACE_STEP + 1.0, 1.0), 0.0, true);
    }
    let shift = vec2f(FACE_STEP * f32(face), 0.0);
    if shape.is_box {
        return Rect(shape.corners[0].xy + shift, shape.corners[1].xy + shift, shape.nearest, true);
    }
    var corners = shape.corners;
    let lowest = min(min(corners[0], corners[1]), corners[2]);
    let highest = max(max(corners[0], corners[1]), corners[2]);
    let size = highest - lowest;
    let is_across = size.x >= size.y;
    if !is_across {
        for (var i = 0u; i < 3u; i++) {
            corners[i] = corners[i].yxz;
        }
    }
    let begin = select(lowest.y, lowest.x, is_across);
    let long = select(size.y, size.x, is_across);
    let around = shape.around;
    let wider = around + long * (1.0 / 512.0);
    let first = begin + long * (f32(number) / f32(count)) - wider;
    let last = begin + long * (f32(number + 1u) / f32(count)) + wider;
    let part = clip_to_strip(corners, first, last);
    var low = part.low;
    var high = part.high;
    if !is_across {
        low = low.yxz;
        high = high.yxz;
    }
    low -= around;
    high += around;
    if is_lamp() {
        let start = max(low.xy, vec2f(-1.0));
        let stop = min(high.xy, vec2f(1.0));
        // Sums are monotonic when rounded, so a point in the rectangle remains in it.
        return Rect(start + shift, stop + shift, shape.nearest, all(start <= stop));
    }
    let nearest = select(max(low.z, 0.0), shape.nearest, shape.grazes);
    return Rect(low.xy, high.xy, nearest, true);
}

fn corners_of(id: u32) -> array<vec3f, 3> {
    var out: array<vec3f, 3>;
    for (var i = 0u; i < 3u; i++) {
        out[i] = frame_point(corners[3u * id + i].xyz);
    }
    return out;
}
