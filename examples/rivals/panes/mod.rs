//! Shadows of coloured panes, written like a technique of a user of the library: a map of opaque
//! casters, and a map of the panes of each material, which transmits a fraction of the light.
//!
//! A mask has one number a pixel, so a coloured shadow is three masks: of red, green and blue
//! light. All three use the same maps. The light through panes of several materials is the product
//! of their transmittances, in any order. A map only keeps the nearest pane, so that two panes of
//! one material behind each other count once.
//!
//! Renderers without such maps treat a pane as if it had holes ("screen-door" or "hashed"
//! transparency: Enderton, Sintorn, Shirley and Luebke 2010, "Stochastic transparency").
//! [`Panes::dithered`] does that, for comparison.

use serde::{Deserialize, Serialize};
use std::sync::Arc;
use umbrage::{
    Cast, CastMode, Faces, Format, Geometry, ImageDesc, Inputs, Invalid, Kernel, Light, Module,
    NO_MATERIAL, NO_TRIANGLE, ReceiveKernel, Receivers, Recipe, RecipeError, Scene,
    ShadowTechnique, Source, Span, UniformBlock, View,
    glam::{UVec2, Vec2, Vec3, Vec4},
    light_sample::{LIGHT_SAMPLE, LightSampler, ray_origin, seed, segment},
    math::dot3,
    module,
    techniques::{
        ShadowMap,
        lanes::batch::{Taps, look_up_span},
        shadow_map::{
            MapFormat, Surface, coord::ShadowCoord, layers::ShadowMapUniforms,
            texel_compare::DepthMap,
        },
    },
    uniforms,
};

pub mod scenes;

/// Greatest number of materials that transmit light.
pub const MATERIALS: usize = 3;
/// Transmittance of a material without absorption.
pub const FULLY_TRANSPARENT: Vec3 = Vec3::ONE;
/// Greatest radius of the square of comparisons.
pub const MAX_RADIUS: u32 = 8;

/// A material that transmits light.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Glass {
    /// Index into the scene's materials.
    pub material: u32,
    /// The transmitted fraction of red, green and blue light, 0 to 1 each.
    pub transmittance: Vec3,
}

/// A mask of one colour for a scene with panes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Panes {
    /// Settings of all maps, which have 32 bits and store the nearest surface.
    pub map: ShadowMap,
    /// Comparisons: texels to each side, 0 to [`MAX_RADIUS`].
    pub radius: u32,
    /// The materials that transmit light.
    pub glass: [Glass; MATERIALS],
    /// Colour of the mask: 0 for red, 1 for green, 2 for blue.
    pub colour: usize,
    /// `true` if panes have random holes in a fraction of the map's texels, instead of transmitting
    /// a fraction of the light.
    pub dithered: bool,
}

impl ShadowTechnique for Panes {
    fn name(&self) -> &'static str {
        "panes"
    }

    fn recipe(&self, view: &View<'_>) -> Result<Recipe, RecipeError> {
        self.validate()?;
        let Some(geometry) = view.geometry else {
            return Err(RecipeError::unsupported_because(
                "panes need the triangles' materials, and this view has no triangles",
            ));
        };
        let shares = self.glass.map(|glass| glass.transmittance[self.colour]);
        let kernel = |lookup| {
            PanesKernel(PanesUniforms {
                lookup,
                transmittance: Vec4::new(shares[0], shares[1], shares[2], 0.0),
                radius: self.radius as i32,
                dithered: u32::from(self.dithered),
            })
        };
        let mut recipe = self.map.recipe(view, self.radius as f32, kernel)?;
        let of_opaque = recipe.casts.clone();
        let layers = recipe.images[0].layers;
        let opaque = Arc::new(faces(geometry, |material| self.pane(material).is_none()));
        for cast in &mut recipe.casts {
            cast.source = Source::Faces(Arc::clone(&opaque));
        }
        for glass in self.glass {
            let image = recipe.images.len();
            recipe.images.push(ImageDesc {
                label: "panes of one material",
                size: UVec2::splat(self.map.size),
                layers,
                format: Format::Depth32,
            });
            recipe.receive.inputs.push(image);
            let panes = Arc::new(faces(geometry, |material| material == glass.material));
            for cast in &of_opaque {
                recipe.casts.push(Cast {
                    source: Source::Faces(Arc::clone(&panes)),
                    mode: CastMode::Depth,
                    image,
                    ..cast.clone()
                });
            }
        }
        Ok(recipe)
    }

    fn follows_camera(&self, light: &Light) -> bool {
        self.map.follows_camera(light)
    }
}

