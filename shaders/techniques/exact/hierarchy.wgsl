// Lookup of a receiver in a hierarchy over the light's view, which a device builds (on_device/).
// Tables: the hierarchy with its ids (table_0), the casters' corners (table_1), and the records of
// alpha-tested casters, if any (table_2).

const NO_CASTER = 0xffffffffu;
// Rows of the header of the nodes.
const HEADER = 4u;

fn corner_of(row: u32) -> vec3f {
    return bitcast<vec3f>(table_1[row].xyz);
}

const FACE_STEP = 3.0;
// That of on_device/shapes.wgsl.
const TEST_ERROR = 1.9073486e-6;
// A quarter of the least depth of a hit from a point light, as a fraction of the receiver's depth:
// rays end 2^-14 of their length before the light.
const LEAST_HIT = 1.52587890625e-5;
const GUARDS = vec2u(0x80808080u);
const ONES = 0x01010101u;

// Returns the position on the faces in a strip, and the depth.
fn point_of(o: vec3f) -> vec3f {
    let at = frame_point(o);
    return vec3f(at.on_face + vec2f(FACE_STEP * f32(at.face), 0.0), at.depth);
}

// Returns the top bits of four bytes as four bits.
fn top_bits(word: u32) -> u32 {
    return (((word >> 7u) & ONES) * 0x01020408u) >> 24u;
}

// Returns the children of a node that contain a point and begin before it, as bits.
fn children_at(node: u32, point: vec3f) -> u32 {
    let row = HEADER + 4u * node;
    let first = table_0[row];
    let inverse = bitcast<vec3f>(((vec3u(first.w) >> vec3u(0u, 8u, 16u)) & vec3u(0xffu)) << vec3u(23u));
    let difference = point - bitcast<vec3f>(first.xyz);
    let steps = difference * inverse;
    // The error of the triangle test grows with the distance to the caster. Around a point light,
    // it is divided by the depth at which a ray may hit.
    let error = TEST_ERROR * max(difference.z, 0.0);
    var around = error;
    if kernel.tiles.z == 1u {
        around /= max(bitcast<f32>(first.z), LEAST_HIT * point.z);
    }
    // A 64th of a step is more than the rounding of differences.
    let slack = vec3f(around, around, error) * inverse + 0.015625;
    let up = floor(steps + slack);
    let down = ceil(steps.xy - slack.xy);
    if any(up < vec3f(0.0)) || any(down > vec2f(127.0)) {
        return 0u;
    }
    let least = vec3u(min(up, vec3f(127.0)));
    let greatest = vec2u(max(down, vec2f(0.0)));
    let across = table_0[row + 1u];
    let along = table_0[row + 2u];
    let depth = table_0[row + 3u];
    let begun = ((vec2u(least.x * ONES) | GUARDS) - across.xy) & ((vec2u(least.y * ONES) | GUARDS) - along.xy);
    let not_over = (across.zw - greatest.x * ONES) & (along.zw - greatest.y * ONES);
    let all_of = begun & not_over & ((vec2u(least.z * ONES) | GUARDS) - depth.xy);
    // The last byte has a bit for each child that exists.
    return (top_bits(all_of.x) | (top_bits(all_of.y) << 4u)) & (depth.w >> 24u);
}

const MOST_LEVELS = 12;

// Returns the number of a child among the 64 of its node's block.
fn child_number(node: u32, child: u32) -> u32 {
    let words = table_0[HEADER + 4u * node + 3u].zw;
    return (words[child / 5u] >> (6u * (child % 5u))) & 63u;
}

fn first_of(level: u32) -> u32 {
    return table_0[1u + level / 4u][level % 4u];
}

// Skips the receiver's own triangle, which its ray can't hit, if `own` is the id of a caster.
fn is_shadowed(o: vec3f, d: vec3f, own: u32) -> bool {
    let skipped = select(NO_CASTER, own, kernel.tiles.w == 1u);
    let point = point_of(o);
    let rows = shear_rows(d);
    let levels = table_0[0].x;
    var level = levels;
    var node = 0u;
    var left = children_at(first_of(level), point);
    // Nodes above this one, and their children that are left.
    var above: array<vec2u, MOST_LEVELS>;
    loop {
        var caster = NO_CASTER;
        loop {
            if left == 0u {
                if level == levels {
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
                caster = table_0[table_0[0].y + below / 4u][below % 4u];
                break;
            }
            above[level] = vec2u(node, left);
            level -= 1u;
            node = below;
            left = children_at(first_of(level) + node, point);
        }
        if caster == NO_CASTER {
            return false;
        }
        if caster != skipped && meets_caster(o, d, rows, caster) {
            return true;
        }
    }
    return false;
}
