// Twin of footprint.rs for one receiver.

// Equal to the constants in footprint.rs.
const FOOTPRINT_MARGIN = 0.01;
const DISTANCE_MARGIN = 7.6293945e-6;

// Projection of boxes and triangles onto the lattice.
struct Footprint {
    start: vec3f,
    along: vec3f,
    down: vec3f,
    away: vec3f,
    middle: vec2f,
    margin: vec2f,
    is_bounded: bool,
}

fn footprint_of(o: vec3f, plane: LightPlane, lattice: Lattice) -> Footprint {
    let p = product3(plane.u, vec3f(lattice.step.x)) + product3(plane.v, vec3f(lattice.step.y));
    let q = product3(plane.u, vec3f(lattice.rise.x)) + product3(plane.v, vec3f(lattice.rise.y));
    let along = cross3(q, plane.center);
    let down = cross3(plane.center, p);
    let away = cross3(p, q);
    let volume = dot3(away, plane.center);
    let sign = select(1.0, -1.0, volume < 0.0);
    let sizes = vec2f(length(along), length(down)) / abs(volume);
    let distance = length(plane.center);
    let row_shift = vec2f(kernel.shift, kernel.shift / f32(kernel.rows));
    let margin = product2(sizes, vec2f(distance * DISTANCE_MARGIN)) + FOOTPRINT_MARGIN + row_shift;
    let turn = product(lattice.step.x, lattice.rise.y) - product(lattice.rise.x, lattice.step.y);
    let place = (product(lattice.rise.x, lattice.origin.y) - product(lattice.origin.x, lattice.rise.y)) / turn;
    let row = (product(lattice.origin.x, lattice.step.y) - product(lattice.step.x, lattice.origin.y)) / turn;
    let is_bounded = max(sizes.x, sizes.y) * distance < 1e6;
    let signs = vec3f(sign);
    return Footprint(o, product3(along, signs), product3(down, signs), product3(away, signs), vec2f(place, row), margin, is_bounded);
}

// Bits of some rows of a lattice, and bits of the same positions in each.
struct Part {
    rows: u32,
    places: u32,
}

// Returns the bits from `first` to `last`, 0 to 30.
fn bits_between(first: f32, last: f32) -> u32 {
    return ((2u << u32(last)) - 1u) & ~((1u << u32(first)) - 1u);
}

// `low` and `high` bound the products with the three vectors of a footprint.
fn part_between(f: Footprint, low: vec3f, high: vec3f) -> Part {
    if !f.is_bounded || !(low.z > 0.0) {
        return Part(0xffffffffu, 0xffffffffu);
    }
    let least = min(low.xy / low.z, low.xy / high.z) + (f.middle - f.margin);
    let greatest = max(high.xy / low.z, high.xy / high.z) + (f.middle + f.margin);
    let end = vec2f(f32(MAX_ROWS - 1), f32(kernel.rows) - 1.0);
    let first = max(ceil(least), vec2f(0.0));
    let last = min(floor(greatest), end);
    if !(first.x <= last.x && first.y <= last.y) {
        return Part(0u, 0u);
    }
    return Part(bits_between(first.y, last.y), bits_between(first.x, last.x));
}

fn part_of_box(f: Footprint, low: vec3f, high: vec3f) -> Part {
    let center = (low + high) * 0.5 - f.start;
    let half = (high - low) * 0.5;
    let middle = vec3f(dot3(f.along, center), dot3(f.down, center), dot3(f.away, center));
    let reach = vec3f(dot3(abs(f.along), half), dot3(abs(f.down), half), dot3(abs(f.away), half));
    return part_between(f, middle - reach, middle + reach);
}

fn products(f: Footprint, p: vec3f) -> vec3f {
    let d = p - f.start;
    return vec3f(dot3(f.along, d), dot3(f.down, d), dot3(f.away, d));
}

// Returns the rows of a triangle's projection from the products of its corners.
fn part_of_corners(f: Footprint, a: vec3f, b: vec3f, c: vec3f) -> Part {
    let least = min(a.z, min(b.z, c.z));
    if !(least > 0.0) {
        return part_between(f, vec3f(least), vec3f(least));
    }
    // Treat the corners' quotients as products with 1 as the third.
    let at_a = a.xy / a.z;
    let at_b = b.xy / b.z;
    let at_c = c.xy / c.z;
    return part_between(f, vec3f(min(at_a, min(at_b, at_c)), 1.0), vec3f(max(at_a, max(at_b, at_c)), 1.0));
}
