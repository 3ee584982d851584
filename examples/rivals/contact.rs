//! Contact shadows, written like a technique of a user of the library. The camera's depth image
//! supplies the last centimetres between a receiver and its blocker, and the result is multiplied
//! with that of a shadow map.
//!
//! After Aldridge 2023, "Inside Bend: Screen space shadows" (Bend Studio, of the game Days Gone):
//! from the receiver's pixel, walk pixel by pixel towards the light's position on the image, and
//! compare the depth of the ray with the depth of the image. Visible surfaces count as solids of a
//! certain thickness, a fraction of their distance from the camera. Each of the nearest pixels can
//! block by itself; farther ones are combined into four groups of a quarter each, and the last ones
//! fade out. The two depths next to the ray are blended if they belong to one surface. Bend's
//! implementation shares loaded depths between the receivers of a ray, in a compute pass whose
//! groups follow rays. A receive kernel processes one receiver, so this one loads them repeatedly.
//!
//! It has no data about geometry outside the image or behind other geometry, or about thicknesses.
//! Area lights count as their centre.

use serde::{Deserialize, Serialize};
use umbrage::{
    Cast, CastMode, Fit, Format, ImageDesc, ImageView, Inputs, Invalid, Kernel, Light, Module,
    ReceiveKernel, Recipe, RecipeError, ShadowTechnique, Source, Span, UniformBlock, View,
    glam::{UVec2, Vec3, Vec4},
    module,
    techniques::{
        ListedTechnique, ShadowMap,
        lanes::batch::{Taps, look_up_span},
        shadow_map::{coord::ShadowCoord, layers::ShadowMapUniforms, texel_compare::DepthMap},
    },
    uniforms,
};
use umbrage_plan::catalogue::{CataloguedKernel, CataloguedTechnique, KernelCost, kernel};

/// Greatest length of a walk, pixels.
pub const MAX_PIXELS: u32 = 512;
/// Greatest radius of the square of comparisons with the map.
pub const MAX_RADIUS: u32 = 8;
/// Number of the nearest pixels that can block by themselves. Aldridge's value.
const PIXELS_ALONE: i32 = 4;
/// Number of the last pixels over which the result fades out. Aldridge's value.
const PIXELS_FADING: i32 = 8;
/// Greatest difference of two neighbouring depths of one surface, as a fraction of the distance.
/// Aldridge's value.
const SAME_SURFACE: f32 = 0.02;
/// Least distance of a blocker in front of the ray, as a fraction of the thickness. It exceeds the
/// effect of rounding in the depth image on a lit surface.
const LEAST_DEPTH: f32 = 1.0 / 32.0;

/// A shadow map, and a walk over the camera's depth image.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ContactShadows {
    /// Settings of the map.
    pub map: ShadowMap,
    /// Comparisons with the map: texels to each side, 0 to [`MAX_RADIUS`].
    pub radius: u32,
    /// Length of the walk, 0 to [`MAX_PIXELS`].
    pub pixels: u32,
    /// Thickness of visible surfaces, as a fraction of their distance from the camera.
    pub thickness: f32,
}

impl Default for ContactShadows {
    fn default() -> Self {
        Self {
            map: ShadowMap::default(),
            radius: 1,
            pixels: 60,
            thickness: 0.005,
        }
    }
}

/// Makes the technique available in `compare`, `stability`, `plan` and presets, like those of the
/// library.
impl ListedTechnique for ContactShadows {
    const SUMMARY: &'static str = "a map, and a walk over the camera's depth image (Aldridge 2023)";

    fn settings(&self) -> String {
        let side = 2 * u64::from(self.radius) + 1;
        let walk = format!("{} pixels", self.pixels);
        format!("{walk}, {side}x{side}, {}", self.map.label())
    }

    fn map(&self) -> Option<&ShadowMap> {
        Some(&self.map)
    }

    fn with_map(self, map: ShadowMap) -> Self {
        Self { map, ..self }
    }
}

