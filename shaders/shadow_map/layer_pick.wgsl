// Twin of the functions in layers.rs and cascades.rs that read the kernel's layers: the layer of a
// receiver, and its weight.

fn holds(layer: i32, p: vec3f) -> bool {
    let room = room_around(kernel.lookup.layers[layer].clip_from_world, p, kernel.lookup.size);
    return is_held(room, kernel.lookup.pick_reach);
}

fn cascade_at(p: vec3f) -> i32 {
    let last = i32(kernel.lookup.layer_count) - 1;
    for (var layer = 0; layer < last; layer++) {
        if holds(layer, p) {
            return layer;
        }
    }
    return last;
}

fn share_of_layer(layer: i32, p: vec3f) -> f32 {
    if layer + 1 >= i32(kernel.lookup.layer_count) {
        return 1.0;
    }
    let own = kernel.lookup.layers[layer].clip_from_world;
    let room = room_around(own, p, kernel.lookup.size);
    let share = own_share(room, kernel.lookup.pick_reach, kernel.lookup.layers[layer].depth_in_texels, kernel.lookup.blend);
    if share < 1.0 && holds(layer + 1, p) {
        return share;
    }
    return 1.0;
}

fn layer_at(light: vec4f, p: vec3f) -> i32 {
    if ARRANGEMENT == CUBE {
        return cube_face(light, p);
    }
    if ARRANGEMENT == CASCADED_MAPS {
        return cascade_at(p);
    }
    return 0;
}

fn map_layer(layer: i32) -> MapLayer {
    if ARRANGEMENT == SINGLE_MAP {
        return kernel.lookup.layers[0];
    }
    return kernel.lookup.layers[layer];
}
