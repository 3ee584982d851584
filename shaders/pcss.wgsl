// Twin of pcss.rs: search for blockers, conclude the penumbra's width, filter that widely.

struct PcssUniforms {
    lookup: MapLookup,
    extent: LightExtent,
    blocker_taps: u32,
    filter_taps: u32,
    turns: u32,
}

const DEPTH_UNITS = 8388608.0;

// How many taps see something nearer, and by how much in sum, in steps of 1 / DEPTH_UNITS.
fn blockers(l: Lookup, size: i32, axes: vec4f, shift: vec2f) -> vec2i {
    var found = vec2i(0, 0);
    for (var tap = 0u; tap < kernel.blocker_taps; tap++) {
        let d = tap_depths(l, size, axes, tap, shift);
        if !(d.y <= d.x) {
            found += vec2i(1, i32(min(d.y - d.x, 1.0) * DEPTH_UNITS));
        }
    }
    return found;
}

fn bounded(depth: f32, most: f32) -> f32 {
    return min(max(depth, 0.0), most);
}

fn receive(r: Receiver) -> f32 {
    let l = look_up(kernel.lookup, r.position, r.normal);
    if !l.seen {
        return 1.0;
    }
    let size = i32(kernel.lookup.size);
    let half = kernel.lookup.size * 0.5;
    let all = kernel.blocker_taps + kernel.filter_taps;
    let turn = pattern_row(all + (noise_index(r.pixel.x, r.pixel.y) & kernel.turns));
    let along = kernel.extent.along[l.layer];
    let from_middle = vec2f(l.texel.x - half, l.texel.y - half);
    let axes = turned(light_axes(kernel.extent.across[l.layer], along, from_middle), turn.xy);
    let found = blockers(l, size, axes * bounded(l.depth, along.w), turn.zw);
    if found.x == 0 {
        return 1.0;
    }
    let nearer = f32(found.y) / (f32(found.x) * DEPTH_UNITS);
    let reach = axes * bounded(nearer, along.w);
    return f32(lit_taps(l, size, reach, kernel.blocker_taps, kernel.filter_taps, turn.zw)) / f32(kernel.filter_taps);
}
