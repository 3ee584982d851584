@group(UMBRAGE_GROUP) @binding(1) var depth_texture: texture_multisampled_2d<f32>;