impl CataloguedTechnique for ContactShadows {
    fn kernel(kernel: &dyn ReceiveKernel) -> Option<&dyn CataloguedKernel> {
        kernel::downcast::<ContactKernel>(kernel)
    }

    fn kernel_reach(&self) -> Option<f32> {
        Some(self.radius as f32)
    }

    /// Returns each map without the walk, with a walk of Aldridge's length, and with a long one.
    fn compared_settings(map_sizes: &[u32], fit: Fit) -> Vec<Self> {
        let mut all = Vec::new();
        for &size in map_sizes {
            let map = ShadowMap {
                size,
                fit,
                ..ShadowMap::default()
            };
            for radius in [0, 1] {
                for pixels in [0, 60, 240] {
                    all.push(Self {
                        map,
                        radius,
                        pixels,
                        ..Self::default()
                    });
                }
            }
        }
        all
    }
}

impl ShadowTechnique for ContactShadows {
    fn name(&self) -> &'static str {
        "contact"
    }

    fn recipe(&self, view: &View<'_>) -> Result<Recipe, RecipeError> {
        self.validate()?;
        let space = view.camera.space();
        let clip_from_world = space.clip_from_world();
        // Without perspective, clip depth is not proportional to the distance from the camera.
        if space.clip_from_view.row(3) == Vec4::W {
            return Err(RecipeError::unsupported_because(
                "contact shadows need a perspective camera: thickness is a fraction of the distance from the camera",
            ));
        }
        let light = homogeneous(view.light);
        let size = view.camera.size;
        let walk = |lookup| ContactUniforms {
            lookup,
            x_from_world: clip_from_world.row(0),
            y_from_world: clip_from_world.row(1),
            z_from_world: clip_from_world.row(2),
            w_from_world: clip_from_world.row(3),
            light_on_image: clip_from_world * light,
            image_size: size,
            radius: self.radius as i32,
            pixels: self.pixels as i32,
            thickness: self.thickness,
        };
        let kernel = |lookup| ContactKernel(walk(lookup));
        let mut recipe = self.map.recipe(view, self.radius as f32, kernel)?;
        let seen_depth = recipe.images.len();
        recipe.images.push(ImageDesc {
            label: "seen depth",
            size,
            layers: 1,
            format: Format::Depth32,
        });
        recipe.casts.push(Cast {
            source: Source::Everything,
            mode: CastMode::Depth,
            ..Cast::nearest(seen_depth, 0, space)
        });
        recipe.receive.inputs.push(seen_depth);
        Ok(recipe)
    }

    fn follows_camera(&self, _: &Light) -> bool {
        true
    }
}

impl ContactShadows {
    fn validate(&self) -> Result<(), Invalid> {
        let what = "contact shadows";
        if self.pixels > MAX_PIXELS || self.radius > MAX_RADIUS {
            let why = format!(
                "walk {} pixels, with a radius of {}",
                self.pixels, self.radius
            );
            let help = format!("use up to {MAX_PIXELS} pixels and a radius up to {MAX_RADIUS}");
            return Err(Invalid::new(what, why, help));
        }
        if !(self.thickness > 0.0 && self.thickness < 1.0) {
            let why = format!("have a thickness of {}", self.thickness);
            return Err(Invalid::new(
                what,
                why,
                "use a fraction of the distance, such as 0.005",
            ));
        }
        Ok(())
    }
}

/// Returns the light's centre: (position, 1), or for a directional light (unit direction to it, 0).
fn homogeneous(light: &Light) -> Vec4 {
    match light.position() {
        Some(position) => position.extend(1.0),
        None => light.direction_from(Vec3::ZERO).extend(0.0),
    }
}

