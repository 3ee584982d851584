// Twin of exact.rs: asks the list of a receiver's cell. Tiles (table_0), cells (table_1), items (table_2), outlines (table_3), corners
// of the casters (table_4).

struct ExactUniforms {
    light: LightSampler,
    eye: vec4f,
    across: vec4f,
    down: vec4f,
    away: vec4f,
    origin: vec4f,
    grid: vec4f,
    tiles: vec4u,
    far: f32,
}

// As exact/touches.rs has it.
const DEPTH_UNKNOWN = 0x80000000u;

struct FramePoint {
    direction: vec3f,
    face: u32,
    on_face: vec2f,
    depth: f32,
}

fn frame_point(o: vec3f) -> FramePoint {
    let v = o - kernel.origin.xyz;
    if kernel.tiles.z == 0u {
        let x = dot3(kernel.across.xyz, v);
        let y = dot3(kernel.down.xyz, v);
        let depth = dot3(kernel.away.xyz, v) - kernel.away.w;
        return FramePoint(vec3f(x, y, 1.0), 0u, vec2f(x, y), depth);
    }
    let size = abs(v);
    if size.x >= size.y && size.x >= size.z {
        let q = v / size.x;
        return FramePoint(q, select(0u, 1u, v.x < 0.0), q.yz, size.x);
    }
    if size.y >= size.z {
        let q = v / size.y;
        return FramePoint(q, select(2u, 3u, v.y < 0.0), q.zx, size.y);
    }
    let q = v / size.z;
    return FramePoint(q, select(4u, 5u, v.z < 0.0), q.xy, size.z);
}

fn meets(o: vec3f, d: vec3f, caster: u32) -> bool {
    let a = bitcast<vec3f>(table_4[3u * caster].xyz);
    let b = bitcast<vec3f>(table_4[3u * caster + 1u].xyz);
    let c = bitcast<vec3f>(table_4[3u * caster + 2u].xyz);
    return segment_hits(o, d, a, b, c);
}

fn is_shadowed(o: vec3f, d: vec3f, own: u32) -> bool {
    let point = frame_point(o);
    let is_lamp = kernel.tiles.z != 0u;
    let size = vec2f(kernel.tiles.xy);
    var at = (point.on_face + kernel.grid.xy) * kernel.grid.z;
    if is_lamp {
        at = clamp(at, vec2f(0.0), size - 0.001);
    } else if !(at.x >= 0.0 && at.y >= 0.0 && at.x < size.x && at.y < size.y) {
        return false;
    }
    let tile = vec2u(at);
    let number = (point.face * kernel.tiles.y + tile.y) * kernel.tiles.x + tile.x;
    let pair = table_0[number / 2u];
    let chosen = select(pair.xy, pair.zw, number % 2u == 1u);
    let cell = vec2u((at - floor(at)) * f32(1u << chosen.y));
    let head = table_1[chosen.x + (cell.y << chosen.y) + cell.x];
    if point.depth > bitcast<f32>(head.z) {
        return true;
    }
    let factor = select(1.0, point.depth, is_lamp);
    let summand = select(point.depth * kernel.origin.w, -kernel.origin.w, is_lamp);
    for (var i = head.x; i < head.x + head.y; i++) {
        let items = table_2[i / 2u];
        let item = select(items.xy, items.zw, i % 2u == 1u);
        if bitcast<f32>(item.y) > point.depth {
            return false;
        }
        let caster = item.x & ~DEPTH_UNKNOWN;
        if caster == own {
            continue;
        }
        let x = bitcast<vec4f>(table_3[3u * caster]);
        let y = bitcast<vec4f>(table_3[3u * caster + 1u]);
        let z = bitcast<vec4f>(table_3[3u * caster + 2u]);
        let value = x * point.direction.x + y * point.direction.y + z * point.direction.z;
        let depth = select(value.w * factor + summand, 0.0, item.x != caster);
        let least = min(min(min(value.x, value.y), value.z), depth);
        if least < -1.0 {
            continue;
        }
        if least > 1.0 || meets(o, d, caster) {
            return true;
        }
    }
    return false;
}

fn ray_reach(p: vec3f) -> f32 {
    let to_eye = abs(kernel.eye.xyz - p);
    return max(max(max(to_eye.x, to_eye.y), to_eye.z), kernel.grid.w);
}

fn receive(r: Receiver) -> f32 {
    let lift = origin_offset(r.position, ray_reach(r.position));
    let o = vec3f(r.position.x + r.normal.x * lift, r.position.y + r.normal.y * lift, r.position.z + r.normal.z * lift);
    let d = segment(kernel.light, o, vec2f(0.0), kernel.far);
    let is_lit = dot3(r.normal, d) > 0.0 && !is_shadowed(o, d, r.triangle);
    return select(0.0, 1.0, is_lit);
}
