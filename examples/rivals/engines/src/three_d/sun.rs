//! A sun for three-d with umbrage's shadow.
//!
//! three-d requests shader text from each light ([`Light`] is a public trait), so a light may apply
//! any factor, here a mask of the image's size. three-d draws with OpenGL and umbrage with wgpu, so
//! they can't share a buffer. Umbrage's CPU backend computes the mask, including the visible
//! surface of each pixel, and the mask is uploaded as a texture.

use anyhow::Result;
use std::sync::Arc;
use three_d::{Context, Interpolation, Light, LightId, Program, Texture2D, Vec3, Wrapping};
use umbrage::{Backend as _, ShadowTechnique, View, cpu::Cpu};

/// Id of the light. three-d's own ids are 0x80 and above.
const ID: LightId = LightId(0x01);

/// A sun with a mask of the image.
pub struct UmbrageSun {
    technique: Arc<dyn ShadowTechnique>,
    cpu: Cpu,
    /// Linear colour.
    color: Vec3,
    /// Direction of its light, a unit vector.
    direction: Vec3,
    mask: Texture2D,
    bytes: u64,
}

impl UmbrageSun {
    /// Returns a sun for images of `size` pixels. Everything is lit before the first
    /// [`UmbrageSun::update`].
    pub fn new(
        context: &Context,
        technique: Arc<dyn ShadowTechnique>,
        color: Vec3,
        direction: Vec3,
        size: [u32; 2],
    ) -> Self {
        let mask = Texture2D::new_empty::<f32>(
            context,
            size[0],
            size[1],
            Interpolation::Nearest,
            Interpolation::Nearest,
            None,
            Wrapping::ClampToEdge,
            Wrapping::ClampToEdge,
        );
        mask.fill(&vec![1.0_f32; size[0] as usize * size[1] as usize]);
        Self {
            technique,
            cpu: Cpu::new(),
            color,
            direction,
            mask,
            bytes: 0,
        }
    }

    /// Computes the mask of a view with the size of [`UmbrageSun::new`], and uploads it.
    ///
    /// # Errors
    /// Returns an error if the technique does not support the view.
    pub fn update(&mut self, view: &View<'_>) -> Result<()> {
        let recipe = self.technique.recipe(view)?;
        let shadows = self.cpu.render(view, &recipe)?;
        // Both three-d and masks have rows from the top.
        self.mask.fill(&shadows.mask);
        // The mask is in main memory and in a texture.
        self.bytes = shadows.bytes + 2 * 4 * shadows.mask.len() as u64;
        Ok(())
    }

    /// Returns the bytes of maps, of visible surfaces, and of the mask.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }
}

impl Light for UmbrageSun {
    fn shader_source(&self, i: u32) -> String {
        // `calculate_light` is three-d's, called like that of its own sun. Row 0 of OpenGL's images
        // and textures is at the bottom.
        format!(
            "
            uniform vec3 color{i};
            uniform vec3 direction{i};
            uniform sampler2D mask{i};

            vec3 calculate_lighting{i}(vec3 surface_color, vec3 position, vec3 normal, vec3 view_direction, float metallic, float roughness, float occlusion)
            {{
                vec3 lit = calculate_light(color{i}, -direction{i}, surface_color, view_direction, normal, metallic, roughness);
                return lit * texelFetch(mask{i}, ivec2(gl_FragCoord.xy), 0).x;
            }}
            "
        )
    }

    fn use_uniforms(&self, program: &Program, i: u32) {
        program.use_uniform(&format!("color{i}"), self.color);
        program.use_uniform(&format!("direction{i}"), self.direction);
        program.use_texture(&format!("mask{i}"), &self.mask);
    }

    fn id(&self) -> LightId {
        ID
    }
}
