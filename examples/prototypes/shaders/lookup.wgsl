// Answers of all receivers. The structure's module defines `is_shadowed`, and counts what it walks
// and tests.

@group(0) @binding(0) var<uniform> kernel: ExactUniforms;
@group(0) @binding(1) var<storage, read> receivers: array<vec4u>;
@group(0) @binding(2) var<storage, read_write> answers: array<u32>;
@group(0) @binding(3) var<storage, read_write> counted: array<vec2u>;
@group(0) @binding(4) var<uniform> image: vec4u;
@group(0) @binding(5) var<storage, read> table_3: array<vec4u>;
@group(0) @binding(6) var<storage, read> table_4: array<vec4u>;

override COUNTS: bool = false;

// Numbers of nodes or items, and of triangle tests.
var<private> walked: u32;
var<private> tested: u32;

struct Receiver {
    position: vec3f,
    normal: vec3f,
    triangle: u32,
}

// A workgroup takes 8 x 8 pixels, its halves 8 x 4.
@compute @workgroup_size(64)
fn look_up(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let across = (image.x + 7u) / 8u;
    let at = 8u * vec2u(group.x % across, group.x / across) + vec2u(lane % 8u, lane / 8u);
    if any(at >= image.xy) {
        return;
    }
    let pixel = at.y * image.x + at.x;
    let position = receivers[2u * pixel];
    let normal = receivers[2u * pixel + 1u];
    opaque_zero = kernel.light.shape.x >> 31u;
    let n = bitcast<vec3f>(normal.xyz);
    var is_lit = true;
    if normal.w != 0u {
        let o = ray_origin(bitcast<vec3f>(position.xyz), n, kernel.eye.xyz, kernel.grid.w);
        let d = segment(kernel.light, o, vec2f(0.0), kernel.far);
        is_lit = dot3(n, d) > 0.0 && !is_shadowed(o, d, position.w);
    }
    answers[pixel] = bitcast<u32>(select(0.0, 1.0, is_lit));
    if COUNTS {
        counted[pixel] = vec2u(walked, tested);
    }
}
