// Walk of a receiver through the hierarchy over the light's view.

struct TreePlace {
    casters: u32,
    capacity: u32,
    levels: u32,
    level: u32,
    firsts: array<vec4u, 3>,
}

@group(0) @binding(7) var<uniform> tree: TreePlace;
@group(0) @binding(8) var<storage, read> nodes: array<vec4u>;
@group(0) @binding(9) var<storage, read> ids: array<u32>;

const FACE_STEP = 3.0;
// That of rects.wgsl.
const TEST_ERROR = 1.9073486e-6;
const GUARDS = vec2u(0x80808080u);
const ONES = 0x01010101u;
const MOST_LEVELS = 12;

// Returns the top bits of four bytes as four bits.
fn top_bits(word: u32) -> u32 {
    return (((word >> 7u) & ONES) * 0x01020408u) >> 24u;
}

// Returns the children of a node that contain a point and begin before it, as bits.
fn children_at(node: u32, point: vec3f) -> u32 {
    walked += 1u;
    let first = nodes[4u * node];
    let inverse = bitcast<vec3f>(((vec3u(first.w) >> vec3u(0u, 8u, 16u)) & vec3u(0xffu)) << vec3u(23u));
    let difference = point - bitcast<vec3f>(first.xyz);
    let steps = difference * inverse;
    // A 64th of a step is more than the rounding of differences. Under a directional light, the
    // error of the triangle test is added; for a point light it is part of the rectangles.
    let error = select(TEST_ERROR * max(difference.z, 0.0), 0.0, kernel.tiles.z == 1u);
    let slack = error * inverse + 0.015625;
    let up = floor(steps + slack);
    let down = ceil(steps.xy - slack.xy);
    if any(up < vec3f(0.0)) || any(down > vec2f(127.0)) {
        return 0u;
    }
    let least = vec3u(min(up, vec3f(127.0)));
    let greatest = vec2u(max(down, vec2f(0.0)));
    let across = nodes[4u * node + 1u];
    let along = nodes[4u * node + 2u];
    let depth = nodes[4u * node + 3u];
    let begun = ((vec2u(least.x * ONES) | GUARDS) - across.xy) & ((vec2u(least.y * ONES) | GUARDS) - along.xy);
    let not_over = (across.zw - greatest.x * ONES) & (along.zw - greatest.y * ONES);
    let all_of = begun & not_over & ((vec2u(least.z * ONES) | GUARDS) - depth.xy);
    return top_bits(all_of.x) | (top_bits(all_of.y) << 4u);
}

// Returns the number of a child among the 64 of its node's block.
fn child_number(node: u32, child: u32) -> u32 {
    let words = nodes[4u * node + 3u].zw;
    return (words[child / 5u] >> (6u * (child % 5u))) & 63u;
}

fn first_of(level: u32) -> u32 {
    return tree.firsts[level / 4u][level % 4u];
}

fn is_shadowed(o: vec3f, d: vec3f, own: u32) -> bool {
    let at = frame_point(o);
    let point = vec3f(at.on_face + vec2f(FACE_STEP * f32(at.face), 0.0), at.depth);
    let rows = shear_rows(d);
    var level = tree.levels;
    var node = 0u;
    var left = children_at(first_of(level), point);
    // Nodes above this one, and their children that are left.
    var above: array<vec2u, MOST_LEVELS>;
    loop {
        var caster = NO_CASTER;
        loop {
            if left == 0u {
                if level == tree.levels {
                    break;
                }
                level += 1u;
                node = above[level].x;
                left = above[level].y;
                continue;
            }
            let child = firstTrailingBit(left);
            left &= left - 1u;
            let below = 64u * (node / 8u) + child_number(first_of(level) + node, child);
            if level == 1u {
                let id = ids[below];
                if id != own {
                    caster = id;
                    break;
                }
                continue;
            }
            above[level] = vec2u(node, left);
            level -= 1u;
            node = below;
            left = children_at(first_of(level) + node, point);
        }
        if caster == NO_CASTER {
            return false;
        }
        tested += 1u;
        if meets_caster(o, d, rows, caster) {
            return true;
        }
    }
    return false;
}
