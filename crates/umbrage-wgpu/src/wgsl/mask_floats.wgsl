// import mask_choice
// Computed masks of 32-bit floats.

@group(UMBRAGE_GROUP) @binding(UMBRAGE_MASK_BINDING + 1u)
var umbrage_masks: texture_storage_2d_array<r32float, write>;

@compute @workgroup_size(64)
fn umbrage_compute_mask(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let at = umbrage_pixel(group, groups, lane);
    if all(at < umbrage_mask.size) {
        let channels = vec4f(umbrage_visibility(at), 0.0, 0.0, 0.0);
        textureStore(umbrage_masks, at, umbrage_mask.layer, channels);
    }
}