impl Panes {
    fn pane(&self, material: u32) -> Option<&Glass> {
        self.glass.iter().find(|glass| glass.material == material)
    }

    fn validate(&self) -> Result<(), Invalid> {
        let what = "panes";
        if self.radius > MAX_RADIUS || self.colour > 2 {
            let why = format!(
                "have a radius of {} and colour {}",
                self.radius, self.colour
            );
            let help = format!("use a radius up to {MAX_RADIUS}, and colours 0 to 2");
            return Err(Invalid::new(what, why, help));
        }
        let is_plain =
            self.map.format == MapFormat::Depth32 && self.map.surface == Surface::Nearest;
        if !is_plain {
            let why = "use a map that does not store the nearest depth in 32 bits";
            return Err(Invalid::new(
                what,
                why,
                "use the default format and surface",
            ));
        }
        let lowest = self.glass.map(|glass| glass.transmittance.min_element());
        let highest = self.glass.map(|glass| glass.transmittance.max_element());
        let are_shares = lowest.iter().all(|&v| v >= 0.0) && highest.iter().all(|&v| v <= 1.0);
        if !are_shares {
            let why = "have a transmittance outside 0 to 1";
            return Err(Invalid::new(what, why, "use fractions from 0 to 1"));
        }
        Ok(())
    }
}

/// Returns the casters with a wanted material.
fn faces(geometry: &Geometry, is_wanted: impl Fn(u32) -> bool) -> Faces {
    let mut faces = Faces::default();
    for triangle in geometry.casters() {
        let material = geometry.materials().get(triangle as usize);
        if !is_wanted(material.copied().unwrap_or(NO_MATERIAL)) {
            continue;
        }
        let first = faces.vertices.len() as u32;
        let corners = geometry.corners(triangle);
        faces
            .vertices
            .extend(corners.map(|corner| corner.extend(1.0)));
        faces.triangles.push([first, first + 1, first + 2]);
    }
    faces
}

uniforms! {
    /// Uniforms of [`PanesKernel`].
    pub struct PanesUniforms {
        /// The maps: their layers and comparison settings.
        pub lookup: ShadowMapUniforms,
        /// Transmittance of the panes of each material for this colour; w is unused.
        pub transmittance: Vec4,
        /// Comparisons: texels to each side.
        pub radius: i32,
        /// 1 if panes have holes, else 0.
        pub dithered: u32,
    }
}

/// The receive kernel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PanesKernel(PanesUniforms);

impl Kernel for PanesKernel {
    fn modules(&self) -> Vec<Module> {
        self.0.lookup.modules(&[LIGHT_SAMPLE, module!("panes")])
    }

    fn uniforms(&self) -> Option<&dyn UniformBlock> {
        Some(&self.0)
    }
}

impl ReceiveKernel for PanesKernel {
    fn receive(&self, inputs: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]) {
        let lookup = &self.0.lookup;
        let taps = OpaqueAndPanes {
            uniforms: &self.0,
            opaque: lookup.map(&inputs.images[0]),
            panes: [1, 2, 3].map(|image| lookup.map(&inputs.images[image])),
        };
        look_up_span(inputs.simd, lookup, span, out, &taps);
    }
}

struct OpaqueAndPanes<'a> {
    uniforms: &'a PanesUniforms,
    opaque: DepthMap<'a>,
    panes: [DepthMap<'a>; MATERIALS],
}

