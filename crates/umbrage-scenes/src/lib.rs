//! Scenes for umbrage: built in, from scene files, from models.
//!
//! * **Built in**: [`all`] lists them and [`find`] finds one by name. Scenes of
//!   [`Kind::ClosedForm`] have points with analytic visibility; scenes of [`Kind::Failure`] provoke
//!   a known weakness; [`Kind::Speed`] is for timing; [`Kind::Content`] resembles games and films.
//! * **A scene file** (`.toml`) or **a model** (`.obj`; `.glb` and `.gltf` with the feature
//!   `gltf`): [`load`].
//! * **Either**: [`by_argument`], for command lines.
//! * **In motion**: [`motion`] has the scenes with a moving camera, light or casters, and their
//!   paths.
//! * **Files that are not on disk**: [`read`], including all files that a scene file or a model
//!   names.
//!
//! ```
//! let scene = umbrage_scenes::by_argument("cubes")?;
//! assert_eq!(scene.instances.len(), 4);
//!
//! let text = r#"
//!     [[light]]
//!     kind = "directional"
//!     direction = [1, -2, 0.5]
//!     [[object]]
//!     shape = "sphere"
//! "#;
//! let scene = umbrage_scenes::parse(text, "ball.toml", ".")?;
//! assert_eq!(scene.name, "ball");
//! # Ok::<(), umbrage_scenes::SceneError>(())
//! ```
//!
//! # Scene files
//!
//! World space is right-handed, y up, metres; angles are degrees. Numbers may be written with or
//! without a point. Unknown keys, wrong types, numbers out of range and missing files are errors
//! that name the file, the line and the key.
//!
//! | key | unit or type | default |
//! |---|---|---|
//! | `name` | text of at most 200 bytes | the file's name without `.toml` |
//! | `anchor` | `[x, y, z]` metres: positions (`eye`, `target`, `position`, `center`, `translate`, a `matrix`) are read as 64-bit numbers, and become relative to the multiple of 1,024 m nearest to this point ([`Anchor`](umbrage_core::Anchor)); for scenes far from the origin | the origin, or near the camera and the geometry if they are far from it (a notice says so) |
//! | **`[camera]`** | row 0 is the top row, rays go through pixel centres | frames all geometry from the right, above and in front |
//! | `eye`, `target` | `[x, y, z]` metres | needed |
//! | `up` | `[x, y, z]`, any length; may be parallel to the view | `[0, 1, 0]` |
//! | `fov_y_degrees` | full vertical angle, above 0 and below 180 | 36 |
//! | `size` | `[width, height]` pixels, 1 to 16384 | `[640, 360]` |
//! | `near`, `far` | metres along the view, `0 < near < far` | fitted to the visible geometry, so that nothing is clipped |
//! | **`[[light]]`** | one or more; the first is compared | needed |
//! | `kind` | `"directional"`, `"point"`, `"spot"`, `"rect"`, `"disc"` | needed |
//! | `direction` | directional, spot: direction of the light rays, any length | needed |
//! | `angular_diameter_degrees` | directional: angular diameter, 0 to below 180 (Sun: 0.53) | 0 |
//! | `position` | point, spot: metres | needed |
//! | `inner_degrees` | spot: half angle of full light, at most the outer one | `outer_degrees` |
//! | `outer_degrees` | spot: half angle where light ends, above 0 and below 90 | needed |
//! | `radius` | point, spot, disc: metres | 0; needed for a disc, above 0 |
//! | `center` | rect, disc: metres | needed |
//! | `half_u`, `half_v` | rect: from the centre to the middles of two neighbouring sides, metres | needed |
//! | `normal` | disc: normal of its plane, any length; it emits on both sides | needed |
//! | **`[[object]]`** | one or more | needed |
//! | `mesh` | a model, relative to the scene file: an `.obj` file, or (feature `gltf`) a `.glb` or `.gltf` file, where `model.glb#night` selects one scene; see [below](#models-in-scene-files) | this or `shape` |
//! | `shape` | `"plane"` (a square in x and z that faces +y), `"box"` or `"sphere"`; all reach from -1 to 1 | this or `mesh` |
//! | `matrix` | four rows of four, world from local for column vectors; the last row is `[0, 0, 0, 1]` | identity |
//! | `scale` | one number, or `[x, y, z]`; negative ones mirror; placed objects are 1e-6 to 1e8 m across | 1 |
//! | `rotate_degrees` | `[x, y, z]`: about the x axis, then y, then z, after scaling | `[0, 0, 0]` |
//! | `translate` | `[x, y, z]` metres, after turning; at most 1e8 from the origin, or the anchor | `[0, 0, 0]` |
//! | `casts`, `receives` | whether it casts and receives shadows | `true` |
//! | `color` | `[r, g, b]`, linear (not sRGB), 0 to 1; multiplied with the texture | grey 0.5; white with a texture |
//! | `texture` | a `.png` file of colours in sRGB, relative to the scene file | none |
//! | `specular` | the highlight's colour: one number or `[r, g, b]`, linear, 0 to 1 | 0.15 |
//! | `shininess` | the highlight's power: a power of two, 1 to 4096 | 32 |
//! | `emissive` | `[r, g, b]`, linear: emitted light, independent of shadows | `[0, 0, 0]` |
//! | `alpha_map` | a `.png` file for the alpha test of light and camera: its alpha, or its first channel if it has no alpha | none |
//! | `alpha_cutoff` | least alpha of opaque texels, 0 to 1; the nearest texel is used | 0.5 |
//! | `alpha_filter` | `"nearest"`, or `"hashed"`: the camera and maps compare mipmapped coverage with hashed thresholds where their pixels are larger than texels. With `alpha_map` it applies to that map; alone, on a `mesh`, to the model's own alpha tests | `"nearest"` |
//! | `normal_map` | a `.png` file of tangent-space normals, green up (OpenGL's convention) | none |
//! | `height_map` | a `.png` file of heights, 0 to 1 in its first channel, preferably of 16 bits; it moves the vertices | none |
//! | `displacement` | metres (before scaling) by which white moves vertices out and black moves them in; negative values invert the relief | needed with `height_map` |
//! | `subdivisions` | how often each triangle is first split in four, 0 to 8: a coarse mesh can't show relief | 0 |
//!
//! Images have 8 or 16 bits a channel, and are read once each. An object with any of these keys
//! replaces the looks of its model; a model without them (except `alpha_filter`) keeps its own, see
//! below. Textures repeat, and require texture coordinates. The three shapes have them: the plane
//! and each side of the box cover one repeat, the sphere has longitude and latitude.
//!
//! # Models
//!
//! Wavefront OBJ, y up, in metres. All faces of one material become one mesh; polygons, including
//! concave ones, are cut into triangles. Names, groups, lines and points are ignored. Normals and
//! texture coordinates are kept if all corners have usable ones; those that can't be read are
//! ignored. [`Scene::notices`](umbrage_core::Scene::notices) lists what is ignored, except names. A model loaded alone receives a
//! floor unless it has its own ground, a camera (inside, for a building around its own floor), and
//! a sun.
//!
//! These keys of `.mtl` files are read: `Kd`, `Ks`, `Ke`, `Ns` (rounded to a power of two),
//! `map_Kd`, `map_d` and, for normals, `norm` or `map_Bump`. Alpha below one half, of `map_d` or
//! else of `map_Kd`, fails the alpha test. Shadows don't need looks, and many models lack theirs,
//! so these are ignored: missing `.mtl` files or textures, textures that are neither PNG nor JPEG (which needs the feature `gltf`), and grey bump
//! maps (heights of unknown scale). They are listed in the notices for the materials that faces use.
//! So are transparency (`d`, `Tr`), `disp`, `map_Ks` and other textures, and the options `-o`, `-s`,
//! `-t`, `-mm`, `-bm`, `-clamp` and `-imfchan`. A `.png` file that can't be decoded and a number that
//! can't be read are errors.
//!
//! ## glTF
//!
//! glTF 2.0 (feature `gltf`): `.gltf` with the files that it names, and `.glb`. The default scene
//! is read, or the one named after the path: `model.glb#night`, `model.glb#1` (counted from 0). A
//! file with neither a camera nor a light is completed like any lone model. If it has one of the
//! two, only the other is added.
//!
//! | what | how it is read |
//! |---|---|
//! | meshes | triangles, strips and fans, with indices of 8, 16 or 32 bits or none, sparse accessors, `KHR_mesh_quantization`; each primitive becomes a mesh. Without normals, surfaces are flat. Morph targets are applied at the weights of the file, and skins at the pose of their joints. Points, lines and animations are ignored; Draco compression, too, unless the file requires it |
//! | nodes | matrices, or translation, rotation and scale, multiplied in 64 bits; mirrored ones keep their outside outwards. A node scaled to zero along all axes is hidden, and one that flattens its mesh is ignored; `EXT_mesh_gpu_instancing`, `KHR_node_visibility` (meshes and lights) |
//! | cameras | with and without perspective, with and without a far plane; node scales are ignored. Images are 360 pixels high, with a width from the aspect ratio (640 without one) |
//! | lights | `KHR_lights_punctual`. Masks don't depend on brightness: intensities, colours and ranges are checked but unused, except that a light that is black or of intensity 0 is off. Cones are limited to 89.9 degrees |
//! | sizes of lights | the format has none: `shadow_soft_size` or `radius` (metres) of points and spots, `angle` (radians) of suns, in the `extras` of the light or its node. Blender writes custom properties there; its built-in radius is only exported as one |
//! | materials | base colour with its texture, normal map, colour of emission; `KHR_texture_transform`. Textures repeat. Metalness, roughness and other textures are ignored; so are normal maps with other coordinates than the colours, and vertex colours (`COLOR_0`) with their alpha |
//! | masks | `alphaMode` `MASK` cuts out texels below `alphaCutoff`; `BLEND` those below one half, and a surface that is less than half opaque everywhere casts no shadow. Alpha tests are kept as [`Material::alpha`](umbrage_core::Material::alpha); the techniques `planar` and `volumes` refuse such casters. A texture that is opaque everywhere, such as a JPEG, cuts nothing out. Alpha tests repeat: a sampler that clamps or mirrors is an error if a mesh would show a difference |
//! | glass | `BLEND` as above. `KHR_materials_transmission` is ignored: such a surface casts like a wall, unless its alpha prevents it |
//! | sides | all surfaces are visible and cast on both sides, regardless of `doubleSided` |
//! | images | PNG and JPEG, embedded or next to the file, regardless of their names. An image that is missing or of another kind is ignored unless an alpha test needs it |
//!
//! What a file uses and the reader ignores is listed in
//! [`Scene::notices`](umbrage_core::Scene::notices), one line each.
//!
//! Paths are relative to the file, and may leave its folder, like those of OBJ; addresses with a
//! scheme (`https:`) are refused, except `data:`. Required extensions that aren't named here are
//! errors, except `KHR_materials_..`, which shadows don't need. The length of a file limits its
//! resources: a few kilobytes that name a gigabyte are refused.
//!
//! ## Models in scene files
//!
//! A model that a scene file names as `mesh` is one object, regardless of its number of meshes. The
//! object's placement, `casts` and `receives` apply to the whole model. Several objects with one
//! model share its meshes.
//!
//! A glTF file contributes all meshes of its default scene (or of the one named after `#`), placed
//! by its nodes, with its materials and their alpha tests. Parts whose material prevents shadows
//! cast none here, either. Its cameras and lights are ignored in favour of the scene file's. An
//! object with looks of its own replaces all of the file's, including alpha tests and panes of
//! glass; its textures then use `TEXCOORD_0`. `alpha_filter` alone is no look: it applies to the
//! model's own alpha tests, of OBJ and of glTF.
//!
//! ## Far coordinates
//!
//! Positions in all files are read as 64-bit numbers. A model or scene that is far from the origin
//! (1.5 km, and 8 times its size), such as one in UTM metres or in earth-centred coordinates, is
//! stored relative to an [`Anchor`](umbrage_core::Anchor) near its camera, with a notice. The key
//! `anchor` of scene files applies to the vertices of models, too. Camera files have positions of the
//! scene file, and share its anchor.
//!
//! # Detailed surfaces
//!
//! [`with_tangents`] prepares a mesh for normal maps, [`fitting_normal_map`] computes the normal
//! map of a height map, and [`denoise`] smooths noisy meshes by displacement.

mod builtin;
mod catalogue;
#[cfg(test)]
mod damage;
mod detail;
mod entry;
mod error;
mod far;
#[cfg(test)]
mod far_tests;
mod file;
mod files;
mod framing;
#[cfg(feature = "gltf")]
mod gltf;
#[cfg(not(feature = "gltf"))]
#[path = "gltf_left_out.rs"]
mod gltf;
mod load;
mod lone_model;
mod looks;
mod model_part;
mod model_triangles;
pub mod motion;
mod nearest;
mod obj;
mod polygon;
mod primitives;
mod scene_of_file;
mod stage;

pub use builtin::textbook::TEXTBOOK_FIT;
pub use catalogue::{all, find};
pub use detail::{denoise, fitting_normal_map, with_tangents};
pub use entry::{ClosedForm, Failure, Kind, Sample, SceneEntry};
pub use error::{Place, SceneError};
pub use file::cameras;
pub use files::{Files, FilesInMemory, FilesOnDisk, OpenFile, SizedFilesOnDisk};
pub use load::{brings_light, by_argument, file_of, is_model, load, load_triangles, parse, read};
pub use model_triangles::ModelTriangles;
