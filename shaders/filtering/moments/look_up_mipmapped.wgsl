// Twin of `MipmappedLookups` in look_up.rs: moments between texels and between levels. Levels from
// 1 on are one below the other in the kernel's second image.

fn blended_moments_of(at: vec2f, layer: i32, level: u32) -> vec4f {
    if level == 0u {
        return blended_moments(at, layer);
    }
    let size = size_0().x;
    var start = 0;
    for (var finer = 1u; finer < level; finer++) {
        start += size >> finer;
    }
    let last = (size >> level) - 1;
    let place = at * (1.0 / f32(1u << level)) - 0.5;
    let corner = floor(place);
    let share = place - corner;
    let origin = vec2i(0, start);
    let first = clamp(vec2i(corner), vec2i(0), vec2i(last)) + origin;
    let second = clamp(vec2i(corner) + 1, vec2i(0), vec2i(last)) + origin;
    let top_left = loaded_moments(load_1(first, layer));
    let top_right = loaded_moments(load_1(vec2i(second.x, first.y), layer));
    let bottom_left = loaded_moments(load_1(vec2i(first.x, second.y), layer));
    let bottom_right = loaded_moments(load_1(second, layer));
    let top = top_left + (top_right - top_left) * share.x;
    let bottom = bottom_left + (bottom_right - bottom_left) * share.x;
    return top + (bottom - top) * share.y;
}

fn filtered_moments(l: ShadowCoord, r: Receiver) -> FilteredMoments {
    let map = map_layer(l.layer);
    let texel = map.texel * transform(map.clip_from_world, r.position).w;
    let n_dot_l = dot3(r.normal, to_light(kernel.lookup.light, r.position));
    let mipmaps = kernel.mipmaps;
    let spanned = texels_spanned(mipmaps.eye, mipmaps.axis, r.position, r.normal, n_dot_l, texel);
    let level = mipmap_level(spanned, mipmaps.levels);
    let finer = u32(level.x);
    var moments = blended_moments_of(l.texel, l.layer, finer);
    if level.y > 0.0 {
        let coarser = blended_moments_of(l.texel, l.layer, finer + 1u);
        moments = moments + (coarser - moments) * level.y;
    }
    return FilteredMoments(moments, added_variance(level));
}
