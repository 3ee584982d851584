// Receivers in the order of the cells of a grid over the light's view.

struct BinsPlace {
    casters: u32,
    // Cells along a side, and number of rows of cells of a face.
    side: u32,
    cells: u32,
    large: u32,
    image: vec2u,
    // Half the size of a face.
    half: vec2f,
    slice: vec2u,
}

struct Bounds {
    low: vec2f,
    high: vec2f,
}

@group(0) @binding(0) var<uniform> kernel: ExactUniforms;
@group(0) @binding(1) var<uniform> made: BinsPlace;
@group(0) @binding(2) var<storage, read> receivers: array<vec4u>;
// Number of receivers of a cell, then its first receiver.
@group(0) @binding(3) var<storage, read_write> counts: array<atomic<u32>>;
@group(0) @binding(4) var<storage, read_write> taken: array<atomic<u32>>;
// Greatest depth of a receiver of a cell.
@group(0) @binding(5) var<storage, read_write> deepest: array<atomic<u32>>;
// Two rows a receiver: origin and own triangle; position on the face, depth and pixel.
@group(0) @binding(6) var<storage, read_write> binned: array<vec4u>;
// Bounds of all receivers on a directional light's face, as integers in the order of floats.
@group(0) @binding(7) var<storage, read_write> ends: array<atomic<u32>>;
@group(0) @binding(8) var<storage, read_write> answers: array<u32>;
@group(0) @binding(9) var<storage, read> table_3: array<vec4u>;
@group(0) @binding(10) var<storage, read> table_4: array<vec4u>;

struct Asking {
    o: vec3f,
    at: vec3f,
    face: u32,
    pixel: u32,
    own: u32,
    asks: bool,
}

fn asking_at(group: vec3u, lane: u32) -> Asking {
    opaque_zero = kernel.light.shape.x >> 31u;
    var out: Asking;
    out.pixel = 64u * group.x + lane;
    if out.pixel >= made.image.x * made.image.y {
        return out;
    }
    let position = receivers[2u * out.pixel];
    let normal = receivers[2u * out.pixel + 1u];
    if normal.w == 0u {
        return out;
    }
    let n = bitcast<vec3f>(normal.xyz);
    out.o = ray_origin(bitcast<vec3f>(position.xyz), n, kernel.eye.xyz, kernel.grid.w);
    let d = segment(kernel.light, out.o, vec2f(0.0), kernel.far);
    let point = frame_point(out.o);
    out.at = vec3f(point.on_face, point.depth);
    out.face = point.face;
    out.own = position.w;
    let is_inside = all(abs(point.on_face) <= made.half * 1.0001);
    out.asks = dot3(n, d) > 0.0 && (is_inside || kernel.tiles.z == 1u);
    return out;
}

fn is_behind_light(group: vec3u, lane: u32) -> bool {
    let pixel = 64u * group.x + lane;
    let normal = receivers[2u * pixel + 1u];
    if normal.w == 0u {
        return false;
    }
    let n = bitcast<vec3f>(normal.xyz);
    let position = bitcast<vec3f>(receivers[2u * pixel].xyz);
    let o = ray_origin(position, n, kernel.eye.xyz, kernel.grid.w);
    return !(dot3(n, segment(kernel.light, o, vec2f(0.0), kernel.far)) > 0.0);
}

fn ordered(x: f32) -> u32 {
    let bits = bitcast<u32>(x);
    return select(bits | 0x80000000u, ~bits, (bits >> 31u) == 1u);
}

var<workgroup> group_ends: array<atomic<u32>, 4>;

@compute @workgroup_size(64)
fn find_bounds(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let asking = asking_at(group, lane);
    if asking.asks {
        atomicMax(&group_ends[0], ~ordered(asking.at.x));
        atomicMax(&group_ends[1], ~ordered(asking.at.y));
        atomicMax(&group_ends[2], ordered(asking.at.x));
        atomicMax(&group_ends[3], ordered(asking.at.y));
    }
    workgroupBarrier();
    if lane < 4u {
        atomicMax(&ends[lane], atomicLoad(&group_ends[lane]));
    }
}

fn from_ordered(word: u32) -> f32 {
    return bitcast<f32>(select(~word, word & 0x7fffffffu, (word >> 31u) == 1u));
}

fn bounds() -> Bounds {
    if kernel.tiles.z == 1u {
        return Bounds(vec2f(-1.0), vec2f(1.0));
    }
    let low = vec2f(from_ordered(~atomicLoad(&ends[0])), from_ordered(~atomicLoad(&ends[1])));
    let high = vec2f(from_ordered(atomicLoad(&ends[2])), from_ordered(atomicLoad(&ends[3])));
    return Bounds(low, max(high, low + 1e-6));
}

fn cell_of(asking: Asking) -> u32 {
    let all_of = bounds();
    let steps = f32(made.side) / (all_of.high - all_of.low);
    let at = vec2u(clamp((asking.at.xy - all_of.low) * steps, vec2f(0.0), vec2f(f32(made.side - 1u))));
    return (asking.face * made.side + at.y) * made.side + at.x;
}

@compute @workgroup_size(64)
fn count_receivers(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let asking = asking_at(group, lane);
    if asking.pixel >= made.image.x * made.image.y {
        return;
    }
    let is_lit = !is_behind_light(group, lane);
    answers[asking.pixel] = bitcast<u32>(select(0.0, 1.0, is_lit));
    if asking.asks {
        let cell = cell_of(asking);
        atomicAdd(&counts[cell], 1u);
        atomicMax(&deepest[cell], bitcast<u32>(max(asking.at.z, 0.0)));
    }
}

@compute @workgroup_size(64)
fn bin_receivers(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let asking = asking_at(group, lane);
    if !asking.asks {
        return;
    }
    let cell = cell_of(asking);
    let place = atomicLoad(&counts[cell]) + atomicAdd(&taken[cell], 1u);
    binned[2u * place] = vec4u(bitcast<vec3u>(asking.o), asking.own);
    binned[2u * place + 1u] = vec4u(bitcast<vec3u>(asking.at), asking.pixel);
}
