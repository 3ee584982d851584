// Pixels of a workgroup of 64 invocations: a block of 8 x 8.

// Returns the pixel of an invocation. The number of workgroups along y is a multiple of 8, so
// pixels may be outside of the image.
//
// Consecutive workgroups along y take every eighth row of blocks. So devices that give each core a
// run of workgroups give each a share of the sky and of the ground.
//
// Eight neighbours in `lane` are a block of 4 x 2 pixels, and 32 are one of 8 x 4, so that similar
// pixels run together.
fn umbrage_pixel(group: vec3u, groups: vec3u, lane: u32) -> vec2u {
    let x = (lane & 3u) | ((lane >> 1u) & 4u);
    let y = ((lane >> 2u) & 1u) | ((lane >> 3u) & 6u);
    let run = groups.y / 8u;
    let row = group.y % run * 8u + group.y / run;
    return vec2u(group.x, row) * 8u + vec2u(x, y);
}
