// Walk of a receiver through a hierarchy. The space's module defines `Ray`, `ray_of`, `children_at`
// and the number of rows of a node.

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

const MOST_LEVELS = 12;

// Returns the number of a child among the 64 of its node's block.
fn child_number(node: u32, child: u32) -> u32 {
    let last = nodes[ROWS * node + ROWS - 1u];
    let words = select(last.zw, last.xy, ROWS == 5u);
    return (words[child / 5u] >> (6u * (child % 5u))) & 63u;
}

fn first_of(level: u32) -> u32 {
    return tree.firsts[level / 4u][level % 4u];
}

fn is_shadowed(o: vec3f, d: vec3f, own: u32) -> bool {
    let ray = ray_of(o, d);
    let rows = shear_rows(d);
    var level = tree.levels;
    var node = 0u;
    var left = children_at(first_of(level), ray);
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
            left = children_at(first_of(level) + node, ray);
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
