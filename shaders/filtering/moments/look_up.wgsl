// Twin of look_up.rs: the common part of every kernel with moments. The technique defines
// `lit_by_moments` and `compared_depth`; `filtered_moments` is in look_up_one_level.wgsl or
// look_up_mipmapped.wgsl.

struct FilteredMoments {
    moments: vec4f,
    // Increase of the averaged positions' variance in a coarser level, texels squared.
    spread: f32,
}

// Returns the kernel's first image, blended between its texels.
fn blended_moments(at: vec2f, layer: i32) -> vec4f {
    let last = size_0() - 1;
    let place = at - 0.5;
    let corner = floor(place);
    let share = place - corner;
    let first = clamp(vec2i(corner), vec2i(0), last);
    let second = clamp(vec2i(corner) + 1, vec2i(0), last);
    let top_left = loaded_moments(load_0(first, layer));
    let top_right = loaded_moments(load_0(vec2i(second.x, first.y), layer));
    let bottom_left = loaded_moments(load_0(vec2i(first.x, second.y), layer));
    let bottom_right = loaded_moments(load_0(second, layer));
    let top = top_left + (top_right - top_left) * share.x;
    let bottom = bottom_left + (bottom_right - bottom_left) * share.x;
    return top + (bottom - top) * share.y;
}

fn visibility(l: ShadowCoord, r: Receiver) -> f32 {
    let size = f32(size_0().x);
    let is_inside = l.texel.x >= 0.0 && l.texel.y >= 0.0 && l.texel.x < size && l.texel.y < size;
    if is_lit_outside(!is_inside) {
        return 1.0;
    }
    if own_depth(l) > 1.0 {
        return 0.0;
    }
    let filtered = filtered_moments(l, r);
    let depth = centred(min(compared_depth(l, filtered.spread), l.deepest));
    let lit = lit_by_moments(filtered.moments, depth);
    return without_bleeding(lit, kernel.bleeding, kernel.bleeding_scale);
}
