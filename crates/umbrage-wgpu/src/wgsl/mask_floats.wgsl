// import mask
// Masks of 32-bit floats.

@group(UMBRAGE_GROUP) @binding(UMBRAGE_MASK_BINDING + 1u)
var umbrage_masks: texture_storage_2d_array<r32float, write>;

@compute @workgroup_size(8, 8)
fn umbrage_compute_mask(@builtin(global_invocation_id) at: vec3u) {
    if all(at.xy < umbrage_mask.size) {
        let channels = vec4f(umbrage_visibility(at.xy), 0.0, 0.0, 0.0);
        textureStore(umbrage_masks, at.xy, umbrage_mask.layer, channels);
    }
}
