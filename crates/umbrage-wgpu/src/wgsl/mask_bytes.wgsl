// import mask
// A mask in steps of 1/255, one byte a pixel. Core WebGPU has no storage texture of bytes, so the
// mask is written to a buffer and then copied.

// Four pixels a word. Rows begin at multiples of 256 bytes, as copies require.
@group(UMBRAGE_GROUP) @binding(UMBRAGE_MASK_BINDING + 1u)
var<storage, read_write> umbrage_words: array<u32>;

// The steps of a workgroup's pixels.
var<workgroup> umbrage_steps: array<u32, 64>;

@compute @workgroup_size(8, 8)
fn umbrage_compute_mask(
    @builtin(global_invocation_id) at: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let is_inside = all(at.xy < umbrage_mask.size);
    var visibility = 1.0;
    if is_inside {
        visibility = umbrage_visibility(at.xy);
    }
    umbrage_steps[lane] = u32(floor(min(max(visibility, 0.0), 1.0) * 255.0 + 0.5));
    workgroupBarrier();
    if is_inside && lane % 4u == 0u {
        let row_words = (umbrage_mask.size.x + 255u) / 256u * 64u;
        let low = umbrage_steps[lane] | (umbrage_steps[lane + 1u] << 8u);
        let high = umbrage_steps[lane + 2u] | (umbrage_steps[lane + 3u] << 8u);
        umbrage_words[at.y * row_words + at.x / 4u] = low | (high << 16u);
    }
}
