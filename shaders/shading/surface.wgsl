// Twin of surface.rs: surface properties at a visible point. table_0: vertices, three rows each;
// table_1: triangles; table_2: materials, five rows each; table_3: texels.

struct SurfacePoint {
    normal: vec3f,
    diffuse: vec3f,
    specular: vec3f,
    shininess_log2: u32,
    emissive: vec3f,
}

fn bilinear(texture: vec4u, uv: vec2f) -> vec4f {
    let x = neighbours(uv.x, texture.y);
    let y = neighbours(uv.y, texture.z);
    let s = fraction(uv.x, texture.y);
    let above = texture.x + y.x * texture.y;
    let below = texture.x + y.y * texture.y;
    let top = blend(bitcast<vec4f>(table_3[above + x.x]), bitcast<vec4f>(table_3[above + x.y]), s);
    let bottom = blend(bitcast<vec4f>(table_3[below + x.x]), bitcast<vec4f>(table_3[below + x.y]), s);
    return blend(top, bottom, fraction(uv.y, texture.z));
}

// Returns row `row` of the triangle's three vertices.
fn corners(triangle: vec4u, row: u32) -> array<vec4f, 3> {
    return array<vec4f, 3>(
        bitcast<vec4f>(table_0[3u * triangle.x + row]),
        bitcast<vec4f>(table_0[3u * triangle.y + row]),
        bitcast<vec4f>(table_0[3u * triangle.z + row]),
    );
}

fn shading_normal(weights: vec3f, n: vec4f, triangle: vec4u, map: vec4u, uv: vec2f, facing: vec3f) -> vec3f {
    var v = n.xyz;
    if map.y > 0u {
        let t = corners(triangle, 2u);
        let texel = bilinear(map, uv);
        let m = vec3f(texel.x * 2.0 - 1.0, texel.y * 2.0 - 1.0, texel.z * 2.0 - 1.0);
        v = bent(n.xyz, weighted(weights, t[0], t[1], t[2]), m);
    }
    return unit_or(on_side_of(n.xyz, v, facing), facing);
}

fn surface(id: u32, p: vec3f, facing: vec3f) -> SurfacePoint {
    let triangle = table_1[id];
    let at = corners(triangle, 0u);
    let normals = corners(triangle, 1u);
    let weights = barycentric(p, at[0].xyz, at[1].xyz, at[2].xyz);
    let position_u = weighted(weights, at[0], at[1], at[2]);
    let normal_v = weighted(weights, normals[0], normals[1], normals[2]);
    let uv = vec2f(position_u.w, normal_v.w);
    let row = 5u * triangle.w;
    let diffuse = table_2[row];
    var color = bitcast<vec3f>(diffuse.xyz);
    if table_2[row + 3u].y > 0u {
        color = color * bilinear(table_2[row + 3u], uv).xyz;
    }
    return SurfacePoint(
        shading_normal(weights, normal_v, triangle, table_2[row + 4u], uv, facing),
        color,
        bitcast<vec3f>(table_2[row + 1u].xyz),
        diffuse.w,
        bitcast<vec3f>(table_2[row + 2u].xyz),
    );
}
