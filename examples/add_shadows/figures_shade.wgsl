struct FigureSurface {
    @builtin(position) at: vec4f,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) cloth_at: vec2f,
}

@vertex fn figure_surface(corner: Corner) -> FigureSurface {
    let placement = world_from_local(corner.weight);
    let world = placement * vec4f(corner.position, 1.0);
    let normal = placement * vec4f(corner.normal, 0.0);
    return FigureSurface(scene.clip_from_world * world, world.xyz, normal.xyz, corner.cloth_at);
}

@fragment fn shade_figure(
    seen: FigureSurface,
    @builtin(front_facing) is_front: bool,
) -> @location(0) vec4f {
    cut_out(seen.cloth_at);
    let normal = normalize(select(-seen.normal, seen.normal, is_front));
    var light = 0.05;
    for (var i = 0u; i < LAMPS; i++) {
        let visibility = shadow(i, seen.position, normal, vec2u(seen.at.xy));
        light += arriving(i, seen.position, normal) * visibility;
    }
    return vec4f(vec3f(0.9, 0.6, 0.4) * light, 1.0);
}
