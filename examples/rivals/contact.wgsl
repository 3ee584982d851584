// Twin of `ContactKernel` in mod.rs.

const MAX_PIXELS = 512.0;
const PIXELS_ALONE = 4;
const PIXELS_FADING = 8;
const SAME_SURFACE = 0.02;
const LEAST_DEPTH = 1.0 / 32.0;

struct ContactUniforms {
    lookup: ShadowMapUniforms,
    x_from_world: vec4f,
    y_from_world: vec4f,
    z_from_world: vec4f,
    w_from_world: vec4f,
    light_on_image: vec4f,
    image_size: vec2u,
    radius: i32,
    pixels: i32,
    thickness: f32,
}

struct Walk {
    step: vec2f,
    start_depth: f32,
    depth_step: f32,
    steps: i32,
}

fn row_times_point(row: vec4f, p: vec3f) -> f32 {
    return row.x * p.x + row.y * p.y + row.z * p.z + row.w;
}

fn by_map(l: ShadowCoord) -> f32 {
    let radius = kernel.radius;
    let x = i32(floor(l.texel.x));
    let y = i32(floor(l.texel.y));
    let size = size_0().x;
    var lit = 0.0;
    for (var dy = -radius; dy <= radius; dy++) {
        for (var dx = -radius; dx <= radius; dx++) {
            lit += tap(size, l, x + dx, y + dy);
        }
    }
    let side = f32(2 * radius + 1);
    return lit / (side * side);
}

// Returns the path of the ray. `steps` is 0 if the ray does not extend over the image.
fn walk_from(p: vec3f) -> Walk {
    let x = row_times_point(kernel.x_from_world, p);
    let y = row_times_point(kernel.y_from_world, p);
    let z = row_times_point(kernel.z_from_world, p);
    let w = row_times_point(kernel.w_from_world, p);
    let light = kernel.light_on_image;
    let right = (light.x * w - x * light.w) * (0.5 * f32(kernel.image_size.x));
    let down = (y * light.w - light.y * w) * (0.5 * f32(kernel.image_size.y));
    let deeper = light.z * w - z * light.w;
    let longer = max(abs(right), abs(down));
    if longer <= 0.0 {
        return Walk(vec2f(0.0, 0.0), 0.0, 0.0, 0);
    }
    var steps = kernel.pixels;
    if light.w > 0.0 {
        let pixels_to_light = longer / (w * light.w);
        steps = min(steps, i32(min(pixels_to_light, MAX_PIXELS)));
    }
    return Walk(vec2f(right / longer, down / longer), z / w, deeper / longer, steps);
}

fn seen_depth(x: f32, y: f32, along_x: bool) -> f32 {
    let size = vec2i(kernel.image_size);
    let column = i32(floor(x));
    let row = i32(floor(y));
    let near = load_1(vec2i(column, row), 0).x;
    let across = select(x - f32(column) - 0.5, y - f32(row) - 0.5, along_x);
    let side = select(1, -1, across < 0.0);
    let beside = vec2i(column, row) + select(vec2i(side, 0), vec2i(0, side), along_x);
    let other = load_1(clamp(beside, vec2i(0), size - 1), 0).x;
    let is_same_surface = abs(other - near) < SAME_SURFACE * (1.0 - near);
    let share = abs(across);
    return select(near, near * (1.0 - share) + other * share, is_same_surface);
}

fn by_walk(p: vec3f, pixel: vec2u) -> f32 {
    let walk = walk_from(p);
    let along_x = abs(walk.step.x) >= 1.0;
    let size = vec2f(kernel.image_size);
    var alone = 1.0;
    var groups = vec4f(1.0, 1.0, 1.0, 1.0);
    for (var i = 1; i <= walk.steps; i++) {
        let steps = f32(i);
        let x = f32(pixel.x) + 0.5 + walk.step.x * steps;
        let y = f32(pixel.y) + 0.5 + walk.step.y * steps;
        if x < 0.0 || y < 0.0 || x >= size.x || y >= size.y {
            break;
        }
        let seen = seen_depth(x, y, along_x);
        let ray = walk.start_depth + walk.depth_step * steps;
        let before = (ray - seen) / ((1.0 - seen) * kernel.thickness);
        if !(before > LEAST_DEPTH && before < 1.0) {
            continue;
        }
        if i <= PIXELS_ALONE {
            alone = 0.0;
            break;
        }
        let fading = max(i - (kernel.pixels - PIXELS_FADING), 0);
        let lit = f32(fading) / f32(PIXELS_FADING + 1);
        let group = i & 3;
        groups[group] = min(groups[group], lit);
    }
    return alone * (0.25 * (groups.x + groups.y + groups.z + groups.w));
}

fn visibility(l: ShadowCoord, r: Receiver) -> f32 {
    let lit = by_map(l);
    if lit == 0.0 {
        return 0.0;
    }
    return lit * by_walk(r.position, r.pixel);
}
