// Points that a triangle hides if no caster is alpha-tested: all points that its outline covers.

fn met_outside_holes(bits: u32, row: u32, o: vec3f, plane: LightPlane, first: vec2f, step: vec2f) -> u32 {
    return bits;
}
