// Outline of a caster relative to the light, like outline.rs, in 32 bits. The rounding errors are
// added to the margins.

// Error of products of a point light's directions: 8 roundings of 1. Those of a directional light
// are differences within the triangle, with a far smaller error.
const LAMP_SLACK = 4.8e-7;
// Greatest error of a plane, as a fraction of the depth margin, for which it is used. Edges of
// casters of few cells are recomputed in each pass, possibly with different rounding. The limit is
// lower when items are counted, so that the count is never too small. Edges of casters of many
// cells are computed once.
const FILLED_SLOPE = 0.5;
const COUNTED_SLOPE = 0.48;

fn exact_slope() -> f32 {
    return select(FILLED_SLOPE, COUNTED_SLOPE, DOES == COUNT);
}

// Functions on a face: three edges, and the plane's depth (one over it for a point light).
struct Edges {
    across: vec4f,
    down: vec4f,
    summand: vec4f,
    // Origin of a directional light's functions on the face.
    base: vec2f,
    knows_depth: bool,
}

// Returns one over a plane's depth from the point light, as a function on a face. w: 0 if
// differences of the corners are too inexact for that.
fn plane_of_lamp(face: u32, corners: array<vec3f, 3>) -> vec4f {
    let u = corners[1] - corners[0];
    let v = corners[2] - corners[0];
    let normal = cross(u, v);
    let offset = dot(normal, corners[0]);
    let longest = max(length(u), length(v));
    let farthest = max(max(length(corners[0]), length(corners[1])), length(corners[2]));
    // The error of corners is a rounding of their distance. That of the normal is this times the
    // edges.
    let error = LAMP_SLACK * longest * farthest * farthest;
    let is_exact = abs(offset) > 0.0 && error <= exact_slope() * grid.down.w * abs(offset);
    return vec4f(turned(normal, face) / offset, select(0.0, 1.0, is_exact));
}

fn edges_of(face: u32, corners: array<vec3f, 3>) -> Edges {
    var directions: array<vec3f, 3>;
    var depths: vec3f;
    var base = vec2f(0.0);
    var slack = 0.0;
    let nearest = distance_to_origin(corners);
    let around = margin(nearest);
    if is_lamp() {
        slack = LAMP_SLACK;
        for (var i = 0u; i < 3u; i++) {
            let inverse = 1.0 / max(length(corners[i]), 1e-30);
            directions[i] = turned(corners[i] * inverse, face);
            depths[i] = inverse;
        }
    } else {
        base = corners[0].xy;
        for (var i = 0u; i < 3u; i++) {
            directions[i] = vec3f(corners[i].xy - base, 1.0);
            depths[i] = corners[i].z;
        }
    }
    let e0 = cross(directions[1], directions[2]);
    let e1 = cross(directions[2], directions[0]);
    let e2 = cross(directions[0], directions[1]);
    var lengths = vec3f(length(e0.xy), length(e1.xy), length(e2.xy));
    if is_lamp() {
        lengths = vec3f(length(e0), length(e1), length(e2));
    }
    let longest = max(max(lengths.x, lengths.y), lengths.z);
    let whole = dot(directions[0], e0);
    let sign = select(1.0, -1.0, whole < 0.0);
    // Scale the edges by their error. A short edge has an uncertain direction; the error at its far
    // end is longest / length as large.
    let factors = sign / max(around * (lengths + longest) + slack, vec3f(1e-30));
    // Fit the plane through the corners' depths. Its error is the sum of the edges' contributions.
    let steps = depths - depths.x;
    let shares = dot(abs(steps), around * lengths + slack);
    var slope = shares;
    if is_lamp() {
        slope /= min(min(depths.x, depths.y), depths.z);
    }
    var plane = vec4f(0.0);
    var knows_depth = false;
    if is_lamp() {
        plane = plane_of_lamp(face, corners);
        knows_depth = nearest >= grid.face.w && plane.w > 0.0;
    } else {
        plane = vec4f((e1 * steps.y + e2 * steps.z) / whole, 1.0);
        plane.z += depths.x;
        knows_depth = abs(whole) > 0.0;
    }
    knows_depth = knows_depth && slope <= exact_slope() * grid.down.w * abs(whole);
    // Set unused planes to 0.
    plane = select(vec4f(0.0), plane, knows_depth);
    return Edges(
        vec4f(e0.x * factors.x, e1.x * factors.y, e2.x * factors.z, plane.x),
        vec4f(e0.y * factors.x, e1.y * factors.y, e2.y * factors.z, plane.y),
        vec4f(e0.z * factors.x, e1.z * factors.y, e2.z * factors.z, plane.z),
        base,
        knows_depth,
    );
}

