// Twin of traced.rs: any-hit traversal of a binary hierarchy (table_0) over triangles (table_1).
// leaf_opaque.wgsl or leaf_cut_out.wgsl defines the leaf test.

struct TracedUniforms {
    light: LightSampler,
    eye: vec4f,
    plane_reach: f32,
    far: f32,
    samples: u32,
}

const STACK = 64;

fn occluded(o: vec3f, d: vec3f, skip: u32) -> bool {
    let inverse = slab_inverse(d);
    let rows = shear_rows(d);
    var stack: array<u32, STACK>;
    var top = 1;
    stack[0] = 0u;
    while top > 0 {
        top -= 1;
        let node = stack[top];
        let low = table_0[2u * node];
        let high = table_0[2u * node + 1u];
        if !enters_box(o, inverse, bitcast<vec3f>(low.xyz), bitcast<vec3f>(high.xyz)) {
            continue;
        }
        if high.w > 0u {
            if leaf_occludes(o, d, rows, low.w, high.w, skip) {
                return true;
            }
        } else if low.w > 0u && top + 2 <= STACK {
            stack[top] = low.w;
            stack[top + 1] = low.w + 1u;
            top += 2;
        }
    }
    return false;
}

fn receive(r: Receiver) -> f32 {
    // There are fewer than 2^31 kinds of lights.
    opaque_zero = kernel.light.shape.x >> 31u;
    let o = ray_origin(r.position, r.normal, kernel.eye.xyz, kernel.plane_reach);
    let scramble = seed(r.pixel.x, r.pixel.y);
    var seen = 0u;
    for (var i = 0u; i < kernel.samples; i++) {
        let d = segment(kernel.light, o, unit_square(i, scramble), kernel.far);
        if dot3(r.normal, d) > 0.0 && !occluded(o, d, r.triangle) {
            seen += 1u;
        }
    }
    return quotient(f32(seen), f32(kernel.samples));
}
