// The filter stage of kernels that compute tiles of texels. A workgroup computes one tile.

@compute @workgroup_size(8, 8)
fn umbrage_filter(@builtin(workgroup_id) tile: vec3u, @builtin(local_invocation_id) lane: vec3u) {
    filter_tile(vec2i(tile.xy), i32(tile.z), vec2i(lane.xy));
}