uniforms! {
    /// Uniforms of [`ContactKernel`].
    pub struct ContactUniforms {
        /// The map: its layers and comparison settings.
        pub lookup: ShadowMapUniforms,
        /// Row of the camera's clip-from-world matrix for clip x.
        pub x_from_world: Vec4,
        /// Row for clip y.
        pub y_from_world: Vec4,
        /// Row for clip z.
        pub z_from_world: Vec4,
        /// Row for clip w.
        pub w_from_world: Vec4,
        /// The light's centre in the camera's clip space.
        pub light_on_image: Vec4,
        /// Size of the camera's image, pixels.
        pub image_size: UVec2,
        /// Comparisons with the map: texels to each side.
        pub radius: i32,
        /// Length of the walk, pixels.
        pub pixels: i32,
        /// Thickness of visible surfaces, as a fraction of their distance.
        pub thickness: f32,
    }
}

/// The receive kernel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactKernel(ContactUniforms);

impl Kernel for ContactKernel {
    fn modules(&self) -> Vec<Module> {
        self.0.lookup.modules(&[module!("contact")])
    }

    fn uniforms(&self) -> Option<&dyn UniformBlock> {
        Some(&self.0)
    }
}

impl ReceiveKernel for ContactKernel {
    fn receive(&self, inputs: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]) {
        let taps = MapAndWalk {
            uniforms: &self.0,
            map: self.0.lookup.map(&inputs.images[0]),
            seen_depth: inputs.images[1],
            span,
        };
        look_up_span(inputs.simd, &self.0.lookup, span, out, &taps);
    }
}

impl CataloguedKernel for ContactKernel {
    /// Returns the cost. A pixel of the walk takes two loads.
    fn cost_per_receiver(&self) -> KernelCost {
        let side = 2 * self.0.radius.unsigned_abs() + 1;
        KernelCost::taps(side * side + 2 * self.0.pixels.unsigned_abs())
    }

    fn layer(&self, position: Vec3) -> Option<u32> {
        Some(self.0.lookup.layer_of(position))
    }
}

struct MapAndWalk<'a> {
    uniforms: &'a ContactUniforms,
    map: DepthMap<'a>,
    seen_depth: ImageView<'a>,
    span: &'a Span<'a>,
}

impl Taps for MapAndWalk<'_> {
    #[inline(always)]
    fn visibility(&self, l: &ShadowCoord, offset: usize) -> f32 {
        let by_map = self.by_map(l);
        if by_map == 0.0 {
            return 0.0;
        }
        let pixel = self.span.first + UVec2::new(offset as u32, 0);
        by_map * self.by_walk(self.span.position(offset), pixel)
    }
}

/// The path of a ray towards the light on the camera's image, in steps of a pixel.
struct ContactWalk {
    /// Step: 1 or -1 along x or y, and at most as much along the other axis.
    step: [f32; 2],
    /// Depth at the receiver.
    start_depth: f32,
    /// Change of the ray's depth a step.
    depth_step: f32,
    /// Number of steps before the light.
    steps: i32,
}

/// Returns a row of a matrix times (p, 1).
#[inline(always)]
fn row_times_point(row: Vec4, p: Vec3) -> f32 {
    row.x * p.x + row.y * p.y + row.z * p.z + row.w
}

