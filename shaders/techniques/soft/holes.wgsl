// Twin of holes.rs: points that a triangle hides if casters are alpha-tested (table_4). table_3 has
// the triangles for ray tests. The fourth word of a triangle's second row is the row of its record
// in table_4, 0 if it is opaque.
//
// Four points are tested per iteration, to keep loops short (see hidden.wgsl).

fn cut_out_row(i: u32) -> vec4u {
    return table_4[i];
}

// Alpha-tested triangle, and the receiver's position.
struct Leaf {
    a: vec3f,
    b: vec3f,
    c: vec3f,
    record: u32,
    o: vec3f,
}

// Returns the lowest of some bits of a row, unless the ray to its point passes at a transparent
// texel.
fn lowest_met(bits: u32, leaf: Leaf, plane: LightPlane, first: vec2f, step: vec2f) -> u32 {
    if bits == 0u {
        return 0u;
    }
    let place = firstTrailingBit(bits);
    let point = first + product2(step, vec2f(f32(place)));
    let d = plane.center + product3(plane.u, vec3f(point.x)) + product3(plane.v, vec3f(point.y));
    if is_hole_met(leaf.o, d, leaf.a, leaf.b, leaf.c, leaf.record) {
        return 0u;
    }
    return 1u << place;
}

fn met_outside_holes(bits: u32, row: u32, o: vec3f, plane: LightPlane, first: vec2f, step: vec2f) -> u32 {
    let record = table_3[row + 1u].w;
    if record == 0u {
        return bits;
    }
    let a = bitcast<vec3f>(table_3[row].xyz);
    let b = bitcast<vec3f>(table_3[row + 1u].xyz);
    let c = bitcast<vec3f>(table_3[row + 2u].xyz);
    let leaf = Leaf(a, b, c, record, o);
    var met = 0u;
    var rest = bits;
    while rest != 0u {
        let second = rest & (rest - 1u);
        let third = second & (second - 1u);
        let fourth = third & (third - 1u);
        met |= lowest_met(rest, leaf, plane, first, step);
        met |= lowest_met(second, leaf, plane, first, step);
        met |= lowest_met(third, leaf, plane, first, step);
        met |= lowest_met(fourth, leaf, plane, first, step);
        rest = fourth & (fourth - 1u);
    }
    return met;
}
