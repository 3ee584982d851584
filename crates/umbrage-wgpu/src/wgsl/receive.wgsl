// The receive stage: calls the kernel for every pixel. Pixels that don't receive are lit.

@group(UMBRAGE_GROUP) @binding(UMBRAGE_MASK_BINDING)
var umbrage_mask: texture_storage_2d<r32float, write>;

fn umbrage_visibility(texel: vec2i) -> f32 {
    let seen = umbrage_seen(texel);
    if !seen.receives {
        return 1.0;
    }
    return receive(Receiver(seen.position, seen.normal, vec2u(texel), seen.triangle));
}

@compute @workgroup_size(8, 8)
fn umbrage_receive(@builtin(global_invocation_id) at: vec3u) {
    if all(at.xy < textureDimensions(umbrage_mask)) {
        let visibility = umbrage_visibility(vec2i(at.xy));
        textureStore(umbrage_mask, at.xy, vec4f(visibility, 0.0, 0.0, 0.0));
    }
}
