// import pixel_block
// The receive stage of kernels whose masks are computed: calls the kernel for every pixel. Pixels
// that don't receive are lit.

@group(UMBRAGE_GROUP) @binding(UMBRAGE_MASK_BINDING)
var umbrage_mask: texture_storage_2d<r32float, write>;

fn umbrage_visibility(texel: vec2i) -> f32 {
    let seen = umbrage_seen(texel);
    if !seen.receives {
        return 1.0;
    }
    return receive(Receiver(seen.position, seen.normal, vec2u(texel), seen.triangle));
}

@compute @workgroup_size(64)
fn umbrage_receive(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let at = umbrage_pixel(group, groups, lane);
    if all(at < textureDimensions(umbrage_mask)) {
        let visibility = umbrage_visibility(vec2i(at));
        textureStore(umbrage_mask, at, vec4f(visibility, 0.0, 0.0, 0.0));
    }
}