impl Taps for OpaqueAndPanes<'_> {
    #[inline(always)]
    fn visibility(&self, l: &ShadowCoord, _: usize) -> f32 {
        let radius = self.uniforms.radius;
        let x = l.texel.x.floor() as i32;
        let y = l.texel.y.floor() as i32;
        let mut lit = 0.0;
        for dy in -radius..=radius {
            for dx in -radius..=radius {
                let mut share = self.opaque.tap(l, x + dx, y + dy);
                for (pane, map) in self.panes.iter().enumerate() {
                    let is_before = map.tap(l, x + dx, y + dy) == 1.0;
                    share *= self.pane_transmittance(is_before, x + dx, y + dy, pane);
                }
                lit += share;
            }
        }
        let side = (2 * radius + 1) as f32;
        lit / (side * side)
    }
}

impl OpaqueAndPanes<'_> {
    /// Returns the fraction of the light that passes one material's panes to a receiver.
    #[inline(always)]
    fn pane_transmittance(&self, is_before: bool, x: i32, y: i32, pane: usize) -> f32 {
        if is_before {
            return 1.0;
        }
        let transmittance = self.uniforms.transmittance[pane];
        if self.uniforms.dithered == 0 {
            return transmittance;
        }
        // A texel has the same hole for all receivers, and another one for each material.
        let bits = seed(x as u32, (y as u32).wrapping_add(pane as u32 * 65536));
        let noise = (bits >> 8) as f32 / 16_777_216.0;
        if noise < transmittance { 1.0 } else { 0.0 }
    }
}

/// Returns the fraction of red, green and blue light that reaches each receiver from the scene's
/// first light, which has no extent, in the view of its first camera. Each ray passes through all
/// casters, and the transmittances of panes are multiplied. Surfaces that face away from the light
/// receive none; pixels without geometry are lit. Each ray tests each pane, so the method is for
/// few panes.
///
/// # Errors
/// Returns an error if the scene is not valid.
pub fn transmitted_light(
    scene: &Scene,
    receivers: &Receivers,
    glass: &[Glass; MATERIALS],
) -> Result<Vec<Vec3>, Invalid> {
    let all = Geometry::bake(scene)?;
    let is_glass = |material: u32| glass.iter().any(|glass| glass.material == material);
    let opaque = with_casters(scene, |material| !is_glass(material))?;
    let mut panes = Vec::new();
    for glass in glass {
        let geometry = with_casters(scene, |material| material == glass.material)?;
        panes.push((geometry, glass.transmittance));
    }
    let sampler = LightSampler::new(&scene.lights[0]);
    let eye = scene.cameras[0].eye();
    let plane_reach = all.receiver_reach();
    let far = 2.0 * all.bounds().diagonal();
    let mut shares = Vec::with_capacity(receivers.triangle.len());
    for (i, &triangle) in receivers.triangle.iter().enumerate() {
        if triangle == NO_TRIANGLE {
            shares.push(Vec3::ONE);
            continue;
        }
        let p = Vec3::new(receivers.x[i], receivers.y[i], receivers.z[i]);
        let n = Vec3::new(receivers.nx[i], receivers.ny[i], receivers.nz[i]);
        // Start in front of the surface, so that a ray away from it doesn't hit it.
        let start = ray_origin(p, n, eye, plane_reach);
        // A light without extent has one point for every sample.
        let ray = segment(&sampler, start, Vec2::ZERO, far);
        if dot3(n, ray) <= 0.0 || opaque.bvh().is_occluded(start, ray, NO_TRIANGLE) {
            shares.push(Vec3::ZERO);
            continue;
        }
        let mut share = Vec3::ONE;
        for (geometry, transmittance) in &panes {
            let bvh = geometry.bvh();
            for pane in 0..geometry.casters().len() as u32 {
                if bvh.hits(pane, start, ray, NO_TRIANGLE) {
                    share *= *transmittance;
                }
            }
        }
        shares.push(share);
    }
    Ok(shares)
}

/// Returns the scene with only those casters that have a wanted material.
fn with_casters(scene: &Scene, is_wanted: impl Fn(u32) -> bool) -> Result<Geometry, Invalid> {
    let mut scene = scene.clone();
    for instance in &mut scene.instances {
        let material = instance.material.map_or(NO_MATERIAL, |index| index as u32);
        instance.casts &= is_wanted(material);
    }
    Geometry::bake(&scene)
}
