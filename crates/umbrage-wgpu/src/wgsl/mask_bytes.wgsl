// import mask_choice
// A computed mask in steps of 1/255, one byte a pixel. Core WebGPU has no storage texture of bytes,
// so the mask is written to a buffer and then copied.

// Four pixels a word. Rows begin at multiples of 256 bytes, as copies require.
@group(UMBRAGE_GROUP) @binding(UMBRAGE_MASK_BINDING + 1u)
var<storage, read_write> umbrage_bytes: array<u32>;

// The steps of a workgroup's pixels, row by row.
var<workgroup> umbrage_steps: array<u32, 64>;

@compute @workgroup_size(64)
fn umbrage_compute_mask(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let at = umbrage_pixel(group, groups, lane);
    let is_inside = all(at < umbrage_mask.size);
    var visibility = 1.0;
    if is_inside {
        visibility = umbrage_visibility(at);
    }
    let place = (at.y & 7u) * 8u + (at.x & 7u);
    umbrage_steps[place] = u32(floor(min(max(visibility, 0.0), 1.0) * 255.0 + 0.5));
    workgroupBarrier();
    if is_inside && at.x % 4u == 0u {
        let row_words = (umbrage_mask.size.x + 255u) / 256u * 64u;
        let low = umbrage_steps[place] | (umbrage_steps[place + 1u] << 8u);
        let high = umbrage_steps[place + 2u] | (umbrage_steps[place + 3u] << 8u);
        umbrage_bytes[at.y * row_words + at.x / 4u] = low | (high << 16u);
    }
}
