//! Scenes for umbrage: built in, from scene files, from models.
//!
//! * **Built in**: [`all`] lists them and [`find`] finds one by name. Those of [`Kind::ClosedForm`]
//!   bring points whose visibility a formula tells; those of [`Kind::Failure`] provoke a known
//!   weakness; [`Kind::Speed`] is for timing; [`Kind::Content`] is as what games and films show.
//! * **A scene file** (`.toml`) or **a model** (`.obj`; `.glb` and `.gltf` with the feature
//!   `gltf`): [`load`].
//! * **Either**: [`by_argument`], for command lines.
//! * **In motion**: [`motion`] has those in which the camera, the light or casters move, and how.
//! * **Files that are not on disk**: [`read`], with all that a scene file or a model names.
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
//! | `anchor` | `[x, y, z]` metres: places (`eye`, `target`, `position`, `center`, `translate`, a `matrix`) are read as 64-bit numbers, and become relative to the multiple of 1,024 m nearest to this point ([`Anchor`](umbrage_core::Anchor)); for scenes far from the origin | the origin |
//! | **`[camera]`** | row 0 is the top row, rays go through pixel centres | frames everything from right, above and in front |
//! | `eye`, `target` | `[x, y, z]` metres | needed |
//! | `up` | `[x, y, z]`, any length; may be parallel to the view | `[0, 1, 0]` |
//! | `fov_y_degrees` | full vertical angle, above 0 and below 180 | 36 |
//! | `size` | `[width, height]` pixels, 1 to 16384 | `[640, 360]` |
//! | `near`, `far` | metres along the view, `0 < near < far` | fitted to what is seen, so that nothing is cut |
//! | **`[[light]]`** | one or more; the first is compared | needed |
//! | `kind` | `"directional"`, `"point"`, `"spot"`, `"rect"`, `"disc"` | needed |
//! | `direction` | directional, spot: the way light travels, any length | needed |
//! | `angular_diameter_degrees` | directional: full angle of its disc in the sky, 0 to below 180; the sun's is 0.53 | 0 |
//! | `position` | point, spot: metres | needed |
//! | `inner_degrees` | spot: half angle of full light, at most the outer one | `outer_degrees` |
//! | `outer_degrees` | spot: half angle where light ends, above 0 and below 90 | needed |
//! | `radius` | point, spot, disc: metres | 0; needed for a disc, above 0 |
//! | `center` | rect, disc: metres | needed |
//! | `half_u`, `half_v` | rect: from the centre to the middles of two neighbouring sides, metres | needed |
//! | `normal` | disc: across it, any length; it shines to both sides | needed |
//! | **`[[object]]`** | one or more | needed |
//! | `mesh` | a model, relative to the scene file: an `.obj` file, or (feature `gltf`) a `.glb` or `.gltf` file, of which `model.glb#night` is one scene; see [below](#models-in-scene-files) | this or `shape` |
//! | `shape` | `"plane"` (a square in x and z that faces +y), `"box"` or `"sphere"`; all reach from -1 to 1 | this or `mesh` |
//! | `matrix` | four rows of four, world from local for column vectors; the last row is `[0, 0, 0, 1]` | identity |
//! | `scale` | one number, or `[x, y, z]`; negative ones mirror; placed objects are 1e-6 to 1e8 m across | 1 |
//! | `rotate_degrees` | `[x, y, z]`: about the x axis, then y, then z, after scaling | `[0, 0, 0]` |
//! | `translate` | `[x, y, z]` metres, after turning; at most 1e8 from the origin, or the anchor | `[0, 0, 0]` |
//! | `casts`, `receives` | whether it throws shadows, and whether they fall on it | `true` |
//! | `color` | `[r, g, b]`, linear (not sRGB), 0 to 1; multiplied with the texture | grey 0.5; white with a texture |
//! | `texture` | a `.png` file of colours in sRGB, relative to the scene file | none |
//! | `specular` | the highlight's colour: one number or `[r, g, b]`, linear, 0 to 1 | 0.15 |
//! | `shininess` | the highlight's power: a power of two, 1 to 4096 | 32 |
//! | `emissive` | `[r, g, b]`, linear: light of its own, which no shadow touches | `[0, 0, 0]` |
//! | `alpha_map` | a `.png` file that cuts holes, through which light falls and the camera sees: its alpha, or, without, its first channel | none |
//! | `alpha_cutoff` | least alpha of what is there, 0 to 1; of the nearest texel | 0.5 |
//! | `alpha_filter` | `"nearest"`, or `"hashed"`: the camera and maps take mipmapped coverages against hashed thresholds where their pixels are larger than texels. With `alpha_map` it is about that; alone, on a `mesh`, about the holes that the model brings | `"nearest"` |
//! | `normal_map` | a `.png` file of tangent-space normals, green up (OpenGL's convention) | none |
//! | `height_map` | a `.png` file of heights, 0 to 1 in its first channel, best of 16 bits; it moves the vertices | none |
//! | `displacement` | metres (before scaling) that white moves out and black in; negative turns the relief inside out | needed with `height_map` |
//! | `subdivisions` | how often each triangle is split in four before, 0 to 8: a coarse mesh can't show relief | 0 |
//!
//! Images have 8 or 16 bits a channel, and are read once each. An object with any of these looks
//! wears no other; a model without them (`alpha_filter` aside) brings its own, see below. Textures
//! repeat. What has a texture must have texture coordinates: the three shapes have, the plane and
//! each side of the box spanning one repeat, the sphere by longitude and latitude.
//!
//! # Models
//!
//! Wavefront OBJ, y up, in metres. All faces of one material become one mesh; polygons are cut into
//! triangles, concave ones too. Names, groups, lines and points are left aside. Normals and texture
//! coordinates are kept if all corners have usable ones. Loaded alone, a model is put on a floor if
//! it brings no ground of its own, framed by a camera (from inside, if it is a building around its
//! own floor), and lit by a sun.
//!
//! Of the `.mtl` files that a model names, `Kd`, `Ks`, `Ke`, `Ns` (rounded to a power of two),
//! `map_Kd`, `map_d` and, for normals, `norm` or `map_Bump` are read. Alpha below one half, of
//! `map_d` or else of `map_Kd`, cuts holes. Models often come without their looks, which no shadow
//! needs: a `.mtl` file or a texture that isn't there, one that is no PNG, and bump maps in grey
//! (heights whose scale nobody tells) are left aside. A `.png` file that can't be decoded and a
//! number that can't be read are errors.
//!
//! ## glTF
//!
//! glTF 2.0 (feature `gltf`): `.gltf` with the files that it names, and `.glb`. The default scene
//! is read, or the one that is named behind the path: `model.glb#night`, `model.glb#1` (counted
//! from 0). A file with neither a camera nor a light becomes what any model alone becomes; where
//! one of the two is there, only the other is added.
//!
//! | what | how it is read |
//! |---|---|
//! | meshes | triangles, strips and fans, with indices of 8, 16 or 32 bits or none, sparse accessors, `KHR_mesh_quantization`; each primitive becomes a mesh. Without normals, surfaces are flat. Points, lines, skins, morph targets and animations are left aside; so is draco's compression, unless the file requires it |
//! | nodes | matrices, or translation, rotation and scale, multiplied in 64 bits; mirrored ones keep their outside out. One that is scaled to zero along all axes is hidden; along one, it is an error |
//! | cameras | with and without perspective, with and without a far plane; sizes of nodes don't count. Pictures are 360 pixels high, and as wide as the aspect ratio tells (640 without one) |
//! | lights | `KHR_lights_punctual`. Masks know no brightness: intensities, colours and ranges are checked and left aside, but a light that is black or of intensity 0 is off. Cones end at 89.9 degrees at most |
//! | sizes of lights | the format has none: `shadow_soft_size` or `radius` (metres) of points and spots, `angle` (radians) of suns, in the `extras` of the light or its node. Blender writes its custom properties there; its own radius needs one |
//! | materials | base colour with its texture, normal map, colour of emission; `KHR_texture_transform`. Textures repeat. Metals, roughness and other textures are left aside; so are a normal map that lies otherwise on the mesh than the colours, and colours of vertices (`COLOR_0`) with their alpha |
//! | masks | `alphaMode` `MASK` cuts out texels below `alphaCutoff`; `BLEND` those below one half, and what is less than half there altogether throws no shadow. Holes are kept as [`Material::alpha`](umbrage_core::Material::alpha); the techniques `planar` and `volumes` refuse such casters. A texture that is nowhere below that, as JPEG is, cuts nothing out. Holes repeat: where a sampler clamps or mirrors, and a mesh would show other holes by it, that is an error |
//! | glass | `BLEND` as above. `KHR_materials_transmission` is left aside: such a surface casts as a wall does, unless its alpha says otherwise |
//! | sides | all surfaces are seen, and cast, on both sides, whatever `doubleSided` says |
//! | pictures | PNG and JPEG, embedded or beside the file, whatever their names say. One that isn't there, or of another kind, is left aside unless a mask needs it |
//!
//! Paths are relative to the file, and may lead out of its folder, as those of OBJ may; addresses
//! with a scheme (`https:`) are refused, but for `data:`. Extensions that a file requires and that
//! aren't named here are errors, but for `KHR_materials_..`, which no shadow needs. What a file
//! asks for is bounded by its length: a few kilobytes that name a gigabyte are refused.
//!
//! ## Models in scene files
//!
//! A model that a scene file names as `mesh` is one object, however many meshes it has: the
//! object's place is that of the whole model, and `casts` and `receives` hold for all of it.
//! Several objects that name one model share its meshes.
//!
//! Of a glTF file, this is all meshes of its default scene (or of the one that is named behind
//! `#`), each where its nodes put it, in the looks of its materials, with their holes; what throws
//! no shadow by its material throws none here. Its cameras and lights are left aside: they are the
//! scene file's. An object with any look of its own wears no other, glTF's masks and panes of glass
//! included; its textures then lie as `TEXCOORD_0` says. `alpha_filter` alone is no look: it is
//! about the model's own holes, of OBJ and of glTF.
//!
//! # Detailed surfaces
//!
//! [`with_tangents`] prepares a mesh for normal maps, [`fitting_normal_map`] makes the normal map
//! of a height map, and [`denoise`] smooths noisy meshes by displacement.

mod builtin;
mod catalogue;
#[cfg(test)]
mod damage;
mod detail;
mod entry;
mod error;
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
pub use files::{Files, FilesInMemory, FilesOnDisk, OpenFile};
pub use load::{brings_light, by_argument, file_of, is_model, load, parse, read};
