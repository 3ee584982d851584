// Entry of a light; `LightEntry` is its twin. The first vector contains the data of every lookup.

struct ShadowLight {
    // x: the kind of kernel, counted from 1 (bits 0 to 7; 0: no shadows, the light is lit), index
    // of the kernel's uniforms (8 to 19), and first layer of image 0 (20 to 31). y: index of each
    // image's texture, 8 bits each. z, w: first layers of images 1, 2 (16 bits each) and 3; if
    // there is a fifth table, its number of rows, and its first row.
    places: vec4u,
    // First rows of the first four tables.
    rows: vec4u,
    // Numbers of rows of the first four tables.
    row_counts: vec4u,
}

// The light that `shadow_on` evaluates.
var<private> shadow_index: u32;
