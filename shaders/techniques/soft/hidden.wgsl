// Twin of hidden.rs for one receiver and triangles with sorted corners (table_1).

const LEAST_GROWTH = 1e-30;

// Linear function over the light's plane. Points may be hidden where it is not negative.
struct Function {
    middle: f32,
    along_u: f32,
    along_v: f32,
}

fn function_across(normal: vec3f, plane: LightPlane) -> Function {
    return Function(dot3(normal, plane.center), dot3(normal, plane.u), dot3(normal, plane.v));
}

fn function_reach(f: Function) -> f32 {
    return abs(f.along_u) + abs(f.along_v);
}

// Sign change of a function along a row: a root, and whether the function is not negative from
// there on, or up to there.
struct Cut {
    f: Function,
    inverse: f32,
    rises: bool,
}

fn cut_of(f: Function, step: vec2f) -> Cut {
    let growth = product(f.along_u, step.x) + product(f.along_v, step.y);
    let inverse = quotient(1.0, select(growth, LEAST_GROWTH, abs(growth) < LEAST_GROWTH));
    return Cut(f, inverse, inverse > 0.0);
}

fn root_of(cut: Cut, first: vec2f) -> f32 {
    let at_first = cut.f.middle + product(cut.f.along_u, first.x) + product(cut.f.along_v, first.y);
    return -at_first * cut.inverse;
}

// Narrows the positions of a row, from x to y, to those where the function is not negative.
fn narrowed(run: vec2f, cut: Cut, first: vec2f) -> vec2f {
    let root = root_of(cut, first);
    return select(vec2f(run.x, min(run.y, root)), vec2f(max(run.x, root), run.y), cut.rises);
}

// Returns the bits of the integer positions from `since`, at least 0, to `until`, at most MAX_ROWS.
fn run_of_bits(since: f32, until: f32) -> u32 {
    let first = u32(min(ceil(since), f32(MAX_ROWS)));
    let after = u32(min(max(floor(until) + 1.0, 0.0), f32(MAX_ROWS)));
    return ((1u << after) - 1u) & ~((1u << first) - 1u);
}

// Light points that are not known to be hidden, a word for each row; and the rows that have any.
//
// Loops are kept short here: see `SHORT_LOOPS` in umbrage-wgpu's drivers.rs.
var<private> open: array<u32, MAX_ROWS>;
var<private> open_rows: u32;

// Returns whether any point of a part may be open. Two rows are tested; others count as open.
fn is_part_open(part: Part) -> bool {
    var rows = part.rows & open_rows;
    if rows == 0u {
        return false;
    }
    if (open[firstTrailingBit(rows)] & part.places) != 0u {
        return true;
    }
    rows &= rows - 1u;
    if rows == 0u {
        return false;
    }
    if (open[firstTrailingBit(rows)] & part.places) != 0u {
        return true;
    }
    return (rows & (rows - 1u)) != 0u;
}

// Opens the lattice points above a receiver's plane. Returns whether there are any.
fn open_above_horizon(normal: vec3f, plane: LightPlane, lattice: Lattice) -> bool {
    let height = function_across(normal, plane);
    if !(height.middle + function_reach(height) > 0.0) {
        return false;
    }
    let above = cut_of(height, lattice.step);
    open_rows = 0u;
    for (var i = 0u; i < kernel.rows; i++) {
        let row = table_2[lattice.at + i];
        let run = narrowed(vec2f(0.0, f32(MAX_ROWS)), above, bitcast<vec2f>(row.xy));
        open[i] = row.z & run_of_bits(run.x, run.y);
        open_rows |= select(0u, 1u << i, open[i] != 0u);
    }
    return open_rows != 0u;
}

// Hides the points that a triangle hides. no_holes.wgsl or holes.wgsl selects them from those that
// its outline covers.
fn hide(f: Footprint, plane: LightPlane, lattice: Lattice, row: u32) {
    let a_at = bitcast<vec3f>(table_1[row].xyz);
    let b_at = bitcast<vec3f>(table_1[row + 1u].xyz);
    let c_at = bitcast<vec3f>(table_1[row + 2u].xyz);
    let at_a = products(f, a_at);
    let at_b = products(f, b_at);
    let at_c = products(f, c_at);
    let part = part_of_corners(f, at_a, at_b, at_c);
    if !is_part_open(part) {
        return;
    }
    let a = a_at - f.start;
    let b = b_at - f.start;
    let a_to_b = b_at - a_at;
    let a_to_c = c_at - a_at;
    let across = cross3(a_to_b, a_to_c);
    let volume = dot3(across, a);
    if volume == 0.0 {
        return;
    }
    let sign = select(1.0, -1.0, volume < 0.0);
    let ab = function_across(cross3(a, a_to_b) * sign, plane);
    let bc = function_across(cross3(b, c_at - b_at) * sign, plane);
    let ac = function_across(cross3(a, a_to_c) * -sign, plane);
    var before = function_across(across * sign, plane);
    before.middle -= product(volume, sign);
    let reach = vec4f(function_reach(ab), function_reach(bc), function_reach(ac), function_reach(before));
    var greatest = vec4f(ab.middle, bc.middle, ac.middle, before.middle) + reach;
    if !is_lamp() {
        greatest.w = 1.0;
    }
    if any(greatest < vec4f(0.0)) {
        return;
    }
    let cut_ab = cut_of(ab, lattice.step);
    let cut_bc = cut_of(bc, lattice.step);
    let cut_ac = cut_of(ac, lattice.step);
    let cut_before = cut_of(before, lattice.step);
    for (var rows = part.rows & open_rows; rows != 0u; rows &= rows - 1u) {
        let i = firstTrailingBit(rows);
        let first = bitcast<vec2f>(table_2[lattice.at + i].xy);
        var run = vec2f(0.0, f32(MAX_ROWS));
        run = narrowed(run, cut_ab, first);
        run = narrowed(run, cut_bc, first);
        run = narrowed(run, cut_ac, first);
        if is_lamp() {
            run = narrowed(run, cut_before, first);
        }
        let covered = open[i] & run_of_bits(run.x, run.y);
        let rest = open[i] & ~met_outside_holes(covered, row, f.start, plane, first, lattice.step);
        open[i] = rest;
        open_rows &= ~select(0u, 1u << i, rest == 0u);
    }
}
