// Pieces of a caster: strips across the longer side of its outline, each with a rectangle of its
// own. A long caster across the axes fills little of its rectangle (Ernst and Greiner 2007, "Early
// Split Clipping for Bounding Volume Hierarchies"). Calls shapes.wgsl.

struct Rect {
    low: vec2f,
    high: vec2f,
    nearest: f32,
    is_there: bool,
}

// Greatest number of pieces of a caster.
const MOST_PIECES = 32u;

// A caster's allowance: a multiple of its area, and at least this part of its share of the face. At
// most its share.
const ALLOWED_AREA = 4.0;
const LEAST_SHARE = 0.01;

// Steps by which casters are divided less and less, until there are few enough references: waste
// of a quarter of the allowance at step 0, and twice as much at each further one.
const STEPS = 15u;
const FIRST_RATIO = 2.0;
const RATIO_STEP = 0.70710678;

// Returns the number of pieces at step 0, possibly fractional. The sum of all rectangles, for a
// number of pieces, is least if each number follows the root of the waste.
fn piece_ratio(shape: Shape) -> f32 {
    if shape.is_box {
        return 0.0;
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
    let share = select(4.0 * view.face.y * view.face.z, 24.0, is_lamp()) / f32(made.casters);
    let allowed = min(share, ALLOWED_AREA * area + LEAST_SHARE * share);
    return FIRST_RATIO * sqrt(max(waste, 0.0) / allowed);
}

// Returns the number of pieces from a ratio of the current step.
fn pieces_of(ratio: f32) -> u32 {
    return clamp(u32(ratio), 1u, MOST_PIECES);
}

// Error of a crossing with a strip's side, as a fraction of the caster's length: 8 roundings.
const CROSSING_ERROR = 4.7683716e-7;

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
    // Crossings are inexact by some roundings of the length.
    let around = shape.around + long * CROSSING_ERROR;
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
        // What is beyond the rim is on it: the lookup adds margins for receivers at the rim.
        let start = clamp(low.xy, vec2f(-1.0), vec2f(1.0));
        let stop = clamp(high.xy, vec2f(-1.0), vec2f(1.0));
        let is_within = all(low.xy <= vec2f(shape.rim)) && all(high.xy >= vec2f(-shape.rim));
        // Sums are monotonic when rounded, so a point in the rectangle remains in it.
        return Rect(start + shift, stop + shift, shape.nearest, is_within);
    }
    let nearest = select(low.z - shape.depth_margin, shape.nearest, shape.grazes);
    return Rect(low.xy, high.xy, nearest, true);
}
