// Twin of pcss.rs: bounds the search, searches blockers, estimates the penumbra's width, and
// filters with it.

struct PcssUniforms {
    lookup: ShadowMapUniforms,
    extent: LightExtent,
    horizon: Horizon,
    blocker_taps: u32,
    filter_taps: u32,
    turns: u32,
    square: u32,
    cell: u32,
}

// Coordinates of a receiver on the map, the light's rotated half axes there, and the bounds of
// differences of clip depth. `most` is the greatest difference that is followed, `texel` the one
// that moves the light's edge by a texel. `heights` are those of the light's points.
struct Soft {
    l: ShadowCoord,
    size: i32,
    axes: vec4f,
    most: f32,
    texel: f32,
    shift: vec2f,
    heights: vec3f,
}

// Returns a shifted tap: its position in the pattern (xy), and its distance from the centre (z).
fn spot(s: Soft, tap: u32) -> vec3f {
    let row = pattern_row(tap);
    let x = wrapped(row.x + s.shift.x);
    let y = wrapped(row.y + s.shift.y);
    return vec3f(x, y, from_middle(x, y, row.z));
}

// Returns the mean by which blockers are nearer; the whole search range if there are none.
fn mean_nearer(s: Soft, widest: f32) -> f32 {
    let axes = s.axes * widest;
    var sum = 0.0;
    var weights = 0.0;
    for (var tap = 0u; tap < kernel.blocker_taps; tap++) {
        let q = spot(s, tap);
        let closer = closer_by(q.z);
        let d = place_depths(s.l, s.size, place(s.l.texel, axes, q.xy * closer));
        let nearer = own_depth(s.l) - d.x;
        if !(d.y <= d.x) && nearer >= widest * (q.z * closer) {
            let weight = tap_weight(q.z, max(nearer, s.texel));
            sum += weight * (d.y - d.x);
            weights += weight;
        }
    }
    if weights > 0.0 {
        return sum / weights;
    }
    return widest;
}

// Returns whether the light's point at the tap is hidden. A surface at the tap that is too low to
// block the ray is looked up again where the ray is at its height.
fn hides(s: Soft, q: vec3f, axes: vec4f, mean: f32) -> bool {
    let d = place_depths(s.l, s.size, place(s.l.texel, axes, q.xy));
    if d.y <= d.x {
        return false;
    }
    let nearer = own_depth(s.l) - d.x;
    if nearer >= mean * q.z {
        return true;
    }
    if nearer <= 0.0 {
        return false;
    }
    let lower = place_depths(s.l, s.size, place(s.l.texel, s.axes * nearer, q.xy));
    return !(lower.y <= lower.x) && own_depth(s.l) - lower.x >= nearer * 0.5;
}

// Returns the visible fraction of the light above the horizon; 1 if no tap is above it.
fn filtered(s: Soft, mean: f32) -> f32 {
    let axes = s.axes * min(max(mean, s.texel), s.most);
    var above = 0;
    var lit = 0;
    for (var tap = kernel.blocker_taps; tap < kernel.blocker_taps + kernel.filter_taps; tap++) {
        let q = spot(s, tap);
        if s.heights.x + s.heights.y * q.x + s.heights.z * q.y > 0.0 {
            above += 1;
            lit += select(1, 0, hides(s, q, axes, mean));
        }
    }
    return select(1.0, quotient(f32(lit), f32(above)), above > 0);
}

fn heights_of_light(r: Receiver, layer: i32, from_middle: vec2f) -> vec3f {
    let middle = height_over_plane(kernel.lookup.light, r.position, r.normal);
    let h = kernel.horizon;
    if h.half_u.w > 0.0 {
        let face = map_layer(layer).clip_from_world;
        let tangent = kernel.extent.half_axis_u[layer].w;
        let unit = tangent * (kernel.lookup.size * 0.5);
        let right = face[0].x * r.normal.x + face[1].x * r.normal.y + face[2].x * r.normal.z;
        let up = face[0].y * r.normal.x + face[1].y * r.normal.y + face[2].y * r.normal.z;
        let grows = ball_heights(h.half_u.w, vec2f(right * unit, -up * unit), from_middle * tangent);
        return vec3f(middle, grows);
    }
    return vec3f(middle, dot3(r.normal, h.half_u.xyz), dot3(r.normal, h.half_v.xyz));
}

// Returns the least clip depth at which a surface may hide part of the light.
fn depth_in_reach(l: ShadowCoord) -> f32 {
    let last = i32(kernel.lookup.size) - 1;
    let x = clamp(i32(floor(l.texel.x)), 0, last) / i32(kernel.cell);
    let y = clamp(i32(floor(l.texel.y)), 0, last) / i32(kernel.cell);
    return load_1(vec2i(x, y), l.layer).x;
}

// Returns the fraction of the light above the horizon.
fn full_light(r: Receiver) -> f32 {
    return light_share(kernel.horizon, kernel.square, kernel.lookup.light, r.position, r.normal);
}

fn visibility(l: ShadowCoord, r: Receiver) -> f32 {
    let share = full_light(r);
    let half_axis_v = kernel.extent.half_axis_v[l.layer];
    let widest = min(max(own_depth(l) - depth_in_reach(l), 0.0), half_axis_v.w);
    if share == 0.0 || widest == 0.0 {
        return share;
    }
    let half = kernel.lookup.size * 0.5;
    let off = vec2f(l.texel.x - half, l.texel.y - half);
    let all = kernel.blocker_taps + kernel.filter_taps;
    let turn = pattern_row(all + (noise_index(r.pixel.x, r.pixel.y) & kernel.turns));
    let axes = turned(light_axes(kernel.extent.half_axis_u[l.layer], half_axis_v, off), turn.xy);
    let texel = texel_depth(reach_along(kernel.square, axes));
    var heights = vec3f(1.0, 0.0, 0.0);
    if share < 1.0 {
        heights = turned_heights(heights_of_light(r, l.layer, off), turn.xy);
    }
    let s = Soft(l, i32(kernel.lookup.size), axes, half_axis_v.w, texel, turn.zw, heights);
    return share * filtered(s, mean_nearer(s, widest));
}
