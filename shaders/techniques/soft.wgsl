// Twin of soft.rs: finds the casters in a receiver's shaft through a binary hierarchy (table_0)
// over triangles with sorted corners (table_1). Hides the points of a lattice over the light
// (table_2) behind them.

struct SoftUniforms {
    light: LightSampler,
    eye: vec4f,
    spread: vec4f,
    plane_reach: f32,
    far: f32,
    shift: f32,
    rows: u32,
    lattices: u32,
}

const STACK = 64;

fn shaft_from(o: vec3f) -> Shaft {
    let center = kernel.light.center.xyz;
    let low = center - kernel.spread.xyz;
    let high = center + kernel.spread.xyz;
    if is_lamp() {
        return shaft_to(o, low - o, high - o);
    }
    let far = vec3f(kernel.far);
    return shaft_to(o, product3(low, far), product3(high, far));
}

// Hides points behind casters, except triangle `skip`. Returns whether any point is still open.
fn search(f: Footprint, plane: LightPlane, lattice: Lattice, skip: u32) -> bool {
    let shaft = shaft_from(f.start);
    var stack: array<u32, STACK>;
    var top = 1;
    stack[0] = 0u;
    while top > 0 {
        top -= 1;
        let node = stack[top];
        let head = table_0[2u * node];
        let tail = table_0[2u * node + 1u];
        let low = bitcast<vec3f>(head.xyz);
        let high = bitcast<vec3f>(tail.xyz);
        if !shaft_enters(shaft, low, high) || !is_part_open(part_of_box(f, low, high)) {
            continue;
        }
        for (var i = head.w; i < head.w + tail.w; i++) {
            if table_1[3u * i].w != skip {
                hide(f, plane, lattice, 3u * i);
            }
        }
        if open_rows == 0u {
            return false;
        }
        if tail.w == 0u && head.w > 0u && top + 2 <= STACK {
            stack[top] = head.w;
            stack[top + 1] = head.w + 1u;
            top += 2;
        }
    }
    return true;
}

fn receive(r: Receiver) -> f32 {
    // There are fewer than 2^31 kinds of lights.
    opaque_zero = kernel.light.shape.x >> 31u;
    let o = ray_origin(r.position, r.normal, kernel.eye.xyz, kernel.plane_reach);
    let plane = light_plane(o);
    let lattice = lattice_of(r.pixel);
    if !open_above_horizon(r.normal, plane, lattice) {
        return 0.0;
    }
    if !search(footprint_of(o, plane, lattice), plane, lattice, r.triangle) {
        return 0.0;
    }
    var count = 0u;
    for (var i = 0u; i < kernel.rows; i++) {
        count += countOneBits(open[i]);
    }
    return quotient(f32(count), f32(lattice.points));
}
