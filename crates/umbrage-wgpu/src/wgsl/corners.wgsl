// import math
// Transforms the casters of one mesh to world space: three rows per triangle, in the layout in
// which kernels read the corners of casters. The arithmetic is that of cast.wgsl.

struct PlacedMesh {
    // 0: three floats. 1: four 16-bit floats. 2: four 16-bit normalized integers for -1..=1.
    format: u32,
    // Slot of the first caster among the instances.
    first_slot: u32,
    casters: u32,
    // Triangles per caster.
    triangles: u32,
    // Row of the first corner in the tables.
    first_row: u32,
    // Words from one vertex to the next, and from a vertex to its position.
    stride: u32,
    position: u32,
    // Bits of an index; 0 if there are none.
    index_bits: u32,
    // The first index or vertex.
    first: u32,
    base_vertex: i32,
    // Row of the first triangle's record in the table of cut_out.rs; 0 for opaque casters.
    first_record: u32,
}

@group(0) @binding(0) var<uniform> mesh: PlacedMesh;
@group(0) @binding(1) var<storage> vertices: array<u32>;
@group(0) @binding(2) var<storage> indices: array<u32>;
// World from local by slot: three columns and a translation.
@group(0) @binding(3) var<storage> instances: array<f32>;
@group(0) @binding(4) var<storage, read_write> tables: array<u32>;

fn vertex_of(place: u32) -> u32 {
    if mesh.index_bits == 0u {
        return place;
    }
    var index = indices[place];
    if mesh.index_bits == 16u {
        index = (indices[place / 2u] >> (16u * (place % 2u))) & 0xffffu;
    }
    return u32(i32(index) + mesh.base_vertex);
}

fn position_of(vertex: u32) -> vec3f {
    let word = vertex * mesh.stride + mesh.position;
    let words = vec3u(vertices[word], vertices[word + 1u], vertices[word + 2u]);
    if mesh.format == 1u {
        return vec3f(unpack2x16float(words.x), unpack2x16float(words.y).x);
    }
    if mesh.format == 2u {
        return vec3f(unpack2x16snorm(words.x), unpack2x16snorm(words.y).x);
    }
    return bitcast<vec3f>(words);
}

fn column(slot: u32, number: u32) -> vec3f {
    let word = 12u * slot + 3u * number;
    return vec3f(instances[word], instances[word + 1u], instances[word + 2u]);
}

@compute @workgroup_size(64)
fn place_corners(@builtin(global_invocation_id) at: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let number = at.x + at.y * groups.x * 64u;
    if number >= mesh.casters * mesh.triangles {
        return;
    }
    opaque_zero = mesh.index_bits >> 31u;
    let slot = mesh.first_slot + number / mesh.triangles;
    let triangle = number % mesh.triangles;
    // An alpha-tested triangle has a record of two rows.
    let record = select(0u, mesh.first_record + 2u * triangle, mesh.first_record > 0u);
    let x = vec4f(column(slot, 0u), 0.0);
    let y = vec4f(column(slot, 1u), 0.0);
    let z = vec4f(column(slot, 2u), 0.0);
    let world_from_local = mat4x4f(x, y, z, vec4f(column(slot, 3u), 1.0));
    for (var i = 0u; i < 3u; i++) {
        let p = position_of(vertex_of(mesh.first + 3u * triangle + i));
        let corner = transform(world_from_local, p);
        let word = 4u * (mesh.first_row + 3u * number + i);
        tables[word] = bitcast<u32>(corner.x);
        tables[word + 1u] = bitcast<u32>(corner.y);
        tables[word + 2u] = bitcast<u32>(corner.z);
        tables[word + 3u] = record;
    }
}