// Functions along a row of cells: their values at the first corner of the face's first cell, and
// their growth from cell to cell and to the next row.
struct Row {
    first: vec4f,
    across: vec4f,
    down: vec4f,
}

fn row_of(edges: Edges, y: u32, cell_side: f32) -> Row {
    let corner = vec2f(0.0, f32(y) * cell_side) - grid.face.xy - edges.base;
    let first = edges.summand + edges.across * corner.x + edges.down * corner.y;
    return Row(first, edges.across * cell_side, edges.down * cell_side);
}

// Returns the first and the last cell of a row in which the edges' greatest values are at least
// `least`; possibly none. Linear functions have their greatest values at corners. `more`, in cells,
// compensates for rounded divisions.
fn touched_cells(row: Row, least: f32, more: f32) -> vec2f {
    let corner = row.first.xyz + max(row.across.xyz, vec3f(0.0)) + max(row.down.xyz, vec3f(0.0));
    let cells = cells_above(row.across.xyz, vec3f(least) - corner);
    return vec2f(ceil(cells.x - more), floor(cells.y + more));
}

// Returns the cells of a row in which the edges' least values are above 1. Here a 16th of a cell
// compensates for rounded divisions.
fn covered_cells(row: Row) -> vec2f {
    let corner = row.first.xyz + min(row.across.xyz, vec3f(0.0)) + min(row.down.xyz, vec3f(0.0));
    let cells = cells_above(row.across.xyz, vec3f(1.0) - corner);
    return vec2f(ceil(cells.x + 0.0625), floor(cells.y - 0.0625));
}

// Returns the positions on a row where each step times the position is at least `needed`.
fn cells_above(step: vec3f, needed: vec3f) -> vec2f {
    let far = vec3f(1e6);
    let bound = clamp(needed / step, -far, far);
    let never = needed > vec3f(0.0);
    let level = select(-far, far, never);
    let rising = step > vec3f(0.0);
    let falling = step < vec3f(0.0);
    let first = select(select(level, -far, falling), bound, rising);
    let last = select(far, bound, falling);
    return vec2f(max(max(first.x, first.y), first.z), min(min(last.x, last.y), last.z));
}

// Returns the least depth of the plane in a cell of a row, minus the margin.
fn nearest_in_cell(row: Row, x: u32) -> f32 {
    let corner = row.first.w + row.across.w * f32(x);
    if is_lamp() {
        // The function is one over the depth.
        let greatest = corner + max(row.across.w, 0.0) + max(row.down.w, 0.0);
        return before(1.0 / max(greatest, 1e-30));
    }
    return before(corner + min(row.across.w, 0.0) + min(row.down.w, 0.0));
}

// Returns the greatest depth of the plane in a cell of a row, plus the margin.
fn farthest_in_cell(row: Row, x: u32) -> f32 {
    let corner = row.first.w + row.across.w * f32(x);
    if !is_lamp() {
        return behind(corner + max(row.across.w, 0.0) + max(row.down.w, 0.0));
    }
    let least = corner + min(row.across.w, 0.0) + min(row.down.w, 0.0);
    return select(1e30, behind(1.0 / least), least > 0.0);
}