impl MapAndWalk<'_> {
    /// Returns the mean of the comparisons with the map.
    #[inline(always)]
    fn by_map(&self, l: &ShadowCoord) -> f32 {
        let radius = self.uniforms.radius;
        let x = l.texel.x.floor() as i32;
        let y = l.texel.y.floor() as i32;
        let mut lit = 0.0;
        for dy in -radius..=radius {
            for dx in -radius..=radius {
                lit += self.map.tap(l, x + dx, y + dy);
            }
        }
        let side = (2 * radius + 1) as f32;
        lit / (side * side)
    }

    /// Returns the path of the ray from `p` to the light. `None` if it does not extend over the
    /// image.
    #[inline(always)]
    fn walk(&self, p: Vec3) -> Option<ContactWalk> {
        let u = self.uniforms;
        let x = row_times_point(u.x_from_world, p);
        let y = row_times_point(u.y_from_world, p);
        let z = row_times_point(u.z_from_world, p);
        let w = row_times_point(u.w_from_world, p);
        let light = u.light_on_image;
        // Points of the ray are p + s light in clip space, with s from 0 on. The following
        // derivatives at s = 0 are those of x / w, y / w and z / w, each times w². The ray and its
        // depth are linear on the image.
        let right = (light.x * w - x * light.w) * (0.5 * u.image_size.x as f32);
        let down = (y * light.w - light.y * w) * (0.5 * u.image_size.y as f32);
        let deeper = light.z * w - z * light.w;
        let longer = right.abs().max(down.abs());
        if longer <= 0.0 {
            return None;
        }
        let mut steps = u.pixels;
        if light.w > 0.0 {
            // If the light's position is ahead on the image, its distance from (x, y) / w is the
            // derivative times w / light.w.
            let pixels_to_light = longer / (w * light.w);
            steps = steps.min(pixels_to_light.min(MAX_PIXELS as f32) as i32);
        }
        Some(ContactWalk {
            step: [right / longer, down / longer],
            start_depth: z / w,
            depth_step: deeper / longer,
            steps,
        })
    }

    /// Returns the depth of the image at a position. `None` outside. `along_x` selects the
    /// coordinate that is at a pixel's centre.
    #[inline(always)]
    fn seen_depth(&self, x: f32, y: f32, along_x: bool) -> Option<f32> {
        let size = self.uniforms.image_size.as_ivec2();
        let column = x.floor() as i32;
        let row = y.floor() as i32;
        if column < 0 || row < 0 || column >= size.x || row >= size.y {
            return None;
        }
        let near = self.seen_depth.load(column, row, 0);
        // Find the other of the two pixels whose centres enclose the position.
        let across = if along_x {
            y - row as f32 - 0.5
        } else {
            x - column as f32 - 0.5
        };
        let side = if across < 0.0 { -1 } else { 1 };
        let other_column = if along_x { column } else { column + side };
        let other_row = if along_x { row + side } else { row };
        let other_column = other_column.clamp(0, size.x - 1);
        let other_row = other_row.clamp(0, size.y - 1);
        let other = self.seen_depth.load(other_column, other_row, 0);
        let is_same_surface = (other - near).abs() < SAME_SURFACE * (1.0 - near);
        let share = across.abs();
        Some(if is_same_surface {
            near * (1.0 - share) + other * share
        } else {
            near
        })
    }

    /// Returns the visibility according to the camera's depth image.
    #[inline(always)]
    fn by_walk(&self, p: Vec3, pixel: UVec2) -> f32 {
        let Some(walk) = self.walk(p) else {
            return 1.0;
        };
        let along_x = walk.step[0].abs() >= 1.0;
        let mut alone = 1.0_f32;
        let mut groups = [1.0_f32; 4];
        for i in 1..=walk.steps {
            let steps = i as f32;
            let x = pixel.x as f32 + 0.5 + walk.step[0] * steps;
            let y = pixel.y as f32 + 0.5 + walk.step[1] * steps;
            let Some(seen) = self.seen_depth(x, y, along_x) else {
                break;
            };
            let ray = walk.start_depth + walk.depth_step * steps;
            // 1 - depth is proportional to 1 / distance, so this is a fraction of the distance.
            let before = (ray - seen) / ((1.0 - seen) * self.uniforms.thickness);
            if !(before > LEAST_DEPTH && before < 1.0) {
                continue;
            }
            if i <= PIXELS_ALONE {
                alone = 0.0;
                break;
            }
            let fading = (i - (self.uniforms.pixels - PIXELS_FADING)).max(0);
            let lit = fading as f32 / (PIXELS_FADING + 1) as f32;
            let group = (i & 3) as usize;
            groups[group] = groups[group].min(lit);
        }
        alone * (0.25 * (groups[0] + groups[1] + groups[2] + groups[3]))
    }
}
